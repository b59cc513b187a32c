//! What is cast and what shapes it, in the mold's frame.

use geometry::extent;
use geometry::frame::Frame;
use mesh::solid::{Solid, SolidError};
use mesh::{SurfaceMesh, Vec3, measure};

use crate::body::boundary::Boundary;
use crate::body::layout::placed;
use crate::body::orientation::Portion;

/// A facet belongs to the seat if it keeps within this part of the body's
/// diagonal of the inlet's plane.
const SEAT: f64 = 2e-3;

/// The portion of a body that is cast.
pub struct CastBody {
    /// With its chambers filled.
    pub surface: SurfaceMesh,
    /// The filled surface as a solid.
    pub filled: Solid,
    /// What is cast.
    pub cast: Solid,
    /// What is cast, without the groove for its thread, if it has one. Walls are measured on it: between grooves that
    /// cross, silicone ends in edges, which are no walls.
    pub plain: Option<Solid>,
    /// What fills the chambers.
    pub cores: Vec<Core>,
    /// Height on which it stands [m].
    pub seat: f64,
}

/// What fills a chamber.
pub struct Core {
    /// The shape.
    pub solid: Solid,
    /// Where it opens.
    pub inlets: Vec<Opening>,
}

/// An inlet in the mold's frame.
pub struct Opening {
    /// Centre of the circle inscribed in its rim [m].
    pub centre: Vec3,
    /// Radius of that circle [m].
    pub radius: f64,
}

impl CastBody {
    /// The portion of a body. Its seat is at the height `joint` if there is one; else at its
    /// inlet, or `foot` below its lowest point if it has none [m].
    pub fn new(
        boundary: &Boundary,
        frame: &Frame,
        portion: Portion,
        joint: Option<f64>,
        foot: f64,
    ) -> Result<Self, SolidError> {
        let solid = |surface: &SurfaceMesh| -> Result<Solid, SolidError> {
            let whole = Solid::from_surface(&placed(surface, frame))?;
            Ok(match portion {
                Portion::Whole => whole,
                Portion::Above(_) => whole.trim_by_plane(&Vec3::z(), 0.0),
                Portion::Below(_) => whole.trim_by_plane(&-Vec3::z(), 0.0),
            })
        };
        let filled = solid(&boundary.filled)?;
        let surface = match portion {
            Portion::Whole => placed(&boundary.filled, frame),
            Portion::Above(_) | Portion::Below(_) => filled.to_surface(),
        };
        let mut cores = Vec::new();
        for core in &boundary.cores {
            let inlets = core.inlets.iter().map(|inlet| Opening {
                centre: frame.point(&inlet.centre),
                radius: inlet.radius * frame.scale,
            });
            cores.push(Core { solid: solid(&core.surface)?, inlets: inlets.collect() });
        }
        let seat = match (joint, portion) {
            (Some(height), _) => height,
            (None, Portion::Whole) => seat_height(&surface, &cores, foot),
            (None, Portion::Above(_) | Portion::Below(_)) => 0.0,
        };
        let plain = boundary.plain.as_ref().map(&solid).transpose()?;
        Ok(Self { cast: solid(&boundary.cast)?, plain, surface, filled, cores, seat })
    }

    /// Area of the walls of its chambers [m²]. With the wall W, the outside U, the caps of inlets C, and
    /// the sections S and K of silicone and cores where a part ends, the areas are U + W + S of what is cast,
    /// W + C + K of cores, and U + C + S + K of the filled body.
    pub fn chamber_area(&self) -> f64 {
        let cores: f64 = self.cores.iter().map(|core| core.solid.area()).sum();
        (self.cast.area() + cores - self.filled.area()) / 2.0
    }
}

/// Height of the seat, on which sides and base meet: the highest vertex of the
/// facets that lie in the first inlet's plane, so that no film of a shell
/// reaches below an uneven seat; `foot` below the lowest vertex if there is no inlet.
fn seat_height(filled: &SurfaceMesh, cores: &[Core], foot: f64) -> f64 {
    let Some(inlet) = cores.iter().flat_map(|core| &core.inlets).next() else {
        return extent(&filled.vertices, &Vec3::z())[0] - foot;
    };
    let level = inlet.centre.z;
    let tolerance = SEAT * measure::diagonal(&filled.vertices);
    let near = |v: &usize| (filled.vertices[*v].z - level).abs() <= tolerance;
    let seat = filled.triangles.iter().filter(|t| t.iter().all(near));
    seat.flatten().map(|&v| filled.vertices[v].z).fold(level, f64::max)
}
