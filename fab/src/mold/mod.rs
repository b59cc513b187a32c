//! The mold of a body: outside − filled part, divided into pieces, with features.
//!
//! Everything is in the mold's frame, see [`crate::geometry::frame`].

mod cast_body;
mod cores;
mod division;
pub mod features;
mod height_field;
pub mod parting;
pub mod venting;

use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::{Solid, SolidError};
use mesh::{SurfaceMesh, Vec3, measure};
use serde::{Deserialize, Serialize};

use crate::body::layout::{LayoutError, frame};
use crate::body::orientation::{Parting, Portion, Stance};
use crate::body::skin::Skin;
use crate::config::method::Method;
use crate::config::{Config, Sprue};
use crate::geometry::frame::{Frame, Pull};
use crate::geometry::frustum::Frustum;
use crate::mold::features::block::Block;
use crate::mold::features::core::PrintError;
use crate::mold::features::pin::PinError;
use crate::mold::features::{channel, funnel};
use crate::mold::parting::FILM;
use crate::mold::venting::{Places, VentError};
use cast_body::Part;

/// Channels reach this far out of the block, so that no faces coincide [m].
const BEYOND: f64 = 1e-3;

/// A printed part.
#[derive(Clone)]
pub struct Piece {
    /// Its name, and that of its file without extension.
    pub name: String,
    /// Its shape in the closed mold [m].
    pub solid: Solid,
    /// The unit direction in which it leaves the closed mold [1].
    pub leaves: Vec3,
}

/// What a channel or gap is for.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Purpose {
    /// Silicone in.
    Sprue,
    /// Air out.
    Vent,
    /// Hole for a registration key.
    Key,
    /// Hole for a core's stub.
    Socket,
    /// Hole for a bolt through a flange.
    Bolt,
    /// Slot for a screwdriver between two shells.
    Pry,
    /// Bore in a soluble core, for water.
    Drain,
    /// Hole in the silicone that a core's second support leaves, to be plugged.
    Pin,
}

impl Purpose {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sprue => "sprue",
            Self::Vent => "vent",
            Self::Key => "key",
            Self::Socket => "socket",
            Self::Bolt => "bolt",
            Self::Pry => "pry",
            Self::Drain => "drain",
            Self::Pin => "pin",
        }
    }
}

/// A channel or gap in the mold.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// What it is for.
    pub purpose: Purpose,
    /// Its outline.
    pub frustum: Frustum,
}

/// A finished mold.
#[derive(Clone)]
pub struct Mold {
    /// From the design to the mold.
    pub frame: Frame,
    /// How the cavity comes into the body.
    pub method: Method,
    /// What is cast of the design.
    pub portion: Portion,
    /// Whether it is cast open.
    pub open: bool,
    /// Bounds of the closed mold, without labels.
    pub block: Block,
    /// Outside of the closed mold.
    pub outside: Solid,
    /// Position of the joint of the shells along the pull, in the rim [m].
    pub level: f64,
    /// Shells, and the base if there is one, taken apart in reverse order.
    pub shells: Vec<Piece>,
    /// One per connected cavity that is held on a stub.
    pub cores: Vec<Piece>,
    /// What stands in the sprue while it is filled, and what it holds [m³].
    pub funnel: Option<(Piece, f64)>,
    /// What is cast, without sprue and vents.
    pub cast: Solid,
    /// All channels and gaps.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
}

/// Why a mold cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum MoldError {
    /// The directions do not fit.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A core cannot be held.
    #[error(transparent)]
    Print(#[from] PrintError),
    /// The pin that was asked for has no place.
    #[error(transparent)]
    Pin(#[from] PinError),
    /// A channel misses the part.
    #[error(transparent)]
    Vent(#[from] VentError),
    /// A surface is refused by the solid kernel.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// A grid too fine to work with.
    #[error(
        "parting.cell = {cell} m makes {columns:.1e} columns over the mold, at most {most:.1e} are allowed; enlarge it"
    )]
    Columns {
        /// Spacing asked for [m].
        cell: f64,
        /// Columns it makes.
        columns: f64,
        /// Columns allowed.
        most: f64,
    },
    /// A shell fell apart.
    #[error(
        "the {name} shell has {count} separate pieces, the second of {volume_mm3:.3} mm³: \
         choose another parting.pull, or another parting.kind"
    )]
    Pieces {
        /// Name of the shell.
        name: String,
        /// How many pieces it has.
        count: usize,
        /// Volume of the second [mm³].
        volume_mm3: f64,
    },
}

