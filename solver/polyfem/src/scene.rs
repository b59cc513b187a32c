//! A state file: bodies, materials, loads, contact and time steps.

use ::scene::config::ContactForm;
use anyhow::Result;
use toml::{Table, Value};

use super::Options;
use super::document::{Document, Key};
use super::geometry::{self, Geometry};
use super::loads::{self, Setting};
use super::material::material;
use super::tables::{push, table};
use super::value::Clock;

/// Why keys of a state file have no part in our scene. `*` is any word.
pub const REASONS: &[(&str, &str)] = &[
    ("/output", "solver simulate writes its own files"),
    ("/solver/linear", "there is one factorisation here, which chooses its own ordering"),
    (
        "/solver/nonlinear",
        "the modified Newton method here has settings of its own, table [solver]",
    ),
    ("/solver/augmented_lagrangian", "supports have settings of their own here"),
    ("/solver/contact/CCD", "the step bound here has no settings"),
    ("/space/advanced/n_boundary_samples", "surface terms are integrated exactly here"),
    ("/geometry/*/advanced", "settings of a reader of meshes"),
    ("/geometry/*/extract", "settings of a reader of meshes"),
    ("/tests", "results of tests, not of the scene"),
    ("/authors", "not part of the scene"),
];

/// Friction is full from this sliding speed on if nothing else is said, as
/// PolyFEM assumes it [m/s].
const FRICTION_SPEED: f64 = 1e-3;
/// Stiffness of the barrier where theirs adapts itself.
const STIFFNESS: f64 = 1e5;

/// A scene of ours.
pub struct Translated {
    /// The comments at the top of `sim.toml` ...
    pub comments: String,
    /// ... and what it holds.
    pub values: Table,
    /// The bodies.
    pub geometry: Geometry,
    /// What the user should know beside the keys.
    pub notes: Vec<String>,
}

/// Reads a state file.
pub fn read(document: &Document, options: &Options) -> Result<Translated> {
    let root = document.root();
    let mut notes = Vec::new();
    let bodies = root.need("geometry", "the list of bodies")?;
    let mut geometry = geometry::read(&bodies, options.thickness)?;
    let clock = clock(&root, geometry.thickness.is_some())?;
    let conditions = root.get("boundary_conditions");
    let materials = root.need("materials", "the laws of the bodies")?;
    let dimension = if clock.planar { 2 } else { 3 };
    let velocity = |solid| loads::velocity(&root, solid, dimension);
    let velocities = geometry.solids.iter().map(velocity).collect::<Result<Vec<_>>>()?;
    let moving = velocities.iter().any(Option::is_some);
    geometry.several = geometry.solids.len() > 1 || clock.planar || moving;
    let at = Setting { geometry: &geometry, clock: &clock };

    let mut scene = Table::new();
    degrees(&root, &mut scene)?;
    if let Some(gravity) = loads::gravity(conditions.as_ref(), &at)? {
        scene.insert("gravity".to_owned(), gravity);
    }
    for (solid, velocity) in geometry.solids.iter().zip(velocities) {
        let law = material(&materials, solid.volume, clock.planar)?;
        let mesh = format!("{}.msh", solid.name);
        let mut body = table([("mesh", mesh.into()), ("material", law.into())]);
        if let Some(velocity) = velocity {
            body.insert("velocity".to_owned(), velocity.into());
        }
        if geometry.several {
            body.insert("name".to_owned(), solid.name.clone().into());
            push(&mut scene, "body", body);
        } else {
            scene.extend(body);
        }
    }
    for key in materials.items() {
        let ids = key.optional("id", Key::ids)?.unwrap_or_default();
        if !ids.is_empty() && geometry.solids.iter().all(|s| !ids.contains(&s.volume)) {
            key.leave("no body is made of it");
        }
    }
    loads::add_obstacles(conditions.as_ref(), &at, &mut scene)?;
    loads::add(conditions.as_ref(), &at, &mut scene)?;
    contact(&root, options.form, &mut scene, &mut notes)?;
    time(&root, &clock, &mut scene)?;
    if let Some(thickness) = geometry.thickness {
        notes.push(format!(
            "the plane bodies became slabs in plane strain, {thickness:.6} m thick; energies, \
             forces and volumes are those of this depth"
        ));
    }
    if options.thickness.is_some() && geometry.thickness.is_none() {
        notes.push("the thickness of slabs has no part in it: its bodies are not plane".to_owned());
    }
    Ok(Translated { comments: comments(document, &geometry), values: scene, geometry, notes })
}

