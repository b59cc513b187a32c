//! Bodies of others: units, Booleans, repair, CAD.

#![allow(clippy::unwrap_used)]

use std::fs;

use crate::support::Workdir;
use mesh::check::check_surface;
use mesh::io::{read_surface, write_surface};
use mesh::measure::{area, bounds, diagonal, enclosed_volume};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

/// A box from the origin.
fn block(x: f64, y: f64, z: f64) -> SurfaceMesh {
    Solid::cube(&Vec3::zeros(), &Vec3::new(x, y, z)).to_surface()
}

fn joined(mut a: SurfaceMesh, b: &SurfaceMesh) -> SurfaceMesh {
    a.append(b);
    a
}

fn moved(mut surface: SurfaceMesh, by: Vec3) -> SurfaceMesh {
    surface.vertices.iter_mut().for_each(|v| *v += by);
    surface
}

/// The sound surface of `out`, its volume [mm³], and the names of its patches.
fn result(dir: &Workdir) -> (SurfaceMesh, f64, Vec<String>) {
    let surface = read_surface(&dir.path("out/model.stl")).unwrap();
    assert_eq!(check_surface(&surface), vec![]);
    let entries = fs::read_dir(dir.path("out/patches")).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().replace(".stl", "")).collect();
    names.sort();
    let patches = names.iter().map(|name| format!("out/patches/{name}.stl"));
    let total: f64 = patches.map(|name| area(&read_surface(&dir.path(&name)).unwrap())).sum();
    assert!((total / area(&surface) - 1.0).abs() < 1e-6, "patches do not cover the surface");
    let volume = enclosed_volume(&surface) * 1e9;
    (surface, volume, names)
}

#[test]
fn the_unit_is_guessed_and_said_or_asked_for() {
    let dir = Workdir::new();
    let put = |name: &str, size: f64| {
        write_surface(&dir.path(name), &block(size, size, size)).unwrap();
    };
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{a} is not {b}");
    let size = || diagonal(&result(&dir).0.vertices) / 3.0_f64.sqrt();
    put("mm.stl", 80.0);
    dir.run("import mm.stl -o out").says("taken for mm, 138.5641 mm");
    close(size(), 0.08);
    put("m.obj", 0.08);
    dir.run("import m.obj -o out").says("taken for m, 138.5641 mm");
    close(size(), 0.08);
    dir.run("import m.obj -o out --unit inch").says("in inch as --unit says");
    close(size(), 0.08 * 25.4e-3);
    put("either.ply", 1.5);
    let run = dir.run("import either.ply -o never");
    run.fails(2, "2.598 m as metres, 2.598 mm as millimetres, 65.991 mm as inches");
    // a small chamber has the unit of its body
    put("small.stl", 2.0);
    dir.run("import mm.stl --subtract small.stl -o out").succeeds();
    close(result(&dir).1, 512e3 - 8.0);
    // the mesher asks, too
    dir.run("tetmesh mm.stl -o out.msh").fails(2, "138.564 mm as millimetres");
    dir.run("offset mm.stl -o out.obj").fails(2, "pass --unit");
    dir.run("offset mm.stl --unit mm -o out.obj").says("distance 0.1386 mm");
    assert!(!dir.path("never").exists());
}

