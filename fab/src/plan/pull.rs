//! In which direction the shells separate, and along which surface.
//!
//! The undercuts of the body are measured along many directions. A mold can be pulled along `up` or
//! across it. A plane is preferred to a height field if it leaves hardly more in undercuts, as it
//! is easier to print, to seal and to bolt.

use geometry::frame::Frame;
use geometry::undercut::{self, Undercut, View, Worst};
use geometry::{MM, extent, gap};
use mesh::{SurfaceMesh, Vec3};

use super::report::Direction;
use crate::body::orientation::{PartingSurface, Portion};
use crate::config::{self, Config};

/// Directions spread evenly over a hemisphere.
const HEMISPHERE: usize = 60;

/// Directions across `up`, over half a turn.
const AROUND: usize = 12;

/// A plane may leave this much more of the area in undercuts than the best surface, and one of two
/// planes that differ by less is chosen by the thickness of the body along it [1].
const EASIER: f64 = 0.01;

/// A body counts as thin along a direction up to this many times its least thickness.
const AS_THIN: f64 = 1.1;

/// Directions that agree to this cosine are parallel.
pub const ALONG: f64 = 1.0 - 1e-9;

/// Positions along the pull that are tried for a plane.
const POSITIONS: usize = 9;

/// How the shells of a mold separate.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The direction [1].
    pub pull: Vec3,
    /// The surface.
    pub parting: PartingSurface,
    /// The undercuts they leave.
    pub undercut: Undercut,
    /// Where that is worst.
    pub worst: Option<Worst>,
    /// Why.
    pub reason: String,
}

impl Choice {
    fn new(view: &View, pull: Vec3, parting: PartingSurface, undercut: Undercut) -> Self {
        let across = direction(&pull);
        let place = match parting {
            PartingSurface::Plane(z) => plane(&pull, z),
            PartingSurface::HeightField(_) => format!("a height field along {across}"),
            PartingSurface::Seat | PartingSurface::Open => {
                format!("a plane across {across} where the body stands")
            }
        };
        let reason = format!(
            "{place} leaves {:.2} % of the area hidden, up to {:.2} mm deep",
            100.0 * undercut.share,
            1e3 * undercut.depth
        );
        Self { pull, parting, worst: view.worst(&undercut), undercut, reason }
    }

    /// Depth of the worst undercut over the width of what must give way [1].
    pub fn ratio(&self) -> f64 {
        self.worst.map_or(0.0, |worst| worst.ratio)
    }
}

/// The undercuts of a body along a hemisphere of directions, `up`, coordinate axes across it and
/// other directions across it; the least come first.
pub fn directions(body: &SurfaceMesh, up: &Vec3) -> Vec<Direction> {
    let spiral = hemisphere().map(|pull| (pull, false));
    let usable = usable(up).into_iter().map(|pull| (pull, true));
    let mut directions: Vec<Direction> = usable
        .chain(spiral)
        .map(|(pull, usable)| {
            let Undercut { share, depth, .. } =
                View::along(body, &pull).undercut(undercut::PartingHeight::Middle);
            Direction { pull: pull.into(), usable, undercut: 100.0 * share, depth: depth * MM }
        })
        .collect();
    directions.sort_by(|a, b| a.undercut.total_cmp(&b.undercut));
    directions
}

/// Directions spread evenly over a hemisphere: a Fibonacci spiral.
pub fn hemisphere() -> impl Iterator<Item = Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..HEMISPHERE).map(move |i| {
        let z = (i as f64 + 0.5) / HEMISPHERE as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    })
}

/// `up`, coordinate axes across it, and directions around it.
pub fn usable(up: &Vec3) -> Vec<Vec3> {
    let mut found = vec![*up];
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    found.extend(axes.into_iter().filter(|axis| axis.dot(up).abs() < 1e-9));
    let (frame, _) = Frame::new(*up, *up).expect("a direction is along itself");
    let [u, v] = [0, 1].map(|row| frame.rotation.row(row).transpose());
    for k in 0..AROUND {
        let (sin, cos) = (std::f64::consts::PI * k as f64 / AROUND as f64).sin_cos();
        let pull = u * cos + v * sin;
        if found.iter().all(|other| other.dot(&pull).abs() < 1.0 - 1e-9) {
            found.push(pull);
        }
    }
    found
}

