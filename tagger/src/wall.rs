//! Pressure walls: what makes the volume behind a wall well defined.
//!
//! The pressure potential −p V needs a closed volume. A wall that is closed
//! has one; an open wall has one up to a constant if its rim does not move.
//! A quadratic edge has a node between its ends, so it is not enough that the
//! ends are fixed: every edge of the rim must belong to a fixed facet.

use std::collections::BTreeSet;

use mesh::topology;

use crate::config::Config;
use crate::facets::Facets;
use crate::select::place;

/// Adds single facets without a tag that are surrounded by `tag` on all three
/// sides; a pressure wall takes such facets from later tags, too. Returns how many.
///
/// A mesher may move one facet out of the reach of a selection, which would
/// leave a hole of one triangle in the wall.
pub fn fill_pinholes(
    facets: &Facets,
    owners: &mut [Option<usize>],
    tag: usize,
    pressure: bool,
) -> usize {
    let edges = topology::edge_facets(&facets.surface.triangles);
    let surrounded = |f: usize| {
        topology::directed_edges(facets.surface.triangles[f])
            .into_iter()
            .all(|side| edges[&sorted(side)].iter().any(|&n| n != f && owners[n] == Some(tag)))
    };
    let holes: Vec<usize> = (0..facets.len())
        .filter(|&f| owners[f].is_none_or(|owner| pressure && owner > tag) && surrounded(f))
        .collect();
    for &f in &holes {
        owners[f] = Some(tag);
    }
    holes.len()
}

/// Checks that a wall is a manifold patch, closed, plugged or with a fixed rim.
pub fn check(
    facets: &Facets,
    owners: &[Option<usize>],
    wall: usize,
    config: &Config,
) -> Result<(), String> {
    let triangles = owned(facets, owners, wall);
    check_manifold(facets, &triangles)?;
    let loops = topology::boundary_loops(&triangles);
    if loops.is_empty() || config.tag[wall].plug {
        return Ok(());
    }
    let rims = config.tag[wall].rim.all();
    if rims.is_empty() {
        return Err(format!(
            "the pressure wall is open: {} boundary loops{}\n  \
             name the fixed tag that closes it with `rim = \"...\"`, write `plug = true` if a plug moves with \
             it, or select the whole wall",
            loops.len(),
            describe(facets, &loops, &vec![Vec::new(); loops.len()])
        ));
    }
    let held = config.tag.iter().enumerate().filter(|(_, tag)| rims.contains(&tag.name));
    let fixed_edges: BTreeSet<[usize; 2]> = held
        .flat_map(|(tag, _)| owned(facets, owners, tag))
        .flat_map(topology::directed_edges)
        .map(sorted)
        .collect();
    let free: Vec<Vec<usize>> = loops
        .iter()
        .map(|l| edges_of(l).filter(|&e| !fixed_edges.contains(&sorted(e))).map(|e| e[0]).collect())
        .collect();
    let count: usize = free.iter().map(Vec::len).sum();
    if count == 0 {
        return Ok(());
    }
    let rim = rims.join("`, `");
    Err(format!(
        "{count} edges of the rim of the pressure wall do not lie on `{rim}`; {} boundary loops{}\n  \
         a rim that moves leaves the pressure volume undefined; extend `{rim}` up to the wall, \
         or the wall up to `{rim}`;\n  \
         if facets are missing there, the mesher moved them by more than epsilon: raise it",
        loops.len(),
        describe(facets, &loops, &free)
    ))
}

fn check_manifold(facets: &Facets, triangles: &[[usize; 3]]) -> Result<(), String> {
    if topology::is_manifold(triangles) {
        return Ok(());
    }
    let edges = topology::edge_facets(triangles);
    let crowded: Vec<_> = edges.iter().filter(|(_, on)| on.len() > 2).collect();
    let pinched = topology::pinched_vertices(triangles);
    let first = crowded.first().map(|(e, _)| e[0]).or(pinched.first().copied());
    let place = first.map_or(String::new(), |v| {
        format!(", first at vertex {v} at {} m", place(&facets.surface.vertices[v]))
    });
    Err(format!(
        "the pressure wall is not a manifold patch: {} edges with more than two facets, \
         {} vertices where it touches itself{place}\n  \
         mesh more finely there, or select a patch that does not touch itself",
        crowded.len(),
        pinched.len()
    ))
}

/// One line per loop: edges, length, and where it leaves the fixed tag.
fn describe(facets: &Facets, loops: &[Vec<usize>], free: &[Vec<usize>]) -> String {
    let length = |l: &[usize]| -> f64 {
        edges_of(l)
            .map(|[a, b]| (facets.surface.vertices[b] - facets.surface.vertices[a]).norm())
            .sum()
    };
    let place = |v: usize| format!("vertex {v} at {} m", place(&facets.surface.vertices[v]));
    loops
        .iter()
        .zip(free)
        .map(|(l, free)| {
            let what = match free.first() {
                Some(&v) => format!("{} edges not fixed, first {}", free.len(), place(v)),
                None => format!("first {}", place(l[0])),
            };
            format!("\n  loop of {} edges, {:.3} mm, {what}", l.len(), 1e3 * length(l))
        })
        .collect()
}

fn owned(facets: &Facets, owners: &[Option<usize>], tag: usize) -> Vec<[usize; 3]> {
    let triangles = facets.surface.triangles.iter().zip(owners);
    triangles.filter(|(_, owner)| **owner == Some(tag)).map(|(t, _)| *t).collect()
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// The edges of a closed loop of vertices.
fn edges_of(vertices: &[usize]) -> impl Iterator<Item = [usize; 2]> {
    vertices.iter().enumerate().map(|(i, &v)| [v, vertices[(i + 1) % vertices.len()]])
}
