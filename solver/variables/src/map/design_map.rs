//! The design map (parametrisation): from design variables to rest shape and loads.
//!
//! X(θ) = X₀ + 𝓔 (patches(θ) − X₀ on the moving surface), with 𝓔 the extension into
//! the interior, so that the gradient is that of what is simulated. The variables of
//! the patches come first, one after the other, then those of the loads, which each scenario
//! applies itself; all are metres. A patch that is the image of another has the variables of that one.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::element::at;
use mesh::Vec3;
use program::{KeyPath, misfit};
use scene::Scene;
use scene::config::{DesignConfig, LevelConfig, ShapeConfig, SymmetricConfig};
use scene::term::rigid;

use super::held::{Flat, Held};
use super::isometry::Isometry;
use super::load_map::{LoadMap, LoadVariable};
use super::patch::Patch;
use mechanics::extension::Extension;

/// The map of one level.
pub struct DesignMap {
    /// Rest vertices at θ = 0 [m].
    rest: Vec<Vec3>,
    patches: Patches,
    /// None where nothing moves.
    extension: Option<Extension>,
    loads: LoadMap,
    /// Mean edge length of the moving surface, of the whole boundary if none moves [m].
    pub mean_edge: f64,
}

/// A patch with the index of its first variable.
struct Placed {
    tag: String,
    patch: Patch,
    start: usize,
}

/// What moves in a level.
#[derive(Default)]
struct Patches {
    /// Images have the same variables as what they are images of.
    all: Vec<Placed>,
    /// Number of variables.
    variables: usize,
    /// All facets that move.
    moving: Vec<[usize; 3]>,
}

impl Patches {
    fn new(shape: &ShapeConfig, level: &LevelConfig, body: &Body) -> Result<Self> {
        let rest = &body.mesh.vertices;
        let flats = flats(shape, body)?;
        let held = Held { planes: &body.planes, flats: &flats, margin: shape.margin };
        let place = |on: &String| shape.symmetry_of(on).map_or(0, |(_, place)| place);
        // what others are images of comes first
        let mut tags: Vec<&String> = shape.on.all().iter().collect();
        tags.sort_by_key(|on| place(on) > 0);
        let mut made = Self::default();
        for on in tags {
            let facets = body.facets(on)?;
            let Some(moves) = shape.moves(level, on) else { continue };
            let image = shape.symmetry_of(on).filter(|(_, place)| *place > 0);
            let image = image.map(|(one, place)| made.image(one, place, rest, &facets, held));
            let (patch, start) = if let Some(image) = image.transpose()?.flatten() {
                image
            } else {
                let own =
                    shape.symmetry_of(on).map_or_else(Vec::new, |(one, _)| Isometry::own(one));
                let patch = Patch::new(rest, &facets, held, moves, &own)?;
                let start = made.variables;
                made.variables += patch.variables();
                (patch, start)
            };
            made.all.push(Placed { tag: on.clone(), patch, start });
            made.moving.extend(facets);
        }
        Ok(made)
    }

    /// The image of the first tag of a symmetry, with the index of its first variable.
    fn image(
        &self,
        symmetric: &SymmetricConfig,
        place: usize,
        rest: &[Vec3],
        facets: &[[usize; 3]],
        held: Held,
    ) -> Result<Option<(Patch, usize)>> {
        let of = &symmetric.of.all()[0];
        let Some(first) = self.all.iter().find(|placed| placed.tag == *of) else { return Ok(None) };
        let by = Isometry::of(symmetric, place);
        Ok(Some((first.patch.image(&by, rest, facets, held)?, first.start)))
    }
}

