//! The rigid parts of a scene: their nodes, how they may move, and the terms of their energy.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Energies, MassPoint, Rigid, RigidLoad, RigidMass, RigidMoment, Term};
use mechanics::material::sheet::Strain;
use mechanics::rigid::{Moves, RigidSet};
use mechanics::schedule::{Written, WrittenField};
use mechanics::symmetry::AXES;
use mesh::Vec3;
use program::misfit;

use super::{Scene, nodes_of};
use crate::config::is_pressure;
use crate::supports::{Support, Supports};
use crate::term::rigid::RigidConfig;

/// How far points that hinge a part may be off a line, over its length.
const STRAIGHT: f64 = 1e-6;

impl Scene {
    /// Supports that guide rigid parts: axes along which they do not move, and those across planes of symmetry
    /// that cut them.
    pub(super) fn guides(&self, body: &Body) -> Vec<Support> {
        let guide = |part: &RigidConfig| {
            let cut = self.planes_through(part, body);
            let held = |axis: &usize| !part.axes()[*axis] || cut.contains(axis);
            let axes: [bool; 3] = std::array::from_fn(|axis| held(&axis));
            axes.contains(&true).then(|| Support::still(&part.on, axes))
        };
        self.config.rigid.iter().filter_map(guide).collect()
    }

    /// Axes normal to the planes of symmetry that cut a part.
    fn planes_through(&self, part: &RigidConfig, body: &Body) -> Vec<usize> {
        let facets = body.facets(&part.on).unwrap_or_default();
        let is_cut = |plane: &&mechanics::symmetry::Plane| {
            facets.iter().flatten().any(|v| plane.vertices().contains(v))
        };
        body.planes.iter().filter(is_cut).map(|plane| plane.axis).collect()
    }

    fn moves(&self, part: &RigidConfig, body: &Body) -> Moves {
        match self.planes_through(part, body)[..] {
            [] if part.turns => Moves::Freely,
            [axis] if part.turns => Moves::InPlane(axis),
            _ => Moves::Straight,
        }
    }