#[test]
fn bodies_are_combined_turned_and_scaled() {
    let dir = Workdir::new();
    write_surface(&dir.path("body.stl"), &block(40.0, 20.0, 10.0)).unwrap();
    write_surface(&dir.path("lug.stl"), &moved(block(10.0, 20.0, 10.0), Vec3::new(35.0, 0.0, 5.0)))
        .unwrap();
    let chamber = |x: f64| moved(block(10.0, 10.0, 4.0), Vec3::new(x, 5.0, 3.0));
    write_surface(&dir.path("left.stl"), &chamber(5.0)).unwrap();
    write_surface(&dir.path("right.stl"), &chamber(20.0)).unwrap();
    let all = "import body.stl lug.stl -o out --subtract left.stl right.stl";
    dir.run(all).says("right.stl subtracted: 0.4000 cm3 less");
    let (_, volume, names) = result(&dir);
    // 40·20·10 + 10·20·10 − 5·20·5 that both have − 2·10·10·4
    assert!((volume / (8000.0 + 2000.0 - 500.0 - 800.0) - 1.0).abs() < 1e-6, "{volume}");
    assert_eq!(names, ["body", "left", "lug", "right"]);

    dir.run(&format!("{all} --scale 2 --turn z=90 --move -0.01,0,0.003")).succeeds();
    let (surface, bigger, _) = result(&dir);
    assert!((bigger / volume / 8.0 - 1.0).abs() < 1e-6);
    let (low, high) = bounds(&surface.vertices);
    let expected = [Vec3::new(-0.05, 0.0, 0.003), Vec3::new(-0.01, 0.09, 0.033)];
    assert!((low - expected[0]).amax().max((high - expected[1]).amax()) < 1e-8, "{low} {high}");

    dir.run("import body.stl -o out --split 40").succeeds();
    assert_eq!(result(&dir).2, ["outer-1", "outer-2", "outer-3", "outer-4", "outer-5", "outer-6"]);
    write_surface(&dir.path("far.stl"), &moved(block(1.0, 1.0, 1.0), Vec3::repeat(90.0))).unwrap();
    dir.run("import body.stl --subtract far.stl -o out")
        .fails(2, "far.stl: it does not meet the body");
}

#[test]
fn a_chamber_that_is_there_already_is_told() {
    let dir = Workdir::new();
    let body = Solid::cube(&Vec3::zeros(), &Vec3::new(40.0, 20.0, 10.0));
    // closed, and open at a side, through which the air that is subtracted reaches
    for (x, there) in [(5.0, 8), (-5.0, 4)] {
        let low = Vec3::new(x, 5.0, 3.0);
        let air = Solid::cube(&low, &(low + Vec3::new(10.0, 10.0, 4.0)));
        write_surface(&dir.path("air.stl"), &air.to_surface()).unwrap();
        write_surface(&dir.path("body.stl"), &body.difference(&air).to_surface()).unwrap();
        let told = format!("air.stl: the body has this chamber already: {there} of its 8 vertices");
        dir.run("import body.stl --subtract air.stl -o never").fails(2, &told);
    }
}

#[test]
fn shells_inside_are_cavities_and_shells_that_cross_are_united() {
    let dir = Workdir::new();
    let inner = moved(block(20.0, 10.0, 4.0), Vec3::new(5.0, 5.0, 3.0));
    write_surface(&dir.path("hollow.stl"), &joined(block(40.0, 20.0, 10.0), &inner)).unwrap();
    dir.run("import hollow.stl -o out").succeeds();
    let (_, volume, names) = result(&dir);
    assert!((volume / 7200.0 - 1.0).abs() < 1e-6, "{volume}");
    assert_eq!(names, ["cavity", "outer"]);

    let other = moved(block(40.0, 20.0, 10.0), Vec3::new(30.0, 3.0, 2.0));
    write_surface(&dir.path("crossing.stl"), &joined(block(40.0, 20.0, 10.0), &other)).unwrap();
    let united = 16000.0 - 10.0 * 17.0 * 8.0;
    // of every shell twice, one counts
    let crossing = joined(block(40.0, 20.0, 10.0), &other);
    write_surface(&dir.path("doubled.stl"), &joined(crossing.clone(), &crossing)).unwrap();
    for file in ["crossing.stl", "doubled.stl"] {
        dir.run(&format!("import {file} -o out --no-repair")).says("2 shells that cross");
        let (_, volume, _) = result(&dir);
        assert!((volume / united - 1.0).abs() < 1e-6, "{file}: {volume}");
    }
    // one that has an edge of the first, and is turned about it by 30°
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let mut turned = moved(block(40.0, 20.0, 10.0), Vec3::new(0.0, 0.0, -10.0));
    for p in &mut turned.vertices {
        *p = Vec3::new(p.x, cos * p.y - sin * p.z, 10.0 + sin * p.y + cos * p.z);
    }
    let solid = |surface: &SurfaceMesh| Solid::from_surface(surface).unwrap();
    let united = solid(&block(40.0, 20.0, 10.0)).union(&solid(&turned)).volume();
    write_surface(&dir.path("edge.stl"), &joined(block(40.0, 20.0, 10.0), &turned)).unwrap();
    dir.run("import edge.stl -o out --no-repair").says("2 shells that cross");
    let (_, volume, _) = result(&dir);
    assert!((volume / united - 1.0).abs() < 1e-6, "{volume}");
}

