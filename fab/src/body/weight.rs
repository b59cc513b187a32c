//! What a casting weighs: a scale shows whether walls became as thick as they should.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Change of a wall that a scale shows [mm].
const TENTH: f64 = 0.1;

/// What a casting weighs when it is cured and finished.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Weight {
    /// The mass: volume × density [g].
    pub mass: f64,
    /// What it is less if the walls around its chambers are 0.1 mm thinner: their area × 0.1 mm × density [g].
    pub per_tenth: f64,
}

impl Weight {
    /// The weight of a volume [mm³] of silicone around chambers of an area [mm²], with its density
    /// [kg/m³].
    pub fn new(volume: f64, area: f64, density: f64) -> Self {
        // 1 kg/m³ is 10⁻⁶ g/mm³.
        let grams = density * 1e-6;
        Self { mass: volume * grams, per_tenth: area * TENTH * grams }
    }

    /// In words, for people with a scale.
    pub fn in_words(&self) -> String {
        let Self { mass, per_tenth } = *self;
        let walls = match per_tenth > 0.0 {
            true => format!(
                ", {per_tenth:.2} g less for each 0.1 mm that its walls are thinner around the chamber"
            ),
            false => String::new(),
        };
        format!("{mass:.1} g{walls}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_with_a_chamber() {
        // 30 mm outside and 20 mm inside: 19 mL, and 2400 mm² of wall.
        let weight = Weight::new(19e3, 2400.0, 1080.0);
        assert!((weight.mass - 20.52).abs() < 1e-12, "{weight:?}");
        assert!((weight.per_tenth - 0.2592).abs() < 1e-12, "{weight:?}");
        assert!(weight.in_words().starts_with("20.5 g, 0.26 g less"), "{}", weight.in_words());
    }
}
