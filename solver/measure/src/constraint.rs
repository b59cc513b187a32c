//! `[[constraint]]`: what a design keeps, as inequalities c_k(X) ≥ 0 on the rest shape.
//!
//! wall    c = d_k − least                                   [m]
//! core    c = d_k − least, through the air                  [m]
//! draft   c = n_f·p − sin(least)                            [1]
//!
//! d_k   distance of a vertex or edge of one part from the other part, or of a chamber's wall from what faces it [m]
//! n_f   unit normal of a facet, out of the silicone [1]
//! p     unit vector along which what lies on the facets is pulled [1]
//!
//! Two more kinds keep the end of a run within bounds: a probe of the scene, and the slope of the pressure.
//!
//! An inequality has no weight. It is met to its tolerance: a thousandth of a `least` wall, or 0.001 of the sine of a draft.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use mechanics::body::{Body, TagError};
use mechanics::contact::pairs::Pair;
use mesh::Vec3;
use program::table::{Range, Table as _};
use program::{KeyPath, Misfit, Names, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::{Axis, ClosePairs};

/// Tolerance of a constraint over its size.
const TOLERANCE: f64 = 1e-3;

/// An inequality on the rest shape.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ConstraintConfig {
    /// No wall between two parts of the surface is thinner.
    Wall(WallConfig),
    /// No core, which the air of a chamber is in a mold, is thinner.
    Core(CoreConfig),
    /// No facet holds back the core, or the piece of the mold, that is pulled off it.
    Draft(DraftConfig),
    /// A probe of the scene stays within bounds.
    Probe(ProbeBound),
    /// The pressure rises as steeply as this, or more: how far the body stays from where it balloons. In contact it has no
    /// gradient.
    Slope(SlopeBound),
}

program::table! {
    /// `kind = "wall"`.
    #[derive(Clone, Debug)]
    pub struct WallConfig {
        /// As reports call it.
        name: String;
        /// Tag, body, or list of them.
        on: Names;
        /// Tags of the other side, which have no vertex in common with `on`; without them, each two of `on`.
        against: Vec<String> = Vec::new();
        /// The thinnest wall allowed [m].
        least: f64, Range::POSITIVE.unit("m");
    }
}

program::table! {
    /// `kind = "core"`.
    #[derive(Clone, Debug)]
    pub struct CoreConfig {
        /// As reports call it.
        name: String;
        /// Tag of the chamber's wall, or list of tags that bound one chamber.
        on: Names;
        /// The thinnest core allowed [m].
        least: f64, Range::POSITIVE.unit("m");
    }
}

program::table! {
    /// `kind = "draft"`.
    #[derive(Clone, Debug)]
    pub struct DraftConfig {
        /// As reports call it.
        name: String;
        /// Tag, body, or list of them.
        on: Names;
        /// The way in which the core, or a piece of the mold, is pulled off them.
        pull: Axis;
        /// The least angle by which they lean away from it [deg].
        least: f64, Range::at_least(0.0).below(90.0).unit("°");
    }
}

program::table! {
    /// Bounds of a probe, in its unit.
    #[derive(Clone, Debug)]
    pub struct ProbeBound {
        /// As reports call it.
        name: String;
        /// Name of a probe of the scene.
        probe: String;
        /// The smallest value that the probe may have.
        least: Option<f64> = None, Range::FINITE;
        /// The largest value that the probe may have.
        most: Option<f64> = None, Range::FINITE;
    }
}

program::table! {
    /// The least slope of the pressure by the volume, over pressure by change of volume from rest: 1 where the body
    /// answers in proportion, 0 where it balloons.
    #[derive(Clone, Debug)]
    pub struct SlopeBound {
        /// As reports call it.
        name: String;
        /// The smallest slope [1].
        least: f64, Range::POSITIVE.advice(": 0 is the slope where it balloons");
    }
}