/// The comments at the top of `sim.toml`.
fn comments(document: &Document, geometry: &Geometry) -> String {
    let name = document.path.file_name().unwrap_or_default().to_string_lossy();
    let from = format!(
        "# From {name} by solver import; what has no part in it is in import.report.json.\n"
    );
    let plane = geometry.thickness.map(|thickness| {
        format!(
            "# A plane scene: slabs {thickness} m thick in plane strain; \"{}\" is their front and back.\n",
            geometry::FACES
        )
    });
    from + &plane.unwrap_or_default() + "\n"
}

/// Polynomial degree and quadrature.
fn degrees(root: &Key, scene: &mut Table) -> Result<()> {
    let space = root.get("space");
    let order = space.as_ref().and_then(|s| s.get("discr_order"));
    // as PolyFEM assumes it
    let degree = order.as_ref().map_or(Ok(1), Key::count)?;
    if let Some(key) = order.filter(|_| !(1..=3).contains(&degree)) {
        return Err(key.wrong(&format!("{degree}: expected 1, 2 or 3")));
    }
    scene.insert("degree".to_owned(), Value::try_from(degree)?);
    let advanced = space.as_ref().and_then(|s| s.get("advanced"));
    if let Some(key) = advanced.and_then(|a| a.get("quadrature_order")) {
        let order = key.count()?;
        if (5..=12).contains(&order) {
            scene.insert("quadrature".to_owned(), Value::try_from(order)?);
        } else {
            key.leave("energies are integrated to a degree from 5 to 12 here; 5 if not said");
        }
    }
    Ok(())
}

/// The time steps.
fn clock(root: &Key, planar: bool) -> Result<Clock> {
    let Some(time) = root.get("time") else { return Ok(Clock { planar, ..Clock::default() }) };
    let start = time.optional("t0", Key::number)?.unwrap_or(0.0);
    let end = time.optional("tend", Key::number)?;
    let step = time.optional("dt", Key::positive)?;
    let count = time.optional("time_steps", Key::count)?;
    let (steps, step) = match (end, step, count) {
        // the last step may be shorter in our count, never in theirs
        (Some(end), Some(step), None) => (((end - start) / step - 1e-9).ceil(), step),
        (Some(end), None, Some(count)) => (count as f64, (end - start) / count as f64),
        (None, Some(step), Some(count)) => (count as f64, step),
        (Some(_), Some(step), Some(count)) => (count as f64, step),
        _ => return Err(time.wrong("expected two of tend [s], dt [s] and time_steps")),
    };
    if !((1.0..1e6).contains(&steps) && step > 0.0) {
        return Err(
            time.wrong(&format!("{steps} steps of {step} s: expected 1 to 10⁶ of positive length"))
        );
    }
    // as it was written if that is the same, and as our scene counts its steps
    let written = end.map(|end| end - start).filter(|end| (end - steps * step).abs() < 1e-9 * step);
    let last = written.unwrap_or(steps * step);
    let ends = (1..=steps as usize).map(|n| last * (n as f64 / steps)).collect();
    Ok(Clock { start, ends, planar })
}

