//! A substitute for the force between parts of the surface, smooth and felt from
//! afar.
//!
//! J(u, X) = Σ_n |f_n|²      f = ∂B/∂x
//! B = σ Σ_k w_k m_k β(d_k²)     σ = 1/d̂³
//!
//! n   nodes of the chosen parts
//! w   weights of the convergent form, see [`terms`](crate::contact::terms) [m²]
//! m   mollifier of parallel edges [1]
//! β   log barrier, or (d² − d̂²)² [m⁴]
//! d̂   distance from which on parts feel each other [m], larger than that of the
//!     contact which is simulated
//!
//! J is in m⁴, as κ is one: f counts, per pressure, the area that presses. Only
//! pairs of different parts count. Both sides of a contact do, and forces of
//! friction do not. J grows without bound as parts touch, and is zero, with zero
//! derivatives, as long as they are farther apart than d̂: a target or a position
//! must bring them together first.
//!
//! ∂J/∂x = 2 (∂²B/∂x²) f;  by the rest shape also through w and the threshold of
//! m, as in [`energy::Contact`](crate::energy::Contact).
//!
//! Source: Gjoka et al. 2024, equation (13), in the form of the published scenes:
//! the square of the sum at a node, not the sum of the squares over pairs.

use std::ops::Range;
use std::path::Path;

use anyhow::{Result, ensure};
use mesh::Vec3;
use serde::{Deserialize, Serialize};

use super::kind::{Builder, Kind, Specification, positive, read};
use super::{Equilibrium, Objective};
use crate::body::Names;
use crate::contact::barrier::{Form, log_barrier, quadratic};
use crate::contact::candidates;
use crate::contact::distance::{Closest, corners};
use crate::contact::pairs::Pair;
use crate::contact::stencil::Local;
use crate::contact::surface::Surface;
use crate::contact::terms::{Term, Terms};
use crate::contact::weights::Adjacency;
use crate::element::FunctionSpace;
use crate::math::tensor::Vec12;
use crate::parallel::map_merge;

use super::Density;

pub(super) const KIND: Kind = Kind {
    key: "contact-proxy",
    formula: "Σ |f_n|² of the forces of a wide barrier between parts of the surface",
    unit: "m⁴",
    keys: &[
        ("on", "two or more tags that are apart"),
        ("density", "\"log\" (default) or \"quadratic\""),
        (
            "activation",
            "distance from which on they feel each other [m], wider than that of contact",
        ),
    ],
    may_be_maximised: true,
    needs_contact: true,
    read: read::<Keys>,
};

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: Names,
    #[serde(default)]
    density: Density,
    activation: f64,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        positive("activation", self.activation)?;
        ensure!(
            self.on.all().len() > 1,
            "on = {:?}: needed are two tags or more that should press on each other",
            self.on.all()
        );
        Ok(())
    }

    fn prepare(&self, _: &Path) -> Result<Builder> {
        let Self { on, density, activation } = self.clone();
        Ok(Box::new(move |name, bodies| {
            let parts = bodies.each(&on)?;
            Ok(Box::new(ContactProxy::new(name, bodies.space, &parts, density, activation)?))
        }))
    }
}

/// Parts have vertices in common.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "parts {first} and {second} of the list share vertex {vertex}: whether they touch there is \
     not defined; choose parts that are apart"
)]
pub struct PartsTouch {
    /// Number of a part, from 1.
    pub first: usize,
    /// Number of another one.
    pub second: usize,
    /// A vertex of both.
    pub vertex: usize,
}

/// The squared norm of the forces of a barrier between parts of the surface.
pub struct ContactProxy {
    name: String,
    surface: Surface,
    adjacency: Adjacency,
    density: Density,
    activation: f64,
}

/// Collision vertices at a state.
struct State {
    x: Vec<Vec3>,
    rest: Vec<Vec3>,
    terms: Terms,
    /// f [m²].
    force: Vec<Vec3>,
}

