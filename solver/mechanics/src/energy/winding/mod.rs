//! Threads that are wound on facets: embedded bars, whose nodes are those of the elements.
//!
//! W(u; X) = Σ ∫ ½ EA q(ε + N₀/EA) dS      ε = l/L − 1      l = |D + u′|, D = X_b − X_a, L = |D|
//! N = ½ EA q′      t = (D + u′)/l      m = λ′
//! ∂W/∂u_a = Σ w N t φ′_a
//! ∂²W/∂u_a∂u_b = Σ w [½ EA q″/L t⊗t + N/l (I − t⊗t)] φ′_a φ′_b
//!
//! EA  stiffness of the thread [N], which may change along an axis, as a property of the thread at a point
//! N₀  pretension [N]: the force of a thread that is as long as at rest
//! q   the square of a strain that counts in tension only, [`square`]
//!
//! A segment lies in a facet. Its ends have fixed barycentric
//! coordinates there: they are points of the material, which move with the body and with a designed rest shape,
//! and the length of the thread without force is that of the rest shape. ′ is the derivative along a segment from
//! its first end to its other, which for the basis is a number of the reference of that facet, so that D and φ′
//! are all that is known of the rest shape. As N ≥ 0 and q″ ≥ 0, the Hessian is positive semidefinite at any state.
//!
//! Derivative by the rest shape: λ · ∂W/∂u = Σ w N t·m, by D
//!
//! w [½ EA q″ (t·m) (t/L − l D/L³) + N (m − (t·m) t)/l]
//!
//! The parameters are the values of EA, N₀, and of a helix the values of its [`Lead`] and its phase [rad]. By the
//! course, ends of segments move at the rates of their [`Piece`]: with δ from end to end and λ a point of a segment,
//!
//! Ḋ = Σ δ̇_k X_k      φ̇′ = ∇φ · δ̇ + δ · ∇∇φ λ̇      L̇ = ∂L/∂D · Ḋ + Σ_a (∂L/∂u′ · u_a + w N t · λ_a) φ̇′_a
//!
//! ∂L/∂u′ is w (½ EA q″/L t⊗t + N/l (I − t⊗t)) m: the Hessian by u′ times m. Where EA changes along an axis, each
//! point takes that of its new height, which adds ∂L/∂EA dEA/dz ż.

mod lead;
mod force;
mod lay;
mod measures;

use mesh::Vec3;

use super::{Energy, Hessian, Iterate, Nature, Owner, Profile, Slot};
use crate::element::quadrature::Rule;
use crate::element::{FunctionSpace, add_at, at, tabulate};
use crate::material::slack::square;
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::Mat3;
use crate::parallel::map_each;

pub use lay::{Helix, LayError, Piece, helix, polyline};
pub use lead::{Along, Lead};
pub use measures::{Strand, WindingSummary};

#[cfg(test)]
pub(super) mod tests;

/// Threads of one kind on the facets of a tag.
#[derive(Clone)]
pub struct Winding {
    /// Values of EA [N].
    stiffness: Vec<f64>,
    /// N₀ [N].
    pub pretension: f64,
    /// Strain over which the thread becomes taut [1].
    pub slack: f64,
    /// Sum of the ranges of all pieces.
    turns: f64,
    segments: Vec<Segment>,
    /// The helix that it is, if it is one.
    pub helix: Option<Helix>,
}

/// A straight piece of a thread in a facet or a tetrahedron.
#[derive(Clone)]
struct Segment {
    vertices: [usize; 3],
    nodes: Vec<usize>,
    /// Barycentric coordinates of its ends.
    ends: [[f64; 3]; 2],
    /// δ, from one end to the other.
    across: [f64; 3],
    points: Vec<Place>,
    /// δ̇ by the values of the lead, and by the phase.
    rates: Vec<Vec<f64>>,
}

/// What a quadrature point of a segment has of the reference.
#[derive(Clone)]
struct Place {
    weight: f64,
    /// φ′ of the nodes.
    slopes: Vec<f64>,
    /// φ̇′ of the nodes by the values of the lead, and by the phase.
    rates: Vec<Vec<f64>>,
    /// λ̇ by the same.
    moves: Vec<Vec<f64>>,
    /// What each value of EA has of that here.
    shares: Vec<(usize, f64)>,
    /// Derivatives of EA by the values of the lead, and by the phase.
    stiffness_rates: Vec<f64>,
}

