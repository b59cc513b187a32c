//! Derivatives of probes by numbers of a scene: one sweep of the adjoint for each probe.
//!
//! modulus    all parameters of all laws, or of one, that are stresses, by one factor  [1]
//! law        one parameter of the law of a body or volume                     [its unit]
//! wall       the boundary, or the part with a tag, outward by a distance      [m]
//! pressure   pressure or fill of a chamber, by a difference                   [Pa]
//! density    of all bodies, by one factor                                     [1]
//! membrane   thickness of all sheets, or of one, by a factor                  [1]

use std::collections::BTreeMap;

use anyhow::{Result, anyhow};
use mesh::Vec3;
use mesh::offset::shifts;

use crate::adjoint::{self, Gradient};
use crate::body::Body;
use crate::config::is_pressure;
use crate::design::Extension;
use crate::energy::{Iterate, ParameterId};
use crate::forward::{Problem, Trajectory, Workspace, solve_multipliers};
use crate::objective::Equilibrium;
use crate::probe::Probe;
use crate::scene::{Scene, SceneMembrane};

/// Moves of the rest vertices per distance: of the whole boundary, then tag by tag.
pub struct Walls {
    extension: Extension,
    vertices: usize,
    shifts: Vec<(Option<String>, BTreeMap<usize, Vec3>)>,
}

impl Walls {
    /// Of a body, or of several.
    ///
    /// # Errors
    /// When an element is so flat that the interior cannot follow.
    pub fn new(body: &Body) -> Result<Self> {
        let x = &body.mesh.vertices;
        let extension = Extension::new(body)
            .map_err(|_| anyhow!("to move walls: an element of the mesh is too flat"))?;
        let mut walls = vec![(None, shifts(x, body.boundary()))];
        for tag in body.used_tags() {
            walls.push((Some(tag.clone()), shifts(x, &body.facets(tag)?)));
        }
        Ok(Self { extension, vertices: x.len(), shifts: walls })
    }

    /// The derivative by each, from that by the rest vertices.
    #[must_use]
    pub fn derivatives(&self, by_rest: &[f64]) -> Vec<(Option<String>, f64)> {
        let mut bar: Vec<Vec3> = by_rest.chunks_exact(3).map(Vec3::from_column_slice).collect();
        self.extension.pull_back(&mut bar);
        let along = |moves: &BTreeMap<usize, Vec3>| moves.iter().map(|(&v, d)| bar[v].dot(d)).sum();
        self.shifts.iter().map(|(tag, moves)| (tag.clone(), along(moves))).collect()
    }

    /// The moves of all vertices per distance of the boundary, or of the part with a tag,
    /// where there is one.
    #[must_use]
    pub fn moves(&self, tag: Option<&str>) -> Option<Vec<Vec3>> {
        let (_, shifts) = self.shifts.iter().find(|(own, _)| own.as_deref() == tag)?;
        let mut moves = vec![Vec3::zeros(); self.vertices];
        shifts.iter().for_each(|(&v, d)| moves[v] = *d);
        self.extension.apply(&mut moves);
        Some(moves)
    }
}

/// The value of each probe at the end of time step n ≥ 1 of a run, and its derivatives.
///
/// # Errors
/// When the adjoint system has no accurate solution.
pub fn sensitivities(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    (probes, run, n): (&[&Probe], &Trajectory, usize),
) -> Result<Vec<(f64, Gradient)>> {
    let rest = &scene.body.mesh.vertices[..];
    let (state, step) = (run.state(n), run.step(problem, rest, n));
    let at = problem.iterate(rest, &state.u, run.times[n]);
    let at = Iterate { step: Some(&step), ..at };
    let multipliers = solve_multipliers(problem, workspace, &at);
    let at = Iterate { multipliers: &multipliers, ..at };
    let contact = problem.energies.contact_forces(&at);
    let reaction = problem.gradient(&at).0;
    let linearization = (n == run.steps()).then(|| workspace.linearize(problem, &at));
    let (space, u, load) = (at.space, at.u, at.load);
    let here = Equilibrium { space, rest, u, load, contact: &contact, reaction: &reaction };
    let mut found = Vec::new();
    for probe in probes {
        let q = &probe.quantity;
        let partials = |_: &_, moment: usize, out: &mut adjoint::Partials| {
            if moment == n {
                q.add_du(&here, 1.0, &mut out.by_u);
                q.add_dcontact(&here, 1.0, &mut out.by_contact);
                q.add_dreaction(&here, 1.0, &mut out.by_reaction);
            }
        };
        let on = (rest, run);
        let mut swept = adjoint::sweep(problem, workspace, on, linearization.as_ref(), partials)
            .map_err(|e| anyhow!("derivatives of the probe \"{}\": {e}", probe.name))?;
        q.add_drest(&here, 1.0, &mut swept.rest);
        found.push((q.value(&here), swept));
    }
    Ok(found)
}

/// By one factor on all parameters of each law that are stresses, with its name [1].
#[must_use]
pub fn by_moduli(scene: &Scene, by: &Gradient) -> Vec<(String, f64)> {
    let by_stresses = |law: usize| -> f64 {
        let material = &scene.laws[law].material;
        let by = by.parameters.total(ParameterId::Material(law));
        let pairs = material.law.named(&material.values).into_iter().zip(material.law.named(&by));
        let stresses = pairs.filter(|((parameter, _), _)| parameter.unit == "Pa");
        stresses.flat_map(|((_, p), (_, by))| p.into_iter().zip(by)).map(|(p, by)| p * by).sum()
    };
    let laws = scene.laws.iter().enumerate();
    laws.map(|(i, law)| (scene.law_name(law), by_stresses(i))).collect()
}

/// By one factor on the density of all bodies [1].
#[must_use]
pub fn by_density(scene: &Scene, by: &Gradient) -> f64 {
    let of = |law: usize| -> f64 {
        let density = scene.laws[law].material.density.unwrap_or(0.0);
        by.parameters.total(ParameterId::Density(law)).iter().map(|by| by * density).sum()
    };
    (0..scene.laws.len()).map(of).sum()
}

/// By a factor on the thickness of each sheet, with the tag that it is on [1].
#[must_use]
pub fn by_membranes(scene: &Scene, by: &Gradient) -> Vec<(String, f64)> {
    let one = |(i, membrane): (usize, &SceneMembrane)| {
        let by = by.parameters.total(ParameterId::Membrane(i));
        (membrane.config.on.clone(), by.first().map_or(0.0, |by| by * membrane.thickness))
    };
    scene.membranes.iter().enumerate().map(one).collect()
}

/// By a difference in what is prescribed of each chamber, where that is a pressure [Pa].
#[must_use]
pub fn by_pressures(problem: &Problem, by: &Gradient) -> Vec<(String, f64)> {
    let chambers = problem.energies.chambers().filter(|(_, c)| is_pressure(c.chamber.gas.key()));
    let steps = 0..by.parameters.steps();
    let sum = |id| steps.clone().map(|step| by.parameters.chamber(step, id)).sum::<f64>();
    chambers.map(|(id, c)| (c.name.clone(), sum(id))).collect()
}
