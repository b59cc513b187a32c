//! Which of several fitted laws to use, and what none of them knows.

use mechanics::material::response::Mode;
use serde::Serialize;

use super::{Candidate, Fitted, Test};

/// Part by which a fit may be worse than the best and still be as good [1].
const AS_GOOD: f64 = 0.1;
/// Error that tells no two laws apart, as a part of the largest stress [1]: specimens of one batch differ by more.
const UNTOLD: f64 = 0.01;
/// Difference of R² that tells no two laws apart, where one mode was tested.
const SAME_R2: f64 = 1e-3;
/// Factor by which a law's guess of a mode that was not tested may differ from what most of the others say [1].
const FAR: f64 = 2.0;

/// What laws that fit equally well say of a mode that was not tested.
#[derive(Clone, Debug, Serialize)]
pub struct Spread {
    /// The mode.
    pub mode: Mode,
    /// Stretch along the pull: the largest principal stretch of the range [1].
    pub stretch: f64,
    /// Least and largest nominal stress [Pa].
    pub stress: [f64; 2],
    /// The laws that say so.
    pub laws: [&'static str; 2],
}

/// The modes of tests.
fn modes(tests: &[Test]) -> Vec<Mode> {
    Mode::ALL.into_iter().filter(|mode| tests.iter().any(|test| test.mode == *mode)).collect()
}

/// The prediction of each mode from the others, see [`super::Quality::left_out`].
pub(super) fn left_out(
    candidate: &'static Candidate,
    tests: &[Test],
    bulk_ratio: f64,
) -> Option<f64> {
    let modes = modes(tests);
    if modes.len() < 2 {
        return None;
    }
    let mut sum = 0.0;
    for mode in &modes {
        let (own, others): (Vec<_>, Vec<_>) =
            tests.iter().cloned().partition(|test| test.mode == *mode);
        let values = candidate.solve(&others, bulk_ratio)?;
        let material = (candidate.law().build)(&values);
        let (mut errors, mut squares) = (0.0, 0.0);
        for &(stretch, stress) in own.iter().flat_map(|test| &test.points) {
            errors += (mode.nominal_stress(material.as_ref(), stretch) - stress).powi(2);
            squares += stress * stress;
        }
        sum += errors / squares;
    }
    Some((sum / modes.len() as f64).sqrt()).filter(|found| found.is_finite())
}

/// The fit to use. Of those that are stable over the data, the one with the fewest parameters that is as good as the
/// best: where several modes were tested, as it predicts each of them from the others; else within 0.001 of the best R², and
/// in no mode far from what most of these say. Without a stable one, the one that is stable furthest.
pub fn choose<'a>(fits: &'a [Fitted], tests: &[Test]) -> Option<&'a Fitted> {
    let stable: Vec<_> = fits.iter().filter(|f| f.stable()).collect();
    let errors = stable.iter().filter_map(|f| f.quality.left_out);
    let least = errors.reduce(f64::min);
    let best = stable.iter().map(|f| f.quality.r2).fold(f64::NEG_INFINITY, f64::max);
    let good = stable.into_iter().filter(|f| match least {
        Some(least) => f.quality.left_out.is_some_and(|error| error <= (1.0 + AS_GOOD) * least),
        None => f.quality.r2 >= best - SAME_R2,
    });
    let mut good: Vec<_> = good.collect();
    for mode in Mode::ALL.into_iter().filter(|mode| !modes(tests).contains(mode)) {
        let stress = |f: &Fitted| {
            let law = (f.law().build)(&f.values);
            mode.nominal_stress(law.as_ref(), f.quality.stretch_range[1])
        };
        let mut stresses: Vec<f64> = good.iter().map(|f| stress(f)).collect();
        stresses.sort_by(f64::total_cmp);
        let Some(&middle) = stresses.get(stresses.len().saturating_sub(1) / 2) else { break };
        good.retain(|f| (middle / FAR..=middle * FAR).contains(&stress(f)));
    }
    let simplest = good.into_iter().min_by(|a, b| {
        let by_count = a.candidate.unknowns().cmp(&b.candidate.unknowns());
        by_count.then(b.quality.r2.total_cmp(&a.quality.r2))
    });
    let reach = |f: &&Fitted| f.quality.stretch_range[1];
    simplest.or_else(|| fits.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))))
}

/// How far the laws that fit as well as the best, or as the chosen one, are apart in the modes that were not tested.
pub fn spreads(fits: &[Fitted], chosen: &Fitted, tests: &[Test]) -> Vec<Spread> {
    let stresses = tests.iter().flat_map(|test| test.points.iter().map(|point| point.1.abs()));
    let untold = UNTOLD * stresses.fold(0.0, f64::max);
    let best = fits.iter().map(|f| f.quality.rms).fold(f64::INFINITY, f64::min);
    let enough = ((1.0 + AS_GOOD) * best).max(untold).max(chosen.quality.rms);
    let usable = |f: &&Fitted| f.stable() || std::ptr::eq(*f, chosen);
    let good: Vec<_> = fits.iter().filter(usable).filter(|f| f.quality.rms <= enough).collect();
    let (tested, stretch) = (modes(tests), chosen.quality.stretch_range[1]);
    let one = |mode: Mode| {
        let stress =
            |f: &&&Fitted| mode.nominal_stress((f.law().build)(&f.values).as_ref(), stretch);
        let least = good.iter().min_by(|a, b| stress(a).total_cmp(&stress(b)))?;
        let most = good.iter().max_by(|a, b| stress(a).total_cmp(&stress(b)))?;
        let laws = [least.candidate.name, most.candidate.name];
        Some(Spread { mode, stretch, stress: [stress(&least), stress(&most)], laws })
    };
    Mode::ALL.into_iter().filter(|mode| !tested.contains(mode)).filter_map(one).collect()
}
