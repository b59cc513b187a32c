//! Pressures that may change in a run file.

use anyhow::Result;

use super::{Writer, iterations};
use crate::document::Key;
use crate::text::{list, number, quoted};

/// Why pressures are left.
const REASON: &str = "a pressure changes by slopes within bounds, one for each time step, in a \
     table [[chamber]] here";

/// A pressure that changes.
struct Controlled {
    on: Vec<String>,
    /// Pressure per time of a variable, in the sense of the file [Pa/s].
    scale: f64,
}

impl Writer<'_> {
    /// Writes the pressures that may change; false if there is none. `alone` if no
    /// shape changes.
    pub(super) fn pressures(&mut self, root: &Key, alone: bool) -> Result<bool> {
        let nonlinear = root.get("solver").and_then(|s| s.get("nonlinear"));
        let limits = nonlinear.and_then(|n| n.get("box_constraints"));
        let mut found = Vec::new();
        for variable in root.items_of("variable_to_simulation") {
            if variable.get("type").is_none_or(|kind| kind.value != "pressure") {
                continue;
            }
            match (self.controlled(&variable)?, &limits) {
                (Some(controlled), Some(_)) => found.push(controlled),
                _ => variable.leave(REASON),
            }
        }
        let Some(limits) = limits.filter(|_| !found.is_empty()) else { return Ok(false) };
        let bounds = limits.need("bounds", "smallest and largest variable")?.numbers(2)?;
        let change = limits.optional("max_change", Key::number)?;
        if alone {
            let iterations = iterations(root)?.to_string();
            self.text.table("[optimizer]").key("iterations", &iterations);
        }
        for Controlled { on, scale } in found {
            // pressures there are minus ours
            let mut slope = [-scale * bounds[0], -scale * bounds[1]];
            slope.sort_by(f64::total_cmp);
            for on in on {
                self.text.table("[[chamber]]").key("on", &quoted(&on));
                self.text.key("slope", &list(slope.map(number)));
                if let Some(change) = change {
                    self.text.number("change", (scale * change).abs());
                }
            }
        }
        Ok(true)
    }

    /// The walls of a pressure whose variables are its slopes, if that is so.
    fn controlled(&self, variable: &Key) -> Result<Option<Controlled>> {
        let (mut scale, mut is_slope) = (1.0, false);
        for map in variable.items_of("composition") {
            match map.get("type").as_ref().map(Key::text) {
                Some(Ok("slice")) => {}
                Some(Ok("scale")) => scale *= map.need("value", "the factor")?.number()?,
                Some(Ok("scalar-velocity-parametrization")) => {
                    is_slope = map.optional("start_val", Key::number)?.unwrap_or(0.0) == 0.0;
                    // that of the scene
                    let _ = map.get("dt");
                }
                _ => return Ok(None),
            }
        }
        let ids = variable.need("surface_selection", "the walls")?.ids()?;
        let on = self.scene.geometry.tags(&ids);
        Ok((is_slope && !on.is_empty()).then_some(Controlled { on, scale }))
    }
}
