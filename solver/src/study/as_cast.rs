//! A body as it came out of its mold: by how much its walls are off, from its mass, from gauges and
//! from probes.
//!
//! The offsets d of walls, outward from the silicone, minimise Σ ((m(d) − m*) / σ)² over the
//! measurements m* with standard uncertainties σ:
//!
//! mass    Σ ρ |T| of the moved mesh; of a body that is cut by symmetry, that of the whole  [kg]
//! gauge   from a point of the boundary straight in, to the next boundary                   [m]
//! probe   of the scene, at its end, on the moved mesh
//!
//! Vertices of a wall move along their normals by d, and the interior follows, as for
//! [`Walls`]. Derivatives of mass and probes are exact; those of gauges are central differences of
//! the thickness of flat facets, which is smooth.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use measure::probe::Probe;
use mechanics::math::least_squares::Residuals;
use mesh::bvh::SurfaceBvh;
use mesh::measure::{diagonal, tet_volume, tet_volume_gradient, triangle_area, triangle_normal};
use mesh::{SurfaceMesh, Vec3};
use nalgebra::{DMatrix, DVector};
use program::table::{Range, Table as _, each, nested};
use program::{KeyPath, Keys, Settings, Unusable};
use reports::{AsCast, Measurement, Offset};
use scene::Scene;
use scene::number::Walls;

use crate::run::{Run, Start};
use crate::study::least_squares::{Failure, minimise, residuals};

/// Step of the differences of gauges [m].
const STEP: f64 = 1e-6;
/// How far from the surface a gauge may be placed, as a part of the body's diagonal.
const NEAR: f64 = 0.02;

program::table! {
    /// What was measured of a cast body, and which of its walls may be off.
    #[derive(Clone, Debug)]
    pub struct Measured {
        /// Tags whose walls may be off, each by its own distance.
        walls: Vec<String> = Vec::new() => "the walls of the chambers";
        /// What a balance shows.
        mass: Option<Mass> = None, nested;
        /// What gauges show.
        gauge: Vec<Gauge> = Vec::new(), each(|_| KeyPath::list("gauge"));
        /// What the body does under the full load of the scene.
        probe: Vec<Probed> = Vec::new(), each(|own: &Probed| KeyPath::list("probe").named(&own.name));
    }
}

program::table! {
    /// Mass of the silicone, without inlets, tubes and sheets.
    #[derive(Clone, Debug)]
    pub struct Mass {
        /// Of the whole body [kg].
        value: f64, Range::POSITIVE.unit("kg");
        /// Standard uncertainty [kg].
        uncertainty: f64, Range::POSITIVE.unit("kg");
    }
}

program::table! {
    /// Thickness of the wall at a place.
    #[derive(Clone, Debug)]
    pub struct Gauge {
        /// A point of the boundary, or near it [m]; the wall is measured straight in from there.
        at: [f64; 3], Range::FINITE.unit("m");
        /// Thickness [m].
        thickness: f64, Range::POSITIVE.unit("m");
        /// Standard uncertainty [m].
        uncertainty: f64, Range::POSITIVE.unit("m");
    }
}

program::table! {
    /// A probe of the scene.
    #[derive(Clone, Debug)]
    pub struct Probed {
        /// The name.
        name: String;
        /// At the end of the run, in the unit of the probe.
        value: f64, Range::FINITE;
        /// Standard uncertainty, in the same unit.
        uncertainty: f64, Range::POSITIVE;
    }
}

/// A value of the model, and its derivatives by the offsets.
type Value = (f64, Vec<f64>);

impl Measured {
    /// Reads the file.
    pub fn read(path: &Path) -> Result<Self> {
        let file = Settings::read(path, &[], Keys::default())?;
        file.checked(|file| {
            let measured: Self = file.parse()?;
            measured.check_ranges(&KeyPath::default())?;
            ensure!(
                !measured.names().is_empty(),
                "nothing is measured; expected [mass], [[gauge]] or [[probe]]"
            );
            Ok(measured)
        })
    }

    /// What each measurement is called.
    fn names(&self) -> Vec<String> {
        let gauges = (1..=self.gauge.len()).map(|i| format!("gauge {i}"));
        let mass = self.mass.iter().map(|_| "mass".to_owned());
        mass.chain(gauges).chain(self.probe.iter().map(|own| own.name.clone())).collect()
    }

    /// Value and uncertainty of each.
    fn values(&self) -> Vec<(f64, f64)> {
        let mass = self.mass.iter().map(|own| (own.value, own.uncertainty));
        let gauges = self.gauge.iter().map(|own| (own.thickness, own.uncertainty));
        mass.chain(gauges)
            .chain(self.probe.iter().map(|own| (own.value, own.uncertainty)))
            .collect()
    }
}

/// Where a gauge is set on: a point of a facet of the boundary.
struct Spot {
    facet: [usize; 3],
    weights: [f64; 3],
}

/// A scene with what is measured of it.
struct Model<'a> {
    scene: &'a Scene,
    measured: &'a Measured,
    /// Moves of all vertices per offset of each wall.
    moves: Vec<Vec<Vec3>>,
    spots: Vec<Spot>,
}

