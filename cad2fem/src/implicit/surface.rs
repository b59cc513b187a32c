//! The closed surface of a model.

use std::collections::BTreeSet;

use anyhow::{Result, ensure};
use mesh::check::{Finding, check_surface};
use mesh::measure::diagonal;
use mesh::rounding::Rounded;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};
use program::Unusable;

use super::model::{Bounds, Cut, Model};
use super::resolution::{left_out, remark_on_chords, remark_on_walls, resolved};
use super::{Field, Fields};
use crate::report::findings;

/// Parts of `simplify` that are tried in turn, until the surface is sound.
const SIMPLIFY: [f64; 4] = [1.0, 0.3, 0.1, 0.0];

/// Parts of `grid` that are tried in turn: another lattice meets a surface elsewhere.
const GRID: [f64; 3] = [1.0, 0.87, 0.73];

/// How far beside a cut a vertex is put onto it [grid].
const BESIDE: f64 = 1e-4;

/// How often vertices are put onto the planes of their cuts in turn.
const TURNS: usize = 20;

/// The thickest needle that is taken out where triangles cross [diagonal]: 32 bits resolve 6e-8 of
/// a coordinate.
const NEEDLE: f64 = 1e-6;

/// What a triangle of the surface is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The outside of the solid.
    Outside,
    /// The wall of a cavity.
    Cavity,
    /// The face of a cut, by its index.
    Cut(usize),
}

/// The closed surface of a body, as binary STL keeps it.
pub struct Skin {
    /// The surface [m].
    pub surface: SurfaceMesh,
    /// What each triangle is a part of.
    pub part: Vec<Part>,
}

/// The closed surface of a model. Where its lattice or its simplification leaves crossing
/// triangles, others are tried, which is logged, as is a wall thinner than the grid.
///
/// # Errors
/// If nothing is left of the body, if it falls into pieces, or if no lattice makes it sound
/// ([`Unusable`]).
pub fn surface(model: &Model, fields: &Fields) -> Result<Skin> {
    let grid = resolved(model)?;
    let mut found = Vec::new();
    for finer in GRID {
        let body = Body::new(model, fields, grid * finer)?;
        match body.skin() {
            Ok(skin) => {
                remark_on_walls(model, fields, &skin, grid * finer);
                remark_on_chords(model, &body.left_out, grid * finer);
                return Ok(skin);
            }
            Err(findings) => found = findings,
        }
        log::info!("a lattice of {:.4} leaves crossing triangles: trying another", grid * finer);
    }
    Err(Unusable(format!(
        "no lattice from {grid:.4} to {:.4} makes a sound surface; surfaces that only just touch \
         each other or a cut cannot be resolved: move one of them by a tenth of `grid`, or choose \
         another `grid`:{}",
        grid * GRID[GRID.len() - 1],
        findings(&found)
    ))
    .into())
}

/// A body whose triangles are labelled with their parts [unit].
struct Body {
    solid: Solid,
    cuts: Cuts,
    /// What the lattice leaves out of the solid and of the cavity, see [`left_out`].
    left_out: Vec<(&'static str, f64)>,
    /// How far simplification may move the surface [unit].
    simplify: f64,
    /// Length of a unit [m].
    metres: f64,
}

impl Body {
    fn new(model: &Model, fields: &Fields, grid: f64) -> Result<Self> {
        let mut solid = level_set(model, &fields.solid, model.bounds(), grid)?;
        let mut beside = vec![("solid", left_out(&solid, &fields.solid))];
        let mut cavity = None;
        if let Some(within) = model.cavity_bounds() {
            let hollow = level_set(model, &fields.cavity, within, grid)?;
            beside.push(("cavity", left_out(&hollow, &fields.cavity)));
            cavity = hollow.id();
            solid = solid.difference(&hollow);
        }
        for cut in &model.cut {
            solid = solid.trim_by_plane(&-Vec3::from(cut.normal), -cut.offset);
        }
        require_one_piece(&solid)?;
        let (mut surface, origins) = solid.to_surface_with_origin();
        let cuts = Cuts::new(model);
        surface.vertices.iter_mut().for_each(|v| *v = cuts.place(*v));
        let part = |t: usize| match cuts.cut_of(&surface.corners(t)) {
            Some(cut) => Part::Cut(cut),
            None if Some(origins[t].solid) == cavity => Part::Cavity,
            None => Part::Outside,
        };
        let labels: Vec<u32> = (0..surface.triangles.len()).map(|t| part(t).label()).collect();
        let solid = Solid::from_labelled_surface(&surface, &labels)?;
        // What is thin enough for a finer grid must not be simplified away.
        let simplify = model.simplify * (grid / model.grid);
        Ok(Self { solid, cuts, left_out: beside, simplify, metres: model.unit.metres() })
    }

