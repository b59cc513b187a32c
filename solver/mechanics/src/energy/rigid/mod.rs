//! Energies of a rigid part, see [`RigidSet`]: what keeps it rigid, its mass, and the force on it.
//!
//! Stiffness   E = κ/4 ‖AᵀA − S²‖²       A = F S = Σ_j x_j m_jᵀ
//!             ∂E/∂x_j = κ A W m_j        W = AᵀA − S²
//!             ∂²E/∂x_j∂x_k = κ ((m_k·W m_j) I + (A m_k)(A m_j)ᵀ + (m_j·m_k) A Aᵀ)
//! Inertia     E = 1/(2 s) Σ_jk m_jk (u_j − ũ_j)·(u_k − ũ_k)        as that of a body
//! Load        E = −(f + m g) · Σ_j w_j u_j
//!
//! x_j   positions of the masters [m]
//! F     deformation gradient of the part along its principal axes, S its extents there [m]
//! κ     such that a displacement of the part against itself by d costs about ½ k d², k = [`STIFFNESS`] G L [N/m]
//! m_jk  mass matrix of the masters: mass spread over the part [kg]
//! w_j   weights of the masters where the force acts, in the middle of that
//!
//! W is scaled by extents on both sides so that a thin part is as stiff across as along. The projected Hessian
//! has the part of W that is positive. Of the numbers there are derivatives by mass and force; m_jk and m_j are
//! those of the rest shape, which must not move.

mod moment;

pub use moment::{NoLever, RigidMoment};

use std::sync::Arc;

use mesh::Vec3;
use nalgebra::{DMatrix, Rotation3, SymmetricEigen};

use super::{Energy, Hessian, Iterate, Nature, Owner, PastCotangent, Slot};
use crate::element::{add_at, at};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::Mat3;
use crate::rigid::RigidSet;
use crate::schedule::Field;

/// Stiffness of a part against itself, over the shear modulus of what it is bonded to and its size: strains of
/// the part are this much smaller than those around it. The factor in single precision bears no more.
pub const STIFFNESS: f64 = 1e4;

/// What keeps a part rigid.
#[derive(Clone)]
pub struct Rigid {
    masters: Vec<usize>,
    /// Rest positions of the masters [m].
    rest: Vec<Vec3>,
    /// m_j in the rows.
    gradients: DMatrix<f64>,
    /// A at rest [m].
    at_rest: DMatrix<f64>,
    /// κ [N/m³].
    stiffness: f64,
}

impl Rigid {
    /// Which part it keeps rigid, by its place among all: it has no numbers.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("rigid", place)
    }

    /// A part bonded to a body with a shear modulus [Pa], with the positions of all nodes at rest [m].
    pub fn new(part: &RigidSet, positions: &[Vec3], shear: f64) -> Self {
        let masters = part.masters().to_vec();
        let rest: Vec<Vec3> = masters.iter().map(|&m| positions[m]).collect();
        let gradients = part.scaled_gradients();
        let mut at_rest = DMatrix::zeros(3, gradients.ncols());
        for (j, x) in rest.iter().enumerate() {
            at_rest += (x - rest[0]) * gradients.row(j);
        }
        let size = part.extents().iter().copied().fold(0.0, f64::max);
        // ¼ κ (2 s d)² = k d² for a displacement d at a point as far as the extent s
        let stiffness = if size > 0.0 { STIFFNESS * shear / size } else { 0.0 };
        Self { masters, rest, gradients, at_rest, stiffness }
    }

    /// By which rotation vector the part has turned [rad].
    pub fn rotation(&self, u: &[f64]) -> Vec3 {
        let now: Vec<Vec3> =
            self.masters.iter().zip(&self.rest).map(|(&m, x)| x + at(u, m)).collect();
        let center = |points: &[Vec3]| points.iter().sum::<Vec3>() / points.len() as f64;
        let (c, c_rest) = (center(&now), center(&self.rest));
        if let ([a, b], [a_rest, b_rest]) = (&now[..], &self.rest[..]) {
            let turn = Rotation3::rotation_between(&(b_rest - a_rest), &(b - a));
            return turn.map_or_else(Vec3::zeros, |turn| turn.scaled_axis());
        }
        let products = now.iter().zip(&self.rest).map(|(x, r)| (x - c) * (r - c_rest).transpose());
        // the rotation next to it in the least squares of Kabsch
        let svd = products.sum::<Mat3>().svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Vec3::zeros() };
        let handed = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, (u * v_t).determinant().signum()));
        Rotation3::from_matrix_unchecked(u * handed * v_t).scaled_axis()
    }

    /// A of a nodal field, relative to that at rest [m].
    fn moved(&self, u: &[f64]) -> DMatrix<f64> {
        let mut moved = DMatrix::zeros(3, self.gradients.ncols());
        for (j, &master) in self.masters.iter().enumerate() {
            moved += at(u, master) * self.gradients.row(j);
        }
        moved
    }

    /// A and W [m, m²]; W from the displacement, of which rounding takes less than of positions.
    fn deformation(&self, iterate: &Iterate) -> (DMatrix<f64>, DMatrix<f64>) {
        let moved = self.moved(iterate.u);
        let cross = self.at_rest.transpose() * &moved;
        let strain = &cross + cross.transpose() + moved.transpose() * &moved;
        (&self.at_rest + moved, strain)
    }
}