impl ConstraintConfig {
    /// What reports call it.
    pub fn name(&self) -> &str {
        match self {
            Self::Wall(wall) => &wall.name,
            Self::Core(core) => &core.name,
            Self::Draft(draft) => &draft.name,
            Self::Probe(bound) => &bound.name,
            Self::Slope(bound) => &bound.name,
        }
    }

    /// What it says of a probe, if it does.
    pub fn bound(&self) -> Option<&ProbeBound> {
        match self {
            Self::Probe(bound) => Some(bound),
            _ => None,
        }
    }

    /// What it says of the slope of the pressure, if it does.
    pub fn slope(&self) -> Option<&SlopeBound> {
        match self {
            Self::Slope(bound) => Some(bound),
            _ => None,
        }
    }

    /// Whether it is kept by the shape alone, without a run.
    pub fn is_of_shape(&self) -> bool {
        self.bound().is_none() && self.slope().is_none()
    }

    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("constraint").named(self.name())
    }

    /// Checks what can be checked without a body.
    pub fn check(&self) -> Result<()> {
        self.check_keys().with_context(|| self.title())
    }

    fn check_keys(&self) -> Result<(), Misfit> {
        let here = KeyPath::default();
        match self {
            Self::Wall(wall) => {
                wall.check_ranges(&here)?;
                match wall.against.is_empty() && wall.on.all().len() < 2 {
                    false => Ok(()),
                    true => Err(misfit!(
                        KeyPath::of("on"),
                        " = {:?}: one side of a wall; name the other by against = [...], or two tags or more in on",
                        wall.on.all()
                    )),
                }
            }
            Self::Core(core) => core.check_ranges(&here),
            Self::Draft(draft) => draft.check_ranges(&here),
            Self::Probe(bound) => {
                bound.check_ranges(&here)?;
                match (bound.least, bound.most) {
                    (None, None) => Err(misfit!(
                        KeyPath::of("probe"),
                        ": without least and most nothing is kept; expected one of them, or both"
                    )),
                    (Some(low), Some(high)) if low >= high => Err(misfit!(
                        KeyPath::of("least"),
                        " = {low} and most = {high}: expected numbers, least below most"
                    )),
                    _ => Ok(()),
                }
            }
            Self::Slope(bound) => bound.check_ranges(&here),
        }
    }

    /// The inequalities on the rest shape of a body; none of a run.
    pub fn build(&self, body: &Body) -> Result<Option<Constraint>> {
        self.on(body).with_context(|| self.title())
    }

    fn on(&self, body: &Body) -> Result<Option<Constraint>> {
        let each = |names: &[String]| -> Result<Vec<_>, TagError> {
            names.iter().map(|name| body.facets(name)).collect()
        };
        let near = |close, least| Constraint {
            name: self.name().to_owned(),
            unit: "m",
            least,
            tolerance: TOLERANCE * least,
            form: Form::Near(close),
        };
        Ok(Some(match self {
            Self::Wall(WallConfig { on, against, least, .. }) => {
                let own = each(on.all())?;
                let parts = match &against[..] {
                    [] => own,
                    against => vec![own.concat(), each(against)?.concat()],
                };
                near(ClosePairs::between(&body.planes, &parts)?, *least)
            }
            Self::Core(CoreConfig { on, least, .. }) => {
                let facets = each(on.all())?.concat();
                near(ClosePairs::through_air(&body.planes, &facets), *least)
            }
            Self::Draft(DraftConfig { name, on, pull, least }) => Constraint {
                name: name.clone(),
                unit: "1",
                least: least.to_radians().sin(),
                tolerance: TOLERANCE,
                form: Form::Draft { facets: each(on.all())?.concat(), pull: pull.unit() },
            },
            Self::Probe(_) | Self::Slope(_) => return Ok(None),
        }))
    }
}

/// One of the inequalities at a rest shape.
#[derive(Clone, Debug)]
pub struct Inequality {
    /// c.
    pub value: f64,
    /// ∂c/∂X of the vertices that it depends on.
    pub by: Vec<(usize, Vec3)>,
    /// Where it is [m].
    pub at: Vec3,
}

