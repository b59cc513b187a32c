//! The closed surface of a model.

use anyhow::{Result, anyhow, ensure};
use mesh::Vec3;
use mesh::check::check_surface;
use mesh::check::findings;
use mesh::measure::diagonal;
use mesh::rounding::Rounded;
use mesh::solid::Solid;
use mesh::topology::submesh;
use program::Unusable;

use super::Fields;
use super::carve::carve;
use super::complex::Complex;
use super::lattice::lattice;
use super::model::Model;
use super::refine::{FINEST, refine};
use super::resolution::{remark_on_chords, remark_on_walls, resolved};
use super::sides::Sides;
use super::skin::{Part, Skin};
use super::thin;

/// Parts of `simplify` that are tried in turn, until the surface is sound.
const SIMPLIFY: [f64; 3] = [1.0, 0.3, 0.1];

/// The thickest needle that is taken out where triangles cross [diagonal]: 32 bits resolve 6e-8 of
/// a coordinate.
const NEEDLE: f64 = 1e-6;

/// The closed surface of a model. What its grid does not resolve is logged, with places.
pub fn surface(model: &Model, fields: &Fields) -> Result<Skin> {
    let sides = Sides::new(model, fields, resolved(model)?)?;
    let laid = laid(model, &sides)?;
    thin::remark(&laid.thin, model.unit.symbol(), sides.metres);
    let tolerance = model.simplify * sides.metres * sides.grid / model.grid;
    let skin = simplified(&laid, tolerance, &sides)?;
    remark_on_walls(model, fields, &skin, sides.grid);
    remark_on_chords(model, fields, &laid, sides.grid);
    Ok(skin)
}

/// The surface as the lattice gives it.
fn laid(model: &Model, sides: &Sides) -> Result<Skin> {
    let (mut complex, hidden) = refine(lattice(sides, model.bounds())?, sides)?;
    for k in 0..sides.list.len() {
        let (carved, beside) = carve(&complex, sides, k)?;
        complex = carved;
        if beside > 0 {
            log::warn!(
                "{beside} edges are split beside {:?}, by up to half of them: the grid does not resolve \
                 what is there",
                sides.part(k)
            );
        }
    }
    let mut skin = require_one_piece(Skin::of(&complex, sides), sides)?;
    skin.thin = thin::places(&skin, hidden, sides);
    Ok(skin)
}

/// A surface with fewer triangles, moved by `tolerance` [m] at most, or by a part of that, or not at
/// all if it does not stay sound.
fn simplified(laid: &Skin, tolerance: f64, sides: &Sides) -> Result<Skin> {
    if tolerance > 0.0 {
        for part in SIMPLIFY {
            let by = part * tolerance;
            let skin = Skin::rounded(&laid.solid()?.simplify(by), sides);
            let found = check_surface(&skin.surface);
            if found.is_empty() {
                return Ok(Skin { thin: laid.thin.clone(), ..skin });
            }
            log::debug!("simplified by {by:.2e} m it is not sound:{}", findings(&found));
        }
        log::info!("no simplification leaves the surface sound: it is kept as it is");
    }
    let found = check_surface(&laid.surface);
    if !found.is_empty() {
        return Err(Unusable(format!("the surface is not sound:{}", findings(&found))).into());
    }
    Ok(laid.clone())
}

impl Skin {
    /// The boundary of carved tetrahedra.
    fn of(complex: &Complex, sides: &Sides) -> Self {
        let faces = complex.boundary();
        let first = |face: &[u32; 3]| sides.part(complex.common(*face).trailing_zeros() as usize);
        let part = faces.iter().map(first).collect();
        let triangles: Vec<[usize; 3]> = faces.iter().map(|f| f.map(|v| v as usize)).collect();
        Self { surface: submesh(&complex.vertices, &triangles).0, part, thin: Vec::new() }
    }

    /// The solid that it bounds, with labels of parts.
    fn solid(&self) -> Result<Solid> {
        let labels: Vec<u32> = self.part.iter().map(|part| part.label()).collect();
        Solid::from_labelled_surface(&self.surface, &labels).map_err(|e| anyhow!(e))
    }

