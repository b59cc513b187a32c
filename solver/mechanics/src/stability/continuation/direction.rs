//! Directions among the unknowns of a path, and lengths there.

use serde::{Deserialize, Serialize};

use crate::math::linear::dot;
use crate::stability::tangent_system::Row;

/// A change of all unknowns.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Direction {
    /// Of the free degrees of freedom [m].
    pub u: Vec<f64>,
    /// Of the pressures of prescribed volumes [Pa], which no length counts.
    pub pressures: Vec<f64>,
    /// Of the load.
    pub load: f64,
}

impl Direction {
    /// u · v / ℓ² + s t, with ℓ the `scale` [m].
    pub fn product(&self, other: &Self, scale: f64) -> f64 {
        dot(&self.u, &other.u) / (scale * scale) + self.load * other.load
    }

    /// The root of its product with itself.
    pub fn length(&self, scale: f64) -> f64 {
        self.product(self, scale).sqrt()
    }

    /// The direction times a number.
    pub fn scaled(&self, by: f64) -> Self {
        let times = |x: &Vec<f64>| x.iter().map(|x| by * x).collect();
        Self { u: times(&self.u), pressures: times(&self.pressures), load: by * self.load }
    }

    /// The sum with another one.
    pub fn plus(&self, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        Self {
            u: sum(&self.u, &other.u),
            pressures: sum(&self.pressures, &other.pressures),
            load: self.load + other.load,
        }
    }

    /// The direction with length 1; none where it has no length.
    pub fn unit(&self, scale: f64) -> Option<Self> {
        let length = self.length(scale);
        (length.is_finite() && length > 0.0).then(|| self.scaled(1.0 / length))
    }

    /// The product with it, as an equation.
    pub fn row(&self, scale: f64) -> Row {
        let u = self.u.iter().map(|u| u / (scale * scale)).collect();
        Row { u, load: self.load }
    }
}
