//! The chambers of a scene: walls, what is behind them, and what they need.

use anyhow::{Context, Result, bail, ensure};

use super::Scene;
use crate::body::Body;
use crate::element::FunctionSpace;
use crate::energy::{Chamber, GasLaw, Multiplier, Prescribed, Wall};
use crate::supports::Supports;

/// Penalty of a prescribed volume in shear moduli per rest volume.
const PENALTY: f64 = 10.0;
/// Rims are plane up to this fraction of the size of all bodies.
const FLAT: f64 = 1e-9;

impl Scene {
    /// The chambers of a body, by the tags of their walls.
    ///
    /// # Errors
    /// When a tag is missing or closes no volume that gas could fill.
    pub fn chambers(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<(String, Chamber)>> {
        let context = || self.path.display().to_string();
        let nodes = space.node_positions(&body.mesh.vertices);
        let mut chambers = Vec::new();
        for (on, gas) in self.gas_laws() {
            let mut wall = Wall::new(space, &body.facets(on).with_context(context)?);
            if let Some(axis) = self.slides(&wall, body, space)? {
                wall = wall.sliding(axis);
            }
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

    /// The axis along which all rims of a wall are plane and fixed, if they are
    /// not fixed along all axes.
    fn slides(&self, wall: &Wall, body: &Body, space: &FunctionSpace) -> Result<Option<usize>> {
        if wall.is_closed() {
            return Ok(None);
        }
        let vertices = &body.mesh.vertices;
        let tolerance = FLAT * mesh::measure::diagonal(vertices);
        let flat = |rim: &Vec<usize>, axis: usize| {
            rim.iter().all(|&v| (vertices[v][axis] - vertices[rim[0]][axis]).abs() <= tolerance)
        };
        let is_flat = |axis: &usize| wall.rim().iter().all(|rim| flat(rim, *axis));
        let Some(axis) = (0..3).find(is_flat) else { return Ok(None) };
        let supports = self.supports(body, space)?;
        let nodes = || wall.rim().iter().flatten();
        let slides = nodes().any(|&v| !supports.holds(v));
        let fixed = nodes().all(|&v| supports.owner[3 * v + axis].is_some());
        Ok((slides && fixed).then_some(axis))
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
    ) -> Result<Vec<Multiplier>> {
        let nodes = space.node_positions(&body.mesh.vertices);
        let shears = self.parts.iter().map(|part| part.material.moduli().shear);
        let shear = shears.fold(0.0, f64::max);
        let one = |(_, chamber): &(String, Chamber)| Multiplier {
            pressure: 0.0,
            penalty: PENALTY * shear / chamber.wall.volume(space, &nodes),
        };
        let chambers = self.chambers(body, space)?;
        let volumes = chambers.iter().filter(|c| matches!(c.1.gas, GasLaw::Volume { .. }));
        Ok(volumes.map(one).collect())
    }
}

/// The gas force has a potential only when every rim of its wall is fixed along
/// all axes, or slides in a plane normal to one.
pub(super) fn check_rim(
    name: &str,
    wall: &Wall,
    facets: &[[usize; 3]],
    supports: &Supports,
    space: &FunctionSpace,
    body: &Body,
) -> Result<()> {
    let rim = mesh::topology::boundary_edges(facets);
    let held = |&[a, b]: &[usize; 2]| {
        let held = |node: usize| match wall.slides() {
            Some(axis) => supports.owner[3 * node + axis].is_some(),
            None => supports.holds(node),
        };
        [a, b].into_iter().chain(space.edge_nodes([a, b])).all(held)
    };
    let free: Vec<_> = rim.iter().filter(|edge| !held(edge)).collect();
    if let Some([a, _]) = free.first() {
        let p = body.mesh.vertices[*a];
        bail!(
            "pressure on \"{name}\": {} of the {} edges of its rim are free, the first at \
             ({:.5}, {:.5}, {:.5}) m\n  gas pressure has no energy unless the wall is closed or its \
             rim is fixed along x, y and z, or plane and fixed along the normal: add the tag around \
             the opening to [[fixed]]",
            free.len(),
            rim.len(),
            p.x,
            p.y,
            p.z
        );
    }
    Ok(())
}
