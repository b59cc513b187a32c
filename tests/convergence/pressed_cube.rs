//! A cube between two plates with friction, pressed to half its height
//! (figure 2 of the paper): the stress at its free faces is not zero and becomes
//! so with the mesh, while contact exerts no force there on any mesh. Nodes of these
//! faces that are nearer to a plate than the activation do touch it, and are not free.

use mechanics::body::Body;
use mechanics::element::quadrature::{Rule, triangle};
use mechanics::element::{at, tabulate};
use mechanics::material::Kinematics;
use mechanics::math::tensor::{Mat3, cofactor};
use mesh::Vec3;
use run::report::results::grid_with_fields;
use solver::plot::{Axes, Series, Style, draw};
use tests::motion::{Motion, SILICONE, begin};
use tests::workdir::repository;
use tests::{Place, block, plate, tag};

/// Edge of the cube [m].
const EDGE: f64 = 0.02;
/// d̂ [m].
const ACTIVATION: f64 = 1e-4;
const STEPS: usize = 10;

fn cube(cells: usize) -> Body {
    let mesh = block([cells; 3], EDGE / cells as f64, |_| false, |p| p);
    let (low, high) = (1e-6, EDGE - 1e-6);
    let end = |p: Vec3| p.z < low || p.z > high;
    let tags: [(&str, Place); 5] = [
        ("ends", &end),
        ("left", &|p| p.x < low),
        ("right", &|p| p.x > high),
        ("front", &|p| p.y < low),
        ("back", &|p| p.y > high),
    ];
    tag(mesh, &tags)
}

fn pressed(cells: usize) -> Motion {
    let start = 0.99 * ACTIVATION;
    let text = format!(
        "degree = 1\n[[body]]\nname = \"cube\"\nmesh = \"cube.msh\"\n{SILICONE}\
         [[obstacle]]\nname = \"low\"\nsurface = \"low.stl\"\ndisplacement = [0, 0, \"{0:e}*t\"]\n\
         [[obstacle]]\nname = \"high\"\nsurface = \"high.stl\"\ndisplacement = [0, 0, \"-{0:e}*t\"]\n\
         [contact]\nactivation = {ACTIVATION:e}\nstiffness = 1e5\nfriction = 0.2\n\
         friction_speed = 1e-4\n\
         [time]\nmethod = \"quasistatic\"\nend = 1.0\nsteps = {STEPS}\n",
        EDGE / 4.0
    );
    // no edge of the squares meets those of the cube: they would share forces of contact with nodes that are farther away
    let square = |z: f64| plate([-0.09, 0.11], [-0.04, 0.17], z);
    let (low, high) = (square(-start), square(EDGE + start));
    begin(&[("cube", &cube(cells))], &[("low", &low), ("high", &high)], &text)
}

/// ∫ P N dA over the facets of a tag, from the stress in their elements [N].
fn traction(motion: &Motion, name: &str) -> Vec3 {
    let (space, body) = (&motion.problem.space, &motion.scene.body);
    let law = motion.scene.laws[0].material.build();
    let facets = body.facets(name).unwrap();
    let n = space.nodes_per_element();
    let on_facet = triangle(5);
    let mut total = Vec3::zeros();
    for (tet, nodes) in space.tets().iter().zip(space.element_nodes().chunks_exact(n)) {
        let Some(facet) = facets.iter().find(|f| f.iter().all(|v| tet.contains(v))) else {
            continue;
        };
        let [a, b, c] = facet.map(|v| body.mesh.vertices[v]);
        let area = 0.5 * (b - a).cross(&(c - a));
        let place = |point: &Vec<f64>| -> Vec<f64> {
            let share = |v| facet.iter().position(|w| w == v).map_or(0.0, |i| point[i]);
            tet.iter().map(share).collect()
        };
        let rule = Rule {
            weights: on_facet.weights.clone(),
            points: on_facet.points.iter().map(place).collect(),
        };
        let table = tabulate(space.degree(), &rule);
        let [a, b, c, d] = tet.map(|v| body.mesh.vertices[v]);
        let g = Mat3::from_columns(&[b - a, c - a, d - a]);
        let to_rest = cofactor(&g) / g.determinant();
        for (gradients, weight) in table.gradients.iter().zip(&table.weights) {
            let mut grad_u = Mat3::zeros();
            for (&node, gradient) in nodes.iter().zip(gradients) {
                grad_u += at(motion.u(), node) * (to_rest * Vec3::from(*gradient)).transpose();
            }
            total += law.first_piola(&Kinematics::new(&grad_u)) * area * *weight;
        }
    }
    total
}

