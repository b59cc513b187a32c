//! Where threads lie on facets: helices and polylines, cut at the edges of facets.
//!
//! Each vertex has two numbers: t, how far along the thread, and c, how far beside it. Both are linear in a
//! facet, where the thread is the segment c = 0. Facets are cut one by one; the pieces, in the order of t,
//! must follow each other without a gap and without a second layer.
//!
//! A helix has c = θ/2π − θ₀/2π − τ(z) up to whole numbers, with the height z along the axis, the angle θ around it
//! and its turns τ ([`Lead`]); t is the height from its start. Vertices lie where they are; between them angle and
//! turns are linear in the facet. For an arc of φ the angle is off by φ³/(72 √3), 0.02° for facets of 20°. A leg of a
//! polyline is cut by the plane through both of its ends, moved to the nearest points of the facets, and the mean of
//! the normals there; t counts the legs.
//!
//! With other numbers of a helix, c at the corners is other by ċ, linear in the facet. An end λ of a piece stays
//! at c = 0 and moves along d, Σ d_k = 0: along the edge that it is on, and at its height where it is an end of
//! the thread or at a vertex. So
//!
//! λ̇ = −ċ(λ) d/Σ c_k d_k      ċ = −∂τ/∂v by a value v of the lead      ċ = ∓1/2π by θ₀ of a right- or left-handed screw
//!
//! As long as no piece appears or vanishes, that is the derivative of all ends. There, and where the thread passes
//! a vertex, forces are continuous, with a kink.

use std::f64::consts::{PI, TAU};

use mesh::Vec3;
use mesh::bvh::closest_on_triangle;

use super::lead::{Lead, Turns, TurnsByHeight};
use crate::energy::Axis;

/// What is rounding beside the numbers of a facet [1].
const ROUNDING: f64 = 1e-10;
/// How far pieces that follow each other may be apart, relative to a mean one [1].
const GAP: f64 = 1e-6;
/// How far two pieces in the same place may be apart, relative to one [1].
const APART: f64 = 1e-3;

/// A helix about an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Helix {
    /// The axis; heights are along it from its point.
    pub axis: Axis,
    /// How it climbs.
    pub lead: Lead,
    /// 1 for a right-handed screw, −1 for a left-handed one.
    pub hand: f64,
    /// Heights of its ends [m].
    pub heights: [f64; 2],
    /// Angle of its start [rad], from [`Axis::reference`].
    pub phase: f64,
}

/// A straight piece of a thread in a facet.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// The corners of the facet.
    pub facet: [usize; 3],
    /// Barycentric coordinates of its ends.
    pub ends: [[f64; 3]; 2],
    /// How far along the thread its ends are: turns of a helix, legs of a polyline.
    pub range: [f64; 2],
    /// Derivatives of `ends` by each value of the lead of a helix, and at last by its phase [1/rad]; none of a
    /// polyline.
    pub rates: Vec<[[f64; 3]; 2]>,
}

/// Why a thread cannot be laid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LayError {
    /// It meets no facet.
    #[error("it meets none of the facets")]
    Misses,
    /// It leaves the facets.
    #[error(
        "it leaves the facets at ({:.6}, {:.6}, {:.6}) m, after {part:.1} % of its way", at[0], at[1], at[2]
    )]
    Leaves {
        /// Where [m].
        at: [f64; 3],
        /// After how much of its way [%].
        part: f64,
    },
    /// There is more than one layer of facets.
    #[error(
        "more than one layer of the facets is in its way at ({:.6}, {:.6}, {:.6}) m", at[0], at[1], at[2]
    )]
    Layers {
        /// Where [m].
        at: [f64; 3],
    },
    /// The axis passes through the facets.
    #[error("the axis passes through a facet at ({:.6}, {:.6}, {:.6}) m", at[0], at[1], at[2])]
    AxisInside {
        /// Where [m].
        at: [f64; 3],
    },
}

impl Piece {
    /// Where its first (0) or other (1) end is [m].
    pub fn place(&self, x: &[Vec3], end: usize) -> Vec3 {
        self.facet.iter().zip(self.ends[end]).map(|(&v, l)| l * x[v]).sum()
    }

    /// Where it is at t.
    fn at(&self, x: &[Vec3], t: f64) -> Vec3 {
        let [from, to] = self.range;
        let part = (t - from) / (to - from);
        (1.0 - part) * self.place(x, 0) + part * self.place(x, 1)
    }
}

