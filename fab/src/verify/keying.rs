//! Each core fits into its sockets one way only.
//!
//! The written stubs of a core are put into its written sockets: every stub on every
//! socket, turned about its axis in steps of 15°, in the middle and pushed aside by its play. How far the
//! core then stands proud is the least height by which it must be lifted so that it meets nothing of the
//! piece with the sockets. The least of all these places is compared with what one sees. Places in which a stub
//! is beside that piece do not count: there one sees it at once.

use std::f64::consts::TAU;

use mesh::Vec3;
use mesh::solid::Solid;
use nalgebra::{Matrix3x4, Rotation3};

use super::closed_mold::{Body, ClosedMold};
use super::{Line, Status};
use crate::mold::Purpose;

/// Turns of a stub in its socket.
const TURNS: usize = 24;

/// Turns by less than this count as none [rad].
const SAME: f64 = TAU / 12.0 - 1e-9;

/// A core is seen to be in a wrong place if it stands proud by two layers of a filament printer and more [mm].
const SEEN: f64 = 0.5;

/// Halvings of the height in which the least is searched: to a hundredth of a millimetre.
const HALVINGS: usize = 9;

/// Parts that share no more than a cube of 0.2 mm touch [mm³].
const TOUCHING: f64 = 1e-2;

/// Part of its play by which a stub is pushed aside: both are polygons.
const PLAY: f64 = 0.95;

/// The stubs of a core.
struct Stubs<'a> {
    name: &'a str,
    /// All of the core below the body.
    solid: Solid,
    /// The axes of its sockets, at their lower ends, and its play in each of them.
    sockets: Vec<(Vec3, f64)>,
}

/// The checks of all cores that stand in sockets.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let Some(holder) = mold.shells.last() else { return Vec::new() };
    let seat = seat(mold);
    let below = |solid: &Solid| solid.trim_by_plane(&-Vec3::z(), -seat);
    let floor = below(&holder.solid);
    let depth = seat - mold.bounds.0.z;
    let cores: Vec<Stubs> =
        mold.cores.iter().map(|core| stubs(mold, core, below(&core.solid))).collect();
    let claimed = mold.report.one_way;
    let line = |core: &Stubs| {
        let proud = core.proud(&floor, depth);
        let found = format!("stands {proud:.2} mm proud when turned");
        let name = format!("{}: one way only", core.name);
        let mut line = Line::new(name, proud >= SEEN, found, &format!("at least {SEEN} mm"));
        if line.status == Status::Fail && !claimed {
            line.status = Status::Warn;
        }
        line
    };
    cores.iter().filter(|core| !core.sockets.is_empty()).map(line).collect()
}

/// The height of the highest inlet, below which stubs are [mm]: bodies may hang lower.
fn seat(mold: &ClosedMold) -> f64 {
    let sockets = mold.report.features.iter().filter(|f| f.purpose == Purpose::Socket);
    let tops = sockets.map(|socket| socket.base[2].max(socket.base[2] + socket.axis[2]));
    tops.fold(mold.cast.solid.bounds().0.z, f64::max)
}

/// The stubs of a core, with the sockets in which most of it stands.
fn stubs<'a>(mold: &ClosedMold, core: &'a Body, solid: Solid) -> Stubs<'a> {
    let sockets = mold.report.features.iter().filter(|f| f.purpose == Purpose::Socket);
    let share = |socket: &Solid, body: &Body| body.solid.intersection(socket).volume();
    let own = sockets.filter_map(|socket| {
        let hole = socket.exact();
        let mine = share(&hole, core);
        let most = mold.cores.iter().all(|other| share(&hole, other) <= mine);
        let axis = Vec3::from(socket.base);
        // of its lower half: above, the shoulder of the core may reach into the socket
        let (low, high) = hole.bounds();
        let half = hole.trim_by_plane(&-Vec3::z(), -(low.z + high.z) / 2.0);
        let stub = solid.intersection(&half).to_surface();
        let reach = stub.vertices.iter().map(|p| (p - axis).xy().norm()).fold(0.0, f64::max);
        (most && mine > 0.0).then_some((axis, (socket.base_radius - reach).max(0.0)))
    });
    Stubs { name: &core.name, sockets: own.collect(), solid }
}

