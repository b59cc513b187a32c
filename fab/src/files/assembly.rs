//! The mold put together from what is printed, closed and taken apart.

use geometry::extent;
use geometry::frame::moved;
use mesh::{SurfaceMesh, Vec3};
use nalgebra::Matrix3;

use crate::files::report::MoldReport;

/// Room between parts that are taken apart, as a share of the mold's diagonal.
const GAP: f64 = 0.06;

/// A body of the assembly in the closed mold's coordinates [mm].
#[derive(Clone, Debug)]
pub struct Member {
    /// The name.
    pub name: String,
    /// The surface in the closed mold [mm].
    pub surface: SurfaceMesh,
    /// How far it is moved in the exploded view [mm].
    pub apart: Vec3,
    /// Whether it is printed; otherwise it is what is cast.
    pub printed: bool,
}

/// All parts in the order of the report, then the cast. `surfaces` are those of the
/// files: the parts as they are printed, and the cast.
pub fn assembly(report: &MoldReport, surfaces: &[SurfaceMesh]) -> Vec<Member> {
    let parts = report.parts.iter().map(|part| (part.name.as_str(), part.turn(), true));
    let all = parts.chain([("cast", Matrix3::identity(), false)]).zip(surfaces);
    let member = |((name, turn, printed), surface): ((&str, Matrix3<f64>, bool), &SurfaceMesh)| {
        let surface = moved(surface, |p| turn * p);
        Member { name: name.into(), surface, apart: Vec3::zeros(), printed }
    };
    let mut members: Vec<Member> = all.map(member).collect();
    let demolding: Vec<Vec3> = report.parts.iter().map(|p| Vec3::from(p.demolding)).collect();
    take_apart(&mut members, &demolding);
    members
}

/// Moves every part along the direction in which it is demolded, beyond the cast and
/// beyond the parts that leave the same way, lie further in, and are in its way: cores beside each other
/// stay side by side.
fn take_apart(members: &mut [Member], demolding: &[Vec3]) {
    let Some((cast, parts)) = members.split_last_mut() else { return };
    let points = parts.iter().flat_map(|part| &part.surface.vertices);
    let gap = GAP * mesh::measure::diagonal(&points.copied().collect::<Vec<_>>());
    let mut waiting: Vec<usize> = (0..parts.len()).collect();
    while let Some(&first) = waiting.first() {
        let direction = demolding[first];
        let same = |&part: &usize| demolding[part].dot(&direction) > 1.0 - 1e-9;
        let mut column: Vec<(f64, usize)> = waiting
            .iter()
            .copied()
            .filter(same)
            .map(|part| (extent(&parts[part].surface.vertices, &direction)[1], part))
            .collect();
        waiting.retain(|part| !same(part));
        // The one that ends first lies innermost.
        column.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let [_, beyond] = extent(&cast.surface.vertices, &direction);
        let mut placed: Vec<(usize, f64)> = Vec::new();
        for (end, part) in column {
            let [start, _] = extent(&parts[part].surface.vertices, &direction);
            let meets = |other: &usize| {
                meet_along(&parts[part].surface, &parts[*other].surface, &direction)
            };
            let ahead = placed.iter().filter(|(other, _)| meets(other)).map(|(_, end)| *end);
            let front = ahead.fold(beyond, f64::max);
            let way = (front + gap - start).max(0.0);
            parts[part].apart = direction * way;
            placed.push((part, end + way));
        }
    }
}

/// Whether the bounds of two surfaces overlap as seen along an axis.
fn meet_along(a: &SurfaceMesh, b: &SurfaceMesh, direction: &Vec3) -> bool {
    let [a, b] = [a, b].map(|surface| mesh::measure::bounds(&surface.vertices));
    let across = (0..3).filter(|&k| direction[k].abs() < 0.5);
    across.into_iter().all(|k| a.0[k] < b.1[k] && b.0[k] < a.1[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;

    fn member(low: [f64; 3], high: [f64; 3], printed: bool) -> Member {
        let surface = Solid::cube(&Vec3::from(low), &Vec3::from(high)).to_surface();
        Member { name: String::new(), surface, apart: Vec3::zeros(), printed }
    }

    #[test]
    fn nothing_overlaps_when_taken_apart() {
        // Left, right and base around a cast that holds a core.
        let mut members = [
            member([-5.0, 0.0, 0.0], [5.0, 5.0, 9.0], true),
            member([-5.0, -5.0, 0.0], [5.0, 0.0, 9.0], true),
            member([-5.0, -5.0, -3.0], [5.0, 5.0, 0.0], true),
            member([-1.0, -1.0, -2.5], [1.0, 1.0, 6.0], true),
            member([-2.0, -2.0, 0.0], [2.0, 2.0, 8.0], false),
        ];
        let demolding = [Vec3::y(), -Vec3::y(), -Vec3::z(), -Vec3::z()];
        take_apart(&mut members, &demolding);
        let bounds = members.each_ref().map(|m| {
            let (low, high) = mesh::measure::bounds(&m.surface.vertices);
            (low + m.apart, high + m.apart)
        });
        for (i, a) in bounds.iter().enumerate() {
            for b in &bounds[i + 1..] {
                let apart = (0..3).any(|k| a.1[k] < b.0[k] || b.1[k] < a.0[k]);
                assert!(apart, "{a:?} {b:?}");
            }
        }
        assert_eq!(members[4].apart, Vec3::zeros());
        // The base is below the core that stood in it.
        assert!(members[2].apart.z < members[3].apart.z);
    }
}
