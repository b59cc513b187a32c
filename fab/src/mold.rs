//! The mold of a body: block − filled part, divided into pieces, with features.
//!
//! Everything is in the mold's frame, see [`crate::frame`].

use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::{Solid, SolidError};
use mesh::{SurfaceMesh, Vec3, measure};
use serde::{Deserialize, Serialize};

use crate::config::{Config, Parting, Sprue};
use crate::frame::{Frame, Pull, Turn};
use crate::layout::{LayoutError, frame, placed};
use crate::parts::block::Block;
use crate::parts::core::{Print, PrintError};
use crate::parts::key::Key;
use crate::parts::{Frustum, channel, key};
use crate::skin::{Inlet, Skin};
use crate::split::{Site, Split, affine, divide, turned};
use crate::venting::{self, VentError};

/// Channels reach this far out of the block, so that no faces coincide [m].
const BEYOND: f64 = 1e-3;

/// A facet belongs to the seat if it keeps within this part of the body's
/// diagonal of the inlet's plane.
const SEAT: f64 = 2e-3;

/// Columns of a height field; ten times those of a hand-sized part at the default spacing.
const MOST_COLUMNS: f64 = 1e6;

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
    /// Collar for a tube, which is cast and not part of the design.
    Boss,
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
    /// Bounds of the closed mold.
    pub block: Block,
    /// Outside of the closed mold.
    pub outside: Solid,
    /// Shells, and the base if there is one.
    pub shells: Vec<Piece>,
    /// One per connected cavity.
    pub cores: Vec<Piece>,
    /// What is cast, without sprue and vents.
    pub cast: Solid,
    /// All channels and gaps.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
}

/// The filled part in the mold's frame.
struct Part {
    surface: SurfaceMesh,
    solid: Solid,
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
    /// Makes the mold of a body.
    ///
    /// # Errors
    /// [`MoldError`] if it cannot be made as configured.
    pub fn new(skin: &Skin, config: &Config) -> Result<Self, MoldError> {
        let (frame, pull) = frame(skin, config)?;
        let filled = placed(&skin.filled, &frame);
        let block = Block::around(measure::bounds(&filled.vertices), config, pull);
        let part = Part { solid: Solid::from_surface(&filled)?, surface: filled };
        let mut mold = Self {
            cast: Solid::from_surface(&placed(&skin.cast, &frame))?,
            frame,
            outside: block.solid(),
            block,
            shells: Vec::new(),
            cores: Vec::new(),
            features: Vec::new(),
            findings: Vec::new(),
        };
        match pull {
            Pull::Z => mold.add_upper_and_lower(&part, config)?,
            Pull::Y => mold.add_sides_on_base(&part, skin, config)?,
        }
        mold.add_cores(skin, config)?;
        mold.add_channels(skin, &part.surface, config)?;
        mold.require_single_pieces()?;
        Ok(mold)
    }

    fn add_upper_and_lower(&mut self, part: &Part, config: &Config) -> Result<(), MoldError> {
        let flat = |p: &Vec3| [p.x, p.y];
        let keys = [flat(&self.block.min), flat(&self.block.max)];
        let [upper, lower] = self.part(&self.block.solid(), part, keys, Pull::Z, config)?;
        self.add_shell("upper", upper, Vec3::z());
        self.add_shell("lower", lower, -Vec3::z());
        Ok(())
    }

    fn add_sides_on_base(
        &mut self,
        part: &Part,
        skin: &Skin,
        config: &Config,
    ) -> Result<(), MoldError> {
        let Block { min, max } = self.block.clone();
        let joint = seat_height(&part.surface, skin, &self.frame);
        // Cut from boxes of their own: a plane through a flat seat would leave
        // a film without thickness on it.
        let mut base = Solid::cube(&min, &Vec3::new(max.x, max.y, joint)).difference(&part.solid);
        let sides = Solid::cube(&Vec3::new(min.x, min.y, joint), &max);
        // Seen along the pull, x runs to the right and z down. The base keys
        // need the lowest strip.
        let base_keys = joint + 2.0 * key::land(&config.keys) + config.keys.height;
        let keys = [[min.x, -max.z], [max.x, -base_keys]];
        let [mut left, mut right] = self.part(&sides, part, keys, Pull::Y, config)?;
        let sites = key::sites([min.x, min.y], [max.x, max.y], &config.keys);
        for [x, y] in sites {
            let key = Key::new(Vec3::new(x, y, joint), &config.keys);
            base = base.union(&key.male.solid());
            for shell in [&mut left, &mut right] {
                *shell = shell.difference(&key.female.solid());
            }
            self.features.push(Feature { purpose: Purpose::Key, frustum: key.seat });
        }
        self.add_shell("left", left, Vec3::y());
        self.add_shell("right", right, -Vec3::y());
        self.add_shell("base", base, -Vec3::z());
        Ok(())
    }

    fn add_shell(&mut self, name: &str, solid: Solid, leaves: Vec3) {
        self.shells.push(Piece { name: name.into(), solid, leaves });
    }

