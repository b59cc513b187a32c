//! From design variables to loads and other numbers: pressures over time by their slopes, numbers
//! that expressions of the scene have in common, and numbers by their paths.
//!
//! Variables of the curves come first, one curve after the other, then one for each
//! number; all are metres. A number within bounds, such as a peak pressure or a phase, is
//!
//! p = p⁰ + r y
//!
//! p⁰   the scene's value
//! y    design variable [m]
//! r    a tenth of the width of the bounds per mean edge, so that one variable changes
//!      its number as much as others change a shape
//!
//! A term (p/s)² of the objective may keep it small, with s the value at which the term is 1.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::energy::{ChamberId, GasLaw, Isobaric};
use mechanics::forward::Problem;
use mechanics::schedule::Schedule;
use program::{KeyPath, misfit};
use scene::Scene;
use scene::config::{ChamberDesign, DesignConfig, ParameterDesign};
use scene::term::chamber::{ChamberConfig, GasConfig};

use super::pressure_curve::PressureCurve;
use scene::number::{Number, Swept};

/// Change of a number for a variable of one mean edge, over the width of its bounds.
const SHARE: f64 = 0.1;

/// What a design does to the loads.
pub struct LoadMap {
    /// t_0 = 0, t_1, …, t_N [s].
    times: Vec<f64>,
    variables: Vec<LoadVariable>,
    curves: Vec<Curve>,
    numbers: Vec<Designed>,
    /// Chambers in whose schedules such numbers occur, with the gas of the scene.
    named: Vec<(ChamberId, GasConfig)>,
    /// All parameters of the scene.
    parameters: BTreeMap<String, f64>,
}

/// A pressure that the design sets.
struct Curve {
    /// Name of the chamber.
    on: String,
    chamber: ChamberId,
    curve: PressureCurve,
    /// Smallest and largest pressure [Pa].
    within: Option<[f64; 2]>,
}

/// A number that the design sets.
struct Designed {
    /// The name in `[parameters]`, or its path.
    name: String,
    /// What has the path.
    number: Option<Number>,
    /// p⁰.
    start: f64,
    /// s, where a term keeps it small.
    cost: Option<f64>,
}

/// A design variable of the loads in the words and the unit of the scene.
pub struct LoadVariable {
    /// Path of what it changes: a number, a name in `[parameters]`, or the slope of a pressure in a time step.
    pub path: String,
    /// SI unit; of names in `[parameters]`, which have none, `1`.
    pub unit: &'static str,
    /// Change of that by a metre of the variable, r.
    pub per_metre: f64,
    /// Smallest and largest value of the variable [m].
    bounds: [f64; 2],
    /// Largest change of the variable in one iteration [m].
    change: f64,
}

impl LoadVariable {
    /// A variable by which what has a path and a unit, and a `value` at zero, changes by `per_metre`, within bounds and by at
    /// most so much in one iteration.
    fn new(
        (path, unit): (String, &'static str),
        (value, per_metre): (f64, f64),
        bounds: [f64; 2],
        change: Option<f64>,
    ) -> Self {
        let bounds = bounds.map(|b| (b - value) / per_metre);
        let change = change.map_or(f64::INFINITY, |change| change / per_metre);
        Self { path, unit, per_metre, bounds, change }
    }
}

impl LoadMap {
    /// The map to the chambers of a scene, with a body whose moving surface has edges of about
    /// `edge` [m].
    pub fn new(scene: &Scene, design: &DesignConfig, edge: f64) -> Result<Self> {
        let times: Vec<f64> = [0.0].into_iter().chain(scene.times()).collect();
        let mut map = Self {
            times,
            variables: Vec::new(),
            curves: Vec::new(),
            numbers: Vec::new(),
            named: Vec::new(),
            parameters: scene.config.parameters.clone(),
        };
        for pressure in &design.chamber {
            map.add_curve(pressure, scene, edge)?;
        }
        for number in &design.parameter {
            match number.name.contains('.') {
                true => map.add_path(number, scene, edge)?,
                false => map.add_parameter(number, scene, edge)?,
            }
        }
        for (i, chamber) in scene.config.chamber.iter().enumerate() {
            let (id, written) = (ChamberId::of(i), &chamber.gas.value);
            if !map.numbers.iter().any(|n| written.uses(&n.name)) {
                continue;
            }
            ensure!(
                map.curves.iter().all(|c| c.chamber != id),
                misfit!(chamber.title(), ": a [[parameter]] changes it, too; keep one of them")
            );
            map.named.push((id, chamber.gas.clone()));
        }
        Ok(map)
    }

