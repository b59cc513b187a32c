//! Rigid parts of a body: their nodes, how they may move, and the terms of their energy.

use std::collections::BTreeSet;

use anyhow::{Context, Result, bail};
use mechanics::body::Body;
use mechanics::energy::{MassPoint, Rigid, RigidLoad, RigidMass, RigidMoment, Term};
use mechanics::rigid::{Moves, RigidSet};
use mechanics::symmetry::{AXES, Plane};
use mesh::Vec3;
use program::misfit;

use super::RigidConfig;
use crate::term::material::{SceneLaw, largest_shear_modulus};
use crate::term::{Ground, nodes_of};

/// How far points that hinge a part may be off a line, over its length.
const STRAIGHT: f64 = 1e-6;

impl RigidConfig {
    /// Axes normal to the planes of symmetry that cut it.
    fn planes_through(&self, body: &Body) -> Vec<usize> {
        let facets = body.facets(&self.on).unwrap_or_default();
        let is_cut = |plane: &&Plane| facets.iter().flatten().any(|v| plane.vertices().contains(v));
        body.planes.iter().filter(is_cut).map(|plane| plane.axis).collect()
    }

    /// Along which of x, y, z it is held by what guides it, and by planes of symmetry that cut it.
    pub(super) fn held(&self, body: &Body) -> [bool; 3] {
        let cut = self.planes_through(body);
        std::array::from_fn(|axis| !self.axes()[axis] || cut.contains(&axis))
    }

    fn moves(&self, cut: &[usize]) -> Moves {
        match cut {
            [] if self.turns => Moves::Freely,
            [axis] if self.turns => Moves::InPlane(*axis),
            _ => Moves::Straight,
        }
    }

