//! Numbers of the rooms of terms.

use super::loads::largest;
use super::{Kind, Number, Swept};
use crate::config::SimConfig;
use crate::model::Scene;
use crate::term::{Known, Place, Room, RoomNumber};
use mechanics::schedule::Written;

/// A radian [°].
const RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// A room of a scene, which has all of them.
fn room<'a>(scene: &'a Scene, list: &str) -> &'a dyn Room {
    scene.config.room(list).expect("all scenes have all rooms")
}

/// The numbers of a room of a scene.
pub(super) fn numbers(kind: &'static Kind, list: &str, scene: &Scene) -> Vec<Number> {
    let one = |(k, number): (usize, RoomNumber)| Number {
        path: [list, &number.name, &number.slot.key].join("."),
        unit: number.slot.unit,
        key: number.slot.key,
        kind,
        place: [number.table, k],
    };
    room(scene, list).numbers().into_iter().enumerate().map(one).collect()
}

/// What is written of a number, and whether values are added to that.
pub(super) fn written(number: &Number, list: &str, scene: &Scene) -> (Written, bool) {
    room(scene, list).written(number.owner(), &number.key)
}

/// Where a number is.
pub(super) fn place<'a>(number: &Number, list: &str, config: &'a mut SimConfig) -> Place<'a> {
    let mut rooms = config.rooms_mut().into_iter();
    let room = rooms.find(|room| room.list() == list).expect("all scenes have all rooms");
    room.number(number.owner(), &number.key)
}

/// What changes of a number are small against, where that is not its value: of a component of a vector that is a function
/// of time the largest of all.
pub(super) fn scale(number: &Number, list: &str, scene: &Scene) -> Option<f64> {
    let room = room(scene, list);
    let vector = number.key.split('.').next();
    let of_vector = |other: &RoomNumber| {
        other.table == number.owner() && other.slot.key.split('.').next() == vector
    };
    if !room.written(number.owner(), &number.key).1 {
        return (number.unit == "°").then_some(RADIAN);
    }
    let all = room.numbers().into_iter().filter(of_vector);
    let sizes = all.map(|own| largest(scene, &room.written(own.table, &own.slot.key).0));
    Some(sizes.fold(0.0, f64::max))
}

/// The derivative of a result by a number, in whose unit angles are degrees.
pub(super) fn derivative(number: &Number, list: &str, swept: &Swept) -> f64 {
    let scene = swept.scene;
    let known =
        Known { regions: &scene.regions(&scene.body), by: &|owner, key| swept.by(owner, key) };
    let by = room(scene, list).derivative(number.owner(), &number.key, &known);
    if number.unit == "°" { by.to_radians() } else { by }
}
