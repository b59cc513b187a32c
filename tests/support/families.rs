//! Random bodies that are hard to mesh: each seed makes one model file, of a family that asks for
//! something else than `bodies.rs` does.
//!
//! Of each the functions are sound, but not made for their grid: grooves that narrow to nothing,
//! surfaces that touch or coincide, walls of less than a cell, planes through points of the lattice.

use std::fmt::Write;

use mechanics::math::random::Random;

use crate::bodies::{Point, block, capsule, sphere};

/// Adds a body at random to a model file.
type Build = fn(&mut Family);

/// The families, which take turns.
const FAMILIES: [(&str, Build); 4] = [
    ("lobes", lobes),
    ("shell", shell),
    ("tangents", tangents),
    ("through points", through_points),
];

/// A model file that grows. Lengths are millimetres.
pub struct Family {
    random: Random,
    grid: f64,
    text: String,
    count: usize,
}

/// The name of the family of a seed, and its model file.
pub fn body(seed: u64) -> (&'static str, String) {
    let (name, build) = FAMILIES[(seed % FAMILIES.len() as u64) as usize];
    let mut random = Random::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    random.numbers(8);
    let mut family = Family { random, grid: 1.0, text: String::new(), count: 0 };
    build(&mut family);
    let (grid, simplify) = (family.grid, family.grid * family.between(-0.05, 0.1).max(0.0));
    let head = format!("unit = \"mm\"\ngrid = {grid}\nsimplify = {simplify:.4}\n");
    (name, head + &family.text + "[[region]]\nname = \"all\"\nrest = true\n")
}

impl Family {
    /// Uniform from `a` to `b`.
    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (0.5 + 0.5 * self.random.uniform())
    }

    fn whole(&mut self, a: usize, b: usize) -> usize {
        (self.between(a as f64, b as f64 + 1.0) as usize).clamp(a, b)
    }

    fn point(&mut self, half: f64) -> Point {
        [0; 3].map(|_| self.between(-half, half))
    }

    /// A primitive of `list`, `solid` or `cavity`, with further keys.
    fn add(&mut self, list: &str, shape: &str, keys: &str) {
        self.count += 1;
        let name = self.count;
        let _ = writeln!(self.text, "[[{list}]]\nname = \"p{name}\"\nshape.{shape}\n{keys}");
    }

    fn cut(&mut self, normal: Point, offset: f64) {
        self.count += 1;
        let name = self.count;
        let _ = writeln!(
            self.text,
            "[[cut]]\nname = \"c{name}\"\nnormal = {normal:?}\noffset = {offset:?}"
        );
    }
}

fn blend(k: f64) -> String {
    format!("blend = {k:?}")
}

/// Fingers that leave a hub at small angles: the grooves between them narrow to nothing.
fn lobes(f: &mut Family) {
    let n = f.whole(3, 8);
    let spread = f.between(0.15, 0.8);
    let radius = f.between(2.0, 5.0);
    f.grid = f.between(0.5, 1.2);
    f.add("solid", &sphere([0.0; 3], 1.3 * radius), "");
    for k in 0..n {
        let turn = spread * (k as f64 - n as f64 / 2.0);
        let (length, rise) = (f.between(15.0, 30.0), f.between(-3.0, 3.0));
        let thin = radius * f.between(0.4, 1.0);
        let soft = f.between(-1.0, 1.0).max(0.0);
        let tip = [length * turn.cos(), length * turn.sin(), rise];
        f.add("solid", &capsule([0.0; 3], tip, [radius, thin]), &blend(soft));
    }
    let inner = f.between(0.2, 0.8) * radius;
    f.add("cavity", &sphere([0.0; 3], inner), "");
    f.cut([0.0, 0.0, -1.0], 0.5 * radius);
}

