//! Pictures of a mold: closed and cut open, and taken apart.

use std::path::Path;

use mesh::io::IoError;
use mesh::io::vtu::{CellType, Field, Grid, write_vtu};
use mesh::{SurfaceMesh, Vec3, topology};
use render::annotate::Key;
use render::camera::Projection;
use render::color::{self, Rgb};
use render::cut::{Plane, cut};
use render::panel::Look;
use render::raster::Lines;
use render::shape::{Shape, Triangle, shade};
use render::sheet::{Panel, Sheet, draw_sheet, floor};
use render::view::View;

use crate::files::assembly::Member;

/// Width and height of a picture [px].
const SIZE: [usize; 2] = [1080, 756];

/// From where molds are seen, so that the cut through a closed one faces the camera.
const VIEW: View = View { azimuth: -58.0, elevation: 24.0 };

/// Colour of the cast: silicone without pigment, unlike any part.
const CAST: u32 = 0x00f3_ead6;

/// Draws the closed mold, cut open by the upright plane through `centre` that lies along
/// `along`, a point and a direction in the mold [mm].
pub fn assembled(
    path: &Path,
    title: &str,
    members: &[Member],
    centre: &Vec3,
    along: &Vec3,
) -> Result<(), IoError> {
    let normal = along.cross(&Vec3::z()).normalize();
    // Towards the camera: what lies before the plane goes.
    let normal = normal * normal.dot(&VIEW.frame()[2]).signum();
    let plane = Plane { normal, offset: normal.dot(centre) };
    draw(path, title, members, Some(plane), |_| Vec3::zeros())
}

/// Draws the parts and the cast taken apart.
pub fn exploded(path: &Path, title: &str, members: &[Member]) -> Result<(), IoError> {
    draw(path, title, members, None, |member| member.apart)
}

fn draw(
    path: &Path,
    title: &str,
    members: &[Member],
    plane: Option<Plane>,
    shift: impl Fn(&Member) -> Vec3,
) -> Result<(), IoError> {
    let colors: Vec<Rgb> = members.iter().enumerate().map(|(i, m)| paint(i, m)).collect();
    let pieces = members
        .iter()
        .zip(&colors)
        .map(|(member, color)| {
            let mut shape = shape(&member.surface, |_| f64::NAN, *color);
            shape.translate(&shift(member));
            cut(&shape, plane)
        })
        .collect();
    let panels = [Panel { pieces, caption: String::new(), labels: Vec::new() }];
    let names = members.iter().map(|m| m.name.clone()).zip(colors).collect();
    let sheet = Sheet {
        size: SIZE,
        title: title.into(),
        view: VIEW,
        projection: Projection::Perspective,
        look: Look {
            scale: None,
            lines: Lines { edges: false, features: true },
            ground: floor(&panels),
        },
        key: Key::Names(names),
        shown: None,
    };
    draw_sheet(&sheet, &panels).write_png(path)
}

fn paint(i: usize, member: &Member) -> Rgb {
    if member.printed { color::palette(i) } else { color::from_hex(CAST) }
}

/// A surface in a colour, with a value at each triangle, or NaN.
pub fn shape(surface: &SurfaceMesh, value: impl Fn(usize) -> f64, color: Rgb) -> Shape {
    let triangle = |(t, &points): (usize, &[usize; 3])| Triangle {
        points,
        values: [value(t); 3],
        color,
        edges: 0,
    };
    let triangles: Vec<Triangle> = surface.triangles.iter().enumerate().map(triangle).collect();
    Shape {
        facets: shade(&surface.vertices, &triangles),
        cells: None,
        closed: topology::boundary_edges(&surface.triangles).is_empty(),
    }
}

/// Writes all members as one grid for ParaView: the number of the member in the cell
/// field `part`, and the point field `apart` [mm], by which its filter Warp By Vector
/// takes the mold apart.
pub fn grid(path: &Path, members: &[Member]) -> Result<(), IoError> {
    let field = |name: &str, unit: &str, components, values| Field {
        name: name.into(),
        unit: unit.into(),
        components,
        values,
    };
    let (mut points, mut cells) = (Vec::new(), Vec::new());
    let (mut part, mut apart) = (Vec::new(), Vec::new());
    for (i, member) in members.iter().enumerate() {
        let first = points.len();
        points.extend_from_slice(&member.surface.vertices);
        apart.extend(member.surface.vertices.iter().flat_map(|_| member.apart.iter().copied()));
        cells.extend(member.surface.triangles.iter().flatten().map(|v| first + v));
        part.extend(member.surface.triangles.iter().map(|_| i as f64));
    }
    let grid = Grid {
        points,
        cells,
        cell_type: CellType::Tri3,
        point_fields: vec![field("apart", "mm", 3, apart)],
        cell_fields: vec![field("part", "", 1, part)],
    };
    write_vtu(path, &grid)
}
