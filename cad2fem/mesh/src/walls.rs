//! Walls of a body: how thin they are, and where.
//!
//! The thickness of a wall at a point of its surface is the length of the straight line through it
//! to a facet that faces the other way, within 60°; where the surface across is tilted
//! more, as near a sharp edge, there is no wall to measure. Nor is there one where the surface leads from one side to the other
//! close by: that is the edge of a body, which noise makes rough, or a spike, which may stand on a thick wall. What is thick
//! beside the whole body, as a block is, is an edge only where facets have a common corner.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::bvh::{SurfaceBvh, closest_on_triangle};
use crate::measure::{diagonal, longest_edge};
use crate::topology::edge_facets;
use crate::{SurfaceMesh, Vec3};

/// Cosine of the greatest angle between a wall's sides that counts as parallel (60°): beyond
/// it is an edge, whose thickness is zero and no fault.
const OPPOSITE: f64 = 0.5;

/// A triangle lower than this says nothing about the direction of its surface [diagonal]: binary STL
/// rounds its corners by 6·10⁻⁸, which turns it by up to 3°.
const NEEDLE: f64 = 2e-6;

/// Walls across less than this part of what another surface has beside them are thinner than it: a
/// judgement. The direction in which a wall is measured may be off by 60°.
const THINNER: f64 = 0.5;

/// Radius of the ball around the middle of a wall within which the surface must not lead around it, over the thickness.
const AROUND: f64 = 2.5;

/// Thickness over the diagonal from which on a wall is thick.
const THICK: f64 = 0.05;

/// Walls of a surface.
struct Walls<'a> {
    surface: &'a SurfaceMesh,
    bvh: SurfaceBvh,
    normals: Vec<Vec3>,
    /// Triangles beside each triangle.
    beside: OnceLock<Vec<Vec<usize>>>,
}

impl<'a> Walls<'a> {
    fn new(surface: &'a SurfaceMesh) -> Self {
        let least = NEEDLE * diagonal(&surface.vertices);
        let normal = |t: usize| {
            let is_needle = 2.0 * surface.area(t) < least * longest_edge(surface.corners(t));
            if is_needle { Vec3::zeros() } else { surface.normal(t) }
        };
        let normals = (0..surface.triangles.len()).map(normal).collect();
        Self { surface, bvh: SurfaceBvh::new(surface), normals, beside: OnceLock::new() }
    }

    /// How far a point on a triangle is from the surface across, and the triangle there: the first
    /// that is not entered again, as its own and its neighbours' are.
    fn across(&self, t: usize, from: &Vec3) -> Option<(f64, usize)> {
        let inward = -self.normals[t];
        if inward == Vec3::zeros() {
            return None;
        }
        let hits = self.bvh.ray(from, &inward);
        hits.into_iter().find(|&(_, hit)| self.normals[hit].dot(&inward) > 0.0)
    }

    /// Triangles with what is across, where that is opposite, and how far it is.
    fn opposite(&self) -> impl ParallelIterator<Item = (f64, [usize; 2])> {
        let wall = |t: usize| {
            let (thickness, across) = self.across(t, &self.surface.centroid(t))?;
            let opposite = -self.normals[t].dot(&self.normals[across]) >= OPPOSITE;
            opposite.then_some((thickness, [t, across]))
        };
        (0..self.surface.triangles.len()).into_par_iter().filter_map(wall)
    }

    /// Whether the surface leads from one triangle to the one across within a ball around the middle between them.
    fn leads_around(&self, thickness: f64, [t, across]: [usize; 2]) -> bool {
        let triangles = &self.surface.triangles;
        let beside = self.beside.get_or_init(|| {
            let mut beside = vec![Vec::new(); triangles.len()];
            for facets in edge_facets(triangles).values() {
                for &f in facets {
                    beside[f].extend(facets.iter().copied().filter(|&g| g != f));
                }
            }
            beside
        });
        let middle = self.surface.centroid(t) - 0.5 * thickness * self.normals[t];
        let is_near = |t: usize| {
            let near = closest_on_triangle(&middle, &self.surface.corners(t));
            (near - middle).norm() <= AROUND * thickness
        };
        let (mut seen, mut pending) = (BTreeSet::from([t]), vec![t]);
        while let Some(t) = pending.pop() {
            if t == across {
                return true;
            }
            for &next in &beside[t] {
                if (next == across || is_near(next)) && seen.insert(next) {
                    pending.push(next);
                }
            }
        }
        false
    }

    /// The thinnest wall that counts.
    fn thinnest_of(&self, counts: impl Fn(&Vec3) -> bool + Sync) -> Option<(f64, Vec3)> {
        let mut all: Vec<_> = self.opposite().collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let at = |pair: [usize; 2]| self.surface.centroid(pair[0]);
        all.retain(|&(_, pair)| counts(&at(pair)));
        let wall = all.iter().find(|&&(thickness, pair)| !self.is_edge(thickness, pair));
        wall.map(|&(thickness, pair)| (thickness, at(pair)))
    }