    /// The surface, simplified as far as it stays sound, or what is wrong with it.
    fn skin(&self) -> Result<Skin, Vec<Finding>> {
        let mut found = Vec::new();
        for part in SIMPLIFY {
            let tolerance = part * self.simplify;
            let skin = match tolerance {
                0.0 => self.rounded(&self.solid),
                _ => self.rounded(&self.solid.simplify(tolerance)),
            };
            found = check_surface(&skin.surface);
            if found.is_empty() {
                return Ok(skin);
            }
            log::debug!("simplified by {tolerance:.4} it is not sound:{}", findings(&found));
        }
        Err(found)
    }

    /// The surface of the solid or of what simplification made of it, in metres and rounded.
    fn rounded(&self, solid: &Solid) -> Skin {
        let (mut surface, origins) = solid.to_surface_with_origin();
        let part: Vec<Part> = origins.iter().map(|o| Part::of_label(o.face)).collect();
        self.cuts.flatten(&mut surface, &part);
        surface.vertices.iter_mut().for_each(|v| *v *= self.metres);
        let rounded = Rounded::new(&surface, NEEDLE * diagonal(&surface.vertices));
        let part = rounded.source.iter().map(|&t| part[t]).collect();
        Skin { surface: rounded.surface, part }
    }
}

impl Part {
    fn label(self) -> u32 {
        match self {
            Self::Outside => 0,
            Self::Cavity => 1,
            Self::Cut(cut) => 2 + cut as u32,
        }
    }

    fn of_label(label: u32) -> Self {
        match label {
            0 => Self::Outside,
            1 => Self::Cavity,
            cut => Self::Cut(cut as usize - 2),
        }
    }
}

/// The set where a field is negative, with vertices on the cuts that they only just miss.
fn level_set(model: &Model, field: &Field, within: Bounds, grid: f64) -> Result<Solid> {
    let onto = Cuts::new(model);
    Ok(Solid::level_set(|p| field.at(&p), within, grid)?.warp(|p| onto.place(p)))
}

/// The planes of the cuts. Vertices that lie hardly beside one are moved onto it: a face that lies in
/// the plane would be cut into needles, and rounding puts those of the cut itself beside it.
struct Cuts {
    /// Unit normal and offset of each cut [unit].
    planes: Vec<(Vec3, f64)>,
    /// [unit]
    tolerance: f64,
}

impl Cuts {
    fn new(model: &Model) -> Self {
        let plane = |c: &Cut| (Vec3::from(c.normal).normalize(), c.offset);
        Self { planes: model.cut.iter().map(plane).collect(), tolerance: BESIDE * model.grid }
    }

    fn place(&self, mut p: Vec3) -> Vec3 {
        for (normal, offset) in &self.planes {
            let beside = normal.dot(&p) - offset;
            if beside.abs() <= self.tolerance {
                p -= normal * beside;
            }
        }
        p
    }

    /// Puts the faces of cuts back into their planes, from which simplification may have moved them.
    fn flatten(&self, surface: &mut SurfaceMesh, part: &[Part]) {
        let faces = surface.triangles.iter().zip(part);
        let on_cuts: BTreeSet<(usize, usize)> = faces
            .filter_map(|(triangle, part)| match part {
                Part::Cut(cut) => Some(triangle.map(|v| (v, *cut))),
                _ => None,
            })
            .flatten()
            .collect();
        // Vertices on one cut are there after one turn; on several, oblique ones, they converge.
        for _ in 0..TURNS {
            for &(v, cut) in &on_cuts {
                let (normal, offset) = self.planes[cut];
                let beside = normal.dot(&surface.vertices[v]) - offset;
                surface.vertices[v] -= normal * beside;
            }
        }
    }

