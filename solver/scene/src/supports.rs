//! Dirichlet conditions of a scene: which degrees of freedom it fixes, and at which
//! displacement.

use std::collections::BTreeMap;
use std::ops::Range;

use anyhow::{Result, bail};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::schedule::Field;
use mesh::Vec3;
use nalgebra::{Matrix6, Vector6};
use program::{KeyPath, misfit};

/// Two prescribed displacements differ when they do so by more than this fraction of the largest.
const SAME: f64 = 1e-12;
/// A rigid motion is free when the supports prevent less than this fraction of it.
const FREE: f64 = 1e-8;

/// A tag whose nodes do not move along some axes, or move as prescribed.
pub struct Support {
    /// Tag name.
    pub on: String,
    /// Which of x, y, z are fixed.
    pub axes: [bool; 3],
    /// Displacement along these [m].
    pub displacement: Field,
}

impl Support {
    /// A tag that does not move along some axes.
    pub fn still(on: &str, axes: [bool; 3]) -> Self {
        Self { on: on.to_owned(), axes, displacement: Field::default() }
    }
}

/// Fixed degrees of freedom.
pub struct Supports {
    /// Index of the support that fixes each degree of freedom, if any.
    owner: Vec<Option<usize>>,
    /// Tag of each support.
    tags: Vec<String>,
    /// Displacement that each support prescribes.
    motions: Vec<Field>,
    /// Rest positions of the nodes [m].
    positions: Vec<Vec3>,
}

