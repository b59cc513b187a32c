//! Two blocks that fall and slide: a scene through time whose whole past counts.

use mesh::Vec3;
use mesh::io::{write_surface, write_tets};

use crate::workdir::Workdir;
use crate::{block, plate, tag};

/// Number of time steps.
pub const STEPS: usize = 16;

/// A block falls onto a floor, and another, which is held above, is moved onto it; they slide.
/// The state before last, lagged contacts, the couplings of contact, and the work of the support
/// all matter.
pub fn workdir() -> Workdir {
    let dir = Workdir::new();
    let top = |p: Vec3| p.z > 12e-3 - 1e-9;
    let block = block([1, 1, 1], 12e-3, |_| false, |p| p);
    let block = tag(block, &[("top", &top), ("skin", &|_| true)]);
    write_tets(&dir.path("block.msh"), &block.mesh, &block.tags).expect("the folder is writable");
    let floor = plate([-1.0, 1.0], [-1.0, 1.1], 0.0);
    write_surface(&dir.path("floor.stl"), &floor).expect("the folder is writable");
    let material = "{ kind = \"neo-hookean\", young = 3e4, poisson = 0.4, density = 1000.0 }";
    dir.write(
        "sim.toml",
        &format!(
            "degree = 1\ngravity = [0, 0, -9.8]\n\
             [[body]]\nname = \"low\"\nmesh = \"block.msh\"\ntranslate = [0, 0, 3e-4]\n\
             velocity = [0.3, 0, 0]\nmaterial = {material}\n\
             [[body]]\nname = \"high\"\nmesh = \"block.msh\"\ntranslate = [3e-3, 2e-3, 13e-3]\n\
             velocity = [0, 0.1, -0.2]\nmaterial = {material}\n\
             [[fixed]]\non = \"high.top\"\ndisplacement = [0, \"0.1*t\", \"-0.05*t\"]\n\
             [[obstacle]]\nname = \"floor\"\nsurface = \"floor.stl\"\n\
             [contact]\nactivation = 2e-4\nstiffness = 3e4\nfriction = 0.4\n\
             [time]\nmethod = \"bdf2\"\nend = 0.032\nsteps = {STEPS}\n"
        ),
    );
    dir
}
