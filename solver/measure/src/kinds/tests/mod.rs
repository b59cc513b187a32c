//! Quantities on a cube: derivatives of all kinds, and numbers of probes that are known.

mod symmetry;

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::Result;
use mechanics::body::Body;
use mechanics::material::{LAWS, Softening, Specification};
use mechanics::testing::cube;
use mesh::{Tags, TetMesh, Vec3};
use nalgebra::Rotation3;

use super::*;
use crate::objective::ObjectiveConfig;
use crate::probe::ProbeConfig;
use crate::quantity::tests::Case;
use crate::quantity::{Law, Quantity, Site, Targets};

/// The faces of the cube, across x, y and z.
const FACES: [[&str; 2]; 3] = [["left", "right"], ["front", "back"], ["bottom", "top"]];

/// Probes beside the examples of their kinds.
const OTHER_PROBES: [&str; 2] = [
    "kind = 'point'\nat = [0.2, 1.0, 2.0]\non = 'top'\naxis = [1, -1, 2]",
    "kind = 'twist'\non = 'top'\naxis = [0.1, 0, 1]",
];

/// Objectives beside those, and how near the state they are smooth: curvature jumps where a stretch passes its limit, or
/// a point the side of a cell of the lattice of distances.
const OTHERS: [(&str, f64); 17] = [
    (
        "kind = 'displacement'\non = 'top'\ndisplacement = ['t*y*(1 + x)', 7, 0.1]\ncomponents = 'xz'",
        5e-5,
    ),
    (
        "kind = 'displacement'\non = 'top'\ndisplacement = ['t*y', 7, 0.1]\nmeasure = 'deformed'",
        5e-5,
    ),
    ("kind = 'position'\non = 'left'\nposition = ['t*y*(1 + x)', 7, 0.1]\ncomponents = 'xz'", 5e-5),
    ("kind = 'volume'", 5e-5),
    ("kind = 'volume'\nvolume = 0.3\nmeasure = 'deformed'", 5e-5),
    ("kind = 'volume'\non = 'top'\nmeasure = 'deformed'", 5e-5),
    (
        "kind = 'target'\non = 'top'\ntarget = 'target.stl'\nspacing = 0.4\nmeasure = 'deformed'",
        5e-5,
    ),
    (
        "kind = 'target'\non = 'top'\ntarget = 'target.stl'\nspacing = 0.4\ndistance = 'unsigned'",
        5e-5,
    ),
    ("kind = 'stress'", 5e-5),
    ("kind = 'strain-limit'\nlargest = 1.02", 1e-5),
    ("kind = 'strain-limit'\nlargest = 1e3\nsmallest = 0.98", 1e-5),
    ("kind = 'contact-force'\non = 'top'", 5e-5),
    ("kind = 'contact-force'\non = 'top'\nform = 'sum-of-squares'", 5e-5),
    ("kind = 'contact-force'\non = 'top'\nform = 'sum'", 5e-5),
    ("kind = 'smoothness'\non = 'top'", 5e-5),
    (
        "kind = 'wall-thickness'\non = ['bottom', 'top']\ndensity = 'quadratic'\nactivation = 1.3",
        5e-5,
    ),
    (
        "kind = 'wall-thickness'\non = ['bottom', 'top']\nminimum = 0.8\nactivation = 1.3\nmeasure = 'deformed'",
        5e-5,
    ),
];

/// The body of a case, with a tag for each face.
fn body(case: &Case) -> Body {
    let mesh = TetMesh { vertices: case.rest.clone(), tets: case.space.tets().to_vec() };
    let mut tags = Tags::new(FACES.concat().into_iter().map(str::to_owned).collect());
    let far = case.rest.iter().fold(Vec3::zeros(), |far, x| far.sup(x));
    for &facet in &case.facets {
        for (axis, id) in (0..3).zip([1, 3, 5]) {
            let x = facet.map(|v| case.rest[v][axis] / far[axis]);
            for (side, id) in [(0.0, id), (1.0, id + 1)] {
                if x.iter().all(|x| (x - side).abs() < 1e-9) {
                    tags.set(facet, id);
                }
            }
        }
    }
    Body::new(mesh, tags)
}

