//! Error bars: what probes, the factors of a limit and of a burst, and the slope of the pressure change by if numbers of the scene are off.
//!
//! To first order, δq = (∂q/∂p) δp for each number p on its own. One sweep of the adjoint per
//! probe q, or the covector of an edge, gives its derivatives by all p, for the run as it is:
//!
//! modulus    all parameters of all laws that are stresses, or of one volume, by one factor  [1]
//! wall       the boundary, or the part with a tag, outward by a distance      [m]
//! pressure   pressure or fill of all chambers, or of one, by a difference     [Pa]
//! density    of all bodies, by one factor                                     [1]
//! membrane   thickness of all sheets, or of one, by a factor                  [1]
//! friction   its coefficient, by a factor                                     [1]
//! a path     one number of the scene, as `solver list --numbers` explains them
//! creep      stresses of materials that are known to creep under a held load  [1]
//! mullins    stresses of materials that are softer after a first stretch      [1]
//!
//! The last two come with the material and go one way: it may be softer than its law. A scene that
//! simulates [`relaxation`](scene::config::RelaxationConfig) of a material has no bar of its creep, one that
//! simulates its [softening](scene::config::MullinsConfig) none of that.
//! The bars of the numbers that a scene states, taken as independent, together make √Σ δq².

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use measure::probe::Probe;
use mechanics::adjoint::{Gradient, ScaledPressure};
use mechanics::energy::Iterate;
use mechanics::forward::{Problem, Trajectory, Workspace};
use program::KeyPath;
use reports::{ErrorBar, ErrorBars};
use scene::Scene;
use scene::config::{Modulus, UncertaintyConfig};

use super::limit::{Edges, configuration, growing};
use super::sensitivity::sensitivities;
use scene::number::{Change, Group, Number, Swept, Walls};

/// The larger of the two changes, without sign.
fn size(bar: &ErrorBar) -> f64 {
    bar.change[0].abs().max(bar.change[1].abs())
}

/// Numbers that may be off together.
struct Off {
    of: String,
    /// Which of them, where it is a part.
    on: Option<String>,
    /// Downward and upward.
    off: [f64; 2],
    group: Group,
}

impl Off {
    fn new(of: &str, on: Option<String>, off: [f64; 2], group: Group) -> Self {
        Self { of: of.to_owned(), on, off, group }
    }

    /// All of them, and one by one.
    fn each(of: &str, off: [f64; 2], all: Group, parts: Vec<(String, Group)>) -> Vec<Self> {
        let parts = parts.into_iter().map(|(on, group)| Self::new(of, Some(on), off, group));
        [Self::new(of, None, off, all)].into_iter().chain(parts).collect()
    }

    /// What a probe changes by.
    fn bar(&self, scene: &Scene, swept: &Swept) -> ErrorBar {
        let per = self.group.start(scene).map_or("1", |(unit, _)| unit);
        let derivative = self.group.derivative(swept, 1.0);
        let change = self.off.map(|off| derivative * off);
        ErrorBar {
            of: self.of.clone(),
            on: self.on.clone(),
            per: per.to_owned(),
            derivative,
            off: self.off,
            change,
        }
    }
}

/// Whether a scene has all numbers that it says may be off.
pub fn check(scene: &Scene) -> Result<()> {
    let Some(config) = &scene.config.uncertainty else { return Ok(()) };
    let context = || scene.path.display().to_string();
    numbers(scene, config).map(drop).with_context(context)
}

/// Error bars of all probes at the end of a run, where the scene asks for them; in the log, too, with why
/// there are none.
pub fn report(
    scene: &Scene,
    solver: (&Problem, &mut Workspace),
    probes: &[Probe],
    run: &Trajectory,
) -> Option<BTreeMap<String, ErrorBars>> {
    let config = scene.config.uncertainty.as_ref().filter(|_| !probes.is_empty())?;
    let found = error_bars(scene, config, solver, probes, run);
    match &found {
        Ok(bars) => {
            log::info!("error bars, to first order:");
            in_words(bars).iter().for_each(|line| log::info!("{line}"));
        }
        Err(why) => log::warn!("no error bars: {why:#}"),
    }
    found.ok()
}

