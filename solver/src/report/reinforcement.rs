//! The file of the threads of a state.

use std::path::Path;

use anyhow::Result;
use mechanics::energy::{self, Energies, Iterate, Strand};
use reports::{Segment, SegmentEnd, WINDINGS};
use scene::Scene;

use super::table;

/// Writes the threads of a state to a folder, if there are any.
pub fn write_threads(
    folder: &Path,
    scene: &Scene,
    energies: &Energies,
    at: &Iterate,
) -> Result<()> {
    if scene.config.winding.is_empty() {
        return Ok(());
    }
    let mut rows = vec![Segment::head()];
    for (winding, thread) in scene.config.winding.iter().zip(energies.each::<energy::Winding>()) {
        rows.extend(thread.strands(at).iter().map(|strand| segment(&winding.name, strand).row()));
    }
    table::write(&folder.join(WINDINGS), rows)
}

fn segment(winding: &str, strand: &Strand) -> Segment {
    let end = |k: usize| SegmentEnd {
        rest: strand.rest[k].into(),
        now: (strand.rest[k] + strand.moved[k]).into(),
        weights: strand.weights[k],
    };
    Segment {
        winding: winding.to_owned(),
        ends: [end(0), end(1)],
        force: strand.force,
        vertices: strand.vertices,
    }
}
