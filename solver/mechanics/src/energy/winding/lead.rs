//! How a helix climbs: its turns by the height, for a pitch or an angle that may change along the axis.
//!
//! τ(z) = ∫ f dz from the start of the helix, with the turns per height f [1/m]
//!
//! f = 1/|p|  of a pitch p [m]      f = tan|α|/2πR  of an angle α [rad] at the distance R [m] from the axis
//!
//! By the control values v_i of a [`Profile`] with the splines N_i: ∂τ/∂v_i = ∫ N_i df/dv dz. A number has the closed
//! form τ = f (z − z₀). Else each piece of the spline has a Gauss rule of [`POINTS`] points: the integrand is smooth
//! there.

use crate::element::quadrature::gauss_jacobi;
use crate::energy::{Profile, Slot};

/// Points of the rule in each piece of a spline.
const POINTS: usize = 10;

/// A number of a thread, or one that changes along its axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Along {
    /// The number has one value everywhere.
    Number(f64),
    /// By the height.
    Profile(Profile),
}

impl Along {
    /// The one value, or the control values.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Number(number) => std::slice::from_ref(number),
            Self::Profile(profile) => profile.values(),
        }
    }

    /// The value at a height [m] and ∂value/∂v_i of the control values that count there.
    pub(super) fn at(&self, height: f64) -> (f64, Vec<(usize, f64)>) {
        match self {
            Self::Number(number) => (*number, vec![(0, 1.0)]),
            Self::Profile(profile) => {
                (profile.value(height), profile.basis(height).pairs().collect())
            }
        }
    }
}

/// What the number of a helix is, all of whose values have one sign: negative for a left-handed screw.
#[derive(Clone, Debug, PartialEq)]
pub enum Lead {
    /// Height of a turn [m].
    Pitch(Along),
    /// Angle to the axis [rad], at a distance from it [m].
    Angle(Along, f64),
}

impl Lead {
    /// The pitch, or the angle.
    pub fn number(&self) -> &Along {
        match self {
            Self::Pitch(along) | Self::Angle(along, _) => along,
        }
    }

    /// What the values of the pitch or the angle are called.
    pub(super) fn slots(&self) -> Vec<Slot> {
        let values = match self.number() {
            Along::Number(_) => None,
            Along::Profile(profile) => Some(profile.values().len()),
        };
        match self {
            Self::Pitch(_) => Slot::along("pitch", "m", values),
            Self::Angle(..) => Slot::along("angle", "rad", values),
        }
    }

    /// 1 for a right-handed screw, −1 for a left-handed one.
    pub fn hand(&self) -> f64 {
        self.number().values()[0].signum()
    }

    /// f by a value v, and df/dv.
    fn density(&self, v: f64) -> [f64; 2] {
        match self {
            Self::Pitch(_) => [1.0 / v.abs(), -v.signum() / (v * v)],
            Self::Angle(_, distance) => {
                let round = std::f64::consts::TAU * distance;
                [v.abs().tan() / round, v.signum() / (v.cos().powi(2) * round)]
            }
        }
    }

    /// The turns of a height from another in one piece of the spline, and their derivatives by the values.
    fn turns(&self, [from, to]: [f64; 2], rule: &[(f64, f64)]) -> Turns {
        let mut turns = Turns { count: 0.0, by: vec![0.0; self.number().values().len()] };
        if let Along::Number(v) = self.number() {
            let [density, slope] = self.density(*v);
            turns.count = density * (to - from);
            turns.by[0] = slope * (to - from);
            return turns;
        }
        for (place, weight) in rule {
            let height = from + place * (to - from);
            let (v, basis) = self.number().at(height);
            let [density, slope] = self.density(v);
            turns.count += weight * (to - from) * density;
            for (i, part) in basis {
                turns.by[i] += weight * (to - from) * slope * part;
            }
        }
        turns
    }
}

/// Turns, and their derivatives by the values of a [`Lead`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Turns {
    pub count: f64,
    pub by: Vec<f64>,
}

