//! Moment on a rigid part.
//!
//! E = −Σ_k M_k θ_k,   θ_k = atan2(s_k, c_k)
//! c_k = Σ_p (F p) · p = Σ_j x_j · a_j,   s_k = Σ_p (F p) · (e_k × p) = Σ_j x_j · b_j
//!
//! M_k  moment about the axis e_k, one of x, y, z [N m]
//! θ_k  angle by which the part has turned about it, as seen along it, between −π and π [rad]
//! p    one or two orthonormal directions across the axis in which the part has an extent
//! F    deformation gradient of the part; x_j its masters [m]
//!
//! A moment has a potential only with a rule of how it turns along with the part. This one is exact where the part
//! turns about that axis alone, as on a hinge, and to first order everywhere. See Ziegler 1968, "Principles of Structural
//! Stability", section 5.1 (quasi-tangential moments).

use std::sync::Arc;

use mesh::Vec3;
use nalgebra::{DMatrix, DVector};

use super::super::{Energy, Hessian, Iterate, Nature, Owner, Slot};
use super::pairs;
use crate::element::{add_at, at};
use crate::math::sparse::BlockMatrix;
use crate::rigid::RigidSet;
use crate::schedule::{Field, Schedule};

/// Part of a direction across an axis, below which it lies along it.
const ALONG: f64 = 1e-9;

/// Moments about x, y and z.
#[derive(Clone)]
pub struct RigidMoment {
    /// M_k [N m].
    pub moment: Field,
    masters: Vec<usize>,
    turns: [Option<Turn>; 3],
}

/// How an angle follows from the masters.
#[derive(Clone)]
struct Turn {
    /// Σ_j X_j · a_j and Σ_j X_j · b_j at rest.
    rest: [f64; 2],
    /// a_j and b_j.
    by: Vec<[Vec3; 2]>,
}

/// A part has no extent across an axis, so that no moment can turn it about that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it has no extent across axis {axis}")]
pub struct NoLever {
    /// 0 to 2 for x to z.
    pub axis: usize,
}

impl Turn {
    fn new(part: &RigidSet, positions: &[Vec3], axis: usize) -> Result<Self, NoLever> {
        let along = Vec3::ith(axis, 1.0);
        let mut by = vec![[Vec3::zeros(); 2]; part.masters().len()];
        let across = across(part.axes(), along);
        if across.is_empty() {
            return Err(NoLever { axis });
        }
        let gradients = part.scaled_gradients();
        for p in across {
            let scaled = part.axes().transpose() * DVector::from_column_slice(p.as_slice());
            let scaled = scaled.component_div(&DVector::from_column_slice(part.extents()));
            for (row, [a, b]) in gradients.row_iter().zip(&mut by) {
                let share = (row * &scaled)[(0, 0)];
                *a += share * p;
                *b += share * along.cross(&p);
            }
        }
        let origin = part.masters().first().map_or_else(Vec3::zeros, |&m| positions[m]);
        let mut rest = [0.0; 2];
        for (&master, vectors) in part.masters().iter().zip(&by) {
            let x = positions[master] - origin;
            rest.iter_mut().zip(vectors).for_each(|(sum, vector)| *sum += x.dot(vector));
        }
        Ok(Self { rest, by })
    }

    /// c and s.
    fn sides(&self, masters: &[usize], u: &[f64]) -> [f64; 2] {
        let mut sides = self.rest;
        for (&master, vectors) in masters.iter().zip(&self.by) {
            let moved = at(u, master);
            sides.iter_mut().zip(vectors).for_each(|(sum, vector)| *sum += moved.dot(vector));
        }
        sides
    }

    /// ∂θ/∂x_j.
    fn slopes(&self, [c, s]: [f64; 2]) -> Vec<Vec3> {
        let square = c * c + s * s;
        self.by.iter().map(|[a, b]| (c * b - s * a) / square).collect()
    }
}

