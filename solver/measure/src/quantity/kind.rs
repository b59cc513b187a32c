//! A row of the table of quantities.

use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use program::schema::{Key, add_kind, key_names, keys_of};
use program::table::Table;
use program::{KeyPath, Misfit, read_table};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Quantity, Site};

/// A list of quantities in a file that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum List {
    /// What is measured in a scene: `[[probe]]`.
    Probe,
    /// What a design minimises: `[[objective]]`.
    Objective,
}

impl List {
    /// What messages call an entry with this name.
    pub fn title(self, name: &str) -> KeyPath {
        match self {
            Self::Probe => KeyPath::list("probe").named(name),
            Self::Objective => KeyPath::of("objective").named(name),
        }
    }

    /// Option of `solver list` that explains its kinds.
    pub fn option(self) -> &'static str {
        match self {
            Self::Probe => "--probes",
            Self::Objective => "--objectives",
        }
    }
}

/// A kind of quantity: where it may be used, what to write, what it means, how to read it.
#[derive(Debug)]
pub struct Kind {
    /// `kind` in an entry of its lists.
    pub key: &'static str,
    /// Unit of its value; a weight has the inverse.
    pub unit: &'static str,
    /// Lists that it may be an entry of.
    pub lists: &'static [List],
    /// Whether its weight may be negative, so that it is maximised.
    pub may_be_maximised: bool,
    /// Whether it looks at forces between surfaces, so that it needs `[contact]`.
    pub needs_contact: bool,
    /// Whether it is made with the stress of the law at each point.
    pub reads_stress: bool,
    /// Keys for a cube with a tag for each side, on which the tests check the derivatives.
    pub example: &'static str,
    /// How its own keys are read.
    pub(crate) form: Form,
}

/// The type that the keys of a kind are read into.
#[derive(Debug)]
pub(crate) struct Form {
    /// From a table of them, and the same with all defaults written.
    read: fn(&toml::Table) -> Result<Read, Misfit>,
    /// Names of the keys.
    names: fn() -> &'static [&'static str],
    /// What the keys mean.
    keys: fn() -> Vec<Key>,
    /// As a schema.
    schema: fn(&mut SchemaGenerator) -> Schema,
}

/// The keys of one kind, and the same as a table.
pub type Read = (Arc<dyn Specification>, toml::Table);

/// A quantity as it is written, without the keys of all kinds. The documentation of the table says what it is.
pub trait Specification: Debug + Table + Send + Sync {
    /// Checks what can be checked without a body, beside the ranges of the keys.
    fn check(&self) -> Result<()> {
        Ok(())
    }
    /// Whether a negative weight has a sense, if it has for this kind.
    fn may_be_maximised(&self) -> bool {
        true
    }
    /// The files that it names, from the folder of the design.
    fn files(&self) -> Vec<&Path> {
        Vec::new()
    }
    /// Builds the quantity on bodies.
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>>;
}

impl Kind {
    /// A row with the keys `S` that every row completes with what is not so by default.
    pub(crate) const fn of<S>(lists: &'static [List]) -> Self
    where
        S: Specification + Serialize + DeserializeOwned + JsonSchema + 'static,
    {
        Self {
            key: "",
            unit: "",
            lists,
            may_be_maximised: false,
            needs_contact: false,
            reads_stress: false,
            example: "",
            form: Form {
                read: read::<S>,
                names: key_names::<S>,
                keys: keys_of::<S>,
                schema: S::json_schema,
            },
        }
    }

    /// What it is.
    pub fn formula(&self) -> String {
        formula(&(self.form.schema)(&mut SchemaGenerator::default()))
    }

    /// The keys of this kind alone, without `kind` and those of the list, with what they mean.
    pub fn keys(&self) -> Vec<Key> {
        (self.form.keys)()
    }

    /// Reads the keys of this kind alone; `common` are those of the list, which were taken out before.
    pub fn read(&self, keys: &toml::Table, common: &[&str]) -> Result<Read, Misfit> {
        let own = (self.form.names)();
        let unknown = keys.keys().find(|name| !own.contains(&name.as_str()));
        let found = match unknown {
            Some(unknown) => {
                let known: Vec<&str> = common.iter().chain(own).copied().collect();
                Err(KeyPath::word(unknown).unknown("field", unknown, &known))
            }
            None => (self.form.read)(keys),
        };
        found.map_err(|what| what.titled(format!("kind = \"{}\"", self.key)))
    }

    /// The table of this kind, without the keys of the list.
    pub fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        let mut schema = (self.form.schema)(generator);
        schema.insert("additionalProperties".into(), false.into());
        let sense = if self.may_be_maximised { "; a negative weight maximises it" } else { "" };
        let about = format!("{} [{}]{sense}.", formula(&schema), self.unit);
        add_kind(&mut schema, self.key, &about);
        schema
    }
}

/// What the documentation of a table says, in one line.
fn formula(schema: &Schema) -> String {
    let about = schema.get("description").and_then(|about| about.as_str());
    about.unwrap_or_default().replace('\n', " ")
}

/// Reads the keys of a kind as `S`, and the same with all defaults written.
fn read<S>(keys: &toml::Table) -> Result<Read, Misfit>
where
    S: Specification + Serialize + DeserializeOwned + 'static,
{
    let found: S = read_table(keys)?;
    let table = toml::Table::try_from(&found).map_err(|what| KeyPath::default().told(what))?;
    Ok((Arc::new(found), table))
}
