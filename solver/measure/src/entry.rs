//! An entry of a list of quantities: keys that all of the list have, a kind, and its own keys.

use std::borrow::Cow;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use program::schema::{Key, add_table, key_names, keys_of, one_of};
use program::{KeyPath, Misfit, misfit, read_table};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Table;

use crate::kinds;
use crate::quantity::{Kind, List, Quantity, Site, Specification};

/// Keys that all entries of a list have, besides `kind`.
pub trait Common: Clone + Serialize + DeserializeOwned + JsonSchema {
    /// The list.
    const LIST: List;
    /// What reports call the entry.
    fn name(&self) -> &str;
    /// Checks that there are as many keys as must be.
    fn complete(&self) -> Result<(), Misfit> {
        Ok(())
    }
    /// Checks what can be checked without a body, for a quantity that may be maximised or not.
    fn check(&self, may_be_maximised: bool) -> Result<()>;
    /// Adds to the schema of a kind what the types of the keys do not say.
    fn describe(_schema: &mut Schema) {}
}

/// A quantity with the keys of its list.
#[derive(Clone, Debug)]
pub struct Entry<C> {
    pub(crate) common: C,
    kind: &'static Kind,
    /// The keys of its kind ...
    pub(crate) own: Arc<dyn Specification>,
    /// ... and the same with all defaults written.
    pub(crate) keys: Table,
}

impl<C: Common> Entry<C> {
    /// What reports call it.
    pub fn name(&self) -> &str {
        self.common.name()
    }

    /// The row of the table.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        C::LIST.title(self.name())
    }

    /// Checks what can be checked without a body.
    pub fn check(&self) -> Result<()> {
        let may_be_maximised = self.kind.may_be_maximised && self.own.may_be_maximised();
        let own = || Ok(self.own.check_ranges(&KeyPath::default())?);
        let checked = self.common.check(may_be_maximised).and_then(|()| own());
        let checked = checked.and_then(|()| self.own.check());
        Ok(checked.map_err(|what| self.title().around(self.title(), &what))?)
    }

    /// Builds the quantity on bodies.
    pub fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        self.own.build(site).with_context(|| self.title())
    }

    /// The keys that all entries of the list have, with what they mean.
    pub fn common_keys() -> Vec<Key> {
        keys_of::<C>()
    }

    fn read(mut keys: Table) -> Result<Self, Misfit> {
        let kind = keys.remove("kind").ok_or_else(|| Misfit::missing_field("kind"))?;
        let kind =
            kind.as_str().ok_or_else(|| misfit!(KeyPath::of("kind"), " = {kind}: a name"))?;
        let (kind, names) = (kinds::find(C::LIST, kind)?, key_names::<C>());
        let (common, own): (Table, Table) =
            keys.into_iter().partition(|(key, _)| names.contains(&key.as_str()));
        let (own, keys) = kind.read(&own, names)?;
        let common: C = read_table(&common)?;
        common.complete()?;
        Ok(Self { common, kind, own, keys })
    }
}

impl<C: Common> Serialize for Entry<C> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Written<'a, C> {
            kind: &'a str,
            #[serde(flatten)]
            common: &'a C,
            #[serde(flatten)]
            own: &'a Table,
        }
        Written { kind: self.kind.key, common: &self.common, own: &self.keys }.serialize(serializer)
    }
}

impl<'de, C: Common> Deserialize<'de> for Entry<C> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keys = Table::deserialize(deserializer)?;
        let name = keys.get("name").and_then(|name| name.as_str()).map(str::to_owned);
        let titled = |what: Misfit| match name {
            Some(name) => what.titled(C::LIST.title(&name)),
            None => what,
        };
        Self::read(keys).map_err(|what| titled(what).carried())
    }
}

impl<C: Common> JsonSchema for Entry<C> {
    fn schema_name() -> Cow<'static, str> {
        C::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        one_of(kinds::of(C::LIST).map(|kind| {
            let mut schema = kind.schema(generator);
            add_table::<C>(&mut schema, generator);
            C::describe(&mut schema);
            schema
        }))
    }
}
