//! A surface whose triangles and vertices change, one change at a time.

use mesh::Vec3;
use mesh::measure::{triangle_area, triangle_normal, triangle_shape};

use super::super::refine::FINEST;
use super::super::sides::Sides;
use super::super::skin::{Part, Skin};

/// Cosine of the angle between neighbours on one side from which on no change may increase that angle.
const FOLD: f64 = 0.3;

/// Shape, 4√3 area over the sum of the squared edges, below which no change may lower it [1].
const SHAPE: f64 = 0.5;

/// A fold with a cosine below this is smoothed away: sharper than any edge of a box.
const CUSP: f64 = -0.2;

/// How far that may move the middle of a triangle from the function [grid]: half of what the lattice resolves.
const FILLED: f64 = FINEST / 2.0;

/// By how much an exchange of an edge must raise the shape of the worse triangle [1].
const GAIN: f64 = 1.02;

/// Parts of the way to a better place that are tried.
const WAYS: [f64; 3] = [1.0, 0.5, 0.25];

/// Steps of Newton's method onto the sides of a vertex.
const TURNS: usize = 8;

/// Step of the differences that give gradients [grid].
const STEP: f64 = 1e-4;

/// What is wrong with some triangles.
struct Score {
    /// Least cosine of the angle to a neighbour on the same side.
    fold: f64,
    /// Shape of the worst.
    shape: f64,
    /// Largest distance of a middle from its side [m].
    off: f64,
}

/// A closed surface under change.
pub struct Net<'a> {
    /// Vertices, as files keep them [m].
    pub places: Vec<Vec3>,
    /// Wanted length of edges at each vertex [m].
    size: Vec<f64>,
    /// Corners of each triangle; one that is gone has a corner twice.
    corners: Vec<[usize; 3]>,
    /// The side that each triangle is on.
    side: Vec<usize>,
    /// The triangles at each vertex.
    star: Vec<Vec<usize>>,
    tolerance: f64,
    sides: &'a Sides<'a>,
}

impl<'a> Net<'a> {
    /// The surface of `skin` with the lengths `size` of edges at its vertices, to be within `tolerance`, all [m].
    pub fn new(skin: &Skin, size: Vec<f64>, tolerance: f64, sides: &'a Sides<'a>) -> Self {
        let mut star = vec![Vec::new(); skin.surface.vertices.len()];
        for (t, corners) in skin.surface.triangles.iter().enumerate() {
            corners.iter().for_each(|&v| star[v].push(t));
        }
        let side = skin.part.iter().map(|&part| sides.index(part)).collect();
        let corners = skin.surface.triangles.clone();
        let places = skin.surface.vertices.clone();
        Self { places, size, corners, side, star, tolerance, sides }
    }

    /// The triangles that are left, and their parts.
    pub fn triangles(&self) -> (Vec<[usize; 3]>, Vec<Part>) {
        let left = (0..self.corners.len()).filter(|&t| self.is_there(t));
        left.map(|t| (self.corners[t], self.sides.part(self.side[t]))).unzip()
    }

    fn is_there(&self, t: usize) -> bool {
        let [a, b, c] = self.corners[t];
        a != b && b != c && c != a
    }

    /// The edges of which `chosen` is true, the lower vertex first, in the order of their triangles.
    pub fn edges(&self, chosen: impl Fn(&Self, [usize; 2]) -> bool) -> Vec<[usize; 2]> {
        let of = |t: usize| {
            let [a, b, c] = self.corners[t];
            [[a, b], [b, c], [c, a]]
        };
        let all = (0..self.corners.len()).filter(|&t| self.is_there(t)).flat_map(of);
        all.filter(|&[a, b]| a < b && chosen(self, [a, b])).collect()
    }

    /// [m]
    pub fn length(&self, [a, b]: [usize; 2]) -> f64 {
        (self.places[a] - self.places[b]).norm()
    }