    fn add_curve(&mut self, design: &ChamberDesign, scene: &Scene, edge: f64) -> Result<()> {
        let on = design.on.clone();
        let title = KeyPath::list("chamber").on(&on);
        let mut chambers = scene.config.chamber.iter().enumerate();
        let Some((i, ChamberConfig { gas, .. })) = chambers.find(|(_, found)| found.name == on)
        else {
            bail!(misfit!(title, ": the scene has no [[chamber]] there"));
        };
        let id = ChamberId::of(i);
        let Some(pressure) = gas.pressure() else {
            bail!(misfit!(
                title,
                ": the scene's [[chamber]] there has {}; expected pressure",
                gas.key()
            ));
        };
        let pressure = scene.config.schedule(pressure);
        ensure!(self.curves.iter().all(|c| c.chamber != id), misfit!(title, " is given twice"));
        let times = &self.times;
        let values: Vec<f64> = times.iter().map(|&t| pressure.at(t)).collect();
        let [low, high] = design.slope;
        let reach = low.abs().max(high.abs()) * times[times.len() - 1];
        let scale = values.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        let scale = if scale > 0.0 { scale } else { reach };
        let curve = PressureCurve::new(times, &values, scale, edge);
        let variable = |(step, &slope): (usize, &f64)| {
            let path = format!("chamber.{on}.pressure.slope.{}", step + 1);
            let value = (slope, curve.unit);
            LoadVariable::new((path, "Pa/s"), value, design.slope, design.change)
        };
        let variables: Vec<LoadVariable> = curve.slopes.iter().enumerate().map(variable).collect();
        for (n, LoadVariable { bounds: [low, high], .. }) in variables.iter().enumerate() {
            ensure!(
                *low <= 1e-9 * (high - low) && *high >= -1e-9 * (high - low),
                misfit!(
                    title,
                    ": in time step {} the scene's pressure has a slope of {:.4e} Pa/s, which slope = {:?} \
                     Pa/s does not allow",
                    n + 1,
                    (values[n + 1] - values[n]) / (times[n + 1] - times[n]),
                    design.slope
                )
            );
        }
        if let Some([low, high]) = design.bounds {
            let outside = times.iter().zip(&values).skip(1).find(|(_, p)| **p < low || **p > high);
            ensure!(
                outside.is_none(),
                misfit!(
                    title,
                    ": at t = {} s the scene's pressure is {:.4e} Pa, which bounds = [{low}, {high}] Pa do not allow",
                    outside.map_or(0.0, |(t, _)| *t),
                    outside.map_or(0.0, |(_, p)| *p)
                )
            );
        }
        self.variables.extend(variables);
        self.curves.push(Curve { on, chamber: id, curve, within: design.bounds });
        Ok(())
    }

    /// Adds a number of the scene by its path.
    fn add_path(&mut self, design: &ParameterDesign, scene: &Scene, edge: f64) -> Result<()> {
        let name = &design.name;
        let title = KeyPath::list("parameter").named(name);
        let number = Number::find(scene, name).context(KeyPath::list("parameter"))?;
        ensure!(
            !["wall", "velocity"].contains(&number.word()),
            misfit!(title, ": a design cannot change it; walls move by [[shape]]")
        );
        ensure!(
            !self.curves.iter().any(|curve| number.is_of_chamber(&curve.on, scene)),
            misfit!(title, ": a [[chamber]] of the design changes it, too; keep one of them")
        );
        let start = number.value(scene);
        self.add(design, Some(number), start, edge)
    }

