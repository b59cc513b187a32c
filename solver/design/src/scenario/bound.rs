//! What the end of a run keeps: numbers c that are to be 0 or more.
//!
//! c = s (q − b)
//!
//! q   a probe of the scene, in its unit, or the slope of the pressure [1]
//! b   the bound, s = 1 of a smallest value, −1 of a largest one

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::forward::Problem;
use program::{KeyPath, misfit};
use scene::config::DesignConfig;
use scene::{Scene, Weighted};

/// Tolerance of a bound over its size.
const TOLERANCE: f64 = 1e-3;

/// A bound of a number at the end of a run.
pub struct Bound {
    /// As reports call it.
    pub name: String,
    /// Unit of the number.
    pub unit: &'static str,
    /// b.
    pub value: f64,
    /// Whether it is the smallest value; else it is the largest.
    pub is_least: bool,
    /// s q, the probe; none of the slope.
    probe: Option<Weighted>,
}

impl Bound {
    /// The bounds of a design on a body.
    pub(super) fn all(
        design: &DesignConfig,
        scene: &Scene,
        body: &Body,
        problem: &Problem,
    ) -> Result<Vec<Self>> {
        let of_slope = design.constraint.iter().filter_map(|kept| {
            let (value, name) = (kept.slope()?.least, kept.name().to_owned());
            Some(Self { name, unit: "1", value, is_least: true, probe: None })
        });
        let mut all: Vec<Self> = of_slope.collect();
        let of_probes = design.constraint.iter().filter_map(|kept| Some((kept, kept.bound()?)));
        for (config, bound) in of_probes {
            let probes = scene.probes(body, &problem.space)?;
            let known: Vec<&str> = probes.iter().map(|probe| probe.name.as_str()).collect();
            ensure!(
                known.contains(&bound.probe.as_str()),
                misfit!(
                    config.title().key("probe"),
                    " = \"{}\": no [[probe]] of the scene is called that; there are: {}",
                    bound.probe,
                    known.join(", ")
                )
            );
            let found = probes.iter().find(|probe| probe.name == bound.probe);
            let sides = [(true, bound.least), (false, bound.most)];
            let both = bound.least.is_some() && bound.most.is_some();
            for (probe, (is_least, value)) in found.into_iter().flat_map(|p| sides.map(|s| (p, s)))
            {
                let Some(value) = value else { continue };
                let side = if is_least { "least" } else { "most" };
                let name = match both {
                    true => format!("{} {side}", config.name()),
                    false => config.name().to_owned(),
                };
                let weighted = Weighted {
                    name: name.clone(),
                    weight: if is_least { 1.0 } else { -1.0 },
                    factor: 1.0,
                    factors: at_the_end(scene),
                    quantity: probe.quantity.clone(),
                };
                let (unit, probe) = (probe.kind.unit, Some(weighted));
                all.push(Self { name, unit, value, is_least, probe });
            }
        }
        Ok(all)
    }

    /// Whether it is that of the slope of the pressure.
    pub fn is_slope(&self) -> bool {
        self.probe.is_none()
    }

    /// Its probe, times s, as a term at the end; none of the slope.
    pub(super) fn probe(&self) -> Option<&Weighted> {
        self.probe.as_ref()
    }

    /// c.
    pub fn kept(&self, number: f64) -> f64 {
        if self.is_least { number - self.value } else { self.value - number }
    }

    /// q, of c.
    pub fn number(&self, kept: f64) -> f64 {
        if self.is_least { self.value + kept } else { self.value - kept }
    }

    /// How far c may be below 0 at the end.
    pub fn tolerance(&self) -> f64 {
        TOLERANCE * self.size()
    }

    /// By what a violation is measured, in the unit of the number.
    pub fn size(&self) -> f64 {
        if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }

    /// Where it is written.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("constraint").named(&self.name)
    }
}

/// One at the end of a run, and nothing before.
fn at_the_end(scene: &Scene) -> Vec<f64> {
    let steps = scene.times().len();
    (0..=steps).map(|n| if n == steps { 1.0 } else { 0.0 }).collect()
}
