//! Sections of format 2.

use super::Raw;
use super::elements::{element_type, node_number};
use super::source::Source;
use crate::Vec3;
use crate::io::Parsed;

/// `$Nodes`: a count, then number and position of each node.
pub fn nodes(source: &mut Source) -> Parsed<Vec<(u64, Vec3)>> {
    let count = source.text_count()?;
    (0..count).map(|_| Ok((node_number(source)?, source.point()?))).collect()
}

/// `$Elements`: a count, then the elements. In ASCII every element has its type
/// and number of tags; in binary they come in blocks that share both.
pub fn elements(source: &mut Source, raw: &mut Raw) -> Parsed<()> {
    let count = source.text_count()?;
    let mut read = 0;
    while read < count {
        let number = if source.is_binary() { None } else { Some(source.int()?) };
        let kind = element_type(source.int()?)?;
        let block = if source.is_binary() { source.int()? } else { 1 };
        let tags = source.int()?;
        if block < 1 || block as usize > count - read {
            return Err(format!("a block of {block} elements after {read} of {count}"));
        }
        for _ in 0..block {
            if number.is_none() {
                source.int()?;
            }
            // The first tag is the physical group, the others are not used.
            let mut group = 0;
            for i in 0..tags {
                let tag = source.int()?;
                if i == 0 {
                    group = tag;
                }
            }
            raw.add_element(kind, group, || node_number(source))?;
        }
        read += block as usize;
    }
    Ok(())
}
