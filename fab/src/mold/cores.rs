//! Cores on their stubs, with bores for water and pins.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::MoldError;
use super::cast_body::{CastBody, Core};
use super::features::core::{Print, drain};
use super::features::keying::{self, Code};
use super::features::number;
use super::features::pin::{PinSpace, pin};
use super::features::support::{self, Sag};
use super::numbering::Numbers;
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
    /// Outside of the closed mold, with the numbers of sockets.
    pub outside: Solid,
    /// What is cast, without pins.
    pub cast: Solid,
    /// Sockets, bores for water and holes for pins.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
    /// Whether each core fits into its own socket only, and there one way only.
    pub one_way: bool,
    /// Whether cores and sockets carry numbers.
    pub numbered: bool,
    /// Where its stubs stand, core by core [m].
    stands: Vec<Vec<Print>>,
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
    pub fn none(body: &CastBody, shells: Vec<Piece>, outside: &Solid) -> Self {
        Self {
            pieces: Vec::new(),
            shells,
            outside: outside.clone(),
            cast: body.cast.clone(),
            features: Vec::new(),
            findings: Vec::new(),
            one_way: true,
            numbered: false,
            stands: Vec::new(),
        }
    }

    /// The cores of a body with their stubs, and sockets for these in the last of the shells.
    ///
    /// # Errors
    /// If a stub does not fit its inlet, stubs cannot be told apart, or a pin that was asked for finds
    /// no place.
    pub fn new(body: &CastBody, shells: Vec<Piece>, mount: &Mount) -> Result<Self, MoldError> {
        let none = Self::none(body, shells, mount.outside);
        if body.cores.len() < 2 {
            let single = |cores: Self, core| cores.and("core".into(), core, None, mount);
            return body.cores.iter().try_fold(none, single);
        }
        let keyed = keyed(&body.cores, mount)?;
        let mut all = none;
        for (i, core) in body.cores.iter().enumerate() {
            let key = keyed.as_ref().map(|(codes, radius)| (codes[i], *radius));
            all = all.and(format!("core{}", i + 1), core, key, mount)?;
        }
        all.one_way &= keyed.is_some();
        Ok(if mount.config.labels && mount.method != Method::Wax { all.numbered() } else { all })
    }

    /// These and one more, on stubs that have a code and are as for an inlet of that radius, or as wide as
    /// each inlet allows.
    fn and(
        self,
        name: String,
        core: &Core,
        key: Option<(Code, f64)>,
        mount: &Mount,
    ) -> Result<Self, MoldError> {
        let Self {
            mut pieces,
            mut shells,
            outside,
            mut cast,
            mut features,
            mut findings,
            mut one_way,
            numbered,
            mut stands,
        } = self;
        let mut solid = core.solid.clone();
        let mut held = None;
        stands.push(Vec::new());
        for inlet in &core.inlets {
            let (centre, radius) = (inlet.centre, key.map_or(inlet.radius, |(_, radius)| radius));
            let code = key.map(|(code, _)| code);
            let print = Print::new(centre, radius, mount.floor, &cast, code, mount.config)?;
            one_way &= print.keeps_from_turning();
            stands.last_mut().expect("it was pushed").push(print.clone());
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
            let supported = supported(&name, core, solid, &cast, (&inlet, &print), mount)?;
            solid = supported.solid;
            findings.extend(supported.finding);
            if let Some((pin, hole)) = supported.pin {
                cast = cast.difference(&pin);
                shells = cut(shells, std::slice::from_ref(&hole));
                features.push(hole);
            }
        }
        pieces.push(Piece { name, solid, demolding: -Vec3::z() });
        Ok(Self { pieces, shells, outside, cast, features, findings, one_way, numbered, stands })
    }

    /// With its number on every stub, and below the piece that holds it beside every socket.
    fn numbered(mut self) -> Self {
        let holder = self.shells.last().expect("there are shells").solid.clone();
        let mut numbers = Numbers::new(&holder, &self.stands);
        for (k, prints) in self.stands.iter().enumerate() {
            for print in prints {
                if let Some(dots) = number::dots(k + 1, &print.front()) {
                    self.pieces[k].solid = self.pieces[k].solid.difference(&dots);
                } else {
                    numbers.without(format!("the stub of core{}", k + 1));
                }
                numbers.add(k + 1, print);
            }
        }
        let holder = self.shells.last_mut().expect("there are shells");
        holder.solid = holder.solid.difference(&numbers.dots);
        self.outside = self.outside.difference(&numbers.dots);
        self.findings.extend(numbers.finding());
        self.numbered = true;
        self
    }
}

/// The codes of several cores, and the radius of the narrowest inlet, for which all of their stubs are
/// made; none if stubs shall be alike.
fn keyed(cores: &[Core], mount: &Mount) -> Result<Option<(Vec<Code>, f64)>, MoldError> {
    let config = mount.config;
    if !config.core.keyed {
        return Ok(None);
    }
    let inlets = || cores.iter().flat_map(|core| &core.inlets);
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
    let radius = least(&mut inlets().map(|inlet| inlet.radius));
    let length =
        least(&mut inlets().map(|inlet| inlet.centre.z)) - (mount.floor + config.stub_clearance());
    let codes = keying::codes(cores.len(), config.stub_radius(radius), length, config)?;
    Ok(Some((codes, radius)))
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
    name: &str,
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
        return Ok(Supported { solid, pin: None, finding: moves(name, &sag, config.limits.sag) });
    };
    let base = pin.base * 1e3;
    let finding = Finding {
        rule: "pin",
        message: format!(
            "a pin of {:.1} mm radius holds the {name} at ({:.1}, {:.1}) mm; plug the hole it leaves in the \
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
fn moves(name: &str, sag: &Sag, limit: f64) -> Option<Finding> {
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
            "the {name} reaches {:.1} mm from its inlet. Floating with up to {lift:.3} N it bends by up to \
             {:.2} mm there, and the play of the stub lets it lean by up to {:.2} mm, limits.sag is {:.2} mm: {advice}",
            reach * 1e3,
            bend * 1e3,
            lean * 1e3,
            limit * 1e3
        ),
        count: 1,
    })
}
