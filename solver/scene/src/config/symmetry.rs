//! `[[symmetry]]`: a plane in which bodies are cut that are a part of symmetric ones.

use anyhow::{Result, ensure};
use program::{KeyPath, Names};

use super::SimConfig;

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

    /// Each plane has tags of its own.
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
            }
        }
        Ok(())
    }
}
