//! `cad2fem film`, judged by the frames that a decoder finds in its GIF.

#![allow(clippy::unwrap_used)]

use std::fs::{self, File};
use std::path::Path;

use crate::support::Workdir;
use mesh::Vec3;
use mesh::io::vtu::{CellType, Field, Grid, write_vtu};

/// A tetrahedron that rises by `lift`.
fn step(folder: &Path, name: &str, lift: f64) {
    let points = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let values = (0..4).flat_map(|_| [0.0, 0.0, lift]).collect();
    let displacement =
        Field { name: "displacement".into(), unit: "m".into(), components: 3, values };
    let grid = Grid {
        points,
        cells: (0..4).collect(),
        cell_type: CellType::Tet4,
        point_fields: vec![displacement],
        cell_fields: vec![],
    };
    write_vtu(&folder.join(name), &grid).unwrap();
}

/// A run of three steps in a folder.
fn made() -> Workdir {
    let dir = Workdir::new();
    let run = dir.path("run");
    fs::create_dir(&run).unwrap();
    for (i, lift) in [0.0, 1.0, 2.0].into_iter().enumerate() {
        step(&run, &format!("step_{i:03}.vtu"), lift);
    }
    let steps: Vec<String> = [0.0, 0.5, 1.0].iter().map(|l| format!("{{\"load\": {l}}}")).collect();
    let report = format!("{{\"config\": {{\"time\": null}}, \"steps\": [{}]}}", steps.join(", "));
    dir.write("run/report.json", &report);
    dir
}

#[test]
fn every_step_is_a_frame_with_one_camera_and_scale() {
    let dir = made();
    let args =
        "film run -o a.gif --size 300x300 --view front --color displacement --no-ground --fps 20";
    dir.run(args).succeeds();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(File::open(dir.path("a.gif")).unwrap()).unwrap();
    assert_eq!([decoder.width(), decoder.height()], [300, 300]);
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let (mut delays, mut middles, mut blue) = (vec![], vec![], vec![]);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
        // rows of the left half, without the captions and the scale, that have strong colours
        let strong = |p: &[u8]| p[..3].iter().max().unwrap() - p[..3].iter().min().unwrap() > 40;
        let row = |y: &usize| frame.buffer[4 * 300 * y..][..4 * 150].chunks(4).any(strong);
        let rows: Vec<usize> = (0..270).filter(row).collect();
        middles.push(rows.iter().sum::<usize>() as f64 / rows.len() as f64);
        let body = frame.buffer.chunks(4).take(300 * 270).filter(|p| strong(p));
        blue.push(body.filter(|p| p[2] > p[1]).count());
    }
    // hundredths of a second, and the last one stays
    assert_eq!(delays, [5, 5, 100]);
    // the body rises in equal steps before a camera that stands still
    assert!(middles[0] > middles[1] + 20.0 && middles[1] > middles[2] + 20.0, "{middles:?}");
    // from the lower end of the common scale, dark blue, to its upper, yellow
    assert!(blue[0] > 5 * blue[2], "{blue:?}");
}

#[test]
fn what_is_no_run_is_refused() {
    let dir = made();
    for (args, words) in [
        ("run -o a.webm", "written as GIF"),
        ("run/step_000.vtu -o a.gif", "a film needs 2 at least"),
        ("run -o a.gif --fps 0", "0 is not in 1..=50"),
        ("nothing -o a.gif", "nothing: no such file or folder"),
        ("run -o a.gif --color stress", "stress"),
    ] {
        dir.run(&format!("film {args}")).fails(2, words);
        assert!(!dir.path("a.gif").exists());
    }
}
