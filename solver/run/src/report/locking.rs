//! What elements hold back (locking): by how much a state would change with the next degree.
//!
//! δ = −H⁻¹ ∂E/∂u at Πu        one step of Newton's method
//!
//! Πu is the state in the space of the next degree on the same tetrahedra, which has it exactly. For small
//! displacements u + δ is what the next degree would find; for large ones it is that to first order, and
//! no bound. Elements of degree 1 cannot bend and, nearly incompressible, hardly change their shape at
//! all; those of degree 2 do both, unless the bulk modulus is beyond [`FIRM`] shear moduli.
//!
//! With mean dilatation (`mechanics::energy`) those of degree 2 do both at any bulk modulus, and the next degree is that
//! with mean dilatation, too. What the estimate then finds is how soft or stiff the mesh is.
//!
//! The cost is one assembly and one factorisation with the next degree. Standard elements of bodies that are nearly
//! incompressible, as all of the library are, are compared with those of the same degree with mean dilatation: that costs
//! no more than an iteration.
//!
//! Source: p-refinement as an estimate of the error: Szabó and Babuška, "Finite Element Analysis", 1991.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use measure::probe::{Probe, measure};
use mechanics::element::{HIGHEST_DEGREE, at, elevate};
use mechanics::energy::{FreeFlight, Iterate, TimeStep};
use mechanics::forward::{Problem, newton_step};
use scene::Scene;
use scene::config::{Dilatation, Locking};

/// Bulk modulus in shear moduli up to which degree 2 is not expected to lock.
pub const FIRM: f64 = 1e3;
/// What to use in place of a larger one: the volume changes by the pressure over the bulk modulus, and the
/// pressure is about shear modulus times shear strain.
pub const FIRM_ENOUGH: &str = "100 to 1000 times, poisson = 0.4950 to 0.4995, where the volume changes by about \
     1 to 0.1 % of the shear strain";
/// What to do about elements of degree 2 that hardly change their volume at each point.
pub const AS_A_WHOLE: &str = "[solver] dilatation = \"mean\"";
/// Bulk modulus in shear moduli from which on standard elements are compared with those with mean dilatation.
const NEARLY: f64 = 50.0;
/// Bulk modulus in shear moduli beyond which Newton's method is slow.
const SLOW: f64 = 1e4;
/// Change of the displacement beyond which a state is not to be trusted.
const LARGE: f64 = 0.05;

/// Missing part of the displacement beyond which its number says no more than that it is large.
const HALF: f64 = 0.5;

/// What a state is compared with.
#[derive(Clone, Copy, PartialEq)]
enum Richer {
    /// Elements of the next degree.
    Degree,
    /// Elements of the same degree, with mean dilatation.
    Mean,
}

impl Richer {
    /// What is due for a scene.
    fn of(scene: &Scene) -> Option<Self> {
        let (degree, ratio) = (scene.config.degree, bulk_over_shear(scene));
        let pointwise = scene.config.solver.dilatation == Dilatation::Pointwise;
        let next = (degree < HIGHEST_DEGREE).then_some(Self::Degree);
        let splits = || scene.laws.iter().all(|law| law.material.build().split().is_some());
        match scene.config.solver.locking {
            Locking::Never => None,
            Locking::Always => next,
            Locking::Likely if degree == 1 || pointwise && ratio > FIRM => next,
            Locking::Likely => {
                (degree > 1 && pointwise && ratio > NEARLY && splits()).then_some(Self::Mean)
            }
        }
    }

    /// What it is called after "with".
    fn name(self, degree: usize) -> String {
        match self {
            Self::Degree => format!("degree {}", degree + 1),
            Self::Mean => AS_A_WHOLE.to_owned(),
        }
    }
}

/// The estimate of a state, where the scene asks for it or its elements are likely to lock; it is said
/// in the log, too, as a warning where the state is not to be trusted.
pub fn estimate(
    scene: &Scene,
    of: (&Problem, &[Probe]),
    state: &Iterate,
) -> Option<reports::Locking> {
    let by = Richer::of(scene)?;
    let degree = scene.config.degree;
    let found = estimated(scene, by, of, state);
    match &found {
        Ok(found) if found.change > LARGE => log::warn!("{}", in_words(scene, by, found)),
        Ok(found) => log::info!("{}", in_words(scene, by, found)),
        Err(why) => {
            log::warn!("degree = {degree}: elements may lock; by how much is not known: {why:#}");
        }
    }
    found.ok()
}

/// Says before a run that it will be slow and may fail, where bodies hardly change their volume.
pub fn foresee(scene: &Scene) {
    let (ratio, degree) = (bulk_over_shear(scene), scene.config.degree);
    let mean = scene.config.solver.dilatation == Dilatation::Mean;
    if mean && degree == 1 {
        log::warn!(
            "{AS_A_WHOLE} changes nothing with degree = 1: the volume of its elements has no other way to \
             change; use degree = 2"
        );
    }
    if ratio > SLOW {
        let lock = match degree {
            2 | 3 if mean => String::new(),
            _ => format!(
                ", and elements of degree 1 and 2 lock (degree 2 with {AS_A_WHOLE} does not)"
            ),
        };
        log::warn!(
            "nearly incompressible: the bulk modulus is {ratio:.1e} times the shear modulus; Newton's method \
             may need many small steps{lock}; use {FIRM_ENOUGH}"
        );
    }
}

