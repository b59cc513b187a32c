//! Every check of `fab verify` fails when the files are damaged in its way.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::fixture::damaged::{
    BOX, after, change, change_solid, cube, feature, moved, sound, turned, write_copies,
};
use crate::fixture::{
    CELL, CHAMBER, CLOSED, Cubes, Scene, TWO_TOPS, assert_fails, assert_status, change_report,
    copy, stderr,
};
use fab::files::report::MoldReport;
use fab::verify::{Against, Line, Status, verify};
use mesh::Vec3;
use mesh::solid::Solid;

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

#[test]
fn files() {
    let lines = after(|mold| {
        std::fs::copy(mold.join("core.stl"), mold.join("stray.stl")).unwrap();
    });
    assert_fails(&lines, "files");
    let lines = after(|mold| std::fs::remove_file(mold.join("upper.stl")).unwrap());
    assert_fails(&lines, "upper.stl: readable");
    let lines = after(|mold| {
        let path = mold.join("upper.stl");
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 7]).unwrap();
    });
    assert_fails(&lines, "upper.stl: readable");
    let lines = after(|mold| {
        let path = mold.join("upper.stl");
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        std::fs::write(&path, &bytes).unwrap();
    });
    assert_fails(&lines, "upper.stl: readable");
}

#[test]
fn surfaces() {
    let lines = after(|mold| {
        change(mold, "core", |mut s| {
            s.triangles.pop();
            s
        });
    });
    assert_fails(&lines, "core: closed");
    let lines = after(|mold| {
        change(mold, "core", |mut s| {
            s.triangles[0].swap(0, 1);
            s
        });
    });
    assert_fails(&lines, "core: oriented");
    // A triangle with a third vertex in the middle of its longest edge.
    let lines = after(|mold| {
        change(mold, "core", |mut s| {
            // Whole coordinates, so that the middle is exact.
            let whole = |&v: &usize| s.vertices[v].iter().all(|x| x.fract() == 0.0);
            let [a, b, _] = *s.triangles.iter().find(|t| t.iter().all(whole)).unwrap();
            s.vertices.push((s.vertices[a] + s.vertices[b]) / 2.0);
            s.triangles.push([a, b, s.vertices.len() - 1]);
            s
        });
    });
    assert_fails(&lines, "core: degenerate");
    assert_fails(&lines, "core: manifold");
    let lines = after(|mold| {
        change(mold, "core", |mut s| {
            let highest =
                (0..s.vertices.len()).max_by(|&a, &b| s.vertices[a].z.total_cmp(&s.vertices[b].z));
            s.vertices[highest.unwrap()].z -= 30.0;
            s
        });
    });
    assert_fails(&lines, "core: intersecting");
    let lines = after(|mold| {
        let crumb = cube([30.0; 3], [30.1; 3]);
        change_solid(mold, "core", |core| core.union(&crumb));
    });
    assert_fails(&lines, "core: pieces");
    // Of a part a warning: a hole that matters is found as a leak.
    let lines = after(|mold| change_report(mold, |report| report.parts[2].genus = 1));
    assert_status(&lines, "core: genus", Status::Warn);
    let lines = after(|mold| {
        let hole = cube([-15.5, -15.5, -20.0], [-14.5, -14.5, 20.0]);
        change_solid(mold, "lower", |lower| lower.difference(&hole));
        change_report(mold, |report| report.parts[1].genus -= 1);
    });
    assert_status(&lines, "lower: genus", Status::Warn);
    assert_fails(&lines, "leaks: empty elsewhere");
    let lines = after(|mold| change_report(mold, |report| report.cast.genus += 1));
    assert_fails(&lines, "cast: genus");
    let lines = after(|mold| change_report(mold, |report| report.parts[2].volume *= 1.0 + 1e-9));
    assert_fails(&lines, "core: volume");
    assert_fails(&lines, "remaining checks");
}

#[test]
fn fit() {
    let lines = after(|mold| change(mold, "core", |s| moved(s, Vec3::new(0.1, 0.0, 0.0))));
    assert_fails(&lines, "overlap: core and cast");
    assert_fails(&lines, "surface: mold to design");
    assert_fails(&lines, "surface: design to mold");
    let lines = after(|mold| change(mold, "upper", |s| moved(s, Vec3::new(0.0, 0.0, -1.0))));
    assert_fails(&lines, "outside: size");
    // A hole in the lower shell, far from the body.
    let hole = cube([-16.0, -16.0, -6.0], [-14.0, -14.0, -4.0]);
    let lines = after(|mold| {
        let open = hole.union(&cube([-15.5, -15.5, -20.0], [-14.5, -14.5, -5.0]));
        change_solid(mold, "lower", |lower| lower.difference(&open));
    });
    assert_fails(&lines, "leaks: empty elsewhere");
    assert_fails(&lines, "balance: outside-parts-voids-cast");
    assert_fails(&lines, "cavity: other bodies");
    // A pit in the wall of the cavity.
    let lines = after(|mold| {
        let pit = cube([-1.0, -15.0, 2.0], [1.0, -13.0, 4.0]);
        change_solid(mold, "lower", |lower| lower.difference(&pit));
    });
    assert_fails(&lines, "surface: mold to design");
    assert_fails(&lines, "volume: mold and design");
}

