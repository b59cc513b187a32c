//! What programs write: states, pictures for ParaView, and the report.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::Result;
use measure::probe::{Probe, measure};
use mechanics::body::Body;
use mechanics::contact::surface::BodyForce;
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{
    self, Energies, Friction, Iterate, Multiplier, Nature, Rigid, RigidLoad, RigidMass,
};
use mechanics::fields::{fields, volume_ratios};
use mechanics::forward::{LoadStep, Problem};
use mechanics::symmetry::{AXES, Plane};
use mesh::Vec3;
use mesh::io::npy;
use mesh::io::vtu::{self, Field};
use program::{InputFile, Settings};
use reports::{
    Chamber, Collisions, CutPlane, ForceBalance, Inputs, OneOrList, PairForce, RigidPart, Step,
    Tag, WINDINGS, numbers,
};
use scene::Scene;
use scene::config::SimConfig;
use scene::term::State;
use serde::Serialize;

use crate::report::stability;

/// Name of the file with a line for each step.
pub const STEPS: &str = "steps.jsonl";

/// Name of the table of steps.
pub const CURVE: &str = "curve.csv";

/// Strain of a whole body that is none but for rounding [1].
const NO_STRAIN: f64 = 1e-9;

/// Name of the file with the state before a load step that failed.
pub const FAILED: &str = "not_full_load.vtu";

/// What a report in a folder says of the files that the result was made from, and of what was set from
/// outside.
pub fn provenance(
    folder: &Path,
    design: Option<&Settings>,
    scene: &Scene,
) -> Result<(Inputs, Vec<String>)> {
    let meshes = scene.parts.iter().map(|part| InputFile::new(&part.mesh_path, folder));
    let files = || design.into_iter().chain([&scene.file]);
    let included = files().flat_map(|file| file.included());
    let inputs = Inputs {
        mesh: OneOrList::new(meshes.collect::<Result<Vec<_>, _>>()?),
        scene: scene.file.file().seen_from(folder),
        design: design.map(|file| file.file().seen_from(folder)),
        included: included.map(|file| file.seen_from(folder)).collect(),
        level_meshes: Vec::new(),
        targets: Vec::new(),
    };
    Ok((inputs, files().flat_map(|file| file.changes()).collect()))
}

/// Writes the report of a run, its keys in alphabetical order.
pub fn write_report(folder: &Path, report: &impl Serialize) -> Result<()> {
    program::write_json(&folder.join("report.json"), &serde_json::to_value(report)?)
}