/// The parting surface that leaves least in undercuts, or what the configuration asks for.
pub fn choose(body: &SurfaceMesh, up: &Vec3, portion: Portion, config: &Config) -> Choice {
    let directions = |pull: Option<[f64; 3]>| match pull {
        Some(pull) => vec![Vec3::from(pull).normalize()],
        None => usable(up),
    };
    let planes = |pull: Vec3| (pull, planes(body, &pull, pull.dot(up) > ALONG, portion));
    match &config.parting {
        config::PartingConfig::Plane(plane) => {
            let options = directions(plane.pull).into_iter().map(|pull| match plane.offset {
                Some(offset) => (pull, vec![PartingSurface::Plane(offset)]),
                None => planes(pull),
            });
            best_plane(body, options.collect(), f64::INFINITY).expect("there are planes")
        }
        config::PartingConfig::HeightField(field) => {
            best_field(body, directions(field.pull), field.clone())
        }
        config::PartingConfig::Auto(auto) => {
            let pulls = directions(auto.pull);
            // Along `up`, what is cut stands on the plate that carries its core.
            let free = |pull: &Vec3| portion == Portion::Whole || pull.dot(up) <= ALONG;
            let fields = pulls.iter().copied().filter(free).collect();
            let mut field = best_field(body, fields, config::HeightFieldConfig::default());
            field.reason += &format!(", and no plane comes within {:.0} % of that", 100.0 * EASIER);
            let options = pulls.into_iter().map(planes).collect();
            best_plane(body, options, field.undercut.share + EASIER).unwrap_or(field)
        }
    }
}

/// The parting surface along or across `up` on which the silicone has to give way least for its
/// width, whatever area that hides; `config` leaves it open.
pub fn loosest(body: &SurfaceMesh, up: &Vec3, portion: Portion) -> Option<Choice> {
    let choices = usable(up).into_iter().flat_map(|pull| {
        let along_up = pull.dot(up) > ALONG;
        let planes = planes(body, &pull, along_up, portion).into_iter();
        let planes = planes
            .filter_map(move |plane| best_plane(body, vec![(pull, vec![plane])], f64::INFINITY));
        let field = (portion == Portion::Whole || !along_up)
            .then(|| best_field(body, vec![pull], config::HeightFieldConfig::default()));
        planes.chain(field)
    });
    choices.min_by(|a, b| a.ratio().total_cmp(&b.ratio()))
}

/// The plane that contains `up` and leaves least in undercuts.
pub fn sideways(body: &SurfaceMesh, up: &Vec3) -> Choice {
    let across = usable(up).into_iter().filter(|pull| pull.dot(up).abs() < 1e-9);
    let options = across.map(|pull| (pull, planes(body, &pull, false, Portion::Whole)));
    best_plane(body, options.collect(), f64::INFINITY).expect("there are planes")
}

/// Planes that can be used: along `up` the seat, which leaves the body in one cup, then
/// other positions if it is not cut; across it the middle.
fn planes(
    body: &SurfaceMesh,
    pull: &Vec3,
    along_up: bool,
    portion: Portion,
) -> Vec<PartingSurface> {
    let heights = || body.vertices.iter().map(|p| p.dot(pull));
    let [low, high] = extent(&body.vertices, pull);
    let at = |t: f64| PartingSurface::Plane(gap::clear(heights(), low + t * (high - low)));
    let tried = (1..=POSITIONS).map(|k| at(k as f64 / (POSITIONS + 1) as f64));
    match (along_up, portion) {
        (false, _) => vec![at(0.5)],
        (true, Portion::Whole) => std::iter::once(PartingSurface::Seat).chain(tried).collect(),
        (true, _) => vec![PartingSurface::Seat],
    }
}

