//! Fragments and spikes: tetrahedra that a mesher leaves where they do not belong.
//!
//! Fragments are connected to the body by an edge or a vertex only. A mesher that makes its
//! boundary manifold separates them from the body into components of their own. Components of
//! negligible volume are removed.
//!
//! A spike hangs on the body by one facet; its other three meet at a tip that belongs to it
//! alone. Corners of a body are like that, too, but high: what is lower than the envelope is none.
//! fTetWild left one 0.05 mm high in a chamber; to a mold it is a wall of 0.02 mm.

use mesh::measure::{tet_volume, triangle_area};
use mesh::topology::{DisjointSets, TET_FACETS, boundary, edge_facets, pinched_vertices};
use mesh::{TetMesh, Vec3, first_at_place};

/// Largest volume of a fragment, relative to that of the mesh [1].
const MAX_VOLUME: f64 = 1e-4;

/// How often what is left is looked at again.
const ROUNDS: usize = 20;

/// Removes the pieces of `mesh`, connected over facets, that have less than 10⁻⁴ of
/// its volume. Returns the number of tetrahedra removed.
pub fn remove_fragments(mesh: &mut TetMesh) -> usize {
    let piece_of = pieces(&mesh.tets);
    let mut volumes = vec![0.0; mesh.tets.len()];
    for (t, &piece) in piece_of.iter().enumerate() {
        volumes[piece] += mesh.volume(t);
    }
    let least = MAX_VOLUME * volumes.iter().sum::<f64>();
    keep(mesh, |t| volumes[piece_of[t]] >= least)
}

/// Keeps some of the tetrahedra, with the vertices that they use. Returns how many go.
fn keep(mesh: &mut TetMesh, kept: impl Fn(usize) -> bool) -> usize {
    let before = mesh.tets.len();
    let tets: Vec<_> = (0..before).filter(|&t| kept(t)).map(|t| mesh.tets[t]).collect();
    if tets.len() < before {
        *mesh = mesh.with_tets(&tets);
    }
    before - mesh.tets.len()
}

/// Removes the spikes whose tip is less than `height` [m] above the facet on which they hang.
/// Returns how many.
pub fn remove_spikes(mesh: &mut TetMesh, height: f64) -> usize {
    let boundary = boundary(mesh);
    let mut free = vec![Vec::new(); mesh.tets.len()];
    for (facet, &tet) in boundary.facets.iter().zip(&boundary.tet_of) {
        free[tet].push(*facet);
    }
    let is_spike = |tet: usize| {
        let [a, b, c] = &free[tet][..] else { return false };
        let tip = a.iter().find(|v| b.contains(v) && c.contains(v));
        let base = mesh.corners(tet);
        tip.is_some_and(|&tip| height_above(mesh.vertices[tip], base) < height)
    };
    let spikes: Vec<bool> = (0..mesh.tets.len()).map(is_spike).collect();
    keep(mesh, |t| !spikes[t])
}

/// Removes, where the boundary touches itself in a vertex or an edge only, the tetrahedra of all but
/// the largest group around it. A mesher may have doubled such vertices: those at the same place are
/// made one first. Returns how many tetrahedra.
pub fn open_pinches(mesh: &mut TetMesh) -> usize {
    let before = mesh.tets.len();
    merge_equal(mesh);
    for _ in 0..ROUNDS {
        let facets = boundary(mesh).facets;
        let edges = edge_facets(&facets);
        let crowded = edges.iter().filter(|(_, beside)| beside.len() > 2);
        let mut touching: Vec<Vec<usize>> = crowded.map(|(edge, _)| edge.to_vec()).collect();
        touching.extend(pinched_vertices(&facets).into_iter().map(|v| vec![v]));
        let mut kept = vec![true; mesh.tets.len()];
        for place in &touching {
            for t in smaller_groups(mesh, place) {
                kept[t] = false;
            }
        }
        if keep(mesh, |t| kept[t]) == 0 {
            break; // nothing touches, or two cavities do
        }
    }
    before - mesh.tets.len()
}

/// Makes one vertex of those at the same place; a tetrahedron with two corners in one goes.
fn merge_equal(mesh: &mut TetMesh) {
    let id = first_at_place(&mesh.vertices);
    let mut tets: Vec<[usize; 4]> = mesh.tets.iter().map(|tet| tet.map(|v| id[v])).collect();
    tets.retain(|tet| (1..4).all(|i| !tet[..i].contains(&tet[i])));
    *mesh = mesh.with_tets(&tets);
}

