//! From config and files to objects: the only place where names become
//! meshes, energies and objectives.

mod apart;
mod assembly;
mod afloat;
mod chambers;
mod contact;
mod laws;
mod objectives;
mod probes;
mod progress;
mod rigid;
mod symmetry;

pub use laws::SceneLaw;
pub use objectives::{ObjectiveBuilder, Weighted};

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{
    BodyForce, Chamber, Contact, Elastic, Energies, Friction, Inertia, InternalVariables, Mullins,
    Term, Traction, Viscous,
};
use mechanics::forward::{Growth, Integrator, Newton, Problem, State, Stepping, Workspace};
use mechanics::schedule::Field;
use mechanics::stability::ArcLength;
use mechanics::stretch::Limits;
use mesh::Vec3;
use program::{KeyPath, Settings, misfit};

use crate::config::{BodyConfig, InsideOut, LevelConfig, LevelTime, SimConfig, TimeConfig};
use crate::memory;
use crate::supports::Supports;
use crate::term::{Ground, Region};

/// Strain of a whole body that is as good as none, where loads are no smaller [1].
const NEGLIGIBLE_STRAIN: f64 = 1e-11;
/// Density for the tiny mass of a loose body if its own is not known [kg/m³].
const WATER: f64 = 1000.0;

/// A scene as read from its file.
#[derive(Clone)]
pub struct Scene {
    /// Where it came from.
    pub path: PathBuf,
    /// The file, for errors and hashes.
    pub file: Settings,
    /// The settings.
    pub config: SimConfig,
    /// The settings of each body, in the order of the body's parts.
    pub parts: Vec<ScenePart>,
    /// What they are made of, body by body, in the order of tetrahedra.
    pub laws: Vec<SceneLaw>,
    /// The bodies.
    pub body: Body,
    /// Numbers that were given values which are not in the settings, by their paths; of a wall the sum of its moves [m].
    pub given: BTreeMap<String, f64>,
    /// Whether to prove of every step that no surfaces intersect.
    pub certify: bool,
}

/// One body as its scene describes it.
#[derive(Clone)]
pub struct ScenePart {
    /// The settings.
    pub config: BodyConfig,
    /// The mesh file that was read.
    pub mesh_path: PathBuf,
}

impl Scene {
    /// This scene with the degree and the time steps of a level of a design.
    pub fn with_fidelity(&self, level: &LevelConfig) -> Result<Self> {
        let mut time = self.config.time.clone();
        if let Some(LevelTime { steps, end }) = level.time {
            let own = time.as_mut().ok_or_else(|| {
                KeyPath::list("shape.level").key("time").told(
                    "[[shape.level]] time: the scene has no [time]; expected a level without it",
                )
            })?;
            let end = end.unwrap_or_else(|| self.end());
            *own = TimeConfig { end: Some(end), steps: Some(steps), at: None, method: own.method };
        }
        let changed = self.config.with(|config| {
            config.degree = level.degree.unwrap_or(config.degree);
            config.time = time;
        });
        let context = || format!("{}, as a [[shape.level]] has it", self.path.display());
        Ok(Self { config: changed.with_context(context)?, ..self.clone() })
    }

    /// Density of a body or volume [kg/m³].
    fn density(&self, law: &SceneLaw) -> Result<f64> {
        law.material.density.with_context(|| {
            format!(
                "{} \"{}\": inertia and gravity need the density of its material; add density \
                 = ... [kg/m³] to its table, about 1000 to 1100 for silicone{}",
                if law.volume.is_some() { "volume" } else { "body" },
                self.law_name(law),
                if self.config.method().has_inertia() {
                    ", or neglect inertia by method = \"quasistatic\" in [time]"
                } else {
                    ""
                }
            )
        })
    }

    /// How far each material may be stretched, as far as it is known, on a body with the volumes of the scene.
    pub fn stretch_limits(&self, body: &Body) -> Vec<Limits> {
        let one = |law: &SceneLaw| Limits {
            name: if self.laws.len() > 1 { self.law_name(law) } else { String::new() },
            elements: law.elements(body),
            tested: law.material.tested(),
            modes: law.material.modes.clone(),
            at_break: law.material.stretch_at_break,
        };
        self.laws.iter().map(one).collect()
    }

    /// Least of the stretches at which its materials tear [1], if one is known.
    pub fn stretch_at_break(&self) -> Option<f64> {
        self.laws.iter().filter_map(|law| law.material.stretch_at_break).reduce(f64::min)
    }

