//! Time steps in which a body moves farther than it is long.

use mechanics::body::Body;
use mechanics::element::at;
use mesh::Vec3;
use mesh::measure::diagonal;

/// What to say of the first body whose mean displacement grows, from the displacement `before` to
/// `after` [m], by more than its own length: it may pass others that it should have met.
pub fn leap(body: &Body, before: &[f64], after: &[f64]) -> Option<String> {
    body.parts.iter().find_map(|part| {
        let (vertices, count) = (part.vertices.clone(), part.vertices.len() as f64);
        let moved: Vec3 = vertices.clone().map(|v| at(after, v) - at(before, v)).sum();
        let (moved, length) = (moved.norm() / count, diagonal(&body.mesh.vertices[vertices]));
        let name = part.name.as_ref().map_or(String::new(), |name| format!(" \"{name}\""));
        (moved > length).then(|| {
            format!(
                "the body{name} moves by {moved:.3e} m within one time step, {:.1} of its own \
                 lengths: it may pass others without touching them; make more time steps",
                moved / length
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use mechanics::testing;
    use mesh::Tags;

    use super::*;

    #[test]
    fn a_body_may_move_by_its_own_length_and_no_farther() {
        let body = Body::new(testing::cube(2, 0.0), Tags::default());
        let nodes = body.mesh.vertices.len();
        let shifted = |x: f64| [x, 0.0, 0.0].repeat(nodes);
        // the diagonal of the unit cube is 1.73 m
        assert_eq!(leap(&body, &shifted(1.0), &shifted(2.7)), None);
        let said = leap(&body, &shifted(1.0), &shifted(4.47)).unwrap_or_default();
        assert!(said.contains("3.470e0 m") && said.contains("2.0 of its own lengths"), "{said}");
        // what turns or grows in its place does not move
        let grown: Vec<f64> =
            body.mesh.vertices.iter().flat_map(|x| [5.0 * x.x, 0.0, 0.0]).collect();
        let centred: Vec<f64> =
            grown.iter().enumerate().map(|(i, u)| if i % 3 == 0 { u - 2.5 } else { *u }).collect();
        assert_eq!(leap(&body, &shifted(0.0), &centred), None);
    }
}
