//! Settings of a term that no type can rule out.

use anyhow::{Result, bail, ensure};

use super::{ForceForm, ObjectiveConfig, axes};
use crate::objective::{Density, KINDS};

impl ObjectiveConfig {
    /// Whether a negative weight has a sense: the term is then maximised.
    fn may_be_maximised(&self) -> bool {
        self.kind().may_be_maximised && !matches!(self, Self::Volume { volume: Some(_), .. })
    }

    /// Checks what can be checked without a body.
    ///
    /// # Errors
    /// With what was found and what is needed.
    pub fn check(&self) -> Result<()> {
        let (name, weight, _) = self.common();
        let own = format!("objective \"{name}\"");
        ensure!(weight.is_finite(), "{own}: weight = {weight}: must be a finite number");
        ensure!(
            weight >= 0.0 || self.may_be_maximised(),
            "{own}: weight = {weight}: a negative weight maximises a term, which makes sense for \
             {} only",
            maximised()
        );
        for (key, value) in self.lengths() {
            ensure!(value.is_finite() && value > 0.0, "{own}: {key} = {value} m must be positive");
        }
        match self {
            Self::Displacement { components, .. } | Self::Position { components, .. } => {
                let axes = axes(components);
                ensure!(
                    components.len() == axes.iter().filter(|a| **a).count()
                        && !components.is_empty(),
                    "{own}: components = \"{components}\": must be some of x, y, z, each once"
                );
            }
            Self::ContactForce { form, direction, .. } => match (form, direction) {
                (ForceForm::Along, None) => {
                    bail!("{own}: form = \"along\" needs direction = [x, y, z]")
                }
                (ForceForm::Along, Some(d)) => ensure!(
                    d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0),
                    "{own}: direction = {d:?}: must be finite, and not zero"
                ),
                (_, direction) => ensure!(
                    direction.is_none(),
                    "{own}: direction is for form = \"along\" only; remove one of them"
                ),
            },
            Self::ContactProxy { on, .. } => ensure!(
                on.all().len() > 1,
                "{own}: on = {:?}: needed are two tags or more that should press on each other",
                on.all()
            ),
            Self::WallThickness { on, against, density, minimum, .. } => {
                ensure!(
                    !against.is_empty() || on.all().len() > 1,
                    "{own}: on = {:?}: one side of a wall; name the other by against = [...], or \
                     two tags or more in on",
                    on.all()
                );
                ensure!(
                    minimum.is_some() == (*density == Density::Log),
                    "{own}: density = \"log\" needs a minimum [m], \"quadratic\" has none"
                );
            }
            Self::Stress { power, .. } => ensure!(
                power.is_finite() && *power >= 2.0,
                "{own}: power = {power}: must be 2 or more"
            ),
            Self::StrainLimit { largest, smallest, .. } => ensure!(
                (0.0..1.0).contains(smallest) && largest.is_finite() && *largest > 1.0,
                "{own}: largest = {largest}, smallest = {smallest}: stretches, the largest must be \
                 above 1 and the smallest from 0 to 1"
            ),
            Self::Volume { volume: Some(volume), .. } => ensure!(
                volume.is_finite() && *volume > 0.0,
                "{own}: volume = {volume} m³ must be positive"
            ),
            _ => {}
        }
        Ok(())
    }

    /// Lengths that must be positive [m].
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Target { spacing, .. } => vec![("spacing", *spacing)],
            Self::ContactProxy { activation, .. } | Self::Clearance { activation, .. } => {
                vec![("activation", *activation)]
            }
            Self::WallThickness { minimum, activation, .. } => {
                let minimum = minimum.map(|minimum| ("minimum", minimum));
                minimum.into_iter().chain([("activation", *activation)]).collect()
            }
            _ => Vec::new(),
        }
    }
}

/// Kinds whose weight may be negative, for messages.
fn maximised() -> String {
    let kinds = KINDS.iter().filter(|kind| kind.may_be_maximised).map(|kind| kind.key);
    kinds.collect::<Vec<_>>().join(", ") + " (without a wanted one)"
}