impl<'a> Model<'a> {
    fn new(scene: &'a Scene, measured: &'a Measured, tags: &[String]) -> Result<Self> {
        let walls = Walls::new(scene)?;
        let of = |tag: &String| {
            walls.moves(tag).with_context(|| {
                let known: Vec<_> = scene.body.used_tags().map(String::as_str).collect();
                format!("walls: unknown tag \"{tag}\"; the body has: {}", known.join(", "))
            })
        };
        let moves = tags.iter().map(of).collect::<Result<_>>()?;
        if measured.mass.is_some() {
            for law in &scene.laws {
                ensure!(
                    law.material.density.is_some(),
                    "mass: the density of \"{}\" is not known; add density = ... [kg/m³] to its \
                     material",
                    scene.law_name(law)
                );
            }
        }
        let mut model = Self { scene, measured, moves, spots: Vec::new() };
        model.spots = measured.gauge.iter().map(|g| model.spot(g)).collect::<Result<_>>()?;
        Ok(model)
    }

    fn spot(&self, gauge: &Gauge) -> Result<Spot> {
        let body = &self.scene.body;
        let x = &body.mesh.vertices;
        let boundary = SurfaceMesh { vertices: x.clone(), triangles: body.boundary().to_vec() };
        let at = Vec3::from(gauge.at);
        let near = SurfaceBvh::new(&boundary).closest(&at);
        let limit = NEAR * diagonal(x);
        ensure!(
            near.distance <= limit,
            "gauge at {:?} m is {:.2} mm from the boundary of the body; expected a point of it, at most \
             {:.2} mm away",
            gauge.at,
            1e3 * near.distance,
            1e3 * limit
        );
        let facet = boundary.triangles[near.triangle];
        let [a, b, c] = facet.map(|v| x[v]);
        let part = |p, q| triangle_area(near.point, p, q) / triangle_area(a, b, c);
        Ok(Spot { facet, weights: [part(b, c), part(c, a), part(a, b)] })
    }

    /// Rest vertices with walls off.
    fn vertices(&self, offsets: &[f64]) -> Vec<Vec3> {
        let mut x = self.scene.body.mesh.vertices.clone();
        for (moves, d) in self.moves.iter().zip(offsets) {
            x.iter_mut().zip(moves).for_each(|(x, m)| *x += *d * m);
        }
        x
    }

    /// The scene with walls off, unless an element is turned over.
    fn scene(&self, offsets: &[f64]) -> Option<Scene> {
        let mut scene = self.scene.clone();
        scene.body.mesh.vertices = self.vertices(offsets);
        mesh::check::check_tets(&scene.body.mesh).is_empty().then_some(scene)
    }

    fn mass(&self, x: &[Vec3]) -> Value {
        let body = &self.scene.body;
        let whole = 2.0_f64.powi(body.planes.len() as i32);
        let (mut mass, mut by) = (0.0, vec![0.0; self.moves.len()]);
        for law in &self.scene.laws {
            let density = whole * law.material.density.unwrap_or(0.0);
            for tet in &body.mesh.tets[law.elements(body)] {
                let [a, b, c, d] = tet.map(|v| x[v]);
                mass += density * tet_volume(a, b, c, d);
                let gradient = tet_volume_gradient(a, b, c, d);
                for (by, moves) in by.iter_mut().zip(&self.moves) {
                    let along = gradient.iter().zip(tet).map(|(g, &v)| g.dot(&moves[v]));
                    *by += density * along.sum::<f64>();
                }
            }
        }
        (mass, by)
    }

    fn thickness(&self, spot: &Spot, offsets: &[f64]) -> Result<f64> {
        let x = self.vertices(offsets);
        let triangles = self.scene.body.boundary().to_vec();
        let [a, b, c] = spot.facet.map(|v| x[v]);
        let inward = -triangle_normal(a, b, c).normalize();
        let [p, q, r] = spot.weights;
        let from = p * a + q * b + r * c;
        let own = triangles.iter().position(|t| *t == spot.facet);
        let surface = SurfaceMesh { vertices: x, triangles };
        let hits = SurfaceBvh::new(&surface).ray(&from, &inward);
        let hit = hits.into_iter().find(|(s, t)| *s > 0.0 && Some(*t) != own);
        hit.map(|(s, _)| s).context("gauge: there is no wall straight in from its place")
    }

    fn gauge(&self, spot: &Spot, offsets: &[f64]) -> Result<Value> {
        let moved = |k: usize, by: f64| {
            let mut moved = offsets.to_vec();
            moved[k] += by;
            self.thickness(spot, &moved)
        };
        let slope = |k: usize| Ok((moved(k, STEP)? - moved(k, -STEP)?) / (2.0 * STEP));
        let by = (0..offsets.len()).map(slope).collect::<Result<_>>()?;
        Ok((self.thickness(spot, offsets)?, by))
    }

