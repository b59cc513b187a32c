//! Whether a core stays in its place, and the pins that hold it there.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::cast_body::CastBody;
use super::features::pin::{self, NEAR, Pin, Site, Tried};
use super::features::support::{Contact, SILICONE, Stand};
use super::mount::Mount;
use super::piece::Piece;
use crate::config::{Casts, Config, Support};
use crate::geometry::frustum::Frustum;
use crate::geometry::walls::too_thin;

/// How a core is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// Name of the core.
    pub core: String,
    /// Centre of its inlet [m].
    pub inlet: Vec3,
    /// The stub.
    pub stub: Frustum,
    /// Play of its stub and of pins [m].
    pub clearance: f64,
    /// Density of the silicone in which it floats [kg/m³].
    pub density: f64,
    /// Motion of its farthest point that is not reported [m].
    pub limit: f64,
    /// Motion of its farthest point on the stub alone [m].
    pub alone: f64,
    /// Motion of its farthest point with its pins [m].
    pub held: f64,
    /// Thickness of the silicone at each pin [m].
    pub lengths: Vec<f64>,
    /// Silicone that closes the holes of its pins [m³].
    pub plugs: f64,
}

/// A core on its stub, of which it is to be seen whether that holds it.
pub struct Standing<'a> {
    /// Its name.
    pub name: &'a str,
    /// The body that is cast.
    pub body: &'a CastBody,
    /// Which of the body's cores it is.
    pub index: usize,
    /// The core with its stub.
    pub solid: &'a Solid,
    /// Centre of its inlet [m].
    pub inlet: Vec3,
    /// The stub.
    pub stub: Frustum,
}

/// How a core is held, and by which pins.
pub struct Held {
    /// The pins.
    pub pins: Vec<Pin>,
    /// What a person should know.
    pub finding: Option<Finding>,
    /// How it is held.
    pub hold: Hold,
}

/// No place for a pin that was asked for.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PinError {
    /// Nowhere.
    #[error(
        "core.support = \"pin\": no pin of {:.2} mm radius finds room at the {core}: {tried}; at {left} places it \
         would be too near to sprue or vents, or leave silicone thinner than casting.least_wall; make core.pin \
         thinner, move sprue.at, or hold the core by its stub",
        radius * 1e3
    )]
    Nowhere {
        /// Name of the core.
        core: String,
        /// Radius of the pin [m].
        radius: f64,
        /// What was tried.
        tried: Tried,
        /// Places that were left.
        left: usize,
    },
    /// Not where it was asked for.
    #[error(
        "core.pins: no pin of {:.2} mm radius can stand within {:.1} mm of ({x}, {y}, {z}) m: {tried}; at {left} \
         places it would be too near to sprue, vents or another pin, or leave silicone thinner than \
         casting.least_wall; choose another point, or leave core.pins out",
        radius * 1e3, NEAR * radius * 1e3, x = at[0], y = at[1], z = at[2]
    )]
    NotThere {
        /// The point [m].
        at: [f64; 3],
        /// Radius of the pin [m].
        radius: f64,
        /// What was tried.
        tried: Tried,
        /// Places that were left.
        left: usize,
    },
}

/// Holds a core on its stub, by pins of the shells if it needs them or they are asked for. `cast` is what is cast, with
/// the holes of other cores' pins.
pub fn hold(
    standing: &Standing,
    cast: &Solid,
    shells: &[Piece],
    mount: &Mount,
) -> Result<Held, PinError> {
    let Standing { name, body, index, solid, inlet, stub } = standing;
    let config = mount.config;
    let chamber = body.cores[*index].solid.to_surface();
    let density = config.density().unwrap_or(SILICONE);
    let clearance = config.stub_clearance();
    let stand = Stand::new(&chamber, inlet, stub, clearance, density);
    let bvh = |solid: &Solid| SurfaceBvh::new(&solid.to_surface());
    let [core, filled] = [*solid, &body.filled].map(bvh);
    let cores: Vec<SurfaceBvh> = body.cores.iter().map(|core| bvh(&core.solid)).collect();
    let around: Vec<(SurfaceBvh, Vec3)> =
        shells.iter().map(|shell| (bvh(&shell.solid), shell.demolding)).collect();
    let site = Site {
        chamber: &chamber,
        core: &core,
        filled: &filled,
        cores: &cores,
        shells: &around,
        radius: config.core.pin,
        play: clearance,
        skin: config.core.skin,
    };
    let channels: Vec<Solid> =
        mount.channels.iter().map(|channel| channel.frustum.solid()).collect();
    let fits = |pin: &Pin, others: &[Pin]| {
        let beside = shells.iter().enumerate().filter(|(i, _)| *i != pin.shell);
        pin.is_beside(beside.map(|(_, shell)| &shell.solid))
            && pin.is_clear(&channels, others, config.core.skin)
            && leaves_walls(pin, others, body.plain.as_ref().unwrap_or(cast), config)
    };
    let alone = stand.sag(&[]).most();
    let limit = config.limits.sag;
    let asked: Vec<[f64; 3]> = config
        .core
        .pins
        .iter()
        .copied()
        .filter(|at| {
            let at = mount.frame.point(&Vec3::from(*at));
            nearest(&cores, &at) == *index
        })
        .collect();
    let mut tried = None;
    let pins = if !asked.is_empty() {
        placed(&asked, &site, mount, fits)?
    } else if config.core.support == Support::Pin {
        let (offered, tried) = site.pins(None);
        let none = || PinError::Nowhere {
            core: (*name).into(),
            radius: site.radius,
            tried,
            left: offered.len(),
        };
        // One even where the core stays within the limit.
        let chosen = pin::choose(&stand, &offered, limit.min(0.999 * alone), fits);
        if chosen.is_empty() {
            return Err(none());
        }
        chosen
    } else if config.core.support == Support::Auto && !mount.method.core.is_cast() && alone > limit
    {
        let (offered, places) = site.pins(None);
        tried = Some((places, offered.len()));
        let chosen = pin::choose(&stand, &offered, limit, fits);
        // Pins that hold nothing leave holes for nothing.
        if pin::hold(&stand, &chosen) { chosen } else { Vec::new() }
    } else {
        Vec::new()
    };
    let contacts: Vec<Contact> = pins.iter().map(|pin| pin.contact).collect();
    let held = stand.sag(&contacts);
    let finding = match pins.is_empty() {
        true => unheld(name, &stand, limit, tried),
        false => Some(pinned(name, &pins, shells, [alone, held.most(), limit])),
    };
    let hold = Hold {
        core: (*name).into(),
        inlet: *inlet,
        stub: stub.clone(),
        clearance,
        density,
        limit,
        alone,
        held: held.most(),
        lengths: pins.iter().map(|pin| pin.length).collect(),
        plugs: pins.iter().map(|pin| pin.hole).sum(),
    };
    Ok(Held { pins, finding, hold })
}

