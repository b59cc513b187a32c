//! Random sound bodies: each seed makes one model file, of a kind that people cast.
//!
//! All are one piece that can be cast: lengths from 25 to 160 mm, walls of 2 mm or more, inlets of
//! 3 mm or more that face down.

use std::fmt::Write;

use mechanics::math::random::Random;

/// A random body.
pub struct Body {
    /// What kind of body it is.
    pub kind: &'static str,
    /// The model file for `cad2fem model`.
    pub model: String,
}

type Kind = (&'static str, fn(&mut Builder));

const KINDS: [Kind; 11] = [
    ("box", |b| _ = cuboid(b, true, 0.0)),
    ("rounded box", |b| _ = cuboid(b, true, 0.3)),
    ("closed box", |b| _ = cuboid(b, false, 0.0)),
    ("box on its cut", box_on_its_cut),
    ("dome", dome),
    ("finger", finger),
    ("bellows", bellows),
    ("arm", arm),
    ("star", star),
    ("oblique", oblique),
    ("tube", tube),
];

impl Body {
    /// The body of a seed. Kinds take turns, so that 11 seeds in a row have them all.
    pub fn new(seed: u64) -> Self {
        let (kind, build) = KINDS[(seed % KINDS.len() as u64) as usize];
        let mut builder = Builder::new(seed);
        build(&mut builder);
        Self { kind, model: builder.finish() }
    }
}

/// The tags of bodies, whose patches have these names.
pub fn tags(patches: &[&str]) -> String {
    let tag = |name: &&str| format!("[[tag]]\nname = \"{name}\"\npatch = \"{name}.stl\"\n");
    "relative_epsilon = 4e-3\n".to_owned() + &patches.iter().map(tag).collect::<String>()
}

/// A model file that grows. Lengths are millimetres.
struct Builder {
    random: Random,
    /// Length of the body [mm].
    length: f64,
    /// Least wall around chambers [mm].
    wall: f64,
    primitives: String,
    cuts: String,
    count: usize,
}

impl Builder {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed.wrapping_mul(0x1000_0001));
        random.numbers(8);
        let length = 25.0 * (160.0_f64 / 25.0).powf(0.5 + 0.5 * random.uniform());
        let wall = (length * (0.075 + 0.025 * random.uniform())).max(2.0);
        let empty = String::new;
        Self { random, length, wall, primitives: empty(), cuts: empty(), count: 0 }
    }

    /// Uniform from `a` to `b`.
    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (0.5 + 0.5 * self.random.uniform())
    }

    fn whole(&mut self, a: usize, b: usize) -> usize {
        (self.between(a as f64, b as f64 + 1.0) as usize).clamp(a, b)
    }

    /// A primitive of `list`, `solid` or `cavity`.
    fn add(&mut self, list: &str, shape: &str, blend: f64) {
        let name = self.count;
        self.count += 1;
        let _ = writeln!(self.primitives, "[[{list}]]\nname = \"p{name}\"\nshape.{shape}");
        if blend > 0.0 {
            let _ = writeln!(self.primitives, "blend = {blend:.4}");
        }
    }

    fn cut(&mut self, name: &str, normal: [f64; 3], offset: f64) {
        let _ = writeln!(
            self.cuts,
            "[[cut]]\nname = \"{name}\"\nnormal = {normal:?}\noffset = {offset:.4}"
        );
    }

    /// The flat face at z = 0, above which the body stands.
    fn ground(&mut self) {
        self.cut("seat", [0.0, 0.0, -1.0], 0.0);
    }

    fn finish(mut self) -> String {
        let grid = self.length * self.between(0.022, 0.04);
        let simplify = grid * self.between(0.0, 0.1);
        let mut text = format!("unit = \"mm\"\ngrid = {grid:.4}\nsimplify = {simplify:.4}\n");
        text += &self.primitives;
        text += &self.cuts;
        if self.cuts.contains("\"seat\"") {
            text += "[[region]]\nname = \"seat\"\ncut = \"seat\"\n";
        }
        text += "[[region]]\nname = \"cavity\"\ncavity = true\n";
        text + "[[region]]\nname = \"rest\"\nrest = true\n"
    }
}

pub type Point = [f64; 3];

pub fn sphere(center: Point, radius: f64) -> String {
    format!("sphere = {{ center = {}, radius = {radius:.4} }}", list(center))
}

fn ellipsoid(center: Point, radii: Point) -> String {
    format!("ellipsoid = {{ center = {}, radii = {} }}", list(center), list(radii))
}

