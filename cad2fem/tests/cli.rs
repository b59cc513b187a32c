//! The command line without external programs: models, patches, information, and
//! what is said about bad input.

#![allow(clippy::unwrap_used)]

use std::fs;

use crate::support::Workdir;
use mesh::check::check_surface;
use mesh::io::{read_surface, write_surface};
use mesh::measure::{area, enclosed_volume};
use mesh::solid::Solid;
use mesh::topology::{boundary_loops, components};
use mesh::{SurfaceMesh, Vec3};

/// Half a ball with a bore that opens in its flat side.
const DOME: &str = "
    unit = 'mm'
    grid = 0.7
    simplify = 0.02
    solid = [{ name = 'ball', shape.sphere = { center = [0, 0, 0], radius = 5 } }]
    cavity = [{ name = 'slot', shape.cylinder = { from = [-1, 0, 0], to = [2, 0, 0], radius = 1 } }]
    cut = [{ name = 'flat', normal = [-1, 0, 0], offset = 0 }]
    region = [
        { name = 'fixed', cut = 'flat' },
        { name = 'cavity', cavity = true },
        { name = 'skin', rest = true },
    ]
    [[variant]]
    name = 'big'
    [variant.solid.ball]
    shape.sphere.radius = 6
";

fn cube(half: f64) -> SurfaceMesh {
    Solid::cube(&Vec3::repeat(-half), &Vec3::repeat(half)).to_surface()
}

#[test]
fn a_model_becomes_a_closed_surface_in_patches() {
    let dir = Workdir::new();
    dir.write("model.toml", DOME);
    dir.run("model model.toml -o out").succeeds();
    let model = read_surface(&dir.path("out/model.stl")).unwrap();
    assert_eq!(check_surface(&model), vec![]);

    let patches = ["fixed", "cavity", "skin"]
        .map(|name| read_surface(&dir.path(&format!("out/patches/{name}.stl"))).unwrap());
    let total: f64 = patches.iter().map(area).sum();
    // STL rounds coordinates to 6e-8.
    assert!((total / area(&model) - 1.0).abs() < 1e-6, "{total} of {}", area(&model));
    assert_eq!(patches.each_ref().map(|p| boundary_loops(&p.triangles).len()), [2, 1, 1]);
    assert!(patches[0].vertices.iter().all(|v| v.x == 0.0), "the cut is not planar");
    // A half ball of 5 mm without a bore of 1 mm; chords of 0.7 mm cost up to 2 %.
    let exact = (2.0 / 3.0 * 125.0 - 2.0) * std::f64::consts::PI * 1e-9;
    let volume = enclosed_volume(&model);
    assert!((volume / exact - 1.0).abs() < 0.02, "{volume} vs {exact}");

    let big = read_surface(&dir.path("out/big/model.stl")).unwrap();
    let growth = (enclosed_volume(&big) / volume - 1.0) * exact;
    let added = 2.0 / 3.0 * (216.0 - 125.0) * std::f64::consts::PI * 1e-9;
    assert!((growth / added - 1.0).abs() < 0.03, "{growth} vs {added}");

    let report = dir.json("out/model.json");
    assert_eq!(report["triangles"], model.triangles.len());
    assert_eq!(report["unassigned"]["triangles"], 0);
}

#[test]
fn regions_name_single_cavities() {
    let dir = Workdir::new();
    let two = DOME.replace(
        "cavity = [",
        "cavity = [{ name = 'side', shape.sphere = { center = [1.5, 2.5, 0], radius = 0.8 } }, ",
    );
    let named = |names: &str| {
        two.replace(
            "{ name = 'cavity', cavity = true }",
            &format!("{{ name = 'one', cavity = {names} }}, {{ name = 'two', cavity = true }}"),
        )
    };
    dir.write("model.toml", &named("'side'"));
    dir.run("model model.toml -o out").succeeds();
    let one = read_surface(&dir.path("out/patches/one.stl")).unwrap();
    // the ball, closed; chords of 0.7 mm take off a good part of its area
    assert_eq!(boundary_loops(&one.triangles).len(), 0);
    let exact = 4.0 * std::f64::consts::PI * 0.8e-3_f64.powi(2);
    assert!((0.6..1.0).contains(&(area(&one) / exact)), "{}", area(&one) / exact);
    dir.write("model.toml", &named("['side', 'slot']"));
    dir.run("model model.toml -o out").fails(1, "region \"two\" is empty");
    dir.write("model.toml", &named("'ball'"));
    dir.run("model model.toml -o out").fails(2, "no body \"ball\" in [[cavity]]");
    let walls = named("true").replace("cavity = true }, {", "primitives = ['side'] }, {");
    dir.write("model.toml", &walls);
    let words = "\"side\" is in [[cavity]], and its walls are cavity = \"side\"";
    dir.run("model model.toml -o out").fails(2, words);
}

