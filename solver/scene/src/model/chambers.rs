//! The chambers of a scene: their walls, gas laws and checks.

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Chamber, Energies, Multiplier, Rim, Wall};
use program::{KeyPath, misfit};

use super::Scene;
use crate::supports::Supports;

/// Volume behind a wall at rest, over the largest that is prescribed, below which there is none.
const FLAT: f64 = 1e-3;
/// Penalty of a prescribed volume in shear moduli per rest volume.
const PENALTY: f64 = 10.0;
/// Height of a rim over its extent up to which it lies in a plane.
const OFF_PLANE: f64 = 1e-9;

impl Scene {
    /// The chambers of a body by their names, in the order of the scene; `internal` variables are of the terms
    /// before.
    pub(super) fn chambers(
        &self,
        body: &Body,
        space: &FunctionSpace,
        internal: usize,
    ) -> Result<Vec<(String, Chamber)>> {
        let context = || self.path.display().to_string();
        let nodes = space.node_positions(&body.mesh.vertices);
        let moments = self.config.moments();
        let (mut chambers, mut prescribed, mut remembered) = (Vec::new(), 0, 0);
        for config in &self.config.chamber {
            let gas = self.config.gas_law(config);
            let mut facets = Vec::new();
            for tag in config.on.all() {
                facets.extend(body.facets(tag).with_context(context)?);
            }
            let mut wall = Wall::cut_by(&body.planes, space, &facets);
            if config.plug {
                ensure!(
                    !wall.is_closed(),
                    config.title().key("plug").told(format!(
                        "{}: {}: plug = true: the wall is closed, there is nothing to plug",
                        self.path.display(),
                        config.title()
                    ))
                );
                wall = wall.plugged();
            }
            let volume = wall.volume(space, |n| nodes[n]);
            if gas.needs_space() && volume <= 0.0 {
                bail!(config.title().told(format!(
                    "{}: \"{}\": the volume behind the wall is {volume:.3e} m³, must be \
                     positive\n  the tag is not the wall of a chamber",
                    self.path.display(),
                    config.name
                )));
            }
            let wanted = |t: f64| gas.wanted(volume, t).map(|wanted| (t, wanted.volume));
            for (t, wanted) in moments.iter().filter_map(|&t| wanted(t)) {
                // at the start nothing is measured against it
                let sound = if gas.needs_space() { wanted > 0.0 } else { wanted != 0.0 };
                ensure!(
                    sound || (volume == 0.0 && t == 0.0),
                    config.title().told(format!(
                        "{}: {}: the chamber of {volume:.3e} m³ would have {wanted:.3e} m³ at t = {t}; \
                         must be {}",
                        self.path.display(),
                        config.title(),
                        if gas.needs_space() { "positive" } else { "another than 0" }
                    ))
                );
            }
            let multiplier = gas.wanted(volume, 0.0).map(|_| prescribed);
            prescribed += usize::from(multiplier.is_some());
            let remembers = self.config.time.is_some() && gas.remembers().is_some();
            let memory = remembers.then_some(internal + remembered);
            remembered += usize::from(remembers);
            let chamber = Chamber { multiplier, memory, ..Chamber::new(wall, gas) };
            chambers.push((config.name.clone(), chamber));
        }
        Ok(chambers)
    }

    /// Multipliers of the prescribed volumes at rest, with a penalty well above what a wall
    /// in a large block resists to a change of volume: 4/3 of its shear modulus
    /// per volume.
    pub(super) fn multipliers(
        &self,
        body: &Body,
        space: &FunctionSpace,
        energies: &Energies,
    ) -> Vec<Multiplier> {
        let nodes = space.node_positions(&body.mesh.vertices);
        let shear = self.largest_shear_modulus();
        let one = |chamber: &Chamber| {
            let rest = chamber.wall.volume(space, |n| nodes[n]);
            let wanted = |t: &f64| chamber.gas.wanted(rest, *t).map_or(0.0, |w| w.volume.abs());
            // below a flat membrane there is none at rest
            let largest = self.config.moments().iter().map(wanted).fold(0.0, f64::max);
            let size = if rest.abs() > FLAT * largest { rest.abs() } else { largest };
            Multiplier { pressure: 0.0, penalty: PENALTY * shear / size }
        };
        let chambers = energies.chambers().map(|(_, chamber)| chamber);
        chambers.filter(|c| c.multiplier.is_some()).map(one).collect()
    }
}

/// The gas force has a potential only when every rim of its wall is fixed along
/// all axes, moves only within a plane, or is plugged.
pub(super) fn check_rim(
    name: &str,
    wall: &Wall,
    supports: &Supports,
    space: &FunctionSpace,
    body: &Body,
) -> Result<()> {
    if wall.is_plugged() {
        return Ok(());
    }
    let nodes = |&[a, b]: &[usize; 2]| [a, b].into_iter().chain(space.edge_nodes([a, b]));
    let clamped = |edge: &[usize; 2]| nodes(edge).all(|node| supports.clamps(node));
    let (mut count, mut free) = (0, Vec::new());
    for rim in wall.rims() {
        count += rim.edges().count();
        if !(0..3).any(|axis| slides(rim, axis, supports, space, body)) {
            free.extend(rim.edges().filter(|edge| !clamped(edge)));
        }
    }
    if let Some([a, _]) = free.first() {
        let p = body.mesh.vertices[*a];
        bail!(misfit!(
            KeyPath::list("chamber").on(name),
            ": {} of the {count} edges of its rim are free, the first at \
             ({:.5}, {:.5}, {:.5}) m\n  gas pressure has no energy unless the wall is closed or its \
             rim is fixed along x, y and z, or lies in a plane across one of these axes and is fixed \
             along that: add the tag around the opening to [[fixed]], or to [[symmetry]] if the body \
             is cut there; or write plug = true, if a plug closes it and moves with the body",
            free.len(),
            p.x,
            p.y,
            p.z
        ));
    }
    Ok(())
}

/// Whether a rim lies in a plane across an axis and all its nodes stay there.
fn slides(rim: &Rim, axis: usize, supports: &Supports, space: &FunctionSpace, body: &Body) -> bool {
    let x = &body.mesh.vertices;
    let first = x[rim.vertices[0]];
    let size = rim.vertices.iter().map(|&v| (x[v] - first).norm()).fold(0.0, f64::max);
    let flat = rim.vertices.iter().all(|&v| (x[v][axis] - first[axis]).abs() < OFF_PLANE * size);
    let stays = |edge: [usize; 2]| {
        let mut nodes = edge.into_iter().chain(space.edge_nodes(edge));
        nodes.all(|n| supports.stays(n, axis))
    };
    flat && rim.edges().all(stays)
}
