//! Other programs that judge what `fab mold` writes: trimesh and manifold3d of the
//! repository's `.venv`, admesh and prusa-slicer.
//!
//! The tests of `fab`, which cannot use this crate, include this file and `skip.rs`, so that
//! it uses nothing else but the standard library.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::skip::skip;

/// Largest difference of two volumes as a part of them: they are sums over the same
/// triangles in another order, found equal to 10⁻¹⁴; 10⁻⁵ is wanted.
const VOLUME: f64 = 1e-9;

/// The same, of decimals in 3MF files that Python does not round to 32 bits.
const DECIMALS: f64 = 1e-6;

/// A written surface.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The STL file.
    pub file: PathBuf,
    /// Its name.
    pub name: String,
    /// Its volume as mold.json has it [mm³].
    pub volume: f64,
}

/// For each STL file: whether trimesh finds it watertight and consistently wound, its
/// volume, status of the same surface in manifold3d, its volume and its pieces.
const SURFACES: &str = "
import sys, numpy, trimesh, manifold3d
for path in sys.argv[1:]:
    m = trimesh.load(path)
    s = manifold3d.Manifold(manifold3d.Mesh64(
        numpy.asarray(m.vertices, numpy.float64), numpy.asarray(m.faces, numpy.uint64)))
    print(m.is_watertight and m.is_winding_consistent, m.volume, s.status().name, s.volume(), len(s.decompose()))
";

/// For each 3MF file and each object in it: its name, unit, volume where it stands, and the
/// twelve numbers of its place.
const ARCHIVES: &str = "
import sys, trimesh
for path in sys.argv[1:]:
    scene = trimesh.load_scene(path)
    for node in sorted(scene.graph.nodes_geometry):
        place, name = scene.graph[node]
        mesh = scene.geometry[name].copy().apply_transform(place)
        print(len(scene.geometry), name, scene.units, mesh.is_watertight, mesh.volume, *place[:3].ravel())
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

/// Words that a slicer says of what it does not like.
const COMPLAINTS: [&str; 6] =
    ["warning", "error", "repaired", "not manifold", "empty layer", "no extrusions"];

/// What the judges need of Python.
pub const PACKAGES: &str = "numpy, trimesh, manifold3d, lxml, networkx";

