//! Bodies to begin with. They are those of `pipelines`, which tests run, as they were when this
//! program was built.

/// A folder that `cad2fem new` writes.
#[derive(Debug)]
pub struct Template {
    /// The folder in `pipelines`.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Names and contents of its files.
    pub files: &'static [(&'static str, &'static str)],
}

macro_rules! template {
    ($name:literal, $about:literal, [$($file:literal),+]) => {
        Template {
            name: $name,
            about: $about,
            files: &[$((
                $file,
                include_str!(concat!("../../pipelines/", $name, "/", $file)),
            )),+],
        }
    };
}

/// All of them. A new one is a line here.
#[rustfmt::skip]
pub const TEMPLATES: &[Template] = &[
    template!("blank", "a finger of four cells that curls: the least that is simulated and cast, every line explained", ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml", "sim.blocked.toml", "mold.toml"]),
    template!("beam", "a bar whose chamber is designed so that it stays straight, in a minute", ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml", "design.toml", "mold.toml"]),
    template!("finger", "a finger whose chamber is designed for a bend, in some minutes", ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml", "design.toml", "mold.toml"]),
    template!("pneunet", "a row of chambers from a gmsh script that bends over paper in its floor, in some minutes", ["model.geo", "cad2fem.toml", "tags.toml", "sim.toml", "mold.toml"]),
    template!("arm", "an arm of three chambers from a gmsh script whose pressures are designed, in half an hour", ["model.geo", "cad2fem.toml", "tags.toml", "sim.toml", "design.toml", "mold.toml"]),
    template!("frog", "a frog whose chamber is designed so that only its throat swells, in an hour", ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml", "design.toml", "mold.toml"]),
    template!("gripper", "half a gripper of bellows from a gmsh script, designed for its force on a cylinder, in an hour", ["model.geo", "cylinder/model.geo", "cad2fem.toml", "tags.toml", "sim.toml", "design.toml", "design.shape.toml", "mold.toml", "rules.mk"]),
    template!("chamber", "two elliptic cylinders from a gmsh script, one in the other, cast as modelled, in some minutes", ["model.geo", "cad2fem.toml", "tags.toml", "sim.toml", "mold.toml"]),
    template!("worm-segment", "a segment of a worm from a gmsh script, whose chamber is closed, in some minutes", ["model.geo", "cad2fem.toml", "tags.toml", "sim.toml", "mold.toml"]),
];

impl Template {
    /// The template of this name.
    pub fn find(name: &str) -> Result<&'static Self, String> {
        TEMPLATES.iter().find(|template| template.name == name).ok_or_else(|| {
            let names = || TEMPLATES.iter().map(|template| template.name);
            let line =
                |template: &Template| format!("\n  {:<12} {}", template.name, template.about);
            let list: Vec<String> = TEMPLATES.iter().map(line).collect();
            let proposal = program::did_you_mean(name, names());
            let stop = if proposal.is_empty() { "." } else { "" };
            format!("there is no {name}{proposal}{stop} There are:{}", list.concat())
        })
    }

    /// Whether the folder has rules for make of its own, beyond those of any body.
    pub fn has_rules(&self) -> bool {
        self.files.iter().any(|(name, _)| *name == "rules.mk")
    }

    /// The files for results in the folder `results`, as seen from its own, with the version that
    /// they are written for.
    pub fn files_for(&self, results: &str) -> impl Iterator<Item = (&'static str, String)> {
        let (own, results) = (format!("../../build/{}/", self.name), format!("{results}/"));
        let version = program::VERSION.rsplit_once('.').map_or("", |(first_two, _)| first_two);
        let version =
            format!("puffer = \"{version}\"      # the version that this file is for\n\n");
        self.files.iter().map(move |(name, text)| {
            let version = if name.ends_with(".toml") { version.as_str() } else { "" };
            (*name, version.to_owned() + &text.replace(&own, &results))
        })
    }
}
