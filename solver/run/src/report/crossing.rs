//! Surfaces that have passed through each other in a scene without contact.

use mechanics::body::Body;
use mechanics::contact::certificate::crossing_pairs;
use mechanics::contact::surface::Surface;
use mechanics::energy::Iterate;
use mechanics::forward::Problem;
use mesh::Vec3;
use scene::Scene;

/// What to do about surfaces that meet in a scene without contact.
pub const WAY_OUT: &str =
    "add the line [contact], which needs no number, or contact = \"ignored\" if that may be";

/// Pairs of triangles of the boundary, each facet cut as for contact, that intersect.
pub struct Crossing {
    /// How many there are.
    pub pairs: usize,
    /// A place of the first [m].
    place: Vec3,
    /// The bodies that it belongs to.
    bodies: [String; 2],
}

impl Crossing {
    /// At a state of a body in a scene without contact; none where it has contact, or says that
    /// it is ignored, or nothing intersects. Decided by exact predicates.
    pub fn find(scene: &Scene, body: &Body, problem: &Problem, at: &Iterate) -> Option<Self> {
        if scene.config.contact.is_some() {
            return None;
        }
        let parts: Vec<usize> = body.boundary().iter().map(|f| body.part_of(f[0])).collect();
        let (space, fixed) = (at.space, problem.dirichlet.fixed());
        let (planes, facets) = (&body.planes, body.boundary());
        let surface =
            Surface::new(planes, space, facets, &parts, Vec::new(), space.degree(), fixed);
        let x = surface.positions(space, at.rest, at.u, at.time);
        let triangles = &surface.features().triangles;
        let pairs = crossing_pairs(triangles, &x, |_| true);
        let &(first, second) = pairs.first()?;
        let names = scene.surface_names();
        let name = |t: usize| names[surface.body(triangles[t][0])].to_owned();
        let corners = triangles[first].map(|v| x[v]);
        let place = corners.iter().sum::<Vec3>() / 3.0;
        Some(Self { pairs: pairs.len(), place, bodies: [name(first), name(second)] })
    }

    /// What to say of it.
    pub fn in_words(&self) -> String {
        let [a, b] = &self.bodies;
        let p = self.place;
        let whose = if a == b { format!("of \"{a}\"") } else { format!("of \"{a}\" and \"{b}\"") };
        format!(
            "{} pairs of triangles on the surfaces {whose} run through each other at the end, the first \
             near ({:.5}, {:.5}, {:.5}) m: without contact nothing holds them apart\n  {WAY_OUT}",
            self.pairs, p.x, p.y, p.z
        )
    }

    /// For report.json.
    pub fn report(&self) -> reports::Crossing {
        let (pairs, bodies, place) = (self.pairs, self.bodies.clone(), self.place.into());
        reports::Crossing { pairs, bodies, place }
    }
}
