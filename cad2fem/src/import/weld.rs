//! Vertices that coincide become one, and triangles that bound nothing go.

use std::collections::{BTreeMap, HashMap};

use mesh::Vec3;
use mesh::topology::boundary_edges;

use super::Patched;

/// What was merged and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Welded {
    /// Vertices at the rims of openings that became others.
    pub vertices: usize,
    /// Edges with a single triangle before.
    pub open_before: usize,
    /// And after.
    pub open_after: usize,
    /// Triangles without three corners, or that lie on others.
    pub triangles: usize,
}

/// Merges vertices at the same place, then those on the rims of openings that are closer than
/// `reach` [m], and leaves out triangles that have two corners in one, and those that another
/// one repeats; of two that face each other neither bounds anything.
pub fn weld(body: &mut Patched, reach: f64) -> Welded {
    let given = body.patch.len();
    let same = mesh::first_at_place(&body.surface.vertices);
    merge(body, &same);
    let mut welded = Welded::default();
    let open = boundary_edges(&body.surface.triangles);
    welded.open_before = open.len();
    if !open.is_empty() && reach > 0.0 {
        let mut rim: Vec<usize> = open.into_iter().flatten().collect();
        rim.sort_unstable();
        rim.dedup();
        let target = near(&body.surface.vertices, &rim, reach);
        welded.vertices = (0..target.len()).filter(|&v| target[v] != v).count();
        merge(body, &target);
    }
    welded.open_after = boundary_edges(&body.surface.triangles).len();
    welded.triangles = given - body.patch.len();
    welded
}

/// For each vertex itself, or of those in `rim` the nearest earlier one within `reach`.
fn near(vertices: &[Vec3], rim: &[usize], reach: f64) -> Vec<usize> {
    let mut target: Vec<usize> = (0..vertices.len()).collect();
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let cell = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x / reach).floor() as i64);
    for &v in rim {
        let [i, j, k] = cell(&vertices[v]);
        let around =
            (-1..=1).flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [a, b, c])));
        let others = around.filter_map(|[a, b, c]| cells.get(&[i + a, j + b, k + c])).flatten();
        let measured = others.map(|&w| ((vertices[w] - vertices[v]).norm(), w));
        let nearest = measured.filter(|&(d, _)| d <= reach).min_by(|a, b| a.0.total_cmp(&b.0));
        match nearest {
            Some((_, other)) => target[v] = other,
            None => cells.entry([i, j, k]).or_default().push(v),
        }
    }
    target
}

/// Puts `target[v]` in place of every vertex, and leaves out triangles that bound nothing.
fn merge(body: &mut Patched, target: &[usize]) {
    let merged: Vec<[usize; 3]> =
        body.surface.triangles.iter().map(|corners| corners.map(|v| target[v])).collect();
    let mut twins: BTreeMap<[usize; 3], Vec<usize>> = BTreeMap::new();
    for (t, corners) in merged.iter().enumerate() {
        twins.entry(mesh::facet_key(*corners)).or_default().push(t);
    }
    let mut kept = Vec::new();
    for ([a, b, c], same) in twins {
        if a == b || b == c {
            continue;
        }
        let (first, second): (Vec<usize>, Vec<usize>) =
            same.into_iter().partition(|&t| is_even(merged[t]));
        // as many from both sides: a sheet without thickness
        match first.len().cmp(&second.len()) {
            std::cmp::Ordering::Greater => kept.push(first[0]),
            std::cmp::Ordering::Less => kept.push(second[0]),
            std::cmp::Ordering::Equal => {}
        }
    }
    kept.sort_unstable();
    body.surface.triangles = merged;
    *body = body.part(&kept);
}

/// Whether the corners are an even permutation of the ascending ones.
fn is_even([a, b, c]: [usize; 3]) -> bool {
    (a < b) ^ (b < c) ^ (a < c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;
    use mesh::{SurfaceMesh, check};

    /// A cube of triangles with corners of their own, each moved by up to `noise`.
    fn soup(noise: f64) -> Patched {
        let cube = Solid::cube(&Vec3::zeros(), &Vec3::repeat(1.0)).to_surface();
        let mut surface = SurfaceMesh::default();
        for t in 0..cube.triangles.len() {
            surface.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
            let shift = Vec3::repeat(noise * (t % 3) as f64 / 4.0);
            surface.vertices.extend(cube.corners(t).map(|p| p + shift));
        }
        Patched { patch: (0..12).collect(), surface }
    }

    #[test]
    fn corners_that_are_close_become_one() {
        let mut body = soup(1e-4);
        let welded = weld(&mut body, 1e-3);
        assert_eq!(welded.open_after, 0);
        assert!(welded.open_before > 0 && welded.vertices > 0, "{welded:?}");
        assert_eq!(body.surface.vertices.len(), 8);
        assert_eq!(body.patch, (0..12).collect::<Vec<u32>>());
        assert_eq!(check::check_surface(&body.surface), vec![]);
        let mut apart = soup(1e-4);
        assert!(weld(&mut apart, 1e-5).open_after > 0);
    }

    #[test]
    fn repeated_triangles_go_and_sheets_without_thickness_too() {
        let mut body = soup(0.0);
        weld(&mut body, 0.0);
        let [a, b, c] = body.surface.triangles[0];
        body.surface.triangles.push([b, c, a]);
        body.surface.triangles.extend([[0, 3, 7], [3, 0, 7], [4, 4, 5]]);
        body.patch.extend([12, 13, 14, 15]);
        let welded = weld(&mut body, 0.0);
        assert_eq!((welded.triangles, body.patch.len()), (4, 12));
    }
}
