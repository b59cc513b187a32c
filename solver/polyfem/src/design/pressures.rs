//! Pressures that may change in a run file.

use anyhow::Result;

use super::{ITERATIONS, Writer, iterations};
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
        let variables = root.get("variable_to_simulation").map(|key| key.items());
        let nonlinear = root.get("solver").and_then(|s| s.get("nonlinear"));
        let limits = nonlinear.and_then(|n| n.get("box_constraints"));
        let mut found = Vec::new();
        for variable in variables.unwrap_or_default() {
            if variable.get("type").is_none_or(|kind| kind.value != "pressure") {
                continue;
            }
            match (self.controlled(&variable)?, &limits) {
                (Some(controlled), Some(_)) => found.push(controlled),
                _ => variable.leave(REASON),
            }
        }
        let Some(limits) = limits.filter(|_| !found.is_empty()) else { return Ok(false) };
        let bounds = limits.need("bounds", "smallest and largest variable")?;
        let bounds = bounds.becomes("[[chamber]] slope").numbers(2)?;
        let change = limits.get("max_change").map(|k| k.becomes("[[chamber]] change").number());
        let change = change.transpose()?;
        if alone {
            let iterations = iterations(root, "[optimizer] iterations")?.unwrap_or(ITERATIONS);
            self.text.table("[optimizer]").key("iterations", &iterations.to_string());
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
        let maps = variable.get("composition").map(|key| key.items()).unwrap_or_default();
        let (mut scale, mut is_slope) = (1.0, false);
        for map in &maps {
            match map.get("type").map(|k| k.becomes("[[chamber]]")).as_ref().map(Key::text) {
                Some(Ok("slice")) => {}
                Some(Ok("scale")) => {
                    let value = map.need("value", "the factor")?.becomes("[[chamber]] slope");
                    scale *= value.number()?;
                }
                Some(Ok("scalar-velocity-parametrization")) => {
                    let start = map.get("start_val").map(|k| k.becomes("zero").number());
                    is_slope = start.transpose()?.unwrap_or(0.0) == 0.0;
                    let _ = map.get("dt").map(|k| k.becomes("[time] of sim.toml"));
                }
                _ => return Ok(None),
            }
        }
        let ids = variable.need("surface_selection", "the walls")?.becomes("[[chamber]] on");
        let on: Vec<String> = ids.ids()?.iter().flat_map(|&id| self.tags(id)).collect();
        let _ = variable.get("type").map(|k| k.becomes("[[chamber]]"));
        let _ = variable.get("composite_map_type").map(|k| k.becomes("[[chamber]]"));
        Ok((is_slope && !on.is_empty()).then_some(Controlled { on, scale }))
    }
}
