//! What is known where there is no equilibrium: how far the load came, which
//! element is worst, how soft the body has become, and what to try.

use std::path::Path;

use anyhow::Result;
use mechanics::body::Body;
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::Iterate;
use mechanics::fields::volume_ratios;
use mechanics::forward::{Failure, Problem, Uncertified, Unreached, Workspace};
use mechanics::math::linear;
use mechanics::stability::SoftestMode;
use mechanics::stretch::Stretches;
use mechanics::symmetry::AXES;
use mesh::Vec3;
use mesh::io::vtu::{self, Field};
use reports::{Failed, Pivot, SoftestStiffness, Status, WorstElement};
use scene::Scene;

use crate::report::buckling;
use crate::report::locking::{FIRM, FIRM_ENOUGH, bulk_over_shear};
use crate::report::results::{self, FAILED};

/// Residuals of the failing load step that are reported.
const RESIDUALS: usize = 8;
/// Volume ratio below which the smallest one marks the worst element.
const CRUSHED: f64 = 0.2;
/// Radius ratio below which a rest element counts as badly shaped.
const BAD_SHAPE: f64 = 0.2;
/// A body is about to lose its stability when its compliance to more load is this many
/// times that at rest. A thin neo-Hookean balloon does so 12 % below its largest
/// pressure, where p ~ 1/λ − 1/λ⁷ and dV/dp ~ λ² / (7/λ⁸ − 1/λ²).
const SOFT: f64 = 8.0;

/// A failure, explained.
pub struct Diagnosis {
    /// For people.
    pub message: String,
    /// Whether there are too few supports, or there is no equilibrium.
    pub status: Status,
    /// Why there is none, and what is known of the load step that failed.
    pub failed: Failed,
    grid: vtu::Grid,
}

impl Diagnosis {
    /// Looks at both sides of the load step that failed; factors twice.
    pub fn new(
        scene: &Scene,
        body: &Body,
        (problem, workspace): (&Problem, &mut Workspace),
        unreached: &Unreached,
    ) -> Self {
        let rest = &body.mesh.vertices[..];
        let attempt = &unreached.attempt;
        let (space, next) = (&*problem.space, attempt.time);
        let (multipliers, step) = (&attempt.multipliers, Some(&*attempt.step));
        let (u, time) = (&attempt.reached, unreached.time);
        let at = Iterate { multipliers, step, ..Iterate::new(space, rest, u, time) };
        let force = unbalanced_force(problem, &Iterate { u: &attempt.u, time: next, ..at });
        let worst = worst_element(space, rest, &attempt.u, &force, &unreached.failure);
        let zero = vec![0.0; problem.dofs()];
        let start = Iterate { u: &zero, time: 0.0, ..at };
        let at_rest = SoftestMode::of(problem, workspace, &start, next - time);
        let reached = SoftestMode::of(problem, workspace, &at, next);
        let stretches = Stretches::of(space, rest, u, scene.stretch_limits(body));
        let pivot = reached.pivot.as_ref().map(|found| pivot(found, problem, rest));
        let sides = Sides { scene, problem, rest, unreached, at_rest, reached, worst, pivot };
        let (reason, advice) = (sides.reason(), sides.advice(&stretches));
        let tries = advice.iter().map(|advice| format!("try: {advice}"));
        let lines: Vec<String> =
            [reason.clone()].into_iter().chain(sides.facts()).chain(tries).collect();
        let status = if sides.floats() { Status::NotEnoughSupports } else { Status::NoEquilibrium };
        let grid = grid(&at, &sides.worst, force);
        let softening = sides.softening();
        let Sides { at_rest, reached, worst, pivot, .. } = sides;
        let failure = reports::Failure {
            load_reached: unreached.time,
            load_tried: attempt.time,
            residuals: last(&attempt.residuals).to_vec(),
            worst_element: worst,
            smallest_pivot: pivot,
            softest_stiffness: SoftestStiffness {
                at_rest: at_rest.stiffness,
                reached: reached.stiffness,
            },
            softening,
            advice,
            state: FAILED.to_owned(),
        };
        Self { message: lines.join("\n  "), status, failed: Failed { reason, failure }, grid }
    }

