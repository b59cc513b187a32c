//! What the machine can do: dense products, and sums of long vectors.

use criterion::Throughput;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

use crate::Bench;

/// The row whose time is the unit of all others.
pub const PRODUCT: &str = "dgemm";
/// Order of the matrices that are multiplied.
const ORDER: usize = 2000;
/// Length of the vectors that are added: far longer than what caches hold.
const VECTOR: usize = 30_000_000;
/// Numbers that a thread adds at once.
const CHUNK: usize = 1 << 16;

/// C = A B on all threads, and a = b + s c, as in McCalpin's STREAM: b and c read, a written.
pub fn time(bench: &mut Bench) {
    let n = ORDER;
    let a = Mat::<f64>::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64);
    let mut c = Mat::<f64>::zeros(n, n);
    let operations = Throughput::Elements(2 * (n as u64).pow(3));
    // in threads of its own, as faer leaves one waiting, which the rows that follow would lack
    let pool = rayon::ThreadPoolBuilder::new().build().expect("threads");
    bench.time([PRODUCT, "2000"], operations, || {
        pool.install(|| {
            matmul(c.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0, Par::rayon(0));
        });
    });
    let (mut a, b, c) = (vec![0.0; VECTOR], vec![1.0; VECTOR], vec![2.0; VECTOR]);
    let bytes = Throughput::Bytes((3 * size_of::<f64>() * VECTOR) as u64);
    bench.time(["triad", "30M"], bytes, || {
        let parts = a.par_chunks_mut(CHUNK).zip(b.par_chunks(CHUNK)).zip(c.par_chunks(CHUNK));
        parts.for_each(|((a, b), c)| {
            a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 0.5 * c);
        });
    });
}
