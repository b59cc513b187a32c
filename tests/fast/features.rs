//! Each feature by the program: what a simulation of its sample says and reports, and its gradients by the shape and by
//! all of its numbers, as a user asks for them.

use rayon::prelude::*;
use serde_json::Value;
use tests::chamber::{self, VOLUME_DESIGN};
use tests::workdir::Workdir;

use crate::samples::*;

struct Feature {
    name: &'static str,
    folder: fn() -> Workdir,
    /// What `solver simulate` says.
    says: &'static [&'static str],
    /// Numbers of its report that are not 0, as JSON pointers.
    report: &'static [&'static str],
    /// Arguments of `solver check design.toml`.
    check: &'static str,
    /// By what it tests the gradients.
    by: &'static [&'static str],
}

const FEATURES: &[Feature] = &[
    Feature {
        name: "fibre",
        // the slack is wide, so that its curvature is seen by the steps of the test
        folder: || wound(&(FIBRE.to_owned() + "slack = 0.1\n")),
        says: &["fibre weave: at 40° to an axis"],
        report: &["/fibres/0/stress", "/fibres/0/taut", "/fibres/0/stretch/1", "/fibres/0/energy"],
        check: "--random 1",
        by: &["shape", "fibre.weave"],
    },
    Feature {
        name: "thread by pitch",
        folder: || pulled(THREAD),
        says: &["helix of pitch 20.000 mm, double", "winding thread crosses itself at "],
        report: &["/windings/0/length", "/windings/0/mean_force", "/windings/0/energy"],
        check: "--random 1",
        by: &["shape", "winding.thread"],
    },
    Feature {
        name: "thread by angle, which is designed",
        folder: || {
            let dir = pulled(&THREAD.replace("pitch = 0.02", "angle = 80"));
            let angle = "[optimizer]\niterations = 1\n\n[[parameter]]\nname = \"winding.thread.angle\"\nbounds = [75, 85]\n";
            let design = dir.text("design.toml");
            let shape = design.find("[shape]").unwrap()..design.find("[[objective]]").unwrap();
            dir.write("design.toml", &design.replace(&design[shape], angle));
            dir
        },
        says: &[],
        report: &["/windings/0/turns"],
        check: "--random 1",
        by: &["winding.thread"],
    },
    Feature {
        name: "profiles",
        folder: || pulled(&(FIBRE_PROFILES.to_owned() + WINDING_PROFILES)),
        says: &[
            "fibre weave: at 40 to 70° to an axis, k1 1.000e5 to 3.000e5 Pa",
            "helix of pitch 12.000 to 20.000 mm, double, EA 4.000e1 to 6.000e1 N",
        ],
        report: &["/fibres/0/energy", "/windings/0/energy"],
        check: "--random 1",
        by: &["shape", "fibre.weave", "winding.thread"],
    },
    Feature {
        name: "sheet",
        folder: || covered(SHEET),
        says: &["membrane on top: 0.100 mm, sheet (young 3.000e6 Pa"],
        report: &["/membranes/0/area", "/membranes/0/taut", "/energies/membrane"],
        check: "--handles 1 --random 1",
        by: &["shape", "membrane.top"],
    },
    Feature {
        name: "fabric",
        folder: || on_the_fabric(""),
        says: &["woven (warp 3.000e6 Pa", "to an axis"],
        report: &["/membranes/0/energy"],
        check: "--random 1",
        by: &["shape", "membrane.top"],
    },
    Feature {
        name: "fabric in tension",
        folder: || on_the_fabric("tension = true\n"),
        says: &["tension only"],
        report: &["/membranes/0/energy"],
        check: "--random 1",
        by: &["shape", "membrane.top"],
    },
    Feature {
        name: "two materials",
        folder: || volumes(TWO),
        says: &[],
        report: &["/energies/elastic"],
        check: "--handles 1 --random 1",
        by: &["shape", "material.floor", "material.walls"],
    },
    Feature {
        name: "rigid part",
        folder: || glued("mass = 0.02\nforce = [0.1, 0, -0.3]\n"),
        says: &[],
        report: &["/steps/0/rigid/top/rotation/1"],
        check: "--steps 5",
        by: &["shape", "rigid.top.mass", "rigid.top.force"],
    },
    Feature {
        name: "softening",
        folder: || {
            let dir = moved(SOFTENING, &[8e-3, 3e-3, 6e-3]);
            dir.write("design.toml", &cube_design("left", "pull", 1.0));
            dir
        },
        says: &["by 55.6 % at most, m = 400 Pa"],
        report: &["/mullins/0/factor", "/mullins/0/lost"],
        check: "",
        by: &["shape", "mullins"],
    },
    Feature {
        name: "relaxation",
        folder: || {
            let dir = creeping(3);
            dir.write("design.toml", &cube_design("top", "top", 1e9));
            dir
        },
        says: &["40.0 % more isochoric stress at once, for 2 s"],
        report: &["/probes/top/value"],
        check: "",
        by: &["shape", "relaxation"],
    },
    Feature {
        name: "supply line beside a viscous body",
        folder: || beside_a_viscous_body("supply = \"40e3*t\""),
        says: &[],
        report: &["/chambers/left/pressure"],
        check: "--handles 3",
        by: &["shape", "chamber.left"],
    },
    Feature {
        name: "supply line with a check valve",
        folder: || beside_a_viscous_body("checked_supply = \"80e3*t*(1 - 2*t)\""),
        says: &[],
        report: &["/chambers/left/pressure"],
        check: "--handles 3",
        by: &["shape", "chamber.left"],
    },
    Feature {
        name: "plug",
        folder: plugged,
        says: &[],
        report: &["/chambers/cavity/volume"],
        check: "--handles 3",
        by: &["shape", "chamber.cavity"],
    },
    Feature {
        name: "forces from expressions of the place",
        folder: || {
            covered(
                "[[body_force]]\nforce = [0, \"2e5*y*t\", \"-3e5*(1 + sin(60*x))\"]\n\
                 [[traction]]\non = \"top\"\ntraction = [\"1e5*x\", 0, \"5e4*(x - y)\"]\n",
            )
        },
        says: &[],
        report: &["/force_balance/traction/0"],
        check: "--motion 3e-4",
        by: &["shape", "material.body"],
    },
    Feature {
        name: "tag that moves as its own image",
        folder: || alike(OWN),
        says: &[],
        report: &[],
        check: "--handles 2 --design-only",
        by: &["shape"],
    },
    Feature {
        name: "two tags that move alike",
        folder: two_chambers,
        says: &[],
        report: &[],
        check: "--handles 1 --design-only",
        by: &["shape"],
    },
    Feature {
        name: "face that keeps its plane",
        folder: kept,
        says: &[],
        report: &[],
        check: "--handles 3 --design-only",
        by: &["shape"],
    },
];

