//! Molds of designed bodies: the surface of the model is carried along.

#![allow(clippy::unwrap_used)]

use std::ffi::OsStr;
use std::process::Output;

use crate::fixture::{CELL, CHAMBER, Scene, fab, stderr, stdout};
use fab::body::files::BodyFiles;
use fab::config::{Casts, Chambers};
use fab::files::report::MoldReport;
use mesh::bvh::SurfaceBvh;
use mesh::io::{read_tets, write_surface, write_tets};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

/// Axis of the round chamber, its radius, bottom and top [m].
const AXIS: [f64; 2] = [2.5 * CELL, 3.5 * CELL];
const RADIUS: f64 = 7e-3;
const ENDS: [f64; 2] = [2.0 * CELL, 5.0 * CELL];

/// A scene whose chamber is made round, so that its facets are 0.36 mm off the model, and designed.
fn designed(config: &str, design: impl Fn(&Vec3) -> Vec3) -> Scene {
    let scene = Scene::new(&CHAMBER, config);
    let file = read_tets(&scene.path("design.msh")).unwrap();
    let mut mesh = file.mesh;
    for p in &mut mesh.vertices {
        let (x, y) = (p.x - AXIS[0], p.y - AXIS[1]);
        let on_wall = (x.abs().max(y.abs()) - 1.5 * CELL).abs() < 1e-9;
        if on_wall && p.z > ENDS[0] - 1e-9 && p.z < ENDS[1] + 1e-9 {
            let scale = RADIUS / x.hypot(y);
            (p.x, p.y) = (AXIS[0] + x * scale, AXIS[1] + y * scale);
        }
    }
    write_tets(&scene.path("tagged.msh"), &mesh, &file.tags).unwrap();
    mesh.vertices.iter_mut().for_each(|p| *p = design(p));
    write_tets(&scene.path("design.msh"), &mesh, &file.tags).unwrap();
    write_surface(&scene.path("model.stl"), &model().to_surface()).unwrap();
    scene
}

/// The body as modelled.
fn model() -> Solid {
    let block = Solid::cube(&Vec3::zeros(), &(Vec3::new(5.0, 7.0, 6.0) * CELL));
    let base = Vec3::new(AXIS[0], AXIS[1], ENDS[0]);
    let axis = Vec3::z() * (ENDS[1] - ENDS[0]);
    let chamber = Solid::cylinder(&base, &axis, RADIUS, RADIUS, 128);
    let inlet =
        Solid::cube(&(Vec3::new(2.0, 3.0, -1.0) * CELL), &(Vec3::new(3.0, 4.0, 2.5) * CELL));
    block.difference(&chamber).difference(&inlet)
}

/// The wall of the chamber bulges and leans; its ends stay.
fn bulging(p: &Vec3) -> Vec3 {
    let (x, y) = (p.x - AXIS[0], p.y - AXIS[1]);
    let out = x.hypot(y);
    if p.z < ENDS[0] || p.z > ENDS[1] || (out - RADIUS).abs() > 2e-5 {
        return *p;
    }
    let height = 4.0 * (p.z - ENDS[0]) * (ENDS[1] - p.z) / (ENDS[1] - ENDS[0]).powi(2);
    p + Vec3::new(0.8 * x / out + 0.3, 0.8 * y / out, 0.0) * (1e-3 * height)
}

/// Largest distance of the points from a surface [mm].
fn off(points: &[Vec3], surface: &SurfaceMesh) -> f64 {
    let bvh = SurfaceBvh::new(surface);
    points.iter().map(|p| 1e3 * bvh.closest(p).distance).fold(0.0, f64::max)
}

/// The surface that is cast [m].
fn cast(scene: &Scene, asked: Option<Casts>) -> (SurfaceMesh, Casts) {
    let [mesh, model, modelled] =
        ["design.msh", "model.stl", "tagged.msh"].map(|name| scene.path(name));
    let files = BodyFiles { mesh: &mesh, model: Some(&model), modelled: Some(&modelled) };
    let boundary = files.read(&Chambers::one("cavity"), asked).unwrap().boundary;
    (boundary.cast, boundary.casts)
}

fn mold(scene: &Scene) -> Output {
    let names = ["design.msh", "mold.toml", "mold", "model.stl", "tagged.msh"];
    let [mesh, config, out, model, from] = names.map(|name| scene.path(name));
    let [mesh, config, out, model, from] =
        [&mesh, &config, &out, &model, &from].map(|path| path.as_os_str());
    let [verb, c, o, m, f, n] =
        ["mold", "--config", "-o", "--model", "--from", "--no-pictures"].map(OsStr::new);
    fab(&[verb, mesh, c, config, o, out, m, model, f, from, n])
}

