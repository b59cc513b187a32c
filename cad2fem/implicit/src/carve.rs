//! A side of the body, carved out of a complex.
//!
//! The zero set of a function, linear in each tetrahedron, is a manifold that never crosses itself: its
//! tetrahedra are split at their edges' zeros, and those outside go. Corners near a zero are moved onto
//! it first, so that pieces are well shaped. Neither may cost soundness: a move or a split is undone
//! where a tetrahedron would lose its volume, and a corner is taken off the surface again where sheets
//! would touch in it. With no corner on the surface there is no such place, so that this ends.

use std::cmp::Ordering;
use std::collections::HashMap;

use anyhow::{Result, bail};
use mesh::Vec3;
use mesh::measure::{is_flat, tet_volume};
use mesh::topology::TET_EDGES;
use rayon::prelude::*;

use super::complex::{Complex, Edge, Stars, edge, is_positive};
use super::refine::FACING;
use super::sides::{Side, Sides};

/// Part of an edge by which its end may be moved onto the surface.
const SNAP: f64 = 0.25;

/// Part of its volume that a tetrahedron keeps when a corner is moved.
const KEPT: f64 = 0.1;

/// A corner as near as this counts as on the surface, if it cannot be moved [grid].
const BESIDE: f64 = 1e-4;

/// Where an edge is split, at least this part away from its ends, on the first try and the next ones.
const PLACES: [f64; 3] = [0.0, 0.05, 0.5];

/// Step of the differences that give normals [grid].
const STEP: f64 = 1e-4;

/// Accuracy of a zero [edge].
const EXACT: f64 = 1e-9;

/// Tries, each with more corners off the surface or edges split elsewhere.
const TRIES: usize = 24;

/// The tries after which no corner may be on the surface.
const PATIENT: usize = 12;

/// Leaves what is inside side `k` of a complex; says how many edges are split beside their zeros.
pub fn carve(complex: &Complex, sides: &Sides, k: usize) -> Result<(Complex, usize)> {
    let mut carving = Carving::new(complex, sides, k);
    for turn in 0..TRIES {
        match carving.attempt() {
            Ok(done) => return Ok((done, carving.place.values().filter(|&&p| p > 0).count())),
            Err(Fault::Flat(edges)) => {
                for edge in edges {
                    let place = carving.place.entry(edge).or_insert(0);
                    *place = (*place + 1).min(PLACES.len() - 1);
                }
            }
            Err(Fault::Pinched(corners)) => carving.set_free(corners, turn / 2),
        }
        if turn >= PATIENT {
            carving.free.fill(true);
        }
    }
    bail!("coordinates of 32 bits do not resolve a grid of {}: choose a coarser one", sides.grid)
}

/// Why an attempt failed.
enum Fault {
    /// Edges whose split leaves a tetrahedron without volume or a triangle without area.
    Flat(Vec<Edge>),
    /// Corners on the surface at which sheets touch.
    Pinched(Vec<u32>),
}

struct Carving<'a> {
    before: &'a Complex,
    sides: &'a Sides<'a>,
    k: usize,
    /// At each vertex [unit].
    value: Vec<f64>,
    /// Edges between vertices of both signs, and the part of each from its first vertex to its zero.
    crossing: Vec<(Edge, f64)>,
    stars: Stars,
    /// Corners that stay off the surface.
    free: Vec<bool>,
    /// Which of [`PLACES`] an edge has, the first if none.
    place: HashMap<Edge, usize>,
}

impl<'a> Carving<'a> {
    fn new(before: &'a Complex, sides: &'a Sides<'a>, k: usize) -> Self {
        let value: Vec<f64> = before.vertices.par_iter().map(|p| sides.at(k, p)).collect();
        let inside = |v: u32| value[v as usize] < 0.0;
        let edges = before.edges(|a, b| inside(a) != inside(b));
        let zero = |[a, b]: Edge| {
            let [p, q] = [a, b].map(|v| before.vertices[v as usize]);
            (
                [a, b],
                zero(|t| sides.at(k, &(p + (q - p) * t)), value[a as usize], value[b as usize]),
            )
        };
        let crossing: Vec<(Edge, f64)> = edges.into_par_iter().map(zero).collect();
        let mut free = vec![false; value.len()];
        for v in between(before, sides, k, &crossing) {
            free[v as usize] = true;
        }
        let stars = before.stars();
        Self { before, sides, k, value, crossing, stars, free, place: HashMap::new() }
    }

    /// Takes corners off the surface, with those that are up to `rings` tetrahedra away.
    fn set_free(&mut self, mut corners: Vec<u32>, rings: usize) {
        for _ in 0..rings {
            let tets = corners.iter().flat_map(|&v| self.stars.at(v));
            corners = tets.flat_map(|&t| self.before.tets[t]).collect();
            corners.sort_unstable();
            corners.dedup();
        }
        corners.iter().for_each(|&v| self.free[v as usize] = true);
    }