impl Supports {
    /// Fixes the nodes of tags. Where tags meet, the first one owns what both
    /// fix. Motions must be defined and agree at the moments `times` [s].
    pub fn new(
        configs: &[Support],
        times: &[f64],
        body: &Body,
        space: &FunctionSpace,
    ) -> Result<Self> {
        let mut supports = Self {
            owner: vec![None; 3 * space.node_count()],
            tags: configs.iter().map(|c| c.on.clone()).collect(),
            motions: configs.iter().map(|c| c.displacement.clone()).collect(),
            positions: space.node_positions(&body.mesh.vertices),
        };
        for (index, config) in configs.iter().enumerate() {
            let facets = body.facets(&config.on)?;
            let mut nodes: Vec<usize> = facets.iter().flat_map(|&f| space.facet_nodes(f)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            let places: Vec<Vec3> = nodes.iter().map(|&n| supports.positions[n]).collect();
            for schedule in config.displacement.0.iter().filter(|s| s.uses_position()) {
                let key = || KeyPath::list("fixed").on(&config.on).key("displacement");
                schedule.check(times, &places).map_err(|what| misfit!(key(), ": {what}"))?;
            }
            for node in nodes {
                supports.fix(node, index, configs, times)?;
            }
        }
        Ok(supports)
    }

    /// Whether some connected part of a range of vertices can move as a whole.
    pub fn leave_loose(&self, space: &FunctionSpace, vertices: &Range<usize>) -> bool {
        parts(space).iter().any(|part| {
            // the lowest node of a part is a vertex
            vertices.contains(&part[0]) && !self.motions_of(part).is_empty()
        })
    }

    /// Whether any support moves.
    pub fn move_at_all(&self) -> bool {
        self.motions.iter().any(|motion| motion.0.iter().any(|s| !s.is_zero()))
    }

    /// Displacement of the fixed degrees of freedom at a load [m], else zero.
    pub fn displacement(&self, load: f64) -> Vec<f64> {
        let one = |(dof, owner): (usize, &Option<usize>)| {
            owner.map_or(0.0, |index| self.value(index, dof, load))
        };
        self.owner.iter().enumerate().map(one).collect()
    }

    fn value(&self, index: usize, dof: usize, load: f64) -> f64 {
        self.motions[index].0[dof % 3].jet(self.positions[dof / 3], load).value
    }

    /// Degrees of freedom that each tag holds. Several supports of one tag are one.
    pub fn by_tag(&self) -> BTreeMap<String, Vec<usize>> {
        let mut held: BTreeMap<String, Vec<usize>> =
            self.tags.iter().map(|tag| (tag.clone(), Vec::new())).collect();
        for (dof, owner) in self.owner.iter().enumerate() {
            if let Some(dofs) = owner.and_then(|index| held.get_mut(&self.tags[index])) {
                dofs.push(dof);
            }
        }
        held
    }

    /// Whether each degree of freedom is fixed.
    pub fn fixed(&self) -> Vec<bool> {
        self.owner.iter().map(Option::is_some).collect()
    }

    /// Whether a component of a node is fixed at zero for all time.
    pub fn stays(&self, node: usize, axis: usize) -> bool {
        self.owner[3 * node + axis].is_some_and(|i| self.motions[i].0[axis].is_zero())
    }

    /// Whether a component of a node is fixed.
    pub fn holds(&self, node: usize, axis: usize) -> bool {
        self.owner[3 * node + axis].is_some()
    }

    /// Whether all components of a node are fixed.
    pub fn clamps(&self, node: usize) -> bool {
        self.owner[3 * node..3 * node + 3].iter().all(Option::is_some)
    }

    fn fix(&mut self, node: usize, index: usize, all: &[Support], times: &[f64]) -> Result<()> {
        let config = &all[index];
        for (k, _) in config.axes.into_iter().enumerate().filter(|a| a.1) {
            let dof = 3 * node + k;
            let Some(first) = self.owner[dof] else {
                self.owner[dof] = Some(index);
                continue;
            };
            let both = |&t: &f64| [first, index].map(|i| self.value(i, dof, t));
            let largest = times.iter().flat_map(both).fold(0.0_f64, |m, value| m.max(value.abs()));
            for &t in times.iter().rev() {
                let [before, value] = both(&t);
                if (before - value).abs() > SAME * largest {
                    let (axis, p) = (["x", "y", "z"][k], self.positions[node]);
                    bail!(misfit!(
                        KeyPath::list("fixed"),
                        ": \"{}\" moves the point ({:.5}, {:.5}, {:.5}) m by {before} m \
                         along {axis}, \"{}\" by {value} m at t = {t}; tags that meet must agree",
                        all[first].on,
                        p.x,
                        p.y,
                        p.z,
                        config.on
                    ));
                }
            }
        }
        Ok(())
    }

    /// The supports of every connected part must prevent all its six rigid motions:
    /// otherwise the stiffness matrix is singular.
    pub fn check_rigid_motions(&self, space: &FunctionSpace) -> Result<()> {
        let parts = parts(space);
        for part in &parts {
            let Some(RigidMotion { name, .. }) = self.motions_of(part).into_iter().next() else {
                continue;
            };
            if parts.len() == 1 {
                bail!(misfit!(
                    KeyPath::list("fixed"),
                    ": the body can still {name} as a whole; fix more components or tags"
                ));
            }
            let centre = self.centre(part);
            bail!(misfit!(
                KeyPath::list("fixed"),
                ": the body consists of {} parts that do not touch, and the one \
                 around ({:.5}, {:.5}, {:.5}) m, of {} nodes, can still {name} as a whole; \
                 fix it, too, or take it out of the mesh",
                parts.len(),
                centre.x,
                centre.y,
                centre.z,
                part.len()
            ));
        }
        Ok(())
    }

    /// The rigid motions of all connected parts that no support prevents.
    pub fn free_motions(&self, space: &FunctionSpace) -> Vec<RigidMotion> {
        parts(space).iter().flat_map(|part| self.motions_of(part)).collect()
    }

    fn centre(&self, part: &[usize]) -> Vec3 {
        part.iter().map(|&n| self.positions[n]).sum::<Vec3>() / part.len() as f64
    }

    /// The rigid motions of some nodes that no support of theirs prevents, the freest first.
    fn motions_of(&self, part: &[usize]) -> Vec<RigidMotion> {
        let (positions, centre) = (&self.positions, self.centre(part));
        let size = part.iter().map(|&n| (positions[n] - centre).norm()).fold(0.0, f64::max);
        let mut prevented = Matrix6::zeros();
        let dofs = part.iter().flat_map(|n| 3 * n..3 * n + 3);
        for dof in dofs.filter(|&d| self.owner[d].is_some()) {
            let (arm, k) = ((positions[dof / 3] - centre) / size, dof % 3);
            let axis = Vec3::from_fn(|c, _| f64::from(u8::from(c == k)));
            // component k of t + ω × arm, linear in (t, ω)
            let turn = arm.cross(&axis);
            let row = Vector6::new(axis.x, axis.y, axis.z, turn.x, turn.y, turn.z);
            prevented += row * row.transpose();
        }
        let eigen = prevented.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let mut order: Vec<usize> =
            (0..6).filter(|&k| eigen.eigenvalues[k] <= FREE * largest).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let motion = |k: usize| {
            let motion = eigen.eigenvectors.column(k).into_owned();
            let [shift, turn] =
                [motion.fixed_rows::<3>(0).into_owned(), motion.fixed_rows::<3>(3).into_owned()];
            let at = |&n: &usize| (n, shift + turn.cross(&((positions[n] - centre) / size)));
            RigidMotion { name: MOTIONS[motion.iamax()], at: part.iter().map(at).collect() }
        };
        order.into_iter().map(motion).collect()
    }
}

/// A motion of a connected part as a whole.
#[derive(Clone, Debug)]
pub struct RigidMotion {
    /// What it is mostly, in words.
    pub name: &'static str,
    /// Nodes with their motions, of the order of 1.
    at: Vec<(usize, Vec3)>,
}

impl RigidMotion {
    /// Σ f · motion of forces on all degrees of freedom [N].
    pub fn work(&self, forces: &[f64]) -> f64 {
        let one = |(n, motion): &(usize, Vec3)| {
            (0..3).map(|k| forces[3 * n + k] * motion[k]).sum::<f64>()
        };
        self.at.iter().map(one).sum()
    }
}

const MOTIONS: [&str; 6] = [
    "shift along x",
    "shift along y",
    "shift along z",
    "turn about x",
    "turn about y",
    "turn about z",
];

/// The nodes of each connected part of a body.
fn parts(space: &FunctionSpace) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..space.node_count()).collect();
    for nodes in space.element_nodes().chunks_exact(space.nodes_per_element()) {
        for &node in &nodes[1..] {
            let (a, b) = (root(&mut parent, nodes[0]), root(&mut parent, node));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut parts = BTreeMap::<usize, Vec<usize>>::new();
    for node in 0..parent.len() {
        parts.entry(root(&mut parent, node)).or_default().push(node);
    }
    parts.into_values().collect()
}

/// The representative of a node's part; paths are halved on the way.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

#[cfg(test)]
mod tests {
    use mechanics::schedule::axes;
    use mechanics::testing;
    use mesh::{Tags, TetMesh};

    use super::*;

    /// A cube with one tag per face of the lower corner, and the top.
    fn body() -> Body {
        let mesh: TetMesh = testing::cube(2, 0.0);
        let mut tags = Tags::new(["left", "front", "bottom", "top"].map(str::to_owned).to_vec());
        for facet in mesh::topology::boundary(&mesh).facets {
            let c = facet.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 3.0;
            let id = [c.x, c.y, c.z, 1.0 - c.z].iter().position(|d| d.abs() < 1e-12);
            if let Some(id) = id {
                tags.set(facet, u32::try_from(id + 1).expect("small"));
            }
        }
        Body::new(mesh, tags)
    }

    fn fixed(on: &str, components: &str, displacement: [f64; 3]) -> Support {
        let displacement = displacement.into();
        Support { on: on.to_owned(), axes: axes(components), displacement }
    }

    fn supports(configs: &[Support]) -> Result<Supports> {
        let body = body();
        let space = FunctionSpace::new(2, body.mesh.vertices.len(), body.mesh.tets.clone());
        let supports = Supports::new(configs, &[0.0, 1.0], &body, &space)?;
        supports.check_rigid_motions(&space)?;
        Ok(supports)
    }

    fn message(configs: &[Support]) -> String {
        supports(configs).err().expect("refused").to_string()
    }

    #[test]
    fn components_are_fixed_one_by_one() {
        let zero = [0.0; 3];
        let symmetric =
            [fixed("left", "x", zero), fixed("front", "y", zero), fixed("bottom", "z", zero)];
        let supports = supports(&symmetric).expect("enough");
        // 25 nodes per face of a P2 cube of two cells, one component each
        assert_eq!(supports.fixed().iter().filter(|f| **f).count(), 75);
        assert!(supports.clamps(0) && !supports.clamps(1));
    }

    #[test]
    fn what_floats_is_refused_with_its_motion() {
        let text = message(&[fixed("left", "x", [0.0; 3]), fixed("front", "y", [0.0; 3])]);
        assert!(text.contains("shift along z"), "{text}");
        let text = message(&[fixed("bottom", "z", [0.0; 3]), fixed("left", "x", [0.0; 3])]);
        assert!(text.contains("shift along y"), "{text}");
    }

    #[test]
    fn a_part_that_does_not_touch_the_rest_needs_supports_of_its_own() {
        let mut body = body();
        let count = body.mesh.vertices.len();
        let shifted: Vec<Vec3> = body.mesh.vertices.iter().map(|v| v + 3.0 * Vec3::x()).collect();
        body.mesh.vertices.extend(shifted);
        let tets: Vec<[usize; 4]> = body.mesh.tets.iter().map(|t| t.map(|v| v + count)).collect();
        body.mesh.tets.extend(tets);
        let body = Body::new(body.mesh, body.tags);
        let space = FunctionSpace::new(1, body.mesh.vertices.len(), body.mesh.tets.clone());
        let configs = [fixed("bottom", "xyz", [0.0; 3])];
        let supports = Supports::new(&configs, &[1.0], &body, &space).expect("on its tag");
        let text = supports.check_rigid_motions(&space).expect_err("refused").to_string();
        for word in ["2 parts", "(3.50000, 0.50000, 0.50000) m", "27 nodes", "can still"] {
            assert!(text.contains(word), "{text}");
        }
    }

    #[test]
    fn contradictions_are_refused_with_numbers() {
        let text =
            message(&[fixed("bottom", "xyz", [0.0; 3]), fixed("left", "x", [1e-3, 0.0, 0.0])]);
        assert!(text.contains("by 0 m along x") && text.contains("by 0.001 m"), "{text}");
    }

    #[test]
    fn a_prescribed_displacement_stands_at_its_nodes() {
        let supports =
            supports(&[fixed("bottom", "xyz", [0.0; 3]), fixed("top", "xyz", [0.0, 0.0, -0.2])])
                .expect("enough");
        let moved = supports.displacement(1.0).iter().filter(|d| **d == -0.2).count();
        assert_eq!(moved, 25);
    }
}
