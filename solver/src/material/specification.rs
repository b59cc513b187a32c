//! A law with its parameters and where they may be trusted, as a `[material]`
//! table says it.

use anyhow::{Context, Result, bail, ensure};
use program::schema::add_keys;
use schemars::Schema;
use serde_json::json;
use toml::Value;

use super::{LAWS, Law, Material, Moduli};

/// A material of a scene.
#[derive(Clone)]
pub struct Specification {
    /// The law.
    pub law: &'static Law,
    /// Its parameters.
    pub values: Vec<f64>,
    /// Density [kg/m³], if known.
    pub density: Option<f64>,
    /// Smallest and largest principal stretch that the parameters were fitted
    /// to and are stable in [1], if known.
    pub stretch_range: Option<[f64; 2]>,
    /// Uniaxial stretch at which it tears [1], if known: 1 + elongation at break.
    pub stretch_at_break: Option<f64>,
    /// How much softer it may be than its law, as far as it is known.
    pub softening: Softening,
}

/// What silicone does besides: how much softer than its law it may be. The law is that of a first
/// stretch, soon after the load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Softening {
    /// Part by which strain grows while a load is held [1]: stiffness falls to 1/(1 + creep).
    pub creep: Option<f64>,
    /// Part by which stress falls once it has been stretched before (Mullins effect) [1].
    pub mullins: Option<f64>,
}

impl Softening {
    /// The changes of all stresses that may be, as parts of them, by name: negative ones.
    pub fn changes(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let creep = self.creep.map(|creep| ("creep", 1.0 / (1.0 + creep) - 1.0));
        creep.into_iter().chain(self.mullins.map(|mullins| ("mullins", -mullins)))
    }
}

impl Specification {
    /// From a table with `kind`, the parameters of the law, and optionally
    /// `density`, `stretch_range`, `stretch_at_break`, `creep` and `mullins`.
    ///
    /// # Errors
    /// With what was found and what is needed.
    pub fn read(table: &toml::Table) -> Result<Self> {
        let mut parameters = table.clone();
        let law = match parameters.remove("kind") {
            Some(Value::String(kind)) => Law::find(&kind)?,
            Some(other) => bail!("kind = {other}: expected the name of a law in quotes"),
            None => bail!("no kind; `solver list` names the laws"),
        };
        let density = parameters.remove("density").map(|v| density(&v)).transpose()?;
        let stretch_range = parameters.remove("stretch_range").map(|v| range(&v)).transpose()?;
        let stretch_at_break =
            parameters.remove("stretch_at_break").map(|v| at_break(&v)).transpose()?;
        let creep = parameters.remove("creep").map(|v| creep(&v)).transpose()?;
        let mullins = parameters.remove("mullins").map(|v| mullins(&v)).transpose()?;
        let softening = Softening { creep, mullins };
        let values = law.read(&parameters)?;
        Ok(Self { law, values, density, stretch_range, stretch_at_break, softening })
    }

    /// The tables that [`Self::read`] takes, one for each law.
    #[must_use]
    pub fn schemas() -> Vec<Schema> {
        let of = |law: &Law| {
            let mut schema = law.schema();
            let range = json!({
                "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2,
                "description": "Smallest and largest principal stretch that it was fitted to [1].",
            });
            let number = |meaning: &str| json!({ "type": "number", "description": meaning });
            let at_break =
                number("Uniaxial stretch at which it tears: 1 + elongation at break [1].");
            let optional = [
                ("density", number("Density [kg/m³]."), false),
                ("stretch_range", range, false),
                ("stretch_at_break", at_break, false),
                ("creep", number("Part by which strain grows while a load is held [1]."), false),
                ("mullins", number("Part by which stress falls after a first stretch [1]."), false),
            ];
            add_keys(&mut schema, &optional);
            schema
        };
        LAWS.iter().map(of).collect()
    }

    /// The law, ready for use.
    #[must_use]
    pub fn build(&self) -> Box<dyn Material> {
        (self.law.build)(&self.values)
    }