    fn attempt(&self) -> Result<Complex, Fault> {
        let mut after = self.before.clone();
        let mut sign: Vec<i8> = self.value.iter().map(|&d| if d < 0.0 { -1 } else { 1 }).collect();
        self.snap(&mut after, &mut sign);
        let mut middle = HashMap::new();
        for &([a, b], t) in &self.crossing {
            if sign[a as usize] * sign[b as usize] < 0 {
                middle.insert([a, b], after.vertices.len() as u32);
                self.add_middle(&mut after, [a, b], t);
                sign.push(0);
            }
        }
        let (mut tets, mut flat) = (Vec::new(), Vec::new());
        after.split(&middle, |whole, part| {
            if part != whole && !is_positive(&after.vertices, part) {
                let edges = TET_EDGES.map(|[i, j]| edge(whole[i], whole[j]));
                flat.extend(edges.into_iter().filter(|e| middle.contains_key(e)));
            } else if self.is_inside(&after.vertices, &sign, part) {
                tets.push(part);
            }
        });
        if !flat.is_empty() {
            flat.sort_unstable();
            flat.dedup();
            return Err(Fault::Flat(flat));
        }
        after.tets = tets;
        let surface = after.boundary();
        if let Some(fault) = self.needles(&after, &surface, &sign, &middle) {
            return Err(fault);
        }
        let touching = after.pinched(&surface);
        if !touching.is_empty() {
            return Err(Fault::Pinched(self.on_surface(&after, &sign, &touching)));
        }
        after.compact();
        Ok(after)
    }

    /// What makes triangles of the surface without area: tetrahedra have a volume, by exact signs, but
    /// where the surface just touches a corner they may be as thin as numbers are.
    fn needles(
        &self,
        after: &Complex,
        surface: &[[u32; 3]],
        sign: &[i8],
        middle: &HashMap<Edge, u32>,
    ) -> Option<Fault> {
        let has_no_area = |face: &&[u32; 3]| {
            let [a, b, c] = face.map(|v| after.vertices[v as usize]);
            is_flat(a, b, c)
        };
        let mut flat: Vec<u32> = surface.iter().filter(has_no_area).flatten().copied().collect();
        flat.sort_unstable();
        let at = |v: &u32| flat.binary_search(v).is_ok();
        let split = middle.iter().filter(|(edge, v)| {
            at(v) && self.place.get(*edge).is_none_or(|&place| place + 1 < PLACES.len())
        });
        let mut edges: Vec<Edge> = split.map(|(&edge, _)| edge).collect();
        edges.sort_unstable();
        if !edges.is_empty() {
            return Some(Fault::Flat(edges));
        }
        (!flat.is_empty()).then(|| Fault::Pinched(self.on_surface(after, sign, &flat)))
    }

    /// Moves corners onto the surface, the nearest first.
    fn snap(&self, after: &mut Complex, sign: &mut [i8]) {
        let bit = 1 << self.k;
        for (v, w, t) in self.moves() {
            let [i, j] = [v, w].map(|v| v as usize);
            if sign[i] == 0 || sign[j] == 0 {
                continue;
            }
            // Along an edge in all the surfaces that the corner is on, it stays on them.
            let along = self.before.on[i] & !self.before.on[j] == 0;
            let [p, q] = [i, j].map(|v| self.before.vertices[v]);
            let place = |p: Vec3| self.sides.settle(&p, self.before.on[i] | bit);
            let beside = self.value[i].abs() <= BESIDE * self.sides.grid;
            if along && self.moved(after, v, place(p + (q - p) * t))
                || beside && self.moved(after, v, place(p))
            {
                sign[i] = 0;
                after.on[i] |= bit;
            }
        }
    }

    /// Corners with a zero close by, with the other end of that edge and the part of it that lies
    /// between, the nearest first.
    fn moves(&self) -> Vec<(u32, u32, f64)> {
        let ends = self.crossing.iter().flat_map(|&([a, b], t)| [(a, b, t), (b, a, 1.0 - t)]);
        let near = |&(v, _, t): &(u32, u32, f64)| t <= SNAP && !self.free[v as usize];
        let mut moves: Vec<_> = ends.filter(near).collect();
        moves.sort_by(|a, b| a.2.total_cmp(&b.2).then((a.0, a.1).cmp(&(b.0, b.1))));
        moves
    }

    /// Moves a corner, unless that takes too much from a tetrahedron.
    fn moved(&self, after: &mut Complex, v: u32, to: Vec3) -> bool {
        let volume = |vertices: &[Vec3], t: usize| {
            let [a, b, c, d] = self.before.tets[t].map(|v| vertices[v as usize]);
            tet_volume(a, b, c, d)
        };
        let from = std::mem::replace(&mut after.vertices[v as usize], to);
        let kept = self.stars.at(v).iter().all(|&t| {
            volume(&after.vertices, t) >= KEPT * volume(&self.before.vertices, t)
                && is_positive(&after.vertices, self.before.tets[t])
        });
        if !kept {
            after.vertices[v as usize] = from;
        }
        kept
    }

