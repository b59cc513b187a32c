//! Softening after a first stretch (Mullins effect), a pseudo-elastic law: a factor η on the stress of
//! another law, by its energy density W and the largest one W_m that the point has met before.
//!
//! η = 1 − erf(x)/r,   x = (W_m − W)/c,   c = m + β W_m        where W < W_m;   else η = 1
//!
//! The stress is η ∂W/∂F, the derivative of W + D at given W_m, with D = 0 at W = W_m:
//!
//! D = ∫ (1 − η) ds from W to W_m = c/r (x erf x + (e^(−x²) − 1)/√π)
//!
//! On the first way up D = 0. On the way down the stress falls at once, by up to 1/r, and a way up again
//! is the way down until W reaches W_m. From rest to W_m and back the work D(W = 0) is lost.
//!
//! W is the isochoric part of a law: pressure and change of volume of a nearly incompressible rubber
//! are not softened.
//!
//! Source: Ogden and Roxburgh 1999, "A pseudo-elastic model for the Mullins effect in filled rubber",
//! doi:10.1098/rspa.1999.0431, for an incompressible rubber and with β = 0. β and the isochoric part are
//! those of finite-element programs: the Abaqus Analysis User's Guide, "Mullins effect". The closed
//! form of D is ours.

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

use libm::erf;

/// Numbers of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OgdenRoxburgh {
    /// r ≥ 1: stress falls by 1/r of itself at most [1].
    pub r: f64,
    /// m ≥ 0: how slowly it falls after small stretches [J/m³].
    pub m: f64,
    /// β ≥ 0: how slowly it falls after large stretches [1]. One of m and β is positive.
    pub beta: f64,
}

/// D and its derivatives where W < W_m.
#[derive(Clone, Copy, Debug)]
pub struct Softened {
    /// D [J/m³].
    pub value: f64,
    /// ∂D/∂W = η − 1 [1].
    pub first: f64,
    /// ∂η/∂W [m³/J].
    pub second: f64,
    /// ∂η/∂W_m [m³/J].
    pub by_largest: f64,
    /// ∂η/∂(r, m, β).
    pub by_numbers: [f64; 3],
}

impl OgdenRoxburgh {
    /// D and its derivatives at W and W_m [J/m³]; none where W ≥ W_m, where D = 0.
    pub fn at(&self, w: f64, largest: f64) -> Option<Softened> {
        if w.is_nan() || w >= largest {
            return None;
        }
        let Self { r, m, beta } = *self;
        let scale = m + beta * largest;
        let x = (largest - w) / scale;
        let (part, density) = (erf(x), FRAC_2_SQRT_PI * (-x * x).exp() / r);
        let under = x * part + (-x * x).exp_m1() / PI.sqrt();
        // x may be infinite or large where the density is zero
        let moved = if density > 0.0 { density * x / scale } else { 0.0 };
        Some(Softened {
            value: scale / r * under,
            first: -part / r,
            second: density / scale,
            by_largest: beta * moved - density / scale,
            by_numbers: [part / (r * r), moved, moved * largest],
        })
    }

    /// η at W and W_m [J/m³].
    pub fn factor(&self, w: f64, largest: f64) -> f64 {
        1.0 + self.at(w, largest).map_or(0.0, |softened| softened.first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: OgdenRoxburgh = OgdenRoxburgh { r: 1.6, m: 900.0, beta: 0.2 };

    /// The integral of 1 − η by Simpson's rule, and what meets at W_m.
    #[test]
    fn the_energy_is_the_integral_of_the_factor() {
        let (largest, n) = (5e3, 2000);
        let h = largest / f64::from(n);
        let weight = |i: i32| match i {
            0 => 1.0,
            i if i == n => 1.0,
            i => 2.0 + 2.0 * f64::from(i % 2),
        };
        let part = |i: i32| weight(i) * (1.0 - LAW.factor(h * f64::from(i), largest));
        let integral = h / 3.0 * (0..=n).map(part).sum::<f64>();
        let value = LAW.at(0.0, largest).expect("below the largest").value;
        assert!((value / integral - 1.0).abs() < 1e-10, "{value} {integral}");
        assert!(LAW.at(largest, largest).is_none() && LAW.factor(2.0 * largest, largest) == 1.0);
        let near = LAW.at(largest * (1.0 - 1e-9), largest).expect("below the largest");
        assert!(near.value > 0.0 && near.value < 1e-9 && near.first > -1e-8, "{near:?}");
    }

    /// With m = 0 a point is softened by any stretch, however small; far below W_m the factor is 1 − 1/r.
    #[test]
    fn limits_are_finite() {
        let law = OgdenRoxburgh { r: 2.0, m: 0.0, beta: 0.01 };
        for largest in [1e-300, 1e4] {
            let at = law.at(0.0, largest).expect("below the largest");
            assert_eq!((at.first, at.second), (-0.5, 0.0));
            assert!(at.by_numbers.iter().all(|by| by.is_finite()) && at.value.is_finite());
        }
        assert_eq!(law.factor(0.0, 0.0), 1.0);
    }
}
