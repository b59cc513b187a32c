//! A picture of the thin places of a body: the whole, and cut through the thinnest.

use std::path::Path;

use anyhow::Result;
use mesh::measure::diagonal;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};
use render::annotate::Key;
use render::camera::Projection;
use render::color::{self, Rgb};
use render::cut::{Plane, cut};
use render::panel::Look;
use render::raster::Lines;
use render::shape::{Shape, Triangle, shade};
use render::sheet::{Panel, Sheet, draw_sheet};
use render::view::View;

use super::skin::{Kind, Thin};

/// Width and height [px].
const SIZE: [usize; 2] = [1600, 800];

/// Radius of the balls at thin places [diagonal].
const BALL: f64 = 0.008;

/// Draws a body with a ball at each of its thin places.
pub fn draw_thin(surface: &SurfaceMesh, thin: &[Thin], path: &Path) -> Result<()> {
    let view = View { azimuth: -50.0, elevation: 28.0 };
    let body = shape(surface, color::material());
    let radius = BALL * diagonal(&surface.vertices);
    let ball = |place: &Thin| {
        shape(&Solid::sphere(&Vec3::from(place.at), radius, 16).to_surface(), paint(place.kind))
    };
    let balls: Vec<Shape> = thin.iter().map(ball).collect();
    let normal = view.frame()[2];
    let through =
        thin.first().map(|place| Plane { normal, offset: normal.dot(&Vec3::from(place.at)) });
    let panel = |plane, caption: &str| {
        let mut pieces = vec![cut(&body, plane)];
        pieces.extend(balls.iter().map(|ball| cut(ball, None)));
        Panel { pieces, caption: caption.into(), labels: Vec::new() }
    };
    let sheet = Sheet {
        size: SIZE,
        title: "thinner than the finest cell".into(),
        view,
        projection: Projection::Orthographic,
        look: Look { scale: None, lines: Lines { edges: false, features: true }, ground: None },
        key: Key::Names([Kind::Wall, Kind::Gap].map(|k| (name(k).into(), paint(k))).into()),
        shown: None,
    };
    let panels = [panel(None, "the body"), panel(through, "cut through the thinnest place")];
    draw_sheet(&sheet, &panels).write_png(path)?;
    Ok(())
}

fn name(kind: Kind) -> &'static str {
    match kind {
        Kind::Wall => "wall",
        Kind::Gap => "gap",
    }
}

fn paint(kind: Kind) -> Rgb {
    color::palette(match kind {
        Kind::Wall => 3,
        Kind::Gap => 0,
    })
}

fn shape(surface: &SurfaceMesh, color: Rgb) -> Shape {
    let triangle = |&points| Triangle { points, values: [f64::NAN; 3], color, edges: 0 };
    let triangles: Vec<Triangle> = surface.triangles.iter().map(triangle).collect();
    Shape { facets: shade(&surface.vertices, &triangles), cells: None, closed: true }
}
