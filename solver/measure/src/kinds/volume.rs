//! Volume of a body, or of the chamber behind a wall.
//!
//! J = V            [m³]
//! J = (V − V*)²    [m⁶]
//!
//! with V as in [`Wall`](mechanics::energy::Wall): behind facets and the caps that
//! close them, of the rest shape or the deformed one. The closed surface of a
//! body seen from outside encloses −V.

use mechanics::energy::Wall;

use super::*;

pub(super) const CHAMBER: Kind = Kind {
    key: "volume",
    unit: "m³",
    example: "on = 'top'",
    ..Kind::of::<ChamberKeys>(&[List::Probe])
};

program::table! {
    /// volume of a chamber behind its deformed wall, an open one closed by caps
    #[derive(Debug)]
    struct ChamberKeys {
        /// tag of the wall
        on: String;
    }
}

impl Specification for ChamberKeys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let facets = site.body.facets(&self.on)?;
        let wall = Wall::cut_by(&site.body.planes, site.space, &facets);
        Ok(Arc::new(Volume { wall, sign: 1.0, measure: Measure::Deformed, wanted: None }))
    }
}

pub(super) const KIND: Kind = Kind {
    key: "volume",
    unit: "m³ or m⁶",
    may_be_maximised: true,
    example: "on = 'top'\nvolume = 0.3",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// V, or (V − V*)²
    #[derive(Debug)]
    struct Keys {
        /// a tag: the chamber behind it; a body; all bodies if not given
        on: Option<String> = None;
        /// V* [m³]
        volume: Option<f64> = None, Range::POSITIVE.unit("m³");
        /// "rest" or "deformed"
        measure: Measure = Measure::Rest;
    }
}

impl Specification for Keys {
    fn may_be_maximised(&self) -> bool {
        self.volume.is_none()
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let (facets, sign) = match self.on.as_ref().filter(|name| !site.is_body(name)) {
            Some(tag) => (site.body.facets(tag)?, 1.0),
            None => (site.boundary(self.on.as_deref())?, -1.0),
        };
        let wall = Wall::cut_by(&site.body.planes, site.space, &facets);
        Ok(Arc::new(Volume { wall, sign, measure: self.measure, wanted: self.volume }))
    }
}

/// A volume, or its squared difference to a wanted one.
struct Volume {
    wall: Wall,
    /// 1 behind the facets, −1 within them.
    sign: f64,
    measure: Measure,
    wanted: Option<f64>,
}

impl Volume {
    fn volume(&self, at: &Equilibrium) -> f64 {
        let x = at.nodes(self.measure);
        self.sign * self.wall.volume(at.space, |n| x[n])
    }

    /// Adds `weight` ∂J/∂x at the nodes.
    fn add_by_nodes(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        let by_volume = self.wanted.map_or(1.0, |wanted| 2.0 * (self.volume(at) - wanted));
        let scale = weight * by_volume * self.sign;
        let x = at.nodes(self.measure);
        self.wall.add_gradient(at.space, |n| x[n], scale, out);
    }
}

impl Quantity for Volume {
    fn value(&self, at: &Equilibrium) -> f64 {
        let volume = self.volume(at);
        self.wanted.map_or(volume, |wanted| (volume - wanted).powi(2))
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        out.add_by_nodes(at, self.measure, |nodal| self.add_by_nodes(at, weight, nodal));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::tests::Case;

    #[test]
    fn volumes_are_of_the_shape_that_was_asked_for() {
        for degree in 1..=3 {
            let mut case = Case::cube(degree, 1.0);
            let nodes = case.space.node_positions(&case.rest);
            for (n, x) in nodes.iter().enumerate() {
                case.u[3 * n..3 * n + 3].copy_from_slice(&[x.x, 2.0 * x.y, 4.0 * x.z]);
            }
            let value = |facets: &[_], sign, measure, wanted| {
                let wall = Wall::new(&case.space, facets);
                Volume { wall, sign, measure, wanted }.value(&case.at())
            };
            let within = |measure, wanted| value(&case.facets, -1.0, measure, wanted);
            assert!((within(Measure::Rest, None) - 1.0).abs() < 1e-13);
            assert!((within(Measure::Deformed, None) - 30.0).abs() < 1e-12);
            assert!((within(Measure::Deformed, Some(32.0)) - 4.0).abs() < 1e-10);
            // five sides of it, and the cap that closes them
            let open = case.facets_where(|x| x.z < 0.99);
            assert!((value(&open, 1.0, Measure::Deformed, None) + 30.0).abs() < 1e-12);
        }
    }
}
