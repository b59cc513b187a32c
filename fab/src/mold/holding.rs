//! Whether a core stays in its place, and the pins that hold it there.

use anyhow::{Context, Result, ensure};
use geometry::frame::Frame;
use geometry::frustum::Frustum;
use geometry::{MM, Triple, place};
use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Mold;
use super::division::Blank;
use super::features::pin::{self, NEAR, Pin, Site, Tried};
use super::features::support::{SILICONE, Stand};
use super::piece::{Feature, Piece, Purpose};
use crate::body::walls::too_thin;
use crate::config::{Casts, Config, Support};

/// How a core is held.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Holding {
    /// Name of the core.
    pub core: String,
    /// Centre of its inlet [mm].
    pub inlet: Triple,
    /// Radius of its stub [mm].
    pub stub_radius: f64,
    /// Length of its stub below the inlet [mm].
    pub stub_length: f64,
    /// Play of its stub and of pins [mm].
    pub clearance: f64,
    /// Density of the silicone in which it floats [kg/m³].
    pub density: f64,
    /// Motion of its farthest point that is not reported [mm].
    pub limit: f64,
    /// Motion of its farthest point on the stub alone [mm].
    pub alone: f64,
    /// Motion of its farthest point with its pins [mm].
    pub held: f64,
    /// Thickness of the silicone at each of its pins, in the order of `features` [mm].
    pub lengths: Vec<f64>,
    /// Silicone that closes the holes of its pins [mm³].
    pub plugs: f64,
}

/// Part of casting.least_wall that must be left beside a core that moves: a judgement.
const LEFT: f64 = 0.5;

impl Mold {
    /// How far cores move, in words, that move by more than `limits.sag`, and so far that less than half of `least_wall` [m]
    /// is left beside them.
    pub fn leaning(&self, least_wall: f64) -> Vec<String> {
        let least = LEFT * least_wall * MM;
        let words = |hold: &Holding| {
            let left = self.left_beside(hold, 2.0 * least_wall) * MM;
            let Holding { core, held, alone, lengths, .. } = hold;
            let (pins, s) = (lengths.len(), if lengths.len() == 1 { "" } else { "s" });
            let said = format!(
                "{core} would move by {held:.2} mm on its stub and {pins} pin{s}, {alone:.2} mm on its stub alone, {:.2} mm from \
                 mold and other cores then, where {least:.2} mm must be left",
                left.max(0.0)
            );
            (left < least).then_some(said)
        };
        self.holds.iter().filter(|hold| hold.held > hold.limit).filter_map(words).collect()
    }

    /// What is left between a core and the mold or another core when it turns about its inlet [m]: each point of it moves
    /// in proportion to its distance from the inlet. Not within the distance `apart` of the piece on which it stands and of
    /// pins [m].
    fn left_beside(&self, hold: &Holding, apart: f64) -> f64 {
        let inlet = Vec3::from(hold.inlet) / MM;
        let (own, others): (Vec<&Piece>, Vec<&Piece>) =
            self.cores.iter().partition(|core| core.name == hold.core);
        let others = others.into_iter().chain(&self.shells);
        let others: Vec<SurfaceBvh> =
            others.map(|piece| SurfaceBvh::new(&piece.solid.to_surface())).collect();
        let pins = self.features.iter().filter(|feature| feature.purpose == Purpose::Pin);
        let pins: Vec<&Frustum> = pins.map(|pin| &pin.frustum).collect();
        let vertices: Vec<Vec3> =
            own.into_iter().flat_map(|core| core.solid.to_surface().vertices).collect();
        let above = vertices.iter().filter(|p| p.z >= inlet.z);
        let reach = above.map(|p| (p - inlet).norm()).fold(0.0, f64::max);
        let free = |p: &&Vec3| {
            let beside = |pin: &&Frustum| pin.from_axis(p) > apart + pin.base_radius;
            p.z > inlet.z + apart && pins.iter().all(beside)
        };
        let left = vertices.iter().filter(free).flat_map(|p| {
            let moves = hold.held / MM * (p - inlet).norm() / reach;
            others.iter().map(move |other| other.closest(p).distance - moves)
        });
        left.fold(f64::INFINITY, f64::min)
    }
}

/// A core on its stub, of which it is to be seen whether that holds it.
pub struct Standing<'a> {
    /// Its name.
    pub name: &'a str,
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
    pub hold: Holding,
}

