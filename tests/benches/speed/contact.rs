//! Cost of collision detection: candidates (broad phase), the bound on a step (CCD), and
//! the proof that nothing intersects, on two bumpy sheets that come together.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use mechanics::contact::candidates::between;
use mechanics::contact::ccd::max_step;
use mechanics::contact::certificate::certify;
use mechanics::contact::pairs::Features;
use mesh::Vec3;
use program::peak_rss_mb;

use crate::row::{Row, Seconds, Work, find};
use crate::scaling::Curve;

/// Sheets by their names, and squares along an edge: four triangles each, as
/// there are two sheets.
const SHEETS: [(&str, usize); 5] = [
    ("sheets10k", 50),
    ("sheets30k", 87),
    ("sheets100k", 158),
    ("sheets300k", 274),
    ("sheets1000k", 500),
];

/// What is timed, as the table names it.
const STEPS: [&str; 4] =
    ["contact candidates", "contact step", "contact proof", "contact, far step"];

const RUNS: usize = 5;

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

    /// Times every step in this process.
    fn rows(&self, body: &str) -> Result<Vec<Row>> {
        let features = Features::new(&self.facets);
        let search = |end: &[Vec3]| between(&features, &self.start, end, self.radius, |_| false);
        let row = |what: &str, seconds, beside| -> Result<Row> {
            let dofs = 3 * self.start.len();
            Ok(Row {
                what: what.to_owned(),
                body: body.to_owned(),
                dofs: Some(dofs),
                seconds,
                one_thread_s: None,
                work: Work::Dofs(dofs as f64),
                peak_mb: Some(peak_rss_mb().context("no VmHWM in /proc/self/status")?),
                beside,
            })
        };
        let (time, pairs) = timed(|| search(&self.end));
        let pairs = pairs.context("of these sheets only near pairs meet")?;
        let found = format!("{} pairs of {} triangles", pairs.len(), self.facets.len());
        let mut rows = vec![row(STEPS[0], time, found)?];
        let (time, step) = timed(|| max_step(&pairs, &self.start, &self.end, 0.0));
        rows.push(row(STEPS[1], time, format!("ends at {step:.3}"))?);
        let (time, proof) = timed(|| certify(&self.facets, &self.start, |_| true));
        proof.context("these sheets are apart")?;
        rows.push(row(STEPS[2], time, String::new())?);
        // every vertex somewhere else: everything meets everything
        let len = self.start.len();
        let far: Vec<Vec3> = (0..len).map(|v| self.start[v * 7919 % len] * 100.0).collect();
        let (time, refused) = timed(|| search(&far));
        ensure!(refused.is_err(), "a far step was not refused");
        let mut last = row(STEPS[3], time, String::new())?;
        let peaks = [rows[2].peak_mb, last.peak_mb].map(Option::unwrap_or_default);
        last.beside = format!("refused; peak memory {:.0} MB, {:.0} before", peaks[1], peaks[0]);
        rows.push(last);
        Ok(rows)
    }
}

/// How long some runs take, and what the last returns.
fn timed<T>(run: impl Fn() -> T) -> (Seconds, T) {
    let once = || {
        let clock = Instant::now();
        let result = run();
        (clock.elapsed().as_secs_f64(), result)
    };
    let mut seconds: Vec<f64> = (1..RUNS).map(|_| once().0).collect();
    let (last, result) = once();
    seconds.push(last);
    (Seconds::new(seconds), result)
}

/// Measures one case in this process and prints its rows.
pub fn child(name: &str) -> Result<()> {
    let Some((_, n)) = SHEETS.into_iter().find(|s| s.0 == name) else { bail!("no {name:?}") };
    serde_json::to_writer(std::io::stdout(), &Sheets::new(n).rows(name)?)?;
    Ok(())
}

/// The rows that are wanted, each case in a process of its own for its memory.
pub fn rows(wanted: &dyn Fn(&str) -> bool) -> Result<Vec<Row>> {
    let mut all = Vec::new();
    for (name, _) in SHEETS {
        let asked = |what: &str| wanted(&format!("{what}/{name}"));
        if !STEPS.iter().any(|what| asked(what)) {
            continue;
        }
        eprintln!("bringing {name} together");
        let output = Command::new(std::env::current_exe()?)
            .args(["--contact", name])
            .stderr(Stdio::inherit())
            .output()?;
        ensure!(output.status.success(), "contact of {name} failed: {}", output.status);
        let rows: Vec<Row> = serde_json::from_slice(&output.stdout)?;
        all.extend(rows.into_iter().filter(|row| asked(&row.what)));
    }
    Ok(all)
}

/// Cost over the number of triangles.
pub fn curves(rows: &[Row]) -> Vec<Curve> {
    let curve = |what: &'static str| {
        let time = |(name, n): (&str, usize)| {
            Some(((4 * n * n) as f64, find(rows, what, name)?.seconds.median))
        };
        Curve { what, unit: "s", points: SHEETS.into_iter().filter_map(time).collect() }
    };
    let memory = |(name, n): (&str, usize)| {
        Some(((4 * n * n) as f64, find(rows, STEPS[2], name)?.peak_mb? * 1.048_576e-3))
    };
    let memory = SHEETS.into_iter().filter_map(memory).collect();
    let mut curves: Vec<Curve> = STEPS[..3].iter().map(|what| curve(what)).collect();
    curves.push(Curve { what: "peak memory", unit: "GB", points: memory });
    curves
}
