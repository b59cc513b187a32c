//! How a body is molded: what is measured, which method, pull and parting surface follow, and why.

pub mod gluing;
pub mod pull;
pub mod report;
mod sides;
pub mod undercut;
mod verdict;

use anyhow::Result;
use mesh::measure::{area, enclosed_volume};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

use crate::body::boundary::Boundary;
use crate::body::layout;
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::body::weight::Weight;
use crate::config::Config;
use crate::config::method::Method;
use crate::geometry::MM;
use crate::geometry::walls::Wall;
use gluing::Flat;
use pull::Choice;
use report::{ChosenBy, Direction, Measure, Verdict};
use undercut::Worst;
use verdict::Judge;
pub use verdict::Refused;

/// How a body is molded, and why.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the chamber comes into it.
    pub method: Method,
    /// Who chose that.
    pub chosen_by: ChosenBy,
    /// Why.
    pub reason: String,
    /// Every number that led to the choice.
    pub measures: Vec<Measure>,
    /// What was found about each method.
    pub verdicts: Vec<Verdict>,
    /// The undercuts along every direction.
    pub directions: Vec<Direction>,
    /// How many chambers the body has.
    pub chambers: usize,
    /// What is cast of silicone.
    pub castings: Vec<Casting>,
    /// What the body weighs, if the density of its silicone is known.
    pub weight: Option<Weight>,
    /// The thinnest wall of the body, if it has one.
    pub wall: Option<Wall>,
}

/// A casting of silicone and how its mold stands.
#[derive(Clone, Debug)]
pub struct Casting {
    /// The name.
    pub name: String,
    /// How it stands, and how its mold comes apart.
    pub orientation: Orientation,
    /// What is cast, with its chamber filled [m].
    pub filled: SurfaceMesh,
    /// Depth of the undercuts of its shells, at each triangle of `filled` [m].
    pub undercut: Vec<f64>,
    /// Where the depth is largest over the width of the silicone that must give way.
    pub worst: Option<Worst>,
}

/// The silicone cannot be peeled out, in words.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Locked(String);

impl Plan {
    /// Measures a body and chooses.
    pub fn new(boundary: &Boundary, config: &Config) -> Result<Self> {
        Self::without(&[], boundary, config)
    }

    /// Plans as [`Self::new`] does, without methods that were tried.
    pub fn without(refused: &[Refused], boundary: &Boundary, config: &Config) -> Result<Self> {
        let mut judge = Judge::new(boundary, config, refused);
        let (method, castings, chosen_by) = match config.method {
            Some(asked) => {
                let method = judge.require(asked)?;
                (method, judge.castings(method)?, ChosenBy::Configuration)
            }
            None => {
                let (method, castings) = judge.first_possible()?;
                (method, castings, ChosenBy::Measures)
            }
        };
        let reason = judge.reason(method);
        let up = layout::up(boundary, config);
        let directions = pull::directions(&boundary.filled, &up);
        let Judge { measures, verdicts, wall, .. } = judge;
        Ok(Self {
            method,
            chosen_by,
            reason,
            measures,
            verdicts,
            directions,
            chambers: boundary.cores.len(),
            castings,
            weight: weight(boundary, config),
            wall: wall.flatten(),
        })
    }

    /// What to do with the castings, in order.
    pub fn steps(&self) -> Vec<String> {
        verdict::steps(self)
    }
}

impl Casting {
    /// A casting whose shells part as is best or as the configuration asks; `filled` is
    /// the portion without its chamber.
    pub fn new(
        name: &str,
        filled: &SurfaceMesh,
        up: Vec3,
        portion: Portion,
        config: &Config,
    ) -> Result<Self> {
        let Choice { pull, parting, undercut, worst, reason } =
            pull::choose(filled, &up, portion, config);
        log::info!("{name}: {reason}");
        let limit = config.limits.peel;
        let orientation = Orientation { up, pull, parting, portion, joint: None };
        if let Some(worst) = worst.filter(|worst| worst.ratio > limit) {
            if let Some(split) = split(name, filled, &orientation, limit) {
                return Ok(split);
            }
            if let Some(other) = other(name, filled, &orientation, config) {
                return Ok(other);
            }
            let Worst { ratio, depth, opposite, width, at } = worst;
            let [x, y, z] = (at * MM).into();
            return Err(Locked(format!(
                "the {name} cannot be peeled out of its mold: {reason}; at ({x:.2}, {y:.2}, {z:.2}) mm the silicone must give way by \
                 {:.2} mm and on its other side by {:.2} mm, {ratio:.2} of its width of {:.2} mm there, limits.peel is {limit:.2}: \
                 choose another `up` or parting.pull, set method = \"halves\", or raise limits.peel for a softer silicone",
                depth * MM,
                opposite * MM,
                width * MM
            ))
            .into());
        }
        let (name, filled, undercut) = (name.into(), filled.clone(), undercut.facets);
        Ok(Self { name, orientation, filled, undercut, worst })
    }
}

