//! Patches of meshes apart at sharp edges, so that faces of a body can be picked.

use anyhow::{Result, ensure};
use mesh::topology::{DisjointSets, edge_facets};

use super::{Patched, Patches};

/// More pieces hint at an angle below that between the triangles of a curved face.
const MOST: usize = 300;

/// Parts every patch at edges where its triangles enclose more than `angle` [deg]; the pieces have
/// the name of the patch and a number, the largest first.
pub fn split(mut body: Patched, angle: f64, patches: &mut Patches) -> Result<Patched> {
    let pieces = pieces(&body, angle);
    let count = pieces.len();
    ensure!(
        count <= MOST,
        "--split {angle} makes {count} patches, {MOST} at most are useful: give a larger angle"
    );
    let area_of = |piece: &Vec<usize>| piece.iter().map(|&t| body.surface.area(t)).sum();
    let area: Vec<f64> = pieces.iter().map(area_of).collect();
    let patch_of: Vec<u32> = pieces.iter().map(|piece| body.patch[piece[0]]).collect();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| patch_of[a].cmp(&patch_of[b]).then(area[b].total_cmp(&area[a])));
    for same in order.chunk_by(|&a, &b| patch_of[a] == patch_of[b]).filter(|same| same.len() > 1) {
        let name = patches.name(patch_of[same[0]]).to_owned();
        for (number, &p) in (1..).zip(same) {
            let renamed = patches.index(&format!("{name}-{number}"));
            pieces[p].iter().for_each(|&t| body.patch[t] = renamed);
        }
    }
    Ok(body)
}

/// The triangles of each piece.
fn pieces(body: &Patched, angle: f64) -> Vec<Vec<usize>> {
    let triangles = &body.surface.triangles;
    let normal: Vec<_> = (0..triangles.len()).map(|t| body.surface.normal(t)).collect();
    let flattest = angle.to_radians().cos();
    let is_smooth = |s: usize, t: usize| normal[s].dot(&normal[t]) >= flattest;
    across_edges(triangles, |s, t| body.patch[s] == body.patch[t] && is_smooth(s, t))
}

/// Triangles that hang together by edges of two triangles that `joins` takes.
pub fn across_edges(
    triangles: &[[usize; 3]],
    joins: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut pieces = DisjointSets::new(triangles.len());
    for beside in edge_facets(triangles).into_values() {
        if let [s, t] = beside[..]
            && joins(s, t)
        {
            pieces.join(s, t);
        }
    }
    pieces.groups()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use mesh::Vec3;
    use mesh::solid::Solid;

    #[test]
    fn a_cylinder_has_a_side_and_two_ends() {
        let surface = Solid::cylinder(&Vec3::zeros(), &Vec3::z(), 1.0, 1.0, 64).to_surface();
        let mut patches = Patches::default();
        let patch = vec![patches.index("outer"); surface.triangles.len()];
        let body = Patched { surface, patch };
        let parted = split(body, 40.0, &mut patches).unwrap();
        let mut count = [0; 4];
        parted.patch.iter().for_each(|&p| count[p as usize] += 1);
        assert_eq!(count, [0, 128, 62, 62]); // outer, outer-1: the side, and the ends
        assert_eq!(patches.name(1), "outer-1");
        let surface = Solid::cylinder(&Vec3::zeros(), &Vec3::z(), 1.0, 1.0, 400).to_surface();
        let patch = vec![patches.index("round"); surface.triangles.len()];
        let error = split(Patched { surface, patch }, 0.5, &mut patches).unwrap_err().to_string();
        assert!(error.contains("makes 402 patches"), "{error}");
    }
}
