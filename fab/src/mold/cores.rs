//! Cores on their stubs, with bores for water and pins.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::MoldError;
use super::cast_body::{CastBody, Core};
use super::features::core::{Print, drain};
use super::features::pin::{PinSpace, pin};
use super::features::support::{self, Sag};
use super::piece::{Feature, Piece, Purpose, cut};
use crate::config::method::Method;
use crate::config::{Config, Support};
use crate::geometry::frustum::Frustum;
use crate::geometry::walls::too_thin;

/// A bore that reaches less far into its core than this part of the core's height is
/// pointed out.
const SHORT: f64 = 0.5;

/// The cores of a mold, and what they make of its shells and of what is cast.
pub struct Cores {
    /// One per chamber.
    pub pieces: Vec<Piece>,
    /// The shells, the last with sockets, all with holes for pins.
    pub shells: Vec<Piece>,
    /// What is cast, without pins.
    pub cast: Solid,
    /// Sockets, bores for water and holes for pins.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
}

/// What surrounds the cores.
pub struct Mount<'a> {
    /// How the cores leave the body.
    pub method: Method,
    /// Outside of the closed mold.
    pub outside: &'a Solid,
    /// Height to which stubs reach [m].
    pub floor: f64,
    /// Height to which holes reach [m].
    pub end: f64,
    /// The plane y = level on which sides meet, if there are any [m].
    pub level: Option<f64>,
    /// Sprue and vents.
    pub channels: &'a [Feature],
    /// What was asked for.
    pub config: &'a Config,
}

/// A core on a pin, if it needs one.
struct Supported {
    solid: Solid,
    /// The pin, and the hole for it in the shells.
    pin: Option<(Solid, Feature)>,
    finding: Option<Finding>,
}

/// A core with a bore for water, if one fits.
struct Bored {
    solid: Solid,
    bore: Option<Feature>,
    finding: Option<Finding>,
}

impl Cores {
    /// None: the shells as they are.
    #[must_use]
    pub fn none(body: &CastBody, shells: Vec<Piece>) -> Self {
        let (features, findings) = (Vec::new(), Vec::new());
        Self { pieces: Vec::new(), shells, cast: body.cast.clone(), features, findings }
    }

    /// The cores of a body with their stubs, and sockets for these in the last of the shells.
    ///
    /// # Errors
    /// If a stub does not fit its inlet, or a pin that was asked for finds no place.
    pub fn new(body: &CastBody, shells: Vec<Piece>, mount: &Mount) -> Result<Self, MoldError> {
        let single = body.cores.len() == 1;
        let none = Self::none(body, shells);
        body.cores.iter().enumerate().try_fold(none, |cores, (i, core)| {
            let name = if single { "core".into() } else { format!("core{}", i + 1) };
            cores.and(name, core, mount)
        })
    }

    /// These and one more.
    fn and(self, name: String, core: &Core, mount: &Mount) -> Result<Self, MoldError> {
        let Self { mut pieces, mut shells, mut cast, mut features, mut findings } = self;
        let mut solid = core.solid.clone();
        let mut held = None;
        for inlet in &core.inlets {
            let (centre, radius) = (inlet.centre, inlet.radius);
            let print = Print::new(centre, radius, mount.floor, &cast, mount.config)?;
            solid = solid.union(&print.stub_solid());
            let holder = shells.last_mut().expect("there are shells");
            holder.solid = holder.solid.difference(&print.socket_solid());
            if mount.method == Method::Soluble {
                let bored = bored(solid, &print, core, mount.config);
                solid = bored.solid;
                features.extend(bored.bore);
                findings.extend(bored.finding);
            }
            let frustum = print.socket.clone();
            features.push(Feature { purpose: Purpose::Socket, frustum });
            held = Some((centre, print));
        }
        if let Some((inlet, print)) = held {
            let supported = supported(core, solid, &cast, (&inlet, &print), mount)?;
            solid = supported.solid;
            findings.extend(supported.finding);
            if let Some((pin, hole)) = supported.pin {
                cast = cast.difference(&pin);
                shells = cut(shells, std::slice::from_ref(&hole));
                features.push(hole);
            }
        }
        pieces.push(Piece { name, solid, demolding: -Vec3::z() });
        Ok(Self { pieces, shells, cast, features, findings })
    }
}

