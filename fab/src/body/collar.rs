//! A collar of silicone around each inlet that holds a tube.
//!
//! It is cast with the body and is no part of the design: with the design's filled part F
//! and cores C, cylinders O around the inlets' axes and narrower ones B along them,
//!
//! filled part = F ∪ O,   core = C ∪ B,   what is cast = (F ∪ O) − C − B.
//!
//! O reaches into the body by a root, so that an uneven seat leaves no gap. B is narrower
//! than the tube, which therefore seals.

use anyhow::{Result, ensure};
use geometry::frame::Frame;
use geometry::{MM, place};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::boundary::{Boundary, CoreBoundary, Inlet};
use crate::body::layout;
use crate::config::Config;
use crate::config::fitting::Tube;

/// Sides of a collar: so many that a turn about its axis moves its surface by less than
/// R (1 − cos π/n), a micrometre at R = 7 mm.
const SIDES: usize = 192;

/// How far collar and bore reach into the body beyond what its rim is uneven [m].
const ROOT: f64 = 2e-4;

/// Part of a collar's end that must lie on the body: a judgement [1].
const HELD: f64 = 0.5;

/// A collar, from its free end into the body; in any unit of length.
#[derive(Clone, Debug, PartialEq)]
pub struct Collar {
    /// Middle of its free end.
    pub base: Vec3,
    /// From there to the end of its root.
    pub axis: Vec3,
    /// Radius of its outside.
    pub radius: f64,
    /// Radius of its bore.
    pub bore: f64,
    /// How far it stands out of the body.
    pub length: f64,
}

/// A collar as mold.json has it, and its tube.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FittedTube {
    /// What to ask for.
    pub tube: String,
    /// Outer diameter of the tube [mm].
    pub outer: f64,
    /// Inner diameter of the tube [mm].
    pub inner: f64,
    /// Where these come from.
    pub source: String,
    /// Middle of the collar's free end in the mold [mm].
    pub base: [f64; 3],
    /// From there to the end of its root in the body [mm].
    pub axis: [f64; 3],
    /// Radius of its outside in the mold [mm].
    pub radius: f64,
    /// Radius of its bore in the mold [mm].
    pub bore: f64,
    /// How far it stands out of the body in the mold [mm].
    pub length: f64,
}

/// The boundary with a collar around every inlet, and the collars in the design's metres;
/// unchanged if no tube is asked for.
pub fn fit(boundary: Boundary, config: &Config) -> Result<(Boundary, Vec<Collar>)> {
    let Some(fitting) = &config.fitting else { return Ok((boundary, Vec::new())) };
    ensure!(
        !boundary.cores.is_empty(),
        "[fitting]: the body has no chamber for a tube; leave [fitting] out"
    );
    ensure!(
        boundary.cores.iter().all(|core| !core.inlets.is_empty()),
        "[fitting]: a chamber is closed and has no inlet for a tube; leave [fitting] out"
    );
    let tube = fitting.tube().map_err(anyhow::Error::msg)?;
    let up = layout::up(&boundary, config);
    let filled = Solid::from_surface(&boundary.filled)?;
    let (mut collars, mut cores, mut solids) = (Vec::new(), Vec::new(), Vec::new());
    for core in &boundary.cores {
        let mut solid = Solid::from_surface(&core.surface)?;
        let mut inlets = Vec::new();
        for inlet in &core.inlets {
            let bore = fitting.bore(&tube);
            let covers = inlet.reach + config.casting.least_wall;
            let radius = covers.max(bore + fitting.wall);
            let length = fitting.length(&tube);
            let inward = layout::inward(inlet, up);
            let axis = inward * (length + inlet.deviation + ROOT);
            let base = inlet.centre - inward * length;
            let collar = Collar { base, axis, radius, bore, length };
            collar.require_held(inlet, &filled)?;
            solid = solid.union(&collar.bore());
            inlets.push(collar.inlet(&inward));
            collars.push(collar);
        }
        let (chamber, surface) = (core.chamber.clone(), solid.to_surface());
        cores.push(CoreBoundary { chamber, surface, inlets });
        solids.push(solid);
    }
    let (filled, cast) = body(&filled, &solids, &collars);
    let (filled, cast) = (filled.to_surface(), cast.to_surface());
    Ok((Boundary { filled, cast, plain: None, cores, ..boundary }, collars))
}

