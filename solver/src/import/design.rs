//! A run file: what may change, and what is wanted.

use std::path::PathBuf;

use anyhow::{Context, Result};

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
    /// Its name in our folder.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// What is known while terms are written.
struct Writer<'a> {
    scene: &'a Translated,
    text: Text,
    targets: Vec<TargetFile>,
    names: Vec<String>,
    notes: Vec<String>,
}

/// Reads a run file; nothing where no shape may change. Adds to the notes of
/// its scene.
///
/// # Errors
/// With the file, the key, what was found and what is needed.
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
    let functionals = root.get("functionals").map(|key| key.items()).unwrap_or_default();
    let design = if writer.shape(&root)? {
        for term in &functionals {
            writer.term(term)?;
        }
        Some(Design { text: writer.text.0, targets: writer.targets })
    } else {
        for term in &functionals {
            term.leave("without a shape that may change there is no design problem here");
        }
        writer.notes.push("no design.toml: no shape may change in this problem".to_owned());
        None
    };
    let notes = writer.notes;
    scene.notes.extend(notes);
    Ok(design)
}

impl Writer<'_> {
    /// Writes the first shape that may change; false if there is none.
    fn shape(&mut self, root: &Key) -> Result<bool> {
        let mut done = false;
        let variables = root.get("variable_to_simulation").map(|key| key.items());
        for variable in variables.unwrap_or_default() {
            let kind = variable.need("type", "the kind of variable")?;
            if kind.text()? != "shape" {
                variable.leave("only shapes are design variables here");
                continue;
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
                variable.leave("the surface that moves is one tag of one body here");
                continue;
            };
            if done {
                variable.leave("the shape of one tag changes here");
                continue;
            }
            done = self.shape_of(root, &variable, solid, id)?;
        }
        Ok(done)
    }

    fn shape_of(&mut self, root: &Key, variable: &Key, solid: &Solid, id: i64) -> Result<bool> {
        let maps = variable.get("composition").map(|key| key.items()).unwrap_or_default();
        let named =
            |key: &&Key| key.get("type").is_some_and(|t| t.value == "bounded-biharmonic-weights");
        let Some(weights) = maps.iter().find(named) else {
            variable.leave("a shape changes by handles with bounded biharmonic weights here");
            return Ok(false);
        };
        for name in ["type", "composite_map_type", "surface_selection"] {
            let _ = variable.get(name).map(|k| k.becomes("[shape] on"));
        }
        for map in &maps {
            let _ = map.get("type").map(|k| k.becomes("[[shape.level]]"));
        }
        let handles = weights.need("num_control_vertices", "the number of handles")?;
        let handles = handles.becomes("[[shape.level]] handles").count()?;
        if let Some(count) = weights.get("num_vertices") {
            let found = vertices(solid, id);
            if count.becomes("nothing: it follows from the mesh").id()? != found {
                self.notes.push(format!(
                    "{}: {} vertices are said to move, {found} are on \"{}\"",
                    weights.document.path.display(),
                    count_of(weights),
                    self.on(solid, id)
                ));
            }
        }
        match weights.get("allow_rotations") {
            Some(key) if key.flag()? => drop(key.becomes("handles, which always rotate")),
            Some(key) => key.leave("handles always rotate here"),
            None => {}
        }
        let nonlinear = root.get("solver").and_then(|s| s.get("nonlinear"));
        let iterations = nonlinear.and_then(|n| n.get("max_iterations"));
        let iterations = iterations.map(|k| k.becomes("[[shape.level]] iterations").count());
        let iterations = iterations.transpose()?.unwrap_or(ITERATIONS);
        let on = self.on(solid, id);
        self.text.table("[shape]").name("on", &on).table("[[shape.level]]");
        self.text.key("handles", &handles.to_string()).key("iterations", &iterations.to_string());
        Ok(true)
    }

    fn on(&self, solid: &Solid, id: i64) -> String {
        let tag = tag(id);
        if self.scene.several { format!("{}.{tag}", solid.name) } else { tag }
    }

    /// The tags with an id.
    fn tags(&self, id: i64) -> Vec<String> {
        let owners = self.scene.geometry.solids.iter().filter(|s| s.ids.contains_key(&id));
        owners.map(|solid| self.on(solid, id)).collect()
    }

    /// Writes a term of the objective if there is one like it here.
    fn term(&mut self, term: &Key) -> Result<()> {
        let weight = match term.get("weight") {
            Some(key) => key.becomes("weight").number()?,
            None => 1.0,
        };
        if weight < 0.0 {
            term.leave("weights are not negative here");
            return Ok(());
        }
        let kind = term.need("type", "the kind of term")?.becomes("kind").text()?;
        let title = match term.get("print_energy") {
            Some(key) => key.becomes("name").text()?,
            None => kind,
        };
        let title = title.to_owned();
        if kind != "transient_integral" {
            return self.of_state(term, term, &title, weight);
        }
        let state = term.need("static_objective", "what is measured at each time")?;
        if self.at_the_end(term)? {
            return self.of_state(term, &state, &title, weight);
        }
        term.leave("the state is measured at the end of the scene only");
        Ok(())
    }

    /// Whether an integral over time is, or nearly is, the state at the end.
    fn at_the_end(&mut self, term: &Key) -> Result<bool> {
        let kind = term.get("integral_type").map(|k| k.becomes("the end of the scene"));
        if kind.as_ref().is_some_and(|k| k.value == "final") {
            return Ok(true);
        }
        let Some(steps) = term.get("steps").filter(|_| kind.is_some_and(|k| k.value == "steps"))
        else {
            return Ok(false);
        };
        let listed = steps.ids()?;
        let last = self.scene.steps as i64;
        let near = listed.iter().any(|&step| step + 1 >= last && step <= last);
        if near && listed != [last] {
            self.notes.push(format!(
                "{}: {}: measured at the end of the scene, step {last}, in place of steps {}",
                steps.document.path.display(),
                steps.pointer,
                steps.value
            ));
        }
        let _ = steps.becomes("the end of the scene");
        Ok(near)
    }

    /// Writes what is measured at a state; `term` is left out if there is nothing
    /// like it here.
    fn of_state(&mut self, term: &Key, state: &Key, title: &str, weight: f64) -> Result<()> {
        let kind = state.need("type", "the kind of term")?.becomes("kind");
        let length = |name: &str, what: &str, becomes: &str| -> Result<f64> {
            state.need(name, what)?.becomes(becomes).positive()
        };
        let selected = |name: &str| -> Result<Vec<i64>> {
            state.need(name, "ids of selections")?.becomes("on").ids()
        };
        match kind.text()? {
            "mesh-target" => {
                let file = state.need("mesh_path", "the target surface")?.becomes("target");
                let target = self.target(&file)?;
                let spacing = length("delta", "the spacing of the lattice [m]", "spacing")?;
                for on in self.on_all(term, &selected("surface_selection")?) {
                    self.objective("target", title, weight).name("on", &on);
                    self.text.name("target", &target).number("spacing", spacing);
                }
            }
            "layer_thickness_log" => {
                let minimum = length("dmin", "the thinnest wall [m]", "minimum")?;
                let activation = length("dhat", "where the barrier begins [m]", "activation")?;
                let ids = selected("boundary_ids")?;
                for (i, &id) in ids.iter().enumerate() {
                    let against: Vec<String> =
                        ids[i + 1..].iter().flat_map(|&other| self.tags(other)).collect();
                    if against.is_empty() {
                        continue;
                    }
                    for on in self.on_all(term, &[id]) {
                        self.objective("wall-thickness", title, weight).name("on", &on);
                        let against = list(against.iter().map(|tag| quoted(tag)));
                        self.text.key("against", &against);
                        self.text.number("minimum", minimum).number("activation", activation);
                    }
                }
            }
            "layer_thickness" => term.leave(
                "of wall thickness, only the form with a smallest thickness is here \
                 (layer_thickness_log)",
            ),
            "collision_barrier" => {
                let activation = length("dhat", "where the barrier begins [m]", "activation")?;
                self.objective("clearance", title, weight).number("activation", activation);
            }
            "boundary_smoothing" => {
                let power = state.get("power").map(|k| k.becomes("smoothness").number());
                let invariant =
                    state.get("scale_invariant").map(|k| k.becomes("smoothness").flag());
                let ids = selected("surface_selection")?;
                if power.transpose()? != Some(2.0) || invariant.transpose()? != Some(true) {
                    term.leave("smoothness is scale-invariant and quadratic here");
                    return Ok(());
                }
                for on in self.on_all(term, &ids) {
                    self.objective("smoothness", title, weight).name("on", &on);
                }
            }
            _ => term.leave("there is no such objective here"),
        }
        Ok(())
    }

    /// The tags with any of these ids; without one, the term is left out.
    fn on_all(&self, term: &Key, ids: &[i64]) -> Vec<String> {
        let tags: Vec<String> = ids.iter().flat_map(|&id| self.tags(id)).collect();
        if tags.is_empty() {
            term.leave("no body has a facet with this id");
        }
        tags
    }

    /// Begins a term with a name that no other has.
    fn objective(&mut self, kind: &str, title: &str, weight: f64) -> &mut Text {
        let mut name = title.to_owned();
        for number in 2.. {
            if !self.names.contains(&name) {
                break;
            }
            name = format!("{title} {number}");
        }
        self.names.push(name.clone());
        self.text.table("[[objective]]").name("kind", kind).name("name", &name);
        self.text.number("weight", weight)
    }

    /// Remembers a target surface; its path in our folder.
    fn target(&mut self, key: &Key) -> Result<String> {
        let path = key.file()?;
        mesh::io::read_surface(&path).map_err(|e| key.wrong(&e.to_string()))?;
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let ours = format!("targets/{name}");
        match self.targets.iter().find(|t| t.name == ours).map(|t| &t.from) {
            Some(same) if *same == path => return Ok(ours),
            Some(other) => {
                let what = format!("another target is called {name}: {}", other.display());
                return Err(key.wrong(&what));
            }
            None => {}
        }
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        self.targets.push(TargetFile { from: path, name: ours.clone(), bytes });
        Ok(ours)
    }
}

fn count_of(weights: &Key) -> String {
    weights.get("num_vertices").map(|k| k.value.to_string()).unwrap_or_default()
}

/// Number of vertices on the facets with an id.
fn vertices(solid: &Solid, id: i64) -> i64 {
    let number = solid.tags.id(&tag(id)).unwrap_or_default();
    let mut all: Vec<usize> = solid.tags.facets_of(number).into_iter().flatten().collect();
    all.sort_unstable();
    all.dedup();
    all.len() as i64
}
