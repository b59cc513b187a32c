//! Printed pieces, and the channels and gaps that are cut into them.

use anyhow::{Result, bail};
use geometry::frustum::Frustum;
use mesh::Vec3;
use mesh::solid::Solid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::parting::FILM;

/// A printed part.
#[derive(Clone)]
pub struct Piece {
    /// The name, and that of its file without extension.
    pub name: String,
    /// The shape in the closed mold [m].
    pub solid: Solid,
    /// The unit vector along which it is demolded [1].
    pub demolding: Vec3,
}

/// What a channel or gap is for.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Purpose {
    /// Silicone in.
    Sprue,
    /// Air out.
    Vent,
    /// Hole for a registration key.
    Key,
    /// Hole for a core's stub.
    Socket,
    /// Hole for a bolt through a flange.
    Bolt,
    /// Slot for a screwdriver between two shells.
    Pry,
    /// Bore in a soluble core, for water.
    Drain,
    /// A pin of a shell that holds a core, with the gap around it in the core's pit; its hole in the silicone is
    /// to be closed.
    Pin,
}

/// A channel or gap in the mold.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// What it is for.
    pub purpose: Purpose,
    /// The outline.
    pub frustum: Frustum,
}

/// Pieces with all features cut out of each of them.
pub fn cut(pieces: Vec<Piece>, features: &[Feature]) -> Vec<Piece> {
    features.iter().fold(pieces, |pieces, feature| {
        let hole = feature.frustum.solid();
        let without = |piece: Piece| Piece { solid: piece.solid.difference(&hole), ..piece };
        pieces.into_iter().map(without).collect()
    })
}

/// A piece without films of rounding.
pub fn connected(piece: Piece) -> Result<Piece> {
    let mut bodies = piece.solid.decompose();
    if bodies.len() < 2 {
        return Ok(piece);
    }
    bodies.retain(|body| body.volume() > FILM);
    if let Some(second) = bodies.get(1) {
        bail!(
            "the {} shell has {} separate pieces, the second of {:.3} mm³: choose another parting.pull, or another \
             parting.kind",
            piece.name,
            bodies.len(),
            second.volume() * 1e9
        );
    }
    Ok(Piece { solid: bodies.swap_remove(0), ..piece })
}
