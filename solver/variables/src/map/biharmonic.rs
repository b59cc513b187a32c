//! Bounded biharmonic weights: how much each handle moves each vertex.
//!
//! min ½ wᵀ Q w,   Q = L A⁻¹ L,   0 ≤ w ≤ 1
//!
//! w = 1 at the handle, 0 at the other handles and on the rim
//!
//! L   cotangent Laplacian, (L w)_v = Σ_w ½ (cot α + cot β) (w_v − w_w), positive semidefinite [1]
//! A   vertex areas, in units of the surface's area [1]: of each the part that is nearer to it than to other vertices
//!
//! α, β are the angles opposite to the edge vw; in an obtuse triangle the
//! obtuse corner gets half of the area and the others a quarter.
//!
//! One problem per handle, and one for the rim as a whole (1 on the rim, 0 at
//! all handles). The rows are then divided by their sum, so that handles and rim
//! add up to one at every vertex and the rim does not move. A component with
//! neither rim nor handle stays where it is.
//!
//! The minimiser without bounds comes from one factorisation for all handles; a
//! quadratic program is solved only where it leaves the bounds.
//!
//! Source: Jacobson et al. 2011, "Bounded biharmonic weights for real-time
//! deformation", doi:10.1145/2010324.1964973; of L and A: Pinkall and Polthier 1993,
//! doi:10.1080/10586458.1993.10504266; Meyer et al. 2003, doi:10.1007/978-3-662-05105-4_2.

use std::collections::BTreeMap;

use anyhow::{Result, anyhow};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
};
use mechanics::math::linear::{NotPositive, Precision, SparseSolver, Symmetric, one_by_one};
use mechanics::math::ordering::nested_dissection;
use mesh::{SurfaceMesh, Vec3};
use rayon::prelude::*;

/// Twice the area below which a triangle counts as degenerate, in units of its
/// longest edge squared [1]; bounds the cotangents of slivers.
const DEGENERATE: f64 = 1e-8;

/// Violation of a bound that counts as rounding [1].
const WEIGHT_ROUNDING: f64 = 1e-9;
/// Accuracy of a quadratic program [1]; what is left is clamped.
const ACCURACY: f64 = 1e-10;
/// Sum of a vertex's raw weights below which nothing moves it [1].
const UNREACHED: f64 = 1e-6;

/// Weights of all handles, `[handle][vertex]`, for handles at vertices off the
/// rim.
pub fn bounded_biharmonic(
    surface: &SurfaceMesh,
    rim: &[usize],
    handles: &[usize],
) -> Result<Vec<Vec<f64>>> {
    let problem = Problem::new(surface, rim, handles);
    let mut targets: Vec<Vec<usize>> = handles.iter().map(|&v| vec![v]).collect();
    if !rim.is_empty() {
        targets.push(rim.to_vec());
    }
    let start = problem.unbounded(&targets).map_err(|why| {
        anyhow!("biharmonic energy: {why}; the surface has degenerate triangles, re-mesh it")
    })?;
    // results come in the order of the handles, whatever the order of solving
    let mut weights: Vec<Vec<f64>> =
        targets.par_iter().zip(start).map(|(ones, w)| problem.bounded(ones, w)).collect();
    normalise(&mut weights);
    weights.truncate(handles.len());
    Ok(weights)
}

/// Divides by the sum at each vertex.
fn normalise(weights: &mut [Vec<f64>]) {
    let vertices = weights.first().map_or(0, Vec::len);
    for v in 0..vertices {
        let sum: f64 = weights.iter().map(|w| w[v]).sum();
        let factor = if sum < UNREACHED { 0.0 } else { 1.0 / sum };
        weights.iter_mut().for_each(|w| w[v] *= factor);
    }
}

/// Sparse symmetric matrix by rows.
type Rows = Vec<BTreeMap<usize, f64>>;

/// The energy with its unknowns.
struct Problem {
    energy: Rows,
    /// Vertex of each unknown, ascending.
    free: Vec<usize>,
    /// Unknown of each vertex.
    unknown: BTreeMap<usize, usize>,
}

