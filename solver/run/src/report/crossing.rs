//! Surfaces that have passed through each other in a scene without contact.

use mechanics::body::Body;
use mechanics::contact::certificate::crossing_pairs;
use mechanics::contact::surface::Surface;
use mechanics::energy::Iterate;
use mechanics::forward::Problem;
use mesh::Vec3;
use reports::Crossing;
use scene::Scene;

/// What to do about surfaces that meet in a scene without contact.
pub const WAY_OUT: &str =
    "add the line [contact], which needs no number, or contact = \"ignored\" if that may be";

/// Pairs of triangles of the boundary, each facet cut as for contact, that intersect at a state of a body in a scene
/// without contact; none where it has contact, or says that it is ignored, or nothing intersects. Decided by exact
/// predicates.
pub fn find(scene: &Scene, body: &Body, problem: &Problem, at: &Iterate) -> Option<Crossing> {
    if scene.config.contact.is_some() {
        return None;
    }
    let parts: Vec<usize> = body.boundary().iter().map(|f| body.part_of(f[0])).collect();
    let (space, fixed) = (at.space, problem.dirichlet.fixed());
    let (planes, facets) = (&body.planes, body.boundary());
    let surface = Surface::new(planes, space, facets, &parts, Vec::new(), space.degree(), fixed);
    let x = surface.positions(space, at.rest, at.u, at.time);
    let triangles = &surface.features().triangles;
    let pairs = crossing_pairs(triangles, &x, |_| true);
    let &(first, second) = pairs.first()?;
    let names = scene.surface_names();
    let name = |t: usize| names[surface.body(triangles[t][0])].to_owned();
    let place = triangles[first].iter().map(|&v| x[v]).sum::<Vec3>() / 3.0;
    let bodies = [name(first), name(second)];
    Some(Crossing { pairs: pairs.len(), place: place.into(), bodies })
}

/// What to say of it.
pub fn in_words(Crossing { pairs, bodies: [a, b], place: [x, y, z] }: &Crossing) -> String {
    let whose = if a == b { format!("of \"{a}\"") } else { format!("of \"{a}\" and \"{b}\"") };
    format!(
        "{pairs} pairs of triangles on the surfaces {whose} run through each other at the end, the first \
         near ({x:.5}, {y:.5}, {z:.5}) m: without contact nothing holds them apart\n  {WAY_OUT}"
    )
}
