//! One objective from those of several scenarios.
//!
//! mean              m = Σ w_s J_s
//! with deviations   m + k σ,   σ² = Σ w_s (J_s − m)²
//! worst             M + τ ln Σ w_s exp((J_s − M)/τ),   M the largest J_s
//!
//! w_s   weights of the scenarios; their sum is 1
//! k     number of standard deviations [1]
//! τ     difference of objectives over which the largest is smoothed: what is minimised is at
//!       most τ ln(1/w) below the largest, w the weight of its scenario
//!
//! Each is J where all J_s are J. Smoothed maximum: Kreisselmeier and Steinhauser 1979.

use scene::config::{RobustConfig, ScenarioConfig};

/// How the objectives of scenarios become one.
#[derive(Clone, Debug)]
pub struct Robust {
    /// w, whose sum is 1.
    pub weights: Vec<f64>,
    measure: Measure,
}

#[derive(Clone, Copy, Debug)]
enum Measure {
    /// Standard deviations beyond the mean.
    Deviations(f64),
    /// Difference over which the largest is smoothed.
    Worst(f64),
}

impl Robust {
    /// As a design has it.
    pub fn new(scenarios: &[ScenarioConfig], config: Option<RobustConfig>) -> Self {
        let sum: f64 = scenarios.iter().map(|scenario| scenario.weight).sum();
        let weights = scenarios.iter().map(|scenario| scenario.weight / sum).collect();
        let RobustConfig { deviations, worst } = config.unwrap_or_default();
        let measure = match worst {
            Some(smoothing) => Measure::Worst(smoothing),
            None => Measure::Deviations(deviations.unwrap_or(0.0)),
        };
        Self { weights, measure }
    }

    /// Whether it is the mean, of terms as of their sum.
    pub fn is_mean(&self) -> bool {
        self.weights.len() == 1 || matches!(self.measure, Measure::Deviations(0.0))
    }

    /// m.
    pub fn mean(&self, objectives: &[f64]) -> f64 {
        self.weights.iter().zip(objectives).map(|(w, j)| w * j).sum()
    }

    /// The one objective.
    pub fn value(&self, objectives: &[f64]) -> f64 {
        let mean = self.mean(objectives);
        match self.measure {
            Measure::Deviations(0.0) => mean,
            Measure::Deviations(count) => mean + count * self.deviation(objectives),
            Measure::Worst(smoothing) => {
                let (largest, sum) = self.exponentials(objectives, smoothing);
                largest + smoothing * sum.iter().sum::<f64>().ln()
            }
        }
    }

    /// The derivatives by the objectives; their sum is 1. Where all objectives are the same, a
    /// standard deviation has none, and those of the mean are taken.
    pub fn derivatives(&self, objectives: &[f64]) -> Vec<f64> {
        match self.measure {
            Measure::Deviations(count) => {
                let (mean, deviation) = (self.mean(objectives), self.deviation(objectives));
                let beyond = |j: &f64| match deviation {
                    0.0 => 0.0,
                    deviation => count * (j - mean) / deviation,
                };
                let pairs = self.weights.iter().zip(objectives);
                pairs.map(|(w, j)| w * (1.0 + beyond(j))).collect()
            }
            Measure::Worst(smoothing) => {
                let (_, each) = self.exponentials(objectives, smoothing);
                let sum: f64 = each.iter().sum();
                each.iter().map(|e| e / sum).collect()
            }
        }
    }

    /// σ.
    fn deviation(&self, objectives: &[f64]) -> f64 {
        let mean = self.mean(objectives);
        let squares = self.weights.iter().zip(objectives).map(|(w, j)| w * (j - mean).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// M, and w exp((J − M)/τ) of each.
    fn exponentials(&self, objectives: &[f64], smoothing: f64) -> (f64, Vec<f64>) {
        let largest = objectives.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let pairs = self.weights.iter().zip(objectives);
        (largest, pairs.map(|(w, j)| w * ((j - largest) / smoothing).exp()).collect())
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::check_gradient;

    use super::*;

    fn robust(config: RobustConfig) -> Robust {
        let weighs = |weight| ScenarioConfig { weight, ..Default::default() };
        Robust::new(&[1.0, 2.0, 1.0].map(weighs), Some(config))
    }

    const MEASURES: [RobustConfig; 4] = [
        RobustConfig { deviations: None, worst: None },
        RobustConfig { deviations: Some(2.0), worst: None },
        RobustConfig { deviations: None, worst: Some(0.3) },
        RobustConfig { deviations: None, worst: Some(1e-3) },
    ];

    #[test]
    fn values_are_those_of_closed_forms() {
        let objectives = [3.0, 1.0, -1.0];
        // m = 1, σ² = (4 + 0 + 4)/4
        let expected = [1.0, 1.0 + 2.0 * 2.0_f64.sqrt()];
        for (config, expected) in MEASURES.into_iter().zip(expected) {
            assert!((robust(config).value(&objectives) - expected).abs() < 1e-14);
        }
        // within τ ln 4 of the largest
        for (config, smoothing) in MEASURES[2..].iter().zip([0.3, 1e-3]) {
            let below = 3.0 - robust(*config).value(&objectives);
            assert!((0.0..smoothing * 4.0_f64.ln() + 1e-12).contains(&below), "{below}");
        }
        for config in MEASURES {
            assert!((robust(config).value(&[2.5; 3]) - 2.5).abs() < 1e-14);
        }
    }

    #[test]
    fn derivatives_are_exact_and_sum_to_one() {
        let objectives = [1.3, 1.0, 0.9];
        // the mean is linear: a Taylor test says nothing of it
        assert_eq!(robust(MEASURES[0]).derivatives(&objectives), [0.25, 0.5, 0.25]);
        for config in &MEASURES[1..3] {
            let measure = robust(*config);
            let by = measure.derivatives(&objectives);
            check_gradient(&objectives, &by, 1e-2, |j| measure.value(j));
            assert!((by.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }
        let same = robust(MEASURES[1]).derivatives(&[2.0; 3]);
        assert_eq!(same, [0.25, 0.5, 0.25]);
    }
}
