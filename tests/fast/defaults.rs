//! What a scene leaves open follows from other numbers: gradients by these are those of the whole, by the program.

use mesh::io::write_surface;
use mesh::{SurfaceMesh, Vec3};
use tests::chamber;
use tests::workdir::Workdir;

/// A folder with a plate at a height [m], above or below the whole block.
fn beside_a_plate(height: f64) -> Workdir {
    let dir = chamber::workdir();
    let corner = |x: f64, y: f64| Vec3::new(0.15 * x - 0.05, 0.14 * y - 0.05, height);
    let vertices = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    let plate = SurfaceMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
    write_surface(&dir.path("plate.stl"), &plate).unwrap();
    dir
}

/// All numbers of a scene pass, and those named are among them.
#[track_caller]
fn check(dir: &Workdir, scene: &str, paths: &[&str]) {
    dir.write("scene.toml", scene);
    dir.write(
        "design.toml",
        "scene = \"scene.toml\"\n[[parameter]]\nname = \"density.body\"\nbounds = [500, 2000]\n\
         [optimizer]\niterations = 1\n[[objective]]\nkind = \"probe\"\nname = \"top\"\nweight = 1\nprobe = \"top\"\n\
         target = 1e-2\nscale = 1e-3\n",
    );
    let run = dir.solver("check design.toml --random 1 --steps 6");
    run.assert_good();
    for path in paths {
        assert!(run.stdout.contains(&format!("by {path}")), "{}", run.stdout);
    }
}

const TOP: &str =
    "[[probe]]\nname = \"top\"\nkind = \"displacement\"\non = \"top\"\naxis = [0, 0, 1]\n";
const SILICONE: &str = "mesh = \"body.msh\"\ndegree = 1\ngravity = [0, 0, -9.81]\n[material]\nkind = \"neo-hookean\"\n\
     young = 3e5\npoisson = 0.4\ndensity = 1070\n";
const TIGHT: &str = "[solver]\nrelative_tolerance = 1e-12\nabsolute_tolerance = 1e-14\n";
const PLATE: &str = "[[obstacle]]\nname = \"plate\"\nsurface = \"plate.stl\"\n";

/// The stiffness of the contact is the shear modulus of the body, in its own forces and in those of friction.
#[test]
fn a_contact_without_a_stiffness_has_the_gradient_by_the_modulus() {
    let dir = beside_a_plate(0.0403);
    // without gravity, by which the top moves within rounding alone
    let silicone = SILICONE.replace("gravity = [0, 0, -9.81]\n", "");
    let scene = format!(
        "{silicone}{TOP}{PLATE}{TIGHT}[[fixed]]\non = \"seat\"\n[[chamber]]\non = \"cavity\"\npressure = \"20e3*t\"\n\
         [contact]\nactivation = 2e-4\nfriction = 0.3\nfriction_speed = 1e-3\n\
         [time]\nend = 1\nsteps = 3\nmethod = \"quasistatic\"\n"
    );
    check(&dir, &scene, &["material.body", "contact.friction"]);
    // the report says what was taken
    dir.solver("simulate scene.toml -o out --final-only").assert_good();
    let contact = &dir.json("out/report.json")["config"]["contact"];
    let shear = 3e5 / 2.8;
    assert!((contact["stiffness"].as_f64().unwrap() / shear - 1.0).abs() < 1e-12, "{contact}");
}

/// A block that lies on a plate is kept from sliding by a mass of its density, however small.
#[test]
fn a_body_that_nothing_holds_has_the_gradient_by_the_density_of_its_tiny_mass() {
    let dir = beside_a_plate(-0.0003);
    let scene = format!(
        "{SILICONE}{TOP}{PLATE}{TIGHT}[contact]\nactivation = 5e-4\n[time]\nend = 1\nsteps = 2\n\
         method = \"quasistatic\"\n"
    );
    check(&dir, &scene, &["density.body", "gravity"]);
}
