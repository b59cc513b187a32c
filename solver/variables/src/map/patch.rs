//! A part of the boundary that a design moves: by handles, or in proportion to variables.
//!
//! every vertex   v' = v + Σ θ_k d_k         d_k   the axes, but none across planes in which v lies
//! offset         v' = v + θ r(v) d(v)       one number, how far it moves along its normals
//!
//! d(v)   move of a vertex per distance, so that the facets at it move by that ([`shifts`]), out of the silicone
//! r(v)   rises from 0 at the rim to 1 within a few edges of it, along the surface [1]

use anyhow::{Result, ensure};
use mechanics::symmetry::OFF_PLANE;
use mesh::measure::mean_edge;
use mesh::offset::shifts;
use mesh::{Vec3, topology};
use scene::config::Moves;

use super::geodesic::Geodesics;
use super::handles::{Handles, sample_handles};
use super::held::{Held, off};
use super::isometry::Isometry;

/// Width of the rise at the rim, in mean edges.
const RISE: f64 = 2.0;

/// Design variables of one patch, all in metres; zero is the shape as it is.
#[derive(Clone, Debug)]
pub enum Patch {
    /// Rigid motions of handles.
    Handles(Handles),
    /// Motions in proportion to the variables.
    Linear(Linear),
}

/// v' = v + Σ θ_k d over the ways of a vertex
#[derive(Clone, Debug)]
pub struct Linear {
    /// Vertex ids that move, ascending.
    vertices: Vec<usize>,
    variables: usize,
    /// Index of the vertex, that of the variable, and d.
    ways: Vec<(usize, usize, Vec3)>,
    /// It is one distance along the normals.
    is_offset: bool,
}

impl Linear {
    /// The displacement of every vertex off the rim, but none across planes in which it lies.
    fn free(rest: &[Vec3], facets: &[[usize; 3]], held: Held) -> Self {
        let (surface, ids) = topology::submesh(rest, facets);
        let rim = held.rim(&surface, &ids);
        let free = (0..ids.len()).filter(|v| rim.binary_search(v).is_err());
        let vertices: Vec<usize> = free.map(|v| ids[v]).collect();
        let directions =
            |(i, &v): (usize, &usize)| held.directions(v).1.into_iter().map(move |d| (i, d));
        let ways = vertices.iter().enumerate().flat_map(directions).enumerate();
        let ways: Vec<_> = ways.map(|(variable, (i, d))| (i, variable, d)).collect();
        Self { vertices, variables: ways.len(), ways, is_offset: false }
    }

    /// How far all of it moves along its normals.
    fn offset(rest: &[Vec3], facets: &[[usize; 3]], held: Held) -> Self {
        let (surface, ids) = topology::submesh(rest, facets);
        let rim = held.rim(&surface, &ids);
        let width = RISE * mean_edge(&surface.vertices, &surface.triangles);
        let rises: Vec<f64> = match rim.is_empty() {
            true => vec![1.0; ids.len()],
            false => Geodesics::new(&surface)
                .distances(&rim)
                .iter()
                .map(|d| (d / width).min(1.0))
                .collect(),
        };
        let moves = shifts(rest, facets);
        let off_rim = ids.into_iter().zip(rises).filter(|(_, rise)| *rise > OFF_PLANE);
        let way = |(v, rise): (usize, f64)| (v, rise * off(&held.directions(v).0, &moves[&v]));
        let (vertices, moves): (Vec<usize>, Vec<Vec3>) = off_rim.map(way).unzip();
        let ways = moves.into_iter().enumerate().map(|(i, d)| (i, 0, d)).collect();
        Self { vertices, variables: 1, ways, is_offset: true }
    }
}

