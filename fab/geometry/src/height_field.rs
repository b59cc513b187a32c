//! The surface that separates the two shells, as the solid below it.
//!
//! Coordinates here have z along the pull. A planar parting is a half-space; a
//! curved one is a height z_p(x, y) over a grid of columns:
//!
//! 1. z_p = (top + bottom)/2 of the filled part in every covered column, of its
//!    longest interval if there are several;
//! 2. outside, the harmonic extension Δz_p = 0 with free edges, and a level rim for
//!    keys and bolts;
//! 3. the slope along the rows limited to tan(max slope), by the mean of the largest
//!    function below and the smallest above with that Lipschitz constant: steps, as
//!    between a limb and what hangs over it, become flanks;
//! 4. Gaussian smoothing, which keeps the limit.

use mesh::{SurfaceMesh, Vec3};

use crate::columns::{Grid, Layer, middle_of_longest};

/// The harmonic extension has converged when no height changes by more [m].
const CONVERGED: f64 = 1e-7;

/// The parting height at each node of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    /// The grid.
    pub grid: Grid,
    /// Height at each node [m].
    pub heights: Vec<f64>,
    /// Height of the rim [m].
    pub level: f64,
}

impl Terrain {
    /// The parting height for a part given by its columns. The rim is what lies
    /// outside of the rectangle `within` = [low, high] [m]. Nowhere is it steeper than `max_slope` [rad], and it is
    /// smoothed over a length [m].
    pub fn new(
        grid: Grid,
        columns: &[Vec<Layer>],
        within: [[f64; 2]; 2],
        max_slope: f64,
        smoothing: f64,
    ) -> Self {
        let middles: Vec<Option<f64>> =
            columns.iter().map(|column| middle_of_longest(column)).collect();
        let mut heights = extend(&grid, &middles);
        let on_rim = |v: usize| {
            let p = grid.point(v);
            (0..2).any(|k| p[k] <= within[0][k] || p[k] >= within[1][k])
        };
        let rim: Vec<usize> = (0..grid.len()).filter(|&v| on_rim(v)).collect();
        let level = rim.iter().map(|&v| heights[v]).sum::<f64>() / rim.len().max(1) as f64;
        let mut fixed = middles;
        rim.iter().for_each(|&v| fixed[v] = Some(level));
        heights = extend(&grid, &fixed);
        limit_slope(&grid, &mut heights, max_slope.tan());
        blur(&grid, &mut heights, smoothing);
        rim.iter().for_each(|&v| heights[v] = level);
        Self { grid, heights, level }
    }

