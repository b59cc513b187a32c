//! Topological changes among fixed vertices: edges and facets are exchanged.

use super::complex::Complex;
use crate::topology::{TET_EDGES, TET_FACETS};

/// Tetrahedra about an edge that is considered for removal, at most.
const RING: usize = 8;

/// Tries to remove each edge and each facet of the tetrahedra with a shape below
/// `limit` near which something changed since the time `since`; returns the number
/// of changes.
pub(super) fn flip(complex: &mut Complex, limit: f64, since: usize) -> usize {
    let mut changes = 0;
    for t in complex.worse_than(limit) {
        let Some(tet) = complex.tet(t) else { continue };
        if !tet.iter().any(|&v| complex.changed_since(v, since)) {
            continue;
        }
        let edges = TET_EDGES.map(|e| e.map(|k| tet[k]));
        let facets = TET_FACETS.map(|f| f.map(|k| tet[k]));
        let changed = edges.iter().any(|&[a, b]| remove_edge(complex, a, b))
            || (0..4).any(|k| remove_facet(complex, t, facets[k], tet[k]));
        changes += usize::from(changed);
    }
    changes
}

/// Replaces the facet abc between d and e by the edge de (flip 2-3) if that makes
/// the worst tetrahedron better.
fn remove_facet(complex: &mut Complex, t: usize, facet: [usize; 3], d: usize) -> bool {
    let Some(s) = complex.across(t, facet) else { return false };
    let Some(other) = complex.tet(s) else { return false };
    let Some(&e) = other.iter().find(|v| !facet.contains(v)) else { return false };
    let [a, b, c] = facet;
    let new = [[d, e, a, b], [d, e, b, c], [d, e, c, a]];
    complex.replace_if_better(&[t, s], &new, 1.0)
}

/// Replaces the tetrahedra about the edge ab (flips 3-2, 4-4, 5-6, ...) by those
/// between a, b and the best triangulation of the ring about it, if that makes
/// the worst tetrahedron better.
fn remove_edge(complex: &mut Complex, a: usize, b: usize) -> bool {
    let star = complex.edge_star(a, b);
    if star.len() > RING {
        return false;
    }
    let Some(ring) = ring(complex, &star, a, b) else { return false };
    let new: Vec<[usize; 4]> = best_triangulation(complex, &ring, a, b)
        .into_iter()
        .flat_map(|[i, k, j]| [[i, k, j, b], [i, j, k, a]])
        .collect();
    complex.replace_if_better(&star, &new, 1.0)
}

/// The vertices around the edge ab, counter-clockwise about the direction from a
/// to b; none if the edge lies on the boundary.
fn ring(complex: &Complex, star: &[usize], a: usize, b: usize) -> Option<Vec<usize>> {
    let sides: Vec<[usize; 2]> =
        star.iter().filter_map(|&t| complex.tet(t)).map(|tet| opposite_edge(tet, a, b)).collect();
    let ring = chain(&sides, sides.first()?[0], sides.len())?;
    let closing = [*ring.last()?, ring[0]];
    (ring.len() >= 3 && sides.contains(&closing)).then_some(ring)
}

/// The first `count` vertices of the chain of `sides` that begins with `start`.
fn chain(sides: &[[usize; 2]], start: usize, count: usize) -> Option<Vec<usize>> {
    let mut chain = vec![start];
    while chain.len() < count {
        let last = *chain.last()?;
        let [_, next] = *sides.iter().find(|side| side[0] == last)?;
        chain.push(next);
    }
    Some(chain)
}

/// What takes the place of the tetrahedra `star` about the boundary edge ab, in whose facets c
/// and d are opposite it, once it is exchanged for cd: nothing where there is only one. None if
/// that is no exchange.
pub(super) fn without_boundary_edge(
    complex: &Complex,
    star: &[usize],
    [a, b]: [usize; 2],
    [c, d]: [usize; 2],
) -> Option<Vec<[usize; 4]>> {
    if star.len() > RING {
        return None;
    }
    let sides: Vec<[usize; 2]> =
        star.iter().filter_map(|&t| complex.tet(t)).map(|tet| opposite_edge(tet, a, b)).collect();
    let (start, end) = if sides.iter().any(|side| side[0] == c) { (c, d) } else { (d, c) };
    let chain = chain(&sides, start, sides.len() + 1)?;
    if chain.last() != Some(&end) {
        return None;
    }
    let polygons = match chain.len() {
        2 => Vec::new(),
        _ => best_triangulation(complex, &chain, a, b),
    };
    Some(polygons.into_iter().flat_map(|[i, k, j]| [[i, k, j, b], [i, j, k, a]]).collect())
}

/// The other two vertices (c, d) of a tetrahedron on the edge ab, ordered so that
/// (a, b, c, d) is positive.
fn opposite_edge(tet: [usize; 4], a: usize, b: usize) -> [usize; 2] {
    let place = |v: usize| tet.iter().position(|&u| u == v).expect("a vertex of the tetrahedron");
    let (i, j) = (place(a), place(b));
    let rest: Vec<usize> = (0..4).filter(|&k| k != i && k != j).collect();
    let order = [i, j, rest[0], rest[1]];
    let inversions =
        (0..4).flat_map(|x| (0..x).map(move |y| (y, x))).filter(|&(y, x)| order[y] > order[x]);
    let (c, d) = (tet[rest[0]], tet[rest[1]]);
    if inversions.count() % 2 == 0 { [c, d] } else { [d, c] }
}

/// The triangulation of the polygon `ring` whose worst tetrahedron with a or b is
/// best, by dynamic programming over its diagonals (Klincsek 1980).
fn best_triangulation(complex: &Complex, ring: &[usize], a: usize, b: usize) -> Vec<[usize; 3]> {
    let n = ring.len();
    // best[i][j]: worst shape over the polygon from i to j, and its third corner.
    let mut best = vec![vec![(f64::INFINITY, 0); n]; n];
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            let corner = |k: usize| {
                let (u, v, w) = (ring[i], ring[k], ring[j]);
                let above = complex.shape_of([u, v, w, b]);
                let below = complex.shape_of([u, w, v, a]);
                (above.min(below).min(best[i][k].0).min(best[k][j].0), k)
            };
            best[i][j] = (i + 1..j)
                .map(corner)
                .fold((f64::NEG_INFINITY, 0), |x, y| if y.0 > x.0 { y } else { x });
        }
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut stack = vec![(0, n - 1)];
    while let Some((i, j)) = stack.pop() {
        if j - i >= 2 {
            let k = best[i][j].1;
            triangles.push([ring[i], ring[k], ring[j]]);
            stack.extend([(i, k), (k, j)]);
        }
    }
    triangles
}
