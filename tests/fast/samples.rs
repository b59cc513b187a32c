//! A small scene of each feature: `p1.toml` in a folder, and where `design.toml` moves its shape, a design of it.

use mesh::io::{read_tets, write_surface, write_tets};
use mesh::{Vec3, Volumes};
use tests::chamber::{self, DESIGN, PROBES, SIM, VOLUME_DESIGN};
use tests::workdir::Workdir;
use tests::{block, plate, tag};

pub const FIBRE: &str = r#"
[[fibre]]
name = "weave"
around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }
angle = 40
k1 = 2e5
k2 = 1.0
dispersion = 0.1
"#;

pub const WINDING: &str = r#"
[[winding]]
name = "thread"
on = "side"
around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }
pitch = 0.02
start = 0.004
end = 0.046
double = true
stiffness = 50
"#;

pub const FIBRE_PROFILES: &str = r#"
[[fibre]]
name = "weave"
around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }
angle = { values = [70, 40, 55], start = -0.001, end = 0.051 }
k1 = { values = [1e5, 3e5], start = -0.001, end = 0.051 }
slack = 0.1
"#;

pub const WINDING_PROFILES: &str = r#"
[[winding]]
name = "thread"
on = "side"
around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }
pitch = { values = [0.012, 0.02, 0.016], start = 0.0, end = 0.05 }
start = 0.004
end = 0.046
phase = 10
double = true
stiffness = { values = [40, 60], start = 0.01, end = 0.04 }
pretension = 0.5
slack = 0.1
"#;

pub const SHEET: &str = r#"
[[membrane]]
on = "top"
thickness = 1e-4
material = { kind = "sheet", young = 3e6, poisson = 0.3 }
"#;

/// Fabric on the bias, the warp around an axis below the body.
pub const FABRIC: &str = r#"
[[membrane]]
on = "top"
thickness = 1e-4
material = { kind = "woven", warp = 3e6, weft = 1e6, shear = 2e5, poisson = 0.3 }
around = { point = [0, 0.02, -0.02], axis = [1, 0, 0] }
angle = 30
"#;

/// The law of the chamber.
pub const ONE: &str = r#"[material]
kind = "mooney-rivlin"
c1 = 55e3
c2 = 5e3
c3 = 1.7e3
d1 = 1e6
"#;

/// One of its floor and one of its walls.
pub const TWO: &str = r#"[[material]]
on = "floor"
kind = "neo-hookean"
young = 600e3
poisson = 0.45

[[material]]
on = "walls"
kind = "mooney-rivlin"
c1 = 55e3
c2 = 5e3
c3 = 1.7e3
d1 = 1e6
"#;

/// The volume in the chamber of a wound body.
const AIR: &str = "\n[[probe]]\nname = \"air\"\nkind = \"volume\"\non = \"cavity\"\n";

pub const TIGHT: &str = "\n[solver]\nrelative_tolerance = 1e-13\nabsolute_tolerance = 1e-12\n";

/// The chamber around which the tables are wound.
pub fn wound(tables: &str) -> Workdir {
    let dir = chamber::with(&chamber::wound(1), &(AIR.to_owned() + tables));
    dir.write("design.toml", VOLUME_DESIGN);
    dir
}

/// The chamber with probes and these tables.
pub fn covered(tables: &str) -> Workdir {
    let dir = chamber::workdir();
    dir.write("p1.toml", &(dir.text("p1.toml") + PROBES + tables));
    dir
}

/// The chamber with a file of another program.
pub fn of_files(name: &str, text: &str) -> Workdir {
    let dir = chamber::workdir();
    dir.write(name, text);
    dir
}

/// The chamber, whose tetrahedra below 10 mm are the volume `floor`, and others `walls`.
pub fn volumes(materials: &str) -> Workdir {
    let dir = covered(TIGHT);
    let mut file = read_tets(&dir.path("body.msh")).unwrap();
    let height = |t: usize| file.mesh.corners(t).iter().map(|p| p.z).sum::<f64>() / 4.0;
    let of = (0..file.mesh.tets.len()).map(|t| usize::from(height(t) > 0.01)).collect();
    file.tags.volumes = Volumes { names: vec!["floor".to_owned(), "walls".to_owned()], of };
    write_tets(&dir.path("body.msh"), &file.mesh, &file.tags).unwrap();
    dir.write("p1.toml", &dir.text("p1.toml").replace(ONE, materials));
    dir
}

