//! Laws fitted to tensile tests (parameter identification).
//!
//! Nominal stress of the incompressible law (see [`mechanics::material::response`])
//! against the measured one, least squares over all points of all tests. The
//! residuals and their derivatives come from the laws of the table themselves.
//!
//! A test of a soft rubber says nothing about its bulk modulus: it is set to a
//! fixed ratio to the shear modulus, [`mechanics::material::BULK_RATIO`] unless another is given.

mod candidate;
mod data;
mod plot;

pub use candidate::{CANDIDATES, Candidate};
pub use data::{Test, Units, read};
pub use plot::draw;

use mechanics::material::response::{Mode, free_uniaxial};
use mechanics::material::{Law, Moduli, Softening, Specification};
use serde::Serialize;

/// Stretch up to which stability is looked for.
const STABILITY_LIMIT: f64 = 20.0;

/// A law fitted to tests.
#[derive(Clone)]
pub struct Fitted {
    /// What was fitted.
    pub candidate: &'static Candidate,
    /// The parameters, as the law takes them.
    pub values: Vec<f64>,
    /// How well, and where it may be used.
    pub quality: Quality,
}

/// How well a law fits and where it may be used.
#[derive(Clone, Debug, Serialize)]
pub struct Quality {
    /// Coefficient of determination over all points [1].
    pub r2: f64,
    /// Root mean square of the errors in nominal stress [Pa].
    pub rms: f64,
    /// Largest error in nominal stress [Pa].
    pub largest_error: f64,
    /// Moduli at rest.
    pub moduli: Moduli,
    /// Smallest and largest stretch in the data, along the pull [1].
    pub fitted: [f64; 2],
    /// For each mode, the stretch up to which nominal stress rises [1]; none
    /// when it rises as far as was looked.
    pub stable_up_to: Vec<(Mode, Option<f64>)>,
    /// The fitted range as far as it is stable in all modes.
    pub stretch_range: [f64; 2],
    /// Largest change of uniaxial stress, relative to the largest stress, that
    /// the finite bulk modulus causes in the fitted range [1].
    pub compressibility: f64,
}

impl Fitted {
    /// The law.
    #[must_use]
    pub fn law(&self) -> &'static Law {
        self.candidate.law()
    }

    /// Law, parameters and range.
    #[must_use]
    pub fn specification(&self) -> Specification {
        Specification {
            law: self.law(),
            values: self.values.clone(),
            density: None,
            stretch_range: Some(self.quality.stretch_range),
            modes: Vec::new(),
            stretch_at_break: None,
            softening: Softening::default(),
        }
    }

    /// Whether nominal stress rises over all of the data, in every mode.
    #[must_use]
    pub fn stable(&self) -> bool {
        self.quality.stretch_range[1] >= self.quality.fitted[1]
    }
}

/// Fits one candidate; nothing if no admissible parameters describe the data.
#[must_use]
pub fn fit(candidate: &'static Candidate, tests: &[Test], bulk_ratio: f64) -> Option<Fitted> {
    let values = candidate.solve(tests, bulk_ratio)?;
    let quality = quality(candidate.law(), &values, tests);
    Some(Fitted { candidate, values, quality })
}

/// The fit to use: of those that are stable over the data and within 0.001 of
/// the best R², the one with the fewest parameters; without a stable one, the
/// one that is stable furthest.
#[must_use]
pub fn choose(fits: &[Fitted]) -> Option<&Fitted> {
    let stable: Vec<_> = fits.iter().filter(|f| f.stable()).collect();
    let best = stable.iter().map(|f| f.quality.r2).fold(f64::NEG_INFINITY, f64::max);
    let good = stable.into_iter().filter(|f| f.quality.r2 >= best - 1e-3);
    let simplest = good.min_by(|a, b| {
        let by_count = a.candidate.unknowns().cmp(&b.candidate.unknowns());
        by_count.then(b.quality.r2.total_cmp(&a.quality.r2))
    });
    let reach = |f: &&Fitted| f.quality.stretch_range[1];
    simplest.or_else(|| fits.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))))
}

fn quality(law: &'static Law, values: &[f64], tests: &[Test]) -> Quality {
    let material = (law.build)(values);
    let mut errors = Vec::new();
    let mut stresses = Vec::new();
    for test in tests {
        for &(stretch, stress) in &test.points {
            stresses.push(stress);
            errors.push(test.mode.nominal_stress(material.as_ref(), stretch) - stress);
        }
    }
    let count = errors.len() as f64;
    let mean = stresses.iter().sum::<f64>() / count;
    let spread: f64 = stresses.iter().map(|s| (s - mean).powi(2)).sum();
    let sum: f64 = errors.iter().map(|e| e * e).sum();
    let fitted = range(tests);
    let ends = Mode::ALL.map(|m| m.stable_up_to(material.as_ref(), STABILITY_LIMIT));
    let stable = ends.into_iter().fold(f64::INFINITY, f64::min);
    let named = Mode::ALL.into_iter().zip(ends.map(|e| e.is_finite().then_some(e)));
    Quality {
        r2: 1.0 - sum / spread,
        rms: (sum / count).sqrt(),
        largest_error: errors.iter().fold(0.0, |m, e| m.max(e.abs())),
        moduli: (law.moduli)(values),
        fitted,
        stable_up_to: named.collect(),
        // a range starts at rest where it has no compression
        stretch_range: [fitted[0].min(1.0), fitted[1].max(1.0).min(stable)],
        compressibility: compressibility(material.as_ref(), fitted),
    }
}

/// Smallest and largest stretch along the pull.
fn range(tests: &[Test]) -> [f64; 2] {
    let stretches = || tests.iter().flat_map(|t| t.points.iter().map(|p| p.0));
    [stretches().fold(f64::INFINITY, f64::min), stretches().fold(0.0, f64::max)]
}

fn compressibility(material: &dyn mechanics::material::Material, [low, high]: [f64; 2]) -> f64 {
    let (mut change, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
    for i in 0..=20 {
        let stretch = low + (high - low) * f64::from(i) / 20.0;
        let exact = Mode::Uniaxial.nominal_stress(material, stretch);
        change = change.max((free_uniaxial(material, stretch).0 - exact).abs());
        largest = largest.max(exact.abs());
    }
    change / largest
}

#[cfg(test)]
mod tests;
