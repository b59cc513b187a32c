//! `[[relaxation]]`: stress that a material has for a while beside that of its law.

use anyhow::{Result, ensure};
use mechanics::energy::Viscous;
use program::table::Range;
use program::{KeyPath, misfit};

use super::{Around, Known, Region, TableNumber, TermTable, value};

program::table! {
    /// A Maxwell branch beside the laws of bodies: one term of a Prony series. The law alone is what is
    /// left after a long time; stresses of result files are those of the law.
    #[derive(Clone, Debug)]
    pub struct RelaxationConfig {
        /// The body or volume.
        on: Option<String> = None => "all";
        /// Isochoric stress that a sudden strain adds, as a part of that of the law [1].
        overstress: f64, Range::POSITIVE.advice("; expected a part of the stress of the law, such as 0.1");
        /// Relaxation time, after which 1/e of it is left under constant strain [s].
        time: f64, Range::POSITIVE.unit("s");
    }
}

impl TermTable for RelaxationConfig {
    const LIST: &'static str = "relaxation";
    const PATHS: &'static str = "relaxation.N.overstress or .time";
    const MEANING: &'static str = "a number of the N-th [[relaxation]], counted from 1";

    fn name(&self, place: usize) -> String {
        (place + 1).to_string()
    }

    fn in_words(&self) -> Option<String> {
        let Self { on, overstress, time } = self;
        let on = on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
        Some(format!(
            "relaxation{on}: {:.1} % more isochoric stress at once, for {time} s",
            100.0 * overstress
        ))
    }

    fn check(all: &[Self], around: &Around) -> Result<()> {
        ensure!(
            all.is_empty() || around.in_time,
            misfit!(
                KeyPath::list("relaxation"),
                " without [time]: a scene without time steps has no rate; its state is that after a long \
                 time, of the law alone. Expected [time], with method = \"quasistatic\" where inertia does \
                 not matter"
            )
        );
        Ok(())
    }

    fn numbers(&mut self) -> Vec<TableNumber<'_>> {
        let Self { overstress, time, .. } = self;
        vec![value("overstress", "1", overstress), value("time", "s", time)]
    }

    /// Each law has the branches of the tables that are of it, one after the other.
    fn derivative(all: &[Self], place: usize, key: &str, known: &Known) -> f64 {
        let of = |(law, region): (usize, &Region)| {
            let is_own = |table: &&Self| region.is_of(table.on.as_deref());
            let branch = all[..place].iter().filter(is_own).count() + 1;
            let own = is_own(&&all[place]);
            own.then(|| (known.by)(Viscous::owner(law), &format!("{branch}.{key}")))
        };
        known.regions.iter().enumerate().filter_map(of).sum()
    }
}
