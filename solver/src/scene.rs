//! From config and files to objects: the only place where names become
//! meshes, energies and objectives.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use crate::body::Body;
use crate::config::{GasConfig, ObjectiveConfig, SimConfig, SolverConfig, beside};
use crate::element::{FunctionSpace, HIGHEST_DEGREE};
use crate::energy::{BodyForce, Chamber, Elastic, Energy, GasLaw, Traction, Wall};
use crate::forward::{Newton, Stepping, System};
use crate::material::Specification;
use crate::memory;
use crate::objective::{
    Clearance, DistanceField, DistanceKind, Objective, Smoothness, Target, WallThickness,
};
use crate::supports::Supports;

/// A scene as read from its file.
pub struct Scene {
    /// Where it came from.
    pub path: PathBuf,
    /// The settings.
    pub config: SimConfig,
    /// Law and parameters of the body.
    pub material: Specification,
    /// The mesh file that was read.
    pub mesh_path: PathBuf,
    /// The body.
    pub body: Body,
}

impl Scene {
    /// Reads a scene and its mesh, or another mesh in its place.
    ///
    /// # Errors
    /// With the file, what was found and what was needed.
    pub fn read(path: &Path, other_mesh: Option<&Path>) -> Result<Self> {
        let config: SimConfig = mesh::io::read_toml(path)?;
        let context = || path.display().to_string();
        check(&config).with_context(context)?;
        let material = config.material.specification().with_context(context)?;
        let mesh_path =
            other_mesh.map_or_else(|| beside(path, &config.mesh), std::path::Path::to_path_buf);
        let file = mesh::io::read_tets(&mesh_path)?;
        let findings = mesh::check::check_tets(&file.mesh);
        if let Some(finding) = findings.first() {
            bail!("{}: {}", mesh_path.display(), finding.message);
        }
        let body = Body::new(file.mesh, file.tags);
        Ok(Self { path: path.to_path_buf(), config, material, mesh_path, body })
    }

    /// The discrete problem on a body with this scene's tags.
    ///
    /// # Errors
    /// When a tag is missing, a pressure wall is open with a free rim, or the
    /// memory is too small.
    pub fn system(&self, body: &Body) -> Result<System> {
        let context = || self.path.display().to_string();
        let (degree, exact) = (self.config.degree, self.config.quadrature);
        let vertices = body.mesh.vertices.len();
        let space = FunctionSpace::with_quadrature(degree, exact, vertices, body.mesh.tets.clone());
        let supports = self.supports(body, &space)?;
        let energies = self.energies(body, &space, &supports).with_context(context)?;
        let system = System::new(space, energies, &supports.fixed());
        system.memory().check(memory::available()).with_context(context)?;
        Ok(system.with_displacement(&supports.displacement))
    }

    /// The fixed degrees of freedom on a body with this scene's tags.
    ///
    /// # Errors
    /// When a tag is missing, tags contradict each other or the body floats.
    pub fn supports(&self, body: &Body, space: &FunctionSpace) -> Result<Supports> {
        Supports::new(&self.config.fixed, body, space)
            .with_context(|| self.path.display().to_string())
    }

    /// The terms of the potential energy; the first is the elastic one.
    fn energies(
        &self,
        body: &Body,
        space: &FunctionSpace,
        supports: &Supports,
    ) -> Result<Vec<Box<dyn Energy>>> {
        let mut energies: Vec<Box<dyn Energy>> =
            vec![Box::new(Elastic { material: self.material.build() })];
        for (name, chamber) in self.chambers(body, space)? {
            check_rim(&name, &body.facets(&name)?, supports, space, body)?;
            energies.push(Box::new(chamber));
        }
        for load in &self.config.body_force {
            energies.push(Box::new(BodyForce { force: load.force.into() }));
        }
        for load in &self.config.traction {
            let facets = body.facets(&load.on)?;
            energies.push(Box::new(Traction::new(space, &facets, load.traction.into())));
        }
        Ok(energies)
    }