#[test]
fn a_torn_surface_is_welded_and_a_broken_one_is_remade() {
    let dir = Workdir::new();
    let ball = Solid::sphere(&Vec3::zeros(), 20.0, 48).to_surface();
    let exact = enclosed_volume(&ball);
    // every triangle has corners of its own, up to 0.2 µm beside those of others
    let mut torn = SurfaceMesh::default();
    for t in 0..ball.triangles.len() {
        let shift = Vec3::repeat(1e-4 * (t % 3) as f64);
        torn.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
        torn.vertices.extend(ball.corners(t).map(|p| p + shift));
    }
    write_surface(&dir.path("torn.ply"), &torn).unwrap();
    dir.run("import torn.ply -o out --no-repair").says("open edges, now 0");
    assert!((result(&dir).1 / exact - 1.0).abs() < 1e-4);

    let mut open = ball.clone();
    open.triangles.drain(100..104);
    write_surface(&dir.path("open.stl"), &open).unwrap();
    dir.run("import open.stl -o never --no-repair").fails(1, "single triangle");
    dir.run("import open.stl -o never --unit mm --scale 0").fails(2, "must be positive");
    dir.run("import open.stl -o never --unit mm --move 1,oops,2,3")
        .fails(2, "three numbers with commas");
    let flat = SurfaceMesh { triangles: open.triangles[..1].to_vec(), ..open.clone() };
    write_surface(&dir.path("flat.stl"), &flat).unwrap();
    dir.run("import flat.stl --unit mm -o never").fails(1, "which is no body");
    assert!(!dir.path("never").exists());

    let Some(dir) = dir.with_python("ftetwild") else { return };
    // one vertex is pushed through the far side
    let mut pierced = open;
    let top = (0..pierced.vertices.len())
        .max_by(|&a, &b| pierced.vertices[a].z.total_cmp(&pierced.vertices[b].z))
        .unwrap();
    pierced.vertices[top] = Vec3::new(0.5, 0.3, -21.0);
    write_surface(&dir.path("broken.stl"), &pierced).unwrap();
    dir.run("import broken.stl -o out").says("remade by fTetWild");
    let (surface, volume, _) = result(&dir);
    // the spike takes off a cone at the top; the envelope is a thousandth of the diagonal
    let lost = enclosed_volume(&pierced) - volume;
    let allowed = area(&surface) * 1e6 * 1e-3 * 69.3;
    assert!(lost.abs() < allowed, "{lost} mm3, {allowed} allowed");
    let report = dir.json("out/model.json");
    assert_eq!(report["import"]["files"][0]["unit_is"], "guessed");
    let changes = report["import"]["changes"].to_string();
    assert!(changes.contains("3 holes filled") && changes.contains("remade"), "{changes}");
}

/// Makes a box of 30 by 20 by 10 mm in three formats.
const BOX: &str = "
import gmsh
gmsh.initialize()
gmsh.option.setNumber('General.Terminal', 0)
gmsh.model.occ.addBox(0, 0, 0, 30, 20, 10)
gmsh.model.occ.synchronize()
for end in ('step', 'brep', 'iges'):
    gmsh.write('box.' + end)
";