    /// The length of an edge over what is wanted at its ends [1].
    pub fn relative_length(&self, [a, b]: [usize; 2]) -> f64 {
        2.0 * self.length([a, b]) / (self.size[a] + self.size[b])
    }

    /// Whether the vertices are joined.
    pub fn has_edge(&self, [a, b]: [usize; 2]) -> bool {
        self.star[a].iter().any(|&t| self.corners[t].contains(&b))
    }

    /// The triangles on an edge, that with the edge in its order first.
    fn beside(&self, [a, b]: [usize; 2]) -> Option<[usize; 2]> {
        let has = |from: usize, to: usize| {
            let follows = |t: &&usize| {
                let k = self.corners[**t].iter().position(|&v| v == from);
                k.is_some_and(|k| self.corners[**t][(k + 1) % 3] == to)
            };
            self.star[a].iter().find(follows).copied()
        };
        Some([has(a, b)?, has(b, a)?])
    }

    /// The corner of a triangle that is not on an edge.
    fn opposite(&self, t: usize, edge: [usize; 2]) -> usize {
        let [a, b, c] = self.corners[t];
        [a, b, c].into_iter().find(|v| !edge.contains(v)).unwrap_or(a)
    }

    /// Whether an edge lies between two sides.
    fn is_rim(&self, edge: [usize; 2]) -> bool {
        self.beside(edge).is_none_or(|[s, t]| self.side[s] != self.side[t])
    }

    /// Each neighbour of a vertex once.
    fn around(&self, v: usize) -> Vec<usize> {
        let next = |&t: &usize| {
            let k = self.corners[t].iter().position(|&c| c == v).unwrap_or_default();
            self.corners[t][(k + 1) % 3]
        };
        self.star[v].iter().map(next).collect()
    }

    /// The neighbours of a vertex along rims.
    fn along_rims(&self, v: usize) -> Vec<usize> {
        let first = self.star[v].first().map(|&t| self.side[t]);
        if self.star[v].iter().all(|&t| Some(self.side[t]) == first) {
            return Vec::new();
        }
        self.around(v).into_iter().filter(|&w| self.is_rim([v, w])).collect()
    }

    /// The sides that a vertex is on, as bits.
    fn on(&self, v: usize) -> u64 {
        self.star[v].iter().fold(0, |bits, &t| bits | 1 << self.side[t])
    }

    fn normal(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners[t].map(|v| self.places[v]);
        triangle_normal(a, b, c)
    }

    fn shape(&self, t: usize) -> f64 {
        triangle_shape(self.corners[t].map(|v| self.places[v]))
    }

    /// Distance of the middle of a triangle from its side [m].
    fn off(&self, t: usize) -> f64 {
        let middle = self.corners[t].iter().map(|&v| self.places[v]).sum::<Vec3>() / 3.0;
        self.distance(self.side[t], &middle)
    }

    /// Distance of a point [m] from a side, to first order [m].
    fn distance(&self, side: usize, p: &Vec3) -> f64 {
        self.sides.at(side, p).abs() * self.sides.metres
    }

    /// Whether the middle of an edge is farther from a side of it than it should be.
    pub fn is_off(&self, [a, b]: [usize; 2]) -> bool {
        let middle = (self.places[a] + self.places[b]) / 2.0;
        let sides = self.beside([a, b]).map(|both| both.map(|t| self.side[t]));
        sides.into_iter().flatten().any(|side| self.distance(side, &middle) > self.tolerance)
    }

    /// Least cosine of the angle between a triangle and a neighbour on its side.
    fn fold(&self, t: usize) -> f64 {
        let ([a, b, c], normal) = (self.corners[t], self.normal(t));
        let edges = [[a, b], [b, c], [c, a]].into_iter();
        let pairs = edges.filter_map(|edge| self.beside(edge));
        let same = pairs.filter(|&[s, u]| self.side[s] == self.side[u]);
        same.map(|[_, u]| normal.dot(&self.normal(u))).fold(1.0, f64::min)
    }

