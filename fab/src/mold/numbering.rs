//! Numbers of sockets, below the piece that holds the cores.

use std::f64::consts::TAU;

use mesh::Vec3;
use mesh::check::Finding;
use mesh::solid::Solid;

use super::features::core::Print;
use super::features::label::Face;
use super::features::number;

/// Directions from a socket in which a place for its number is looked for.
const DIRECTIONS: usize = 16;

/// A number keeps this far from its socket and from all that is not full there [m].
const MARGIN: f64 = 8e-4;

/// How thick the piece must be above a number: more than its dots are deep [m].
const ABOVE: f64 = 1.5e-3;

/// The numbers of all sockets of a piece.
pub struct Numbers<'a> {
    /// Their dots.
    pub dots: Solid,
    holder: &'a Solid,
    /// The axes of all sockets.
    axes: Vec<Vec3>,
    /// Where there is no place for a number.
    without: Vec<String>,
}

impl<'a> Numbers<'a> {
    /// None yet, below a piece that holds these stubs.
    pub fn new(holder: &'a Solid, stands: &[Vec<Print>]) -> Self {
        let axes = stands.iter().flatten().map(|print| print.stub.base).collect();
        let dots = Solid::cube(&Vec3::zeros(), &Vec3::zeros());
        Self { dots, holder, axes, without: Vec::new() }
    }

    /// Names a place that has no number.
    pub fn without(&mut self, place: String) {
        self.without.push(place);
    }

    /// One more, beside the socket of a stub, as far from other sockets as can be.
    pub fn add(&mut self, number: usize, print: &Print) {
        let places = self.places(number, print);
        let free = places.into_iter().find(|face| self.is_free(face));
        match free.and_then(|face| number::dots(number, &face)) {
            Some(dots) => self.dots = self.dots.union(&dots),
            None => self.without(format!("the socket of core{number}")),
        }
    }

    /// Faces around a socket, the farthest from other sockets first.
    fn places(&self, number: usize, print: &Print) -> Vec<Face> {
        let size = number::largest(number);
        let reach = print.socket.base_radius + MARGIN + size[0].hypot(size[1]) / 2.0;
        let axis = print.socket.base;
        let floor = self.holder.bounds().0.z;
        let face = |k: usize| {
            let angle = TAU * k as f64 / DIRECTIONS as f64;
            let middle = axis + Vec3::new(angle.cos(), angle.sin(), 0.0) * reach;
            Face {
                middle: Vec3::new(middle.x, middle.y, floor),
                along: Vec3::x(),
                up: -Vec3::y(),
                size,
                down: -Vec3::z(),
            }
        };
        let others = || self.axes.iter().filter(|other| (*other - axis).xy().norm() > MARGIN);
        let distance = |face: &Face| {
            others().map(|o| (o - face.middle).xy().norm()).fold(f64::INFINITY, f64::min)
        };
        let mut faces: Vec<Face> = (0..DIRECTIONS).map(face).collect();
        faces.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
        faces
    }

    /// Whether the piece is full above a face.
    fn is_free(&self, face: &Face) -> bool {
        let [x, y] = face.size.map(|size| size / 2.0 + MARGIN);
        let low = face.middle - Vec3::new(x, y, 0.0);
        let room = Solid::cube(&low, &(face.middle + Vec3::new(x, y, ABOVE)));
        room.difference(self.holder).volume() <= 1e-6 * room.volume()
    }

    /// What has to be marked by hand.
    pub fn finding(self) -> Option<Finding> {
        let count = self.without.len();
        let places = self.without.join(", ");
        let message = format!("no room for the number on {places}: mark it by hand");
        (count > 0).then_some(Finding { rule: "number", message, count })
    }
}
