//! Two sides in place of an upper shell that cannot be demolded.
//!
//! A shell that is demolded upward is held by undercuts: places where the body is narrower
//! below. If the shell is split by a plane that contains `up`, its halves are demolded
//! sideways, where only undercuts along that direction hold them. The shell below the joint
//! becomes their base.

use geometry::undercut::{PartingHeight, View};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

use super::pull::{self, Choice};

/// How sides above the height `joint` along `up` [m] separate. None if their undercuts, or
/// those of the base below the joint, exceed `limit` of the widths of the silicone.
pub fn instead(filled: &SurfaceMesh, up: &Vec3, joint: f64, limit: f64) -> Option<Choice> {
    let (above, below) = Solid::from_surface(filled).ok()?.split_by_plane(up, joint);
    if above.is_empty() || (!below.is_empty() && locks(&below.to_surface(), up, joint, limit)) {
        return None;
    }
    Some(pull::sideways(&above.to_surface(), up)).filter(|choice| choice.ratio() <= limit)
}

/// Whether undercuts below a joint hold the shell that is demolded downward.
fn locks(below: &SurfaceMesh, up: &Vec3, joint: f64, limit: f64) -> bool {
    let view = View::along(below, up);
    let undercut = view.undercut(PartingHeight::Plane(joint));
    view.worst(&undercut).is_some_and(|worst| worst.ratio > limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(radius: f64, low: f64, high: f64) -> Solid {
        let base = Vec3::z() * low;
        Solid::cylinder(&base, &(Vec3::z() * (high - low)), radius, radius, 96)
    }

    #[test]
    fn pockets_on_all_sides_hold_every_shell() {
        // Holes along x and along y, each deeper than the silicone gives way, lock both ways.
        let hole = |axis: Vec3| Solid::cylinder(&(Vec3::z() * 10.0), &axis, 2.0, 2.0, 48);
        let pocket = |axis: Vec3| hole(axis * 7.0).union(&hole(axis * -7.0));
        let block = Solid::cube(&Vec3::new(-10.0, -10.0, 0.0), &Vec3::new(10.0, 10.0, 20.0));
        let hollow = disc(8.0, 4.0, 16.0);
        let open = block.difference(&hollow).difference(&disc(2.0, 15.0, 25.0));
        let open = open.difference(&pocket(Vec3::x() * 2.0)).difference(&pocket(Vec3::y() * 2.0));
        assert!(instead(&open.to_surface(), &Vec3::z(), 1.0, 0.1).is_none());
    }
}