/// The STEP file with a name for its first face and red for the next two.
fn marked(step: &str) -> String {
    let number = |line: &str| line[1..].split(' ').next().unwrap().to_owned();
    let faces: Vec<String> =
        step.lines().filter(|l| l.contains("ADVANCED_FACE")).map(number).collect();
    let context = step.lines().find(|l| l.contains("GEOMETRIC_REPRESENTATION_CONTEXT")).unwrap();
    let mut added = "#9001 = COLOUR_RGB('',1.,0.,0.);\n\
                     #9002 = FILL_AREA_STYLE_COLOUR('',#9001);\n\
                     #9003 = FILL_AREA_STYLE('',(#9002));\n\
                     #9004 = SURFACE_STYLE_FILL_AREA(#9003);\n\
                     #9005 = SURFACE_SIDE_STYLE('',(#9004));\n\
                     #9006 = SURFACE_STYLE_USAGE(.BOTH.,#9005);\n\
                     #9007 = PRESENTATION_STYLE_ASSIGNMENT((#9006));\n"
        .to_owned();
    added += &format!("#9008 = STYLED_ITEM('color',(#9007),#{});\n", faces[1]);
    added += &format!("#9009 = STYLED_ITEM('color',(#9007),#{});\n", faces[2]);
    added += &format!(
        "#9010 = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#9008,#9009),#{});\n",
        number(context)
    );
    let named = step.replacen("ADVANCED_FACE(''", "ADVANCED_FACE('the seat'", 1);
    named.replacen("ENDSEC;\nEND-ISO", &format!("{added}ENDSEC;\nEND-ISO"), 1)
}

#[test]
fn cad_files_keep_units_names_and_colours_of_faces() {
    let Some(dir) = Workdir::with(&["gmsh"]) else { return };
    dir.script(BOX);
    for (file, said) in [
        ("box.step", "the file states its unit"),
        ("box.iges", "the file states its unit"),
        ("box.brep", "taken for mm"),
    ] {
        dir.run(&format!("import {file} -o out")).says(said);
        let (_, volume, names) = result(&dir);
        assert!((volume / 6000.0 - 1.0).abs() < 1e-6, "{file}: {volume}");
        assert_eq!(names.len(), 6, "{file}: {names:?}");
    }
    dir.run("import box.step -o out --unit mm").fails(2, "states its unit");

    let step = fs::read_to_string(dir.path("box.step")).unwrap();
    dir.write("marked.step", &marked(&step));
    dir.run("import marked.step -o out").succeeds();
    let (_, _, names) = result(&dir);
    assert_eq!(names, ["color-ff0000", "face-4", "face-5", "face-6", "the-seat"]);
    let seat = read_surface(&dir.path("out/patches/the-seat.stl")).unwrap();
    // gmsh writes the face x = 0 first
    assert!(seat.vertices.iter().all(|v| v.x == 0.0), "another face is called seat");

    // a script reads the file in the unit of its own numbers
    dir.write("reads.geo", "SetFactory(\"OpenCASCADE\"); a() = ShapeFromFile(\"box.step\");\n");
    dir.run("model reads.geo --unit mm --trust -o out").succeeds();
    assert!((result(&dir).1 / 6000.0 - 1.0).abs() < 1e-6);

    // a plane face whose rim crosses itself
    let bow = "Point(1) = {0, 0, 0, 1}; Point(2) = {10, 10, 0, 1}; Point(3) = {10, 0, 0, 1};\n\
               Point(4) = {0, 10, 0, 1}; Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4};\n\
               Line(4) = {4, 1}; Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(7) = {1};\n\
               Physical Surface(\"lid\") = {7};\n";
    dir.write("bow.geo", bow);
    dir.run("model bow.geo --unit mm -o out").fails(2, "face 7 (from 0 0 0 to 10 10 0)");
}

/// A ball of 20 mm; a plate with fillets of 0.4 mm, once more in a file without a unit.
const ROUND: &str = "
import gmsh
gmsh.initialize()
gmsh.option.setNumber('General.Terminal', 0)
gmsh.model.occ.addSphere(0, 0, 0, 20)
gmsh.model.occ.synchronize()
gmsh.write('ball.step')
gmsh.clear()
box = gmsh.model.occ.addBox(0, 0, 0, 60, 40, 8)
gmsh.model.occ.fillet([box], list(range(1, 13)), [0.4])
gmsh.model.occ.synchronize()
gmsh.write('plate.step')
gmsh.write('plate.brep')
";