impl Stubs<'_> {
    /// How far these stubs stand proud when they are turned in their sockets [mm], at most `depth`.
    fn proud(&self, floor: &Solid, depth: f64) -> f64 {
        let (low, high) = floor.bounds();
        let is_seen = |placed: &Solid| {
            let (from, to) = placed.bounds();
            (from - low).xy().min() < 0.0 || (high - to).xy().min() < 0.0
        };
        let mut least = depth;
        for (from, _) in &self.sockets {
            for (to, play) in &self.sockets {
                for turn in (0..TURNS).map(|k| TAU * k as f64 / TURNS as f64) {
                    if from == to && turn.min(TAU - turn) < SAME {
                        continue;
                    }
                    for aside in pushed(*play) {
                        let placed = moved(&self.solid, from, &(to + aside), turn);
                        if !is_seen(&placed) {
                            least = lowered(&placed, floor, least);
                        }
                    }
                }
            }
        }
        least
    }
}

/// In the middle, and to six sides.
fn pushed(play: f64) -> Vec<Vec3> {
    let side = |k: usize| {
        let angle = TAU * k as f64 / 6.0;
        Vec3::new(angle.cos(), angle.sin(), 0.0) * (PLAY * play)
    };
    [Vec3::zeros()].into_iter().chain((0..6).map(side)).collect()
}

/// A solid turned about the upright line through a point, which is moved level to another.
fn moved(solid: &Solid, from: &Vec3, to: &Vec3, turn: f64) -> Solid {
    let rotation = Rotation3::from_axis_angle(&Vec3::z_axis(), turn);
    let shift = Vec3::new(to.x, to.y, 0.0) - rotation * Vec3::new(from.x, from.y, 0.0);
    let m = rotation.matrix();
    solid.transform(&Matrix3x4::from_columns(&[
        m.column(0).into_owned(),
        m.column(1).into_owned(),
        m.column(2).into_owned(),
        shift,
    ]))
}

/// The height from which stubs meet nothing of the floor, if it is below `least`; else that.
fn lowered(stubs: &Solid, floor: &Solid, least: f64) -> f64 {
    let free = |height: f64| {
        stubs.translate(&(Vec3::z() * height)).intersection(floor).volume() <= TOUCHING
    };
    if !free(least) {
        return least;
    }
    let (mut low, mut high) = (0.0, least);
    if free(low) {
        return low;
    }
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if free(middle) { high = middle } else { low = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::Config;
    use crate::mold::Opening;
    use crate::mold::features::core::Print;

    /// The thinnest stub of which the mold says that it fits one way only stands proud when it is turned.
    #[test]
    fn the_thinnest_stub_that_keeps_from_turning_does() {
        let config = Config::default();
        let away = Solid::cube(&Vec3::repeat(1.0), &Vec3::repeat(2.0));
        let print = |inlet: f64| {
            let inlet = Opening { centre: Vec3::zeros(), radius: inlet };
            Print::new(&inlet, -8e-3, &away, &config).unwrap()
        };
        let inlets = (1200..3000).map(|k| 1e-6 * f64::from(k));
        let thinnest = inlets.map(print).find(Print::keeps_from_turning).unwrap();
        let millimetres = Matrix3x4::from_partial_diagonal(&[1e3; 3]);
        let solid = |solid: Solid| solid.transform(&millimetres);
        let socket = solid(thinnest.socket_solid());
        let around = Solid::cube(&Vec3::new(-9.0, -9.0, -8.0), &Vec3::new(9.0, 9.0, 0.0));
        let below = |solid: Solid| solid.trim_by_plane(&-Vec3::z(), 0.0);
        let sockets = vec![(Vec3::new(0.0, 0.0, -8.0), 1e3 * config.stub_clearance())];
        let stub = below(solid(thinnest.stub_solid()));
        let stubs = Stubs { name: "core", solid: stub, sockets };
        let proud = stubs.proud(&around.difference(&socket), 8.0);
        assert!(proud >= SEEN, "{proud} mm with a stub of {:e} m", thinnest.stub.base_radius);
    }

    /// The thin stub would stand in the thick one's socket if the thick one could stand beside the floor.
    #[test]
    fn places_with_a_stub_beside_the_floor_do_not_count() {
        let round = |x: f64, radius: f64| {
            Solid::cylinder(&Vec3::new(x, 0.0, -8.0), &(8.0 * Vec3::z()), radius, radius, 48)
        };
        let sockets = vec![(Vec3::new(-8.0, 0.0, -8.0), 0.2), (Vec3::new(8.0, 0.0, -8.0), 0.2)];
        let solid = round(-8.0, 2.5).union(&round(8.0, 3.5));
        let stubs = Stubs { name: "core", solid, sockets };
        let floor = Solid::cube(&Vec3::new(-13.0, -9.0, -10.0), &Vec3::new(13.0, 9.0, 0.0));
        let floor = floor.difference(&round(-8.0, 2.7)).difference(&round(8.0, 3.7));
        let proud = stubs.proud(&floor, 8.0);
        assert!(proud >= SEEN, "{proud} mm");
    }
}
