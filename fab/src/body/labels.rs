//! Which triangles of a model are walls of chambers.
//!
//! Tags are those of the tetrahedra. Each facet of their boundary votes with its area for the triangle of the model
//! that is nearest and faces the same way. The triangles of a region (`patches` beside the model) get one answer
//! together, so that a wall ends where the region does, and not along facets; a region in which the tags end is
//! divided at its sharp edges, and what is left triangle by triangle.

use std::collections::{BTreeMap, HashMap};

use mesh::bvh::SurfaceBvh;
use mesh::topology::{DisjointSets, edge_facets};
use mesh::{SurfaceMesh, triangle_key};

/// The chamber whose wall a facet is, if any.
pub type Chamber = Option<usize>;

/// Part of a region's area that may have another answer than the rest: facets cross its rim.
const STRAY: f64 = 0.1;

/// The area that may have another answer in any case [mean facets]: the facets at the rim of a small region are most
/// of it.
const STRAY_FACETS: f64 = 4.0;

/// Least cosine of the angle between triangles at an edge that is not sharp (40°).
const SMOOTH: f64 = 0.766;

/// The chamber of each triangle of a model, as the facets of `mesh` have them. `patches` are regions of the model.
pub fn of_model(
    model: &SurfaceMesh,
    patches: &[SurfaceMesh],
    mesh: &SurfaceMesh,
    chamber: &[Chamber],
) -> Vec<Chamber> {
    let votes = Votes::new(model, mesh, chamber);
    let mut found = vec![None; model.triangles.len()];
    for region in regions(model, patches) {
        if let Some(answer) = votes.clear(&region) {
            region.into_iter().for_each(|t| found[t] = answer);
            continue;
        }
        for piece in smooth_pieces(model, &region) {
            let answer = votes.clear(&piece);
            for t in piece {
                found[t] = answer.unwrap_or_else(|| votes.nearest(t));
            }
        }
    }
    found
}

/// What the facets of a mesh say about the triangles of a model.
struct Votes<'a> {
    model: &'a SurfaceMesh,
    chamber: &'a [Chamber],
    bvh: SurfaceBvh,
    /// For each triangle of the model the areas of facets for each answer [m²].
    of: Vec<BTreeMap<Chamber, f64>>,
    /// Mean area of a facet [m²].
    facet: f64,
}

impl<'a> Votes<'a> {
    fn new(model: &'a SurfaceMesh, mesh: &'a SurfaceMesh, chamber: &'a [Chamber]) -> Self {
        let on_model = SurfaceBvh::new(model);
        let mut of = vec![BTreeMap::new(); model.triangles.len()];
        let mut total = 0.0;
        for (f, &answer) in chamber.iter().enumerate() {
            let near = on_model.closest(&mesh.centroid(f));
            let area = mesh.area(f);
            total += area;
            if mesh.normal(f).dot(&model.normal(near.triangle)) > 0.0 {
                *of[near.triangle].entry(answer).or_insert(0.0) += area;
            }
        }
        let facet = total / chamber.len().max(1) as f64;
        Self { model, chamber, bvh: SurfaceBvh::new(mesh), of, facet }
    }

    /// The answer for all of these triangles, if one clearly prevails.
    fn clear(&self, triangles: &[usize]) -> Option<Chamber> {
        let mut sums: BTreeMap<Chamber, f64> = BTreeMap::new();
        let mut add = |answer, area| *sums.entry(answer).or_insert(0.0) += area;
        triangles.iter().flat_map(|&t| &self.of[t]).for_each(|(&answer, &area)| add(answer, area));
        let asked = triangles.iter().all(|&t| self.of[t].is_empty());
        if asked {
            // No facet is nearest to it: it is smaller than facets.
            triangles.iter().for_each(|&t| add(self.nearest(t), self.model.area(t)));
        }
        let total: f64 = sums.values().sum();
        let (answer, most) = sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let stray = (STRAY * total).max(STRAY_FACETS * self.facet);
        (asked || total - most <= stray).then_some(answer)
    }

    /// The answer of the facet nearest to a triangle.
    fn nearest(&self, triangle: usize) -> Chamber {
        self.chamber[self.bvh.closest(&self.model.centroid(triangle)).triangle]
    }
}

/// The triangles of a model by region, and last those of none.
fn regions(model: &SurfaceMesh, patches: &[SurfaceMesh]) -> Vec<Vec<usize>> {
    let key = |surface: &SurfaceMesh, t: usize| triangle_key(&surface.corners(t));
    let mut owner = HashMap::new();
    for (i, patch) in patches.iter().enumerate() {
        for t in 0..patch.triangles.len() {
            owner.entry(key(patch, t)).or_insert(i);
        }
    }
    let mut all = vec![Vec::new(); patches.len() + 1];
    for t in 0..model.triangles.len() {
        all[owner.get(&key(model, t)).copied().unwrap_or(patches.len())].push(t);
    }
    all.retain(|region| !region.is_empty());
    all
}

/// Parts of a region that are connected across edges which are not sharp.
fn smooth_pieces(model: &SurfaceMesh, region: &[usize]) -> Vec<Vec<usize>> {
    let triangles: Vec<[usize; 3]> = region.iter().map(|&t| model.triangles[t]).collect();
    let mut pieces = DisjointSets::new(region.len());
    for pair in edge_facets(&triangles).into_values() {
        let [a, b] = pair[..] else { continue };
        if model.normal(region[a]).dot(&model.normal(region[b])) >= SMOOTH {
            pieces.join(a, b);
        }
    }
    let members = |piece: Vec<usize>| piece.into_iter().map(|t| region[t]).collect();
    pieces.groups().into_iter().map(members).collect()
}
