//! One level of the cascade: handles θ → rest shape → equilibrium → objective,
//! and the gradient of that whole map.
//!
//! X(θ) = X₀ + 𝓔 (handles(θ) − X₀ on the moving surface), with 𝓔 the extension
//! into the interior, so that the gradient is that of what is simulated.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::Result;
use mesh::Vec3;

use super::validity;
use crate::adjoint;
use crate::body::Body;
use crate::design::{Extension, Handles, sample_handles};
use crate::element::{FunctionSpace, at, interpolate};
use crate::failure::Diagnosis;
use crate::forward::{Newton, Stepping, System, Unreached, follow, solve, solve_from};
use crate::objective::Equilibrium;
use crate::results::displacements;
use crate::scene::{ObjectiveBuilder, Scene, Weighted};

/// Newton iterations from a nearby equilibrium. Accepted shapes of the frog
/// took 2 to 8; what takes more is better reached by a shorter step.
const NEARBY: usize = 12;

/// A shape that was not accepted, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Rejected(pub String);

/// A rest shape with its equilibrium and objective.
#[derive(Clone)]
pub struct Evaluation {
    /// Rest vertex positions [m].
    pub rest: Vec<Vec3>,
    /// Displacement at equilibrium [m].
    pub u: Vec<f64>,
    /// Σ of the terms.
    pub objective: f64,
    /// Weighted value of each term, by the user's name.
    pub terms: BTreeMap<String, f64>,
    /// Newton iterations of the equilibrium.
    pub newton_iterations: usize,
    /// Time for the shape, its equilibrium and the terms [s].
    pub forward_s: f64,
}

/// A design problem with a fixed mesh topology and a fixed set of handles.
pub struct Level {
    /// The body at θ = 0.
    pub body: Body,
    /// The handles.
    pub handles: Handles,
    system: System,
    stepping: Stepping,
    terms: Vec<Weighted>,
    extension: Extension,
    moving: Vec<[usize; 3]>,
    mean_edge: f64,
    /// Why the last solve from rest failed, if it did.
    unreached: Option<Unreached>,
}

impl Level {
    /// Sets up `handles` handles on the tag `on` of a body.
    ///
    /// # Errors
    /// When a tag is missing or the handles cannot be placed.
    pub fn new(
        scene: &Scene,
        objectives: &ObjectiveBuilder,
        body: Body,
        on: &str,
        handles: usize,
    ) -> Result<Self> {
        let system = scene.system(&body)?;
        let terms = objectives.build(&body, &system.space)?;
        let moving = body.facets(on)?;
        let handles = sample_handles(&body.mesh.vertices, &moving, handles)?;
        let extension = Extension::new(&body.mesh)?;
        let mean_edge = mesh::measure::mean_edge(&body.mesh.vertices, &moving);
        let stepping = scene.stepping();
        Ok(Self {
            body,
            handles,
            system,
            stepping,
            terms,
            extension,
            moving,
            mean_edge,
            unreached: None,
        })
    }