fn time(root: &Key, clock: &Clock, scene: &mut Table) -> Result<()> {
    let (Some(time), Some(end)) = (root.get("time"), clock.ends.last()) else { return Ok(()) };
    let mut method = "implicit-euler".to_owned();
    if let Some(integrator) = time.get("integrator") {
        let kind = integrator.get("type").unwrap_or_else(|| integrator.clone());
        let steps = integrator.optional("steps", Key::count)?.unwrap_or(1);
        method = match (kind.text()?, steps) {
            ("ImplicitEuler" | "BDF" | "BDF1", 1) => method,
            ("BDF", 2) | ("BDF2", _) => "bdf2".to_owned(),
            ("BDF", 3) | ("BDF3", _) => "bdf3".to_owned(),
            _ => {
                return Err(integrator.wrong(&format!(
                    "{}: expected ImplicitEuler, or BDF with 1, 2 or 3 steps",
                    integrator.value
                )));
            }
        };
    }
    if time.optional("quasistatic", Key::flag)? == Some(true) {
        method = "quasistatic".to_owned();
    }
    let steps = Value::try_from(clock.ends.len())?;
    let table = table([("end", (*end).into()), ("steps", steps), ("method", method.into())]);
    scene.insert("time".to_owned(), table.into());
    Ok(())
}

fn contact(
    root: &Key,
    wanted: Option<ContactForm>,
    scene: &mut Table,
    notes: &mut Vec<String>,
) -> Result<()> {
    let solver = root.get("solver").and_then(|s| s.get("contact"));
    let contact = root.get("contact");
    let enabled = contact.as_ref().map_or(Ok(None), |c| c.optional("enabled", Key::flag))?;
    let Some(contact) = contact.filter(|_| enabled == Some(true)) else {
        for key in root.get("contact").into_iter().chain(solver) {
            key.leave("contact is off");
        }
        if wanted.is_some() {
            notes.push("the form of contact has no part in it: contact is off".to_owned());
        }
        return Ok(());
    };
    let activation = contact.need("dhat", "where the barrier begins [m]")?.positive()?;
    let written = contact.optional("use_convergent_formulation", Key::flag)?;
    let form = form(written.unwrap_or(false), wanted, notes);
    let stiffness = solver.as_ref().and_then(|s| s.get("barrier_stiffness"));
    let stiffness = match stiffness.filter(|k| k.value != "adaptive") {
        Some(key) => key.positive()?,
        None => {
            notes.push(format!(
                "the stiffness of the barrier adapts itself there and is fixed here: stiffness = \
                 {STIFFNESS:e}; raise it if surfaces come too close"
            ));
            STIFFNESS
        }
    };
    let mut table = table([
        ("form", Value::try_from(form)?),
        ("pairs", "all".into()),
        ("activation", activation.into()),
        ("stiffness", stiffness.into()),
    ]);
    if let Some(friction) = contact.optional("friction_coefficient", Key::number)? {
        let speed = contact.get("epsv");
        if friction > 0.0 {
            let speed = speed.as_ref().map_or(Ok(FRICTION_SPEED), Key::positive)?;
            table.insert("friction".to_owned(), friction.into());
            table.insert("friction_speed".to_owned(), speed.into());
        }
    }
    scene.insert("contact".to_owned(), table.into());
    if let Some(key) = solver.and_then(|s| s.get("friction_iterations"))
        && key.count()? != 1
    {
        key.leave("friction is lagged once per step here");
    }
    Ok(())
}

fn form(convergent: bool, wanted: Option<ContactForm>, notes: &mut Vec<String>) -> ContactForm {
    let written = if convergent { ContactForm::Convergent } else { ContactForm::Plain };
    if let Some(wanted) = wanted {
        return wanted;
    }
    if written == ContactForm::Plain {
        notes.push(
            "[contact] form = \"plain\", as the file says: its forces depend on the mesh; in an \
             optimisation the authors' program of 2024 uses --form convergent"
                .to_owned(),
        );
    }
    written
}