#[test]
fn copies() {
    let lines = after(|mold| {
        std::fs::copy(mold.join("upper.3mf"), mold.join("core.3mf")).unwrap();
    });
    assert_fails(&lines, "core.3mf");
    let lines = after(|mold| change_unit(&mold.join("core.3mf")));
    assert_fails(&lines, "core.3mf");
    assert_status(&lines, "upper.3mf", Status::Ok);
    let lines = after(|mold| std::fs::remove_file(mold.join("assembly.3mf")).unwrap());
    assert_fails(&lines, "assembly.3mf");
    // All parts where they are printed, not where they belong.
    let lines = after(|mold| {
        let (path, turned) = (mold.join("assembly.3mf"), mold.join("turned.3mf"));
        let mut shapes = mesh::io::threemf::read(&path).unwrap().shapes;
        shapes[0].place.turn = nalgebra::Matrix3::identity();
        // a program does not write over what it has read
        mesh::io::threemf::write(&turned, "fab", "closed mold", &shapes).unwrap();
        std::fs::rename(turned, path).unwrap();
    });
    assert_fails(&lines, "assembly.3mf");
    let lines = after(|mold| change_report(mold, |report| report.casting.waste = 0.0));
    assert_fails(&lines, "cast.json");
    let lines = after(|mold| std::fs::write(mold.join("cast.json"), "{}").unwrap());
    assert_fails(&lines, "cast.json");
}

/// Says of a 3MF file that its numbers are inches.
fn change_unit(path: &Path) {
    let mut old = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let texts: Vec<(String, String)> = (0..old.len())
        .map(|i| {
            let mut entry = old.by_index(i).unwrap();
            let mut text = String::new();
            std::io::Read::read_to_string(&mut entry, &mut text).unwrap();
            (entry.name().unwrap().into_owned(), text)
        })
        .collect();
    let mut new = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, text) in texts {
        let text = text.replace("unit=\"millimeter\"", "unit=\"inch\"");
        new.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut new, text.as_bytes()).unwrap();
    }
    new.finish().unwrap();
}

/// What the settings for the slicer and the sheet rely on.
#[test]
fn slicing() {
    let lines = after(|mold| change_report(mold, |report| report.parts[2].overhang = 0.0));
    assert_fails(&lines, "core.ini");
    let lines = after(|mold| {
        change_report(mold, |report| report.parts[2].overhang = 0.0);
        write_copies(mold);
    });
    assert_status(&lines, "core.ini", Status::Ok);
    assert_fails(&lines, "core: overhang");
    let lines = after(|mold| {
        let path = mold.join("core.ini");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("support_material = 1", "support_material = 0"))
            .unwrap();
    });
    assert_fails(&lines, "core.ini");
    assert_status(&lines, "upper.ini", Status::Ok);
    let lines = after(|mold| std::fs::remove_file(mold.join("core.ini")).unwrap());
    assert_fails(&lines, "core.ini");
}

#[test]
fn design() {
    let lines = after(|mold| std::fs::remove_file(mold.join("../design.msh")).unwrap());
    assert_fails(&lines, "design: readable");
    let lines = after(|mold| {
        let path = mold.join("../design.msh");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text + "\n").unwrap();
    });
    assert_fails(&lines, "design: unchanged");
}

