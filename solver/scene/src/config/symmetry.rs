//! `[[symmetry]]`: a plane in which bodies are cut that are a part of symmetric ones.

use anyhow::{Result, ensure};
use program::{KeyPath, Names};

use super::SimConfig;
use crate::meaning::cut;

program::table! {
    /// A plane of symmetry.
    #[derive(Clone, Debug)]
    pub struct SymmetryConfig {
        /// Tags of the cut, all of which lie in the plane.
        on: Names;
    }
}

impl SimConfig {
    /// Tags of the cut in each plane of symmetry.
    pub fn cuts(&self) -> Vec<Vec<String>> {
        self.symmetry.iter().map(|plane| plane.on.all().to_vec()).collect()
    }

    /// No surface of the whole is where a part is cut.
    pub(super) fn check_symmetry(&self) -> Result<()> {
        let cuts = self.cuts();
        for (i, tags) in cuts.iter().enumerate() {
            let title = KeyPath::list("symmetry");
            let empty =
                title.clone().number(i + 1).told("[[symmetry]]: on = []: name the tags of the cut");
            ensure!(!tags.is_empty(), empty);
            for tag in tags {
                ensure!(
                    cuts[..i].iter().all(|others| !others.contains(tag)),
                    title
                        .number(i + 1)
                        .told(format!("two [[symmetry]] are on \"{tag}\": keep one"))
                );
                let chamber = self.chamber.iter().any(|c| c.is_on(tag)).then_some("[[chamber]]");
                let traction = self.traction.iter().any(|t| t.on == *tag).then_some("[[traction]]");
                if let Some(load) = chamber.or(traction) {
                    anyhow::bail!(cut(tags).told(format!(
                        "{}: {load} is on the same tag, but there is no surface where the whole body \
                         is cut; expected a tag of its own for each",
                        mechanics::symmetry::title(tags)
                    )));
                }
            }
        }
        Ok(())
    }
}