/// The core whose surface is nearest to a point.
fn nearest(cores: &[SurfaceBvh], at: &Vec3) -> usize {
    let far = |i: &usize| cores[*i].closest(at).distance;
    (0..cores.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_default()
}

/// A pin beside each of the points asked for, as near to it as one can stand.
fn placed(
    asked: &[[f64; 3]],
    site: &Site,
    mount: &Mount,
    fits: impl Fn(&Pin, &[Pin]) -> bool,
) -> Result<Vec<Pin>, PinError> {
    let mut pins: Vec<Pin> = Vec::new();
    for at in asked {
        let point = mount.frame.point(&Vec3::from(*at));
        let (mut offered, tried) = site.pins(Some(&point));
        let off = |pin: &Pin| {
            let Frustum { base, axis, .. } = &pin.frustum;
            let along = ((point - base).dot(axis) / axis.norm_squared()).clamp(0.0, 1.0);
            (point - base - axis * along).norm()
        };
        offered.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let left = offered.len();
        let found = offered.into_iter().find(|pin| fits(pin, &pins));
        let radius = site.radius;
        pins.push(found.ok_or(PinError::NotThere { at: *at, radius, tried, left })?);
    }
    Ok(pins)
}

/// Whether the silicone around a pin and others is thick enough.
fn leaves_walls(pin: &Pin, others: &[Pin], cast: &Solid, config: &Config) -> bool {
    let all = others.iter().chain([pin]);
    let around = all.fold(cast.clone(), |cast, pin| cast.difference(&pin.frustum.solid()));
    too_thin((&around.to_surface(), Casts::Mesh), None, config.casting.least_wall).is_none()
}

/// Tells of the pins of a core, which moves by so much alone, with them, and at most [m].
fn pinned(name: &str, pins: &[Pin], shells: &[Piece], [alone, held, limit]: [f64; 3]) -> Finding {
    let each: Vec<String> = pins
        .iter()
        .map(|pin| {
            let at = pin.contact.at * 1e3;
            let shell = &shells[pin.shell].name;
            format!("of {shell} at ({:.1}, {:.1}, {:.1}) mm", at.x, at.y, at.z)
        })
        .collect();
    let (count, s) = match pins.len() {
        1 => ("a pin".into(), "s"),
        n => (format!("{n} pins"), ""),
    };
    let more = match held <= limit {
        true => String::new(),
        false => {
            ", still more than that: make core.pin thinner, widen the inlet, or lengthen core.length".into()
        }
    };
    Finding {
        rule: "pin",
        message: format!(
            "{count} of {:.1} mm radius, {}, hold{s} the {name}: its far end moves by up to {:.2} mm, in place of \
             {:.2} mm on its stub alone, limits.sag is {:.2} mm{more}. Close the hole{} in the silicone, as the steps say",
            pins[0].frustum.base_radius * 1e3,
            each.join(", "),
            held * 1e3,
            alone * 1e3,
            limit * 1e3,
            if pins.len() == 1 { "" } else { "s" },
        ),
        count: pins.len(),
    }
}

/// Reports how far a core may move that is held at one end, and why no pin holds it, if places were tried.
fn unheld(name: &str, stand: &Stand, limit: f64, tried: Option<(Tried, usize)>) -> Option<Finding> {
    let sag = stand.sag(&[]);
    if sag.most() <= limit {
        return None;
    }
    let advice = match sag.bend <= limit {
        true => "glue the stub into its socket",
        false => "widen the inlet, or cast halves",
    };
    let tried = tried.map_or(String::new(), |(tried, left)| {
        format!("No pin can hold it: {tried}; the other {left} hold too little, are too near to sprue or vents, or \
                 leave silicone thinner than casting.least_wall. ")
    });
    Some(Finding {
        rule: "core support",
        message: format!(
            "the {name} reaches {:.1} mm from its inlet. Floating with up to {:.3} N it bends by up to \
             {:.2} mm there, and the play of the stub lets it lean by up to {:.2} mm, limits.sag is {:.2} mm. {tried}\
             {}{}",
            stand.reach * 1e3,
            stand.lift,
            sag.bend * 1e3,
            sag.lean * 1e3,
            limit * 1e3,
            advice[..1].to_uppercase(),
            &advice[1..]
        ),
        count: 1,
    })
}