/// A quadrature point of a segment.
struct Point<'a> {
    place: &'a Place,
    /// EA [N].
    stiffness: f64,
    /// D [m].
    rest: Vec3,
    /// L [m].
    long: f64,
    /// l [m].
    stretched: f64,
    /// t.
    along: Vec3,
    /// q, q′ and q″.
    square: [f64; 3],
}

/// Gauss–Legendre rules on [0, 1] of one, two and three points: places and weights.
fn rule(points: usize) -> Vec<(f64, f64)> {
    let pair = |root: f64, weight: f64| [(0.5 - root, weight), (0.5 + root, weight)];
    match points {
        1 => vec![(0.5, 1.0)],
        2 => pair(0.5 / 3.0_f64.sqrt(), 0.5).to_vec(),
        _ => {
            let [low, high] = pair(0.5 * 0.6_f64.sqrt(), 5.0 / 18.0);
            vec![low, (0.5, 4.0 / 9.0), high]
        }
    }
}

/// From one end to the other.
fn between(ends: &[[f64; 3]; 2]) -> [f64; 3] {
    std::array::from_fn(|k| ends[1][k] - ends[0][k])
}

/// The place at a part of the way between two ends.
fn part(ends: &[[f64; 3]; 2], s: f64) -> [f64; 3] {
    let by = between(ends);
    std::array::from_fn(|k| ends[0][k] + s * by[k])
}

/// Derivatives of a basis at barycentric coordinates along a difference of such.
fn along(degree: usize, at: &[f64; 3], by: &[f64; 3]) -> Vec<f64> {
    let table = tabulate(degree, &Rule { weights: vec![1.0], points: vec![at.to_vec()] });
    let slope = |g: &[f64; 3]| g.iter().zip(&by[1..]).map(|(g, by)| g * by).sum();
    table.gradients[0].iter().map(slope).collect()
}

/// φ̇′ at a part of the way, for rates of the ends. Gradients are quadratic at most, so that their central
/// difference along λ̇ is exact.
fn slope_rates(degree: usize, piece: &Piece, rates: &[[f64; 3]; 2], s: f64) -> Vec<f64> {
    let (at, moves, by) = (part(&piece.ends, s), part(rates, s), between(&piece.ends));
    let size = moves.iter().fold(0.0_f64, |size, m| size.max(m.abs()));
    let own = along(degree, &at, &between(rates));
    if size == 0.0 {
        return own;
    }
    let shifted = |sign: f64| std::array::from_fn(|k| at[k] + sign / size * moves[k]);
    let [before, after] = [-1.0, 1.0].map(|sign| along(degree, &shifted(sign), &by));
    let turned = before.iter().zip(&after).map(|(before, after)| 0.5 * size * (after - before));
    own.iter().zip(turned).map(|(own, turned)| own + turned).collect()
}

impl Segment {
    fn new(space: &FunctionSpace, piece: &Piece) -> Self {
        let Piece { facet, ends, rates, .. } = piece;
        let (degree, by) = (space.degree(), between(ends));
        let place = |(s, weight): (f64, f64)| Place {
            weight,
            slopes: along(degree, &part(ends, s), &by),
            rates: rates.iter().map(|rates| slope_rates(degree, piece, rates, s)).collect(),
            moves: rates.iter().map(|rates| part(rates, s).to_vec()).collect(),
            shares: vec![(0, 1.0)],
            stiffness_rates: vec![0.0; rates.len()],
        };
        let points = rule(degree).into_iter().map(place).collect();
        Self {
            vertices: *facet,
            nodes: space.facet_nodes(*facet),
            ends: *ends,
            across: by,
            points,
            rates: rates.iter().map(|rates| between(rates).to_vec()).collect(),
        }
    }

    /// Σ δ_k X_k over the corners.
    fn corners(&self, by: &[f64], rest: &[Vec3]) -> Vec3 {
        self.vertices.iter().zip(by).map(|(&v, by)| *by * rest[v]).sum()
    }

    /// w′ of a nodal field.
    fn slope(&self, slopes: &[f64], w: &[f64]) -> Vec3 {
        self.nodes.iter().zip(slopes).map(|(&node, slope)| *slope * at(w, node)).sum()
    }
}

