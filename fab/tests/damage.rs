//! Every check of `fab verify` fails when the files are damaged in its way.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::fixture::damaged::{
    BOX, after, change, change_solid, cube, feature, moved, sound, turned,
};
use crate::fixture::{
    CELL, CHAMBER, CLOSED, Cubes, Scene, TWO_TOPS, assert_fails, assert_status, change_report, copy,
};
use fab::files::report::MoldReport;
use fab::mold::Purpose;
use fab::verify::{Against, Line, Status, verify};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

#[test]
fn an_undamaged_copy_passes() {
    let lines = after(|_| ());
    // Supports are needed below the ceilings of any mold.
    // There is no CAD of cubes.
    let known = |name: &str| name.ends_with(": overhang") || name == "surface: mold to CAD";
    let fine = |line: &&Line| line.status == Status::Ok || known(&line.name);
    let bad: Vec<&Line> = lines.iter().filter(|line| !fine(line)).collect();
    assert!(bad.is_empty(), "{bad:#?}");
}

/// A copy of the sound mold fails these checks after `damage`.
fn assert_found(checks: &[&str], damage: impl FnOnce(&Path)) {
    let lines = after(damage);
    checks.iter().for_each(|check| assert_fails(&lines, check));
}

#[test]
fn files() {
    assert_found(&["files"], |mold| {
        std::fs::copy(mold.join("core.stl"), mold.join("stray.stl")).unwrap();
    });
    assert_found(&["upper.stl: readable"], |mold| {
        std::fs::remove_file(mold.join("upper.stl")).unwrap();
    });
    let design = |mold: &Path| mold.join("../design.msh");
    assert_found(&["design: readable"], |mold| std::fs::remove_file(design(mold)).unwrap());
    assert_found(&["design: unchanged"], |mold| {
        let text = std::fs::read_to_string(design(mold)).unwrap();
        std::fs::write(design(mold), text + "\n").unwrap();
    });
}

#[test]
fn surfaces() {
    let core = |checks: &[&str], damage: fn(&mut SurfaceMesh)| {
        assert_found(checks, |mold| {
            change(mold, "core", |mut surface| {
                damage(&mut surface);
                surface
            });
        });
    };
    core(&["core: closed"], |s| {
        s.triangles.pop();
    });
    core(&["core: oriented"], |s| s.triangles[0].swap(0, 1));
    // A triangle with a third vertex in the middle of its longest edge.
    core(&["core: degenerate", "core: manifold"], |s| {
        // Whole coordinates, so that the middle is exact.
        let whole = |&v: &usize| s.vertices[v].iter().all(|x| x.fract() == 0.0);
        let [a, b, _] = *s.triangles.iter().find(|t| t.iter().all(whole)).unwrap();
        s.vertices.push((s.vertices[a] + s.vertices[b]) / 2.0);
        s.triangles.push([a, b, s.vertices.len() - 1]);
    });
    core(&["core: intersecting"], |s| {
        let highest =
            (0..s.vertices.len()).max_by(|&a, &b| s.vertices[a].z.total_cmp(&s.vertices[b].z));
        s.vertices[highest.unwrap()].z -= 30.0;
    });
    assert_found(&["core: pieces"], |mold| {
        change_solid(mold, "core", |core| core.union(&cube([30.0; 3], [30.1; 3])));
    });
    // Of a part a warning: a hole that matters is found as a leak.
    let lines = after(|mold| {
        let hole = cube([-15.5, -15.5, -20.0], [-14.5, -14.5, 20.0]);
        change_solid(mold, "lower", |lower| lower.difference(&hole));
        change_report(mold, |report| report.parts[1].genus -= 1);
    });
    assert_status(&lines, "lower: genus", Status::Warn);
    assert_fails(&lines, "leaks: empty elsewhere");
    for (check, change) in [
        ("cast: genus", (|report| report.cast.genus += 1) as fn(&mut MoldReport)),
        ("core: volume", |report| report.parts[2].volume *= 1.0 + 1e-9),
    ] {
        assert_found(&[check, "remaining checks"], |mold| change_report(mold, change));
    }
}

