//! Interior vertices are removed where they crowd and added where they lack.

use super::complex::Complex;
use super::smooth::{relocate, worst_about};
use crate::topology::TET_FACETS;
use crate::{Vec3, facet_key};

/// Most tetrahedra that are replaced around a new vertex.
const CAVITY: usize = 40;

/// A new vertex must make the worst shape better by this factor.
const GAIN: f64 = 1.2;

/// Contracts edges of the tetrahedra with a shape below `limit` where that makes
/// the worst tetrahedron about the removed vertex better; returns their number.
pub(super) fn contract(complex: &mut Complex, limit: f64) -> usize {
    let mut removed = 0;
    for t in complex.worse_than(limit) {
        let Some(tet) = complex.tet(t) else { continue };
        let mut directed = tet.iter().flat_map(|&v| tet.iter().map(move |&w| (v, w)));
        let done = directed.any(|(v, w)| {
            v != w && complex.can_remove(v) && {
                let new = contracted(complex, v, w);
                complex.remove_if_better(v, &new)
            }
        });
        removed += usize::from(done);
    }
    removed
}

/// The tetrahedra about `v` once it has been moved onto its neighbour `w`.
pub(super) fn contracted(complex: &Complex, v: usize, w: usize) -> Vec<[usize; 4]> {
    let link = complex.link(v).into_iter();
    link.filter(|facet| !facet.contains(&w)).map(|[a, b, c]| [a, b, c, w]).collect()
}

/// Adds vertices to the tetrahedra with a shape below `limit` where that makes the
/// worst of those they replace better; returns their number.
pub(super) fn insert(complex: &mut Complex, limit: f64) -> usize {
    let mut added = 0;
    for t in complex.worse_than(limit) {
        let Some(tet) = complex.tet(t) else { continue };
        // A tetrahedron may have taken the number of one that has been replaced.
        if complex.shape(t) >= limit {
            continue;
        }
        if let Some((cavity, place)) = best_cavity(complex, t, tet) {
            let facets: Vec<_> = cavity.facets.iter().map(|&(facet, _)| facet).collect();
            let accepted = complex.insert_if_better(place, &cavity.tets, &facets, GAIN);
            added += usize::from(accepted);
        }
    }
    added
}

/// Tetrahedra to be replaced by those between their boundary and a new vertex.
#[derive(Clone)]
struct Cavity {
    tets: Vec<usize>,
    /// Facets around the cavity facing inward, each with its tetrahedron inside.
    facets: Vec<([usize; 3], usize)>,
}

/// The cavity about a tetrahedron, with the place of the new vertex, for which the
/// worst of the new tetrahedra is best; none if none is better than now.
///
/// The cavity grows across its worst facet, and with it the place adapts.
fn best_cavity(complex: &Complex, t: usize, tet: [usize; 4]) -> Option<(Cavity, Vec3)> {
    let mut place = tet.iter().map(|&v| complex.points[v]).sum::<Vec3>() / 4.0;
    let mut cavity = Cavity { tets: vec![t], facets: inward_facets(tet, t).to_vec() };
    let mut best = None;
    let mut record = 0.0;
    while cavity.tets.len() < CAVITY {
        let link: Vec<_> =
            cavity.facets.iter().map(|&(f, _)| f.map(|v| complex.points[v])).collect();
        place = relocate(&link, place);
        let worst = worst_about(&link, &place);
        if worst > record && worst > GAIN * complex.worst(&cavity.tets) {
            record = worst;
            best = Some((cavity.clone(), place));
        }
        let Some(larger) = grown(complex, &cavity, &place) else { break };
        cavity = larger;
    }
    best
}

/// The cavity with the tetrahedron beyond its worst facet, or beyond the next worst
/// if that does not help.
fn grown(complex: &Complex, cavity: &Cavity, place: &Vec3) -> Option<Cavity> {
    let shape = |f: [usize; 3]| worst_about(&[f.map(|v| complex.points[v])], place);
    let mut order: Vec<_> =
        cavity.facets.iter().map(|&(facet, owner)| (shape(facet), facet, owner)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().find_map(|(worst, facet, owner)| {
        let t = complex.across(owner, facet)?;
        let tet = complex.tet(t)?;
        let mut larger = cavity.clone();
        larger.tets.push(t);
        for (new, owner) in inward_facets(tet, t) {
            let is_same = |(f, _): &([usize; 3], usize)| facet_key(*f) == facet_key(new);
            if let Some(shared) = larger.facets.iter().position(is_same) {
                if complex.is_kept(new) {
                    return None;
                }
                larger.facets.swap_remove(shared);
            } else if shape(new) > worst.max(0.0) {
                larger.facets.push((new, owner));
            } else {
                return None;
            }
        }
        // No vertex may end up inside.
        let is_kept = |v: &usize| larger.facets.iter().any(|(f, _)| f.contains(v));
        tet.iter().all(is_kept).then_some(larger)
    })
}

fn inward_facets(tet: [usize; 4], t: usize) -> [([usize; 3], usize); 4] {
    TET_FACETS.map(|[a, b, c]| ([tet[a], tet[c], tet[b]], t))
}