    /// Divides a region of the block along the parting surface, takes the part out
    /// and adds keys: the shell the pull points to, with the holes, and the other,
    /// with the cones.
    fn part(
        &mut self,
        region: &Solid,
        part: &Part,
        keys: [[f64; 2]; 2],
        pull: Pull,
        config: &Config,
    ) -> Result<[Solid; 2], MoldError> {
        let turn = Turn::lowering(-pull.vector());
        let corners = [turn.0 * self.block.min, turn.0 * self.block.max];
        let (min, max) = measure::bounds(&corners);
        let site = Site { min, max, keys };
        let split = match &config.parting {
            Parting::Plane(plane) => {
                let middle = (min.z + max.z) / 2.0;
                let z = plane.offset.map_or(middle, |offset| self.along(plane.pull, offset, pull));
                Split::plane(&site, z, &config.keys)
            }
            Parting::HeightField(field) => {
                let columns = (max.x - min.x) * (max.y - min.y) / field.cell.powi(2);
                if columns > MOST_COLUMNS {
                    let (cell, most) = (field.cell, MOST_COLUMNS);
                    return Err(MoldError::Columns { cell, columns, most });
                }
                let vertices = part.surface.vertices.iter().map(|p| turn.0 * p).collect();
                let triangles = part.surface.triangles.clone();
                let turned = SurfaceMesh { vertices, triangles };
                Split::height_field(&site, &turned, field, &config.keys)
            }
        };
        let back = turn.inverse();
        let feet = split.feet;
        self.findings.extend(split.findings.iter().cloned());
        let mut sides = divide(region, &part.solid, &split.turned(back));
        self.findings.append(&mut sides.findings);
        for foot in feet {
            let key = Key::new(foot, &config.keys);
            let place = |cone: &Frustum| cone.solid().transform(&affine(back));
            sides.below = sides.below.union(&place(&key.male));
            sides.above = sides.above.difference(&place(&key.female));
            let frustum = turned(&key.seat, back);
            self.features.push(Feature { purpose: Purpose::Key, frustum });
        }
        Ok([sides.above, sides.below])
    }

    /// The height along the pull of a plane given in the design [m].
    fn along(&self, direction: Option<[f64; 3]>, offset: f64, pull: Pull) -> f64 {
        let axis = direction.map_or_else(
            || self.frame.rotation.transpose() * pull.vector(),
            |d| Vec3::from(d).normalize(),
        );
        self.frame.point(&(axis * offset)).dot(&pull.vector())
    }

    /// Adds the cores with their stubs, and cuts the sockets into the lowest piece.
    fn add_cores(&mut self, skin: &Skin, config: &Config) -> Result<(), MoldError> {
        let single = skin.cores.len() == 1;
        for (i, core) in skin.cores.iter().enumerate() {
            let mut solid = Solid::from_surface(&placed(&core.surface, &self.frame))?;
            for Inlet { centre, radius, .. } in &core.inlets {
                let centre = self.frame.point(centre);
                let floor = self.block.min.z;
                let print = Print::new(centre, *radius, floor, &self.cast, &config.core)?;
                solid = solid.union(&print.stub_solid());
                let holder = self.shells.last_mut().expect("there are shells");
                holder.solid = holder.solid.difference(&print.socket_solid());
                self.features.push(Feature { purpose: Purpose::Socket, frustum: print.socket });
            }
            let name = if single { "core".into() } else { format!("core{}", i + 1) };
            self.cores.push(Piece { name, solid, leaves: -Vec3::z() });
        }
        Ok(())
    }

    /// Cuts sprue and vents out of the shells.
    fn add_channels(
        &mut self,
        skin: &Skin,
        filled: &SurfaceMesh,
        config: &Config,
    ) -> Result<(), MoldError> {
        let bvh = SurfaceBvh::new(filled);
        let places = venting::places(skin, &self.frame, &bvh, config)?;
        self.findings.extend(places.findings);
        let end = self.block.max.z + BEYOND;
        let Sprue { radius, top_radius, .. } = config.sprue;
        let funnel = channel(&bvh, &places.sprue, end, radius, top_radius);
        self.add_channel(Purpose::Sprue, funnel);
        let radius = config.vents.radius;
        for top in &places.vents {
            self.add_channel(Purpose::Vent, channel(&bvh, top, end, radius, radius));
        }
        Ok(())
    }

    fn add_channel(&mut self, purpose: Purpose, frustum: Frustum) {
        let channel = frustum.solid();
        for shell in &mut self.shells {
            shell.solid = shell.solid.difference(&channel);
        }
        self.features.push(Feature { purpose, frustum });
    }

    fn require_single_pieces(&self) -> Result<(), MoldError> {
        for piece in self.shells.iter().chain(&self.cores) {
            let bodies = piece.solid.decompose();
            if let Some(second) = bodies.get(1) {
                return Err(MoldError::Pieces {
                    name: piece.name.clone(),
                    count: bodies.len(),
                    volume_mm3: second.volume() * 1e9,
                });
            }
        }
        Ok(())
    }
}

/// Height of the seat, on which sides and base meet: the highest vertex of the
/// facets that lie in the first inlet's plane, so that no film of a shell
/// reaches below an uneven seat.
fn seat_height(filled: &SurfaceMesh, skin: &Skin, frame: &Frame) -> f64 {
    let level = frame.point(&skin.cores[0].inlets[0].centre).z;
    let tolerance = SEAT * measure::diagonal(&filled.vertices);
    let near = |v: &usize| (filled.vertices[*v].z - level).abs() <= tolerance;
    let seat = filled.triangles.iter().filter(|t| t.iter().all(near));
    seat.flatten().map(|&v| filled.vertices[v].z).fold(level, f64::max)
}
