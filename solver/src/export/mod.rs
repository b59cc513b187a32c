//! Scenes as input decks of other finite-element programs, so that a number can be checked there.
//!
//! A [`Deck`] is the state at the end of a scene, free of names of ours: nodes, elements, laws, supports, pressures
//! and nodal forces. What the other program cannot say is refused with the key; nothing is left out.

mod calculix;
mod febio;
mod names;
mod refused;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, bail};
use mechanics::energy::{Iterate, Nature};
use mechanics::forward::Problem;
use mechanics::material::Specification;
use mesh::Vec3;
use program::KeyPath;
use scene::Scene;

use names::Names;

/// A program that reads a deck.
pub struct Format {
    /// What people call it.
    pub program: &'static str,
    /// Ending of its decks.
    pub ending: &'static str,
    write: fn(&Deck) -> Result<String>,
}

/// The programs, in the order in which they are listed.
pub const FORMATS: &[Format] = &[calculix::FORMAT, febio::FORMAT];

/// A scene at its end.
pub struct Deck {
    /// The file of the scene, for comments.
    title: String,
    /// Degree of the displacement: 1 or 2.
    degree: usize,
    /// Rest positions [m].
    nodes: Vec<Vec3>,
    /// Nodes of all elements: 4 or 10 of each, in the order of VTK.
    elements: Vec<Vec<usize>>,
    /// What they are made of.
    volumes: Vec<Volume>,
    /// The parts of the boundary that have names.
    tags: Vec<Tag>,
    /// Supports.
    held: Vec<Held>,
    /// Follower pressures, by the index of their tag [Pa].
    pressures: Vec<(usize, f64)>,
    /// Forces that stay as they are, on the nodes that have any [N].
    forces: Vec<(usize, Vec3)>,
}

/// Elements with one law.
struct Volume {
    name: String,
    elements: Range<usize>,
    material: Specification,
}

/// A named part of the boundary.
struct Tag {
    name: String,
    facets: Vec<Facet>,
    /// Ascending.
    nodes: Vec<usize>,
}

/// A facet with the element behind it.
struct Facet {
    /// Three or six nodes, counterclockwise from outside.
    nodes: Vec<usize>,
    element: usize,
    /// The corner of the element that is none of the facet.
    opposite: usize,
}

/// Nodes of a tag that are held along the same axes.
struct Held {
    name: String,
    axes: [bool; 3],
    nodes: Vec<usize>,
    /// Displacement of each node; zero along axes that are free [m].
    displacement: Vec<Vec3>,
}

impl Held {
    /// The displacement of all nodes along an axis, if it is one [m].
    fn uniform(&self, axis: usize) -> Option<f64> {
        let first = self.displacement.first()?[axis];
        self.displacement.iter().all(|u| u[axis] == first).then_some(first)
    }
}

/// The program whose decks end as a path does.
pub fn format_of(path: &Path) -> Result<&'static Format> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let found = FORMATS.iter().find(|format| format.ending.eq_ignore_ascii_case(ending));
    let known = FORMATS.iter().map(|format| format!(".{} ({})", format.ending, format.program));
    found.with_context(|| {
        let known = known.collect::<Vec<_>>().join(" or ");
        format!("{}: the ending says for which program a deck is; expected {known}", path.display())
    })
}

impl Deck {
    /// The deck of a scene.
    pub fn new(scene: &Scene) -> Result<Self> {
        scene.file.checked(|_| refused::check(scene))?;
        let (problem, _) = scene.problem(&scene.body)?;
        let space = &problem.space;
        let nodes = space.node_positions(&scene.body.mesh.vertices);
        let elements = space.element_nodes().chunks_exact(space.nodes_per_element());
        let tags = tags(scene, &problem)?;
        let end = scene.end();
        let mut pressures = Vec::new();
        for chamber in &scene.config.chamber {
            let Some(pressure) = chamber.gas.pressure() else { continue };
            let pressure = scene.config.schedule(pressure);
            let own = (0..tags.len()).filter(|&i| chamber.is_on(&tags[i].name));
            pressures.extend(own.map(|tag| (tag, pressure.at(end))));
        }
        Ok(Self {
            title: scene.path.display().to_string(),
            degree: space.degree(),
            elements: elements.map(<[usize]>::to_vec).collect(),
            volumes: volumes(scene),
            held: held(scene, &problem)?,
            forces: dead_loads(scene, &problem, end),
            pressures,
            nodes,
            tags,
        })
    }

    /// The deck as text; differences between laws are told to the log.
    pub fn text(&self, format: &Format) -> Result<String> {
        (format.write)(self)
    }