#[test]
fn a_failed_model_leaves_no_stamp() {
    let dir = Workdir::new();
    dir.write("model.toml", DOME);
    dir.run("model model.toml -o out").succeeds();
    let nowhere = "within = { min = [20, 0, 0], max = [21, 1, 1] }";
    dir.write("model.toml", &DOME.replace("cut = 'flat' }", &format!("{nowhere} }}")));
    let run = dir.run("model model.toml -o out");
    run.fails(1, "region \"fixed\" is empty");
    assert!(!dir.path("out/model.json").exists());
}

#[test]
fn mistakes_in_a_model_file_are_shown_with_their_line() {
    let dir = Workdir::new();
    dir.write("model.toml", &DOME.replace("grid", "gird"));
    dir.run("model model.toml -o out").fails(2, "model.toml:3:");
    dir.run("model nothing.toml -o out").fails(2, "nothing.toml");
    dir.write("model.toml", DOME);
    dir.run("model model.toml -o out --unit mm").fails(2, "states its own");
    dir.write("script.geo", "Sphere(1) = {0, 0, 0, 1};");
    dir.run("model script.geo -o out").fails(2, "say --unit mm");
    assert!(!dir.path("out").exists());
}

#[test]
fn an_open_patch_becomes_a_closed_volume() {
    let dir = Workdir::new();
    let mut patch = cube(0.5);
    patch.triangles.retain(|t| t.iter().all(|&v| patch.vertices[v].z > 0.0));
    write_surface(&dir.path("patch.stl"), &patch).unwrap();
    write_surface(&dir.path("model.stl"), &cube(0.5)).unwrap();
    dir.run("offset patch.stl -o a.obj").says("distance 1.4142 mm");
    dir.run("offset patch.stl -o c.obj --distance 0.01").succeeds();
    let volume = read_surface(&dir.path("c.obj")).unwrap();
    assert_eq!(check_surface(&volume), vec![]);
    assert!((enclosed_volume(&volume) - 0.02).abs() < 1e-12);

    dir.run("offset model.stl -o d.obj").says("the patch is closed");
    assert_eq!(components(&read_surface(&dir.path("d.obj")).unwrap().triangles).len(), 2);
    dir.run("offset patch.stl -o e.obj --distance=-1").fails(2, "positive");
    dir.run("offset patch.stl -o ./patch.stl").fails(2, "give the output another name");
    // five sides of a cube, which bends more sharply than the distance
    let mut bent = cube(0.5);
    bent.triangles.pop();
    write_surface(&dir.path("bent.stl"), &bent).unwrap();
    let bent = dir.run("offset bent.stl -o f.obj --distance 0.9");
    bent.says("smaller --distance");
}

#[test]
fn info_tells_numbers_and_findings() {
    let dir = Workdir::new();
    let mut surface = cube(0.5);
    write_surface(&dir.path("cube.ply"), &surface).unwrap();
    let run = dir.run("info cube.ply --json --check");
    run.succeeds();
    let info: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(info["triangles"], 12);
    assert!((info["volume"].as_f64().unwrap() - 1.0).abs() < 1e-15, "{}", info["volume"]);
    assert_eq!(info["findings"], serde_json::json!([]));

    surface.triangles.pop();
    write_surface(&dir.path("open.ply"), &surface).unwrap();
    let run = dir.run("info open.ply");
    run.succeeds();
    assert!(run.stdout.contains("3 open edge(s) in 1 loop(s)"), "{}", run.stdout);
    dir.run("info open.ply --check").fails(1, "closed: 3 edges");
    dir.write("cut.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0\n");
    dir.run("info cut.msh").fails(2, "truncated");
}

#[test]
fn bad_surfaces_are_refused_before_a_mesher_runs() {
    let dir = Workdir::new();
    let refused = |name: &str, surface: &SurfaceMesh, expected: &str| {
        write_surface(&dir.path(name), surface).unwrap();
        dir.run(&format!("tetmesh {name} -o out.msh")).fails(2, expected);
        assert!(!dir.path("out.msh").exists());
    };
    let mut open = cube(1.0);
    open.triangles.pop();
    refused("open.stl", &open, "open.stl: it does not bound a body:\n  closed: 3 edges");
    let mut crossing = cube(0.5);
    crossing.vertices[0] = Vec3::repeat(1.5);
    refused("crossing.stl", &crossing, "intersect");

    let mut bytes = fs::read(dir.path("open.stl")).unwrap();
    bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(dir.path("nan.stl"), &bytes).unwrap();
    dir.run("tetmesh nan.stl -o out.msh").fails(2, "not finite");
    fs::write(dir.path("cut.stl"), &bytes[..200]).unwrap();
    dir.run("tetmesh cut.stl -o out.msh").fails(2, "cut.stl");
}

#[test]
fn a_missing_python_or_mesher_is_explained() {
    let dir = Workdir::new();
    write_surface(&dir.path("cube.stl"), &cube(1.0)).unwrap();
    let arguments = "tetmesh cube.stl -o out.msh --no-cache";
    dir.run_with("PUFFER_PYTHON", "/nowhere/python", arguments).fails(2, "/nowhere/python");
    let bare = dir.program("bare", "exit 1");
    dir.run_with("PUFFER_PYTHON", &bare, arguments).fails(2, "make setup");
}