/// The part of a symmetric matrix with positive eigenvalues.
fn positive_part(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(matrix);
    let values = eigen.eigenvalues.map(|value| value.max(0.0));
    &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

/// Pairs of nodes, each once.
fn pairs(nodes: &[usize]) -> Vec<[usize; 2]> {
    let all = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| [a, b]));
    all.filter(|[a, b]| a > b).collect()
}

impl Energy for Rigid {
    fn kind(&self) -> (&'static str, Nature) {
        ("rigid", Nature::Rigid)
    }

    fn value(&self, at: &Iterate) -> f64 {
        let (_, strain) = self.deformation(at);
        0.25 * self.stiffness * strain.norm_squared()
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let (a, strain) = self.deformation(at);
        let forces = self.stiffness * a * strain * self.gradients.transpose();
        for (j, &master) in self.masters.iter().enumerate() {
            add_at(out, master, &Vec3::from_column_slice(forces.column(j).as_slice()));
        }
    }

    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        let (a, strain) = self.deformation(at);
        let strain = match kind {
            Hessian::Exact => strain,
            Hessian::Projected => positive_part(strain),
        };
        let square = &a * a.transpose();
        for (j, &row) in self.masters.iter().enumerate() {
            for (k, &column) in self.masters.iter().enumerate() {
                let (m_j, m_k) = (self.gradients.row(j), self.gradients.row(k));
                let along = (m_k * &strain * m_j.transpose())[(0, 0)];
                let product = (&a * m_k.transpose()) * (&a * m_j.transpose()).transpose();
                let sum = product + m_j.dot(&m_k) * &square;
                let block = Mat3::from_fn(|i, l| sum[(i, l)]) + along * Mat3::identity();
                out.add_lower(row, column, &(self.stiffness * block));
            }
        }
    }

    fn couplings(&self, _: &Iterate, _: f64) -> Vec<[usize; 2]> {
        pairs(&self.masters)
    }

    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {}
}

/// A point of a part that has a share of its mass.
#[derive(Clone, Debug)]
pub struct MassPoint {
    /// Part of the mass [1].
    pub share: f64,
    /// Weights of the masters there [1].
    pub weights: Vec<f64>,
}

/// Mass of a part, spread over it.
#[derive(Clone)]
pub struct RigidMass {
    /// Mass [kg].
    pub mass: f64,
    masters: Vec<usize>,
    /// m_jk / mass.
    matrix: DMatrix<f64>,
}

impl RigidMass {
    /// Who owns the mass of a part in its inertia, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("rigid_mass", place)
    }

    /// A mass [kg] at some points.
    pub fn new(part: &RigidSet, mass: f64, points: &[MassPoint]) -> Self {
        let masters = part.masters().to_vec();
        let sum = |j: usize, k: usize| {
            points.iter().map(|point| point.share * point.weights[j] * point.weights[k]).sum()
        };
        let matrix = DMatrix::from_fn(masters.len(), masters.len(), sum);
        Self { mass, masters, matrix }
    }

    /// Σ_k m_jk w_k of a nodal field for each master [kg].
    fn times<'a>(&'a self, w: &'a [f64]) -> impl Iterator<Item = (usize, Vec3)> + 'a {
        self.masters.iter().enumerate().map(move |(j, &master)| {
            let row = self.masters.iter().enumerate();
            let sum: Vec3 = row.map(|(k, &other)| self.matrix[(j, k)] * at(w, other)).sum();
            (master, self.mass * sum)
        })
    }

    /// ½ vᵀ M v of a velocity [J].
    pub fn kinetic_energy(&self, velocity: &[f64]) -> f64 {
        self.times(velocity).map(|(master, mv)| 0.5 * mv.dot(&at(velocity, master))).sum()
    }

    /// Momentum of a velocity [kg m/s].
    pub fn momentum(&self, velocity: &[f64]) -> Vec3 {
        self.times(velocity).map(|(_, mv)| mv).sum()
    }

    /// 1/s [1/s²] and u − ũ [m].
    fn deviation(iterate: &Iterate) -> Option<(f64, Vec<f64>)> {
        let flight = iterate.step?.free_flight.as_ref()?;
        let deviation = iterate.u.iter().zip(&flight.at).map(|(u, at)| u - at).collect();
        Some((1.0 / flight.square, deviation))
    }
}