/// Magnitudes of the forces of contact and friction on the nodes of the four free faces [N]: on those that no plate is
/// near, and on those that are nearer to one than the activation.
fn face_forces(motion: &Motion) -> [Vec<f64>; 2] {
    let rest = &motion.scene.body.mesh.vertices;
    let load = motion.stepper.progress.time();
    let state = motion.stepper.iterate(&motion.problem, rest);
    let grid = grid_with_fields(&motion.problem.energies, &state);
    let half = 0.5 * EDGE + 0.99 * ACTIVATION - 0.25 * EDGE * load;
    let mut found = [Vec::new(), Vec::new()];
    for (node, x) in grid.points.iter().enumerate() {
        if ![x.x, x.y].iter().any(|c| c.min(EDGE - c) < 1e-9) {
            continue;
        }
        let forces = grid.point_fields.iter().filter(|f| f.name.ends_with("_force"));
        let force = forces.map(|f| at(&f.values, node).norm()).fold(0.0, f64::max);
        let gap = half - ((x + at(motion.u(), node)).z - 0.5 * EDGE).abs();
        found[usize::from(gap < ACTIVATION)].push(force);
    }
    found
}

/// Forces on the free faces relative to the force of a plate, at a step.
struct Point {
    /// Shortening of the cube as a part of its height.
    shortening: f64,
    /// Mean of |∫ P N dA| over the four faces.
    stress: f64,
    /// Largest force of contact on a node that no plate is near.
    contact: f64,
}

/// Presses a cube, step by step.
fn press(cells: usize) -> Vec<Point> {
    let clock = std::time::Instant::now();
    let mut cube = pressed(cells);
    let mut curve = Vec::new();
    for step in 1..=STEPS {
        cube.go(1);
        let faces = ["cube.left", "cube.right", "cube.front", "cube.back"];
        let sum: f64 = faces.iter().map(|face| traction(&cube, face).norm()).sum();
        let force = cube.force_by("high", "contact").z.abs();
        let [free, near] = face_forces(&cube);
        let largest = free.iter().copied().fold(0.0, f64::max);
        let shortening = 0.5 * step as f64 / STEPS as f64;
        let (stress, contact) = (0.25 * sum / force, largest / force);
        curve.push(Point { shortening, stress, contact });
        assert!(largest == 0.0, "{largest:e} N at a free node in step {step}");
        // the rows at the plates are not free, and the next ones may have been folded onto them
        let rows = 4 * cells * (cells - 3);
        assert!(free.len() >= rows, "{} free nodes of {rows}", free.len());
        // the same forces are seen where a plate is near: the rims of both ends, 4 cells nodes each
        let (near, least) = (near.len(), near.iter().copied().fold(f64::INFINITY, f64::min));
        assert!(shortening <= 0.1 || near >= 8 * cells && least > 0.0, "{near} nodes, {least:e} N");
    }
    let last = curve.last().unwrap();
    eprintln!(
        "cube of {} tetrahedra at {} %: |∫ P N dA| on a free face {:.4} of the {:.3} N of a plate, \
         force of contact there {:e}; {} Newton iterations, {:.1} s",
        6 * cells.pow(3),
        100.0 * last.shortening,
        last.stress,
        cube.force_by("high", "contact").z.abs(),
        last.contact,
        cube.stepper.progress.newton_iterations,
        clock.elapsed().as_secs_f64()
    );
    curve
}

/// Where the cube slips at its edges, the error halves with the mesh.
#[test]
fn stress_at_free_faces_halves_with_the_mesh_and_contact_has_none() {
    let [coarse, fine] = [4, 8].map(press);
    // the friction of the first steps is that of plates that hardly touch
    for (c, f) in coarse.iter().zip(&fine).filter(|(c, _)| c.shortening > 0.1) {
        let at = c.shortening;
        assert!(c.stress > 0.01, "at {at}: {}", c.stress);
        assert!(f.stress < 0.5 * c.stress, "at {at}: {} {}", c.stress, f.stress);
    }
}

#[test]
#[ignore = "takes minutes, and draws build/contact-cube.svg"]
fn the_picture_of_it() {
    let cells = [3, 6, 12];
    let (mut series, mut largest) = (Vec::new(), Vec::<Vec<(f64, f64)>>::new());
    for (turn, &n) in cells.iter().enumerate() {
        let label = Some(format!("{} tetrahedra: stress", 6 * n * n * n));
        let curve = press(n);
        let points = curve.iter().map(|p| (100.0 * p.shortening, p.stress)).collect();
        series.push(Series { label, points, style: Style::Dotted(2), turn });
        largest.push(curve.iter().map(|p| (100.0 * p.shortening, p.contact)).collect());
    }
    // the largest over all meshes
    let most = |a: Vec<(f64, f64)>, b: Vec<(f64, f64)>| {
        a.iter().zip(&b).map(|(a, b)| (a.0, a.1.max(b.1))).collect()
    };
    let points = largest.into_iter().reduce(most).unwrap();
    let label = Some("contact, all meshes".to_owned());
    series.push(Series { label, points, style: Style::Line(2), turn: cells.len() });
    let axes = Axes {
        x: "compression [%]".to_owned(),
        y: "force on a free face / force of a plate".to_owned(),
        ..Axes::default()
    };
    draw(&repository().join("build/contact-cube.svg"), &axes, &series).unwrap();
}