impl Problem {
    fn new(surface: &SurfaceMesh, rim: &[usize], handles: &[usize]) -> Self {
        let (laplacian, areas) = cotangent_laplacian(surface);
        let total: f64 = areas.iter().sum();
        let smallest = f64::EPSILON * total / areas.len() as f64;
        let mut energy = vec![BTreeMap::new(); areas.len()];
        for (row, area) in laplacian.iter().zip(&areas) {
            let scale = total / area.max(smallest);
            for (&i, a) in row {
                for (&j, b) in row {
                    *energy[i].entry(j).or_insert(0.0) += scale * a * b;
                }
            }
        }
        let fixed = [rim, handles].concat();
        let reached = reached_from(&laplacian, &fixed);
        let free: Vec<usize> =
            (0..areas.len()).filter(|v| reached[*v] && !fixed.contains(v)).collect();
        let unknown = free.iter().enumerate().map(|(i, &v)| (v, i)).collect();
        Self { energy, free, unknown }
    }

    /// ∂/∂w of the energy at the unknowns for w = 1 at `ones` and 0 elsewhere.
    fn linear_term(&self, ones: &[usize]) -> Vec<f64> {
        let mut q = vec![0.0; self.free.len()];
        for &one in ones {
            for (v, value) in &self.energy[one] {
                if let Some(&i) = self.unknown.get(v) {
                    q[i] += value;
                }
            }
        }
        q
    }

    /// One triangle of the energy on the unknowns in compressed columns:
    /// rows `keep(row, column)`.
    fn triangle(&self, keep: impl Fn(usize, usize) -> bool) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut start, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for (column, &v) in self.free.iter().enumerate() {
            for (w, value) in &self.energy[v] {
                if let Some(&row) = self.unknown.get(w).filter(|&&row| keep(row, column)) {
                    rows.push(row);
                    values.push(*value);
                }
            }
            start.push(rows.len());
        }
        (start, rows, values)
    }

    /// Minimisers without bounds, one per list of vertices where w = 1.
    fn unbounded(&self, targets: &[Vec<usize>]) -> Result<Vec<Vec<f64>>, NotPositive> {
        if self.free.is_empty() {
            return Ok(vec![Vec::new(); targets.len()]);
        }
        let neighbours = |&v: &usize| -> Vec<usize> {
            let others = self.energy[v].keys().filter(|&&w| w != v);
            others.filter_map(|w| self.unknown.get(w).copied()).collect()
        };
        let adjacency: Vec<Vec<usize>> = self.free.iter().map(neighbours).collect();
        let (start, rows, values) = self.triangle(|row, column| row >= column);
        let solver = SparseSolver::new(start, &rows, &one_by_one(&nested_dissection(&adjacency)));
        let factored = solver.positive(Symmetric::sparse(values), Precision::Double)?;
        let solve = |ones: &Vec<usize>| {
            let mut w: Vec<f64> = self.linear_term(ones).iter().map(|q| -q).collect();
            factored.solve(&mut w);
            w
        };
        Ok(targets.iter().map(solve).collect())
    }

    /// Weights of all vertices from the minimiser without bounds, which is kept where it
    /// is within them. It is clamped to them where the quadratic program, on a surface with
    /// slivers, has no accurate solution: not the smoothest weights, but weights.
    fn bounded(&self, ones: &[usize], mut w: Vec<f64>) -> Vec<f64> {
        if w.iter().any(|x| !(-WEIGHT_ROUNDING..=1.0 + WEIGHT_ROUNDING).contains(x)) {
            match self.quadratic_program(ones) {
                Ok(within) => w = within,
                Err(status) => log::warn!(
                    "weights of the handle at vertex {} of its surface are clamped to their \
                     bounds: their quadratic program ended as {status}",
                    ones[0]
                ),
            }
        }
        let mut weights = vec![0.0; self.energy.len()];
        ones.iter().for_each(|&v| weights[v] = 1.0);
        for (&v, x) in self.free.iter().zip(w) {
            weights[v] = x.clamp(0.0, 1.0);
        }
        weights
    }

    fn quadratic_program(&self, ones: &[usize]) -> Result<Vec<f64>, String> {
        let n = self.free.len();
        let (start, rows, values) = self.triangle(|row, column| row <= column);
        // in unknowns y = w / d for which the diagonal is one: a sliver makes its own large
        let d: Vec<f64> = self.free.iter().map(|v| self.energy[*v][v].sqrt().recip()).collect();
        let columns = (0..n).flat_map(|column| vec![column; start[column + 1] - start[column]]);
        let scaled = rows.iter().zip(columns).zip(values).map(|((&i, j), v)| d[i] * v * d[j]);
        let energy = CscMatrix::new(n, n, start.clone(), rows.clone(), scaled.collect());
        // −w + s = 0 and w + s = 1 with slacks s ≥ 0
        let column_start = (0..=n).map(|i| 2 * i).collect();
        let sides = (0..n).flat_map(|i| [i, n + i]).collect();
        let unit = d.iter().flat_map(|d| [-d, *d]).collect();
        let bounds = CscMatrix::new(2 * n, n, column_start, sides, unit);
        let limits = [vec![0.0; n], vec![1.0; n]].concat();
        let cones: [SupportedConeT<f64>; 1] = [NonnegativeConeT(2 * n)];
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: ACCURACY,
            tol_gap_rel: ACCURACY,
            tol_feas: ACCURACY,
            ..DefaultSettings::default()
        };
        let q: Vec<f64> = self.linear_term(ones).iter().zip(&d).map(|(q, d)| d * q).collect();
        let mut solver = DefaultSolver::new(&energy, &q, &bounds, &limits, &cones, settings)
            .map_err(|e| e.to_string())?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                Ok(solver.solution.x.iter().zip(&d).map(|(y, d)| d * y).collect())
            }
            status => Err(format!("{status:?}")),
        }
    }
}