#[test]
fn channels() {
    let lines = after(|mold| {
        // The file of the upper shell is turned upside down about x.
        let [x, y, z] = feature(mold, "sprue").base;
        let plug = cube([x - 7.0, -y - 7.0, -z - 4.0], [x + 7.0, -y + 7.0, -z - 3.0]);
        change_solid(mold, "upper", |upper| upper.union(&plug));
    });
    assert_fails(&lines, "sprue 1: blocked");
    assert_fails(&lines, "sprue 1: reaches the cavity");
    assert_fails(&lines, "filling: not reached");
    let lines = after(|mold| {
        change_report(mold, |report| report.features.retain(|f| f.purpose.name() != "sprue"))
    });
    assert_fails(&lines, "sprue");
    // Moved out of the mold, the sprue begins below the top of the body.
    let lines = after(|mold| {
        change_report(mold, |report| {
            let sprue = report.features.iter_mut().find(|f| f.purpose.name() == "sprue");
            sprue.unwrap().base[0] += 40.0;
        });
    });
    assert_fails(&lines, "sprue 1: rim");
    let lines = after(|mold| {
        let key = feature(mold, "key");
        let foot = Vec3::from(key.base);
        let cut =
            Solid::cube(&(foot - Vec3::new(5.0, 5.0, 0.0)), &(foot + Vec3::new(5.0, 5.0, 5.0)));
        change_solid(mold, "lower", |lower| lower.difference(&cut));
    });
    assert_fails(&lines, "key 1: engaged");
    let lines = after(|mold| {
        let stub = cube([-5.0, -5.0, -9.0], [5.0, 5.0, -1.0]);
        change_solid(mold, "core", |core| core.difference(&stub));
    });
    assert_fails(&lines, "socket 1: stub length");
    assert_fails(&lines, "socket 1: stub fills");
    let lines = after(|mold| change_report(mold, |report| report.wall = 5.1));
    assert_fails(&lines, "wall: least");
    // The walls of the body are one cube of 4 mm.
    let lines = after(|mold| change_report(mold, |report| report.casting.least_wall = 4.1e-3));
    assert_fails(&lines, "silicone: thinnest wall");
    // Its core is thinnest beside the pit of a pin, 1.64 mm.
    let core = |least: f64| {
        after(|mold| change_report(mold, |report| report.casting.least_core = Some(least)))
    };
    assert_fails(&core(1.7e-3), "core: thinnest");
    assert_status(&core(1.5e-3), "core: thinnest", Status::Ok);
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
        write_copies(mold);
    });
    assert_fails(&lines, "lower: comes off");
    assert_fails(&lines, "lower: path");
    assert_status(&lines, "lower: undercut", Status::Warn);
}

/// What `fab mold` says of a mold that fails a check before it is written.
fn refused(scene: &Scene, check: &str) -> String {
    let output = scene.mold();
    let said = crate::fixture::stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains(check), "{said}");
    assert!(!scene.path("mold/mold.json").exists());
    said
}

/// A tower of 4 mm beside the sprue's, which no vent reaches.
#[test]
fn trapped_air() {
    let config = format!("{BOX}\n[sprue]\nat = [0.01, 0.014, 0]\n[vents]\npersistence = 0.1");
    let scene = Scene::new(&TWO_TOPS, &config);
    let said = refused(&scene, "filling: trapped air");
    assert!(!said.contains("filling: not reached"), "{said}");
}

#[test]
fn printing() {
    let lines = after(|_| ());
    assert_status(&lines, "upper: build volume", Status::Ok);
    // The core's underside hangs over its stub: 12 x 12 mm and more, less the stub.
    assert_status(&lines, "core: overhang", Status::Warn);
    let large = Cubes { count: [48, 7, 6], ..CHAMBER };
    let scene = Scene::new(&large, BOX);
    refused(&scene, "upper: build volume");
}

#[test]
fn inflated_walls() {
    let lines_of = |folder: &tempfile::TempDir| {
        let against = Against { simulation: Some(folder.path()), ..Against::default() };
        verify(&sound().path("mold"), against).unwrap()
    };
    let lines = lines_of(&sound().simulation(0.5, true, 2.0));
    assert_status(&lines, "inflated: body", Status::Ok);
    assert_status(&lines, "inflated: thinnest wall", Status::Ok);
    assert_status(&lines, "inflated: largest stretch", Status::Ok);
    assert_status(&lines, "inflated: elements", Status::Ok);
    let inside_out = lines_of(&sound().simulation(-0.5, true, 2.0));
    assert_status(&inside_out, "inflated: elements", Status::Warn);
    // Dragon Skin 20 breaks at 620 %.
    assert_fails(&lines_of(&sound().simulation(0.5, true, 7.3)), "inflated: largest stretch");
    // 4 mm become 0.2 mm.
    assert_fails(&lines_of(&sound().simulation(0.05, true, 2.0)), "inflated: thinnest wall");
    assert_fails(&lines_of(&sound().simulation(0.5, false, 2.0)), "inflated: result");
    assert_fails(&lines_of(&tempfile::tempdir().unwrap()), "inflated: result");
}

