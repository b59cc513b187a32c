//! Scenes of PolyFEM translated to ours.
//!
//! Reads the JSON files that were published with Gjoka et al. 2024: a state
//! (bodies, materials, loads, contact, time) or a run (an optimisation of a
//! state). Every key is either read here or listed with the reason why not.
//!
//! What is different there:
//!
//! - the pressure of gas is minus ours, `rhs` is minus our gravity;
//! - of selections, the first that holds for a facet counts;
//! - loads are evaluated at the end of a time step, lists at times rounded to 1 ms;
//! - a list of surfaces has ids: the tag of id 2 is `s2`, that of facets which
//!   nothing selects `unselected`;
//! - a plane scene is one of depth 1 m, ours a slab of another thickness: see
//!   `planar`. Displacements are the same, energies and forces are in
//!   proportion to the thickness.

mod design;
mod document;
mod geometry;
mod loads;
mod material;
mod planar;
mod scene;
mod selection;
mod text;
mod value;
mod write;

use std::path::{Path, PathBuf};

use ::scene::config::{ContactForm, DesignConfig, SimConfig, beside};
use anyhow::{Context, Result, bail};
use program::Settings;

use self::design::Design;
use self::document::Document;
use self::scene::Translated;

/// What the file does not say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The form of the contact potential, whatever the file says.
    pub form: Option<ContactForm>,
    /// Thickness of the slabs of a plane scene [m]; if not given, a tenth of the
    /// mean length of the edges of the body where it is smallest.
    pub thickness: Option<f64>,
}

/// Patterns of keys that have no part in our scene, and why.
type Reasons = &'static [(&'static str, &'static str)];

/// A scene in our words.
pub struct Imported {
    documents: Vec<(Document, Reasons)>,
    scene: Translated,
    design: Option<Design>,
}

/// Reads a state or a run file and everything that it names.
pub fn read(path: &Path, options: &Options) -> Result<Imported> {
    if let Some(thickness) = options.thickness
        && !(thickness > 0.0 && thickness.is_finite())
    {
        bail!("thickness = {thickness} m: must be positive and finite");
    }
    let document = Document::read(path)?;
    if document.root().get("geometry").is_some() {
        let scene = scene::read(&document, false, options)?;
        return Imported::checked(vec![(document, scene::REASONS)], scene, None);
    }
    let Some(states) = document.root().get("states") else {
        bail!(
            "{}: neither \"geometry\", as in the file of a scene, nor \"states\", as in that of an \
             optimisation",
            path.display()
        );
    };
    let all = states.items();
    let [state] = &all[..] else {
        return Err(states.wrong(&format!("{} scenes; expected one", all.len())));
    };
    let key = state.need("path", "the file of the scene")?;
    let (place, moved) = find(path, Path::new(key.text()?)).ok_or_else(|| {
        key.wrong(&format!(
            "there is no file {}",
            beside(path, Path::new(&key.value.to_string())).display()
        ))
    })?;
    let inner = Document::read(&place)?;
    let mut scene = scene::read(&inner, true, options)?;
    if moved {
        scene.notes.push(format!(
            "{}: {}: {} is not there; taken is {}",
            path.display(),
            key.pointer,
            key.value,
            place.display()
        ));
    }
    let design = design::read(&document, &mut scene)?;
    let documents = vec![(document, design::REASONS), (inner, scene::REASONS)];
    Imported::checked(documents, scene, design)
}

/// A file as seen from another, or beside it if it is not where it should be.
fn find(from: &Path, path: &Path) -> Option<(PathBuf, bool)> {
    let place = beside(from, path);
    if place.is_file() {
        return Some((place, false));
    }
    let here = beside(from, Path::new(path.file_name()?));
    here.is_file().then_some((here, true))
}

impl Imported {
    /// Makes sure that our programs can read it.
    fn checked(
        documents: Vec<(Document, Reasons)>,
        scene: Translated,
        design: Option<Design>,
    ) -> Result<Self> {
        let context = || format!("{}: the scene that it describes", documents[0].0.path.display());
        let config = SimConfig::of(&Settings::of_text(&scene.text)).with_context(context)?;
        for body in config.bodies().with_context(context)? {
            body.material.specification().with_context(context)?;
        }
        for solid in &scene.geometry.solids {
            if let Some(finding) = mesh::check::check_tets(&solid.mesh).first() {
                bail!("{}: body \"{}\": {}", context(), solid.name, finding.message);
            }
        }
        if let Some(design) = &design {
            let text = &design.text;
            // without a term there is no list, which is for the user to see
            if text.contains("[[objective]]") {
                let _: DesignConfig = toml::from_str(text).with_context(context)?;
            }
        }
        Ok(Self { documents, scene, design })
    }
}

#[cfg(test)]
mod tests;