impl ContactProxy {
    /// The term between different ones of several sets of boundary facets, with
    /// d̂ = `activation` [m].
    ///
    /// # Errors
    /// [`PartsTouch`] if a vertex belongs to two sets.
    pub fn new(
        name: &str,
        space: &FunctionSpace,
        parts: &[Vec<[usize; 3]>],
        density: Density,
        activation: f64,
    ) -> Result<Self, PartsTouch> {
        let mut owner = vec![usize::MAX; space.vertex_count()];
        for (part, facets) in parts.iter().enumerate() {
            for &vertex in facets.as_flattened() {
                if owner[vertex] < part {
                    return Err(PartsTouch { first: owner[vertex] + 1, second: part + 1, vertex });
                }
                owner[vertex] = part;
            }
        }
        let bodies: Vec<usize> =
            parts.iter().enumerate().flat_map(|(i, p)| vec![i; p.len()]).collect();
        let free = vec![false; 3 * space.node_count()];
        // with as many parts per edge as the degree, collision vertices are nodes
        let surface =
            Surface::new(space, (&parts.concat(), &bodies), Vec::new(), space.degree(), &free);
        let adjacency = Adjacency::new(&surface);
        Ok(Self { name: name.to_owned(), surface, adjacency, density, activation })
    }

    /// σ [1/m³].
    fn scale(&self) -> f64 {
        self.activation.powi(-3)
    }

    fn beta(&self, d2: f64) -> [f64; 3] {
        let activation = self.activation * self.activation;
        match self.density {
            Density::Log => log_barrier(d2, activation),
            Density::Quadratic => quadratic(d2, activation),
        }
    }

    /// None where parts touch.
    fn state(&self, at: &Equilibrium) -> Option<State> {
        let x = self.surface.positions(at.space, at.rest, at.u, at.load);
        let rest = self.surface.rest(at.space, at.rest);
        let same = |corners: [usize; 4]| {
            corners.iter().all(|&v| self.surface.body(v) == self.surface.body(corners[0]))
        };
        let features = self.surface.features();
        let pairs = candidates::between(features, &x, &x, self.activation, same).ok()?;
        let closest = |pair: Pair| (pair, pair.closest(&pair.gather(&x)));
        let range2 = self.activation * self.activation;
        let active: Vec<(Pair, Closest)> =
            pairs.into_iter().map(closest).filter(|(_, closest)| closest.d2 < range2).collect();
        if active.iter().any(|(_, closest)| closest.d2 == 0.0) {
            return None;
        }
        let on = (&self.surface, &self.adjacency);
        let terms = Terms::new(on, Form::Convergent, &active, (&x, &rest), self.activation);
        let force = vec![Vec3::zeros(); x.len()];
        let mut state = State { x, rest, terms, force };
        let mut force = std::mem::take(&mut state.force);
        self.for_each_term(&state, Local::gradient, |term, gradient| {
            let weight = self.scale() * term.weight;
            add(&mut force, &term.stencil.corners, &(gradient * weight));
        });
        state.force = force;
        Some(state)
    }

    /// Calls `map` on all terms in parallel, and `merge` on their results in
    /// order.
    fn for_each_term<T: Send>(
        &self,
        state: &State,
        map: impl Fn(&Local) -> T + Sync,
        mut merge: impl FnMut(&Term, T),
    ) {
        let terms = &state.terms.terms;
        let local = |t: &Term| Local::with(&t.stencil, &state.x, &state.rest, |d2| self.beta(d2));
        let part = |range: Range<usize>| -> Vec<T> {
            terms[range].iter().map(|t| map(&local(t))).collect()
        };
        map_merge(terms.len(), part, |range, part| {
            terms[range].iter().zip(part).for_each(|(term, value)| merge(term, value));
        });
    }

    /// ∂J/∂x of the collision vertices, and the rest of ∂J/∂X of their rest
    /// positions.
    fn derivatives(&self, state: &State) -> [Vec<Vec3>; 2] {
        let zero = || vec![Vec3::zeros(); state.x.len()];
        let (mut by_x, mut by_rest) = (zero(), zero());
        let mut by_area = vec![0.0; self.adjacency.areas(&state.rest).len()];
        let force = &state.force;
        let map = |local: &Local| (local.hessian(), local.gradient(), local.by_threshold());
        self.for_each_term(state, map, |term, (hessian, gradient, by_threshold)| {
            let own = &term.stencil.corners;
            let l = 2.0 * self.scale() * corners(term.stencil.gather(force));
            add(&mut by_x, own, &(hessian * l * term.weight));
            if let Some((by_threshold, threshold)) = by_threshold {
                add(&mut by_rest, own, &(threshold * (term.weight * by_threshold.dot(&l))));
            }
            state.terms.add_by_area(term, gradient.dot(&l), &mut by_area);
        });
        self.adjacency.add_gradient(&state.rest, &by_area, &mut by_rest);
        [by_x, by_rest]
    }
}

