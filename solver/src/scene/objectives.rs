//! From the terms of a design file to objectives.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, anyhow, ensure};
use mesh::Vec3;

use super::Scene;
use crate::body::{Body, Part};
use crate::config::{BODY, ForceForm, Names, ObjectiveConfig, axes, beside};
use crate::element::FunctionSpace;
use crate::objective::{
    Clearance, ContactForce, ContactProxy, DistanceField, DistanceKind, Motion, Objective, Patch,
    Quantity, Repulsion, Resultant, Smoothness, StrainLimit, Stress, Target, Volume, WallThickness,
};
use crate::schedule::Field;

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
    scene: &'a Scene,
    fields: BTreeMap<usize, DistanceField>,
}

impl<'a> ObjectiveBuilder<'a> {
    /// Reads the targets of a design file.
    ///
    /// # Errors
    /// When a target cannot be read or a setting is not admissible.
    pub fn new(design: &Path, configs: &'a [ObjectiveConfig], scene: &'a Scene) -> Result<Self> {
        let mut fields = BTreeMap::new();
        for (i, config) in configs.iter().enumerate() {
            let context = || design.display().to_string();
            config.check().with_context(context)?;
            let name = config.name();
            config
                .over()
                .factors(&scene.times())
                .map_err(|what| anyhow!("objective \"{name}\": over: {what}"))
                .with_context(context)?;
            ensure!(
                scene.config.contact.is_some() || !needs_contact(config),
                "{}: objective \"{name}\": {}: there are no forces between surfaces without \
                 [contact] in {}",
                design.display(),
                config.kind().key,
                scene.path.display()
            );
            if let ObjectiveConfig::Target { target, spacing, distance, .. } = config {
                let path = beside(design, target);
                let surface = mesh::io::read_surface(&path)?;
                check_target(&surface, *distance).with_context(|| path.display().to_string())?;
                fields.insert(i, DistanceField::new(&surface, *spacing, *distance));
            }
        }
        Ok(Self { configs, scene, fields })
    }

