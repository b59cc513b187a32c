//! Tetrahedra in named volumes: those whose centroid a selection holds.

use anyhow::{Context as _, Result, ensure};
use log::{info, warn};
use mesh::measure::tet_volume;
use mesh::{TetMesh, Vec3, Volumes};
use program::Unusable;

use crate::config::{Config, Volume};
use crate::facets::Facets;
use crate::select::{Selector, Sources};

/// The volume of each tetrahedron; those in no selection are called as before, and all are none
/// where the file has no `[[volume]]`.
pub fn assign(
    config: &Config,
    mesh: &TetMesh,
    before: &Volumes,
    facets: &Facets,
    sources: &mut Sources,
) -> Result<Volumes> {
    if config.volume.is_empty() {
        return Ok(before.clone());
    }
    let mut owners: Vec<Option<usize>> = vec![None; mesh.tets.len()];
    for (index, volume) in config.volume.iter().enumerate() {
        let mut build = || volume.selection()?.build(sources);
        let selector = build().with_context(|| label(volume))?;
        let held = held(&*selector, mesh, sources.epsilon);
        ensure!(
            !held.tets.is_empty(),
            Unusable(format!(
                "{}: no centroid of a tetrahedron is in it: {}",
                label(volume),
                selector.advice(facets, sources)
            ))
        );
        let shared: Vec<usize> =
            held.tets.iter().copied().filter(|&t| owners[t].is_some()).collect();
        if let Some(other) = shared.first().and_then(|&t| owners[t]) {
            return Err(Unusable(format!(
                "{} and {} overlap: {} tetrahedra, {:.3} mm³, are in both; volumes may have faces in \
                 common only",
                label(&config.volume[other]),
                label(volume),
                shared.len(),
                1e9 * size(mesh, &shared)
            ))
            .into());
        }
        held.tets.iter().for_each(|&t| owners[t] = Some(index));
        info!(
            "volume {}: {} tetrahedra, {:.3} mm³",
            volume.name,
            held.tets.len(),
            1e9 * size(mesh, &held.tets)
        );
        if held.crossing > 0 {
            warn!(
                "volume {}: {} tetrahedra cross its surface by more than epsilon, by up to {:.3e} m: it \
                 is rough there; to make the mesh follow its surface: cad2fem tetmesh --inside FILE",
                volume.name, held.crossing, held.depth
            );
        }
    }
    Ok(named(config, &owners, before))
}

/// Names of the file, then those that tetrahedra without a selection had.
fn named(config: &Config, owners: &[Option<usize>], before: &Volumes) -> Volumes {
    let mut names: Vec<String> = config.volume.iter().map(|v| v.name.clone()).collect();
    let rest = |t: usize| before.of.get(t).map_or(mesh::io::msh::BODY, |&i| &before.names[i]);
    let mut place = |name: &str| {
        names.iter().position(|n| n == name).unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        })
    };
    let of = owners.iter().enumerate();
    let of = of.map(|(t, owner)| owner.unwrap_or_else(|| place(rest(t)))).collect();
    Volumes { names, of }
}

/// What a selection holds, and how well the mesh follows its surface.
struct Held {
    tets: Vec<usize>,
    /// Tetrahedra that have corners on both sides of it, farther than ε.
    crossing: usize,
    /// How far the nearer of both sides is from it [m].
    depth: f64,
}

fn held(selector: &dyn Selector, mesh: &TetMesh, epsilon: f64) -> Held {
    let mut held = Held { tets: Vec::new(), crossing: 0, depth: 0.0 };
    for t in 0..mesh.tets.len() {
        let corners = mesh.corners(t);
        let centroid = corners.iter().sum::<Vec3>() / 4.0;
        let distance = |p: &Vec3| selector.signed_distance(p).expect("a volume has an inside");
        if distance(&centroid) <= 0.0 {
            held.tets.push(t);
        }
        let distances = corners.map(|p| distance(&p));
        let inward = distances.iter().fold(0.0_f64, |a, d| a.max(-d));
        let outward = distances.iter().fold(0.0_f64, |a, &d| a.max(d));
        if inward.min(outward) > epsilon {
            held.crossing += 1;
            held.depth = held.depth.max(inward.min(outward));
        }
    }
    held
}

fn size(mesh: &TetMesh, tets: &[usize]) -> f64 {
    let volume = |&t: &usize| {
        let [a, b, c, d] = mesh.corners(t);
        tet_volume(a, b, c, d)
    };
    tets.iter().map(volume).sum()
}

fn label(volume: &Volume) -> String {
    format!("[[volume]] `{}`", volume.name)
}
