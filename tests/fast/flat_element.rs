//! Elements that are nearly flat do not end a level: the interior is re-meshed, and the surface that
//! moves where they lie along it.

use mechanics::body::Body;
use mesh::Vec3;
use tests::chamber::{DESIGN, SIM, workdir};
use tests::workdir::Workdir;
use tests::{block, tag};

/// 60 × 60 × 60 mm with a chamber of 40 × 20 × 20 mm, open at x = 0.
fn hollow(distort: impl Fn(Vec3) -> Vec3) -> Body {
    let middle = |i: usize| i == 2 || i == 3;
    let mesh = block([6, 6, 6], 0.01, |c| c[0] < 4 && middle(c[1]) && middle(c[2]), distort);
    let inner = |x: f64| x > 0.019 && x < 0.041;
    tag(
        mesh,
        &[
            ("seat", &|p| p.x < 1e-6),
            ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z)),
            ("top", &|p| p.z > 0.06 - 1e-6),
            ("skin", &|_| true),
        ],
    )
}

/// An inner vertex lies 20 µm off a facet of the chamber.
fn body_with_a_flat_element() -> Body {
    let mut body = hollow(|p| p);
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

/// The same body without it, where the vertices of the chamber's wall at x = 20 mm lie 0.4 mm from
/// those at 10 mm: a ring of needles.
fn body_with_needles() -> Body {
    hollow(|p| {
        let depth = p.y.min(0.06 - p.y).min(p.z).min(0.06 - p.z);
        let at_ring = f64::from((p.x - 0.02).abs() < 1e-6);
        p - Vec3::x() * 0.0096 * at_ring * (depth / 0.02).clamp(0.0, 1.0)
    })
}

fn folder(body: &Body) -> Workdir {
    let dir = workdir();
    assert_eq!(mesh::check::check_tets(&body.mesh).len(), 0, "nothing is inverted");
    dir.put("body.msh", body);
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
    let dir = folder(&body_with_a_flat_element());
    let run = dir.solver("optimize design.toml -o out");
    run.assert_good();
    let lines = dir.lines("out/history.jsonl");
    let iterations: Vec<u64> =
        lines.iter().map(|line| line["iteration"].as_u64().unwrap()).collect();
    // the first two steps are short, and on the new mesh the shape that they led to comes again
    assert_eq!(iterations, [0, 1, 2, 2, 3, 4], "{}", run.stderr);
    assert!(dir.path("out/remeshed-1-2.msh").exists());
    let motion = |i: usize| lines[i]["motion_m"].as_f64().unwrap();
    assert!(motion(4) > 10.0 * motion(2), "{} and {}", motion(2), motion(4));
    let volume = |file: &str| {
        let mesh = mesh::io::read_tets(&dir.path(file)).unwrap().mesh;
        (0..mesh.tets.len()).map(|t| mesh.volume(t)).fold(f64::INFINITY, f64::min)
    };
    assert!(volume("out/remeshed-1-2.msh") > 20.0 * volume("body.msh"));
}

/// Facets of a tag and their area [m²].
fn tagged(dir: &Workdir, file: &str, name: &str) -> (usize, f64) {
    let file = mesh::io::read_tets(&dir.path(file)).unwrap();
    let facets = file.tags.facets_of(file.tags.id(name).unwrap());
    let corners = facets.iter().map(|f| f.map(|v| file.mesh.vertices[v]));
    (facets.len(), corners.map(|[a, b, c]| mesh::measure::triangle_area(a, b, c)).sum())
}

#[test]
fn needles_of_the_surface_that_moves_are_meshed_away_and_the_rest_stays() {
    let dir = folder(&body_with_needles());
    let design = dir.text("design.toml");
    let level = "[[shape.level]]\nvertices = true\niterations = 4\n";
    let two = format!("{}{}", level.replace('4', "1"), level.replace('4', "2"));
    dir.write("design.toml", &design.replace(level, &two));
    let kept = two.replacen("[[shape", "surface_tolerance = 0\n\n[[shape", 1);
    dir.write("kept.toml", &design.replace(level, &kept));

    let run = dir.solver("optimize design.toml -o out");
    run.assert_says(&["re-meshed the surface: "]);
    let [before, after] = ["level-1", "level-2"].map(|at| format!("out/{at}.msh"));
    let (many, area) = tagged(&dir, &before, "cavity");
    let (fewer, new) = tagged(&dir, &after, "cavity");
    assert!(fewer < many, "{fewer} of {many} facets");
    assert!((new / area - 1.0).abs() < 0.02, "{new} of {area} m²");
    for name in ["seat", "top", "skin"] {
        let (old, new) = (tagged(&dir, &before, name), tagged(&dir, &after, name));
        assert_eq!(old.0, new.0, "{name}");
        assert!((old.1 / new.1 - 1.0).abs() < 1e-12, "{name}");
    }
    let objectives = |folder: &str| -> Vec<f64> {
        let lines = dir.lines(&format!("{folder}/history.jsonl"));
        lines.iter().map(|line| line["objective"].as_f64().unwrap()).collect()
    };
    let with = objectives("out");
    // 0.05 mean edges are 0.4 mm of a wall of 20 mm
    assert!((with[2] / with[1] - 1.0).abs() < 0.1, "the same shape on another mesh: {with:?}");
    assert_eq!(with.len(), 5, "{}", run.stderr);

    let run = dir.solver("optimize kept.toml -o kept");
    run.assert_good();
    assert!(!run.stderr.contains("re-meshed the surface"), "{}", run.stderr);
    let without = objectives("kept");
    assert!(with[4] < without[4], "{with:?} {without:?}");
    dir.write("bad.toml", &dir.text("kept.toml").replace("tolerance = 0", "tolerance = -1e-4"));
    dir.solver("optimize bad.toml -o bad").assert_refused(
        2,
        &["bad.toml", "surface_tolerance = -0.0001 m: must be finite and not negative"],
    );
}

#[test]
fn a_surface_is_remeshed_by_a_program_alone() {
    let dir = folder(&body_with_needles());
    dir.run("cad2fem", "remesh body.msh --surface cavity --tolerance 1e-3 -o better.msh")
        .assert_says(&["1.0000 mm allowed"]);
    assert!(tagged(&dir, "better.msh", "cavity").0 < tagged(&dir, "body.msh", "cavity").0);
    assert_eq!(tagged(&dir, "better.msh", "skin").0, tagged(&dir, "body.msh", "skin").0);
    dir.run("cad2fem", "remesh body.msh --surface hole -o none.msh")
        .assert_refused(2, &["body.msh: no tag `hole`; the mesh has: seat, cavity, top, skin"]);
}
