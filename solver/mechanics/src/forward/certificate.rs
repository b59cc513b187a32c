//! Proof that a deformed body is nowhere turned inside out.
//!
//! J(λ) = det ∂x/∂ξ / det ∂X/∂ξ > 0 on every whole element, not only at its
//! quadrature points: all Bernstein coefficients are positive, if need be after
//! cutting the element in halves along its longest edges. A corner of a part
//! with J ≤ 0 is a counterexample.

use mesh::Vec3;

use crate::element::{FunctionSpace, JacobianForm, at};
use crate::parallel::map_merge;

/// Parts of one element that are examined before it counts as undecided.
const PARTS: usize = 1000;

/// Why a deformed body is not certified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Uncertified {
    /// There is a point with J ≤ 0.
    #[error(
        "element {element} is turned inside out at {} at rest: volume ratio {value:.3e} there, \
         although it is positive at the quadrature points; a finer mesh there, or less load, \
         may help", point(.at)
    )]
    Inverted {
        /// The element where J is smallest.
        element: usize,
        /// The point in the rest shape [m].
        at: Vec3,
        /// J there.
        value: f64,
    },
    /// J > 0 wherever it was evaluated, but there is no proof.
    #[error(
        "element {element} at {} at rest is too distorted to show that it is not turned inside \
         out: volume ratio at least {bound:.3e}; a finer mesh there, or less load, may help",
        point(.at)
    )]
    Undecided {
        /// The element.
        element: usize,
        /// The centre in the rest shape [m].
        at: Vec3,
        /// Lower bound of J.
        bound: f64,
    },
}

impl Uncertified {
    /// J where it is worst, or its lower bound.
    pub fn volume_ratio(&self) -> f64 {
        self.rank().1
    }

    /// Smaller is worse: inversions before doubts.
    fn rank(&self) -> (u8, f64) {
        match self {
            Self::Inverted { value, .. } => (0, *value),
            Self::Undecided { bound, .. } => (1, *bound),
        }
    }
}

fn point(p: &Vec3) -> String {
    format!("({:.5}, {:.5}, {:.5}) m", p.x, p.y, p.z)
}