/// Calls `with` with what quantities are built on: a cube of one law that is fixed at its bottom.
fn on_site<T>(case: &Case, with: impl FnOnce(Site) -> T) -> T {
    let law = LAWS.iter().find(|law| law.key == "neo-hookean").expect("a law");
    let material = Specification {
        law,
        values: vec![2.6, 0.3],
        density: None,
        stretch_range: None,
        modes: Vec::new(),
        stretch_at_break: None,
        softening: Softening::default(),
    };
    let law = Law { body: "cube", name: "cube".to_owned(), material: &material, elements: 0..48 };
    with(Site {
        body: &body(case),
        space: &case.space,
        bodies: vec!["cube"],
        laws: vec![law],
        supports: BTreeMap::from([("bottom".to_owned(), vec![0, 1, 2])]),
        times: vec![0.7],
        probes: BTreeMap::new(),
        threads: vec!["other", "thread"],
        targets: Targets::default(),
    })
}

fn build(case: &Case, keys: &str) -> Result<Arc<dyn Quantity>> {
    let config: ProbeConfig = toml::from_str(&format!("name = 'q'\n{keys}"))?;
    config.check()?;
    on_site(case, |site| config.build(&site))
}

/// Value of a probe where every node of the cube moves by `u`.
fn value(degree: usize, keys: &str, u: impl Fn(Vec3) -> Vec3) -> f64 {
    let mut case = Case::cube(degree, 1.0);
    let nodes = case.space.node_positions(&case.rest);
    case.u = nodes.into_iter().flat_map(|x| <[f64; 3]>::from(u(x))).collect();
    build(&case, keys).expect(keys).value(&case.at())
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{found} {expected}");
}

/// Derivatives of the square of what is left of a quantity to a wanted value, a function that is not
/// linear, within `near` of the state.
fn check(case: &Case, quantity: Arc<dyn Quantity>, near: f64) {
    let size = quantity.value(&case.at()).abs();
    assert!(size > 0.0 && size.is_finite(), "{size}");
    let wanted = format!(
        "kind = 'probe'\nname = 'j'\nweight = 1\nprobe = 'q'\nscale = {size}\ntarget = {}",
        -0.5 * size
    );
    let config: ObjectiveConfig = toml::from_str(&wanted).expect("sound");
    let objective = on_site(case, |mut site| {
        site.probes.insert("q".to_owned(), quantity);
        config.build(&site)
    });
    case.check_near(&*objective.expect("the probe is there"), near);
}

/// Every kind in each of its lists, by its example; in degree 3 probes alone, as elements are turned inside out there,
/// where some objectives have no derivative.
#[test]
fn derivatives_of_every_kind_belong_to_its_value() {
    let folder = tempfile::tempdir().expect("a folder");
    let (skin, _) = mesh::topology::boundary(&cube(2, 0.0)).surface(&cube(2, 0.0));
    mesh::io::write_surface(&folder.path().join("target.stl"), &skin).expect("a file");
    for degree in 1..=3 {
        let case = Case::cube(degree, 1.0);
        let built = |list: List, keys: &str| {
            let text = format!("name = 'q'\n{keys}");
            on_site(&case, |mut site| {
                site.targets = Targets::new(folder.path());
                if list == List::Objective {
                    let tip = build(&case, "kind = 'displacement'\non = 'top'\naxis = [1, 0, 0]");
                    site.probes.insert("q".to_owned(), tip?);
                    let config: ObjectiveConfig = toml::from_str(&format!("weight = 1\n{text}"))?;
                    return config.check().and_then(|()| config.build(&site));
                }
                let config: ProbeConfig = toml::from_str(&text)?;
                config.check().and_then(|()| config.build(&site))
            })
        };
        for kind in KINDS.iter().filter(|kind| degree < 3 || kind.lists == [List::Probe]) {
            for &list in kind.lists {
                let keys = format!("kind = '{}'\n{}", kind.key, kind.example);
                let quantity = built(list, &keys).unwrap_or_else(|e| panic!("{keys}: {e:#}"));
                assert!(kind.needs_contact || !quantity.uses_contact(), "{}", kind.key);
                eprintln!("{} of degree {degree}", kind.key);
                // another pair of points becomes the closest one a step of 1e-4 away
                check(&case, quantity, if kind.key == "gap" { 2e-5 } else { 5e-5 });
            }
        }
        for keys in OTHER_PROBES {
            check(&case, built(List::Probe, keys).expect(keys), 5e-5);
        }
        for (keys, near) in OTHERS.into_iter().filter(|_| degree < 3) {
            eprintln!("{keys} of degree {degree}");
            let quantity = built(List::Objective, keys);
            check(&case, quantity.unwrap_or_else(|e| panic!("{keys}: {e:#}")), near);
        }
    }
}