/// What holds the core beside its stub: a pin that is cut off, one that does not reach down, and a core with a
/// pit that is too wide.
#[test]
fn pins() {
    assert_status(&after(|_| ()), "core: stays", Status::Ok);
    let cut = |from: f64, to: f64| {
        after(move |mold| {
            let pin = feature(mold, "pin");
            let (base, out) = (Vec3::from(pin.base), Vec3::from(pin.axis).normalize());
            // The file of the upper shell is turned upside down about x.
            let (shell, turn) = match out.z > 0.0 {
                true => ("upper", Vec3::new(1.0, -1.0, -1.0)),
                false => ("lower", Vec3::repeat(1.0)),
            };
            let [low, high] = [from, to].map(|h| (base + out * h).component_mul(&turn));
            let gap = Solid::cylinder(&low, &(high - low), 1.5, 1.5, 48);
            change_solid(mold, shell, |shell| {
                let rest = shell.difference(&gap).decompose();
                rest.into_iter().max_by(|a, b| a.volume().total_cmp(&b.volume())).unwrap()
            });
        })
    };
    // Through the silicone: nothing is left in the pit.
    let lines = cut(1.1, 2.0);
    for name in ["pin 1: touches the core", "pin 1: stands in its pit", "core: stays"] {
        assert_fails(&lines, name);
    }
    let lines = cut(-0.1, 0.2);
    assert_fails(&lines, "pin 1: touches the core");
    assert_fails(&lines, "core: stays");
    let lines = after(|mold| {
        let pin = feature(mold, "pin");
        let (base, axis) = (Vec3::from(pin.base), Vec3::from(pin.axis));
        let pit = Solid::cylinder(&base, &axis, 1.8, 1.8, 48);
        change_solid(mold, "core", |core| core.difference(&pit));
    });
    assert_fails(&lines, "pin 1: stands in its pit");
    let lines = after(|mold| {
        change_report(mold, |report| {
            report.features.retain(|f| f.purpose.name() != "pin");
            report.holds[0].lengths.clear();
        });
        write_copies(mold);
    });
    assert_fails(&lines, "core: stays");
    let lines = after(|mold| {
        change_report(mold, |report| report.features.retain(|f| f.purpose.name() != "pin"));
        write_copies(mold);
    });
    assert_fails(&lines, "pins");
    let lines = after(|mold| {
        change_report(mold, |report| {
            let pin = report.features.iter().find(|f| f.purpose.name() == "pin").unwrap().base;
            let sprue = report.features.iter_mut().find(|f| f.purpose.name() == "sprue").unwrap();
            sprue.base = pin;
        });
    });
    assert_fails(&lines, "pin 1: beside channels");
}

/// What a scale should show.
#[test]
fn weight() {
    assert_status(&after(|_| ()), "cast: mass", Status::Ok);
    let change = |f: fn(&mut fab::body::weight::Weight)| {
        let lines = after(|mold| {
            change_report(mold, |report| f(report.cast.weight.as_mut().unwrap()));
            write_copies(mold);
        });
        assert_fails(&lines, "cast: mass");
    };
    change(|weight| weight.mass *= 1.01);
    change(|weight| weight.per_tenth *= 1.1);
    let lines = after(|mold| {
        change_report(mold, |report| report.casting.silicone = None);
        write_copies(mold);
    });
    assert_fails(&lines, "cast: mass");
}

/// A core that is wider than its inlet, by less and by more than the silicone stretches.
#[test]
fn cores_leave() {
    // The chamber of 12 x 12 mm over an inlet of 4 x 4 mm: 48 mm around to 16 mm.
    assert_status(&after(|_| ()), "core: demolds", Status::Ok);
    let scene = Scene::new(&CHAMBER, &BOX.replace("dragon-skin-20", "dragon-skin-30"));
    refused(&scene, "core: demolds");
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
    let output = scene.mold();
    assert!(output.status.success(), "{}", stderr(&output));
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
        write_copies(copied.path());
        verify(copied.path(), Against { design: Some(&design), ..Against::default() }).unwrap()
    };
    let sound = after(&|_| ());
    for check in ["in silicone", "silicone below", "laid in"] {
        assert_status(&sound, &format!("paper: {check}"), Status::Ok);
    }
    // too high, beside the body, too near to the floor
    for height in [30.0, 7.9, 0.1] {
        assert_fails(&after(&|report| report.layers[0].height = height), "paper: in silicone");
    }
    let aside = after(&|report| {
        report.layers[0].outlines.iter_mut().flatten().for_each(|p| p[0] += 9.0);
    });
    assert_fails(&aside, "paper: in silicone");
    assert_fails(&after(&|report| report.layers[0].below_ml *= 1.05), "paper: silicone below");
    assert_fails(&after(&|report| report.layers[0].height += 0.5), "paper: silicone below");
    assert_fails(&after(&|report| report.open = false), "paper: laid in");
}