/// Holds a core on its stub, by pins of the shells if it needs them or they are asked for, beside the channels. `cast` is
/// what is cast, with the holes of other cores' pins.
pub fn hold(
    standing: &Standing,
    cast: &Solid,
    shells: &[Piece],
    channels: &[Feature],
    blank: &Blank,
) -> Result<Held> {
    let Standing { name, index, solid, inlet, stub } = standing;
    let Blank { body, frame, config, .. } = blank;
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
    let channels: Vec<Solid> = channels.iter().map(|channel| channel.frustum.solid()).collect();
    let fits = |pin: &Pin, others: &[Pin]| {
        let beside = shells.iter().enumerate().filter(|(i, _)| *i != pin.shell);
        pin.is_beside(beside.map(|(_, shell)| &shell.solid))
            && pin.is_clear(&channels, others, config.core.skin)
            && leaves_walls(pin, others, body.plain.as_ref().unwrap_or(cast), config)
    };
    let alone = stand.sag(&[]).most();
    let limit = config.limits.sag;
    let belongs = |at: &&[f64; 3]| nearest(&cores, &frame.point(&Vec3::from(**at))) == *index;
    let asked: Vec<&[f64; 3]> = config.core.pins.iter().filter(belongs).collect();
    let mut tried = None;
    let pins = if !asked.is_empty() {
        placed(&asked, &site, frame, fits)?
    } else if config.core.support == Support::Pin {
        let (offered, tried) = site.pins(None);
        // One even where the core stays within the limit.
        let chosen = pin::choose(&stand, &offered, limit.min(0.999 * alone), fits);
        ensure!(
            !chosen.is_empty(),
            "core.support = \"pin\": no pin of {:.2} mm radius finds room at the {name}: {tried}; at {} places it would be too \
             near to sprue or vents, or leave silicone thinner than casting.least_wall; make core.pin thinner, move sprue.at, \
             or hold the core by its stub",
            site.radius * 1e3,
            offered.len()
        );
        chosen
    } else if config.core.support == Support::Auto && alone > limit {
        let (offered, places) = site.pins(None);
        tried = Some((places, offered.len()));
        let chosen = pin::choose(&stand, &offered, limit, fits);
        // Pins that hold nothing leave holes for nothing.
        if pin::hold(&stand, &chosen) { chosen } else { Vec::new() }
    } else {
        Vec::new()
    };
    let held = pin::sag_with(&stand, &pins).most();
    let finding = match pins.is_empty() {
        true => unheld(name, &stand, limit, tried),
        false => Some(pinned(name, &pins, shells, [alone, held, limit])),
    };
    let hold = Holding {
        core: (*name).into(),
        inlet: (inlet * MM).map(|x| x + 0.0).into(),
        stub_radius: stub.base_radius * MM,
        stub_length: (inlet.z - stub.base.z - stub.axis.z) * MM,
        clearance: clearance * MM,
        density,
        limit: limit * MM,
        alone: alone * MM,
        held: held * MM,
        lengths: pins.iter().map(|pin| pin.length * MM).collect(),
        plugs: pins.iter().map(|pin| pin.hole).sum::<f64>() * MM.powi(3),
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
    asked: &[&[f64; 3]],
    site: &Site,
    frame: &Frame,
    fits: impl Fn(&Pin, &[Pin]) -> bool,
) -> Result<Vec<Pin>> {
    let mut pins: Vec<Pin> = Vec::new();
    for at in asked {
        let point = frame.point(&Vec3::from(**at));
        let (mut offered, tried) = site.pins(Some(&point));
        let off = |pin: &Pin| pin.frustum.from_axis(&point);
        offered.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let left = offered.len();
        let found = offered.into_iter().find(|pin| fits(pin, &pins));
        let nowhere = || {
            let ([x, y, z], radius) = (at, site.radius);
            format!(
                "core.pins: no pin of {:.2} mm radius can stand within {:.1} mm of ({x}, {y}, {z}) m: {tried}; at {left} places \
                 it would be too near to sprue, vents or another pin, or leave silicone thinner than casting.least_wall; \
                 choose another point, or leave core.pins out",
                radius * 1e3,
                NEAR * radius * 1e3
            )
        };
        pins.push(found.with_context(nowhere)?);
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
        .map(|pin| format!("of {} at {}", shells[pin.shell].name, place(&pin.contact.at, 1)))
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
        true => "Glue the stub into its socket",
        false => "Widen the inlet, or cast halves",
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
             {advice}",
            stand.reach * 1e3,
            stand.lift,
            sag.bend * 1e3,
            sag.lean * 1e3,
            limit * 1e3
        ),
        count: 1,
    })
}