/// The largest bulk modulus of a scene's laws, in shear moduli.
pub fn bulk_over_shear(scene: &Scene) -> f64 {
    let moduli = scene.laws.iter().map(|law| law.material.moduli());
    moduli.map(|m| m.bulk / m.shear).fold(0.0, f64::max)
}

/// The estimate for a state of a scene's bodies.
fn estimated(
    scene: &Scene,
    with: Richer,
    (problem, probes): (&Problem, &[Probe]),
    state: &Iterate,
) -> Result<reports::Locking> {
    let begin = Instant::now();
    let richer = richer(scene, with);
    let (next, mut workspace) = richer.problem(&scene.body)?;
    let (step, u) = match with {
        Richer::Mean => (state.step.cloned(), state.u.to_vec()),
        Richer::Degree => (
            state.step.map(|step| elevated(step, problem, &next)).transpose()?,
            elevate(state.space, &next.space, state.u),
        ),
    };
    let start = Iterate { space: &next.space, u: &u, step: step.as_ref(), ..*state };
    let by = newton_step(&next, &mut workspace, &start).context("there is no Newton step")?;
    let moved: Vec<f64> = u.iter().zip(&by).map(|(u, by)| u + by).collect();
    let volumes = vertex_volumes(state);
    let size = |field: &[f64]| -> f64 {
        let square = |(v, volume): (usize, &f64)| volume * at(field, v).norm_squared();
        volumes.iter().enumerate().map(square).sum::<f64>().sqrt()
    };
    let after = size(&moved);
    ensure!(after > 0.0 && after.is_finite(), "nothing moves");
    let values = measure(probes, problem, state);
    let end = Iterate { u: &moved, ..start };
    let better = richer.probes(&scene.body, &next.space)?;
    let better: Vec<Probe> = better.into_iter().filter(|p| !p.kind.needs_contact).collect();
    let missing = measure(&better, &next, &end).into_iter();
    let missing = missing.map(|(name, q)| (name.clone(), 1.0 - values[&name] / q));
    Ok(reports::Locking {
        degree: scene.config.degree,
        compared_with: with.name(scene.config.degree),
        bulk_over_shear: bulk_over_shear(scene),
        displacement: 1.0 - size(&u) / after,
        change: size(&by) / after,
        probes: missing.filter(|(_, part)| part.is_finite()).collect(),
        wall_s: begin.elapsed().as_secs_f64(),
    })
}

/// What to say of it.
fn in_words(scene: &Scene, by: Richer, found: &reports::Locking) -> String {
    let reports::Locking { degree, bulk_over_shear, displacement, change, probes, .. } = found;
    let richer = &found.compared_with;
    let percent = 100.0 * displacement.abs();
    let amount = match displacement {
        // the step leads far beyond what it is accurate for
        d if *d > HALF => format!("half of those with {richer}, or less"),
        d if *d < 0.0 => format!("{percent:.1} % too large"),
        _ => format!("{percent:.1} % too small"),
    };
    let mut words = format!(
        "degree = {degree}, bulk modulus {bulk_over_shear:.0} times the shear modulus: displacements \
         are likely {amount}, in all {:.1} % off",
        100.0 * change
    );
    for (name, part) in probes {
        words += &format!(", \"{name}\" {:.1} %", 100.0 * part);
    }
    let pointwise = scene.config.solver.dilatation == Dilatation::Pointwise;
    let next = degree + 1;
    let better = match (by, *degree) {
        (Richer::Mean, _) => AS_A_WHOLE.to_owned(),
        (_, 1) => format!("degree = {next} (where that locks, too, with {AS_A_WHOLE})"),
        _ if pointwise => format!("degree = {next}, {AS_A_WHOLE}"),
        _ => format!("degree = {next}"),
    };
    let advice =
        if *change > LARGE { format!("; use {better}, or a finer mesh") } else { String::new() };
    words + &format!(" (one Newton step with {richer}, {:.1} s){advice}", found.wall_s)
}

/// The scene with richer elements, and the same collision surface.
fn richer(scene: &Scene, by: Richer) -> Scene {
    let mut richer = scene.clone();
    if by == Richer::Mean {
        richer.config.solver.dilatation = Dilatation::Mean;
        return richer;
    }
    if let Some(contact) = richer.config.contact_mut() {
        contact.split = Some(contact.split.unwrap_or(scene.config.degree));
    }
    richer.config.degree += 1;
    richer
}

/// A step in time for the next degree.
fn elevated(step: &TimeStep, from: &Problem, to: &Problem) -> Result<TimeStep> {
    let count = |problem: &Problem| problem.energies.internal_count(&problem.space);
    ensure!(
        count(from) == count(to),
        "[[relaxation]] and [[mullins]]: states at other points of degree 1"
    );
    let lift = |field: &Vec<f64>| match &field[..] {
        [] => Vec::new(),
        field => elevate(&from.space, &to.space, field),
    };
    Ok(TimeStep {
        history: lift(&step.history),
        free_flight: step
            .free_flight
            .as_ref()
            .map(|flight| FreeFlight { at: lift(&flight.at), square: flight.square }),
        ..step.clone()
    })
}

/// A quarter of the rest volumes of the tetrahedra around each vertex [m³].
fn vertex_volumes(state: &Iterate) -> Vec<f64> {
    let mut volumes = vec![0.0; state.rest.len()];
    for tet in state.space.tets() {
        let [a, b, c, d] = tet.map(|v| state.rest[v]);
        let quarter = mesh::measure::tet_volume(a, b, c, d).abs() / 4.0;
        tet.iter().for_each(|&v| volumes[v] += quarter);
    }
    volumes
}