/// Adds the components of four collision vertices to a list over all of them.
fn add(list: &mut [Vec3], corners: &[usize; 4], values: &Vec12) {
    for (i, &v) in corners.iter().enumerate() {
        list[v] += values.fixed_rows::<3>(3 * i);
    }
}

impl Objective for ContactProxy {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        let sum = |state: State| state.force.iter().map(Vec3::norm_squared).sum();
        self.state(at).map_or(f64::INFINITY, sum)
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        let Some(state) = self.state(at) else { return };
        let [mut by_x, _] = self.derivatives(&state);
        by_x.iter_mut().for_each(|g| *g *= weight);
        self.surface.add_to_nodes(&by_x, out);
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        let Some(state) = self.state(at) else { return };
        let [by_x, by_rest] = self.derivatives(&state);
        let both: Vec<Vec3> = by_x.iter().zip(&by_rest).map(|(a, b)| weight * (a + b)).collect();
        let mut nodal = vec![0.0; at.u.len()];
        self.surface.add_to_nodes(&both, &mut nodal);
        at.space.add_to_vertices(&nodal, out);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mesh::TetMesh;

    use super::*;
    use crate::math::random::Random;
    use crate::objective::tests::Case;
    use crate::testing::cube;

    /// Two cubes of 48 tetrahedra with a gap between the top of one and the bottom
    /// of the other.
    fn cubes(gap: f64, shift: f64) -> TetMesh {
        let one = cube(2, 0.0);
        let n = one.vertices.len();
        let above = |v: &Vec3| v + Vec3::new(shift, 0.6 * shift, 1.0 + gap);
        let upper: Vec<Vec3> = one.vertices.iter().map(above).collect();
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

    const DENSITIES: [Density; 2] = [Density::Log, Density::Quadratic];

    /// With the cubes in line, edges are parallel up to a little noise.
    #[test]
    fn derivatives_belong_to_the_value() {
        let (gap, range) = (0.1, 0.15);
        for (degree, scale) in [(1, 1.0), (2, 1.0), (2, 1e-3), (3, 1e-3)] {
            for (shift, noise, fades) in [(0.23, 0.02, false), (0.0, 1e-3, true)] {
                let mut case = Case::of(&cubes(gap, shift), degree, scale);
                let parts = faces(&case, gap);
                let mut random = Random::new(4);
                case.rest.iter_mut().for_each(|x| *x += 0.3 * noise * scale * random.vector());
                case.u.iter_mut().for_each(|u| *u *= noise / 0.05);
                for density in DENSITIES {
                    let activation = range * scale;
                    let term =
                        ContactProxy::new("c", &case.space, &parts, density, activation).unwrap();
                    let terms = &term.state(&case.at()).unwrap().terms.terms;
                    let faded = terms.iter().filter(|t| t.stencil.faded && t.weight != 0.0).count();
                    assert!(
                        !fades || faded > 10,
                        "{faded} pairs of parallel edges of {}",
                        terms.len()
                    );
                    // closest points, and pairs that fade, change within 1e-5
                    case.check_near(&term, 4e-6);
                }
            }
        }
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
        for (density, slope) in [
            (Density::Quadratic, 2.0 * (d2 - range * range)),
            (Density::Log, log_barrier(d2, range * range)[1]),
        ] {
            let term = ContactProxy::new("c", &case.space, &parts, density, range).unwrap();
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
        let mut case = Case::of(&cubes(0.1, 0.0), 2, 1.0);
        case.u.fill(0.0);
        let parts = faces(&case, 0.1);
        let new = |parts: &[_], d| ContactProxy::new("c", &case.space, parts, Density::Log, d);
        assert!(new(&parts, 0.09).unwrap().value(&case.at()) == 0.0);
        let near = new(&parts, 0.11).unwrap();
        assert!(near.value(&case.at()) > 0.0);
        let sides = [parts[0].clone(), case.facets_where(|x| x.x < 1e-9)];
        let error = new(&sides, 0.1).err().unwrap();
        assert_eq!((error.first, error.second), (1, 2));
        let [a, b] = [0, 1].map(|side: usize| parts[side][0][0]);
        let mut rest = case.rest.clone();
        rest[b] = rest[a];
        let touching = Equilibrium { rest: &rest, ..case.at() };
        assert!(near.value(&touching).is_infinite());
    }
}