/// The segment c = 0 of a facet by c and t of its corners, from a range of t.
fn cut(facet: [usize; 3], corners: [[f64; 2]; 3], range: [f64; 2]) -> Option<Piece> {
    // facets that are far higher than the pitch have c of many turns
    let most = corners.iter().fold(0.0_f64, |most, [c, _]| most.max(c.abs())).min(1.0);
    let c = corners.map(|[c, _]| if c.abs() < ROUNDING * most { 0.0 } else { c });
    let mut ends: Vec<[f64; 3]> = Vec::new();
    for k in 0..3 {
        let (next, mut end) = ((k + 1) % 3, [0.0; 3]);
        if c[k] == 0.0 {
            end[k] = 1.0;
        } else if c[k] * c[next] < 0.0 {
            end[next] = c[k] / (c[k] - c[next]);
            end[k] = 1.0 - end[next];
        } else {
            continue;
        }
        ends.push(end);
    }
    let [a, b] = ends.try_into().ok()?;
    let along = |end: &[f64; 3]| -> f64 { end.iter().zip(&corners).map(|(l, [_, t])| l * t).sum() };
    let (mut ends, mut own) = ([a, b], [along(&a), along(&b)]);
    if own[0] > own[1] {
        ends.swap(0, 1);
        own.swap(0, 1);
    }
    clipped(Piece { facet, ends, range: own, rates: Vec::new() }, range)
}

/// The part of a piece in a range of t; none where nothing is left.
fn clipped(piece: Piece, [first, last]: [f64; 2]) -> Option<Piece> {
    let ([from, to], [a, b]) = (piece.range, piece.ends);
    let own = [from.max(first), to.min(last)];
    if own[1] - own[0] <= ROUNDING * (last - first) {
        return None;
    }
    let ends = own.map(|t| {
        let part = (t - from) / (to - from);
        std::array::from_fn(|k| (1.0 - part) * a[k] + part * b[k])
    });
    Some(Piece { range: own, ends, ..piece })
}

/// ∂λ/∂c of an end of a piece, by c of the corners, for a motion along its edge, or at its height where it is free.
fn slide(end: &[f64; 3], corners: &[[f64; 2]; 3], free: bool) -> [f64; 3] {
    let mut along = [0.0; 3];
    match end.iter().position(|l| *l == 0.0) {
        Some(k) if !free => (along[(k + 1) % 3], along[(k + 2) % 3]) = (1.0, -1.0),
        _ => (0..3).for_each(|k| along[k] = corners[(k + 1) % 3][1] - corners[(k + 2) % 3][1]),
    }
    let across: f64 = corners.iter().zip(&along).map(|([c, _], d)| c * d).sum();
    along.map(|d| -d / across)
}

impl Helix {
    /// A helix of the hand of its lead.
    pub fn new(axis: Axis, lead: Lead, heights: [f64; 2], phase: f64) -> Self {
        let hand = lead.hand();
        Self { axis, lead, hand, heights, phase }
    }

    /// The helix of the other hand from the same start.
    pub fn opposite(&self) -> Self {
        Self { hand: -self.hand, ..self.clone() }
    }

    /// Its turns.
    pub fn turns(&self) -> f64 {
        let [start, end] = self.heights;
        TurnsByHeight::new(&self.lead, start).turns(end).count
    }

    /// Its segment in a facet, by c and t of the corners and their turns, with its rates. The range is that of t.
    fn piece(
        &self,
        facet: [usize; 3],
        corners: [[f64; 2]; 3],
        turns: &[Turns; 3],
    ) -> Option<Piece> {
        let rise = self.heights[1] - self.heights[0];
        let mut piece = cut(facet, corners, [0.0, rise])?;
        let values = self.lead.number().values().len();
        piece.rates = vec![[[0.0; 3]; 2]; values + 1];
        for (k, (end, t)) in piece.ends.iter().zip(piece.range).enumerate() {
            // an end of the thread that is on an edge moves at its height, too
            let ends_there = |limit: f64| (t - limit).abs() <= ROUNDING * rise;
            let free = ends_there(0.0) || ends_there(rise) || end.contains(&1.0);
            let slide = slide(end, &corners, free);
            for (i, rates) in piece.rates[..values].iter_mut().enumerate() {
                let by: f64 = turns.iter().zip(end).map(|(turns, l)| l * turns.by[i]).sum();
                rates[k] = slide.map(|slide| -slide * by);
            }
            piece.rates[values][k] = slide.map(|slide| -slide * self.hand / TAU);
        }
        Some(piece)
    }
}