    /// Its nodes, those of its surface first: only these are guided, and one of them has to lead.
    fn nodes(&self, Ground { around, body, space, .. }: &Ground) -> Result<Vec<usize>> {
        let Some(own) = around.bodies.iter().position(|name| *name == self.on) else {
            let facets = body.tagged(&self.on).with_context(|| self.title())?;
            let mut nodes: Vec<usize> = facets.iter().flat_map(|&f| space.facet_nodes(f)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            return Ok(nodes);
        };
        let facets = body.facets(&self.on)?;
        let outside: BTreeSet<usize> = facets.iter().flat_map(|&f| space.facet_nodes(f)).collect();
        let mut nodes = nodes_of(body, own, space);
        nodes.sort_by_key(|node| !outside.contains(node));
        Ok(nodes)
    }

    /// Refuses loads that are not their own mirror images in planes that cut it.
    fn check_symmetric(&self, cut: &[usize]) -> Result<()> {
        if let Some(&axis) = cut.iter().find(|axis| !self.force.0[**axis].is_zero()) {
            bail!(misfit!(
                self.title().key("force"),
                ": {} along {}, across a plane of symmetry that cuts the part; expected 0, as the mirror image \
                 of the force points the other way",
                self.force.0[axis],
                AXES[axis]
            ));
        }
        if let [normal] = *cut
            && let Some(axis) = (0..3).find(|&k| k != normal && !self.moment.0[k].is_zero())
        {
            bail!(misfit!(
                self.title().key("moment"),
                ": {} about {}, along a plane of symmetry that cuts the part; expected 0, as the mirror image of \
                 the moment turns the other way",
                self.moment.0[axis],
                AXES[axis]
            ));
        }
        Ok(())
    }

    /// Those of its nodes that [[fixed]] tags hold as a hinge. Along axes that guide it, it is held anyway.
    fn hinge(&self, nodes: &[usize], positions: &[Vec3], ground: &Ground) -> Result<Vec<usize>> {
        let (mut hinge, guided) = (Vec::new(), self.held(ground.body));
        for &node in nodes {
            let holds = |axis: &usize| ground.supports.holds(node, *axis) && !guided[*axis];
            match (0..3).filter(holds).collect::<Vec<_>>()[..] {
                [] => {}
                [0, 1, 2] if self.turns => hinge.push(node),
                [axis, ..] => {
                    bail!(misfit!(
                        self.title(),
                        ": a [[fixed]] tag holds its point {} along {}; a rigid part is hinged to points that are \
                         held along x, y and z, or held as a whole: by along and turns, or as [[fixed]] in place of \
                         [[rigid]]",
                        point(positions[node]),
                        AXES[axis]
                    ));
                }
            }
        }
        self.check_hinge(&hinge, positions)?;
        Ok(hinge)
    }

    /// Refuses a part that cannot turn, as what holds it are points of no line.
    fn check_hinge(&self, hinge: &[usize], positions: &[Vec3]) -> Result<()> {
        let [first, ..] = hinge else { return Ok(()) };
        let offset = |node: &usize| positions[*node] - positions[*first];
        let longest = hinge.iter().map(offset).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let along = longest.unwrap_or_default();
        let axis = along.try_normalize(0.0).unwrap_or_default();
        let across = |node: &usize| (offset(node) - axis.dot(&offset(node)) * axis).norm();
        let farthest = hinge.iter().max_by(|a, b| across(a).total_cmp(&across(b)));
        if let Some(node) = farthest.filter(|node| across(node) > STRAIGHT * along.norm()) {
            bail!(misfit!(
                self.title(),
                ": [[fixed]] tags hold {} of its points, and these are on no line: {} is {:.3e} m off it, so that it cannot \
                 move; hold one point or an edge of it as a hinge, or write [[fixed]] in place of [[rigid]]",
                hinge.len(),
                point(positions[*node]),
                across(node)
            ));
        }
        Ok(())
    }

    /// Shear modulus that stands for its own: of what is around it the stiffest, or what bears the largest
    /// load on it with a strain of one; a power of ten, for it must not change with the numbers of the scene, by which
    /// there are derivatives [Pa].
    fn shear_modulus(&self, set: &RigidSet, Ground { around, rooms, laws, .. }: &Ground) -> f64 {
        let (values, size) = (&around.values, set.extents().iter().copied().fold(0.0, f64::max));
        let force = values.length(&self.force) + self.mass * values.length(around.gravity);
        let on_part = force / size.powi(2) + values.length(&self.moment) / size.powi(3);
        let others = rooms.iter().map(|room| room.stress(size, values));
        let largest = others.fold(soft_shear_modulus(laws).max(on_part), f64::max);
        if largest.is_finite() { power_of_ten(largest) } else { shear_modulus(laws) }
    }
}

/// The rigid parts, in the order of the scene.
pub(crate) fn sets(parts: &[RigidConfig], ground: &Ground) -> Result<Vec<RigidSet>> {
    let positions = ground.space.node_positions(&ground.body.mesh.vertices);
    let mut owner: Vec<Option<&str>> = vec![None; positions.len()];
    let mut sets = Vec::new();
    for part in parts {
        let (nodes, cut) = (part.nodes(ground)?, part.planes_through(ground.body));
        part.check_symmetric(&cut)?;
        for &node in &nodes {
            if let Some(other) = owner[node].replace(&part.on) {
                bail!(misfit!(
                    part.title(),
                    " and \"{other}\" are rigid and meet at {}: they would be one part; tag them as one",
                    point(positions[node])
                ));
            }
        }
        let hinge = part.hinge(&nodes, &positions, ground)?;
        let set = RigidSet::hinged(&nodes, &hinge, &positions, part.moves(&cut));
        sets.push(set.with_context(|| part.title().told("has no facets".to_owned()))?);
    }
    Ok(sets)
}

/// The terms of the rigid parts. Their stiffness does not change with numbers.
pub(super) fn terms(parts: &[RigidConfig], ground: &Ground) -> Result<Vec<Term>> {
    let Ground { around, body, space, last, .. } = ground;
    let positions = space.node_positions(&body.mesh.vertices);
    let mut terms = Vec::new();
    for (place, (part, set)) in parts.iter().zip(&ground.rigid).enumerate() {
        let points = spread(set, &body.facets(&part.on)?, &body.mesh.vertices)
            .with_context(|| part.title())?;
        let [force, gravity] = [&part.force, around.gravity].map(|own| around.values.field(own));
        let has_mass = part.mass > 0.0 && around.method.has_inertia();
        let moment = (!part.moment.is_zero())
            .then(|| RigidMoment::new(set, &positions, around.values.field(&part.moment)))
            .transpose()
            .map_err(|lever| {
                misfit!(
                    part.title().key("moment"),
                    ": the part has no extent across {}, so that no moment turns it about that; expected 0",
                    AXES[lever.axis]
                )
            })?;
        let stiffness = (set.masters().len() > 1).then(|| {
            let last = last.and_then(|last| last.of::<Rigid>(Rigid::owner(place))).cloned();
            let new = || Rigid::new(set, &positions, part.shear_modulus(set, ground));
            last.unwrap_or_else(new)
        });
        let mass = has_mass.then(|| RigidMass::new(set, part.mass, &points));
        let load = RigidLoad::new(set, middle(set, &points), force, gravity, part.mass);
        terms.extend(stiffness.map(|own| Term::of(Rigid::owner(place), own)));
        terms.extend(mass.map(|own| Term::of(RigidMass::owner(place), own)));
        terms.push(Term::of(RigidLoad::owner(place), load));
        terms.extend(moment.map(|own| Term::of(RigidMoment::owner(place), own)));
    }
    Ok(terms)
}

/// Largest shear modulus of what is not rigid, else of all [Pa].
fn soft_shear_modulus(laws: &[SceneLaw]) -> f64 {
    let soft = largest_shear_modulus(laws.iter().filter(|law| !law.is_rigid));
    if soft > 0.0 { soft } else { largest_shear_modulus(laws) }
}

/// Shear modulus of a rigid body, whose own is of no account: that of what is around it, as a power of ten [Pa].
pub(crate) fn shear_modulus(laws: &[SceneLaw]) -> f64 {
    power_of_ten(soft_shear_modulus(laws))
}

/// The next power of ten.
fn power_of_ten(number: f64) -> f64 {
    10.0_f64.powf(number.log10().round())
}

/// Points of some facets with their shares of the area: the middles of edges, which integrate second moments
/// exactly.
fn spread(set: &RigidSet, facets: &[[usize; 3]], vertices: &[Vec3]) -> Result<Vec<MassPoint>> {
    let area = |f: &[usize; 3]| {
        let [a, b, c] = f.map(|v| vertices[v]);
        mesh::measure::triangle_area(a, b, c)
    };
    let total: f64 = facets.iter().map(area).sum();
    let mut points = Vec::new();
    for facet in facets {
        for k in 0..3 {
            let middle = 0.5 * (vertices[facet[k]] + vertices[facet[(k + 1) % 3]]);
            let share = area(facet) / (3.0 * total);
            points.push(MassPoint { share, weights: set.weights_at(middle)? });
        }
    }
    Ok(points)
}

/// Weights of the masters in the middle of all points.
fn middle(set: &RigidSet, points: &[MassPoint]) -> Vec<f64> {
    let mut middle = vec![0.0; set.masters().len()];
    for MassPoint { share, weights } in points {
        middle.iter_mut().zip(weights).for_each(|(m, w)| *m += share * w);
    }
    middle
}

fn point(x: Vec3) -> String {
    format!("({:.5}, {:.5}, {:.5}) m", x.x, x.y, x.z)
}