impl Point<'_> {
    /// The Hessian by the slope u′, but for the weight.
    fn hessian(&self) -> Mat3 {
        let dyad = self.along * self.along.transpose();
        let axial = 0.5 * self.stiffness * self.square[2] / self.long;
        let lateral = self.force() / self.stretched;
        lateral * Mat3::identity() + (axial - lateral) * dyad
    }

    /// N [N].
    fn force(&self) -> f64 {
        0.5 * self.stiffness * self.square[1]
    }

    /// ∂N/∂EA [1] and ∂N/∂N₀ [1].
    fn force_by_law(&self, pretension: f64) -> [f64; 2] {
        let [_, first, second] = self.square;
        [0.5 * (first - pretension / self.stiffness * second), 0.5 * second]
    }

    /// ∂ε/∂D at constant u′.
    fn strained(&self) -> Vec3 {
        self.along / self.long - (self.stretched / self.long.powi(3)) * self.rest
    }

    /// ∂L/∂D of L = w N t·m.
    fn by_rest(&self, m: &Vec3) -> Vec3 {
        let along = self.along.dot(m);
        let by_strain = 0.5 * self.stiffness * self.square[2] * along;
        let turned = self.force() / self.stretched * (m - along * self.along);
        self.place.weight * (by_strain * self.strained() + turned)
    }

    /// L̇ for the rate k of the ends.
    fn by_ends(&self, segment: &Segment, (at, lambda): (&Iterate, &[f64]), k: usize) -> f64 {
        let slope = |field: &[f64]| segment.slope(&self.place.rates[k], field);
        let m = segment.slope(&self.place.slopes, lambda);
        let by_slope = self.place.weight * self.hessian() * m;
        let by_m = self.place.weight * self.force() * self.along;
        self.by_rest(&m).dot(&segment.corners(&segment.rates[k], at.rest))
            + by_slope.dot(&slope(at.u))
            + by_m.dot(&slope(lambda))
    }
}

impl Winding {
    /// Who owns the numbers of a thread, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("winding", place)
    }

    /// A thread of pieces in facets of the mesh, as [`helix`] and [`polyline`] lay them.
    ///
    /// # Panics
    /// When one is in no facet of the mesh and the degree is above 1.
    pub fn new(
        space: &FunctionSpace,
        pieces: &[Piece],
        [stiffness, pretension, slack]: [f64; 3],
    ) -> Self {
        let segments = pieces.iter().map(|piece| Segment::new(space, piece)).collect();
        let turns = pieces.iter().map(|piece| piece.range[1] - piece.range[0]).sum();
        Self { stiffness: vec![stiffness], pretension, slack, turns, segments, helix: None }
    }

    /// The same as a helix, or two of both hands, whose lead and phase are numbers of the thread, too.
    pub fn with_helix(self, helix: Option<Helix>) -> Self {
        Self { helix, ..self }
    }

    /// The same with a stiffness that changes along an axis [N]: each point of the thread has that of its height at rest.
    pub fn with_stiffness(mut self, profile: &Profile, rest: &[Vec3]) -> Self {
        self.stiffness = profile.values().to_vec();
        for segment in &mut self.segments {
            let [a, b] =
                [0, 1].map(|end| profile.height(segment.corners(&segment.ends[end], rest)));
            let corners: Vec<f64> =
                segment.vertices.iter().map(|&v| profile.height(rest[v])).collect();
            let rule = rule(segment.points.len());
            for (place, (s, _)) in segment.points.iter_mut().zip(rule) {
                let height = (1.0 - s) * a + s * b;
                place.shares = profile.basis(height).pairs().collect();
                let lead = |by: &Vec<f64>| by.iter().zip(&corners).map(|(by, z)| by * z).sum();
                let climbs = place.moves.iter().map(lead);
                let slope = profile.slope(height);
                place.stiffness_rates = climbs.map(|lead: f64| slope * lead).collect();
            }
        }
        self
    }

    /// Number of the parameters of the thread itself, before those of its course.
    fn own_parameters(&self) -> usize {
        self.stiffness.len() + 1
    }

    /// Number of all parameters.
    fn parameters(&self) -> usize {
        self.own_parameters() + self.segments.first().map_or(0, |segment| segment.rates.len())
    }

    /// How long it is in the unit in which it was laid: turns of helices, legs of polylines.
    pub fn turns(&self) -> f64 {
        self.turns
    }

    /// Number of its segments.
    pub fn segments(&self) -> usize {
        self.segments.len()
    }

    fn for_each_point(&self, iterate: &Iterate, segment: &Segment, mut f: impl FnMut(&Point)) {
        let rest = segment.corners(&segment.across, iterate.rest);
        let long = rest.norm();
        for place in &segment.points {
            let moved = segment.slope(&place.slopes, iterate.u);
            let stretched = (rest + moved).norm();
            // without the digits of 1
            let strain =
                (2.0 * rest.dot(&moved) + moved.norm_squared()) / (long * (stretched + long));
            let shares = place.shares.iter();
            let stiffness = shares.map(|&(i, share)| share * self.stiffness[i]).sum();
            let square = square(strain + self.pretension / stiffness, Some(self.slack));
            let along = (rest + moved) / stretched;
            f(&Point { place, stiffness, rest, long, stretched, along, square });
        }
    }

    /// Calls `of_point` with each segment's points, in parallel, which changes a value that begins as
    /// `T::default()`, and `merge` with each segment and its value, in their order.
    fn for_each_segment<T: Default + Send>(
        &self,
        iterate: &Iterate,
        of_point: impl Fn(&Segment, &Point, &mut T) + Sync,
        merge: impl FnMut(&Segment, T),
    ) {
        let one = |segment: &Segment| {
            let mut value = T::default();
            self.for_each_point(iterate, segment, |p| of_point(segment, p, &mut value));
            value
        };
        map_each(&self.segments, one, merge);
    }
}