    /// The surface of the solid between height `floor` and the parting.
    pub fn surface(&self, floor: f64) -> SurfaceMesh {
        let [nx, ny] = self.grid.count;
        let n = self.grid.len();
        let at = |i, j| self.grid.index(i, j);
        let mut vertices: Vec<Vec3> = (0..n)
            .map(|node| {
                let [x, y] = self.grid.point(node);
                Vec3::new(x, y, self.heights[node])
            })
            .collect();
        let mut triangles = Vec::with_capacity(2 * n);
        for j in 0..ny - 1 {
            for i in 0..nx - 1 {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        // The edge of the grid counter-clockwise, walls down from it, and a bottom.
        let south = (0..nx - 1).map(|i| at(i, 0));
        let east = (0..ny - 1).map(|j| at(nx - 1, j));
        let north = (1..nx).rev().map(|i| at(i, ny - 1));
        let west = (1..ny).rev().map(|j| at(0, j));
        let edge: Vec<usize> = south.chain(east).chain(north).chain(west).collect();
        vertices.extend(edge.iter().map(|&v| {
            let [x, y] = self.grid.point(v);
            Vec3::new(x, y, floor)
        }));
        let [x0, y0] = self.grid.point(0);
        let [x1, y1] = self.grid.point(n - 1);
        let centre = vertices.len();
        vertices.push(Vec3::new((x0 + x1) / 2.0, (y0 + y1) / 2.0, floor));
        for k in 0..edge.len() {
            let next = (k + 1) % edge.len();
            let [a, b, c, d] = [edge[k], edge[next], n + next, n + k];
            triangles.extend([[b, a, d], [b, d, c], [c, d, centre]]);
        }
        SurfaceMesh { vertices, triangles }
    }
}

/// The harmonic function with the given values, free where there are none and at
/// the edge of the grid, by successive over-relaxation.
fn extend(grid: &Grid, fixed: &[Option<f64>]) -> Vec<f64> {
    let known: Vec<f64> = fixed.iter().flatten().copied().collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let mut heights: Vec<f64> = fixed.iter().map(|f| f.unwrap_or(mean)).collect();
    let free: Vec<(usize, Vec<usize>)> = (0..grid.len())
        .filter(|&v| fixed[v].is_none())
        .map(|v| (v, grid.neighbours(v).collect()))
        .collect();
    // Optimal for the Laplacian on a rectangle of this size.
    let size = grid.count[0].max(grid.count[1]) as f64;
    let relaxation = 2.0 / (1.0 + (std::f64::consts::PI / size).sin());
    for _ in 0..100 * grid.count[0].max(grid.count[1]) {
        let mut change: f64 = 0.0;
        for (v, around) in &free {
            let average = around.iter().map(|&n| heights[n]).sum::<f64>() / around.len() as f64;
            let step = relaxation * (average - heights[*v]);
            heights[*v] += step;
            change = change.max(step.abs());
        }
        if change <= CONVERGED {
            break;
        }
    }
    heights
}

/// Convolves with a Gaussian of standard deviation `sigma` [m], mirrored at the edges.
fn blur(grid: &Grid, heights: &mut [f64], sigma: f64) {
    let s = sigma / grid.step;
    let reach = (3.0 * s).ceil() as isize;
    let kernel: Vec<f64> =
        (-reach..=reach).map(|k| (-0.5 * (k as f64 / s).powi(2)).exp()).collect();
    let total: f64 = kernel.iter().sum();
    let mirror = |i: isize, n: usize| {
        let n = n as isize;
        let i = if i < 0 { -i } else { i };
        (if i >= n { 2 * (n - 1) - i } else { i }).clamp(0, n - 1) as usize
    };
    let [nx, ny] = grid.count;
    for axis in 0..2 {
        let before = heights.to_vec();
        for j in 0..ny {
            for i in 0..nx {
                let value = |k: isize| match axis {
                    0 => before[grid.index(mirror(i as isize + k, nx), j)],
                    _ => before[grid.index(i, mirror(j as isize + k, ny))],
                };
                let sum: f64 = (-reach..=reach).zip(&kernel).map(|(k, w)| w * value(k)).sum();
                heights[grid.index(i, j)] = sum / total;
            }
        }
    }
}

/// Limits the difference of neighbours to `slope` times the step.
fn limit_slope(grid: &Grid, heights: &mut [f64], slope: f64) {
    let rise = slope * grid.step;
    let below = envelope(grid, heights, rise);
    let mirrored: Vec<f64> = heights.iter().map(|h| -h).collect();
    let above = envelope(grid, &mirrored, rise);
    for (v, height) in heights.iter_mut().enumerate() {
        *height = (below[v] - above[v]) / 2.0;
    }
}

/// The largest function not above `heights` whose neighbours differ by at most
/// `rise`: min over w of heights(w) + rise · (steps from v to w), in two sweeps.
fn envelope(grid: &Grid, heights: &[f64], rise: f64) -> Vec<f64> {
    let mut result = heights.to_vec();
    let mut relax = |v: usize| {
        for n in grid.neighbours(v) {
            result[v] = result[v].min(result[n] + rise);
        }
    };
    (0..grid.len()).for_each(&mut relax);
    (0..grid.len()).rev().for_each(&mut relax);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid { origin: [0.0, 0.0], step: 1.0, count: [40, 30] }
    }

    #[test]
    fn the_extension_is_harmonic_and_keeps_what_is_given() {
        let grid = grid();
        // x² − y² is harmonic; free edges would flatten it, so the edge is given.
        let exact = |v: usize| {
            let [x, y] = grid.point(v);
            (x * x - y * y) / 1e3
        };
        let on_edge = |v: usize| grid.neighbours(v).count() < 4;
        let fixed: Vec<Option<f64>> =
            (0..grid.len()).map(|v| on_edge(v).then(|| exact(v))).collect();
        let heights = extend(&grid, &fixed);
        // The five-point formula is exact on quadratics: only the iteration errs.
        for (v, height) in heights.iter().enumerate() {
            assert!((height - exact(v)).abs() < 1e-5, "{v}");
        }
    }

    #[test]
    fn slopes_are_limited_and_gentle_heights_kept() {
        let grid = grid();
        let gentle: Vec<f64> = (0..grid.len()).map(|v| 0.5 * grid.point(v)[0]).collect();
        let mut heights = gentle.clone();
        limit_slope(&grid, &mut heights, 0.6);
        assert_eq!(heights, gentle);
        heights[grid.index(20, 15)] += 30.0;
        limit_slope(&grid, &mut heights, 0.6);
        for v in 0..grid.len() {
            for n in grid.neighbours(v) {
                assert!((heights[v] - heights[n]).abs() <= 0.6 + 1e-9);
            }
        }
    }

    #[test]
    fn a_ball_is_parted_at_its_equator_and_the_rim_is_level() {
        let grid = grid();
        let ball = |[x, y]: [f64; 2], middle: f64| -> Vec<Layer> {
            let depth = 64.0 - (x - 20.0).powi(2) - (y - 15.0).powi(2);
            let half = (depth > 0.0).then(|| depth.sqrt());
            half.map(|half| [middle - half, middle + half]).into_iter().collect()
        };
        let columns = |middle: fn([f64; 2]) -> f64| -> Vec<Vec<Layer>> {
            (0..grid.len()).map(|v| ball(grid.point(v), middle(grid.point(v)))).collect()
        };
        let terrain = |middle| {
            let within = [[4.0, 3.0], [36.0, 26.0]];
            Terrain::new(grid.clone(), &columns(middle), within, 75f64.to_radians(), 1.5)
        };
        let heights = terrain(|_| 5.0).heights;
        assert!(heights.iter().all(|h| (h - 5.0).abs() < 1e-5));
        // A tilted body has a sloping outline, but a level rim.
        let terrain = terrain(|[x, y]| 5.0 + 0.1 * y + 0.05 * x);
        let edge = |v: &usize| {
            let [x, y] = grid.point(*v);
            !(4.0..36.0).contains(&x) || !(3.0..26.0).contains(&y)
        };
        assert!((0..grid.len()).filter(edge).all(|v| terrain.heights[v] == terrain.level));
        let range =
            terrain.heights.iter().fold([f64::MAX, f64::MIN], |[a, b], h| [a.min(*h), b.max(*h)]);
        assert!(range[1] - range[0] > 0.5, "{range:?}");
    }
}
