//! From config and files to objects: bodies, problems, probes and objectives. The terms of a problem are those of rooms.

mod assembly;
mod afloat;
mod objectives;
mod probes;
mod progress;

pub use objectives::{ObjectiveBuilder, Weighted};

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Elastic, Energies, Inertia, Term};
use mechanics::forward::{Growth, Integrator, Newton, Problem, State, Stepping, Workspace};
use mechanics::stability::ArcLength;
use mechanics::stretch::Limits;
use mechanics::symmetry::{AXES, Plane};
use program::{KeyPath, Settings};

use crate::config::{
    BodyConfig, Dilatation, InsideOut, LevelConfig, LevelTime, SimConfig, TimeConfig,
};
use crate::meaning::cut;
use crate::memory;
use crate::supports::{Support, Supports};
use crate::term::material::{SceneLaw, largest_shear_modulus};
use crate::term::{Ground, Stage, chamber, nodes_of, rigid};

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

    /// How far each material may be stretched, as far as it is known, on a body with the volumes of the scene.
    pub fn stretch_limits(&self, body: &Body) -> Vec<Limits> {
        let one = |law: &SceneLaw| Limits {
            name: if self.laws.len() > 1 { law.name.clone() } else { String::new() },
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
        let ground = self.ground(body, (&space, &supports), None).with_context(context)?;
        let energies = self.energies(&ground).with_context(context)?;
        let multipliers = chamber::multipliers(&energies, &ground);
        let rigid = ground.rigid;
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
            let moments = self.config.values().moments();
            let supports = Supports::new(&self.fixed(body), &moments, body, space)?;
            if !self.config.may_float() {
                supports.check_rigid_motions(space)?;
            }
            Ok::<_, anyhow::Error>(supports)
        };
        supports().with_context(|| self.path.display().to_string())
    }

    /// All supports of a body: those of the scene, then those in planes of symmetry, then those of terms.
    fn fixed(&self, body: &Body) -> Vec<Support> {
        let held = |plane: &Plane| {
            let axes = std::array::from_fn(|axis| axis == plane.axis);
            let still = plane.tags.iter().map(|tag| Support::still(tag, axes));
            still.collect::<Vec<_>>()
        };
        let own = self.config.fixed.iter().map(|fixed| Support {
            on: fixed.on.clone(),
            axes: fixed.axes(),
            displacement: self.config.field(&fixed.displacement),
        });
        let of_terms = self.config.rooms().into_iter().flat_map(|room| room.supports(body));
        own.chain(body.planes.iter().flat_map(held)).chain(of_terms).collect()
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

    /// What the terms stand on; `last` are those of the same scene with other numbers.
    fn ground<'a>(
        &'a self,
        body: &'a Body,
        (space, supports): (&'a FunctionSpace, &'a Supports),
        last: Option<&'a Energies>,
    ) -> Result<Ground<'a>> {
        let mut ground = Ground {
            path: &self.path,
            around: self.config.around(),
            rooms: self.config.rooms(),
            obstacles: &self.config.obstacle,
            surfaces: self.surface_names(),
            own_shape: &self.body.mesh.vertices,
            body,
            space,
            supports,
            laws: &self.laws,
            rigid: Vec::new(),
            certify: self.certify,
            last,
        };
        ground.rigid = rigid::sets(&self.config.rigid, &ground)?;
        Ok(ground)
    }

    /// The terms of the potential energy: for each law its elastic energy and what stands beside it, then those of rooms.
    fn energies(&self, ground: &Ground) -> Result<Energies> {
        let Ground { body, space, rooms, .. } = ground;
        let mut energies = Energies::default();
        for (place, law) in self.laws.iter().enumerate() {
            let elastic = self.elastic(law, law.elements(body))?;
            energies.extend([Term::of(Elastic::owner(place), elastic)]);
            for room in rooms {
                let beside = room.beside(place, ground, energies.internal_count(space))?;
                energies.extend(beside);
            }
        }
        for stage in [Stage::Body, Stage::Load, Stage::Part] {
            for room in rooms.iter().filter(|room| room.about().stage == stage) {
                energies.extend(room.build(ground, energies.internal_count(space))?);
            }
            if stage == Stage::Body {
                energies.extend(self.inertia(ground)?);
            }
        }
        self.check_velocities(body)?;
        Ok(energies)
    }

    /// The terms of a problem with the numbers of this scene. Supports are those of the problem.
    pub fn energies_like(&self, body: &Body, problem: &Problem) -> Result<Energies> {
        let space = &*problem.space;
        let supports = self.supports(body, space)?;
        self.energies(&self.ground(body, (space, &supports), Some(&problem.energies))?)
    }

    /// Whether all laws can have what stands beside them, and the dilatation of the scene.
    fn check_laws(&self) -> Result<()> {
        self.config.rooms().into_iter().try_for_each(|room| room.check_laws(&self.laws))?;
        self.laws.iter().try_for_each(|law| self.elastic(law, 0..0).map(drop))
    }

    /// The elastic energy of a law on some elements.
    fn elastic(&self, law: &SceneLaw, elements: Range<usize>) -> Result<Elastic> {
        let mean = self.config.solver.dilatation == Dilatation::Mean;
        law.elastic(elements, mean, rigid::shear_modulus(&self.laws))
    }

    /// The law whose shear modulus is the stiffness of `[contact]`, where the scene gives none: the first of the stiffest.
    pub fn law_of_contact(&self) -> Option<usize> {
        let largest = largest_shear_modulus(&self.laws);
        let stiffest = || self.laws.iter().position(|law| law.shear_modulus() == largest);
        self.config.contact().filter(|own| own.stiffness.is_none()).and_then(|_| stiffest())
    }

    /// The inertia of all laws, or the tiny mass of bodies that are loose.
    fn inertia(&self, ground: &Ground) -> Result<Vec<Term>> {
        let Ground { body, space, supports, .. } = ground;
        let mut terms = Vec::new();
        for (place, law) in self.laws.iter().enumerate() {
            let tets = law.elements(body);
            let inertia = if self.config.method().has_inertia() {
                Inertia::new(space, law.density(self.config.method())?, tets)
            } else if supports.leave_loose(space, &body.parts[law.part].vertices) {
                Inertia::tiny(space, law.material.density.unwrap_or(WATER), tets)
            } else {
                continue;
            };
            terms.push(Term::of(Inertia::owner(place), inertia));
        }
        Ok(terms)
    }

    /// Velocities must not point across a plane of symmetry.
    fn check_velocities(&self, body: &Body) -> Result<()> {
        for plane in &body.planes {
            for (part, own) in self.parts.iter().zip(&body.parts) {
                let is_cut = plane.vertices().iter().any(|v| own.vertices.contains(v));
                let v = part.config.velocity[plane.axis];
                ensure!(
                    !is_cut || v == 0.0,
                    cut(&plane.tags).told(format!(
                        "{}: the velocity of \"{}\" is {v} m/s along {}, across the plane {}; its mirror \
                         image would part from it: expected 0",
                        plane.title(),
                        part.config.name,
                        AXES[plane.axis],
                        plane.equation()
                    ))
                );
            }
        }
        Ok(())
    }

    /// Names of all surfaces that may touch: bodies, then obstacles.
    pub fn surface_names(&self) -> Vec<&str> {
        let bodies = self.parts.iter().map(|part| &part.config.name[..]);
        bodies.chain(self.config.obstacle.iter().map(|o| &o.name[..])).collect()
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
        NEGLIGIBLE_STRAIN * largest_shear_modulus(&self.laws) * size * size
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
