//! The external meshers themselves; where one is missing its tests say why they are
//! skipped.

#![allow(clippy::unwrap_used)]

use std::fs;

use crate::support::{Workdir, scene};
use mesh::check::check_surface;
use mesh::io::{read_surface, read_tets, write_surface};
use mesh::measure::{area, enclosed_volume, quality, volume};
use mesh::solid::Solid;
use mesh::topology::{boundary, boundary_loops};
use mesh::{TetMesh, Vec3};

#[test]
fn ftetwild_fills_the_beam_and_the_cache_keeps_it() {
    let Some(dir) = Workdir::with(&["ftetwild"]) else { return };
    dir.run(&format!("model {} -o model", scene("beam", "model.toml"))).succeeds();
    let config = scene("beam", "cad2fem.toml");
    let mesh = format!("tetmesh model/model.stl --config {config} -o");
    // a module of the standard library that Python imports for us
    dir.write("csv.py", "open('executed', 'w')");
    dir.run(&format!("{mesh} a.msh")).succeeds();
    assert!(!dir.path("executed").exists(), "a file of the working directory was run");

    let tets = read_tets(&dir.path("a.msh")).unwrap().mesh;
    assert!((1000..5000).contains(&tets.tets.len()), "{} tets", tets.tets.len());
    let surface = read_surface(&dir.path("model/model.stl")).unwrap();
    let difference = (volume(&tets) - enclosed_volume(&surface)).abs();
    assert!(difference < area(&surface) * 4e-4, "volumes differ by {difference:e}");
    assert!(quality(&tets).radius_ratio_p1 > 0.3);
    // The clamped end stays flat to the last bit, its rim included.
    let (skin, _) = boundary(&tets).surface(&tets);
    assert_eq!(check_surface(&skin), vec![]);
    let flat: f64 = (0..skin.triangles.len())
        .map(|t| skin.corners(t))
        .filter(|corners| corners.iter().all(|p| p.x == 0.0))
        .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
        .sum();
    let fixed = area(&read_surface(&dir.path("model/patches/fixed.stl")).unwrap());
    // The envelope of 0.4 mm may shift the rim of the slot, 28 mm long.
    assert!((flat - fixed).abs() < 28e-3 * 4e-4, "{flat:e} of {fixed:e}");

    dir.run(&format!("{mesh} b.msh")).says("from the cache");
    let bytes = |name: &str| fs::read(dir.path(name)).unwrap();
    assert_eq!(bytes("a.msh"), bytes("b.msh"));

    // made twice, with the same bits
    dir.run(&format!("{mesh} c.msh --no-cache")).succeeds();
    assert_eq!(bytes("a.msh"), bytes("c.msh"));
}

#[test]
fn gmsh_takes_the_chamber_from_cad_to_tets() {
    let Some(dir) = Workdir::with(&["gmsh"]) else { return };
    let script = scene("chamber", "model.geo");
    dir.run(&format!("model {script} --unit mm --set h=3 -o model")).succeeds();

    let surface = read_surface(&dir.path("model/model.stl")).unwrap();
    assert_eq!(check_surface(&surface), vec![]);
    let patch = |name: &str| read_surface(&dir.path(&format!("model/patches/{name}.stl"))).unwrap();
    let loops = |name: &str| boundary_loops(&patch(name).triangles).len();
    assert_eq!(["fixed", "cavity", "outer", "tip"].map(loops), [2, 1, 2, 1]);
    // π (20·16·60 − 15·11·50 − 2.5²·5) mm³; chords of 3 mm take off up to 2 %.
    let exact = std::f64::consts::PI * (19200.0 - 8250.0 - 31.25) * 1e-9;
    assert!((enclosed_volume(&surface) / exact - 1.0).abs() < 0.02);

    let config = scene("chamber", "cad2fem.toml");
    let made = dir.run(&format!("tetmesh model/model.stl --config {config} -o out.msh"));
    made.succeeds();
    let tets = read_tets(&dir.path("out.msh")).unwrap().mesh;
    let off = volume(&tets) / enclosed_volume(&surface) - 1.0;
    assert!(off.abs() < 1e-9, "{off:e}");
    let (skin, _) = boundary(&tets).surface(&tets);
    assert_eq!(skin.triangles.len(), surface.triangles.len());

    // a user who wants longer edges than the surface has learns what makes them
    assert!(!made.stderr.contains("keeps the triangles"), "{}", made.stderr);
    dir.run("tetmesh model/model.stl --mesher gmsh -o longer.msh --edge-length 6e-3")
        .says("edges of 6.0000 mm are wanted, but gmsh keeps the triangles of the surface");

    dir.run(&format!("model {script} --unit mm --set k=4 -o model")).fails(2, "no number k");
    dir.write("broken.geo", "Sphere(1) = {0,");
    dir.run("model broken.geo --unit mm -o model").fails(2, "syntax error");
}

