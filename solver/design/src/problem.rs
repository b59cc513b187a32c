//! A design problem as its files have it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use program::{Change, Changes, InputFile, KeyPath, Settings, Unusable};
use reports::Inputs;
use run::report::results;
use scene::config::{DesignConfig, LevelConfig, beside};
use scene::{ObjectiveBuilder, Scene};

use super::{Evaluation, Level, Meshes};

/// A design problem and its scene.
pub struct Problem {
    /// The file of the design.
    pub path: PathBuf,
    /// What is written there.
    pub file: Settings,
    /// The design problem.
    pub design: DesignConfig,
    /// The scene that it is of.
    pub scene: Scene,
    /// What is set in the scene from outside.
    of_scene: Vec<Change>,
}

impl Problem {
    /// A design file and its scene, perhaps with other meshes, each by the name of its body if there are several, and
    /// other values.
    pub fn read(
        path: &Path,
        others: &[(Option<String>, PathBuf)],
        changes: &Changes,
    ) -> Result<Self> {
        let (own, of_scene) = changes.own_and_scene();
        let file = DesignConfig::settings(path, &own)?;
        let design = DesignConfig::of(&file)?;
        let scene = Scene::read_with(&beside(path, &design.scene), others, &of_scene)?;
        scene.warn_of_growth();
        Ok(Self { path: path.to_owned(), file, design, scene, of_scene })
    }

    /// The terms of its objective.
    pub fn objectives(&self) -> Result<ObjectiveBuilder<'_>> {
        let terms = &self.design.objective;
        self.file.checked(|_| ObjectiveBuilder::new(&self.path, terms, &self.scene))
    }

    /// A level on the body of the scene, and its start with the weights that shares come to.
    pub fn start(
        &self,
        objectives: &ObjectiveBuilder,
        settings: &LevelConfig,
    ) -> Result<(Level, Evaluation)> {
        let Self { path, file, design, scene, .. } = self;
        let mut level = file.checked(|_| {
            let level = Level::new(scene, objectives, scene.body.clone(), design, settings)?;
            level.admit(&level.body.mesh.vertices).context("the starting shape")?;
            Ok(level)
        })?;
        let start = level.evaluate(&vec![0.0; level.variables()], &[]);
        let start =
            start.map_err(|e| Unusable(format!("{}: the starting shape: {e}", path.display())))?;
        let start = file.checked(|_| level.weigh(&design.objective, start))?;
        Ok((level, start))
    }

    /// The body on the meshes of the scene and of the levels.
    pub fn meshes(&self) -> Result<Meshes> {
        let Self { path, design, scene, .. } = self;
        let read = |level: &LevelConfig| {
            let levels = if design.shape.is_some() { "shape.level" } else { "level" };
            check_body(level, &KeyPath::list(levels), scene)?;
            let path = level.mesh.iter().map(|mesh| beside(path, mesh));
            let others: Vec<_> = path.map(|path| (level.body.clone(), path)).collect();
            Ok(Scene::read_with(&scene.path, &others, &self.of_scene)?.body)
        };
        self.file.checked(|_| Meshes::new(&scene.body, design, read))
    }

    /// Hash of all that is read: a checkpoint is only good for the problem it was made for.
    pub fn hash(&self) -> Result<String> {
        let mut hashes = vec![self.file.hash(), self.scene.file.hash()];
        let meshes = self.scene.parts.iter().map(|part| &part.mesh_path);
        for path in meshes.chain(self.named_files().iter().flatten()) {
            hashes.push(program::sha256_file(path)?);
        }
        Ok(hashes.join(" "))
    }

    /// The meshes of levels and the files of objectives that a design names beside its scene.
    fn named_files(&self) -> [BTreeSet<PathBuf>; 2] {
        let at = self.file.file().path;
        let all = |paths: Vec<PathBuf>| paths.iter().map(|path| beside(&at, path)).collect();
        let meshes = self.design.levels().into_iter().filter_map(|level| level.mesh).collect();
        let targets = self.design.objective.iter().flat_map(|term| term.files());
        [all(meshes), all(targets.map(PathBuf::from).collect())]
    }

    /// The files that a design was made from, as seen from a folder, and the values that were set.
    pub fn provenance(&self, folder: &Path) -> Result<(Inputs, Vec<String>)> {
        let (inputs, set) = results::provenance(folder, Some(&self.file), &self.scene)?;
        let hashed = |paths: BTreeSet<PathBuf>| -> Result<Vec<InputFile>> {
            Ok(paths.iter().map(|path| InputFile::new(path, folder)).collect::<Result<_, _>>()?)
        };
        let [level_meshes, targets] = self.named_files().map(hashed);
        Ok((Inputs { level_meshes: level_meshes?, targets: targets?, ..inputs }, set))
    }
}

/// The mesh of a level is of a body that the scene has.
fn check_body(level: &LevelConfig, levels: &KeyPath, scene: &Scene) -> Result<()> {
    let names: Vec<&str> = scene.body.parts.iter().filter_map(|p| p.name.as_deref()).collect();
    let known = names.join(", ");
    let (word, what) = match level.body.as_deref() {
        Some(body) if names.is_empty() => {
            (body, format!("body = \"{body}\": the scene has only one body; expected none"))
        }
        Some(body) if !names.contains(&body) => {
            (body, format!("body = \"{body}\": expected one of {known}"))
        }
        None if names.len() > 1 => {
            ("mesh", format!("mesh without body; expected body = one of {known}"))
        }
        _ => return Ok(()),
    };
    bail!(levels.clone().with(KeyPath::word(word)).told(format!("level: {what}")))
}