    /// Writes the last equilibrium to [`FAILED`]: cell array `worst_element` is 1
    /// there and 0 elsewhere.
    pub fn write_state(&self, folder: &Path) -> Result<()> {
        Ok(vtu::write_vtu(&folder.join(FAILED), &self.grid)?)
    }
}

/// Both sides of a load step that failed.
struct Sides<'a> {
    scene: &'a Scene,
    problem: &'a Problem,
    rest: &'a [Vec3],
    unreached: &'a Unreached,
    /// The softest mode at rest, and at the last equilibrium.
    at_rest: SoftestMode,
    reached: SoftestMode,
    worst: WorstElement,
    /// The smallest pivot at the last equilibrium, if that is stable.
    pivot: Option<Pivot>,
}

fn last(residuals: &[f64]) -> &[f64] {
    &residuals[residuals.len().saturating_sub(RESIDUALS)..]
}

/// Gradient on the free degrees of freedom [N]; zero where it is not finite.
fn unbalanced_force(problem: &Problem, at: &Iterate) -> Vec<f64> {
    let (gradient, _) = problem.gradient(at);
    let mut force = problem.prolong(&problem.restrict(&gradient));
    force.iter_mut().filter(|f| !f.is_finite()).for_each(|f| *f = 0.0);
    force
}

fn worst_element(
    space: &FunctionSpace,
    rest: &[Vec3],
    u: &[f64],
    force: &[f64],
    failure: &Failure,
) -> WorstElement {
    let n = space.nodes_per_element();
    let nodes = |e: usize| &space.element_nodes()[n * e..n * (e + 1)];
    let ratios: Vec<f64> =
        (0..space.tets().len()).map(|e| smallest_volume_ratio(space, rest, u, e)).collect();
    let (crushed, smallest) =
        ratios.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).expect("there are elements");
    let node = (0..space.node_count())
        .max_by(|&a, &b| at(force, a).norm_squared().total_cmp(&at(force, b).norm_squared()))
        .expect("there are nodes");
    let around = (0..ratios.len()).filter(|&e| nodes(e).contains(&node));
    let strained = around.min_by(|&a, &b| ratios[a].total_cmp(&ratios[b]));
    let (id, ratio) = match failure {
        Failure::Uncertified(Uncertified::Inverted { element, value, .. }) => (*element, *value),
        Failure::Uncertified(Uncertified::Undecided { element, .. }) => {
            (*element, ratios[*element])
        }
        _ if *smallest < CRUSHED => (crushed, *smallest),
        _ => strained.map_or((crushed, *smallest), |e| (e, ratios[e])),
    };
    let [a, b, c, d] = space.tets()[id].map(|v| rest[v]);
    let forces = nodes(id).iter().map(|&i| at(force, i).norm());
    WorstElement {
        id,
        at: ((a + b + c + d) / 4.0).into(),
        volume_ratio: ratio,
        unbalanced_force: forces.fold(0.0, f64::max),
        quality: mesh::measure::radius_ratio(a, b, c, d),
    }
}