    /// Adds a number within its bounds, which is `start` in the scene.
    fn add(
        &mut self,
        design: &ParameterDesign,
        number: Option<Number>,
        start: f64,
        edge: f64,
    ) -> Result<()> {
        let ParameterDesign { name, bounds, change, .. } = design;
        let title = KeyPath::list("parameter").named(name);
        ensure!(
            bounds[0] <= start && start <= bounds[1],
            misfit!(title, ": the scene's value {start} is not within bounds = {bounds:?}")
        );
        ensure!(self.numbers.iter().all(|n| n.name != *name), misfit!(title, " is given twice"));
        let unit = number.as_ref().map_or("1", |number| number.unit);
        let per_metre = SHARE * (bounds[1] - bounds[0]) / edge;
        let named = (name.clone(), unit);
        self.variables.push(LoadVariable::new(named, (start, per_metre), *bounds, *change));
        let cost = design.unit_cost();
        self.numbers.push(Designed { name: name.clone(), number, start, cost });
        Ok(())
    }

    /// Adds a number of `[parameters]`.
    fn add_parameter(&mut self, design: &ParameterDesign, scene: &Scene, edge: f64) -> Result<()> {
        let name = &design.name;
        let title = KeyPath::list("parameter").named(name);
        let Some(&start) = self.parameters.get(name) else {
            bail!(misfit!(
                title,
                ": {} has none of this name in [parameters]",
                scene.path.display()
            ));
        };
        let config = &scene.config;
        let uses = config.schedules().into_iter().filter(|(_, _, written)| written.uses(name));
        let in_chamber =
            |written| config.chamber.iter().any(|c| std::ptr::eq(&c.gas.value, written));
        let (inside, outside): (Vec<_>, Vec<_>) =
            uses.partition(|(_, _, written)| in_chamber(*written));
        if let Some((what, ..)) = outside.first() {
            bail!(misfit!(
                title,
                " occurs in {what}, by which there is no gradient; it may occur in [[chamber]]"
            ));
        }
        ensure!(!inside.is_empty(), misfit!(title, " occurs in no [[chamber]]"));
        self.add(design, None, start, edge)
    }

    /// Each design variable, in the order of θ.
    pub fn variables(&self) -> &[LoadVariable] {
        &self.variables
    }

    fn curve_variables(&self) -> usize {
        self.curves.iter().map(|c| c.curve.slopes.len()).sum()
    }

    /// Each curve with its variables.
    fn each_curve<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a Curve, &'a [f64])> + 'a {
        let mut rest = theta;
        self.curves.iter().map(move |curve| {
            let (own, others) = rest.split_at(curve.curve.slopes.len());
            rest = others;
            (curve, own)
        })
    }