    /// Whether what is between two triangles is an edge of the body, and no wall.
    fn is_edge(&self, thickness: f64, pair: [usize; 2]) -> bool {
        match thickness < THICK * diagonal(&self.surface.vertices) {
            true => self.leads_around(thickness, pair),
            false => self.have_a_corner(pair),
        }
    }

    /// Whether two triangles have a corner in common.
    fn have_a_corner(&self, [t, across]: [usize; 2]) -> bool {
        let corners = &self.surface.triangles;
        corners[t].iter().any(|v| corners[across].contains(v))
    }

    fn thinnest(&self) -> Option<(f64, Vec3)> {
        self.thinnest_of(|_| true)
    }
}

/// The thinnest wall of a closed surface and where it begins, in the unit of the surface, measured
/// through the centroid of every triangle; `None` if no two triangles are opposite to each other.
pub fn thinnest(surface: &SurfaceMesh) -> Option<(f64, Vec3)> {
    Walls::new(surface).thinnest()
}

/// The thinnest wall with given outward unit normals of the triangles, for surfaces with needles,
/// whose own normals say little.
pub fn thinnest_along(surface: &SurfaceMesh, normals: &[Vec3]) -> Option<(f64, Vec3)> {
    let (bvh, normals) = (SurfaceBvh::new(surface), normals.to_vec());
    Walls { surface, bvh, normals, beside: OnceLock::new() }.thinnest()
}