/// The mesher of a mesh, and how far its boundary is from the surface [envelope].
fn made(dir: &Workdir) -> (String, f64) {
    let report = dir.json("out.report.json");
    let mesher = report["mesher"].as_str().unwrap().split(' ').next().unwrap().to_owned();
    (mesher, report["hausdorff_from_input"].as_f64().unwrap())
}

#[test]
fn gmsh_takes_well_shaped_surfaces_first_and_ftetwild_what_it_refuses() {
    let Some(dir) = Workdir::with(&["gmsh", "ftetwild"]) else { return };
    let ball = |radius: f64| Solid::sphere(&Vec3::zeros(), radius, 48);
    write_surface(&dir.path("ball.stl"), &ball(0.02).to_surface()).unwrap();
    dir.run("tetmesh ball.stl -o out.msh").succeeds();
    assert!(
        matches!(made(&dir), (mesher, off) if mesher == "gmsh" && off < 1e-9),
        "{:?}",
        made(&dir)
    );
    // shells inside bound cavities
    let hollow = ball(0.02).difference(&ball(0.012)).difference(&Solid::sphere(
        &Vec3::new(0.0, 0.0, 0.016),
        0.002,
        12,
    ));
    write_surface(&dir.path("hollow.stl"), &hollow.to_surface()).unwrap();
    dir.run("tetmesh hollow.stl --mesher gmsh -o out.msh").succeeds();
    assert!(
        matches!(made(&dir), (mesher, off) if mesher == "gmsh" && off < 1e-9),
        "{:?}",
        made(&dir)
    );
    let tets = read_tets(&dir.path("out.msh")).unwrap().mesh;
    let off = volume(&tets) / enclosed_volume(&read_surface(&dir.path("hollow.stl")).unwrap());
    assert!((off - 1.0).abs() < 1e-9, "{off}");
    // what gmsh cannot keep goes to fTetWild, unless gmsh was asked for
    let plate = Solid::cube(&Vec3::new(-0.03, -0.03, -1e-3), &Vec3::new(0.03, 0.03, 1e-3));
    write_surface(&dir.path("plate.stl"), &plate.to_surface()).unwrap();
    let inside = "tetmesh ball.stl --inside plate.stl -o out.msh";
    dir.run(inside).says("ftetwild is tried");
    assert_eq!(made(&dir).0, "ftetwild");
    dir.run(&format!("{inside} --mesher gmsh")).fails(2, "surfaces inside cross");
}

#[test]
fn scripts_reach_outside_only_with_trust() {
    let Some(dir) = Workdir::with(&["gmsh"]) else { return };
    let body = "SetFactory('OpenCASCADE'); Box(1) = {0, 0, 0, 30, 20, 10};\n";
    let reach = |name: &str| format!("SystemCall 'touch {}';\n", dir.path(name).display());
    let model = |name: &str| dir.run(&format!("model {name} --unit mm -o model"));

    dir.write("calls.geo", &format!("{body}{}", reach("called")));
    let refused = model("calls.geo");
    refused.fails(2, "calls.geo: line 2: SystemCall runs programs");
    refused.fails(2, "--trust");
    assert!(!dir.path("called").exists());
    model("calls.geo --trust").says("Python of the meshers: ");
    assert!(dir.path("called").exists());

    // gmsh skips what an If leaves out without a look at quotes, and begins a line anew in a loop
    let hidden = reach("hidden");
    for escape in [
        format!("If (0)\nE// EndIf {hidden}\nEndIf\n"),
        format!("For (1:2) /*\n{hidden} */\nEndFor\n"),
        format!("If (0)\nE\" EndIf {} \"\nEndIf\n", hidden.trim()),
    ] {
        dir.write("escapes.geo", &format!("{body}{escape}"));
        model("escapes.geo"); // whether gmsh likes it or not
        assert!(!dir.path("hidden").exists(), "{escape}");
    }
    // gmsh reads options from a file beside the one that it opens
    dir.write("box.geo", body);
    dir.write("box.geo.opt", &reach("options"));
    model("box.geo").succeeds();
    assert!(!dir.path("options").exists());
    dir.write("broken.geo", &format!("{body}Sphere(1) = {{0,"));
    model("broken.geo").fails(2, "'broken.geo', line ");
}

