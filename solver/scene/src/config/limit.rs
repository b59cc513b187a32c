//! `[limit]`: how much more pressure than its loads a body bears.

use anyhow::{Result, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{OptimizerConfig, OptimizerMethod, SimConfig};

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

/// How far the body of a design is to stay from where it balloons or buckles. Its scene has the `[limit]` that says of
/// which pressures. The term `limit` of the objective is weight (least − factor)², or 0 where the factor is more.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitGoal {
    /// Factor on the pressures that the body is to bear, at least [1].
    pub least: f64,
    /// Weight of the term.
    pub weight: f64,
}

impl LimitGoal {
    /// Checks it alone.
    pub(super) fn check(&self, optimizer: &OptimizerConfig, objectives: &[&str]) -> Result<()> {
        let table = KeyPath::table("limit");
        let Self { least, weight } = *self;
        ensure!(
            least.is_finite() && least > 1.0,
            misfit!(table.key("least"), " = {least}: must be above 1, the pressure of the scene")
        );
        ensure!(
            weight.is_finite() && weight > 0.0,
            misfit!(table.key("weight"), " = {weight}: must be positive")
        );
        ensure!(
            optimizer.method == OptimizerMethod::LBfgs,
            misfit!(
                table,
                " does not go with method = \"gauss-newton\": a limit is no square whose curvature is known; \
                 expected \"l-bfgs\""
            )
        );
        ensure!(
            !objectives.contains(&LIMIT),
            misfit!(
                KeyPath::list("objective").named(LIMIT),
                " beside [limit], whose term has this name; expected another"
            )
        );
        Ok(())
    }

    /// Checks it against the scene of its design.
    ///
    /// # Errors
    /// When the scene does not say of which pressures, or does not seek so far.
    pub fn check_scene(&self, scene: Option<&LimitConfig>) -> Result<()> {
        let table = KeyPath::table("limit");
        let Some(scene) = scene else {
            return Err(misfit!(
                table,
                " of the design: its scene has no [limit], which says of which pressures"
            )
            .into());
        };
        let (least, most) = (self.least, scene.most);
        ensure!(
            most >= least,
            misfit!(
                table.key("least"),
                " = {least}: above most = {most} of [limit] in the scene, up to which a limit is sought"
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
