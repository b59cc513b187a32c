//! A part of the boundary that a design moves.

use mesh::{Vec3, topology};
use scene::config::{Moves, Spread};

use super::handles::{HandleError, Handles, sample_handles};
use super::held::Held;

/// Design variables of one patch, all in metres; zero is the shape as it is.
#[derive(Clone, Debug)]
pub enum Patch {
    /// Rigid motions of handles.
    Handles(Handles),
    /// The displacement of every vertex off the rim, but none across planes in which it lies.
    Vertices(FreeVertices),
}

/// Vertices of a patch that move freely.
#[derive(Clone, Debug)]
pub struct FreeVertices {
    /// Vertex ids off the rim, ascending.
    vertices: Vec<usize>,
    /// Index of the vertex and direction of each variable.
    ways: Vec<(usize, Vec3)>,
}

impl Patch {
    /// A patch with handles, or with all vertices free.
    ///
    /// # Errors
    /// [`HandleError`] if the patch has too few vertices or is degenerate.
    pub fn new(
        rest: &[Vec3],
        facets: &[[usize; 3]],
        held: Held,
        moves: Moves,
        spread: Spread,
    ) -> Result<Self, HandleError> {
        if let Moves::Handles(count, motion) = moves {
            let handles = sample_handles(rest, facets, held, count, spread)?;
            return Ok(Self::Handles(handles.with(motion)));
        }
        let (surface, ids) = topology::submesh(rest, facets);
        let rim = held.rim(&surface, &ids);
        let free = (0..ids.len()).filter(|v| rim.binary_search(v).is_err());
        let vertices: Vec<usize> = free.map(|v| ids[v]).collect();
        let of_vertex = |(i, &v): (usize, &usize)| {
            let (_, free) = held.directions(v);
            free.into_iter().map(move |direction| (i, direction))
        };
        let ways = vertices.iter().enumerate().flat_map(of_vertex).collect();
        Ok(Self::Vertices(FreeVertices { vertices, ways }))
    }

    /// Number of design variables.
    #[must_use]
    pub fn variables(&self) -> usize {
        match self {
            Self::Handles(handles) => handles.variables(),
            Self::Vertices(free) => free.ways.len(),
        }
    }

    /// Ids of the vertices that it may move, ascending.
    #[must_use]
    pub fn vertices(&self) -> &[usize] {
        match self {
            Self::Handles(handles) => handles.vertices(),
            Self::Vertices(free) => &free.vertices,
        }
    }

    /// Positions of its vertices [m], from the rest positions of the whole mesh
    /// with which it was made.
    #[must_use]
    pub fn apply(&self, theta: &[f64], rest: &[Vec3]) -> Vec<Vec3> {
        match self {
            Self::Handles(handles) => handles.apply(theta, rest),
            Self::Vertices(free) => {
                let mut moved: Vec<Vec3> = free.vertices.iter().map(|&v| rest[v]).collect();
                free.ways.iter().zip(theta).for_each(|((i, way), d)| moved[*i] += *d * way);
                moved
            }
        }
    }

    /// Cotangents of the variables for those of its vertices' positions.
    #[must_use]
    pub fn vjp(&self, theta: &[f64], rest: &[Vec3], bar: &[Vec3]) -> Vec<f64> {
        match self {
            Self::Handles(handles) => handles.vjp(theta, rest, bar),
            Self::Vertices(free) => free.ways.iter().map(|(i, way)| way.dot(&bar[*i])).collect(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::{cap, check_gradient};
    use scene::config::HandleMotion;

    use super::*;
    use crate::design::Geodesics;
    use crate::design::sampling::rim;

    #[test]
    fn nothing_moves_within_the_margin() {
        let surface = cap(3);
        let x = &surface.vertices;
        let margin = 0.3;
        let distances = Geodesics::new(&surface).distances(&rim(&surface));
        for moves in [Moves::Vertices, Moves::Handles(4, HandleMotion::Rigid)] {
            let facets = &surface.triangles;
            let held = Held { margin, ..Held::default() };
            let patch = Patch::new(x, facets, held, moves, Spread::RePick).unwrap();
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

    #[test]
    fn free_vertices_move_all_but_the_rim() {
        let surface = cap(2);
        let x = &surface.vertices;
        let patch =
            Patch::new(x, &surface.triangles, Held::default(), Moves::Vertices, Spread::RePick)
                .unwrap();
        let on_rim = rim(&surface);
        assert_eq!(patch.vertices().len() + on_rim.len(), x.len());
        assert!(patch.vertices().iter().all(|v| !on_rim.contains(v)));
        let theta = Random::new(3).numbers(patch.variables());
        let a = Random::new(4).numbers(patch.variables());
        let value = |theta: &[f64]| -> f64 {
            let moved = patch.apply(theta, x);
            let sum = moved
                .iter()
                .zip(a.chunks_exact(3))
                .map(|(v, a)| Vec3::from_column_slice(a).dot(v) + 0.5 * v.norm_squared());
            sum.sum()
        };
        let moved = patch.apply(&theta, x);
        let bar: Vec<Vec3> = moved
            .iter()
            .zip(a.chunks_exact(3))
            .map(|(v, a)| Vec3::from_column_slice(a) + v)
            .collect();
        check_gradient(&theta, &patch.vjp(&theta, x, &bar), 1e-2, value);
    }
}
