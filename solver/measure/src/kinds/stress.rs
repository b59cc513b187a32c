//! The p-norm of the stress in bodies, to the power q.
//!
//! J(u, X) = ∫ |P|^q dX      P = ∂ψ/∂F, |·| the Frobenius norm
//!
//! J is in Pa^q m³. With q = 2 it is a mean over the volume; the larger q, the
//! more the largest stress counts: (J/V)^(1/q) tends to it.
//!
//! Source: the p-norm of stresses, Duysinx and Sigmund 1998,
//! doi:10.2514/6.1998-4906, with the stress per rest area in place of the true
//! one.

use std::ops::Range;

use mechanics::energy::{Elastic, Owner};
use mechanics::material::{Kinematics, Material};
use mechanics::math::tensor::{Mat3, vec9};

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "stress",
    unit: "Pa^q m³",
    reads_stress: true,
    example: "power = 4",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// ∫ |P|^q dX, P the force per rest area; the larger q, the more the largest counts
    #[derive(Debug)]
    struct Keys {
        /// body; all if not given
        on: Option<String> = None;
        /// q ≥ 2
        power: f64 = 2.0, program::table::Range::at_least(2.0);
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let part = |(law, elements): (&mechanics::material::Specification, Range<usize>)| {
            let place = site.laws.iter().position(|law| law.elements == elements)?;
            Some((place, law.build(), elements))
        };
        let parts = site.parts(self.on.as_deref())?.into_iter().filter_map(part).collect();
        Ok(Arc::new(Stress { parts, power: self.power }))
    }
}

/// A law, its place among all, and the elements that have it.
type Part = (usize, Box<dyn Material>, Range<usize>);

/// A norm of the stress in bodies.
struct Stress {
    parts: Vec<Part>,
    /// q ≥ 2, so that J is smooth where the stress vanishes.
    power: f64,
}

impl Stress {
    fn density(&self, material: &dyn Material, grad_u: &Mat3) -> (f64, Mat3) {
        let k = Kinematics::new(grad_u);
        let stress = material.first_piola(&k);
        let norm = stress.norm();
        // the tangent is symmetric
        let by = material.tangent(&k) * vec9(&stress) * (self.power * norm.powf(self.power - 2.0));
        (norm.powf(self.power), Mat3::from_column_slice(by.as_slice()))
    }

    /// ∂|P|^q/∂p by the parameters of a law.
    fn density_by_parameters(&self, material: &dyn Material, grad_u: &Mat3) -> Vec<f64> {
        let k = Kinematics::new(grad_u);
        let stress = material.first_piola(&k);
        let by_stress = stress * (self.power * stress.norm().powf(self.power - 2.0));
        let mut by = vec![0.0; material.parameter_count()];
        material.add_parameter_vjp(&k, &by_stress, &mut by);
        by
    }
}

impl Quantity for Stress {
    fn value(&self, at: &Equilibrium) -> f64 {
        let one = |(_, law, elements): &Part| {
            solid_integral::value(at, elements, &|h| self.density(&**law, h))
        };
        self.parts.iter().map(one).sum()
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        for (_, law, elements) in &self.parts {
            solid_integral::add_partials(at, elements, &|h| self.density(&**law, h), weight, out);
        }
    }

    fn by_parameters(&self, at: &Equilibrium, weight: f64) -> Vec<(Owner, Vec<f64>)> {
        let by = |(place, law, elements): &Part| {
            let one = |i: usize| {
                let density = |h: &Mat3| (self.density_by_parameters(&**law, h)[i], Mat3::zeros());
                weight * solid_integral::value(at, elements, &density)
            };
            (Elastic::owner(*place), (0..law.parameter_count()).map(one).collect())
        };
        self.parts.iter().map(by).collect()
    }
}

#[cfg(test)]
mod tests {
    use mechanics::material::{Lame, MooneyRivlin, NeoHookean};
    use mesh::Vec3;

    use super::*;
    use crate::quantity::tests::Case;

    fn soft() -> Box<dyn Material> {
        Box::new(NeoHookean(Lame::new(2.6, 0.3)))
    }

    #[test]
    fn derivatives_by_the_law_belong_to_the_value() {
        let mut case = Case::cube(2, 1.0);
        case.u.iter_mut().for_each(|u| *u *= 0.2);
        let term = |c1: f64, c2: f64| {
            let law = Box::new(MooneyRivlin { c1, c2, c3: 0.05, d1: 2.0 });
            Stress { parts: vec![(0, soft(), 0..20), (1, law, 20..48)], power: 3.0 }
        };
        let by = term(0.8, 0.1).by_parameters(&case.at(), 2.0);
        assert_eq!([by[0].0, by[1].0], [0, 1].map(Elastic::owner));
        let value = |c1, c2| 2.0 * term(c1, c2).value(&case.at());
        let step = 1e-5;
        let differences = [
            (value(0.8 + step, 0.1) - value(0.8 - step, 0.1)) / (2.0 * step),
            (value(0.8, 0.1 + step) - value(0.8, 0.1 - step)) / (2.0 * step),
        ];
        for (difference, exact) in differences.iter().zip(&by[1].1) {
            assert!((difference / exact - 1.0).abs() < 1e-7, "{difference} {exact}");
        }
    }

    /// Stretched by 1.5 along x alone, a material has the same stress everywhere.
    #[test]
    fn a_homogeneous_state_has_its_closed_form() {
        let mut case = Case::cube(2, 2.0);
        let nodes = case.space.node_positions(&case.rest);
        for (n, x) in nodes.iter().enumerate() {
            case.u[3 * n..3 * n + 3].copy_from_slice(&[0.5 * x.x, 0.0, 0.0]);
        }
        let k = Kinematics::new(&Mat3::from_diagonal(&Vec3::new(0.5, 0.0, 0.0)));
        let stress = soft().first_piola(&k).norm();
        let value = |power, elements| {
            Stress { parts: vec![(0, soft(), elements)], power }.value(&case.at())
        };
        assert!((value(3.0, 0..48) / (8.0 * stress.powi(3)) - 1.0).abs() < 1e-12);
        let volume = |tet: &[usize; 4]| {
            let [a, b, c, d] = tet.map(|v| case.rest[v]);
            mesh::measure::tet_volume(a, b, c, d)
        };
        let part: f64 = case.space.tets()[..6].iter().map(volume).sum();
        assert!((value(2.0, 0..6) / (part * stress.powi(2)) - 1.0).abs() < 1e-12);
    }
}
