//! `[[material]]`: volumes of a mesh with laws of their own, in scenes, error bars, scenarios and designs.

use mesh::io::{MshFile, read_tets, write_tets};
use mesh::topology::TET_FACETS;
use mesh::{Vec3, Volumes, facet_key};
use tests::workdir::Workdir;
use tests::{block, tag};

use crate::samples::{ONE, TIGHT, TWO, volumes};

#[test]
fn a_stiff_floor_is_reported_with_error_bars_of_each_volume() {
    let dir = volumes(TWO);
    dir.write("p1.toml", &(dir.text("p1.toml") + "[uncertainty]\nmodulus = 0.1\n"));
    dir.solver("simulate p1.toml -o two").assert_good();
    let report = dir.json("two/report.json");
    let laws = report["material"].as_array().unwrap();
    let names: Vec<_> = laws.iter().map(|law| law["on"].as_str().unwrap()).collect();
    assert_eq!(names, ["floor", "walls"]);
    assert!(report["force_balance"]["out_of_balance"].as_f64().unwrap() < 1e-9);

    let bars = report["error_bars"]["top"]["bars"].as_array().unwrap();
    let derivative = |on: Option<&str>| {
        let own = |bar: &&serde_json::Value| bar["of"] == "modulus" && bar["on"].as_str() == on;
        bars.iter().find(own).unwrap()["derivative"].as_f64().unwrap()
    };
    let sum = derivative(Some("floor")) + derivative(Some("walls"));
    assert!((sum / derivative(None) - 1.0).abs() < 1e-12);
}

#[test]
fn one_law_in_two_volumes_is_that_of_the_body() {
    let walls = &TWO[TWO.find("on = \"walls\"").unwrap() + "on = \"walls\"\n".len()..];
    let same =
        format!("[[material]]\non = \"floor\"\n{walls}\n[[material]]\non = \"walls\"\n{walls}");
    let dir = volumes(&same);
    dir.solver("simulate p1.toml -o two").assert_good();
    let bare = volumes(ONE);
    bare.solver("simulate p1.toml -o one").assert_good();
    assert!((dir.probe("two", "top") / bare.probe("one", "top") - 1.0).abs() < 1e-12);
}

/// Between its levels the interior is re-meshed, the layer between the volumes with a tag is not.
#[test]
fn a_design_keeps_its_volumes_where_it_is_re_meshed() {
    let dir = volumes(TWO);
    let mut file = read_tets(&dir.path("body.msh")).unwrap();
    let layer = between(&file);
    file.tags.names.push("paper".to_owned());
    let id = file.tags.id("paper").unwrap();
    layer.iter().for_each(|&facet| file.tags.set(facet, id));
    add_flat_tetrahedron(&mut file);
    write_tets(&dir.path("body.msh"), &file.mesh, &file.tags).unwrap();
    let paper = "[[membrane]]\non = \"paper\"\nthickness = 1e-4\nmaterial = { kind = \"sheet\", \
                 young = 3e6, poisson = 0.3 }\n";
    dir.write("p1.toml", &(dir.text("p1.toml") + paper));
    let design = dir.text("design.toml").replace("iterations = 3", "iterations = 1");
    dir.write("design.toml", &(design + "\n[[scenario]]\nname = \"soft\"\nmodulus = 0.9\n"));
    let run = dir.solver("optimize design.toml -o design");
    run.assert_good();
    assert!(run.stderr.contains("re-meshed the interior"), "{}", run.stderr);
    let before = read_tets(&dir.path("body.msh")).unwrap();
    let after = read_tets(&dir.path("design/design.msh")).unwrap();
    let [was, is] = [&before, &after].map(worst);
    assert!(was < 0.1 && is > 2.0 * was, "{was} {is}");
    assert_eq!(before.tags.volumes.names, after.tags.volumes.names);
    assert_eq!(layer.len(), between(&after).len());
    let tagged: std::collections::BTreeSet<_> = after.tags.facets_of(id).into_iter().collect();
    assert_eq!(tagged, between(&after));
    dir.solver("simulate p1.toml --mesh design/design.msh -o last").assert_good();
}

/// Puts a vertex into the last tetrahedron, near one of its facets: something to improve, as the body has
/// no vertices inside.
fn add_flat_tetrahedron(file: &mut MshFile) {
    let last = file.mesh.tets.len() - 1;
    let [a, b, c, d] = file.mesh.tets[last];
    let [p, q, r, s] = file.mesh.corners(last);
    let new = file.mesh.vertices.len();
    file.mesh.vertices.push(0.01 * p + 0.33 * (q + r + s));
    file.mesh.tets[last] = [new, b, c, d];
    file.mesh.tets.extend([[a, new, c, d], [a, b, new, d], [a, b, c, new]]);
    let volume = file.tags.volumes.of[last];
    file.tags.volumes.of.extend([volume; 3]);
}

/// Smallest radius ratio.
fn worst(file: &MshFile) -> f64 {
    let ratio = |t: usize| {
        let [a, b, c, d] = file.mesh.corners(t);
        mesh::measure::radius_ratio(a, b, c, d)
    };
    (0..file.mesh.tets.len()).map(ratio).fold(f64::INFINITY, f64::min)
}