/// What `fab verify` says of a mold that is right, with single spaces.
fn verified(scene: &Scene) -> String {
    let made = mold(scene);
    assert!(made.status.success(), "{}", stderr(&made));
    let verified = scene.verify();
    assert!(verified.status.success(), "{}", stdout(&verified));
    stdout(&verified).split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn a_designed_chamber_has_the_roundness_of_its_model() {
    let scene = designed("core.support = \"stub\"", bulging);
    let around = |i: usize| std::f64::consts::TAU * i as f64 / 360.0;
    let point = |i: usize, j: usize| {
        let z = ENDS[0] + (ENDS[1] - ENDS[0]) * j as f64 / 40.0;
        Vec3::new(AXIS[0] + RADIUS * around(i).cos(), AXIS[1] + RADIUS * around(i).sin(), z)
    };
    let exact: Vec<Vec3> =
        (0..360).flat_map(|i| (0..=40).map(move |j| bulging(&point(i, j)))).collect();
    let (carried, casts) = cast(&scene, None);
    assert_eq!(casts, Casts::Carried);
    let [carried, facets] = [&carried, &cast(&scene, Some(Casts::Model)).0].map(|s| off(&exact, s));
    assert!(carried < 0.04, "{carried} mm");
    assert!(facets > 0.3, "{facets} mm");

    // how far the triangles of the model are from the CAD, as its report says, is added
    let triangles = model().to_surface().triangles.len();
    let with = |chord: f64| {
        let report = format!("{{\"triangles\": {triangles}, \"chord_error\": {chord}}}");
        std::fs::write(scene.path("model.json"), report).unwrap();
        verified(&scene)
    };
    let said = with(1e-5);
    for line in [
        "ok surface: mold to carried CAD ",
        "ok surface: mold to CAD that moved 0.0",
        "ok surface: mold to CAD 0.01",
        "0.0100 mm of it between model.stl and the CAD",
        "ok surface: mold to design ",
    ] {
        assert!(said.contains(line), "{line}: {said}");
    }
    let report = MoldReport::read(&scene.path("mold")).unwrap();
    assert_eq!(report.input.surface, Casts::Carried);
    let said = with(2e-4);
    assert!(said.contains("warn surface: mold to CAD 0.2"), "{said}");
    assert!(said.contains("with a smaller --chord"), "{said}");
}

/// A side of the block bulges by 0.8 mm, its edges stay.
#[test]
fn an_outside_that_was_designed_is_carried() {
    let [wide, deep, high] = [5.0, 7.0, 6.0].map(|count| count * CELL);
    let bulge = |p: &Vec3| {
        let hat = |x: f64, end: f64| 4.0 * x * (end - x) / end.powi(2);
        let out =
            if p.x > wide - 1e-9 { 8e-4 * (hat(p.y, deep) * hat(p.z, high)).powi(2) } else { 0.0 };
        p + Vec3::x() * out
    };
    let scene = designed("core.support = \"stub\"", bulge);
    let point = |i: usize, j: usize| {
        bulge(&Vec3::new(wide, deep * i as f64 / 60.0, high * j as f64 / 60.0))
    };
    let exact: Vec<Vec3> = (0..=60).flat_map(|i| (0..=60).map(move |j| point(i, j))).collect();
    let (carried, casts) = cast(&scene, None);
    assert_eq!(casts, Casts::Carried);
    let [carried, facets] = [&carried, &cast(&scene, Some(Casts::Mesh)).0].map(|s| off(&exact, s));
    assert!(carried < 0.045, "{carried} mm");
    assert!(facets > 0.06, "{facets} mm");

    let said = verified(&scene);
    for line in ["ok surface: mold to CAD that moved 0.0", "ok surface: mold to CAD "] {
        assert!(said.contains(line), "{line}: {said}");
    }
}

/// The tetrahedra are cast, with the reason, where the design has other facets than the mesh as modelled.
#[test]
fn a_surface_that_was_meshed_again_is_not_carried() {
    let scene = designed("core.support = \"stub\"", bulging);
    let path = scene.path("design.msh");
    let mut file = read_tets(&path).unwrap();
    // A tetrahedron is divided at its facet.
    let [a, b, c] = mesh::topology::boundary(&file.mesh).facets[0];
    let index =
        file.mesh.tets.iter().position(|t| [a, b, c].iter().all(|v| t.contains(v))).unwrap();
    let whole = file.mesh.tets[index];
    let middle = file.mesh.vertices.len();
    file.mesh.vertices.push([a, b, c].iter().map(|&v| file.mesh.vertices[v]).sum::<Vec3>() / 3.0);
    let part = |corner: usize| whole.map(|v| if v == corner { middle } else { v });
    file.mesh.tets[index] = part(a);
    file.mesh.tets.extend([part(b), part(c)]);
    let tag = file.tags.get([a, b, c]).unwrap();
    for corner in [a, b, c] {
        file.tags.set([a, b, c].map(|v| if v == corner { middle } else { v }), tag);
    }
    file.tags.facets.remove(&mesh::facet_key([a, b, c]));
    write_tets(&path, &file.mesh, &file.tags).unwrap();
    let made = mold(&scene);
    assert!(made.status.success(), "{}", stderr(&made));
    assert!(stderr(&made).contains("facets on its boundary, and not those"), "{}", stderr(&made));
    let report = MoldReport::read(&scene.path("mold")).unwrap();
    assert_ne!(report.input.surface, Casts::Carried);
}