/// The thinnest wall of `model` and of what `surface` has further than `reach` from it.
pub fn thinnest_with(
    surface: &SurfaceMesh,
    model: &SurfaceMesh,
    reach: f64,
) -> Option<(f64, Vec3)> {
    let (walls, model) = (Walls::new(surface), Walls::new(model));
    let beside = walls.thinnest_of(|at| model.bvh.closest(at).distance > reach);
    [model.thinnest(), beside].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The wall of `surface` that is thinnest among those that are thinner by more than `envelope` on
/// both sides than any wall of `model`, which it follows, and than half of what the model has where
/// it is nearest: a triangle that stands askew in a groove. Its thickness, that of the model there,
/// and its place.
pub fn thinner(
    surface: &SurfaceMesh,
    model: &SurfaceMesh,
    envelope: f64,
) -> Option<(f64, f64, Vec3)> {
    let model = Walls::new(model);
    let least = model.thinnest()?.0 - 2.0 * envelope;
    let walls = Walls::new(surface);
    let thin = |(thickness, pair): (f64, [usize; 2])| {
        if thickness >= least {
            return None;
        }
        let at = surface.centroid(pair[0]);
        let nearest = model.bvh.closest(&at);
        let (wanted, _) = model.across(nearest.triangle, &nearest.point)?;
        let is_thin = thickness < THINNER * (wanted - 2.0 * envelope);
        // edges of the model are no walls of it, either
        (is_thin && !walls.is_edge(thickness, pair)).then_some((thickness, wanted, at))
    };
    walls.opposite().filter_map(thin).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The air between triangles that face each other: how wide it is, straight out of the middle of the first to the
/// second, in the unit of the surface.
pub fn gaps(surface: &SurfaceMesh) -> Vec<(f64, [usize; 2])> {
    let triangles = surface.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let inside_out = SurfaceMesh { vertices: surface.vertices.clone(), triangles };
    Walls::new(&inside_out).opposite().collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::solid::Solid;

    #[test]
    fn a_wall_is_measured_straight_through() {
        // A box with a hole that leaves 1.5 mm at its thinnest side.
        let outer = Solid::cube(&Vec3::zeros(), &Vec3::new(20.0, 20.0, 20.0));
        let hole = Solid::cube(&Vec3::new(5.0, 1.5, 5.0), &Vec3::new(15.0, 15.0, 15.0));
        let (thickness, at) = thinnest(&outer.difference(&hole).to_surface()).unwrap();
        assert!((thickness - 1.5).abs() < 1e-12, "{thickness} at {at}");
        // Near the edge of a wedge there is no wall.
        let wedge = outer.trim_by_plane(&Vec3::new(1.0, 0.0, -1.0).normalize(), 0.0);
        let (thickness, _) = thinnest(&wedge.to_surface()).unwrap();
        assert!(thickness > 1.0, "{thickness}");
    }

    /// A plate whose rim is a narrow ridge with a blunt top: the surface leads around it close by.
    #[test]
    fn a_blunt_edge_is_no_wall() {
        let plate = Solid::cube(&Vec3::zeros(), &Vec3::new(40.0, 40.0, 4.0));
        let slope = |x: f64| Vec3::new(x, 0.0, -0.45).normalize();
        // the sides by 24° from the vertical, up to a top of 0.3 mm
        let sides = [(slope(1.0), 18.0), (slope(-1.0), 22.0)];
        let ridge = Solid::cube(&Vec3::new(15.0, 2.0, 3.9), &Vec3::new(25.0, 38.0, 7.5));
        let ridge = sides.iter().fold(ridge, |ridge, (inward, x)| {
            ridge.trim_by_plane(inward, inward.dot(&Vec3::new(*x, 0.0, 4.0)))
        });
        let body = plate.union(&ridge).to_surface();
        assert!(Walls::new(&body).opposite().any(|(thickness, _)| thickness < 3.5));
        let (thickness, at) = thinnest(&body).unwrap();
        assert!((thickness - 4.0).abs() < 1e-9, "{thickness} at {at}");
    }

    #[test]
    fn walls_beside_a_model_are_measured_on_the_surface() {
        let box_of = |low: [f64; 3], high: [f64; 3]| Solid::cube(&low.into(), &high.into());
        // A plate of 2 mm, as meshed with 1.9 mm, with a fin of 1 mm that the model has not.
        let model = box_of([0.0; 3], [20.0, 20.0, 2.0]).to_surface();
        let meshed = box_of([0.0; 3], [20.0, 20.0, 1.9]);
        let fin = box_of([5.0, 5.0, 1.0], [15.0, 6.0, 9.0]);
        let thickness = |surface: &Solid| thinnest_with(&surface.to_surface(), &model, 0.2);
        assert!((thickness(&meshed).unwrap().0 - 2.0).abs() < 1e-12);
        assert!((thickness(&meshed.union(&fin)).unwrap().0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn air_is_measured_between_what_faces_each_other() {
        let block =
            |x: [f64; 2]| Solid::cube(&Vec3::new(x[0], 0.0, 0.0), &Vec3::new(x[1], 9.0, 9.0));
        let floor = Solid::cube(&Vec3::new(0.0, 0.0, -1.0), &Vec3::new(13.0, 9.0, 0.5));
        let comb = floor.union(&block([0.0, 5.0])).union(&block([5.8, 13.0])).to_surface();
        let found = gaps(&comb);
        // Two walls of two triangles or more; the floor faces nothing, and neither does the outside.
        assert!(found.len() >= 4, "{found:?}");
        for (width, [from, to]) in found {
            let x = [from, to].map(|t| comb.centroid(t).x);
            assert!(
                (width - 0.8).abs() < 1e-9 && (x[0] - x[1]).abs() < 0.8 + 1e-9,
                "{width} {x:?}"
            );
        }
    }

    #[test]
    fn a_wall_far_thinner_than_that_of_the_model_is_found() {
        let plate = Solid::cube(&Vec3::zeros(), &Vec3::new(20.0, 20.0, 2.0));
        let pit = Solid::cube(&Vec3::new(9.9, 9.9, 0.15), &Vec3::new(10.1, 10.1, 3.0));
        let model = plate.to_surface();
        let pitted = plate.difference(&pit).to_surface();
        let (found, wanted, at) = thinner(&pitted, &model, 0.05).unwrap();
        assert!((found - 0.15).abs() < 1e-12 && (wanted - 2.0).abs() < 1e-12, "{found} {wanted}");
        assert!((at - Vec3::new(10.0, 10.0, 0.15)).xy().norm() < 0.2, "{at}");
        // What the envelope explains, and an edge that is sharp in the model, too.
        let thin = Solid::cube(&Vec3::zeros(), &Vec3::new(20.0, 20.0, 1.91)).to_surface();
        assert_eq!(thinner(&thin, &model, 0.05), None);
        let wedge = plate.trim_by_plane(&Vec3::new(1.0, 0.0, -1.2).normalize(), 10.0);
        let cut = wedge.trim_by_plane(&Vec3::new(-1.0, 0.0, 0.0), -12.0);
        assert_eq!(thinner(&cut.to_surface(), &wedge.to_surface(), 0.05), None);
    }

    #[test]
    fn a_spike_on_a_wall_is_no_wall() {
        let plate = Solid::cube(&Vec3::zeros(), &Vec3::new(20.0, 20.0, 2.0));
        let block = Solid::cube(&Vec3::new(9.0, 9.0, 1.9), &Vec3::new(11.0, 11.0, 4.0));
        // four sides that meet at (10, 10, 3), each by 14° from the vertical
        let tip = Vec3::new(10.0, 10.0, 3.0);
        let sides = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let spike = sides.iter().fold(block, |spike, &(x, y)| {
            let inward = Vec3::new(x, y, -0.25).normalize();
            spike.trim_by_plane(&inward, inward.dot(&tip))
        });
        let spiked = plate.union(&spike).to_surface();
        assert!(Walls::new(&spiked).opposite().any(|(thickness, _)| thickness < 0.5));
        let (thickness, _) = thinnest(&spiked).unwrap();
        assert!((thickness - 2.0).abs() < 1e-9, "{thickness}");
    }
}
