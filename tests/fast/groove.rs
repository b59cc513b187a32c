//! The groove for a thread: its ridge in the shells, and what is left of the casting.

use fab::files::report::MoldReport;
use fab::plan::report::PlanReport;
use fab::verify::{Against, Line, Status, before_writing};
use mesh::io::read_surface;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};
use reports::Segment;
use tests::workdir::Workdir;

use crate::samples;

/// Height that the thread climbs for each radian about the axis [mm].
const CLIMB: f64 = 6.0 / std::f64::consts::TAU;

/// Half the width of the block [mm].
const HALF: f64 = 20.0;

/// Diameter of the thread, and depth of its groove [mm].
const THREAD: f64 = 1.0;

const MOLD: &str = "wound = \"out/report.json\"\n\n[parting]\nkind = \"plane\"\npull = [0, 1, 0]\noffset = 0.02\n\n\
                    [core]\npins = [[0.034, 0.03, 0.02]]\n\n[groove]\nthread = 1e-3\n";

/// The chamber, wound around x by two threads, simulated, and the file of its mold.
pub fn wound() -> Workdir {
    let winding = "\n[[winding]]\nname = \"thread\"\non = \"side\"\npitch = 6e-3\nstart = 4e-3\nend = 22e-3\n\
                   around = { point = [0, 0.02, 0.02], axis = [1, 0, 0] }\ndouble = true\nstiffness = 50\n";
    let dir = samples::wound(winding);
    dir.solver("simulate p1.toml --final-only -o out").assert_good();
    dir.write("mold.toml", MOLD);
    dir
}

/// The surfaces of a mold in the order of its report, as they are in their files [mm].
fn surfaces(dir: &Workdir, report: &MoldReport) -> Vec<SurfaceMesh> {
    report.files().map(|file| read_surface(&dir.path("mold").join(file)).unwrap()).collect()
}

/// The checks of a mold with these surfaces.
fn checked(dir: &Workdir, report: &MoldReport, surfaces: &[SurfaceMesh]) -> Vec<Line> {
    let plan = PlanReport::read(&dir.path("mold")).unwrap();
    let against = Against { design: Some(dir.path("body.msh")), ..Against::default() };
    before_writing(report, surfaces, &against, &plan)
}

/// Ends of the segments of the threads at rest [m].
fn segments(dir: &Workdir) -> Vec<[Vec3; 2]> {
    let segments = Segment::all(&dir.text("out/windings.csv")).unwrap();
    segments.into_iter().map(|one| one.ends.map(|end| Vec3::from(end.rest))).collect()
}

