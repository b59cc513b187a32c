//! Chambers on a body: their walls, gas laws and checks.

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Chamber, ChamberId, Energies, GasLaw, Multiplier, Rim, Term, Wall};
use program::{KeyPath, misfit};

use super::ChamberConfig;
use crate::supports::Supports;
use crate::term::Ground;
use crate::term::material::largest_shear_modulus;

/// Volume behind a wall at rest, over the largest that is prescribed, below which there is none.
const FLAT: f64 = 1e-3;
/// Penalty of a prescribed volume in shear moduli per rest volume.
const PENALTY: f64 = 10.0;
/// Height of a rim over its extent up to which it lies in a plane.
const OFF_PLANE: f64 = 1e-9;

/// The chambers of a body, in the order of the scene; `first` internal variables are of the terms before.
pub(super) fn terms(all: &[ChamberConfig], ground: &Ground, mut first: usize) -> Result<Vec<Term>> {
    let (mut terms, mut prescribed) = (Vec::new(), 0..);
    for (place, config) in all.iter().enumerate() {
        let (id, gas) = (ChamberId::of(place), config.law(&ground.around.values));
        if let Some(last) = ground.last {
            let chamber = Chamber { gas, ..last.chamber(id).clone() };
            terms.push(Term::of(id.owner(), chamber));
            continue;
        }
        let (wall, volume) = wall(config, &*gas, ground)?;
        check_rim(&config.name, &wall, ground)?;
        let multiplier = gas.wanted(volume, 0.0).and_then(|_| prescribed.next());
        let remembers = ground.around.in_time && gas.remembers().is_some();
        let memory = remembers.then_some(first);
        first += usize::from(remembers);
        let name = config.name.clone();
        let chamber = Chamber { name, multiplier, memory, ..Chamber::new(wall, gas) };
        terms.push(Term::of(id.owner(), chamber));
    }
    Ok(terms)
}

/// The wall of a chamber, and the volume behind it at rest [m³].
fn wall(config: &ChamberConfig, gas: &dyn GasLaw, ground: &Ground) -> Result<(Wall, f64)> {
    let Ground { around, body, space, .. } = ground;
    let path = ground.path.display();
    let (title, nodes) = (config.title(), space.node_positions(&body.mesh.vertices));
    let mut facets = Vec::new();
    for tag in config.on.all() {
        facets.extend(body.facets(tag).with_context(|| path.to_string())?);
    }
    let mut wall = Wall::cut_by(&body.planes, space, &facets);
    if config.plug {
        ensure!(
            !wall.is_closed(),
            title.clone().key("plug").told(format!(
                "{path}: {title}: plug = true: the wall is closed, there is nothing to plug"
            ))
        );
        wall = wall.plugged();
    }
    let volume = wall.volume(space, |n| nodes[n]);
    ensure!(
        !gas.needs_space() || volume > 0.0,
        title.told(format!(
            "{path}: \"{}\": the volume behind the wall is {volume:.3e} m³, must be \
             positive\n  the tag is not the wall of a chamber",
            config.name
        ))
    );
    let wanted = |t: f64| gas.wanted(volume, t).map(|wanted| (t, wanted.volume));
    for (t, wanted) in around.values.moments().into_iter().filter_map(wanted) {
        // at the start nothing is measured against it
        let sound = if gas.needs_space() { wanted > 0.0 } else { wanted != 0.0 };
        ensure!(
            sound || (volume == 0.0 && t == 0.0),
            title.clone().told(format!(
                "{path}: {title}: the chamber of {volume:.3e} m³ would have {wanted:.3e} m³ at t = {t}; \
                 must be {}",
                if gas.needs_space() { "positive" } else { "another than 0" }
            ))
        );
    }
    Ok((wall, volume))
}

/// Multipliers of the prescribed volumes at rest, with a penalty well above what a wall
/// in a large block resists to a change of volume: 4/3 of its shear modulus
/// per volume.
pub(crate) fn multipliers(energies: &Energies, ground: &Ground) -> Vec<Multiplier> {
    let Ground { around, body, space, laws, .. } = ground;
    let nodes = space.node_positions(&body.mesh.vertices);
    let (shear, moments) = (largest_shear_modulus(*laws), around.values.moments());
    let one = |chamber: &Chamber| {
        let rest = chamber.wall.volume(space, |n| nodes[n]);
        let wanted = |t: &f64| chamber.gas.wanted(rest, *t).map_or(0.0, |w| w.volume.abs());
        // below a flat membrane there is none at rest
        let largest = moments.iter().map(wanted).fold(0.0, f64::max);
        let size = if rest.abs() > FLAT * largest { rest.abs() } else { largest };
        Multiplier { pressure: 0.0, penalty: PENALTY * shear / size }
    };
    let chambers = energies.each::<Chamber>();
    chambers.filter(|chamber| chamber.multiplier.is_some()).map(one).collect()
}

/// The gas force has a potential only when every rim of its wall is fixed along
/// all axes, moves only within a plane, or is plugged.
fn check_rim(name: &str, wall: &Wall, ground: &Ground) -> Result<()> {
    if wall.is_plugged() {
        return Ok(());
    }
    let &Ground { supports, space, body, .. } = ground;
    let nodes = |&[a, b]: &[usize; 2]| [a, b].into_iter().chain(space.edge_nodes([a, b]));
    let clamped = |edge: &[usize; 2]| nodes(edge).all(|node| supports.clamps(node));
    let (mut count, mut free) = (0, Vec::new());
    for rim in wall.rims() {
        count += rim.edges().count();
        if !(0..3).any(|axis| slides(rim, axis, supports, space, body)) {
            free.extend(rim.edges().filter(|edge| !clamped(edge)));
        }
    }
    let Some([a, _]) = free.first() else { return Ok(()) };
    let p = body.mesh.vertices[*a];
    Err(misfit!(
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
    )
    .into())
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