/// A soluble core with a bore for water along its stub.
fn bored(solid: Solid, print: &Print, core: &Core, config: &Config) -> Bored {
    let finding = |message| Some(Finding { rule: "drain", message, count: 1 });
    let Some(frustum) = drain(&print.stub, &core.solid, config) else {
        let message = format!(
            "no upright bore of core.drain = {1:.2} mm within core.skin = {2:.2} mm fits into a stub of {0:.2} mm \
             radius and the core above it: water dissolves the core from its end only",
            print.stub.base_radius * 1e3,
            config.core.drain * 1e3,
            config.core.skin * 1e3
        );
        return Bored { solid, bore: None, finding: finding(message) };
    };
    let (low, high) = core.solid.bounds();
    let [reach, height] = [frustum.base.z + frustum.axis.z - low.z, high.z - low.z];
    let short = (reach < SHORT * height).then(|| {
        format!(
            "the bore for water ends {:.1} mm above the inlet, where less than core.skin = {:.2} mm of the core \
             would be left around it; the core is {:.1} mm high: change the water more often",
            reach * 1e3,
            config.core.skin * 1e3,
            height * 1e3
        )
    });
    let solid = solid.difference(&frustum.solid());
    let bore = Some(Feature { purpose: Purpose::Drain, frustum });
    Bored { solid, bore, finding: short.and_then(finding) }
}

/// A core that is held at one inlet, on a pin if it needs one. The pin keeps clear of the
/// channels and leaves walls of what is cast that are thick enough; between shells that part
/// sideways it stands on their plane.
fn supported(
    core: &Core,
    solid: Solid,
    cast: &Solid,
    (inlet, print): (&Vec3, &Print),
    mount: &Mount,
) -> Result<Supported, MoldError> {
    let config = mount.config;
    let surface = core.solid.to_surface();
    let density = config.density().unwrap_or(support::SILICONE);
    let clearance = config.stub_clearance();
    let sag = support::sag(&surface, inlet, &print.stub, clearance, density);
    let radius = config.core.pin;
    let outside = mount.outside.to_surface();
    let leaves_walls = |pin: &Frustum| {
        let around = cast.difference(&pin.solid()).to_surface();
        too_thin(&around, config.casting.least_wall).is_none()
    };
    let space = PinSpace {
        outside: &SurfaceBvh::new(&outside),
        channels: mount.channels.iter().map(|channel| &channel.frustum).collect(),
        clearance,
        level: mount.level,
        leaves_walls: &leaves_walls,
    };
    let found = match config.core.support {
        Support::Auto if sag.bend <= config.limits.sag => None,
        Support::Auto => pin(&surface, inlet, radius, &space).ok(),
        Support::Pin => Some(pin(&surface, inlet, radius, &space)?),
        Support::Stub => None,
    };
    let Some(pin) = found else {
        return Ok(Supported { solid, pin: None, finding: moves(&sag, config.limits.sag) });
    };
    let base = pin.base * 1e3;
    let finding = Finding {
        rule: "pin",
        message: format!(
            "a pin of {:.1} mm radius holds the core at ({:.1}, {:.1}) mm; plug the hole it leaves in the \
             silicone",
            pin.base_radius * 1e3,
            base.x,
            base.y
        ),
        count: 1,
    };
    let around = clearance + pin.base_radius;
    let hole = Frustum {
        axis: Vec3::z() * (mount.end - pin.base.z),
        base_radius: around,
        top_radius: around,
        ..pin.clone()
    };
    let pin = pin.solid();
    let solid = solid.union(&pin);
    let hole = Feature { purpose: Purpose::Pin, frustum: hole };
    Ok(Supported { solid, pin: Some((pin, hole)), finding: Some(finding) })
}

/// Reports how far a core may move that is held at one end.
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