/// Two boxes of 20 × 10 mm, 2 and 4 mm high, on each other.
const LAYERED: &str = r#"
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 20, 10, 2};
Box(2) = {0, 0, 2, 20, 10, 4};
BooleanFragments{ Volume{1, 2}; Delete; }{}
sheet() = Surface In BoundingBox{-0.1, -0.1, 1.9, 20.1, 10.1, 2.1};
skin() = CombinedBoundary{ Volume{:}; };
Physical Surface("sheet") = {sheet()};
Physical Surface("skin") = {skin()};
Physical Volume("floor") = {1};
Physical Volume("roof") = {2};
Mesh.MeshSizeMax = 3;
"#;

#[test]
fn surfaces_inside_are_facets_of_both_meshers() {
    let Some(dir) = Workdir::with(&["gmsh"]) else { return };
    dir.write("layered.geo", LAYERED);
    let made = dir.run("model layered.geo --unit mm -o model");
    made.succeeds();
    made.says("inside: cad2fem tetmesh --inside");
    let read = |name: &str| read_surface(&dir.path(&format!("model/{name}.stl"))).unwrap();
    // Binary STL rounds coordinates to 6e-8.
    assert!((area(&read("patches/sheet")) / 2e-4 - 1.0).abs() < 1e-6);
    assert!((enclosed_volume(&read("model")) / 1.2e-6 - 1.0).abs() < 1e-6);
    assert!((enclosed_volume(&read("volumes/floor")) / 4e-7 - 1.0).abs() < 1e-6);
    let below = |mesh: &TetMesh| {
        let in_floor = |t: &usize| mesh.corners(*t).iter().all(|p| p.z < 2.02e-3);
        let tets = (0..mesh.tets.len()).filter(in_floor).map(|t| mesh.tets[t]).collect();
        volume(&TetMesh { vertices: mesh.vertices.clone(), tets })
    };
    for mesher in ["gmsh", "ftetwild"] {
        if mesher == "ftetwild" && Workdir::with(&["ftetwild"]).is_none() {
            continue;
        }
        // The sheet, and the boundary of a part, most of which is on that of the body.
        for inside in ["model/patches/sheet.stl", "model/volumes/floor.stl"] {
            let mesh = "tetmesh model/model.stl -o out.msh --edge-length 0.003";
            dir.run(&format!("{mesh} --mesher {mesher} --inside {inside}")).succeeds();
            let tets = read_tets(&dir.path("out.msh")).unwrap().mesh;
            // the envelope of fTetWild, 0.02 mm, on the area of the sheet
            assert!((below(&tets) - 4e-7).abs() < 2e-4 * 2e-5, "{mesher}: {:e}", below(&tets));
        }
    }
    let across = "Box(1) = {5, 5, 1, 30, 30, 2}; Mesh.MeshSizeMax = 9;";
    dir.write("across.geo", &format!("SetFactory(\"OpenCASCADE\"); {across}"));
    dir.run("model across.geo --unit mm -o across").succeeds();
    dir.run("tetmesh model/model.stl --mesher gmsh -o never.msh --inside across/model.stl")
        .fails(2, "surfaces inside cross each other or the boundary");
}

