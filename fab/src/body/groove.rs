//! The groove for a thread: what a ridge of the mold leaves in the casting.
//!
//! Between two stations of the thread the ridge is the hull of two sections: at the depth d below the surface as wide
//! as the thread and a clearance, w, and wider outward by both flanks, which lean by the draft δ,
//!
//! width at the height h above its bottom = w + 2 h tan δ.
//!
//! A ridge that climbs as it turns is not along the pull, so that one of its flanks would press into the silicone
//! near the parting plane, where draft is of no use: there the surface is along the pull itself. Each piece P of the
//! groove is therefore widened by what it sweeps on its way out,
//!
//! P ⊕ \[0, r\] e,
//!
//! with the direction e in which its shell leaves and the way r to where it leaves the body. A body without that can
//! be left by the ridge along e: no point of the ridge has silicone before it.

use geometry::MM;
use geometry::frame::Frame;
use mesh::solid::{Solid, SolidError};
use mesh::{SurfaceMesh, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::boundary::Boundary;

/// Corners of the outline of a pit.
const SIDES: usize = 16;

/// A groove as mold.json has it; before, in the metres of the design.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Groove {
    /// Diameter of the thread [mm].
    pub thread: f64,
    /// Width at the bottom [mm].
    pub width: f64,
    /// Depth [mm].
    pub depth: f64,
    /// Angle by which each flank leans out [°].
    pub draft: f64,
    /// Diameter of the pits for knots [mm].
    pub pit: f64,
    /// Direction along which the shells part [1].
    pub pull: [f64; 3],
    /// Where they part, along the pull [mm].
    pub parting: f64,
    /// Where ridges run, each from its start to its end.
    pub courses: Vec<Vec<Station>>,
    /// Pits for the knots at the ends of the thread.
    pub pits: Vec<Station>,
    /// Length of the thread on the tags that get a groove [mm].
    pub wound: f64,
    /// Length of the groove [mm].
    pub length: f64,
    /// By how much it is widened beside the thread, at most [mm].
    pub widened: f64,
    /// By how much it would have to be widened where there is no ridge, at most; none if the ridge is whole [mm].
    pub locked: Option<f64>,
}

/// A place on the thread, with the section of its groove.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Station {
    /// On the surface of the body [mm].
    pub at: [f64; 3],
    /// Outward, across the thread [1].
    pub normal: [f64; 3],
    /// Along the thread [1].
    pub along: [f64; 3],
    /// Depth of its bottom below the surface; negative where it fades [mm].
    pub depth: f64,
    /// How far the piece from here to the next station sweeps along the pull [mm].
    pub reach: f64,
}

impl Station {
    /// The unit vector across the thread in the surface.
    pub fn across(&self) -> Vec3 {
        Vec3::from(self.along).cross(&Vec3::from(self.normal))
    }

    /// The place at a height above the surface and beside the thread.
    pub fn place(&self, height: f64, beside: f64) -> Vec3 {
        Vec3::from(self.at) + Vec3::from(self.normal) * height + self.across() * beside
    }
}

impl Groove {
    /// Half of its width at a height above its bottom.
    pub fn half_width(&self, height: f64) -> f64 {
        self.width / 2.0 + height * self.draft.to_radians().tan()
    }

    /// The corners of the section at a station, from its bottom to as far above the surface as it is deep.
    pub fn section(&self, station: &Station) -> [Vec3; 4] {
        let top = self.half_width(station.depth + self.depth);
        let bottom = self.half_width(0.0);
        [
            station.place(-station.depth, -bottom),
            station.place(-station.depth, bottom),
            station.place(self.depth, top),
            station.place(self.depth, -top),
        ]
    }

    /// The corners of a pit, with the same draft.
    pub fn pit(&self, station: &Station) -> Vec<Vec3> {
        let along = Vec3::from(station.along);
        let ring = |height: f64| {
            let radius = self.pit / 2.0 + (height + station.depth) * self.draft.to_radians().tan();
            (0..SIDES).map(move |k| {
                let (sine, cosine) = (std::f64::consts::TAU * k as f64 / SIDES as f64).sin_cos();
                station.place(height, radius * sine) + along * (radius * cosine)
            })
        };
        ring(-station.depth).chain(ring(self.depth)).collect()
    }

    /// How far a point is beyond the parting plane.
    pub fn beyond(&self, p: &Vec3) -> f64 {
        p.dot(&Vec3::from(self.pull)) - self.parting
    }

