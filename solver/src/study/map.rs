//! The quasi-static response of an actuator as a table: equilibria on a grid of numbers, with derivatives.
//!
//! Rows follow each other, the last number fastest. Each equilibrium is sought from the one before, where the way there
//! does not matter, and from rest where it is not found like that.

use std::str::FromStr;

use anyhow::{Result, ensure};
use measure::probe::Probe;
use mechanics::adjoint;
use mechanics::energy::Iterate;
use mechanics::forward::Linearizations;
use nalgebra::Matrix6;
use reports::Status;
use scene::Scene;

use super::pose::Tip;
use run::{Run, Start};
use scene::number::{Number, Swept, Walls};

/// Values of one number at most.
const MOST_VALUES: usize = 100_000;
/// Part of a step by which the last value may be off the end of a range.
const LARGEST_OVERSHOOT: f64 = 1e-9;
/// What the columns of a pose are called.
const POSE: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// The values of one number: `PATH=FROM:STEP:TO` or `PATH=VALUE,VALUE,...`.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// The path of the number.
    pub path: String,
    /// Values of the number, in its unit.
    pub values: Vec<f64>,
}

impl FromStr for Grid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected PATH=FROM:STEP:TO or PATH=VALUE,VALUE,..., as in \
                        chamber.cavity.pressure=0:5e3:20e3";
        let (path, values) = text.split_once('=').ok_or(expected)?;
        let number = |text: &str| {
            let value = text.trim().parse::<f64>().map_err(|_| format!("{text:?}: {expected}"))?;
            if value.is_finite() { Ok(value) } else { Err(format!("{value}: must be finite")) }
        };
        let range = values.split(':').collect::<Vec<_>>();
        let values = match range[..] {
            [list] => list.split(',').map(number).collect::<Result<_, _>>()?,
            [from, step, to] => steps([number(from)?, number(step)?, number(to)?])?,
            _ => return Err(expected.to_owned()),
        };
        Ok(Self { path: path.trim().to_owned(), values })
    }
}

/// `from`, `from + step`, … up to `to`.
fn steps([from, step, to]: [f64; 3]) -> Result<Vec<f64>, String> {
    let count = ((to - from) / step + LARGEST_OVERSHOOT).floor();
    if !(0.0..MOST_VALUES as f64).contains(&count) {
        return Err(format!(
            "{from}:{step}:{to} has no values, or more than {MOST_VALUES}; expected FROM:STEP:TO"
        ));
    }
    Ok((0..=count as usize).map(|n| from + n as f64 * step).collect())
}

/// What is tabulated.
pub struct Map<'a> {
    scene: &'a Scene,
    grid: &'a [Grid],
    /// Numbers by which there are derivatives: those of the grid, then others.
    by: Vec<Number>,
    tip: Option<&'a str>,
}

/// A row of the table.
pub struct Row {
    /// The values of the grid.
    pub at: Vec<f64>,
    /// Whether there is an equilibrium that may be used.
    pub status: Status,
    /// Values of all further columns; none where there is no such equilibrium.
    pub values: Option<Vec<f64>>,
    /// Displacement [m]; empty where there is no such equilibrium.
    pub u: Vec<f64>,
}

impl<'a> Map<'a> {
    /// A table for a scene without time steps.
    pub fn new(
        scene: &'a Scene,
        grid: &'a [Grid],
        by: &[String],
        tip: Option<&'a str>,
    ) -> Result<Self> {
        ensure!(
            scene.config.time.is_none(),
            "{}: [time]: a map has equilibria, not a course; expected a scene without it",
            scene.path.display()
        );
        let others = by.iter().filter(|path| grid.iter().all(|own| own.path != **path));
        let paths = grid.iter().map(|own| &own.path).chain(others);
        let by = paths.map(|path| Number::find(scene, path)).collect::<Result<Vec<_>>>()?;
        for (i, own) in grid.iter().enumerate() {
            let twice = grid[..i].iter().any(|other| other.path == own.path);
            ensure!(!twice, "--grid {}: is given twice", own.path);
        }
        if let Some(tag) = tip {
            scene.body.facets(tag)?;
        }
        Ok(Self { scene, grid, by, tip })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.grid.iter().map(|own| own.values.len()).product()
    }

    /// Names of the columns.
    pub fn columns(&self) -> Vec<String> {
        let grid = self.grid.iter().map(|own| own.path.clone()).chain(["status".to_owned()]);
        let probes = self.scene.config.probe.iter().map(|probe| probe.name().to_owned());
        let pose = self.tip.iter().flat_map(|_| POSE.map(|axis| format!("tip.{axis}")));
        let measured: Vec<String> = probes.chain(pose).collect();
        let slopes = measured.iter().flat_map(|name| {
            self.by.iter().map(move |number| format!("d {name}/d {}", number.path))
        });
        let slopes: Vec<String> = slopes.collect();
        let stiffness = upper().map(|[i, j]| format!("k.{}.{}", POSE[i], POSE[j]));
        let stiffness = stiffness.filter(|_| self.tip.is_some());
        grid.chain(measured).chain(slopes).chain(stiffness).collect()
    }

