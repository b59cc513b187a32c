//! `[limit]`: how much more pressure than its loads a body bears.

use anyhow::{Result, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;

/// How much more pressure than the full load a body bears before it balloons, buckles or tears. Pressures grow together
/// from the state at the end, while all other loads, volumes and supports are held.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LimitConfig {
    /// Tags of the chambers whose pressures grow; all that have a pressure if not given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub on: Vec<String>,
    /// Factor up to which a limit is sought [1].
    pub most: f64,
}

impl Default for LimitConfig {
    fn default() -> Self {
        Self { on: Vec::new(), most: 3.0 }
    }
}

/// Name of the term of an objective that counts the limit.
pub const LIMIT: &str = "limit";

/// Name of the term of an objective that counts the burst.
pub const BURST: &str = "burst";

/// Name of the term of an objective that counts the slope of the pressure.
pub const SLOPE: &str = "slope";

/// How far the body of a design is to stay from where it balloons or buckles, and from where it tears. Its
/// scene has the `[limit]` that says of which pressures. Without a weight, each is a constraint: the number is `least` or
/// more. With one, `limit` is a term of the objective, weight (least − factor)², or 0 where the factor is more; `burst` is
/// the same of the factor at which the largest stretch is that at break, and `slope` the same of the slope of the pressure
/// at the equilibrium itself.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitGoal {
    /// Factor on the pressures that the body is to bear, at least, before it balloons or buckles [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Weight of the term `limit`; a constraint without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// Factor on the pressures that the body is to bear, at least, before it tears: `{ least = 1.5 }`. Of a
    /// body that balloons or buckles first, the factor of that counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<Least>,
    /// Slope of the pressure by the volume, over pressure by change of volume from rest, at least:
    /// `{ least = 0.5 }`. 1 where the body answers in proportion, 0 where it balloons. It needs no path and no
    /// limit, and does not see where a body buckles. In contact it has no gradient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope: Option<Least>,
}

/// A number that is to be large enough.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Least {
    /// The smallest one that is enough [1].
    pub least: f64,
    /// Weight of the term; a constraint without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

impl Least {
    fn check(&self, name: &str) -> Result<()> {
        let (table, Self { least, weight }) = (LimitGoal::path(name), *self);
        let (bound, of) = if name == SLOPE {
            (0.0, "the slope where it balloons")
        } else {
            (1.0, "the pressure of the scene")
        };
        ensure!(
            least.is_finite() && least > bound,
            misfit!(table.key("least"), " = {least}: must be above {bound}, {of}")
        );
        if let Some(weight) = weight {
            ensure!(
                weight.is_finite() && weight > 0.0,
                misfit!(table.key("weight"), " = {weight}: must be positive")
            );
        }
        Ok(())
    }
}

impl LimitGoal {
    /// What counts or is kept, by name; the slope last.
    #[must_use]
    pub fn goals(&self) -> Vec<(&'static str, Least)> {
        let limit = self.least.map(|least| Least { least, weight: self.weight });
        let named = [(LIMIT, limit), (BURST, self.burst), (SLOPE, self.slope)];
        named.into_iter().filter_map(|(name, goal)| Some((name, goal?))).collect()
    }

    /// Where a goal is written.
    fn path(name: &str) -> KeyPath {
        let table = KeyPath::table("limit");
        if name == LIMIT { table } else { table.key(name) }
    }

    /// Checks it alone.
    pub(super) fn check(&self, objectives: &[&str]) -> Result<()> {
        let table = KeyPath::table("limit");
        ensure!(
            self.least.is_some() || self.weight.is_none(),
            misfit!(
                table.key("weight"),
                " without least: expected both, least alone, burst or slope"
            )
        );
        let goals = self.goals();
        ensure!(
            !goals.is_empty(),
            misfit!(
                table,
                " of the design is empty; expected least, burst = {{ least = 1.5 }} or slope = {{ least = 0.5 }}, or \
                 several of them"
            )
        );
        for (name, goal) in goals {
            goal.check(name)?;
            ensure!(
                !objectives.contains(&name),
                misfit!(
                    KeyPath::list("objective").named(name),
                    " beside [limit], which has this name in reports; expected another"
                )
            );
        }
        Ok(())
    }

    /// Checks it against the scene of its design, and the stretch at break of its materials.
    ///
    /// # Errors
    /// When the scene does not say of which pressures, or does not seek so far, when no material says when it tears, or
    /// when the slope is to be raised in contact.
    pub fn check_scene(&self, scene: &SimConfig, at_break: Option<f64>) -> Result<()> {
        let table = KeyPath::table("limit");
        ensure!(
            self.slope.is_none() || scene.contact().is_none(),
            misfit!(
                table.key(SLOPE),
                " does not go with the [contact] of the scene: the stiffness jumps where facets slide over each other, so \
                 that the slope has no gradient there; leave one of both away, or write least and weight"
            )
        );
        let Some(scene) = &scene.limit else {
            return Err(misfit!(
                table,
                " of the design: its scene has no [limit], which says of which pressures"
            )
            .into());
        };
        let most = scene.most;
        for (name, Least { least, .. }) in self.goals() {
            ensure!(
                name == SLOPE || most >= least,
                misfit!(
                    Self::path(name).key("least"),
                    " = {least}: above most = {most} of [limit] in the scene, up to which a limit is sought"
                )
            );
        }
        ensure!(
            self.burst.is_none() || at_break.is_some(),
            misfit!(
                table.key(BURST),
                ": no material of the scene has a stretch_at_break, at which it tears; give it one, or leave burst away"
            )
        );
        Ok(())
    }
}

impl SimConfig {
    /// Checks `[limit]` against its scene.
    pub(super) fn check_limit(&self) -> Result<()> {
        let Some(limit) = &self.limit else { return Ok(()) };
        let table = KeyPath::table("limit");
        ensure!(
            limit.most.is_finite() && limit.most > 1.0,
            misfit!(table.key("most"), " = {}: must be above 1", limit.most)
        );
        let moves = self.obstacle.iter().any(|o| !o.displacement.0.iter().all(|d| d.is_zero()));
        let history = [
            (self.time.is_some(), "[time]"),
            (!self.relaxation.is_empty(), "[[relaxation]]"),
            (self.has_friction(), "friction"),
            (moves, "an obstacle that moves"),
        ];
        if let Some((_, what)) = history.iter().find(|(found, _)| *found) {
            let said = "which a state at a held load cannot have; leave one of both away";
            return Err(misfit!(table, " does not go with {what}, {said}").into());
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
                table,
                ": no chamber has a pressure that could grow; needed is [[chamber]] with pressure = …"
            )
        );
        for tag in &limit.on {
            ensure!(
                pressures.contains(&tag.as_str()),
                misfit!(
                    table.key("on"),
                    ": no chamber on \"{tag}\" has a pressure; those that have: {known}"
                )
            );
        }
        Ok(())
    }
}
