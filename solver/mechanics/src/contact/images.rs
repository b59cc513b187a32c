//! Mirror images of collision vertices in planes of symmetry.
//!
//! With k planes there are 2^k copies of a surface, each a product of reflections; bit p of
//! its number says whether it is reflected in plane p. A vertex in a plane is its own image
//! there, so the copies are joined.

use std::collections::BTreeMap;

use mesh::{Vec3, facet_key};

use crate::symmetry::Plane;

/// A collision vertex as the image of another: x ↦ R x + s.
#[derive(Clone, Debug)]
pub(super) struct Image {
    /// The vertex of which it is the image.
    pub of: usize,
    /// The diagonal of R.
    pub signs: Vec3,
    /// s [m].
    pub shift: Vec3,
}

impl Image {
    /// A vertex of which no other is an image.
    pub fn itself(of: usize) -> Self {
        Self { of, signs: Vec3::repeat(1.0), shift: Vec3::zeros() }
    }
}

/// The vertices of a body, then their images in planes of symmetry.
pub struct Mirrored {
    images: Vec<Image>,
    share: f64,
}

impl Mirrored {
    /// The vertices up to the last of some sets of facets, and these sets with their images.
    pub fn new(planes: &[Plane], sets: &[Vec<[usize; 3]>]) -> (Self, Vec<Vec<[usize; 3]>>) {
        let count = sets.iter().flatten().flatten().max().map_or(0, |last| last + 1);
        let mut images = Images::new(planes, (0..count).map(|v| (v, vec![v])).collect());
        let mut whole = |set: &Vec<[usize; 3]>| -> Vec<[usize; 3]> {
            let mut facets = set.clone();
            for copy in 1..images.copies() {
                let mirrored = set.iter().map(|&facet| (facet, images.mirror(facet, copy)));
                // a facet in a plane is its own image
                let moved = mirrored.filter(|&(own, image)| facet_key(own) != facet_key(image));
                facets.extend(moved.map(|(_, image)| image));
            }
            facets
        };
        let sets = sets.iter().map(&mut whole).collect();
        (Self { images: images.all, share: share(planes) }, sets)
    }

    /// Share of the body in the whole: 1, or a half for each plane.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Positions of all from those of the body's vertices [m].
    pub fn positions(&self, x: &[Vec3]) -> Vec<Vec3> {
        self.images.iter().map(|i| x[i.of].component_mul(&i.signs) + i.shift).collect()
    }

    /// The vertex of the body that a vertex of the whole is an image of, with a cotangent there turned into its own.
    pub fn to_vertex(&self, of_whole: usize, bar: Vec3) -> (usize, Vec3) {
        let image = &self.images[of_whole];
        (image.of, image.signs.component_mul(&bar))
    }

    /// Adds the transpose of the derivative of [`Self::positions`] times `bar`, both three
    /// components per vertex.
    pub fn add_to_vertices(&self, bar: &[f64], out: &mut [f64]) {
        for (image, bar) in self.images.iter().zip(bar.chunks_exact(3)) {
            for k in 0..3 {
                out[3 * image.of + k] += image.signs[k] * bar[k];
            }
        }
    }
}

/// Share of a body that planes of symmetry cut in the whole.
pub(super) fn share(planes: &[Plane]) -> f64 {
    0.5_f64.powi(planes.len() as i32)
}

/// The images of all vertices.
pub(super) struct Images<'a> {
    planes: &'a [Plane],
    /// Planes that each vertex is in, as bits.
    within: Vec<usize>,
    /// Number of each image by the vertex and the copy.
    ids: BTreeMap<(usize, usize), usize>,
    /// The vertices themselves, then their images.
    pub all: Vec<Image>,
}

impl<'a> Images<'a> {
    /// The vertices themselves, by the vertices of the mesh that they lie between.
    pub fn new(planes: &'a [Plane], corners: BTreeMap<usize, Vec<usize>>) -> Self {
        let of_vertex = |corners: &Vec<usize>| {
            let is_in = |p: &usize| corners.iter().all(|&v| planes[*p].contains(v));
            (0..planes.len()).filter(is_in).map(|p| 1 << p).sum()
        };
        let within = corners.values().map(of_vertex).collect();
        let all = (0..corners.len()).map(Image::itself).collect();
        Self { planes, within, ids: BTreeMap::new(), all }
    }

    /// Number of copies of the surface, the first of which is the surface itself.
    pub fn copies(&self) -> usize {
        1 << self.planes.len()
    }

    /// A triangle in one of the copies, oriented out of the solid.
    pub fn mirror(&mut self, triangle: [usize; 3], copy: usize) -> [usize; 3] {
        let [a, b, c] = triangle.map(|v| self.image(v, copy));
        if copy.count_ones().is_multiple_of(2) { [a, b, c] } else { [b, a, c] }
    }

    fn image(&mut self, of: usize, copy: usize) -> usize {
        let copy = copy & !self.within[of];
        if copy == 0 {
            return of;
        }
        let (all, planes) = (&mut self.all, self.planes);
        *self.ids.entry((of, copy)).or_insert_with(|| {
            let mut image = Image::itself(of);
            for plane in planes.iter().enumerate().filter(|(p, _)| copy >> p & 1 == 1).map(|p| p.1)
            {
                image.signs[plane.axis] = -1.0;
                image.shift[plane.axis] = 2.0 * plane.level;
            }
            all.push(image);
            all.len() - 1
        })
    }
}
