//! What a Taylor test says.

use mechanics::math::taylor::log_slope;

/// Slopes of the first-order remainder that an exact gradient may have.
const ACCEPTED: std::ops::RangeInclusive<f64> = 1.9..=2.1;

/// Change of a term, relative to the term, that rounding and the tolerance of the
/// run may hide.
const NOISE: f64 = 1e-9;

/// Largest remainder of a term that is linear along q, and largest noise there, relative to
/// the change of the term at the longest step.
const LINEAR: f64 = 1e-4;

/// Remainders above the noise that a slope needs.
const POINTS: usize = 3;

/// Slopes between remainders that are below the noise, of which [`POINTS`] in a row are enough.
const EXACT: std::ops::RangeInclusive<f64> = 1.99..=2.01;

/// Slopes of remainders that fall as those of an exact gradient do, some of them by the third order.
const FALLING: std::ops::RangeInclusive<f64> = 1.9..=3.1;

/// Remainders in a row that fall like that, and so are no noise although they are below the usual one: a
/// term of the rest shape alone has less.
const QUADRATIC: usize = 4;

/// What the remainders of a term along a direction say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// Slope of the remainders against ε.
    Slope(f64),
    /// Steps along −q pass, while those along q have a slope of 1: the derivatives to either side differ, and g·q
    /// is one of them.
    Kink,
    /// Slope above 2 of longer steps; the remainders of shorter ones are within the noise.
    Faster(f64),
    /// The term does not change and g·q is zero, both within the noise.
    Constant,
    /// The change is ε g·q; the largest difference relative to the change.
    Linear(f64),
    /// A step was too long for an equilibrium or a valid shape.
    TooLong,
    /// Changes and remainders are too near to the noise for any of these.
    NotMeasurable,
}

impl Finding {
    /// From changes J(θ + εq) − J(θ) of a term of a size.
    pub fn new(size: f64, slope: f64, epsilon: &[f64], change: &[f64], remainder: &[f64]) -> Self {
        let noise = NOISE * size;
        // a remainder in the noise says nothing, nor do those after it
        let above = remainder.iter().take_while(|r| **r > noise).count();
        let measured = above.max(quadratic(epsilon, remainder));
        if measured >= POINTS {
            return Self::Slope(log_slope(&epsilon[..measured], &remainder[..measured]));
        }
        let predicted = epsilon.iter().map(|e| e * slope);
        if change.iter().copied().chain(predicted).all(|c| c.abs() <= noise) {
            return Self::Constant;
        }
        // the longest step changes the term most
        let limit = LINEAR * change[0].abs();
        match remainder[0].max(noise) <= limit {
            true => Self::Linear(remainder[0] / change[0].abs()),
            false => Self::NotMeasurable,
        }
    }

    pub fn passes(self) -> bool {
        match self {
            Self::Slope(slope) => ACCEPTED.contains(&slope),
            Self::Kink | Self::Faster(_) | Self::Constant | Self::Linear(_) => true,
            Self::TooLong | Self::NotMeasurable => false,
        }
    }

    /// Whether shorter steps may find something else.
    pub fn is_open(self) -> bool {
        !self.passes() && self != Self::NotMeasurable
    }

    /// The finding of steps along q, if those along −q have another one.
    pub fn beside(self, backward: Self) -> Self {
        match self {
            Self::Slope(slope) if slope < *ACCEPTED.start() && backward.passes() => Self::Kink,
            _ => self,
        }
    }

    /// The finding of the shortest steps, after those `before` with longer ones. A wrong gradient leaves a slope of 1.
    pub fn after(self, before: &[(f64, Self)]) -> Self {
        let faster = |finding: Self| match finding {
            Self::Slope(slope) if slope > *ACCEPTED.end() => Some(slope),
            _ => None,
        };
        let all: Option<Vec<f64>> = before.iter().map(|(_, finding)| faster(*finding)).collect();
        let Some(last) = all.and_then(|all| all.last().copied()) else { return self };
        match (self, faster(self)) {
            (Self::NotMeasurable, _) => Self::Faster(last),
            (_, Some(own)) => Self::Faster(own),
            _ => self,
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Slope(slope) => write!(f, "slope {slope:.3} (2 expected)"),
            Self::Kink => write!(
                f,
                "slope 1 along q and not along −q: a kink, such as where a thread passes a vertex; g·q is the derivative \
                 along −q"
            ),
            Self::Faster(slope) => {
                write!(f, "slope {slope:.3} until the remainder is within rounding")
            }
            Self::Constant => write!(f, "no change within rounding, and none predicted"),
            Self::Linear(off) => write!(f, "linear: the change is ε g·q within {off:.0e} of it"),
            Self::TooLong => write!(f, "no result with steps of this length"),
            Self::NotMeasurable => write!(f, "not measurable: the remainder is within rounding"),
        }
    }
}