    /// The values of the grid in a row.
    pub fn at(&self, row: usize) -> Vec<f64> {
        let mut rest = row;
        let mut at = vec![0.0; self.grid.len()];
        for (value, own) in at.iter_mut().zip(self.grid).rev() {
            *value = own.values[rest % own.values.len()];
            rest /= own.values.len();
        }
        at
    }

    /// The numbers of the grid.
    fn of_grid(&self) -> impl Iterator<Item = &Number> {
        self.by[..self.grid.len()].iter()
    }

    /// Finds a row, from the displacement of the one before [m] if there is one.
    pub fn row(&self, row: usize, before: &[f64]) -> Result<Row> {
        let at = self.at(row);
        let mut scene = self.scene.clone();
        let walls = Walls::of(self.of_grid(), &scene)?;
        for (number, value) in self.of_grid().zip(&at) {
            number.replace(&mut scene, walls.as_ref(), *value)?;
        }
        self.of_grid().try_for_each(|number| number.check(&scene))?;
        let none = |status| Row { at: at.clone(), status, values: None, u: Vec::new() };
        let start = Start { near: Some(before), ..Start::default() };
        let Ok(run) = Run::new(scene, start)? else { return Ok(none(Status::NoEquilibrium)) };
        let status = run.verdict()?.status();
        if status != Status::Ok {
            return Ok(none(status));
        }
        let (values, u) = (self.values(&run)?, run.states.last().into_owned());
        Ok(Row { at, status, values: Some(values), u })
    }

    /// Values of the columns at the end of a run.
    fn values(&self, run: &Run) -> Result<Vec<f64>> {
        let (scene, problem) = (&*run.scene, &run.problem);
        let walls = Walls::of(self.by.iter(), scene)?;
        let slopes = |gradient: &adjoint::Gradient| {
            let swept = Swept::new(scene, problem, walls.as_ref(), gradient);
            self.by.iter().map(|number| number.derivative(&swept)).collect::<Vec<_>>()
        };
        let all: Vec<&Probe> = run.probes.iter().collect();
        let found = run.sensitivities(&all, 1)?;
        let mut values: Vec<f64> = found.iter().map(|(value, _)| *value).collect();
        let mut by: Vec<f64> = found.iter().flat_map(|(_, gradient)| slopes(gradient)).collect();
        let Some(tag) = self.tip else {
            values.extend(by);
            return Ok(values);
        };
        let (rest, state) = (run.rest(), run.states.state(1));
        let pose = Tip::new(&scene.body, &problem.space, tag)?.pose(&state.u)?;
        let step = run.states.step(problem, rest, 1);
        let at = problem.iterate(rest, &state.u, run.states.times[1]);
        let at = Iterate { step: Some(&step), ..at };
        let (linearization, stiffness) = pose.stiffness(problem, &mut run.workspace(), &at)?;
        let known = Linearizations::at_step(1, linearization);
        values.extend(pose.position.iter().chain(pose.rotation.iter()));
        for row in pose.by_displacement() {
            let partials = |_: &_, moment: usize, out: &mut adjoint::Partials| {
                if moment == 1 {
                    out.by_u.iter_mut().zip(&row).for_each(|(u, by)| *u += by);
                }
            };
            by.extend(slopes(&run.gradient(&known, partials)?));
        }
        values.extend(by);
        let stiffness = stiffness.unwrap_or_else(|| Matrix6::from_element(f64::NAN));
        values.extend(upper().map(|place| stiffness[(place[0], place[1])]));
        Ok(values)
    }
}

/// Places of a symmetric matrix on and above its diagonal.
fn upper() -> impl Iterator<Item = [usize; 2]> {
    (0..6).flat_map(|i| (i..6).map(move |j| [i, j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_ranges_or_lists() {
        let values = |text: &str| text.parse::<Grid>().map(|grid| grid.values);
        assert_eq!(values("a.b=0:5e3:20e3"), Ok(vec![0.0, 5e3, 1e4, 15e3, 20e3]));
        assert_eq!(values("a=0:0.1:0.3").map(|v| v.len()), Ok(4));
        assert_eq!(values("a=3,1,-2"), Ok(vec![3.0, 1.0, -2.0]));
        assert_eq!(values("a=2:-1:0"), Ok(vec![2.0, 1.0, 0.0]));
        for wrong in ["a", "a=1:2", "a=0:0:1", "a=0:-1:1", "a=x", "a=nan", "a=0:1e-9:1"] {
            assert!(values(wrong).is_err(), "{wrong}");
        }
    }
}
