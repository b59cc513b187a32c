//! How far variables move the surface.

use mesh::Vec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::DesignMap;
use crate::vectors::{moved, products};

/// Motion of the surface by which runs are varied, over its mean edge [1]. Forces are differences of residuals, whose second
/// order is large where elements are flat and hardly change their volume: with 1e-5 changes were off by 2 to 4 %, and steps
/// met a target by thirds; with 1e-8 by squares. There they were off by 2e-5 of the largest on that body.
const VARIATION: f64 = 1e-8;

impl DesignMap {
    /// Mean square of the motion of the moving surface as a quadratic form in a step from θ; the variables of loads
    /// count as motions.
    pub fn metric(&self, theta: &[f64]) -> DMatrix<f64> {
        let sizes = self.variations(theta);
        let shapes = self.shape_variables();
        let here = self.surface(theta);
        let column = |i: usize| -> Vec<f64> {
            let there = self.surface(&moved(theta, i, sizes[i]));
            let motion = |(a, b): (&Vec3, &Vec3)| (a - b) / sizes[i];
            there.iter().zip(&here).map(motion).flat_map(|d| [d.x, d.y, d.z]).collect()
        };
        let columns: Vec<Vec<f64>> = (0..shapes).into_par_iter().map(column).collect();
        let moving = columns.iter().fold(vec![false; 3 * here.len()], |mut all, column| {
            all.iter_mut().zip(column).for_each(|(all, d)| *all |= *d != 0.0);
            all
        });
        let count = (moving.iter().filter(|moves| **moves).count() as f64 / 3.0).max(1.0);
        let mut metric = DMatrix::identity(theta.len(), theta.len());
        metric
            .view_mut((0, 0), (shapes, shapes))
            .copy_from(&(products(&columns, &columns) / count));
        metric
    }

    /// How far each variable is varied.
    pub fn variations(&self, theta: &[f64]) -> Vec<f64> {
        let small = VARIATION * self.mean_edge;
        let size =
            |i| small * small / self.motion(theta, &moved(theta, i, small)).max(1e-3 * small);
        (0..theta.len()).map(size).collect()
    }
}
