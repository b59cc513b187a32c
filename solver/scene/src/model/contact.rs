//! Contact of a scene: its collision surface, barrier and friction.

use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::contact::barrier::Barrier;
use mechanics::contact::rest_offset::Close;
use mechanics::contact::surface::{Obstacle, Surface};
use mechanics::element::FunctionSpace;
use mechanics::energy::{Contact, Friction};
use mesh::Vec3;
use program::{KeyPath, misfit};

use super::Scene;
use crate::config::{ContactConfig, beside};

/// Size of an obstacle from which it looks like one in millimetres [that of the bodies].
const LARGEST_OBSTACLE: f64 = 300.0;

/// Contact of a scene.
pub(super) struct Collisions {
    /// The barrier between surfaces.
    pub contact: Contact,
    /// Friction between them, if there is any.
    pub friction: Option<Friction>,
}

impl Scene {
    /// Contact of bodies with these degrees of freedom fixed; none where the scene
    /// has none.
    pub(super) fn collisions(
        &self,
        body: &Body,
        space: &FunctionSpace,
        fixed: &[bool],
    ) -> Result<Option<Collisions>> {
        let Some(config) = self.config.contact() else { return Ok(None) };
        let mut obstacles = Vec::new();
        for obstacle in &self.config.obstacle {
            let path = beside(&self.path, &obstacle.surface);
            let surface = mesh::io::read_surface_in_metres(&path)?;
            check_unit(&surface.vertices, &body.mesh.vertices)
                .with_context(|| path.display().to_string())?;
            let (surface, mirrored) = self.complete(surface, obstacle, body)?;
            let moves = !obstacle.displacement.is_zero();
            let displacement = self.config.field(&obstacle.displacement);
            let motion = move |place: Vec3, load: f64| {
                let mut motion = displacement.at(place, load);
                mirrored.iter().for_each(|mirror| mirror.turn(place, &mut motion));
                motion
            };
            obstacles.push(Obstacle { surface, motion: moves.then(|| Box::new(motion) as _) });
        }
        let parts: Vec<usize> = body.boundary().iter().map(|f| body.part_of(f[0])).collect();
        let split = config.split.unwrap_or(space.degree());
        let (planes, facets) = (&body.planes, body.boundary());
        let surface = Surface::new(planes, space, facets, &parts, obstacles, split, fixed);
        let surface = Arc::new(surface);
        let barrier = self.barrier(config, &surface, space, body);
        let rest = surface.rest(space, &body.mesh.vertices);
        let context = || self.path.display().to_string();
        check_edges(&surface, &rest, &barrier).with_context(context)?;
        let friction = (config.friction > 0.0)
            .then(|| Friction::new(Arc::clone(&surface), config.friction, config.friction_speed));
        let contact = Contact::new(Arc::clone(&surface), config.pairs.partners(), barrier);
        let contact = if self.certify { contact.certified() } else { contact };
        if let Some(what) = contact.intersection(&rest) {
            let names = self.surface_names();
            let [a, b] =
                what.triangles.map(|t| names[surface.body(surface.features().triangles[t][0])]);
            bail!(
                "{}: at rest {what}, of \"{a}\" and \"{b}\"\n  bodies must be apart at the start: move \
                 one by translate, or repair the mesh",
                self.path.display()
            );
        }
        self.check_nested(&surface, &rest).with_context(context)?;
        self.check_gaps(&contact, &rest, &barrier).with_context(context)?;
        Ok(Some(Collisions { contact, friction }))
    }

    /// The barrier, with what the scene leaves open taken from the mesh and the materials. A
    /// design does not change them: they are those of the scene's own shape.
    fn barrier(
        &self,
        config: &ContactConfig,
        surface: &Surface,
        space: &FunctionSpace,
        body: &Body,
    ) -> Barrier {
        let &ContactConfig { form, barrier: density, thickness, .. } = config;
        let own = &self.body.mesh.vertices;
        let vertices = if own.len() == space.vertex_count() { own } else { &body.mesh.vertices };
        let by_mesh = || {
            let shortest = shortest_edge(surface, &surface.rest(space, vertices));
            let size = || mesh::measure::volume(&body.mesh).cbrt();
            round_down(0.5 * shortest.map_or_else(size, |(length, _)| length - thickness))
        };
        let activation = config.activation.unwrap_or_else(by_mesh);
        let stiffness = config.stiffness.unwrap_or_else(|| self.largest_shear_modulus());
        log::debug!("[contact]: activation = {activation:.1e} m, stiffness = {stiffness:.3e}");
        Barrier { form, density, activation, stiffness, thickness }
    }

    /// Surfaces must be farther apart at rest than they may ever come; what is within the
    /// activation there is told.
    fn check_gaps(&self, contact: &Contact, rest: &[Vec3], barrier: &Barrier) -> Result<()> {
        let close = contact.close_at_rest(rest).unwrap_or_default();
        let nearest = |chosen: &dyn Fn(&Close) -> bool| {
            let chosen: Vec<_> = close.iter().filter(|pair| chosen(pair)).collect();
            let nearest = chosen.iter().min_by(|a, b| a.closest.d2.total_cmp(&b.closest.d2))?;
            Some((
                self.between(nearest, contact.surface(), rest),
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
    fn between(&self, Close { pair, .. }: &Close, surface: &Surface, rest: &[Vec3]) -> String {
        let (corners, names) = (pair.corners(), self.surface_names());
        let [first, second] = [corners[0], corners[3]].map(|v| names[surface.body(v)]);
        let p = rest[corners[0]];
        format!("\"{first}\" at ({:.5}, {:.5}, {:.5}) m and \"{second}\"", p.x, p.y, p.z)
    }
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
