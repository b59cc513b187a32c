//! Orientation of closed shells from how they are nested.

use crate::SurfaceMesh;
use crate::inside::WindingNumber;
use crate::measure::enclosed_volume;
use crate::topology::{components, directed_edges, edge_facets};

/// Turns the triangles of closed, disjoint shells so that they bound a solid:
/// shells at even depth of nesting face outward, those at odd depth, which bound
/// cavities, face inward. Neighbours that wind oppositely are made to agree first.
pub fn orient_by_nesting(surface: &mut SurfaceMesh) {
    let shells = components(&surface.triangles);
    for shell in &shells {
        align_neighbours(surface, shell);
        if enclosed_volume(&surface.part(shell)) < 0.0 {
            flip(surface, shell);
        }
    }
    let inside: Vec<WindingNumber> =
        shells.iter().map(|shell| WindingNumber::new(&surface.part(shell))).collect();
    for (i, shell) in shells.iter().enumerate() {
        let [probe, ..] = surface.corners(shell[0]);
        let others = inside.iter().enumerate().filter(|&(j, _)| j != i);
        let depth = others.filter(|(_, other)| other.contains(&probe)).count();
        if depth % 2 == 1 {
            flip(surface, shell);
        }
    }
}

fn flip(surface: &mut SurfaceMesh, shell: &[usize]) {
    for &t in shell {
        surface.triangles[t].swap(1, 2);
    }
}

/// Turns triangles of a connected shell until all wind like its first one.
fn align_neighbours(surface: &mut SurfaceMesh, shell: &[usize]) {
    let triangles: Vec<_> = shell.iter().map(|&t| surface.triangles[t]).collect();
    let edges = edge_facets(&triangles);
    let mut done = vec![false; triangles.len()];
    let mut front = vec![0];
    done[0] = true;
    while let Some(i) = front.pop() {
        for [a, b] in directed_edges(surface.triangles[shell[i]]) {
            for &j in &edges[&[a.min(b), a.max(b)]] {
                if done[j] {
                    continue;
                }
                done[j] = true;
                front.push(j);
                let neighbour = &mut surface.triangles[shell[j]];
                if directed_edges(*neighbour).contains(&[a, b]) {
                    neighbour.swap(1, 2);
                }
            }
        }
    }
}
