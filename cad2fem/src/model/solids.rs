//! What several solids of a CAD file are to each other: the air of a chamber inside a body, separate
//! bodies, or solids that meet, of which the user has to say what they are.

use std::fmt::Write as _;
use std::path::Path;

use mesh::SurfaceMesh;
use mesh::check::orient_by_nesting;
use mesh::crossings::self_intersecting_pairs;
use mesh::inside::WindingNumber;
use mesh::measure::{bounds, enclosed_volume};

use crate::mesher::gmsh::Faces;

/// The solids of a file; none of a file that has one.
#[derive(Debug, Default)]
pub struct Solids {
    all: Vec<Solid>,
}

#[derive(Debug)]
struct Solid {
    /// Name of the solid in the file; empty if the file gives none.
    name: String,
    /// Boundary of the solid [m].
    surface: SurfaceMesh,
    /// [m³]
    volume: f64,
}

impl Solids {
    /// The solids of a file whose faces have been meshed.
    pub fn of(faces: &Faces) -> Self {
        let solid = |(name, triangles): &(String, Vec<usize>)| {
            let mut surface = faces.surface.part(triangles);
            orient_by_nesting(&mut surface);
            let volume = enclosed_volume(&surface);
            Solid { name: name.clone(), surface, volume }
        };
        Self { all: faces.solids.iter().map(solid).collect() }
    }

    /// Says which solid lies strictly inside which, so that it is a chamber. What meets is no
    /// matter of this function.
    pub fn remark_on_chambers(&self, file: &Path) {
        for (air, body) in self.nested() {
            log::info!(
                "{}: {} lies inside {}: it is taken for the air of a closed chamber",
                file.display(),
                self.described(air),
                self.label(body)
            );
        }
    }

    /// Pairs of a solid and the smallest one around it.
    fn nested(&self) -> Vec<(usize, usize)> {
        let numbers: Vec<WindingNumber> =
            self.all.iter().map(|solid| WindingNumber::new(&solid.surface)).collect();
        let holds = |outer: usize, inner: usize| {
            let first = self.all[inner].surface.vertices.first();
            outer != inner && first.is_some_and(|p| numbers[outer].contains(p))
        };
        let around = |inner: usize| {
            let outer = (0..self.all.len()).filter(|&outer| holds(outer, inner));
            outer.min_by(|&a, &b| self.all[a].volume.total_cmp(&self.all[b].volume))
        };
        (0..self.all.len()).filter_map(|inner| Some((inner, around(inner)?))).collect()
    }

    /// Why the solids are no body, and what to do; none if they do not meet. `command` is what the
    /// user wrote up to the option.
    pub fn complaint(&self, file: &Path, command: &str) -> Option<String> {
        if self.all.len() < 2 || !self.meet() {
            return None;
        }
        let count = self.all.len();
        let mut text = format!(
            "{}: it has {count} solids, and their surfaces touch or cross:",
            file.display()
        );
        for i in 0..count {
            // writing to a string cannot fail
            let _ = write!(text, "\n  {}", self.described(i));
        }
        let air = (0..count).min_by(|&a, &b| self.all[a].volume.total_cmp(&self.all[b].volume));
        let air = air.map(|i| self.key(i)).unwrap_or_default();
        let _ = write!(
            text,
            "\nif one of them is the air of a chamber, take it out of the others: {command} --subtract {air}"
        );
        Some(text)
    }

    fn meet(&self) -> bool {
        let mut together = SurfaceMesh::default();
        self.all.iter().for_each(|solid| together.append(&solid.surface));
        !self_intersecting_pairs(&together).is_empty()
    }

    /// What `--subtract` calls a solid: its name if no other has it and it is one word, or its number.
    fn key(&self, i: usize) -> String {
        let name = &self.all[i].name;
        let word = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        let plain = name.chars().all(word) && !name.is_empty() && !name.starts_with('-');
        let unique = self.all.iter().filter(|other| other.name == *name).count() == 1;
        if plain && unique { name.clone() } else { (i + 1).to_string() }
    }

    fn label(&self, i: usize) -> String {
        match self.all[i].name.as_str() {
            "" => format!("solid {}", i + 1),
            name => format!("solid {} {name:?}", i + 1),
        }
    }

    fn described(&self, i: usize) -> String {
        let Solid { surface, volume, .. } = &self.all[i];
        let (low, high) = bounds(&surface.vertices);
        let point = |p: mesh::Vec3| format!("{:.1}, {:.1}, {:.1}", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
        let place = format!("from {} to {} mm", point(low), point(high));
        format!("{} of {:.3} cm3, {place}", self.label(i), 1e6 * volume)
    }
}