    /// Nodes of a part, those of its surface first: only these are guided, and one of them has to lead.
    fn nodes_of_rigid(
        &self,
        part: &RigidConfig,
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Vec<usize>> {
        if let Some(own) = self.parts.iter().position(|own| self.is_body(part, &own.config.name)) {
            let facets = body.facets(&part.on)?;
            let outside: BTreeSet<usize> =
                facets.iter().flat_map(|&f| space.facet_nodes(f)).collect();
            let mut nodes = nodes_of(body, own, space);
            nodes.sort_by_key(|node| !outside.contains(node));
            return Ok(nodes);
        }
        let facets = body.tagged(&part.on).with_context(|| part.title())?;
        let mut nodes: Vec<usize> = facets.iter().flat_map(|&f| space.facet_nodes(f)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Vertices of rigid parts, each with the tag or body.
    pub fn rigid_vertices(&self, body: &Body) -> Result<BTreeMap<usize, String>> {
        let mut all = BTreeMap::new();
        for part in &self.config.rigid {
            let facets = body.tagged(&part.on).with_context(|| part.title())?;
            all.extend(facets.into_iter().flatten().map(|v| (v, part.on.clone())));
        }
        Ok(all)
    }

    fn is_body(&self, part: &RigidConfig, name: &str) -> bool {
        !self.config.body.is_empty() && part.on == name
    }

    /// Whether all of a body is rigid.
    pub fn is_rigid(&self, body: &str) -> bool {
        self.config.rigid.iter().any(|part| self.is_body(part, body))
    }

    /// Gives the terms of rigid parts the masses, forces and gravity of this scene.
    pub(super) fn set_rigid_numbers(&self, energies: &mut Energies) {
        let parts = &self.config.rigid;
        energies.change(|place, own: &RigidLoad| {
            let mut load = own.clone();
            load.force = self.config.field(&parts[place].force);
            load.gravity = self.config.field(&self.config.gravity);
            load.mass = parts[place].mass;
            load
        });
        energies.change(|place, own: &RigidMoment| {
            let mut moment = own.clone();
            moment.moment = self.config.field(&parts[place].moment);
            moment
        });
        energies.change(|place, own: &RigidMass| {
            let mut mass = own.clone();
            mass.mass = parts[place].mass;
            mass
        });
    }

    /// The rigid parts, in the order of the scene.
    pub(super) fn rigid_sets(
        &self,
        body: &Body,
        space: &FunctionSpace,
        supports: &Supports,
    ) -> Result<Vec<RigidSet>> {
        let positions = space.node_positions(&body.mesh.vertices);
        let mut owner: Vec<Option<&str>> = vec![None; space.node_count()];
        let mut sets = Vec::new();
        for part in &self.config.rigid {
            let nodes = self.nodes_of_rigid(part, body, space)?;
            let cut = self.planes_through(part, body);
            let held = |axis: usize| !part.axes()[axis] || cut.contains(&axis);
            if let Some(&axis) = cut.iter().find(|axis| !part.force.0[**axis].is_zero()) {
                return Err(misfit!(
                    part.title().key("force"),
                    ": {} along {}, across a plane of symmetry that cuts the part; expected 0, as the mirror image \
                     of the force points the other way",
                    part.force.0[axis],
                    AXES[axis]
                )
                .into());
            }
            if let [normal] = cut[..]
                && let Some(axis) = (0..3).find(|&k| k != normal && !part.moment.0[k].is_zero())
            {
                return Err(misfit!(
                    part.title().key("moment"),
                    ": {} about {}, along a plane of symmetry that cuts the part; expected 0, as the mirror image of \
                     the moment turns the other way",
                    part.moment.0[axis],
                    AXES[axis]
                )
                .into());
            }
            let mut hinge = Vec::new();
            for &node in &nodes {
                let place = positions[node];
                if let Some(other) = owner[node].replace(&part.on) {
                    return Err(misfit!(
                        part.title(),
                        " and \"{other}\" are rigid and meet at {}: they would be one part; tag them as one",
                        point(place)
                    )
                    .into());
                }
                // along axes that guide it, it is held anyway
                let holds = |axis: &usize| supports.holds(node, *axis) && !held(*axis);
                match (0..3).filter(holds).collect::<Vec<_>>()[..] {
                    [] => {}
                    [0, 1, 2] if part.turns => hinge.push(node),
                    [axis, ..] => {
                        return Err(misfit!(
                            part.title(),
                            ": a [[fixed]] tag holds its point {} along {}; a rigid part is hinged to points that are \
                             held along x, y and z, or held as a whole: by along and turns, or as [[fixed]] in place of \
                             [[rigid]]",
                            point(place),
                            AXES[axis]
                        )
                        .into());
                    }
                }
            }
            self.check_hinge(part, &hinge, &positions)?;
            let moves = self.moves(part, body);
            let set = RigidSet::hinged(&nodes, &hinge, &positions, moves);
            sets.push(set.with_context(|| part.title().told("has no facets".to_owned()))?);
        }
        Ok(sets)
    }

    /// Refuses a part that cannot turn, as what holds it are points of no line.
    fn check_hinge(&self, part: &RigidConfig, hinge: &[usize], positions: &[Vec3]) -> Result<()> {
        let [first, ..] = hinge else { return Ok(()) };
        let offset = |node: &usize| positions[*node] - positions[*first];
        let longest = hinge.iter().map(offset).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let along = longest.unwrap_or_default();
        let axis = along.try_normalize(0.0).unwrap_or_default();
        let across = |node: &usize| (offset(node) - axis.dot(&offset(node)) * axis).norm();
        let farthest = hinge.iter().max_by(|a, b| across(a).total_cmp(&across(b)));
        if let Some(node) = farthest.filter(|node| across(node) > STRAIGHT * along.norm()) {
            return Err(misfit!(
                part.title(),
                ": [[fixed]] tags hold {} of its points, and these are on no line: {} is {:.3e} m off it, so that it cannot \
                 move; hold one point or an edge of it as a hinge, or write [[fixed]] in place of [[rigid]]",
                hinge.len(),
                point(positions[*node]),
                across(node)
            )
            .into());
        }
        Ok(())
    }

    /// The terms of the rigid parts.
    pub(super) fn rigid_terms(
        &self,
        sets: &[RigidSet],
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Vec<Term>> {
        let positions = space.node_positions(&body.mesh.vertices);
        let mut terms = Vec::new();
        for (place, (part, set)) in self.config.rigid.iter().zip(sets).enumerate() {
            let points = spread(set, &body.facets(&part.on)?, &body.mesh.vertices)
                .with_context(|| part.title())?;
            let middle = middle(set, &points);
            let gravity = self.config.field(&self.config.gravity);
            let has_mass = part.mass > 0.0 && self.config.method().has_inertia();
            let moment = (!part.moment.is_zero())
                .then(|| RigidMoment::new(set, &positions, self.config.field(&part.moment)))
                .transpose()
                .map_err(|lever| {
                    misfit!(
                        part.title().key("moment"),
                        ": the part has no extent across {}, so that no moment turns it about that; expected 0",
                        AXES[lever.axis]
                    )
                })?;
            let stiffness = (set.masters().len() > 1)
                .then(|| Rigid::new(set, &positions, self.shear_modulus_of(part, set)));
            let mass = has_mass.then(|| RigidMass::new(set, part.mass, &points));
            let force = self.config.field(&part.force);
            let load = RigidLoad::new(set, middle, force, gravity, part.mass);
            terms.extend(stiffness.map(|own| Term::of(Rigid::owner(place), own)));
            terms.extend(mass.map(|own| Term::of(RigidMass::owner(place), own)));
            terms.push(Term::of(RigidLoad::owner(place), load));
            terms.extend(moment.map(|own| Term::of(RigidMoment::owner(place), own)));
        }
        Ok(terms)
    }

    /// Largest shear modulus of what is not rigid, else of all [Pa].
    fn largest_soft_shear_modulus(&self) -> f64 {
        let soft = |part: usize| !self.is_rigid(&self.parts[part].config.name);
        let moduli = self.laws.iter().filter(|law| soft(law.part));
        let largest = moduli.map(|law| law.material.moduli().shear).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { self.largest_shear_modulus() }
    }

    /// Shear modulus that stands for that of a rigid part: of what is around it the stiffest, or what bears the largest
    /// load on it with a strain of one; a power of ten, so that it does not change with the numbers of the scene, by which
    /// there are derivatives [Pa].
    fn shear_modulus_of(&self, part: &RigidConfig, set: &RigidSet) -> f64 {
        let size = set.extents().iter().copied().fold(0.0, f64::max);
        let times = self.config.moments();
        let most = |written: &Written| {
            let schedule = self.config.schedule(written);
            times.iter().map(|t| schedule.at(*t).abs()).fold(0.0, f64::max)
        };
        let length =
            |field: &WrittenField| field.0.iter().map(most).map(|f| f * f).sum::<f64>().sqrt();
        let weight = part.mass * length(&self.config.gravity);
        let on_part =
            (length(&part.force) + weight) / size.powi(2) + length(&part.moment) / size.powi(3);
        let sheets = self.config.membrane.iter().filter_map(|sheet| {
            let law = sheet.specification().ok()?.build(false);
            Some(law.tangent(&Strain::zeros()).max() * sheet.thickness / size)
        });
        let threads = self.config.winding.iter().flat_map(|thread| thread.stiffness.values());
        let threads = threads.map(|stiffness| stiffness / size.powi(2));
        let fibres = self.config.fibre.iter().flat_map(|fibre| fibre.k1.values()).copied();
        let pressures = self.config.chamber.iter().filter(|chamber| is_pressure(chamber.gas.key()));
        let pressures = pressures.map(|chamber| most(&chamber.gas.value));
        let tractions = self.config.traction.iter().map(|load| length(&load.traction));
        let all = sheets.chain(threads).chain(fibres).chain(pressures).chain(tractions);
        let largest = all.fold(self.largest_soft_shear_modulus().max(on_part), f64::max);
        if largest.is_finite() { power_of_ten(largest) } else { self.rigid_shear_modulus() }
    }

    /// Shear modulus of a rigid body, whose own is of no account: that of what is around it, as a power of ten [Pa].
    pub(super) fn rigid_shear_modulus(&self) -> f64 {
        power_of_ten(self.largest_soft_shear_modulus())
    }
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
