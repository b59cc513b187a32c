//! Meshers that are slow, die, or answer nonsense.

use std::os::unix::fs::PermissionsExt;

use mechanics::math::random::Random;
use mesh::io::write_surface;
use mesh::{SurfaceMesh, Vec3};
use tests::workdir::Workdir;

use crate::any;
use crate::child;
use crate::job::Sound;
use crate::trial::Tally;

/// What stands in for Python: it answers the question for its version, then does this.
const DEEDS: &[&str] = &[
    "exec sleep 60",
    "kill -9 $$",
    "exit 1",
    "exit 0",
    "echo nonsense > \"$PWD/volume.msh\"",
    "head -c 3000 /dev/urandom > volume.msh",
    "head -c 100000 /dev/zero >&2; exit 3",
    "for f in *; do echo 1 > \"$f\"; done",
    "cd ..; rmdir * 2> /dev/null; exit 0",
];

/// `cad2fem tetmesh` with one of them ends in time, says so, and leaves nothing.
pub fn bad(_: &Sound, random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let dir = Workdir::new();
    write_surface(&dir.path("cube.stl"), &tetrahedron()).map_err(|e| format!("{e:#}"))?;
    std::fs::create_dir(dir.path("tmp")).map_err(|e| e.to_string())?;
    let deed = DEEDS[any(random, DEEDS.len())];
    dir.write(
        "python",
        &format!("#!/bin/sh\nif [ \"$2\" = -c ]; then echo 0.0; exit; fi\n{deed}\n"),
    );
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(dir.path("python"), executable).map_err(|e| e.to_string())?;
    let arguments = "tetmesh cube.stl -o out/volume.msh --no-cache --timeout 1";
    let mut command = dir.command_of("cad2fem", arguments);
    command.env("PUFFER_PYTHON", dir.path("python")).env("TMPDIR", dir.path("tmp"));
    let context = |what: String| format!("{deed}: {what}");
    child::run(command)?.expect(&[1, 2]).map_err(context)?;
    tally.interruptions += 1;
    for folder in ["out", "tmp"] {
        if let Some(name) = dir.files(folder).first() {
            return Err(context(format!("{folder}/{name} is left behind")));
        }
    }
    Ok(())
}

fn tetrahedron() -> SurfaceMesh {
    let corner = |x: f64, y: f64, z: f64| 0.01 * Vec3::new(x, y, z);
    SurfaceMesh {
        vertices: vec![
            corner(0.0, 0.0, 0.0),
            corner(1.0, 0.0, 0.0),
            corner(0.0, 1.0, 0.0),
            corner(0.0, 0.0, 1.0),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    }
}