    /// Each number with its value.
    fn each_number<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a Designed, f64)> + 'a {
        let first = self.curve_variables();
        let variables = self.variables[first..].iter().zip(&theta[first..]);
        let one = |(own, (variable, y)): (&'a Designed, (&LoadVariable, &f64))| {
            (own, own.start + variable.per_metre * y)
        };
        self.numbers.iter().zip(variables).map(one)
    }

    /// The terms that keep numbers small: name, index of the variable, and (p/s)² with both derivatives by that.
    pub fn costs<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a str, usize, [f64; 3])> + 'a {
        let first = self.curve_variables();
        let numbers = self.numbers.iter().zip(first..);
        numbers.filter_map(move |(Designed { name, start, cost, .. }, variable)| {
            let unit = (*cost)?;
            let per_metre = self.variables[variable].per_metre / unit;
            let part = start / unit + per_metre * theta[variable];
            let cost = [part.powi(2), 2.0 * part * per_metre, 2.0 * per_metre.powi(2)];
            Some((name.as_str(), variable, cost))
        })
    }

    /// Tag and pressures P_0, …, P_N of each curve [Pa].
    pub fn pressures(&self, theta: &[f64]) -> Vec<(String, Vec<f64>)> {
        self.each_curve(theta).map(|(c, own)| (c.on.clone(), c.curve.values(own))).collect()
    }

    /// Designed numbers by name.
    pub fn numbers(&self, theta: &[f64]) -> BTreeMap<String, f64> {
        self.each_number(theta).map(|(n, value)| (n.name.clone(), value)).collect()
    }

    /// The gas laws with the numbers of θ in their schedules.
    fn bound(&self, theta: &[f64]) -> Vec<(ChamberId, Box<dyn GasLaw>)> {
        let mut parameters = self.parameters.clone();
        parameters.extend(self.numbers(theta));
        let bind = |(id, gas): &(ChamberId, GasConfig)| {
            let schedule = gas.value.schedule(&parameters, self.times[1]);
            (*id, gas.law(schedule.expect("the scene's own names")))
        };
        self.named.iter().map(bind).collect()
    }

    /// The problem of a scene and a body with the loads and numbers of θ.
    pub fn problem(&self, base: &Problem, on: (&Scene, &Body), theta: &[f64]) -> Result<Problem> {
        let mut problem = base.clone();
        let paths = self.each_number(theta);
        let paths: Vec<(&Number, f64)> =
            paths.filter_map(|(own, value)| Some((own.number.as_ref()?, value))).collect();
        if !paths.is_empty() {
            let (scene, body) = on;
            let mut scene = scene.clone();
            for (number, value) in &paths {
                number.set(&mut scene, None, *value)?;
            }
            paths.iter().try_for_each(|(number, _)| number.check(&scene))?;
            problem.energies = scene.energies_like(body, base)?;
        }
        for (Curve { curve, chamber, .. }, own) in self.each_curve(theta) {
            let pressure = Schedule::table(&self.times, &curve.values(own))
                .expect("times of the scene, and finite values");
            problem.energies.set_gas_law(*chamber, Box::new(Isobaric { pressure }));
        }
        for (id, gas) in self.bound(theta) {
            problem.energies.set_gas_law(id, gas);
        }
        Ok(problem)
    }

    /// dJ/dθ from dJ/dp.
    pub fn vjp(&self, theta: &[f64], swept: &Swept) -> Vec<f64> {
        let by_parameters = swept.parameters();
        let mut gradient = Vec::with_capacity(self.variables.len());
        let steps = 0..by_parameters.steps();
        for Curve { curve, chamber, .. } in &self.curves {
            let by = |step: usize| by_parameters.sum(step, chamber.owner());
            gradient.extend(curve.vjp(&steps.clone().map(by).collect::<Vec<_>>()));
        }
        let bound = self.bound(theta);
        for Designed { name, number, .. } in &self.numbers {
            let per_metre = self.variables[gradient.len()].per_metre;
            if let Some(number) = number {
                gradient.push(per_metre * number.derivative(swept));
                continue;
            }
            let in_step = |(step, &t): (usize, &f64)| -> f64 {
                let by = |(id, gas): &(ChamberId, Box<dyn GasLaw>)| {
                    by_parameters.sum(step, id.owner()) * gas.schedule().by_parameter(name, t)
                };
                bound.iter().map(by).sum()
            };
            let bar: f64 = steps.clone().zip(&self.times[1..]).map(in_step).sum();
            gradient.push(per_metre * bar);
        }
        gradient
    }

    /// What pressures with bounds are away from these [Pa], each with its derivatives by the variables.
    pub fn pressures_within(&self, theta: &[f64]) -> Vec<(f64, Vec<(usize, f64)>)> {
        let (mut all, mut first) = (Vec::new(), 0);
        for (curve, own) in self.each_curve(theta) {
            let rows = curve.within.map(|within| curve.curve.within(own, within));
            for (left, mut by) in rows.into_iter().flatten() {
                by.iter_mut().for_each(|(i, _)| *i += first);
                all.push((left, by));
            }
            first += own.len();
        }
        all
    }

    /// Smallest and largest value of each variable in an iteration from θ.
    pub fn bounds(&self, theta: &[f64]) -> Vec<[f64; 2]> {
        let one = |(LoadVariable { bounds: [low, high], change, .. }, y): (&LoadVariable, &f64)| {
            [low.max(y - change), high.min(y + change)]
        };
        self.variables.iter().zip(theta).map(one).collect()
    }
}