/// A thread whose forces have no kink: it does not start on an edge of the mesh.
const THREAD: &str = r#"
[[winding]]
name = "thread"
on = "side"
around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }
pitch = 0.02
start = 0.004
end = 0.046
double = true
stiffness = 50
slack = 0.1
pretension = 0.5
phase = 10
"#;

/// The force of the thread is an objective, too.
fn pulled(tables: &str) -> Workdir {
    let pull =
        "\n[[probe]]\nname = \"pull\"\nkind = \"winding-force\"\nwinding = \"thread\"\npower = 4\n";
    let dir = wound(&(tables.to_owned() + pull));
    let objective =
        "\n[[objective]]\nkind = \"probe\"\nname = \"pull\"\nweight = 1\nprobe = \"pull\"\n";
    dir.write("design.toml", &(VOLUME_DESIGN.to_owned() + objective));
    dir
}

/// A design by the shape of the fabric itself, with which the warp turns.
fn on_the_fabric(keys: &str) -> Workdir {
    let dir = covered(&(FABRIC.to_owned() + keys + TIGHT));
    let design = VOLUME_DESIGN.replacen("on = \"cavity\"", "on = \"top\"", 1);
    dir.write("design.toml", &design.replace("handles = 1", "handles = 2"));
    dir
}

/// Internal variables of the body come before those of the line.
fn beside_a_viscous_body(supply: &str) -> Workdir {
    let chamber = supplied("on = \"left\"", supply, 0.2 / RESISTANCE);
    twins(200e3, &format!("{chamber}[[relaxation]]\noverstress = 0.4\ntime = 0.1\n\n"))
}

