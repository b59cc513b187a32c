//! States between those of a run: where a condition is met, and the value there.

/// Two values of a condition are the same when they differ by less than this part of the larger.
const SAME: f64 = 1e-6;
/// Points that a polynomial goes through, at most.
const NEAREST: usize = 4;

/// The values at the places on a run of states (condition, value) where the condition is `wanted`: one for each stretch
/// on which it grows or falls and passes that.
pub fn passages(path: &[(f64, f64)], wanted: f64) -> Vec<f64> {
    let mut path = path.to_vec();
    path.dedup_by(|a, b| same(a.0, b.0));
    if let [(x, value)] = path[..] {
        return if same(x, wanted) { vec![value] } else { Vec::new() };
    }
    let mut found: Vec<f64> = Vec::new();
    let mut start = 0;
    for end in 1..path.len() {
        let turns = |i: usize| (path[i].0 - path[i - 1].0) * (path[i + 1].0 - path[i].0) < 0.0;
        if end + 1 < path.len() && !turns(end) {
            continue;
        }
        let mut stretch = path[start..=end].to_vec();
        stretch.sort_by(|a, b| a.0.total_cmp(&b.0));
        // the state at which two stretches meet is one
        let known =
            |value: &f64| found.last().is_some_and(|last| last.to_bits() == value.to_bits());
        found.extend(polynomial(&stretch, wanted).filter(|value| !known(value)));
        start = end;
    }
    found
}

/// The first maximum of values along a run, and the first minimum after it: of the parabola through the state and its
/// two neighbours.
pub fn turns(values: &[f64]) -> [Option<f64>; 2] {
    let extreme = |sign: f64, from: usize| {
        let inner = from.max(1)..values.len().saturating_sub(1);
        let at = inner.into_iter().find(|&i| {
            sign * (values[i] - values[i - 1]) > 0.0 && sign * (values[i] - values[i + 1]) >= 0.0
        })?;
        let [a, b, c] = [values[at - 1], values[at], values[at + 1]];
        let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
        Some((at, b - 0.25 * (a - c) * offset))
    };
    let peak = extreme(1.0, 0);
    let valley = peak.and_then(|(at, _)| extreme(-1.0, at));
    [peak, valley].map(|found| found.map(|(_, value)| value))
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// Lagrange's polynomial through the points (x, y) that are nearest to `x`, in order of x; none
/// outside of them.
fn polynomial(points: &[(f64, f64)], x: f64) -> Option<f64> {
    if let Some(hit) = points.iter().find(|p| same(p.0, x)) {
        return Some(hit.1);
    }
    let after = points.iter().position(|p| p.0 > x).filter(|&i| i > 0)?;
    let start = after.saturating_sub(NEAREST / 2).min(points.len().saturating_sub(NEAREST));
    let near = &points[start..points.len().min(start + NEAREST)];
    let weight = |i: usize| -> f64 {
        let others = near.iter().enumerate().filter(|&(j, _)| j != i);
        others.map(|(_, p)| (x - p.0) / (near[i].0 - p.0)).product()
    };
    Some(near.iter().enumerate().map(|(i, p)| weight(i) * p.1).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_exact_and_nothing_is_extrapolated() {
        let cubic: Vec<_> = (0..5).map(f64::from).map(|x| (x, x.powi(3) - x)).collect();
        for x in [0.5, 2.0, 3.9, 4.0] {
            let [found] = passages(&cubic, x)[..] else { panic!("{x}") };
            assert!((found - (x.powi(3) - x)).abs() < 1e-12, "{found}");
        }
        assert!(passages(&cubic, 4.1).is_empty() && passages(&cubic, -0.1).is_empty());
        assert_eq!(passages(&[(1.0, 10.0), (3.0, 20.0)], 2.0), [15.0]);
        assert_eq!(passages(&[(1.0, 7.0)], 1.0), [7.0]);
        assert!(passages(&[(1.0, 7.0)], 2.0).is_empty());
    }

    /// Up to 3, back to 1, and up again to 4.
    #[test]
    fn a_path_that_turns_passes_a_value_several_times() {
        let path = [(0.0, 0.0), (2.0, 1.0), (3.0, 2.0), (1.0, 3.0), (4.0, 4.0)];
        assert_eq!([passages(&path, 3.5).len(), passages(&path, 2.0).len()], [1, 3]);
        // where it turns, one state is met once
        assert_eq!(passages(&path[..4], 3.0), [2.0]);
    }

    /// A cubic with a maximum of 2 and then a minimum of −2, and one that only rises.
    #[test]
    fn a_run_has_a_peak_and_a_valley() {
        let cubic = |i: i32| (f64::from(i) / 2.0 - 3.0).powi(3) - 3.0 * (f64::from(i) / 2.0 - 3.0);
        let [Some(peak), Some(valley)] = turns(&(0..12).map(cubic).collect::<Vec<_>>()) else {
            panic!("it turns twice")
        };
        assert!((peak - 2.0).abs() < 0.02 && (valley + 2.0).abs() < 0.02, "{peak} {valley}");
        assert_eq!(turns(&[0.0, 1.0, 2.0]), [None, None]);
        assert_eq!(turns(&[0.0, 1.0, 0.5])[1], None);
    }
}