/// Error bars of all probes at the end of a run, by their names.
pub fn error_bars(
    scene: &Scene,
    config: &UncertaintyConfig,
    (problem, workspace): (&Problem, &mut Workspace),
    probes: &[Probe],
    run: &Trajectory,
) -> Result<BTreeMap<String, ErrorBars>> {
    let all = numbers(scene, config)?;
    let walls = Walls::of(all.iter().flat_map(|off| &off.group.numbers), scene)?;
    let each: Vec<&Probe> = probes.iter().collect();
    let found = sensitivities(scene, (problem, workspace), (&each, run, run.steps()))?;
    let mut bars_of = BTreeMap::new();
    for (probe, (value, by)) in probes.iter().zip(found) {
        let swept = Swept::new(scene, problem, walls.as_ref(), &by);
        bars_of.insert(probe.name.clone(), bars(scene, &all, &swept, (value, probe.kind.unit)));
    }
    Ok(bars_of)
}

/// The bars of a value by its derivatives.
fn bars(scene: &Scene, all: &[Off], swept: &Swept, (value, unit): (f64, &str)) -> ErrorBars {
    let bars: Vec<ErrorBar> = all.iter().map(|off| off.bar(scene, swept)).collect();
    let whole = bars.iter().filter(|bar| bar.on.is_none());
    let together = whole.map(|bar| size(bar).powi(2)).sum::<f64>().sqrt();
    ErrorBars { value, unit: unit.to_owned(), together, bars }
}

/// Adds the error bars of the factors of a limit and of a burst, and of the slope, to their report, where the scene asks for them; in the
/// log, too, with why there are none.
pub fn report_edges(scene: &Scene, problem: &Problem, end: &Iterate, edges: &mut Edges) {
    let Some(config) = &scene.config.uncertainty else { return };
    match of_edges(scene, config, problem, end, edges) {
        Ok(bars) => {
            in_words(&bars).iter().for_each(|line| log::info!("limit: {line}"));
            edges.limit.error_bars = bars;
        }
        Err(why) => log::warn!("no error bars of the limit: {why:#}"),
    }
}

/// Error bars of the factors of a limit and of a burst, and of the slope, by their names in the report.
fn of_edges(
    scene: &Scene,
    config: &UncertaintyConfig,
    problem: &Problem,
    end: &Iterate,
    edges: &Edges,
) -> Result<BTreeMap<String, ErrorBars>> {
    let mut bars_of = BTreeMap::new();
    let Some(limit) = &scene.config.limit else { return Ok(bars_of) };
    let all = numbers(scene, config)?;
    let walls = Walls::of(all.iter().flat_map(|off| &off.group.numbers), scene)?;
    let growing = growing(problem, limit);
    let held = &problem.with_scaled_pressures(end.time, &growing);
    let scaled =
        ScaledPressure { problem, held, rest: end.rest, time: end.time, chambers: &growing };
    let mut add = |name: &str, value: f64, by: &Gradient| {
        let swept = Swept::new(scene, problem, walls.as_ref(), by);
        bars_of.insert(name.to_owned(), bars(scene, &all, &swept, (value, "1")));
    };
    if let Some(found) = &edges.at_limit {
        let by = scaled.gradient(&mut Workspace::new(held), found);
        add("factor", found.at.time, &by.context("derivatives of the factor")?);
    }
    if let Some(burst) = &edges.burst {
        add("burst", burst.at.time, &scaled.gradient_of_burst(burst));
    }
    // in contact the tangent jumps, and the slope has no derivative
    if let Some(slope) = edges.slope.as_ref().filter(|_| scene.config.contact().is_none()) {
        let by = scaled.gradient_of_slope(&mut Workspace::new(held), &configuration(end), slope);
        add("slope", slope.value, &by.context("derivatives of the slope")?);
    }
    Ok(bars_of)
}