/// A Python that has numpy and pytetwild and nothing else, as where wildmeshing has no wheel.
#[test]
fn pytetwild_takes_the_place_of_wildmeshing() {
    let Some(dir) = Workdir::with_pytetwild() else { return };
    let doctor = dir.run("doctor").stdout;
    assert!(doctor.contains("ok       fTetWild       pytetwild 0."), "{doctor}");
    let skin = Solid::cube(&Vec3::zeros(), &Vec3::new(0.02, 0.01, 0.01));
    let body = skin.difference(&Solid::sphere(&Vec3::new(0.006, 0.005, 0.005), 0.003, 24));
    write_surface(&dir.path("body.stl"), &body.to_surface()).unwrap();
    let beyond = Solid::cube(&Vec3::new(0.0124, -0.001, -0.001), &Vec3::new(0.021, 0.011, 0.011));
    write_surface(&dir.path("beyond.stl"), &beyond.to_surface()).unwrap();
    let ball = "refine = [{ center = [0.02, 0.01, 0.01], radius = 0.004, edge_length = 0.0006 }]";
    dir.write("plain.toml", "[tetmesh]\nmesher = 'ftetwild'\nedge_length = 0.002\n");
    dir.write(
        "ball.toml",
        &format!("[tetmesh]\nmesher = 'ftetwild'\nedge_length = 0.002\n{ball}\n"),
    );
    let made = |name: &str, options: &str| {
        dir.run(&format!("tetmesh body.stl -o {name}.msh --no-cache --config {options}"))
            .says("by ftetwild (pytetwild 0.");
        read_tets(&dir.path(&format!("{name}.msh"))).unwrap().mesh
    };
    let near = |mesh: &TetMesh| {
        let corner = Vec3::new(0.02, 0.01, 0.01);
        mesh.vertices.iter().filter(|&p| (p - corner).norm() < 0.004).count()
    };
    let (plain, fine) =
        (made("plain", "plain.toml --inside beyond.stl"), made("ball", "ball.toml"));
    assert!(near(&fine) > 8 * near(&plain), "{} {}", near(&fine), near(&plain));
    // the surface inside cuts no tetrahedron by more than the envelope
    let cut = |t: &usize| {
        let x = plain.corners(*t).map(|p| p.x - 0.0124);
        x.iter().any(|x| *x < -5e-5) && x.iter().any(|x| *x > 5e-5)
    };
    assert_eq!((0..plain.tets.len()).filter(cut).count(), 0);
    assert!((volume(&plain) / volume(&fine) - 1.0).abs() < 2e-3);
    // made twice, with the same bits
    assert_eq!(made("again", "ball.toml"), fine);
}

/// A skin and a chamber from two files, and the volume of a selection, which reaches out of the body.
#[test]
fn several_files_and_a_selection_go_to_the_mesher_together() {
    let Some(dir) = Workdir::with(&["ftetwild"]) else { return };
    let cuboid = |name: &str, low: [f64; 3], high: [f64; 3]| {
        let surface = Solid::cube(&Vec3::from(low), &Vec3::from(high)).to_surface();
        write_surface(&dir.path(name), &surface).unwrap();
    };
    cuboid("skin.stl", [0.0; 3], [0.02, 0.01, 0.01]);
    cuboid("chamber.stl", [0.004, 0.003, 0.003], [0.016, 0.007, 0.007]);
    cuboid("selection.stl", [0.0124, -0.001, -0.001], [0.021, 0.011, 0.011]);
    dir.run("tetmesh skin.stl chamber.stl --edge-length 0.002 -o out.msh --inside selection.stl")
        .succeeds();
    let tets = read_tets(&dir.path("out.msh")).unwrap().mesh;
    let expected = 2e-6 - 0.012 * 0.004 * 0.004;
    assert!((volume(&tets) / expected - 1.0).abs() < 1e-3, "{:e}", volume(&tets));
    // no tetrahedron is cut by the selection, but for the envelope
    let cut = |t: &usize| {
        let x = tets.corners(*t).map(|p| p.x - 0.0124);
        x.iter().any(|x| *x < -5e-5) && x.iter().any(|x| *x > 5e-5)
    };
    assert_eq!((0..tets.tets.len()).filter(cut).count(), 0);
    let report = dir.json("out.report.json");
    assert_eq!(report["shells"], 2);
    assert_eq!(report["input"][1]["path"], "chamber.stl");
    // one of them alone is no body
    cuboid("beside.stl", [0.018, 0.002, 0.002], [0.03, 0.008, 0.008]);
    dir.run("tetmesh skin.stl beside.stl -o never.msh")
        .fails(2, "skin.stl, beside.stl: it does not bound");
}
