//! Numbers of scenes that measurements may determine.

use anyhow::{Result, ensure};
use program::{KeyPath, misfit};
use scene::Scene;
use scene::number::Group;

program::table! {
    /// `[[number]]`: what is sought.
    #[derive(Clone, Debug, PartialEq, Eq)]
    pub struct Sought {
        /// `modulus`, `density`, `membrane` or `pressure`, or the path of a number of `solver list --numbers`.
        of: String;
        /// The body or volume of a modulus or density, the tag of the sheet, or the chamber.
        on: Option<String> = None;
    }
}

/// Numbers that change together: what people write, how they change, and those of a scene, or of a part of it by name.
type Word = (&'static str, &'static str, fn(&Scene, Option<&str>) -> Group);
const WORDS: [Word; 4] = [
    ("modulus", "factor on all stresses", Group::modulus),
    ("density", "factor", Group::density),
    ("membrane", "factor on the thickness", Group::membrane),
    ("pressure", "offset", Group::pressure),
];

impl Sought {
    /// Refuses a part of a number.
    pub(super) fn check(&self) -> Result<()> {
        let words = WORDS.map(|(word, ..)| word).join(", ");
        ensure!(
            self.on.is_none() || self.word().is_some(),
            misfit!(KeyPath::of("on"), " is for {words}; {} is one number", self.of)
        );
        Ok(())
    }

    fn word(&self) -> Option<Word> {
        WORDS.into_iter().find(|(word, ..)| *word == self.of)
    }

    /// What tables call it.
    pub fn title(&self) -> String {
        let on = self.on.as_ref().map(|on| format!(" of {on}"));
        self.of.clone() + &on.unwrap_or_default()
    }

    /// Whether it is a factor, an offset, or a number.
    pub fn meaning(&self) -> &'static str {
        self.word().map_or("number of the scene", |(_, meaning, _)| meaning)
    }

    /// Whether it is a factor on all stresses.
    pub fn is_modulus(&self) -> bool {
        self.of == "modulus"
    }

    /// Whether it is a parameter of a law.
    pub fn is_parameter(&self) -> bool {
        self.of.starts_with("material.")
    }

    /// Whether a table `[material]`, `[[relaxation]]`, `[[mullins]]` or `[[membrane]]` has it.
    pub fn is_of_material(&self) -> bool {
        let kind = self.of.split('.').next().unwrap_or_default();
        ["modulus", "material", "relaxation", "mullins", "membrane"].contains(&kind)
    }

    /// Whether it is the density of what a scene is made of.
    pub fn is_density(&self) -> bool {
        self.of.split('.').next() == Some("density")
    }

    /// The numbers of a scene that it stands for; none where the scene does not have it.
    pub fn group(&self, scene: &Scene) -> Option<Group> {
        let group = match self.word() {
            Some((.., numbers)) => numbers(scene, self.on.as_deref()),
            None => Group::of_path(scene, &self.of),
        };
        Some(group).filter(|group| !group.numbers.is_empty())
    }
}
