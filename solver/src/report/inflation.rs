//! Inflations of chambers, of which the first differs from the others where bodies soften after a first stretch.

use std::ops::RangeInclusive;

use reports::{Chamber, Inflated, Inflation, Step};
use scene::Scene;

/// Fall or rise of a pressure, as a part of the largest, below which it does not count as one.
const NOTABLE: f64 = 0.01;

/// The inflations of all chambers; none of a scene without softening.
pub fn inflations(scene: &Scene, lines: &[Step]) -> Option<Vec<Inflation>> {
    let names = lines.first().into_iter().flat_map(|line| line.chambers.keys());
    let of_chamber = |name: &String| {
        let states: Vec<Inflated> = lines.iter().map(|line| inflated(line, name)).collect();
        let pressures: Vec<f64> = states.iter().map(|state| state.pressure).collect();
        let inflation = |(i, rise): (usize, RangeInclusive<usize>)| Inflation {
            chamber: name.clone(),
            number: i + 1,
            peak: states[*rise.end()].clone(),
            halfway: halfway(&states[rise]),
        };
        rises(&pressures).into_iter().enumerate().map(inflation).collect::<Vec<_>>()
    };
    (!scene.config.mullins.is_empty()).then(|| names.flat_map(of_chamber).collect())
}

/// The state of a chamber at the end of a step.
fn inflated(line: &Step, chamber: &str) -> Inflated {
    let Chamber { pressure, volume, .. } = line.chambers[chamber];
    Inflated { t: line.t, pressure, volume, probes: line.probes.clone() }
}

/// Where states that rise to a last one first have half of its pressure, along a line between two of them.
fn halfway(rise: &[Inflated]) -> Option<Inflated> {
    let half = 0.5 * rise.last()?.pressure;
    let [from, to] = rise.windows(2).find_map(|pair| match pair {
        [from, to] if from.pressure < half && to.pressure >= half => Some([from, to]),
        _ => None,
    })?;
    let part = (half - from.pressure) / (to.pressure - from.pressure);
    let between = |from: f64, to: f64| from + part * (to - from);
    let probe = |(name, from): (&String, &Option<f64>)| {
        let to = to.probes.as_ref().and_then(|probes| *probes.get(name)?);
        (name.clone(), from.zip(to).map(|(from, to)| between(from, to)))
    };
    Some(Inflated {
        t: between(from.t, to.t),
        pressure: half,
        volume: between(from.volume, to.volume),
        probes: from.probes.as_ref().map(|probes| probes.iter().map(probe).collect()),
    })
}

/// Places from each smallest value to the largest before the next, after 0; of equal ones the first.
fn rises(values: &[f64]) -> Vec<RangeInclusive<usize>> {
    let notable = NOTABLE * values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let (mut rises, mut top) = (Vec::new(), None);
    let (mut bottom, mut lowest) = (0, 0.0_f64);
    for (place, &value) in values.iter().enumerate() {
        match top {
            Some(at) if value > values[at] => top = Some(place),
            Some(at) if value < values[at] - notable => {
                rises.push(bottom..=at);
                (top, bottom, lowest) = (None, place, value);
            }
            None if value > lowest + notable => top = Some(place),
            None if value <= lowest => (bottom, lowest) = (place, value),
            _ => {}
        }
    }
    rises.into_iter().chain(top.map(|at| bottom..=at)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_are_counted_once_and_noise_is_none() {
        for (values, expected) in [
            (&[][..], vec![]),
            (&[0.0, 0.0], vec![]),
            (&[1.0, 2.0, 3.0], vec![0..=2]),
            (&[1.0, 3.0, 3.0, 0.0, 2.0, 1.0, 5.0], vec![0..=1, 3..=4, 5..=6]),
            // within 1 % of the largest
            (&[10.0, 9.95, 9.98, 0.0, 0.05, 0.0], vec![0..=0]),
            (&[-5.0, -1.0, -4.0], vec![0..=1]),
        ] {
            assert_eq!(rises(values), expected, "{values:?}");
        }
    }

    #[test]
    fn halfway_is_on_a_line_between_two_states() {
        let state = |n: f64| Inflated {
            t: n,
            pressure: 3.0 * n,
            volume: 10.0 + n,
            probes: Some([("tip".to_owned(), Some(2.0 * n))].into()),
        };
        let found = halfway(&[state(0.0), state(1.0), state(4.0)]).expect("two states");
        assert_eq!((found.t, found.pressure, found.volume), (2.0, 6.0, 12.0));
        assert_eq!(found.probes, Some([("tip".to_owned(), Some(4.0))].into()));
        assert!(halfway(&[state(4.0)]).is_none());
    }
}