    /// Comments at the head of a deck, whose units are these.
    fn head(&self, program: &str, units: &str) -> Vec<String> {
        vec![
            format!("{} for {program}, by {}", self.title, scene::PROGRAM),
            format!(
                "Units: {units}. Node n is row n of nodes.npy and displacement.npy of solver simulate, counted from 1."
            ),
            "Loads are those at the end of the scene; they grow together from nothing.".to_owned(),
        ]
    }

    /// Names of the volumes and of the tags as sets, which differ whatever the case of letters.
    fn set_names(&self) -> (Vec<String>, Vec<String>) {
        let mut names = Names::default();
        let volumes = self.volumes.iter().map(|v| names.add("E", &v.name)).collect();
        (volumes, self.tags.iter().map(|tag| names.add("S", &tag.name)).collect())
    }
}

/// Numbers of nodes, counted from 1.
fn ids(nodes: &[usize], between: &str) -> String {
    nodes.iter().map(|node| (node + 1).to_string()).collect::<Vec<_>>().join(between)
}

/// Text that cannot end a comment.
fn in_one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A law that a program does not have.
fn no_law<T>(volume: &Volume, program: &str, why: &str) -> Result<T> {
    let law = volume.material.law.key;
    bail!(KeyPath::of("material").with(KeyPath::word(law)).told(format!(
        "[material]: kind = \"{law}\" of \"{}\": {program} has no such law{why}; expected another law",
        volume.name
    )))
}

fn volumes(scene: &Scene) -> Vec<Volume> {
    let volume = |law: &scene::SceneLaw| Volume {
        name: law.name.clone(),
        elements: law.elements(&scene.body),
        material: law.material.clone(),
    };
    scene.laws.iter().map(volume).collect()
}

fn tags(scene: &Scene, problem: &Problem) -> Result<Vec<Tag>> {
    let (body, space) = (&scene.body, &problem.space);
    let mut behind = BTreeMap::new();
    for (element, tet) in space.tets().iter().enumerate() {
        for opposite in 0..4 {
            let facet = [1, 2, 3].map(|i| tet[(opposite + i) % 4]);
            behind.insert(mesh::facet_key(facet), (element, opposite));
        }
    }
    let facet = |&vertices: &[usize; 3]| {
        let (element, opposite) = behind[&mesh::facet_key(vertices)];
        Facet { nodes: space.facet_nodes(vertices), element, opposite }
    };
    let mut tags = Vec::new();
    for name in body.used_tags() {
        let facets: Vec<Facet> = body.facets(name)?.iter().map(facet).collect();
        let mut nodes: Vec<usize> = facets.iter().flat_map(|f| f.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        tags.push(Tag { name: name.clone(), facets, nodes });
    }
    Ok(tags)
}

/// The supports, by tag and axes.
fn held(scene: &Scene, problem: &Problem) -> Result<Vec<Held>> {
    let supports = scene.supports(&scene.body, &problem.space)?;
    let displacement = supports.displacement(scene.end());
    let mut names = Names::default();
    let mut found = Vec::new();
    for (tag, dofs) in supports.by_tag() {
        let mut axes = BTreeMap::<usize, [bool; 3]>::new();
        dofs.iter().for_each(|dof| axes.entry(dof / 3).or_default()[dof % 3] = true);
        let mut groups = BTreeMap::<[bool; 3], Vec<usize>>::new();
        axes.into_iter().for_each(|(node, axes)| groups.entry(axes).or_default().push(node));
        for (axes, nodes) in groups {
            let at = |&node: &usize| Vec3::from_fn(|k, _| displacement[3 * node + k]);
            let letters: String =
                "XYZ".chars().zip(axes).filter(|(_, held)| *held).map(|(axis, _)| axis).collect();
            let name = names.add(&format!("FIX_{letters}"), &tag);
            found.push(Held { name, axes, displacement: nodes.iter().map(at).collect(), nodes });
        }
    }
    Ok(found)
}

/// Nodal forces of gravity, body forces and tractions: exact for elements of the degree of the scene.
fn dead_loads(scene: &Scene, problem: &Problem, end: f64) -> Vec<(usize, Vec3)> {
    let u = vec![0.0; problem.dofs()];
    let at: Iterate = problem.iterate(&scene.body.mesh.vertices, &u, end);
    let mut gradient = vec![0.0; problem.dofs()];
    let dead = problem.energies.terms().filter(|term| term.nature() == Nature::DeadLoad);
    dead.for_each(|term| term.energy.add_gradient(&at, &mut gradient));
    let forces = gradient.chunks_exact(3).map(|g| -Vec3::from_column_slice(g)).enumerate();
    forces.filter(|(_, force)| *force != Vec3::zeros()).collect()
}