/// What a body weighs, if the density of its silicone is known. With the wall W of its chambers, its
/// outside U and the caps of inlets C, the areas are U + W of the body, W + C of cores, and U + C of the
/// filled body.
fn weight(boundary: &Boundary, config: &Config) -> Option<Weight> {
    let cores: f64 = boundary.cores.iter().map(|core| area(&core.surface)).sum();
    let walls = (area(&boundary.cast) + cores - area(&boundary.filled)) / 2.0;
    let volume = enclosed_volume(&boundary.cast);
    config.density().map(|density| Weight::new(volume * MM.powi(3), walls * MM.powi(2), density))
}

/// A casting whose upper shell cannot be demolded, with two sides instead, if these can.
fn split(name: &str, filled: &SurfaceMesh, locked: &Orientation, limit: f64) -> Option<Casting> {
    let along = locked.pull.dot(&locked.up);
    let joint = match locked.parting {
        PartingSurface::Plane(position) if along.abs() > pull::ALONG => position * along,
        _ => return None,
    };
    let sides = sides::instead(filled, &locked.up, joint, limit)?;
    log::info!(
        "{name}: the upper shell would lock, so that it is split: above that, {}",
        sides.reason
    );
    let undercut = undercut::View::along(filled, &sides.pull).undercut(sides.plane()?).facets;
    let Choice { pull, parting, worst, .. } = sides;
    let orientation = Orientation { pull, parting, joint: Some(joint), ..locked.clone() };
    Some(Casting { name: name.into(), orientation, filled: filled.clone(), undercut, worst })
}

/// A casting on the parting surface on which it has to give way least instead, if that is
/// little enough and the configuration leaves the surface open.
fn other(
    name: &str,
    filled: &SurfaceMesh,
    locked: &Orientation,
    config: &Config,
) -> Option<Casting> {
    if !config.parting.is_open() {
        return None;
    }
    let choice = pull::loosest(filled, &locked.up, locked.portion)?;
    if choice.ratio() > config.limits.peel {
        return None;
    }
    log::info!("{name}: the shells would lock, so that they part otherwise: {}", choice.reason);
    let Choice { pull, parting, undercut, worst, .. } = choice;
    let orientation = Orientation { pull, parting, ..locked.clone() };
    let (name, filled, undercut) = (name.into(), filled.clone(), undercut.facets);
    Some(Casting { name, orientation, filled, undercut, worst })
}

/// The filled body beyond a plane.
fn beyond(boundary: &Boundary, normal: &Vec3, offset: f64) -> SurfaceMesh {
    let filled = Solid::from_surface(&boundary.filled).expect("the boundary was checked");
    filled.trim_by_plane(normal, offset).to_surface()
}

/// Both halves, cut face down. The parting of the whole body does not concern them.
fn halves(
    boundary: &Boundary,
    normal: &Vec3,
    offset: f64,
    config: &Config,
) -> Result<Vec<Casting>> {
    let config = Config { parting: Config::default().parting, ..config.clone() };
    let sides = [("half-a", *normal, offset), ("half-b", -normal, -offset)];
    let half = |(name, up, offset): (&str, Vec3, f64)| {
        Casting::new(name, &beyond(boundary, &up, offset), up, Portion::Above(offset), &config)
    };
    sides.into_iter().map(half).collect()
}

/// The chamber, cut face down on a plate that carries the core, and the sheet in a tray.
fn chamber_and_sheet(boundary: &Boundary, flat: &Flat, config: &Config) -> Result<Vec<Casting>> {
    let config = Config { parting: Config::default().parting, ..config.clone() };
    let (normal, offset) = (&flat.cut.normal, flat.cut.offset);
    let up = -normal;
    let chamber = Casting::new(
        "chamber",
        &beyond(boundary, &up, -offset),
        up,
        Portion::Above(-offset),
        &config,
    )?;
    // The sheet lies in the tray with its glued face up.
    let filled = beyond(boundary, normal, flat.beyond);
    let view = undercut::View::along(&filled, &up);
    let undercut = view.undercut(undercut::PartingHeight::Plane(-flat.beyond));
    let worst = view.worst(&undercut);
    let sheet = if worst.is_none_or(|worst| worst.ratio <= config.limits.peel) {
        let portion = Portion::Below(-flat.beyond);
        let orientation =
            Orientation { up, pull: up, parting: PartingSurface::Open, portion, joint: None };
        Casting { name: "sheet".into(), orientation, filled, undercut: undercut.facets, worst }
    } else {
        Casting::new("sheet", &filled, *normal, Portion::Above(flat.beyond), &config)?
    };
    Ok(vec![chamber, sheet])
}
