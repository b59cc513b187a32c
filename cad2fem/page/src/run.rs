//! The states of simulations.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use mesh::Vec3;
use mesh::io::read_tets;
use mesh::io::vtu::{Field, Grid, read_vtu};
use program::{InputFile, sha256_file};
use serde_json::{Value, json};

use crate::Shown;
use crate::reported::Run;
use crate::solid::{Solid, TagsByPlace};
use crate::store::Store;
use crate::survey::{Reported, Survey, name};
use crate::threads;
use crate::wall::{self, Wall};

/// Points of all states of all simulations in a page, about; of more, some states are left out.
const POINTS: usize = 1_500_000;

/// A mesh and the hash by which reports name it.
#[derive(Clone)]
struct Known {
    path: PathBuf,
    sha256: String,
}

/// All simulations of a page. What an optimisation left of its design under load is one of them
/// where the design was not simulated again.
pub fn all(survey: &Survey, walls: &[Wall], shown: Shown, store: &mut Store) -> Result<Vec<Value>> {
    let known: Vec<Known> = survey
        .meshes
        .iter()
        .map(|path| Ok(Known { path: path.clone(), sha256: sha256_file(path)? }))
        .collect::<Result<_>>()?;
    let none = Run::default();
    let mut sources: Vec<Source> =
        survey.runs.iter().map(|run| Source::of_run(run, &known)).collect();
    for design in &survey.designs {
        let source = Source::of_design(&design.folder, &none, &known);
        let has = |s: &Source, hash: &str| s.meshes.iter().any(|m| m.mesh.sha256 == hash);
        let again = |s: &Source| source.meshes.iter().all(|m| has(s, &m.mesh.sha256));
        if !source.states.is_empty() && !sources.iter().any(again) {
            sources.push(source);
        }
    }
    if shown == Shown::Last {
        sources
            .iter_mut()
            .for_each(|source| drop(source.states.drain(..source.states.len().saturating_sub(1))));
    }
    let share = POINTS / sources.len().max(1);
    sources.iter().map(|source| source.packed(share, walls, store)).collect()
}

/// Files of a simulation.
struct Source<'a> {
    folder: &'a Path,
    report: &'a Run,
    /// States in their order, with the entry of `steps` in the report.
    states: Vec<(PathBuf, Option<usize>)>,
    /// Meshes that the report names.
    meshes: Vec<Part>,
}

/// A mesh in a simulation.
struct Part {
    mesh: Known,
    /// The name in a scene of several bodies.
    body: Option<String>,
    /// Where it was moved to [m].
    shift: Vec3,
}

impl<'a> Source<'a> {
    fn of_run(Reported { folder, report }: &'a Reported<Run>, known: &[Known]) -> Self {
        let steps = report.steps.len();
        let each = (0..steps).map(|i| (folder.join(format!("step_{i:03}.vtu")), Some(i)));
        let mut states: Vec<_> = each.filter(|(path, _)| path.exists()).collect();
        let last = (folder.join("result.vtu"), steps.checked_sub(1));
        if states.is_empty() && last.0.exists() {
            states.push(last);
        }
        let failed = folder.join("not_full_load.vtu");
        states.extend(failed.exists().then_some((failed, None)));
        let meshes = meshes(report, folder, known);
        Self { folder, report, states, meshes }
    }

    /// What an optimisation left; its report is that of no simulation.
    fn of_design(folder: &'a Path, report: &'a Run, known: &[Known]) -> Self {
        let state = folder.join("result.vtu");
        let states = if state.exists() { vec![(state, None)] } else { vec![] };
        let is_design =
            |k: &&Known| k.path.parent() == Some(folder) && name(&k.path).starts_with("design.");
        let alone = |mesh: &Known| Part { mesh: mesh.clone(), body: None, shift: Vec3::zeros() };
        let meshes = known.iter().filter(is_design).map(alone).collect();
        Self { folder, report, states, meshes }
    }