/// Orthonormal directions in the span of some orthonormal columns, across an axis.
fn across(columns: &DMatrix<f64>, axis: Vec3) -> Vec<Vec3> {
    let column = |k: usize| Vec3::from_column_slice(columns.column(k).as_slice());
    let within: Vec3 = (0..columns.ncols()).map(|k| column(k).dot(&axis) * column(k)).sum();
    let mut found: Vec<Vec3> = within.try_normalize(ALONG).into_iter().collect();
    let first = found.len();
    for k in 0..columns.ncols() {
        let left = found.iter().fold(column(k), |x, unit| x - unit.dot(&x) * unit);
        // a second time, for what rounding left
        let left = found.iter().fold(left, |x, unit| x - unit.dot(&x) * unit);
        if found.len() < columns.ncols() {
            found.extend(left.try_normalize(1e-3));
        }
    }
    found.split_off(first)
}

impl RigidMoment {
    /// Who owns the three components of what is added to the moment on a part, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("rigid_moment", place)
    }

    /// Moments [N m] on a part, with the positions of all nodes at rest [m].
    pub fn new(part: &RigidSet, positions: &[Vec3], moment: Field) -> Result<Self, NoLever> {
        let turn = |axis: usize| {
            let turns = !moment.0[axis].is_zero();
            turns.then(|| Turn::new(part, positions, axis)).transpose()
        };
        let turns = [turn(0)?, turn(1)?, turn(2)?];
        Ok(Self { moment, masters: part.masters().to_vec(), turns })
    }

    /// The moments at a time with the turns they make.
    fn acting(&self, time: f64) -> impl Iterator<Item = (f64, &Turn)> {
        let moments = self.moment.0.iter().map(move |moment| moment.at(time));
        moments.zip(&self.turns).filter_map(|(moment, turn)| Some((moment, turn.as_ref()?)))
    }
}

impl Energy for RigidMoment {
    fn kind(&self) -> (&'static str, Nature) {
        ("rigid_moment", Nature::Load)
    }

    fn held(&self, time: f64) -> Option<Arc<dyn Energy>> {
        Some(Arc::new(Self { moment: self.moment.held_at(time), ..self.clone() }))
    }

    fn value(&self, at: &Iterate) -> f64 {
        let work = |(moment, turn): (f64, &Turn)| {
            let [c, s] = turn.sides(&self.masters, at.u);
            moment * s.atan2(c)
        };
        -self.acting(at.time).map(work).sum::<f64>()
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        for (moment, turn) in self.acting(at.time) {
            let slopes = turn.slopes(turn.sides(&self.masters, at.u));
            for (&master, slope) in self.masters.iter().zip(slopes) {
                add_at(out, master, &(-moment * slope));
            }
        }
    }

    /// The projected one is none: the angle has no convex part.
    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        if kind == Hessian::Projected {
            return;
        }
        for (moment, turn) in self.acting(at.time) {
            let [c, s] = turn.sides(&self.masters, at.u);
            let fourth = (c * c + s * s).powi(2);
            let (twice, mixed) = (2.0 * s * c / fourth, (s * s - c * c) / fourth);
            for (&row, [a_j, b_j]) in self.masters.iter().zip(&turn.by) {
                for (&column, [a_k, b_k]) in self.masters.iter().zip(&turn.by) {
                    let same = twice * (a_j * a_k.transpose() - b_j * b_k.transpose());
                    let cross = mixed * (a_j * b_k.transpose() + b_j * a_k.transpose());
                    out.add_lower(row, column, &(-moment * (same + cross)));
                }
            }
        }
    }

    fn couplings(&self, _: &Iterate, _: f64) -> Vec<[usize; 2]> {
        pairs(&self.masters)
    }

    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {}

    /// By what is added to the three moments.
    fn slots(&self) -> Vec<Slot> {
        Slot::components("moment", "N m").to_vec()
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let by = |(moment, turn): (&Schedule, &Option<Turn>)| {
            let turn = turn.as_ref()?;
            let slopes = turn.slopes(turn.sides(&self.masters, iterate.u));
            let each = self.masters.iter().zip(slopes);
            let turned: f64 = each.map(|(&master, slope)| slope.dot(&at(lambda, master))).sum();
            Some(-(1.0 - moment.to_come(iterate.time)) * turned)
        };
        self.moment.0.iter().zip(&self.turns).map(|pair| by(pair).unwrap_or(0.0)).collect()
    }
}
