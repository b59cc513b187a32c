//! What a run came to: the files and the report of its end, as `solver simulate` and the Python package write them.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use measure::probe::Probe;
use mechanics::energy::Iterate;
use mechanics::forward::{LoadStep, Problem, Trajectory, Workspace};
use reports::{End, Simulation, Status};
use scene::Scene;

use super::error_bars;
use super::limit;
use crate::report::record::Recorder;
use crate::report::simulation::{self, Verdict};
use crate::report::{inflation, locking, results, stability, summary, threads};

/// The end of a run.
pub struct Outcome<'a> {
    /// The state there.
    pub end: Iterate<'a>,
    /// The last load step, if it is known: of a path, with its stability.
    pub last: Option<&'a LoadStep>,
    /// All states, where error bars need them.
    pub states: Option<&'a Trajectory>,
    /// What was written of its steps.
    pub recorder: &'a Recorder<'a>,
    /// Iterations of Newton's method.
    pub newton_iterations: usize,
    /// Velocity at the end, where there is inertia [m/s].
    pub velocity: Option<&'a [f64]>,
    /// How long ordering and load steps took [s], ...
    pub equilibrium_s: f64,
    /// ... and were foreseen to take, if they were [s].
    pub predicted_s: Option<f64>,
    /// When this began that the run took besides ...
    pub since: Instant,
    /// ... after so many seconds.
    pub before_s: f64,
}

impl Outcome<'_> {
    /// Completes the report of the run and writes it to a folder, beside the state at the end. The result is why it
    /// must not be used, if it must not.
    pub fn write(
        &self,
        scene: &Scene,
        (problem, workspace, probes): (&Problem, &mut Workspace, &[Probe]),
        folder: &Path,
        mut report: Simulation,
    ) -> Result<Option<String>> {
        let (end, terms, recorder) = (&self.end, &problem.energies, self.recorder);
        let timings = workspace.timings;
        threads::write(folder, scene, terms, end)?;
        threads::crossings(scene, terms, end).iter().for_each(|line| log::info!("{line}"));
        let on_path = (recorder.lines.len(), self.last);
        let verdict = Verdict::new(scene, problem, end, on_path, recorder.largest_gain());
        let (status, refusal) = (verdict.status(), verdict.refusal());
        let energies = results::stored_energies(terms, end);
        let elastic = results::elastic_energy(terms, &energies);
        let kinetic = self.velocity.map(|v| results::kinetic_energy(terms, end.space, end.rest, v));
        let locking = locking::estimate(scene, (problem, probes), end);
        let known = stability::at_end(scene, (problem, workspace), end, self.last);
        let (stability, mode) = known.unzip();
        let edges = scene.config.limit.as_ref().map(|config| {
            let mut found = limit::find(scene, problem, end, config);
            log::info!("{}", limit::in_words(&found.limit));
            error_bars::report_edges(scene, problem, end, &mut found);
            found
        });
        let at_limit = || edges.as_ref()?.at_limit.as_ref().map(|found| found.mode.clone());
        let mode = mode.or_else(at_limit);
        results::write_end(folder, problem, end, mode.as_deref())?;
        let bars = |states| error_bars::report(scene, (problem, workspace), probes, states);
        let found = End {
            tolerance_met: recorder.lines.iter().all(|line| line.rounding_floor.is_none()),
            newton_iterations: self.newton_iterations,
            energy_balance: simulation::balance(recorder, elastic, kinetic),
            energies,
            force_balance: results::balance(problem, end),
            tags: results::tags(scene, &scene.body, problem, end)?,
            chambers: results::chambers(terms, end),
            terms: verdict.terms,
            inflations: inflation::inflations(scene, &recorder.lines),
            probes: (!probes.is_empty()).then(|| results::probes(probes, problem, end)),
            stretch_range: verdict.stretch_range,
            locking,
            timings: simulation::timings(&timings, self.predicted_s),
            crossing: verdict.crossing,
            stability,
            load_reached: self.last.filter(|step| step.path.is_some()).map(|step| step.time),
            limit: edges.map(|edges| edges.limit),
            error_bars: self.states.and_then(bars),
            equilibrium_s: self.equilibrium_s,
            wall_s: self.before_s + self.since.elapsed().as_secs_f64(),
            peak_rss_mb: program::peak_rss_mb(),
        };
        (report.usable, report.status) = (status == Status::Ok, status);
        log::info!("{}", summary::in_words(&found));
        summary::inflations(&found).iter().for_each(|line| log::info!("{line}"));
        report.end = Some(found);
        results::write_report(folder, &report)?;
        Ok(refusal)
    }
}
