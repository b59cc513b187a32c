//! The threads of a state: their file, and where they cross each other.

use std::path::Path;

use anyhow::Result;
use mechanics::energy::{Energies, Iterate, Strand, Winding};
use mesh::Vec3;
use mesh::bvh::overlapping_pairs;
use reports::{SegmentEnd, WINDINGS};
use scene::Scene;

use super::table;

/// Sine of the angle below which segments have one direction.
const PARALLEL: f64 = 1e-9;
/// Distance of two lines that meet, over the length of the segments, at most.
const MEET: f64 = 1e-6;

/// A segment at rest [m].
type Segment = [Vec3; 2];

/// Writes the threads of a state to a folder, if there are any.
pub fn write(folder: &Path, scene: &Scene, energies: &Energies, at: &Iterate) -> Result<()> {
    if scene.config.winding.is_empty() {
        return Ok(());
    }
    let mut rows = vec![reports::Segment::head()];
    for (winding, thread) in scene.config.winding.iter().zip(energies.each::<Winding>()) {
        rows.extend(thread.strands(at).iter().map(|strand| written(&winding.name, strand).row()));
    }
    table::write(&folder.join(WINDINGS), rows)
}

fn written(winding: &str, strand: &Strand) -> reports::Segment {
    let end = |k: usize| SegmentEnd {
        rest: strand.rest[k].into(),
        now: (strand.rest[k] + strand.moved[k]).into(),
        weights: strand.weights[k],
    };
    reports::Segment {
        winding: winding.to_owned(),
        ends: [end(0), end(1)],
        force: strand.force,
        vertices: strand.vertices,
    }
}

/// Which threads cross, and how often.
pub fn crossings(scene: &Scene, energies: &Energies, at: &Iterate) -> Vec<String> {
    let rest = |winding: &Winding| -> Vec<Segment> {
        winding.strands(at).into_iter().map(|strand| strand.rest).collect()
    };
    let all: Vec<Vec<Segment>> = energies.each().map(rest).collect();
    let name = |i: usize| &scene.config.winding[i].name;
    let free = "where they do not touch: neither holds the other";
    let mut found = Vec::new();
    for (i, one) in all.iter().enumerate() {
        // the next segment begins where one ends
        let own = count(one, one, |a, b| a + 1 < b);
        if own > 0 {
            found.push(format!("winding {} crosses itself at {}, {free}", name(i), points(own)));
        }
        for (j, other) in all.iter().enumerate().skip(i + 1) {
            let both = count(one, other, |_, _| true);
            if both > 0 {
                let (a, b) = (name(i), name(j));
                found.push(format!("windings {a} and {b} cross at {}, {free}", points(both)));
            }
        }
    }
    found
}

fn points(count: usize) -> String {
    format!("{count} point{}", if count == 1 { "" } else { "s" })
}

/// Pairs of segments that cross, of those that are wanted.
fn count(a: &[Segment], b: &[Segment], wanted: fn(usize, usize) -> bool) -> usize {
    let boxes = |all: &[Segment]| -> Vec<(Vec3, Vec3)> {
        all.iter().map(|[p, q]| (p.inf(q), p.sup(q))).collect()
    };
    let near = overlapping_pairs(&boxes(a), &boxes(b)).into_iter();
    near.filter(|&(i, j)| wanted(i, j) && cross(&a[i], &b[j])).count()
}

/// Whether two segments have a point in common; their last points do not count, as the next segments begin there.
fn cross([p, p_end]: &Segment, [q, q_end]: &Segment) -> bool {
    let (r, s, from) = (p_end - p, q_end - q, q - p);
    let normal = r.cross(&s);
    let (area, longest) = (normal.norm(), r.norm().max(s.norm()));
    if area <= PARALLEL * r.norm() * s.norm() {
        return false;
    }
    let apart = from.dot(&normal).abs() / area;
    let parts = [from.cross(&s).dot(&normal), from.cross(&r).dot(&normal)];
    apart <= MEET * longest && parts.iter().all(|part| (0.0..1.0).contains(&(part / area / area)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(p: [f64; 3], q: [f64; 3]) -> Segment {
        [p.into(), q.into()]
    }

    #[test]
    fn segments_cross_once() {
        let one = segment([0.0, 0.0, 1.0], [2.0, 0.0, 1.0]);
        let other = segment([1.0, -1.0, 1.0], [1.5, 1.0, 1.0]);
        assert!(cross(&one, &other) && cross(&other, &one));
        // above it, beside it, along it
        assert!(!cross(&one, &segment([1.0, -1.0, 1.1], [1.5, 1.0, 1.1])));
        assert!(!cross(&one, &segment([3.0, -1.0, 1.0], [3.5, 1.0, 1.0])));
        assert!(!cross(&one, &segment([1.0, 0.0, 1.0], [3.0, 0.0, 1.0])));
        // a chain has its corners once, and does not cross itself there
        let chain = [one, segment([2.0, 0.0, 1.0], [2.0, 2.0, 1.0])];
        let through = [segment([1.0, -1.0, 1.0], [3.0, 1.0, 1.0])];
        assert_eq!(count(&chain, &through, |_, _| true), 1);
        assert_eq!(count(&chain, &chain, |a, b| a + 1 < b), 0);
    }
}
