//! Error bars: what probes change by if numbers of the scene are off.
//!
//! To first order, δq = (∂q/∂p) δp for each number p on its own. One sweep of the adjoint per
//! probe q gives its derivatives by all p, for the run as it is:
//!
//! modulus    all parameters of all laws that are stresses, or of one volume, by one factor  [1]
//! wall       the boundary, or the part with a tag, outward by a distance      [m]
//! pressure   pressure or fill of all chambers, or of one, by a difference     [Pa]
//! density    of all bodies, by one factor                                     [1]
//! membrane   thickness of all sheets, or of one, by a factor                  [1]
//! friction   its coefficient, by a factor                                     [1]
//! creep      stresses of materials that are known to creep under a held load  [1]
//! mullins    stresses of materials that are softer after a first stretch      [1]
//!
//! The last two come with the material and go one way: it may be softer than its law. A scene that
//! simulates [`relaxation`](crate::config::RelaxationConfig) of a material has no bar of its creep.
//! The bars of the numbers that a scene states, taken as independent, together make √Σ δq².

use std::collections::BTreeMap;

use anyhow::Result;
use serde::Serialize;

use crate::adjoint::Gradient;
use crate::config::{Modulus, UncertaintyConfig};
use crate::energy::ParameterId;
use crate::forward::{Problem, Trajectory, Workspace};
use crate::probe::Probe;
use crate::scene::Scene;
use crate::sensitivity::{Walls, by_density, by_membranes, by_moduli, by_pressures, sensitivities};

/// What a probe changes by.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorBars {
    /// As the probe is.
    pub value: f64,
    /// Of the value and of all changes.
    pub unit: &'static str,
    /// Root of the sum of squares of the bars that are not part of another.
    pub together: f64,
    /// One by one.
    pub bars: Vec<ErrorBar>,
}

/// What one number does to a probe.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorBar {
    /// `modulus`, `creep`, `mullins`, `wall`, `pressure`, `density`, `membrane` or `friction`.
    pub of: &'static str,
    /// Tag of the wall, the chamber or the sheet, or volume, where it is of that alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Unit of the number.
    pub per: &'static str,
    /// ∂q/∂p.
    pub derivative: f64,
    /// How far the number is off, downward and upward.
    pub off: [f64; 2],
    /// What the probe changes by at these, to first order.
    pub change: [f64; 2],
}

impl ErrorBar {
    fn new(of: &'static str, per: &'static str, derivative: f64, off: [f64; 2]) -> Self {
        Self { of, on: None, per, derivative, off, change: off.map(|off| derivative * off) }
    }

    /// The larger of the two changes, without sign.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.change[0].abs().max(self.change[1].abs())
    }
}

/// Error bars of all probes at the end of a run, by their names.
///
/// # Errors
/// When the adjoint system has no accurate solution.
pub fn error_bars(
    scene: &Scene,
    config: &UncertaintyConfig,
    (problem, workspace): (&Problem, &mut Workspace),
    probes: &[Probe],
    run: &Trajectory,
) -> Result<BTreeMap<String, ErrorBars>> {
    let walls = config.wall.map(|off| Ok::<_, anyhow::Error>((Walls::new(&scene.body)?, off)));
    let walls = walls.transpose()?;
    let all: Vec<&Probe> = probes.iter().collect();
    let found = sensitivities(scene, (problem, workspace), (&all, run, run.steps()))?;
    let mut bars_of = BTreeMap::new();
    for (probe, (value, swept)) in probes.iter().zip(found) {
        let mut bars = numbers(scene, config, problem, &swept);
        if let Some((walls, off)) = &walls {
            let bar = |(on, derivative)| ErrorBar {
                on,
                ..ErrorBar::new("wall", "m", derivative, [-off, *off])
            };
            bars.extend(walls.derivatives(&swept.rest).into_iter().map(bar));
        }
        let whole = bars.iter().filter(|bar| bar.on.is_none());
        let together = whole.map(|bar| bar.size().powi(2)).sum::<f64>().sqrt();
        let unit = probe.kind.unit;
        bars_of.insert(probe.name.clone(), ErrorBars { value, unit, together, bars });
    }
    Ok(bars_of)
}

