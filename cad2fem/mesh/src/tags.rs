//! Names for parts of a boundary, for surfaces inside and for volumes.

use std::collections::BTreeMap;

/// Facet tags of a tetrahedral mesh: facet → id ↔ name; and its volumes.
///
/// Ids start at 1 in the order in which the names were declared. A facet is
/// known by its three vertex ids in ascending order, so that its orientation
/// plays no part. Facets without a tag are absent.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tags {
    /// Tag names; the id of `names[i]` is `i + 1`.
    pub names: Vec<String>,
    /// Sorted facet → id.
    pub facets: BTreeMap<[usize; 3], u32>,
    /// Parts of the tetrahedra with a name.
    pub volumes: Volumes,
}

/// Volumes of a mesh: one for each tetrahedron, or none at all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Volumes {
    /// Their names.
    pub names: Vec<String>,
    /// For each tetrahedron the index of its name; empty if there are none.
    pub of: Vec<usize>,
}

/// The key of a facet: its vertex ids in ascending order.
pub fn facet_key(mut facet: [usize; 3]) -> [usize; 3] {
    facet.sort_unstable();
    facet
}

impl Tags {
    /// No facets yet, ids in the order of `names`.
    pub fn new(names: Vec<String>) -> Self {
        Self { names, ..Self::default() }
    }

    /// The id of a name.
    pub fn id(&self, name: &str) -> Option<u32> {
        let index = self.names.iter().position(|n| n == name)?;
        u32::try_from(index + 1).ok()
    }

    /// The id of a facet, whatever the order of its vertices.
    pub fn get(&self, facet: [usize; 3]) -> Option<u32> {
        self.facets.get(&facet_key(facet)).copied()
    }

    /// Tags a facet.
    pub fn set(&mut self, facet: [usize; 3], id: u32) {
        self.facets.insert(facet_key(facet), id);
    }

    /// All facets of a tag, sorted.
    pub fn facets_of(&self, id: u32) -> Vec<[usize; 3]> {
        self.facets.iter().filter(|&(_, &i)| i == id).map(|(&f, _)| f).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_are_known_in_any_order_of_their_vertices() {
        let mut tags = Tags::new(vec!["seat".into(), "cavity".into()]);
        tags.set([7, 2, 5], 2);
        tags.set([3, 2, 1], 2);
        assert_eq!(tags.get([5, 7, 2]), Some(2));
        assert_eq!(tags.get([5, 7, 3]), None);
        assert_eq!(tags.facets_of(2), [[1, 2, 3], [2, 5, 7]]);
        assert_eq!((tags.id("cavity"), tags.id("throat")), (Some(2), None));
    }
}