/// The longest edges of a surface, up to a part of them [mm].
fn longest_edges(surface: &SurfaceMesh, part: f64) -> f64 {
    let edge = |t: usize| {
        let [a, b, _] = surface.corners(t);
        (b - a).norm() * 1e3
    };
    let mut all: Vec<f64> = (0..surface.triangles.len()).map(edge).collect();
    all.sort_by(f64::total_cmp);
    all[(part * (all.len() - 1) as f64) as usize]
}

#[test]
fn triangles_follow_curved_faces_of_cad_and_are_long_on_flat_ones() {
    let Some(dir) = Workdir::with(&["gmsh"]) else { return };
    dir.script(ROUND);
    let stated = || dir.json("out/model.json")["chord_error"].as_f64().unwrap() * 1e3;
    // how far the middles of the ball's triangles and of their edges are from it [mm], and how many there are
    let ball = |chord: &str| {
        dir.run(&format!("import ball.step -o out {chord}"))
            .says("mm from the faces that they stand for");
        let (surface, _, _) = result(&dir);
        let off = |t: usize| {
            let [a, b, c] = surface.corners(t);
            let middles = [surface.centroid(t), (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            middles.iter().map(|p| 20.0 - p.norm() * 1e3).fold(0.0, f64::max)
        };
        let count = surface.triangles.len();
        ((0..count).map(off).fold(0.0, f64::max), count)
    };
    let (off, count) = ball("");
    assert!(off < 0.02 && stated() < 0.02, "{off} {}", stated());
    assert!((stated() - off).abs() < 1e-4, "{} is not {off}", stated());
    let (_, coarse) = ball("--chord 8e-5 --scale 2");
    assert!(stated() > 0.08 && stated() < 0.16, "{}", stated());
    assert!(3 * coarse < count && count < 6 * coarse, "{count} {coarse}");

    dir.run("import plate.brep -o out").succeeds();
    let (surface, volume, names) = result(&dir);
    assert!(stated() < 0.02, "{}", stated());
    assert!((volume / 19200.0 - 1.0).abs() < 5e-3, "{volume}");
    assert_eq!(names.len(), 26, "{names:?}");
    // edges of the fillets of 0.4 mm are shorter than 0.3 mm, of the flat faces ten times as long
    let edges = [0.02, 1.0].map(|part| longest_edges(&surface, part));
    assert!(edges[0] < 0.3 && edges[1] > 3.0, "{edges:?}");
    assert!(surface.triangles.len() < 20_000, "{}", surface.triangles.len());
    dir.run("import plate.step --chord 1e-9 -o never")
        .fails(2, "triangles for a chord error of 1e-06 mm");
    assert!(!dir.path("never").exists());
}

/// A body of 40 by 20 by 10 mm and air in two solids: `inside.step` with the air strictly inside, and
/// `open.step`, where it sticks out at x = 0.
const TWO: &str = "
import gmsh
gmsh.initialize()
gmsh.option.setNumber('General.Terminal', 0)
for name, x in (('inside', 5), ('open', -5)):
    gmsh.clear()
    gmsh.model.occ.addBox(0, 0, 0, 40, 20, 10)
    gmsh.model.occ.addBox(x, 5, 3, 30, 10, 4)
    gmsh.model.occ.synchronize()
    gmsh.write(name + '.step')
";

#[test]
fn of_two_solids_the_air_is_found_or_asked_for() {
    let Some(dir) = Workdir::with(&["gmsh"]) else { return };
    dir.script(TWO);
    // solids get names as a CAD program gives them
    let step = fs::read_to_string(dir.path("open.step")).unwrap();
    // and the face in which the air opens, too
    let step = step.replacen("ADVANCED_FACE(''", "ADVANCED_FACE('seat'", 1);
    let named = step.replacen("MANIFOLD_SOLID_BREP(''", "MANIFOLD_SOLID_BREP('finger'", 1);
    dir.write(
        "open.step",
        &named.replacen("MANIFOLD_SOLID_BREP(''", "MANIFOLD_SOLID_BREP('air'", 1),
    );
    for verb in ["model", "import"] {
        dir.run(&format!("{verb} inside.step -o out")).says(
            "solid 2 of 1.200 cm3, from 5.0, 5.0, 3.0 to 35.0, 15.0, 7.0 mm lies inside solid 1",
        );
        assert!((result(&dir).1 / 6800.0 - 1.0).abs() < 1e-6);
        let asked = dir.run(&format!("{verb} open.step -o never"));
        asked
            .fails(2, "solid 1 \"finger\" of 8.000 cm3, from 0.0, 0.0, 0.0 to 40.0, 20.0, 10.0 mm");
        let command = format!("cad2fem {verb} open.step -o never --subtract air");
        asked.fails(2, &format!("take it out of the others: {command}"));
        dir.run(&format!("{verb} open.step -o out --subtract air")).succeeds();
        let (_, volume, names) = result(&dir);
        assert!((volume / 7000.0 - 1.0).abs() < 1e-6, "{volume}");
        let walls = names.iter().filter(|name| name.starts_with("air-")).count();
        assert_eq!((walls, names.len()), (5, 11), "{names:?}");
        assert!(names.contains(&"seat".to_owned()), "{names:?}");
        dir.run(&format!("{verb} open.step -o never --subtract 3"))
            .fails(2, "--subtract 3: there is no such file or solid; the solids of open.step are 1 'finger', 2 'air'");
    }
    dir.run("pick open.step -o never.html")
        .fails(2, "take it out of the others: cad2fem pick open.step -o never.html --subtract air");
    dir.run("pick inside.step -o pick.html").says("12 faces, closed chambers: 1");
    dir.run("import open.step -o out --unite").succeeds();
    assert!((result(&dir).1 / 8200.0 - 1.0).abs() < 1e-6);
    write_surface(&dir.path("box.stl"), &block(40.0, 20.0, 10.0)).unwrap();
    dir.run("import box.stl -o never --subtract air").fails(2, "--subtract air");
    assert!(!dir.path("never").exists());
}

#[test]
fn printed_files_state_their_unit() {
    let Some(dir) = Workdir::with(&["trimesh"]) else { return };
    let write = "import trimesh; trimesh.creation.box((30, 20, 10)).export('box.3mf')";
    dir.script(write);
    dir.run("import box.3mf -o out").says("the file states its unit");
    assert!((result(&dir).1 / 6000.0 - 1.0).abs() < 1e-6);
    dir.run("import box.3mf -o out --unit m").fails(2, "leave out --unit");
}

#[test]
fn the_boundary_of_a_mesh_comes_with_a_patch_for_each_tag() {
    let dir = Workdir::new();
    // a block of 40 mm in millimetres, about a point in its middle
    let skin = block(40.0, 30.0, 20.0);
    let mut vertices = skin.vertices.clone();
    vertices.push(Vec3::new(20.0, 15.0, 10.0));
    let apex = vertices.len() - 1;
    let tets = skin.triangles.iter().map(|&[a, b, c]| [a, c, b, apex]).collect();
    let mut tags = mesh::Tags::new(vec!["floor".into(), "none".into()]);
    let low = |t: &&[usize; 3]| t.iter().all(|&v| skin.vertices[v].z < 1e-9);
    skin.triangles.iter().filter(low).for_each(|&t| tags.set(t, 1));
    mesh::io::write_tets(&dir.path("in.msh"), &mesh::TetMesh { vertices, tets }, &tags).unwrap();
    dir.run("import in.msh -o out").says("taken for mm");
    let (surface, volume, patches) = result(&dir);
    assert_eq!(surface.triangles.len(), 12);
    assert_eq!(patches, ["floor", "rest"]);
    assert!((volume - 24e3).abs() < 1e-6 * 24e3, "{volume} mm³");
}