/// A chamber that is the body itself, smaller by a thin wall.
fn shell(f: &mut Family) {
    f.grid = f.between(0.8, 1.5);
    let wall = f.grid * f.between(0.15, 2.0);
    let size = [0; 3].map(|_| f.between(12.0, 25.0));
    let turn = f.point(60.0);
    match f.whole(0, 2) {
        0 => {
            let radii = size.map(|s| s / 2.0);
            let shape = |less: f64| {
                let radii = radii.map(|r| r - less);
                format!(
                    "ellipsoid = {{ center = [0, 0, 0], radii = {radii:?}, rotation = {turn:?} }}"
                )
            };
            f.add("solid", &shape(0.0), "");
            f.add("cavity", &shape(wall), "");
        }
        1 => {
            let round = f.between(0.0, 4.0);
            let shape = |less: f64| {
                let (size, round) = (size.map(|s| s - 2.0 * less), (round - less).max(0.0));
                format!(
                    "box = {{ center = [0, 0, 0], size = {size:?}, rounding = {round:?}, rotation = {turn:?} }}"
                )
            };
            f.add("solid", &shape(0.0), "");
            f.add("cavity", &shape(wall), "");
        }
        _ => {
            let (to, radii) = (f.point(12.0), [f.between(4.0, 8.0), f.between(4.0, 8.0)]);
            f.add("solid", &capsule([0.0; 3], to, radii), "");
            f.add("cavity", &capsule([0.0; 3], to, radii.map(|r| r - wall)), "");
        }
    }
    if f.between(0.0, 1.0) < 0.5 {
        let (lean, offset) = (f.point(1.0), f.between(-1.0, 1.0));
        f.cut(lean, offset);
    }
}

/// Balls and blocks that touch each other, the chamber and planes in points, edges and faces, on a slab.
fn tangents(f: &mut Family) {
    f.grid = [0.5, 0.75, 1.0, 1.1][f.whole(0, 3)];
    f.add("solid", &block([0.0, 0.0, -1.5], [30.0, 30.0, 3.0], 0.0), "");
    let radius = f.whole(3, 6) as f64;
    // They stand on the slab, by a point and by a face, and touch each other.
    f.add("solid", &sphere([-radius, 0.0, radius - 0.5], radius), "");
    f.add("solid", &sphere([radius, 0.0, radius - 0.5], radius), "");
    let side = f.whole(2, 6) as f64;
    f.add(
        "solid",
        &block([0.0, radius + side / 2.0, side / 2.0], [2.0 * side, side, side], 0.0),
        "",
    );
    let deep = f.whole(1, 2) as f64;
    f.add("cavity", &block([-8.0, -8.0, -1.5], [4.0, 4.0, deep], 0.0), "");
    f.add("cavity", &block([-4.0, -8.0, -1.5], [4.0, 4.0, deep], 0.0), "");
    f.add("cavity", &sphere([radius, 0.0, radius - 0.5], radius - 1.0), "");
    f.cut([0.0, 0.0, -1.0], 3.0);
    f.cut([0.0, 0.0, 1.0], 2.0 * radius - 0.5);
}

/// Planes, edges and corners exactly through points of the lattice.
fn through_points(f: &mut Family) {
    f.grid = [0.5, 1.0, 2.0][f.whole(0, 2)];
    let (h, half) = (f.grid, |f: &mut Family| f.whole(8, 16) as f64);
    let size = [half(f) * h, half(f) * h, half(f) * h];
    f.add("solid", &block([0.0; 3], size, 0.0), "");
    let inner = size.map(|s| s - 2.0 * h * (1.0 + f.whole(0, 3) as f64 / 2.0));
    f.add("cavity", &block([0.0; 3], inner, 0.0), "");
    if f.between(0.0, 1.0) < 0.5 {
        let radius = h * f.whole(4, 8) as f64 / 2.0;
        f.add("solid", &sphere([size[0] / 2.0, 0.0, 0.0], radius), "");
    }
    let normals = [[1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [1.0, 1.0, 1.0], [0.0, 0.0, -1.0]];
    for normal in normals {
        if f.between(0.0, 1.0) < 0.5 {
            let norm = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            let steps = f.whole(3, 6) as f64;
            f.cut(normal, steps * h / norm);
        }
    }
}
