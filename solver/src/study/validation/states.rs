//! States between those of a run: where a condition is met, and the value there.

/// Two values of a condition are the same when they differ by less than this part of the larger.
const SAME: f64 = 1e-6;
/// Points that a polynomial goes through, at most.
const NEAREST: usize = 4;

/// A place on a run at which a condition is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// How far along the run: the number of a state, with a fraction between two.
    pub place: f64,
    /// The value there.
    pub value: f64,
}

/// The places on a run of states (condition, value) where the condition is `wanted`: one for each stretch on which it
/// grows or falls and passes that.
pub fn passages(path: &[(f64, f64)], wanted: f64) -> Vec<Met> {
    let numbered = path.iter().enumerate().map(|(i, &(x, value))| (x, i as f64, value));
    let mut path: Vec<(f64, f64, f64)> = numbered.collect();
    path.dedup_by(|a, b| same(a.0, b.0));
    if let [(x, place, value)] = path[..] {
        return if same(x, wanted) { vec![Met { place, value }] } else { Vec::new() };
    }
    let mut found: Vec<Met> = Vec::new();
    let mut start = 0;
    for end in 1..path.len() {
        let turns = |i: usize| (path[i].0 - path[i - 1].0) * (path[i + 1].0 - path[i].0) < 0.0;
        if end + 1 < path.len() && !turns(end) {
            continue;
        }
        let mut stretch = path[start..=end].to_vec();
        stretch.sort_by(|a, b| a.0.total_cmp(&b.0));
        let values: Vec<(f64, f64)> = stretch.iter().map(|s| (s.0, s.2)).collect();
        if let Some(value) = polynomial(&values, wanted) {
            let met = Met { place: place(&stretch, wanted), value };
            // the state at which two stretches meet is one
            if found.last().is_none_or(|last| last.value.to_bits() != value.to_bits()) {
                found.push(met);
            }
        }
        start = end;
    }
    found
}

/// The first maximum of values along a run, and the first minimum after it: of the parabola through the state and its
/// two neighbours.
pub fn turns(values: impl Iterator<Item = f64>) -> [Option<Met>; 2] {
    let values: Vec<f64> = values.collect();
    let extreme = |sign: f64, from: usize| {
        let inner = from.max(1)..values.len().saturating_sub(1);
        let at = inner.into_iter().find(|&i| {
            sign * (values[i] - values[i - 1]) > 0.0 && sign * (values[i] - values[i + 1]) >= 0.0
        })?;
        let [a, b, c] = [values[at - 1], values[at], values[at + 1]];
        let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
        Some((at, Met { place: at as f64 + offset, value: b - 0.25 * (a - c) * offset }))
    };
    let peak = extreme(1.0, 0);
    let valley = peak.and_then(|(at, _)| extreme(-1.0, at));
    [peak, valley].map(|found| found.map(|(_, met)| met))
}

/// Where along a run the condition is `wanted`, between states (condition, place, value) in order of the condition.
fn place(stretch: &[(f64, f64, f64)], wanted: f64) -> f64 {
    let after = stretch.iter().position(|s| s.0 >= wanted).unwrap_or(stretch.len() - 1);
    let (a, b) = (stretch[after.saturating_sub(1)], stretch[after]);
    let part = if a.0 < b.0 { ((wanted - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) } else { 1.0 };
    a.1 + part * (b.1 - a.1)
}

/// The value at `wanted` between states, given by their conditions and values. States with the
/// same first condition are a curve over the others; the curves are interpolated one by one, and
/// then their values over the first condition.
pub fn interpolate(states: &[(Vec<f64>, f64)], wanted: &[f64]) -> Option<f64> {
    let Some((first, others)) = wanted.split_first() else {
        return states.first().map(|s| s.1);
    };
    let mut sorted: Vec<(f64, Vec<f64>, f64)> =
        states.iter().map(|(c, value)| (c[0], c[1..].to_vec(), *value)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let curves = sorted.chunk_by(|a, b| same(a.0, b.0));
    let curve = |curve: &[(f64, Vec<f64>, f64)]| {
        let states: Vec<_> = curve.iter().map(|s| (s.1.clone(), s.2)).collect();
        Some((curve[0].0, interpolate(&states, others)?))
    };
    polynomial(&curves.filter_map(curve).collect::<Vec<_>>(), *first)
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

    /// z = x³ + x y², on a grid.
    fn cubic() -> Vec<(Vec<f64>, f64)> {
        let grid = (0..5).flat_map(|i| (0..4).map(move |j| (f64::from(i), f64::from(j))));
        grid.map(|(x, y)| (vec![x, y], x * x * x + x * y * y)).collect()
    }

    #[test]
    fn cubics_of_two_conditions_are_exact() {
        for (x, y) in [(0.5, 0.25), (2.0, 1.7), (3.9, 3.0), (4.0, 0.0)] {
            let found = interpolate(&cubic(), &[x, y]).expect("inside");
            assert!((found - (x * x * x + x * y * y)).abs() < 1e-12, "{found}");
        }
    }

    /// Up to 3, back to 1, and up again to 4.
    #[test]
    fn a_path_that_turns_passes_a_value_several_times() {
        let path = [(0.0, 0.0), (2.0, 1.0), (3.0, 2.0), (1.0, 3.0), (4.0, 4.0)];
        let met = |place, value| Met { place, value };
        assert_eq!(passages(&path[..3], 2.0), [met(1.0, 1.0)]);
        assert_eq!(passages(&path, 3.5).len(), 1);
        let thrice = passages(&path, 2.0);
        assert_eq!((thrice.len(), thrice[0], thrice[1]), (3, met(1.0, 1.0), met(2.5, 2.5)));
        assert!((thrice[2].place - 10.0 / 3.0).abs() < 1e-12, "{thrice:?}");
        // where it turns, one state is met once
        assert_eq!(passages(&path[..4], 3.0), [met(2.0, 2.0)]);
        assert!(passages(&path, 5.0).is_empty());
        assert_eq!(passages(&[(1.0, 7.0)], 1.0), [met(0.0, 7.0)]);
    }

    /// A cubic with a maximum of 2 at state 4 and a minimum of -2 at state 8, and one that only rises.
    #[test]
    fn a_run_has_a_peak_and_a_valley() {
        let cubic = |i: i32| (f64::from(i) / 2.0 - 3.0).powi(3) - 3.0 * (f64::from(i) / 2.0 - 3.0);
        let [peak, valley] = turns((0..12).map(cubic));
        let near = |met: Option<Met>, place: f64, value: f64| {
            let met = met.expect("there is one");
            (met.place - place).abs() < 0.1 && (met.value - value).abs() < 0.02
        };
        assert!(near(peak, 4.0, 2.0) && near(valley, 8.0, -2.0), "{peak:?} {valley:?}");
        assert_eq!(turns((0..5).map(f64::from)), [None, None]);
        assert_eq!(turns([0.0, 1.0, 0.5].into_iter())[1], None);
    }

    #[test]
    fn nothing_is_extrapolated() {
        assert_eq!(interpolate(&cubic(), &[4.1, 1.0]), None);
        assert_eq!(interpolate(&cubic(), &[2.0, -0.1]), None);
        // two states: a line between them
        let line = [(vec![1.0], 10.0), (vec![3.0], 20.0)];
        assert_eq!(interpolate(&line, &[2.0]), Some(15.0));
        assert_eq!(interpolate(&line[..1], &[2.0]), None);
    }
}