    /// The discrete problem on a body with this scene's tags, and what solving it needs.
    pub fn problem(&self, body: &Body) -> Result<(Problem, Workspace)> {
        let problem = self.discretise(body)?;
        let large = memory::foretold(problem.dirichlet.free().len());
        large.iter().for_each(|said| log::warn!("{said}"));
        let mut workspace = Workspace::new(&problem);
        workspace.watch = Some(progress::watch(self.config.time.is_some()));
        memory::require(workspace.memory()).with_context(|| self.path.display().to_string())?;
        Ok((problem, workspace))
    }

    /// The discrete problem of [`Self::problem`] alone.
    pub fn discretise(&self, body: &Body) -> Result<Problem> {
        self.file.checked(|_| self.discretised(body))
    }

    fn discretised(&self, body: &Body) -> Result<Problem> {
        let context = || self.path.display().to_string();
        let (degree, exact) = (self.config.degree, self.config.quadrature);
        let vertices = body.mesh.vertices.len();
        let space = FunctionSpace::with_quadrature(degree, exact, vertices, body.mesh.tets.clone());
        let supports = self.supports(body, &space)?;
        let rigid = self.rigid_sets(body, &space, &supports).with_context(context)?;
        let mut energies = self.energies(body, &space, &supports).with_context(context)?;
        energies.extend(self.rigid_terms(&rigid, body, &space).with_context(context)?);
        let multipliers = self.multipliers(body, &space, &energies);
        let mut problem =
            Problem::new(space, energies, &supports.fixed()).with_multipliers(multipliers);
        if !rigid.is_empty() {
            problem = problem.with_rigid(&rigid);
        }
        problem.tolerates_inversion = self.config.solver.inside_out == InsideOut::Tolerated;
        if self.config.is_afloat() {
            self.check_afloat(&problem, &supports, &body.mesh.vertices)?;
        }
        if supports.move_at_all() {
            problem = problem.with_motion(move |load| supports.displacement(load));
        }
        Ok(problem)
    }

    /// Refuses a scene that has nothing to move a body; loads that are zero may be one case of many.
    pub fn check_loads(&self) -> Result<()> {
        let flies = self.parts.iter().any(|part| part.config.velocity != [0.0; 3]);
        let config = &self.config;
        if flies || config.schedules().iter().any(|(_, _, value)| !value.is_zero()) {
            return Ok(());
        }
        let path = self.path.display();
        let has_load = !(config.chamber.is_empty()
            && config.body_force.is_empty()
            && config.traction.is_empty());
        ensure!(
            has_load,
            "{path}: nothing moves the body: no chamber, no force, no gravity, and no support or obstacle \
             that moves\n  give it a load, such as [[chamber]] with a pressure"
        );
        log::warn!("{path}: nothing moves the body: all its loads are zero");
        Ok(())
    }

    /// Warns of a time integration by which oscillations grow that nothing drives.
    pub fn warn_of_growth(&self) {
        if let Some(Growth { factor, phase, largest_phase }) = self.config.method().growth() {
            log::warn!(
                "{}: oscillations of frequency ω grow where ω Δt < {largest_phase:.2}, by {:.1} % in each step \
                 at ω Δt = {phase:.2}\n  \
                 in place of bdf3 take method = \"generalized-alpha\" in [time], by which none grow",
                self.path.display(),
                100.0 * (factor - 1.0)
            );
        }
        let turns = self.config.rigid.iter().find(|part| part.turns);
        if let Some(part) = turns.filter(|_| self.config.method().shakes_stiff_parts()) {
            log::warn!(
                "{}: {} may turn, and with this method in [time] its energy may grow: it is stiffer than steps \
                 resolve\n  take method = \"bdf2\", which damps that, or turns = false if it is guided",
                self.path.display(),
                part.title()
            );
        }
    }

    /// The fixed degrees of freedom on a body with this scene's tags.
    pub fn supports(&self, body: &Body, space: &FunctionSpace) -> Result<Supports> {
        let supports = || {
            let supports = Supports::new(&self.fixed(body), &self.config.moments(), body, space)?;
            if !self.config.may_float() {
                supports.check_rigid_motions(space)?;
            }
            Ok::<_, anyhow::Error>(supports)
        };
        supports().with_context(|| self.path.display().to_string())
    }

    /// The bodies at t = 0, and their time integration.
    pub fn integrator(&self, body: &Body, problem: &Problem) -> Integrator {
        let space = &problem.space;
        let nodes = space.node_count();
        let mut v = vec![0.0; 3 * nodes];
        for (i, part) in self.parts.iter().enumerate() {
            for node in nodes_of(body, i, space) {
                v[3 * node..3 * node + 3].copy_from_slice(&part.config.velocity);
            }
        }
        problem.dirichlet.supports().iter().for_each(|&dof| v[dof] = 0.0);
        Integrator::new(self.config.method(), State::new(vec![0.0; 3 * nodes], v))
    }

