//! A pressure over time by its slopes.
//!
//! P_n = P_0 + Σ_{m ≤ n} Δt_m s_m      s_m = s⁰_m + r y_m
//!
//! P_n   gauge pressure at the end of time step n [Pa]
//! s_m   slope during step m, s⁰ that of the scene [Pa/s]
//! y_m   design variables [m]; zero is the scene's pressure
//! r     a tenth of the scale of pressure per run and mean edge, so that changing all
//!       y by an edge changes the pressure at the end by a tenth of its scale, as
//!       variables of the shape change it by about an edge [Pa/s/m]
//!
//! Source: the authors' walker, Gjoka et al. 2024, section 5.

/// Change of the pressure for a variable of one mean edge, over its scale.
const SHARE: f64 = 0.1;

/// One pressure.
#[derive(Clone, Debug)]
pub struct PressureCurve {
    /// t_0 = 0, t_1, …, t_N [s].
    times: Vec<f64>,
    start: f64,
    /// s⁰, one for each design variable [Pa/s].
    pub slopes: Vec<f64>,
    /// Change of a slope by a metre of its variable, r [Pa/s/m].
    pub unit: f64,
}

impl PressureCurve {
    /// Slopes around a pressure with `values` P_n [Pa] at `times` t_n [s], the first 0. `scale` is a
    /// typical pressure [Pa], `edge` a typical motion of the shape [m].
    pub fn new(times: &[f64], values: &[f64], scale: f64, edge: f64) -> Self {
        let slopes = (1..times.len())
            .map(|n| (values[n] - values[n - 1]) / (times[n] - times[n - 1]))
            .collect();
        let unit = SHARE * scale / (times[times.len() - 1] * edge);
        Self { times: times.to_vec(), start: values[0], slopes, unit }
    }

    /// P_0, …, P_N [Pa].
    pub fn values(&self, y: &[f64]) -> Vec<f64> {
        let mut values = vec![self.start];
        for (n, (slope, y)) in self.slopes.iter().zip(y).enumerate() {
            let dt = self.times[n + 1] - self.times[n];
            values.push(values[n] + dt * (slope + self.unit * y));
        }
        values
    }

    /// Cotangents of the variables for those of P_1, …, P_N.
    pub fn vjp(&self, bar: &[f64]) -> Vec<f64> {
        let mut later = 0.0;
        let mut by: Vec<f64> = (0..bar.len())
            .rev()
            .map(|n| {
                later += bar[n];
                later * self.unit * (self.times[n + 1] - self.times[n])
            })
            .collect();
        by.reverse();
        by
    }

    /// What P_1, …, P_N are above the low and below the high one [Pa], each with its derivatives by the variables.
    pub fn within(&self, y: &[f64], [low, high]: [f64; 2]) -> Vec<(f64, Vec<(usize, f64)>)> {
        let values = self.values(y);
        let of_one = |n: usize| {
            let by = |sign: f64| {
                let each = self.times.windows(2).take(n).enumerate();
                each.map(|(i, t)| (i, sign * self.unit * (t[1] - t[0]))).collect::<Vec<_>>()
            };
            [(values[n] - low, by(1.0)), (high - values[n], by(-1.0))]
        };
        (1..values.len()).flat_map(of_one).collect()
    }
}

#[cfg(test)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::check_gradient;

    use super::*;

    #[test]
    fn slopes_add_up_and_have_their_transpose() {
        let (times, values) = ([0.0, 0.1, 0.4, 0.5], [0.0, 100.0, -50.0, 0.0]);
        let curve = PressureCurve::new(&times, &values, 500.0, 1e-3);
        assert_eq!(curve.values(&[0.0; 3]), values);
        // all variables by an edge: the end by a tenth of the scale
        assert!((curve.values(&[1e-3; 3])[3] - 50.0).abs() < 1e-9);
        let y = Random::new(1).numbers(3);
        let value = |y: &[f64]| -> f64 {
            curve.values(y)[1..].iter().enumerate().map(|(n, p)| (n + 1) as f64 * p * p).sum()
        };
        let bar: Vec<f64> = curve.values(&y)[1..]
            .iter()
            .enumerate()
            .map(|(n, p)| 2.0 * (n + 1) as f64 * p)
            .collect();
        check_gradient(&y, &curve.vjp(&bar), 1e-4, value);
    }
}