/// The tetrahedra with all of the vertices but for the largest group that facets connect.
fn smaller_groups(mesh: &TetMesh, vertices: &[usize]) -> Vec<usize> {
    let around: Vec<usize> = (0..mesh.tets.len())
        .filter(|&t| vertices.iter().all(|v| mesh.tets[t].contains(v)))
        .collect();
    let tets: Vec<[usize; 4]> = around.iter().map(|&t| mesh.tets[t]).collect();
    let group = pieces(&tets);
    let mut volume = vec![0.0; tets.len()];
    for (&g, &t) in group.iter().zip(&around) {
        volume[g] += mesh.volume(t);
    }
    let largest = (0..tets.len()).max_by(|&a, &b| volume[a].total_cmp(&volume[b]));
    let smaller = around.into_iter().zip(group).filter(|&(_, g)| Some(g) != largest);
    smaller.map(|(t, _)| t).collect()
}

/// Height of a corner of a tetrahedron above the other three.
fn height_above(tip: Vec3, corners: [Vec3; 4]) -> f64 {
    let base: Vec<Vec3> = corners.into_iter().filter(|&corner| corner != tip).collect();
    let [a, b, c] = base[..] else { return 0.0 };
    3.0 * tet_volume(a, b, c, tip).abs() / triangle_area(a, b, c)
}

/// For each tetrahedron the smallest one that is connected to it over facets.
fn pieces(tets: &[[usize; 4]]) -> Vec<usize> {
    let mut sides: Vec<_> = (0..tets.len())
        .flat_map(|t| TET_FACETS.map(|f| (mesh::facet_key(f.map(|c| tets[t][c])), t)))
        .collect();
    sides.sort_unstable();
    let mut pieces = DisjointSets::new(tets.len());
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        pieces.join(pair[0].1, pair[1].1);
    }
    (0..tets.len()).map(|t| pieces.representative(t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_spike_is_removed_and_a_corner_stays() {
        // a bipyramid, with a tetrahedron on one of its facets
        let spike = |height: f64| {
            let mut vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::z()];
            vertices.push(Vec3::repeat((1.0 + height * 3.0_f64.sqrt()) / 3.0));
            TetMesh { vertices, tets: vec![[0, 1, 2, 3], [0, 2, 1, 4], [1, 2, 3, 5]] }
        };
        let mut low = spike(0.05);
        assert_eq!(remove_spikes(&mut low, 0.06), 1);
        assert_eq!((low.vertices.len(), low.tets.len()), (5, 2));
        assert_eq!(remove_spikes(&mut spike(0.05), 0.04), 0);
        // its lower tip is 1 above its facet
        assert_eq!(remove_spikes(&mut low, 0.9), 0);
        assert_eq!(remove_spikes(&mut low, 1.1), 2);
    }

    #[test]
    fn what_touches_in_a_vertex_is_taken_off() {
        // three in a row, and a small one that touches the first in a corner
        let mut vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::z()];
        vertices.extend([Vec3::x(), Vec3::y(), Vec3::z()].map(|v| v * -0.1 + Vec3::x() * 1.2));
        let mut mesh = TetMesh { vertices, tets: vec![[0, 1, 2, 3], [0, 2, 1, 4], [1, 5, 7, 6]] };
        assert_eq!(open_pinches(&mut mesh), 1);
        assert_eq!((mesh.vertices.len(), mesh.tets.len()), (5, 2));
        assert_eq!(open_pinches(&mut mesh), 0);

        // two that share an edge, whose vertices a mesher has doubled
        let mut vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        vertices.extend([Vec3::zeros(), Vec3::x(), -Vec3::y() * 0.1, -Vec3::z() * 0.1]);
        let mut mesh = TetMesh { vertices, tets: vec![[0, 1, 2, 3], [4, 5, 6, 7]] };
        assert_eq!(open_pinches(&mut mesh), 1);
        assert_eq!(mesh.tets, vec![[0, 1, 2, 3]]);
    }

    #[test]
    fn a_small_piece_at_a_vertex_is_removed_and_a_large_one_stays() {
        let corner = |s: f64| [Vec3::zeros(), Vec3::x() * s, Vec3::y() * s, Vec3::z() * s];
        let mut vertices = corner(1.0).to_vec();
        vertices.push(Vec3::repeat(1.0));
        vertices.extend(corner(-0.01).map(|v| v + Vec3::x()));
        vertices.extend(corner(0.5).map(|v| v + Vec3::x() * 3.0));
        let tets = vec![[5, 7, 6, 8], [0, 1, 2, 3], [1, 2, 3, 4], [9, 10, 11, 12]];
        let mut mesh = TetMesh { vertices, tets };
        assert_eq!(remove_fragments(&mut mesh), 1);
        assert_eq!(mesh.vertices.len(), 9);
        assert_eq!(mesh.tets, vec![[0, 1, 2, 3], [1, 2, 3, 4], [5, 6, 7, 8]]);
        assert_eq!(remove_fragments(&mut mesh), 0);
    }
}