/// A filled part with its collars, and what is cast of it around the cores.
pub fn body(filled: &Solid, cores: &[Solid], collars: &[Collar]) -> (Solid, Solid) {
    let filled = collars.iter().fold(filled.clone(), |all, collar| all.union(&collar.outside()));
    let cast = cores.iter().fold(filled.clone(), |rest, core| rest.difference(core));
    let cast = collars.iter().fold(cast, |rest, collar| rest.difference(&collar.through()));
    (filled, cast)
}

impl Collar {
    fn cylinder(base: Vec3, axis: Vec3, radius: f64) -> Solid {
        Solid::cylinder(&base, &axis, radius, radius, SIDES)
    }

    /// All within its outside.
    pub fn outside(&self) -> Solid {
        Self::cylinder(self.base, self.axis, self.radius)
    }

    /// What fills its bore.
    pub fn bore(&self) -> Solid {
        Self::cylinder(self.base, self.axis, self.bore)
    }

    /// The bore and a bit beyond its free end, so that no faces coincide.
    fn through(&self) -> Solid {
        let beyond = self.axis * 0.1;
        Self::cylinder(self.base - beyond, self.axis + beyond, self.bore)
    }

    /// A slice of its outside, from a part of its length to another.
    pub fn slice(&self, from: f64, to: f64) -> Solid {
        let along = self.axis.normalize() * self.length;
        Self::cylinder(self.base + along * from, along * (to - from), 2.0 * self.radius)
    }

    /// The bore as an inlet.
    fn inlet(&self, inward: &Vec3) -> Inlet {
        let half = std::f64::consts::PI / SIDES as f64;
        Inlet {
            centre: self.base,
            radius: self.bore * half.cos(),
            reach: self.bore,
            normal: -inward,
            deviation: 0.0,
            girth: 2.0 * SIDES as f64 * self.bore * half.sin(),
            cap: SurfaceMesh::default(),
        }
    }

    /// Whether its end lies on the body.
    fn require_held(&self, inlet: &Inlet, filled: &Solid) -> Result<()> {
        let thin = self.axis.normalize() * (ROOT / 2.0);
        let end = Self::cylinder(self.base + self.axis - thin, thin, self.radius);
        let part = end.intersection(filled).volume() / end.volume();
        let at = place(&inlet.centre, 2);
        ensure!(
            part >= HELD,
            "[fitting]: a collar of {:.1} mm around the inlet at {at} lies on the body with {:.0} % of its \
             end, at least {:.0} % are needed: choose a thinner tube or reduce fitting.wall",
            2.0 * self.radius * MM,
            100.0 * part,
            100.0 * HELD
        );
        Ok(())
    }

    /// For mold.json, in the millimetres of a mold.
    pub fn fitted_tube(&self, tube: &Tube, frame: &Frame) -> FittedTube {
        let scale = frame.scale * MM;
        FittedTube {
            tube: tube.name.clone(),
            outer: tube.outer * MM,
            inner: tube.inner * MM,
            source: tube.source.clone(),
            base: (frame.point(&self.base) * MM).into(),
            axis: (frame.rotation * self.axis * scale).into(),
            radius: self.radius * scale,
            bore: self.bore * scale,
            length: self.length * scale,
        }
    }
}

impl FittedTube {
    /// The collar in the millimetres of the mold.
    pub fn collar(&self) -> Collar {
        let Self { base, axis, radius, bore, length, .. } = self;
        let [base, axis] = [base, axis].map(|v| Vec3::from(*v));
        Collar { base, axis, radius: *radius, bore: *bore, length: *length }
    }
}
