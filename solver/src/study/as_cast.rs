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
use program::{Keys, Settings, Unusable};
use reports::{AsCast, Measurement, Offset};
use scene::Scene;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::study::calibration::least_squares::{Failure, minimise};
use run::{Run, Start};
use scene::number::Walls;

/// Step of the differences of gauges [m].
const STEP: f64 = 1e-6;
/// How far from the surface a gauge may be placed, as a part of the body's diagonal.
const NEAR: f64 = 0.02;

const KEYS: Keys = Keys { paths: &[], named: &[], meaning: None };

/// What was measured of a cast body, and which of its walls may be off.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Tags whose walls may be off, each by its own distance; by default the walls of the chambers.
    #[serde(default)]
    pub walls: Vec<String>,
    /// What a balance shows.
    pub mass: Option<Mass>,
    /// What gauges show.
    #[serde(default)]
    pub gauge: Vec<Gauge>,
    /// What the body does under the full load of the scene.
    #[serde(default)]
    pub probe: Vec<Probed>,
}

/// Mass of the silicone, without inlets, tubes and sheets.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mass {
    /// Of the whole body [kg].
    pub value: f64,
    /// Standard uncertainty [kg].
    pub uncertainty: f64,
}

/// Thickness of the wall at a place.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// A point of the boundary, or near it [m]; the wall is measured straight in from there.
    pub at: [f64; 3],
    /// Thickness [m].
    pub thickness: f64,
    /// Standard uncertainty [m].
    pub uncertainty: f64,
}

/// A probe of the scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probed {
    /// The name.
    pub name: String,
    /// At the end of the run, in the unit of the probe.
    pub value: f64,
    /// Standard uncertainty, in the same unit.
    pub uncertainty: f64,
}

/// A value of the model, and its derivatives by the offsets.
type Value = (f64, Vec<f64>);

impl Measured {
    /// Reads the file.
    pub fn read(path: &Path) -> Result<Self> {
        let file = Settings::read(path, &[], KEYS)?;
        let measured: Self = file.parse()?;
        measured.check().with_context(|| path.display().to_string())?;
        Ok(measured)
    }

    fn check(&self) -> Result<()> {
        ensure!(
            self.mass.is_some() || !self.gauge.is_empty() || !self.probe.is_empty(),
            "nothing is measured; expected [mass], [[gauge]] or [[probe]]"
        );
        for (of, value, uncertainty) in self.numbers() {
            ensure!(
                uncertainty > 0.0 && uncertainty.is_finite(),
                "{of}: uncertainty = {uncertainty}: must be positive and finite"
            );
            let positive = of == "mass" || of.starts_with("gauge ");
            ensure!(
                value.is_finite() && (!positive || value > 0.0),
                "{of}: {value}: must be {}finite",
                if positive { "positive and " } else { "" }
            );
        }
        Ok(())
    }

    /// Name, value and uncertainty of each measurement.
    fn numbers(&self) -> Vec<(String, f64, f64)> {
        let mass = self.mass.iter().map(|m| ("mass".to_owned(), m.value, m.uncertainty));
        let gauges = self.gauge.iter().enumerate();
        let gauges = gauges.map(|(i, g)| (format!("gauge {}", i + 1), g.thickness, g.uncertainty));
        let probes = self.probe.iter().map(|p| (p.name.clone(), p.value, p.uncertainty));
        mass.chain(gauges).chain(probes).collect()
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
        ensure!(at.iter().all(|x| x.is_finite()), "gauge at {:?}: must be finite", gauge.at);
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

    /// All that is measured, in the order of [`Measured::numbers`].
    fn values(&self, offsets: &[f64]) -> Result<Option<Vec<Value>>> {
        let Some(scene) = self.scene(offsets) else { return Ok(None) };
        let mut values = Vec::new();
        values.extend(self.measured.mass.iter().map(|_| self.mass(&scene.body.mesh.vertices)));
        for spot in &self.spots {
            values.push(self.gauge(spot, offsets)?);
        }
        let Some(probes) = self.probes(scene)? else { return Ok(None) };
        values.extend(probes);
        Ok(Some(values))
    }

    fn residuals(&self, offsets: &[f64]) -> Result<Option<Residuals>> {
        let Some(values) = self.values(offsets)? else { return Ok(None) };
        let numbers = self.measured.numbers();
        let rows = || values.iter().zip(&numbers);
        let r = rows().map(|((value, _), (_, measured, sigma))| (value - measured) / sigma);
        let jacobian =
            DMatrix::from_fn(numbers.len(), offsets.len(), |i, k| values[i].1[k] / numbers[i].2);
        Ok(Some(Residuals { r: DVector::from_vec(r.collect()), jacobian }))
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
    let before = vec![0.0; tags.len()];
    let observe = |iteration: usize, offsets: &[f64], residuals: &Residuals| {
        let walls = tags.iter().zip(offsets).map(|(tag, d)| format!("{tag} {:+.4} mm", 1e3 * d));
        let walls = walls.collect::<Vec<_>>().join("  ");
        log::info!("as cast: iteration {iteration}  χ² {:.3e}  {walls}", residuals.sum());
    };
    let minimum = match minimise(&before, |offsets| model.residuals(offsets), observe)? {
        Ok(minimum) => minimum,
        Err(Failure::Undetermined(which)) => {
            let which: Vec<_> = which.into_iter().map(|k| &tags[k][..]).collect();
            bail!(
                "{} measurements do not determine the walls {}: changes of them together leave all as \
                 they are; measure something that tells them apart, or name fewer walls",
                measured.numbers().len(),
                which.join(" and ")
            )
        }
        Err(failure @ (Failure::Start | Failure::Unsettled(_))) => {
            return Err(Unusable(format!("walls as cast: {failure}")).into());
        }
    };
    let values =
        |offsets: &[f64]| Ok::<_, anyhow::Error>(model.values(offsets)?.unwrap_or_default());
    let (first, last) = (values(&before)?, values(&minimum.numbers)?);
    let offset = |(k, on): (usize, &String)| Offset {
        on: on.clone(),
        offset: minimum.numbers[k],
        standard_error: minimum.covariance[(k, k)].sqrt(),
    };
    let rows = measured.numbers().into_iter().zip(first.into_iter().zip(last));
    let measurement = |((of, measured, uncertainty), (before, after)): (_, (Value, Value))| {
        Measurement { of, measured, before: before.0, after: after.0, uncertainty }
    };
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
