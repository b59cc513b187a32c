//! Numbers that carry their gradient by position (forward differentiation).

use std::ops::{Add, Div, Mul, Neg, Sub};

use mesh::Vec3;

/// A value and its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// f
    pub value: f64,
    /// ∂f/∂(x, y, z) [1/m]
    pub gradient: Vec3,
}

impl Jet {
    /// A value that is the same everywhere.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: Vec3::zeros() }
    }

    /// A component of the position.
    pub fn coordinate(position: Vec3, k: usize) -> Self {
        Self { value: position[k], gradient: Vec3::from_fn(|i, _| f64::from(u8::from(i == k))) }
    }

    /// g(f) with the slope g'(f).
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, gradient: scaled(self.gradient, slope) }
    }

    pub(super) fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    pub(super) fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    pub(super) fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }

    pub(super) fn log(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }

    pub(super) fn sqrt(self) -> Self {
        self.chain(self.value.sqrt(), 0.5 / self.value.sqrt())
    }

    pub(super) fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }

    /// (3a − a³)/2 on [−1, 1], ±1 outside.
    pub(super) fn half_smoothstep(self) -> Self {
        let a = self.value;
        if a.abs() > 1.0 {
            return Self::constant(a.signum());
        }
        self.chain(0.5 * (3.0 * a - a.powi(3)), 1.5 * (1.0 - a * a))
    }

    /// The smaller one; NaN if any is.
    pub(super) fn smaller(self, other: Self) -> Self {
        if self.value.is_nan() || self.value < other.value { self } else { other }
    }

    pub(super) fn power(self, exponent: Self) -> Self {
        let (a, b) = (self.value, exponent.value);
        let value = a.powf(b);
        let by_base = scaled(self.gradient, b * a.powf(b - 1.0));
        let by_exponent = scaled(exponent.gradient, value * a.ln());
        Self { value, gradient: by_base + by_exponent }
    }
}

/// Zero stays zero, whatever the slope.
fn scaled(gradient: Vec3, slope: f64) -> Vec3 {
    gradient.map(|g| if g == 0.0 { 0.0 } else { slope * g })
}

impl Neg for Jet {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, gradient: -self.gradient }
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self { value: self.value + b.value, gradient: self.gradient + b.gradient }
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let gradient = scaled(self.gradient, b.value) + scaled(b.gradient, self.value);
        Self { value: self.value * b.value, gradient }
    }
}

impl Div for Jet {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        let gradient = scaled(self.gradient - scaled(b.gradient, value), 1.0 / b.value);
        Self { value, gradient }
    }
}
