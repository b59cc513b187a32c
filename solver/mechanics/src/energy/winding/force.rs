//! Means of the force of a thread.
//!
//! M = (∫ N^q dS / S)^(1/q)      S = ∫ dS = Σ w L
//! δM = Σ w/S [(N/M)^(q−1) L δN + ((N/M)^q − 1) M/q δL]
//! δN = ½ EA q″ δε + ½ (q′ − N₀/EA q″) δEA + ½ q″ δN₀
//! δε = t/L · δu′ + (t/L − l D/L³) · δD      δL = D/L · δD
//!
//! With q = 1 it is the mean along the thread; the larger q, the more the largest force counts, to which M tends.
//! The sums are in the order of the segments.

use mesh::Vec3;

use super::{Point, Segment, Winding};
use crate::element::add_at;
use crate::energy::Iterate;

impl Winding {
    /// The power mean M of the force along it [N], of a power q of 1 or more.
    pub fn mean_force(&self, at: &Iterate, power: f64) -> f64 {
        self.mean_and_length(at, power)[0]
    }

    /// Adds `weight` times the derivatives of [`Self::mean_force`] by the nodal displacement and by the rest vertices.
    pub fn add_mean_force(
        &self,
        at: &Iterate,
        [power, weight]: [f64; 2],
        (by_u, by_rest): (&mut [f64], &mut [f64]),
    ) {
        self.for_each_share(at, power, |segment, p, shares| {
            let [by_slope, by_difference] = p.force_by(shares).map(|by| weight * by);
            for (&node, slope) in segment.nodes.iter().zip(&p.place.slopes) {
                add_at(by_u, node, &(*slope * by_slope));
            }
            for (&vertex, share) in segment.vertices.iter().zip(&segment.across) {
                add_at(by_rest, vertex, &(*share * by_difference));
            }
        });
    }

    /// Derivatives of [`Self::mean_force`] by the parameters of the thread.
    pub fn mean_force_by_parameters(&self, at: &Iterate, power: f64) -> Vec<f64> {
        let (mut by, own) = (vec![0.0; self.parameters()], self.own_parameters());
        self.for_each_share(at, power, |segment, p, shares| {
            let [by_stiffness, by_pretension] = p.force_by_law(self.pretension);
            p.place.shares.iter().for_each(|(i, share)| by[*i] += share * shares[0] * by_stiffness);
            by[own - 1] += shares[0] * by_pretension;
            let [by_slope, by_difference] = p.force_by(shares);
            for (k, by) in by[own..].iter_mut().enumerate() {
                *by += shares[0] * by_stiffness * p.place.stiffness_rates[k]
                    + by_slope.dot(&segment.slope(&p.place.rates[k], at.u))
                    + by_difference.dot(&segment.corners(&segment.rates[k], at.rest));
            }
        });
        by
    }

    /// M and S.
    fn mean_and_length(&self, at: &Iterate, power: f64) -> [f64; 2] {
        let (mut length, mut largest) = (0.0, 0.0_f64);
        let mut all = Vec::new();
        for segment in &self.segments {
            self.for_each_point(at, segment, |p| {
                let (force, share) = (p.force(), p.place.weight * p.long);
                (length, largest) = (length + share, largest.max(force));
                all.push((force, share));
            });
        }
        if largest == 0.0 {
            return [0.0, length];
        }
        let sum: f64 = all.iter().map(|(force, share)| share * (force / largest).powf(power)).sum();
        [largest * (sum / length).powf(1.0 / power), length]
    }

    /// Calls `f` with each point, ∂M/∂N there and ∂M/∂L there; not at all where there is no force.
    fn for_each_share(
        &self,
        at: &Iterate,
        power: f64,
        mut f: impl FnMut(&Segment, &Point, [f64; 2]),
    ) {
        let [mean, length] = self.mean_and_length(at, power);
        if mean == 0.0 {
            return;
        }
        for segment in &self.segments {
            self.for_each_point(at, segment, |p| {
                let ratio = p.force() / mean;
                let root = ratio.powf(power - 1.0);
                let part = p.place.weight / length;
                f(segment, p, [part * root * p.long, part * (root * ratio - 1.0) * mean / power]);
            });
        }
    }
}

impl Point<'_> {
    /// From ∂M/∂N and ∂M/∂L, ∂M/∂u′ and ∂M/∂D.
    fn force_by(&self, [by_force, by_length]: [f64; 2]) -> [Vec3; 2] {
        let by_strain = 0.5 * self.stiffness * self.square[2] * by_force;
        let along = by_length / self.long * self.rest;
        [by_strain / self.long * self.along, by_strain * self.strained() + along]
    }
}
