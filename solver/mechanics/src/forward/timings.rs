//! Where computing time goes.

use std::ops::AddAssign;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};

use crate::energy::Nature;

/// Time that some work took. Divided by each other, the two are the number of cores that
/// were busy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// On the clock [s].
    pub wall_s: f64,
    /// Time of all threads together [s].
    pub processor_s: f64,
}

impl AddAssign for Time {
    fn add_assign(&mut self, other: Self) {
        self.wall_s += other.wall_s;
        self.processor_s += other.processor_s;
    }
}

/// Measures [`Time`] from its start on.
pub struct Clock {
    wall: Instant,
    processor: ProcessTime,
}

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        Self { wall: Instant::now(), processor: ProcessTime::now() }
    }

    /// Since the start. What other threads of the process do at the same time counts.
    pub fn elapsed(&self) -> Time {
        let (wall, processor) = (self.wall.elapsed(), self.processor.elapsed());
        let [wall_s, processor_s] = [wall, processor].map(|t: Duration| t.as_secs_f64());
        Time { wall_s, processor_s }
    }
}

/// Computing time by task.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Sparsity pattern, ordering and symbolic factorisation.
    pub ordering: Time,
    /// Values, gradients and Hessians of all energies but contact and friction.
    pub assembly: Time,
    /// Values, gradients and Hessians of contact and friction, and the search for close pairs.
    pub contact: Time,
    /// Numerical factorisation.
    pub factor: Time,
    /// Triangular solves, with the products around them.
    pub solve: Time,
    /// Step lengths by collision detection.
    pub collision: Time,
    /// Certificates of positive volume, and of surfaces that do not intersect.
    pub certificate: Time,
    /// Results and checkpoints that were written during the run.
    pub output: Time,
    /// Numerical factorisations, failed ones included.
    pub factorizations: usize,
    /// Those that met a pivot that is not positive.
    pub failed_factorizations: usize,
}

impl Timings {
    /// Does some work for a term of the energy, and counts its time.
    pub fn of<T>(&mut self, nature: Nature, work: impl FnOnce() -> T) -> T {
        let clock = Clock::start();
        let result = work();
        let task = if nature.is_contact() { &mut self.contact } else { &mut self.assembly };
        *task += clock.elapsed();
        result
    }

    /// The tasks by name.
    pub fn tasks(&self) -> [(&'static str, Time); 8] {
        [
            ("ordering", self.ordering),
            ("assembly", self.assembly),
            ("contact", self.contact),
            ("factor", self.factor),
            ("solve", self.solve),
            ("collision", self.collision),
            ("certificate", self.certificate),
            ("output", self.output),
        ]
    }

    /// All tasks together.
    pub fn total(&self) -> Time {
        let mut total = Time::default();
        self.tasks().into_iter().for_each(|(_, time)| total += time);
        total
    }
}