/// Those of the numbers that are no positions.
fn numbers(
    scene: &Scene,
    config: &UncertaintyConfig,
    problem: &Problem,
    swept: &Gradient,
) -> Vec<ErrorBar> {
    let both = |off: f64| [-off, off];
    let mut bars = Vec::new();
    if let Some(modulus) = &config.modulus {
        let off = match modulus {
            Modulus::Part(part) => both(*part),
            Modulus::Sources(_) => range_of_sources(scene),
        };
        let each = by_moduli(scene, swept);
        let all = each.iter().map(|(_, by)| by).sum();
        bars.push(ErrorBar::new("modulus", "1", all, off));
        let several = scene.laws.iter().any(|law| law.volume.is_some());
        let bar = |(on, by)| ErrorBar { on: Some(on), ..ErrorBar::new("modulus", "1", by, off) };
        bars.extend(each.into_iter().filter(|_| several).map(bar));
    }
    bars.extend(["creep", "mullins"].into_iter().flat_map(|of| softening(scene, swept, of)));
    if let Some(off) = config.pressure {
        let each = by_pressures(problem, swept);
        let all = each.iter().map(|(_, by)| by).sum();
        bars.push(ErrorBar::new("pressure", "Pa", all, both(off)));
        let several = each.len() > 1;
        let bar =
            |(on, by)| ErrorBar { on: Some(on), ..ErrorBar::new("pressure", "Pa", by, both(off)) };
        bars.extend(each.into_iter().filter(|_| several).map(bar));
    }
    if let Some(off) = config.density {
        bars.push(ErrorBar::new("density", "1", by_density(scene, swept), both(off)));
    }
    if let Some(off) = config.membrane {
        let each = by_membranes(scene, swept);
        let all = each.iter().map(|(_, by)| by).sum();
        bars.push(ErrorBar::new("membrane", "1", all, both(off)));
        let several = each.len() > 1;
        let bar =
            |(on, by)| ErrorBar { on: Some(on), ..ErrorBar::new("membrane", "1", by, both(off)) };
        bars.extend(each.into_iter().filter(|_| several).map(bar));
    }
    if let (Some(off), Some(contact)) = (config.friction, scene.config.contact()) {
        let by: f64 = swept.parameters.total(ParameterId::Friction).iter().sum();
        bars.push(ErrorBar::new("friction", "1", by * contact.friction, both(off)));
    }
    bars
}

/// Bars of what materials are softer by than their laws: of all that are, by the most of them, and,
/// where volumes have laws of their own, of each.
fn softening(scene: &Scene, swept: &Gradient, of: &'static str) -> Vec<ErrorBar> {
    let by_laws = scene.laws.iter().zip(by_moduli(scene, swept));
    let soft = by_laws.filter(|(law, _)| of != "creep" || law.branches.is_empty());
    let soft = soft.filter_map(|(law, (name, by))| {
        let (_, off) = law.material.softening.changes().find(|(known, _)| *known == of)?;
        Some((law.volume.is_some().then_some(name), by, off))
    });
    let soft: Vec<_> = soft.collect();
    let Some(most) = soft.iter().map(|(.., off)| *off).reduce(f64::min) else { return Vec::new() };
    let all = ErrorBar::new(of, "1", soft.iter().map(|(_, by, _)| by).sum(), [most, 0.0]);
    let each = soft.into_iter().filter(|(on, ..)| on.is_some());
    let each = each.map(|(on, by, off)| ErrorBar { on, ..ErrorBar::new(of, "1", by, [off, 0.0]) });
    [all].into_iter().chain(each).collect()
}

/// From the least to the largest shear modulus of all sources, over that of the scene, less 1;
/// the widest of several silicones.
fn range_of_sources(scene: &Scene) -> [f64; 2] {
    let mut off = [0.0_f64; 2];
    for named in scene.laws.iter().filter_map(|law| law.config.silicone()) {
        let [low, high] = named.silicone.entry.shear_moduli();
        let own = named.fit.entry.shear_modulus;
        off = [off[0].min(low / own - 1.0), off[1].max(high / own - 1.0)];
    }
    off
}

/// The bars in lines of text, the largest first, for each probe.
#[must_use]
pub fn in_words(bars: &BTreeMap<String, ErrorBars>) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, ErrorBars { value, unit, together, bars }) in bars {
        lines.push(format!("{name} {value:.3e} {unit}, together ± {together:.1e} {unit}"));
        let mut sorted: Vec<&ErrorBar> = bars.iter().collect();
        sorted.sort_by(|a, b| b.size().total_cmp(&a.size()));
        for bar in sorted {
            let on = bar.on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
            let (factor, shown) = match bar.per {
                "1" => (100.0, "%"),
                "m" => (1e3, "mm"),
                other => (1.0, other),
            };
            let [low, high] = bar.off.map(|off| factor * off);
            let [down, up] = bar.change;
            let of = bar.of;
            lines.push(format!(
                "  {of}{on} {low:+.2}, {high:+.2} {shown}: {down:+.1e}, {up:+.1e} {unit}"
            ));
        }
    }
    lines
}
