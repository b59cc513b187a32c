//! Settings that no type can rule out.

use anyhow::{Context, Result, ensure};
use mechanics::schedule::{Field, Schedule, Written, WrittenField};
use program::table::Table;
use program::{KeyPath, misfit};

use super::{Fixed, SimConfig, TimeConfig};
use crate::term::values::{Values, components};
use crate::term::{Around, Scheduled};

impl SimConfig {
    /// Whether all settings that can be checked without a body are sound.
    pub(crate) fn check(&self) -> Result<()> {
        self.check_ranges(&KeyPath::default())?;
        self.check_bodies()?;
        self.solver.check()?;
        self.check_path()?;
        self.time.as_ref().map_or(Ok(()), TimeConfig::check)?;
        self.check_schedules()?;
        self.check_parts()
    }

    /// What functions of time stand for: with the values of `[parameters]` and the end of the first time step.
    pub fn values(&self) -> Values<'_> {
        Values { parameters: &self.parameters, times: self.times() }
    }

    /// What is written of a number.
    pub fn schedule(&self, written: &Written) -> Schedule {
        self.values().schedule(written)
    }

    /// What is written of a vector.
    pub fn field(&self, written: &WrittenField) -> Field {
        self.values().field(written)
    }

    /// What rooms may look at besides their tables.
    pub fn around(&self) -> Around<'_> {
        Around {
            values: self.values(),
            cuts: self.cuts(),
            method: self.method(),
            in_time: self.time.is_some(),
            gravity: &self.gravity,
            bodies: self.body.iter().map(|body| &*body.name).collect(),
        }
    }

    fn check_schedules(&self) -> Result<()> {
        let values = self.values();
        for (name, may_use_position, written) in self.schedules() {
            let schedule = values.known(written).with_context(|| name.clone())?;
            if schedule.uses_position() {
                ensure!(may_use_position, misfit!(name, " = {schedule}: must depend on t alone"));
            } else {
                schedule.check(&values.moments(), &[]).map_err(|what| misfit!(name, ": {what}"))?;
            }
        }
        Ok(())
    }

    /// Checks what schedules are a part of.
    fn check_parts(&self) -> Result<()> {
        self.fixed.iter().try_for_each(Fixed::check)?;
        self.check_symmetry()?;
        let around = self.around();
        self.rooms().into_iter().try_for_each(|room| room.check(&around))?;
        self.check_probes()?;
        if let Some(uncertainty) = &self.uncertainty {
            uncertainty.check(self).context(KeyPath::table("uncertainty"))?;
        }
        self.check_limit()
    }

    /// Whether bodies need no support.
    pub fn may_float(&self) -> bool {
        self.method().has_inertia() || self.contact().is_some() || self.is_afloat()
    }

    /// Whether nothing holds bodies in a scene without inertia and contact, so that its loads must balance.
    pub fn is_afloat(&self) -> bool {
        let held = self.method().has_inertia() || self.contact().is_some();
        !held && self.fixed.is_empty()
    }

    fn check_bodies(&self) -> Result<()> {
        let bodies = self.bodies()?;
        let names: Vec<&String> =
            bodies.iter().map(|b| &b.name).chain(self.obstacle.iter().map(|o| &o.name)).collect();
        for (i, name) in names.iter().enumerate() {
            ensure!(
                !name.is_empty() && !name.contains('.'),
                KeyPath::word(name).told(format!(
                    "body or obstacle \"{name}\": a name has one letter or more, and no dot"
                ))
            );
            let twice = format!("two bodies or obstacles are called \"{name}\"");
            ensure!(!names[..i].contains(name), KeyPath::word(name).told(twice));
        }
        for body in &bodies {
            ensure!(
                body.velocity == [0.0; 3] || self.method().has_inertia(),
                misfit!(
                    body.title().key("velocity"),
                    " = {:?} m/s means nothing without inertia; expected [time] with a method other than \
                     \"quasistatic\"",
                    body.velocity
                )
            );
        }
        ensure!(
            self.obstacle.is_empty() || self.contact().is_some(),
            misfit!(KeyPath::list("obstacle"), " without [contact]: bodies would pass through it")
        );
        Ok(())
    }

    /// All values that may change with time.
    pub fn schedules(&self) -> Vec<Scheduled<'_>> {
        let mut all: Vec<_> = self.rooms().into_iter().flat_map(|room| room.schedules()).collect();
        for c in &self.fixed {
            all.extend(components(c.title().key("displacement"), true, &c.displacement));
        }
        for c in &self.obstacle {
            let name = KeyPath::list("obstacle").named(&c.name).key("displacement");
            all.extend(components(name, false, &c.displacement));
        }
        all
    }

    fn check_probes(&self) -> Result<()> {
        for (i, probe) in self.probe.iter().enumerate() {
            probe.check()?;
            ensure!(
                self.probe[..i].iter().all(|other| other.name() != probe.name()),
                probe.title().told(format!(
                    "two [[probe]] are called \"{}\": give each a name of its own",
                    probe.name()
                ))
            );
            ensure!(
                self.contact().is_some() || !probe.kind().needs_contact,
                misfit!(
                    probe.title(),
                    ": {}: there are no forces between surfaces without [contact]",
                    probe.kind().key
                )
            );
        }
        Ok(())
    }
}

impl TimeConfig {
    fn check(&self) -> Result<()> {
        ensure!(
            matches!(
                (self.end, self.steps, &self.at),
                (Some(_), Some(_), None) | (None, None, Some(_))
            ),
            misfit!(
                KeyPath::table("time"),
                ": expected either end [s] and steps, or at, a list of times [s]"
            )
        );
        ensure!(
            self.method.states() == 1 || self.at.is_none(),
            misfit!(
                KeyPath::table("time"),
                ": this method uses {} earlier states, which needs steps of equal length: give end and steps, \
                 not at",
                self.method.states()
            )
        );
        Ok(())
    }
}
