//! The report of a simulation, and the judgement of it: one for the program, which ends with exit code 1 where the
//! result must not be used, and for the Python package, which raises an exception there.

use std::path::Path;

use anyhow::Result;
use mechanics::energy::Iterate;
use mechanics::forward::{self, LoadStep, Problem, Workspace};
use mechanics::stretch::{Strained, Stretches};
use reports::{
    Crossing, EnergyBalance, Material, MaterialRange, Moduli, OneOrList, Simulation, Status,
    StretchRange, Task, Terms, Timings,
};
use scene::term::State;
use scene::{Scene, SceneLaw, law_table};
use serde_json::json;

use crate::report::crossing;
use crate::report::locking;
use crate::report::record::Recorder;
use crate::report::results;
use crate::report::stability;

/// What is known before a run whose results lie in a folder.
pub fn begun(scene: &Scene, problem: &Problem, folder: &Path) -> Result<Simulation> {
    let (inputs, set) = results::provenance(folder, None, scene)?;
    let cut = !scene.body.planes.is_empty();
    let mut config = scene.config.clone();
    if let (Some(own), Some(contact)) = (config.contact_mut(), problem.energies.contact()) {
        let barrier = contact.barrier();
        own.activation.get_or_insert(barrier.activation);
        own.stiffness.get_or_insert(barrier.stiffness);
    }
    Ok(Simulation {
        status: Status::Ok,
        usable: true,
        program: scene::PROGRAM.to_owned(),
        inputs,
        set,
        config: json!(config),
        material: OneOrList::new(materials(scene)?),
        dofs: problem.dofs(),
        tets: scene.body.mesh.tets.len(),
        vertices: scene.body.mesh.vertices.len(),
        symmetry: cut.then(|| results::symmetry(&scene.body)),
        rest: None,
        steps: Vec::new(),
        factor_entries: 0,
        memory_estimate_mb: 0.0,
        end: None,
        failed: None,
    })
}

/// The law of each body or volume.
fn materials(scene: &Scene) -> Result<Vec<Material>> {
    let one = |law: &SceneLaw| {
        let (material, moduli) = (&law.material, law.material.moduli());
        let parameters = law_table::written(material.law, &material.values);
        let silicone = law.config.silicone().map(|named| named.report());
        Ok(Material {
            kind: material.law.key.to_owned(),
            parameters: serde_json::from_value(json!(parameters))?,
            moduli: Moduli { shear: moduli.shear, bulk: moduli.bulk },
            silicone: silicone.map(serde_json::from_value).transpose()?,
            on: law.volume.is_some().then(|| law.name.clone()),
        })
    };
    scene.laws.iter().map(one).collect()
}

/// Energy that time integration may add, over the largest stored and kinetic one: the work of loads is summed by
/// the trapezoidal rule, of second order in the step.
const NOTABLE_GAIN: f64 = 0.1;

/// Takes over what a run has written of its steps, and what its factor took.
pub fn follow(report: &mut Simulation, recorder: &Recorder, workspace: &Workspace) {
    report.rest.clone_from(&recorder.rest);
    report.steps.clone_from(&recorder.lines);
    // at the end, as contact adds entries
    report.factor_entries = workspace.linear().cost().entries;
    report.memory_estimate_mb = workspace.memory().bytes as f64 / f64::from(1 << 20);
}

/// Says before a run what a user should know of its scene, as warnings in the log.
pub fn foresee(scene: &Scene) {
    scene.warn_of_growth();
    locking::foresee(scene);
    let warnings = scene.config.rooms().into_iter().flat_map(|room| room.warnings(&scene.body));
    warnings.for_each(|line| log::warn!("{line}"));
}

/// What decides whether the state at the end of a run may be used.
pub struct Verdict {
    /// Surfaces that have passed through each other.
    pub crossing: Option<Crossing>,
    /// How a path ended before the full load that was asked for.
    missed: Option<String>,
    /// Principal stretches.
    pub stretch_range: StretchRange,
    /// Sections of the terms.
    pub terms: Terms,
}