#[test]
fn fit() {
    let checks = ["overlap: core and cast", "surface: mold to design", "surface: design to mold"];
    assert_found(&checks, |mold| change(mold, "core", |s| moved(s, Vec3::new(0.1, 0.0, 0.0))));
    assert_found(&["outside: size"], |mold| {
        change(mold, "upper", |s| moved(s, Vec3::new(0.0, 0.0, -1.0)));
    });
    // A hole in the lower shell, far from the body.
    let checks =
        ["leaks: empty elsewhere", "balance: outside-parts-voids-cast", "cavity: other bodies"];
    assert_found(&checks, |mold| {
        let hole = cube([-16.0, -16.0, -6.0], [-14.0, -14.0, -4.0]);
        let open = hole.union(&cube([-15.5, -15.5, -20.0], [-14.5, -14.5, -5.0]));
        change_solid(mold, "lower", |lower| lower.difference(&open));
    });
    // A pit in the wall of the cavity.
    assert_found(&["surface: mold to design", "volume: mold and design"], |mold| {
        let pit = cube([-1.0, -15.0, 2.0], [1.0, -13.0, 4.0]);
        change_solid(mold, "lower", |lower| lower.difference(&pit));
    });
}

#[test]
fn channels() {
    let checks = ["sprue 1: blocked", "sprue 1: reaches the cavity", "filling: not reached"];
    assert_found(&checks, |mold| {
        // The file of the upper shell is turned upside down about x.
        let [x, y, z] = feature(mold, Purpose::Sprue).base;
        let plug = cube([x - 7.0, -y - 7.0, -z - 4.0], [x + 7.0, -y + 7.0, -z - 3.0]);
        change_solid(mold, "upper", |upper| upper.union(&plug));
    });
    assert_found(&["key 1: engaged"], |mold| {
        let foot = Vec3::from(feature(mold, Purpose::Key).base);
        let cut =
            Solid::cube(&(foot - Vec3::new(5.0, 5.0, 0.0)), &(foot + Vec3::new(5.0, 5.0, 5.0)));
        change_solid(mold, "lower", |lower| lower.difference(&cut));
    });
    assert_found(&["socket 1: stub length", "socket 1: stub fills"], |mold| {
        let stub = cube([-5.0, -5.0, -9.0], [5.0, 5.0, -1.0]);
        change_solid(mold, "core", |core| core.difference(&stub));
    });
    for (check, change) in [
        (
            "sprue",
            (|report| report.features.retain(|f| f.purpose != Purpose::Sprue))
                as fn(&mut MoldReport),
        ),
        // Moved out of the mold, the sprue begins below the top of the body.
        ("sprue 1: rim", |report| {
            let sprue = report.features.iter_mut().find(|f| f.purpose == Purpose::Sprue);
            sprue.unwrap().base[0] += 40.0;
        }),
        ("wall: least", |report| report.wall = 5.1),
        // The walls of the body are one cube of 4 mm.
        ("silicone: thinnest wall", |report| report.casting.least_wall = 4.1e-3),
        // Its core is thinnest beside the pit of a pin, 1.64 mm.
        ("core: thinnest", |report| report.casting.least_core = Some(1.7e-3)),
        ("core: overhang", |report| report.parts[2].overhang = 0.0),
    ] {
        assert_found(&[check], |mold| change_report(mold, change));
    }
    let thick = |report: &mut MoldReport| report.casting.least_core = Some(1.5e-3);
    let lines = after(|mold| change_report(mold, thick));
    assert_status(&lines, "core: thinnest", Status::Ok);
}

#[test]
fn demolding() {
    // The lower shell taken away upward meets the upper one and the silicone.
    let lines = after(|mold| {
        change(mold, "lower", turned);
        change_report(mold, |report| {
            report.parts[1].demolding = report.parts[0].demolding;
            report.parts[1].to_mold = report.parts[0].to_mold;
        });
    });
    assert_fails(&lines, "lower: comes off");
    assert_fails(&lines, "lower: path");
    assert_status(&lines, "lower: undercut", Status::Warn);
}

/// A tower of 4 mm beside the sprue's, which no vent reaches; a mold that is too long for its printer; a core that is wider
/// than its inlet by more than the silicone stretches.
#[test]
fn molds_that_fail_a_check_are_not_written() {
    assert_status(&after(|_| ()), "upper: build volume", Status::Ok);
    // The core's underside hangs over its stub: 12 x 12 mm and more, less the stub.
    assert_status(&after(|_| ()), "core: overhang", Status::Warn);
    // The chamber of 12 x 12 mm over an inlet of 4 x 4 mm: 48 mm around to 16 mm.
    assert_status(&after(|_| ()), "core: demolds", Status::Ok);
    let trapped = format!("{BOX}\n[sprue]\nat = [0.01, 0.014, 0]\n[vents]\npersistence = 0.1");
    let stiff = BOX.replace("dragon-skin-20", "dragon-skin-30");
    for (body, config, check) in [
        (&TWO_TOPS, &trapped[..], "filling: trapped air"),
        (&Cubes { count: [48, 7, 6], ..CHAMBER }, BOX, "upper: build volume"),
        (&CHAMBER, &stiff, "core: demolds"),
    ] {
        let said = Scene::new(body, config).refused(1, &[check]);
        assert!(!said.contains("filling: not reached"), "{said}");
    }
}

