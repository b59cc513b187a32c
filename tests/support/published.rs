//! Bodies that were published with Gjoka et al. 2024, where they are installed.

use std::collections::BTreeMap;
use std::path::Path;

use mechanics::body::Body;
use mesh::{Tags, TetMesh, Vec3};

use crate::shared;

/// Where they are beside the repository.
pub const FOLDER: &str = "data/pneumatic-actuator-design";

/// Ids of the chambers of the worm, from its end at −x.
pub const WORM_CHAMBERS: [u32; 10] = [2, 3, 4, 5, 6, 7, 8, 9, 10, 11];

/// The gripper in metres. Tags: `fixed`, `cavity`, `outer`, `grip`.
pub fn gripper() -> Option<Body> {
    let mesh = published("gripper_bellows/gripper_bellows_thick.msh", 1e-3)?;
    let selections = shared(&format!("{FOLDER}/gripper_bellows/surface_selections_thick.txt"))?;
    let mut tags = Tags::new(["fixed", "cavity", "outer", "grip"].map(str::to_owned).to_vec());
    tags.facets = first_ids(&selections);
    Some(Body::new(mesh, tags))
}

/// The worm in metres, along x. Tags: `end` at −x, `chamber 2` to `chamber 11`,
/// and `skin` for the rest.
pub fn worm() -> Option<Body> {
    let mesh = published("worm/worm_long_clean.msh", 0.02)?;
    let ids = first_ids(&shared(&format!("{FOLDER}/worm/surface_selections_long.txt"))?);
    let low = mesh.vertices.iter().map(|v| v.x).fold(f64::INFINITY, f64::min);
    let high = mesh.vertices.iter().map(|v| v.x).fold(f64::NEG_INFINITY, f64::max);
    let at_end = |v: Vec3| v.x < low + 0.02 * (high - low);
    let mut names = vec!["end".to_owned(), "skin".to_owned()];
    names.extend(WORM_CHAMBERS.map(|id| format!("chamber {id}")));
    let mut tags = Tags::new(names);
    for facet in mesh::topology::boundary(&mesh).facets {
        let chamber = ids.get(&mesh::facet_key(facet)).filter(|id| WORM_CHAMBERS.contains(id));
        let tag = match chamber {
            // the chambers follow the first two names in the order of their ids
            Some(id) => id - WORM_CHAMBERS[0] + 3,
            None if facet.iter().all(|&v| at_end(mesh.vertices[v])) => 1,
            None => 2,
        };
        tags.set(facet, tag);
    }
    Some(Body::new(mesh, tags))
}

fn published(file: &str, scale: f64) -> Option<TetMesh> {
    let path = shared(&format!("{FOLDER}/{file}"))?;
    let mut mesh = mesh::io::read_tets(&path).expect("a published mesh").mesh;
    mesh.vertices.iter_mut().for_each(|v| *v *= scale);
    Some(mesh)
}

/// The first id that a list of selections, `id a b c` per line, gives each facet.
fn first_ids(path: &Path) -> BTreeMap<[usize; 3], u32> {
    let mut first = BTreeMap::new();
    for line in std::fs::read_to_string(path).expect("published selections").lines() {
        let n: Vec<usize> =
            line.split_whitespace().map(|w| w.parse().expect("whole numbers")).collect();
        let id = u32::try_from(n[0]).expect("a small id");
        first.entry(mesh::facet_key([n[1], n[2], n[3]])).or_insert(id);
    }
    first
}
