//! Other programs find the same as `fab verify`: trimesh and manifold3d of the
//! repository's `.venv`, and admesh. Each is skipped, and says so, if it is missing.

#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod fixture;

use std::path::Path;
use std::process::Command;

use fab::report::Report;
use fixture::{CHAMBER, Scene, TWO_TOPS, stderr};

/// Prints whether trimesh finds a surface watertight and consistently wound, its
/// volume, and status and volume of the same surface in manifold3d.
const PYTHON: &str = "
import sys, numpy as np, trimesh, manifold3d
for path in sys.argv[1:]:
    m = trimesh.load(path)
    s = manifold3d.Manifold(manifold3d.Mesh64(
        np.asarray(m.vertices, np.float64), np.asarray(m.faces, np.uint64)))
    print(m.is_watertight and m.is_winding_consistent, m.volume, s.status().name, s.volume())
";

/// What admesh would repair, by the names of its report.
const REPAIRS: [&str; 7] = [
    "Degenerate facets",
    "Edges fixed",
    "Facets removed",
    "Facets added",
    "Facets reversed",
    "Backwards edges",
    "Total disconnected facets",
];

fn molds() -> Vec<Scene> {
    let scenes = [("", &CHAMBER), ("[parting]\nkind = \"plane\"", &CHAMBER), ("", &TWO_TOPS)];
    scenes
        .map(|(config, body)| {
            let scene = Scene::new(body, config);
            let output = scene.mold();
            assert!(output.status.success(), "{}", stderr(&output));
            scene
        })
        .into()
}

fn files(scene: &Scene) -> (Vec<std::path::PathBuf>, Vec<f64>) {
    let folder = scene.path("mold");
    let report = Report::read(&folder).unwrap();
    let volumes = report.parts.iter().map(|p| p.volume).chain([report.cast.volume]).collect();
    (report.files().map(|file| folder.join(file)).collect(), volumes)
}

#[test]
fn trimesh_and_manifold3d_agree() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin/python");
    let found = Command::new(&python).args(["-c", "import trimesh, manifold3d"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {} has no trimesh and manifold3d; run `make setup`", python.display());
        return;
    }
    for scene in molds() {
        let (files, volumes) = files(&scene);
        let output = Command::new(&python).args(["-c", PYTHON]).args(&files).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(
            said.lines().count(),
            files.len(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        for (line, volume) in said.lines().zip(volumes) {
            let words: Vec<&str> = line.split_whitespace().collect();
            assert_eq!([words[0], words[2]], ["True", "NoError"], "{line}");
            for other in [words[1], words[3]] {
                let other: f64 = other.parse().unwrap();
                assert!((other / volume - 1.0).abs() < 1e-9, "{line}, ours {volume}");
            }
        }
    }
}

#[test]
fn admesh_repairs_nothing() {
    if Command::new("admesh").arg("--version").output().is_err() {
        eprintln!("skipped: admesh is not installed");
        return;
    }
    for file in molds().iter().flat_map(|scene| files(scene).0) {
        let output = Command::new("admesh").arg(&file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        for repair in REPAIRS {
            let line = said.lines().find(|line| line.contains(repair));
            let line = line.unwrap_or_else(|| panic!("no {repair:?} in {said}"));
            let counts = line.split(':').nth(1).unwrap_or_default();
            let last = counts.split_whitespace().last();
            assert_eq!(last, Some("0"), "{}: {line}", file.display());
        }
    }
}

/// Reads 3MF files by the specification, with nothing but Python: the volume of the first
/// object, the unit, and the number of objects in the build.
const THREEMF: &str = "
import sys, zipfile, xml.etree.ElementTree as tree
core = '{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}'
for path in sys.argv[1:]:
    archive = zipfile.ZipFile(path)
    assert archive.testzip() is None
    relations = tree.fromstring(archive.read('_rels/.rels'))
    model = tree.fromstring(archive.read(relations[0].get('Target').lstrip('/')))
    mesh = model.find(f'.//{core}mesh')
    p = [[float(v.get(k)) for k in 'xyz'] for v in mesh.iter(core + 'vertex')]
    six = 0.0
    for t in mesh.iter(core + 'triangle'):
        a, b, c = (p[int(t.get(k))] for k in ('v1', 'v2', 'v3'))
        six += sum(a[i] * (b[i-2] * c[i-1] - b[i-1] * c[i-2]) for i in range(3))
    objects = model.findall(f'.//{core}object')
    print(six / 6, model.get('unit'), len(objects), objects[0].get('name'))
";

#[test]
fn python_reads_the_3mf_files() {
    let Ok(found) = Command::new("python3").arg("--version").output() else {
        eprintln!("skipped: there is no python3");
        return;
    };
    assert!(found.status.success());
    for scene in molds() {
        let folder = scene.path("mold");
        let report = Report::read(&folder).unwrap();
        let mut files: Vec<_> =
            report.parts.iter().map(|p| folder.join(format!("{}.3mf", p.name))).collect();
        files.push(folder.join("assembly.3mf"));
        let output = Command::new("python3").args(["-c", THREEMF]).args(&files).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines.len(), files.len(), "{}", String::from_utf8_lossy(&output.stderr));
        for (line, part) in lines.iter().zip(&report.parts) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let volume: f64 = words[0].parse().unwrap();
            // Decimals, that we round to 32 bits and Python does not.
            assert!((volume / part.volume - 1.0).abs() < 1e-6, "{line}, ours {}", part.volume);
            assert_eq!(words[1..], ["millimeter", "1", part.name.as_str()]);
        }
        // The parts, and the whole that is composed of them.
        let whole = lines.last().unwrap().split_whitespace().nth(2).unwrap();
        assert_eq!(whole, (report.parts.len() + 1).to_string());
    }
}