/// What may be off, as the scene says it and its materials are known.
fn numbers(scene: &Scene, config: &UncertaintyConfig) -> Result<Vec<Off>> {
    let both = |off: f64| [-off, off];
    let mut all = Vec::new();
    if let Some(modulus) = &config.modulus {
        let off = match modulus {
            Modulus::Part(part) => both(*part),
            Modulus::Sources(_) => range_of_sources(scene),
        };
        all.extend(Off::each("modulus", off, Group::modulus(scene, None), by_volume(scene)));
    }
    all.extend(["creep", "mullins"].into_iter().flat_map(|of| softening(scene, of)));
    if let Some(off) = config.pressure {
        let chambers = scene.config.chamber.iter().filter(|c| c.gas.is_pressure());
        let each = chambers.map(|c| (c.name.clone(), Group::pressure(scene, Some(&c.name))));
        let (whole, each) = (Group::pressure(scene, None), if_several(each.collect()));
        all.extend(Off::each("pressure", both(off), whole, each));
    }
    if let Some(off) = config.density {
        all.push(Off::new("density", None, both(off), Group::density(scene, None)));
    }
    if let Some(off) = config.membrane {
        let tags = scene.config.membrane.iter().map(|sheet| &sheet.on);
        let each = tags.map(|on| (on.clone(), Group::membrane(scene, Some(on))));
        let (whole, each) = (Group::membrane(scene, None), if_several(each.collect()));
        all.extend(Off::each("membrane", both(off), whole, each));
    }
    if let Some(off) = config.friction {
        all.push(Off::new("friction", None, both(off), Group::friction(scene)));
    }
    for (path, &off) in &config.numbers {
        let number = Number::find(scene, path).context(KeyPath::table("uncertainty.numbers"))?;
        all.push(Off::new(path, None, both(off), number.into()));
    }
    if let Some(off) = config.wall {
        let tags = scene.body.used_tags();
        let each = tags.map(|tag| (tag.clone(), Group::of_path(scene, &format!("wall.{tag}"))));
        let whole = Group::of_path(scene, "wall");
        all.extend(Off::each("wall", both(off), whole, each.collect()));
    }
    Ok(all)
}

/// One part is the whole.
fn if_several(parts: Vec<(String, Group)>) -> Vec<(String, Group)> {
    if parts.len() > 1 { parts } else { Vec::new() }
}

/// The stresses of each law, where volumes have laws of their own.
fn by_volume(scene: &Scene) -> Vec<(String, Group)> {
    let several = scene.laws.iter().any(|law| law.volume.is_some());
    let laws = scene.laws.iter().enumerate().filter(|_| several);
    laws.map(|(i, law)| (law.name.clone(), Group::modulus_of(scene, i))).collect()
}

/// What materials are softer by than their laws: all that are, by the most of them, and, where
/// volumes have laws of their own, each.
fn softening(scene: &Scene, of: &str) -> Vec<Off> {
    let (mut parts, mut whole) = (Vec::new(), Vec::new());
    let mut most = f64::INFINITY;
    for (i, law) in scene.laws.iter().enumerate() {
        let mut changes = law.material.softening.changes();
        let Some((_, off)) = changes.find(|(known, _)| *known == of) else { continue };
        let config = &scene.config;
        let simulated = if of == "creep" {
            config.relaxation.iter().any(|table| law.is_of(table.on.as_deref()))
        } else {
            config.mullins.iter().any(|table| law.is_of(table.on.as_deref()))
        };
        if simulated {
            continue;
        }
        most = most.min(off);
        let group = Group::modulus_of(scene, i);
        whole.extend(group.numbers.iter().cloned());
        if law.volume.is_some() {
            parts.push(Off::new(of, Some(law.name.clone()), [off, 0.0], group));
        }
    }
    if whole.is_empty() {
        return Vec::new();
    }
    let whole = Group { numbers: whole, change: Change::Factor };
    [Off::new(of, None, [most, 0.0], whole)].into_iter().chain(parts).collect()
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
pub fn in_words(bars: &BTreeMap<String, ErrorBars>) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, ErrorBars { value, unit, together, bars }) in bars {
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        lines.push(format!("{name} {value:.3e}{unit}, together ± {together:.1e}{unit}"));
        let mut sorted: Vec<&ErrorBar> = bars.iter().collect();
        sorted.sort_by(|a, b| size(b).total_cmp(&size(a)));
        for bar in sorted {
            let on = bar.on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
            let (factor, shown) = match &bar.per[..] {
                "1" => (100.0, "%"),
                "m" => (1e3, "mm"),
                other => (1.0, other),
            };
            let [low, high] = bar.off.map(|off| factor * off);
            let [down, up] = bar.change;
            let of = &bar.of;
            lines.push(format!(
                "  {of}{on} {low:+.2}, {high:+.2} {shown}: {down:+.1e}, {up:+.1e}{unit}"
            ));
        }
    }
    lines
}
