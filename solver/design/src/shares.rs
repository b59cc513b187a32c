//! Shares of terms in the objective, and the weights that give them.
//!
//! s_i = |w_i J_i| / T,   T = Σ |w_j J_j|
//!
//! J_i   value of a term at the start of the design, the mean over its scenarios
//! w_i   its weight, in the inverse of its unit
//! s_i   its share [1]
//!
//! Where some weights are given, A = Σ |w_j J_j| of those, and shares s_i are wanted of the
//! others, T = A / (1 − Σ s_i). Where A is zero, only ratios of shares have a meaning, and T = 1.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};
use scene::config::Weight;

/// A term that has more than this share of the objective ...
const LARGE: f64 = 0.8;
/// ... and has changed by less than this fraction of it in a level, drowns the others.
const STILL: f64 = 0.01;

/// The weights of terms with these names and values J.
pub fn weights(terms: &[(&str, Weight)], values: &[f64]) -> Result<Vec<f64>> {
    let (mut given, mut shares) = (0.0, 0.0);
    for ((name, weight), value) in terms.iter().zip(values) {
        match weight {
            Weight::Factor(0.0) => {}
            Weight::Factor(factor) => given += (factor * value).abs(),
            Weight::Share(share) => {
                ensure!(
                    *value != 0.0 && value.is_finite(),
                    "objective \"{name}\": share = {share}: the term is {value} at the start, so \
                     that no weight gives it a share; write weight = ... in place of share"
                );
                shares += share.abs();
            }
        }
    }
    let total = if given > 0.0 { given / (1.0 - shares) } else { 1.0 };
    let one = |((_, weight), value): (&(&str, Weight), &f64)| match weight {
        Weight::Factor(factor) => *factor,
        Weight::Share(share) => share * total / value.abs(),
    };
    Ok(terms.iter().zip(values).map(one).collect())
}

/// The share of each weighted term, the largest first.
pub fn shares(terms: &BTreeMap<String, f64>) -> Vec<(&str, f64)> {
    let total: f64 = terms.values().map(|value| value.abs()).sum();
    let mut shares: Vec<(&str, f64)> =
        terms.iter().map(|(name, value)| (name.as_str(), value.abs() / total)).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    shares
}

/// The shares in words, where there is more than one term.
pub fn describe(terms: &BTreeMap<String, f64>) -> Option<String> {
    let one = |(name, share): (&str, f64)| format!("{name} {:.1} %", 100.0 * share);
    let all: Vec<String> = shares(terms).into_iter().map(one).collect();
    (all.len() > 1).then(|| all.join(", "))
}

/// What to say of a term that was nearly all of the objective in a level and hardly changed.
pub fn drowns(before: &BTreeMap<String, f64>, after: &BTreeMap<String, f64>) -> Option<String> {
    let &(name, share) = shares(before).first()?;
    let change = (after.get(name)? - before[name]) / before[name].abs();
    (before.len() > 1 && share > LARGE && change.abs() < STILL).then(|| {
        format!(
            "\"{name}\" is {:.0} % of the objective and changed by {:.2} % in this level, so that \
             the other terms count for little: lower its weight, or give it a share",
            100.0 * share,
            100.0 * change
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn weights_give_the_shares_that_were_wanted() {
        use Weight::{Factor, Share};
        let terms = [("a", Factor(2.0)), ("b", Share(0.5)), ("c", Share(-0.1)), ("d", Factor(0.0))];
        let values = [3.0, 1e-9, -7.0, f64::INFINITY];
        let weights = weights(&terms, &values).unwrap();
        let weighted: Vec<f64> = weights[..3].iter().zip(values).map(|(w, j)| w * j).collect();
        // 6 is what the other 0.4 of the objective is
        let expected = [6.0, 7.5, 1.5];
        for (found, wanted) in weighted.iter().zip(expected) {
            assert!((found - wanted).abs() < 1e-12, "{weighted:?}");
        }
        assert!(weights[2] < 0.0 && weights[3] == 0.0);
    }

    #[test]
    fn without_given_weights_the_objective_begins_at_one() {
        let terms = [("a", Weight::Share(0.75)), ("b", Weight::Share(0.25))];
        let weights = weights(&terms, &[4.0, -0.5]).unwrap();
        assert_eq!(weights, [0.75 / 4.0, 0.5]);
    }

    #[test]
    fn a_large_term_that_stays_is_named() {
        let terms = |tip: f64, smooth: f64| {
            BTreeMap::from([("tip".to_owned(), tip), ("smooth".to_owned(), smooth)])
        };
        let before = terms(1.0, 9.0);
        assert_eq!(describe(&before).unwrap(), "smooth 90.0 %, tip 10.0 %");
        assert!(drowns(&before, &terms(0.5, 8.99)).unwrap().contains("\"smooth\" is 90 %"));
        assert_eq!(drowns(&before, &terms(0.5, 8.0)), None);
        assert_eq!(drowns(&terms(3.0, 7.0), &terms(0.5, 7.0)), None);
    }
}
