//! `material`: what a body is made of.

mod build; // laws of a body and of its volumes

use std::borrow::Cow;
use std::collections::BTreeSet;

use anyhow::{Context, Result, bail};
use mechanics::material::Specification;
use program::schema::{add_keys, one_of, one_of_these};
use program::{KeyPath, misfit};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::law_table;
use crate::silicone;
pub use build::SceneLaw;
pub(crate) use build::{largest_shear_modulus, laws};

/// The name of a silicone of the library, or a law with its parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected the name of a silicone, as in \
    material = \"ecoflex-00-30\", a table [material] with kind and parameters, or tables \
    [[material]] with on, a volume of the mesh, for each"
)]
pub enum MaterialConfig {
    /// A row of `solver list --silicones`.
    Silicone(String),
    /// `kind`, the parameters of that law in `solver list`, and optionally
    /// `density` [kg/m³], `stretch_range`, `stretch_at_break`, `creep` and `mullins` [1].
    Law(toml::Table),
    /// One for each volume of the mesh.
    Volumes(Vec<VolumeMaterial>),
}

/// `[[material]]`: what a volume of the mesh is made of.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VolumeMaterial {
    /// Name of the volume.
    pub on: String,
    /// `silicone` alone, or the keys of a law.
    #[serde(flatten)]
    pub keys: toml::Table,
}

impl VolumeMaterial {
    /// This material as it is written for a whole body.
    pub fn material(&self) -> Result<MaterialConfig> {
        match self.keys.get("silicone") {
            None => Ok(MaterialConfig::Law(self.keys.clone())),
            Some(toml::Value::String(name)) if self.keys.len() == 1 => {
                Ok(MaterialConfig::Silicone(name.clone()))
            }
            Some(_) => {
                bail!(misfit!(
                    KeyPath::of("silicone"),
                    ": expected the name of one of the library, without other keys"
                ))
            }
        }
    }
}

impl MaterialConfig {
    /// The law with its parameters.
    pub fn specification(&self) -> Result<Specification> {
        match self {
            Self::Silicone(name) => silicone::find(name).map(|n| n.fit.specification.clone()),
            Self::Law(table) => law_table::volume(table).context(KeyPath::table("material")),
            Self::Volumes(_) => {
                bail!(misfit!(KeyPath::list("material"), ": expected a law of one volume"))
            }
        }
    }

    /// The silicone that is named, if one is.
    pub fn silicone(&self) -> Option<silicone::Named> {
        match self {
            Self::Silicone(name) => silicone::find(name).ok(),
            Self::Law(_) | Self::Volumes(_) => None,
        }
    }

    /// Whether all of it are silicones that are named.
    pub fn is_named(&self) -> bool {
        match self {
            Self::Volumes(volumes) => {
                volumes.iter().all(|v| v.material().is_ok_and(|material| material.is_named()))
            }
            one => one.silicone().is_some(),
        }
    }
}

impl JsonSchema for MaterialConfig {
    fn schema_name() -> Cow<'static, str> {
        "MaterialConfig".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let laws = law_table::volume_schemas(generator);
        let mut volumes = laws.clone();
        volumes.push(json_schema!({
            "type": "object",
            "title": "`silicone`",
            "properties": { "silicone": silicone_name() },
            "required": ["silicone"],
            "additionalProperties": false,
        }));
        let mut volumes = one_of(volumes);
        let on = json!({ "type": "string", "description": "Name of the volume." });
        add_keys(&mut volumes, &[("on", on, true)]);
        let of_volumes = json_schema!({ "type": "array", "items": volumes });
        let mut forms = vec![silicone_name(), of_volumes];
        forms.splice(1..1, laws);
        json_schema!({ "anyOf": forms })
    }
}

/// The names that [`silicone::find`] knows.
fn silicone_name() -> Schema {
    let mut names: BTreeSet<String> = BTreeSet::new();
    for silicone in silicone::all() {
        names.insert(silicone.key.to_owned());
        for fit in &silicone.fits {
            for which in [fit.entry.source.as_str(), fit.specification.law.key] {
                names.insert(format!("{}/{which}", silicone.key));
            }
        }
    }
    let mut schema = one_of_these(names.iter().map(String::as_str));
    schema.insert("title".into(), "name of a silicone".into());
    schema
}
