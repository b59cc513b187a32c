//! What the machine can do at most: dense products and factorisations, and sums of long vectors.

use std::time::Instant;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::traits::RealField;
use faer::{Accum, Mat, Par, Spec};
use rayon::prelude::*;

use crate::row::{Row, Seconds, Work};

/// Order of the matrices that are multiplied.
const PRODUCT: usize = 4000;
/// Length of the vectors that are added: far longer than what caches hold.
const VECTOR: usize = 30_000_000;
/// Numbers that a thread adds at once.
const CHUNK: usize = 1 << 16;
/// Runs of each.
const RUNS: usize = 3;

/// One thread, and all.
fn threads() -> [(usize, Par); 2] {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    [(1, Par::Seq), (all, Par::rayon(all))]
}

/// The name of a row on some threads.
pub fn name(what: &str, threads: usize) -> String {
    format!("{what}, {threads} thread{}", if threads == 1 { "" } else { "s" })
}

/// C = A B in double and in single precision, and a = b + s c.
pub fn limits() -> Vec<Row> {
    let mut rows = products::<f64>("dgemm");
    rows.extend(products::<f32>("sgemm"));
    rows.extend(triad());
    rows
}

/// C = A B.
fn products<T: RealField + From<f32>>(what: &str) -> Vec<Row> {
    let n = PRODUCT;
    let a = Mat::<T>::from_fn(n, n, |i, j| (((i * 7 + j * 3) % 11) as f32).into());
    let mut c = Mat::<T>::zeros(n, n);
    let one = |(threads, par)| {
        let mut run =
            || matmul(c.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0_f32.into(), par);
        let flops = Work::Flops(2.0 * (n as f64).powi(3));
        row(name(what, threads), n, flops, (0..RUNS).map(|_| timed(&mut run)).collect())
    };
    threads().map(one).into_iter().collect()
}

/// a = b + s c of long vectors in double precision, as in McCalpin's STREAM: b and c read, a written.
fn triad() -> Vec<Row> {
    let (mut a, b, c) = (vec![0.0; VECTOR], vec![1.0; VECTOR], vec![2.0; VECTOR]);
    let one = |(threads, _)| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut run = || {
            let parts = a.par_chunks_mut(CHUNK).zip(b.par_chunks(CHUNK)).zip(c.par_chunks(CHUNK));
            parts.for_each(|((a, b), c)| {
                a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 0.5 * c);
            });
        };
        // pages are there only once they were written
        pool.install(&mut run);
        let seconds = pool.install(|| (0..RUNS).map(|_| timed(&mut run)).collect());
        let bytes = Work::Bytes(3.0 * size_of::<f64>() as f64 * VECTOR as f64);
        Row { body: format!("{VECTOR} numbers"), ..row(name("triad", threads), 0, bytes, seconds) }
    };
    threads().map(one).into_iter().collect()
}

/// The rate of a product on all threads [operations/s].
pub fn fastest_product(rows: &[Row]) -> Option<f64> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let row = rows.iter().find(|row| row.what == name("dgemm", all))?;
    let Work::Flops(flops) = row.work else { return None };
    Some(flops / row.seconds.median)
}

/// A = L Lᵀ of the order that takes as many operations as a sparse factorisation.
pub fn factorisations(body: &str, flops: f64) -> Vec<Row> {
    let n = (3.0 * flops).cbrt().round() as usize;
    let one = |(threads, par)| {
        let mut a = Mat::<f64>::zeros(n, n);
        let mut scratch = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, par, Spec::default()));
        let mut runs = Vec::new();
        for _ in 0..RUNS {
            for j in 0..n {
                a.col_as_slice_mut(j).fill(1.0);
                a[(j, j)] = n as f64;
            }
            runs.push(timed(|| {
                let stack = MemStack::new(&mut scratch);
                cholesky_in_place(a.as_mut(), Default::default(), par, stack, Spec::default())
                    .expect("the diagonal dominates");
            }));
        }
        let what = name("dense LLᵀ", threads);
        Row { body: format!("as {body}"), ..row(what, n, Work::Flops(flops), runs) }
    };
    threads().map(one).into_iter().collect()
}

fn timed(mut run: impl FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn row(what: String, n: usize, work: Work, runs: Vec<f64>) -> Row {
    Row {
        what,
        body: format!("{n} × {n}"),
        dofs: None,
        seconds: Seconds::new(runs),
        one_thread_s: None,
        work,
        peak_mb: None,
        beside: String::new(),
    }
}