/// The interpreter of the repository's `.venv` if it has the packages that a
/// test needs; none if not, and the test is counted as skipped.
pub fn python(packages: &str) -> Option<PathBuf> {
    // Of every package that includes this file the repository is the folder above.
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin/python");
    let found = Command::new(&python).args(["-c", &format!("import {packages}")]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    skip(&format!("Python packages {packages} are missing: run `make setup`"));
    None
}

/// Whether a program is there; if not, the test is counted as skipped.
pub fn installed(program: &str) -> bool {
    let found = Command::new(program).arg("--help").output().is_ok();
    if !found {
        skip(&format!("{program} is not installed"));
    }
    found
}

/// Runs a script of Python on files and returns the words of each line.
fn run(python: &Path, script: &str, files: &[PathBuf]) -> Vec<Vec<String>> {
    let output = Command::new(python).args(["-c", script]).args(files).output();
    let output = output.expect("python starts");
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaint}");
    let said = String::from_utf8_lossy(&output.stdout);
    said.lines().map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

fn assert_close(found: &str, volume: f64, limit: f64, solid: &Solid) -> f64 {
    let found: f64 = found.parse().expect("a volume");
    let off = (found / volume - 1.0).abs();
    assert!(off < limit, "{}: volume {found}, ours {volume}", solid.file.display());
    off
}

/// trimesh and manifold3d find every surface closed and in one piece, and its volume.
pub fn trimesh_and_manifold3d_agree(python: &Path, solids: &[Solid]) {
    let files: Vec<PathBuf> = solids.iter().map(|solid| solid.file.clone()).collect();
    let lines = run(python, SURFACES, &files);
    assert_eq!(lines.len(), solids.len());
    let mut worst: f64 = 0.0;
    for (words, solid) in lines.iter().zip(solids) {
        let sound = [&words[0], &words[2], &words[4]];
        assert_eq!(sound, ["True", "NoError", "1"], "{}", solid.file.display());
        for volume in [&words[1], &words[3]] {
            worst = worst.max(assert_close(volume, solid.volume, VOLUME, solid));
        }
    }
    eprintln!("{} surfaces, volumes within {worst:.1e}", solids.len());
}

/// trimesh reads the 3MF file of every part, and in `assembly.3mf` of their folder all of
/// them, turned by `places`: rows of rotations from a part's file to the closed mold.
pub fn trimesh_reads_3mf(python: &Path, parts: &[Solid], places: &[[[f64; 3]; 3]]) {
    let archive = |solid: &Solid| solid.file.with_extension("3mf");
    let mut files: Vec<PathBuf> = parts.iter().map(archive).collect();
    files.push(parts[0].file.with_file_name("assembly.3mf"));
    let lines = run(python, ARCHIVES, &files);
    assert_eq!(lines.len(), 2 * parts.len());
    let (alone, together) = lines.split_at(parts.len());
    for (words, part) in alone.iter().zip(parts) {
        assert_eq!(words[..4], ["1", part.name.as_str(), "millimeter", "True"]);
        assert_close(&words[4], part.volume, DECIMALS, part);
    }
    let mut shifts = Vec::new();
    for (part, turn) in parts.iter().zip(places) {
        let words = together.iter().find(|words| words[1] == part.name);
        let words = words.unwrap_or_else(|| panic!("no {} in {together:?}", part.name));
        assert_eq!(words[0], parts.len().to_string());
        assert_eq!(words[2..4], ["millimeter", "True"]);
        assert_close(&words[4], part.volume, DECIMALS, part);
        let place: Vec<f64> = words[5..].iter().map(|x| x.parse().expect("a number")).collect();
        let turned = [0, 1, 2].map(|i| [0, 1, 2].map(|j| place[4 * i + j]));
        assert_eq!(turned, *turn, "{}", part.name);
        shifts.push([place[3], place[7], place[11]]);
    }
    // All are shifted into the octant of positive coordinates as one.
    assert!(shifts.iter().all(|shift| *shift == shifts[0]), "{shifts:?}");
}

/// admesh has nothing to repair.
pub fn admesh_repairs_nothing(solids: &[Solid]) {
    for Solid { file, .. } in solids {
        let output = Command::new("admesh").arg(file).output().expect("admesh starts");
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

/// prusa-slicer slices the 3MF file of a part with its settings, and the STL file solid, so
/// that all of it is seen to be printed: it complains of nothing, not even in its log, and
/// prints the plastic that the part has.
pub fn prusa_slicer_slices(part: &Solid, folder: &Path) {
    let settings = part.file.with_extension("ini");
    let archive = part.file.with_extension("3mf");
    let lengths = slice(&archive, &settings, &[], folder);
    assert!(lengths.part > 0.0, "{}: nothing is printed", archive.display());
    let solid = ["--fill-density", "100%", "--fill-pattern", "rectilinear"];
    let lengths = slice(&part.file, &settings, &solid, folder);
    let printed = lengths.part * FILAMENT / part.volume;
    let supports = lengths.support * FILAMENT / part.volume;
    eprintln!(
        "{}: {:.1} % of its volume printed, {:.1} % as supports",
        part.file.display(),
        100.0 * printed,
        100.0 * supports
    );
    assert!((1.0 - LOST..1.0 + GAINED).contains(&printed), "{}: {printed}", part.file.display());
}

/// Area of a filament of 1.75 mm [mm²].
const FILAMENT: f64 = 2.405_281_875;

/// Share of a part's volume that may not be printed, or too much: 0.2 to 2.3 % too much was
/// found, as lines reach over each other; what is too thin to be printed would be missing.
const LOST: f64 = 0.02;
const GAINED: f64 = 0.05;

/// Filament by what it is for [mm].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lengths {
    /// In the part.
    pub part: f64,
    /// In its supports.
    pub support: f64,
}

/// Slices a file and measures the filament.
pub fn slice(file: &Path, settings: &Path, options: &[&str], folder: &Path) -> Lengths {
    let gcode = folder.join("part.gcode");
    let mut command = Command::new("prusa-slicer");
    // Level 2 of its log are warnings.
    command.args(["--export-gcode", "--loglevel", "2", "--load"]).arg(settings);
    command.args(["--use-relative-e-distances", "--layer-gcode", "G92 E0", "--skirts", "0"]);
    command.args(options).arg("--output").arg(&gcode).arg(file);
    let output = command.output().expect("prusa-slicer starts");
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).to_lowercase();
    assert!(output.status.success(), "{}: {said}", file.display());
    for word in COMPLAINTS {
        assert!(!said.contains(word), "{}: {said}", file.display());
    }
    lengths(&std::fs::read_to_string(&gcode).expect("G-code was written"))
}

/// Filament of the moves along which something is printed.
fn lengths(gcode: &str) -> Lengths {
    let mut lengths = Lengths::default();
    let mut kind = "";
    for line in gcode.lines() {
        if let Some(name) = line.strip_prefix(";TYPE:") {
            kind = name;
        }
        // Without X and Y the filament is only drawn back or pushed on.
        if !line.starts_with("G1 X") {
            continue;
        }
        let extruded = line.split_whitespace().find_map(|word| word.strip_prefix('E'));
        let extruded = extruded.and_then(|number| number.parse::<f64>().ok()).unwrap_or(0.0);
        match kind {
            "Skirt/Brim" | "Custom" => {}
            _ if kind.starts_with("Support") => lengths.support += extruded,
            _ => lengths.part += extruded,
        }
    }
    lengths
}
