//! Cores on their stubs, with bores for water and pits for pins.

use anyhow::Result;
use mesh::Vec3;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::cast_body::{CastBody, Core};
use super::division::Blank;
use super::features::core::{Print, drain};
use super::features::pin::Pin;
use super::holding::{self, Holding, Standing};
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
    /// What is cast, with the holes of pins.
    pub cast: Solid,
    /// Sockets, bores for water and pins.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
    /// How each core is held.
    pub holds: Vec<Holding>,
    /// Whether each core fits into its socket one way only.
    pub one_way: bool,
}

impl Cores {
    /// None: the shells as they are.
    pub fn none(body: &CastBody, shells: Vec<Piece>) -> Self {
        Self {
            pieces: Vec::new(),
            shells,
            cast: body.cast.clone(),
            features: Vec::new(),
            findings: Vec::new(),
            holds: Vec::new(),
            one_way: true,
        }
    }

    /// The cores of a body with their stubs, and sockets for these in the last of the shells.
    pub fn new(blank: &Blank, shells: Vec<Piece>, channels: &[Feature]) -> Result<Self> {
        let body = &blank.body;
        let mut all = Self::none(body, shells);
        for index in 0..body.cores.len() {
            let name = match body.cores.len() {
                1 => "core".to_owned(),
                _ => format!("core{}", index + 1),
            };
            all.add(name, index, blank, channels)?;
        }
        Ok(all)
    }

    /// One more.
    fn add(
        &mut self,
        name: String,
        index: usize,
        blank: &Blank,
        channels: &[Feature],
    ) -> Result<()> {
        let Blank { body, block, method, config, .. } = blank;
        let core = &body.cores[index];
        let mut solid = core.solid.clone();
        let mut last = None;
        for inlet in &core.inlets {
            let print = Print::new(inlet, block.min.z, &self.cast, config)?;
            self.one_way &= print.keeps_from_turning();
            solid = solid.union(&print.stub_solid());
            let holder = self.shells.last_mut().expect("there are shells");
            holder.solid = holder.solid.difference(&print.socket_solid());
            if method.core.dissolves() {
                solid = self.bored(solid, &print, core, config);
            }
            let frustum = print.socket.clone();
            self.features.push(Feature { purpose: Purpose::Socket, frustum });
            last = Some((inlet.centre, print.stub));
        }
        if let Some((inlet, stub)) = last {
            let standing = Standing { name: &name, index, solid: &solid, inlet, stub };
            let held = holding::hold(&standing, &self.cast, &self.shells, channels, blank)?;
            for Pin { shell, frustum, pit, .. } in &held.pins {
                let pin = frustum.solid();
                solid = solid.difference(&pit.solid());
                self.cast = self.cast.difference(&pin);
                self.shells[*shell].solid = self.shells[*shell].solid.union(&pin);
                self.features.push(Feature { purpose: Purpose::Pin, frustum: pit.clone() });
            }
            self.findings.extend(held.finding);
            self.holds.push(held.hold);
        }
        self.pieces.push(Piece { name, solid, demolding: -Vec3::z() });
        Ok(())
    }

    /// A soluble core with a bore for water along its stub, if one fits.
    fn bored(&mut self, solid: Solid, print: &Print, core: &Core, config: &Config) -> Solid {
        let mut find = |message| self.findings.push(Finding { rule: "drain", message, count: 1 });
        let Some(frustum) = drain(&print.stub, &core.solid, config) else {
            find(format!(
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
            find(format!(
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
}
