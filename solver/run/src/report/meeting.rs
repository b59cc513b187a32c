//! Parts of a surface that will meet under load, said before the run of a scene without contact.
//!
//! s = λ w / (τ·(u(a) − u(b)))      the part of the full load at which they meet [1]
//!
//! a, b   middle of a facet, and of the one that it faces through air, along the normal τ at a
//! w      the gap between them at rest [m]
//! u      displacement under the part λ = `SMALL` of the load: one step of Newton's method from rest [m]
//!
//! That is linear elasticity: a body that grows softer as it is stretched closes a gap earlier. The cost is one
//! assembly and one factorisation, where there are gaps at all. Walls of one chamber whose pressure is positive are none:
//! it drives them apart.

use std::collections::HashMap;

use mechanics::body::Body;
use mechanics::element::at;
use mechanics::energy::Iterate;
use mechanics::forward::{Problem, Workspace, newton_step};
use mesh::walls::gaps;
use mesh::{SurfaceMesh, Vec3};
use scene::Scene;

use crate::report::crossing::WAY_OUT;
use crate::report::results;

/// Part of the full load that is small, so that its displacements are linear in it.
const SMALL: f64 = 1e-3;

/// Facets that will meet.
struct Meeting {
    /// The gap between them at rest [m].
    gap: f64,
    /// Part of the full load at which they do.
    load: f64,
    facets: [[usize; 3]; 2],
}

/// A warning where parts of the surface of a static scene without contact will meet. The workspace is left as new.
pub fn foreseen(scene: &Scene, problem: &Problem, workspace: &mut Workspace) -> Option<String> {
    if scene.config.contact.is_some() || scene.config.time.is_some() || !scene.certify {
        return None;
    }
    let found = first(scene, problem, workspace);
    workspace.forget();
    let meeting = found.filter(|meeting| meeting.load < 1.0)?;
    Some(format!("{}: {}", scene.path.display(), in_words(&meeting, &scene.body)))
}

/// The facets that meet first, under whatever load.
fn first(scene: &Scene, problem: &Problem, workspace: &mut Workspace) -> Option<Meeting> {
    let body = &scene.body;
    let (rest, facets) = (&body.mesh.vertices, body.boundary());
    let surface = SurfaceMesh { vertices: rest.clone(), triangles: facets.to_vec() };
    let still = vec![0.0; problem.dofs()];
    let inflated = inflated(scene, problem, &problem.iterate(rest, &still, SMALL));
    let mut gaps = gaps(&surface);
    gaps.retain(|(_, pair)| {
        let [a, b] = pair.map(|t| body.tags.get(facets[t]).and_then(|tag| inflated.get(&tag)));
        a.is_none() || a != b
    });
    if gaps.is_empty() {
        return None;
    }
    let led = workspace.move_supports(problem, &problem.iterate(rest, &still, SMALL));
    let start = Iterate { u: &led, ..problem.iterate(rest, &still, SMALL) };
    let step = newton_step(problem, workspace, &start)?;
    let u: Vec<f64> = led.iter().zip(&step).map(|(u, step)| u + step).collect();
    let middle = |t: usize| facets[t].iter().map(|&v| at(&u, v)).sum::<Vec3>() / 3.0;
    let meeting = |&(gap, [from, to]): &(f64, [usize; 2])| {
        let [a, b, c] = surface.corners(from);
        let closing = mesh::measure::triangle_normal(a, b, c).dot(&(middle(from) - middle(to)));
        let load = SMALL * gap / closing;
        (closing > 0.0 && load.is_finite()).then(|| Meeting {
            gap,
            load,
            facets: [from, to].map(|t| facets[t]),
        })
    };
    gaps.iter().filter_map(meeting).min_by(|a, b| a.load.total_cmp(&b.load))
}

/// The chambers with positive pressure, by the tags of their walls.
fn inflated(scene: &Scene, problem: &Problem, at: &Iterate) -> HashMap<u32, usize> {
    let state = results::chambers(&problem.energies, at);
    let mut of_tag = HashMap::new();
    for (place, chamber) in scene.config.chamber.iter().enumerate() {
        if state.get(&chamber.name).is_some_and(|state| state.pressure > 0.0) {
            let on_wall =
                scene.body.tags.names.iter().zip(1..).filter(|(name, _)| chamber.is_on(name));
            of_tag.extend(on_wall.map(|(_, tag)| (tag, place)));
        }
    }
    of_tag
}

fn in_words(Meeting { gap, load, facets }: &Meeting, body: &Body) -> String {
    let tag = |facet: &[usize; 3]| {
        let id = body.tags.get(*facet);
        id.map_or_else(
            || "no tag".to_owned(),
            |id| format!("\"{}\"", body.tags.names[id as usize - 1]),
        )
    };
    let [a, b] = [0, 1].map(|i| tag(&facets[i]));
    let on = if a == b { format!("two parts of {a}") } else { format!("{a} and {b}") };
    let corners = facets[0].iter().map(|&v| body.mesh.vertices[v]);
    let at = 1e3 * corners.sum::<Vec3>() / 3.0;
    format!(
        "{on} will meet: {:.2} mm apart at rest, at ({:.1}, {:.1}, {:.1}) mm, they close that at {:.0} % of the load \
         by linear elasticity; without contact they run through each other, and the result is not usable\n  {WAY_OUT}",
        1e3 * gap,
        at.x,
        at.y,
        at.z,
        100.0 * load
    )
}