    /// The directions in which shells leave that have some of these points.
    pub fn leaving(&self, points: &[Vec3]) -> Vec<Vec3> {
        let pull = Vec3::from(self.pull);
        let on_side = |sign: &f64| points.iter().any(|p| self.beyond(p) * sign > 0.0);
        [1.0, -1.0].into_iter().filter(on_side).map(|sign| pull * sign).collect()
    }

    /// The direction in which the piece between two stations leaves: none lies on both sides of the parting plane.
    pub fn way_out(&self, pair: [&Station; 2]) -> Vec3 {
        let middle = pair.map(|station| Vec3::from(station.at)).iter().sum::<Vec3>() / 2.0;
        Vec3::from(self.pull) * self.beyond(&middle).signum()
    }

    /// All that is left out of the casting.
    pub fn solid(&self) -> Solid {
        let mut pieces = Vec::new();
        for course in &self.courses {
            for pair in course.windows(2) {
                let corners = [self.section(&pair[0]), self.section(&pair[1])].concat();
                pieces.push(swept(&corners, self.way_out([&pair[0], &pair[1]]) * pair[0].reach));
            }
        }
        for pit in &self.pits {
            let corners = self.pit(pit);
            let ways = self.leaving(&corners).into_iter();
            pieces.extend(ways.map(|way| swept(&corners, way * pit.reach)));
        }
        union(pieces)
    }

    /// A body without its groove.
    pub fn cut(&self, boundary: &Boundary) -> Result<Boundary, SolidError> {
        let groove = self.solid();
        let without = |surface: &SurfaceMesh| -> Result<SurfaceMesh, SolidError> {
            Ok(Solid::from_surface(surface)?.difference(&groove).to_surface())
        };
        let (filled, cast) = (without(&boundary.filled)?, without(&boundary.cast)?);
        Ok(Boundary { filled, cast, plain: Some(boundary.cast.clone()), ..boundary.clone() })
    }

    /// This groove in the millimetres of a mold.
    pub fn placed(&self, frame: &Frame) -> Self {
        let scale = frame.scale * MM;
        let turned = |v: &[f64; 3]| frame.direction(&Vec3::from(*v)).into();
        let station = |station: &Station| Station {
            at: (frame.point(&Vec3::from(station.at)) * MM).into(),
            normal: turned(&station.normal),
            along: turned(&station.along),
            depth: station.depth * scale,
            reach: station.reach * scale,
        };
        let stations = |all: &Vec<Station>| all.iter().map(station).collect();
        let origin = frame.origin.dot(&Vec3::from(self.pull));
        Self {
            thread: self.thread * scale,
            width: self.width * scale,
            depth: self.depth * scale,
            draft: self.draft,
            pit: self.pit * scale,
            pull: turned(&self.pull),
            parting: (self.parting - origin) * scale,
            courses: self.courses.iter().map(stations).collect(),
            pits: self.pits.iter().map(station).collect(),
            wound: self.wound * scale,
            length: self.length * scale,
            widened: self.widened * scale,
            locked: self.locked.map(|locked| locked * scale),
        }
    }

    /// For the one who winds.
    pub fn in_words(&self) -> String {
        let Self { width, depth, length, wound, .. } = self;
        let whole = match length / wound {
            part if part > 0.999 => String::new(),
            part => format!(
                " It is there for {:.0} % of the way: not around pins, and not where its ridge would hold back a shell. \
                 There the thread is laid by eye from groove to groove.",
                100.0 * part
            ),
        };
        let pits = match self.pits.len() {
            0 => "",
            _ => " The knots go into the pits at its ends.",
        };
        format!(
            "A groove of {width:.2} mm and {depth:.2} mm depth guides the thread.{whole}{pits} Cut off what silicone \
             has run over its rims before winding. Where two threads cross, the second lies on the first, and \
             stands out by its thickness."
        )
    }
}

/// What the hull of points sweeps on its way.
fn swept(points: &[Vec3], way: Vec3) -> Solid {
    let moved = points.iter().map(|p| p + way);
    Solid::hull(&points.iter().copied().chain(moved).collect::<Vec<_>>())
}

/// The points in any of the solids.
fn union(mut solids: Vec<Solid>) -> Solid {
    while solids.len() > 1 {
        let pair = |pair: &[Solid]| match pair {
            [a, b] => a.union(b),
            rest => rest[0].clone(),
        };
        solids = solids.chunks(2).map(pair).collect();
    }
    solids.pop().unwrap_or_else(|| Solid::hull(&[]))
}
