//! How a body is molded: what is measured, which method, pull and parting surface follow, and why.

pub mod gluing;
pub mod pull;
pub mod report;
mod sides;
mod verdict;

use anyhow::Result;
use geometry::undercut::{self, Worst};
use geometry::{MM, place};
use mesh::measure::{area, enclosed_volume};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

use crate::body::boundary::Boundary;
use crate::body::layout;
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::body::source::Input;
use crate::body::weight::Weight;
use crate::config::Config;
use gluing::Flat;
use pull::Choice;
use report::{ChosenBy, PlanReport, ThinnestWall};
use verdict::Judge;
pub use verdict::Refused;

/// How a body is molded, and why.
pub struct Plan {
    /// What was chosen, as it is written.
    pub report: PlanReport,
    /// What is cast of silicone.
    pub castings: Vec<Casting>,
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
    /// Measures a body, which `input` names, and chooses, without methods that were tried.
    pub fn new(
        boundary: &Boundary,
        config: &Config,
        input: Input,
        refused: &[Refused],
    ) -> Result<Self> {
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
        let steps = (method.steps)(boundary.cores.len());
        let report = PlanReport {
            program: format!("fab {}", env!("CARGO_PKG_VERSION")),
            units: "mm".into(),
            input,
            method,
            chosen_by,
            reason,
            measures: judge.measures,
            methods: judge.verdicts,
            directions: pull::directions(&boundary.filled, &up),
            molds: report::entries(&castings),
            steps: steps.iter().map(|step| (*step).to_owned()).collect(),
            weight: weight(boundary, config),
            wall: judge.wall.flatten().map(ThinnestWall::from),
        };
        Ok(Self { report, castings })
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
        let (filled, orientation) =
            (filled.clone(), Orientation { up, pull, parting, portion, joint: None });
        let casting =
            Self { name: name.into(), orientation, filled, undercut: undercut.facets, worst };
        if let Some(worst) = worst.filter(|worst| worst.ratio > limit) {
            if let Some(free) = casting.split(limit).or_else(|| casting.parted_otherwise(config)) {
                return Ok(free);
            }
            let Worst { ratio, depth, opposite, width, at } = worst;
            let at = place(&at, 2);
            return Err(Locked(format!(
                "the {name} cannot be peeled out of its mold: {reason}; at {at} the silicone must give way by \
                 {:.2} mm and on its other side by {:.2} mm, {ratio:.2} of its width of {:.2} mm there, limits.peel is {limit:.2}: \
                 choose another `up` or parting.pull, set method = \"halves\", or raise limits.peel for a softer silicone",
                depth * MM,
                opposite * MM,
                width * MM
            ))
            .into());
        }
        Ok(casting)
    }

    /// This casting, whose upper shell cannot be demolded, with two sides instead, if these can.
    fn split(&self, limit: f64) -> Option<Self> {
        let Orientation { up, pull, parting, .. } = &self.orientation;
        let along = pull.dot(up);
        let joint = match parting {
            PartingSurface::Plane(position) if along.abs() > pull::ALONG => position * along,
            _ => return None,
        };
        let sides = sides::instead(&self.filled, up, joint, limit)?;
        log::info!(
            "{}: the upper shell would lock, so that it is split: above that, {}",
            self.name,
            sides.reason
        );
        let PartingSurface::Plane(position) = sides.parting else { return None };
        let plane = undercut::PartingHeight::Plane(position);
        let undercut = undercut::View::along(&self.filled, &sides.pull).undercut(plane);
        Some(self.parted(Choice { undercut, ..sides }, Some(joint)))
    }

    /// This casting on the parting surface on which it has to give way least, if that is little enough and the
    /// configuration leaves the surface open.
    fn parted_otherwise(&self, config: &Config) -> Option<Self> {
        if !config.parting.is_open() {
            return None;
        }
        let Orientation { up, portion, .. } = &self.orientation;
        let choice = pull::loosest(&self.filled, up, *portion)?;
        if choice.ratio() > config.limits.peel {
            return None;
        }
        let (name, reason) = (&self.name, &choice.reason);
        log::info!("{name}: the shells would lock, so that they part otherwise: {reason}");
        Some(self.parted(choice, None))
    }

    /// This casting in shells that part so, above a joint if there is one.
    fn parted(&self, choice: Choice, joint: Option<f64>) -> Self {
        let Choice { pull, parting, undercut, worst, .. } = choice;
        let orientation = Orientation { pull, parting, joint, ..self.orientation.clone() };
        Self { orientation, undercut: undercut.facets, worst, ..self.clone() }
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
