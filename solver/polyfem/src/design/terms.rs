//! Terms of the objective of a run file.

use anyhow::Result;

use super::{TargetFile, Writer, names};
use crate::document::Key;
use crate::text::{Text, list, number, quoted, unused};

/// A term of the objective.
struct Term<'a> {
    key: &'a Key<'a>,
    title: String,
    weight: f64,
    /// The value of `over`, if it is not the default.
    over: Option<String>,
}

impl Writer<'_> {
    /// Writes a term of the objective if there is one like it here.
    pub(super) fn term(&mut self, term: &Key) -> Result<()> {
        let weight = term.optional("weight", Key::number)?.unwrap_or(1.0);
        let kind = term.need("type", "the kind of term")?.text()?;
        let (state, over) = if kind == "transient_integral" {
            let Some(over) = self.over(term)? else { return Ok(()) };
            (term.need("static_objective", "what is measured at each time")?, over)
        } else {
            (term.clone(), None)
        };
        let title = match term.get("print_energy") {
            Some(key) => key.text()?,
            None => state.need("type", "the kind of term")?.text()?,
        };
        let title = title.to_owned();
        self.of_state(Term { key: term, title, weight, over }, &state)
    }

    /// The value of `over`, none for the end of the scene; nothing if the term is
    /// left out.
    fn over(&mut self, term: &Key) -> Result<Option<Option<String>>> {
        let kind = term.need("integral_type", "how to sum over time")?;
        Ok(Some(match kind.text()? {
            "final" => None,
            "uniform" => Some(quoted("uniform")),
            "trapezoidal" => Some(quoted("trapezoid")),
            "simpson" => {
                self.notes.push(format!(
                    "{}: {}: Simpson's rule, whose weights inside are wrong in some versions of \
                     PolyFEM, is that of the books here",
                    term.document.path.display(),
                    kind.pointer
                ));
                Some(quoted("simpson"))
            }
            "steps" => {
                let steps = term.need("steps", "the time steps")?.ids()?;
                let last = self.scene.steps as i64;
                if let Some(step) = steps.iter().find(|&&step| step < 1 || step > last) {
                    term.leave(&format!("the scene has no step {step}: its steps are 1 to {last}"));
                    return Ok(None);
                }
                let steps = list(steps.iter().map(ToString::to_string));
                Some(format!("{{ steps = {steps} }}"))
            }
            _ => {
                term.leave("over time there are final, steps, uniform, trapezoid and simpson here");
                return Ok(None);
            }
        }))
    }

    /// Writes what is measured at a state; the term is left out if there is nothing
    /// like it here.
    fn of_state(&mut self, term: Term, state: &Key) -> Result<()> {
        let kind = state.need("type", "the kind of term")?.text()?;
        if term.weight < 0.0 && !kind.ends_with("contact_force_norm") {
            term.key.leave("weights are not negative here, but of contact forces");
            return Ok(());
        }
        match kind {
            "mesh-target" => self.mesh_target(term, state),
            "displacement-target" => self.displacement(term, state),
            "log_contact_force_norm" => self.contact_force(term, state, "log"),
            "quadratic_contact_force_norm" => self.contact_force(term, state, "quadratic"),
            "layer_thickness_log" => self.thickness(term, state, "log"),
            "layer_thickness" => self.thickness(term, state, "quadratic"),
            "boundary_smoothing" => self.smoothness(term, state),
            "collision_barrier" => {
                let activation = dhat(state)?;
                self.objective("clearance", &term).number("activation", activation);
                Ok(())
            }
            _ => {
                term.key.leave("there is no such objective here");
                Ok(())
            }
        }
    }

    fn mesh_target(&mut self, term: Term, state: &Key) -> Result<()> {
        let file = state.need("mesh_path", "the target surface")?;
        let target = self.target(&file)?;
        let spacing = state.need("delta", "the spacing of the lattice [m]")?.positive()?;
        let Some(on) = self.on_all(&term, &selected(state, "surface_selection")?) else {
            return Ok(());
        };
        let term = self.per_thickness(term);
        self.objective("target", &term).key("on", &names(&on));
        self.text.name("target", &target).name("distance", "unsigned");
        self.text.number("spacing", spacing);
        Ok(())
    }

    fn displacement(&mut self, term: Term, state: &Key) -> Result<()> {
        let wanted = state.need("target_displacement", "the wanted displacement [m]")?;
        let mut wanted: Vec<f64> = wanted.items().iter().map(Key::number).collect::<Result<_>>()?;
        wanted.resize(3, 0.0);
        let mut components = "xyz"[..if self.planar() { 2 } else { 3 }].to_owned();
        if let Some(active) = state.get("active_dimension") {
            let flags: Vec<bool> = active.items().iter().map(Key::flag).collect::<Result<_>>()?;
            let named = "xyz".chars().zip(flags).filter(|(_, active)| *active);
            components = named.map(|(axis, _)| axis).collect();
        }
        let Some(on) = self.on_all(&term, &selected(state, "surface_selection")?) else {
            return Ok(());
        };
        let term = self.per_thickness(term);
        self.objective("displacement", &term).key("on", &names(&on));
        self.text.key("displacement", &list(wanted.into_iter().map(number)));
        self.text.name("components", &components);
        Ok(())
    }

    fn contact_force(&mut self, term: Term, state: &Key, density: &str) -> Result<()> {
        let activation = dhat(state)?;
        let Some(on) = self.on_all(&term, &selected(state, "surface_selection")?) else {
            return Ok(());
        };
        if on.len() < 2 {
            term.key.leave("forces act between two tags or more");
            return Ok(());
        }
        self.objective("contact-proxy", &term).key("on", &names(&on)).name("density", density);
        self.text.number("activation", activation);
        Ok(())
    }

    fn thickness(&mut self, term: Term, state: &Key, density: &str) -> Result<()> {
        let minimum = state.optional("dmin", Key::positive)?;
        let activation = dhat(state)?;
        let ids = selected(state, "boundary_ids")?;
        let Some(on) = self.on_all(&term, &ids) else { return Ok(()) };
        if on.len() < 2 {
            term.key.leave("a wall is between two tags or more");
            return Ok(());
        }
        self.objective("wall-thickness", &term).key("on", &names(&on)).name("density", density);
        match (density, minimum) {
            ("log", Some(minimum)) => drop(self.text.number("minimum", minimum)),
            ("log", None) => return Err(state.wrong("there is no \"dmin\", the thinnest wall [m]")),
            _ => {}
        }
        self.text.number("activation", activation);
        Ok(())
    }

    fn smoothness(&mut self, term: Term, state: &Key) -> Result<()> {
        let power = state.optional("power", Key::number)?;
        let invariant = state.optional("scale_invariant", Key::flag)?;
        let ids = selected(state, "surface_selection")?;
        if power != Some(2.0) || invariant != Some(true) {
            term.key.leave("smoothness is scale-invariant and quadratic here");
            return Ok(());
        }
        let Some(on) = self.on_all(&term, &ids) else { return Ok(()) };
        self.objective("smoothness", &term).key("on", &names(&on));
        Ok(())
    }

    /// The tags with any of these ids; none, and the term is left out, without one.
    fn on_all(&self, term: &Term, ids: &[i64]) -> Option<Vec<String>> {
        let tags = self.scene.geometry.tags(ids);
        if tags.is_empty() {
            term.key.leave("no body has a facet with this id");
            return None;
        }
        Some(tags)
    }

    fn planar(&self) -> bool {
        self.scene.geometry.thickness.is_some()
    }

    /// Integrals over curves in the plane are over areas of slabs here.
    fn per_thickness<'k>(&mut self, mut term: Term<'k>) -> Term<'k> {
        if let Some(thickness) = self.scene.geometry.thickness {
            self.notes.push(format!(
                "{}: {}: weight {} over the thickness of the slab, {thickness} m",
                term.key.document.path.display(),
                term.key.pointer,
                term.weight
            ));
            term.weight /= thickness;
        }
        term
    }

    /// Begins a term with a name that no other has.
    fn objective(&mut self, kind: &str, term: &Term) -> &mut Text {
        let name = unused(&term.title, ' ', &mut self.names);
        self.text.table("[[objective]]").name("kind", kind).name("name", &name);
        self.text.number("weight", term.weight);
        match &term.over {
            Some(over) => self.text.key("over", over),
            None => &mut self.text,
        }
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
        let bytes = mesh::io::read_bytes(&path)?;
        self.targets.push(TargetFile { from: path, name: ours.clone(), bytes });
        Ok(ours)
    }
}

fn dhat(state: &Key) -> Result<f64> {
    state.need("dhat", "where the barrier begins [m]")?.positive()
}

fn selected(state: &Key, name: &str) -> Result<Vec<i64>> {
    state.need(name, "ids of selections")?.ids()
}