#[test]
fn inflated_walls() {
    let lines_of = |folder: &tempfile::TempDir| {
        let against = Against { simulation: Some(folder.path().into()), ..Against::default() };
        verify(&sound().path("mold"), &against).unwrap()
    };
    let sound_lines = lines_of(&sound().simulation(0.5, true, 2.0));
    for check in ["body", "thinnest wall", "largest stretch", "elements"] {
        assert_status(&sound_lines, &format!("inflated: {check}"), Status::Ok);
    }
    for (thin, usable, stretch, check, status) in [
        (-0.5, true, 2.0, "elements", Status::Warn),
        // Dragon Skin 20 breaks at 620 %.
        (0.5, true, 7.3, "largest stretch", Status::Fail),
        // 4 mm become 0.2 mm.
        (0.05, true, 2.0, "thinnest wall", Status::Fail),
        (0.5, false, 2.0, "result", Status::Fail),
    ] {
        let lines = lines_of(&sound().simulation(thin, usable, stretch));
        assert_status(&lines, &format!("inflated: {check}"), status);
    }
    assert_fails(&lines_of(&tempfile::tempdir().unwrap()), "inflated: result");
}

/// 24 × 28 × 24 mm with a chamber, whose flat wall across x is 8 mm thick.
const THICK: Cubes = Cubes { count: [6, 7, 6], ..CLOSED };

/// A sheet of 12 × 8 mm in the middle of that wall, in a body that is cast open above in two parts.
fn layered() -> (Scene, std::path::PathBuf) {
    let config = "method = \"open-top\"\nlayers = [\"paper\"]\nlabels = false\n[casting]\nsilicone = \"dragon-skin-20\"\n\
                  printer = \"prusa-mini\"";
    let scene = Scene::planned(&THICK, config);
    let path = scene.path("design.msh");
    let mut file = mesh::io::read_tets(&path).unwrap();
    file.tags.names.push("paper".into());
    let id = file.tags.id("paper").unwrap();
    let within = |p: Vec3| {
        let [x, y, z] = (p / CELL).into();
        (x - 5.0).abs() < 1e-9 && (1.9..5.1).contains(&y) && (1.9..4.1).contains(&z)
    };
    for tet in &file.mesh.tets {
        for facet in mesh::topology::TET_FACETS.map(|f| f.map(|k| tet[k])) {
            if facet.iter().all(|&v| within(file.mesh.vertices[v])) {
                file.tags.set(facet, id);
            }
        }
    }
    std::fs::remove_file(&path).unwrap();
    mesh::io::write_tets(&path, &file.mesh, &file.tags).unwrap();
    scene.made();
    let folders = std::fs::read_dir(scene.path("mold")).unwrap().flatten().map(|e| e.path());
    let has = |folder: &std::path::PathBuf| {
        MoldReport::read(folder).is_ok_and(|report| !report.layers.is_empty())
    };
    let folder = folders.filter(|f| f.is_dir()).find(has).unwrap();
    (scene, folder)
}

#[test]
fn sheets_that_are_laid_in() {
    let (scene, folder) = layered();
    let design = scene.path("design.msh");
    let after = |damage: &dyn Fn(&mut MoldReport)| {
        let copied = tempfile::tempdir().unwrap();
        copy(&folder, copied.path());
        change_report(copied.path(), damage);
        let against = Against { design: Some(design.clone()), ..Against::default() };
        verify(copied.path(), &against).unwrap()
    };
    let sound = after(&|_| ());
    assert_status(&sound, "paper: in silicone", Status::Ok);
    // too high, beside the body, too near to the floor
    for height in [30.0, 7.9, 0.1] {
        assert_fails(&after(&|report| report.layers[0].height = height), "paper: in silicone");
    }
    let aside = after(&|report| {
        report.layers[0].outlines.iter_mut().flatten().for_each(|p| p[0] += 9.0);
    });
    assert_fails(&aside, "paper: in silicone");
}
