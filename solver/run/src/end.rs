//! What a run came to: the files and the report of its end, as `solver simulate` and the Python package write them.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use measure::probe::Probe;
use mechanics::energy::Iterate;
use mechanics::forward::{LoadStep, Problem, Trajectory, Workspace};
use reports::{Simulation, Status};
use scene::Scene;

use super::error_bars;
use super::limit::{self, Edges};
use crate::report::simulation::{self, Spent, Verdict};
use crate::report::{reinforcement, results, stability, summary, threads};

/// The end of a run.
pub struct Outcome<'a> {
    /// The state there.
    pub end: Iterate<'a>,
    /// The last load step, if it is known: of a path, with its stability.
    pub last: Option<&'a LoadStep>,
    /// All states, where error bars need them.
    pub states: Option<&'a Trajectory>,
    /// What the run took.
    pub spent: Spent<'a>,
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
        let (end, energies) = (&self.end, &problem.energies);
        reinforcement::write_threads(folder, scene, energies, end)?;
        threads::crossings(scene, energies, end).iter().for_each(|line| log::info!("{line}"));
        let (recorder, last) = (self.spent.recorder, self.last);
        let on_path = (recorder.lines.len(), last);
        let verdict = Verdict::new(scene, problem, end, on_path, recorder.largest_gain());
        let (status, refusal) = (verdict.status(), verdict.refusal());
        let mut found = simulation::end(scene, (problem, probes), end, &self.spent, verdict)?;
        let known = stability::at_end(scene, (problem, workspace), end, last);
        let (stability, mode) = known.unzip();
        found.stability = stability;
        found.load_reached = last.filter(|step| step.path.is_some()).map(|step| step.time);
        let mut edges = edges(scene, problem, end);
        if let Some(edges) = &mut edges {
            error_bars::report_edges(scene, problem, end, edges);
        }
        let at_limit = || edges.as_ref()?.at_limit.as_ref().map(|found| found.mode.clone());
        let mode = mode.or_else(at_limit);
        found.limit = edges.map(|edges| edges.limit);
        results::write_end(folder, problem, end, mode.as_deref())?;
        let bars = |states| error_bars::report(scene, (problem, workspace), probes, states);
        found.error_bars = self.states.and_then(bars);
        found.wall_s = self.before_s + self.since.elapsed().as_secs_f64();
        found.peak_rss_mb = program::peak_rss_mb();
        (report.usable, report.status) = (status == Status::Ok, status);
        log::info!("{}", summary::in_words(&found));
        summary::inflations(&found).iter().for_each(|line| log::info!("{line}"));
        report.end = Some(found);
        results::write_report(folder, &report)?;
        Ok(refusal)
    }
}

/// How much more pressure the state at the end bears, where the scene asks for that.
fn edges(scene: &Scene, problem: &Problem, end: &Iterate) -> Option<Edges> {
    let found = limit::find(scene, problem, end, scene.config.limit.as_ref()?);
    log::info!("{}", limit::in_words(&found.limit));
    Some(found)
}