/// Half of a wound chamber, cut at y = 20 mm.
pub fn half(tables: &str) -> Workdir {
    let mesh = block([5, 2, 4], 0.01, |c| c[0] < 4 && c[1] == 1 && (1..3).contains(&c[2]), |p| p);
    let body = tag(
        mesh,
        &[
            ("cut", &|p| p.y > 0.02 - 1e-6),
            ("seat", &|p| p.x < 1e-6),
            ("cavity", &|p| p.x < 0.041 && p.y > 0.009 && p.z > 0.009 && p.z < 0.031),
            ("side", &|_| true),
        ],
    );
    chamber::with(&body, &format!("{tables}\n[[symmetry]]\non = \"cut\"\n"))
}

/// A block with a closed chamber `air`, a rigid plate glued to its top, and more keys of the plate.
pub fn glued(keys: &str) -> Workdir {
    let hollow = |c: [usize; 3]| c == [1, 1, 1] || c == [1, 1, 2];
    let body = tag(
        block([3, 3, 4], 5e-3, hollow, |p| p),
        &[
            ("bottom", &|c| c.z < 1e-9),
            ("top", &|c| c.z > 0.02 - 1e-9),
            ("sides", &|c| [c.x, c.y].into_iter().any(|x| !(1e-9..=0.015 - 1e-9).contains(&x))),
            ("air", &|_| true),
        ],
    );
    let dir = Workdir::with(&body);
    let scene = format!(
        "mesh = \"body.msh\"\ndegree = 1\ngravity = [0, 0, -9.81]\n\n{}density = 1000.0\n\n\
         [[fixed]]\non = \"bottom\"\n\n[[chamber]]\non = \"air\"\npressure = 2e3\n\n\
         [[rigid]]\non = \"top\"\n{keys}",
        ONE
    );
    dir.write("p1.toml", &scene);
    dir.write(
        "design.toml",
        "scene = \"p1.toml\"\n\n[shape]\non = \"air\"\n\n[[shape.level]]\nhandles = 2\niterations = 1\n\n\
         [[objective]]\nkind = \"displacement\"\nname = \"up\"\nweight = 1e9\non = \"top\"\n\
         displacement = [1e-3, 0, 2e-3]\n",
    );
    dir
}

/// A cube of 20 mm with a law, which contracts freely while its top is pulled or moved as `loads` say, in tables of time.
pub fn cube(law: &str, loads: &str) -> Workdir {
    let body = tag(
        block([2, 2, 2], 0.01, |_| false, |p| p),
        &[
            ("bottom", &|p| p.z < 1e-9),
            ("top", &|p| p.z > 0.02 - 1e-9),
            ("left", &|p| p.x < 1e-9),
            ("front", &|p| p.y < 1e-9),
        ],
    );
    let dir = Workdir::with(&body);
    let fixed = [("bottom", "z"), ("left", "x"), ("front", "y")]
        .map(|(on, axis)| format!("[[fixed]]\non = \"{on}\"\ncomponents = \"{axis}\"\n"));
    let scene = format!("mesh = \"body.msh\"\ndegree = 1\n{law}{}{loads}{TIGHT}", fixed.concat());
    dir.write("p1.toml", &scene);
    dir
}

/// 40 % more isochoric stress at once, which relaxes in 2 s.
pub const BRANCH: &str = "[[relaxation]]\noverstress = 0.4\ntime = 2\n";

