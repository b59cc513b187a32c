//! The pieces of a mold, and what holds them together.

use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3, measure};

use super::cast_body::Part;
use super::{Feature, Mold, MoldError, Piece, Purpose};
use crate::body::orientation::{Parting, Portion, Stance};
use crate::config::Config;
use crate::geometry::frame::{Pull, Turn};
use crate::geometry::frustum::Frustum;
use crate::mold::features::block::Block;
use crate::mold::features::flange::Joint;
use crate::mold::features::key::Sizes;
use crate::mold::features::label::{self, Face};
use crate::mold::features::outside::{hull, slab};
use crate::mold::parting::{Site, Split, affine, divide, turned};

/// Columns of a height field; ten times those of a hand-sized part at the default spacing.
const MOST_COLUMNS: f64 = 1e6;

impl Mold {
    /// Makes the outside, around the part and the rims of its channels, and the shells.
    pub(super) fn divide(
        &mut self,
        part: &Part,
        rims: &[Vec3],
        stance: &Stance,
        pull: Pull,
        config: &Config,
    ) -> Result<(), MoldError> {
        let below = Block::below(stance.portion, config);
        let points = [&part.surface.vertices, rims].concat();
        self.outside = hull(&points, &self.block, below, config);
        match (&stance.parting, pull) {
            (Parting::Open, _) => self.add_tray(part, config),
            (Parting::Seat, _) => self.add_cup_on_plate(part, config),
            (_, Pull::Z) => self.add_upper_and_lower(part, stance, config)?,
            (_, Pull::Y) => self.add_sides_on_base(part, stance, config)?,
        }
        Ok(())
    }

    fn add_shell(&mut self, name: &str, solid: Solid, leaves: Vec3) {
        self.shells.push(Piece { name: name.into(), solid, leaves });
    }

    /// One piece, open above.
    fn add_tray(&mut self, part: &Part, config: &Config) {
        let Block { min, max } = self.block.clone();
        self.raise("tray", front(&min, &max, [min.z, max.z], -Vec3::z()), config);
        let tray = self.outside.difference(&part.filled);
        self.add_shell("tray", tray, -Vec3::z());
    }

    /// A cup, and the plate on which it stands.
    fn add_cup_on_plate(&mut self, part: &Part, config: &Config) {
        let Block { min, max } = self.block.clone();
        let thickness = config.flange.thickness;
        let (bottom, joint, top) = (min.z, part.seat, part.seat + thickness);
        self.widen(Vec3::new(min.x, min.y, bottom), Vec3::new(max.x, max.y, top));
        let [upper, lower] = match self.portion {
            Portion::Whole => ["upper", "lower"],
            Portion::Above(_) | Portion::Below(_) => ["cup", "lid"],
        };
        self.raise(upper, front(&min, &max, [joint, top], Vec3::z()), config);
        self.raise(lower, front(&min, &max, [bottom, joint], -Vec3::z()), config);
        let (mut cup, mut plate) = self.cut_at_seat(part);
        self.add_keys(joint, &mut plate, &mut [&mut cup], config);
        self.add_shell(upper, cup, Vec3::z());
        self.add_shell(lower, plate, -Vec3::z());
        self.bolt(&self.joint(joint), Turn::lowering(-Vec3::z()), config);
    }

