//! Every core can be demolded from the body.
//!
//! When a core is pulled out, the inlet is stretched over it. The girth of the inlet is that of
//! the core just inside of it, and the largest girth of the core across the pull has to pass.
//! The same holds for every neck of the chamber and for what lies behind it. Soluble and molten
//! cores can always be removed.

use library::silicones;

use super::closed_mold::{Body, ClosedMold};
use super::{Line, Status};
use crate::config::method::Method;
use crate::geometry::girth::{self, Passage};
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
    let above = |height: f64| core.solid.trim_by_plane(&up, seat + height);
    let mouth = above(INSIDE[0]).difference(&above(INSIDE[1])).to_surface();
    let inside = above(INSIDE[0]).to_surface();
    if mouth.triangles.is_empty() {
        return Line::new(name, false, "the core does not reach the inlet".into(), "an inlet");
    }
    let inlet = girth::largest(&mouth, &up).length;
    let ratio = girth::largest(&inside, &up).length / inlet;
    let Passage { neck, through } = girth::tightest(&inside, &-up, INSIDE[1] - INSIDE[0]);
    let (ratio, found) = match through.length / neck.length {
        tighter if tighter > ratio => {
            (tighter, format!("{tighter:.2} × a neck's girth of {:.1} mm", neck.length))
        }
        _ => (ratio, format!("{ratio:.2} × the inlet's girth of {inlet:.1} mm")),
    };
    match plan.map(|plan| plan.method) {
        Some(method @ (Method::Soluble | Method::Wax)) => {
            Line::new(name, true, found, &format!("any, the core is {}", method.name()))
        }
        _ => stretched(mold, name, ratio, found),
    }
}

/// Whether silicone can be stretched so far; a warning if it is not known which.
fn stretched(mold: &ClosedMold, name: String, ratio: f64, found: String) -> Line {
    let key = mold.report.casting.silicone.as_deref();
    let facts = key.and_then(|k| silicones().find(k).ok()).and_then(|s| s.casting.as_ref());
    match facts.and_then(|facts| facts.elongation) {
        Some(elongation) => {
            let limit = 1.0 + SAFE * elongation / 100.0;
            Line::new(
                name,
                ratio <= limit,
                found,
                &format!("at most {limit:.2}, half the elongation at break"),
            )
        }
        None => {
            let needed = "little; name a silicone whose elongation at break is known";
            let mut line = Line::new(name, true, found, needed);
            if ratio > 1.0 + 1e-3 {
                line.status = Status::Warn;
            }
            line
        }
    }
}
