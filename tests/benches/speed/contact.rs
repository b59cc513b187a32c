//! Cost of collision detection: candidates (broad phase), the bound on a step (CCD), and
//! the proof that nothing intersects, on two bumpy sheets that come together.

use anyhow::{Context, Result};
use criterion::Throughput;
use mechanics::contact::candidates::between;
use mechanics::contact::ccd::max_step;
use mechanics::contact::certificate::certify;
use mechanics::contact::pairs::Features;
use mesh::Vec3;

use crate::Bench;

/// Sheets by their names, and squares along an edge: four triangles each, as
/// there are two sheets.
const SHEETS: [(&str, usize); 3] = [("sheets10k", 50), ("sheets100k", 158), ("sheets1000k", 500)];

/// What is timed.
const STEPS: [&str; 4] =
    ["contact candidates", "contact step", "contact proof", "contact, far step"];

/// Edge of a sheet [m].
const SIZE: f64 = 0.1;

/// Two sheets, one above the other, and where they would like to go.
struct Sheets {
    facets: Vec<[usize; 3]>,
    start: Vec<Vec3>,
    end: Vec<Vec3>,
    /// Activation distance, an eighth of a square [m].
    radius: f64,
}

impl Sheets {
    /// Half a square apart; the upper one goes down by three quarters of one and a
    /// little aside, so that they meet.
    fn new(n: usize) -> Self {
        let square = SIZE / n as f64;
        let side = n + 1;
        let point = |v: usize| {
            let (sheet, i, j) = (v / (side * side), v / side % side, v % side);
            let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
            let bumps = 0.05 * SIZE * (9.0 * x).sin() * (7.0 * y).cos();
            let own = 0.2 * square * sheet as f64 * (3.0 + (40.0 * x + 30.0 * y).sin());
            Vec3::new(SIZE * x, SIZE * y, bumps + own)
        };
        let start: Vec<Vec3> = (0..2 * side * side).map(point).collect();
        let away = Vec3::new(0.2, 0.1, -0.75) * square;
        let upper = |v: usize| if v < side * side { Vec3::zeros() } else { away };
        let end = start.iter().enumerate().map(|(v, p)| p + upper(v)).collect();
        let facets = (0..2 * n * n).flat_map(|s| {
            let a = s / (n * n) * side * side + s / n % n * side + s % n;
            let (b, c, d) = (a + side, a + side + 1, a + 1);
            [[a, b, c], [a, c, d]]
        });
        Self { facets: facets.collect(), start, end, radius: square / 8.0 }
    }
}

/// All sheets.
pub fn time(bench: &mut Bench) -> Result<()> {
    for (name, n) in SHEETS {
        if STEPS.iter().any(|step| bench.wants(step, name)) {
            Sheets::new(n).time(bench, name)?;
        }
    }
    Ok(())
}

impl Sheets {
    fn time(&self, bench: &mut Bench, name: &str) -> Result<()> {
        let features = Features::new(&self.facets);
        let search = |end: &[Vec3]| between(&features, &self.start, end, self.radius, &|_| false);
        let dofs = || Throughput::Elements(3 * self.start.len() as u64);
        let [candidates, step, proof, far_step] = STEPS.map(|what| [what, name]);
        let pairs = search(&self.end).context("of these sheets only near pairs meet")?;
        bench.time(candidates, dofs(), || search(&self.end));
        bench.time(step, dofs(), || max_step(&pairs, &self.start, &self.end, 0.0));
        bench.time(proof, dofs(), || {
            certify(&self.facets, &self.start, |_| true).expect("these sheets are apart");
        });
        // every vertex somewhere else: everything meets everything
        let len = self.start.len();
        let far: Vec<Vec3> = (0..len).map(|v| self.start[v * 7919 % len] * 100.0).collect();
        bench.time(far_step, dofs(), || {
            assert!(search(&far).is_err(), "a far step was not refused")
        });
        Ok(())
    }
}
