//! `[fitting]`: the tube that is put into the inlet, and the collar that holds it.

use library::tubes;
use program::schema::one_of_these;
use program::table;
use program::table::{Range, nested};
use program::{KeyPath, Misfit};
use schemars::{Schema, SchemaGenerator};

table! {
    /// A tube and its collar.
    #[derive(Clone, Debug)]
    pub struct FittingConfig {
        /// A tube of `cad2fem/library/tubes.toml`, for which a collar is cast around each inlet.
        #[schemars(schema_with = "tube_names")]
        name: Option<String> = None => "none: no collar";
        /// Outer diameter of the tube, instead of its name [m].
        outer: Option<f64> = None => "that of the named tube";
        /// Inner diameter of the tube, instead of its name [m].
        inner: Option<f64> = None => "that of the named tube";
        /// How much narrower the bore is than the tube, over the tube's diameter: a judgement [1].
        interference: f64 = 0.1, Range::between(0.0, 0.4).advice(": a part of the diameter, not percent");
        /// How far the collar stands out of the body [m].
        length: Option<f64> = None => "twice the outer diameter", SIZE;
        /// Thickness of the collar around the bore; more where the rim of the inlet needs it, by
        /// `casting.least_wall` [m].
        wall: f64 = 2e-3, SIZE;
    }
}

fn tube_names(_: &mut SchemaGenerator) -> Schema {
    one_of_these(tubes().iter().map(|(key, _)| key))
}

/// A size of a collar.
const SIZE: Range = Range::above(0.0).below(0.1).unit("m");

/// The tube that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Tube {
    /// What to ask for.
    pub name: String,
    /// Outer diameter [m].
    pub outer: f64,
    /// Inner diameter [m].
    pub inner: f64,
    /// Where its sizes come from.
    pub source: String,
}

impl FittingConfig {
    /// The tube, named or given by its diameters.
    pub fn tube(&self) -> Result<Tube, String> {
        match (&self.name, self.outer, self.inner) {
            (Some(key), None, None) => {
                let found = tubes().find(key).map_err(|message| {
                    format!("fitting.name: {message}; or give outer and inner instead")
                })?;
                Ok(Tube {
                    name: found.name.clone(),
                    outer: found.outer * 1e-3,
                    inner: found.inner * 1e-3,
                    source: found.citation().into(),
                })
            }
            (None, Some(outer), Some(inner)) => {
                if !(0.0 < inner && inner < outer && outer < 0.05) {
                    return Err(format!(
                        "fitting.inner and fitting.outer are {inner} and {outer}, must be diameters above 0 and \
                         below 0.05 m, the inner one smaller"
                    ));
                }
                let name = format!("tube of {:.2} mm, {:.2} mm inside", outer * 1e3, inner * 1e3);
                Ok(Tube { name, outer, inner, source: "mold.toml".into() })
            }
            _ => Err("[fitting] needs either name, or outer and inner".into()),
        }
    }

    /// Radius of the bore in the silicone [m].
    pub fn bore(&self, tube: &Tube) -> f64 {
        tube.outer / 2.0 * (1.0 - self.interference)
    }

    /// How far the collar stands out of the body [m].
    pub fn length(&self, tube: &Tube) -> f64 {
        self.length.unwrap_or(2.0 * tube.outer)
    }

    /// Whether the tube is known and the numbers can be.
    pub fn check(at: &KeyPath, fitting: &Option<Self>) -> Result<(), Misfit> {
        let Some(fitting) = fitting else { return Ok(()) };
        nested(at, fitting)?;
        fitting.tube().map(drop).map_err(|what| KeyPath::table("fitting").told(what))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::config::Config;

    #[test]
    fn a_tube_is_named_or_given() {
        let parse = |text: &str| Config::parse(&format!("[fitting]\n{text}"));
        let named = parse("name = \"tube-4x2.5\"").unwrap().fitting.unwrap();
        let tube = named.tube().unwrap();
        assert_eq!([tube.outer, tube.inner], [4e-3, 2.5e-3]);
        assert!((named.bore(&tube) - 1.8e-3).abs() < 1e-15);
        assert_eq!(named.length(&tube), 8e-3);
        parse("outer = 5e-3\ninner = 3e-3").unwrap();
        assert!(Config::parse("").unwrap().fitting.is_none());
        for (text, message) in [
            ("", "needs either name"),
            ("name = \"hose\"", "known are barb-eighth-inch"),
            ("outer = 3e-3\ninner = 5e-3", "the inner one smaller"),
            ("name = \"tube-6x4\"\nouter = 6e-3", "needs either name"),
            ("name = \"tube-6x4\"\ninterference = 10", "[fitting]: interference = 10"),
            ("name = \"tube-6x4\"\nwall = 2", "[fitting]: wall = 2 m"),
        ] {
            let found = format!("{:#}", parse(text).unwrap_err());
            assert!(found.contains(message), "{found}");
        }
    }
}
