//! What an objective of a design problem depends on, one by one, for Taylor tests of
//! the user's own scene.

use anyhow::Result;
use mechanics::adjoint::Gradient;
use mechanics::math::linear::sum;
use scene::config::{LevelConfig, VerticesConfig};
use scene::{ObjectiveBuilder, Scene};
use serde::Serialize;

use super::{Evaluation, Level, Problem, Scenario};
use scene::number::{KINDS, Number, Swept};

/// A group of numbers.
#[derive(Clone)]
pub enum Parameter {
    /// Design variables of the shape [m].
    Shape,
    /// Design variables of the loads [m].
    Loads,
    /// Numbers of the scene that belong together, each relative to itself or to what is large of
    /// its kind.
    Numbers(Vec<Number>),
}

impl Parameter {
    /// All that the runs of a level depend on. Walls move with the shape, and pressures that are
    /// designed are among the loads.
    pub fn of(Problem { scene, design, .. }: &Problem, level: &Level) -> Vec<Self> {
        let mut all = Vec::new();
        let shape = level.map.shape_variables();
        all.extend((shape > 0).then_some(Self::Shape));
        all.extend((level.variables() > shape).then_some(Self::Loads));
        let designed = |number: &Number| {
            design.chamber.iter().any(|chamber| number.is_of_chamber(&chamber.on, scene))
        };
        let counts = |number: &Number| match number.word() {
            "density" => scene.weighs(number.owner()),
            "chamber" => !designed(number),
            word => word != "wall",
        };
        for kind in KINDS.iter() {
            let numbers: Vec<Number> = kind.numbers(scene).into_iter().filter(counts).collect();
            let owners =
                numbers.chunk_by(|a, b| a.owner() == b.owner() && a.vector() == b.vector());
            all.extend(owners.map(|own| Self::Numbers(own.to_vec())));
        }
        all
    }

    /// The name in reports.
    pub fn name(&self) -> String {
        match self {
            Self::Shape => "shape".to_owned(),
            Self::Loads => "loads".to_owned(),
            Self::Numbers(numbers) => {
                let words = |number: &Number| -> Vec<String> {
                    number.path.split('.').map(str::to_owned).collect()
                };
                let shared = numbers.iter().map(words).reduce(|a, b| {
                    a.into_iter().zip(b).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
                });
                shared.unwrap_or_default().join(".")
            }
        }
    }

    /// Number of its numbers.
    pub fn count(&self, level: &Level) -> usize {
        let shape = level.map.shape_variables();
        match self {
            Self::Shape => shape,
            Self::Loads => level.variables() - shape,
            Self::Numbers(numbers) => numbers.len(),
        }
    }

    /// dJ by its numbers, from the sweeps of all scenarios at θ = 0.
    pub fn gradient(&self, scene: &Scene, level: &Level, swept: &[Gradient]) -> Vec<f64> {
        let shape = level.map.shape_variables();
        let by_variables = || level.vjp(&vec![0.0; level.variables()], swept);
        match self {
            Self::Shape => by_variables()[..shape].to_vec(),
            Self::Loads => by_variables()[shape..].to_vec(),
            Self::Numbers(numbers) => {
                let one = |(scenario, by): (&Scenario, &Gradient)| -> Vec<f64> {
                    let swept = scenario.swept(by);
                    // by the part of it that it is changed by in the scene of the design
                    let by_part = |number: &Number| {
                        let part = number.scale(scene);
                        let part = part.unwrap_or_else(|| number.value(&scenario.scene));
                        part * by_number(number, scenario, &swept)
                    };
                    numbers.iter().map(by_part).collect()
                };
                sum(level.scenarios.iter().zip(swept).map(one))
            }
        }
    }
}

/// The derivative of an objective by a number.
#[derive(Clone, Debug, Serialize)]
pub struct Derivative {
    /// The number's path.
    pub path: String,
    /// dJ by the number.
    pub derivative: f64,
    /// Unit of that.
    pub unit: String,
}

impl Derivative {
    /// All of them, from the sweeps of all scenarios at θ = 0: the loads that are designed, then the
    /// numbers of the scene. A number counts in the scenarios that give it no value of their own.
    pub fn of(problem: &Problem, level: &Level, swept: &[Gradient]) -> Vec<Self> {
        let one = |path: String, derivative: f64, unit: &str| {
            let unit = if unit == "1" { unit.to_owned() } else { format!("1/({unit})") };
            Self { path, derivative, unit }
        };
        let mut all = Vec::new();
        for parameter in Parameter::of(problem, level) {
            match &parameter {
                Parameter::Shape => {}
                Parameter::Loads => {
                    let by = parameter.gradient(&problem.scene, level, swept);
                    let named = level.map.named_load_variables().iter().zip(by);
                    all.extend(
                        named.map(|(own, by)| one(own.path.clone(), by / own.per_metre, own.unit)),
                    );
                }
                Parameter::Numbers(numbers) => all.extend(numbers.iter().map(|number| {
                    let each = level.scenarios.iter().zip(swept);
                    let by = each.map(|(own, by)| by_number(number, own, &own.swept(by))).sum();
                    one(number.path.clone(), by, number.unit)
                })),
            }
        }
        all
    }
}

/// dJ of a scenario by a number; zero where it has a value of its own there.
fn by_number(number: &Number, scenario: &Scenario, swept: &Swept) -> f64 {
    if scenario.config.numbers.contains_key(&number.path) { 0.0 } else { number.derivative(swept) }
}

/// Evaluates a design problem with changed parameters.
pub struct Perturbed<'a> {
    /// As it is.
    pub problem: &'a Problem,
    /// The level that is checked.
    pub settings: &'a LevelConfig,
    /// Terms of the objective.
    pub objectives: &'a ObjectiveBuilder<'a>,
}

impl Perturbed<'_> {
    /// The evaluation at θ = 0 with a parameter changed by `by`, next to that of the
    /// level.
    pub fn evaluate(
        &self,
        level: &Level,
        start: &Evaluation,
        parameter: &Parameter,
        by: &[f64],
    ) -> Result<Evaluation> {
        let mut theta = vec![0.0; level.variables()];
        let near = &level.near(start);
        let changed = match parameter {
            Parameter::Shape => {
                theta[..by.len()].copy_from_slice(by);
                return Ok(level.evaluate(&theta, near)?);
            }
            Parameter::Loads => {
                let shape = theta.len() - by.len();
                theta[shape..].copy_from_slice(by);
                return Ok(level.evaluate(&theta, near)?);
            }
            Parameter::Numbers(numbers) => self.changed(numbers, by)?,
        };
        let design = &self.problem.design;
        // free vertices take no time to set up, and none is moved
        let settings = LevelConfig {
            handles: None,
            vertices: VerticesConfig::All(design.shape.is_some()),
            ..self.settings.clone()
        };
        let body = level.body.clone();
        let mut other = Level::new(&changed, self.objectives, body, design, &settings)?;
        other.set_weights(&level.weights());
        let theta = vec![0.0; other.variables()];
        Ok(other.evaluate(&theta, near)?)
    }

    /// The scene with numbers changed by parts of themselves, or of what is large of their kind.
    fn changed(&self, numbers: &[Number], by: &[f64]) -> Result<Scene> {
        let own = &self.problem.scene;
        let mut scene = own.clone();
        for (number, by) in numbers.iter().zip(by) {
            let value = number.value(own);
            let value = match number.scale(own) {
                Some(scale) => value + scale * by,
                None => value * (1.0 + by),
            };
            number.set(&mut scene, None, value)?;
        }
        numbers.iter().try_for_each(|number| number.check(&scene))?;
        Ok(scene)
    }
}
