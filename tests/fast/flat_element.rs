//! One element that is nearly flat does not end a level: the interior is re-meshed.

use mesh::Vec3;
use mesh::io::write_tets;
use serde_json::Value;
use solver::body::Body;
use tests::chamber::{DESIGN, SIM, workdir};
use tests::workdir::Workdir;
use tests::{block, tag};

/// 60 × 60 × 60 mm with a chamber of 40 × 20 × 20 mm, open at x = 0. An inner vertex lies 20 µm
/// off a facet of the chamber.
fn body_with_a_flat_element() -> Body {
    let middle = |i: usize| i == 2 || i == 3;
    let mesh = block([6, 6, 6], 0.01, |c| c[0] < 4 && middle(c[1]) && middle(c[2]), |p| p);
    let inner = |x: f64| x > 0.019 && x < 0.041;
    let mut body = tag(
        mesh,
        &[
            ("seat", &|p| p.x < 1e-6),
            ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z)),
            ("top", &|p| p.z > 0.06 - 1e-6),
            ("skin", &|_| true),
        ],
    );
    let boundary: Vec<usize> = body.boundary().iter().flatten().copied().collect();
    let facet = body
        .facets("cavity")
        .unwrap()
        .into_iter()
        .find(|facet| facet.iter().all(|&v| (0.015..0.035).contains(&body.mesh.vertices[v].x)));
    let facet = facet.unwrap();
    let apex = |tet: &&[usize; 4]| facet.iter().all(|v| tet.contains(v));
    let tet = *body.mesh.tets.iter().find(apex).unwrap();
    let apex = *tet.iter().find(|v| !facet.contains(v)).unwrap();
    assert!(!boundary.contains(&apex), "an inner vertex");
    let [a, b, c] = facet.map(|v| body.mesh.vertices[v]);
    let center = (a + b + c) / 3.0;
    let normal: Vec3 = (b - a).cross(&(c - a)).normalize();
    let inward = normal * normal.dot(&(body.mesh.vertices[apex] - center)).signum();
    body.mesh.vertices[apex] = center + 2e-5 * inward;
    body
}

fn folder() -> Workdir {
    let dir = workdir();
    let body = body_with_a_flat_element();
    assert_eq!(mesh::check::check_tets(&body.mesh).len(), 0, "nothing is inverted");
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    dir.write("p1.toml", &SIM.replace("degree = 2", "degree = 1"));
    let (first, rest) = DESIGN.split_once("[[shape.level]]").unwrap();
    let (_, terms) = rest.split_once("[[objective]]").unwrap();
    let level = "[[shape.level]]\nvertices = true\niterations = 4\n\n[[objective]]";
    let design = format!("{first}{level}{terms}").replace("sim.toml", "p1.toml");
    dir.write("design.toml", &design.replace("minimum = 2e-3", "minimum = 1e-3"));
    dir
}

#[test]
fn a_flat_element_is_meshed_away_and_the_level_goes_on() {
    let dir = folder();
    let run = dir.solver("optimize design.toml -o out");
    run.assert_good();
    eprintln!("{}", run.stderr);
    let history = dir.text("out/history.jsonl");
    let lines: Vec<Value> = history.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let iterations: Vec<u64> =
        lines.iter().map(|line| line["iteration"].as_u64().unwrap()).collect();
    // the first two steps are short, and on the new mesh the shape that they led to comes again
    assert_eq!(iterations, [0, 1, 2, 2, 3, 4], "{}", run.stderr);
    assert!(dir.path("out/remeshed-1-2.msh").exists());
    let motion = |i: usize| lines[i]["motion_m"].as_f64().unwrap();
    assert!(motion(4) > 10.0 * motion(2), "{} and {}", motion(2), motion(4));
    let volume = |file: &str| {
        let mesh = mesh::io::read_tets(&dir.path(file)).unwrap().mesh;
        mesh.tets
            .iter()
            .map(|t| {
                let [a, b, c, d] = t.map(|v| mesh.vertices[v]);
                mesh::measure::tet_volume(a, b, c, d)
            })
            .fold(f64::INFINITY, f64::min)
    };
    assert!(volume("out/remeshed-1-2.msh") > 20.0 * volume("body.msh"));
}