impl Patch {
    /// A patch with handles, with all vertices free, or as a whole; `own` are its images in itself.
    pub fn new(
        rest: &[Vec3],
        facets: &[[usize; 3]],
        held: Held,
        moves: Moves,
        own: &[Isometry],
    ) -> Result<Self> {
        Ok(match moves {
            Moves::Handles(count, motion) => {
                Self::Handles(sample_handles(rest, facets, held, (count, motion), own)?)
            }
            Moves::Offset => Self::Linear(Linear::offset(rest, facets, held)),
            Moves::Vertices => Self::Linear(Linear::free(rest, facets, held)),
        })
    }

    /// The image of this patch by an isometry, with the same variables; `rest`, `facets` and `held` are those of the image.
    pub fn image(
        &self,
        by: &Isometry,
        rest: &[Vec3],
        facets: &[[usize; 3]],
        held: Held,
    ) -> Result<Self> {
        match self {
            Self::Handles(handles) => Ok(Self::Handles(handles.image(by, rest, facets, held)?)),
            Self::Linear(linear) => {
                ensure!(
                    linear.is_offset,
                    "vertices that move freely have no images; expected handles or an offset"
                );
                Ok(Self::Linear(Linear::offset(rest, facets, held)))
            }
        }
    }

    /// Number of design variables.
    pub fn variables(&self) -> usize {
        match self {
            Self::Handles(handles) => handles.variables(),
            Self::Linear(linear) => linear.variables,
        }
    }

    /// Ids of the vertices that it may move, ascending.
    pub fn vertices(&self) -> &[usize] {
        match self {
            Self::Handles(handles) => handles.vertices(),
            Self::Linear(linear) => &linear.vertices,
        }
    }

    /// Positions of its vertices [m], from the rest positions of the whole mesh
    /// with which it was made.
    pub fn apply(&self, theta: &[f64], rest: &[Vec3]) -> Vec<Vec3> {
        match self {
            Self::Handles(handles) => handles.apply(theta, rest),
            Self::Linear(Linear { vertices, ways, .. }) => {
                let mut moved: Vec<Vec3> = vertices.iter().map(|&v| rest[v]).collect();
                ways.iter().for_each(|(i, k, d)| moved[*i] += theta[*k] * d);
                moved
            }
        }
    }

