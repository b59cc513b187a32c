//! What programs write: states, pictures for ParaView, and the report.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use measure::probe::{Probe, measure};
use measure::quantity::Kind;
use mechanics::body::Body;
use mechanics::contact::surface::BodyForce;
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{Chamber, Energies, Iterate, Membrane, Term};
use mechanics::forward::{LoadStep, Problem};
use mechanics::material::Kinematics;
use mechanics::symmetry::{AXES, Plane};
use mesh::Vec3;
use mesh::io::{npy, vtu};
use program::{InputFile, Settings};
use scene::{Scene, SceneMembrane};
use serde::Serialize;
use serde_json::{Value, json};

use crate::report::fields::fields;

/// Measures of one tag.
#[derive(Clone, Debug, Serialize)]
pub struct TagReport {
    /// Rest area [m²].
    pub area: f64,
    /// Force of the support on the body [N]; zero along axes that are free. A
    /// node on the rim of several fixed tags counts for the first of them.
    pub reaction: [f64; 3],
    /// Mean length of the displacement over the rest area [m].
    pub mean_displacement: f64,
    /// Mean displacement over the rest area [m].
    pub mean_displacement_vector: [f64; 3],
    /// Largest displacement of a node [m].
    pub max_displacement: f64,
}

/// Measures of one chamber.
#[derive(Clone, Debug, Serialize)]
pub struct ChamberReport {
    /// Volume behind the rest wall; an open one is closed by a cap over its rim
    /// [m³].
    pub volume_rest: f64,
    /// Volume behind the deformed wall [m³].
    pub volume: f64,
    /// Gauge pressure [Pa].
    pub pressure: f64,
    /// Whether the wall is closed.
    pub closed: bool,
}

/// What a report in a folder says of the files that the result was made from, each by its kind,
/// and of what was set from outside.
///
/// # Errors
/// When a mesh cannot be read.
pub fn provenance(
    folder: &Path,
    files: &[(&str, &Settings)],
    scene: &Scene,
) -> Result<(Value, Vec<String>)> {
    let meshes = scene.parts.iter().map(|part| InputFile::new(&part.mesh_path, folder));
    let mut inputs = json!({ "mesh": one_or_list(meshes.collect::<Result<Vec<_>, _>>()?) });
    let mut included = Vec::new();
    for (kind, file) in files {
        inputs[*kind] = json!(file.file().seen_from(folder));
        included.extend(file.included().iter().map(|file| file.seen_from(folder)));
    }
    if !included.is_empty() {
        inputs["included"] = json!(included);
    }
    Ok((inputs, files.iter().flat_map(|(_, file)| file.changes()).collect()))
}

/// What is reported of each body: alone where there is one.
pub fn one_or_list<T: Serialize>(values: Vec<T>) -> Value {
    if let [one] = &values[..] { json!(one) } else { json!(values) }
}

/// Measures every tag that has facets at an equilibrium.
///
/// # Errors
/// When a tag has no facets.
pub fn tags(
    scene: &Scene,
    body: &Body,
    problem: &Problem,
    at: &Iterate,
) -> Result<BTreeMap<String, TagReport>> {
    let reactions = reactions(scene, body, problem, at)?;
    let mut reports = BTreeMap::new();
    for name in body.used_tags() {
        let mut report = displacements(body, at.space, &body.facets(name)?, at.u);
        if let Some(reaction) = reactions.get(name) {
            report.reaction = *reaction;
        }
        reports.insert(name.clone(), report);
    }
    Ok(reports)
}

/// Reaction force of each support on the body [N], in the components that it fixes.
fn reactions(
    scene: &Scene,
    body: &Body,
    problem: &Problem,
    at: &Iterate,
) -> Result<BTreeMap<String, [f64; 3]>> {
    let (gradient, _) = problem.gradient(at);
    let held = scene.supports(body, at.space)?.by_tag();
    let reaction = |dofs: Vec<usize>| {
        let mut sum = [0.0; 3];
        dofs.iter().for_each(|&dof| sum[dof % 3] += gradient[dof]);
        sum
    };
    Ok(held.into_iter().map(|(tag, dofs)| (tag, reaction(dofs))).collect())
}

/// Area and displacements of the facets of a tag.
#[must_use]
pub fn displacements(
    body: &Body,
    space: &FunctionSpace,
    facets: &[[usize; 3]],
    u: &[f64],
) -> TagReport {
    let table = space.facet_table();
    let (mut area, mut length, mut vector, mut largest) = (0.0, 0.0, Vec3::zeros(), 0.0_f64);
    for &facet in facets {
        let ids = space.facet_nodes(facet);
        let [a, b, c] = facet.map(|v| body.mesh.vertices[v]);
        let facet_area = mesh::measure::triangle_area(a, b, c);
        area += facet_area;
        for (values, weight) in table.values.iter().zip(&table.weights) {
            let here: Vec3 = ids.iter().zip(values).map(|(&n, v)| at(u, n) * *v).sum();
            length += facet_area * weight * here.norm();
            vector += facet_area * weight * here;
        }
        largest = ids.iter().map(|&n| at(u, n).norm()).fold(largest, f64::max);
    }
    TagReport {
        area,
        reaction: [0.0; 3],
        mean_displacement: length / area,
        mean_displacement_vector: (vector / area).into(),
        max_displacement: largest,
    }
}