/// A rotation by 40° and a shift: what is measured of the cube turns with it.
#[test]
fn a_rigid_motion_has_its_known_numbers() {
    let turn =
        Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(Vec3::new(1.0, 2.0, -1.0)), 0.7);
    let shift = Vec3::new(0.3, -2.0, 0.1);
    let moved = |x: Vec3| turn * x + shift - x;
    let axis = Vec3::new(1.0, -1.0, 2.0).normalize();
    for degree in 1..=3 {
        let value = |keys: &str| value(degree, keys, moved);
        let a = "axis = [1, -1, 2]";
        // a face is flat: its moment matrix has no third direction
        near(
            value(&format!("kind = 'point'\nat = [0.2, 1, 5]\non = 'top'\n{a}")),
            axis.dot(&moved(Vec3::new(0.2, 1.0, 5.0))),
        );
        near(
            value(&format!("kind = 'point'\nat = [0.2, 0.9, 0.4]\n{a}")),
            axis.dot(&moved(Vec3::new(0.2, 0.9, 0.4))),
        );
        near(
            value(&format!("kind = 'displacement'\non = 'right'\n{a}")),
            axis.dot(&moved(Vec3::new(1.0, 0.5, 0.5))),
        );
        let twist = "kind = 'twist'\non = 'top'\naxis = [1, 2, -1]";
        near(value(twist), 0.7_f64.to_degrees());
        near(self::value(degree, twist, |x| 1.3 * (turn * x) + shift - x), 0.7_f64.to_degrees());
        near(value("kind = 'angle'\non = 'top'\nto = 'left'"), 90.0);
        near(value("kind = 'angle'\non = 'top'\nto = 'bottom'"), 180.0);
        near(value("kind = 'distance'\non = 'top'\nto = 'left'"), 0.5_f64.sqrt());
        near(value("kind = 'gap'\non = 'top'\nto = 'bottom'"), 1.0);
        // the middles of four faces are on a circle of radius ½
        near(value("kind = 'curvature'\non = ['left', 'top', 'right', 'bottom']"), 2.0);
    }
}

/// Under u_z = s x z the top tilts by atan s, and its far edge moves away from the bottom.
#[test]
fn a_tilted_face_has_its_closed_form() {
    for degree in 1..=3 {
        let value = |keys: &str| value(degree, keys, |x| Vec3::new(0.0, 0.0, 0.4 * x.x * x.z));
        let tilt = 0.4_f64.atan();
        near(value("kind = 'angle'\non = 'top'\nto = 'bottom'"), 180.0 - tilt.to_degrees());
        near(value("kind = 'angle'\non = 'top'\nto = 'left'"), 90.0 - tilt.to_degrees());
        near(value("kind = 'gap'\non = 'top'\nto = 'bottom'"), 1.0);
        near(value("kind = 'displacement'\non = 'top'\naxis = [0, 0, 3]"), 0.2);
        near(value("kind = 'distance'\non = 'top'\nto = 'bottom'"), 1.2);
        near(value("kind = 'displacement-magnitude'\non = 'right'"), 0.2);
        near(value("kind = 'displacement-magnitude'\non = 'bottom'"), 0.0);
    }
}

