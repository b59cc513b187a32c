//! Gas in a part of a chamber that is cut out by planes of symmetry.

use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{
    Constraint, Energy, GasLaw, Hessian, Iterate, Moment, Nature, Potential, RankOne, Wall,
};
use mechanics::math::sparse::BlockMatrix;
use mesh::Vec3;

/// Where the planes are, on which the rim of the wall slides.
#[derive(Clone, Copy)]
pub enum Planes {
    /// All through the origin: V = −⅓ ∫ x · (g₁ × g₂) dξ.
    ThroughOrigin,
    /// Through the z axis, and at two heights: V = −½ ∫ (x, y, 0) · (g₁ × g₂) dξ.
    Slab,
}

/// Gas behind an open wall. `mechanics::energy::Chamber` closes it by caps from
/// rim to rim, which is not the chamber's share here; law, force and stiffness
/// of the wall are the same.
pub struct SymmetricGas {
    wall: Wall,
    gas: Box<dyn GasLaw>,
    facets: Vec<Vec<usize>>,
    planes: Planes,
}

impl SymmetricGas {
    /// Gas behind facets (vertex ids, oriented out of the solid).
    pub fn new(
        space: &FunctionSpace,
        facets: &[[usize; 3]],
        planes: Planes,
        gas: Box<dyn GasLaw>,
    ) -> Self {
        let wall = Wall::new(space, facets);
        let facets = facets.iter().map(|&f| space.facet_nodes(f)).collect();
        Self { wall, gas, facets, planes }
    }

    /// Volume at node positions `x` [m³].
    pub fn volume(&self, space: &FunctionSpace, x: impl Fn(usize) -> Vec3) -> f64 {
        let table = space.facet_table();
        let (mask, share) = match self.planes {
            Planes::ThroughOrigin => (Vec3::repeat(1.0), 1.0 / 3.0),
            Planes::Slab => (Vec3::new(1.0, 1.0, 0.0), 1.0 / 2.0),
        };
        let mut volume = 0.0;
        for nodes in &self.facets {
            for (q, weight) in table.weights.iter().enumerate() {
                let tangent = |k: usize| -> Vec3 {
                    nodes.iter().zip(&table.gradients[q]).map(|(&n, g)| x(n) * g[k]).sum()
                };
                let normal = tangent(0).cross(&tangent(1));
                let p: Vec3 = nodes.iter().zip(&table.values[q]).map(|(&n, v)| x(n) * *v).sum();
                volume -= 0.5 * weight * share * mask.component_mul(&p).dot(&normal);
            }
        }
        volume
    }

    /// Volume, rest volume [m³] and gas.
    pub fn state(&self, iterate: &Iterate) -> (f64, f64, Potential) {
        let rest = self.volume(iterate.space, |n| iterate.space.node_position(iterate.rest, n));
        let volume = self.volume(iterate.space, deformed(iterate));
        let multiplier = iterate.multipliers.first().copied().unwrap_or_default();
        let moment = Moment { time: iterate.time, multiplier, past: None };
        (volume, rest, self.gas.at(volume, rest, &moment))
    }
}

fn deformed<'a>(iterate: &Iterate<'a>) -> impl Fn(usize) -> Vec3 + use<'a> {
    let Iterate { space, rest, u, .. } = *iterate;
    move |node| space.node_position(rest, node) + at(u, node)
}

impl Energy for SymmetricGas {
    fn name(&self) -> &'static str {
        "chamber"
    }

    fn nature(&self) -> Nature {
        Nature::Gas
    }
    fn value(&self, at: &Iterate) -> f64 {
        self.state(at).2.value
    }
    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let pressure = self.state(at).2.pressure;
        self.wall.add_wall_gradient(at.space, deformed(at), -pressure, out);
    }
    fn add_hessian(&self, at: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        let pressure = self.state(at).2.pressure;
        self.wall.add_stiffness(at.space, deformed(at), pressure, out);
    }
    fn rank_one(&self, at: &Iterate) -> Option<RankOne> {
        let scale = self.state(at).2.stiffness;
        let mut vector = vec![0.0; at.u.len()];
        self.wall.add_wall_gradient(at.space, deformed(at), 1.0, &mut vector);
        (scale != 0.0).then_some(RankOne { scale, vector })
    }
    fn constraint(&self, at: &Iterate) -> Option<Constraint> {
        let (volume, rest, _) = self.state(at);
        let wanted = self.gas.wanted(rest, at.time)?.volume;
        let mut gradient = vec![0.0; at.u.len()];
        self.wall.add_wall_gradient(at.space, deformed(at), 1.0, &mut gradient);
        Some(Constraint { multiplier: 0, volume, wanted, gradient })
    }
    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {
        unreachable!("no shape is varied here")
    }
}
