//! Random paths of features, checked by an independent formula of the distance:
//! between two times it changes by no more than the path of the corners, so that
//! few samples prove that nothing touches in between.

use twofloat::TwoFloat;

use super::*;
use crate::math::random::Random;

const KINDS: [Pair; 2] = [Pair::PointTriangle([0, 1, 2, 3]), Pair::EdgeEdge([0, 1, 2, 3])];

/// Scale and distance from the origin in its units.
const PLACES: [(f64, f64); 5] = [(1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 1e3), (1e-3, 1e3)];

/// The corners of a pair at the ends of their paths, and the minimum distance.
struct Path {
    pair: Pair,
    start: [Vec3; 4],
    end: [Vec3; 4],
    thickness: f64,
}

impl Path {
    /// Corners at relative time `t`, as seen from the first of them.
    fn at(&self, t: f64) -> [Vec3; 4] {
        let moved = |i: usize| self.end[i] - self.start[i];
        std::array::from_fn(|i| self.start[i] - self.start[0] + t * (moved(i) - moved(0)))
    }

    fn at_precisely(&self, t: f64) -> [[TwoFloat; 3]; 4] {
        let x = |i: usize, k: usize| {
            let (a, b) = (TwoFloat::from(self.start[i][k]), TwoFloat::from(self.end[i][k]));
            a + (b - a) * t
        };
        std::array::from_fn(|i| std::array::from_fn(|k| x(i, k)))
    }

    /// d(t) − thickness, with relative errors of d of at most 1e-5.
    fn gap(&self, t: f64) -> f64 {
        let x = self.at(t);
        let size = x.iter().fold(0.0, |all: f64, p| all.max(p.norm()));
        let d = distance(self.pair, &x.map(|p| [p.x, p.y, p.z]), 1e-3);
        match d {
            Some(d) if d > 1e-6 * size && d - self.thickness > 1e-5 * d => d - self.thickness,
            _ => {
                let d = distance(self.pair, &self.at_precisely(t), 0.0);
                f64::from(d.expect("no condition") - TwoFloat::from(self.thickness))
            }
        }
    }

    /// Largest change of the distance in unit time.
    fn speed(&self) -> f64 {
        let v: [Vec3; 4] = std::array::from_fn(|i| self.end[i] - self.start[i]);
        across(self.pair).map(|(i, j)| (v[i] - v[j]).norm()).fold(0.0, f64::max)
    }

    /// Nothing for a path that is free, or a time shortly before contact.
    fn contact(&self) -> Option<f64> {
        let speed = self.speed();
        let shortest = 1e-2 * self.gap(0.0) / speed;
        self.contact_between(0.0, 1.0, speed, shortest)
    }

    fn contact_between(&self, from: f64, to: f64, speed: f64, shortest: f64) -> Option<f64> {
        let middle = 0.5 * (from + to);
        if (1.0 - 1e-5) * self.gap(middle) > 0.5 * (to - from) * speed {
            return None;
        }
        if to - from < shortest {
            return Some(from);
        }
        let earlier = self.contact_between(from, middle, speed, shortest);
        earlier.or_else(|| self.contact_between(middle, to, speed, shortest))
    }
}

/// Distance of two features; none where the sine of their angle is below
/// `flattest`.
fn distance<T: Real>(pair: Pair, x: &[[T; 3]; 4], flattest: f64) -> Option<T> {
    let zero = T::from(0.0);
    let edges = match pair {
        Pair::PointTriangle(_) => [sub(x[2], x[1]), sub(x[3], x[1])],
        Pair::EdgeEdge(_) => [sub(x[1], x[0]), sub(x[3], x[2])],
    };
    let n = cross(edges[0], edges[1]);
    let n2 = dot(n, n);
    let least = T::from(flattest * flattest) * dot(edges[0], edges[0]) * dot(edges[1], edges[1]);
    if n2 < least {
        return None;
    }
    let ends: &[[usize; 3]] = match pair {
        Pair::PointTriangle(_) => &[[0, 1, 2], [0, 2, 3], [0, 3, 1]],
        Pair::EdgeEdge(_) => &[[0, 2, 3], [1, 2, 3], [2, 0, 1], [3, 0, 1]],
    };
    let mut d2 = to_segment(x, ends[0]);
    for &end in &ends[1..] {
        let other = to_segment(x, end);
        d2 = if other < d2 { other } else { d2 };
    }
    if n2 > zero {
        let w = match pair {
            Pair::PointTriangle(_) => sub(x[0], x[1]),
            Pair::EdgeEdge(_) => sub(x[2], x[0]),
        };
        let (s, t) = (dot(cross(w, edges[1]), n) / n2, dot(cross(edges[0], w), n) / n2);
        let one = T::from(1.0);
        let inside = match pair {
            Pair::PointTriangle(_) => s > zero && t > zero && s + t < one,
            // w and t are reversed
            Pair::EdgeEdge(_) => s > zero && s < one && t < zero && t > zero - one,
        };
        if inside {
            let h = dot(w, n);
            d2 = h * h / n2;
        }
    }
    Some(d2.root())
}