/// The element that is inverted most by displacements, and where it is at rest; none where no element is.
pub fn inverted(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Option<String> {
    let each = (0..space.tets().len()).map(|e| (e, smallest_volume_ratio(space, rest, u, e)));
    let (worst, ratio) = each.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let middle = space.tets()[worst].iter().map(|&v| rest[v]).sum::<Vec3>() / 4.0;
    (ratio <= 0.0).then(|| format!("tetrahedron {worst} at {} at rest is inverted", point(&middle)))
}

fn smallest_volume_ratio(space: &FunctionSpace, rest: &[Vec3], u: &[f64], e: usize) -> f64 {
    volume_ratios(space, rest, u, e).into_iter().fold(f64::INFINITY, f64::min)
}

impl Sides<'_> {
    /// Whether the body, or a part of it, moves without any force.
    fn floats(&self) -> bool {
        self.at_rest.floats(bulk_over_shear(self.scene))
    }

    /// Compliance to the loads, relative to that at rest.
    fn softening(&self) -> Option<f64> {
        Some(self.reached.compliance? / self.at_rest.compliance?)
    }

    fn reason(&self) -> String {
        let reached = self.scene.progress(self.unreached.time);
        if !self.floats() {
            return format!("no equilibrium beyond {reached}: {}", self.unreached.failure);
        }
        let (motion, space) = (&self.at_rest.motion, &self.problem.space);
        let length = |i: usize| at(motion, i).norm();
        let node = (0..space.node_count()).max_by(|&a, &b| length(a).total_cmp(&length(b)));
        let node = node.expect("there are nodes");
        let axis = AXES[at(motion, node).iamax()];
        format!(
            "not enough supports: at rest the body, or a part of it, moves without any force, most at \
             {} along {axis}; nothing beyond {reached} can be computed",
            point(&space.node_positions(self.rest)[node])
        )
    }

    fn facts(&self) -> Vec<String> {
        let Self { scene, unreached, worst, .. } = self;
        let residuals: Vec<String> =
            last(&unreached.attempt.residuals).iter().map(|r| format!("{r:.1e}")).collect();
        let mut facts = Vec::new();
        if !residuals.is_empty() {
            facts.push(format!(
                "residuals at {}: {} N",
                scene.progress(unreached.attempt.time),
                residuals.join(", ")
            ));
        }
        facts.push(format!(
            "worst element: tetrahedron {} at {} at rest: volume ratio {:.3}, unbalanced force {:.1e} \
             N, quality {:.2} (regular: 1)",
            worst.id,
            point(&worst.at.into()),
            worst.volume_ratio,
            worst.unbalanced_force,
            worst.quality
        ));
        match (&self.pivot, self.softening()) {
            (Some(Pivot { value, largest, at, .. }), softening) => {
                facts.push(format!(
                    "smallest pivot at {}: {value:.1e} N/m at {}, largest {largest:.1e} N/m",
                    scene.progress(unreached.time),
                    point(&(*at).into())
                ));
                facts.extend(softening.map(|times| {
                    format!("it yields to more load by {times:.1} times what it did at rest")
                }));
            }
            (None, _) => facts.push("that state is not stable".to_owned()),
        }
        facts
    }

    fn advice(&self, stretches: &Stretches) -> Vec<String> {
        let Self { scene, unreached, worst, at_rest, reached, .. } = self;
        let mut advice = Vec::new();
        let settings = &scene.config.solver;
        let ratio = bulk_over_shear(scene);
        if self.floats() {
            advice.push(
                "fix more tags or components; parts that touch in an edge or a vertex only do not \
                 hold each other"
                    .to_owned(),
            );
            return advice;
        }
        if let Some(of_path) = of_path(&unreached.failure) {
            advice.push(of_path.to_owned());
            return advice;
        }
        if ratio > FIRM {
            advice.push(incompressible(ratio));
        }
        if let Failure::Stagnated { residual, scale, .. } = unreached.failure {
            advice.push(format!(
                "set [solver] relative_tolerance = {:.0e}, or absolute_tolerance = {:.0e} N, if that \
                 is accurate enough",
                2.0 * residual / scale,
                2.0 * residual
            ));
            return advice;
        }
        let time = unreached.attempt.time;
        let pressures = scene.config.chamber.iter().filter_map(|c| c.gas.pressure());
        let pressures: Vec<f64> =
            pressures.map(|pressure| scene.config.schedule(pressure).at(time)).collect();
        let pressed = pressures.iter().any(|pressure| *pressure > 0.0);
        let emptied =
            scene.config.contact().is_none() && pressures.iter().any(|pressure| *pressure < 0.0);
        if emptied {
            advice.push(
                "add [contact]: without it the walls of a chamber under vacuum pass through each other"
                    .to_owned(),
            );
        }
        let soft = reached.pivot.is_none() && at_rest.pivot.is_some()
            || self.softening().is_some_and(|times| times > SOFT);
        if soft {
            advice.push(if pressed {
                "the body is about to give way, as a thin wall that balloons: more pressure than this \
                 it may not hold; lower the pressure, thicken the wall, or prescribe the volume of \
                 the chamber instead of its pressure"
                    .to_owned()
            } else {
                let stiffness = at_rest.stiffness.zip(reached.stiffness).map(<[f64; 2]>::from);
                let load = stiffness.and_then(|both| buckling::critical_load(unreached.time, both));
                load.filter(|load| *load > 0.0).map_or_else(
                    || "the body is about to give way (buckling): lower the load".to_owned(),
                    |load| buckling::in_words(scene, load),
                )
            });
        }
        for warning in stretches.warnings() {
            advice.push(format!("a material for larger stretches: {warning}"));
        }
        if worst.volume_ratio < CRUSHED || worst.quality < BAD_SHAPE {
            let shape = if worst.quality < BAD_SHAPE { "badly shaped" } else { "crushed" };
            advice.push(format!(
                "a finer or better mesh at {}: the worst element there is {shape}",
                point(&worst.at.into())
            ));
        }
        if pressed && !soft {
            advice.push("lower the pressure, or thicken the wall".to_owned());
        }
        if emptied {
            return advice;
        }
        advice.push(format!(
            "finer load steps: [solver] smallest_load_step below {:e}, newton_iterations above {}; -v \
             shows every iteration",
            settings.smallest_load_step,
            scene.config.newton_iterations()
        ));
        advice
    }
}

