//! A measurement and what it is compared with.

use serde::{Deserialize, Serialize};

/// Seconds of repeated runs.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Seconds {
    /// Half of the runs took longer.
    pub median: f64,
    /// The fastest run.
    pub min: f64,
    /// The slowest.
    pub max: f64,
    /// Number of runs.
    pub runs: usize,
}

impl Seconds {
    /// Of at least one run.
    pub fn new(mut runs: Vec<f64>) -> Self {
        runs.sort_by(f64::total_cmp);
        let n = runs.len();
        let median = f64::midpoint(runs[(n - 1) / 2], runs[n / 2]);
        Self { median, min: runs[0], max: runs[n - 1], runs: n }
    }
}

/// Work of one run, by which its time is turned into a rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Work {
    /// Degrees of freedom.
    Dofs(f64),
    /// Operations on numbers.
    Flops(f64),
    /// Bytes read.
    Bytes(f64),
}

impl Work {
    /// The rate at a time, with its unit.
    pub fn rate(self, seconds: f64) -> String {
        match self {
            Self::Dofs(n) => format!("{:.1} kdof/s", 1e-3 * n / seconds),
            Self::Flops(n) => format!("{:.1} GFLOP/s", 1e-9 * n / seconds),
            Self::Bytes(n) => format!("{:.1} GB/s", 1e-9 * n / seconds),
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// What was done.
    pub what: String,
    /// On which body.
    pub body: String,
    /// Degrees of freedom; none for dense matrices.
    pub dofs: Option<usize>,
    /// How long it took on all threads, or on those that its name says.
    pub seconds: Seconds,
    /// On one thread, where that was measured beside it [s].
    #[serde(default)]
    pub one_thread_s: Option<f64>,
    /// How much it was.
    pub work: Work,
    /// Largest resident set [MiB], where a process of its own did it.
    #[serde(default)]
    pub peak_mb: Option<f64>,
    /// The same in other numbers: against the dense rate, or another solver.
    #[serde(default)]
    pub beside: String,
}

impl Row {
    /// What identifies a row.
    pub fn key(&self) -> String {
        format!("{}/{}", self.what, self.body)
    }

    /// How much faster all threads are than one.
    pub fn speed_up(&self) -> Option<f64> {
        self.one_thread_s.map(|one| one / self.seconds.median)
    }
}

/// The row of a key.
pub fn find<'a>(rows: &'a [Row], what: &str, body: &str) -> Option<&'a Row> {
    rows.iter().find(|row| row.what == what && row.body == body)
}