trait Real:
    Copy
    + PartialOrd
    + From<f64>
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
{
    fn root(self) -> Self;
}

impl Real for f64 {
    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Real for TwoFloat {
    fn root(self) -> Self {
        self.sqrt()
    }
}

fn sub<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

/// Squared distance of corner `p` from the segment between two others.
fn to_segment<T: Real>(x: &[[T; 3]; 4], [p, i, j]: [usize; 3]) -> T {
    let (zero, one) = (T::from(0.0), T::from(1.0));
    let (edge, w) = (sub(x[j], x[i]), sub(x[p], x[i]));
    let length2 = dot(edge, edge);
    let t = if length2 > zero { dot(w, edge) / length2 } else { zero };
    let t = if t < zero {
        zero
    } else if t > one {
        one
    } else {
        t
    };
    let r: [T; 3] = std::array::from_fn(|k| w[k] - t * edge[k]);
    dot(r, r)
}

/// Corners of features that touch.
fn touching(pair: Pair, random: &mut Random) -> [Vec3; 4] {
    let mut x: [Vec3; 4] = std::array::from_fn(|_| random.vector());
    let share = |random: &mut Random| 0.5 + 0.5 * random.uniform();
    let (s, t) = (share(random), share(random));
    match pair {
        Pair::PointTriangle(_) => {
            let (a, b) = (s * (1.0 - t), s * t);
            x[0] = x[1] + a * (x[2] - x[1]) + b * (x[3] - x[1]);
        }
        Pair::EdgeEdge(_) => {
            let apart = x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2]);
            x[2] += apart;
            x[3] += apart;
        }
    }
    x
}

/// A power of ten with an exponent in `low..high`.
fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10_f64.powf(low + (high - low) * 0.5 * (1.0 + random.uniform()))
}

/// Kinds of paths, by the corners at the start and the end.
type Family = fn(Pair, &mut Random) -> [[Vec3; 4]; 2];

/// Any corners at both ends.
fn anything(_: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    std::array::from_fn(|_| std::array::from_fn(|_| random.vector()))
}

/// Features in touch at one time, shortly after the start or later.
fn hitting(pair: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    let x = touching(pair, random);
    let v: [Vec3; 4] = std::array::from_fn(|_| 2.0 * random.vector());
    let t = power(random, -3.0, 0.0);
    [-t, 1.0 - t].map(|t| std::array::from_fn(|i| x[i] + t * v[i]))
}

/// Features in touch at one time, all in one plane.
fn coplanar(pair: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    let mut flat = random.clone();
    random.uniform();
    let mut x: [Vec3; 4] = std::array::from_fn(|_| flat.vector());
    let v: [Vec3; 4] = std::array::from_fn(|_| flat.vector());
    // touching by a corner of the first and an edge of the second
    let t = 0.5 + 0.5 * flat.uniform();
    let apart = x[0] - x[2] - t * (x[3] - x[2]);
    (pair.corners_of_first()..4).for_each(|j| x[j] += apart);
    let t = power(random, -3.0, 0.0);
    let plane = |p: Vec3| Vec3::new(p.x, p.y, 0.0);
    [-t, 1.0 - t].map(|t| std::array::from_fn(|i| plane(x[i] + t * v[i])))
}

