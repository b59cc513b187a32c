//! Checks before the mesher and after it, with a mesher that is told what to answer.
#![allow(clippy::unwrap_used)]

use super::*;
use mesh::solid::Solid;

fn cube(half: f64) -> SurfaceMesh {
    Solid::cube(&Vec3::repeat(-half), &Vec3::repeat(half)).to_surface()
}

#[test]
fn a_cavity_is_turned_but_an_inward_body_only_on_demand() {
    let mut nested = cube(2.0);
    nested.append(&cube(1.0));
    prepare(&mut nested, false).unwrap();
    assert!((enclosed_volume(&nested) - 56.0).abs() < 1e-12);

    let mut inward = cube(1.0);
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let message = prepare(&mut inward.clone(), false).unwrap_err().to_string();
    assert!(message.contains("--orient"), "{message}");
    prepare(&mut inward, true).unwrap();
    assert!((enclosed_volume(&inward) - 8.0).abs() < 1e-12);
}

/// A mesher that answers with a cube of 20 mm, spoiled in its first tries.
struct Stub<'a> {
    spoiled: usize,
    spoil: fn(&mut TetMesh),
    asked: std::sync::Mutex<Vec<(f64, u32)>>,
    body: &'a TetMesh,
}

impl TetMesher for Stub<'_> {
    fn name(&self) -> &'static str {
        "stub"
    }
    fn packages(&self) -> &'static [&'static str] {
        &["stub"]
    }
    fn script(&self) -> &'static str {
        ""
    }
    fn mesh(
        &self,
        _: &Package,
        _: &SurfaceMesh,
        _: &Layers,
        options: &Options,
        _: Duration,
    ) -> Result<TetMesh> {
        let mut asked = self.asked.lock().unwrap();
        asked.push((options.envelope, options.seed));
        let mut mesh = self.body.clone();
        if asked.len() <= self.spoiled {
            (self.spoil)(&mut mesh);
        }
        Ok(mesh)
    }
}

/// What comes of it, and the envelopes [m] and seeds that were asked for.
fn made(spoiled: usize, spoil: fn(&mut TetMesh)) -> (Result<Outcome>, Vec<(f64, u32)>) {
    let corner = |i: usize| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
    let body = TetMesh {
        vertices: (0..8).map(|i| corner(i) * 0.02).collect(),
        tets: vec![[0, 1, 2, 4], [1, 3, 2, 7], [1, 4, 7, 5], [2, 7, 4, 6], [1, 2, 4, 7]],
    };
    let mut surface = body.clone();
    make_positive(&mut surface);
    let surface = boundary(&surface).surface(&surface).0;
    let stub = Stub { spoiled, spoil, asked: Vec::new().into(), body: &body };
    let settings = crate::tetmesh::config::Tetmesh { envelope: Some(1e-4), ..Default::default() };
    let python = || Python { path: "none".into() };
    let request = Request {
        python: python(),
        meshers: Vec::new(),
        options: settings.options(0.03).unwrap(),
        improve_passes: 0,
        layers: Layers::default(),
        cache: None,
        timeout: Duration::ZERO,
    };
    let package = Package { python: &python(), name: "stub", version: "1".into() };
    let outcome = make(&stub, &package, &surface, &request, "stub").map(|(_, outcome)| outcome);
    (outcome, stub.asked.into_inner().unwrap())
}

#[test]
fn a_mesh_that_leaves_its_envelope_is_made_again_with_a_smaller_one() {
    let (outcome, asked) = made(2, |mesh| mesh.vertices[7].x += 1.4e-4);
    let outcome = outcome.unwrap();
    assert_eq!(asked.len(), 3);
    let expected = [1.0, FINER, FINER * FINER].map(|share| 1e-4 * share);
    for ((envelope, seed), (wanted, number)) in asked.into_iter().zip(expected.into_iter().zip(1..))
    {
        assert!((envelope / wanted - 1.0).abs() < 1e-12 && seed == number, "{envelope} {seed}");
    }
    assert_eq!(outcome.refused.len(), 2);
    let place = "at (20.140, 20.000, 20.000) mm: 1.40 of the envelope of 0.1000 mm";
    assert!(outcome.refused[0].contains(place), "{:?}", outcome.refused);

    let (outcome, asked) = made(3, |mesh| mesh.vertices[7].x += 1.4e-4);
    let message = format!("{:#}", outcome.err().unwrap());
    assert_eq!(asked.len(), 3);
    assert!(message.contains("no usable mesh in 3 tries: the boundary"), "{message}");
    assert!(message.contains(place), "{message}");
}

#[test]
fn vertices_side_by_side_are_no_mesh() {
    // a layer on a side, with a vertex next to a corner
    let (outcome, _) = made(1, |mesh| {
        mesh.vertices.push(Vec3::new(0.02, 0.02, -1e-8));
        mesh.tets.extend([[0, 1, 2, 8], [1, 3, 2, 8]]);
    });
    let refused = outcome.unwrap().refused;
    assert!(refused[0].contains("vertices are at the place of another"), "{refused:?}");
}
