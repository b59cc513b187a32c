//! Laws fitted to tensile tests (parameter identification).
//!
//! Nominal stress of the incompressible law (see [`mechanics::material::response`])
//! against the measured one, least squares over all points of all tests. The
//! residuals and their derivatives come from the laws of the table themselves.
//!
//! A test of a soft rubber says nothing about its bulk modulus: it is set to a
//! fixed ratio to the shear modulus, [`mechanics::material::BULK_RATIO`] unless another is given.
//!
//! A test in one mode says little about others (Ogden, Saccomandi and Sgura 2004, doi:10.1007/s00466-004-0593-y): where
//! several modes were tested, a law is judged by how it predicts each of them from the others, and where one is missing,
//! by how far laws that fit equally well are apart in it.

mod candidate;
mod data;
mod judge;
mod plot;

pub use candidate::{CANDIDATES, Candidate};
pub use data::{Test, Units, read};
pub use judge::{Spread, choose, spreads};
pub use plot::draw;

use mechanics::material::response::{Mode, free_uniaxial};
use mechanics::material::{Law, Moduli};
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
    /// Smallest and largest principal stretch in the data [1].
    pub tested: [f64; 2],
    /// For each mode, in tension and compression, the stretch up to which nominal stress rises and the law is stable
    /// (Drucker) [1]; none when it is so as far as was looked.
    pub stable_up_to: Vec<(Mode, Option<f64>)>,
    /// Smallest and largest principal stretch in the data, as far as the law is stable in all modes [1].
    pub stretch_range: [f64; 2],
    /// Where several modes were tested: each predicted by the law that is fitted to the others, root of the mean of the
    /// squared errors over that of the stresses, and the same mean over the modes [1]. None where no such fit is
    /// admissible.
    pub left_out: Option<f64>,
    /// Largest change of uniaxial stress, relative to the largest stress, that
    /// the finite bulk modulus causes in the fitted range [1].
    pub compressibility: f64,
}

impl Fitted {
    /// The law.
    pub fn law(&self) -> &'static Law {
        self.candidate.law()
    }

    /// Whether it is stable over all of the data, in every mode.
    pub fn stable(&self) -> bool {
        self.quality.stretch_range == self.quality.tested
    }
}

/// Fits one candidate; nothing if no admissible parameters describe the data.
pub fn fit(candidate: &'static Candidate, tests: &[Test], bulk_ratio: f64) -> Option<Fitted> {
    let values = candidate.solve(tests, bulk_ratio)?;
    let mut quality = quality(candidate.law(), &values, tests);
    quality.left_out = judge::left_out(candidate, tests, bulk_ratio);
    Some(Fitted { candidate, values, quality })
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
    let (fitted, tested) = (range(tests), principal(tests, f64::INFINITY));
    let ends = Mode::ALL.map(|m| m.stable_up_to(material.as_ref(), STABILITY_LIMIT));
    let stable = ends.into_iter().fold(f64::INFINITY, f64::min);
    let named = Mode::ALL.into_iter().zip(ends.map(|e| e.is_finite().then_some(e)));
    Quality {
        r2: 1.0 - sum / spread,
        rms: (sum / count).sqrt(),
        largest_error: errors.iter().fold(0.0, |m, e| m.max(e.abs())),
        moduli: (law.moduli)(values),
        fitted,
        tested,
        stable_up_to: named.collect(),
        stretch_range: principal(tests, stable),
        left_out: None,
        compressibility: compressibility(material.as_ref(), fitted),
    }
}

/// Smallest and largest stretch along the pull.
fn range(tests: &[Test]) -> [f64; 2] {
    let stretches = || tests.iter().flat_map(|t| t.points.iter().map(|p| p.0));
    [stretches().fold(f64::INFINITY, f64::min), stretches().fold(0.0, f64::max)]
}

/// Smallest and largest principal stretch of tests, each pulled or pressed no further than until its largest one is `most`.
fn principal(tests: &[Test], most: f64) -> [f64; 2] {
    let mut range = [1.0_f64, 1.0_f64];
    for test in tests {
        for end in self::range(std::slice::from_ref(test)) {
            // a block that is compressed to λ is stretched across it
            let end = match test.mode {
                _ if end >= 1.0 => end.min(most),
                Mode::Uniaxial => end.max(most.powi(-2)),
                Mode::Biaxial => end.max(most.powf(-0.5)),
                Mode::Planar => end.max(1.0 / most),
            };
            let stretches = test.mode.stretches(end);
            range[0] = stretches.into_iter().fold(range[0], f64::min);
            range[1] = stretches.into_iter().fold(range[1], f64::max);
        }
    }
    range
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
