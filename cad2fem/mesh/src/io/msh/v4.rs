//! Sections of format 4.1.

use std::collections::BTreeMap;

use super::Raw;
use super::elements::element_type;
use super::source::Source;
use crate::Vec3;
use crate::io::Parsed;

/// The physical group of an entity, by its dimension and number.
pub type Groups = BTreeMap<(i32, i32), i32>;

/// `$Entities`: points, curves, surfaces and volumes with their physical groups.
pub fn entities(source: &mut Source) -> Parsed<Groups> {
    let counts = [source.count()?, source.count()?, source.count()?, source.count()?];
    let mut groups = Groups::new();
    for (dimension, count) in (0..).zip(counts) {
        for _ in 0..count {
            let entity = source.int()?;
            // Points have a position, the others the corners of a bounding box.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                source.double()?;
            }
            let physical = source.count()?;
            for i in 0..physical {
                let group = source.int()?.abs();
                if i == 0 {
                    groups.insert((dimension, entity), group);
                } else if dimension == 2 {
                    return Err(format!(
                        "surface {entity} is in {physical} physical groups; a facet can have one"
                    ));
                }
            }
            if dimension > 0 {
                for _ in 0..source.count()? {
                    source.int()?;
                }
            }
        }
    }
    Ok(groups)
}

/// `$Nodes`: blocks of node numbers followed by their positions.
pub fn nodes(source: &mut Source) -> Parsed<Vec<(u64, Vec3)>> {
    let (blocks, total) = (source.count()?, source.count()?);
    let _smallest_and_largest_number = (source.size()?, source.size()?);
    let mut nodes = Vec::with_capacity(total);
    for _ in 0..blocks {
        let dimension = source.int()?;
        source.int()?; // entity
        let parametric = source.int()?;
        let count = source.count()?;
        let numbers: Vec<u64> = (0..count).map(|_| source.size()).collect::<Parsed<_>>()?;
        for number in numbers {
            nodes.push((number, source.point()?));
            // Parametric nodes carry as many parameters as their entity has dimensions.
            for _ in 0..if parametric == 0 { 0 } else { dimension } {
                source.double()?;
            }
        }
    }
    require_total("nodes", nodes.len(), total)?;
    Ok(nodes)
}

/// `$Elements`: blocks of one entity and type.
pub fn elements(source: &mut Source, groups: &Groups, raw: &mut Raw) -> Parsed<()> {
    let (blocks, total) = (source.count()?, source.count()?);
    let _smallest_and_largest_number = (source.size()?, source.size()?);
    let mut read = 0;
    for _ in 0..blocks {
        let dimension = source.int()?;
        let entity = source.int()?;
        let kind = element_type(source.int()?)?;
        let count = source.count()?;
        let group = groups.get(&(dimension, entity)).copied().unwrap_or(0);
        for _ in 0..count {
            source.size()?; // number
            raw.add_element(kind, group, || source.size())?;
        }
        read += count;
    }
    require_total("elements", read, total)
}

fn require_total(what: &str, found: usize, announced: usize) -> Parsed<()> {
    if found == announced {
        return Ok(());
    }
    Err(format!("{announced} {what} announced, the blocks hold {found}"))
}