/// Measures of one load step: the step, its chambers, reactions, balance of
/// forces and energies; of one with the velocity `v` [m/s] the kinetic one, too.
///
/// # Errors
/// When a tag is missing.
pub fn step(
    scene: &Scene,
    body: &Body,
    problem: &Problem,
    step: &LoadStep,
    v: Option<&[f64]>,
) -> Result<Value> {
    let (energies, at) = (&problem.energies, step.iterate(problem, &body.mesh.vertices));
    let mut report = json!(step);
    report["t"] = json!(step.time);
    if scene.config.time.is_some()
        && let Some(report) = report.as_object_mut()
    {
        // there is no full load of which it would be a fraction
        report.remove("load");
    }
    report["chambers"] = json!(chambers(energies, &at));
    let mut moved = BTreeMap::new();
    for name in body.used_tags() {
        let report = displacements(body, at.space, &body.facets(name)?, at.u);
        moved.insert(name.clone(), report.mean_displacement_vector);
    }
    report["mean_displacement"] = json!(moved);
    report["reactions"] = json!(reactions(scene, body, problem, &at)?);
    report["force_balance"] = balance(problem, &at);
    report["energies"] = json!(stored_energies(energies, &at));
    if let Some(v) = v {
        report["energies"]["kinetic"] = json!(kinetic_energy(energies, at.space, at.rest, v));
        let momentum = momentum(energies, at.space, at.rest, v);
        report["momentum"] = json!(<[f64; 3]>::from(momentum));
    }
    if let Some(collisions) = collisions(scene, energies, &at) {
        report["collisions"] = collisions;
    }
    Ok(report)
}

/// ½ vᵀ M v of all bodies with inertia [J].
#[must_use]
pub fn kinetic_energy(energies: &Energies, space: &FunctionSpace, rest: &[Vec3], v: &[f64]) -> f64 {
    energies.inertia().map(|i| i.kinetic_energy(space, rest, v)).sum()
}

/// ∫ ρ v dX of all bodies with inertia [kg m/s].
#[must_use]
pub fn momentum(energies: &Energies, space: &FunctionSpace, rest: &[Vec3], v: &[f64]) -> Vec3 {
    energies.inertia().map(|i| i.momentum(space, rest, v)).sum()
}

/// Measures every chamber.
#[must_use]
pub fn chambers(energies: &Energies, at: &Iterate) -> BTreeMap<String, ChamberReport> {
    let report = |chamber: &Chamber| {
        let (volume, gas) = chamber.state(at);
        let volume_rest = chamber.rest_volume(at);
        let closed = chamber.wall.is_closed();
        ChamberReport { volume_rest, volume, pressure: gas.pressure, closed }
    };
    let chambers = energies.chambers();
    chambers.map(|(_, named)| (named.name.clone(), report(&named.chamber))).collect()
}

/// Thickness, law and measures of every sheet, in the order of the scene.
#[must_use]
pub fn membranes(scene: &Scene, energies: &Energies, at: &Iterate) -> Value {
    let one = |(membrane, energy): (&SceneMembrane, &Membrane)| {
        let mut row = json!(energy.summary(at));
        row["on"] = json!(membrane.config.on);
        row["kind"] = json!(membrane.material.law.key);
        row["tension_only"] = json!(membrane.config.tension);
        row["thickness"] = json!(membrane.thickness);
        row
    };
    scene.membranes.iter().zip(&energies.membranes).map(one).collect()
}

/// Kind, unit and value of every probe.
#[must_use]
pub fn probes(probes: &[Probe], problem: &Problem, at: &Iterate) -> Value {
    let values = measure(probes, problem, at);
    let row = |probe: &Probe| {
        let Kind { key, unit, .. } = probe.kind;
        let row = json!({ "kind": key, "unit": unit, "value": values[&probe.name] });
        (probe.name.clone(), row)
    };
    probes.iter().map(row).collect()
}

/// Energies of a state by kind, and their sum `total` [J]. What inertia and
/// friction add to the potential of a step in time is none.
#[must_use]
pub fn stored_energies(energies: &Energies, at: &Iterate) -> BTreeMap<&'static str, f64> {
    // those that a scene may lack are reported, too
    let mut stored = BTreeMap::from([("elastic", 0.0), ("chamber", 0.0), ("total", 0.0)]);
    for Term { energy, .. } in energies.terms().filter(|term| term.kind.is_stored()) {
        let value = energy.value(at);
        *stored.entry(energy.name()).or_insert(0.0) += value;
        *stored.entry("total").or_insert(0.0) += value;
    }
    stored
}

