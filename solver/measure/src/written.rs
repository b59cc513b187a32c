//! Values of scenes as people write them: names, and the schemas of what [`mechanics`] reads.
//!
//! `mechanics` knows no schema language. The types called `…Schema` stand in for its types where
//! a table is described; `#[schemars(with = "…")]` names them.

use std::borrow::Cow;
use std::collections::BTreeMap;

use mechanics::contact::barrier::Form;
use mechanics::contact::density::Density;
use mechanics::forward::Method;
use mechanics::schedule::{Malformed, Schedule, Written, axes};
use program::{KeyPath, Misfit, did_you_mean, misfit};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;

/// The rule of axes.
pub fn some_axes(at: &KeyPath, components: &String) -> Result<(), Misfit> {
    let count = axes(components).iter().filter(|axis| **axis).count();
    match components.len() == count && count > 0 {
        true => Ok(()),
        false => {
            Err(misfit!(at.clone(), " = \"{components}\": must be some of x, y, z, each once"))
        }
    }
}

/// What is wrong with an expression, with what may have been meant by a name that nobody knows.
pub fn proposed(error: &Malformed) -> String {
    let near = error.unknown().map(|u| did_you_mean(&u.name, u.known.iter().map(|k| &k[..])));
    format!("{error}{}", near.unwrap_or_default())
}

/// The values of what is wanted, which has no parameters, by its key.
pub fn values(key: &str, written: &Written) -> Result<Schedule, Misfit> {
    let schedule = written.schedule(&BTreeMap::new(), 1.0);
    schedule.map_err(|what| misfit!(KeyPath::of(key), ": {}", proposed(&what)))
}

/// Schema of [`Written`].
pub struct ScheduleSchema;

impl JsonSchema for ScheduleSchema {
    fn schema_name() -> Cow<'static, str> {
        "Schedule".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "title": "number, expression or table over time",
            "anyOf": [
                { "type": "number" },
                { "type": "string", "description": "An expression, as in \"20e3*t\"." },
                Columns::json_schema(generator),
            ],
        })
    }
}

/// Columns of a table with increasing times.
#[derive(JsonSchema)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "described, never built")]
struct Columns {
    t: Vec<f64>,
    value: Vec<f64>,
}

/// Three schedules: a vector that may change with time and position; the schema of
/// [`mechanics::schedule::WrittenField`].
#[derive(JsonSchema)]
#[serde(transparent)]
pub struct FieldSchema(pub [ScheduleSchema; 3]);

/// Time integration of a body.
#[derive(Serialize, JsonSchema)]
#[serde(remote = "Method", rename_all = "kebab-case")]
pub enum MethodSchema {
    /// Inertia is neglected: an equilibrium at every time.
    Quasistatic,
    /// First order; damps what the step does not resolve.
    ImplicitEuler,
    /// Second order.
    Bdf2,
    /// Third order, for imported scenes: some oscillations grow, which is warned of.
    Bdf3,
    /// Implicit Newmark of average acceleration: second order, damps nothing.
    Newmark,
    /// Generalized-α: second order, damps what the step does not resolve, and little else.
    GeneralizedAlpha,
}

/// How pairs are weighted.
#[derive(Serialize, JsonSchema)]
#[serde(remote = "Form", rename_all = "kebab-case")]
pub enum FormSchema {
    /// By areas, so that the potential is that of a surface and converges as
    /// meshes are refined.
    Convergent,
    /// By areas as well, but nearly all of it by vertices and triangles, so that it
    /// does not depend on how meshes lie on each other: between flat surfaces each
    /// edge meets several others, of which the convergent form counts all.
    Even,
    /// Every pair alike, so that it grows with the number of facets.
    Plain,
}

/// A function of a squared distance that is zero from the activation distance on.
#[derive(Serialize, JsonSchema)]
#[serde(remote = "Density", rename_all = "kebab-case")]
pub enum DensitySchema {
    /// A log barrier, infinite where surfaces touch or come closer than they may.
    Log,
    /// A log barrier that is smoother and weaker where it begins.
    LogSquared,
    /// (d² − d̂²)².
    Quadratic,
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Serialize, Deserialize)]
    struct Scene {
        pressure: Written,
    }

    fn read(text: &str) -> Result<Written, String> {
        let scene: Result<Scene, _> = toml::from_str(&format!("pressure = {text}"));
        scene.map(|s| s.pressure).map_err(|e| e.to_string())
    }

    #[test]
    fn slips_name_line_expression_and_place() {
        for (text, words) in [
            ("\"20e3*(t\"", &["line 1", "\"20e3*(t\"", "')' is needed", "character 8"][..]),
            ("true", &["line 1", "a number, an expression", "a table"]),
            ("[1, 2]", &["a number, an expression"]),
            ("{ t = [0, 1], value = [1] }", &["line 1", "2 times and 1 value"]),
            ("{ t = [0, 0], value = [1, 2] }", &["must increase", "0, 0"]),
            ("{ t = [0], value = [1] }", &["two or more"]),
            ("{ t = [0, 1], value = [1, nan] }", &["NaN"]),
            ("{ t = [0, 1], values = [1, 2] }", &["unknown field `values`"]),
        ] {
            let message = read(text).expect_err(text);
            assert!(words.iter().all(|w| message.contains(w)), "{text}: {message}");
        }
    }

    #[test]
    fn what_is_written_is_what_was_read() {
        for text in ["8.5", "\"20e3*t\"", "{ t = [0.0, 1.0], value = [2.0, 3.0] }"] {
            let scene = Scene { pressure: read(text).expect(text) };
            let again = toml::to_string(&scene).expect("a table");
            let again: Scene = toml::from_str(&again).expect("what was written");
            assert_eq!(again.pressure, scene.pressure);
        }
    }
}
