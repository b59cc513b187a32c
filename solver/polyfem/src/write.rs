//! The folder of an imported scene, and what became of each key.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use mesh::io::{write_atomic, write_surface, write_tets};
use serde_json::{Value, json};

use super::Imported;
use super::scene::REASONS;

/// The names of what is written.
const SCENE: &str = "sim.toml";
const REPORT: &str = "import.report.json";

impl Imported {
    /// Keys that have no part in our scene, by the reason.
    pub fn left(&self) -> BTreeMap<String, Vec<String>> {
        let mut left: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (pointer, why) in self.document.left(REASONS) {
            left.entry(why).or_default().push(pointer);
        }
        left
    }

    /// What the user should know: keys without a part, and choices made.
    pub fn warnings(&self) -> Vec<String> {
        let line = |(why, keys): (String, Vec<String>)| format!("{why}: {}", keys.join(", "));
        self.left().into_iter().map(line).chain(self.scene.notes.iter().cloned()).collect()
    }

    /// Writes the scene; `sim.toml` appears last, when all that it names is there.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let _lock = program::FolderLock::new(folder)?;
        for name in [SCENE, REPORT] {
            mesh::io::remove_output(&folder.join(name))?;
        }
        for solid in &self.scene.geometry.solids {
            write_tets(&folder.join(format!("{}.msh", solid.name)), &solid.mesh, &solid.tags)?;
        }
        for obstacle in &self.scene.geometry.obstacles {
            write_surface(&folder.join(format!("{}.obj", obstacle.name)), &obstacle.surface)?;
        }
        program::write_json(&folder.join(REPORT), &self.report())?;
        let text = self.scene.comments.clone() + &toml::to_string(&self.scene.values)?;
        write_atomic(&folder.join(SCENE), |out| out.write_all(text.as_bytes()))?;
        Ok(())
    }

    fn report(&self) -> Value {
        json!({
            "program": ::scene::PROGRAM,
            "path": self.document.path,
            "sha256": self.document.sha256,
            "left": self.document.left(REASONS),
            "notes": self.scene.notes,
            "thickness": self.scene.geometry.thickness,
        })
    }
}
