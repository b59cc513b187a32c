//! Cores stay in their places: pins hold them, and what holds them leaves them little play.
//!
//! Pins are looked for in the written parts: that a shell fills each, that it touches a core and stands in a pit of it,
//! and how much play it has there. How far a core moves with this play is computed by `mold::features::support`, as
//! when the pins were chosen.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::solid::Solid;

use super::closed_mold::{Body, ClosedMold};
use super::{Line, Status};
use crate::files::report::{Holding, Outline};
use crate::geometry::MM;
use crate::geometry::frustum::{Frustum, SEGMENTS};
use crate::mold::Purpose;
use crate::mold::features::pin::LAND;
use crate::mold::features::support::{Contact, Stand};

/// A shell moved by this against its demolding direction meets the core below its pins, if they touch it [mm].
const MOVED: f64 = 0.05;

/// Least part of a pin's end that must touch its core, and of the ring around a pit that the core must fill.
const TOUCHES: f64 = 0.5;

/// Least part of its pit that a pin must fill: its radius is at least half of the pit's.
const FILLS: f64 = 0.25;

/// Width of that ring [mm].
const RING: f64 = 0.1;

/// Depth of a pit in which pin and ring are measured, in radii of the pit: half of what pits are deep at least.
const DEPTH: f64 = 0.4;

/// Part of casting.least_wall that must be left beside a core that moves: a judgement.
pub const LEFT: f64 = 0.5;

/// How the check is called that a core stays in its place, after the name of the core.
pub const STAYS: &str = ": stays";

/// A core moves by at most this much more than mold.json says: two digits of it [mm].
const OFF: f64 = 0.01;

/// All checks of what holds cores.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let pins: Vec<&Outline> =
        mold.report.features.iter().filter(|f| f.purpose == Purpose::Pin).collect();
    let mut lines = Vec::new();
    let mut found = Vec::new();
    for (i, outline) in pins.iter().enumerate() {
        let name = format!("pin {}", i + 1);
        lines.push(beside_channels(mold, &name, outline));
        let pin = Found::new(mold, outline);
        lines.extend(pin.lines(&name));
        found.push(pin);
    }
    let said: usize = mold.report.holds.iter().map(|hold| hold.lengths.len()).sum();
    if said != pins.len() {
        let needed = format!("{said}, as cores are held in mold.json");
        lines.push(Line::new("pins", false, pins.len().to_string(), &needed));
    }
    let mut rest = &found[..];
    for hold in &mold.report.holds {
        let (own, others) = rest.split_at(hold.lengths.len().min(rest.len()));
        rest = others;
        lines.push(stays(mold, hold, own));
    }
    lines
}

/// A pin keeps clear of sprue and vents.
fn beside_channels(mold: &ClosedMold, name: &str, pin: &Outline) -> Line {
    let around = frustum(pin).grown(LAND * MM - 4.0 * mold.rounding).solid();
    let channels = mold.report.features.iter();
    let channels = channels.filter(|f| matches!(f.purpose, Purpose::Sprue | Purpose::Vent));
    let near = channels.filter(|channel| !channel.exact().intersection(&around).is_empty()).count();
    let needed = format!("none within {:.0} mm, so that mold is left", LAND * MM);
    Line::new(format!("{name}: beside channels"), near == 0, format!("{near} nearer"), &needed)
}

/// What is found of a pin in the written parts.
struct Found {
    /// The shell that it belongs to.
    shell: String,
    /// The core that it touches.
    core: String,
    /// Part of the section of its outline that the shell fills in the pit [1].
    filled: f64,
    /// Part of that section with which it touches the core [1].
    touched: f64,
    /// Part of the ring around the pit that the core fills [1].
    ringed: f64,
    /// Where it holds the core [mm].
    contact: Contact,
}

impl Found {
    fn new(mold: &ClosedMold, outline: &Outline) -> Self {
        let radius = outline.base_radius;
        let (base, axis) = (Vec3::from(outline.base), Vec3::from(outline.axis));
        let out = axis.try_normalize(0.0).unwrap_or_else(Vec3::z);
        let deep = out * (DEPTH * radius);
        let column = |radius: f64, base: Vec3, axis: Vec3| {
            Solid::cylinder(&base, &axis, radius, radius, SEGMENTS)
        };
        let pit = column(radius, base, deep);
        let shared = |body: &&Body, with: &Solid| body.solid.intersection(with).volume();
        let most = |bodies: &[Body], with: &Solid| {
            let each = bodies.iter().map(|body| (shared(&body, with), body.name.clone()));
            each.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
        };
        let (inside, shell) = most(&mold.shells, &pit);
        // Below the pit, as deep as the shell is moved.
        let below = column(radius, base, -out * MOVED);
        let moved = mold.shells.iter().find(|body| body.name == shell);
        let moved = moved.map(|body| body.solid.translate(&(-out * MOVED)).intersection(&below));
        let touched = |core: &Body| {
            moved.as_ref().map_or(0.0, |moved| moved.intersection(&core.solid).volume())
        };
        let core = mold.cores.iter().max_by(|a, b| touched(a).total_cmp(&touched(b)));
        let ring = column(radius + RING, base, deep).difference(&pit);
        let filled = inside / pit.volume();
        // A pin of the radius r fills (r/R)² of its pit.
        let play = (radius * (1.0 - filled.max(0.0).sqrt())).max(0.0);
        Self {
            filled,
            touched: core.map_or(0.0, touched) / below.volume(),
            ringed: core.map_or(0.0, |core| shared(&core, &ring)) / ring.volume(),
            core: core.map_or(String::new(), |core| core.name.clone()),
            shell,
            contact: Contact { at: base, out, play },
        }
    }