/// A lower bound of J over the whole body, which is positive.
pub fn certificate(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Result<f64, Uncertified> {
    let form = JacobianForm::new(space.degree());
    let positions = space.node_positions(rest);
    let (mut bound, mut worst) = (f64::INFINITY, None);
    map_merge(
        space.tets().len(),
        |range| range.map(|e| element_certificate(space, &form, rest, &positions, u, e)).collect(),
        |_, results: Vec<Result<f64, Uncertified>>| {
            for result in results {
                match result {
                    Ok(lower) => bound = bound.min(lower),
                    Err(found) => keep_worse(&mut worst, found),
                }
            }
        },
    );
    worst.map_or(Ok(bound), Err)
}

fn keep_worse(worst: &mut Option<Uncertified>, found: Uncertified) {
    if worst.as_ref().is_none_or(|w| found.rank() < w.rank()) {
        *worst = Some(found);
    }
}

fn element_certificate(
    space: &FunctionSpace,
    form: &JacobianForm,
    rest: &[Vec3],
    positions: &[Vec3],
    u: &[f64],
    element: usize,
) -> Result<f64, Uncertified> {
    let n = space.nodes_per_element();
    let nodes = &space.element_nodes()[n * element..n * (element + 1)];
    let x: Vec<Vec3> = nodes.iter().map(|&i| positions[i] + at(u, i)).collect();
    let corners = space.tets()[element].map(|v| rest[v]);
    let [a, b, c, d] = corners;
    let scale = 1.0 / (6.0 * mesh::measure::tet_volume(a, b, c, d));
    let coefficients = form.coefficients(&x).into_iter().map(|c| scale * c).collect();
    let place = |lambda: [f64; 4]| lambda.iter().zip(corners).map(|(l, x)| *l * x).sum::<Vec3>();
    examine(form, coefficients, element, place)
}

/// Is a polynomial in Bernstein form positive on the whole simplex? A lower bound of it; `place` is where barycentric
/// coordinates are.
fn examine(
    form: &JacobianForm,
    coefficients: Vec<f64>,
    element: usize,
    place: impl Fn([f64; 4]) -> Vec3,
) -> Result<f64, Uncertified> {
    let unit = |k: usize| std::array::from_fn(|c| f64::from(u8::from(c == k)));
    let whole: [[f64; 4]; 4] = std::array::from_fn(unit);
    let mut parts = vec![(coefficients, whole)];
    let (mut bound, mut examined) = (f64::INFINITY, 0);
    while let Some((coefficients, corners)) = parts.pop() {
        for (k, &lambda) in corners.iter().enumerate() {
            let value = coefficients[form.corner(k)];
            if value <= 0.0 {
                return Err(Uncertified::Inverted { element, at: place(lambda), value });
            }
        }
        let smallest = coefficients.iter().copied().fold(f64::INFINITY, f64::min);
        if coefficients.iter().all(|&c| c > 0.0) {
            bound = bound.min(smallest);
            continue;
        }
        examined += 1;
        if examined == PARTS {
            let open = parts.iter().flat_map(|p| p.0.iter().copied());
            let bound = open.chain([bound, smallest]).fold(f64::INFINITY, f64::min);
            return Err(Uncertified::Undecided { element, at: place([0.25; 4]), bound });
        }
        let (i, j) = longest_edge(&corners);
        for (kept, moved) in [(i, j), (j, i)] {
            let mut half = corners;
            half[moved] = std::array::from_fn(|c| 0.5 * (corners[i][c] + corners[j][c]));
            parts.push((form.half(&coefficients, kept, moved), half));
        }
    }
    Ok(bound)
}

/// In the metric of a regular tetrahedron.
fn longest_edge(corners: &[[f64; 4]; 4]) -> (usize, usize) {
    let square = |i: usize, j: usize| -> f64 {
        (0..4).map(|c| (corners[i][c] - corners[j][c]).powi(2)).sum()
    };
    let pairs = (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j)));
    pairs.max_by(|a, b| square(a.0, a.1).total_cmp(&square(b.0, b.1))).expect("six edges")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::testing;

    /// One tetrahedron of edge 1 cm at the origin.
    fn single(degree: usize) -> (FunctionSpace, Vec<Vec3>) {
        let rest = vec![Vec3::zeros(), 0.01 * Vec3::x(), 0.01 * Vec3::y(), 0.01 * Vec3::z()];
        (FunctionSpace::new(degree, 4, vec![[0, 1, 2, 3]]), rest)
    }

    #[test]
    fn a_homogeneous_deformation_has_its_volume_ratio_as_bound() {
        let mesh = testing::cube(2, 0.2);
        for degree in 1..=3 {
            let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
            let u: Vec<f64> = space
                .node_positions(&mesh.vertices)
                .iter()
                .flat_map(|x| [0.2 * x.x + 0.3 * x.y, -0.1 * x.y, 0.1 * x.z])
                .collect();
            let bound = certificate(&space, &mesh.vertices, &u).expect("no inversion");
            assert!((bound / (1.2 * 0.9 * 1.1) - 1.0).abs() < 1e-12, "{bound}");
        }
    }

    /// Sampling must never contradict the certificate, in either direction.
    #[test]
    fn the_verdict_agrees_with_dense_sampling() {
        let mut random = Random::new(31);
        let mut verdicts = [0; 3];
        for degree in [2, 3] {
            let (space, rest) = single(degree);
            let form = JacobianForm::new(degree);
            let positions = space.node_positions(&rest);
            for k in 0..60 {
                let size = 0.01 * 0.3 * f64::from(k) / 60.0;
                let u: Vec<f64> =
                    random.numbers(3 * positions.len()).iter().map(|x| size * x).collect();
                let nodes = space.element_nodes().iter();
                let x: Vec<Vec3> = nodes.map(|&i| positions[i] + at(&u, i)).collect();
                let smallest = sampled(&form, form.coefficients(&x)) / 1e-6;
                match certificate(&space, &rest, &u) {
                    Ok(bound) => {
                        assert!(bound > 0.0 && bound <= smallest + 1e-12, "{bound} {smallest}");
                        verdicts[0] += 1;
                    }
                    Err(Uncertified::Inverted { value, .. }) => {
                        assert!(value <= 0.0);
                        verdicts[1] += 1;
                    }
                    Err(Uncertified::Undecided { bound, .. }) => {
                        assert!(bound <= smallest);
                        verdicts[2] += 1;
                    }
                }
            }
        }
        assert!(verdicts[0] > 20 && verdicts[1] > 20 && verdicts[2] < 3, "{verdicts:?}");
    }

    /// The smallest corner value of all parts after cutting nine times.
    fn sampled(form: &JacobianForm, coefficients: Vec<f64>) -> f64 {
        let mut parts = vec![coefficients];
        for level in 0..9 {
            let (i, j) = [(0, 1), (2, 3), (0, 2), (1, 3), (0, 3), (1, 2)][level % 6];
            parts = parts.iter().flat_map(|p| [form.half(p, i, j), form.half(p, j, i)]).collect();
        }
        let corners = parts.iter().flat_map(|p| (0..4).map(|c| p[form.corner(c)]));
        corners.fold(f64::INFINITY, f64::min)
    }
}
