//! One line per accepted iteration, in `history.jsonl`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use reports::{Handles, Iteration, Numbers, ScenarioRun, numbers};
use scene::config::{HandlesConfig, LevelConfig};

use super::{Evaluation, Level, Run, Scenario};

/// The file in a folder.
pub struct History {
    path: PathBuf,
}

impl History {
    /// The history of a folder.
    pub fn new(folder: &Path) -> Self {
        Self { path: folder.join("history.jsonl") }
    }

    /// All lines.
    pub fn read(&self) -> Result<Vec<Iteration>> {
        let text = mesh::io::read_own_text(&self.path)?;
        let lines = text.lines().map(serde_json::from_str).collect::<Result<_, _>>();
        lines.with_context(|| self.path.display().to_string())
    }

    /// Adds a line.
    pub fn append(&self, line: &Iteration) -> Result<()> {
        let line = serde_json::to_value(line)?;
        let mut file = mesh::io::open_to_append(&self.path)?;
        writeln!(file, "{line}")
            .and_then(|()| file.sync_all())
            .with_context(|| self.path.display().to_string())
    }

    /// SHA-256 of all lines.
    pub fn sha256(&self) -> Result<String> {
        Ok(program::sha256_file(&self.path)?)
    }

    /// Keeps the first `lines` lines, which have this SHA-256 if there are any.
    pub fn truncate(&self, lines: usize, sha256: &str) -> Result<()> {
        let path = &self.path;
        let text = if path.exists() { mesh::io::read_own_text(path)? } else { String::new() };
        let found = text.lines().count();
        ensure!(
            found >= lines,
            "{}: {found} lines, but the checkpoint is at line {lines}; start over with --restart",
            path.display()
        );
        let kept: String = text.lines().take(lines).flat_map(|l| [l, "\n"]).collect();
        ensure!(
            lines == 0 || program::sha256(kept.as_bytes()) == sha256,
            "{}: its first {lines} lines were altered; start over with --restart",
            path.display()
        );
        if found > lines {
            mesh::io::write_atomic(path, |out| out.write_all(kept.as_bytes()))?;
        }
        Ok(())
    }
}

/// What each scenario comes to, by its name, in their order.
pub(super) fn scenarios(level: &Level, at: &Evaluation) -> Result<Vec<(String, ScenarioRun)>> {
    let one = |(scenario, run): (&Scenario, &Run)| {
        let measured = scenario.measured(run)?;
        let found = ScenarioRun {
            objective: Some(run.objective),
            terms: numbers(&run.terms),
            newton_iterations: run.newton_iterations,
            mean_displacement: numbers(&scenario.mean_displacements(run)?),
            probes: (!measured.is_empty()).then(|| numbers(&measured)),
        };
        Ok((scenario.config.name.clone(), found))
    };
    level.runs(at).map(one).collect()
}

/// Handles of a level, whose numbers are those of one alone.
pub(super) fn handles(settings: &LevelConfig) -> Option<Handles> {
    match settings.handles.as_ref()? {
        HandlesConfig::Each(count) => Some(Handles::Each(*count)),
        HandlesConfig::Tags(counts) => Some(Handles::Tags(counts.clone())),
        HandlesConfig::Growing(_) => None,
    }
}

/// The spread of mean displacements of tags: the largest less the smallest, over that of the first scenario [1].
pub(super) fn spread(scenarios: &[(String, ScenarioRun)]) -> Numbers {
    let spread = |(tag, first): (&String, &Option<f64>)| {
        let first = first.filter(|first| *first > 0.0)?;
        let all = || scenarios.iter().filter_map(|(_, run)| *run.mean_displacement.get(tag)?);
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        Some((tag.clone(), Some((high - low) / first)))
    };
    scenarios[0].1.mean_displacement.iter().filter_map(spread).collect()
}