    /// Two shells that part above each other.
    fn add_upper_and_lower(
        &mut self,
        part: &Part,
        stance: &Stance,
        config: &Config,
    ) -> Result<(), MoldError> {
        let split = self.split(part, stance, Pull::Z, config)?;
        let Block { min, max } = self.block.clone();
        let thickness = config.flange.thickness;
        let level = split.level;
        self.level = level;
        let at = |z: f64| z.clamp(min.z, max.z);
        let (bottom, top) = (at(level - thickness), at(level + thickness));
        self.widen(Vec3::new(min.x, min.y, bottom), Vec3::new(max.x, max.y, top));
        self.raise("upper", front(&min, &max, [level, top], Vec3::z()), config);
        self.raise("lower", front(&min, &max, [bottom, level], -Vec3::z()), config);
        let sides = divide(&self.outside, &part.filled, &split);
        self.findings.extend(split.findings);
        self.findings.extend(sides.findings);
        let (mut upper, mut lower) = (sides.above, sides.below);
        self.add_keys(level, &mut lower, &mut [&mut upper], config);
        self.add_shell("upper", upper, Vec3::z());
        self.add_shell("lower", lower, -Vec3::z());
        self.bolt(&self.joint(level), Turn::lowering(-Vec3::z()), config);
        Ok(())
    }

    /// Two shells side by side, on a base.
    fn add_sides_on_base(
        &mut self,
        part: &Part,
        stance: &Stance,
        config: &Config,
    ) -> Result<(), MoldError> {
        let split = self.split(part, stance, Pull::Y, config)?;
        let Block { min, max } = self.block.clone();
        let thickness = config.flange.thickness;
        let (level, joint) = (split.level, part.seat);
        self.level = level;
        let foot = joint + thickness;
        self.widen(min, Vec3::new(max.x, max.y, foot));
        self.widen(
            Vec3::new(min.x, level - thickness, min.z),
            Vec3::new(max.x, level + thickness, max.z),
        );
        let base_name = match self.portion {
            Portion::Whole => "base",
            Portion::Above(_) | Portion::Below(_) => "lid",
        };
        let middle = (foot + max.z) / 2.0;
        let rim = |along: Vec3, y: f64, down: Vec3| Face {
            middle: Vec3::new(max.x, y, middle),
            along,
            up: along.cross(&Vec3::x()) * -1.0,
            size: [max.z - foot, thickness],
            down,
        };
        self.raise(base_name, front(&min, &max, [min.z, joint], -Vec3::z()), config);
        self.raise("left", rim(Vec3::z(), level + thickness / 2.0, Vec3::y()), config);
        self.raise("right", rim(-Vec3::z(), level - thickness / 2.0, -Vec3::y()), config);
        let (above, mut base) = self.cut_at_seat(part);
        let empty = Solid::cube(&Vec3::zeros(), &Vec3::zeros());
        let turn = Turn::lowering(-Vec3::y());
        let mut sides = divide(&above, &empty, &split.turned(turn.inverse()));
        self.findings.append(&mut sides.findings);
        let (mut left, mut right) = (sides.above, sides.below);
        self.add_keys(joint, &mut base, &mut [&mut left, &mut right], config);
        // Seen along the pull, x runs to the right and z down.
        let rim = Joint { low: [min.x, -max.z], high: [max.x, -foot], level };
        for [x, y] in Sizes::of(config).sites(rim.low, rim.high) {
            let key = Sizes::of(config).key(Vec3::new(x, y, level));
            let place = |cone: &Frustum| cone.solid().transform(&affine(turn.inverse()));
            right = right.union(&place(&key.male));
            left = left.difference(&place(&key.female));
            let frustum = turned(&key.seat, turn.inverse());
            self.features.push(Feature { purpose: Purpose::Key, frustum });
        }
        self.add_shell("left", left, Vec3::y());
        self.add_shell("right", right, -Vec3::y());
        self.add_shell(base_name, base, -Vec3::z());
        self.bolt(&rim, turn.inverse(), config);
        for bolt in self.joint(joint).corner_bolts(min.z, foot, config) {
            self.cut(Purpose::Bolt, bolt);
        }
        Ok(())
    }

    /// What is above the seat, without the part, and what is below. A part that is cut
    /// there has its core on what is below.
    fn cut_at_seat(&self, part: &Part) -> (Solid, Solid) {
        let above = self.outside.trim_by_plane(&Vec3::z(), part.seat).difference(&part.filled);
        let region = self.outside.trim_by_plane(&-Vec3::z(), -part.seat);
        let below = match self.portion {
            Portion::Whole => region.difference(&part.filled),
            // Not what is left by body and cup: where their surfaces differ in the last bits,
            // that has films.
            Portion::Above(_) | Portion::Below(_) => {
                part.cores.iter().fold(region, |all, core| all.union(&core.solid))
            }
        };
        (above, below)
    }