/// Whether a piece is elsewhere than the chain is at the same t.
fn apart(chain: &[Piece], piece: &Piece, x: &[Vec3]) -> bool {
    let middle = f64::midpoint(piece.range[0], piece.range[1]);
    let size = (piece.place(x, 1) - piece.place(x, 0)).norm();
    let own = chain.iter().rev().find(|p| p.range[0] <= middle);
    own.is_some_and(|own| (own.at(x, middle) - piece.at(x, middle)).norm() > APART * size)
}

/// Pieces one after the other from one end of a range to the other.
fn chained(mut pieces: Vec<Piece>, x: &[Vec3], range: [f64; 2]) -> Result<Vec<Piece>, LayError> {
    pieces
        .sort_by(|a, b| a.range[0].total_cmp(&b.range[0]).then(a.range[1].total_cmp(&b.range[1])));
    if pieces.is_empty() {
        return Err(LayError::Misses);
    }
    let mean = pieces.iter().map(|p| p.range[1] - p.range[0]).sum::<f64>() / pieces.len() as f64;
    let (tolerance, mut chain): (f64, Vec<Piece>) = (GAP * mean, Vec::new());
    let mut reached = range[0];
    let leaves = |chain: &[Piece], reached: f64| {
        let Some(last) = chain.last() else { return LayError::Misses };
        let part = 100.0 * (reached - range[0]) / (range[1] - range[0]);
        LayError::Leaves { at: last.place(x, 1).into(), part }
    };
    for piece in pieces {
        let [from, to] = piece.range;
        if from > reached + tolerance {
            return Err(leaves(&chain, reached));
        }
        let layers = || LayError::Layers { at: piece.at(x, f64::midpoint(from, to)).into() };
        if to <= reached + tolerance {
            // what is between two facets is found in both
            if from < reached - tolerance && to - from > tolerance && apart(&chain, &piece, x) {
                return Err(layers());
            }
            continue;
        }
        if from < reached - tolerance {
            return Err(layers());
        }
        reached = to;
        chain.push(piece);
    }
    if reached < range[1] - tolerance {
        return Err(leaves(&chain, reached));
    }
    Ok(chain)
}

impl Axis {
    /// The direction from which angles around it count: x where it is along z or y, y where it is along x;
    /// its part across the axis.
    pub fn reference(&self) -> Vec3 {
        let from = if self.along.x.abs() > 0.9 { Vec3::y() } else { Vec3::x() };
        (from - from.dot(&self.along) * self.along).normalize()
    }

    /// Height along it from its point [m], and angle around it [rad].
    fn coordinates(&self, x: Vec3) -> [f64; 2] {
        let (from, first) = (x - self.point, self.reference());
        let second = self.along.cross(&first);
        [from.dot(&self.along), from.dot(&second).atan2(from.dot(&first))]
    }

    /// Mean distance of some facets from it, by their area [m].
    pub fn mean_distance(&self, facets: &[[usize; 3]], x: &[Vec3]) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for facet in facets {
            let [a, b, c] = facet.map(|v| x[v]);
            let (centre, size) = ((a + b + c) / 3.0, (b - a).cross(&(c - a)).norm());
            sum += size * (centre - self.point).cross(&self.along).norm();
            area += size;
        }
        sum / area
    }

    /// Smallest and largest height of some facets [m].
    pub fn heights(&self, facets: &[[usize; 3]], x: &[Vec3]) -> [f64; 2] {
        let all = facets.iter().flatten().map(|&v| (x[v] - self.point).dot(&self.along));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    }
}

/// Smallest and largest of values that are linear in a facet, where its height is in a range; none where it is not.
fn range_between(heights: [f64; 3], values: [f64; 3], [start, end]: [f64; 2]) -> Option<[f64; 2]> {
    let mut range = None;
    // the corners of the part in the range lie on edges
    for (k, next) in [(0, 1), (1, 2), (2, 0)] {
        let ([a, b], rise) = ([values[k], values[next]], heights[next] - heights[k]);
        let parts = [start, end].map(|height| ((height - heights[k]) / rise).clamp(0.0, 1.0));
        let outside = heights[k].max(heights[next]) < start || heights[k].min(heights[next]) > end;
        let parts = if rise == 0.0 { [0.0, 1.0] } else { parts };
        for value in parts.map(|part| a + part * (b - a)).into_iter().filter(|_| !outside) {
            let [least, most] = range.unwrap_or([value, value]);
            range = Some([value.min(least), value.max(most)]);
        }
    }
    range
}

