//! `[[material]]`: volumes of a mesh with laws of their own, in scenes, error bars, scenarios and designs.

use std::collections::{BTreeMap, BTreeSet};

use mesh::io::{MshFile, read_tets, write_tets};
use mesh::measure::quality;
use mesh::topology::TET_FACETS;
use mesh::{Vec3, Volumes, facet_key};
use tests::workdir::Workdir;
use tests::{block, tag};

use crate::samples::{TIGHT, TWO, volumes};

#[test]
fn a_stiff_floor_is_reported_with_error_bars_of_each_volume() {
    let dir = volumes(TWO);
    dir.write("p1.toml", &(dir.text("p1.toml") + "[uncertainty]\nmodulus = 0.1\n"));
    let report = dir.report("simulate p1.toml -o two");
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
    dir.solver("optimize design.toml -o design").assert_says(&["re-meshed the interior"]);
    let before = read_tets(&dir.path("body.msh")).unwrap();
    let after = read_tets(&dir.path("design/design.msh")).unwrap();
    let [was, is] = [&before, &after].map(|file| quality(&file.mesh).radius_ratio_min);
    assert!(was < 0.1 && is > 2.0 * was, "{was} {is}");
    assert_eq!(before.tags.volumes.names, after.tags.volumes.names);
    assert_eq!(layer.len(), between(&after).len());
    let tagged: BTreeSet<_> = after.tags.facets_of(id).into_iter().collect();
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

/// The facets where volumes meet.
fn between(file: &MshFile) -> BTreeSet<[usize; 3]> {
    let mut first = BTreeMap::new();
    let mut found = BTreeSet::new();
    for (tet, &volume) in file.mesh.tets.iter().zip(&file.tags.volumes.of) {
        for facet in TET_FACETS.map(|f| facet_key(f.map(|c| tet[c]))) {
            if first.insert(facet, volume).is_some_and(|other| other != volume) {
                found.insert(facet);
            }
        }
    }
    found
}

/// Young's moduli of the lower and the upper half of a column [Pa], their densities [kg/m³], and gravity [m/s²].
const SOFT: f64 = 1e5;
const STIFF: f64 = 4e5;
const LIGHT: f64 = 800.0;
const HEAVY: f64 = 2500.0;
const GRAVITY: f64 = 9.81;

/// Two cubes of 20 mm above each other, without lateral contraction, on volumes that are not in the order of their places.
fn column() -> Workdir {
    let mesh = block([2, 2, 4], 0.01, |_| false, |p| p);
    let mut body = tag(mesh, &[("bottom", &|p| p.z < 1e-9), ("top", &|p| p.z > 0.04 - 1e-9)]);
    let height = |t: usize| body.mesh.corners(t).iter().sum::<Vec3>().z / 4.0;
    let of = (0..body.mesh.tets.len()).map(|t| usize::from(height(t) < 0.02)).collect();
    body.tags.volumes = Volumes { names: vec!["stiff".to_owned(), "soft".to_owned()], of };
    let dir = Workdir::with(&body);
    let law = |on: &str, density: f64, young: f64| {
        format!(
            "[[material]]\non = \"{on}\"\nkind = \"linear-elastic\"\nyoung = {young:e}\npoisson = 0.0\n\
             density = {density}\n\n"
        )
    };
    let laws = law("soft", LIGHT, SOFT) + &law("stiff", HEAVY, STIFF);
    let probes = [("sag", "displacement", "top"), ("weight", "reaction", "bottom")];
    let probes = probes.map(|(name, kind, on)| {
        format!(
            "[[probe]]\nname = \"{name}\"\nkind = \"{kind}\"\non = \"{on}\"\naxis = [0, 0, 1]\n\n"
        )
    });
    let head = format!("mesh = \"body.msh\"\ndegree = 2\ngravity = [0, 0, -{GRAVITY}]\n\n");
    let held = "[[fixed]]\non = \"bottom\"\n\n[uncertainty]\ndensity = 0.1\n\n";
    dir.write("sim.toml", &(head + &probes.concat() + held + &laws + TIGHT));
    dir
}

/// With h the height of a half, the lower one carries g (ρ₁ (h − z) + ρ₂ h) and the upper one what is
/// above z: both strains are linear in z, so that quadratic elements are exact.
#[test]
fn a_column_of_two_densities_sags_under_its_weight() {
    let dir = column();
    let report = dir.report("simulate sim.toml -o out");
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