    /// The terms on one body.
    ///
    /// # Errors
    /// When a tag or a body is missing.
    pub fn build(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Weighted>> {
        let build = |(i, config): (usize, &ObjectiveConfig)| {
            let name = config.name();
            let context = || format!("objective \"{name}\"");
            let objective = self.one(i, config, body, space).with_context(context)?;
            let factors = config.over().factors(&self.scene.times()).map_err(anyhow::Error::msg)?;
            Ok(Weighted { weight: config.weight(), factors, objective })
        };
        self.configs.iter().enumerate().map(build).collect()
    }

    fn one(
        &self,
        index: usize,
        config: &ObjectiveConfig,
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Box<dyn Objective>> {
        Ok(match config {
            ObjectiveConfig::Target { name, on, measure, .. } => {
                let patch = Patch::new(space, &facets(body, on)?, *measure);
                Box::new(Target::new(name, patch, self.fields[&index].clone()))
            }
            ObjectiveConfig::Displacement {
                name, on, displacement, components, measure, ..
            } => {
                let facets = facets(body, on)?;
                self.check_wanted("displacement", config, displacement, body, &facets)?;
                let patch = Patch::new(space, &facets, *measure);
                let (quantity, wanted) = (Quantity::Displacement, displacement.clone());
                Box::new(Motion::new(name, patch, quantity, wanted, axes(components)))
            }
            ObjectiveConfig::Position { name, on, position, components, measure, .. } => {
                let facets = facets(body, on)?;
                self.check_wanted("position", config, position, body, &facets)?;
                let patch = Patch::new(space, &facets, *measure);
                let (quantity, wanted) = (Quantity::Position, position.clone());
                Box::new(Motion::new(name, patch, quantity, wanted, axes(components)))
            }
            ObjectiveConfig::ContactForce { name, on, form, direction, .. } => {
                let facets = facets(body, on)?;
                let nodes = facets.iter().flat_map(|&f| space.facet_nodes(f)).collect();
                let resultant = match form {
                    ForceForm::Along => {
                        Resultant::Along(direction.map_or_else(Vec3::zeros, Vec3::from))
                    }
                    ForceForm::Squared => Resultant::Squared,
                    ForceForm::SumOfSquares => Resultant::SumOfSquares,
                };
                Box::new(ContactForce::new(name, nodes, resultant))
            }
            ObjectiveConfig::ContactProxy { name, on, density, activation, .. } => {
                let parts = each(body, on)?;
                Box::new(ContactProxy::new(name, space, &parts, *density, *activation)?)
            }
            ObjectiveConfig::WallThickness {
                name,
                on,
                against,
                density,
                minimum,
                activation,
                measure,
                ..
            } => {
                let minimum = minimum.unwrap_or(0.0);
                let limits = Repulsion { density: *density, minimum, activation: *activation };
                if against.is_empty() {
                    Box::new(WallThickness::among(name, &each(body, on)?, limits, *measure)?)
                } else {
                    let others = facets(body, &Names::Several(against.clone()))?;
                    let own = facets(body, on)?;
                    Box::new(WallThickness::between(name, &own, &others, limits, *measure)?)
                }
            }
            ObjectiveConfig::Smoothness { name, on, form, .. } => {
                Box::new(Smoothness::new(name, &facets(body, on)?, *form))
            }
            ObjectiveConfig::Clearance { name, activation, .. } => {
                Box::new(Clearance::new(name, body.boundary(), *activation))
            }
            ObjectiveConfig::Volume { name, on, volume, measure, .. } => {
                let part = |name: &String| body.parts.iter().any(|p| is_called(p, name));
                match on.as_ref().filter(|name| !part(name)) {
                    Some(tag) => {
                        let facets = body.facets(tag)?;
                        Box::new(Volume::behind(name, space, &facets, *measure, *volume))
                    }
                    None => {
                        let facets = boundary_of(body, on.as_deref())?;
                        Box::new(Volume::within(name, space, &facets, *measure, *volume))
                    }
                }
            }
            ObjectiveConfig::Stress { name, on, power, .. } => {
                let parts = self.parts(body, on.as_deref())?;
                let law = |i: usize| self.scene.parts[i].material.build();
                let parts = parts.into_iter().map(|(i, elements)| (law(i), elements)).collect();
                Box::new(Stress::new(name, parts, *power))
            }
            ObjectiveConfig::StrainLimit { name, on, largest, smallest, .. } => {
                let parts = self.parts(body, on.as_deref())?;
                let elements = parts.into_iter().map(|(_, elements)| elements).collect();
                Box::new(StrainLimit::new(name, elements, [*smallest, *largest]))
            }
        })
    }

    /// Numbers and elements of one body, or of all.
    fn parts(&self, body: &Body, name: Option<&str>) -> Result<Vec<(usize, Range<usize>)>> {
        let wanted = |part: &Part| name.is_none_or(|name| is_called(part, name));
        let parts = body.parts.iter().enumerate().filter(|(_, part)| wanted(part));
        let found: Vec<_> = parts.map(|(i, part)| (i, part.tets.clone())).collect();
        ensure!(
            !found.is_empty(),
            "on = \"{}\": no body is called that; there are: {}",
            name.unwrap_or_default(),
            self.scene.parts.iter().map(|p| p.config.name.as_str()).collect::<Vec<_>>().join(", ")
        );
        Ok(found)
    }

    /// Whether what is wanted is defined on all facets whenever it counts.
    fn check_wanted(
        &self,
        key: &str,
        config: &ObjectiveConfig,
        wanted: &Field,
        body: &Body,
        facets: &[[usize; 3]],
    ) -> Result<()> {
        let ends = self.scene.times();
        let factors = config.over().factors(&ends).map_err(anyhow::Error::msg)?;
        let times = [0.0].into_iter().chain(ends).zip(factors);
        let times: Vec<f64> = times.filter(|(_, factor)| *factor != 0.0).map(|(t, _)| t).collect();
        let positions: Vec<Vec3> =
            facets.as_flattened().iter().map(|&v| body.mesh.vertices[v]).collect();
        let check = |schedule: &crate::schedule::Schedule| {
            schedule.check(&times, &positions).map_err(|what| anyhow!("{key}: {what}"))
        };
        wanted.0.iter().try_for_each(check)
    }
}

/// Whether a term looks at forces between surfaces.
fn needs_contact(config: &ObjectiveConfig) -> bool {
    matches!(config, ObjectiveConfig::ContactForce { .. } | ObjectiveConfig::ContactProxy { .. })
}

/// The signed distance needs an inside.
fn check_target(surface: &mesh::SurfaceMesh, distance: DistanceKind) -> Result<()> {
    let rim = mesh::topology::boundary_edges(&surface.triangles).len();
    ensure!(
        distance != DistanceKind::Signed || rim == 0,
        "{rim} edges on the rim of an open surface, which has no inside: distance = \"signed\" \
         needs a closed target; take \"squared\""
    );
    let volume = mesh::measure::enclosed_volume(surface);
    ensure!(
        distance != DistanceKind::Signed || volume > 0.0,
        "the triangles face inwards (volume {volume:.3e} m³): distance = \"signed\" needs a \
         target that faces outwards; turn its triangles around"
    );
    Ok(())
}

/// The facets of each tag or body.
fn each(body: &Body, names: &Names) -> Result<Vec<Vec<[usize; 3]>>> {
    names.all().iter().map(|name| boundary_or_tag(body, name)).collect()
}

/// The facets of all tags and bodies, each once.
fn facets(body: &Body, names: &Names) -> Result<Vec<[usize; 3]>> {
    ensure!(!names.all().is_empty(), "on = []: name a tag or more");
    let mut seen = std::collections::BTreeSet::new();
    let mut facets = each(body, names)?.concat();
    facets.retain(|facet| seen.insert(*facet));
    Ok(facets)
}

fn boundary_or_tag(body: &Body, name: &str) -> Result<Vec<[usize; 3]>> {
    if body.parts.iter().any(|part| is_called(part, name)) && body.tags.id(name).is_none() {
        return boundary_of(body, Some(name));
    }
    body.facets(name)
}

/// Whether a body has a name; the only one is called [`BODY`].
fn is_called(part: &Part, name: &str) -> bool {
    part.name.as_deref().unwrap_or(BODY) == name
}

/// The boundary of one body, or of all.
fn boundary_of(body: &Body, name: Option<&str>) -> Result<Vec<[usize; 3]>> {
    match name {
        Some(name) if body.parts.len() > 1 => body.facets(name),
        _ => Ok(body.boundary().to_vec()),
    }
}

#[cfg(test)]
mod tests;