/// Lays a helix on facets at rest positions: pieces of up to one facet, in the order of its turns.
pub fn helix(facets: &[[usize; 3]], x: &[Vec3], own: &Helix) -> Result<Vec<Piece>, LayError> {
    let [start, end] = own.heights;
    let turns_by_height = TurnsByHeight::new(&own.lead, start);
    let mut pieces = Vec::new();
    for &facet in facets {
        let corners = facet.map(|v| own.axis.coordinates(x[v]));
        let wrapped = |angle: f64| angle - TAU * (angle / TAU).round();
        let [first, second, third] = corners.map(|[_, angle]| angle);
        let sides = [wrapped(second - first), wrapped(third - second), wrapped(first - third)];
        if sides.iter().sum::<f64>().abs() > PI {
            let centre = facet.map(|v| x[v]).iter().sum::<Vec3>() / 3.0;
            return Err(LayError::AxisInside { at: centre.into() });
        }
        let angles = [first, first + sides[0], first - sides[2]];
        let beside = angles.map(|angle| own.hand * (angle - own.phase) / TAU);
        let turns = corners.map(|[height, _]| turns_by_height.turns(height));
        let along = [0, 1, 2].map(|k| turns[k].count);
        let heights = corners.map(|[height, _]| height);
        let Some([low, high]) = range_between(heights, along, own.heights) else { continue };
        let least = beside.into_iter().fold(f64::INFINITY, f64::min);
        let most = beside.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // whole turns after which the thread is at the angles and at the heights
        let (first, last) = ((low - most).floor(), (high - least).ceil());
        for after in first as i64..=last as i64 {
            let at = |k: usize| [beside[k] + after as f64 - along[k], corners[k][0] - start];
            pieces.extend(own.piece(facet, [at(0), at(1), at(2)], &turns));
        }
    }
    let mut chain = chained(pieces, x, [0.0, end - start])?;
    for piece in &mut chain {
        piece.range = piece.range.map(|height| turns_by_height.turns(start + height).count);
    }
    Ok(chain)
}

/// The nearest point of some facets with the normal there.
fn nearest(facets: &[[usize; 3]], x: &[Vec3], point: Vec3) -> Option<(Vec3, Vec3)> {
    let on = |facet: &[usize; 3]| {
        let [a, b, c] = facet.map(|v| x[v]);
        (closest_on_triangle(&point, &[a, b, c]), (b - a).cross(&(c - a)).normalize())
    };
    let distance = |(place, _): &(Vec3, Vec3)| (place - point).norm();
    facets.iter().map(on).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Lays a polyline on facets at rest positions, leg by leg; its points are moved to the nearest ones of the
/// facets. Pieces farther from a leg than half its length are none of it.
pub fn polyline(
    facets: &[[usize; 3]],
    x: &[Vec3],
    points: &[Vec3],
) -> Result<Vec<Piece>, LayError> {
    let on = |&point: &Vec3| nearest(facets, x, point).ok_or(LayError::Misses);
    let places = points.iter().map(on).collect::<Result<Vec<_>, _>>()?;
    let mut pieces = Vec::new();
    for (i, leg) in places.windows(2).enumerate() {
        let [(a, first), (b, second)] = [leg[0], leg[1]];
        // normals of facets inside a body have either sign
        let up = if first.dot(&second) < 0.0 { first - second } else { first + second };
        let (along, long) = (b - a, (b - a).norm());
        let beside = along.cross(&up).normalize();
        let up = beside.cross(&along) / long;
        let range = [i as f64, i as f64 + 1.0];
        for &facet in facets {
            let values = facet.map(|v| {
                let from = x[v] - a;
                [from.dot(&beside), i as f64 + from.dot(&along) / (long * long)]
            });
            let near = |piece: &Piece| {
                let middle = 0.5 * (piece.place(x, 0) + piece.place(x, 1));
                (middle - a).dot(&up).abs() <= 0.5 * long
            };
            pieces.extend(cut(facet, values, range).filter(near));
        }
    }
    chained(pieces, x, [0.0, (points.len() - 1) as f64])
}
