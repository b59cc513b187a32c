//! A scalar design variable: a number of a scene within bounds, such as a peak pressure
//! or a phase.
//!
//! p = p⁰ + r y
//!
//! p⁰   the scene's value
//! y    design variable [m]
//! r    a tenth of the width of the bounds per mean edge, so that one variable changes
//!      its number as much as others change a shape

/// Change of the number for a variable of one mean edge, over the width of its bounds.
const SHARE: f64 = 0.1;

/// One number.
#[derive(Clone, Copy, Debug)]
pub struct Scalar {
    /// p⁰
    start: f64,
    /// r [1/m]
    unit: f64,
    /// Smallest and largest p.
    bounds: [f64; 2],
}

impl Scalar {
    /// A number that is `start` at y = 0, within `bounds`; `edge` is a typical motion
    /// of the shape [m].
    pub fn new(start: f64, bounds: [f64; 2], edge: f64) -> Self {
        Self { start, unit: SHARE * (bounds[1] - bounds[0]) / edge, bounds }
    }

    /// p
    pub fn value(&self, y: f64) -> f64 {
        self.start + self.unit * y
    }

    /// Cotangent of y for that of p.
    pub fn vjp(&self, bar: f64) -> f64 {
        self.unit * bar
    }

    /// Smallest and largest y [m].
    pub fn bounds(&self) -> [f64; 2] {
        self.bounds.map(|b| (b - self.start) / self.unit)
    }

    /// Change of p by a metre of its variable, r.
    pub fn per_metre(&self) -> f64 {
        self.unit
    }

    /// A change of p as one of y [m].
    pub fn variable_change(&self, by: f64) -> f64 {
        by / self.unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_reached_and_no_more() {
        let scalar = Scalar::new(20e3, [0.0, 80e3], 1e-3);
        let [low, high] = scalar.bounds();
        assert!((scalar.value(low)).abs() < 1e-9 && (scalar.value(high) - 80e3).abs() < 1e-9);
        // an edge is a tenth of the range, and 4 kPa are half an edge
        assert!((scalar.value(1e-3) - 28e3).abs() < 1e-9);
        assert!((scalar.variable_change(4e3) - 0.5e-3).abs() < 1e-15);
        assert!((scalar.vjp(2.0) - (scalar.value(2.0) - scalar.value(0.0))).abs() < 1e-6);
    }
}
