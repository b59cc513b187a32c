//! The speed of this machine, in some milliseconds.

use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// Order of the matrices that are multiplied to measure the machine.
const ORDER: usize = 768;
/// Products, of which the fastest counts.
const PRODUCTS: usize = 8;

/// Operations per second of a matrix product in single precision on all threads.
pub fn product_speed() -> f64 {
    let a = Mat::<f32>::from_fn(ORDER, ORDER, |i, j| ((i * 7 + j * 3) % 11) as f32);
    let mut c = Mat::<f32>::zeros(ORDER, ORDER);
    let mut fastest = f64::INFINITY;
    for _ in 0..PRODUCTS {
        let start = Instant::now();
        let par = Par::rayon(0);
        matmul(c.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0, par);
        fastest = fastest.min(start.elapsed().as_secs_f64());
    }
    2.0 * (ORDER as f64).powi(3) / fastest
}
