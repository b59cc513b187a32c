//! `[limit]`: how much more pressure than its loads a body bears.

use anyhow::{Result, bail, ensure};
use program::table::Range;
use program::{KeyPath, misfit};

use super::SimConfig;

program::table! {
    /// How much more pressure than the full load a body bears before it balloons, buckles or tears. Pressures grow together
    /// from the state at the end, while all other loads, volumes and supports are held.
    #[derive(Clone, Debug)]
    pub struct LimitConfig {
        /// Tags of the chambers whose pressures grow.
        on: Vec<String> = Vec::new() => "all that have a pressure";
        /// Factor up to which a limit is sought [1].
        most: f64 = 3.0, Range::above(1.0);
    }
}

impl SimConfig {
    /// Checks `[limit]` against its scene.
    pub(super) fn check_limit(&self) -> Result<()> {
        let Some(limit) = &self.limit else { return Ok(()) };
        self.check_growing(&KeyPath::table("limit"), &limit.on)
    }

    /// Checks that the slope of the pressure can be kept, by what is at this place of a design.
    pub fn check_slope(&self, place: &KeyPath) -> Result<()> {
        ensure!(
            self.contact().is_none(),
            misfit!(
                place.clone(),
                " does not go with the [contact] of the scene: the stiffness jumps where facets slide over each other, so \
                 that the slope has no gradient there; leave one of both away"
            )
        );
        self.check_growing(place, &[])
    }

    /// Checks that pressures can grow at the end.
    fn check_growing(&self, place: &KeyPath, on: &[String]) -> Result<()> {
        let moves = self.obstacle.iter().any(|o| !o.displacement.is_zero());
        let history = [
            (self.time.is_some(), "[time]"),
            (!self.relaxation.is_empty(), "[[relaxation]]"),
            (self.has_friction(), "friction"),
            (moves, "an obstacle that moves"),
        ];
        if let Some((_, what)) = history.iter().find(|(found, _)| *found) {
            let said = "which a state at a held load cannot have; leave one of both away";
            bail!(misfit!(place.clone(), " does not go with {what}, {said}"));
        }
        let pressures: Vec<&str> = self
            .chamber
            .iter()
            .filter_map(|chamber| chamber.gas.pressure().map(|_| chamber.name.as_str()))
            .collect();
        let known = pressures.join(", ");
        ensure!(
            !pressures.is_empty(),
            misfit!(
                place.clone(),
                ": no chamber has a pressure that could grow; needed is [[chamber]] with pressure = …"
            )
        );
        for tag in on {
            ensure!(
                pressures.contains(&tag.as_str()),
                misfit!(
                    place.clone().key("on"),
                    ": no chamber on \"{tag}\" has a pressure; those that have: {known}"
                )
            );
        }
        Ok(())
    }
}
