//! Other programs find the same as `fab verify`. Each is skipped, and says so, if it is missing.

#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod fixture;
#[path = "../../tests/support/skip.rs"]
#[allow(clippy::expect_used)]
mod skip;
#[path = "../../tests/support/judges.rs"]
#[allow(dead_code, clippy::expect_used)]
mod judges;

use std::sync::OnceLock;

use fab::files::report::MoldReport;
use fab::geometry::overhang::needs_supports;
use fixture::{CHAMBER, Cubes, Scene, TWO_TOPS, stderr};
use judges::{Lengths, Solid};

/// A mold of a body for a printer.
fn molded(body: &Cubes, parting: &str) -> Scene {
    let scene = Scene::new(body, &format!("{parting}\n[casting]\nprinter = \"prusa-mk4\""));
    let output = scene.mold();
    assert!(output.status.success(), "{}", stderr(&output));
    scene
}

const PLANE: &str = "[parting]\nkind = \"plane\"";
const FIELD: &str = "[parting]\nkind = \"height-field\"\npull = [0, 0, 1]";

fn molds() -> &'static [Scene; 3] {
    static MOLDS: OnceLock<[Scene; 3]> = OnceLock::new();
    MOLDS.get_or_init(|| {
        [molded(&CHAMBER, FIELD), molded(&CHAMBER, PLANE), molded(&TWO_TOPS, FIELD)]
    })
}

/// The printed parts of a mold.
fn parts(scene: &Scene) -> Vec<Solid> {
    let folder = scene.path("mold");
    let report = MoldReport::read(&folder).unwrap();
    let solid = |p: fab::files::report::Part| Solid {
        file: folder.join(p.file),
        name: p.name,
        volume: p.volume,
    };
    report.parts.into_iter().map(solid).collect()
}

/// The parts and what is cast.
fn solids(scene: &Scene) -> Vec<Solid> {
    let folder = scene.path("mold");
    let cast = MoldReport::read(&folder).unwrap().cast;
    let mut solids = parts(scene);
    let file = folder.join(cast.file);
    solids.push(Solid { file, name: "cast".into(), volume: cast.volume });
    solids
}

#[test]
fn trimesh_and_manifold3d_agree() {
    let Some(python) = judges::python(judges::PACKAGES) else { return };
    for scene in molds() {
        judges::trimesh_and_manifold3d_agree(&python, &solids(scene));
        let places: Vec<_> = MoldReport::read(&scene.path("mold")).unwrap().parts;
        let places: Vec<_> = places.iter().map(|part| part.to_mold).collect();
        judges::trimesh_reads_3mf(&python, &parts(scene), &places);
    }
}

#[test]
fn admesh_repairs_nothing() {
    if judges::installed("admesh") {
        molds().iter().for_each(|scene| judges::admesh_repairs_nothing(&solids(scene)));
    }
}

/// Where we see no need for supports the slicer sees none, either.
#[test]
fn prusa_slicer_needs_supports_where_told() {
    if !judges::installed("prusa-slicer") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = &molds()[1];
    let report = MoldReport::read(&scene.path("mold")).unwrap();
    // One shell is as the other.
    for part in report.parts.iter().filter(|part| part.name != "right") {
        let file = scene.path("mold").join(&part.file);
        let needs = needs_supports(part.overhang);
        for options in [&[][..], &["--support-material"]] {
            let Lengths { part: printed, support } =
                judges::slice(&file, &file.with_extension("ini"), options, folder.path());
            eprintln!(
                "{}: {:.1} mm2 hang over, {printed:.0} and {support:.0} mm of filament",
                part.name, part.overhang
            );
            assert!(printed > 0.0 && (support > 0.0) == needs, "{}", part.name);
        }
    }
    let needy = report.parts.iter().filter(|part| needs_supports(part.overhang));
    assert_eq!(needy.map(|part| part.name.as_str()).collect::<Vec<_>>(), ["left", "right", "core"]);
}