    fn score(&self, triangles: &[usize]) -> Score {
        let least = |f: &dyn Fn(usize) -> f64| triangles.iter().map(|&t| f(t)).fold(1.0, f64::min);
        let off = triangles.iter().map(|&t| self.off(t)).fold(0.0, f64::max);
        Score { fold: least(&|t| self.fold(t)), shape: least(&|t| self.shape(t)), off }
    }

    /// Whether triangles are at least as good as they were, or good enough.
    fn is_better(&self, now: &Score, before: &Score) -> bool {
        now.fold >= before.fold.min(FOLD)
            && now.shape >= before.shape.min(SHAPE)
            && now.off <= before.off.max(self.tolerance)
    }

    /// A point [m] moved onto the sides of which the bits are set, as files keep it; `None` if they are too far.
    fn settled(&self, p: &Vec3, on: u64, reach: f64) -> Option<Vec3> {
        let (metres, step) = (self.sides.metres, STEP * self.sides.grid);
        let mut at = p / metres;
        for _ in 0..TURNS {
            let sides = self.sides.list.iter().enumerate();
            for (_, side) in sides.filter(|(k, _)| on >> k & 1 == 1) {
                let (value, slope) = (side.at(&at), side.gradient(&at, step));
                if slope.norm_squared() > 0.0 {
                    at -= slope * (value / slope.norm_squared());
                }
            }
        }
        let settled = self.sides.settle(&(at * metres), on);
        ((settled - p).norm() <= reach).then_some(settled)
    }

    /// Splits an edge in the middle, on the sides of its triangles if they are near.
    pub fn split(&mut self, [a, b]: [usize; 2]) {
        let Some([s, t]) = self.beside([a, b]) else { return };
        let before = self.score(&[s, t]);
        let on = 1 << self.side[s] | 1 << self.side[t];
        let half = (self.places[a] + self.places[b]) / 2.0;
        let straight = self.sides.settle(&half, on);
        let m = self.places.len();
        self.places.push(self.settled(&half, on, self.length([a, b]) / 2.0).unwrap_or(straight));
        self.size.push((self.size[a] + self.size[b]) / 2.0);
        self.star.push(Vec::new());
        for t in [s, t] {
            let new = self.corners.len();
            self.corners.push(self.corners[t].map(|v| if v == b { m } else { v }));
            self.side.push(self.side[t]);
            let across = self.opposite(t, [a, b]);
            self.star[a].retain(|&u| u != t);
            self.star[a].push(new);
            self.star[across].push(new);
            self.star[m].extend([t, new]);
            self.corners[t] = self.corners[t].map(|v| if v == a { m } else { v });
        }
        if self.score(&self.star[m]).fold < before.fold.min(FOLD) {
            self.places[m] = straight;
        }
    }

    /// Moves vertex `v` onto its neighbour `w`, whereupon they are one, unless that harms triangles or makes an
    /// edge of more than `long` times its size. Whether it is done.
    pub fn contract(&mut self, v: usize, w: usize, long: f64) -> bool {
        let rims = self.along_rims(v);
        if !rims.is_empty() && (rims.len() != 2 || !rims.contains(&w)) {
            return false;
        }
        let (around, others) = (self.around(v), self.around(w));
        let both = around.iter().filter(|u| others.contains(u)).count();
        let is_long = |&u: &usize| u != w && self.relative_length([u, w]) > long;
        if both != 2 || around.len() < 4 || others.len() < 4 || around.iter().any(is_long) {
            return false;
        }
        let star = self.star[v].clone();
        let before = self.score(&star);
        let old: Vec<[usize; 3]> = star.iter().map(|&t| self.corners[t]).collect();
        let left: Vec<usize> =
            star.iter().copied().filter(|&t| !self.corners[t].contains(&w)).collect();
        self.detach(&star);
        for &t in &star {
            self.corners[t] = self.corners[t].map(|u| if u == v { w } else { u });
        }
        self.attach(&left);
        let done = self.is_better(&self.score(&left), &before);
        if !done {
            self.detach(&left);
            star.iter().zip(old).for_each(|(&t, corners)| self.corners[t] = corners);
            self.attach(&star);
        }
        done
    }

