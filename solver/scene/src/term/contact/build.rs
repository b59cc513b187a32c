//! Contact of a body: its collision surface, barrier and friction.

use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use mechanics::contact::barrier::Barrier;
use mechanics::contact::rest_offset::Close;
use mechanics::contact::surface::{Obstacle, Surface};
use mechanics::energy::{Contact, Energies, Friction, Term};
use mesh::Vec3;
use program::{KeyPath, misfit};

use super::apart::check_nested;
use super::obstacle::complete;
use super::{ContactConfig, ObstacleConfig};
use crate::term::Ground;
use crate::term::material::largest_shear_modulus;

/// Size of an obstacle from which it looks like one in millimetres [that of the bodies].
const LARGEST_OBSTACLE: f64 = 300.0;

/// Contact, and friction if there is any.
pub(super) fn terms(config: &ContactConfig, ground: &Ground) -> Result<Vec<Term>> {
    if let Some(last) = ground.last {
        return Ok(again(config, ground, last));
    }
    let Ground { body, space, path, .. } = ground;
    let obstacles = ground.obstacles.iter().map(|own| obstacle(own, ground));
    let obstacles = obstacles.collect::<Result<Vec<_>>>()?;
    let parts: Vec<usize> = body.boundary().iter().map(|f| body.part_of(f[0])).collect();
    let split = config.split.unwrap_or(space.degree());
    let (planes, facets, fixed) = (&body.planes, body.boundary(), ground.supports.fixed());
    let surface = Surface::new(planes, space, facets, &parts, obstacles, split, &fixed);
    let surface = Arc::new(surface);
    let barrier = barrier(config, &surface, ground);
    let rest = surface.rest(space, &body.mesh.vertices);
    let context = || path.display().to_string();
    check_edges(&surface, &rest, &barrier).with_context(context)?;
    let contact = Contact::new(Arc::clone(&surface), config.pairs.partners(), barrier);
    let contact = if ground.certify { contact.certified() } else { contact };
    if let Some(what) = contact.intersection(&rest) {
        let name = |t: usize| surface.body(surface.features().triangles[t][0]);
        let [a, b] = what.triangles.map(|t| ground.surfaces[name(t)]);
        bail!(
            "{}: at rest {what}, of \"{a}\" and \"{b}\"\n  bodies must be apart at the start: move \
             one by translate, or repair the mesh",
            path.display()
        );
    }
    check_nested(&surface, &rest, ground, true).with_context(context)?;
    check_gaps(&contact, &rest, &barrier, ground).with_context(context)?;
    let friction = (config.friction > 0.0)
        .then(|| Friction::new(surface, config.friction, config.friction_speed));
    let friction = friction.map(|own| Term::of(Friction::OWNER, own));
    Ok([Term::of(Contact::OWNER, contact)].into_iter().chain(friction).collect())
}

/// The terms that there were, with the friction of this scene, and the stiffness that follows from its laws.
fn again(config: &ContactConfig, Ground { laws, .. }: &Ground, last: &Energies) -> Vec<Term> {
    let is_contact = |term: &&Term| term.nature().is_contact();
    let mut own: Energies = last.terms().filter(is_contact).cloned().collect();
    own.change(|_, friction: &Friction| friction.clone().with_coefficient(config.friction));
    if config.stiffness.is_none() {
        let stiffness = largest_shear_modulus(*laws);
        own.change(|_, contact: &Contact| contact.with_stiffness(stiffness));
    }
    own.terms().cloned().collect()
}

/// An obstacle from its file, with its mirror images.
fn obstacle(config: &ObstacleConfig, ground: &Ground) -> Result<Obstacle> {
    let path = ground.path.with_file_name(&config.surface);
    let surface = mesh::io::read_surface_in_metres(&path)?;
    check_unit(&surface.vertices, &ground.body.mesh.vertices)
        .with_context(|| path.display().to_string())?;
    let (surface, mirrored) = complete(surface, config, ground)?;
    let moves = !config.displacement.is_zero();
    let displacement = ground.around.values.field(&config.displacement);
    let motion = move |place: Vec3, load: f64| {
        let mut motion = displacement.at(place, load);
        mirrored.iter().for_each(|mirror| mirror.turn(place, &mut motion));
        motion
    };
    Ok(Obstacle { surface, motion: moves.then(|| Box::new(motion) as _) })
}

/// The barrier, with what the scene leaves open taken from the mesh and the materials. A
/// design does not change them: they are those of the scene's own shape.
fn barrier(config: &ContactConfig, surface: &Surface, ground: &Ground) -> Barrier {
    let &ContactConfig { form, barrier: density, thickness, .. } = config;
    let Ground { own_shape: own, space, body, .. } = ground;
    let is_own = own.len() == space.vertex_count();
    let vertices: &[Vec3] = if is_own { own } else { &body.mesh.vertices };
    let by_mesh = || {
        let shortest = shortest_edge(surface, &surface.rest(space, vertices));
        let size = || mesh::measure::volume(&body.mesh).cbrt();
        round_down(0.5 * shortest.map_or_else(size, |(length, _)| length - thickness))
    };
    let activation = config.activation.unwrap_or_else(by_mesh);
    let stiffness = config.stiffness.unwrap_or_else(|| largest_shear_modulus(ground.laws));
    log::debug!("[contact]: activation = {activation:.1e} m, stiffness = {stiffness:.3e}");
    Barrier { form, density, activation, stiffness, thickness }
}