/// The cube, whose top is pulled from the first time step on to a strain of 0.1 %; its branch creeps.
pub fn creeping(steps: usize) -> Workdir {
    let law =
        format!("[material]\nkind = \"neo-hookean\"\nyoung = 2.64e5\npoisson = 0.49\n{BRANCH}");
    let loads = format!(
        "[[traction]]\non = \"top\"\ntraction = [0, 0, 264]\n\
         [[probe]]\nname = \"top\"\nkind = \"displacement\"\non = \"top\"\naxis = [0, 0, 1]\n\
         [time]\nend = 4\nsteps = {steps}\nmethod = \"quasistatic\"\n"
    );
    cube(&law, &loads)
}

pub const SOFTENING: &str = "[[mullins]]\nr = 1.8\nm = 400\nbeta = 0.15\n";

/// A law with a bulk modulus [Pa].
pub fn silicone(bulk: f64) -> String {
    let d1 = 0.5 * bulk;
    format!("[material]\nkind = \"mooney-rivlin\"\nc1 = 40000\nc2 = 6000\nc3 = 0\nd1 = {d1}\n")
}

/// The cube, whose top rises so far [m] in steps of a second.
pub fn moved(softening: &str, rises: &[f64]) -> Workdir {
    let (count, times) = (rises.len(), Vec::from_iter(0..=rises.len()));
    let values: Vec<f64> = [0.0].iter().chain(rises).copied().collect();
    let loads = format!(
        "[[fixed]]\non = \"top\"\ncomponents = \"z\"\n\
         displacement = [0, 0, {{ t = {times:?}, value = {values:?} }}]\n\
         [[probe]]\nname = \"pull\"\nkind = \"reaction\"\non = \"top\"\naxis = [0, 0, 1]\n\
         [time]\nend = {count}\nsteps = {count}\nmethod = \"quasistatic\"\n"
    );
    cube(&(silicone(5e6) + softening), &loads)
}

/// A design of the cube for a probe, by the shape of a face.
pub fn cube_design(on: &str, probe: &str, weight: f64) -> String {
    format!(
        "scene = \"p1.toml\"\n[shape]\non = \"{on}\"\n[[shape.level]]\nhandles = 1\niterations = 1\n\
         [[objective]]\nkind = \"probe\"\nname = \"low\"\nprobe = \"{probe}\"\ntarget = 0.0\n\
         over = \"uniform\"\nweight = {weight:e}\n"
    )
}

/// Ambient pressure [Pa], volume of a hollow [m³], and resistance of a line that fills it in 0.1 s [Pa s/m³].
pub const AMBIENT: f64 = 101_325.0;
pub const HOLLOW: f64 = 1e-6;
pub const RESISTANCE: f64 = 0.1 * AMBIENT / HOLLOW;

/// A block of 70 x 30 x 30 mm with two hollows of 1 mL, and a scene of it through half a second.
pub fn twins(young: f64, chambers: &str) -> Workdir {
    let inside = |p: Vec3, x: f64| (p - Vec3::new(x, 0.015, 0.015)).amax() < 0.006;
    let hole = |cell: [usize; 3]| cell == [1, 1, 1] || cell == [5, 1, 1];
    let body = tag(
        block([7, 3, 3], 0.01, hole, |p| p),
        &[
            ("left", &|p| inside(p, 0.015)),
            ("right", &|p| inside(p, 0.055)),
            ("seat", &|p| p.z < 1e-9),
        ],
    );
    let dir = Workdir::with(&body);
    let scene = format!(
        "mesh = \"body.msh\"\ndegree = 1\n\n[material]\nkind = \"neo-hookean\"\nyoung = {young:e}\npoisson = 0.3\n\n\
         [[fixed]]\non = \"seat\"\n\n{chambers}\n[time]\nend = 0.5\nsteps = 10\nmethod = \"quasistatic\"\n"
    );
    dir.write("p1.toml", &scene);
    dir.write(
        "design.toml",
        "scene = \"p1.toml\"\n\n[shape]\non = \"left\"\n\n[[shape.level]]\nhandles = 3\niterations = 1\n\n\
         [[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = -1e6\non = \"left\"\nmeasure = \"deformed\"\n",
    );
    dir
}

/// A chamber of the twins at the end of a line.
pub fn supplied(tags: &str, supply: &str, leak: f64) -> String {
    format!("[[chamber]]\n{tags}\n{supply}\nresistance = {RESISTANCE:e}\nleak = {leak:e}\n\n")
}

