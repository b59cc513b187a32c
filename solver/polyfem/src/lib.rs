//! Scenes of PolyFEM translated to ours.
//!
//! Reads the state files in JSON that were published with Gjoka et al. 2024: bodies, materials, loads,
//! contact, time. Every key is either read here or listed with the reason why not.
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

mod document;
mod geometry;
mod loads;
mod material;
mod planar;
mod scene;
mod selection;
mod tables;
mod value;
mod write;

use std::path::Path;

use ::scene::config::{ContactForm, SimConfig};
use anyhow::{Context, Result, bail};

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

/// A scene in our words.
pub struct Imported {
    document: Document,
    scene: Translated,
}

/// Reads a state file and everything that it names.
pub fn read(path: &Path, options: &Options) -> Result<Imported> {
    if let Some(thickness) = options.thickness
        && !(thickness > 0.0 && thickness.is_finite())
    {
        bail!("thickness = {thickness} m: must be positive and finite");
    }
    let document = Document::read(path)?;
    let root = document.root();
    if root.get("geometry").is_none() {
        let optimised = match root.get("states") {
            Some(_) => ", as the \"states\" of this optimisation name one",
            None => "",
        };
        bail!("{}: no \"geometry\": expected the file of a scene{optimised}", path.display());
    }
    let scene = scene::read(&document, options)?;
    Imported { document, scene }.checked()
}

impl Imported {
    /// Makes sure that our programs can read it.
    fn checked(self) -> Result<Self> {
        let context = || format!("{}: the scene that it describes", self.document.path.display());
        let values = SimConfig::settings_of(self.scene.values.clone());
        let config = values.and_then(|values| SimConfig::of(&values)).with_context(context)?;
        for body in config.bodies().with_context(context)? {
            body.material.specification().with_context(context)?;
        }
        for solid in &self.scene.geometry.solids {
            if let Some(finding) = mesh::check::check_tets(&solid.mesh).first() {
                bail!("{}: body \"{}\": {}", context(), solid.name, finding.message);
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests;