/// L, and A_v of all vertices.
fn cotangent_laplacian(surface: &SurfaceMesh) -> (Rows, Vec<f64>) {
    let n = surface.vertices.len();
    let (mut rows, mut areas) = (vec![BTreeMap::new(); n], vec![0.0; n]);
    for (t, triangle) in surface.triangles.iter().enumerate() {
        let cot = cotangents(&surface.corners(t));
        let corner_areas = corner_areas(&surface.corners(t), &cot);
        for k in 0..3 {
            areas[triangle[k]] += corner_areas[k];
            let (i, j) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
            for (a, b) in [(i, j), (j, i)] {
                *rows[a].entry(b).or_insert(0.0) -= 0.5 * cot[k];
                *rows[a].entry(a).or_insert(0.0) += 0.5 * cot[k];
            }
        }
    }
    (rows, areas)
}

/// Edge vectors leaving corner k of a triangle.
fn legs(x: &[Vec3; 3], k: usize) -> (Vec3, Vec3) {
    (x[(k + 1) % 3] - x[k], x[(k + 2) % 3] - x[k])
}

fn cotangents(x: &[Vec3; 3]) -> [f64; 3] {
    let longest2 = (0..3).map(|k| legs(x, k).0.norm_squared()).fold(0.0, f64::max);
    let (a, b) = legs(x, 0);
    let double_area = a.cross(&b).norm().max(DEGENERATE * longest2).max(f64::MIN_POSITIVE);
    std::array::from_fn(|k| {
        let (a, b) = legs(x, k);
        a.dot(&b) / double_area
    })
}

fn corner_areas(x: &[Vec3; 3], cot: &[f64; 3]) -> [f64; 3] {
    let (a, b) = legs(x, 0);
    let area = 0.5 * a.cross(&b).norm();
    if let Some(obtuse) = cot.iter().position(|&c| c < 0.0) {
        return std::array::from_fn(|k| if k == obtuse { area / 2.0 } else { area / 4.0 });
    }
    std::array::from_fn(|k| {
        let (a, b) = legs(x, k);
        (cot[(k + 2) % 3] * a.norm_squared() + cot[(k + 1) % 3] * b.norm_squared()) / 8.0
    })
}