    /// It is one with a shell, and holds a core across and along itself.
    fn lines(&self, name: &str) -> [Line; 2] {
        let Self { shell, core, filled, touched, ringed, .. } = self;
        [
            Line::new(
                format!("{name}: touches the core"),
                *touched >= TOUCHES * filled && *filled > 0.0,
                format!(
                    "{shell} on {core}, {:.0} % of its end",
                    100.0 * touched / filled.max(1e-9)
                ),
                "at least 50 % of its end",
            ),
            Line::new(
                format!("{name}: stands in its pit"),
                *filled >= FILLS && *ringed >= TOUCHES,
                format!("{:.0} % filled, {:.0} % core around", 100.0 * filled, 100.0 * ringed),
                "at least 25 % filled, 50 % core",
            ),
        ]
    }

    /// Whether it holds a core.
    fn holds(&self, core: &str) -> bool {
        let Self { filled, touched, ringed, .. } = *self;
        self.core == core && filled >= FILLS && touched >= TOUCHES * filled && ringed >= TOUCHES
    }
}

/// A core moves by at most what is allowed, or by what mold.json says where it is not held so well.
fn stays(mold: &ClosedMold, hold: &Holding, pins: &[Found]) -> Line {
    let name = format!("{}{STAYS}", hold.core);
    let Some(core) = mold.cores.iter().find(|core| core.name == hold.core) else {
        return Line::new(name, false, "no such core".into(), "the core of mold.json");
    };
    let inlet = Vec3::from(hold.inlet) / MM;
    let metres = |p: &Vec3| p / MM;
    let mut surface = core.solid.trim_by_plane(&Vec3::z(), hold.inlet[2]).to_surface();
    surface.vertices.iter_mut().for_each(|p| *p = metres(p));
    let stub = Frustum {
        base: inlet,
        axis: -Vec3::z() * (hold.stub_length / MM),
        base_radius: hold.stub_radius / MM,
        top_radius: hold.stub_radius / MM,
    };
    let stand = Stand::new(&surface, &inlet, &stub, hold.clearance / MM, hold.density);
    let contact = |pin: &Found| Contact {
        at: metres(&pin.contact.at),
        play: pin.contact.play / MM,
        ..pin.contact
    };
    let contacts: Vec<Contact> =
        pins.iter().filter(|pin| pin.holds(&hold.core)).map(contact).collect();
    let moves = stand.sag(&contacts).most() * MM;
    let found = format!(
        "{moves:.2} mm on its stub and {} pin{}, {:.2} mm on its stub alone",
        contacts.len(),
        if contacts.len() == 1 { "" } else { "s" },
        stand.sag(&[]).most() * MM
    );
    let needed =
        format!("at most {:.2} mm, limits.sag, and {:.2} mm of mold.json", hold.limit, hold.held);
    let mut line = Line::new(name, moves <= hold.held + OFF, found, &needed);
    if line.status == Status::Ok && moves > hold.limit {
        let left = left_beside(mold, hold, moves / MM / stand.reach);
        let least = LEFT * mold.report.casting.least_wall * MM;
        line.status = if left < least { Status::Fail } else { Status::Warn };
        line.found += &format!(", {:.2} mm from mold and other cores then", left.max(0.0));
        line.needed += &format!(
            "; beyond limits.sag {least:.2} mm left, half of casting.least_wall: widen the inlet, lengthen core.length, give \
             core.pins, or method = \"halves\""
        );
    }
    line
}

/// What is left between a core and the mold or another core when it turns by an angle about its inlet [mm]: each point
/// of it moves by the angle times its distance from the inlet. Not where it stands on the piece below, nor at pins.
fn left_beside(mold: &ClosedMold, hold: &Holding, angle: f64) -> f64 {
    let inlet = Vec3::from(hold.inlet);
    let apart = 2.0 * mold.report.casting.least_wall * MM;
    let others = mold.cores.iter().filter(|core| core.name != hold.core).chain(&mold.shells);
    let others: Vec<SurfaceBvh> =
        others.map(|body| SurfaceBvh::new(&body.solid.to_surface())).collect();
    let Some(core) = mold.cores.iter().find(|core| core.name == hold.core) else { return 0.0 };
    let pins: Vec<Frustum> =
        mold.report.features.iter().filter(|f| f.purpose == Purpose::Pin).map(frustum).collect();
    let free = |p: &Vec3| {
        let beside = |pin: &Frustum| {
            let along = ((p - pin.base).dot(&pin.axis) / pin.axis.norm_squared()).clamp(0.0, 1.0);
            (p - pin.base - pin.axis * along).norm() > apart + pin.base_radius
        };
        p.z > inlet.z + apart && pins.iter().all(beside)
    };
    let vertices = core.solid.to_surface().vertices;
    let left = vertices.iter().filter(|p| free(p)).flat_map(|p| {
        let moves = angle * (p - inlet).norm();
        others.iter().map(move |other| other.closest(p).distance - moves)
    });
    left.fold(f64::INFINITY, f64::min)
}

fn frustum(outline: &Outline) -> Frustum {
    Frustum {
        base: Vec3::from(outline.base),
        axis: Vec3::from(outline.axis),
        base_radius: outline.base_radius,
        top_radius: outline.top_radius,
    }
}
