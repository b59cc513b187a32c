//! `tagger transfer`: carry tags to a mesh with the same boundary.
//!
//! Between levels the interior is remeshed while the boundary, facets inside with a tag and those
//! between volumes stay as they are, bit for bit. Facets are therefore matched by the exact positions of
//! their vertices; anything else is an error, never a nearest neighbour.

mod inside;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use log::info;
use mesh::{Tags, TetMesh, Vec3, facet_key, io, topology};

use self::inside::Inside;
use crate::select::point;

/// Copies the tags of one mesh to another whose boundary is exactly the same.
#[derive(clap::Args)]
pub struct Args {
    /// Tagged mesh to copy from.
    tagged: PathBuf,
    /// Mesh to tag.
    volume: PathBuf,
    /// Tagged mesh to write; tags.txt and tags.json appear beside it.
    #[arg(short, long)]
    output: PathBuf,
}

/// Runs `tagger transfer`.
pub fn run(args: &Args) -> Result<()> {
    let old = io::read_tets(&args.tagged)?;
    let new = io::read_tets(&args.volume)?;
    ensure!(
        !old.tags.facets.is_empty(),
        "{}: no tagged facets; make them with: tagger tag",
        args.tagged.display()
    );
    let mut tags = transfer(&old.mesh, &old.tags, &new.mesh)
        .with_context(|| differ(&args.tagged, &args.volume))?;
    let inside = Inside::new(&old.mesh, &old.tags);
    inside.transfer(&new.mesh, &mut tags).with_context(|| {
        format!("{} and {} differ inside", args.tagged.display(), args.volume.display())
    })?;
    info!("{} tagged facets carried over", tags.facets.len());
    super::write_tagged(&args.output, &new.mesh, &tags)
}

fn differ(old: &Path, new: &Path) -> String {
    format!("{} and {} do not have the same boundary", old.display(), new.display())
}

/// The tags of `old` on `new`, whose boundary must be the same.
fn transfer(old: &TetMesh, tags: &Tags, new: &TetMesh) -> Result<Tags> {
    let (old_facets, new_facets) = (topology::boundary(old).facets, topology::boundary(new).facets);
    ensure!(
        old_facets.len() == new_facets.len(),
        "{} boundary facets against {}; tag the new mesh from its selections instead: tagger tag",
        old_facets.len(),
        new_facets.len()
    );
    let old_vertices = by_position(old, &old_facets)?;
    let mut old_facets: Vec<_> = old_facets.into_iter().map(facet_key).collect();
    old_facets.sort_unstable();
    let mut carried = Tags::new(tags.names.clone());
    let mut unmatched = Vec::new();
    for facet in new_facets {
        let corners = facet.map(|v| old_vertices.get(&bits(&new.vertices[v])).copied());
        let twin = match corners {
            [Some(a), Some(b), Some(c)] => Some(facet_key([a, b, c])),
            _ => None,
        };
        match twin.filter(|twin| old_facets.binary_search(twin).is_ok()) {
            Some(twin) => {
                if let Some(id) = tags.get(twin) {
                    carried.set(facet, id);
                }
            }
            None => unmatched.push(facet),
        }
    }
    if let Some(first) = unmatched.first() {
        bail!(
            "{} of {} boundary facets have no exact twin, first the one at {} m\n  \
             tags are carried only over an unchanged boundary; tag the new mesh from its \
             selections instead: tagger tag",
            unmatched.len(),
            old_facets.len(),
            point(&new.vertices[first[0]])
        );
    }
    Ok(carried)
}

/// Boundary vertices by the bits of their position.
fn by_position(mesh: &TetMesh, facets: &[[usize; 3]]) -> Result<BTreeMap<[u64; 3], usize>> {
    let mut map = BTreeMap::new();
    for &v in facets.iter().flatten() {
        let p = &mesh.vertices[v];
        if map.insert(bits(p), v).is_some_and(|other| other != v) {
            bail!("two boundary vertices of the tagged mesh are both at {} m", point(p));
        }
    }
    Ok(map)
}

/// The bits of a position; adding zero makes −0 and 0 the same.
fn bits(p: &Vec3) -> [u64; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}