impl Energy for Winding {
    fn kind(&self) -> (&'static str, Nature) {
        ("winding", Nature::Elastic)
    }

    fn is_reinforcement(&self) -> bool {
        true
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        let mut sum = 0.0;
        self.for_each_segment(
            iterate,
            |_, p, value: &mut f64| {
                *value += 0.5 * p.stiffness * p.place.weight * p.long * p.square[0]
            },
            |_, part| sum += part,
        );
        sum
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        self.for_each_segment(
            iterate,
            |_, p, forces: &mut Vec<Vec3>| {
                forces.resize(p.place.slopes.len(), Vec3::zeros());
                let pull = p.place.weight * p.force() * p.along;
                forces
                    .iter_mut()
                    .zip(&p.place.slopes)
                    .for_each(|(force, slope)| *force += pull * *slope);
            },
            |segment, forces| {
                segment.nodes.iter().zip(&forces).for_each(|(&node, f)| add_at(out, node, f));
            },
        );
    }

    fn add_hessian(&self, iterate: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        self.for_each_segment(
            iterate,
            |_, p, blocks: &mut Vec<Mat3>| {
                let n = p.place.slopes.len();
                blocks.resize(n * n, Mat3::zeros());
                let stiffness = p.place.weight * p.hessian();
                for (a, blocks) in p.place.slopes.iter().zip(blocks.chunks_exact_mut(n)) {
                    let pairs = p.place.slopes.iter().zip(blocks);
                    pairs.for_each(|(b, block)| *block += a * b * stiffness);
                }
            },
            |segment, blocks| out.add_dense(&segment.nodes, &blocks),
        );
    }

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        self.for_each_segment(
            iterate,
            |segment, p, by: &mut Vec3| *by += p.by_rest(&segment.slope(&p.place.slopes, lambda)),
            |segment, by| {
                for (&vertex, share) in segment.vertices.iter().zip(&segment.across) {
                    add_at(out, vertex, &(*share * by));
                }
            },
        );
    }

    fn slots(&self) -> Vec<Slot> {
        let values = (self.stiffness.len() > 1).then_some(self.stiffness.len());
        let mut slots = Slot::along("stiffness", "N", values);
        slots.push(Slot::new("pretension", "N"));
        if let Some(helix) = &self.helix {
            slots.extend(helix.lead.slots());
            slots.push(Slot::new("phase", "rad"));
        }
        slots
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let (mut sum, own) = (vec![0.0; self.parameters()], self.own_parameters());
        self.for_each_segment(
            iterate,
            |segment, p, by: &mut Vec<f64>| {
                by.resize(self.parameters(), 0.0);
                let along = p.place.weight * p.along.dot(&segment.slope(&p.place.slopes, lambda));
                let [by_stiffness, by_pretension] = p.force_by_law(self.pretension);
                p.place.shares.iter().for_each(|(i, share)| by[*i] += share * along * by_stiffness);
                by[own - 1] += along * by_pretension;
                for (k, by) in by[own..].iter_mut().enumerate() {
                    *by += p.by_ends(segment, (iterate, lambda), k);
                    *by += along * by_stiffness * p.place.stiffness_rates[k];
                }
            },
            |_, part| sum.iter_mut().zip(part).for_each(|(s, p)| *s += p),
        );
        sum
    }
}
