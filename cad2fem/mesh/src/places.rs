//! Places that are the same, to the last bit.

use std::collections::HashMap;

use crate::{SurfaceMesh, Vec3};

/// The key of a place [m]: the bits of its coordinates, those of −0 as of 0.
pub fn place_key(place: &Vec3) -> [u64; 3] {
    // adding zero turns −0 into 0
    [place.x, place.y, place.z].map(|x| (x + 0.0).to_bits())
}

/// The key of a triangle by its places, in any order of its corners.
pub fn triangle_key(corners: &[Vec3; 3]) -> [[u64; 3]; 3] {
    let mut places = corners.each_ref().map(place_key);
    places.sort_unstable();
    places
}

/// For each place the index of the first that is the same.
pub fn first_at_place(places: &[Vec3]) -> Vec<usize> {
    let mut first = HashMap::with_capacity(places.len());
    places.iter().enumerate().map(|(i, p)| *first.entry(place_key(p)).or_insert(i)).collect()
}

/// The surface of triangles by their corners: of those at the same place the first is a vertex.
pub fn welded(corners: &[[Vec3; 3]]) -> SurfaceMesh {
    let (mut vertices, mut ids) = (Vec::new(), HashMap::with_capacity(corners.len() / 2));
    let mut id = |corner: Vec3| {
        *ids.entry(place_key(&corner)).or_insert_with(|| {
            vertices.push(corner);
            vertices.len() - 1
        })
    };
    let triangles = corners.iter().map(|triangle| triangle.map(&mut id)).collect();
    SurfaceMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_at_a_place_stands_for_all() {
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        let at = [0.0, 1.0, -0.0, next, 1.0].map(|x| Vec3::new(x, 2.0, -x));
        assert_eq!(first_at_place(&at), [0, 1, 0, 3, 1]);
    }
}
