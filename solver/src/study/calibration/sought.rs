//! Numbers of scenes that measurements may determine.

use anyhow::{Context, Error, Result, bail, ensure};
use program::KeyPath;
use scene::Scene;
use schemars::JsonSchema;
use serde::Deserialize;

use scene::number::Group;

/// `[[number]]`: what is sought.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "Written")]
pub struct Sought {
    /// What, as people write it.
    of: String,
    /// The chamber, the tag of the wall or the sheet, or the body or volume.
    on: Option<String>,
    /// Which `[[relaxation]]`, counted from 1.
    branch: Option<usize>,
}

/// A number as people write it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Written {
    /// `modulus`, `density`, `membrane`, `pressure`, `wall`, `overstress`, `relaxation-time`, the
    /// name of a parameter of the law, or the path of a number of `solver list --numbers`.
    of: String,
    /// The chamber, the tag of the wall or the sheet, or the body or volume of the modulus.
    on: Option<String>,
    /// The body or volume with that law.
    body: Option<String>,
    /// Which `[[relaxation]]` of the scene, counted from 1; may be left out where there is one.
    branch: Option<usize>,
}

impl TryFrom<Written> for Sought {
    type Error = Error;

    fn try_from(Written { of, on, body, branch }: Written) -> Result<Self> {
        let chosen = ["modulus", "membrane", "pressure", "wall"].contains(&&*of);
        let relaxes = ["overstress", "relaxation-time"].contains(&&*of);
        let of_law = !chosen && !relaxes && of != "density" && !of.contains('.');
        let place = if of_law { body.clone() } else { on.clone() };
        let sought = Self { of, on: place, branch };
        let title = sought.title();
        ensure!(chosen || on.is_none(), "{title}: on is for modulus, membrane, pressure and wall");
        ensure!(of_law || body.is_none(), "{title}: body is for parameters of a law");
        ensure!(
            branch.is_none() || relaxes,
            "{title}: branch is for overstress and relaxation-time"
        );
        ensure!(
            branch != Some(0),
            "{title}: branch = 0: the first [[relaxation]] of the scene is 1"
        );
        Ok(sought)
    }
}

impl Sought {
    /// What tables call it.
    pub fn title(&self) -> String {
        let branch = self.branch.map(|branch| format!("branch {branch}"));
        let on = self.on.clone().or(branch);
        on.map_or_else(|| self.of.clone(), |on| format!("{} of {on}", self.of))
    }

    /// Whether it is a factor, an offset, or a parameter of a law.
    pub fn meaning(&self) -> &'static str {
        match &*self.of {
            "modulus" => "factor on all stresses",
            "density" => "factor",
            "membrane" => "factor on the thickness",
            "pressure" => "offset",
            "wall" => "outward offset",
            "overstress" | "relaxation-time" => "of the scene",
            path if path.contains('.') => "number of the scene",
            _ => "parameter of the law",
        }
    }

    /// Whether it is a factor on all stresses.
    pub fn is_modulus(&self) -> bool {
        self.of == "modulus"
    }

    /// Whether it is a parameter of a law.
    pub fn is_parameter(&self) -> bool {
        self.meaning() == "parameter of the law" || self.of.starts_with("material.")
    }

    /// Whether a table `[material]`, `[[relaxation]]`, `[[mullins]]` or `[[membrane]]` has it.
    pub fn is_of_material(&self) -> bool {
        let words = ["modulus", "membrane", "overstress", "relaxation-time"];
        let paths = ["relaxation.", "mullins.", "membrane."];
        self.is_parameter()
            || words.contains(&&*self.of)
            || paths.iter().any(|path| self.of.starts_with(path))
    }

    /// Whether it is the density of what a scene is made of.
    pub fn is_density(&self) -> bool {
        self.of.split('.').next() == Some("density")
    }

    /// The numbers of a scene that it stands for; none where the scene does not have it.
    pub fn group(&self, scene: &Scene) -> Result<Option<Group>> {
        let on = self.on.as_deref();
        let group = match &*self.of {
            "modulus" => Group::modulus(scene, on),
            "density" => Group::density(scene, None),
            "membrane" => Group::membrane(scene, on),
            "pressure" => Group::pressure(scene, on),
            "wall" => {
                let path = on.map_or_else(|| "wall".to_owned(), |on| format!("wall.{on}"));
                Group::of_path(scene, &path)
            }
            "overstress" => self.relaxation("overstress", scene)?,
            "relaxation-time" => self.relaxation("time", scene)?,
            path if path.contains('.') => Group::of_path(scene, path),
            parameter => self.parameter(parameter, scene)?,
        };
        Ok(Some(group).filter(|group| !group.numbers.is_empty()))
    }

    /// A number of a `[[relaxation]]`.
    fn relaxation(&self, key: &str, scene: &Scene) -> Result<Group> {
        let count = scene.config.relaxation.len();
        ensure!(
            self.branch.is_some() || count <= 1,
            "{}: {} has {count} tables [[relaxation]]; expected branch = 1 to {count}",
            self.title(),
            scene.path.display()
        );
        let branch = self.branch.unwrap_or(1);
        ensure!(
            count == 0 || branch <= count,
            "{}: {} has {count} tables [[relaxation]]",
            self.title(),
            scene.path.display()
        );
        Ok(Group::of_path(scene, &format!("relaxation.{branch}.{key}")))
    }

    /// A parameter of the law of a body or volume, which may be left out where there is one law.
    fn parameter(&self, wanted: &str, scene: &Scene) -> Result<Group> {
        let names: Vec<String> = scene.laws.iter().map(|law| scene.law_name(law)).collect();
        let law = match &self.on {
            Some(name) => names.iter().position(|own| own == name).with_context(|| {
                format!(
                    "{}: no body or volume has this name; there are: {}",
                    self.title(),
                    names.join(", ")
                )
            })?,
            None if names.len() == 1 => 0,
            None => {
                bail!("{wanted}: there are several laws; name a body or volume by body = \"…\"")
            }
        };
        let material = &scene.laws[law].material;
        let Some(parameter) = material.law.parameters.iter().find(|p| p.name == wanted) else {
            let known: Vec<&str> = material.law.parameters.iter().map(|p| p.name).collect();
            let what = format!(
                "of = \"{wanted}\": expected modulus, density, membrane, pressure, wall, \
                 overstress, relaxation-time, a path of `solver list --numbers`, or a parameter \
                 of the law {}: {}",
                material.law.key,
                known.join(", ")
            );
            bail!(KeyPath::list("number").with(KeyPath::word(wanted)).told(what));
        };
        let path = format!("material.{}.{wanted}", names[law]);
        ensure!(
            !parameter.list,
            "{}: a list of numbers; expected one of them, as in of = \"{path}.1\", or \
             of = \"modulus\"",
            self.title()
        );
        Ok(Group::of_path(scene, &path))
    }
}
