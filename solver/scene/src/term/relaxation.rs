//! `[[relaxation]]`: stress that a material has for a while beside that of its law.

use anyhow::{Result, ensure};
use mechanics::energy::{Branch, Term, Viscous};
use program::table::Range;
use program::{KeyPath, misfit};

use super::material::SceneLaw;
use super::{About, Around, Ground, Known, Room, RoomNumber, Stage, each, isochoric, value};

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

impl Room for Vec<RelaxationConfig> {
    fn about(&self) -> About {
        About {
            list: "relaxation",
            stage: Stage::Body,
            paths: "relaxation.N.overstress or .time",
            meaning: "a number of the N-th [[relaxation]], counted from 1",
            example: "[[relaxation]]\noverstress = 0.5\ntime = 0.01\n",
        }
    }

    fn in_words(&self) -> Vec<String> {
        let one = |RelaxationConfig { on, overstress, time }: &RelaxationConfig| {
            let on = on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
            format!(
                "relaxation{on}: {:.1} % more isochoric stress at once, for {time} s",
                100.0 * overstress
            )
        };
        self.iter().map(one).collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        ensure!(
            self.is_empty() || around.in_time,
            misfit!(
                KeyPath::list("relaxation"),
                " without [time]: a scene without time steps has no rate; its state is that after a long \
                 time, of the law alone. Expected [time], with method = \"quasistatic\" where inertia does \
                 not matter"
            )
        );
        Ok(())
    }

    fn check_laws(&self, laws: &[SceneLaw]) -> Result<()> {
        let own = |table: &RelaxationConfig| isochoric("relaxation", table.on.as_deref(), laws);
        self.iter().try_for_each(|table| own(table).map(drop))
    }

    /// The branches of all tables that are of a law; none of a rigid body, which has another elastic law.
    fn beside(&self, law: usize, ground: &Ground, first: usize) -> Result<Option<Term>> {
        let own_law = &ground.laws[law];
        let own = self.iter().filter(|table| own_law.is_of(table.on.as_deref()));
        let branch = |own: &RelaxationConfig| Branch { overstress: own.overstress, time: own.time };
        let branches: Vec<Branch> = own.map(branch).collect();
        let has = !branches.is_empty() && !own_law.is_rigid;
        let isochoric = own_law.material.build().isochoric().filter(|_| has);
        Ok(isochoric.map(|isochoric| {
            let elements = own_law.elements(ground.body);
            let viscous = Viscous::new(isochoric, branches, elements, first);
            Term::of_both(own_law.numbers(law), Viscous::owner(law), viscous)
        }))
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |place, RelaxationConfig { overstress, time, .. }| {
            let numbers = vec![value("overstress", "1", overstress), value("time", "s", time)];
            ((place + 1).to_string(), numbers)
        })
    }

    /// Each law has the branches of the tables that are of it, one after the other.
    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64 {
        let of = |(place, law): (usize, &SceneLaw)| {
            let is_own = |table: &&RelaxationConfig| law.is_of(table.on.as_deref());
            let branch = self[..table].iter().filter(is_own).count() + 1;
            let own = is_own(&&self[table]);
            own.then(|| known.by(Viscous::owner(place), &format!("{branch}.{key}")))
        };
        known.laws.iter().enumerate().filter_map(of).sum()
    }
}