/// The plane that leaves least in undercuts, if that is at most `limit` of the area.
fn best_plane(
    body: &SurfaceMesh,
    options: Vec<(Vec3, Vec<PartingSurface>)>,
    limit: f64,
) -> Option<Choice> {
    struct Plane {
        pull: Vec3,
        parting: PartingSurface,
        undercut: Undercut,
        thickness: f64,
    }
    let mut planes = Vec::new();
    for (pull, partings) in options {
        let view = View::along(body, &pull);
        let [low, high] = view.extent();
        for parting in partings {
            let position = match parting {
                PartingSurface::Plane(z) => z,
                _ => low,
            };
            let undercut = view.undercut(undercut::PartingHeight::Plane(position));
            planes.push(Plane { pull, parting, undercut, thickness: high - low });
        }
    }
    planes.retain(|plane| plane.undercut.share <= limit);
    let least = planes.iter().map(|p| p.undercut.share).fold(f64::INFINITY, f64::min);
    planes.retain(|plane| plane.undercut.share <= least + EASIER);
    // Directions that are about as thin are as good: the first is kept.
    let thinnest = planes.iter().map(|p| p.thickness).fold(f64::INFINITY, f64::min);
    let plane = planes.into_iter().find(|plane| plane.thickness <= AS_THIN * thinnest)?;
    let Plane { pull, parting, undercut, .. } = plane;
    Some(Choice::new(&View::along(body, &pull), pull, parting, undercut))
}

fn best_field(body: &SurfaceMesh, pulls: Vec<Vec3>, settings: config::HeightFieldConfig) -> Choice {
    let seen = pulls.into_iter().map(|pull| {
        let view = View::along(body, &pull);
        let undercut = view.undercut(undercut::PartingHeight::Middle);
        (pull, view, undercut)
    });
    let (pull, view, undercut) =
        seen.min_by(|a, b| a.2.share.total_cmp(&b.2.share)).expect("there is a direction");
    Choice::new(&view, pull, PartingSurface::HeightField(settings), undercut)
}

/// A plane n·p = offset [m] in words: by the coordinate that it holds, or by its normal.
pub fn plane(normal: &Vec3, offset: f64) -> String {
    let place = |sign: f64| rounded(sign * offset * 1e3, 2);
    for (name, along) in [("x", normal.x), ("y", normal.y), ("z", normal.z)] {
        if along.abs() > 1.0 - 1e-9 {
            return format!("the plane {name} = {:.2} mm", place(along.signum()));
        }
    }
    format!("the plane across {} at {:.2} mm from the origin", direction(normal), place(1.0))
}

/// A number as some digits after the point say it, without the sign of a zero.
fn rounded(x: f64, digits: i32) -> f64 {
    let one = 10_f64.powi(digits);
    (x * one).round() / one + 0.0
}

/// A direction in words.
pub fn direction(d: &Vec3) -> String {
    let [x, y, z] = [d.x, d.y, d.z].map(|c| rounded(c, 3));
    match () {
        () if x.abs() > 1.0 - 1e-9 => "x".into(),
        () if y.abs() > 1.0 - 1e-9 => "y".into(),
        () if z.abs() > 1.0 - 1e-9 => "z".into(),
        () => format!("({x:.3}, {y:.3}, {z:.3})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_directions_are_told_without_the_sign_of_a_zero() {
        assert_eq!(plane(&-Vec3::y(), 1e-6), "the plane y = 0.00 mm");
        assert_eq!(plane(&-Vec3::z(), 4e-3), "the plane z = -4.00 mm");
        let tilted = plane(&Vec3::new(0.6, 0.0, 0.8), 2e-3);
        assert_eq!(tilted, "the plane across (0.600, 0.000, 0.800) at 2.00 mm from the origin");
        assert_eq!(direction(&Vec3::new(-1e-5, 0.6, 0.8)), "(0.000, 0.600, 0.800)");
    }
}
