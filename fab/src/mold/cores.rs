//! Cores on their stubs, with bores for water and pits for pins.

use mesh::Vec3;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::MoldError;
use super::cast_body::{CastBody, Core};
use super::features::core::{Print, drain};
use super::features::keying::{self, Code};
use super::features::number;
use super::holding::{self, Hold, Solids};
use super::mount::Mount;
use super::numbering::Numbers;
use super::piece::{Feature, Piece, Purpose};
use crate::config::Config;

/// A bore that reaches less far into its core than this part of the core's height is
/// pointed out.
const SHORT: f64 = 0.5;

/// The cores of a mold, and what they make of its shells and of what is cast.
pub struct Cores {
    /// One per chamber.
    pub pieces: Vec<Piece>,
    /// The shells, the last with sockets, and with pins that hold cores.
    pub shells: Vec<Piece>,
    /// Outside of the closed mold, with the numbers of sockets.
    pub outside: Solid,
    /// What is cast, with the holes of pins.
    pub cast: Solid,
    /// Sockets, bores for water and pins.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
    /// How each core is held.
    pub holds: Vec<Hold>,
    /// Whether each core fits into its own socket only, and there one way only.
    pub one_way: bool,
    /// Whether cores and sockets carry numbers.
    pub numbered: bool,
    /// Where its stubs stand, core by core [m].
    stands: Vec<Vec<Print>>,
}

/// A core with a bore for water, if one fits.
struct Bored {
    solid: Solid,
    bore: Option<Feature>,
    finding: Option<Finding>,
}

impl Cores {
    /// None: the shells as they are.
    pub fn none(body: &CastBody, shells: Vec<Piece>, outside: &Solid) -> Self {
        Self {
            pieces: Vec::new(),
            shells,
            outside: outside.clone(),
            cast: body.cast.clone(),
            features: Vec::new(),
            findings: Vec::new(),
            holds: Vec::new(),
            one_way: true,
            numbered: false,
            stands: Vec::new(),
        }
    }

    /// The cores of a body with their stubs, and sockets for these in the last of the shells.
    pub fn new(body: &CastBody, shells: Vec<Piece>, mount: &Mount) -> Result<Self, MoldError> {
        let none = Self::none(body, shells, mount.outside);
        if body.cores.len() < 2 {
            let single = |cores: Self, index| cores.and("core".into(), body, index, None, mount);
            return (0..body.cores.len()).try_fold(none, single);
        }
        let keyed = keyed(&body.cores, mount)?;
        let mut all = none;
        for i in 0..body.cores.len() {
            let key = keyed.as_ref().map(|(codes, radius)| (codes[i], *radius));
            all = all.and(format!("core{}", i + 1), body, i, key, mount)?;
        }
        all.one_way &= keyed.is_some();
        Ok(if mount.config.labels && !mount.method.core.is_cast() { all.numbered() } else { all })
    }

    /// These and one more, on stubs that have a code and are as for an inlet of that radius, or as wide as
    /// each inlet allows.
    fn and(
        self,
        name: String,
        body: &CastBody,
        index: usize,
        key: Option<(Code, f64)>,
        mount: &Mount,
    ) -> Result<Self, MoldError> {
        let core = &body.cores[index];
        let Self {
            mut pieces,
            mut shells,
            outside,
            mut cast,
            mut features,
            mut findings,
            mut holds,
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
            if mount.method.core.is_bored {
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
            let (solids, pieces) = (Solids { core: solid, cast }, shells);
            let held =
                holding::hold(&name, (body, index), solids, pieces, (&inlet, &print), mount)?;
            (solid, cast, shells) = (held.solids.core, held.solids.cast, held.shells);
            features.extend(held.features);
            findings.extend(held.finding);
            holds.push(held.hold);
        }
        pieces.push(Piece { name, solid, demolding: -Vec3::z() });
        Ok(Self {
            pieces,
            shells,
            outside,
            cast,
            features,
            findings,
            holds,
            one_way,
            numbered,
            stands,
        })
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