    /// The probes that are measured; none where there is no equilibrium.
    fn probes(&self, scene: Scene) -> Result<Option<Vec<Value>>> {
        if self.measured.probe.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let known: Vec<_> = scene.config.probe.iter().map(|probe| probe.name()).collect();
        let place = |probed: &Probed| {
            known.iter().position(|name| *name == probed.name).with_context(|| {
                let name = &probed.name;
                format!("unknown probe \"{name}\"; the scene has: {}", known.join(", "))
            })
        };
        let places = self.measured.probe.iter().map(place).collect::<Result<Vec<_>>>()?;
        let run = match Run::new(scene, Start::default())? {
            Ok(run) => run,
            Err(why) => {
                log::info!("as cast: {}", why.unreached);
                return Ok(None);
            }
        };
        let own: Vec<&Probe> = places.into_iter().map(|place| &run.probes[place]).collect();
        let found = run.sensitivities(&own, run.states.steps())?;
        let along = |by: &[f64], moves: &Vec<Vec3>| -> f64 {
            by.chunks_exact(3).zip(moves).map(|(b, m)| m.dot(&Vec3::from_column_slice(b))).sum()
        };
        let one = |(value, by): (f64, mechanics::adjoint::Gradient)| {
            (value, self.moves.iter().map(|moves| along(&by.rest, moves)).collect())
        };
        Ok(Some(found.into_iter().map(one).collect()))
    }

    /// All that is measured, less the measurements.
    fn residuals(&self, offsets: &[f64]) -> Result<Option<Residuals>> {
        let Some(scene) = self.scene(offsets) else { return Ok(None) };
        let mut values = Vec::new();
        values.extend(self.measured.mass.iter().map(|_| self.mass(&scene.body.mesh.vertices)));
        for spot in &self.spots {
            values.push(self.gauge(spot, offsets)?);
        }
        let Some(probes) = self.probes(scene)? else { return Ok(None) };
        values.extend(probes);
        let simulated =
            DVector::from_iterator(values.len(), values.iter().map(|(value, _)| *value));
        let by = DMatrix::from_fn(values.len(), offsets.len(), |i, k| values[i].1[k]);
        Ok(residuals((simulated, by), &self.measured.values()))
    }
}

/// Finds by how much the walls of a scene are off, and moves them in it.
pub fn apply(scene: &mut Scene, path: &Path) -> Result<AsCast> {
    let measured = Measured::read(path)?;
    let found = found(scene, &measured, path).with_context(|| path.display().to_string())?;
    let tags: Vec<String> = found.walls.iter().map(|wall| wall.on.clone()).collect();
    let offsets: Vec<f64> = found.walls.iter().map(|wall| wall.offset).collect();
    let moved = Model::new(scene, &measured, &tags)?.vertices(&offsets);
    scene.body.mesh.vertices = moved;
    Ok(found)
}

fn found(scene: &Scene, measured: &Measured, path: &Path) -> Result<AsCast> {
    let tags = if measured.walls.is_empty() {
        scene.config.chamber.iter().flat_map(|chamber| chamber.on.all()).cloned().collect()
    } else {
        measured.walls.clone()
    };
    ensure!(!tags.is_empty(), "walls: the scene has no [[chamber]]; expected the tags of walls");
    for (i, tag) in tags.iter().enumerate() {
        ensure!(!tags[..i].contains(tag), "walls: \"{tag}\" is given twice");
    }
    let model = Model::new(scene, measured, &tags)?;
    let measurements = measured.values();
    let start = vec![0.0; tags.len()];
    let minimum = match minimise(&tags, &start, |offsets| model.residuals(offsets))? {
        Ok(minimum) => minimum,
        Err(failure) => {
            let why = format!("walls: {}", failure.in_words(&tags, measurements.len()));
            match failure {
                Failure::Undetermined(_) => bail!(why),
                Failure::Start | Failure::Unsettled(_) => return Err(Unusable(why).into()),
            }
        }
    };
    let offset = |(k, on): (usize, &String)| Offset {
        on: on.clone(),
        offset: minimum.numbers[k],
        standard_error: minimum.standard_error(k),
    };
    let measurement = |(i, (of, (measured, uncertainty))): (usize, (String, (f64, f64)))| {
        let [before, after] =
            [&minimum.before, &minimum.residuals.r].map(|r| measured + r[i] * uncertainty);
        Measurement { of, measured, before, after, uncertainty }
    };
    let rows = measured.names().into_iter().zip(measurements).enumerate();
    Ok(AsCast {
        file: path.to_path_buf(),
        walls: tags.iter().enumerate().map(offset).collect(),
        measurements: rows.map(measurement).collect(),
    })
}

/// What was found, in lines of text.
pub fn in_words(found: &AsCast) -> Vec<String> {
    let wall = |Offset { on, offset, standard_error }: &Offset| {
        format!(
            "as cast: wall of {on} {:+.3} ± {:.3} mm of silicone",
            1e3 * offset,
            1e3 * standard_error
        )
    };
    let row = |m: &Measurement| {
        let off = (m.after - m.measured) / m.uncertainty;
        format!(
            "  {}: measured {:.4e}, modelled {:.4e}, as cast {:.4e} ({off:+.1} uncertainties off)",
            m.of, m.measured, m.before, m.after
        )
    };
    found.walls.iter().map(wall).chain(found.measurements.iter().map(row)).collect()
}
