//! Cores on their stubs, with bores for water and pins.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::cast_body::{Core, Part};
use super::{BEYOND, Feature, Mold, MoldError, Piece, Purpose};
use crate::config::method::Method;
use crate::config::{Config, Support};
use crate::geometry::frustum::Frustum;
use crate::mold::features::core::{Print, drain};
use crate::mold::features::pin::{Room, pin};
use crate::mold::features::support::{self, Sag};

/// A bore that reaches less far into its core than this part of the core's height is
/// pointed out.
const SHORT: f64 = 0.5;

impl Mold {
    /// Adds the cores with their stubs, and cuts the sockets into the lowest piece.
    pub(super) fn add_cores(
        &mut self,
        part: &Part,
        channels: &[Feature],
        level: Option<f64>,
        config: &Config,
    ) -> Result<(), MoldError> {
        let single = part.cores.len() == 1;
        for (i, core) in part.cores.iter().enumerate() {
            let mut solid = core.solid.clone();
            let mut held = None;
            for inlet in &core.inlets {
                let floor = self.block.min.z;
                let print = Print::new(inlet.centre, inlet.radius, floor, &self.cast, config)?;
                solid = solid.union(&print.stub_solid());
                let holder = self.shells.last_mut().expect("there are shells");
                holder.solid = holder.solid.difference(&print.socket_solid());
                if self.method == Method::Soluble {
                    solid = self.bore(solid, &print, core, config);
                }
                let frustum = print.socket.clone();
                self.features.push(Feature { purpose: Purpose::Socket, frustum });
                held = Some((inlet.centre, print));
            }
            if let Some(held) = held {
                solid = self.support(core, &held, solid, (channels, level), config)?;
            }
            let name = if single { "core".into() } else { format!("core{}", i + 1) };
            self.cores.push(Piece { name, solid, leaves: -Vec3::z() });
        }
        Ok(())
    }

    /// A soluble core with a bore for water, if there is room for one.
    fn bore(&mut self, solid: Solid, print: &Print, core: &Core, config: &Config) -> Solid {
        let mut tell = |message| self.findings.push(Finding { rule: "drain", message, count: 1 });
        let Some(frustum) = drain(&print.stub, &core.solid, config) else {
            tell(format!(
                "no upright bore of core.drain = {1:.2} mm within core.skin = {2:.2} mm fits into a stub of {0:.2} mm \
                 radius and the core above it: water dissolves the core from its end only",
                print.stub.base_radius * 1e3,
                config.core.drain * 1e3,
                config.core.skin * 1e3
            ));
            return solid;
        };
        let (low, high) = core.solid.bounds();
        let [reach, height] = [frustum.base.z + frustum.axis.z - low.z, high.z - low.z];
        if reach < SHORT * height {
            tell(format!(
                "the bore for water ends {:.1} mm above the inlet, where less than core.skin = {:.2} mm of the core \
                 would be left around it; the core is {:.1} mm high: change the water more often",
                reach * 1e3,
                config.core.skin * 1e3,
                height * 1e3
            ));
        }
        let solid = solid.difference(&frustum.solid());
        self.features.push(Feature { purpose: Purpose::Drain, frustum });
        solid
    }

    /// A core that is held at one inlet, with a pin if it needs one, and what to know of it.
    /// The pin keeps clear of the channels; between shells that part sideways it stands on
    /// their plane y = level.
    fn support(
        &mut self,
        core: &Core,
        (inlet, print): &(Vec3, Print),
        solid: Solid,
        (channels, level): (&[Feature], Option<f64>),
        config: &Config,
    ) -> Result<Solid, MoldError> {
        let surface = core.solid.to_surface();
        let density = config.density().unwrap_or(support::SILICONE);
        let clearance = config.stub_clearance();
        let sag = support::sag(&surface, inlet, &print.stub, clearance, density);
        let radius = config.core.pin;
        let outside = self.outside.to_surface();
        let room = Room {
            outside: &SurfaceBvh::new(&outside),
            channels: channels.iter().map(|channel| &channel.frustum).collect(),
            clearance,
            level,
        };
        let found = match config.core.support {
            Support::Auto if sag.bend <= config.limits.sag => None,
            Support::Auto => pin(&surface, inlet, radius, &room).ok(),
            Support::Pin => Some(pin(&surface, inlet, radius, &room)?),
            Support::Stub => None,
        };
        let Some(pin) = found else {
            self.findings.extend(moves(&sag, config.limits.sag));
            return Ok(solid);
        };
        let base = pin.base * 1e3;
        self.findings.push(Finding {
            rule: "pin",
            message: format!(
                "a pin of {:.1} mm radius holds the core at ({:.1}, {:.1}) mm; plug the hole it leaves in the \
                 silicone",
                pin.base_radius * 1e3,
                base.x,
                base.y
            ),
            count: 1,
        });
        let around = clearance + pin.base_radius;
        let top = self.block.max.z + BEYOND;
        let hole = Frustum {
            axis: Vec3::z() * (top - pin.base.z),
            base_radius: around,
            top_radius: around,
            ..pin.clone()
        };
        let pin = pin.solid();
        self.cast = self.cast.difference(&pin);
        self.cut(Purpose::Pin, hole);
        Ok(solid.union(&pin))
    }
}

/// Tells how far a core may move that is held at one end.
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