#[test]
fn a_ridge_leaves_room_for_the_thread_and_comes_out() {
    let dir = wound();
    dir.run("fab", "mold body.msh --config mold.toml --no-pictures -o mold").assert_good();
    let report = MoldReport::read(&dir.path("mold")).unwrap();
    let groove = report.groove.as_ref().unwrap();
    // On faces along the pull, threads climb: they may go by half a diameter until they leave the face. Pieces of up to
    // four diameters have a groove as a whole or not at all.
    // At y from the middle of a face it climbs by CLIMB · HALF / (HALF² + y²) for each millimetre.
    let beside = |y: f64| (HALF - y) * CLIMB * HALF / (HALF * HALF + y * y);
    let free = (0..2000).map(|i| f64::from(i) * 0.01).find(|&y| beside(y) < THREAD / 2.0);
    let across = HALF - free.unwrap();
    let part = groove.length / groove.wound;
    let [least, most] = [across - 4.0 * THREAD, across].map(|way| (80.0 + 4.0 * way) / 160.0);
    assert!((least - 0.02..most).contains(&part), "{part}");
    let locked = groove.locked.unwrap();
    // In a facet of 10 mm the thread is straight; a quarter of the depth is added to the way.
    let climb = CLIMB * 0.5_f64.atan() / 10.0;
    let needed = (HALF + THREAD / 4.0) * climb;
    assert!((locked / needed - 1.0).abs() < 0.01 && groove.widened <= 0.5, "{locked} {needed}");
    // The shells within the block, which our own Booleans cut out of their files: what is in the groove.
    let surfaces = surfaces(&dir, &report);
    let placed = |p: Vec3| {
        Vec3::from(report.design_to_mold.map(|r| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]))
    };
    let corners = [Vec3::zeros(), Vec3::new(0.05, 0.04, 0.04)].map(placed);
    let block = Solid::cube(&corners[0].inf(&corners[1]), &corners[0].sup(&corners[1]));
    let cast = &surfaces[report.parts.len()];
    let cast = Solid::from_surface(cast).unwrap();
    let mut ridges = 0.0;
    for (part, surface) in report.parts.iter().zip(&surfaces) {
        if !["left", "right"].contains(&part.name.as_str()) {
            continue;
        }
        let turned = |p: &Vec3| Vec3::from(part.to_mold.map(|row| Vec3::from(row).dot(p)));
        let vertices = surface.vertices.iter().map(turned).collect();
        let closed = SurfaceMesh { vertices, triangles: surface.triangles.clone() };
        let ridge = Solid::from_surface(&closed).unwrap().intersection(&block);
        ridges += ridge.volume();
        for distance in [0.05, 0.2, 1.0, 5.0, 20.0] {
            let moved = ridge.translate(&(Vec3::from(part.demolding) * distance));
            let pressed = moved.intersection(&cast).volume();
            assert!(pressed < 1e-2, "{}: {pressed} mm³ of {}", part.name, ridge.volume());
        }
    }
    // Its section is a trapezoid; both threads share what they cross, and what is widened is added.
    let section = 1.1 + 10_f64.to_radians().tan();
    let straight = groove.length * section;
    assert!((0.8..1.3).contains(&(ridges / straight)), "{ridges} mm³, {straight} mm³");
    // Thread that lies on the bottom of the groove touches no silicone, on faces across the pull.
    let mut laid = 0.0;
    for [a, b] in segments(&dir) {
        let normal = (a + b) / 2.0 - Vec3::new(a.x, 0.02, 0.02);
        // Around the edges of the block a thread is bent.
        let at_edge = [a, b].iter().any(|p| (p.z - 0.02).abs() > 0.016);
        if normal.y.abs() < 0.02 - 1e-6 || at_edge {
            continue;
        }
        let inward = -Vec3::y() * normal.y.signum() * (THREAD / 2.0 * 1e-3);
        let [a, b] = [a + inward, b + inward].map(placed);
        let radius = 0.49 * THREAD;
        let thread = Solid::cylinder(&a, &(b - a), radius, radius, 24);
        let inside = thread.intersection(&cast).volume();
        assert!(inside < 1e-3, "{inside} mm³ at {a:?}");
        laid += (b - a).norm();
    }
    assert!(laid > 100.0, "{laid} mm");
    let sheet = dir.text("mold/cast.html");
    assert!(sheet.contains("A groove of 1.10 mm and 1.00 mm depth guides the thread"), "{sheet}");
    assert!(sheet.contains("The knots go into the pits"), "{sheet}");
    // A casting without the groove does not pass.
    let lines = checked(&dir, &report, &surfaces);
    assert!(lines.iter().all(|line| line.status != Status::Fail), "{lines:#?}");
    let mut plain = surfaces.clone();
    plain[report.parts.len()] = cast.union(&groove.solid().intersection(&block)).to_surface();
    let lines = checked(&dir, &report, &plain);
    for name in
        ["overlap: left and cast", "groove: ridge leaves left", "groove: ridge leaves right"]
    {
        let failed = |line: &&Line| line.status == Status::Fail && line.name == name;
        assert!(lines.iter().any(|line| failed(&line)), "{name}: {lines:#?}");
    }
    // Nor do ridges that turn out to be wider than what they left: as if nothing were widened.
    let mut straight = report.clone();
    let stations = straight.groove.as_mut().unwrap().courses.iter_mut().flatten();
    stations.for_each(|station| station.reach = 0.0);
    let narrow = straight.groove.as_ref().unwrap().solid();
    let mut filled = surfaces.clone();
    let widened = groove.solid().difference(&narrow).intersection(&block);
    filled[report.parts.len()] = cast.union(&widened).to_surface();
    let lines = checked(&dir, &report, &filled);
    let failed = |line: &&Line| line.status == Status::Fail && line.name.contains("ridge leaves");
    assert_eq!(lines.iter().filter(failed).count(), 2, "{lines:#?}");
}
