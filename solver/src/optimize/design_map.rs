//! From design variables to what is simulated: rest shape and pressures.
//!
//! X(θ) = X₀ + 𝓔 (patches(θ) − X₀ on the moving surface), with 𝓔 the extension into
//! the interior, so that the gradient is that of what is simulated. The variables of
//! the patches come first, one after the other, then those of the pressures; all are
//! metres.

use anyhow::{Result, ensure};
use mesh::Vec3;

use crate::body::Body;
use crate::config::{DesignConfig, Interior, LevelConfig, PressureDesign};
use crate::design::{Extension, Patch, PressureCurve};
use crate::element::at;
use crate::energy::{Chamber, GasLaw};
use crate::forward::System;
use crate::scene::Scene;
use crate::schedule::Schedule;

/// The map of one level.
pub struct DesignMap {
    /// Rest vertices at θ = 0 [m].
    rest: Vec<Vec3>,
    patches: Vec<Patch>,
    /// None where nothing moves.
    extension: Option<Extension>,
    interior: Interior,
    controls: Vec<Control>,
    /// All facets that move.
    moving: Vec<[usize; 3]>,
    mean_edge: f64,
}

/// A pressure that the design sets.
struct Control {
    /// Tag of the wall.
    on: String,
    /// Index among the energies.
    energy: usize,
    curve: PressureCurve,
    times: Vec<f64>,
    chamber: Chamber,
    /// Largest change of a variable in one iteration.
    change: f64,
}

impl DesignMap {
    /// The map of one level on a body.
    ///
    /// # Errors
    /// When a tag is missing or the handles cannot be placed.
    pub fn new(
        scene: &Scene,
        design: &DesignConfig,
        level: &LevelConfig,
        body: &Body,
        system: &System,
    ) -> Result<Self> {
        let rest = body.mesh.vertices.clone();
        let (mut patches, mut moving) = (Vec::new(), Vec::new());
        for on in design.shape.iter().flat_map(|shape| shape.on.all()) {
            let facets = body.facets(on)?;
            patches.push(Patch::new(&rest, &facets, level.handles)?);
            moving.extend(facets);
        }
        check_apart(&patches)?;
        let edges = if moving.is_empty() { body.boundary() } else { &moving };
        let mean_edge = mesh::measure::mean_edge(&rest, edges);
        let extension = if moving.is_empty() { None } else { Some(Extension::new(&body.mesh)?) };
        let interior = design.shape.as_ref().map_or(Interior::default(), |shape| shape.interior);
        let controls = controls(scene, &design.pressure, body, system, mean_edge)?;
        Ok(Self { rest, patches, extension, interior, controls, moving, mean_edge })
    }