/// The facets where volumes meet.
fn between(file: &MshFile) -> std::collections::BTreeSet<[usize; 3]> {
    let mut first = std::collections::BTreeMap::new();
    let mut found = std::collections::BTreeSet::new();
    for (tet, &volume) in file.mesh.tets.iter().zip(&file.tags.volumes.of) {
        for facet in TET_FACETS.map(|f| facet_key(f.map(|c| tet[c]))) {
            if first.insert(facet, volume).is_some_and(|other| other != volume) {
                found.insert(facet);
            }
        }
    }
    found
}

/// Young's moduli of two halves of a block [Pa].
const SOFT: f64 = 1e5;
const STIFF: f64 = 4e5;

/// Densities of the lower and the upper half of a column [kg/m³], and of the gravity on it [m/s²].
const LIGHT: f64 = 800.0;
const HEAVY: f64 = 2500.0;
const GRAVITY: f64 = 9.81;

/// A block of 20 × 20 mm in cells of 10 mm with two volumes, which are not in the order of their places, without
/// lateral contraction; and more keys of its scene.
fn halves(height: usize, is_soft: impl Fn(Vec3) -> bool, degree: usize, more: &str) -> Workdir {
    let dir = Workdir::new();
    let top = 0.01 * height as f64 - 1e-9;
    let mesh = block([2, 2, height], 0.01, |_| false, |p| p);
    let mut body = tag(mesh, &[("bottom", &|p| p.z < 1e-9), ("top", &|p| p.z > top)]);
    let middle = |t: usize| body.mesh.corners(t).iter().sum::<Vec3>() / 4.0;
    let of = (0..body.mesh.tets.len()).map(|t| usize::from(is_soft(middle(t)))).collect();
    body.tags.volumes = Volumes { names: vec!["stiff".to_owned(), "soft".to_owned()], of };
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let law = |on: &str, density: f64, young: f64| {
        format!(
            "[[material]]\non = \"{on}\"\nkind = \"linear-elastic\"\nyoung = {young:e}\npoisson = 0.0\n\
             density = {density}\n\n"
        )
    };
    let laws = law("soft", LIGHT, SOFT) + &law("stiff", HEAVY, STIFF);
    let head = format!("mesh = \"body.msh\"\ndegree = {degree}\n");
    dir.write("sim.toml", &(head + more + &laws + TIGHT));
    dir
}

/// A probe along z.
fn probe(name: &str, kind: &str, on: &str) -> String {
    format!("[[probe]]\nname = \"{name}\"\nkind = \"{kind}\"\non = \"{on}\"\naxis = [0, 0, 1]\n\n")
}

/// Springs of area A and height h: A δ/(h/E₁ + h/E₂) in series, A δ (E₁ + E₂)/2h in parallel. Without lateral contraction
/// the state is uniform in each half, and linear elements are exact.
#[test]
fn halves_of_a_block_are_springs_in_series_and_in_parallel() {
    let pressed = |axis: usize| {
        let loads = "[[fixed]]\non = \"bottom\"\n\n[[fixed]]\non = \"top\"\ndisplacement = [0, 0, -2e-4]\n\n";
        let more = loads.to_owned() + &probe("force", "reaction", "bottom");
        let dir = halves(2, |p| p[axis] < 0.01, 1, &more);
        dir.solver("simulate sim.toml -o out").assert_good();
        dir.probe("out", "force")
    };
    let (area, press) = (4e-4, 2e-4);
    let series = area * press / (0.01 / SOFT + 0.01 / STIFF);
    let parallel = area / 2.0 * press / 0.02 * (SOFT + STIFF);
    let found = [pressed(2), pressed(0)];
    assert!((found[0] / series - 1.0).abs() < 1e-9, "{found:?} {series}");
    assert!((found[1] / parallel - 1.0).abs() < 1e-9, "{found:?} {parallel}");
}

/// Two cubes of 20 mm above each other, quadratic elements.
fn column(more: &str) -> Workdir {
    let gravity = format!("gravity = [0, 0, -{GRAVITY}]\n\n");
    halves(4, |p| p.z < 0.02, 2, &(gravity + &probe("sag", "displacement", "top") + more))
}

/// With h the height of a half, the lower one carries g (ρ₁ (h − z) + ρ₂ h) and the upper one what is
/// above z: both strains are linear in z, so that quadratic elements are exact.
#[test]
fn a_column_of_two_densities_sags_under_its_weight() {
    let held = "[[fixed]]\non = \"bottom\"\n\n[uncertainty]\ndensity = 0.1\n\n";
    let dir = column(&(probe("weight", "reaction", "bottom") + held));
    dir.solver("simulate sim.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let value = |name: &str| report["probes"][name]["value"].as_f64().unwrap();
    let (h, area) = (0.02, 4e-4);
    let weight = GRAVITY * area * h * (LIGHT + HEAVY);
    let below = (LIGHT * h * h / 2.0 + HEAVY * h * h) / SOFT;
    let sag = -GRAVITY * (below + HEAVY * h * h / 2.0 / STIFF);
    // conjugate gradients end at 1e-13 of the force
    assert!((value("weight").abs() / weight - 1.0).abs() < 1e-9, "{} {weight}", value("weight"));
    assert!((value("sag") / sag - 1.0).abs() < 1e-9, "{} {sag}", value("sag"));
    // in proportion to both densities together: the derivative by a factor on them is the value
    for name in ["weight", "sag"] {
        let bar = &report["error_bars"][name]["bars"][0];
        assert_eq!(bar["of"], "density");
        let slope = bar["derivative"].as_f64().unwrap();
        assert!((slope / value(name) - 1.0).abs() < 1e-8, "{name}: {slope} {}", value(name));
    }
}