    /// The level rectangle over all of the block.
    fn joint(&self, level: f64) -> Joint {
        let Block { min, max } = &self.block;
        Joint { low: [min.x, min.y], high: [max.x, max.y], level }
    }

    /// Adds a box to the outside.
    fn widen(&mut self, min: Vec3, max: Vec3) {
        self.outside = self.outside.union(&slab(&self.block, min, max));
    }

    /// Raises the name of a piece on a face of the outside.
    fn raise(&mut self, name: &str, face: Face, config: &Config) {
        if config.labels {
            self.outside = self.outside.union(&label::word(name, &face));
        }
    }

    /// Keys on a level joint: cones on what is below, holes in what is above.
    fn add_keys(
        &mut self,
        level: f64,
        below: &mut Solid,
        above: &mut [&mut Solid],
        config: &Config,
    ) {
        let Joint { low, high, .. } = self.joint(level);
        for [x, y] in Sizes::of(config).sites(low, high) {
            let key = Sizes::of(config).key(Vec3::new(x, y, level));
            *below = below.union(&key.male.solid());
            for shell in above.iter_mut() {
                **shell = shell.difference(&key.female.solid());
            }
            self.features.push(Feature { purpose: Purpose::Key, frustum: key.seat });
        }
    }

    /// Holes for bolts and a slot for a screwdriver, in coordinates with z along the pull.
    fn bolt(&mut self, joint: &Joint, turn: Turn, config: &Config) {
        for bolt in joint.bolts(config) {
            self.cut(Purpose::Bolt, turned(&bolt, turn));
        }
        self.cut(Purpose::Pry, turned(&joint.pry(config), turn));
    }

    /// The parting surface, in coordinates with z along the pull.
    fn split(
        &self,
        part: &Part,
        stance: &Stance,
        pull: Pull,
        config: &Config,
    ) -> Result<Split, MoldError> {
        let turn = Turn::lowering(-pull.vector());
        let corners = [turn.0 * self.block.min, turn.0 * self.block.max];
        let (min, max) = measure::bounds(&corners);
        let rim = match pull {
            Pull::Z => [Joint::band(config), Block::rim(config)],
            Pull::Y => [Joint::band(config), 0.0],
        };
        let site = Site { min, max, rim };
        match &stance.parting {
            Parting::HeightField(field) => {
                let columns = (max.x - min.x) * (max.y - min.y) / field.cell.powi(2);
                if columns > MOST_COLUMNS {
                    let (cell, most) = (field.cell, MOST_COLUMNS);
                    return Err(MoldError::Columns { cell, columns, most });
                }
                let vertices = part.surface.vertices.iter().map(|p| turn.0 * p).collect();
                let triangles = part.surface.triangles.clone();
                Ok(Split::height_field(&site, &SurfaceMesh { vertices, triangles }, field))
            }
            Parting::Plane(position) => {
                let point = self.frame.point(&(stance.pull * *position));
                Ok(Split::plane(&site, point.dot(&pull.vector())))
            }
            Parting::Seat | Parting::Open => Ok(Split::plane(&site, part.seat)),
        }
    }
}

/// The face of a block that looks along −y, between two heights, of a piece that is printed
/// with `down` below.
fn front(min: &Vec3, max: &Vec3, [low, high]: [f64; 2], down: Vec3) -> Face {
    Face {
        middle: Vec3::new((min.x + max.x) / 2.0, min.y, (low + high) / 2.0),
        along: Vec3::x(),
        up: Vec3::z(),
        size: [max.x - min.x, high - low],
        down,
    }
}