impl Energy for RigidMass {
    fn kind(&self) -> (&'static str, Nature) {
        ("inertia", Nature::Inertia)
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        Self::deviation(iterate).map_or(0.0, |(rate, d)| rate * self.kinetic_energy(&d))
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        let Some((rate, deviation)) = Self::deviation(iterate) else { return };
        self.times(&deviation).for_each(|(master, md)| add_at(out, master, &(rate * md)));
    }

    fn add_hessian(&self, iterate: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        let Some((rate, _)) = Self::deviation(iterate) else { return };
        for (j, &row) in self.masters.iter().enumerate() {
            for (k, &column) in self.masters.iter().enumerate() {
                let factor = rate * self.mass * self.matrix[(j, k)];
                out.add_lower(row, column, &(factor * Mat3::identity()));
            }
        }
    }

    fn couplings(&self, _: &Iterate, _: f64) -> Vec<[usize; 2]> {
        pairs(&self.masters)
    }

    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {}

    fn add_past_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some((rate, _)) = Self::deviation(iterate) else { return };
        self.times(lambda).for_each(|(master, ml)| {
            add_at(&mut out.free_flight, master, &(-rate * ml));
        });
    }

    fn slots(&self) -> Vec<Slot> {
        vec![Slot::new("mass", "kg")]
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let Some((rate, deviation)) = Self::deviation(iterate) else { return vec![0.0] };
        let unit = Self { mass: 1.0, ..self.clone() };
        vec![
            rate * unit
                .times(&deviation)
                .map(|(master, d)| d.dot(&at(lambda, master)))
                .sum::<f64>(),
        ]
    }
}

/// Dead force on a part, with its weight.
#[derive(Clone)]
pub struct RigidLoad {
    /// f [N].
    pub force: Field,
    /// g [m/s²].
    pub gravity: Field,
    /// Mass [kg].
    pub mass: f64,
    masters: Vec<usize>,
    /// w_j.
    weights: Vec<f64>,
}

impl RigidLoad {
    /// Who owns the mass of a part in its weight, then the components of what is added to the force on it, and to gravity; by
    /// its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("rigid_load", place)
    }

    /// A force [N] and the weight of a mass [kg] where masters have these weights.
    pub fn new(
        part: &RigidSet,
        weights: Vec<f64>,
        force: Field,
        gravity: Field,
        mass: f64,
    ) -> Self {
        Self { force, gravity, mass, masters: part.masters().to_vec(), weights }
    }

    /// Displacement of the point where the force acts [m], or another nodal field there.
    pub fn of_point(&self, w: &[f64]) -> Vec3 {
        self.masters.iter().zip(&self.weights).map(|(&m, share)| at(w, m) * *share).sum()
    }

    fn force_at(&self, time: f64) -> Vec3 {
        self.force.at(Vec3::zeros(), time) + self.mass * self.gravity.at(Vec3::zeros(), time)
    }
}

impl Energy for RigidLoad {
    fn kind(&self) -> (&'static str, Nature) {
        ("rigid_load", Nature::DeadLoad)
    }

    fn held(&self, time: f64) -> Option<Arc<dyn Energy>> {
        let (force, gravity) = (self.force.held_at(time), self.gravity.held_at(time));
        Some(Arc::new(Self { force, gravity, ..self.clone() }))
    }

    fn value(&self, at: &Iterate) -> f64 {
        -self.force_at(at.time).dot(&self.of_point(at.u))
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let force = self.force_at(at.time);
        for (&master, share) in self.masters.iter().zip(&self.weights) {
            add_at(out, master, &(-*share * force));
        }
    }

    fn add_hessian(&self, _: &Iterate, _: Hessian, _: &mut BlockMatrix) {}

    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {}

    /// By the mass, then by the three components of what is added to the force, and to gravity, which is ramped up
    /// in the first step as the rest of it.
    fn slots(&self) -> Vec<Slot> {
        let [force, gravity] =
            [Slot::components("force", "N"), Slot::components("gravity", "m/s²")];
        [Slot::new("mass", "kg")].into_iter().chain(force).chain(gravity).collect()
    }

    fn parameter_vjp(&self, at: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let moved = self.of_point(lambda);
        let by_force = |axis: usize| -(1.0 - self.force.0[axis].to_come(at.time)) * moved[axis];
        let by_mass = -self.gravity.at(Vec3::zeros(), at.time).dot(&moved);
        let to_come = |axis: usize| self.gravity.0[axis].to_come(at.time);
        let by_gravity = |axis: usize| -self.mass * (1.0 - to_come(axis)) * moved[axis];
        let components = (0..3).map(by_force).chain((0..3).map(by_gravity));
        std::iter::once(by_mass).chain(components).collect()
    }
}

#[cfg(test)]
pub(super) mod tests;
