//! The mold of a body: outside − filled body, divided into pieces, with features.
//!
//! A mold is made in steps, each a function from values to a value:
//!
//! | step | gives |
//! |-|-|
//! | [`layout::frame`] | the mold's frame, in which everything below is |
//! | `CastBody::new` | what is cast, and what fills its chambers |
//! | [`venting::places`] | where silicone enters and air leaves |
//! | `Division::new` | the outside, and shells with keys and bolts |
//! | `Places::channels` | the sprue and the vents |
//! | `Cores::new` | cores on their stubs, shells with sockets, the cast with holes of pins |
//! | `cut`, `connected` | shells with channels; every piece in one piece |

mod cast_body;
mod cores;
mod division;
pub mod features;
pub mod holding;
pub mod parting;
mod piece;
pub mod venting;

use anyhow::Result;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3, measure};

use crate::body::boundary::Boundary;
use crate::body::layout;
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::config::Config;
use crate::config::method::Method;
use cast_body::CastBody;
pub use cast_body::Opening;
use cores::Cores;
use division::{Blank, Division};
use features::block::Block;
use geometry::frame::Frame;
use holding::Holding;
pub use piece::{Feature, Piece, Purpose};
use piece::{connected, cut};
use venting::Places;

/// Channels reach this far out of the block, so that no faces coincide [m].
const BEYOND: f64 = 1e-3;

/// A mold, in its frame.
#[derive(Clone)]
pub struct Mold {
    /// From the design to the mold.
    pub frame: Frame,
    /// How the chamber comes into the body.
    pub method: Method,
    /// What is cast of the design.
    pub portion: Portion,
    /// Whether it is cast open.
    pub open: bool,
    /// Bounds of the closed mold, without labels.
    pub block: Block,
    /// Outside of the closed mold.
    pub outside: Solid,
    /// Shells, and the base if there is one, taken apart in reverse order.
    pub shells: Vec<Piece>,
    /// One per connected chamber that is held on a stub.
    pub cores: Vec<Piece>,
    /// Tags of the chambers, one for each core that the body has.
    pub chambers: Vec<String>,
    /// How each core is held that stands on a stub.
    pub holds: Vec<Holding>,
    /// Whether each core fits into its socket one way only.
    pub one_way: bool,
    /// What is cast, without sprue and vents.
    pub cast: Solid,
    /// Area of the walls of its chambers [m²].
    pub chamber_area: f64,
    /// All channels and gaps.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
}

impl Mold {
    /// The mold of a body whose chamber comes into it by `method`.
    pub fn new(
        boundary: &Boundary,
        orientation: &Orientation,
        method: Method,
        config: &Config,
    ) -> Result<Self> {
        let portion = orientation.portion;
        let (frame, pull) = layout::frame(&boundary.filled, orientation, config.shrinkage())?;
        let joint = orientation.joint.map(|joint| frame.point(&(orientation.up * joint)).z);
        let foot = Block::foot(orientation, pull, config);
        let body = CastBody::new(boundary, &frame, portion, joint, foot)?;
        let bounds = measure::bounds(&body.surface.vertices);
        let block = Block::around(bounds, orientation, pull, joint, config);
        let surface = SurfaceBvh::new(&body.surface);
        let open = matches!(orientation.parting, PartingSurface::Open);
        let places = match open {
            true => None,
            false => Some(venting::places(boundary, &frame, portion, &surface, config)?),
        };
        let rims = places.as_ref().map_or(Vec::new(), |p| rims(p, &body.surface, config));
        let blank = Blank { body, block, frame, orientation, pull, method, config };
        let division = Division::new(&blank, &rims)?;
        let end = blank.block.max.z + BEYOND;
        let outside = division.outside;
        let channels =
            places.as_ref().map_or(Vec::new(), |places| places.channels(&surface, end, config));
        let sealed = places.map_or(Vec::new(), |places| places.findings);
        let cores = match portion {
            Portion::Whole => Cores::new(&blank, division.shells, &channels)?,
            Portion::Above(_) | Portion::Below(_) => Cores::none(&blank.body, division.shells),
        };
        let shells = cut(cores.shells, &channels);
        Ok(Self {
            shells: shells.into_iter().map(connected).collect::<Result<_, _>>()?,
            cores: cores.pieces.into_iter().map(connected).collect::<Result<_, _>>()?,
            features: [division.features, cores.features, channels].concat(),
            findings: [division.findings, sealed, cores.findings].concat(),
            cast: cores.cast,
            chamber_area: blank.body.chamber_area(),
            frame: blank.frame,
            method,
            outside,
            chambers: boundary.cores.iter().map(|core| core.chamber.clone()).collect(),
            holds: cores.holds,
            one_way: cores.one_way,
            portion,
            open,
            block: blank.block,
        })
    }

    /// Volume of the box that the outside replaces, less the outside [m³].
    pub fn saved(&self) -> f64 {
        self.block.solid().volume() - self.outside.volume()
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
