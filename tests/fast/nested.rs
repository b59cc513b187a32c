//! Bodies and obstacles that lie in the solid of another one at the start are refused, with and without
//! contact; those in a chamber, a container or a mirrored scene's air are not.

use mesh::io::write_surface;
use mesh::{SurfaceMesh, Vec3};
use tests::workdir::Workdir;
use tests::{block, tag};

const MATERIAL: &str =
    "material = { kind = \"neo-hookean\", young = 1e5, poisson = 0.35, density = 1000.0 }\n";
const CONTACT: &str = "[contact]\nactivation = 1e-4\nstiffness = 1e5\n";

/// The surface of a cube about the middle of `base.msh`, facing outward.
fn cube(side: f64) -> SurfaceMesh {
    let mesh = block([1, 1, 1], side, |_| false, |p| p + Vec3::repeat(1e-2 - side / 2.0));
    mesh::topology::boundary(&mesh).surface(&mesh).0
}

/// A folder with `base.msh`, 2 cm wide; `hollow.msh` with a chamber of 1 cm in it; `half.msh`, cut at
/// x = 1 cm; `small.msh`, 1 mm wide; and obstacles.
fn workdir() -> Workdir {
    let dir = Workdir::new();
    let write = |name: &str, cells: [usize; 3], side: f64, hole: fn([usize; 3]) -> bool| {
        let body = tag(
            block(cells, side, hole, |p| p),
            &[
                ("bottom", &|p| p.z < 1e-9),
                ("cut", &|p| (p.x - 1e-2).abs() < 1e-9),
                ("rest", &|_| true),
            ],
        );
        dir.put(name, &body);
    };
    write("base.msh", [4, 4, 4], 5e-3, |_| false);
    write("hollow.msh", [4, 4, 4], 5e-3, |cell| cell.iter().all(|k| (1..3).contains(k)));
    write("half.msh", [2, 4, 4], 5e-3, |_| false);
    write("small.msh", [1, 1, 1], 1e-3, |_| false);
    let mut container = cube(5e-2);
    write_surface(&dir.path("block.stl"), &container).unwrap();
    container.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    write_surface(&dir.path("container.stl"), &container).unwrap();
    container.triangles.pop();
    write_surface(&dir.path("open.stl"), &container).unwrap();
    let mut seed = cube(2e-3);
    write_surface(&dir.path("seed.stl"), &seed).unwrap();
    seed.triangles.truncate(3);
    write_surface(&dir.path("flake.stl"), &seed).unwrap();
    dir
}

fn base(mesh: &str) -> String {
    format!(
        "degree = 1\ngravity = [0, 0, -1]\n[[body]]\nname = \"base\"\nmesh = \"{mesh}.msh\"\n\
         {MATERIAL}[[fixed]]\non = \"base.bottom\"\n"
    )
}

fn small(x: f64, y: f64, z: f64) -> String {
    format!(
        "[[body]]\nname = \"small\"\nmesh = \"small.msh\"\ntranslate = [{x:e}, {y:e}, {z:e}]\n{MATERIAL}\
         [[fixed]]\non = \"small.bottom\"\n"
    )
}

fn obstacle(name: &str) -> String {
    format!("[[obstacle]]\nname = \"{name}\"\nsurface = \"{name}.stl\"\n")
}

/// Asserts that a scene is refused with words before it runs, or without words that it is simulated.
fn check(dir: &Workdir, scene: &str, words: &[&str]) {
    dir.write("sim.toml", scene);
    let run = dir.solver("simulate sim.toml -o out --restart");
    if words.is_empty() {
        run.assert_good();
        assert_eq!(dir.json("out/report.json")["usable"], true, "{scene}");
        std::fs::remove_dir_all(dir.path("out")).unwrap();
    } else {
        run.assert_refused(2, &[&["sim.toml", "apart", "translate"], words].concat());
        assert_eq!(dir.files("out"), [""; 0], "{scene}");
    }
}

#[test]
fn bodies_and_obstacles_in_solids_are_refused() {
    let dir = workdir();
    let with = |mesh: &str, more: &str| base(mesh) + more + CONTACT;
    let half = |inside: &str| with("half", &format!("{inside}[[symmetry]]\non = \"base.cut\"\n"));
    let inside = small(3e-3, 4e-3, 12e-3);
    let in_wall = small(2e-3, 4e-3, 12e-3);
    let across = small(19.5e-3, 4e-3, 12e-3);
    // in the other order, and led along by its supports
    let head = "degree = 1\ngravity = [0, 0, -1]\n";
    let led = format!("{inside}displacement = [1e-3, 0, 0]\n{}", base("base").replace(head, ""));
    let of_base = "body \"small\" lies in the solid of body \"base\"";
    let found = [of_base, "(0.00300, 0.00400, 0.01200) m"];
    let seed = "obstacle \"seed\" lies in the solid of body \"base\"";
    let flake = "obstacle \"flake\" lies in the solid of body \"base\"";
    let block = ["body \"base\" lies in the solid of obstacle \"block\"", "face inward"];
    for (scene, words) in [
        (with("base", &inside), &found[..]),
        (base("base") + &inside, &found),
        (base("base") + &inside, &["contact = \"ignored\""]),
        (format!("degree = 1\n{led}{CONTACT}"), &found),
        (format!("contact = \"ignored\"\n{}{inside}", base("base")), &[]),
        // in the wall of a hollow body, in its chamber, and beside it
        (with("hollow", &in_wall), &[of_base]),
        (with("hollow", &small(9e-3, 8.5e-3, 9e-3)), &[]),
        (base("hollow") + &small(9e-3, 8.5e-3, 9e-3), &[]),
        (with("hollow", &small(21e-3, 10e-3, 12e-3)), &[]),
        (base("base") + &across, &["\"base\" and \"small\" meet near (0.02"]),
        (with("base", &across), &["intersect at (0.02", "of \"base\" and \"small\""]),
        (half(&inside), &found),
        (half(&small(-3e-3, 4e-3, 12e-3)), &[]),
        // in the whole, through the plane
        (half(&obstacle("seed")), &[seed]),
        (with("base", &obstacle("seed")), &[seed]),
        (with("base", &obstacle("flake")), &[flake]),
        (with("hollow", &obstacle("seed")), &[]),
        (with("hollow", &obstacle("flake")), &[]),
        (with("base", &obstacle("block")), &block),
        (with("base", &obstacle("container")), &[]),
        (with("base", &obstacle("open")), &[]),
    ] {
        check(&dir, &scene, words);
    }
}