/// The chamber with a plug in its mouth, which nothing holds, for some time.
pub fn plugged() -> Workdir {
    let dir = chamber::workdir();
    let held = SIM.find("[[fixed]]").unwrap()..SIM.find("[[chamber]]").unwrap();
    let scene = dir
        .text("p1.toml")
        .replace("d1 = 1e6", "d1 = 1e6\ndensity = 1000")
        .replace(&SIM[held], "")
        .replace("pressure = 8e3", "pressure = 8e3\nplug = true");
    // the derivatives by density are small
    let time = "\n[solver]\nabsolute_tolerance = 1e-10\n[time]\nend = 0.02\nsteps = 4\nmethod = \"implicit-euler\"\n";
    dir.write("p1.toml", &(scene + time));
    let lift = "\n[[objective]]\nkind = \"displacement\"\nname = \"lift\"\nweight = 1e9\non = \"top\"\n\
                displacement = [0, 0, 1e-3]\nmeasure = \"deformed\"\n";
    dir.write("design.toml", &(VOLUME_DESIGN.replace("handles = 1", "handles = 3") + lift));
    dir
}

/// A block of 1 cm that falls the 2 mm to a floor, and another one 2 cm beside it.
pub fn falling() -> Workdir {
    let dir = Workdir::new();
    let block = tag(block([2, 2, 2], 5e-3, |_| false, |p| p), &[("skin", &|_| true)]);
    dir.put("block.msh", &block);
    write_surface(&dir.path("floor.stl"), &plate([-1.0, 1.0], [-1.0, 1.1], 0.0)).unwrap();
    dir.write(
        "p1.toml",
        &format!(
            "degree = 1\ngravity = [0, 0, -9.8]\n\
             [[body]]\nname = \"a\"\nmesh = \"block.msh\"\ntranslate = [0, 0, 2e-3]\n{SOLID}\
             [[body]]\nname = \"b\"\nmesh = \"block.msh\"\ntranslate = [0.02, 0, 3e-3]\n{SOLID}\
             [[obstacle]]\nname = \"floor\"\nsurface = \"floor.stl\"\n\
             [contact]\nactivation = 1e-4\nstiffness = 1e5\nthickness = 0.0\n\
             [time]\nend = 0.04\nsteps = 10\n"
        ),
    );
    dir
}

/// A block falls onto a floor, and another, which is held above, is moved onto it; they slide.
/// The state before last, lagged contacts, the couplings of contact, and the work of the support
/// all matter.
pub fn sliding() -> Workdir {
    let dir = Workdir::new();
    let top = |p: Vec3| p.z > 12e-3 - 1e-9;
    let block = block([1, 1, 1], 12e-3, |_| false, |p| p);
    let block = tag(block, &[("top", &top), ("skin", &|_| true)]);
    dir.put("block.msh", &block);
    let floor = plate([-1.0, 1.0], [-1.0, 1.1], 0.0);
    write_surface(&dir.path("floor.stl"), &floor).unwrap();
    let material = "{ kind = \"neo-hookean\", young = 3e4, poisson = 0.4, density = 1000.0 }";
    dir.write(
        "sim.toml",
        &format!(
            "degree = 1\ngravity = [0, 0, -9.8]\n\
             [[body]]\nname = \"low\"\nmesh = \"block.msh\"\ntranslate = [0, 0, 3e-4]\n\
             velocity = [0.3, 0, 0]\nmaterial = {material}\n\
             [[body]]\nname = \"high\"\nmesh = \"block.msh\"\ntranslate = [3e-3, 2e-3, 13e-3]\n\
             velocity = [0, 0.1, -0.2]\nmaterial = {material}\n\
             [[fixed]]\non = \"high.top\"\ndisplacement = [0, \"0.1*t\", \"-0.05*t\"]\n\
             [[obstacle]]\nname = \"floor\"\nsurface = \"floor.stl\"\n\
             [contact]\nactivation = 2e-4\nstiffness = 3e4\nfriction = 0.4\n\
             [time]\nmethod = \"bdf2\"\nend = 0.032\nsteps = 16\n"
        ),
    );
    dir
}

