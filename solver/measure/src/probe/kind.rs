//! A row of the table of probes.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use program::schema::add_kind;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::KINDS;
use crate::objective::{Objective, from_keys, refuse_unknown};

/// Keys that every `[[probe]]` has besides `kind`, with what they mean.
pub const COMMON_KEYS: [(&str, &str); 1] = [("name", "its column in results")];

/// Keys that several kinds have.
pub(super) const TAG: (&str, &str) = ("on", "tag");
pub(super) const OTHER_TAG: (&str, &str) = ("to", "the other tag");
pub(super) const AXIS: (&str, &str) = ("axis", "a, of any length but 0");

/// A kind of probe: what to write, what it means, how to read it.
#[derive(Debug)]
pub struct Kind {
    /// `kind` in a `[[probe]]`.
    pub key: &'static str,
    /// What it measures.
    pub formula: &'static str,
    /// Unit of its value.
    pub unit: &'static str,
    /// Keys besides `kind` and [`COMMON_KEYS`], with what they mean.
    pub keys: &'static [(&'static str, &'static str)],
    /// Whether it looks at forces between surfaces, so that it needs `[contact]`.
    pub needs_contact: bool,
    /// How its own keys are read.
    pub(super) form: Form,
}

/// The type that the keys of a kind are read into.
#[derive(Debug)]
pub(super) struct Form {
    /// From a table of them, and the same with all defaults written.
    read: fn(toml::Table) -> Result<Read>,
    /// As a schema.
    schema: fn(&mut SchemaGenerator) -> Schema,
}

/// The form of the type `S`.
pub(super) const fn form<S>() -> Form
where
    S: Specification + Serialize + DeserializeOwned + JsonSchema + 'static,
{
    Form { read: read::<S>, schema: S::json_schema }
}

/// The keys of one kind, and the same as a table.
pub type Read = (Arc<dyn Specification>, toml::Table);

/// What probes are built on.
pub struct Site<'a> {
    /// The bodies in one mesh.
    pub body: &'a Body,
    /// Topology and basis of its displacement.
    pub space: &'a FunctionSpace,
    /// Degrees of freedom that each fixed tag holds.
    pub supports: &'a BTreeMap<String, Vec<usize>>,
}

/// One kind of `[[probe]]` as it is written, without the keys of all kinds.
pub trait Specification: Debug + Send + Sync {
    /// Checks what can be checked without a body.
    ///
    /// # Errors
    /// With what was found and what is needed.
    fn check(&self) -> Result<()> {
        Ok(())
    }
    /// The probe on a body, with a name.
    ///
    /// # Errors
    /// When a tag is missing, or a point lies where it must not.
    fn build(&self, name: &str, site: &Site) -> Result<Arc<dyn Objective>>;
}

impl Kind {
    /// The kind that is called so.
    ///
    /// # Errors
    /// When there is none; the message lists those there are.
    pub fn find(key: &str) -> Result<&'static Self> {
        KINDS.iter().find(|kind| kind.key == key).with_context(|| {
            let known: Vec<String> = KINDS.iter().map(|kind| format!("`{}`", kind.key)).collect();
            format!(
                "unknown kind `{key}`, expected one of {}\n  `solver list --probes` explains them",
                known.join(", ")
            )
        })
    }

    /// Reads the keys of this kind alone.
    ///
    /// # Errors
    /// When one is unknown, missing or of the wrong type.
    pub fn read(&self, keys: toml::Table) -> Result<Read> {
        refuse_unknown(self.key, &keys, &COMMON_KEYS, self.keys)?;
        (self.form.read)(keys).with_context(|| format!("kind = \"{}\"", self.key))
    }

    /// The table of this kind, without [`COMMON_KEYS`].
    #[must_use]
    pub fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        let mut schema = (self.form.schema)(generator);
        let about = format!("{} [{}].", self.formula, self.unit);
        add_kind(&mut schema, self.key, &about, self.keys);
        schema
    }
}

/// Reads the keys of a kind as `S`.
fn read<S>(keys: toml::Table) -> Result<Read>
where
    S: Specification + Serialize + DeserializeOwned + 'static,
{
    let (found, table) = from_keys::<S>(keys)?;
    Ok((Arc::new(found), table))
}