    /// Cotangents of the variables for those of its vertices' positions.
    pub fn vjp(&self, theta: &[f64], rest: &[Vec3], bar: &[Vec3]) -> Vec<f64> {
        match self {
            Self::Handles(handles) => handles.vjp(theta, rest, bar),
            Self::Linear(linear) => {
                let mut by = vec![0.0; linear.variables];
                linear.ways.iter().for_each(|(i, k, d)| by[*k] += d.dot(&bar[*i]));
                by
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::{cap, check_gradient, sphere};
    use scene::config::{HandleMotion, SymmetricConfig};

    use super::*;
    use crate::map::sampling::rim;

    #[test]
    fn nothing_moves_within_the_margin() {
        let surface = cap(3);
        let x = &surface.vertices;
        let margin = 0.3;
        let distances = Geodesics::new(&surface).distances(&rim(&surface, |_| false));
        let handles = |motion| Moves::Handles(4, motion);
        for moves in [
            Moves::Vertices,
            Moves::Offset,
            handles(HandleMotion::Rigid),
            handles(HandleMotion::RigidAndOffset),
        ] {
            let facets = &surface.triangles;
            let held = Held { margin, ..Held::default() };
            let patch = Patch::new(x, facets, held, moves, &[]).unwrap();
            let at_rest = patch.apply(&vec![0.0; patch.variables()], x);
            assert!(patch.vertices().iter().zip(at_rest).all(|(&v, m)| m == x[v]), "{moves:?}");
            let theta = Random::new(5).numbers(patch.variables());
            let moved = patch.apply(&theta, x);
            let way: Vec<f64> =
                patch.vertices().iter().zip(&moved).map(|(&v, m)| (m - x[v]).norm()).collect();
            let near = |&v: &usize| distances[v] < margin;
            assert!(patch.vertices().iter().any(|v| !near(v)));
            for (v, way) in patch.vertices().iter().zip(&way) {
                assert_eq!(near(v), *way == 0.0, "{moves:?}: vertex {v} moves by {way}");
            }
        }
    }

    /// J = Σ (a·x + ½ |x|²) over the vertices of patches with the same variables.
    fn check_vjp(patches: &[Patch], rest: &[Vec3]) {
        let moved = |theta: &[f64]| -> Vec<Vec<Vec3>> {
            patches.iter().map(|patch| patch.apply(theta, rest)).collect()
        };
        let theta = Random::new(32).numbers(patches[0].variables());
        let theta: Vec<f64> = theta.iter().map(|t| 0.4 * t).collect();
        let mut random = Random::new(33);
        let along: Vec<Vec3> = moved(&theta).concat().iter().map(|_| random.vector()).collect();
        let value = |theta: &[f64]| -> f64 {
            let all = moved(theta).concat();
            all.iter().zip(&along).map(|(x, a)| a.dot(x) + 0.5 * x.norm_squared()).sum()
        };
        let mut gradient = vec![0.0; theta.len()];
        let mut rest_of_along = &along[..];
        for (patch, moved) in patches.iter().zip(moved(&theta)) {
            let (own, others) = rest_of_along.split_at(moved.len());
            let bar: Vec<Vec3> = moved.iter().zip(own).map(|(x, a)| a + x).collect();
            let by = patch.vjp(&theta, rest, &bar);
            gradient.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
            rest_of_along = others;
        }
        check_gradient(&theta, &gradient, 1e-3, value);
    }

    /// Of all kinds, alone and with an image beside them.
    #[test]
    fn gradients_are_exact() {
        let n = 3;
        let by: SymmetricConfig =
            toml::from_str("of = ['a', 'b']\nmirror = { axis = 'x', at = 2 }").unwrap();
        let by = Isometry::of(&by, 1);
        let own: SymmetricConfig =
            toml::from_str("of = 'a'\nturn = { axis = 'z', angle = 180 }").unwrap();
        let (first, held) = (sphere(2), Held::default());
        let count = first.vertices.len();
        let image = first.vertices.iter().map(|x| by.image(x));
        let rest: Vec<Vec3> = first.vertices.iter().copied().chain(image).collect();
        let other: Vec<_> =
            first.triangles.iter().map(|&[a, b, c]| [a, c, b].map(|v| v + count)).collect();
        let handles = |motion| Moves::Handles(n, motion);
        for (moves, variables) in [
            (Moves::Vertices, 3 * count),
            (Moves::Offset, 1),
            (handles(HandleMotion::Rigid), 6 * n),
            (handles(HandleMotion::Translation), 3 * n),
            (handles(HandleMotion::RigidAndOffset), 7 * n),
        ] {
            let patch = Patch::new(&rest, &first.triangles, held, moves, &[]).unwrap();
            assert_eq!(patch.variables(), variables, "{moves:?}");
            check_vjp(&[patch], &rest);
            if moves == Moves::Vertices {
                continue;
            }
            let own = Isometry::own(&own);
            let patch = Patch::new(&rest, &first.triangles, held, moves, &own).unwrap();
            let image = patch.image(&by, &rest, &other, held).unwrap();
            check_vjp(&[patch, image], &rest);
        }
    }

    /// A ball of radius 1 grows by the distance; facets in chords lie a little deeper.
    #[test]
    fn a_ball_that_is_offset_is_another_ball() {
        let ball = sphere(3);
        let x = &ball.vertices;
        let patch = Patch::new(x, &ball.triangles, Held::default(), Moves::Offset, &[]).unwrap();
        assert_eq!((patch.variables(), patch.vertices().len()), (1, x.len()));
        for moved in patch.apply(&[0.2], x) {
            assert!((moved.norm() - 1.2).abs() < 4e-3, "{}", moved.norm());
        }
    }
}
