//! Every reader of files, as a function of bytes that must return: whatever the bytes are, there is
//! a value or an error, in reasonable time.
//!
//! The bodies are those that `cargo fuzz` wants, `fuzz_target!(|data: &[u8]| (target.read)(data))`;
//! `make fuzz` runs them on stable with the mutations of [`mutate`], from seeds that it prints.

mod corpus;
mod mutation;
pub mod numbers;

use std::path::Path;

pub use mutation::mutate;

use crate::workdir::Workdir;

/// A reader.
pub struct Target {
    /// Its name, for regression files and messages.
    pub name: &'static str,
    /// Reads bytes; must not panic.
    pub read: fn(&[u8]),
    /// Sound inputs.
    pub corpus: fn() -> Vec<Vec<u8>>,
}

/// All readers.
pub const TARGETS: &[Target] = &[
    Target { name: "stl", read: |b| surface(b, "a.stl"), corpus: || corpus::surface("stl") },
    Target { name: "obj", read: |b| surface(b, "a.obj"), corpus: || corpus::surface("obj") },
    Target { name: "ply", read: |b| surface(b, "a.ply"), corpus: || corpus::surface("ply") },
    Target {
        name: "msh",
        read: |b| read(b, "a.msh", |p| mesh::io::read_tets(p).map(drop)),
        corpus: corpus::msh,
    },
    Target {
        name: "vtu",
        read: |b| read(b, "a.vtu", |p| mesh::io::vtu::read_vtu(p).map(drop)),
        corpus: corpus::vtu,
    },
    Target {
        name: "npy",
        read: |b| read(b, "a.npy", |p| mesh::io::npy::read_f64(p).map(drop)),
        corpus: corpus::npy,
    },
    Target {
        name: "checkpoint",
        read: |b| {
            let value = |p: &Path| program::read_checkpoint::<Vec<f64>>(p, "fuzz 1").map(drop);
            read(b, "checkpoint.json", value);
        },
        corpus: corpus::checkpoint,
    },
    Target {
        name: "geo",
        read: |b| drop(cad2fem::mesher::script::without_reach(b)),
        corpus: || corpus::pipelines("model.geo"),
    },
    Target {
        name: "model.toml",
        read: |b| read(b, "model.toml", |p| cad2fem::implicit::ModelFile::read(p, &[]).map(drop)),
        corpus: || corpus::pipelines("model.toml"),
    },
    Target {
        name: "cad2fem.toml",
        read: |b| {
            read(b, "cad2fem.toml", |p| {
                cad2fem::tetmesh::config::Config::read(Some(p), &[]).map(drop)
            })
        },
        corpus: || corpus::pipelines("cad2fem.toml"),
    },
    Target {
        name: "tags.toml",
        read: |b| read(b, "tags.toml", |p| tagger::config::Config::read(p, &[]).map(drop)),
        corpus: || corpus::pipelines("tags.toml"),
    },
    Target {
        name: "sim.toml",
        read: |b| read(b, "sim.toml", |p| scene::config::SimConfig::read(p).map(drop)),
        corpus: || corpus::pipelines("sim.toml"),
    },
    Target {
        name: "design.toml",
        read: |b| read(b, "design.toml", |p| scene::config::DesignConfig::read(p).map(drop)),
        corpus: || corpus::pipelines("design.toml"),
    },
    Target {
        name: "mold.toml",
        read: |b| read(b, "mold.toml", |p| fab::config::Config::read(Some(p), &[]).map(drop)),
        corpus: || corpus::pipelines("mold.toml"),
    },
    Target {
        name: "3mf",
        read: |b| read(b, "a.3mf", |p| mesh::io::threemf::read(p).map(drop)),
        corpus: corpus::threemf,
    },
    Target {
        name: "polyfem",
        read: |b| {
            let options = polyfem::Options::default();
            read(b, "scene.json", |p| polyfem::read(p, &options).map(drop));
        },
        corpus: corpus::polyfem,
    },
];

fn surface(bytes: &[u8], name: &str) {
    read(bytes, name, |path| {
        let surface = mesh::io::read_surface(path)?;
        let _ = mesh::check::check_surface(&surface);
        Ok::<_, mesh::io::IoError>(())
    });
}

thread_local! {
    // a disk would be a hundred times as slow as most readers
    static FOLDER: Workdir = Workdir::in_memory();
}

/// Puts the bytes into a file and reads it; a value is as good as an error.
fn read<E>(bytes: &[u8], name: &str, reader: impl FnOnce(&Path) -> Result<(), E>) {
    FOLDER.with(|folder| {
        let path = folder.path(name);
        std::fs::write(&path, bytes).expect("the folder is writable");
        let _ = reader(&path);
    });
}
