//! Gap between two tags.
//!
//! q = min |x − y|      x on one tag, y on the other, both deformed   [m]
//!
//! on flat triangles between the nodes, as in contact ([`Surface`]). The derivative is that of
//! the closest pair (envelope theorem); it jumps where another pair becomes the closest one.

use anyhow::Context as _;
use mechanics::contact::candidates::closest_between;
use mechanics::contact::pairs::Features;
use mechanics::contact::surface::Surface;
use mechanics::element::FunctionSpace;

use super::*;
use crate::quantity::PartsTouch;

pub(super) const KIND: Kind = Kind {
    key: "gap",
    unit: "m",
    example: "on = 'top'\nto = 'bottom'",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// smallest distance of two tags that share no vertex
    #[derive(Debug)]
    struct Keys {
        /// tag
        on: String;
        /// the other tag
        to: String;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let sides = [site.body.facets(&self.on)?, site.body.facets(&self.to)?];
        PartsTouch::check(&sides)
            .with_context(|| format!("tags \"{}\" and \"{}\"", self.on, self.to))?;
        Ok(Arc::new(Gap::new(site.space, &sides)))
    }
}

/// Distance of two surfaces.
struct Gap {
    surface: Surface,
    sides: [Features; 2],
}

impl Gap {
    fn new(space: &FunctionSpace, sides: &[Vec<[usize; 3]>; 2]) -> Self {
        let bodies: Vec<usize> = (0..2).flat_map(|side| vec![side; sides[side].len()]).collect();
        let free = vec![false; 3 * space.node_count()];
        let both = sides.concat();
        let surface = Surface::new(&[], space, &both, &bodies, Vec::new(), space.degree(), &free);
        let sides = [0, 1].map(|side| {
            let own = |t: &&[usize; 3]| surface.body(t[0]) == side;
            let triangles: Vec<_> =
                surface.features().triangles.iter().filter(own).copied().collect();
            Features::new(&triangles)
        });
        Self { surface, sides }
    }

    fn positions(&self, at: &Equilibrium) -> Vec<Vec3> {
        self.surface.positions(at.space, at.rest, at.u, at.time)
    }

    /// `weight` ∂q/∂x at the corners of the closest pair, zero elsewhere.
    fn by_positions(&self, at: &Equilibrium, weight: f64) -> Vec<Vec3> {
        let x = self.positions(at);
        let mut by = vec![Vec3::zeros(); x.len()];
        let Some((pair, closest)) = closest_between(&self.sides, &x) else { return by };
        let Some(direction) = closest.offset.try_normalize(0.0) else { return by };
        for (v, c) in pair.corners().into_iter().zip(closest.coefficients) {
            by[v] += weight * c * direction;
        }
        by
    }
}

impl Quantity for Gap {
    fn value(&self, at: &Equilibrium) -> f64 {
        let closest = closest_between(&self.sides, &self.positions(at));
        closest.map_or(f64::INFINITY, |(_, closest)| closest.d2.sqrt())
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let by = self.by_positions(at, weight);
        self.surface.add_to_nodes(&by, out.u);
        self.surface.add_to_rest(at.space, &by, out.rest);
    }
}
