//! `[[rigid]]`: a part that keeps its shape.

mod build; // its nodes, and its energies on a body

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use measure::written::{FieldSchema, some_axes};
use mechanics::body::Body;
use mechanics::energy::{RigidLoad, RigidMass, RigidMoment, Term};
use mechanics::schedule::{WrittenField, axes};
use program::table::Range;
use program::{KeyPath, misfit};

use super::values::components as scheduled;
use super::{
    About, Around, Ground, Known, Room, RoomNumber, Scheduled, Stage, components, each, value,
};
use crate::supports::Support;
pub(crate) use build::{sets, shear_modulus};

program::table! {
    /// A part that moves without changing its shape: what a tag is glued to, such as a fitting or a disc, or a whole
    /// body.
    #[derive(Clone, Debug)]
    pub struct RigidConfig {
        /// Tag that is glued to it, or a body of which all is rigid.
        on: String;
        /// The axes along which it may move, such as "xyz" or "z"; where these are not all, it cannot turn.
        along: String = "xyz".to_owned(), some_axes;
        /// Whether it may turn.
        turns: bool = true;
        /// Mass, spread evenly over the tag; a body has that of its density [kg].
        mass: f64 = 0.0, Range::NOT_NEGATIVE.unit("kg");
        /// Force on the middle of the tag, or of the body's surface [N].
        #[schemars(with = "FieldSchema")]
        force: WrittenField = WrittenField::default();
        /// Moments about axes through it that keep the directions of x, y and z [N m]. Each works by the angle by which the
        /// part has turned about its axis, as seen along that: up to half a turn.
        #[schemars(with = "FieldSchema")]
        moment: WrittenField = WrittenField::default();
    }
}

impl RigidConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("rigid").on(&self.on)
    }

    /// Along which of x, y, z it may move.
    pub fn axes(&self) -> [bool; 3] {
        axes(&self.along)
    }

    /// Whether what guides it admits its loads.
    fn check_guides(&self) -> Result<()> {
        let Self { along, turns, .. } = self;
        ensure!(
            self.axes() == [true; 3] || !turns,
            misfit!(
                self.title().key("along"),
                " = \"{along}\" beside turns = true: a part that is guided along axes cannot turn; write \
                 turns = false, too"
            )
        );
        for (axis, moment) in ["x", "y", "z"].into_iter().zip(&self.moment.0) {
            ensure!(
                *turns || moment.is_zero(),
                misfit!(
                    self.title().key("moment"),
                    ": {moment} about {axis}, beside turns = false: expected 0"
                )
            );
        }
        let axes = ["x", "y", "z"].into_iter().zip(self.axes()).zip(&self.force.0);
        for ((axis, may_move), force) in axes {
            ensure!(
                may_move || force.is_zero(),
                misfit!(
                    self.title().key("force"),
                    ": {force} along {axis}, along which it cannot move: expected 0"
                )
            );
        }
        Ok(())
    }
}

/// Vertices of rigid parts, each with the tag or body.
pub fn vertices(parts: &[RigidConfig], body: &Body) -> Result<BTreeMap<usize, String>> {
    let mut all = BTreeMap::new();
    for part in parts {
        let facets = body.tagged(&part.on).with_context(|| part.title())?;
        all.extend(facets.into_iter().flatten().map(|v| (v, part.on.clone())));
    }
    Ok(all)
}

impl Room for Vec<RigidConfig> {
    fn about(&self) -> About {
        About {
            list: "rigid",
            stage: Stage::Part,
            paths: "rigid.PART.mass, .force.x or .moment.x",
            meaning: "the mass of a rigid part, where it has one; what is added to a component of the force on one that has \
                      a force, or to one of its moment that is not 0",
            example: "",
        }
    }

    fn schedules(&self) -> Vec<Scheduled<'_>> {
        let each = self.iter().flat_map(|part| {
            let force = scheduled(part.title().key("force"), false, &part.force);
            let moment = scheduled(part.title().key("moment"), false, &part.moment);
            [force, moment].concat()
        });
        each.collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        for (i, part) in self.iter().enumerate() {
            part.check_guides()?;
            ensure!(
                self[..i].iter().all(|other| other.on != part.on),
                misfit!(part.title(), " is given twice")
            );
            ensure!(
                part.mass == 0.0 || around.method.has_inertia() || !around.gravity.is_zero(),
                misfit!(
                    part.title().key("mass"),
                    " = {} kg means nothing without gravity and inertia; expected gravity, or [time] with a method \
                     other than \"quasistatic\"",
                    part.mass
                )
            );
            ensure!(
                !around.bodies.contains(&&*part.on) || part.mass == 0.0,
                misfit!(
                    part.title().key("mass"),
                    " = {} kg: a body has the mass of its material's density; expected none",
                    part.mass
                )
            );
        }
        Ok(())
    }

    /// Axes along which parts do not move, and those across planes of symmetry that cut them.
    fn supports(&self, body: &Body) -> Vec<Support> {
        let guide = |part: &RigidConfig| {
            let held = part.held(body);
            held.contains(&true).then(|| Support::still(&part.on, held))
        };
        self.iter().filter_map(guide).collect()
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        build::terms(self, ground)
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |_, part| {
            let (axes, pushed) = (part.axes(), !part.force.is_zero());
            let turned = part.moment.0.each_ref().map(|moment| !moment.is_zero());
            let RigidConfig { on, mass, force, moment, .. } = part;
            let heavy = *mass > 0.0;
            let force = components("force", "N", force).zip(axes);
            let moment = components("moment", "N m", moment).zip(turned);
            let vectors = force.filter(|_| pushed).chain(moment).filter(|(_, counts)| *counts);
            let mass = heavy.then(|| value("mass", "kg", mass)).into_iter();
            (on.clone(), mass.chain(vectors.map(|(number, _)| number)).collect())
        })
    }

    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64 {
        let [load, mass, moment] = [RigidLoad::owner, RigidMass::owner, RigidMoment::owner]
            .map(|owner| known.by(owner(table), key));
        load + mass + moment
    }
}