    /// The surface of what simplification made of [`Self::solid`]. Faces of cuts are put back into
    /// their planes, from which it may have moved them.
    fn rounded(solid: &Solid, sides: &Sides) -> Self {
        let (mut surface, origins) = solid.to_surface_with_origin();
        let part: Vec<Part> = origins.iter().map(|o| Part::of_label(o.face)).collect();
        let mut on = vec![0; surface.vertices.len()];
        for (triangle, part) in surface.triangles.iter().zip(&part) {
            if let Part::Cut(cut) = part {
                triangle.iter().for_each(|&v| on[v] |= 1 << cut);
            }
        }
        surface.vertices.iter_mut().zip(on).for_each(|(v, on)| *v = sides.settle(v, on));
        let rounded = Rounded::new(&surface, NEEDLE * diagonal(&surface.vertices));
        let part = rounded.source.iter().map(|&t| part[t]).collect();
        Self { surface: rounded.surface, part, thin: Vec::new() }
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

/// Refuses a body of no or of several pieces, and says where they are. Crumbs of less than a finest cell
/// go.
fn require_one_piece(skin: Skin, sides: &Sides) -> Result<Skin> {
    ensure!(
        !skin.part.is_empty(),
        "nothing is left of the body: do its primitives lie behind a cut, or in the cavity?"
    );
    let crumb = (FINEST * sides.grid * sides.metres).powi(3);
    let all = skin.solid()?.decompose();
    let (pieces, crumbs): (Vec<_>, Vec<_>) = all.into_iter().partition(|p| p.volume() > crumb);
    let place = |piece: &Solid| {
        let (min, max): (Vec3, Vec3) = piece.bounds();
        let (at, volume) =
            ((min + max) / 2.0 / sides.metres, piece.volume() / sides.metres.powi(3));
        format!("{volume:.4e} around ({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)
    };
    let list = |pieces: &[Solid]| {
        let first: Vec<String> = pieces.iter().take(3).map(place).collect();
        first.join(", ") + if pieces.len() > 3 { ", …" } else { "" }
    };
    ensure!(
        pieces.len() == 1,
        "the body falls into {} pieces, of the volumes {}; it must be one: join its primitives, or \
         leave out what is cut off",
        pieces.len(),
        list(&pieces)
    );
    if crumbs.is_empty() {
        return Ok(skin);
    }
    log::warn!("left out: {} crumb(s), of the volumes {}", crumbs.len(), list(&crumbs));
    Ok(Skin::rounded(&pieces[0], sides))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{Fields, Kind, assign};
    use mesh::SurfaceMesh;

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
    fn a_ball_converges() {
        for grid in [4.0_f64, 2.0] {
            let skin = made(&format!(
                "unit = 'mm'\ngrid = {grid}\n[[solid]]\nname = 'ball'\nshape.sphere = {{ center = [0, 0, 0], \
                 radius = 35 }}\n[[region]]\nname = 'all'\nrest = true"
            ))
            .unwrap();
            let exact = 4.0 / 3.0 * std::f64::consts::PI * 35.0_f64.powi(3);
            // Inscribed triangles of size h: relative volume error ~ h²/R². 32 bits keep 2e-6 mm.
            let error = enclosed_volume(&skin.surface) * 1e9 / exact - 1.0;
            assert!(error.abs() < (grid / 35.0).powi(2), "{grid} {error}");
            let off = skin.surface.vertices.iter().map(|v| (v.norm() * 1e3 - 35.0).abs());
            assert!(off.fold(0.0, f64::max) < 1e-4 * grid);
        }
    }

    /// Two blocks on a slab, `gap` apart, the right one `wide`, so that points of the lattice of 1 mm lie in
    /// the middle of the gap or not.
    fn blocks(gap: f64, wide: f64) -> Skin {
        let block = |name: &str, x: f64, wide: f64| {
            format!(
                "[[solid]]\nname = '{name}'\nshape.box = {{ center = [{x}, 0, 3.1], size = [{wide}, 6, 6.3] }}\n"
            )
        };
        let (left, right) =
            (block("left", -2.5 - gap / 2.0, 5.0), block("right", (wide + gap) / 2.0, wide));
        made(&format!(
            "unit = 'mm'\ngrid = 1\n[[solid]]\nname = 'slab'\nshape.box = {{ center = [0, 0, 0], size = \
             [10, 8, 3] }}\n{left}{right}[[region]]\nname = 'all'\nrest = true"
        ))
        .unwrap()
    }

    #[test]
    fn a_groove_narrower_than_the_grid_is_open() {
        for (gap, wide) in [(0.9, 5.0), (0.35, 5.0), (0.9, 5.6), (0.5, 5.6), (0.35, 5.6)] {
            let skin = blocks(gap, wide);
            let winding = mesh::inside::WindingNumber::new(&skin.surface);
            let inside = |x: f64, z: f64| winding.contains(&Vec3::new(x * 1e-3, 0.1e-3, z * 1e-3));
            assert!((0..8).all(|k| !inside(0.0, 2.0 + 0.5 * f64::from(k))), "closed: {gap}");
            assert!(inside(gap / 2.0 + 0.2, 4.0) && inside(-gap / 2.0 - 0.2, 4.0), "{gap}");
            assert!(skin.thin.is_empty(), "{gap}: {:?}", skin.thin);
        }
    }

    #[test]
    fn what_is_thinner_than_the_finest_cell_is_said_with_its_place() {
        for (gap, wide) in [(0.28, 5.0), (0.02, 5.0), (0.1, 5.6), (0.02, 5.6)] {
            let skin = blocks(gap, wide);
            assert_eq!(check_surface(&skin.surface), vec![]);
            let thin = skin.thin.first().unwrap();
            assert_eq!(thin.kind, Kind::Gap);
            // Measured on the functions: to rounding where it is open, along an edge where it is not.
            assert!((thin.thickness * 1e3 / gap - 1.0).abs() < 1e-3, "{gap}: {thin:?}");
            let [x, y, z] = thin.at.map(|x| x * 1e3);
            assert!(x.abs() < gap && y.abs() < 3.2 && (1.4..6.4).contains(&z), "{thin:?}");
        }
        // A web of the solid, and a wall between solid and cavity.
        let skin = made(&BOX.replace("11.6, 11.6, 9.4", "11.8, 11.6, 9.4")).unwrap();
        assert_eq!((skin.thin[0].kind, skin.thin[0].resolved), (Kind::Wall, true));
        assert!((skin.thin[0].thickness * 1e3 - 0.1).abs() < 1e-5, "{:?}", skin.thin[0]);
    }

    #[test]
    fn surfaces_that_touch_or_coincide_make_a_sound_body() {
        // Balls that touch each other in a lattice point, a slab and a cut; chambers that share a face.
        let text = "unit = 'mm'\ngrid = 1\n
            [[solid]]\nname = 'slab'\nshape.box = { center = [0, 0, -1], size = [16, 16, 4] }
            [[solid]]\nname = 'a'\nshape.sphere = { center = [-3, 0, 4], radius = 3 }
            [[solid]]\nname = 'b'\nshape.sphere = { center = [3, 0, 4], radius = 3 }
            [[solid]]\nname = 'post'\nshape.box = { center = [0, 3, 3], size = [4, 6, 8] }
            [[cavity]]\nname = 'c'\nshape.box = { center = [-4, -4, -1], size = [4, 4, 2] }
            [[cavity]]\nname = 'd'\nshape.box = { center = [0, -4, -1], size = [4, 4, 2] }
            [[cut]]\nname = 'low'\nnormal = [0, 0, -1]\noffset = 3
            [[cut]]\nname = 'high'\nnormal = [0, 0, 1]\noffset = 7
            [[region]]\nname = 'all'\nrest = true";
        let skin = made(text).unwrap();
        assert_eq!(check_surface(&skin.surface), vec![]);
        assert!(
            (area_of(&skin, Part::Cut(0)) - 256.0).abs() < 4.0,
            "{}",
            area_of(&skin, Part::Cut(0))
        );
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