/// Resultants of the loads by kind and of the reactions [N]; the norm of their
/// sum is `out_of_balance`.
#[must_use]
pub fn balance(problem: &Problem, state: &Iterate) -> Value {
    let nodes = state.space.node_count();
    let resultant = |v: &[f64]| (0..nodes).map(|i| at(v, i)).sum::<Vec3>();
    let mut loads = BTreeMap::from([("chamber", Vec3::zeros())]);
    // elastic forces have no resultant
    for Term { energy, .. } in problem.energies.terms().filter(|term| !term.kind.is_elastic()) {
        let mut gradient = vec![0.0; state.u.len()];
        energy.add_gradient(state, &mut gradient);
        *loads.entry(energy.name()).or_default() -= resultant(&gradient);
    }
    let (gradient, _) = problem.gradient(state);
    loads.insert("reaction", resultant(&gradient));
    let sum: Vec3 = loads.values().sum();
    let mut report: BTreeMap<&str, Value> =
        loads.into_iter().map(|(name, f)| (name, json!(<[f64; 3]>::from(f)))).collect();
    report.insert("out_of_balance", json!(sum.norm()));
    json!(report)
}

/// Writes nodes and displacements exactly: two arrays of shape (nodes, 3) [m].
///
/// # Errors
/// When a file cannot be written.
pub fn write_state(folder: &Path, space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Result<()> {
    write_arrays(folder, &space.node_positions(rest), u)
}

/// Writes nodes and displacements exactly, from the positions of the nodes at rest [m].
///
/// # Errors
/// When a file cannot be written.
pub fn write_arrays(folder: &Path, nodes: &[Vec3], u: &[f64]) -> Result<()> {
    let shape = [nodes.len(), 3];
    let nodes: Vec<f64> = nodes.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    npy::write_f64(&folder.join("nodes.npy"), &nodes, &shape)?;
    npy::write_f64(&folder.join("displacement.npy"), u, &shape)?;
    Ok(())
}

/// Forces between surfaces at a state: how close they are, and for each pair of
/// bodies the force on the first [N] and the sum of its magnitudes; none where the
/// scene has no contact.
#[must_use]
pub fn collisions(scene: &Scene, energies: &Energies, at: &Iterate) -> Option<Value> {
    let contact = energies.contact.as_ref()?;
    let names = scene.surface_names();
    let gaps = contact.gaps(at);
    let report = |forces: Vec<BodyForce>| -> Vec<Value> {
        let one = |f: BodyForce| {
            json!({
                "bodies": f.bodies.map(|b| names[b]),
                "force": <[f64; 3]>::from(f.force),
                "magnitude": f.magnitude,
            })
        };
        forces.into_iter().map(one).collect()
    };
    let friction = energies.friction.as_ref();
    Some(json!({
        "pairs": gaps.pairs,
        "smallest_gap": gaps.smallest.is_finite().then_some(gaps.smallest),
        "contact": report(contact.body_forces(at)),
        "friction": report(friction.map_or_else(Vec::new, |f| f.body_forces(at))),
    }))
}

/// [`grid`] with strains and stresses, and with the forces of contact and friction on the
/// nodes [N].
#[must_use]
pub fn grid_with_fields(energies: &Energies, at: &Iterate) -> vtu::Grid {
    let mut grid = grid(at.space, at.rest, at.u);
    let [at_points, of_cells] = fields(energies, at);
    grid.point_fields.extend(at_points);
    grid.cell_fields.extend(of_cells);
    for energy in energies.contact_terms() {
        let mut values = vec![0.0; at.u.len()];
        energy.add_gradient(at, &mut values);
        values.iter_mut().for_each(|f| *f = -*f);
        let (name, unit) = (format!("{}_force", energy.name()), "N".to_owned());
        grid.point_fields.push(vtu::Field { name, unit, components: 3, values });
    }
    grid
}

/// The body with its displacement, and the mean of J over each element.
#[must_use]
pub fn grid(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> vtu::Grid {
    let types = [vtu::CellType::Tet4, vtu::CellType::Tet10, vtu::CellType::Tet20];
    let cell_type = types[space.degree() - 1];
    let field = |name: &str, unit: &str, components, values| vtu::Field {
        name: name.to_owned(),
        unit: unit.to_owned(),
        components,
        values,
    };
    vtu::Grid {
        points: space.node_positions(rest),
        cells: space.element_nodes().to_vec(),
        cell_type,
        point_fields: vec![field("displacement", "m", 3, u.to_vec())],
        cell_fields: vec![field("volume_ratio", "1", 1, mean_volume_ratio(space, rest, u))],
    }
}

fn mean_volume_ratio(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Vec<f64> {
    let weights = &space.volume_table().weights;
    let one = |e: usize| {
        let points = space.displacement_gradients(rest, u, e).zip(weights);
        points.map(|(grad_u, weight)| weight * Kinematics::new(&grad_u).j()).sum()
    };
    (0..space.tets().len()).map(one).collect()
}

/// Planes of symmetry of a body, for `solver mirror`.
#[must_use]
pub fn symmetry(body: &Body) -> Value {
    let one =
        |plane: &Plane| json!({ "on": plane.tags, "axis": AXES[plane.axis], "level": plane.level });
    body.planes.iter().map(one).collect()
}