    /// Number of design variables.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.shape_variables() + self.controls.iter().map(|c| c.curve.variables()).sum::<usize>()
    }

    /// Number of those of the shape, which come first.
    #[must_use]
    pub fn shape_variables(&self) -> usize {
        self.patches.iter().map(Patch::variables).sum()
    }

    /// Facets that move.
    #[must_use]
    pub fn moving(&self) -> &[[usize; 3]] {
        &self.moving
    }

    /// Mean edge length of the moving surface, of the whole boundary if none moves
    /// [m].
    #[must_use]
    pub fn mean_edge(&self) -> f64 {
        self.mean_edge
    }

    /// Each patch with its variables.
    fn each_patch<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a Patch, &'a [f64])> + 'a {
        let mut rest = theta;
        self.patches.iter().map(move |patch| {
            let (own, others) = rest.split_at(patch.variables());
            rest = others;
            (patch, own)
        })
    }

    /// Each pressure with its variables.
    fn each_control<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a Control, &'a [f64])> + 'a {
        let mut rest = &theta[self.shape_variables()..];
        self.controls.iter().map(move |control| {
            let (own, others) = rest.split_at(control.curve.variables());
            rest = others;
            (control, own)
        })
    }

    /// Rest vertex positions with the moving surface at θ and all others at θ = 0 [m].
    #[must_use]
    pub fn surface(&self, theta: &[f64]) -> Vec<Vec3> {
        let mut moved = self.rest.clone();
        for (patch, own) in self.each_patch(theta) {
            for (&v, x) in patch.vertices().iter().zip(patch.apply(own, &self.rest)) {
                moved[v] = x;
            }
        }
        moved
    }

    /// Rest vertex positions X(θ) [m].
    #[must_use]
    pub fn shape(&self, theta: &[f64]) -> Vec<Vec3> {
        let Some(extension) = &self.extension else { return self.rest.clone() };
        let moved = self.surface(theta);
        let mut displacement: Vec<Vec3> =
            moved.iter().zip(&self.rest).map(|(x, rest)| x - rest).collect();
        extension.apply(&mut displacement);
        self.rest.iter().zip(displacement).map(|(x, d)| x + d).collect()
    }

    /// Gives the system the pressures of θ.
    pub fn set_pressures(&self, theta: &[f64], system: &mut System) {
        for (control, own) in self.each_control(theta) {
            let values = control.curve.values(own);
            let pressure = Schedule::table(&control.times, &values)
                .expect("times of the scene, and finite values");
            let wall = control.chamber.wall.clone();
            let gas = GasLaw::Isobaric { pressure };
            system.energies[control.energy] = Box::new(Chamber { wall, gas });
        }
    }

    /// Tag and pressures P_0, …, P_N of each control [Pa].
    #[must_use]
    pub fn pressures(&self, theta: &[f64]) -> Vec<(String, Vec<f64>)> {
        let one = |(c, own): (&Control, &[f64])| (c.on.clone(), c.curve.values(own));
        self.each_control(theta).map(one).collect()
    }

    /// Largest motion of a vertex from θ = a to θ = b [m].
    #[must_use]
    pub fn vertex_motion(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        for ((patch, a), (_, b)) in self.each_patch(a).zip(self.each_patch(b)) {
            let (a, b) = (patch.apply(a, &self.rest), patch.apply(b, &self.rest));
            largest = a.iter().zip(&b).map(|(a, b)| (a - b).norm()).fold(largest, f64::max);
        }
        largest
    }

    /// The same, or the equivalent in a variable of a pressure if that is larger [m].
    #[must_use]
    pub fn motion(&self, a: &[f64], b: &[f64]) -> f64 {
        let largest = self.vertex_motion(a, b);
        let from = self.shape_variables();
        let pressures = a[from..].iter().zip(&b[from..]).map(|(a, b)| (a - b).abs());
        pressures.fold(largest, f64::max)
    }

    /// dJ/dθ from dJ/dX, three components per vertex, and dJ/dp, for each step and
    /// energy.
    #[must_use]
    pub fn pull_back(
        &self,
        theta: &[f64],
        by_rest: &[f64],
        by_parameters: &[Vec<Vec<f64>>],
    ) -> Vec<f64> {
        let mut gradient = Vec::with_capacity(self.variables());
        let mut bar: Vec<Vec3> = (0..self.rest.len()).map(|v| at(by_rest, v)).collect();
        if let (Some(extension), Interior::Extended) = (&self.extension, self.interior) {
            extension.pull_back(&mut bar);
        }
        for (patch, own) in self.each_patch(theta) {
            let on_patch: Vec<Vec3> = patch.vertices().iter().map(|&v| bar[v]).collect();
            gradient.extend(patch.pull_back(own, &self.rest, &on_patch));
        }
        for control in &self.controls {
            let by: Vec<f64> = by_parameters.iter().map(|step| step[control.energy][0]).collect();
            gradient.extend(control.curve.pull_back(&by));
        }
        gradient
    }

    /// dJ/dX of the boundary when the interior follows it, three components per
    /// vertex, zero inside; as it is where nothing moves.
    #[must_use]
    pub fn on_boundary(&self, by_rest: &[f64]) -> Vec<f64> {
        let mut bar: Vec<Vec3> = (0..self.rest.len()).map(|v| at(by_rest, v)).collect();
        if let Some(extension) = &self.extension {
            extension.pull_back(&mut bar);
        }
        bar.iter().flat_map(|b| [b.x, b.y, b.z]).collect()
    }

    /// Smallest and largest value of each variable in an iteration from θ; none where
    /// nothing is bounded.
    #[must_use]
    pub fn bounds(&self, theta: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        if self.controls.is_empty() {
            return None;
        }
        let free = self.shape_variables();
        let mut lower = vec![f64::NEG_INFINITY; free];
        let mut upper = vec![f64::INFINITY; free];
        for (control, own) in self.each_control(theta) {
            for ([low, high], y) in control.curve.bounds().into_iter().zip(own) {
                lower.push(low.max(y - control.change));
                upper.push(high.min(y + control.change));
            }
        }
        Some((lower, upper))
    }
}

