//! Numbers of the rooms of terms.

use mechanics::energy::Owner;

use super::{Kind, Number, Swept};
use crate::model::Scene;

/// The numbers of a room of a scene.
pub(super) fn numbers(kind: &'static Kind, list: &str, scene: &Scene) -> Vec<Number> {
    let numbers = scene.config.room(list).map(|room| room.numbers()).unwrap_or_default();
    let one = |(k, number): (usize, crate::term::RoomNumber)| Number {
        path: [list, &number.name, &number.slot.key].join("."),
        unit: number.slot.unit,
        key: number.slot.key,
        kind,
        place: [number.table, k],
    };
    numbers.into_iter().enumerate().map(one).collect()
}

/// Its value in a scene.
pub(super) fn value(number: &Number, scene: &Scene) -> f64 {
    let room = scene.config.room(number.word()).expect("the room that it is of");
    room.value(number.owner(), &number.key)
}

/// Gives it another one.
pub(super) fn set(number: &Number, list: &str, scene: &mut Scene, value: f64) {
    let rooms = scene.config.rooms_mut().into_iter();
    let room = rooms.filter(|room| room.list() == list);
    room.for_each(|room| room.set(number.owner(), &number.key, value));
}

/// The derivative of a result by it, in whose unit angles are degrees.
pub(super) fn derivative(number: &Number, list: &'static str, swept: &Swept) -> f64 {
    let by = swept.by(Owner::new(list, number.owner()), &number.key);
    if number.unit == "°" { by.to_radians() } else { by }
}
