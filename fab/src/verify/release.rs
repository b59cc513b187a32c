//! Every core can be demolded from the body.
//!
//! When a core is pulled out, the inlet is stretched over it. The girth of the inlet is that of
//! the core just inside of it, and the largest girth of the core across the pull has to pass.
//! This also holds for every neck of the chamber and for what lies behind it. Soluble cores can always be removed.

use geometry::girth::{self, Passage};
use mesh::Vec3;
use mesh::solid::Solid;

use super::Line;
use super::closed_mold::{Body, ClosedMold};
use crate::plan::report::PlanReport;

/// Where the girth of an inlet is measured, above the lowest point of the body: above its
/// uneven rim, within the 1 mm that any wall is thick at least [mm].
const INSIDE: [f64; 2] = [0.1, 0.3];

/// Part of the elongation at break to which the inlet may be stretched: a judgement, from
/// the scatter of elongations at break and the notch that a cut inlet is.
const SAFE: f64 = 0.5;

/// The check of every core, with the method of the plan if there is one.
pub fn checks(mold: &ClosedMold, plan: Option<&PlanReport>) -> Vec<Line> {
    mold.cores.iter().map(|core| passes(mold, core, plan)).collect()
}

fn passes(mold: &ClosedMold, core: &Body, plan: Option<&PlanReport>) -> Line {
    let name = format!("{}: demolds", core.name);
    let up = -core.demolding;
    let seat = mold.cast.solid.bounds().0.dot(&up).min(mold.cast.solid.bounds().1.dot(&up));
    let inside = core.solid.trim_by_plane(&up, seat + INSIDE[0]);
    let Some(inlet) = inlet(&inside, &up, seat) else {
        return Line::new(name, false, "the core does not reach the inlet".into(), "an inlet");
    };
    let inside = inside.to_surface();
    let ratio = girth::largest(&inside, &up).length / inlet;
    let Passage { neck, through } = girth::tightest(&inside, &-up, INSIDE[1] - INSIDE[0]);
    let (ratio, found) = match through.length / neck.length {
        tighter if tighter > ratio => {
            (tighter, format!("{tighter:.2} × a neck's girth of {:.1} mm", neck.length))
        }
        _ => (ratio, format!("{ratio:.2} × the inlet's girth of {inlet:.1} mm")),
    };
    match plan.map(|plan| plan.method) {
        Some(method) if method.core.dissolves() => {
            Line::new(name, true, found, &format!("any, the core is {}", method.name()))
        }
        _ => stretched(mold, name, ratio, found),
    }
}

/// The girth of a core where its inlet is measured, of the part of it that lies above that; none if it is not
/// there. It is cut by a plane: a difference of parts with the same walls may leave films along these.
fn inlet(inside: &Solid, up: &Vec3, seat: f64) -> Option<f64> {
    let mouth = inside.trim_by_plane(&-up, -(seat + INSIDE[1])).to_surface();
    (!mouth.triangles.is_empty()).then(|| girth::largest(&mouth, up).length)
}

/// Whether silicone can be stretched so far; a warning if it is not known which.
fn stretched(mold: &ClosedMold, name: String, ratio: f64, found: String) -> Line {
    let Some(elongation) = mold.report.casting.elongation() else {
        let needed = "little; name a silicone whose elongation at break is known";
        return Line::new(name, ratio <= 1.0 + 1e-3, found, needed).or_warning();
    };
    let limit = 1.0 + SAFE * elongation / 100.0;
    let needed = format!("at most {limit:.2}, half the elongation at break");
    Line::new(name, ratio <= limit, found, &needed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a cylinder of 120 mm that stands askew about its axis, as a core of an imported STL does.
    #[test]
    fn the_girth_of_an_inlet_is_that_of_its_core() {
        let cylinder = Solid::cylinder(&-Vec3::z(), &(121.0 * Vec3::z()), 8.5, 8.5, 72);
        let (sine, cosine) = 15_f64.to_radians().sin_cos();
        let core = cylinder.trim_by_plane(&Vec3::new(sine, cosine, 0.0), 2.5);
        // with a bore, as files round it
        let bore = Solid::cylinder(&Vec3::new(1.5, 5.0, -2.0), &(60.0 * Vec3::z()), 0.6, 0.6, 24);
        let mut surface = core.difference(&bore).to_surface();
        let rounded = |x: f64| f64::from(x as f32);
        surface.vertices.iter_mut().for_each(|p| *p = p.map(rounded));
        let core = Solid::from_surface(&surface).expect("it is closed");
        let inside = core.trim_by_plane(&Vec3::z(), INSIDE[0]);
        // arc and chord of the section, of 72 sides
        let half = (2.5_f64 / 8.5).acos();
        let outline = 2.0 * 8.5 * (half + half.sin()) + std::f64::consts::TAU * 0.6;
        let found = inlet(&inside, &Vec3::z(), 0.0).expect("it is there");
        assert!((found / outline - 1.0).abs() < 2e-3, "{found} mm, {outline} mm");
        assert!(inlet(&core.trim_by_plane(&Vec3::z(), 1.0), &Vec3::z(), 0.0).is_none());
    }
}