#[test]
fn a_mesher_that_crashes_or_hangs_is_reported() {
    let dir = Workdir::new();
    write_surface(&dir.path("cube.stl"), &cube(1.0)).unwrap();
    let arguments = "tetmesh cube.stl -o out.msh --no-cache --timeout 1";
    let answer = "if [ \"$2\" = -c ]; then echo wildmeshing 0.0; exit; fi";
    let crash = dir.program("crash", &format!("{answer}; echo dividing by zero >&2; exit 9"));
    dir.run_with("PUFFER_PYTHON", &crash, arguments).fails(1, "dividing by zero");
    let hang = dir.program("hang", &format!("{answer}; exec sleep 60"));
    dir.run_with("PUFFER_PYTHON", &hang, arguments).fails(1, "--timeout");
    assert!(!dir.path("out.msh").exists());
}

#[test]
fn a_signal_ends_the_mesher_and_removes_its_folder() {
    let dir = Workdir::new();
    write_surface(&dir.path("cube.stl"), &cube(1.0)).unwrap();
    fs::create_dir(dir.path("tmp")).unwrap();
    let answer = "if [ \"$2\" = -c ]; then echo wildmeshing 0.0; exit; fi";
    let hang = dir.program("hang", &format!("{answer}; echo $$ > ../../mesher; exec sleep 60"));
    let start = format!(
        "TMPDIR=$PWD/tmp PUFFER_PYTHON={hang} \"$0\" tetmesh cube.stl -o out.msh --no-cache & p=$!"
    );
    let wait = "until [ -s mesher ]; do sleep 0.05; done";
    let run = dir.run_in_shell(&format!("{start}; {wait}; kill -s TERM $p; wait $p"));
    run.fails(
        143,
        "interrupted by SIGTERM; nothing unfinished is left; the same command does it again",
    );
    assert_eq!(fs::read_dir(dir.path("tmp")).unwrap().count(), 0, "a folder is left");
    let mesher = fs::read_to_string(dir.path("mesher")).unwrap();
    assert!(!std::path::Path::new(&format!("/proc/{}", mesher.trim())).exists(), "it runs on");
}

#[test]
fn sizes_that_cannot_be_meant_are_remarked_on() {
    let dir = Workdir::new();
    write_surface(&dir.path("large.obj"), &cube(40.0)).unwrap();
    dir.run("info large.obj --check").says("138.5641 mm if they are millimetres");
    write_surface(&dir.path("small.obj"), &cube(0.04)).unwrap();
    assert!(!dir.run("info small.obj").stderr.contains("metres"));
    dir.write("endless.obj", "v 0 0 0\nv 1e155 0 0\nv 0 1 0\nf 1 2 3\n");
    dir.run("info endless.obj").fails(2, "1 of 3 vertices are beyond 1e9, the first is");
}

#[test]
fn a_grid_that_cuts_corners_is_remarked_on_with_one_that_does_not() {
    let dir = Workdir::new();
    let made = |grid: f64| {
        let ball = "name = 'ball', shape.sphere = { center = [0, 0, 0], radius = 5 }";
        let rest = "region = [{ name = 'skin', rest = true }]";
        dir.write(
            "model.toml",
            &format!("unit = 'mm'\ngrid = {grid}\nsolid = [{{ {ball} }}]\n{rest}"),
        );
        let run = dir.run("model model.toml -o out");
        run.succeeds();
        (run.stderr, enclosed_volume(&read_surface(&dir.path("out/model.stl")).unwrap()))
    };
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 125e-9;
    let (said, volume) = made(5.0);
    assert!(volume < 0.7 * ball, "{volume} of {ball} m³");
    let better = said.split("; grid = ").nth(1).and_then(|rest| rest.split(' ').next());
    let better = better.unwrap_or_else(|| panic!("no better grid: {said}")).parse().unwrap();
    assert!(said.contains("% of the volume of the solid"), "{said}");
    let (said, volume) = made(better);
    assert!(!said.contains("cuts corners"), "{said}");
    // 5 % to second order in the grid; by as much as a quarter of that more.
    assert!((volume / ball - 1.0).abs() < 1.25 * 0.05, "grid {better}: {volume} of {ball} m³");
}

#[test]
fn settings_are_refused_with_their_file() {
    let dir = Workdir::new();
    write_surface(&dir.path("cube.stl"), &cube(1.0)).unwrap();
    let python = dir.program("python", "exit 1");
    let arguments = "tetmesh cube.stl -o out.msh --config cad2fem.toml";
    for (setting, said) in [
        ("stop_energy = 2", "stop_energy must exceed 3"),
        ("mesher = 'netgen'", "expected one of auto, ftetwild, gmsh"),
        ("envelop = 3", "expected one of `mesher`, `edge_length`"),
        ("edge_length = -1", "between 0 and the diagonal"),
    ] {
        dir.write("cad2fem.toml", &format!("[tetmesh]\n{setting}\n"));
        let run = dir.run_with("PUFFER_PYTHON", &python, arguments);
        run.fails(2, "cad2fem.toml:");
        run.fails(2, said);
    }
}
