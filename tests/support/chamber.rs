//! A block with an air chamber that is open at its fixed end: the body, scene
//! and design problem of most tests.

use mechanics::body::Body;
use mesh::io::write_surface;

use crate::workdir::Workdir;
use crate::{Place, block, plate, tag};

/// Side of the mouth of the chamber [m]; it is a square.
pub const MOUTH: f64 = 0.02;

/// Gas pressure of the scene [Pa].
pub const PRESSURE: f64 = 8e3;

/// A scene on the chamber with quadratic elements.
pub const SIM: &str = r#"
mesh = "body.msh"
degree = 2

[material]
kind = "mooney-rivlin"
c1 = 55e3
c2 = 5e3
c3 = 1.7e3
d1 = 1e6

[[fixed]]
on = "seat"

[[chamber]]
on = "cavity"
pressure = 8e3
"#;

/// How far its top rises, and the volume of its chamber.
pub const PROBES: &str = r#"
[[probe]]
name = "top"
kind = "displacement"
on = "top"
axis = [0, 0, 1]

[[probe]]
name = "air"
kind = "volume"
on = "cavity"
"#;

/// The top should bulge up to a plane above it; all kinds of terms take part.
pub const DESIGN: &str = r#"
scene = "sim.toml"

[optimizer]
first_step = 0.1

[shape]
on = "cavity"

[[shape.level]]
handles = 1
iterations = 3

[[shape.level]]
handles = 3
iterations = 3

[[objective]]
kind = "target"
name = "top"
weight = 1e10
on = "top"
target = "target.stl"
spacing = 2e-3

[[objective]]
kind = "wall-thickness"
name = "wall"
weight = 1e5
on = "cavity"
against = ["top", "skin"]
minimum = 2e-3
activation = 9e-3

[[objective]]
kind = "smoothness"
name = "smooth"
weight = 1e-3
on = "cavity"

[[objective]]
kind = "clearance"
name = "clear"
weight = 1.0
activation = 5e-5
"#;

/// A design of the shape of the chamber for its volume under load, in `p1.toml`.
pub const VOLUME_DESIGN: &str = r#"
scene = "p1.toml"

[shape]
on = "cavity"

[[shape.level]]
handles = 1
iterations = 1

[[objective]]
kind = "volume"
name = "air"
weight = 1e6
on = "cavity"
volume = 2e-5
measure = "deformed"
"#;

/// 50 × 40 × 40 mm with a chamber of 40 × 20 × 20 mm that opens to x = 0, of 384
/// tetrahedra. Tags: `seat` around the mouth, `cavity`, `top`, and `skin` for
/// the rest.
pub fn chamber() -> Body {
    refined(1)
}

/// The same in cells of 10 mm / n.
pub fn refined(n: usize) -> Body {
    body(n, &[("top", &|p| p.z > 0.04 - 1e-6), ("skin", &|_| true)])
}

/// The same with other tags of its outside: `tip` at the closed end, and `side` around.
pub fn wound(n: usize) -> Body {
    body(n, &[("tip", &|p| p.x > 0.05 - 1e-6), ("side", &|_| true)])
}

/// The same with `seat`, `cavity` and these tags.
pub fn body(n: usize, outside: &[(&str, Place)]) -> Body {
    let middle = |i: usize| (n..3 * n).contains(&i);
    let hollow = |c: [usize; 3]| c[0] < 4 * n && middle(c[1]) && middle(c[2]);
    let mesh = block([5 * n, 4 * n, 4 * n], 0.01 / n as f64, hollow, |p| p);
    let inner = |x: f64| x > 0.009 && x < 0.031;
    let inside: [(&str, Place); 2] =
        [("seat", &|p| p.x < 1e-6), ("cavity", &|p| p.x < 0.041 && inner(p.y) && inner(p.z))];
    tag(mesh, &[&inside, outside].concat())
}

/// A folder with `body.msh`, `sim.toml`, `design.toml` and `target.stl`. The
/// designs are made with linear elements, which are fast.
pub fn workdir() -> Workdir {
    let body = chamber();
    let dir = Workdir::with(&body);
    dir.write("sim.toml", SIM);
    dir.write("p1.toml", &SIM.replace("degree = 2", "degree = 1"));
    dir.write("design.toml", &DESIGN.replace("sim.toml", "p1.toml"));
    // half a millimetre above the top, and larger than it
    let target = plate([-0.02, 0.07], [-0.02, 0.07], 0.0405);
    write_surface(&dir.path("target.stl"), &target).expect("a sound surface");
    dir
}

/// [`workdir`] with another body, and more tables in its scene of linear elements.
pub fn with(body: &Body, tables: &str) -> Workdir {
    let dir = workdir();
    dir.put("body.msh", body);
    dir.write("p1.toml", &(dir.text("p1.toml") + tables));
    dir
}

/// A folder whose `p1.toml` has a pressure not far from where it balloons, and a silicone that tears before.
pub fn near_its_edges() -> Workdir {
    let dir = workdir();
    // it tears between its state under pressure and its limit
    let tears = "d1 = 1e6\nstretch_at_break = 2";
    let scene = dir.text("p1.toml").replace("8e3", "60e3").replace("d1 = 1e6", tears);
    dir.write("p1.toml", &(scene + "\n[limit]\nmost = 4\n"));
    dir
}

/// A scene with a pressure above the limit point, and settings that end the search soon.
pub fn beyond_any_equilibrium(scene: &str) -> String {
    let soon = "[solver]\nsmallest_load_step = 0.1\nnewton_iterations = 8\n\n[material]";
    scene.replace("8e3", "1e8").replace("[material]", soon)
}