/// The inequalities of one entry, on a body.
pub struct Constraint {
    /// As reports call it.
    pub name: String,
    /// Unit of c.
    pub unit: &'static str,
    /// The least wall or core [m], or the sine of the least draft [1]: c is what was measured less this.
    pub least: f64,
    /// How far c may be below 0 at the end.
    pub tolerance: f64,
    form: Form,
}

enum Form {
    /// Distances of what is close.
    Near(ClosePairs),
    Draft {
        facets: Vec<[usize; 3]>,
        pull: Vec3,
    },
}

impl Constraint {
    /// A number of it, which `least` is, in words.
    pub fn in_words(&self, number: f64) -> String {
        match &self.form {
            Form::Draft { .. } => format!("{:.2}°", number.clamp(-1.0, 1.0).asin().to_degrees()),
            Form::Near(_) => format!("{number:.4e} {}", self.unit),
        }
    }

    /// The inequalities that may be violated once every vertex has moved by at most `motion` [m].
    pub fn near(&self, rest: &[Vec3], motion: f64) -> Vec<Inequality> {
        match &self.form {
            Form::Near(close) => {
                let (pairs, x) = close.at(rest, self.least + 2.0 * motion);
                let mut near = distances(pairs, &x);
                for one in &mut near {
                    one.value -= self.least;
                    let by = one.by.iter_mut();
                    by.for_each(|(v, by)| (*v, *by) = close.whole.to_vertex(*v, *by));
                }
                near
            }
            Form::Draft { facets, pull } => {
                let all = facets.iter().map(|&facet| draft_of(rest, facet, pull, self.least));
                all.filter(|(c, slope)| c.value < 2.0 * motion * slope).map(|(c, _)| c).collect()
            }
        }
    }
}

/// The distance of each vertex and edge that comes first in pairs from its closest partner, where they do not touch.
pub fn distances(pairs: Vec<Pair>, x: &[Vec3]) -> Vec<Inequality> {
    let mut closest: BTreeMap<[usize; 2], (f64, Pair)> = BTreeMap::new();
    for pair in pairs {
        let corners = pair.corners();
        let first = [corners[0], corners[pair.corners_of_first() - 1]];
        let distance = pair.closest(&pair.gather(x)).d2.sqrt();
        let best = closest.entry(first).or_insert((distance, pair));
        if distance < best.0 {
            *best = (distance, pair);
        }
    }
    let one = |(distance, pair): (f64, Pair)| {
        let corners = pair.gather(x);
        let by_corner = pair.closest(&corners).d2_gradient();
        let by = pair.corners().into_iter().zip(by_corner);
        let by = by.map(|(v, d2)| (v, d2 / (2.0 * distance))).collect();
        Inequality { value: distance, by, at: corners[0] }
    };
    closest.into_values().filter(|(distance, _)| *distance > 0.0).map(one).collect()
}

