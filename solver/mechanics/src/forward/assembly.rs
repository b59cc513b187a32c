//! The assembly of second derivatives: of all terms at an iterate, or along the chord of the step that leads there.

use super::Problem;
use super::timings::Timings;
use crate::energy::chord::{self, Side, on_chord};
use crate::energy::{Hessian, Iterate, Nature, RankOne, Term};
use crate::math::linear::dot;
use crate::math::sparse::{BlockMatrix, Pattern};

/// What is assembled of the second derivatives of all terms.
pub struct Wanted<'a> {
    /// Which second derivatives.
    pub kind: Hessian,
    /// Of the gradient by the end, by which side of the chord of the step.
    pub side: Side,
    /// Of which terms.
    pub of: &'a dyn Fn(Nature) -> bool,
}

/// The sparse part of second derivatives, in the memory of an earlier matrix.
pub fn assemble<'p>(
    pattern: &'p Pattern,
    memory: Vec<[f64; 9]>,
    problem: &Problem,
    at: &Iterate,
    wanted: &Wanted,
    timings: &mut Timings,
) -> BlockMatrix<'p> {
    let mut sum = BlockMatrix::zeros_in(pattern, memory);
    let terms = || problem.energies.terms().filter(|term| (wanted.of)(term.nature()));
    if at.step.is_none_or(|step| step.chord.is_none()) {
        for term in terms() {
            timings.of(term.nature(), || term.energy.add_hessian(at, wanted.kind, &mut sum));
        }
        return sum;
    }
    for s in chord::ALL {
        on_chord(at, s, |there| {
            // the terms of a point have few different parts: of the mean, and alone
            for alone in [false, true] {
                let point = |term: &Term| {
                    let points = term.points(at);
                    let own = points.iter().find(|point| point[0] == s).copied();
                    own.filter(|_| (points.len() == 1) == alone)
                };
                let Some(factor) = terms().find_map(point).map(|p| wanted.side.weight(p)) else {
                    continue;
                };
                if factor == 0.0 {
                    continue;
                }
                let mut own = BlockMatrix::zeros(pattern);
                for term in terms().filter(|&term| point(term).is_some()) {
                    timings.of(term.nature(), || {
                        term.energy.add_hessian(there, wanted.kind, &mut own)
                    });
                }
                sum.add_multiple(factor, &own);
            }
        });
    }
    sum
}

/// A Hessian of a sparse and a dense part times a vector.
pub fn times(matrix: &BlockMatrix, dense: &[RankOne], vector: &[f64]) -> Vec<f64> {
    let mut product = matrix.multiply(vector);
    for RankOne { scale, vector: v } in dense {
        let along = scale * dot(v, vector);
        product.iter_mut().zip(v).for_each(|(p, v)| *p += along * v);
    }
    product
}
