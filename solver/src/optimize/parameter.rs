//! What an objective of a design problem depends on, one by one, for Taylor tests of
//! the user's own scene.

use anyhow::Result;

use super::{Evaluation, Level, Rejected, Scenario};
use crate::adjoint::Gradient;
use crate::config::{DesignConfig, LevelConfig, VerticesConfig};
use crate::energy::ParameterId;
use crate::math::linear::sum;
use crate::scene::{ObjectiveBuilder, Scene};

/// A group of numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// Design variables of the shape [m].
    Shape,
    /// Design variables of the loads [m].
    Loads,
    /// Parameters of the law of a body or volume, each relative to itself.
    Material(usize),
    /// Its density, relative to itself.
    Density(usize),
    /// Thickness of a sheet and parameters of its law, each relative to itself.
    Membrane(usize),
    /// Coefficient of friction, relative to itself.
    Friction,
    /// Velocity of a body at t = 0 [m/s].
    Velocity(usize),
}

impl Parameter {
    /// All that the runs of a level depend on.
    #[must_use]
    pub fn of(scene: &Scene, level: &Level) -> Vec<Self> {
        let mut all = Vec::new();
        let shape = level.map().shape_variables();
        all.extend((shape > 0).then_some(Self::Shape));
        all.extend((level.variables() > shape).then_some(Self::Loads));
        for law in 0..scene.laws.len() {
            all.push(Self::Material(law));
            if scene.weighs(law) {
                all.push(Self::Density(law));
            }
        }
        if scene.config.method().has_inertia() {
            all.extend((0..scene.parts.len()).map(Self::Velocity));
        }
        all.extend((0..scene.membranes.len()).map(Self::Membrane));
        let has_friction = scene.config.contact().is_some_and(|c| c.friction > 0.0);
        all.extend(has_friction.then_some(Self::Friction));
        all
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(&self, scene: &Scene) -> String {
        let law = |i: usize| scene.law_name(&scene.laws[i]);
        match self {
            Self::Shape => "shape".to_owned(),
            Self::Loads => "loads".to_owned(),
            Self::Material(i) => format!("material of {}", law(*i)),
            Self::Density(i) => format!("density of {}", law(*i)),
            Self::Membrane(i) => format!("membrane {} on {}", i + 1, scene.membranes[*i].config.on),
            Self::Friction => "friction".to_owned(),
            Self::Velocity(part) => format!("velocity of {}", scene.parts[*part].config.name),
        }
    }

    /// Number of its numbers.
    #[must_use]
    pub fn count(&self, scene: &Scene, level: &Level) -> usize {
        let shape = level.map().shape_variables();
        match self {
            Self::Shape => shape,
            Self::Loads => level.variables() - shape,
            Self::Material(law) => scene.laws[*law].material.values.len(),
            Self::Membrane(i) => scene.membranes[*i].numbers().len(),
            Self::Density(_) | Self::Friction => 1,
            Self::Velocity(_) => 3,
        }
    }

    /// dJ by its numbers, from the sweeps of all scenarios at θ = 0.
    #[must_use]
    pub fn gradient(&self, level: &Level, swept: &[Gradient]) -> Vec<f64> {
        let shape = level.map().shape_variables();
        let by_variables = || level.pull_back(&vec![0.0; level.variables()], swept);
        let relative = |of: fn(&Scenario, usize) -> Vec<f64>, place: usize, id: ParameterId| {
            let one = |(scenario, by): (&Scenario, &Gradient)| -> Vec<f64> {
                let by = by.parameters.total(id);
                by.iter().zip(of(scenario, place)).map(|(by, value)| by * value).collect()
            };
            sum(level.scenarios().iter().zip(swept).map(one))
        };
        match self {
            Self::Shape => by_variables()[..shape].to_vec(),
            Self::Loads => by_variables()[shape..].to_vec(),
            Self::Material(law) => {
                let values = |s: &Scenario, law: usize| s.scene.laws[law].material.values.clone();
                relative(values, *law, ParameterId::Material(*law))
            }
            Self::Density(law) => {
                let density = |s: &Scenario, law: usize| {
                    vec![s.scene.laws[law].material.density.unwrap_or(0.0)]
                };
                relative(density, *law, ParameterId::Density(*law))
            }
            Self::Membrane(i) => {
                let numbers = |s: &Scenario, i: usize| s.scene.membranes[i].numbers();
                relative(numbers, *i, ParameterId::Membrane(*i))
            }
            Self::Friction => {
                let friction = |s: &Scenario, _: usize| {
                    vec![s.scene.config.contact().map_or(0.0, |c| c.friction)]
                };
                relative(friction, 0, ParameterId::Friction)
            }
            Self::Velocity(part) => level.by_velocity(*part, swept),
        }
    }
}

/// Evaluates a design problem with changed parameters.
pub struct Perturbed<'a> {
    /// The scene as it is.
    pub scene: &'a Scene,
    /// The design problem.
    pub design: &'a DesignConfig,
    /// The level that is checked.
    pub settings: &'a LevelConfig,
    /// Terms of the objective.
    pub objectives: &'a ObjectiveBuilder<'a>,
}

impl Perturbed<'_> {
    /// The evaluation at θ = 0 with a parameter changed by `by`, next to that of the
    /// level.
    ///
    /// # Errors
    /// When the shape is not admissible or the run fails.
    pub fn evaluate(
        &self,
        level: &mut Level,
        start: &Evaluation,
        parameter: &Parameter,
        by: &[f64],
    ) -> Result<Evaluation> {
        let mut theta = vec![0.0; level.variables()];
        let last: Vec<Vec<f64>> =
            start.runs.iter().map(|run| run.states.last().into_owned()).collect();
        let near = level.near(start, &last);
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
            Parameter::Material(law) => {
                let mut scene = self.scene.clone();
                let values = &mut scene.laws[*law].material.values;
                values.iter_mut().zip(by).for_each(|(p, by)| *p *= 1.0 + by);
                scene
            }
            Parameter::Density(law) => {
                let mut scene = self.scene.clone();
                let density = &mut scene.laws[*law].material.density;
                *density = density.map(|d| d * (1.0 + by[0]));
                scene
            }
            Parameter::Membrane(i) => {
                let mut scene = self.scene.clone();
                let membrane = &mut scene.membranes[*i];
                let numbers = [&mut membrane.thickness].into_iter();
                let numbers = numbers.chain(&mut membrane.material.values);
                numbers.zip(by).for_each(|(p, by)| *p *= 1.0 + by);
                scene
            }
            Parameter::Friction => {
                let mut scene = self.scene.clone();
                scene.config.contact_mut().into_iter().for_each(|c| c.friction *= 1.0 + by[0]);
                scene
            }
            Parameter::Velocity(part) => {
                let mut scene = self.scene.clone();
                let velocity = &mut scene.parts[*part].config.velocity;
                velocity.iter_mut().zip(by).for_each(|(v, by)| *v += by);
                scene
            }
        };
        // free vertices take no time to set up, and none is moved
        let settings = LevelConfig {
            handles: None,
            vertices: VerticesConfig::All(self.design.shape.is_some()),
            ..self.settings.clone()
        };
        let body = level.body.clone();
        let mut other = Level::new(&changed, self.objectives, body, self.design, &settings)?;
        other.set_weights(&level.weights());
        let theta = vec![0.0; other.variables()];
        other.evaluate(&theta, near).map_err(|Rejected(why)| anyhow::anyhow!(why))
    }
}