    /// Moduli at rest.
    #[must_use]
    pub fn moduli(&self) -> Moduli {
        (self.law.moduli)(&self.values)
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

fn density(value: &Value) -> Result<f64> {
    let density = number(value).filter(|d| d.is_finite() && *d > 0.0);
    density.with_context(|| format!("density = {value}: expected a positive number [kg/m³]"))
}

fn at_break(value: &Value) -> Result<f64> {
    let stretch = number(value).filter(|s| s.is_finite() && *s > 1.0);
    stretch.with_context(|| {
        format!(
            "stretch_at_break = {value}: expected a number above 1, 1 + elongation at break [1]"
        )
    })
}

fn creep(value: &Value) -> Result<f64> {
    let part = number(value).filter(|c| c.is_finite() && *c > 0.0);
    part.with_context(|| {
        format!("creep = {value}: expected a positive part by which strain grows, such as 0.2")
    })
}

fn mullins(value: &Value) -> Result<f64> {
    let part = number(value).filter(|m| *m > 0.0 && *m < 1.0);
    part.with_context(|| {
        format!(
            "mullins = {value}: expected a part between 0 and 1 by which stress falls, such as 0.1"
        )
    })
}

fn range(value: &Value) -> Result<[f64; 2]> {
    let numbers: Option<Vec<f64>> =
        value.as_array().and_then(|items| items.iter().map(number).collect());
    let Some(&[low, high]) = numbers.as_deref() else {
        bail!("stretch_range = {value}: expected two numbers, as in [0.5, 4.0]");
    };
    ensure!(
        low > 0.0 && low <= 1.0 && high >= 1.0 && high.is_finite(),
        "stretch_range = {value}: must be [smallest, largest] principal stretch around 1"
    );
    Ok([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Specification> {
        Specification::read(&toml::from_str(text).expect("TOML"))
    }

    fn message(text: &str) -> String {
        format!("{:#}", read(text).err().expect("must be refused"))
    }

    #[test]
    fn the_table_of_the_pipelines_is_read() {
        let material = read("kind = 'mooney-rivlin'\nc1 = 55e3\nc2 = 5000\nc3 = 1.7e3\nd1 = 1e6")
            .expect("as in pipelines/frog/sim.toml");
        assert_eq!(material.values, [55e3, 5e3, 1.7e3, 1e6]);
        assert_eq!(material.moduli(), Moduli { shear: 120e3, bulk: 2e6 });
        assert!((material.moduli().poisson() - 0.470_588_235).abs() < 1e-9);
        assert_eq!((material.density, material.stretch_range), (None, None));
        assert_eq!(material.stretch_at_break, None);
    }

    #[test]
    fn optional_keys_are_read() {
        let text = "kind = 'ogden'\nmu = [1e4, -2e3]\nalpha = [2, -3]\nbulk = 1e6\n";
        let optional =
            "density = 1070\nstretch_range = [0.5, 4]\nstretch_at_break = 10\ncreep = 0.25";
        let material = read(&format!("{text}{optional}\nmullins = 0.1")).expect("ok");
        let changes: Vec<_> = material.softening.changes().collect();
        assert_eq!(changes, [("creep", 1.0 / 1.25 - 1.0), ("mullins", -0.1)]);
        assert_eq!(material.values, [1e4, -2e3, 2.0, -3.0, 1e6]);
        assert_eq!(material.density, Some(1070.0));
        assert_eq!(material.stretch_range, Some([0.5, 4.0]));
        assert_eq!(material.stretch_at_break, Some(10.0));
    }

    #[test]
    fn what_is_wrong_is_said_with_numbers() {
        let yeoh = "kind = 'yeoh'\nc1 = 1e4\nc2 = 0\nc3 = 0\nbulk = 1e6\n";
        let ogden = "kind = 'ogden'\nbulk = 1e6\n";
        for (text, needed) in [
            ("kind = 'mooney'".to_owned(), "mooney-rivlin-quadratic, neo-hookean, yeoh"),
            ("c1 = 1.0".to_owned(), "no kind"),
            ("kind = 3".to_owned(), "kind = 3"),
            (format!("{yeoh}c4 = 1"), "unknown parameter \"c4\"; expected c1 [Pa], c2 [Pa]"),
            ("kind = 'neo-hookean'\nyoung = 1e5".to_owned(), "no \"poisson\""),
            ("kind = 'neo-hookean'\nyoung = 1e5\npoisson = 0.5".to_owned(), "inf Pa"),
            ("kind = 'neo-hookean'\nyoung = -1e5\npoisson = 0.3".to_owned(), "-38461.5"),
            (yeoh.replace("c1 = 1e4", "c1 = -1e4"), "shear = 2 c1 = -20000 Pa"),
            (yeoh.replace("c1 = 1e4", "c1 = nan"), "must be finite"),
            (yeoh.replace("c1 = 1e4", "c1 = 'soft'"), "expected a number [Pa]"),
            (format!("{ogden}mu = [1e4]\nalpha = [2, 3]"), "mu has 1 numbers, alpha has 2"),
            (format!("{ogden}mu = 1e4\nalpha = [2]"), "expected a list of numbers [Pa]"),
            (format!("{ogden}mu = []\nalpha = []"), "expected a list"),
            (format!("{ogden}mu = [1e4]\nalpha = [0]"), "NaN Pa"),
            (format!("{yeoh}density = -1"), "density = -1"),
            (format!("{yeoh}stretch_range = [2, 1]"), "around 1"),
            (format!("{yeoh}stretch_at_break = 0.9"), "above 1"),
            (format!("{yeoh}creep = -0.2"), "creep = -0.2"),
            (format!("{yeoh}mullins = 1"), "between 0 and 1"),
        ] {
            let message = message(&text);
            assert!(message.contains(needed), "{needed} is not in: {message}");
        }
    }
}
