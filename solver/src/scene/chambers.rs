//! The chambers of a scene: walls, what is behind them, and what they need.

use anyhow::{Context, Result, bail, ensure};

use super::Scene;
use crate::body::Body;
use crate::element::FunctionSpace;
use crate::energy::{Chamber, Energies, GasLaw, Multiplier, Prescribed, Wall};
use crate::supports::Supports;

/// Penalty of a prescribed volume in shear moduli per rest volume.
const PENALTY: f64 = 10.0;
/// Height of a rim over its extent up to which it lies in a plane.
const FLAT: f64 = 1e-9;

impl Scene {
    /// The chambers of a body, by the tags of their walls.
    ///
    /// # Errors
    /// When a tag is missing or closes no volume that gas could fill.
    pub(super) fn chambers(
        &self,
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Vec<(String, Chamber)>> {
        let context = || self.path.display().to_string();
        let nodes = space.node_positions(&body.mesh.vertices);
        let mut chambers = Vec::new();
        for (on, gas) in self.gas_laws() {
            let wall = Wall::new(space, &body.facets(on).with_context(context)?);
            let volume = wall.volume(space, &nodes);
            if !matches!(gas, GasLaw::Isobaric { .. }) && volume <= 0.0 {
                bail!(
                    "{}: \"{on}\": the volume behind the wall is {volume:.3e} m³, must be \
                     positive\n  the tag is not the wall of a chamber",
                    self.path.display()
                );
            }
            if let GasLaw::Volume { prescribed, .. } = &gas {
                for t in self.config.moments() {
                    let (wanted, _) = prescribed.at(volume, t);
                    ensure!(
                        wanted > 0.0,
                        "{}: [[volume]] on \"{on}\": the chamber of {volume:.3e} m³ would have \
                         {wanted:.3e} m³ at t = {t}; must be positive",
                        self.path.display()
                    );
                }
            }
            chambers.push((on.clone(), Chamber { wall, gas }));
        }
        Ok(chambers)
    }

    /// What is behind each wall.
    fn gas_laws(&self) -> Vec<(&String, GasLaw)> {
        let mut laws = Vec::new();
        for c in &self.config.pressure {
            laws.push((&c.on, GasLaw::Isobaric { pressure: c.pressure.clone() }));
        }
        for c in &self.config.gas {
            let (ambient, exponent) = (c.ambient, c.exponent);
            laws.push((&c.on, GasLaw::Ideal { fill: c.fill.clone(), ambient, exponent }));
        }
        for (multiplier, c) in self.config.volume.iter().enumerate() {
            let change = c.change.clone().map(Prescribed::Change);
            let prescribed = change.or_else(|| c.factor.clone().map(Prescribed::Factor));
            laws.extend(prescribed.map(|p| (&c.on, GasLaw::Volume { prescribed: p, multiplier })));
        }
        laws
    }

    /// Of the prescribed volumes at rest, with a penalty well above what a wall
    /// in a large block resists to a change of volume: 4/3 of its shear modulus
    /// per volume.
    pub(super) fn multipliers(
        &self,
        body: &Body,
        space: &FunctionSpace,
        energies: &Energies,
    ) -> Vec<Multiplier> {
        let nodes = space.node_positions(&body.mesh.vertices);
        let shears = self.parts.iter().map(|part| part.material.moduli().shear);
        let shear = shears.fold(0.0, f64::max);
        let one = |chamber: &Chamber| Multiplier {
            pressure: 0.0,
            penalty: PENALTY * shear / chamber.wall.volume(space, &nodes),
        };
        let chambers = energies.chambers().map(|(_, named)| &named.chamber);
        chambers.filter(|c| matches!(c.gas, GasLaw::Volume { .. })).map(one).collect()
    }
}

/// The gas force has a potential only when every rim of its wall is fixed along
/// all axes, or moves only within a plane.
pub(super) fn check_rim(
    name: &str,
    facets: &[[usize; 3]],
    supports: &Supports,
    space: &FunctionSpace,
    body: &Body,
) -> Result<()> {
    let rim = mesh::topology::boundary_edges(facets);
    let nodes = |&[a, b]: &[usize; 2]| [a, b].into_iter().chain(space.edge_nodes([a, b]));
    let held = |edge: &[usize; 2]| nodes(edge).all(|node| supports.holds(node));
    let flat: Vec<usize> = mesh::topology::boundary_loops(facets)
        .into_iter()
        .filter(|rim| (0..3).any(|axis| slides(rim, axis, supports, space, body)))
        .flatten()
        .collect();
    let free: Vec<_> = rim.iter().filter(|edge| !held(edge) && !flat.contains(&edge[0])).collect();
    if let Some([a, _]) = free.first() {
        let p = body.mesh.vertices[*a];
        bail!(
            "pressure on \"{name}\": {} of the {} edges of its rim are free, the first at \
             ({:.5}, {:.5}, {:.5}) m\n  gas pressure has no energy unless the wall is closed or its \
             rim is fixed along x, y and z, or lies in a plane across one of these axes and is fixed \
             along that: add the tag around the opening to [[fixed]]",
            free.len(),
            rim.len(),
            p.x,
            p.y,
            p.z
        );
    }
    Ok(())
}

/// Whether a loop of vertices lies in a plane across an axis and all its nodes
/// stay there.
fn slides(
    rim: &[usize],
    axis: usize,
    supports: &Supports,
    space: &FunctionSpace,
    body: &Body,
) -> bool {
    let x = &body.mesh.vertices;
    let level = x[rim[0]][axis];
    let size = rim.iter().map(|&v| (x[v] - x[rim[0]]).norm()).fold(0.0, f64::max);
    rim.iter().enumerate().all(|(i, &a)| {
        let edge = [a, rim[(i + 1) % rim.len()]];
        let mut nodes = [a].into_iter().chain(space.edge_nodes(edge));
        (x[a][axis] - level).abs() < FLAT * size && nodes.all(|n| supports.stays(n, axis))
    })
}