/// Number of first remainders that fall as noise never does several times in a row: [`QUADRATIC`] about as an
/// exact gradient's, or [`POINTS`] exactly so; else none.
fn quadratic(epsilon: &[f64], remainder: &[f64]) -> usize {
    let enough = |slopes: std::ops::RangeInclusive<f64>, least: usize| {
        let pairs = epsilon.windows(2).zip(remainder.windows(2));
        let fall = pairs.take_while(|(e, r)| slopes.contains(&log_slope(e, r))).count() + 1;
        if fall >= least { fall } else { 0 }
    };
    enough(FALLING, QUADRATIC).max(enough(EXACT, POINTS))
}

#[cfg(test)]
mod tests {
    use super::super::{Outcome, Step};
    use super::*;

    /// J(ε) along a direction, at steps up to 0.01.
    fn steps(count: i32, j: impl Fn(f64) -> f64) -> Vec<Step> {
        (0..count).map(|k| 1e-2 * 0.5_f64.powi(k)).map(|e| (e, Some(j(e)))).collect()
    }

    /// The finding for J(ε) with a slope g·q.
    fn found(j: impl Fn(f64) -> f64, slope: f64) -> Finding {
        Outcome::new("term", j(0.0), slope, &steps(7, &j), 7).finding
    }

    #[test]
    fn a_curved_term_has_a_slope() {
        let j = |e: f64| (1.0 + e).powi(3);
        assert!(found(j, 3.0).passes() && matches!(found(j, 3.0), Finding::Slope(_)));
        assert!(!found(j, 3.1).passes());
        assert!(!found(j, 0.0).passes());
    }

    /// The remainders are 4e-11 of the term and less.
    #[test]
    fn small_remainders_that_fall_as_they_should_have_a_slope() {
        let j = |e: f64| 5.0 + 1e-3 * e + 2e-6 * e * e;
        assert!(found(j, 1e-3).passes() && matches!(found(j, 1e-3), Finding::Slope(_)));
        assert!(!found(j, 1.01e-3).passes());
    }

    /// Three steps are too few for [`QUADRATIC`] remainders.
    #[test]
    fn few_remainders_that_fall_exactly_by_four_have_a_slope() {
        let j = |e: f64| 5.0 + 1e-3 * e + 2e-6 * e * e;
        let finding = |slope: f64| Outcome::new("term", j(0.0), slope, &steps(3, j), 3).finding;
        assert!(finding(1e-3).passes() && matches!(finding(1e-3), Finding::Slope(_)));
        assert!(!finding(1.01e-3).passes());
    }

    #[test]
    fn without_a_slope_only_proven_gradients_pass() {
        assert_eq!(found(|_| 5.0, 0.0), Finding::Constant);
        assert_eq!(found(|_| 0.0, 0.0), Finding::Constant);
        assert!(!found(|_| 5.0, 1e-3).passes());
        let line = |e: f64| 5.0 + 2.0 * e;
        assert!(matches!(found(line, 2.0), Finding::Linear(_)));
        assert!(!found(line, 2.001).passes());
        assert!(!found(line, 0.0).passes());
        // changes of 1e-8 of the term, of which 10 % may be noise, prove nothing
        assert_eq!(found(|e| 5.0 + 5e-6 * e, 5e-6), Finding::NotMeasurable);
        assert_eq!(found(|e| 5.0 + 5e-6 * e, 4.8e-6), Finding::NotMeasurable);
    }

    #[test]
    fn a_kink_is_told_from_a_wrong_gradient() {
        let j = |e: f64| 5.0 + if e > 0.0 { 1.1 * e } else { e } + e * e;
        let both = |slope: f64| found(j, slope).beside(found(|e| j(-e), -slope));
        assert!(both(1.0).passes() && both(1.0) == Finding::Kink);
        assert!(!both(1.05).passes());
        let smooth = |e: f64| 5.0 + e + e * e;
        assert!(!found(smooth, 1.1).beside(found(|e| smooth(-e), -1.1)).passes());
    }

    #[test]
    fn a_term_without_curvature_has_a_slope_above_two() {
        let j = |e: f64| 5.0 + 1e-3 * e + e.powi(3);
        let told =
            |slope: f64| Outcome::new("term", j(0.0), slope, &steps(15, j), 7).at_last().finding;
        assert!(told(1e-3).passes() && matches!(told(1e-3), Finding::Faster(_)), "{}", told(1e-3));
        assert!(!told(1.01e-3).passes(), "{}", told(1.01e-3));
    }
}
