//! Finer tetrahedra where two sheets of a surface lie within an edge, or where it bends.
//!
//! An edge hides sheets if its ends are on one side of a surface and the function, followed from both
//! ends, changes its sign between them: a groove or a wall that the lattice passes over. It bends if the
//! function at its middle is far from the mean of its ends and is smooth there. Tetrahedra at such edges
//! are halved at their longest edge, and so are those that have this edge, after their own longest one
//! (Rivara 1984), so that all still meet in common faces. Of a body-centred cubic lattice this makes
//! three shapes only, however fine (Maubach 1995).

use std::collections::{HashMap, HashSet};

use anyhow::{Result, ensure};
use mesh::Vec3;
use mesh::topology::TET_EDGES;
use rayon::prelude::*;

use super::complex::{Complex, Edge, edge, is_positive};
use super::sides::{Side, Sides};
use super::skin::{Kind, Thin};

/// Edges that are not split any more [grid]: those of two octaves.
pub const FINEST: f64 = 0.3;

/// How far the function at the middle of an edge may be from the mean of its ends [edge]: as of a ball
/// with 1.7 edges across.
const CHORD: f64 = 0.15;

/// Part of that on either half, at least, that a sharp edge of the body has not.
const SMOOTH: f64 = 0.1;

/// Cosine of the angle between the normals of two sheets from which on they face each other, as in
/// [`mesh::walls`].
pub const FACING: f64 = -0.5;

/// Part of an edge over which slopes are measured.
const STEP: f64 = 1e-4;

/// Most tetrahedra: a gigabyte with all that is made of them.
const MOST: usize = 6_000_000;

/// What an edge needs.
enum Need {
    Nothing,
    Finer,
    /// To tell apart what is thin.
    Sheets(Thin),
}

/// Halves tetrahedra until no edge above [`FINEST`] needs it. Also the sheets that no edge tells apart.
pub fn refine(mut complex: Complex, sides: &Sides) -> Result<(Complex, Vec<Thin>)> {
    let (mut hidden, mut coarse) = (HashMap::new(), HashSet::new());
    let curved = (0..sides.list.len()).filter(|&k| !matches!(sides.list[k], Side::Cut(..)));
    let mut values: Vec<(usize, Vec<f64>)> = curved.map(|k| (k, Vec::new())).collect();
    loop {
        let known = values[0].1.len();
        for (k, value) in &mut values {
            value.par_extend(complex.vertices[known..].par_iter().map(|p| sides.at(*k, p)));
        }
        let look = Look { complex: &complex, sides, values: &values };
        // An edge that is not new has been looked at.
        let fresh = complex.edges(|a, b| b as usize >= known && look.may_meet([a, b]));
        let needs: Vec<Need> = fresh.par_iter().map(|&edge| look.need(edge)).collect();
        for (edge, need) in fresh.into_iter().zip(needs) {
            match need {
                Need::Nothing => continue,
                Need::Finer => {}
                Need::Sheets(sheets) => _ = hidden.insert(edge, sheets),
            }
            if look.length(edge) > FINEST * sides.grid {
                coarse.insert(edge);
            }
        }
        let marked = look.marked(&coarse);
        if marked.is_empty() || complex.tets.len() > MOST {
            let mut left: Vec<(Edge, Thin)> = hidden.into_iter().collect();
            left.sort_unstable_by_key(|(edge, _)| *edge);
            return Ok((complex, left.into_iter().map(|(_, sheets)| sheets).collect()));
        }
        for edge in &marked {
            coarse.remove(edge);
            hidden.remove(edge);
        }
        complex = halved(&complex, sides, &marked)?;
    }
}

/// A complex with edges split in the middle.
fn halved(complex: &Complex, sides: &Sides, marked: &[Edge]) -> Result<Complex> {
    let mut finer =
        Complex { vertices: complex.vertices.clone(), on: complex.on.clone(), tets: Vec::new() };
    let mut middle = HashMap::new();
    for &[a, b] in marked {
        let [i, j] = [a as usize, b as usize];
        middle.insert([a, b], finer.vertices.len() as u32);
        let half = (finer.vertices[i] + finer.vertices[j]) / 2.0;
        finer.vertices.push(sides.settle(&half, 0));
        finer.on.push(finer.on[i] & finer.on[j]);
    }
    let mut flat = 0;
    complex.split(&middle, |whole, part| {
        flat += usize::from(part != whole && !is_positive(&finer.vertices, part));
        finer.tets.push(part);
    });
    ensure!(
        flat == 0,
        "coordinates of 32 bits do not resolve a grid of {} refined: choose a coarser one",
        sides.grid
    );
    Ok(finer)
}

struct Look<'a> {
    complex: &'a Complex,
    sides: &'a Sides<'a>,
    /// The curved sides, each with its values at the vertices [unit].
    values: &'a [(usize, Vec<f64>)],
}