/// The chamber, blown up by a pulse whose peak and delay are designed.
pub fn pulsed() -> Workdir {
    let dir = chamber::workdir();
    let pulse =
        dir.text("p1.toml").replace("pressure = 8e3", "pressure = \"peak*max(t - delay, 0)\"");
    let pulse = pulse.replace("\"seat\"\n", "\"seat\"\ndisplacement = [\"1e-5*moved\", 0, 0]\n");
    let time = "[parameters]\npeak = 5e3\ndelay = 0.01\nmoved = 0\n[time]\nmethod = \"quasistatic\"\nend = 1\nsteps = 2\n";
    dir.write("p1.toml", &(pulse + time));
    dir.write(
        "design.toml",
        "scene = \"p1.toml\"\n[optimizer]\niterations = 3\n\
         [[parameter]]\nname = \"peak\"\nbounds = [0, 1e4]\n[[parameter]]\nname = \"delay\"\nbounds = [0, 0.09]\n\
         [[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = 1e6\non = \"cavity\"\nmeasure = \"deformed\"\n",
    );
    dir
}

/// The material of blocks that fall and touch.
pub const SOLID: &str =
    "material = { kind = \"neo-hookean\", young = 1e5, poisson = 0.35, density = 1000.0 }\n";

/// A design of the shape of the chamber at one level, with more in its `[shape]`.
fn shaped(more: &str, handles: usize) -> Workdir {
    let dir = chamber::workdir();
    let (first, rest) = DESIGN.split_once("[[shape.level]]").unwrap();
    let (_, terms) = rest.split_once("[[objective]]").unwrap();
    let level = format!("[[shape.level]]\nhandles = {handles}\niterations = {handles}\n");
    let design = format!("{first}surface_tolerance = 0\n{more}\n{level}\n[[objective]]{terms}");
    dir.write("design.toml", &design.replace("sim.toml", "p1.toml"));
    dir
}

/// The floor of the chamber stays flat.
pub fn kept() -> Workdir {
    shaped("keep = [{ axis = \"z\", at = 0.01 }]", 3)
}

/// The chamber is its own mirror image.
pub const OWN: &str =
    "[[shape.symmetric]]\nof = \"cavity\"\nmirror = { axis = \"y\", at = 0.02 }\n";

/// A design of the chamber with what [`OWN`] may stand for, on a target that is higher on one side.
pub fn alike(symmetric: &str) -> Workdir {
    let dir = shaped(symmetric, 4);
    let mut target = plate([-0.02, 0.07], [-0.02, 0.07], 0.0);
    target.vertices.iter_mut().for_each(|x| x.z = 0.0405 + 0.1 * (x.y - 0.02));
    write_surface(&dir.path("target.stl"), &target).unwrap();
    dir
}

/// A bar of 90 mm with a chamber in each end, both open to the end, as images of each other.
pub fn two_chambers() -> Workdir {
    let dir = alike(
        "[[shape.symmetric]]\nof = [\"cavity\", \"other\"]\nmirror = { axis = \"x\", at = 0.045 }\n",
    );
    let middle = |i: usize| (1..3).contains(&i);
    let hollow = |c: [usize; 3]| c[0] != 4 && middle(c[1]) && middle(c[2]);
    let mesh = block([9, 4, 4], 0.01, hollow, |p| p);
    let inner = |x: f64| x > 0.009 && x < 0.031;
    let body = tag(
        mesh,
        &[
            ("seat", &|p| p.x < 1e-6 || p.x > 0.09 - 1e-6),
            ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z)),
            ("other", &|p| p.x > 0.049 && inner(p.y) && inner(p.z)),
            ("top", &|p| p.z > 0.04 - 1e-6),
            ("skin", &|_| true),
        ],
    );
    dir.put("body.msh", &body);
    let design = dir.text("design.toml");
    dir.write(
        "design.toml",
        &design.replacen("on = \"cavity\"", "on = [\"cavity\", \"other\"]", 1),
    );
    dir
}