pub fn capsule(from: Point, to: Point, radii: [f64; 2]) -> String {
    let [r, s] = radii;
    format!("capsule = {{ from = {}, to = {}, radii = [{r:.4}, {s:.4}] }}", list(from), list(to))
}

fn cylinder(from: Point, to: Point, radius: f64) -> String {
    format!("cylinder = {{ from = {}, to = {}, radius = {radius:.4} }}", list(from), list(to))
}

pub fn block(center: Point, size: Point, rounding: f64) -> String {
    format!(
        "box = {{ center = {}, size = {}, rounding = {rounding:.4} }}",
        list(center),
        list(size)
    )
}

fn list(p: Point) -> String {
    format!("[{:.4}, {:.4}, {:.4}]", p[0], p[1], p[2])
}

/// A box on the ground with a box-shaped chamber, with a bore to it or without; its size.
fn cuboid(b: &mut Builder, bore: bool, rounding: f64) -> Point {
    let (l, w) = (b.length, b.wall);
    let size = [l * b.between(0.5, 1.0), l * b.between(0.5, 1.0), l * b.between(0.5, 1.0)];
    let round = |size: Point| 0.5 * rounding * size.into_iter().fold(f64::INFINITY, f64::min);
    // the body reaches below the ground, where it is cut
    let (center, whole) =
        ([0.0, 0.0, size[2] / 2.0 - l / 8.0], [size[0], size[1], size[2] + l / 4.0]);
    b.add("solid", &block(center, whole, round(size)), 0.0);
    let play = w * b.between(0.0, 1.0);
    let chamber = size.map(|s| s - 2.0 * w - play);
    let shift = play * b.between(-0.5, 0.5);
    b.add("cavity", &block([shift, 0.0, size[2] / 2.0], chamber, round(chamber)), 0.0);
    if bore {
        let radius = 0.5 * chamber[0].min(chamber[1]) * b.between(0.4, 0.8);
        b.add("cavity", &cylinder([shift, 0.0, -l], [shift, 0.0, size[2] / 2.0], radius), 0.0);
    }
    b.ground();
    size
}

/// The bottom of the box lies in the plane of the cut, and its chamber is open below.
fn box_on_its_cut(b: &mut Builder) {
    let (l, w) = (b.length, b.wall);
    // a height that the file holds, so that its half is there, too
    let height = (l * b.between(0.5, 0.8) * 1e3).round() / 1e3;
    let size = [l, l * b.between(0.5, 1.0), height];
    b.add("solid", &block([0.0, 0.0, height / 2.0], size, 0.0), 0.0);
    let [x, y, z] = [size[0] - 2.0 * w, size[1] - 2.0 * w, size[2] - w];
    // its side is that of the bore to it: both are tangent
    b.add("cavity", &block([0.0, 0.0, w + (z - w) / 2.0], [x, y, z - w], 0.0), 0.0);
    b.add("cavity", &cylinder([0.0, 0.0, -w], [0.0, 0.0, z / 2.0], y / 2.0), 0.0);
    b.ground();
}

/// Half an ellipsoid with an ellipsoid in it and a bore.
fn dome(b: &mut Builder) {
    let (l, w) = (b.length, b.wall);
    let radii = [l / 2.0, l * b.between(0.35, 0.5), l * b.between(0.4, 0.6)];
    b.add("solid", &ellipsoid([0.0; 3], radii), 0.0);
    let high = (radii[2] - 2.2 * w) / 2.0;
    let inner = [0.55 * radii[0], 0.55 * radii[1], high];
    b.add("cavity", &ellipsoid([0.0, 0.0, 1.1 * w + high], inner), 0.0);
    let bore = inner[1] * b.between(0.4, 0.7);
    b.add("cavity", &cylinder([0.0, 0.0, -w], [0.0, 0.0, 1.1 * w + high], bore), 0.5 * w);
    b.ground();
}

/// A slender box with a row of chambers on one bore.
fn finger(b: &mut Builder) {
    let l = b.length.max(60.0);
    let (n, wide) = (b.whole(3, 6), l * b.between(0.22, 0.3));
    let w = 0.2 * wide;
    b.add("solid", &block([0.0, 0.0, 0.45 * l], [wide, wide, 1.1 * l], 0.1 * wide), 0.0);
    let pitch = (l - 2.0 * w) / n as f64;
    let top = w + (n as f64 - 0.5) * pitch;
    let bore = 0.5 * (wide - 2.0 * w) * b.between(0.5, 0.8);
    b.add("cavity", &cylinder([0.0, 0.0, -0.2 * l], [0.0, 0.0, top], bore), 0.0);
    for k in 0..n {
        let z = w + (k as f64 + 0.5) * pitch;
        let chamber = [wide - 2.0 * w, wide - 2.0 * w, pitch - w];
        b.add("cavity", &block([0.0, 0.0, z], chamber, 0.05 * pitch), 0.0);
    }
    b.ground();
}

