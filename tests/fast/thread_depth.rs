//! Threads at a depth below a tag: where they lie, derivatives, and what is refused.

use mesh::io::write_tets;
use mesh::{Vec3, facet_key, topology};
use tests::chamber::VOLUME_DESIGN;
use tests::workdir::Workdir;
use tests::{block, chamber, tag};

const WINDING: &str = r#"
[[probe]]
name = "air"
kind = "volume"
on = "cavity"

[[winding]]
name = "thread"
on = "side"
depth = 5e-3
around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }
pitch = 0.02
start = 0.004
end = 0.046
double = true
stiffness = 50
"#;

/// A chamber with walls of 10 mm in cells of 5 mm: its long outer faces are `side`, and `inner` is 5 mm below them,
/// inside the walls.
fn workdir(tables: &str) -> Workdir {
    let dir = chamber::workdir();
    let middle = |i: usize| (2..6).contains(&i);
    let hollow = |c: [usize; 3]| c[0] < 8 && middle(c[1]) && middle(c[2]);
    let mesh = block([10, 8, 8], 0.005, hollow, |p| p);
    let within = |x: f64| x > 0.009 && x < 0.031;
    let mut body = tag(
        mesh,
        &[
            ("seat", &|p| p.x < 1e-6),
            ("cavity", &|p| p.x < 0.041 && within(p.y) && within(p.z)),
            ("tip", &|p| p.x > 0.05 - 1e-6),
            ("side", &|_| true),
        ],
    );
    body.tags.names.push("inner".to_owned());
    let id = body.tags.id("inner").unwrap();
    let is_inner = |facet: &[usize; 3]| {
        let x = facet.map(|v| body.mesh.vertices[v]);
        let from_axis = |x: &Vec3| (x.y - 0.02).abs().max((x.z - 0.02).abs());
        let flat = |k: usize| x.iter().all(|p| p[k] == x[0][k]) && (x[0][k] - 0.02).abs() > 0.014;
        x.iter().all(|x| (from_axis(x) - 0.015).abs() < 1e-9) && (flat(1) || flat(2))
    };
    let facets =
        body.mesh.tets.iter().flat_map(|tet| topology::TET_FACETS.map(|f| f.map(|c| tet[c])));
    for facet in facets.map(facet_key).filter(is_inner) {
        body.tags.set(facet, id);
    }
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    dir.write("p1.toml", &(dir.text("p1.toml") + tables));
    dir.write("sim.toml", &(dir.text("sim.toml") + tables));
    dir
}

/// With vertices at the depth, the thread lies where it does on a tag there. Threshold, set before: 1e-9.
#[test]
fn a_thread_below_a_tag_is_one_on_a_tag_inside() {
    let below = workdir(WINDING);
    let on = workdir(&WINDING.replace("\"side\"\ndepth = 5e-3", "\"inner\""));
    for scene in ["p1.toml", "sim.toml"] {
        let run = below.solver(&format!("simulate {scene} -o out"));
        run.assert_good();
        assert!(run.stderr.contains("winding thread 5.000 mm below side: helix"), "{}", run.stderr);
        on.solver(&format!("simulate {scene} -o out")).assert_good();
        let [own, other] = [&below, &on].map(|dir| dir.json("out/report.json"));
        for key in ["length", "turns", "mean_force", "axial_force", "energy"] {
            let [own, other] = [&own, &other].map(|r| r["windings"][0][key].as_f64().unwrap());
            assert!((own / other - 1.0).abs() < 1e-9, "{scene} {key}: {own} {other}");
        }
        let [own, other] = [&below, &on].map(|dir| dir.probe("out", "air"));
        assert!((own / other - 1.0).abs() < 1e-9, "{own} {other}");
    }
}

/// Half a cell below the tag, where no facets are: around a square of 35 mm, of which the cells at the edges cut off
/// corners with legs of half a cell, at most.
#[test]
fn a_thread_between_vertices_has_its_length_and_its_gradients() {
    let dir = workdir(
        &(WINDING.replace("5e-3", "2.5e-3") + "slack = 0.1\npretension = 0.5\nphase = 10\n"),
    );
    dir.solver("simulate p1.toml -o out").assert_good();
    let row = dir.json("out/report.json")["windings"][0].clone();
    let turn = |corners: f64| 4.2 * (0.14 - corners * (2.0 - 2.0_f64.sqrt()) * 2.5e-3).hypot(0.02);
    let length = row["length"].as_f64().unwrap();
    assert!((turn(4.0)..turn(0.0)).contains(&length), "{row}");
    dir.write("design.toml", VOLUME_DESIGN);
    let run = dir.solver("check design.toml --random 1");
    run.assert_good();
    assert!(run.stdout.contains("by winding.thread, "), "{}", run.stdout);
}

#[test]
fn depths_that_cannot_be_used_are_refused() {
    for (from, to, words) in [
        ("5e-3", "0", &["depth = 0 m", "without depth the thread lies on the tag"][..]),
        ("5e-3", "0.03", &["depth = 0.03 m", "the deepest vertex is 2.0000e-2 m below"]),
        ("5e-3", "1e-12", &["the mesh is too coarse for a layer", "a depth above", "no depth"]),
        ("\"side\"", "\"inner\"", &["\"inner\" has no facet on the boundary"]),
        ("end = 0.046", "end = 0.08", &["0.005 m below \"side\": it leaves the facets", "% of"]),
    ] {
        let dir = workdir(&WINDING.replace(from, to));
        let run = dir.solver("simulate p1.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["p1.toml"]);
    }
}