    /// Whether the density of a law matters, by its place among all.
    pub fn weighs(&self, law: usize) -> bool {
        let falls = !self.config.gravity.is_zero();
        let known = self.laws[law].material.density.is_some();
        known && (falls || self.config.method().has_inertia())
    }

    /// The terms of the potential energy.
    fn energies(
        &self,
        body: &Body,
        space: &FunctionSpace,
        supports: &Supports,
    ) -> Result<Energies> {
        let mut energies: Energies =
            self.terms_with_numbers(body, space, supports)?.into_iter().collect();
        let internal = energies.internal_count(space);
        for (name, chamber) in self.chambers(body, space, internal)? {
            chambers::check_rim(&name, &chamber.wall, supports, space, body)?;
            energies = energies.with_chamber(name, chamber);
        }
        if let Some(collisions) = self.collisions(body, space, &supports.fixed())? {
            energies.extend([Term::of(Contact::OWNER, collisions.contact)]);
            energies.extend(collisions.friction.map(|own| Term::of(Friction::OWNER, own)));
        }
        self.check_apart(body, space)?;
        self.check_symmetric(body)?;
        let nodes = space.node_positions(&body.mesh.vertices);
        let gravity = self.config.field(&self.config.gravity);
        self.check_field(KeyPath::of("gravity"), &gravity, &nodes)?;
        for load in &self.config.body_force {
            let force = self.config.field(&load.force);
            self.check_field(KeyPath::list("body_force").key("force"), &force, &nodes)?;
            energies = energies.with(BodyForce::whole(force));
        }
        for (place, load) in self.config.traction.iter().enumerate() {
            let facets = body.facets(&load.on)?;
            let ids = facets.iter().flat_map(|&f| space.facet_nodes(f));
            let places: Vec<Vec3> = ids.map(|node| nodes[node]).collect();
            let name = KeyPath::list("traction").on(&load.on).key("traction");
            let traction = self.config.field(&load.traction);
            self.check_field(name, &traction, &places)?;
            let traction = Traction::new(space, &facets, traction);
            energies.extend([Term::of(Traction::owner(place), traction)]);
        }
        Ok(energies)
    }

    /// The terms of a problem with the numbers of this scene: its materials, sheets, fibres, threads, gravity,
    /// gas, friction, and the stiffness of the barrier that follows from them. Supports and other forces are those of the
    /// problem.
    pub fn energies_like(&self, body: &Body, problem: &Problem) -> Result<Energies> {
        let space = &*problem.space;
        let own = self.terms_with_numbers(body, space, &self.supports(body, space)?)?;
        let others = problem.energies.terms().skip(own.len()).cloned();
        let mut energies: Energies = own.iter().cloned().chain(others).collect();
        energies.change(|place, chamber: &Chamber| Chamber {
            gas: self.config.gas_law(&self.config.chamber[place]),
            ..chamber.clone()
        });
        let coefficient = self.config.contact().map_or(0.0, |contact| contact.friction);
        energies.change(|_, own: &Friction| own.clone().with_coefficient(coefficient));
        if let Some(law) = self.law_of_contact() {
            let stiffness = self.laws[law].material.moduli().shear;
            energies.change(|_, contact: &Contact| contact.with_stiffness(stiffness));
        }
        self.set_rigid_numbers(&mut energies);
        Ok(energies)
    }

    /// The terms that begin the list, whose numbers are made with them: bodies, sheets, fibres, threads, inertia.
    fn terms_with_numbers(
        &self,
        body: &Body,
        space: &FunctionSpace,
        supports: &Supports,
    ) -> Result<Vec<Term>> {
        let mut terms = self.bodies(body, space)?;
        let ground = Ground { path: &self.path, body, space, regions: self.regions(body) };
        for room in self.config.rooms() {
            terms.extend(room.build(&ground)?);
        }
        for (place, law) in self.laws.iter().enumerate() {
            let inertia = self.inertia(law, body, space, supports)?;
            terms.extend(inertia.map(|inertia| Term::of(Inertia::owner(place), inertia)));
        }
        Ok(terms)
    }

    /// What has a law of its own on a body, in the order of laws.
    pub(crate) fn regions(&self, body: &Body) -> Vec<Region> {
        let region = |law: &SceneLaw| Region {
            name: self.law_name(law),
            body: self.parts[law.part].config.name.clone(),
            elements: law.elements(body),
        };
        self.laws.iter().map(region).collect()
    }