/// A pile of ellipsoids with a flat chamber in each, on one bore.
fn bellows(b: &mut Builder) {
    let (l, w) = (b.length.max(50.0), 0.08 * b.length.max(50.0));
    let (n, radius) = (b.whole(3, 4), l * b.between(0.3, 0.4));
    let pitch = l / n as f64;
    let at = |k: usize| [0.0, 0.0, (k as f64 + 0.5) * pitch];
    for k in 0..n {
        b.add("solid", &ellipsoid(at(k), [radius, radius, 0.62 * pitch + w / 2.0]), 0.15 * pitch);
    }
    let chamber = [radius - 1.3 * w, radius - 1.3 * w, 0.5 * (pitch - w)];
    for k in 0..n {
        b.add("cavity", &ellipsoid(at(k), chamber), 0.0);
    }
    let [x, y, top] = at(n - 1);
    b.add("cavity", &cylinder([x, y, -l], [x, y, top], 0.45 * radius), 0.3 * w);
    b.ground();
}

/// A chain of limbs, each thinner than the one before it.
fn arm(b: &mut Builder) {
    let l = b.length.max(60.0);
    let n = b.whole(2, 4);
    let mut radius = l * b.between(0.14, 0.2);
    let mut from = [0.0, 0.0, -radius];
    for k in 0..n {
        let step = l / n as f64;
        let lean = if k == 0 { 0.0 } else { b.between(-0.8, 0.8) };
        let aside = 0.3 * step * lean.abs() * b.between(-1.0, 1.0);
        let to = [from[0] + step * lean, from[1] + aside, from[2] + step];
        let thinner = radius * b.between(0.8, 0.95);
        b.add("solid", &capsule(from, to, [radius, thinner]), 0.0);
        b.add("cavity", &capsule(from, to, [0.6 * radius, 0.6 * thinner]), 0.0);
        (from, radius) = (to, thinner);
    }
    b.ground();
}

/// Arms around a hub.
fn star(b: &mut Builder) {
    let (l, n) = (b.length.max(60.0), b.whole(3, 5));
    let thick = l * b.between(0.13, 0.17);
    let w = 0.3 * thick;
    let center = [0.0, 0.0, thick * b.between(0.7, 0.9)];
    b.add("solid", &sphere(center, 1.3 * thick), 0.0);
    // chambers stay above the ground by a wall
    let most = center[2] - w;
    b.add("cavity", &sphere(center, most), 0.0);
    let tip = thick * b.between(0.7, 1.0);
    for k in 0..n {
        let angle = std::f64::consts::TAU * k as f64 / n as f64;
        let to = [l / 2.0 * angle.cos(), l / 2.0 * angle.sin(), center[2]];
        b.add("solid", &capsule(center, to, [thick, tip]), w);
        let inner = [(thick - w).min(0.9 * most), (tip - w).min(0.9 * most)];
        b.add("cavity", &capsule(center, to, inner), w);
    }
    b.add("cavity", &cylinder([0.0, 0.0, -thick], center, 0.7 * most), 0.0);
    b.ground();
}

/// A rounded box of which a plane cuts off a corner, a wall away from the chamber.
fn oblique(b: &mut Builder) {
    let w = b.wall;
    let [x, y, z] = cuboid(b, true, 0.15);
    let lean = [b.between(-0.5, 0.5), b.between(-0.5, 0.5), 1.0];
    let norm = (lean[0] * lean[0] + lean[1] * lean[1] + 1.0_f64).sqrt();
    let chamber = lean[0].abs() * (x / 2.0 - w) + lean[1].abs() * (y / 2.0 - w) + z - w;
    b.cut("top", lean, chamber / norm + w);
}

/// A tube with flat ends and a narrower bore.
fn tube(b: &mut Builder) {
    let (l, w) = (b.length, b.wall);
    let radius = l * b.between(0.3, 0.5);
    b.add("solid", &cylinder([0.0, 0.0, -0.1 * l], [0.0, 0.0, l], radius), 0.0);
    b.add("cavity", &cylinder([0.0, 0.0, w], [0.0, 0.0, l - w], radius - w), 0.0);
    let bore = (radius - w) * b.between(0.4, 0.7);
    b.add("cavity", &cylinder([0.0, 0.0, -0.2 * l], [0.0, 0.0, 1.5 * w], bore), 0.0);
    b.ground();
}
