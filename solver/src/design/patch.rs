//! A part of the boundary that a design moves.

use mesh::{Vec3, topology};
use scene::config::Moves;

use super::handles::{HandleError, Handles, sample_handles};
use super::held::Held;
use super::isometry::Isometry;
use super::swelling::Swelling;

/// Design variables of one patch, all in metres; zero is the shape as it is.
#[derive(Clone, Debug)]
pub enum Patch {
    /// Rigid motions of handles.
    Handles(Handles),
    /// The displacement of every vertex off the rim, but none across planes in which it lies.
    Vertices(FreeVertices),
    /// How far all of it moves along its normals.
    Offset(Swelling),
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
    /// A patch with handles, with all vertices free, or as a whole; `own` are its images in itself.
    pub fn new(
        rest: &[Vec3],
        facets: &[[usize; 3]],
        held: Held,
        moves: Moves,
        own: &[Isometry],
    ) -> Result<Self, HandleError> {
        if let Moves::Handles(count, motion) = moves {
            let handles = sample_handles(rest, facets, held, count, own)?;
            return Ok(Self::Handles(handles.with(motion)));
        }
        if moves == Moves::Offset {
            return Ok(Self::Offset(Swelling::new(rest, facets, held)));
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

    /// The image of this patch by an isometry, with the same variables; `rest`, `facets` and `held` are those of the image.
    pub fn image(
        &self,
        by: &Isometry,
        rest: &[Vec3],
        facets: &[[usize; 3]],
        held: Held,
    ) -> Result<Self, HandleError> {
        match self {
            Self::Handles(handles) => Ok(Self::Handles(handles.image(by, rest, facets, held)?)),
            Self::Offset(_) => Ok(Self::Offset(Swelling::new(rest, facets, held))),
            Self::Vertices(_) => Err(HandleError::Free),
        }
    }

    /// Number of design variables.
    pub fn variables(&self) -> usize {
        match self {
            Self::Handles(handles) => handles.variables(),
            Self::Vertices(free) => free.ways.len(),
            Self::Offset(_) => 1,
        }
    }

    /// Ids of the vertices that it may move, ascending.
    pub fn vertices(&self) -> &[usize] {
        match self {
            Self::Handles(handles) => handles.vertices(),
            Self::Vertices(free) => &free.vertices,
            Self::Offset(swelling) => &swelling.vertices,
        }
    }

    /// Positions of its vertices [m], from the rest positions of the whole mesh
    /// with which it was made.
    pub fn apply(&self, theta: &[f64], rest: &[Vec3]) -> Vec<Vec3> {
        match self {
            Self::Handles(handles) => handles.apply(theta, rest),
            Self::Offset(swelling) => swelling.apply(theta[0], rest),
            Self::Vertices(free) => {
                let mut moved: Vec<Vec3> = free.vertices.iter().map(|&v| rest[v]).collect();
                free.ways.iter().zip(theta).for_each(|((i, way), d)| moved[*i] += *d * way);
                moved
            }
        }
    }

    /// Cotangents of the variables for those of its vertices' positions.
    pub fn vjp(&self, theta: &[f64], rest: &[Vec3], bar: &[Vec3]) -> Vec<f64> {
        match self {
            Self::Handles(handles) => handles.vjp(theta, rest, bar),
            Self::Offset(swelling) => vec![swelling.vjp(bar)],
            Self::Vertices(free) => free.ways.iter().map(|(i, way)| way.dot(&bar[*i])).collect(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::{cap, check_gradient, sphere};
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
            Patch::new(x, &surface.triangles, Held::default(), Moves::Vertices, &[]).unwrap();
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

    /// A ball of radius 1 grows by the distance; facets in chords lie a little deeper.
    #[test]
    fn a_ball_that_is_offset_is_another_ball() {
        let ball = sphere(3);
        let x = &ball.vertices;
        let held = Held::default();
        let patch = Patch::new(x, &ball.triangles, held, Moves::Offset, &[]).unwrap();
        assert_eq!((patch.variables(), patch.vertices().len()), (1, x.len()));
        for moved in patch.apply(&[0.2], x) {
            assert!((moved.norm() - 1.2).abs() < 4e-3, "{}", moved.norm());
        }
        let bar = Random::new(8).numbers(3 * x.len());
        let bar: Vec<Vec3> = bar.chunks_exact(3).map(Vec3::from_column_slice).collect();
        let value = |theta: f64| -> f64 {
            patch.apply(&[theta], x).iter().zip(&bar).map(|(x, b)| x.dot(b)).sum()
        };
        let slope = patch.vjp(&[0.1], x, &bar)[0];
        assert!((value(1.0) - value(0.0) - slope).abs() < 1e-12);
    }
}
