//! `keep` in `[shape]`: flat faces of what moves stay in their planes.

use mesh::Vec3;
use tests::chamber::{DESIGN, SIM, chamber, workdir};
use tests::workdir::Workdir;

/// The floor of the chamber.
const FLOOR: &str = "keep = [{ axis = \"z\", at = 0.01 }]";

pub fn folder(levels: &str) -> Workdir {
    let dir = workdir();
    let (first, rest) = DESIGN.split_once("[[shape.level]]").unwrap();
    let (_, terms) = rest.split_once("[[objective]]").unwrap();
    let design = format!("{first}{FLOOR}\nsurface_tolerance = 0\n\n{levels}\n[[objective]]{terms}");
    dir.write("p1.toml", &SIM.replace("degree = 2", "degree = 1"));
    dir.write("design.toml", &design.replace("sim.toml", "p1.toml"));
    dir
}

/// Vertices of the chamber's floor: ids in the body.
fn floor() -> Vec<usize> {
    let body = chamber();
    let mut floor: Vec<usize> = body.facets("cavity").unwrap().concat();
    floor.retain(|&v| (body.mesh.vertices[v].z - 0.01).abs() < 1e-9);
    floor.sort_unstable();
    floor.dedup();
    floor
}

#[test]
fn a_flat_floor_stays_flat_and_moves_along_its_plane() {
    let before = chamber().mesh.vertices;
    for level in ["handles = 4", "vertices = true"] {
        let dir = folder(&format!("[[shape.level]]\n{level}\niterations = 3\n"));
        let run = dir.solver("optimize design.toml -o out");
        run.assert_good();
        let after = mesh::io::read_tets(&dir.path("out/design.msh")).unwrap().mesh.vertices;
        let way = |v: usize| -> Vec3 { after[v] - before[v] };
        let floor = floor();
        assert!(floor.len() > 8, "{}", floor.len());
        assert!(floor.iter().all(|&v| after[v].z.to_bits() == before[v].z.to_bits()), "{level}");
        let along = floor.iter().map(|&v| way(v).xy().norm()).fold(0.0, f64::max);
        let all = (0..before.len()).map(|v| way(v).z.abs()).fold(0.0, f64::max);
        assert!(along > 1e-5 && all > 1e-4, "{level}: floor {along} m, others {all} m");
    }
}
