//! Solids: Booleans, simplification, planar cuts.
//!
//! The kernel is manifold-rust behind our types; this is the only file that
//! names it. A solid is bounded by closed, oriented, edge-manifold shells; outer
//! shells face outward, cavities inward. Its coordinates are 64-bit floats from
//! end to end, and its internal tolerance is 10⁻¹² of the bounding box, so that
//! metres need no scaling.

use crate::inside::WindingNumber;
use crate::measure::enclosed_volume;
use crate::{SurfaceMesh, Vec3};
use manifold_rust::linalg::{Mat3x4, Vec2 as KernelVec2, Vec3 as KernelVec3};
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Error as Status, MeshGL64};
use nalgebra::{Matrix3, Matrix3x4};

/// A solid body.
#[derive(Clone)]
pub struct Solid {
    kernel: Manifold,
}

/// Why a surface does not bound a solid.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum SolidError {
    /// The kernel refuses the surface.
    #[error(
        "a surface of {triangles} triangles and {vertices} vertices does not bound a solid: {status}; \
         it must be closed, oriented and manifold: see its validity checks"
    )]
    Refused {
        /// What the kernel found.
        status: String,
        /// Triangles given.
        triangles: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// Normals point inward.
    #[error("the surface encloses {volume:e} m³: its triangles face inward; reverse them")]
    InsideOut {
        /// Signed enclosed volume [m³].
        volume: f64,
    },
}

/// Where a triangle of a result comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin {
    /// [`Solid::id`] of the input solid.
    pub solid: u32,
    /// The label given to [`Solid::from_labelled_surface`]; without labels, the
    /// number of a coplanar group of triangles.
    pub face: u32,
}

impl Solid {
    /// The solid bounded by a closed surface.
    pub fn from_surface(surface: &SurfaceMesh) -> Result<Self, SolidError> {
        Self::import(surface, Vec::new())
    }

    /// As [`Self::from_surface`], with a label for each triangle that Booleans
    /// and planar cuts carry along; simplification keeps triangles of different
    /// labels apart.
    ///
    /// # Panics
    /// Unless each triangle has a label.
    pub fn from_labelled_surface(
        surface: &SurfaceMesh,
        labels: &[u32],
    ) -> Result<Self, SolidError> {
        assert_eq!(labels.len(), surface.triangles.len(), "one label for each triangle");
        Self::import(surface, labels.iter().map(|&l| u64::from(l)).collect())
    }

    fn import(surface: &SurfaceMesh, face_id: Vec<u64>) -> Result<Self, SolidError> {
        let mesh = MeshGL64 {
            num_prop: 3,
            vert_properties: surface.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect(),
            tri_verts: surface.triangles.iter().flatten().map(|&v| v as u64).collect(),
            run_original_id: vec![Manifold::reserve_ids(1)],
            face_id,
            ..MeshGL64::default()
        };
        let kernel = Manifold::from_mesh_gl64(&mesh);
        if kernel.status() != Status::NoError {
            return Err(SolidError::Refused {
                status: kernel.status().to_string(),
                triangles: surface.triangles.len(),
                vertices: surface.vertices.len(),
            });
        }
        let volume = enclosed_volume(surface);
        if volume < 0.0 {
            return Err(SolidError::InsideOut { volume });
        }
        Ok(Self { kernel })
    }

    /// The boundary of the solid.
    pub fn to_surface(&self) -> SurfaceMesh {
        surface_of(&self.kernel.get_mesh_gl64(-1))
    }

    /// The boundary of the solid and the origin of each of its triangles.
    pub fn to_surface_with_origin(&self) -> (SurfaceMesh, Vec<Origin>) {
        let mesh = self.kernel.get_mesh_gl64(-1);
        let mut origins = Vec::with_capacity(mesh.num_tri());
        for (run, &solid) in mesh.run_original_id.iter().enumerate() {
            let (start, end) = (mesh.run_index[run] / 3, mesh.run_index[run + 1] / 3);
            for t in start..end {
                origins.push(Origin { solid, face: mesh.face_id[t as usize] as u32 });
            }
        }
        (surface_of(&mesh), origins)
    }

    /// The number by which [`Origin::solid`] knows this solid, if all of its
    /// triangles come from one input.
    pub fn id(&self) -> Option<u32> {
        let (_, origins) = self.to_surface_with_origin();
        let first = origins.first()?.solid;
        origins.iter().all(|o| o.solid == first).then_some(first)
    }