    /// The cut in whose plane all corners lie.
    fn cut_of(&self, corners: &[Vec3; 3]) -> Option<usize> {
        self.planes.iter().position(|(normal, offset)| {
            corners.iter().all(|p| (normal.dot(p) - offset).abs() <= self.tolerance)
        })
    }
}

/// Refuses a body of no or of several pieces, and says where they are.
fn require_one_piece(solid: &Solid) -> Result<()> {
    ensure!(!solid.is_empty(), "nothing is left of the body: do its primitives lie behind a cut?");
    let pieces = solid.decompose();
    let place = |piece: &Solid| {
        let (min, max) = piece.bounds();
        let at = (min + max) / 2.0;
        format!("{:.4e} around ({:.4}, {:.4}, {:.4})", piece.volume(), at.x, at.y, at.z)
    };
    ensure!(
        pieces.len() == 1,
        "the body falls into {} pieces, of the volumes {}{}; it must be one: join its primitives, or \
         leave out what is cut off",
        pieces.len(),
        pieces.iter().take(3).map(place).collect::<Vec<_>>().join(", "),
        if pieces.len() > 3 { ", …" } else { "" }
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{Fields, assign};
    use super::*;
    use mesh::measure::{area, enclosed_volume, triangle_area};
    use mesh::walls;

    fn made(text: &str) -> anyhow::Result<Skin> {
        let model = toml::from_str::<Model>(text).unwrap();
        surface(&model, &Fields::new(&model, false))
    }

    /// Area of what is `part` [mm²].
    fn area_of(skin: &Skin, part: Part) -> f64 {
        let of_part = skin.surface.triangles.iter().zip(&skin.part).filter(|t| *t.1 == part);
        let triangles = of_part.map(|t| *t.0).collect();
        area(&SurfaceMesh { vertices: skin.surface.vertices.clone(), triangles }) * 1e6
    }

    /// A dome with a bore from its flat base into a round chamber.
    const DOME: &str = "
        unit = 'mm'
        grid = 0.5
        [[solid]]
        name = 'dome'
        shape.sphere = { center = [0, 0, 0], radius = 6 }
        [[solid]]
        name = 'knob'
        shape.sphere = { center = [0, 0, 6], radius = 2 }
        [[cavity]]
        name = 'chamber'
        shape.sphere = { center = [0, 0, 2.5], radius = 2 }
        [[cavity]]
        name = 'bore'
        shape.cylinder = { from = [0, 0, -1], to = [0, 0, 2], radius = 1 }
        [[cut]]
        name = 'floor'
        normal = [0, 0, -2]
        offset = 0
        [[region]]
        name = 'base'
        cut = 'floor'
        [[region]]
        name = 'cavity'
        cavity = true
        [[region]]
        name = 'top'
        primitives = ['knob']
        [[region]]
        name = 'left'
        within = { min = [-9, 0, 0], max = [9, 9, 9] }
        [[region]]
        name = 'skin'
        rest = true";

    #[test]
    fn a_dome_is_closed_cut_exactly_and_fully_assigned() {
        let model = toml::from_str::<Model>(DOME).unwrap();
        let fields = Fields::new(&model, false);
        let skin = surface(&model, &fields).unwrap();
        assert_eq!(check_surface(&skin.surface), vec![]);

        let regions = assign(&model, &fields, &skin);
        let to_mm = skin.surface.vertices.iter().map(|v| v * 1e3).collect();
        let surface = SurfaceMesh { vertices: to_mm, triangles: skin.surface.triangles };
        let (mut areas, mut lowest) = ([0.0; 5], [f64::INFINITY; 5]);
        for (t, region) in regions.iter().enumerate() {
            let [a, b, c] = surface.corners(t);
            areas[region.unwrap()] += triangle_area(a, b, c);
            lowest[region.unwrap()] = lowest[region.unwrap()].min(surface.centroid(t).z);
            if region.unwrap() == 0 {
                assert!([a, b, c].iter().all(|p| p.z == 0.0), "{a} {b} {c}");
            }
        }
        // Chords of length h under-estimate areas by about (h/r)²/10: 2 % at the bore.
        let pi = std::f64::consts::PI;
        for (region, exact) in
            [(0, 35.0 * pi), (1, 4.0 * pi * 4.0 - 2.0 * pi * 2.0 * 0.268 + 2.0 * pi * 0.768)]
        {
            let off = areas[region] / exact - 1.0;
            assert!(off.abs() < 0.03, "region {region}: area {} vs {exact}", areas[region]);
        }
        assert!(lowest[2] > 5.0, "the knob reaches down to {}", lowest[2]);
        // Triangles on the seam, 19 mm long, go to either side: up to 19 h/4 mm² of 106.
        assert!((areas[3] / areas[4] - 1.0).abs() < 0.05, "halves {} {}", areas[3], areas[4]);

        let dome = 2.0 / 3.0 * pi * 216.0;
        let air = 4.0 / 3.0 * pi * 8.0 + pi * 0.768;
        let (volume, knob) = (enclosed_volume(&surface), 4.0 / 3.0 * pi * 8.0 / 2.0);
        assert!((dome - air..dome - air + knob * 1.5).contains(&volume), "volume {volume}");
    }

    #[test]
    fn loose_pieces_are_refused_with_their_places() {
        let message = made(&DOME.replace("center = [0, 0, 6]", "center = [0, 0, 20]"));
        let message = message.err().unwrap().to_string();
        assert!(message.contains("2 pieces") && message.contains("20.0"), "{message}");
    }

    /// A box of 12 mm with a chamber that leaves a wall of a fifth of the grid, on its cut.
    const BOX: &str = "
        unit = 'mm'
        grid = 1
        simplify = 0.1
        [[solid]]
        name = 'box'
        shape.box = { center = [0, 0, 6], size = [12, 12, 12] }
        [[cavity]]
        name = 'chamber'
        shape.box = { center = [0, 0, 5], size = [11.6, 11.6, 9.4] }
        [[cut]]
        name = 'floor'
        normal = [0, 0, -1]
        offset = 0
        [[region]]
        name = 'all'
        rest = true";

    #[test]
    fn a_wall_thinner_than_the_grid_is_there() {
        let skin = made(BOX).unwrap();
        let volume = enclosed_volume(&skin.surface) * 1e9;
        // Lattices round off edges by half a cell: 10 % of the chamber's and the body's each.
        let exact = 12.0_f64.powi(3) - 11.6 * 11.6 * 9.4;
        assert!((volume / exact - 1.0).abs() < 0.1, "{volume} of {exact} mm³");
        let (thickness, _) = walls::thinnest(&skin.surface).unwrap();
        assert!((0.1..0.2001).contains(&(thickness * 1e3)), "{thickness} m");
        // Both shells are whole: eight corners of each, and no hole between them.
        assert_eq!(mesh::topology::components(&skin.surface.triangles).len(), 2);
    }

    #[test]
    fn a_face_in_the_plane_of_a_cut_is_on_the_cut() {
        for simplify in ["0.1", "0"] {
            let text = BOX.replace("simplify = 0.1", &format!("simplify = {simplify}"));
            let skin = made(&text).unwrap();
            // Its edges are rounded off by less than a cell; rounding moves it by 1e-9 m.
            let floor = area_of(&skin, Part::Cut(0));
            assert!((100.0..=144.001).contains(&floor), "{floor} mm²");
        }
    }

    #[test]
    fn simplified_faces_of_cuts_stay_planar() {
        // A box that the cut leaves little of a cell below: rims that simplification would move.
        let text = BOX.replace(
            "center = [0, 0, 6], size = [12, 12, 12]",
            "center = [0, 0, 3.9], size = [12.3, 12.9, 16.2]",
        );
        for simplify in ["0.1", "0.3"] {
            let skin =
                made(&text.replace("simplify = 0.1", &format!("simplify = {simplify}"))).unwrap();
            let faces = skin.surface.triangles.iter().zip(&skin.part);
            let on_cut = faces.filter(|t| *t.1 == Part::Cut(0)).flat_map(|t| t.0);
            let heights: Vec<f64> = on_cut.map(|&v| skin.surface.vertices[v].z).collect();
            assert!(!heights.is_empty() && heights.iter().all(|z| *z == 0.0), "{heights:?}");
        }
    }

    #[test]
    fn a_primitive_thinner_than_the_grid_refines_it() {
        let plate = |grid: f64| {
            let text = BOX.replace("grid = 1", &format!("grid = {grid}"));
            text.replace("size = [12, 12, 12]", "size = [12, 12, 0.3]")
                .replace(
                    "center = [0, 0, 5], size = [11.6, 11.6, 9.4]",
                    "center = [0, 0, 9], size = [1, 1, 1]",
                )
                .replace("offset = 0", "offset = -5")
        };
        let skin = made(&plate(1.0)).unwrap();
        let volume = enclosed_volume(&skin.surface) * 1e9;
        assert!((volume / 43.2 - 1.0).abs() < 0.1, "{volume} mm³");
        let cells = plate(1.0).replace("size = [12, 12, 0.3]", "size = [1200, 1200, 0.3]");
        let message = format!("{:#}", made(&cells).err().unwrap());
        assert!(
            message.contains("\"box\" is 0.3000 mm thin") && message.contains("cells"),
            "{message}"
        );
    }
}