/// A bar of 1 × 0.05 × 0.05 that is rolled up by an angle, both ways and beyond whole turns, and
/// turned as a whole.
#[test]
fn bending_counts_whole_turns() {
    let mut bar = cube(8, 0.0);
    bar.vertices.iter_mut().for_each(|x| x.component_mul_assign(&Vec3::new(1.0, 0.05, 0.05)));
    let turn = Rotation3::from_axis_angle(&Vec3::y_axis(), 2.9);
    for (degree, angle) in [(1, 30.0), (2, -170.0), (1, 200.0), (2, 450.0), (1, -800.0)] {
        let mut case = Case::of(&bar, degree, 1.0);
        let rolled = |x: Vec3| {
            let (radius, a) = (-1.0 / f64::to_radians(angle), f64::to_radians(angle) * x.x);
            let r = radius - x.z;
            turn * Vec3::new(-r * a.sin(), x.y, radius - r * a.cos()) - x
        };
        let nodes = case.space.node_positions(&case.rest);
        case.u = nodes.into_iter().flat_map(|x| <[f64; 3]>::from(rolled(x))).collect();
        let found = |keys: &str| build(&case, keys).expect(keys).value(&case.at());
        near(found("kind = 'bending'\non = 'right'\nto = 'left'\naxis = [0, 2, 0]"), angle);
        near(found("kind = 'bending'\non = 'right'\nto = 'left'\naxis = [0, -1, 0]"), -angle);
        near(found("kind = 'bending'\non = 'left'\nto = 'right'\naxis = [0, 1, 0]"), -angle);
    }
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let case = Case::cube(1, 1.0);
    for (keys, words) in [
        (
            "kind = 'speed'",
            "unknown kind `speed`, expected one of `displacement`, `displacement-magnitude`",
        ),
        ("kind = 'gap'\non = 'top'\nfrom = 'left'", "unknown field `from`"),
        ("kind = 'displacement'\non = 'top'", "missing field `axis`"),
        (
            "kind = 'displacement'\non = 'lid'\naxis = [0, 0, 1]",
            "unknown tag \"lid\"; the mesh has",
        ),
        ("kind = 'displacement'\non = 'top'\naxis = [0, 0, 0]", "[0.0, 0.0, 0.0]: must be"),
        ("kind = 'displacement'\non = 'top'\naxis = [0, 1]", "kind = \"displacement\""),
        ("kind = 'point'\nat = [0.5, 0.5, 1.1]\naxis = [0, 0, 1]", "lies in no element at rest"),
        ("kind = 'point'\nat = [nan, 0, 0]\naxis = [0, 0, 1]", "must be finite"),
        ("kind = 'gap'\non = 'top'\nto = 'left'", "share 3 vertices"),
        ("kind = 'curvature'\non = ['top', 'left']", "found 2 tags"),
        ("kind = 'curvature'\non = ['top', 'left', 'top']", "\"top\" occurs twice"),
        ("kind = 'bending'\non = 'top'\nto = 'left'", "missing field `axis`"),
        (
            "kind = 'bending'\non = 'top'\nto = 'left'\naxis = [0, 0.02, 1]",
            "tag \"top\": its mean normal is 1° from the axis",
        ),
        ("kind = 'reaction'\non = 'top'\naxis = [0, 0, 1]", "fixed are: bottom"),
    ] {
        let error = match build(&case, keys) {
            Ok(_) => panic!("not refused: {keys}"),
            Err(error) => format!("{error:#}"),
        };
        assert!(error.contains(words) && error.contains("[[probe]] \"q\""), "{keys}: {error}");
    }
}
