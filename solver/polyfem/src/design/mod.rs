//! A run file: design variables and objective function.

mod pressures;
mod terms;

use std::path::PathBuf;

use anyhow::Result;

use super::document::{Document, Key};
use super::geometry::{Solid, tag};
use super::scene::Translated;
use super::text::{Text, list, quoted};

/// Why keys of a run file have no part in our design problem.
pub const REASONS: &[(&str, &str)] = &[
    ("/output", "solver optimize writes its own files"),
    ("/parameters", "the number of variables follows from the handles"),
    ("/variable_to_simulation/*/state", "there is one scene"),
    ("/variable_to_simulation/*/composition/*/state", "there is one scene"),
    (
        "/variable_to_simulation/*/composition/*/parameter_index",
        "the handles have variables of their own",
    ),
    ("/functionals/*/state", "there is one scene"),
    ("/functionals/*/static_objective/state", "there is one scene"),
    ("/solver/contact", "the rest shape keeps clear of itself by the objective \"clearance\""),
    ("/solver/nonlinear", "L-BFGS here has settings of its own"),
    (
        "/solver/advanced",
        "the interior follows the surface by an extension and is re-meshed between levels",
    ),
];

/// Iterations of a level where the file says nothing, as PolyFEM assumes them.
const ITERATIONS: usize = 1000;

/// A design problem of ours.
pub struct Design {
    /// The text of `design.toml`.
    pub text: String,
    /// Target surfaces.
    pub targets: Vec<TargetFile>,
}

/// A target surface.
pub struct TargetFile {
    /// Where it was read.
    from: PathBuf,
    /// The name in our folder.
    pub name: String,
    /// The content.
    pub bytes: Vec<u8>,
}

/// A tag that moves.
struct Moving {
    on: String,
    handles: usize,
    rotates: bool,
}

/// What is known while terms are written.
struct Writer<'a> {
    scene: &'a Translated,
    text: Text,
    targets: Vec<TargetFile>,
    names: Vec<String>,
    notes: Vec<String>,
}

/// Reads a run file; nothing where neither a shape nor a pressure may change. Adds to the notes of
/// its scene.
pub fn read(document: &Document, scene: &mut Translated) -> Result<Option<Design>> {
    let root = document.root();
    let mut writer = Writer {
        scene,
        text: Text::new(&["What may change in sim.toml, and what is wanted.".to_owned()]),
        targets: Vec::new(),
        names: Vec::new(),
        notes: Vec::new(),
    };
    writer.text.name("scene", "sim.toml");
    let functionals = root.items_of("functionals");
    let shape = writer.shape(&root)?;
    let design = if writer.pressures(&root, !shape)? || shape {
        for term in &functionals {
            writer.term(term)?;
        }
        Some(Design { text: writer.text.0, targets: writer.targets })
    } else {
        for term in &functionals {
            term.leave(
                "without a shape or a pressure that may change there is no design problem here",
            );
        }
        writer.notes.push(
            "no design.toml: neither a shape nor a pressure may change in this problem".to_owned(),
        );
        None
    };
    let notes = writer.notes;
    scene.notes.extend(notes);
    Ok(design)
}

impl Writer<'_> {
    /// Writes the shapes that may change; false if there is none.
    fn shape(&mut self, root: &Key) -> Result<bool> {
        let mut moving: Vec<Moving> = Vec::new();
        for variable in root.items_of("variable_to_simulation") {
            // the kind says it
            let _ = variable.get("composite_map_type");
            match variable.need("type", "the kind of variable")?.text()? {
                "shape" => {}
                "pressure" => continue,
                _ => {
                    variable.leave("only shapes and pressures are design variables here");
                    continue;
                }
            }
            let ids = variable.need("surface_selection", "the surface that moves")?.ids()?;
            let owners: Vec<&Solid> = self
                .scene
                .geometry
                .solids
                .iter()
                .filter(|s| ids.iter().all(|i| s.ids.contains_key(i)))
                .collect();
            let (&[id], &[solid]) = (&ids[..], &owners[..]) else {
                variable.leave("a surface that moves is one tag of one body here");
                continue;
            };
            moving.extend(self.shape_of(&variable, solid, id)?);
        }
        let Some(first) = moving.first() else { return Ok(false) };
        let handles = if moving.iter().all(|m| m.handles == first.handles) {
            first.handles.to_string()
        } else {
            let tags = moving.iter().map(|m| format!("{} = {}", quoted(&m.on), m.handles));
            format!("{{ {} }}", tags.collect::<Vec<_>>().join(", "))
        };
        let rotates = moving.iter().any(|m| m.rotates);
        if rotates && !moving.iter().all(|m| m.rotates) {
            self.notes.push(format!(
                "{}: handles rotate on every tag that moves, though not on all there",
                root.document.path.display()
            ));
        }
        let iterations = iterations(root)?;
        let on: Vec<String> = moving.into_iter().map(|m| m.on).collect();
        self.text.table("[shape]").key("on", &names(&on)).table("[[shape.level]]");
        self.text.key("handles", &handles).key("iterations", &iterations.to_string());
        if !rotates {
            self.text.key("motion", &quoted("translation"));
        }
        Ok(true)
    }

    fn shape_of(&mut self, variable: &Key, solid: &Solid, id: i64) -> Result<Option<Moving>> {
        let maps = variable.items_of("composition");
        let named =
            |key: &&Key| key.get("type").is_some_and(|t| t.value == "bounded-biharmonic-weights");
        let Some(weights) = maps.iter().find(named) else {
            variable.leave("a shape changes by handles with bounded biharmonic weights here");
            return Ok(None);
        };
        for map in &maps {
            let _ = map.get("type");
        }
        let handles = weights.need("num_control_vertices", "the number of handles")?.count()?;
        if let Some(count) = weights.get("num_vertices") {
            let found = vertices(solid, id);
            if count.id()? != found {
                self.notes.push(format!(
                    "{}: {} vertices are said to move, {found} are on \"{}\"",
                    weights.document.path.display(),
                    count.value,
                    self.scene.geometry.on(solid, &tag(id))
                ));
            }
        }
        let rotates = weights.optional("allow_rotations", Key::flag)?.unwrap_or(true);
        Ok(Some(Moving { on: self.scene.geometry.on(solid, &tag(id)), handles, rotates }))
    }
}

/// Iterations of the optimiser.
fn iterations(root: &Key) -> Result<usize> {
    let nonlinear = root.get("solver").and_then(|s| s.get("nonlinear"));
    let iterations = nonlinear.map_or(Ok(None), |n| n.optional("max_iterations", Key::count))?;
    Ok(iterations.unwrap_or(ITERATIONS))
}

/// A name in quotes, or a list of names.
fn names(names: &[String]) -> String {
    match names {
        [one] => quoted(one),
        several => list(several.iter().map(|name| quoted(name))),
    }
}

/// Number of vertices on the facets with an id.
fn vertices(solid: &Solid, id: i64) -> i64 {
    let number = solid.tags.id(&tag(id)).unwrap_or_default();
    let mut all: Vec<usize> = solid.tags.facets_of(number).into_iter().flatten().collect();
    all.sort_unstable();
    all.dedup();
    all.len() as i64
}