    /// The thinnest wall at rest of a body of the run, and its place [m]; nothing where no mold was planned
    /// for the body.
    fn wall(&self, walls: &[Wall]) -> Value {
        let hashes: Vec<&str> = self.meshes.iter().map(|part| &part.mesh.sha256[..]).collect();
        wall::of(walls, &hashes).map_or(Value::Null, |(wall, part)| {
            let at = wall.at + self.meshes[part].shift;
            json!({ "thickness": wall.thickness, "at": at.as_slice() })
        })
    }

    fn packed(&self, share: usize, walls: &[Wall], store: &mut Store) -> Result<Value> {
        let place = || self.folder.display().to_string();
        let mut tags = TagsByPlace::default();
        for Part { mesh, body, shift } in &self.meshes {
            tags.add(&read_tets(&mesh.path)?, body.as_deref(), shift);
        }
        let read = |path: &Path| Ok::<Grid, anyhow::Error>(read_vtu(path)?.at_most_quadratic());
        let (first, _) = self.states.first().with_context(|| {
            format!("{}: report.json has no step that one of the .vtu files here shows", place())
        })?;
        let first = read(first)?;
        let solid = Solid::of_grid(&first)
            .with_context(|| format!("{}: the cells are not tetrahedra", place()))?;
        let body = solid.packed(&tags, store);
        let stride = (solid.nodes() * self.states.len()).div_ceil(share).max(1);
        let mut states = Vec::new();
        for (i, (path, step)) in self.states.iter().enumerate() {
            // the last one is always shown
            if !(self.states.len() - 1 - i).is_multiple_of(stride) {
                continue;
            }
            let grid = if i == 0 { first.clone() } else { read(path)? };
            ensure!(
                solid.is_of(&grid),
                "{}: not the mesh of {}: remove what is left of an earlier run",
                path.display(),
                self.states[0].0.display()
            );
            let has_numbers = |f: &&Field| f.components > 0;
            let mut fields = Vec::new();
            for field in grid.point_fields.iter().filter(has_numbers) {
                fields.push(solid.point_field(field, store));
            }
            for field in grid.cell_fields.iter().filter(has_numbers) {
                fields.push(solid.cell_field(field, store));
            }
            states.push(json!({ "file": name(path), "step": step, "fields": fields }));
        }
        let end = self.report.end.as_ref();
        let windings = end.and_then(|end| end.terms.windings.as_ref());
        let force = windings.map(|all| all.iter().map(|w| w.force[1]).fold(0.0, f64::max));
        let threads = threads::packed(self.folder, &solid, force, store)?;
        let chambers = end.map(|end| end.chambers.keys().collect::<Vec<_>>());
        Ok(json!({
            "name": name(self.folder),
            "body": body,
            "threads": threads,
            "states": states,
            "inTime": self.report.config.time.is_some(),
            "chambers": chambers.unwrap_or_default(),
            "rest": self.report.rest,
            "steps": self.report.steps,
            "probes": end.and_then(|end| end.probes.as_ref()),
            "errorBars": end.and_then(|end| end.error_bars.as_ref()),
            "limit": end.and_then(|end| end.limit.as_ref()),
            "stretch": end.map(|end| &end.stretch_range),
            "wall": self.wall(walls),
        }))
    }
}

/// The meshes of a report: by their hash, wherever they are now.
fn meshes(report: &Run, folder: &Path, known: &[Known]) -> Vec<Part> {
    let part = |(i, input): (usize, &InputFile)| {
        let body = report.config.body.get(i).cloned().unwrap_or_default();
        let mesh = find(input, folder, known)?;
        Some(Part { mesh, body: body.name, shift: body.translate.into() })
    };
    let meshes = report.inputs.as_ref().map_or(&[][..], |inputs| inputs.mesh.all());
    meshes.iter().enumerate().filter_map(part).collect()
}

fn find(input: &InputFile, folder: &Path, known: &[Known]) -> Option<Known> {
    let here = known.iter().find(|k| k.sha256 == input.sha256).cloned();
    let there = || Some(Known { path: input.find(folder).ok()?, sha256: input.sha256.clone() });
    let found = here.or_else(there);
    if found.is_none() {
        let path = input.path.display();
        log::warn!("{path}: not where the report has it, or another by now: no tags from it");
    }
    found
}