    /// The chambers of a body, by the tags of their walls.
    ///
    /// # Errors
    /// When a tag is missing or closes no volume that gas could fill.
    pub fn chambers(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<(String, Chamber)>> {
        let context = || self.path.display().to_string();
        let isobaric =
            self.config.pressure.iter().map(|c| (&c.on, GasLaw::Isobaric { pressure: c.pressure }));
        let ideal = self.config.gas.iter().map(|c| {
            let GasConfig { fill, ambient, exponent, .. } = *c;
            (&c.on, GasLaw::Ideal { fill, ambient, exponent })
        });
        let nodes = space.node_positions(&body.mesh.vertices);
        let mut chambers = Vec::new();
        for (on, gas) in isobaric.chain(ideal) {
            let wall = Wall::new(space, &body.facets(on).with_context(context)?);
            let volume = wall.volume(space, &nodes);
            if matches!(gas, GasLaw::Ideal { .. }) && volume <= 0.0 {
                bail!(
                    "{}: gas on \"{on}\": the volume behind the wall is {volume:.3e} m³, must be \
                     positive\n  the tag is not the wall of a chamber",
                    self.path.display()
                );
            }
            chambers.push((on.clone(), Chamber { wall, gas }));
        }
        Ok(chambers)
    }

    /// How to approach the full load.
    #[must_use]
    pub fn stepping(&self) -> Stepping {
        let SolverConfig {
            first_load_step,
            largest_load_step,
            smallest_load_step,
            newton_iterations,
            relative_tolerance,
            absolute_tolerance,
        } = self.config.solver;
        Stepping {
            first: first_load_step,
            largest: largest_load_step,
            smallest: smallest_load_step,
            newton: Newton {
                iterations: newton_iterations,
                relative: relative_tolerance,
                absolute: absolute_tolerance,
            },
        }
    }
}

/// Settings that no type can rule out.
fn check(config: &SimConfig) -> Result<()> {
    let s = &config.solver;
    ensure!(
        (1..=HIGHEST_DEGREE).contains(&config.degree),
        "degree = {}: must be 1, 2 or 3",
        config.degree
    );
    ensure!(
        (5..=12).contains(&config.quadrature),
        "quadrature = {}: must be from 5 to 12",
        config.quadrature
    );
    for load in &config.body_force {
        ensure!(
            load.force.iter().all(|f| f.is_finite()),
            "[[body_force]]: force = {:?} N/m³ must be finite",
            load.force
        );
    }
    for load in &config.traction {
        ensure!(
            load.traction.iter().all(|t| t.is_finite()),
            "[[traction]] on \"{}\": traction = {:?} Pa must be finite",
            load.on,
            load.traction
        );
    }
    ensure!(!config.fixed.is_empty(), "no [[fixed]] tag: the body would float away; fix one");
    for gas in &config.gas {
        ensure!(
            gas.ambient > 0.0
                && gas.fill + gas.ambient > 0.0
                && gas.exponent >= 1.0
                && (gas.fill + gas.ambient + gas.exponent).is_finite(),
            "gas on \"{}\": ambient = {} Pa and ambient + fill = {} Pa must be positive, exponent = {} \
             at least 1, all finite",
            gas.on,
            gas.ambient,
            gas.fill + gas.ambient,
            gas.exponent
        );
    }
    let walls: Vec<&String> =
        config.pressure.iter().map(|c| &c.on).chain(config.gas.iter().map(|c| &c.on)).collect();
    if let Some(twice) = walls.iter().enumerate().find(|(i, w)| walls[..*i].contains(w)) {
        bail!("\"{}\" is the wall of two chambers: keep one of [[pressure]] and [[gas]]", twice.1);
    }
    for load in &config.pressure {
        ensure!(load.pressure.is_finite(), "pressure on \"{}\" is {}", load.on, load.pressure);
    }
    ensure!(
        s.first_load_step > 0.0 && s.first_load_step <= 1.0,
        "first_load_step = {}: must be above 0 and at most 1",
        s.first_load_step
    );
    ensure!(
        s.smallest_load_step > 0.0 && s.smallest_load_step <= s.first_load_step,
        "smallest_load_step = {}: must be above 0 and at most first_load_step",
        s.smallest_load_step
    );
    ensure!(
        s.largest_load_step >= s.first_load_step,
        "largest_load_step = {}: must be at least first_load_step = {}",
        s.largest_load_step,
        s.first_load_step
    );
    ensure!(
        s.relative_tolerance > 0.0 && s.relative_tolerance < 1.0,
        "relative_tolerance = {}: must be above 0 and below 1",
        s.relative_tolerance
    );
    ensure!(
        s.absolute_tolerance >= 0.0 && s.absolute_tolerance.is_finite(),
        "absolute_tolerance = {} N: must be finite and not negative",
        s.absolute_tolerance
    );
    ensure!(
        s.newton_iterations > 0,
        "newton_iterations = {}: must be positive",
        s.newton_iterations
    );
    Ok(())
}

/// The gas force has a potential only when every rim of its wall is fixed along
/// all axes.
fn check_rim(
    name: &str,
    facets: &[[usize; 3]],
    supports: &Supports,
    space: &FunctionSpace,
    body: &Body,
) -> Result<()> {
    let rim = mesh::topology::boundary_edges(facets);
    let held = |&[a, b]: &[usize; 2]| {
        [a, b].into_iter().chain(space.edge_nodes([a, b])).all(|node| supports.holds(node))
    };
    let free: Vec<_> = rim.iter().filter(|edge| !held(edge)).collect();
    if let Some([a, _]) = free.first() {
        let p = body.mesh.vertices[*a];
        bail!(
            "pressure on \"{name}\": {} of the {} edges of its rim are free, the first at \
             ({:.5}, {:.5}, {:.5}) m\n  gas pressure has no energy unless the wall is closed or its \
             rim is fixed along x, y and z: add the tag around the opening to [[fixed]]",
            free.len(),
            rim.len(),
            p.x,
            p.y,
            p.z
        );
    }
    Ok(())
}

/// A term and its weight.
pub struct Weighted {
    /// Factor of the term.
    pub weight: f64,
    /// The term.
    pub objective: Box<dyn Objective>,
}

/// Builds objectives; the distance fields of targets are made once and shared
/// by all levels.
pub struct ObjectiveBuilder<'a> {
    configs: &'a [ObjectiveConfig],
    fields: BTreeMap<usize, DistanceField>,
}

impl<'a> ObjectiveBuilder<'a> {
    /// Reads the targets of a design file.
    ///
    /// # Errors
    /// When a target cannot be read or a setting is not admissible.
    pub fn new(design: &Path, configs: &'a [ObjectiveConfig]) -> Result<Self> {
        let mut fields = BTreeMap::new();
        for (i, config) in configs.iter().enumerate() {
            check_objective(config).with_context(|| design.display().to_string())?;
            if let ObjectiveConfig::Target { target, spacing, .. } = config {
                let surface = mesh::io::read_surface(&beside(design, target))?;
                fields.insert(i, DistanceField::new(&surface, *spacing, DistanceKind::Squared));
            }
        }
        Ok(Self { configs, fields })
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
        Ok(Weighted { weight, objective })
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
