//! Forces along the chord of a time step: what keeps the energy of a body in motion.
//!
//! F = ∫₀¹ −∂E/∂u(u₀ + s Δu) ds,   Δu = u − u₀        so that F · Δu = E(u₀) − E(u)
//!
//! u₀   the state at the start of the step
//!
//! Velocities that change by Δt M⁻¹ F over the step, and a mean velocity of Δu/Δt, then leave the sum of kinetic and
//! potential energy as it is. F is the gradient of ∫₀¹ E(u₀ + s Δu)/s ds by u, so that a step has a potential. The
//! integral is that of `MEAN`, four points of Lobatto, exact up to s⁵: what the contact keeps apart it keeps apart at
//! the end, which is one of them. So is the start, where E/s is ∇E(u₀) · Δu: a step back undoes a step, and what the
//! rule misses of a barrier that is met is given back when it is left. Loads are those of the time at each point.
//!
//! What keeps a part rigid is many times as stiff as all else. Along a chord a part that turns is shorter than at both
//! ends, which would make its mean force expand it; at `MIDDLE` with the strain of both ends it has none, see
//! [`Rigid`](super::Rigid).
//!
//! Inertia is that of the whole step. Friction, overstress, softening, and gas that is prescribed or remembered are
//! taken at its end: energy is not kept in them.
//!
//! Sources: Quispel and McLaren 2008, "A new class of energy-preserving numerical integration methods",
//! doi:10.1088/1751-8113/41/4/045206; Simo and Tarnow 1992, "The discrete energy-momentum method",
//! doi:10.1007/BF00913408.

use super::{Iterate, RankOne, Term};

/// The chord of a time step.
#[derive(Clone, Debug, Default)]
pub struct Chord {
    /// Displacement at the start u₀ [m].
    pub start: Vec<f64>,
    /// Time at the start [s].
    pub time: f64,
    /// The end, of which [`Rigid`](super::Rigid) takes how far a part turns [m]: to be that which is found.
    pub end: Vec<f64>,
}

/// A point of a chord: where it is, s, and its part of the mean.
pub type Point = [f64; 2];

/// The end alone.
pub(super) const END: &[Point] = &[[1.0, 1.0]];
/// The middle alone.
pub(super) const MIDDLE: &[Point] = &[[0.5, 1.0]];
/// √5.
const ROOT: f64 = 2.236_067_977_499_79;
/// The points of Lobatto.
pub(super) const MEAN: &[Point] = &[
    [0.0, 1.0 / 12.0],
    [(5.0 - ROOT) / 10.0, 5.0 / 12.0],
    [(5.0 + ROOT) / 10.0, 5.0 / 12.0],
    [1.0, 1.0 / 12.0],
];

/// All points at which terms are evaluated, each once.
pub const ALL: [f64; 5] = [MEAN[0][0], MEAN[1][0], 0.5, MEAN[2][0], 1.0];

impl Chord {
    /// The displacement at a point of the chord to `u` [m].
    pub fn between(&self, u: &[f64], s: f64) -> Vec<f64> {
        self.start.iter().zip(u).map(|(from, to)| from + s * (to - from)).collect()
    }
}

/// What a term contributes to the equations of the step that leads to an iterate: at the iterate, or, where the step
/// has a chord, along that.
impl Term {
    /// The points at which it counts.
    pub fn points(&self, at: &Iterate) -> &'static [Point] {
        if at.step.is_none_or(|step| step.chord.is_none()) {
            return END;
        }
        self.energy.chord_points(at)
    }

    /// Calls `each` with the energy's iterate at each of the points, with s and its part.
    fn along(&self, at: &Iterate, mut each: impl FnMut(&Iterate, Point)) {
        for &[s, part] in self.points(at) {
            on_chord(at, s, |there| each(there, [s, part]));
        }
    }

    /// Potential of the step [J].
    pub fn value(&self, at: &Iterate) -> f64 {
        let mut sum = 0.0;
        self.along(at, |there, [s, part]| {
            sum +=
                part * if s > 0.0 { self.energy.value(there) / s } else { self.work(there, at.u) };
        });
        sum
    }

    /// ∇E · Δu from the start of a chord to its end [J].
    fn work(&self, start: &Iterate, end: &[f64]) -> f64 {
        let mut gradient = vec![0.0; end.len()];
        self.energy.add_gradient(start, &mut gradient);
        let by_moves = gradient.iter().zip(end.iter().zip(start.u));
        by_moves.map(|(g, (to, from))| g * (to - from)).sum()
    }

    /// Adds its gradient by the end [N].
    pub fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        self.along(at, |there, [_, part]| {
            add_multiple(out, part, |out| self.energy.add_gradient(there, out));
        });
    }

    /// What its second derivative adds to its sparse part, by the end and, in the second derivative, by what is at the
    /// other `side`.
    pub fn rank_ones(&self, at: &Iterate, side: Side) -> Vec<RankOne> {
        let mut all = Vec::new();
        self.along(at, |there, point| {
            let weight = side.weight(point);
            let found = (weight > 0.0).then(|| self.energy.rank_one(there)).flatten();
            all.extend(found.map(|found| RankOne { scale: weight * found.scale, ..found }));
        });
        all
    }

    /// Pairs of nodes that it couples beyond elements.
    pub fn couplings(&self, at: &Iterate, reach: f64) -> Vec<[usize; 2]> {
        let mut all = Vec::new();
        self.along(at, |there, _| all.extend(self.energy.couplings(there, reach)));
        all
    }

    /// Adds λᵀ ∂²/∂u∂X of the potential.
    pub fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        self.along(at, |there, [_, part]| {
            add_multiple(out, part, |out| self.energy.add_mixed_vjp(there, lambda, out));
        });
    }

    /// λᵀ ∂²/∂u∂p of the potential for the numbers p of the term.
    pub fn parameter_vjp(&self, at: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let mut sum: Vec<f64> = Vec::new();
        self.along(at, |there, [_, part]| {
            let by = self.energy.parameter_vjp(there, lambda);
            sum.resize(by.len(), 0.0);
            sum.iter_mut().zip(by).for_each(|(sum, by)| *sum += part * by);
        });
        sum
    }
}

/// By what the gradient of the potential of a step is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The end of the chord.
    End,
    /// The start of the chord.
    Start,
}

impl Side {
    /// The weight of the second derivative at a point.
    pub fn weight(self, [s, part]: Point) -> f64 {
        match self {
            Self::End => part * s,
            Self::Start => part * (1.0 - s),
        }
    }
}

/// Calls `each` with the iterate at a point of the chord to an iterate; without a chord, or for its end, with that.
pub fn on_chord(at: &Iterate, s: f64, each: impl FnOnce(&Iterate)) {
    match at.step.and_then(|step| step.chord.as_ref()) {
        Some(chord) if s < 1.0 => {
            let u = chord.between(at.u, s);
            // all loads are zero at the time 0 itself, which a step that begins there has not
            let time = (chord.time + s * (at.time - chord.time)).max(f64::MIN_POSITIVE);
            each(&Iterate { u: &u, time, chord: Some(chord), ..*at });
        }
        _ => each(at),
    }
}

/// Adds a multiple of what `add` adds.
fn add_multiple(out: &mut [f64], factor: f64, add: impl FnOnce(&mut [f64])) {
    if factor == 1.0 {
        return add(out);
    }
    let mut own = vec![0.0; out.len()];
    add(&mut own);
    out.iter_mut().zip(own).for_each(|(out, own)| *out += factor * own);
}
