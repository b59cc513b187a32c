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

impl Time {
    /// Processor time over time on the clock; none for no time.
    pub fn busy_cores(&self) -> Option<f64> {
        (self.wall_s > 0.0).then(|| self.processor_s / self.wall_s)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two threads that are busy for a while take twice that in processor time, if the
    /// machine lets them; sleep takes none.
    #[test]
    fn processor_time_counts_threads_and_not_sleep() {
        let clock = Clock::start();
        std::thread::sleep(Duration::from_millis(30));
        let slept = clock.elapsed();
        assert!(slept.wall_s >= 0.03);
        // other tests run in the same process, so that there is no upper limit
        let clock = Clock::start();
        let spin = || {
            let own = cpu_time::ThreadTime::now();
            while own.elapsed() < Duration::from_millis(20) {
                std::hint::spin_loop();
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(spin);
            scope.spawn(spin);
        });
        let busy = clock.elapsed();
        assert!(busy.processor_s >= 0.04, "{busy:?}");
        assert!(busy.busy_cores().is_some_and(|cores| cores > 0.0));
        assert_eq!(Time::default().busy_cores(), None);
    }
}