impl Look<'_> {
    /// Whether an edge is near enough to a surface, if that is a distance.
    fn may_meet(&self, [a, b]: Edge) -> bool {
        let far = |value: &[f64]| value[a as usize].abs() + value[b as usize].abs();
        self.values.iter().any(|(_, value)| far(value) <= self.sides.grid)
    }

    /// The point at part `t` of an edge [unit].
    fn point(&self, [a, b]: Edge, t: f64) -> Vec3 {
        let [p, q] = [a, b].map(|v| self.complex.vertices[v as usize]);
        (p + (q - p) * t) / self.sides.metres
    }

    fn length(&self, edge: Edge) -> f64 {
        (self.point(edge, 1.0) - self.point(edge, 0.0)).norm()
    }

    fn need(&self, edge: Edge) -> Need {
        let length = self.length(edge);
        let mut need = Need::Nothing;
        for (k, value) in self.values {
            let ends = edge.map(|v| value[v as usize]);
            // What changes by no more than distances do has no zero pair or bend on other edges.
            if ends[0].abs() + ends[1].abs() > length {
                continue;
            }
            if let Some(sheets) = self.hidden(*k, edge, ends, length) {
                return Need::Sheets(sheets);
            }
            if self.bends(*k, edge, ends, length) {
                need = Need::Finer;
            }
        }
        need
    }

    /// Whether the surface that crosses an edge bends. Beside a sharp edge of the body, distances bend,
    /// too, but on the outer side only.
    fn bends(&self, k: usize, edge: Edge, ends: [f64; 2], length: f64) -> bool {
        if ends[0] * ends[1] >= 0.0 {
            return false;
        }
        let f = |t| self.sides.list[k].at(&self.point(edge, t));
        let middle = f(0.5);
        let off = |a: f64, m: f64, b: f64| (m - (a + b) / 2.0).abs();
        let bend = off(ends[0], middle, ends[1]);
        bend > CHORD * length
            && off(ends[0], f(0.25), middle) > SMOOTH * bend
            && off(middle, f(0.75), ends[1]) > SMOOTH * bend
    }

    /// The sheets of side `k` between the ends of an edge.
    fn hidden(&self, k: usize, edge: Edge, ends: [f64; 2], length: f64) -> Option<Thin> {
        let sign = ends[0].signum();
        if sign != ends[1].signum() {
            return None;
        }
        let f = |t: f64| sign * self.sides.list[k].at(&self.point(edge, t));
        let [a, b] = ends.map(f64::abs);
        // Slopes from both ends: where the two lines meet, the function may have changed its sign.
        let (down, up) = ((f(STEP) - a) / STEP, (b - f(1.0 - STEP)) / STEP);
        if down >= 0.0 || up <= 0.0 {
            return None;
        }
        let t = (b - up - a) / (down - up);
        if !(0.0..=1.0).contains(&t) || f(t) >= 0.0 {
            return None;
        }
        let sheets = [zero(f, 0.0, t), zero(f, 1.0, t)];
        let step = STEP * self.sides.grid;
        let normal = |t| self.sides.list[k].gradient(&self.point(edge, t), step).normalize();
        let [n, m] = sheets.map(normal);
        let at = self.point(edge, (sheets[0] + sheets[1]) / 2.0);
        let others = self.sides.list.iter().enumerate().filter(|(other, _)| *other != k);
        if n.dot(&m) > FACING || others.into_iter().any(|(_, side)| side.at(&at) > 0.0) {
            return None;
        }
        let along = self.point(edge, 1.0) - self.point(edge, 0.0);
        let width = (sheets[1] - sheets[0]).abs() * n.dot(&along).abs().max(m.dot(&along).abs());
        Some(Thin {
            kind: if sign > 0.0 { Kind::Wall } else { Kind::Gap },
            resolved: false,
            thickness: width.min(length) * self.sides.metres,
            at: (at * self.sides.metres).into(),
        })
    }

    /// The edges to split so that none of `coarse` is left of its length, the longest first.
    fn marked(&self, coarse: &HashSet<Edge>) -> Vec<Edge> {
        if coarse.is_empty() {
            return Vec::new();
        }
        let stars = self.complex.stars();
        let tets_at = |[a, b]: Edge| {
            let tets = stars.at(a).iter().copied();
            tets.filter(move |&t| self.complex.tets[t].contains(&b))
        };
        let (mut marked, mut next) = (HashSet::new(), Vec::new());
        let mut mark = |edge: Edge, next: &mut Vec<Edge>| {
            for longest in tets_at(edge).map(|t| self.longest(self.complex.tets[t])) {
                if marked.insert(longest) {
                    next.push(longest);
                }
            }
        };
        let mut start: Vec<Edge> = coarse.iter().copied().collect();
        start.sort_unstable();
        start.into_iter().for_each(|edge| mark(edge, &mut next));
        while let Some(edge) = next.pop() {
            mark(edge, &mut next);
        }
        let mut marked: Vec<Edge> = marked.into_iter().collect();
        marked.sort_by_key(|&edge| (std::cmp::Reverse(self.rank(edge)), edge));
        marked
    }

    /// The length of an edge in steps of a thousandth of the grid: equal ones are equal.
    fn rank(&self, edge: Edge) -> u64 {
        (self.length(edge) / self.sides.grid * 1e3).round() as u64
    }

    fn longest(&self, tet: [u32; 4]) -> Edge {
        let edges = TET_EDGES.map(|[i, j]| edge(tet[i], tet[j]));
        edges.into_iter().max_by_key(|&e| (self.rank(e), std::cmp::Reverse(e))).unwrap_or(edges[0])
    }
}

/// The zero of f between `outer`, where it is positive, and `inner`, where it is negative.
fn zero(f: impl Fn(f64) -> f64, mut outer: f64, mut inner: f64) -> f64 {
    for _ in 0..30 {
        let middle = (outer + inner) / 2.0;
        if f(middle) > 0.0 { outer = middle } else { inner = middle }
    }
    inner
}
