//! A smooth substitute for the contact force between parts of the surface that is not
//! zero at a distance.
//!
//! J(u, X) = Σ_n |f_n|²      f = ∂B/∂x
//!
//! n   nodes of the chosen parts
//! B   [`Potential`] of the convergent form, with the scale 1/d̂³ [m³]
//! β   its density, log barrier or (d² − d̂²)² [m⁴]
//! d̂   activation distance [m], larger than that of the contact which is simulated
//!
//! J is in m⁴, as κ is one: f counts, per pressure, the area that presses. Only
//! pairs of different parts count. Both sides of a contact do, and forces of
//! friction do not. J grows without bound as parts touch, and is zero, with zero
//! derivatives, as long as they are farther apart than d̂: a target or a position
//! must bring them together first.
//!
//! ∂J/∂x = 2 (∂²B/∂x²) f      ∂J/∂X = 2 fᵀ ∂²B/∂x∂X
//!
//! Where planes of symmetry cut the body, the parts are those of the whole, and J is the
//! body's share of it.
//!
//! Source: Gjoka et al. 2024, equation (13), in the form of the published scenes:
//! the square of the sum at a node, not the sum of the squares over pairs.

use mechanics::contact::barrier::Form;
use mechanics::contact::density::{Density, Repulsion};
use mechanics::contact::potential::{Contacts, Partners, Potential};
use mechanics::contact::surface::Surface;
use mechanics::element::FunctionSpace;
use mechanics::symmetry::Plane;
use program::Names;

use super::*;
use crate::quantity::PartsTouch;
use crate::written::DensitySchema;

pub(super) const KIND: Kind = Kind {
    key: "contact-proxy",
    unit: "m⁴",
    may_be_maximised: true,
    needs_contact: true,
    example: "on = ['left', 'right']\nactivation = 1.3",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// Σ |f_n|² of the forces of a wide barrier between parts of the surface
    #[derive(Debug)]
    struct Keys {
        /// two or more tags that are apart
        on: Names;
        /// "log" or "quadratic"
        #[schemars(with = "DensitySchema")]
        density: Density = Density::default();
        /// activation distance, below which they interact [m], larger than that of contact
        activation: f64, Range::POSITIVE.unit("m");
    }
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        ensure!(
            self.on.all().len() > 1,
            misfit!(
                KeyPath::of("on"),
                " = {:?}: expected two tags or more that should press on each other",
                self.on.all()
            )
        );
        Ok(())
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let Self { density, activation, .. } = *self;
        let (parts, planes) = (site.each(&self.on)?, &site.body.planes);
        let repulsion = Repulsion { density, minimum: 0.0, activation };
        Ok(Arc::new(ContactProxy::new(planes, site.space, &parts, repulsion)?))
    }
}

/// The squared norm of the forces of a barrier between parts of the surface.
pub struct ContactProxy {
    potential: Potential,
}

impl ContactProxy {
    /// The term between different ones of several sets of boundary facets.
    pub fn new(
        planes: &[Plane],
        space: &FunctionSpace,
        parts: &[Vec<[usize; 3]>],
        repulsion: Repulsion,
    ) -> Result<Self, PartsTouch> {
        PartsTouch::check(parts)?;
        let bodies: Vec<usize> =
            parts.iter().enumerate().flat_map(|(i, p)| vec![i; p.len()]).collect();
        let free = vec![false; 3 * space.node_count()];
        // with as many parts per edge as the degree, collision vertices are nodes
        let (facets, split) = (parts.concat(), space.degree());
        let none = Vec::new();
        let surface = Surface::new(planes, space, &facets, &bodies, none, split, &free);
        let (surface, partners) = (Arc::new(surface), Partners::OtherBodies);
        let scale = repulsion.activation.powi(-3);
        let potential = Potential::new(surface, partners, Form::Convergent, repulsion, scale);
        Ok(Self { potential })
    }

    /// Share of the body in the whole.
    fn share(&self) -> f64 {
        self.potential.surface().share()
    }

    /// None where parts touch.
    fn contacts(&self, at: &Equilibrium) -> Option<Contacts<'_>> {
        let (surface, repulsion) = (self.potential.surface(), self.potential.repulsion());
        let x = surface.positions(at.space, at.rest, at.u, at.time);
        let candidates = self.potential.candidates(&x, &x, repulsion.range()).ok()?;
        let rest = surface.rest(at.space, at.rest);
        let close = self.potential.close_pairs(&candidates, &x, &rest);
        if close.iter().any(|pair| pair.is_violated(repulsion)) {
            return None;
        }
        Some(self.potential.contacts(&close, x, rest))
    }
}