    /// The terms of all bodies and volumes, but for inertia: elastic energy, overstress, softening and weight of each.
    fn bodies(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Term>> {
        let gravity = self.config.field(&self.config.gravity);
        let (mut terms, mut internal) = (Vec::new(), 0);
        for (place, law) in self.laws.iter().enumerate() {
            let tets = law.elements(body);
            let elastic = self.elastic(law, tets.clone())?;
            let of_law = (Elastic::owner(place), elastic.material.parameter_count());
            terms.push(Term::of(of_law.0, elastic));
            if let Some(own) = self.overstress(law, tets.clone(), internal) {
                internal += InternalVariables::count(&own, space);
                terms.push(Term::of_both(of_law, Viscous::owner(place), own));
            }
            if let Some(own) = self.softening(law, tets.clone(), internal) {
                internal += InternalVariables::count(&own, space);
                terms.push(Term::of_both(of_law, Mullins::owner(place), own));
            }
            if !self.config.gravity.is_zero() {
                let weight = BodyForce::weight(gravity.clone(), self.density(law)?, tets);
                terms.push(Term::of(BodyForce::weight_owner(place), weight));
            }
        }
        Ok(terms)
    }

    /// The inertia of a law on its elements, or the tiny mass of a body that is loose.
    fn inertia(
        &self,
        law: &SceneLaw,
        body: &Body,
        space: &FunctionSpace,
        supports: &Supports,
    ) -> Result<Option<Inertia>> {
        let tets = law.elements(body);
        if self.config.method().has_inertia() {
            return Ok(Some(Inertia::new(space, self.density(law)?, tets)));
        }
        let density = law.material.density.unwrap_or(WATER);
        let is_loose = supports.leave_loose(space, &body.parts[law.part].vertices);
        Ok(is_loose.then(|| Inertia::tiny(space, density, tets)))
    }

    /// Names of all surfaces that may touch: bodies, then obstacles.
    pub fn surface_names(&self) -> Vec<&str> {
        let bodies = self.parts.iter().map(|part| &part.config.name[..]);
        bodies.chain(self.config.obstacle.iter().map(|o| &o.name[..])).collect()
    }

    /// Whether a load is defined at all these positions, at the ends of all time
    /// steps.
    fn check_field(&self, name: KeyPath, field: &Field, positions: &[Vec3]) -> Result<()> {
        let times: Vec<f64> = [0.0].into_iter().chain(self.times()).collect();
        for schedule in field.0.iter().filter(|s| s.uses_position()) {
            schedule.check(&times, positions).map_err(|what| misfit!(name.clone(), ": {what}"))?;
        }
        Ok(())
    }

    /// How to approach the full load.
    pub fn stepping(&self) -> Stepping {
        let solver = &self.config.solver;
        let absolute = solver.absolute_tolerance;
        Stepping {
            first: solver.first_load_step(),
            largest: solver.largest_load_step(),
            smallest: solver.smallest_load_step,
            newton: Newton {
                iterations: self.config.newton_iterations(),
                relative: solver.relative_tolerance,
                absolute: absolute.unwrap_or(0.0),
                negligible: absolute.map_or_else(|| self.negligible_force(), |_| 0.0),
                ballooned: None,
            },
        }
    }

    /// How to follow the path of equilibria by its arc length, where the scene asks for that.
    pub fn path(&self) -> Option<ArcLength> {
        let solver = &self.config.solver;
        (!solver.follow.is_load()).then(|| ArcLength {
            first: solver.first_load_step(),
            largest: solver.largest_load_step.unwrap_or(f64::INFINITY),
            smallest: solver.smallest_load_step,
            end: 1.0,
        })
    }

    /// The force that strains the bodies by [`NEGLIGIBLE_STRAIN`], whatever unit they are small in [N].
    fn negligible_force(&self) -> f64 {
        let size = mesh::measure::volume(&self.body.mesh).cbrt();
        NEGLIGIBLE_STRAIN * self.largest_shear_modulus() * size * size
    }
}

/// Says in the log what part of a symmetric body this is, if it is one.
pub fn log_share(body: &Body) {
    let part = match body.planes.len() {
        0 => return,
        1 => "a half",
        2 => "a quarter",
        _ => "an eighth",
    };
    log::info!("{part} of the whole: volumes, energies and forces are those of this part");
}

/// Nodes of one of the bodies, ascending.
pub fn nodes_of(body: &Body, part: usize, space: &FunctionSpace) -> Vec<usize> {
    let (tets, n) = (&body.parts[part].tets, space.nodes_per_element());
    let mut nodes = space.element_nodes()[n * tets.start..n * tets.end].to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