/// Each feature stays in a plane of its own, and the planes are close.
fn sliding(pair: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    let gap = power(random, -3.0, 0.0);
    anything(pair, random).map(|x| {
        std::array::from_fn(|i| {
            let height = if i < pair.corners_of_first() { gap } else { 0.0 };
            Vec3::new(x[i].x, x[i].y, height)
        })
    })
}

/// No motion relative to each other.
fn still(pair: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    let [x, [drift, ..]] = anything(pair, random);
    let drift = drift * if random.uniform() < 0.0 { 0.0 } else { 100.0 };
    [x, x.map(|p| p + drift)]
}

/// Edges that are parallel, nearly or exactly, or a triangle that is a needle;
/// at a small distance, moving towards each other and along.
fn parallel(pair: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    let exactly = random.uniform() < -0.5;
    let tilt = if exactly { 0.0 } else { power(random, -18.0, -2.0) };
    let gap = power(random, -7.0, 0.0);
    let x: [Vec3; 4] = std::array::from_fn(|i| {
        let height = if i < pair.corners_of_first() { gap } else { 0.0 };
        let bent = tilt * random.vector();
        Vec3::new(random.uniform(), bent.y, height + 0.5 * gap * bent.z)
    });
    let v = gap * Vec3::new(10.0 * random.uniform(), random.uniform(), 3.0 * random.uniform());
    let first = pair.corners_of_first();
    [x, std::array::from_fn(|i| if i < first { x[i] + v } else { x[i] })]
}

/// Edges without length and triangles without area, in touch at one time.
fn degenerate(pair: Pair, random: &mut Random) -> [[Vec3; 4]; 2] {
    let [mut start, mut end] = hitting(pair, random);
    for x in [&mut start, &mut end] {
        let apart = x[0] - x[3];
        match pair {
            Pair::PointTriangle(_) => x[2] = x[1],
            Pair::EdgeEdge(_) => x[1] = x[0],
        }
        x[3] += 0.5 * apart;
    }
    [start, end]
}

fn time_of_impact(pair: Pair, start: &[Vec3; 4], end: &[Vec3; 4], thickness: f64) -> f64 {
    time_within(1.0, pair, start, end, thickness)
}

/// What became of a path.
struct Outcome {
    /// Returned over true time to contact, if there is one.
    ratio: Option<f64>,
    /// Gap left over what shall be kept.
    left: f64,
    /// Whether the path was shortened.
    cut: bool,
}

/// Follows `count` paths of a family and proves each result.
fn follow(family: Family, pair: Pair, place: (f64, f64), seed: u64, count: usize) -> Vec<Outcome> {
    let mut random = Random::new(seed);
    let mut all = Vec::new();
    while all.len() < count {
        let corners = family(pair, &mut random);
        let (scale, far) = place;
        let shift = Vec3::new(1.0, -0.7, 0.3) * far;
        let [start, end] = corners.map(|x| x.map(|p| scale * (p + shift)));
        let mut path = Path { pair, start, end, thickness: 0.0 };
        let d0 = path.gap(0.0);
        // what rounding of the positions decides proves nothing
        if d0 < 1e-9 * scale * (1.0 + far) {
            continue;
        }
        if random.uniform() < 0.0 {
            path.thickness = 0.5 * d0 * (1.0 + random.uniform());
        }
        all.push(check(&path));
    }
    all
}

fn check(path: &Path) -> Outcome {
    let Path { pair, start, end, thickness } = *path;
    let t = time_of_impact(pair, &start, &end, thickness);
    let kept = KEPT * path.gap(0.0);
    let touching = path.contact();
    let said = || format!("{pair:?} {start:?} {end:?} {thickness}: {t}, contact {touching:?}");
    assert!((0.0..=1.0).contains(&t) && touching.is_none_or(|contact| t <= contact), "{}", said());
    // what other pairs have found so far changes nothing
    for limit in [0.2 * t, 0.9 * t, 0.999 * t, (1.1 * t).min(1.0), 0.5 * (1.0 + t)] {
        let within = time_within(limit, pair, &start, &end, thickness);
        assert_eq!(within.to_bits(), limit.min(t).to_bits(), "{limit} {within} {}", said());
    }
    let (ratio, left) = (touching.map(|contact| t / contact), path.gap(t) / kept);
    Outcome { ratio, left, cut: t < 1.0 }
}