impl Quantity for ContactProxy {
    fn value(&self, at: &Equilibrium) -> f64 {
        let Some(contacts) = self.contacts(at) else { return f64::INFINITY };
        self.share() * contacts.gradient().iter().map(Vec3::norm_squared).sum::<f64>()
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let Some(contacts) = self.contacts(at) else { return };
        // ∂J/∂f = 2 f
        let (surface, factor) = (self.potential.surface(), 2.0 * (weight * self.share()));
        let by: Vec<Vec3> = contacts.gradient().into_iter().map(|f| f * factor).collect();
        surface.add_to_nodes(&contacts.hessian_times(&by), out.u);
        surface.add_to_rest(at.space, &contacts.shape_vjp(&by), out.rest);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::testing::cube;
    use mesh::TetMesh;

    use super::*;
    use crate::quantity::tests::Case;

    /// Two cubes of 48 tetrahedra with a gap between the top of one and the bottom
    /// of the other.
    fn cubes(gap: f64) -> TetMesh {
        let one = cube(2, 0.0);
        let n = one.vertices.len();
        let upper: Vec<Vec3> = one.vertices.iter().map(|v| v + (1.0 + gap) * Vec3::z()).collect();
        let mut two = one.clone();
        two.vertices.extend(upper);
        two.tets.extend(one.tets.iter().map(|t| t.map(|v| v + n)));
        two
    }

    /// Both faces at the gap.
    fn faces(case: &Case, gap: f64) -> [Vec<[usize; 3]>; 2] {
        let at = |z: f64| case.facets_where(|x| (x.z - z).abs() < 1e-9);
        [at(1.0), at(1.0 + gap)]
    }

    fn proxy(
        case: &Case,
        parts: &[Vec<[usize; 3]>],
        density: Density,
        activation: f64,
    ) -> Result<ContactProxy, PartsTouch> {
        let repulsion = Repulsion { density, minimum: 0.0, activation };
        ContactProxy::new(&[], &case.space, parts, repulsion)
    }

    /// One vertex above the inside of one triangle: the closed form of a pair.
    #[test]
    fn a_single_pair_has_its_closed_form() {
        let corners = [
            [-1.0, -1.0, 0.0],
            [3.0, -1.0, 0.0],
            [-1.0, 3.0, 0.0],
            [0.0, 0.0, -2.0],
            [0.0, 0.0, 0.1],
            [0.0, 2.0, 4.1],
            [0.0, -2.0, 4.1],
            [1.0, 0.0, 4.1],
        ];
        let mesh = TetMesh {
            vertices: corners.map(Vec3::from).to_vec(),
            tets: vec![[0, 2, 1, 3], [4, 5, 6, 7]],
        };
        let mut case = Case::of(&mesh, 1, 1.0);
        case.u.fill(0.0);
        let parts = [vec![[0, 1, 2]], vec![[4, 5, 6]]];
        let (d2, range) = (0.01_f64, 0.12_f64);
        let gap = d2 - range * range;
        let log = (d2 / (range * range)).ln();
        for (density, slope) in [
            (Density::Quadratic, 2.0 * gap),
            (Density::Log, -gap * (2.0 * log + gap / d2)),
            (Density::LogSquared, 2.0 * gap * log * (log + gap / d2)),
        ] {
            let term = proxy(&case, &parts, density, range).unwrap();
            // a third of the area of the triangle, which is 8, and barycentric
            // coordinates ½, ¼, ¼ of the vertex below
            let force = 0.25 * (8.0 / 3.0) * slope * 2.0 * d2.sqrt() / range.powi(3);
            let expected = force * force * (1.0 + 0.25 + 2.0 / 16.0);
            let found = term.value(&case.at());
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn parts_far_apart_cost_nothing_and_touching_ones_are_refused_or_infinite() {
        let mut case = Case::of(&cubes(0.1), 2, 1.0);
        case.u.fill(0.0);
        let parts = faces(&case, 0.1);
        let new = |parts: &[_], d| proxy(&case, parts, Density::Log, d);
        assert!(new(&parts, 0.09).unwrap().value(&case.at()) == 0.0);
        let near = new(&parts, 0.11).unwrap();
        assert!(near.value(&case.at()) > 0.0);
        let sides = [parts[0].clone(), case.facets_where(|x| x.x < 1e-9)];
        let error = new(&sides, 0.1).err().unwrap();
        assert_eq!(error.parts, [1, 2]);
        let [a, b] = [0, 1].map(|side: usize| parts[side][0][0]);
        let mut rest = case.rest.clone();
        rest[b] = rest[a];
        let touching = Equilibrium { rest: &rest, ..case.at() };
        assert!(near.value(&touching).is_infinite());
    }
}
