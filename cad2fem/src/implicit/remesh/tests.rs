#![allow(clippy::unwrap_used)]
use mesh::check::check_surface;
use mesh::measure::area;
use mesh::topology::edge_facets;
use mesh::{SurfaceMesh, Vec3, walls};

use super::super::{Fields, Model, Part, Skin, surface};

/// A model of one grid of 1 mm, remeshed with an accuracy of 0.03 mm.
fn made(body: &str) -> Skin {
    let text = format!(
        "unit = 'mm'\ngrid = 1\nsimplify = 0.03\nremesh = true\n{body}\n[[region]]\nname = 'all'\nrest = true"
    );
    let model = toml::from_str::<Model>(&text).unwrap();
    let skin = surface(&model, &Fields::new(&model, false)).unwrap();
    assert_eq!(check_surface(&skin.surface), vec![]);
    skin
}

/// A half of a ball of 8 mm with a chamber of 5 mm.
const DOME: &str = "
    [[solid]]
    name = 'ball'
    shape.sphere = { center = [0, 0, 0], radius = 8 }
    [[cavity]]
    name = 'chamber'
    shape.sphere = { center = [0, 0, 0], radius = 5 }
    [[cut]]
    name = 'floor'
    normal = [0, 0, -1]
    offset = 0";

/// Two lobes with a blend of an eighth of the grid, on a chamber through both.
const LOBES: &str = "
    [[solid]]
    name = 'low'
    shape.ellipsoid = { center = [0, 0, 3], radii = [12, 12, 3.8] }
    [[solid]]
    name = 'high'
    shape.ellipsoid = { center = [0, 0, 9.1], radii = [12, 12, 3.8] }
    blend = 0.12
    [[cavity]]
    name = 'chamber'
    shape.cylinder = { from = [0, 0, -9], to = [0, 0, 9], radius = 4.6 }
    [[cut]]
    name = 'floor'
    normal = [0, 0, -1]
    offset = -2";

/// Areas of the outside, the cavity and the cut [mm²].
fn areas(skin: &Skin) -> [f64; 3] {
    [Part::Outside, Part::Cavity, Part::Cut(0)].map(|part| {
        let of_part = skin.surface.triangles.iter().zip(&skin.part).filter(|t| *t.1 == part);
        let triangles = of_part.map(|t| *t.0).collect();
        area(&SurfaceMesh { vertices: skin.surface.vertices.clone(), triangles }) * 1e6
    })
}

/// The smallest angle of a triangle [deg].
fn smallest_angle(surface: &SurfaceMesh) -> f64 {
    let angle = |[a, b, c]: [Vec3; 3]| (b - a).angle(&(c - a)).to_degrees();
    let smallest = |t: usize| {
        let [a, b, c] = surface.corners(t);
        [[a, b, c], [b, c, a], [c, a, b]].map(angle).into_iter().fold(180.0, f64::min)
    };
    (0..surface.triangles.len()).map(smallest).fold(180.0, f64::min)
}

/// The largest angle between the normals of neighbours on one part [deg].
fn sharpest(skin: &Skin) -> f64 {
    let normal = |t: usize| skin.surface.normal(t);
    let edges = edge_facets(&skin.surface.triangles);
    let same = edges.values().filter(|both| skin.part[both[0]] == skin.part[both[1]]);
    same.map(|both| normal(both[0]).angle(&normal(both[1])).to_degrees()).fold(0.0, f64::max)
}

#[test]
fn a_dome_gets_good_triangles_as_near_as_is_asked_for() {
    let skin = made(DOME);
    let pi = std::f64::consts::PI;
    for (part, exact) in areas(&skin).into_iter().zip([128.0 * pi, 50.0 * pi, 39.0 * pi]) {
        // Chords at a distance of 0.03 mm: 1 % of the smaller area.
        assert!((part / exact - 1.0).abs() < 0.01, "{part} of {exact} mm²");
    }
    let off = skin.chord_error.unwrap();
    assert!((0.003e-3..=0.033e-3).contains(&off), "{off}");
    for (triangle, part) in skin.surface.triangles.iter().zip(&skin.part) {
        for p in triangle.map(|v| skin.surface.vertices[v] * 1e3) {
            match part {
                Part::Outside => assert!((p.norm() - 8.0).abs() < 2e-6, "{p}"),
                Part::Cavity => assert!((p.norm() - 5.0).abs() < 2e-6, "{p}"),
                Part::Cut(_) => assert!(p.z == 0.0, "{p}"),
            }
        }
    }
    let angle = smallest_angle(&skin.surface);
    assert!(angle > 20.0, "{angle}");
}

#[test]
fn a_groove_between_lobes_has_no_spikes() {
    let skin = made(LOBES);
    // As the lattice leaves it, the smallest angle is 0.1° and the sharpest fold 146°.
    let (angle, fold) = (smallest_angle(&skin.surface), sharpest(&skin));
    assert!(angle > 5.0 && fold < 100.0, "{angle} {fold}");
    // The function has 2.1 mm at its thinnest, where the cut meets the outside.
    let (thickness, at) = walls::thinnest(&skin.surface).unwrap();
    assert!(thickness * 1e3 > 2.0, "{thickness} at {at}");
}

#[test]
fn a_wall_thinner_than_its_edges_is_kept() {
    let skin = made(&DOME.replace("radius = 5", "radius = 7.7"));
    let (thickness, at) = walls::thinnest(&skin.surface).unwrap();
    assert!((0.24..0.31).contains(&(thickness * 1e3)), "{thickness} at {at}");
    let volume = |r: f64| 2.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let exact = volume(8.0) - volume(7.7);
    let found = mesh::measure::enclosed_volume(&skin.surface) * 1e9;
    assert!((found / exact - 1.0).abs() < 0.02, "{found} of {exact} mm³");
}

#[test]
fn the_same_model_gives_the_same_bits() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let (first, again) = (made(LOBES), one.install(|| made(LOBES)));
    assert_eq!(first.surface, again.surface);
    assert_eq!(first.part, again.part);
}