/// The draft of a facet, and by how much it changes for a motion of its corners at most [1/m].
fn draft_of(rest: &[Vec3], facet: [usize; 3], pull: &Vec3, sine: f64) -> (Inequality, f64) {
    let [a, b, c] = facet.map(|v| rest[v]);
    let area = 0.5 * (b - a).cross(&(c - a));
    let size = area.norm().max(f64::MIN_POSITIVE);
    let n = area / size;
    let by_area = (pull - n.dot(pull) * n) / size;
    let corner = |k: usize| {
        // a = ½ Σ X_k × X_{k+1}
        let opposite = rest[facet[(k + 1) % 3]] - rest[facet[(k + 2) % 3]];
        (facet[k], 0.5 * opposite.cross(&by_area))
    };
    let by: Vec<_> = (0..3).map(corner).collect();
    let slope = by.iter().map(|(_, d)| d.norm()).sum();
    (Inequality { value: n.dot(pull) - sine, by, at: (a + b + c) / 3.0 }, slope)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::testing::{check_gradient, cube, flat, points};
    use mesh::{Tags, topology};

    use super::*;

    /// A cube whose bottom and top are two parts, with bumps.
    fn body() -> (Body, [Vec<[usize; 3]>; 2]) {
        let mesh = cube(3, 0.15);
        let facets = topology::boundary(&mesh).facets;
        let level = |z: f64| {
            let on = |f: &&[usize; 3]| f.iter().all(|&v| (mesh.vertices[v].z - z).abs() < 1e-9);
            facets.iter().filter(on).copied().collect()
        };
        let sides = [level(0.0), level(1.0)];
        (Body::new(mesh, Tags::default()), sides)
    }

    fn constraint(form: Form, least: f64) -> Constraint {
        Constraint { name: String::new(), unit: "", least, tolerance: 0.0, form }
    }

    fn wall(sides: &[Vec<[usize; 3]>], least: f64) -> Constraint {
        constraint(Form::Near(ClosePairs::between(&[], sides).unwrap()), least)
    }

    fn core(facets: &[[usize; 3]], least: f64) -> Constraint {
        constraint(Form::Near(ClosePairs::through_air(&[], facets)), least)
    }

    fn sum_and_gradient(constraint: &Constraint, rest: &[Vec3], motion: f64) -> (f64, Vec<f64>) {
        let mut gradient = vec![0.0; 3 * rest.len()];
        let mut sum = 0.0;
        for (k, inequality) in constraint.near(rest, motion).into_iter().enumerate() {
            let factor = 1.0 + 0.1 * k as f64;
            sum += factor * inequality.value.powi(2);
            for (v, d) in inequality.by {
                (0..3).for_each(|i| gradient[3 * v + i] += 2.0 * factor * inequality.value * d[i]);
            }
        }
        (sum, gradient)
    }

    #[test]
    fn derivatives_belong_to_the_values() {
        let (body, sides) = body();
        let mut rest = body.mesh.vertices.clone();
        let bump = |x: &Vec3| 0.03 * (3.0 * x.x + 2.0 * x.y).sin() * x.z;
        rest.iter_mut().for_each(|x| x.z += bump(x));
        let draft = Form::Draft { facets: sides[1].clone(), pull: Vec3::z() };
        // bottom and top of what is air here face each other
        let turned = sides.concat().into_iter().map(|[a, b, c]| [a, c, b]).collect::<Vec<_>>();
        for constraint in [wall(&sides, 0.9), constraint(draft, 0.05), core(&turned, 0.9)] {
            let (_, gradient) = sum_and_gradient(&constraint, &rest, 1.0);
            let value = |y: &[f64]| sum_and_gradient(&constraint, &points(y), 1.0).0;
            check_gradient(&flat(&rest), &gradient, 1e-5, value);
        }
    }

    /// Sides of a wall are not the sides of a core, nor are neighbours along either side, and edges of a box.
    #[test]
    fn a_core_is_what_faces_through_air() {
        let (body, sides) = body();
        let rest = &body.mesh.vertices;
        let near = |facets: &[[usize; 3]]| core(facets, 0.8).near(rest, 0.15);
        assert!(near(&sides.concat()).is_empty());
        let turn = |facets: &[[usize; 3]]| -> Vec<[usize; 3]> {
            facets.iter().map(|&[a, b, c]| [a, c, b]).collect()
        };
        let box_of_air = turn(body.boundary());
        let (flat, all) = (near(&turn(&sides.concat())), near(&box_of_air));
        assert!(!flat.is_empty() && all.len() > flat.len(), "{} {}", flat.len(), all.len());
        // within the jitter of the mesh
        assert!(all.iter().all(|c| (c.value - 0.2).abs() < 0.1), "{all:?}");
    }

    #[test]
    fn what_is_too_far_for_the_motion_is_left_out() {
        let (body, sides) = body();
        let wall = wall(&sides, 0.8);
        assert!(wall.near(&body.mesh.vertices, 0.05).is_empty());
        let near = wall.near(&body.mesh.vertices, 0.11);
        assert!(!near.is_empty() && near.iter().all(|c| c.value > 0.19), "{near:?}");
    }
}
