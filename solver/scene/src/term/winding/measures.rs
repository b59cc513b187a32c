//! What a report says of threads: their forces, and what they carry of the load.

use mechanics::energy::{Axis, Energy, Helix, Iterate, Winding, WindingSummary};
use mesh::Vec3;

use super::WindingConfig;
use crate::term::State;

/// A force across a section that is rounding beside that of a thread [1].
const NO_FORCE: f64 = 1e-6;

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
fn axial_forces(thread: &Winding, State { energies, at }: State) -> Option<[f64; 2]> {
    let section = Section::middle(thread.helix.as_ref()?);
    let elastic = energies.iter().filter(|energy| energy.nature().is_elastic());
    let own: &dyn Energy = thread;
    Some([section.force(std::iter::once(own), at), section.force(elastic, at)])
}

/// Measures of a thread, with a warning where it breaks.
pub(super) fn of(config: &WindingConfig, thread: &Winding, state: State) -> reports::Winding {
    let WindingSummary { length, energy, force, mean_force, taut } = thread.summary(state.at);
    let WindingConfig { name, on, points, strength, .. } = config;
    let margin = strength.filter(|_| force[1] > 0.0).map(|strength| strength / force[1]);
    if margin.is_some_and(|margin| margin <= 1.0) {
        log::warn!(
            "winding {name}: its largest force, {:.3} N, is above its strength, {:.3} N: it breaks\n  lower \
             the load, or take more turns or a stronger thread",
            force[1],
            strength.unwrap_or_default()
        );
    }
    let axial = axial_forces(thread, state);
    let counts = |[own, all]: &[f64; 2]| all.abs() > NO_FORCE * own.abs();
    reports::Winding {
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
}
