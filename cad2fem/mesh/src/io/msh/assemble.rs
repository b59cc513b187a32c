//! From the numbers of a Gmsh file to a mesh with tags.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::{BODY, MshFile, Raw};
use crate::io::{Parsed, require_finite};
use crate::topology::TET_FACETS;
use crate::{Tags, TetMesh, Volumes, facet_key};

/// The mesh, and warnings.
pub fn assemble(raw: Raw) -> Parsed<(MshFile, Vec<String>)> {
    if raw.tets.is_empty() {
        return Err(format!(
            "no tetrahedra among {} nodes and {} triangles; a volume mesh is needed",
            raw.nodes.len(),
            raw.triangles.len()
        ));
    }
    let mut notes = Vec::new();
    let (mut mesh, index) = mesh_of(&raw, &mut notes)?;
    require_finite(&mesh.vertices)?;
    let turned = mesh.turn_inverted();
    if turned > 0 {
        log::debug!("turned {turned} of {} tetrahedra", mesh.tets.len());
    }
    let mut tags = tags_of(&raw, &mesh, &index)?;
    tags.volumes = volumes_of(&raw)?;
    Ok((MshFile { mesh, tags }, notes))
}

/// Keeps the nodes that tetrahedra use, in the order of the file; also returns
/// the vertex of each node number.
fn mesh_of(raw: &Raw, notes: &mut Vec<String>) -> Parsed<(TetMesh, HashMap<u64, usize>)> {
    let used: HashSet<u64> = raw.tets.iter().flat_map(|&(tet, _)| tet).collect();
    let mut index = HashMap::with_capacity(used.len());
    let mut vertices = Vec::with_capacity(used.len());
    for &(number, position) in raw.nodes.iter().filter(|(number, _)| used.contains(number)) {
        if index.insert(number, vertices.len()).is_some() {
            return Err(format!("node number {number} occurs twice"));
        }
        vertices.push(position);
    }
    if raw.nodes.len() > vertices.len() {
        let unused = raw.nodes.len() - vertices.len();
        notes.push(format!(
            "left out {unused} of {} nodes: they are no corner of a tetrahedron",
            raw.nodes.len()
        ));
    }
    let vertex = |n: u64| index.get(&n).copied().ok_or(n);
    let mut tets = Vec::with_capacity(raw.tets.len());
    for (t, &([a, b, c, d], _)) in raw.tets.iter().enumerate() {
        let corners = || Ok([vertex(a)?, vertex(b)?, vertex(c)?, vertex(d)?]);
        tets.push(corners().map_err(|n: u64| {
            format!("tetrahedron {t} has node {n}, which is not among {} nodes", raw.nodes.len())
        })?);
    }
    Ok((TetMesh { vertices, tets }, index))
}

fn tags_of(raw: &Raw, mesh: &TetMesh, index: &HashMap<u64, usize>) -> Parsed<Tags> {
    let tagged = || raw.triangles.iter().filter(|&&(_, group)| group != 0);
    let numbers: BTreeSet<i32> =
        raw.names.iter().map(|&(n, _)| n).chain(tagged().map(|&(_, n)| n)).collect();
    let names: BTreeMap<i32, &String> = raw.names.iter().map(|(n, name)| (*n, name)).collect();
    let name = |n: &i32| names.get(n).map_or_else(|| n.to_string(), ToString::to_string);
    let mut tags = Tags::new(numbers.iter().map(name).collect());
    if let Some(i) = (1..tags.names.len()).find(|&i| tags.names[..i].contains(&tags.names[i])) {
        return Err(format!("two physical groups of triangles are called {:?}", tags.names[i]));
    }
    let id: BTreeMap<i32, u32> = numbers.into_iter().zip(1..).collect();

    let mut strangers = 0;
    let known = if tagged().next().is_some() { tet_facets(mesh) } else { HashSet::new() };
    for &(nodes, group) in tagged() {
        let facet = nodes.map(|n| index.get(&n).copied().unwrap_or(usize::MAX));
        if !known.contains(&facet_key(facet)) {
            strangers += 1;
            continue;
        }
        let before = tags.get(facet).filter(|&other| other != id[&group]);
        if let Some(other) = before {
            let (first, second) = (&tags.names[other as usize - 1], name(&group));
            return Err(format!(
                "the triangle with nodes {nodes:?} is in the groups {first:?} and {second:?}; \
                 a facet can have one tag"
            ));
        }
        tags.set(facet, id[&group]);
    }
    if strangers > 0 {
        return Err(format!(
            "{strangers} of {} tagged triangles are no facet of a tetrahedron; tags and volume \
             belong to different meshes",
            tagged().count()
        ));
    }
    Ok(tags)
}

fn volumes_of(raw: &Raw) -> Parsed<Volumes> {
    let named: BTreeMap<i32, &String> =
        raw.volume_names.iter().map(|(n, name)| (*n, name)).collect();
    let groups: BTreeSet<i32> = raw.tets.iter().map(|&(_, group)| group).collect();
    let name = |n: &i32| match named.get(n) {
        Some(&name) => name.clone(),
        None if *n == 0 => BODY.to_owned(),
        None => n.to_string(),
    };
    let names: Vec<String> = groups.iter().map(name).collect();
    if let Some(i) = (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
        return Err(format!("two physical groups of tetrahedra are called {:?}", names[i]));
    }
    let anonymous = groups.iter().all(|n| named.get(n).is_none_or(|name| *name == BODY));
    if groups.len() == 1 && anonymous {
        return Ok(Volumes::default());
    }
    let place: BTreeMap<i32, usize> = groups.into_iter().zip(0..).collect();
    Ok(Volumes { names, of: raw.tets.iter().map(|(_, group)| place[group]).collect() })
}

fn tet_facets(mesh: &TetMesh) -> HashSet<[usize; 3]> {
    let facets = |tet: &[usize; 4]| TET_FACETS.map(|corners| facet_key(corners.map(|c| tet[c])));
    mesh.tets.iter().flat_map(facets).collect()
}