    /// Adds the vertex at the zero of an edge.
    fn add_middle(&self, after: &mut Complex, [a, b]: Edge, t: f64) {
        let away = self.place.get(&[a, b]).map_or(0.0, |&place| PLACES[place]);
        let (s, [i, j]) = (t.clamp(away, 1.0 - away), [a as usize, b as usize]);
        let on = after.on[i] & after.on[j] | 1 << self.k;
        // Beside its zero it is not put into the plane of this side.
        let planes = if s == t { on } else { on & !(1 << self.k) };
        let p = after.vertices[i] + (after.vertices[j] - after.vertices[i]) * s;
        after.vertices.push(self.sides.settle(&p, planes));
        after.on.push(on);
    }

    fn is_inside(&self, vertices: &[Vec3], sign: &[i8], tet: [u32; 4]) -> bool {
        let signs = tet.map(|v| sign[v as usize]);
        if signs == [0; 4] {
            let middle = tet.iter().map(|&v| vertices[v as usize]).sum::<Vec3>() / 4.0;
            return self.sides.at(self.k, &middle) < 0.0;
        }
        signs.iter().all(|&s| s <= 0)
    }

    /// The corners on the surface at which sheets touch, or those of the tetrahedra there.
    fn on_surface(&self, after: &Complex, sign: &[i8], touching: &[u32]) -> Vec<u32> {
        let old = |v: &u32| (*v as usize) < self.value.len() && sign[*v as usize] == 0;
        let corners: Vec<u32> = touching.iter().copied().filter(old).collect();
        if !corners.is_empty() {
            return corners;
        }
        let there = |tet: &&[u32; 4]| tet.iter().any(|v| touching.binary_search(v).is_ok());
        after.tets.iter().filter(there).flatten().copied().filter(old).collect()
    }
}

/// Corners between two sheets that face each other: on either they would close the gap.
fn between(before: &Complex, sides: &Sides, k: usize, crossing: &[(Edge, f64)]) -> Vec<u32> {
    if matches!(sides.list[k], Side::Cut(..)) {
        return Vec::new();
    }
    // From each end of an edge to its zero.
    let mut ways: Vec<(u32, f64, Vec3)> = Vec::new();
    for &([a, b], t) in crossing {
        let along = before.vertices[b as usize] - before.vertices[a as usize];
        ways.extend([(a, t, along * t), (b, 1.0 - t, along * (t - 1.0))]);
    }
    ways.par_sort_unstable_by(|v, w| {
        (v.0, v.1).partial_cmp(&(w.0, w.1)).unwrap_or(Ordering::Equal)
    });
    let step = STEP * sides.grid;
    let is_between = |ways: &&[(u32, f64, Vec3)]| {
        let (v, near, first) = ways[0];
        if near > SNAP || ways.iter().all(|(_, _, way)| way.dot(&first) >= 0.0) {
            return false;
        }
        let normal = |way: &Vec3| {
            let p = (before.vertices[v as usize] + way) / sides.metres;
            sides.list[k].gradient(&p, step).try_normalize(0.0).unwrap_or_default()
        };
        let n = normal(&first);
        let behind = |way: &Vec3| way.dot(&n) * first.dot(&n) < 0.0 && normal(way).dot(&n) < FACING;
        ways.iter().any(|(_, _, way)| behind(way))
    };
    let corners: Vec<_> = ways.chunk_by(|v, w| v.0 == w.0).collect();
    corners.into_par_iter().filter(is_between).map(|ways| ways[0].0).collect()
}

/// The zero of f in [0, 1], where it has the values `f0` and `f1` of different signs at the ends: false
/// position, with half the value of an end that stays (Illinois).
fn zero(f: impl Fn(f64) -> f64, mut f0: f64, mut f1: f64) -> f64 {
    let (mut t0, mut t1, floor) = (0.0, 1.0, EXACT * (f0 - f1).abs());
    let mut moved_first = None;
    loop {
        let t = t0 + (t1 - t0) * f0 / (f0 - f1);
        if t <= t0 || t >= t1 {
            return t.clamp(t0, t1);
        }
        let value = f(t);
        if value.abs() <= floor || t1 - t0 < EXACT {
            return t;
        }
        let first = (value < 0.0) == (f0 < 0.0);
        let again = moved_first.replace(first) == Some(first);
        let weight = if again { 0.5 } else { 1.0 };
        if first {
            (t0, f0, f1) = (t, value, f1 * weight);
        } else {
            (t1, f1, f0) = (t, value, f0 * weight);
        }
    }
}
