//! The folder of an imported scene, and what became of each key.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use mesh::io::{write_atomic, write_surface, write_tets};
use serde_json::{Value, json};

use super::document::Document;
use super::geometry::Solid;
use super::{Imported, Reasons};

/// The names of what is written, and of what an earlier import may have left.
const SCENE: &str = "sim.toml";
const DESIGN: &str = "design.toml";
const REPORT: &str = "import.report.json";

impl Imported {
    /// Keys that have no part in our scene, by the reason.
    pub fn left(&self) -> BTreeMap<String, Vec<String>> {
        let mut left: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (document, reasons) in &self.documents {
            let file = document.path.file_name().unwrap_or_default().to_string_lossy();
            for (pointer, why) in document.left(reasons) {
                left.entry(format!("{file}: {why}")).or_default().push(pointer);
            }
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
        for name in [SCENE, DESIGN, REPORT] {
            mesh::io::remove_output(&folder.join(name))?;
        }
        for solid in &self.scene.geometry.solids {
            write_tets(&folder.join(format!("{}.msh", solid.name)), &solid.mesh, &solid.tags)?;
        }
        for obstacle in &self.scene.geometry.obstacles {
            write_surface(&folder.join(format!("{}.obj", obstacle.name)), &obstacle.surface)?;
        }
        if let Some(design) = &self.design {
            for target in &design.targets {
                write_atomic(&folder.join(&target.name), |out| out.write_all(&target.bytes))?;
            }
            write_atomic(&folder.join(DESIGN), |out| out.write_all(design.text.as_bytes()))?;
        }
        program::write_json(&folder.join(REPORT), &self.report())?;
        write_atomic(&folder.join(SCENE), |out| out.write_all(self.scene.text.as_bytes()))?;
        Ok(())
    }

    fn report(&self) -> Value {
        let file = |(document, reasons): &(Document, Reasons)| {
            json!({
                "path": document.path,
                "sha256": document.sha256,
                "left": document.left(reasons),
            })
        };
        let files: Vec<Value> = self.documents.iter().map(file).collect();
        let bodies: Vec<Value> = self.scene.geometry.solids.iter().map(facts).collect();
        json!({
            "program": ::scene::PROGRAM,
            "files": files,
            "notes": self.scene.notes,
            "thickness": self.scene.geometry.thickness,
            "bodies": bodies,
        })
    }
}

/// Sizes of a body and its tags.
fn facts(solid: &Solid) -> Value {
    let mut tags = serde_json::Map::new();
    for (name, id) in solid.tags.names.iter().zip(1..) {
        let facets = solid.tags.facets_of(id);
        let area = |f: &[usize; 3]| {
            let [a, b, c] = f.map(|v| solid.mesh.vertices[v]);
            mesh::measure::triangle_area(a, b, c)
        };
        let mut vertices: Vec<usize> = facets.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        tags.insert(
            name.clone(),
            json!({
                "facets": facets.len(),
                "vertices": vertices.len(),
                "area": facets.iter().map(area).sum::<f64>(),
            }),
        );
    }
    let (low, high) = mesh::measure::bounds(&solid.mesh.vertices);
    json!({
        "name": solid.name,
        "vertices": solid.mesh.vertices.len(),
        "tets": solid.mesh.tets.len(),
        "volume": mesh::measure::volume(&solid.mesh),
        "bounds": [<[f64; 3]>::from(low), <[f64; 3]>::from(high)],
        "tags": tags,
    })
}
