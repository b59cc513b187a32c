//! What is reported of fibres and threads, and their fields for ParaView.
//!
//! | name of a cell field | is | unit |
//! |-|-|-|
//! | `fibre_NAME_direction` | mean of a₀ at rest, zero where the family is not | 1 |
//! | `fibre_NAME_stretch` | mean of √I₄, 1 where the family is not | 1 |
//! | `fibre_NAME_stress` | mean of the force of the fibres per rest area across them | Pa |

use std::path::Path;

use anyhow::Result;
use mechanics::energy::{
    self, Axis, Energies, Energy, FibreMean, FibreSummary, Fibres, Helix, Iterate, Strand,
    WindingSummary,
};
use mesh::Vec3;
use mesh::io::vtu::Field;
use reports::{Fibre, Segment, SegmentEnd, WINDINGS, Winding};
use scene::Scene;
use scene::config::WindingConfig;

use super::table;

/// A force across a section that is rounding beside that of a thread [1].
const NO_FORCE: f64 = 1e-6;

/// Measures of every family of fibres.
pub fn fibres(energies: &Energies, at: &Iterate) -> Vec<Fibre> {
    let one = |family: &Fibres| {
        let FibreSummary { volume, energy, stretch, stress, taut } = family.summary(at);
        Fibre { name: family.name.clone(), volume, energy, stretch, stress, taut }
    };
    energies.each().map(one).collect()
}

/// Heights of a section, from 0 to 1 between two of them, and the axis across it.
struct Section {
    axis: Axis,
    heights: [f64; 2],
}

impl Section {
    /// The middle third of a helix.
    fn middle(helix: &Helix) -> Self {
        let [start, end] = helix.heights;
        let third = (end - start) / 3.0;
        Self { axis: helix.axis, heights: [start + third, end - third] }
    }

    /// Force of terms along the axis across sections between both heights at rest, on average [N]: with φ of 0 below
    /// and 1 above, linear between them and interpolated at the nodes, Σ ∂W/∂u_a · k φ_a. That is the force across
    /// every section where no load is between the heights.
    fn force<'a>(&self, terms: impl Iterator<Item = &'a dyn Energy>, at: &Iterate) -> f64 {
        let mut forces = vec![0.0; at.u.len()];
        terms.for_each(|term| term.add_gradient(at, &mut forces));
        let [low, high] = self.heights;
        let nodes = at.space.node_positions(at.rest).into_iter().enumerate();
        let one = |(node, x): (usize, Vec3)| {
            let height = (x - self.axis.point).dot(&self.axis.along);
            let part = ((height - low) / (high - low)).clamp(0.0, 1.0);
            part * self.axis.along.dot(&Vec3::from_column_slice(&forces[3 * node..3 * node + 3]))
        };
        nodes.map(one).sum()
    }
}

/// Force of a thread along its axis, and that of all that is elastic [N]; none of a line through points.
fn axial_forces(
    scene: &Scene,
    (winding, thread): (&WindingConfig, &energy::Winding),
    (energies, at): (&Energies, &Iterate),
) -> Option<[f64; 2]> {
    // a thread that lies on the body has a helix
    let section = Section::middle(&scene.helix(winding).ok()??);
    let elastic = energies.iter().filter(|energy| energy.nature().is_elastic());
    let own: &dyn Energy = thread;
    Some([section.force(std::iter::once(own), at), section.force(elastic, at)])
}

/// Measures of every thread, in the order of the scene.
pub fn windings(scene: &Scene, energies: &Energies, at: &Iterate) -> Vec<Winding> {
    let one = |(winding, thread): (&WindingConfig, &energy::Winding)| {
        let WindingSummary { length, energy, force, mean_force, taut } = thread.summary(at);
        let WindingConfig { name, on, points, strength, .. } = winding;
        let margin = strength.filter(|_| force[1] > 0.0).map(|strength| strength / force[1]);
        if margin.is_some_and(|margin| margin <= 1.0) {
            log::warn!(
                "winding {name}: its largest force, {:.3} N, is above its strength, {:.3} N: it breaks\n  lower \
                 the load, or take more turns or a stronger thread",
                force[1],
                strength.unwrap_or_default()
            );
        }
        let axial = axial_forces(scene, (winding, thread), (energies, at));
        let counts = |[own, all]: &[f64; 2]| all.abs() > NO_FORCE * own.abs();
        Winding {
            name: name.clone(),
            on: on.all().join(" and "),
            length,
            turns: points.is_empty().then(|| thread.turns()),
            segments: thread.segments(),
            energy,
            force,
            mean_force,
            axial_force: axial.map(|[own, _]| own),
            section_force: axial.map(|[_, all]| all),
            load_share: axial.filter(counts).map(|[own, all]| own / all),
            margin,
            taut,
        }
    };
    scene.config.winding.iter().zip(energies.each()).map(one).collect()
}

/// Writes the threads of a state to a folder, if there are any.
pub fn write_threads(
    folder: &Path,
    scene: &Scene,
    energies: &Energies,
    at: &Iterate,
) -> Result<()> {
    if scene.config.winding.is_empty() {
        return Ok(());
    }
    let mut rows = vec![Segment::head()];
    for (winding, thread) in scene.config.winding.iter().zip(energies.each::<energy::Winding>()) {
        rows.extend(thread.strands(at).iter().map(|strand| segment(&winding.name, strand).row()));
    }
    table::write(&folder.join(WINDINGS), rows)
}

fn segment(winding: &str, strand: &Strand) -> Segment {
    let end = |k: usize| SegmentEnd {
        rest: strand.rest[k].into(),
        now: (strand.rest[k] + strand.moved[k]).into(),
        weights: strand.weights[k],
    };
    Segment {
        winding: winding.to_owned(),
        ends: [end(0), end(1)],
        force: strand.force,
        vertices: strand.vertices,
    }
}

/// Fields of the cells.
pub fn fibre_fields(energies: &Energies, at: &Iterate) -> Vec<Field> {
    energies.each().flat_map(|family| of_family(family, at)).collect()
}

fn of_family(family: &Fibres, at: &Iterate) -> [Field; 3] {
    let elsewhere = FibreMean { direction: Vec3::zeros(), stretch: 1.0, stress: 0.0 };
    let mut means = vec![elsewhere; at.space.tets().len()];
    means[family.elements()].copy_from_slice(&family.means(at));
    let field = |name: &str, unit: &str, components: usize, values: Vec<f64>| Field {
        name: format!("fibre_{}_{name}", family.name),
        unit: unit.to_owned(),
        components,
        values,
    };
    let directions = means.iter().flat_map(|mean| <[f64; 3]>::from(mean.direction)).collect();
    [
        field("direction", "1", 3, directions),
        field("stretch", "1", 1, means.iter().map(|mean| mean.stretch).collect()),
        field("stress", "Pa", 1, means.iter().map(|mean| mean.stress).collect()),
    ]
}
