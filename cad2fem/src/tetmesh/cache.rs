//! Meshes of earlier runs, by a hash of everything that determines them.
//!
//! fTetWild is not deterministic: without the cache a second run would give another
//! mesh. An entry is `<key>.msh` and `<key>.sha256`, the fingerprint of the former;
//! an entry that does not match its fingerprint is replaced.

use std::path::PathBuf;

use anyhow::Result;
use mesh::io::{read_own_text, read_tets, write_atomic, write_tets};
use mesh::{SurfaceMesh, Tags, TetMesh};
use program::{sha256, sha256_file};
use serde::Serialize;

use crate::installation::{checkout, share};

/// Environment variable that names the folder of caches.
pub const CACHE_VARIABLE: &str = "PUFFER_CACHE";

/// A folder of meshes.
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// `meshes` in the folder named by [`CACHE_VARIABLE`], else in `.cache` of the
    /// checkout that the program was built in, or in the user's folder of caches where the program was installed
    /// with its rules for make; else `None`.
    pub fn open() -> Option<Self> {
        let named = std::env::var_os(CACHE_VARIABLE).map(PathBuf::from);
        let installed = || share().and_then(|_| users());
        let root =
            named.or_else(|| checkout().map(|folder| folder.join(".cache"))).or_else(installed)?;
        Some(Self { folder: root.join("meshes") })
    }

    /// The mesh of `key`, if there is a sound one.
    pub fn get(&self, key: &str) -> Option<TetMesh> {
        let (file, print) = self.entry(key);
        let expected = read_own_text(&print).ok()?;
        let sound = sha256_file(&file).is_ok_and(|found| found == expected.trim());
        let mesh = sound.then(|| read_tets(&file).ok()).flatten();
        if mesh.is_none() {
            log::warn!("{}: damaged cache entry, meshing again", file.display());
        }
        mesh.map(|file| file.mesh)
    }

    /// Keeps a mesh.
    pub fn put(&self, key: &str, mesh: &TetMesh) -> Result<()> {
        let (file, print) = self.entry(key);
        write_tets(&file, mesh, &Tags::default())?;
        let hash = sha256_file(&file)?;
        write_atomic(&print, |out| writeln!(out, "{hash}"))?;
        Ok(())
    }

    fn entry(&self, key: &str) -> (PathBuf, PathBuf) {
        (self.folder.join(format!("{key}.msh")), self.folder.join(format!("{key}.sha256")))
    }
}

/// Puffer's place in the user's folder of caches.
fn users() -> Option<PathBuf> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let caches = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(caches.join("puffer"))
}

/// SHA-256 of the bits of a surface and of everything else that determines a mesh.
pub fn key(surface: &SurfaceMesh, rest: &impl Serialize) -> Result<String> {
    let coordinates = surface.vertices.iter().flat_map(|v| v.iter());
    let mut bytes: Vec<u8> = coordinates.flat_map(|x| x.to_le_bytes()).collect();
    let corners = surface.triangles.iter().flatten();
    bytes.extend(corners.flat_map(|&v| (v as u64).to_le_bytes()));
    serde_json::to_writer(&mut bytes, rest)?;
    Ok(sha256(&bytes))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;

    fn tetrahedron() -> TetMesh {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z() / 3.0];
        TetMesh { vertices, tets: vec![[0, 1, 2, 3]] }
    }

    #[test]
    fn a_damaged_entry_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache { folder: folder.path().to_path_buf() };
        assert!(cache.get("k").is_none());
        cache.put("k", &tetrahedron()).unwrap();
        assert_eq!(cache.get("k"), Some(tetrahedron()));
        let file = folder.path().join("k.msh");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text.replacen("1.0", "1.5", 1)).unwrap();
        assert!(cache.get("k").is_none());
        std::fs::write(&file, &text[..text.len() / 2]).unwrap();
        assert!(cache.get("k").is_none());
    }

    #[test]
    fn the_key_tells_inputs_and_options_apart() {
        let surface = |x: f64| SurfaceMesh {
            vertices: vec![Vec3::zeros(), Vec3::x() * x, Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        let reference = key(&surface(1.0), &("a", 1)).unwrap();
        assert_eq!(reference, key(&surface(1.0), &("a", 1)).unwrap());
        assert_ne!(reference, key(&surface(1.0), &("a", 2)).unwrap());
        assert_ne!(reference, key(&surface(1.0 + 1e-15), &("a", 1)).unwrap());
    }
}
