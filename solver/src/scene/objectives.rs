//! From the terms of a design file to objectives.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::body::Body;
use crate::config::{ObjectiveConfig, beside};
use crate::element::FunctionSpace;
use crate::objective::{
    Clearance, DistanceField, DistanceKind, Objective, Smoothness, Target, TimeIntegral,
    WallThickness,
};

use super::Scene;

/// A term with its factors.
pub struct Weighted {
    /// Factor of the term.
    pub weight: f64,
    /// ω of each moment, that of rest first: Σ ω J is the term over time.
    pub factors: Vec<f64>,
    /// The term.
    pub objective: Box<dyn Objective>,
}

/// Builds objectives; the distance fields of targets are made once and shared
/// by all levels.
pub struct ObjectiveBuilder<'a> {
    configs: &'a [ObjectiveConfig],
    /// Ends of the time steps [s].
    ends: Vec<f64>,
    fields: BTreeMap<usize, DistanceField>,
}

impl<'a> ObjectiveBuilder<'a> {
    /// Reads the targets of a design file.
    ///
    /// # Errors
    /// When a target cannot be read or a setting is not admissible.
    pub fn new(design: &Path, configs: &'a [ObjectiveConfig], scene: &Scene) -> Result<Self> {
        let mut fields = BTreeMap::new();
        for (i, config) in configs.iter().enumerate() {
            check_objective(config).with_context(|| design.display().to_string())?;
            if let ObjectiveConfig::Target { target, spacing, .. } = config {
                let surface = mesh::io::read_surface(&beside(design, target))?;
                fields.insert(i, DistanceField::new(&surface, *spacing, DistanceKind::Squared));
            }
        }
        Ok(Self { configs, ends: scene.times(), fields })
    }

    /// The terms on one body.
    ///
    /// # Errors
    /// When a tag is missing.
    pub fn build(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Weighted>> {
        let build = |(i, config): (usize, &ObjectiveConfig)| self.one(i, config, body, space);
        self.configs.iter().enumerate().map(build).collect()
    }

    fn one(
        &self,
        index: usize,
        config: &ObjectiveConfig,
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Weighted> {
        let (weight, objective): (f64, Box<dyn Objective>) = match config {
            ObjectiveConfig::Target { name, weight, on, .. } => {
                let facets =
                    body.facets(on)?.into_iter().map(|f| (f, space.facet_nodes(f))).collect();
                let field = self.fields[&index].clone();
                (*weight, Box::new(Target::new(name.clone(), facets, field)))
            }
            ObjectiveConfig::WallThickness { name, weight, on, against, minimum, activation } => {
                let mut others = Vec::new();
                for tag in against {
                    others.extend(body.facets(tag)?);
                }
                let term =
                    WallThickness::log(name, &body.facets(on)?, &others, *minimum, *activation)
                        .with_context(|| format!("objective \"{name}\""))?;
                (*weight, Box::new(term))
            }
            ObjectiveConfig::Smoothness { name, weight, on } => {
                (*weight, Box::new(Smoothness::scale_invariant(name, &body.facets(on)?)))
            }
            ObjectiveConfig::Clearance { name, weight, activation } => {
                (*weight, Box::new(Clearance::new(name, body.boundary(), *activation)))
            }
        };
        let factors = TimeIntegral::Final.factors(&self.ends).map_err(anyhow::Error::msg)?;
        Ok(Weighted { weight, factors, objective })
    }
}

/// The user's name and weight of a term.
fn label(config: &ObjectiveConfig) -> (&str, f64) {
    match config {
        ObjectiveConfig::Target { name, weight, .. }
        | ObjectiveConfig::WallThickness { name, weight, .. }
        | ObjectiveConfig::Smoothness { name, weight, .. }
        | ObjectiveConfig::Clearance { name, weight, .. } => (name, *weight),
    }
}

fn check_objective(config: &ObjectiveConfig) -> Result<()> {
    let (name, weight) = label(config);
    ensure!(weight.is_finite() && weight >= 0.0, "objective \"{name}\": weight = {weight}");
    let lengths = match config {
        ObjectiveConfig::Target { spacing, .. } => vec![("spacing", *spacing)],
        ObjectiveConfig::WallThickness { minimum, activation, .. } => {
            vec![("minimum", *minimum), ("activation", *activation)]
        }
        ObjectiveConfig::Clearance { activation, .. } => vec![("activation", *activation)],
        ObjectiveConfig::Smoothness { .. } => Vec::new(),
    };
    for (key, value) in lengths {
        ensure!(
            value.is_finite() && value > 0.0,
            "objective \"{name}\": {key} = {value} m must be positive"
        );
    }
    Ok(())
}
