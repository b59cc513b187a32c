//! Settings that no type can rule out.

use anyhow::{Context, Result, ensure};
use mechanics::energy::GasLaw;
use mechanics::schedule::{Field, Malformed, Schedule, Written, WrittenField};
use program::table::Table;
use program::{KeyPath, misfit};

use super::{ChamberConfig, Fixed, SimConfig, TimeConfig};
use crate::term::Around;

/// Times at which schedules are checked in each time step, for load steps
/// may end in between.
const MOMENTS: usize = 8;

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

    /// What is written of a number, with the values of `[parameters]` and the end of the first time step.
    pub fn schedule(&self, written: &Written) -> Schedule {
        self.valued(written).expect("names that were checked as the scene was read")
    }

    fn valued(&self, written: &Written) -> Result<Schedule, Malformed> {
        written.schedule(&self.parameters, self.times()[0])
    }

    /// What is written of a vector, as [`Self::schedule`].
    pub fn field(&self, written: &WrittenField) -> Field {
        Field(written.0.each_ref().map(|component| self.schedule(component)))
    }

    /// The gas law of one of its chambers.
    pub fn gas_law(&self, chamber: &ChamberConfig) -> Box<dyn GasLaw> {
        chamber.gas.law(self.schedule(&chamber.gas.value))
    }

    fn check_schedules(&self) -> Result<()> {
        let moments = self.moments();
        for (name, may_use_position, written) in self.schedules() {
            let schedule = self.valued(written).with_context(|| name.clone())?;
            if schedule.uses_position() {
                ensure!(may_use_position, misfit!(name, " = {schedule}: must depend on t alone"));
            } else {
                schedule.check(&moments, &[]).map_err(|what| misfit!(name, ": {what}"))?;
            }
        }
        Ok(())
    }

    /// Checks what schedules are a part of.
    fn check_parts(&self) -> Result<()> {
        self.fixed.iter().try_for_each(Fixed::check)?;
        self.check_symmetry()?;
        self.check_rooms()?;
        self.check_probes()?;
        if let Some(uncertainty) = &self.uncertainty {
            uncertainty.check(self).context(KeyPath::table("uncertainty"))?;
        }
        self.check_limit()?;
        self.check_chambers()
    }

    fn check_rooms(&self) -> Result<()> {
        let around = Around {
            cuts: &self.cuts(),
            method: self.method(),
            in_time: self.time.is_some(),
            has_gravity: !self.gravity.is_zero(),
            bodies: self.body.iter().map(|body| &*body.name).collect(),
        };
        self.rooms().into_iter().try_for_each(|room| room.check(&around))
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

    /// Moments at which schedules are checked: t = 0, the ends of time steps,
    /// and some in between [s].
    pub fn moments(&self) -> Vec<f64> {
        let mut moments = vec![0.0];
        for end in self.times() {
            let begin = moments[moments.len() - 1];
            let part = |i: usize| begin + (end - begin) * (i as f64 / MOMENTS as f64);
            moments.extend((1..MOMENTS).map(part));
            moments.push(end);
        }
        moments
    }

    /// All values that may change with time: what they are called in messages,
    /// and whether they may change with the position; those of chambers come first.
    pub fn schedules(&self) -> Vec<(KeyPath, bool, &Written)> {
        let mut all = Vec::new();
        for c in &self.chamber {
            all.push((c.title().key(c.gas.key()), false, &c.gas.value));
        }
        for c in &self.fixed {
            let name = KeyPath::list("fixed").on(&c.on).key("displacement");
            all.extend(along(name, true, &c.displacement));
        }
        for c in &self.body_force {
            all.extend(along(KeyPath::list("body_force").key("force"), true, &c.force));
        }
        all.extend(along(KeyPath::of("gravity"), true, &self.gravity));
        for c in &self.obstacle {
            let name = KeyPath::list("obstacle").named(&c.name).key("displacement");
            all.extend(along(name, false, &c.displacement));
        }
        for c in &self.traction {
            let name = KeyPath::list("traction").on(&c.on).key("traction");
            all.extend(along(name, true, &c.traction));
        }
        for part in &self.rigid {
            all.extend(along(part.title().key("force"), false, &part.force));
            all.extend(along(part.title().key("moment"), false, &part.moment));
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

    fn check_chambers(&self) -> Result<()> {
        let moments = self.moments();
        for (i, chamber) in self.chamber.iter().enumerate() {
            self.gas_law(chamber).check(&moments).with_context(|| chamber.title())?;
            let earlier = &self.chamber[..i];
            for (k, tag) in chamber.on.all().iter().enumerate() {
                let taken = earlier.iter().any(|other| other.is_on(tag));
                ensure!(
                    !taken && !chamber.on.all()[..k].contains(tag),
                    chamber.title().told(format!(
                        "\"{tag}\" is the wall of two chambers: keep one [[chamber]] on it"
                    ))
                );
            }
            ensure!(
                earlier.iter().all(|other| other.name != chamber.name),
                chamber.title().told(format!("two [[chamber]] are called \"{}\"", chamber.name))
            );
            ensure!(!chamber.on.all().is_empty(), chamber.title().told("on = []: name a tag"));
        }
        Ok(())
    }
}

/// The components of a field, with their keys.
fn along(
    name: KeyPath,
    may_use_position: bool,
    field: &WrittenField,
) -> impl Iterator<Item = (KeyPath, bool, &Written)> {
    let components = field.0.iter().enumerate();
    components.map(move |(axis, value)| (name.clone().along(axis), may_use_position, value))
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