/// Measures every tag that has facets at an equilibrium.
pub fn tags(
    scene: &Scene,
    body: &Body,
    problem: &Problem,
    at: &Iterate,
) -> Result<BTreeMap<String, Tag>> {
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
pub fn displacements(body: &Body, space: &FunctionSpace, facets: &[[usize; 3]], u: &[f64]) -> Tag {
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
    Tag {
        area,
        reaction: [0.0; 3],
        mean_displacement: length / area,
        mean_displacement_vector: (vector / area).into(),
        max_displacement: largest,
    }
}

/// Measures of one load step: the step, its chambers, reactions, balance of
/// forces, energies and probes; of one with the velocity `v` [m/s] the kinetic one, too. The loads have done
/// some work so far [J].
pub fn step(
    scene: &Scene,
    body: &Body,
    problem: &Problem,
    step: &LoadStep,
    v: Option<&[f64]>,
    (probes, work): (&[Probe], f64),
) -> Result<Step> {
    let (energies, at) = (&problem.energies, step.iterate(problem, &body.mesh.vertices));
    let mut mean_displacement = BTreeMap::new();
    for name in body.used_tags() {
        let report = displacements(body, at.space, &body.facets(name)?, at.u);
        mean_displacement.insert(name.clone(), report.mean_displacement_vector);
    }
    let mut stored = stored_energies(energies, &at);
    if let Some(v) = v {
        stored.insert("kinetic".to_owned(), kinetic_energy(energies, at.space, at.rest, v));
    }
    Ok(Step {
        t: step.time,
        // in time there is no full load of which it would be a fraction
        load: scene.config.time.is_none().then_some(step.time),
        newton_iterations: step.newton_iterations,
        residual: step.residual,
        residual_wanted: step.residual_wanted,
        rounding_floor: step.rounding_floor,
        smallest_volume_ratio: step.smallest_volume_ratio,
        chambers: chambers(energies, &at),
        mean_displacement,
        reactions: reactions(scene, body, problem, &at)?,
        rigid: rigid_parts(scene, energies, at.u),
        force_balance: balance(problem, &at),
        energies: stored,
        momentum: v.map(|v| momentum(energies, at.space, at.rest, v).into()),
        collisions: collisions(scene, energies, &at),
        work_of_loads: work,
        energy_gain: None,
        path: step.path.as_deref().map(stability::path_state),
        probes: (!probes.is_empty()).then(|| numbers(&measure(probes, problem, &at))),
    })
}

/// Rest before any load, where prescribed volumes need no pressure.
pub fn still(problem: &Problem) -> LoadStep {
    let relaxed = |m: &Multiplier| Multiplier { pressure: 0.0, ..*m };
    LoadStep {
        time: 0.0,
        newton_iterations: 0,
        residual: 0.0,
        residual_wanted: 0.0,
        rounding_floor: None,
        smallest_volume_ratio: 1.0,
        u: vec![0.0; problem.dofs()],
        multipliers: problem.multipliers.iter().map(relaxed).collect(),
        step: None,
        ends_time_step: true,
        path: None,
    }
}

/// Measures of the state at rest, if it is one of equilibrium without any load: the first point of curves. With inertia
/// loads may set in at once.
pub fn at_rest(scene: &Scene, problem: &Problem, probes: &[Probe]) -> Result<Option<Step>> {
    let (body, mut still) = (&scene.body, still(problem));
    let (gradient, _) = problem.gradient(&still.iterate(problem, &body.mesh.vertices));
    let free = problem.restrict(&gradient).iter().map(|g| g * g).sum::<f64>();
    still.residual = free.sqrt();
    let stiffest = scene.laws.iter().map(|law| law.material.moduli().shear).fold(0.0, f64::max);
    still.residual_wanted =
        NO_STRAIN * stiffest * mesh::measure::volume(&body.mesh).powf(2.0 / 3.0);
    let led = problem.dirichlet.displacement(0.0);
    let led = problem.dirichlet.supports().iter().any(|&dof| led[dof] != 0.0);
    if scene.config.method().has_inertia() || led || still.residual > still.residual_wanted {
        return Ok(None);
    }
    step(scene, body, problem, &still, None, (probes, 0.0)).map(Some)
}

/// ½ vᵀ M v of all bodies with inertia [J].
pub fn kinetic_energy(energies: &Energies, space: &FunctionSpace, rest: &[Vec3], v: &[f64]) -> f64 {
    let rigid = energies.each::<RigidMass>();
    let of_bodies: f64 = energies.inertia().map(|i| i.kinetic_energy(space, rest, v)).sum();
    of_bodies + rigid.map(|mass| mass.kinetic_energy(v)).sum::<f64>()
}

/// ∫ ρ v dX of all bodies with inertia [kg m/s].
pub fn momentum(energies: &Energies, space: &FunctionSpace, rest: &[Vec3], v: &[f64]) -> Vec3 {
    let rigid = energies.each::<RigidMass>();
    let of_bodies: Vec3 = energies.inertia().map(|i| i.momentum(space, rest, v)).sum();
    of_bodies + rigid.map(|mass| mass.momentum(v)).sum::<Vec3>()
}

/// How far each rigid part has moved and turned.
pub fn rigid_parts(scene: &Scene, energies: &Energies, u: &[f64]) -> BTreeMap<String, RigidPart> {
    let one = |(place, load): (usize, &RigidLoad)| {
        let turns = energies.of::<Rigid>(Rigid::owner(place));
        let rotation = turns.map(|own| own.rotation(u)).unwrap_or_default().into();
        let displacement = load.of_point(u).into();
        (scene.config.rigid[place].on.clone(), RigidPart { displacement, rotation })
    };
    energies.each().enumerate().map(one).collect()
}

/// Measures every chamber.
pub fn chambers(energies: &Energies, at: &Iterate) -> BTreeMap<String, Chamber> {
    let report = |chamber: &energy::Chamber| {
        let (volume, gas) = chamber.state(at);
        let volume_rest = chamber.rest_volume(at);
        let closed = chamber.wall.is_closed();
        Chamber { volume_rest, volume, pressure: gas.pressure, closed }
    };
    let chambers = energies.chambers();
    chambers.map(|(_, chamber)| (chamber.name.clone(), report(chamber))).collect()
}

/// Kind, unit and value of every probe.
pub fn probes(
    probes: &[Probe],
    problem: &Problem,
    at: &Iterate,
) -> BTreeMap<String, reports::Probe> {
    let values = measure(probes, problem, at);
    let row = |probe: &Probe| {
        let (kind, unit) = (probe.kind.key.to_owned(), probe.kind.unit.to_owned());
        (probe.name.clone(), reports::Probe { kind, unit, value: Some(values[&probe.name]) })
    };
    probes.iter().map(row).collect()
}

/// Energies of a state by kind, and their sum `total` [J]. What inertia and
/// friction add to the potential of a step in time is none.
pub fn stored_energies(energies: &Energies, at: &Iterate) -> BTreeMap<String, f64> {
    // those that a scene may lack are reported, too
    let mut stored = BTreeMap::from([("elastic", 0.0), ("chamber", 0.0), ("total", 0.0)]);
    for energy in energies.iter().filter(|energy| energy.nature().is_stored()) {
        let value = energy.value(at);
        *stored.entry(energy.name()).or_insert(0.0) += value;
        *stored.entry("total").or_insert(0.0) += value;
    }
    stored.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Elastic energy of a state, of bodies and of what is beside their laws, by its stored energies [J].
pub fn elastic_energy(energies: &Energies, stored: &BTreeMap<String, f64>) -> f64 {
    let elastic = energies.iter().filter(|energy| energy.nature() == Nature::Elastic);
    let names: BTreeSet<&str> = elastic.map(|energy| energy.name()).collect();
    names.into_iter().map(|name| stored[name]).sum()
}

/// Energy of a state that is stored in bodies, sheets and contacts, not in loads [J].
pub fn internal_energy(energies: &Energies, at: &Iterate) -> f64 {
    let internal =
        |nature: Nature| nature.is_stored() && !matches!(nature, Nature::DeadLoad | Nature::Gas);
    let stored = energies.iter().filter(|energy| internal(energy.nature()));
    stored.map(|energy| energy.value(at)).sum()
}

/// Resultants of the loads by kind and of the reactions [N]; the norm of their
/// sum is `out_of_balance`.
pub fn balance(problem: &Problem, state: &Iterate) -> ForceBalance {
    let nodes = state.space.node_count();
    let resultant = |v: &[f64]| (0..nodes).map(|i| at(v, i)).sum::<Vec3>();
    let mut loads = BTreeMap::from([("chamber", Vec3::zeros())]);
    // elastic forces have no resultant
    for energy in problem.energies.iter().filter(|energy| !energy.nature().is_elastic()) {
        let mut gradient = vec![0.0; state.u.len()];
        energy.add_gradient(state, &mut gradient);
        *loads.entry(energy.name()).or_default() -= resultant(&gradient);
    }
    let (gradient, _) = problem.gradient(state);
    loads.insert("reaction", resultant(&gradient));
    let sum: Vec3 = loads.values().sum();
    let resultants = loads.into_iter().map(|(name, f)| (name.to_owned(), f.into()));
    ForceBalance { out_of_balance: sum.norm(), resultants: resultants.collect() }
}

/// Writes the positions of nodes at rest and their displacements exactly: two arrays of shape (nodes, 3) [m].
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
pub fn collisions(scene: &Scene, energies: &Energies, at: &Iterate) -> Option<Collisions> {
    let contact = energies.contact()?;
    let names = scene.surface_names();
    let gaps = contact.gaps(at);
    let report = |forces: Vec<BodyForce>| -> Vec<PairForce> {
        let one = |BodyForce { bodies, force, magnitude }: BodyForce| {
            let bodies = bodies.map(|b| names[b].to_owned());
            PairForce { bodies, force: force.into(), magnitude }
        };
        forces.into_iter().map(one).collect()
    };
    let friction = energies.each::<Friction>().next();
    Some(Collisions {
        pairs: gaps.pairs,
        smallest_gap: gaps.smallest.is_finite().then_some(gaps.smallest),
        contact: report(contact.body_forces(at)),
        friction: report(friction.map_or_else(Vec::new, |f| f.body_forces(at))),
    })
}

/// [`grid`] with strains and stresses, and with the forces of contact and friction on the
/// nodes [N].
pub fn grid_with_fields(energies: &Energies, at: &Iterate) -> vtu::Grid {
    let mut grid = grid(at.space, at.rest, at.u);
    let [at_points, of_cells] = fields(energies, at);
    grid.point_fields.extend(at_points);
    grid.cell_fields.extend(of_cells);
    // a room knows the fields of its terms by their type
    for room in SimConfig::default().rooms() {
        grid.cell_fields.extend(room.fields(State { energies, at }));
    }
    for energy in energies.contact_terms() {
        let mut values = vec![0.0; at.u.len()];
        energy.add_gradient(at, &mut values);
        values.iter_mut().for_each(|f| *f = -*f);
        grid.point_fields.push(Field::new(&format!("{}_force", energy.name()), "N", 3, values));
    }
    grid
}

/// The body with its displacement, and the mean of J over each element.
pub fn grid(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> vtu::Grid {
    let types = [vtu::CellType::Tet4, vtu::CellType::Tet10, vtu::CellType::Tet20];
    vtu::Grid {
        points: space.node_positions(rest),
        cells: space.element_nodes().to_vec(),
        cell_type: types[space.degree() - 1],
        point_fields: vec![Field::new("displacement", "m", 3, u.to_vec())],
        cell_fields: vec![Field::new("volume_ratio", "1", 1, mean_volume_ratio(space, rest, u))],
    }
}

fn mean_volume_ratio(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Vec<f64> {
    let weights = &space.volume_table().weights;
    let one =
        |e: usize| volume_ratios(space, rest, u, e).iter().zip(weights).map(|(j, w)| w * j).sum();
    (0..space.tets().len()).map(one).collect()
}

/// Planes of symmetry of a body, for `solver mirror`.
pub fn symmetry(body: &Body) -> Vec<CutPlane> {
    let one = |plane: &Plane| CutPlane {
        on: plane.tags.clone(),
        axis: AXES[plane.axis].to_string(),
        level: plane.level,
    };
    body.planes.iter().map(one).collect()
}

/// Writes the state at the end, with the softest mode, where it is known.
pub fn write_end(
    folder: &Path,
    problem: &Problem,
    end: &Iterate,
    mode: Option<&[f64]>,
) -> Result<()> {
    write_arrays(folder, &end.space.node_positions(end.rest), end.u)?;
    let mut grid = grid_with_fields(&problem.energies, end);
    grid.point_fields.extend(mode.map(stability::field));
    Ok(vtu::write_vtu(&folder.join("result.vtu"), &grid)?)
}

/// Results of an earlier run must not remain beside a report that contradicts
/// them; those of the steps that an interrupted one has done stay.
pub fn remove_stale(folder: &Path, done: usize) -> Result<()> {
    let kept: Vec<String> = (0..done).map(|i| format!("step_{i:03}.vtu")).collect();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let ours = ["report.json", "nodes.npy", "displacement.npy", "result.vtu", WINDINGS, FAILED];
        let unless_kept = ["result.pvd", STEPS, CURVE];
        let step = name.starts_with("step_") && name.ends_with(".vtu");
        if ours.contains(&name)
            || (done == 0 && unless_kept.contains(&name))
            || (step && !kept.iter().any(|k| k == name))
        {
            mesh::io::remove_output(&path)?;
        }
    }
    Ok(())
}
