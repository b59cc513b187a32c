//! The rest offset: pairs of one body that are closer at rest than the barrier reaches
//! have an activation of their own, so that neither force nor energy is there at rest.
//!
//! a = min(d̂, D − d₀)      β_a(d²) = V(d̂)/V(a) β(d²; a)
//!
//! D   distance of the pair at rest [m], less some of its rounding
//! V   divisor of a [`form`](Form::divisor): pressures depend on d/a alone [m³; 1]
//!
//! Where several features meet, their part has the least activation of those that
//! contain it: as β_a grows with a, parts take off no more than their features add. Pairs
//! that are farther apart than a have no part that acts.

use mesh::Vec3;

use super::barrier::Form;
use super::density::Repulsion;
use super::distance::{Closest, corners};
use super::pairs::Pair;
use crate::math::tensor::Vec12;

/// D in distances at rest: less by more than their rounding, so that at rest β is zero.
const AT_REST: f64 = 1.0 - 1e-12;

/// A pair with an activation of its own [m]: the less comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// a; not positive where rest shapes are closer than they may be.
    pub activation: f64,
    /// Whose rest distance it is.
    pub pair: Pair,
}

impl Offset {
    /// The offset of a pair of one body at rest positions of all collision vertices [m]; none
    /// where the pair is out of range.
    pub fn of(pair: &Pair, rest: &[Vec3], repulsion: &Repulsion) -> Option<Self> {
        let d2 = pair.closest(&pair.gather(rest)).d2;
        let near = d2 < repulsion.range().powi(2);
        let activation = AT_REST * d2.sqrt() - repulsion.minimum;
        near.then_some(Self { activation, pair: *pair })
    }

    /// The lesser of two, where none has the full activation.
    pub fn least(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        let key = |offset: &Self| (offset.activation, offset.pair);
        match (one, other) {
            (Some(a), Some(b)) => Some(if key(&b) < key(&a) { b } else { a }),
            (one, other) => one.or(other),
        }
    }
}

/// A pair within range.
#[derive(Clone, Copy, Debug)]
pub struct Close {
    /// The pair.
    pub pair: Pair,
    /// The closest points.
    pub closest: Closest,
    /// The activation, if that is not the full one.
    pub offset: Option<Offset>,
}

impl Close {
    /// Whether the pair is not farther apart than it must be, here or at rest.
    pub fn is_violated(&self, repulsion: &Repulsion) -> bool {
        let at_rest = self.offset.is_some_and(|offset| offset.activation <= 0.0);
        at_rest || repulsion.is_violated(self.closest.d2)
    }

    /// Whether its features repel each other.
    pub fn acts(&self, repulsion: &Repulsion) -> bool {
        let activation = self.offset.map_or(repulsion.activation, |offset| offset.activation);
        self.closest.d2 < (repulsion.minimum + activation).powi(2)
    }
}

/// β_a of a pair, and how a follows the rest shape.
pub struct OffsetRepulsion {
    repulsion: Repulsion,
    /// V(d̂)/V(a) and its derivative by a.
    factor: [f64; 2],
    /// Corners of the pair whose rest distance decides.
    pub corners: [usize; 4],
    /// ∂a/∂X there.
    pub by_rest: Vec12,
}

impl OffsetRepulsion {
    /// β_a for the rest distance of a pair.
    pub fn new(pair: &Pair, rest: &[Vec3], full: &Repulsion, form: Form) -> Self {
        let closest = pair.closest(&pair.gather(rest));
        let distance = AT_REST * closest.d2.sqrt();
        let repulsion = Repulsion { activation: distance - full.minimum, ..*full };
        let ([all, _], [own, slope]) = (form.divisor(full), form.divisor(&repulsion));
        let by_rest = corners(closest.d2_gradient()) * (AT_REST * AT_REST / (2.0 * distance));
        let factor = [all / own, -all * slope / (own * own)];
        Self { repulsion, factor, corners: pair.corners(), by_rest }
    }

    /// β_a [m⁴] and its first two derivatives by d² at a squared distance [m²].
    pub fn at(&self, d2: f64) -> [f64; 3] {
        self.repulsion.at(d2).map(|beta| self.factor[0] * beta)
    }

    /// The derivatives of β_a and ∂β_a/∂d² by a at a squared distance [m²].
    pub fn by_activation(&self, d2: f64) -> [f64; 2] {
        let (beta, by) = (self.repulsion.at(d2), self.repulsion.by_activation(d2));
        [0, 1].map(|k| self.factor[0] * by[k] + self.factor[1] * beta[k])
    }
}