    /// The points in this solid or in the other.
    pub fn union(&self, other: &Self) -> Self {
        Self { kernel: self.kernel.union(&other.kernel) }
    }

    /// The points in this solid and not in the other.
    pub fn difference(&self, other: &Self) -> Self {
        Self { kernel: self.kernel.difference(&other.kernel) }
    }

    /// The points in both solids.
    pub fn intersection(&self, other: &Self) -> Self {
        Self { kernel: self.kernel.intersection(&other.kernel) }
    }

    /// The solid moved by `v` [m].
    pub fn translate(&self, v: &Vec3) -> Self {
        Self { kernel: self.kernel.translate(to_kernel(v)) }
    }

    /// The solid under the affine map x ↦ A x + t, `map` = (A | t), t in [m]. A
    /// reflection keeps the outside outside.
    pub fn transform(&self, map: &Matrix3x4<f64>) -> Self {
        let column = |k: usize| KernelVec3::new(map[(0, k)], map[(1, k)], map[(2, k)]);
        let map = Mat3x4::from_cols(column(0), column(1), column(2), column(3));
        Self { kernel: self.kernel.transform(&map) }
    }

    /// Volume [m³].
    pub fn volume(&self) -> f64 {
        self.kernel.volume()
    }

    /// Area of the boundary [m²].
    pub fn area(&self) -> f64 {
        self.kernel.surface_area()
    }

    /// Genus 1 − χ/2 of the whole boundary, χ its Euler number: the number of
    /// handles for one shell, and one less for each further shell.
    pub fn genus(&self) -> i32 {
        self.kernel.genus()
    }

    /// Whether the solid has no points.
    pub fn is_empty(&self) -> bool {
        self.kernel.is_empty()
    }