/// No step goes through a contact, and none ends before the gap is used up, on thousands of paths of each family.
#[test]
fn steps_end_before_contact_and_not_long_before() {
    let families: [(&str, Family, usize); 7] = [
        ("anything", anything, 24),
        ("hitting", hitting, 21),
        ("coplanar", coplanar, 3),
        ("sliding", sliding, 3),
        ("still", still, 3),
        ("parallel", parallel, 3),
        ("degenerate", degenerate, 3),
    ];
    for pair in KINDS {
        for (name, family, parts) in families {
            let one = |seed| follow(family, pair, PLACES[seed % PLACES.len()], seed as u64, 1000);
            let outcomes: Vec<Outcome> = (0..parts).into_par_iter().flat_map_iter(one).collect();
            let mut ratios: Vec<f64> = outcomes.iter().filter_map(|o| o.ratio).collect();
            ratios.sort_by(f64::total_cmp);
            let least = outcomes.iter().map(|o| o.left).fold(f64::INFINITY, f64::min);
            let most = outcomes.iter().filter(|o| o.cut).map(|o| o.left).fold(0.0, f64::max);
            // with what rounding and the end of the search allow
            assert!(least > 0.99 && most < 1.05, "{name}");
            assert_eq!(ratios.is_empty(), name == "still");
            assert!(ratios.is_empty() || ratios[ratios.len() / 2] > 0.85, "{name}");
        }
    }
}

#[test]
fn steps_of_known_length() {
    let [pair, _] = KINDS;
    let [a, b, c] = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let at = |z: f64| [Vec3::new(0.25, 0.25, z), a, b, c];
    let step = |from: f64, to: f64, d| time_of_impact(pair, &at(from), &at(to), d);
    let close = |t: f64, expected: f64| assert!((t - expected).abs() < 1e-12, "{t} {expected}");
    close(step(1.0, -1.0, 0.0), 0.5 * (1.0 - KEPT));
    close(step(1.0, -1.0, 0.5), 0.25 * (1.0 - KEPT));
    // free: away, along, too short to matter, past each other at a distance
    close(step(1.0, 2.0, 0.5), 1.0);
    close(step(1.0, 0.2, 0.0), 1.0);
    close(time_of_impact(pair, &at(1e-9), &at(1e-9).map(|p| p + Vec3::repeat(1e3)), 0.0), 1.0);
    // too close from the start, inside the thickness or touching, and not a number
    close(step(1.0, 2.0, 1.0), 0.0);
    close(step(0.5, 2.0, 1.0), 0.0);
    close(step(0.0, 2.0, 0.0), 0.0);
    close(step(1.0, f64::NAN, 0.0), 0.0);
    close(step(f64::NAN, 1.0, 0.0), 0.0);
    close(step(1.0, f64::INFINITY, 0.0), 0.0);
}

#[test]
fn the_largest_step_is_the_least_of_all_pairs() {
    let mut random = Random::new(3);
    let x0: Vec<Vec3> = (0..4000).map(|_| random.vector()).collect();
    let x1: Vec<Vec3> = x0.iter().map(|x| x + 0.3 * random.vector()).collect();
    let corners = |i: usize| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3];
    let pairs: Vec<Pair> = (0..1000)
        .map(|i| match i % 2 {
            0 => Pair::PointTriangle(corners(i)),
            _ => Pair::EdgeEdge(corners(i)),
        })
        .collect();
    let one = |p: &Pair| time_of_impact(*p, &p.gather(&x0), &p.gather(&x1), 1e-4);
    let expected = pairs.iter().map(one).fold(1.0, f64::min);
    assert!(expected < 0.5);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let step = pool.expect("a thread pool").install(|| max_step(&pairs, &x0, &x1, 1e-4));
        assert_eq!(step.to_bits(), expected.to_bits());
    }
    assert_eq!(max_step(&[], &x0, &x1, 0.0).to_bits(), 1.0_f64.to_bits());
}
