//! What programs write: states, pictures for ParaView, and the report.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use mesh::Vec3;
use mesh::io::{npy, vtu};
use serde::Serialize;
use serde_json::{Value, json};

use crate::body::Body;
use crate::element::{FunctionSpace, at};
use crate::energy::{Chamber, Energy};
use crate::forward::System;
use crate::material::Kinematics;
use crate::math::tensor::Mat3;
use crate::scene::Scene;

/// Measures of one tag.
#[derive(Clone, Debug, Serialize)]
pub struct TagReport {
    /// Rest area [m²].
    pub area: f64,
    /// Force of the support on the body [N]; zero on a tag that is free. A node
    /// on the rim of several fixed tags counts for the first of them.
    pub reaction: [f64; 3],
    /// Mean length of the displacement over the rest area [m].
    pub mean_displacement: f64,
    /// Mean displacement over the rest area [m].
    pub mean_displacement_vector: [f64; 3],
    /// Largest displacement of a node [m].
    pub max_displacement: f64,
}

/// Measures of one chamber wall.
#[derive(Clone, Debug, Serialize)]
pub struct WallReport {
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

/// Energies in the final state [J].
#[derive(Clone, Debug, Serialize)]
pub struct Energies {
    /// Stored in the silicone.
    pub elastic: f64,
    /// Potential of the gas, −Σ P ΔV.
    pub pressure: f64,
    /// Sum.
    pub total: f64,
}

/// Measures every tag that has facets at an equilibrium.
///
/// # Errors
/// When a tag has no facets.
pub fn tags(
    scene: &Scene,
    body: &Body,
    system: &mut System,
    u: &[f64],
) -> Result<BTreeMap<String, TagReport>> {
    let reactions = reactions(scene, body, system, u)?;
    let mut reports = BTreeMap::new();
    for name in body.used_tags() {
        let mut report = displacements(body, &system.space, &body.facets(name)?, u);
        if let Some(reaction) = reactions.get(name) {
            report.reaction = *reaction;
        }
        reports.insert(name.clone(), report);
    }
    Ok(reports)
}

/// Force of each support on the body [N].
fn reactions(
    scene: &Scene,
    body: &Body,
    system: &mut System,
    u: &[f64],
) -> Result<BTreeMap<String, [f64; 3]>> {
    let (gradient, _) = system.gradient(&body.mesh.vertices, u, 1.0);
    let mut counted = vec![false; system.space.node_count()];
    let mut reactions = BTreeMap::new();
    for support in &scene.config.fixed {
        let mut sum = Vec3::zeros();
        for facet in body.facets(&support.on)? {
            for node in system.space.facet_nodes(facet) {
                if !std::mem::replace(&mut counted[node], true) {
                    sum += at(&gradient, node);
                }
            }
        }
        reactions.insert(support.on.clone(), sum.into());
    }
    Ok(reactions)
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

/// Measures every chamber under the full load.
///
/// # Errors
/// When a tag is missing.
pub fn walls(
    scene: &Scene,
    body: &Body,
    system: &System,
    u: &[f64],
) -> Result<BTreeMap<String, WallReport>> {
    let here = system.iterate(&body.mesh.vertices, u, 1.0);
    let report = |chamber: &Chamber| {
        let (volume, gas) = chamber.state(&here);
        let volume_rest = chamber.rest_volume(&here);
        let closed = chamber.wall.is_closed();
        WallReport { volume_rest, volume, pressure: gas.pressure, closed }
    };
    let chambers = scene.chambers(body, &system.space)?;
    Ok(chambers.iter().map(|(name, chamber)| (name.clone(), report(chamber))).collect())
}

/// Energies of a state under the full load.
#[must_use]
pub fn energies(system: &System, rest: &[Vec3], u: &[f64]) -> Energies {
    let at = system.iterate(rest, u, 1.0);
    let elastic = system.energies[0].value(&at);
    let pressure = system.energies[1..].iter().map(|e| e.value(&at)).sum();
    Energies { elastic, pressure, total: elastic + pressure }
}

/// Resultants of the loads and the reactions [N]; their sum is the force that
/// is out of balance.
///
/// # Errors
/// When a tag is missing.
pub fn balance(scene: &Scene, body: &Body, system: &mut System, u: &[f64]) -> Result<Value> {
    let rest = &body.mesh.vertices;
    let mut load = vec![0.0; system.len()];
    for (_, chamber) in scene.chambers(body, &system.space)? {
        chamber.add_gradient(&system.iterate(rest, u, 1.0), &mut load);
    }
    let nodes = system.space.node_count();
    let pressure: Vec3 = -(0..nodes).map(|i| at(&load, i)).sum::<Vec3>();
    let (gradient, _) = system.gradient(rest, u, 1.0);
    let reaction: Vec3 = (0..nodes).map(|i| at(&gradient, i)).sum();
    Ok(json!({
        "pressure": <[f64; 3]>::from(pressure),
        "reaction": <[f64; 3]>::from(reaction),
        "out_of_balance": (pressure + reaction).norm(),
    }))
}

/// Writes nodes and displacements exactly: two arrays of shape (nodes, 3) [m].
///
/// # Errors
/// When a file cannot be written.
pub fn write_state(folder: &Path, space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Result<()> {
    let nodes: Vec<f64> = space.node_positions(rest).iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let shape = [space.node_count(), 3];
    npy::write_f64(&folder.join("nodes.npy"), &nodes, &shape)?;
    npy::write_f64(&folder.join("displacement.npy"), u, &shape)?;
    Ok(())
}

/// The body with its displacement, and the mean of J over each element.
#[must_use]
pub fn grid(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> vtu::Grid {
    let cell_type = if space.degree() == 1 { vtu::CellType::Tet4 } else { vtu::CellType::Tet10 };
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
    let table = space.volume_table();
    let n = space.nodes_per_element();
    let one = |(tet, nodes): (&[usize; 4], &[usize])| {
        let [a, b, c, d] = tet.map(|v| rest[v]);
        let g = Mat3::from_columns(&[b - a, c - a, d - a]);
        let to_rest = crate::math::tensor::cofactor(&g) / g.determinant();
        let at_point = |(gradients, weight): (&Vec<[f64; 3]>, &f64)| {
            let mut grad_u = Mat3::zeros();
            for (&node, gradient) in nodes.iter().zip(gradients) {
                grad_u += at(u, node) * (to_rest * Vec3::from(*gradient)).transpose();
            }
            weight * Kinematics::new(&grad_u).j()
        };
        table.gradients.iter().zip(&table.weights).map(at_point).sum()
    };
    space.tets().iter().zip(space.element_nodes().chunks_exact(n)).map(one).collect()
}

/// Largest resident set of this process so far [MiB]; none where the system
/// does not tell.
#[must_use]
pub fn peak_rss_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}

/// Writes JSON with indentation.
///
/// # Errors
/// When the file cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)?;
    mesh::io::write_atomic(path, |out| writeln!(out, "{text}"))?;
    Ok(())
}