impl Mold {
    /// Makes the mold of a body, whose cavity comes into it by `method`.
    ///
    /// # Errors
    /// [`MoldError`] if it cannot be made as configured.
    pub fn new(
        skin: &Skin,
        stance: &Stance,
        method: Method,
        config: &Config,
    ) -> Result<Self, MoldError> {
        let (frame, pull) = frame(&skin.filled, stance, config.shrinkage())?;
        let mut part = Part::new(skin, &frame, stance.portion, Block::foot(stance, pull, config))?;
        let bounds = measure::bounds(&part.surface.vertices);
        let mut block = Block::around(bounds, stance, pull, config);
        if let Some(joint) = stance.joint {
            part.seat = frame.point(&(stance.up * joint)).z;
            block.max.z = block.max.z.max(part.seat + Block::sides(config));
        }
        let mut mold = Self {
            block,
            outside: Solid::cube(&Vec3::zeros(), &Vec3::zeros()),
            level: 0.0,
            cast: part.cast.clone(),
            frame,
            method,
            portion: stance.portion,
            open: matches!(stance.parting, Parting::Open),
            shells: Vec::new(),
            cores: Vec::new(),
            funnel: None,
            features: Vec::new(),
            findings: Vec::new(),
        };
        let bvh = SurfaceBvh::new(&part.surface);
        let places = match mold.open {
            true => None,
            false => Some(venting::places(skin, &mold.frame, mold.portion, &bvh, config)?),
        };
        let rims = places.as_ref().map_or(Vec::new(), |p| rims(p, &part.surface, config));
        mold.divide(&part, &rims, stance, pull, config)?;
        let channels = places.map_or(Vec::new(), |p| mold.channels(p, &bvh, config));
        if stance.portion == Portion::Whole {
            let level = (pull == Pull::Y).then_some(mold.level);
            mold.add_cores(&part, &channels, level, config)?;
        }
        for Feature { purpose, frustum } in channels {
            mold.cut(purpose, frustum);
        }
        mold.require_single_pieces()?;
        Ok(mold)
    }

    /// Volume of the box that the outside replaces, less the outside [m³].
    #[must_use]
    pub fn saved(&self) -> f64 {
        self.block.solid().volume() - self.outside.volume()
    }

    /// The sprue and the vents.
    fn channels(&mut self, places: Places, bvh: &SurfaceBvh, config: &Config) -> Vec<Feature> {
        self.findings.extend(places.findings);
        let end = self.block.max.z + BEYOND;
        let Sprue { radius, top_radius, head, .. } = config.sprue;
        let frustum = channel(bvh, &places.sprue, end, radius, top_radius);
        if let Some(head) = head {
            self.add_funnel(&frustum, head, config);
        }
        let mut channels = vec![Feature { purpose: Purpose::Sprue, frustum }];
        let radius = config.vents.radius;
        channels.extend(places.vents.iter().map(|top| {
            let frustum = channel(bvh, top, end, radius, radius);
            Feature { purpose: Purpose::Vent, frustum }
        }));
        channels
    }

    /// A funnel in the sprue for a share of what is cast.
    fn add_funnel(&mut self, sprue: &Frustum, head: f64, config: &Config) {
        let volume = head * self.cast.volume();
        let funnel = funnel::funnel(sprue, &self.outside, volume, config.stub_clearance());
        match funnel.filter(|solid| solid.intersection(&self.cast).is_empty()) {
            Some(solid) => {
                let piece = Piece { name: "funnel".into(), solid, leaves: Vec3::z() };
                self.funnel = Some((piece, volume));
            }
            None => self.findings.push(Finding {
                rule: "funnel",
                message: format!(
                    "a sprue of {:.2} mm radius leaves the mold where no funnel can stand in it: increase sprue.radius \
                     or wall, or move sprue.at to where the outside slopes less",
                    sprue.base_radius * 1e3
                ),
                count: 1,
            }),
        }
    }

    /// Takes a channel out of all shells.
    fn cut(&mut self, purpose: Purpose, frustum: Frustum) {
        let channel = frustum.solid();
        for shell in &mut self.shells {
            shell.solid = shell.solid.difference(&channel);
        }
        self.features.push(Feature { purpose, frustum });
    }

    /// Drops films of rounding; what is left of every piece must be one.
    fn require_single_pieces(&mut self) -> Result<(), MoldError> {
        for piece in self.shells.iter_mut().chain(&mut self.cores) {
            let mut bodies = piece.solid.decompose();
            if bodies.len() < 2 {
                continue;
            }
            bodies.retain(|body| body.volume() > FILM);
            if let Some(second) = bodies.get(1) {
                return Err(MoldError::Pieces {
                    name: piece.name.clone(),
                    count: bodies.len(),
                    volume_mm3: second.volume() * 1e9,
                });
            }
            piece.solid = bodies.swap_remove(0);
        }
        Ok(())
    }
}

/// Points around sprue and vents at the height of the part's top: the outside encloses
/// them like the part, so that nothing runs over before the mold is full.
fn rims(places: &Places, filled: &SurfaceMesh, config: &Config) -> Vec<Vec3> {
    let top = measure::bounds(&filled.vertices).1.z;
    let vents = places.vents.iter().map(|vent| (vent, config.vents.radius));
    let channels = [(&places.sprue, config.sprue.top_radius)].into_iter().chain(vents);
    let rim = |(at, radius): (&Vec3, f64)| {
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let at = Vec3::new(at.x, at.y, top);
        corners.map(|[x, y]| at + Vec3::new(x, y, 0.0) * radius)
    };
    channels.flat_map(rim).collect()
}