    /// Number of design variables.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.handles.variables()
    }

    /// Mean edge length of the moving surface [m].
    #[must_use]
    pub fn mean_edge(&self) -> f64 {
        self.mean_edge
    }

    /// Number of degrees of freedom of the equilibrium.
    #[must_use]
    pub fn dofs(&self) -> usize {
        self.system.len()
    }

    /// Rest vertex positions X(θ) [m].
    #[must_use]
    pub fn shape(&self, theta: &[f64]) -> Vec<Vec3> {
        let rest = &self.body.mesh.vertices;
        let moved = self.handles.apply(theta, rest);
        let mut displacement = vec![Vec3::zeros(); rest.len()];
        for (&v, x) in self.handles.vertices().iter().zip(moved) {
            displacement[v] = x - rest[v];
        }
        self.extension.apply(&mut displacement);
        rest.iter().zip(displacement).map(|(x, d)| x + d).collect()
    }

    /// Largest motion of a vertex from θ = a to θ = b [m].
    #[must_use]
    pub fn motion(&self, a: &[f64], b: &[f64]) -> f64 {
        let rest = &self.body.mesh.vertices;
        let (a, b) = (self.handles.apply(a, rest), self.handles.apply(b, rest));
        a.iter().zip(&b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }

    /// Shape, equilibrium and objective at θ; the equilibrium is sought next to
    /// `start` if given, else from rest. The first keeps a search on one branch
    /// of equilibria, and is several times cheaper.
    ///
    /// # Errors
    /// [`Rejected`] when the shape is invalid, a term is infinite or there is
    /// no equilibrium.
    pub fn evaluate(
        &mut self,
        theta: &[f64],
        start: Option<&[f64]>,
    ) -> Result<Evaluation, Rejected> {
        let clock = Instant::now();
        let rest = self.shape(theta);
        self.admit(&rest)?;
        let solution = match start {
            Some(u) => {
                let newton = Newton { iterations: NEARBY, ..self.stepping.newton };
                solve_from(&mut self.system, &rest, u, &newton)
                    .map_err(|e| Rejected(e.to_string()))?
            }
            None => match solve(&mut self.system, &rest, &self.stepping, |_| ()) {
                Ok(solution) => solution,
                Err(unreached) => {
                    let rejected = Rejected(unreached.to_string());
                    self.unreached = Some(unreached);
                    return Err(rejected);
                }
            },
        };
        let at = Equilibrium {
            space: &self.system.space,
            rest: &rest,
            u: &solution.u,
            load: 1.0,
            contact: &[],
        };
        let mut terms = BTreeMap::new();
        for term in &self.terms {
            let value = term.weight * term.objective.value(&at);
            *terms.entry(term.objective.name().to_owned()).or_insert(0.0) += value;
        }
        let objective: f64 = terms.values().sum();
        let newton_iterations = solution.newton_iterations;
        let u = solution.u;
        let forward_s = clock.elapsed().as_secs_f64();
        Ok(Evaluation { rest, u, objective, terms, newton_iterations, forward_s })
    }

    /// Explains why the body at θ = 0 has no equilibrium, after
    /// [`Self::evaluate`] has sought it from rest in vain.
    pub fn diagnose(&mut self, scene: &Scene) -> Option<Diagnosis> {
        let unreached = self.unreached.take()?;
        Some(Diagnosis::new(scene, &self.body, &mut self.system, &unreached))
    }

    /// Makes ready for [`Self::gradient`], [`Self::predict`] and trials at or
    /// next to an evaluation. What follows depends on the evaluation alone, not
    /// on how it was reached: an interrupted search goes on with the same bits.
    pub fn linearize(&mut self, at: &Evaluation) {
        self.system.linearize(&at.rest, &at.u);
    }

    /// First-order change of the equilibrium from `at`, where the level is
    /// linearised, to the shape X(θ): a start for [`Self::evaluate`] on the way
    /// there. None where the equilibrium is not stable.
    pub fn predict(&mut self, theta: &[f64], at: &Evaluation) -> Option<Vec<f64>> {
        let shape = self.shape(theta);
        let motion: Vec<Vec3> = shape.iter().zip(&at.rest).map(|(a, b)| a - b).collect();
        follow(&mut self.system, &at.rest, &at.u, &motion)
    }

    /// The displacement of an evaluation on another mesh of the same shape.
    #[must_use]
    pub fn carry(&self, at: &Evaluation, body: &Body) -> Vec<f64> {
        let space = &self.system.space;
        let vertices = &body.mesh.vertices;
        let other = FunctionSpace::new(space.degree(), vertices.len(), body.mesh.tets.clone());
        interpolate((space, &at.rest, &at.u), (&other, vertices))
    }

    /// dJ/dθ at an evaluation made with the same θ, where the level is
    /// linearised.
    ///
    /// # Errors
    /// When the adjoint system has no accurate solution.
    pub fn gradient(&mut self, theta: &[f64], at: &Evaluation) -> Result<Vec<f64>, Rejected> {
        let by_rest = self.rest_gradient(at)?;
        let mut bar: Vec<Vec3> =
            (0..self.body.mesh.vertices.len()).map(|v| self::at(&by_rest, v)).collect();
        self.extension.pull_back(&mut bar);
        let on_surface: Vec<Vec3> = self.handles.vertices().iter().map(|&v| bar[v]).collect();
        Ok(self.handles.pull_back(theta, &self.body.mesh.vertices, &on_surface))
    }

    /// dJ/dX of all vertices, three components per vertex.
    fn rest_gradient(&mut self, at: &Evaluation) -> Result<Vec<f64>, Rejected> {
        let mut by_u = vec![0.0; at.u.len()];
        let mut by_rest = vec![0.0; 3 * at.rest.len()];
        let here = Equilibrium {
            space: &self.system.space,
            rest: &at.rest,
            u: &at.u,
            load: 1.0,
            contact: &[],
        };
        for term in &self.terms {
            term.objective.add_du(&here, term.weight, &mut by_u);
            term.objective.add_drest(&here, term.weight, &mut by_rest);
        }
        adjoint::add_implicit(&mut self.system, &at.rest, &at.u, &by_u, &mut by_rest)
            .map_err(|e| Rejected(e.to_string()))?;
        Ok(by_rest)
    }

    /// Mean displacement of each tag over its rest area [m].
    ///
    /// # Errors
    /// When a tag has no facets.
    pub fn mean_displacements(&self, at: &Evaluation) -> Result<BTreeMap<String, f64>> {
        let mut body = self.body.clone();
        body.mesh.vertices.clone_from(&at.rest);
        let one = |name: &String| {
            let facets = body.facets(name)?;
            let report = displacements(&body, &self.system.space, &facets, &at.u);
            Ok((name.clone(), report.mean_displacement))
        };
        body.used_tags().map(one).collect()
    }

    /// Whether a rest shape is valid and every term admits it; cheap beside the
    /// equilibrium.
    ///
    /// # Errors
    /// With the element, facet or term that is in the way.
    pub fn admit(&self, rest: &[Vec3]) -> Result<(), Rejected> {
        validity::check(rest, &self.body.mesh.tets, self.body.boundary(), &self.moving)
            .map_err(|e| Rejected(e.to_string()))?;
        for term in &self.terms {
            let name = term.objective.name();
            term.objective.admit(rest).map_err(|e| Rejected(format!("\"{name}\": {e}")))?;
        }
        Ok(())
    }

    /// The solution's grid for ParaView.
    #[must_use]
    pub fn grid(&self, at: &Evaluation) -> mesh::io::vtu::Grid {
        crate::results::grid(&self.system.space, &at.rest, &at.u)
    }
}