/// What to do where a path that is followed by its arc length cannot go on.
fn of_path(failure: &Failure) -> Option<&'static str> {
    match failure {
        Failure::NoLoad => Some(
            "a load to follow: a [[chamber]] with a pressure or a volume, a [[traction]], [gravity], or a \
             support that moves",
        ),
        Failure::Singular => Some(
            "another number of a load or a wall, by little: the state is one at which several branches meet; \
             or fix what may move freely",
        ),
        Failure::Folded => Some("a finer mesh there, or a higher degree"),
        Failure::Strayed { .. } => Some(
            "smaller arcs: [solver] first_load_step and largest_load_step below what they are, or a smaller \
             smallest_load_step",
        ),
        _ => None,
    }
}

/// Why Newton's method fails in a nearly incompressible body, and what to use.
fn incompressible(bulk_over_shear: f64) -> String {
    format!(
        "a smaller bulk modulus: it is {bulk_over_shear:.1e} times the shear modulus, so nearly \
         incompressible that steps of Newton's method beyond a strain of about {:.0e} change the volume \
         by more than they gain; use {FIRM_ENOUGH}",
        bulk_over_shear.powf(-0.5)
    )
}

fn pivot(found: &linear::Pivot, problem: &Problem, rest: &[Vec3]) -> Pivot {
    let linear::Pivot { value, largest, unknown } = *found;
    let dof = problem.dirichlet.free()[unknown];
    let at = problem.space.node_positions(rest)[dof / 3].into();
    Pivot { value, largest, at, axis: AXES[dof % 3].to_string() }
}

fn grid(at: &Iterate, worst: &WorstElement, force: Vec<f64>) -> vtu::Grid {
    let mut grid = results::grid(at.space, at.rest, at.u);
    let mut marks = vec![0.0; at.space.tets().len()];
    marks[worst.id] = 1.0;
    let quality = at.space.tets().iter().map(|tet| {
        let [a, b, c, d] = tet.map(|v| at.rest[v]);
        mesh::measure::radius_ratio(a, b, c, d)
    });
    grid.cell_fields.push(Field::new("worst_element", "1", 1, marks));
    grid.cell_fields.push(Field::new("quality", "1", 1, quality.collect()));
    grid.point_fields.push(Field::new("unbalanced_force", "N", 3, force));
    grid
}

fn point(p: &Vec3) -> String {
    format!("({:.5}, {:.5}, {:.5}) m", p.x, p.y, p.z)
}