/// The tags of each symmetry are images of each other in a body as modelled: what a design makes of it may be off by more.
fn check_symmetric(shape: &ShapeConfig, body: &Body) -> Result<()> {
    for one in &shape.symmetric {
        let (tags, rest) = (one.of.all(), &body.mesh.vertices);
        let first = body.facets(&tags[0])?;
        for by in Isometry::own(one) {
            by.check_there(one, rest, [(&tags[0], &first); 2])?;
        }
        for (place, tag) in tags.iter().enumerate().skip(1) {
            let sides = [(&tags[0][..], &first[..]), (tag, &body.facets(tag)?)];
            Isometry::of(one, place).check_there(one, rest, sides)?;
        }
    }
    Ok(())
}

/// The flat faces that a design keeps, of all that moves in any level.
fn flats(shape: &ShapeConfig, body: &Body) -> Result<Vec<Flat>> {
    let facets = shape.on.all().iter().map(|on| body.facets(on));
    let moving = facets.collect::<Result<Vec<_>, _>>()?.concat();
    shape.keep.iter().map(|keep| Flat::find(keep, body, &moving)).collect()
}

/// Rigid parts have the shape of the scene: what they are made of does not move with a design.
fn check_not_rigid(patches: &[Placed], rigid: &BTreeMap<usize, String>) -> Result<()> {
    let moved = patches.iter().flat_map(|p| p.patch.vertices()).find_map(|v| rigid.get(v));
    ensure!(
        moved.is_none(),
        misfit!(
            KeyPath::table("shape"),
            ": moves vertices of the [[rigid]] part on \"{}\", which keeps its shape; take the tag out of \
             one of them",
            moved.map_or("", String::as_str)
        )
    );
    Ok(())
}

impl DesignMap {
    /// The map of one level on a body.
    pub fn new(
        scene: &Scene,
        design: &DesignConfig,
        level: &LevelConfig,
        body: &Body,
    ) -> Result<Self> {
        let rest = body.mesh.vertices.clone();
        let mut patches = Patches::default();
        if let Some(shape) = &design.shape {
            check_symmetric(shape, &scene.body)?;
            patches = Patches::new(shape, level, body)?;
        }
        check_apart(&patches.all)?;
        check_not_rigid(&patches.all, &rigid::vertices(&scene.config.rigid, body)?)?;
        let moving = &patches.moving;
        let edges = if moving.is_empty() { body.boundary() } else { moving };
        let mean_edge = mesh::measure::mean_edge(&rest, edges);
        let extension = if moving.is_empty() { None } else { Some(Extension::new(body)?) };
        let loads = LoadMap::new(scene, design, mean_edge)?;
        Ok(Self { rest, patches, extension, loads, mean_edge })
    }

    /// Number of design variables.
    pub fn variables(&self) -> usize {
        self.shape_variables() + self.loads.variables().len()
    }

    /// Number of those of the shape, which come first.
    pub fn shape_variables(&self) -> usize {
        self.patches.variables
    }

    /// Facets that move.
    pub fn moving(&self) -> &[[usize; 3]] {
        &self.patches.moving
    }