    fn detach(&mut self, triangles: &[usize]) {
        for &t in triangles {
            self.corners[t].iter().for_each(|&v| self.star[v].retain(|&u| u != t));
        }
    }

    fn attach(&mut self, triangles: &[usize]) {
        for &t in triangles {
            self.corners[t].iter().for_each(|&v| self.star[v].push(t));
        }
    }

    /// Exchanges an edge for that between the corners opposite it, if that makes the worse triangle better, or an
    /// edge less sharp.
    pub fn exchange(&mut self, [a, b]: [usize; 2]) {
        let Some([s, t]) = self.beside([a, b]) else { return };
        let [c, d] = [s, t].map(|t| self.opposite(t, [a, b]));
        let is_last = |v: usize| self.star[v].len() < 4;
        if self.side[s] != self.side[t] || self.has_edge([c, d]) || is_last(a) || is_last(b) {
            return;
        }
        let (old, before) = ([self.corners[s], self.corners[t]], self.score(&[s, t]));
        self.set([s, t], [[a, d, c], [d, b, c]]);
        let now = self.score(&[s, t]);
        let flatter = now.fold > before.fold && before.fold < FOLD;
        if !self.is_better(&now, &before) || now.shape < GAIN * before.shape && !flatter {
            self.set([s, t], old);
        }
    }

    fn set(&mut self, triangles: [usize; 2], corners: [[usize; 3]; 2]) {
        self.detach(&triangles);
        [0, 1].into_iter().for_each(|k| self.corners[triangles[k]] = corners[k]);
        self.attach(&triangles);
    }

    /// Moves a vertex towards the middle of its triangles, or of its neighbours on a rim, along its sides; in a
    /// sharp fold also off them.
    pub fn slide(&mut self, v: usize) {
        let rims = self.along_rims(v);
        let star = self.star[v].clone();
        if star.is_empty() || !rims.is_empty() && rims.len() != 2 {
            return;
        }
        let (from, before, on) = (self.places[v], self.score(&star), self.on(v));
        let away = self.distance(self.side[star[0]], &from);
        let target = if rims.is_empty() { self.middle(&star) } else { self.mean(&rims) };
        for part in WAYS {
            let p = from + (target - from) * part;
            let reach = (target - from).norm().max(self.tolerance).max(2.0 * away);
            let Some(place) = self.settled(&p, on, reach) else { continue };
            self.places[v] = place;
            if self.is_better(&self.score(&star), &before) {
                return;
            }
        }
        self.places[v] = from;
        if rims.is_empty() && before.fold < CUSP {
            self.places[v] = self.sides.settle(&self.mean(&self.around(v)), on);
            let (now, most) = (self.score(&star), FILLED * self.sides.grid * self.sides.metres);
            if now.fold <= before.fold || now.off > before.off.max(most) {
                self.places[v] = from;
            }
        }
    }

    fn mean(&self, vertices: &[usize]) -> Vec3 {
        vertices.iter().map(|&v| self.places[v]).sum::<Vec3>() / vertices.len() as f64
    }

    /// The mean of the middles of triangles, by their areas over the squares of the lengths that are wanted there.
    fn middle(&self, star: &[usize]) -> Vec3 {
        let (mut sum, mut total) = (Vec3::zeros(), 0.0);
        for &t in star {
            let [a, b, c] = self.corners[t].map(|v| self.places[v]);
            let size = self.corners[t].iter().map(|&v| self.size[v]).sum::<f64>();
            let weight = triangle_area(a, b, c) / (size * size);
            sum += (a + b + c) * (weight / 3.0);
            total += weight;
        }
        sum / total
    }
}