    /// Corners of the bounding box [m]; inverted infinities for the empty solid.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let bounds = self.kernel.bounding_box();
        (from_kernel(bounds.min), from_kernel(bounds.max))
    }

    /// The connected bodies, each with the cavities inside it, largest first.
    pub fn decompose(&self) -> Vec<Self> {
        let shells = self.kernel.decompose().into_iter().map(|kernel| Self { kernel });
        let (mut outer, mut cavities) = (Vec::new(), Vec::new());
        for shell in shells {
            let volume = enclosed_volume(&shell.to_surface());
            if volume > 0.0 {
                outer.push((volume, vec![shell.kernel]));
            } else {
                cavities.push(shell);
            }
        }
        // Smallest first for now: the first shell that contains a cavity is its own.
        outer.sort_by(|a, b| a.0.total_cmp(&b.0));
        if !cavities.is_empty() {
            place_cavities(&mut outer, cavities);
        }
        outer.reverse();
        outer.into_iter().map(|(_, shells)| Self { kernel: Manifold::compose(&shells) }).collect()
    }

    /// The parts beyond and before the plane x · n = `offset` [m], where n is
    /// `normal` scaled to unit length.
    pub fn split_by_plane(&self, normal: &Vec3, offset: f64) -> (Self, Self) {
        let (beyond, before) = self.kernel.split_by_plane(to_kernel(normal), offset);
        (Self { kernel: beyond }, Self { kernel: before })
    }

    /// The part beyond the plane x · n = `offset` [m], where n is `normal` scaled
    /// to unit length. A cut along a coordinate plane is exact.
    pub fn trim_by_plane(&self, normal: &Vec3, offset: f64) -> Self {
        Self { kernel: self.kernel.trim_by_plane(to_kernel(normal), offset) }
    }

    /// Fewer triangles, the boundary moved by no more than about `tolerance` [m].
    pub fn simplify(&self, tolerance: f64) -> Self {
        Self { kernel: self.kernel.simplify(tolerance) }
    }

    /// The box with the given corners [m]; empty unless min < max in every
    /// coordinate.
    pub fn cube(min: &Vec3, max: &Vec3) -> Self {
        if (0..3).any(|k| max[k] <= min[k]) {
            return Self { kernel: Manifold::empty() };
        }
        let unit = Manifold::cube(KernelVec3::splat(1.0), false);
        // Placing the corners themselves: min + (max − min) need not be max.
        let place = |p: &mut KernelVec3| {
            for k in 0..3 {
                p[k] = if p[k] == 0.0 { min[k] } else { max[k] };
            }
        };
        Self { kernel: unit.warp(place).as_original() }
    }

    /// The frustum of a cone from `base` to `base + axis` [m] with the radii `r0`
    /// at its base and `r1` at its top [m], inscribed with `segments` sides (at
    /// least 3). Empty if it has no volume.
    pub fn cylinder(base: &Vec3, axis: &Vec3, r0: f64, r1: f64, segments: usize) -> Self {
        let height = axis.norm();
        if !(height > 0.0 && r0.min(r1) >= 0.0 && r0.max(r1) > 0.0) {
            return Self { kernel: Manifold::empty() };
        }
        let upright = Manifold::cylinder(height, r0, r1, segments.max(3) as i32);
        let frame = frame(&(axis / height));
        let map = Matrix3x4::from_columns(&[
            frame.column(0).into_owned(),
            frame.column(1).into_owned(),
            frame.column(2).into_owned(),
            *base,
        ]);
        Self { kernel: upright }.transform(&map)
    }

    /// The inscribed polyhedron of a sphere [m] with `segments` edges around a
    /// great circle, rounded up to a multiple of four. Empty if it has no volume.
    pub fn sphere(centre: &Vec3, radius: f64, segments: usize) -> Self {
        if radius <= 0.0 {
            return Self { kernel: Manifold::empty() };
        }
        let kernel = Manifold::sphere(radius, segments.max(4) as i32);
        Self { kernel }.translate(centre)
    }

    /// The prism z₀ ≤ z ≤ z₁ [m] over plane polygons [m]: outlines
    /// counter-clockwise, holes clockwise, not crossing. Empty if it has no volume.
    pub fn extrude(polygons: &[Vec<[f64; 2]>], z0: f64, z1: f64) -> Self {
        let polygons: Vec<Vec<KernelVec2>> = polygons
            .iter()
            .map(|polygon| polygon.iter().map(|p| KernelVec2::new(p[0], p[1])).collect())
            .collect();
        if polygons.is_empty() || z1 <= z0 {
            return Self { kernel: Manifold::empty() };
        }
        let prism = Manifold::extrude(&polygons, z1 - z0, 0, 0.0, KernelVec2::new(1.0, 1.0));
        Self { kernel: prism }.translate(&Vec3::new(0.0, 0.0, z0))
    }

    /// The convex hull of points [m].
    pub fn hull(points: &[Vec3]) -> Self {
        let points: Vec<_> = points.iter().map(to_kernel).collect();
        Self { kernel: Manifold::hull(&points) }
    }
}

/// Adds every cavity to the first of the shells, given with their volumes, that contains it.
fn place_cavities(outer: &mut [(f64, Vec<Manifold>)], cavities: Vec<Solid>) {
    let winding: Vec<_> = outer
        .iter()
        .map(|(_, shell)| WindingNumber::new(&surface_of(&shell[0].get_mesh_gl64(-1))))
        .collect();
    for cavity in cavities {
        let point = cavity.to_surface().vertices[0];
        if let Some(owner) = winding.iter().position(|w| w.contains(&point)) {
            outer[owner].1.push(cavity.kernel);
        }
    }
}

fn to_kernel(v: &Vec3) -> KernelVec3 {
    KernelVec3::new(v.x, v.y, v.z)
}

fn from_kernel(v: KernelVec3) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn surface_of(mesh: &MeshGL64) -> SurfaceMesh {
    let vertices = mesh.vert_properties.chunks_exact(mesh.num_prop.max(3) as usize);
    let triangles = mesh.tri_verts.chunks_exact(3);
    SurfaceMesh {
        vertices: vertices.map(|v| Vec3::new(v[0], v[1], v[2])).collect(),
        triangles: triangles.map(|t| [t[0] as usize, t[1] as usize, t[2] as usize]).collect(),
    }
}

/// A right-handed orthonormal frame whose third axis is the unit vector `w`; made
/// of unit vectors without rounding when `w` is one.
fn frame(w: &Vec3) -> Matrix3<f64> {
    let mut e = Vec3::zeros();
    e[w.iamin()] = 1.0;
    let u = (e - w * w.dot(&e)).normalize();
    Matrix3::from_columns(&[u, w.cross(&u), *w])
}

#[cfg(test)]
mod tests;