/// Patches may share vertices only on their rims.
fn check_apart(patches: &[Patch]) -> Result<()> {
    for (i, a) in patches.iter().enumerate() {
        for b in &patches[..i] {
            let shared = a.vertices().iter().filter(|v| b.vertices().binary_search(v).is_ok());
            let count = shared.count();
            let rims = matches!((a, b), (Patch::Handles(_), Patch::Handles(_)));
            ensure!(
                count == 0 || rims,
                "[shape] on: two tags share {count} vertices off their rims; needed are tags \
                 whose facets are apart"
            );
        }
    }
    Ok(())
}

fn controls(
    scene: &Scene,
    configs: &[PressureDesign],
    body: &Body,
    system: &System,
    edge: f64,
) -> Result<Vec<Control>> {
    if configs.is_empty() {
        return Ok(Vec::new());
    }
    let named = (0..).zip(&system.energies).filter(|(_, e)| e.name() == "pressure");
    let energies: Vec<usize> = named.map(|(i, _)| i).collect();
    let chambers = scene.chambers(body, &system.space)?;
    let times: Vec<f64> = [0.0].into_iter().chain(scene.times()).collect();
    let mut controls: Vec<Control> = Vec::new();
    for config in configs {
        let found = chambers.iter().zip(&energies).find(|((on, _), _)| *on == config.on);
        let Some(((_, chamber), &energy)) = found else {
            anyhow::bail!("[[pressure]] on \"{}\": the scene has no [[pressure]] there", config.on);
        };
        let GasLaw::Isobaric { pressure } = &chamber.gas else {
            anyhow::bail!(
                "[[pressure]] on \"{}\": the scene has a closed chamber there; needed is a \
                 [[pressure]]",
                config.on
            );
        };
        ensure!(
            controls.iter().all(|c| c.energy != energy),
            "[[pressure]] on \"{}\" is there twice",
            config.on
        );
        let values: Vec<f64> = times.iter().map(|&t| pressure.at(t)).collect();
        let [low, high] = config.slope;
        let reach = low.abs().max(high.abs()) * times[times.len() - 1];
        let scale = values.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        let scale = if scale > 0.0 { scale } else { reach };
        let curve = PressureCurve::new(&times, &values, config.slope, scale, edge);
        for (n, [low, high]) in curve.bounds().into_iter().enumerate() {
            ensure!(
                low <= 1e-9 * (high - low) && high >= -1e-9 * (high - low),
                "[[pressure]] on \"{}\": in time step {} the scene's pressure has a slope of \
                 {:.4e} Pa/s, which slope = {:?} Pa/s does not allow",
                config.on,
                n + 1,
                (values[n + 1] - values[n]) / (times[n + 1] - times[n]),
                config.slope
            );
        }
        let change = config.change.map_or(f64::INFINITY, |c| curve.variable_change(c));
        let gas = GasLaw::Isobaric { pressure: pressure.clone() };
        let chamber = Chamber { wall: chamber.wall.clone(), gas };
        let on = config.on.clone();
        controls.push(Control { on, energy, curve, times: times.clone(), chamber, change });
    }
    Ok(controls)
}
