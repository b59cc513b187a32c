//! What a quantity is built on: bodies, and the data of their scene.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::material::Specification;
use mechanics::schedule::{Field, WrittenField};
use mesh::Vec3;
use program::{KeyPath, Names, misfit};

use super::{Quantity, Targets};
use crate::written::values;

/// What a quantity is built on.
pub struct Site<'a> {
    /// The bodies in one mesh.
    pub body: &'a Body,
    /// Topology and basis of its displacement.
    pub space: &'a FunctionSpace,
    /// Name of each body, in the order of the body's parts.
    pub bodies: Vec<&'a str>,
    /// All laws, with the body or volume and the elements of each.
    pub laws: Vec<Law<'a>>,
    /// Degrees of freedom that each fixed tag holds.
    pub supports: BTreeMap<String, Vec<usize>>,
    /// Times at which the quantity counts [s].
    pub times: Vec<f64>,
    /// What the scene's probes measure, by their names, where an objective is built.
    pub probes: BTreeMap<String, Arc<dyn Quantity>>,
    /// Names of the threads, in the order of the scene.
    pub threads: Vec<&'a str>,
    /// Target surfaces, from their files.
    pub targets: Targets,
}

/// The law of a body or volume.
pub struct Law<'a> {
    /// Name of the body.
    pub body: &'a str,
    /// Name of the volume, or again of the body.
    pub name: String,
    /// Law and parameters.
    pub material: &'a Specification,
    /// The tetrahedra that have it.
    pub elements: Range<usize>,
}

impl Site<'_> {
    /// Whether a body has this name.
    pub fn is_body(&self, name: &str) -> bool {
        self.bodies.contains(&name)
    }

    /// The facets of each tag or body.
    pub fn each(&self, names: &Names) -> Result<Vec<Vec<[usize; 3]>>> {
        names.all().iter().map(|name| self.boundary_or_tag(name)).collect()
    }

    /// The facets of all tags and bodies, each once.
    pub fn facets(&self, names: &Names) -> Result<Vec<[usize; 3]>> {
        ensure!(!names.all().is_empty(), misfit!(KeyPath::of("on"), " = []: name a tag or more"));
        let mut seen = BTreeSet::new();
        let mut facets = self.each(names)?.concat();
        facets.retain(|facet| seen.insert(*facet));
        Ok(facets)
    }

    /// The boundary of one body, or of all.
    pub fn boundary(&self, name: Option<&str>) -> Result<Vec<[usize; 3]>> {
        match name {
            Some(name) if self.bodies.len() > 1 => Ok(self.body.facets(name)?),
            _ => Ok(self.body.boundary().to_vec()),
        }
    }

    /// Laws and elements of one body or volume, or of all.
    pub fn parts(&self, name: Option<&str>) -> Result<Vec<(&Specification, Range<usize>)>> {
        let is_of = |law: &&Law| name.is_none_or(|name| law.body == name || law.name == name);
        let wanted = self.laws.iter().filter(is_of);
        let found: Vec<_> = wanted.map(|law| (law.material, law.elements.clone())).collect();
        ensure!(
            !found.is_empty(),
            misfit!(
                KeyPath::of("on"),
                " = \"{}\": no body or volume is called that; there are: {}",
                name.unwrap_or_default(),
                self.laws.iter().map(|law| law.name.clone()).collect::<Vec<_>>().join(", ")
            )
        );
        Ok(found)
    }

    /// Elements of one body or volume, or of all.
    pub fn elements(&self, name: Option<&str>) -> Result<Vec<Range<usize>>> {
        Ok(self.parts(name)?.into_iter().map(|(_, elements)| elements).collect())
    }

    /// The values of what is wanted, which has to be defined on all facets at all times that count.
    pub fn wanted(&self, key: &str, wanted: &WrittenField, facets: &[[usize; 3]]) -> Result<Field> {
        let [x, y, z] = wanted.0.each_ref().map(|component| values(key, component));
        let wanted = Field([x?, y?, z?]);
        let positions: Vec<Vec3> =
            facets.as_flattened().iter().map(|&v| self.body.mesh.vertices[v]).collect();
        let mut all = wanted.0.iter();
        all.try_for_each(|schedule| schedule.check(&self.times, &positions))
            .map_err(|what| misfit!(KeyPath::of(key), ": {what}"))?;
        Ok(wanted)
    }

    fn boundary_or_tag(&self, name: &str) -> Result<Vec<[usize; 3]>> {
        if self.is_body(name) && self.body.tags.id(name).is_none() {
            return self.boundary(Some(name));
        }
        Ok(self.body.facets(name)?)
    }
}