impl Turns {
    fn add(&mut self, other: &Self, sign: f64) {
        self.count += sign * other.count;
        self.by.iter_mut().zip(&other.by).for_each(|(by, other)| *by += sign * other);
    }
}

/// The turns of a helix by the height.
pub(super) struct TurnsByHeight<'a> {
    lead: &'a Lead,
    /// Places on [0, 1] and weights.
    rule: Vec<(f64, f64)>,
    /// Heights between which splines are polynomials, in their order, and the turns there from the first.
    knots: Vec<(f64, Turns)>,
    /// The turns at the start, from the first knot.
    start: Option<Turns>,
}

impl<'a> TurnsByHeight<'a> {
    /// Of a helix that starts at a height [m].
    pub fn new(lead: &'a Lead, start: f64) -> Self {
        let heights = match lead.number() {
            Along::Number(_) => vec![start],
            Along::Profile(profile) => profile.knots(),
        };
        let rule = gauss_jacobi(POINTS, 0);
        let mut turns = Self { lead, rule, knots: Vec::new(), start: None };
        for height in heights {
            let there = turns.since_first(height);
            turns.knots.push((height, there));
        }
        turns.start = Some(turns.since_first(start));
        turns
    }

    /// The turns at a height from the first knot.
    fn since_first(&self, height: f64) -> Turns {
        let below = self.knots.iter().rev().find(|(knot, _)| *knot <= height);
        let Some((from, turns)) = below.or(self.knots.first()) else {
            return self.lead.turns([height, height], &[]);
        };
        let mut turns = turns.clone();
        turns.add(&self.lead.turns([*from, height], &self.rule), 1.0);
        turns
    }

    /// The turns at a height [m] from the start of the helix, negative below.
    pub fn turns(&self, height: f64) -> Turns {
        let mut turns = self.since_first(height);
        if let Some(start) = &self.start {
            turns.add(start, -1.0);
        }
        turns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::Axis;
    use mesh::Vec3;

    const HEIGHTS: [f64; 2] = [0.01, 0.07];

    fn profile(values: &[f64]) -> Along {
        let axis = Axis { point: Vec3::zeros(), along: Vec3::z() };
        Along::Profile(Profile::new(axis, HEIGHTS, values.to_vec()).expect("it is good"))
    }

    fn turns(lead: &Lead, start: f64, height: f64) -> Turns {
        TurnsByHeight::new(lead, start).turns(height)
    }

    /// A pitch that grows linearly, a + b z: ln of the ratio over b; constant beyond the ends.
    #[test]
    fn a_linear_pitch_has_its_logarithm() {
        let lead = Lead::Pitch(profile(&[2e-3, 5e-3]));
        let slope = 3e-3 / 0.06;
        let at = |z: f64| (1.0 + slope * (z - 0.01) / 2e-3).ln() / slope;
        let found = turns(&lead, 0.02, 0.06).count;
        assert!((found / (at(0.06) - at(0.02)) - 1.0).abs() < 1e-9, "{found}");
        let beyond = turns(&lead, -0.01, 0.09).count;
        let exact = 0.02 / 2e-3 + at(0.07) + 0.02 / 5e-3;
        assert!((beyond / exact - 1.0).abs() < 1e-9, "{beyond} {exact}");
        assert!((turns(&lead, 0.06, 0.02).count + found).abs() < 1e-9 * found);
    }

    #[test]
    fn equal_values_are_a_number() {
        for hand in [1.0, -1.0] {
            for number in [3e-3, 1.1] {
                let of = |along: Along| match number < 0.1 {
                    true => Lead::Pitch(along),
                    false => Lead::Angle(along, 0.01),
                };
                let [one, all] = [Along::Number(hand * number), profile(&[hand * number; 6])]
                    .map(|along| turns(&of(along), 0.013, 0.055));
                assert!((all.count / one.count - 1.0).abs() < 1e-12 && one.count > 0.0);
                assert!((all.by.iter().sum::<f64>() / one.by[0] - 1.0).abs() < 1e-12);
            }
        }
    }
}
