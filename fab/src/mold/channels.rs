//! The sprue, the vents, and the funnel that stands in the sprue.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::features::{channel, funnel};
use super::piece::{Feature, Piece, Purpose};
use super::venting::Places;
use crate::config::{Config, SprueConfig};
use crate::geometry::frustum::Frustum;

/// Channels for silicone and air.
#[derive(Default)]
pub struct Channels {
    /// The sprue and the vents; none of an open mold.
    pub features: Vec<Feature>,
    /// What stands in the sprue while the mold is filled, and the volume it holds [m³].
    pub funnel: Option<(Piece, f64)>,
    /// What a person should know.
    pub findings: Vec<Finding>,
}

impl Channels {
    /// Channels from `places` on the body up to height `end` [m], and a funnel on `outside` for
    /// a share of the volume of `cast`; `surface` is that of the filled body.
    pub fn new(
        places: Places,
        surface: &SurfaceBvh,
        end: f64,
        outside: &Solid,
        cast: &Solid,
        config: &Config,
    ) -> Self {
        let SprueConfig { radius, top_radius, head, .. } = config.sprue;
        let sprue = channel(surface, &places.sprue, end, radius, top_radius);
        let mut findings = places.findings;
        let funnel = head.and_then(|head| {
            let found = standing(&sprue, head * cast.volume(), outside, cast, config);
            found.map_err(|finding| findings.push(finding)).ok()
        });
        let radius = config.vents.radius;
        let vents = places.vents.iter().map(|top| {
            let frustum = channel(surface, top, end, radius, radius);
            Feature { purpose: Purpose::Vent, frustum }
        });
        let sprue = Feature { purpose: Purpose::Sprue, frustum: sprue };
        Self { features: std::iter::once(sprue).chain(vents).collect(), funnel, findings }
    }
}

/// A funnel of `volume` [m³] in the sprue, or why there is none.
fn standing(
    sprue: &Frustum,
    volume: f64,
    outside: &Solid,
    cast: &Solid,
    config: &Config,
) -> Result<(Piece, f64), Finding> {
    let funnel = funnel::funnel(sprue, outside, volume, config.stub_clearance());
    match funnel.filter(|solid| solid.intersection(cast).is_empty()) {
        Some(solid) => Ok((Piece { name: "funnel".into(), solid, demolding: Vec3::z() }, volume)),
        None => Err(Finding {
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
