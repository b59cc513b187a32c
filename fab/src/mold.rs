//! The mold of a body: outside − filled part, divided into pieces, with features.
//!
//! Everything is in the mold's frame, see [`crate::frame`].

mod division;
mod part;

use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::{Solid, SolidError};
use mesh::{SurfaceMesh, Vec3, measure};
use serde::{Deserialize, Serialize};

use crate::config::{Config, Sprue, Support};
use crate::frame::{Frame, Pull};
use crate::layout::{LayoutError, frame};
use crate::method::Method;
use crate::parts::block::Block;
use crate::parts::core::{Print, PrintError, drain};
use crate::parts::support::{self, Sag};
use crate::parts::{Frustum, channel, funnel, pin};
use crate::skin::Skin;
use crate::stance::{Parting, Portion, Stance};
use crate::venting::{self, VentError};
use part::{Core, Part};

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
        let mut part = Part::new(skin, &frame, stance.portion)?;
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
        mold.divide(&part, stance, pull, config)?;
        if stance.portion == Portion::Whole {
            let level = (pull == Pull::Y).then_some(mold.level);
            mold.add_cores(&part, method, level, config)?;
        }
        if !mold.open {
            mold.add_channels(skin, &part.surface, config)?;
        }
        mold.require_single_pieces()?;
        Ok(mold)
    }

    /// Volume of the box that the outside replaces, less the outside [m³].
    #[must_use]
    pub fn saved(&self) -> f64 {
        self.block.solid().volume() - self.outside.volume()
    }

    /// Adds the cores with their stubs, and cuts the sockets into the lowest piece.
    fn add_cores(
        &mut self,
        part: &Part,
        method: Method,
        level: Option<f64>,
        config: &Config,
    ) -> Result<(), MoldError> {
        let single = part.cores.len() == 1;
        for (i, core) in part.cores.iter().enumerate() {
            let mut solid = core.solid.clone();
            let mut held = None;
            for inlet in &core.inlets {
                let floor = self.block.min.z;
                let print = Print::new(inlet.centre, inlet.radius, floor, &self.cast, config)?;
                solid = solid.union(&print.stub_solid());
                let holder = self.shells.last_mut().expect("there are shells");
                holder.solid = holder.solid.difference(&print.socket_solid());
                if method == Method::Soluble {
                    solid = self.bore(solid, &print, core, config);
                }
                let frustum = print.socket.clone();
                self.features.push(Feature { purpose: Purpose::Socket, frustum });
                held = Some((inlet.centre, print));
            }
            if let Some(held) = held {
                solid = self.support(core, &held, solid, level, config);
            }
            let name = if single { "core".into() } else { format!("core{}", i + 1) };
            self.cores.push(Piece { name, solid, leaves: -Vec3::z() });
        }
        Ok(())
    }

    /// A soluble core with a bore for water, if there is room for one.
    fn bore(&mut self, solid: Solid, print: &Print, core: &Core, config: &Config) -> Solid {
        let Some(frustum) = drain(&print.stub, &core.solid, config) else {
            let message = format!(
                "no upright bore of core.drain = {1:.2} mm within core.skin = {2:.2} mm fits into a stub of {0:.2} mm \
                 radius and the core above it: water dissolves the core from its end only",
                print.stub.base_radius * 1e3,
                config.core.drain * 1e3,
                config.core.skin * 1e3
            );
            self.findings.push(Finding { rule: "drain", message, count: 1 });
            return solid;
        };
        let solid = solid.difference(&frustum.solid());
        self.features.push(Feature { purpose: Purpose::Drain, frustum });
        solid
    }

    /// A core that is held at one inlet, with a pin if it needs one, and what to know of it.
    fn support(
        &mut self,
        core: &Core,
        (inlet, print): &(Vec3, Print),
        solid: Solid,
        level: Option<f64>,
        config: &Config,
    ) -> Solid {
        let surface = core.solid.to_surface();
        let density = config.density().unwrap_or(support::SILICONE);
        let clearance = config.stub_clearance();
        let sag = support::sag(&surface, inlet, &print.stub, clearance, density);
        let wanted = match config.core.support {
            Support::Auto => sag.bend > config.limits.sag,
            Support::Pin => true,
            Support::Stub => false,
        };
        let top = self.block.max.z - clearance;
        let pin = || pin::pin(&surface, inlet, config.core.pin, top, level);
        let Some(pin) = wanted.then(pin).flatten() else {
            self.findings.extend(moves(&sag, config.limits.sag));
            return solid;
        };
        let base = pin.base * 1e3;
        self.findings.push(Finding {
            rule: "pin",
            message: format!(
                "a pin of {:.1} mm radius holds the core at ({:.1}, {:.1}) mm; plug the hole it leaves in the \
                 silicone",
                pin.base_radius * 1e3,
                base.x,
                base.y
            ),
            count: 1,
        });
        let around = clearance + pin.base_radius;
        let hole = Frustum {
            axis: pin.axis + Vec3::z() * (clearance + BEYOND),
            base_radius: around,
            top_radius: around,
            ..pin.clone()
        };
        let pin = pin.solid();
        self.cast = self.cast.difference(&pin);
        self.cut(Purpose::Pin, hole);
        solid.union(&pin)
    }

    /// Cuts sprue and vents out of the shells.
    fn add_channels(
        &mut self,
        skin: &Skin,
        filled: &SurfaceMesh,
        config: &Config,
    ) -> Result<(), MoldError> {
        let bvh = SurfaceBvh::new(filled);
        let places = venting::places(skin, &self.frame, self.portion, &bvh, config)?;
        self.findings.extend(places.findings);
        let end = self.block.max.z + BEYOND;
        let Sprue { radius, top_radius, head, .. } = config.sprue;
        let sprue = channel(&bvh, &places.sprue, end, radius, top_radius);
        if let Some(head) = head {
            self.add_funnel(&sprue, head, config);
        }
        self.cut(Purpose::Sprue, sprue);
        let radius = config.vents.radius;
        for top in &places.vents {
            self.cut(Purpose::Vent, channel(&bvh, top, end, radius, radius));
        }
        Ok(())
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

/// Tells how far a core may move that is held at one end.
fn moves(sag: &Sag, limit: f64) -> Option<Finding> {
    let Sag { lift, reach, bend, lean } = *sag;
    if bend.max(lean) <= limit {
        return None;
    }
    let advice = match bend <= limit {
        true => "glue the stub into its socket",
        false => "widen the inlet, or cast halves",
    };
    Some(Finding {
        rule: "core support",
        message: format!(
            "the core reaches {:.1} mm from its inlet. Floating with up to {lift:.3} N it bends by up to \
             {:.2} mm there, and the play of the stub lets it lean by up to {:.2} mm, limits.sag is {:.2} mm: {advice}",
            reach * 1e3,
            bend * 1e3,
            lean * 1e3,
            limit * 1e3
        ),
        count: 1,
    })
}
