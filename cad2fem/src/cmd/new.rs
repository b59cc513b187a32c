//! `cad2fem new`: a folder to begin with.

use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, ensure};
use mesh::io::write_atomic;

use crate::installation::SPECIAL;
use crate::template::Template;

/// Writes a folder with all files of a body, which can be made at once and then changed
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder to write; its name is that of the body
    folder: PathBuf,
    /// Body to begin with: blank, beam, finger, pneunet, arm, frog, gripper, chamber or worm-segment
    #[arg(long, value_name = "BODY", default_value = "blank", value_parser = Template::find)]
    like: &'static Template,
}

/// Runs the verb; prints what to do next.
pub fn run(args: &Args) -> Result<()> {
    let (folder, template) = (&args.folder, args.like);
    let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    ensure!(
        !name.is_empty() && name.chars().all(plain) && !name.starts_with('-'),
        "{}: a body is called by letters, digits, - and _, as make has no other names",
        folder.display()
    );
    ensure!(
        !folder.exists(),
        "{}: is there already; give another name, or remove it",
        folder.display()
    );
    let place = Place::of(folder, name)?;
    ensure!(
        !(place.in_pipelines && template.has_rules()),
        "{}: {} has rules of its own for make, which call it by that name: write the folder outside of pipelines",
        folder.display(),
        template.name
    );
    for (file, text) in template.files_for(&place.results) {
        write_atomic(&folder.join(file), |out| out.write_all(text.as_bytes()))?;
    }
    if !place.in_pipelines {
        let own = std::env::current_exe().ok().filter(|own| special(own).is_none());
        let text = makefile(template, own.as_deref());
        write_atomic(&folder.join("Makefile"), |out| out.write_all(text.as_bytes()))?;
    }
    let readme = readme(name, template, &place);
    write_atomic(&folder.join("README.md"), |out| out.write_all(readme.as_bytes()))?;
    writeln!(
        program::stdout(),
        "{} is like {}: {}.\nmake it:        {}\nand open:       {}",
        folder.display(),
        template.name,
        template.about,
        place.command,
        place.page.display()
    )
    .context("standard output")
}

/// Where a body is, and so its results.
struct Place {
    /// Whether it lies in `pipelines` of a checkout, whose results are in `build`.
    in_pipelines: bool,
    /// What makes it.
    command: String,
    /// What is made of it.
    page: PathBuf,
    /// The folder of results, as seen from that of the body.
    results: String,
}

impl Place {
    fn of(folder: &Path, name: &str) -> Result<Self> {
        let full = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
        let above = full.parent().unwrap_or(Path::new("/"));
        if let (true, Some(top)) = (is_in_pipelines(&full), above.parent()) {
            let command = match std::env::current_dir().is_ok_and(|here| here == top) {
                true => format!("make {name}"),
                false => format!("make -C {} {name}", top.display()),
            };
            let page = top.join("build").join(name).join("report.html");
            let results = format!("../../build/{name}");
            return Ok(Self { in_pipelines: true, command, page, results });
        }
        let special = special(&full);
        ensure!(
            special.is_none(),
            "{}: make and the shell take the {:?} in it for their own: make the body in a folder whose path has \
             letters, digits, - . _ and / alone",
            full.display(),
            special.unwrap_or_default()
        );
        Ok(Self {
            in_pipelines: false,
            command: format!("make -C {}", folder.display()),
            page: folder.join("build/report.html"),
            results: "build".into(),
        })
    }
}

/// Whether the rules of a checkout make a body.
pub(super) fn is_in_pipelines(folder: &Path) -> bool {
    folder.parent().is_some_and(|above| above.join("rules.mk").is_file())
}

fn special(path: &Path) -> Option<char> {
    // the drive of a path on Windows is none of its names
    let mut names = path.components().filter(|part| matches!(part, Component::Normal(_)));
    names.find_map(|name| name.as_os_str().to_string_lossy().chars().find(|c| SPECIAL.contains(*c)))
}

/// The Makefile of a body anywhere: it takes the rules of the cad2fem in PATH, else of its `own`.
pub(super) fn makefile(template: &Template, own: Option<&Path>) -> String {
    let like =
        if template.has_rules() { format!("LIKE := {}\n", template.name) } else { String::new() };
    let found = own.map_or_else(
        || "$(shell command -v cad2fem)".into(),
        |own| format!("$(or $(shell command -v cad2fem),{})", own.display()),
    );
    format!(
        "# `make` makes all that is missing or out of date, and build/report.html, a page of it.\n\
         {like}BIN ?= $(patsubst %/,%,$(dir {found}))\n\
         include $(or $(shell $(BIN)/cad2fem rules),$(error cad2fem is needed: put it into PATH, or make BIN=folder))\n"
    )
}

fn readme(name: &str, template: &Template, place: &Place) -> String {
    let results = &place.results;
    let (model, _) = template.files[0];
    let design = template.files.iter().any(|(file, _)| *file == "design.toml");
    let design = if design {
        "| `design.toml` | `solver optimize` | what of the shape may change, and what for |\n"
    } else {
        ""
    };
    format!(
        "# {name}\n\n\
         Written by `cad2fem new --like {}`: {}.\n\n\
         ```\n{}\n```\n\n\
         {}makes everything that is missing, or older than or made from another version of its sources, and \
         `{results}/report.html`, a page of all results.\n\n\
         | file | read by | contains |\n|-|-|-|\n\
         | `{model}` | `cad2fem model` | the body and its regions |\n\
         | `cad2fem.toml` | `cad2fem tetmesh` | sizes of the tetrahedra |\n\
         | `tags.toml` | `tagger tag` | the name of each part of the boundary |\n\
         | `sim.toml` | `solver simulate` | material, supports, pressure |\n\
         {design}\
         | `mold.toml` | `fab mold` | how the body is cast |\n{}",
        template.name,
        template.about,
        if place.in_pipelines { &place.command } else { "make" },
        if place.in_pipelines { "" } else { "in this folder " },
        if place.in_pipelines { "" } else { "| `Makefile` | `make` | where its rules are |\n" }
    )
}