impl Verdict {
    /// Of the state at the end of a run of some load steps, the last of which is known on a path. They have added a part of
    /// the largest energy to it [1], where that is known. What a user should know of it is said in the log, as warnings.
    pub fn new(
        scene: &Scene,
        problem: &Problem,
        end: &Iterate,
        (steps, last): (usize, Option<&LoadStep>),
        gain: Option<f64>,
    ) -> Self {
        if let Some(gain) = gain.filter(|gain| *gain > NOTABLE_GAIN) {
            log::warn!(
                "the steps in time add energy: {:.0} % of the largest that there is, at most {:.0} % expected\n  \
                 take shorter steps, or method = \"generalized-alpha\" in [time]",
                100.0 * gain,
                100.0 * NOTABLE_GAIN
            );
        }
        let missed = stability::missed(scene, steps, last);
        missed.iter().for_each(|missed| log::warn!("{missed}"));
        let (mut terms, state) = (Terms::default(), State { energies: &problem.energies, at: end });
        scene.config.rooms().into_iter().for_each(|room| room.report(state, &mut terms));
        let find = || crossing::find(scene, &scene.body, problem, end);
        Self {
            stretch_range: stretches(scene, end),
            terms,
            crossing: scene.certify.then(find).flatten(),
            missed,
        }
    }

    /// What the result is.
    pub fn status(&self) -> Status {
        match (&self.crossing, &self.missed) {
            (Some(_), _) => Status::SurfacesCrossed,
            (None, Some(_)) => Status::FullLoadNotReached,
            (None, None) => Status::Ok,
        }
    }

    /// Why the result must not be used, if it must not.
    pub fn refusal(&self) -> Option<String> {
        self.crossing.as_ref().map(crossing::in_words).or_else(|| self.missed.clone())
    }
}

/// Work of the loads beside stored and kinetic energy [J].
pub fn balance(recorder: &Recorder, elastic: f64, kinetic: Option<f64>) -> EnergyBalance {
    let work_of_loads = recorder.work().total;
    let gap = (work_of_loads - elastic) / elastic.max(f64::MIN_POSITIVE);
    let relative_gap = kinetic.is_none().then_some(gap);
    let largest_gain = recorder.largest_gain();
    EnergyBalance { work_of_loads, elastic, kinetic, largest_gain, relative_gap }
}

/// Principal stretches of the state, with warnings where the material was not tested or tears.
fn stretches(scene: &Scene, end: &Iterate) -> StretchRange {
    let found = Stretches::of(end.space, end.rest, end.u, scene.stretch_limits(&scene.body));
    found.warnings().iter().for_each(|warning| log::warn!("{warning}"));
    let one = |(of, law): (&Strained, &SceneLaw)| MaterialRange {
        on: (scene.laws.len() > 1).then(|| law.name.clone()),
        tested: of.limits.tested,
        modes: of.limits.modes.iter().map(|mode| mode.state().to_owned()).collect(),
        smallest: of.smallest.stretch,
        smallest_at: of.smallest.at,
        largest: of.largest.stretch,
        largest_at: of.largest.at,
        volume_beyond: of.beyond,
        untested: of.untested.iter().map(|(mode, part)| (mode.state().to_owned(), *part)).collect(),
    };
    let tested = found.materials.iter().filter_map(|of| of.limits.tested);
    StretchRange {
        smallest: found.smallest.stretch,
        smallest_at: found.smallest.at,
        largest: found.largest.stretch,
        largest_at: found.largest.at,
        volume_beyond: found.volume_beyond,
        margin: found.margin,
        fitted: tested.reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])]),
        at_break: found.at_break,
        materials: found.materials.iter().zip(&scene.laws).map(one).collect(),
    }
}

/// Where the time went, and how much was foreseen [s].
pub fn timings(spent: &forward::Timings, predicted_s: Option<f64>) -> Timings {
    let task = |time: forward::Time| Task { wall_s: time.wall_s, processor_s: time.processor_s };
    Timings {
        ordering: task(spent.ordering),
        assembly: task(spent.assembly),
        contact: task(spent.contact),
        factor: task(spent.factor),
        solve: task(spent.solve),
        collision: task(spent.collision),
        certificate: task(spent.certificate),
        output: task(spent.output),
        factorizations: spent.factorizations,
        failed_factorizations: spent.failed_factorizations,
        predicted_s,
    }
}