/// Which vertices are connected to one of `sources`.
fn reached_from(adjacency: &Rows, sources: &[usize]) -> Vec<bool> {
    let mut reached = vec![false; adjacency.len()];
    let mut pending = sources.to_vec();
    while let Some(v) = pending.pop() {
        if !std::mem::replace(&mut reached[v], true) {
            pending.extend(adjacency[v].keys());
        }
    }
    reached
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::map::sampling::{rim, spread_points};
    use mechanics::testing::{cap, sphere, square};

    #[test]
    fn weights_are_bounded_add_up_and_vanish_on_the_rim() {
        let surface = cap(3);
        let rim = rim(&surface, |_| false);
        let handles = spread_points(&surface, &rim, 6, &|_| Vec::new()).unwrap();
        let weights = bounded_biharmonic(&surface, &rim, &handles).unwrap();
        for v in 0..surface.vertices.len() {
            let sum: f64 = weights.iter().map(|w| w[v]).sum();
            assert!(weights.iter().all(|w| (-1e-8..=1.0 + 1e-8).contains(&w[v])));
            assert!(sum < 1.0 + 1e-8 && (!rim.contains(&v) || sum == 0.0), "vertex {v}: {sum}");
        }
        for (i, w) in weights.iter().enumerate() {
            for (j, &h) in handles.iter().enumerate() {
                assert!((w[h] - f64::from(u8::from(i == j))).abs() < 1e-8);
            }
        }
    }

    /// The conditions for the minimum under bounds: no slope where the weight
    /// is free, a slope into the bound where it is not.
    #[test]
    fn weights_are_the_minimum_under_bounds() {
        let surface = cap(3);
        let rim = rim(&surface, |_| false);
        let handles = spread_points(&surface, &rim, 6, &|_| Vec::new()).unwrap();
        let problem = Problem::new(&surface, &rim, &handles);
        let targets: Vec<Vec<usize>> = handles.iter().map(|&v| vec![v]).collect();
        let mut active = 0;
        for (ones, start) in targets.iter().zip(problem.unbounded(&targets).unwrap()) {
            let w = problem.bounded(ones, start);
            for &v in &problem.free {
                let slope: f64 = problem.energy[v].iter().map(|(&j, q)| q * w[j]).sum();
                let scale = 1e-6 * problem.energy[v][&v];
                active += usize::from(w[v] < 1e-7);
                assert!(w[v] < 1e-5 || slope < scale, "{} {}", w[v], slope / scale);
                assert!(w[v] > 1.0 - 1e-5 || slope > -scale, "{} {}", w[v], slope / scale);
            }
        }
        assert!(active > 100, "only {active} weights at a bound");
    }

    #[test]
    fn a_component_without_rim_or_handle_stays() {
        let ball = sphere(1);
        let n = ball.vertices.len();
        let mut two = ball.clone();
        two.vertices.extend(ball.vertices.iter().map(|v| v + 5.0 * Vec3::x()));
        two.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + n)));
        let weights = bounded_biharmonic(&two, &[], &[0, 3]).unwrap();
        for v in 0..2 * n {
            let sum: f64 = weights.iter().map(|w| w[v]).sum();
            let expected = if v < n { 1.0 } else { 0.0 };
            assert!((sum - expected).abs() < 1e-8, "{sum}");
        }
    }

    #[test]
    fn linear_functions_are_harmonic_and_areas_add_up() {
        let n = 8;
        let surface = square(n, 0.3);
        let (rows, areas) = cotangent_laplacian(&surface);
        assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        assert!(areas.iter().all(|&a| a > 0.0));
        let f = |v: usize| 3.0 * surface.vertices[v].x - 2.0 * surface.vertices[v].y + 1.0;
        for (v, row) in rows.iter().enumerate() {
            let interior = v % (n + 1) % n != 0 && v / (n + 1) % n != 0;
            let sum: f64 = row.iter().map(|(&w, c)| c * f(w)).sum();
            assert!(!interior || sum.abs() < 1e-12, "{sum}");
        }
    }

    #[test]
    fn the_unit_of_length_does_not_matter() {
        let surface = square(8, 0.2);
        let mut small = surface.clone();
        small.vertices.iter_mut().for_each(|v| *v *= 1e-3);
        let rim = rim(&surface, |_| false);
        let handles = spread_points(&surface, &rim, 3, &|_| Vec::new()).unwrap();
        let a = bounded_biharmonic(&surface, &rim, &handles).unwrap();
        let b = bounded_biharmonic(&small, &rim, &handles).unwrap();
        let differences = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(differences.fold(0.0, f64::max) < 1e-6);
    }
}
