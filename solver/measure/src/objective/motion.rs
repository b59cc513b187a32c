//! Displacement or position of a part of the surface against a wanted one (trajectory
//! tracking).
//!
//! J(u, X) = ∫_Γ Σ_k (u_k − w_k)² dA     displacement
//! J(u, X) = ∫_Γ Σ_k (x_k − w_k)² dA     position, x = ΠX + u
//!
//! k        the axes that count
//! w(X, t)  wanted displacement or position [m], as it is written, from t = 0 on
//!
//! J is in m⁴; over time it makes a point follow a trajectory. Rest shape and
//! displacement also enter through the area, see
//! [`surface_integral`](super::Patch).
//!
//! Source: Gjoka et al. 2024, the worm's and the walker's objective.

use std::path::Path;

use anyhow::{Result, ensure};
use mechanics::schedule::{Field, axes};
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{AXES, Builder, Kind, MEASURE, Specification, TAGS, form};
use super::surface_integral::{Density, Patch, Place};
use super::{Equilibrium, Measure, Objective};
use crate::written::FieldSchema;
use crate::written::Names;

const WANTED: &str = "w [m]: numbers, expressions in t, x, y, z, or tables";

pub(super) const DISPLACEMENT: Kind = Kind {
    key: "displacement",
    formula: "∫ Σ (u_i − w_i)² dA",
    unit: "m⁴",
    keys: &[TAGS, ("displacement", WANTED), AXES, MEASURE],
    may_be_maximised: false,
    needs_contact: false,
    form: form::<DisplacementKeys>(),
};

pub(super) const POSITION: Kind = Kind {
    key: "position",
    formula: "∫ Σ (x_i − w_i)² dA, x = X + u",
    unit: "m⁴",
    keys: &[TAGS, ("position", WANTED), AXES, MEASURE],
    may_be_maximised: false,
    needs_contact: false,
    form: form::<PositionKeys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct DisplacementKeys {
    on: Names,
    #[schemars(with = "FieldSchema")]
    displacement: Field,
    #[serde(default = "all_axes")]
    components: String,
    #[serde(default)]
    measure: Measure,
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PositionKeys {
    on: Names,
    #[schemars(with = "FieldSchema")]
    position: Field,
    #[serde(default = "all_axes")]
    components: String,
    #[serde(default)]
    measure: Measure,
}

fn all_axes() -> String {
    "xyz".to_owned()
}

impl Specification for DisplacementKeys {
    fn check(&self) -> Result<()> {
        check_components(&self.components)
    }

    fn prepare(&self, _: &Path) -> Result<Builder> {
        let Self { on, displacement, components, measure } = self.clone();
        Ok(builder(Quantity::Displacement, displacement, on, &components, measure))
    }
}

impl Specification for PositionKeys {
    fn check(&self) -> Result<()> {
        check_components(&self.components)
    }

    fn prepare(&self, _: &Path) -> Result<Builder> {
        let Self { on, position, components, measure } = self.clone();
        Ok(builder(Quantity::Position, position, on, &components, measure))
    }
}

fn check_components(components: &str) -> Result<()> {
    let count = axes(components).iter().filter(|axis| **axis).count();
    ensure!(
        components.len() == count && !components.is_empty(),
        "components = \"{components}\": must be some of x, y, z, each once"
    );
    Ok(())
}

fn builder(
    quantity: Quantity,
    wanted: Field,
    on: Names,
    components: &str,
    measure: Measure,
) -> Builder {
    let axes = axes(components);
    let key = match quantity {
        Quantity::Displacement => DISPLACEMENT.key,
        Quantity::Position => POSITION.key,
    };
    Box::new(move |name, bodies| {
        let facets = bodies.facets(&on)?;
        bodies.check_wanted(key, &wanted, &facets)?;
        let patch = Patch::new(bodies.space, &facets, measure);
        Ok(Box::new(Motion::new(name, patch, quantity, wanted.clone(), axes)))
    })
}

/// What of a point is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// u.
    Displacement,
    /// ΠX + u.
    Position,
}

/// Squared distance to a wanted displacement or position.
pub struct Motion {
    name: String,
    patch: Patch,
    quantity: Quantity,
    wanted: Field,
    axes: [bool; 3],
}

impl Motion {
    /// A patch that should be at `wanted` [m] along some axes.
    #[must_use]
    pub fn new(
        name: &str,
        patch: Patch,
        quantity: Quantity,
        wanted: Field,
        axes: [bool; 3],
    ) -> Self {
        Self { name: name.to_owned(), patch, quantity, wanted, axes }
    }

    fn density(&self, place: &Place, time: f64) -> Density {
        let is_place = f64::from(u8::from(self.quantity == Quantity::Position));
        let (mut value, mut by_u, mut by_rest) = (0.0, Vec3::zeros(), Vec3::zeros());
        for k in (0..3).filter(|&k| self.axes[k]) {
            let wanted = self.wanted.0[k].as_written(place.rest, time);
            let gap = place.u[k] + is_place * place.rest[k] - wanted.value;
            value += gap * gap;
            by_u[k] += 2.0 * gap;
            by_rest[k] += 2.0 * gap * is_place;
            by_rest -= 2.0 * gap * wanted.gradient;
        }
        Density { value, by_u, by_rest }
    }
}

impl Objective for Motion {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.patch.value(at, &|place| self.density(place, at.load))
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.patch.add_du(at, &|place| self.density(place, at.load), weight, out);
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.patch.add_drest(at, &|place| self.density(place, at.load), weight, out);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::objective::tests::Case;

    const AXES: [bool; 3] = [true, false, true];

    #[test]
    fn derivatives_belong_to_the_value() {
        for (degree, scale) in [(1, 1.0), (2, 1e-3), (3, 1.0)] {
            let case = Case::cube(degree, scale);
            let expression = format!("t*y*(1 + x/{scale})");
            let wanted = Field([expression.parse().unwrap(), 7.0.into(), (0.1 * scale).into()]);
            for measure in [Measure::Rest, Measure::Deformed] {
                for quantity in [Quantity::Displacement, Quantity::Position] {
                    let patch = Patch::new(&case.space, &case.facets, measure);
                    case.check(&Motion::new("m", patch, quantity, wanted.clone(), AXES));
                }
            }
        }
    }

    /// The top of a cube that is lifted by 0.3 where 0.1 + 0.2 t is wanted, with
    /// t = 0.7, and shifted along x, where nothing is wanted of it.
    #[test]
    fn a_shifted_face_has_its_closed_form() {
        let mut case = Case::cube(2, 1.0);
        case.u.chunks_exact_mut(3).for_each(|u| u.copy_from_slice(&[0.0, 0.9, 0.3]));
        let top = case.facets_where(|x| x.z > 0.99);
        let value = |quantity, wanted: &str| {
            let wanted = Field([0.0.into(), 0.0.into(), wanted.parse().unwrap()]);
            let patch = Patch::new(&case.space, &top, Measure::Deformed);
            Motion::new("m", patch, quantity, wanted, [false, false, true]).value(&case.at())
        };
        let expected = (0.3_f64 - 0.24).powi(2);
        assert!((value(Quantity::Displacement, "0.1 + 0.2*t") - expected).abs() < 1e-15);
        assert!((value(Quantity::Position, "1.1 + 0.2*t") - expected).abs() < 1e-14);
    }
}
