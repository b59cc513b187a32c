//! What errors of the mechanics mean for settings: the keys where they are, and what may have been meant.

use std::error::Error;

use measure::written::proposed;
use mechanics::body::{CutError, TagError};
use mechanics::energy::gas_law::BelowVacuum;
use mechanics::schedule::Malformed;
use program::{KeyPath, Misfit, unknown};

/// What an error of the mechanics means, if it is one.
pub fn meaning(error: &(dyn Error + 'static)) -> Option<Misfit> {
    if let Some(error) = error.downcast_ref() {
        return Some(of_tag(error));
    }
    if let Some(error) = error.downcast_ref::<Malformed>() {
        return Some(KeyPath::default().told(proposed(error)));
    }
    if let Some(error) = error.downcast_ref::<CutError>() {
        let path = match error {
            // the error of the tag says where
            CutError::Tag { .. } => KeyPath::list("symmetry"),
            CutError::Plane { tags, .. } => cut(tags),
            CutError::Parallel(parallel) => cut(&parallel.planes[1].tags),
        };
        return Some(path.told(error));
    }
    let BelowVacuum { key, .. } = error.downcast_ref()?;
    Some(KeyPath::of(key).told(error))
}

/// Where a plane of symmetry is written that some tags are cut by.
pub fn cut(tags: &[String]) -> KeyPath {
    let first = tags.first().map_or_else(KeyPath::default, |tag| KeyPath::word(tag));
    KeyPath::list("symmetry").with(first)
}

fn of_tag(error: &TagError) -> Misfit {
    match error {
        TagError::Unknown { tag, known } => {
            let (before, has) = (format!("unknown tag \"{tag}\""), known.join(", "));
            let known = known.iter().map(|tag| &tag[..]);
            KeyPath::word(tag).told(unknown(
                &before,
                tag,
                known,
                ';',
                &format!("the mesh has: {has}"),
            ))
        }
        TagError::Untagged { tag }
        | TagError::NotOnBoundary { tag }
        | TagError::Lost { tag, .. } => KeyPath::word(tag).told(error),
    }
}