    /// Each patch with the index of its first variable, and its variables.
    fn each_patch<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a Patch, usize, &'a [f64])> + 'a {
        let one = |Placed { patch, start, .. }: &'a Placed| {
            (patch, *start, &theta[*start..start + patch.variables()])
        };
        self.patches.all.iter().map(one)
    }

    /// Rest vertex positions with the moving surface at θ and all others at θ = 0 [m].
    pub fn surface(&self, theta: &[f64]) -> Vec<Vec3> {
        let mut moved = self.rest.clone();
        for (patch, _, own) in self.each_patch(theta) {
            for (&v, x) in patch.vertices().iter().zip(patch.apply(own, &self.rest)) {
                moved[v] = x;
            }
        }
        moved
    }

    /// Rest vertex positions X(θ) [m].
    pub fn shape(&self, theta: &[f64]) -> Vec<Vec3> {
        let Some(extension) = &self.extension else { return self.rest.clone() };
        let moved = self.surface(theta);
        let mut displacement: Vec<Vec3> =
            moved.iter().zip(&self.rest).map(|(x, rest)| x - rest).collect();
        extension.apply(&mut displacement);
        self.rest.iter().zip(displacement).map(|(x, d)| x + d).collect()
    }

    /// Variables at which the shape is that of the body, and the loads are those of another
    /// level, whose [`Self::loads`] they are; the scene's own without any.
    pub fn start(&self, loads: &[f64]) -> Vec<f64> {
        let mut theta = vec![0.0; self.variables()];
        let own = &mut theta[self.shape_variables()..];
        own.iter_mut().zip(loads).for_each(|(own, load)| *own = load * self.mean_edge);
        theta
    }

    /// Variables of the loads in mean edges, which mean the same in every level [1].
    pub fn loads(&self, theta: &[f64]) -> Vec<f64> {
        self.load_variables(theta).iter().map(|own| own / self.mean_edge).collect()
    }

    /// Variables of the loads in the words of the scene, in the order of θ.
    pub fn named_load_variables(&self) -> &[LoadVariable] {
        self.loads.variables()
    }

    /// The terms that keep designed numbers small: name, index in θ of the variable, and term with both derivatives by it.
    pub fn costs<'a>(
        &'a self,
        theta: &'a [f64],
    ) -> impl Iterator<Item = (&'a str, usize, [f64; 3])> + 'a {
        let first = self.shape_variables();
        let costs = self.loads.costs(self.load_variables(theta));
        costs.map(move |(name, variable, cost)| (name, first + variable, cost))
    }

    /// Variables of the loads in θ [m].
    pub fn load_variables<'a>(&self, theta: &'a [f64]) -> &'a [f64] {
        &theta[self.shape_variables()..]
    }

    /// Tag and pressures P_0, …, P_N of each designed pressure [Pa].
    pub fn pressures(&self, theta: &[f64]) -> Vec<(String, Vec<f64>)> {
        self.loads.pressures(self.load_variables(theta))
    }

    /// Designed parameters of the scene by name.
    pub fn parameters(&self, theta: &[f64]) -> BTreeMap<String, f64> {
        self.loads.numbers(self.load_variables(theta))
    }

    /// Largest motion of a vertex from θ = a to θ = b [m].
    pub fn vertex_motion(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        for ((patch, _, a), (_, _, b)) in self.each_patch(a).zip(self.each_patch(b)) {
            let (a, b) = (patch.apply(a, &self.rest), patch.apply(b, &self.rest));
            largest = a.iter().zip(&b).map(|(a, b)| (a - b).norm()).fold(largest, f64::max);
        }
        largest
    }

    /// [`Self::vertex_motion`], or the equivalent in a variable of a load if that is larger [m].
    pub fn motion(&self, a: &[f64], b: &[f64]) -> f64 {
        self.scaled_motion(a, b, 1.0)
    }

    /// [`Self::motion`] where the motion of vertices counts so many times.
    pub fn scaled_motion(&self, a: &[f64], b: &[f64], of_vertices: f64) -> f64 {
        let largest = of_vertices * self.vertex_motion(a, b);
        let from = self.shape_variables();
        let loads = a[from..].iter().zip(&b[from..]).map(|(a, b)| (a - b).abs());
        loads.fold(largest, f64::max)
    }

    /// [`Self::motion`] from θ along a short step, for each unit of it, and the largest component of that [m].
    pub fn motion_along(&self, theta: &[f64], step: &[f64]) -> (f64, f64) {
        let largest = step.iter().fold(0.0_f64, |largest, d| largest.max(d.abs()));
        if largest == 0.0 {
            return (0.0, 0.0);
        }
        let small = 1e-3 * self.mean_edge / largest;
        let there: Vec<f64> = theta.iter().zip(step).map(|(theta, d)| theta + small * d).collect();
        (self.motion(theta, &there) / small, largest)
    }

    /// dJ by the variables of the shape from dJ/dX, three components per vertex.
    pub fn vjp(&self, theta: &[f64], by_rest: &[f64]) -> Vec<f64> {
        let mut gradient = Vec::with_capacity(self.variables());
        gradient.resize(self.shape_variables(), 0.0);
        let mut bar: Vec<Vec3> = (0..self.rest.len()).map(|v| at(by_rest, v)).collect();
        if let Some(extension) = &self.extension {
            extension.vjp(&mut bar);
        }
        for (patch, start, own) in self.each_patch(theta) {
            let on_patch: Vec<Vec3> = patch.vertices().iter().map(|&v| bar[v]).collect();
            let by = patch.vjp(own, &self.rest, &on_patch);
            gradient[start..].iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
        }
        gradient
    }

    /// Derivatives by the variables of a number that depends on a few vertices of the surface, from those by their
    /// positions; variables without any are left out.
    pub fn by_surface(&self, theta: &[f64], by: &[(usize, Vec3)]) -> Vec<(usize, f64)> {
        let mut all: BTreeMap<usize, f64> = BTreeMap::new();
        for (patch, start, own) in self.each_patch(theta) {
            let vertices = patch.vertices();
            let mut bar = vec![Vec3::zeros(); vertices.len()];
            let mut moves = false;
            for (v, d) in by {
                if let Ok(i) = vertices.binary_search(v) {
                    bar[i] += d;
                    moves = true;
                }
            }
            if moves {
                let by = patch.vjp(own, &self.rest, &bar).into_iter().enumerate();
                by.for_each(|(i, d)| *all.entry(start + i).or_insert(0.0) += d);
            }
        }
        all.into_iter().filter(|(_, d)| *d != 0.0).collect()
    }

    /// dJ/dX of the boundary when the interior follows it, three components per
    /// vertex, zero inside; as it is where nothing moves.
    pub fn on_boundary(&self, by_rest: &[f64]) -> Vec<f64> {
        let mut bar: Vec<Vec3> = (0..self.rest.len()).map(|v| at(by_rest, v)).collect();
        if let Some(extension) = &self.extension {
            extension.vjp(&mut bar);
        }
        bar.iter().flat_map(|b| [b.x, b.y, b.z]).collect()
    }

    /// What pressures with bounds are away from these [Pa], each with its derivatives by the variables.
    pub fn pressures_within(&self, theta: &[f64]) -> Vec<(f64, Vec<(usize, f64)>)> {
        let first = self.shape_variables();
        let mut all = self.loads.pressures_within(&theta[first..]);
        all.iter_mut().flat_map(|(_, by)| by).for_each(|(i, _)| *i += first);
        all
    }

    /// Smallest and largest value of each variable in an iteration from θ; none where
    /// nothing is bounded.
    pub fn bounds(&self, theta: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        if self.loads.variables().is_empty() {
            return None;
        }
        let free = self.shape_variables();
        let mut lower = vec![f64::NEG_INFINITY; free];
        let mut upper = vec![f64::INFINITY; free];
        for [low, high] in self.loads.bounds(&theta[free..]) {
            lower.push(low);
            upper.push(high);
        }
        Some((lower, upper))
    }
}

/// Patches may share vertices only on their rims.
fn check_apart(patches: &[Placed]) -> Result<()> {
    for (i, Placed { patch: a, .. }) in patches.iter().enumerate() {
        for Placed { patch: b, .. } in &patches[..i] {
            let shared = a.vertices().iter().filter(|v| b.vertices().binary_search(v).is_ok());
            let count = shared.count();
            let rims = matches!((a, b), (Patch::Handles(_), Patch::Handles(_)));
            ensure!(
                count == 0 || rims,
                KeyPath::table("shape").key("on").told(format!(
                    "[shape] on: two tags share {count} vertices off their rims; expected tags whose \
                     facets are apart"
                ))
            );
        }
    }
    Ok(())
}