impl Feature {
    fn check(&self) {
        let (dir, name) = ((self.folder)(), self.name);
        if !(self.says.is_empty() && self.report.is_empty()) {
            let run = dir.solver("simulate p1.toml -o out");
            run.assert_good();
            for words in self.says {
                assert!(run.stderr.contains(words), "{name}: {words}: {}", run.stderr);
            }
            let report = dir.json("out/report.json");
            for pointer in self.report {
                let number = report.pointer(pointer).and_then(Value::as_f64);
                assert!(number.is_some_and(|n| n != 0.0), "{name}: {pointer} is {number:?}");
            }
        }
        let run = dir.solver(&format!("check design.toml {}", self.check));
        assert_eq!(run.code, Some(0), "{name}: {}\n{}", run.stdout, run.stderr);
        for by in self.by {
            let tested = run.stdout.contains(&format!("by {by}"));
            assert!(tested, "{name}: no gradient by {by}: {}", run.stdout);
        }
    }
}

#[test]
fn features_are_reported_and_have_their_gradients() {
    FEATURES.par_iter().for_each(Feature::check);
}

/// Numbers that a scene leaves open follow from others, and gradients by these are those of the whole: the stiffness
/// of contact from the modulus, and the tiny mass of what nothing holds from the density.
#[test]
fn numbers_that_are_left_open_have_gradients() {
    let silicone = "mesh = \"body.msh\"\ndegree = 1\ngravity = [0, 0, -9.81]\n[material]\nkind = \"neo-hookean\"\n\
                    young = 3e5\npoisson = 0.4\ndensity = 1070\n";
    let top =
        "[[probe]]\nname = \"top\"\nkind = \"displacement\"\non = \"top\"\naxis = [0, 0, 1]\n";
    let tight = "[solver]\nrelative_tolerance = 1e-12\nabsolute_tolerance = 1e-14\n";
    let obstacle = "[[obstacle]]\nname = \"plate\"\nsurface = \"plate.stl\"\n";
    let check = |height: f64, scene: &str, by: &[&str]| {
        let dir = chamber::workdir();
        let plate = tests::plate([-0.05, 0.1], [-0.05, 0.09], height);
        mesh::io::write_surface(&dir.path("plate.stl"), &plate).unwrap();
        dir.write("p1.toml", scene);
        let density = "[[parameter]]\nname = \"density.body\"\nbounds = [500, 2000]\n[optimizer]\niterations = 1\n";
        let goal = "[[objective]]\nkind = \"probe\"\nname = \"top\"\nweight = 1\nprobe = \"top\"\ntarget = 1e-2\nscale = 1e-3\n";
        dir.write("design.toml", &format!("scene = \"p1.toml\"\n{density}{goal}"));
        let run = dir.solver("check design.toml --random 1 --steps 6");
        run.assert_good();
        by.iter().for_each(|by| {
            assert!(run.stdout.contains(&format!("by {by}")), "{by}: {}", run.stdout);
        });
        dir
    };
    // without gravity, by which the top moves within rounding alone
    let inflated = format!(
        "{}{top}{obstacle}{tight}[[fixed]]\non = \"seat\"\n[[chamber]]\non = \"cavity\"\npressure = \"20e3*t\"\n\
         [contact]\nactivation = 2e-4\nfriction = 0.3\nfriction_speed = 1e-3\n\
         [time]\nend = 1\nsteps = 3\nmethod = \"quasistatic\"\n",
        silicone.replace("gravity = [0, 0, -9.81]\n", "")
    );
    let dir = check(0.0403, &inflated, &["material.body", "contact.friction"]);
    // the report says what was taken
    let contact = &dir.report("simulate p1.toml -o out --final-only")["config"]["contact"];
    assert!(
        (contact["stiffness"].as_f64().unwrap() / (3e5 / 2.8) - 1.0).abs() < 1e-12,
        "{contact}"
    );
    // a block that lies on a plate is kept from sliding by a mass of its density, however small
    let lying = format!(
        "{silicone}{top}{obstacle}{tight}[contact]\nactivation = 5e-4\n[time]\nend = 1\nsteps = 2\n\
         method = \"quasistatic\"\n"
    );
    check(-0.0003, &lying, &["density.body", "gravity"]);
}