/// Surfaces must be farther apart at rest than they may ever come; what is within the
/// activation there is told.
fn check_gaps(contact: &Contact, rest: &[Vec3], barrier: &Barrier, ground: &Ground) -> Result<()> {
    let close = contact.close_at_rest(rest).unwrap_or_default();
    let nearest = |chosen: &dyn Fn(&Close) -> bool| {
        let chosen: Vec<_> = close.iter().filter(|pair| chosen(pair)).collect();
        let nearest = chosen.iter().min_by(|a, b| a.closest.d2.total_cmp(&b.closest.d2))?;
        Some((
            between(nearest, contact.surface(), rest, ground),
            nearest.closest.d2.sqrt(),
            chosen.len(),
        ))
    };
    let (thickness, repulsion) = (barrier.thickness, barrier.repulsion());
    if let Some((between, distance, _)) = nearest(&|_| true) {
        ensure!(
            distance > thickness,
            misfit!(
                KeyPath::table("contact"),
                ": at rest {between} are {distance:.3e} m apart, but thickness = {thickness:.3e} m\n  \
                 surfaces cannot come closer than that: lower the thickness, or move a body by translate"
            )
        );
    }
    let range = barrier.range();
    if let Some((between, distance, count)) = nearest(&|pair| pair.acts(&repulsion)) {
        log::warn!(
            "[contact]: at rest {between} are {distance:.3e} m apart, and {count} pairs are \
             closer than activation + thickness = {range:.3e} m: they push each other away \
             without any load"
        );
    }
    if let Some((between, distance, count)) = nearest(&|pair| pair.offset.is_some()) {
        log::info!(
            "[contact]: at rest {between} are {distance:.3e} m apart, and {count} pairs of one \
             body are closer than activation + thickness = {range:.3e} m: they repel each other \
             only below the distance that they have at rest"
        );
    }
    Ok(())
}

/// Between which surfaces a pair is, and where.
fn between(
    Close { pair, .. }: &Close,
    surface: &Surface,
    rest: &[Vec3],
    ground: &Ground,
) -> String {
    let corners = pair.corners();
    let [first, second] = [corners[0], corners[3]].map(|v| ground.surfaces[surface.body(v)]);
    let p = rest[corners[0]];
    format!("\"{first}\" at ({:.5}, {:.5}, {:.5}) m and \"{second}\"", p.x, p.y, p.z)
}

/// Features of one surface that share no vertex must be farther apart than the
/// barrier reaches, or it would push neighbours apart at rest.
fn check_edges(surface: &Surface, rest: &[Vec3], barrier: &Barrier) -> Result<()> {
    let Some((shortest, at)) = shortest_edge(surface, rest) else { return Ok(()) };
    let p = rest[at];
    ensure!(
        barrier.range() < shortest,
        misfit!(
            KeyPath::table("contact"),
            ": activation + thickness = {:.3e} m, but the shortest edge of the collision surface has \
             {shortest:.3e} m, at ({:.5}, {:.5}, {:.5}) m\n  neighbours would repel each other: lower \
             the activation, or use a mesh without such short edges{}",
            barrier.range(),
            p.x,
            p.y,
            p.z,
            if barrier.range() < 2.0 * shortest { ", or a smaller split" } else { "" }
        )
    );
    Ok(())
}

/// An obstacle must not be as large as if its unit were another than that of the bodies.
fn check_unit(obstacle: &[Vec3], bodies: &[Vec3]) -> Result<()> {
    let [size, of_bodies] = [obstacle, bodies].map(mesh::measure::diagonal);
    let unlikely = mesh::measure::unlikely_size(obstacle).is_some();
    ensure!(
        !unlikely || size < LARGEST_OBSTACLE * of_bodies,
        "the obstacle is {size:.4} m from corner to corner, the bodies are {of_bodies:.4} m: lengths \
         are read as metres\n  is its unit another? `cad2fem import FILE --unit mm -o OBSTACLE.stl` \
         converts it"
    );
    Ok(())
}

/// The shortest edge of a collision surface that moves: its length [m] and one of its ends.
fn shortest_edge(surface: &Surface, rest: &[Vec3]) -> Option<(f64, usize)> {
    let movable = surface.features().edges.iter().filter(|edge| !surface.immovable(&edge[..]));
    let length = |&[a, b]: &[usize; 2]| (rest[a] - rest[b]).norm();
    movable.map(|edge| (length(edge), edge[0])).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The largest of 1, 2 or 5 × 10ⁿ that is no larger.
fn round_down(length: f64) -> f64 {
    let power = length.log10().floor();
    let digit = [5.0, 2.0].into_iter().find(|digit| digit * 10_f64.powf(power) <= length);
    digit.unwrap_or(1.0) * 10_f64.powf(power)
}
