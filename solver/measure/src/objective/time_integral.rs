//! Sums over time steps.
//!
//! J = Σ ω_n j(u_n)      n = 0 at rest, n = 1 … N at the ends t_n of the time steps
//!
//! final       ω_N = 1
//! steps       ω_n = 1/K for each of K listed steps; repeats add up
//! times       the same for the steps that end at K listed times [s]
//! uniform     ω_n = Δt_n = t_n − t_{n−1} for n ≥ 1                          [s]
//! trapezoid   ω_n = (t_{n+1} − t_{n−1})/2, half a step at both ends         [s]
//! simpson     Δt/3 (1, 4, 2, 4, …, 2, 4, 1) for an even number of equal steps [s]

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Relative difference of steps that count as equal.
const EQUAL: f64 = 1e-9;

/// Which sum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeIntegral {
    /// The last state.
    #[default]
    Final,
    /// The mean over time steps, of which the first is 1.
    Steps(Vec<usize>),
    /// The mean over the states at these times [s], however long the time steps are: one has to end at each.
    Times(Vec<f64>),
    /// The rectangle rule.
    Uniform,
    /// The trapezoidal rule.
    Trapezoid,
    /// Simpson's rule.
    Simpson,
}

impl TimeIntegral {
    /// ω_n for n = 0 … N, given the ends of the N time steps [s].
    pub fn factors(&self, ends: &[f64]) -> Result<Vec<f64>, String> {
        let count = ends.len();
        let t = |n: usize| if n == 0 { 0.0 } else { ends[n - 1] };
        let mut factors = vec![0.0; count + 1];
        match self {
            Self::Final => factors[count] = 1.0,
            Self::Steps(steps) => {
                if steps.is_empty() {
                    return Err("steps = []: name one time step or more".to_owned());
                }
                for &n in steps {
                    if n == 0 || n > count {
                        return Err(format!("step {n}: the scene has steps 1 to {count}"));
                    }
                    factors[n] += 1.0 / steps.len() as f64;
                }
            }
            Self::Times(times) => {
                if times.is_empty() {
                    return Err("times = []: name one time or more".to_owned());
                }
                for &time in times {
                    factors[step_at(time, ends)?] += 1.0 / times.len() as f64;
                }
            }
            Self::Uniform => (1..=count).for_each(|n| factors[n] = t(n) - t(n - 1)),
            Self::Trapezoid => (1..=count).for_each(|n| {
                let half = 0.5 * (t(n) - t(n - 1));
                factors[n - 1] += half;
                factors[n] += half;
            }),
            Self::Simpson => {
                let dt = t(count) / count as f64;
                let equal = |n: usize| (t(n) - n as f64 * dt).abs() <= EQUAL * t(count);
                if count % 2 == 1 || !(1..=count).all(equal) {
                    return Err(format!(
                        "simpson needs an even number of equal time steps, the scene has {count}{}",
                        if count.is_multiple_of(2) { " that are not equal" } else { "" }
                    ));
                }
                for (n, factor) in factors.iter_mut().enumerate() {
                    let by = if n == 0 || n == count { 1.0 } else { [2.0, 4.0][n % 2] };
                    *factor = by * dt / 3.0;
                }
            }
        }
        Ok(factors)
    }
}

/// The step, of which the first is 1, that ends at a time [s].
fn step_at(time: f64, ends: &[f64]) -> Result<usize, String> {
    let off = |end: f64| (end - time).abs();
    let nearest = (0..ends.len()).min_by(|&a, &b| off(ends[a]).total_cmp(&off(ends[b])));
    let last = ends.last().copied().unwrap_or_default();
    match nearest {
        Some(n) if off(ends[n]) <= EQUAL * last => Ok(n + 1),
        Some(n) => Err(format!(
            "time {time} s: no time step ends there; step {} of {} ends at {} s, the nearest",
            n + 1,
            ends.len(),
            ends[n]
        )),
        None => Err(format!("time {time} s: the scene has no time steps")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integrate(rule: &TimeIntegral, ends: &[f64], f: fn(f64) -> f64) -> f64 {
        let factors = rule.factors(ends).expect("fits");
        let times = [0.0].iter().chain(ends);
        factors.iter().zip(times).map(|(w, t)| w * f(*t)).sum()
    }

    #[test]
    fn rules_integrate_what_they_should() {
        let equal: Vec<f64> = (1..=6).map(|n| 0.5 * f64::from(n)).collect();
        let uneven = [0.1, 0.5, 2.0, 3.0];
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-13 * b.abs().max(1.0), "{a} {b}");
        for ends in [&equal[..], &uneven] {
            close(integrate(&TimeIntegral::Trapezoid, ends, |t| 2.0 * t + 1.0), 12.0);
            close(integrate(&TimeIntegral::Uniform, ends, |_| 2.0), 6.0);
            close(integrate(&TimeIntegral::Final, ends, |t| t * t), 9.0);
        }
        close(integrate(&TimeIntegral::Simpson, &equal, |t| t * t * t), 81.0 / 4.0);
        let steps = TimeIntegral::Steps(vec![1, 3, 3]);
        close(integrate(&steps, &equal, |t| t), (0.5 + 1.5 + 1.5) / 3.0);
        // 0.1 + 0.2 is not quite 0.3
        let times = TimeIntegral::Times(vec![0.3, 0.9]);
        close(integrate(&times, &[0.1, 0.1 + 0.2, 0.9], |t| t), 0.6);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let fails = |rule: TimeIntegral, ends: &[f64]| rule.factors(ends).expect_err("refused");
        assert!(fails(TimeIntegral::Simpson, &[1.0, 2.0, 3.0]).contains("even number"));
        assert!(fails(TimeIntegral::Simpson, &[1.0, 3.0]).contains("not equal"));
        assert!(fails(TimeIntegral::Steps(vec![4]), &[1.0]).contains("step 4"));
        assert!(fails(TimeIntegral::Steps(vec![]), &[1.0]).contains("one time step"));
        assert!(fails(TimeIntegral::Times(vec![]), &[1.0]).contains("one time"));
        let found = fails(TimeIntegral::Times(vec![0.7]), &[0.5, 1.0]);
        assert!(found.contains("step 1 of 2 ends at 0.5 s"), "{found}");
        assert!(fails(TimeIntegral::Times(vec![0.7]), &[]).contains("no time steps"));
    }
}
