//! The outside of a mold divided into shells, and what joins these.

use anyhow::{Result, ensure};
use geometry::frame::{Frame, Pull, Turn, moved};
use geometry::frustum::Frustum;
use mesh::check::Finding;
use mesh::solid::Solid;
use mesh::{Vec3, measure};

use super::cast_body::CastBody;
use super::features::block::Block;
use super::features::flange::Joint;
use super::features::key::{Key, Sizes};
use super::features::label::{self, Face};
use super::features::outside::{hull, slab};
use super::parting::{Sides, Site, Split, affine, divide, turned};
use super::piece::{Feature, Piece, Purpose, cut};
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::config::Config;
use crate::config::method::Method;

/// Columns of a height field; ten times those of a hand-sized part at the default spacing.
const MOST_COLUMNS: f64 = 1e6;

/// A piece stands on the seat if it ends within this distance of it: rounding [m].
const ON_SEAT: f64 = 1e-9;

/// What a mold is made from.
pub struct Blank<'a> {
    /// What is cast.
    pub body: CastBody,
    /// Bounds of the closed mold.
    pub block: Block,
    /// From the design to the mold.
    pub frame: Frame,
    /// How the body stands, and where the shells separate.
    pub orientation: &'a Orientation,
    /// In which direction.
    pub pull: Pull,
    /// How the cores leave the body.
    pub method: Method,
    /// What was asked for.
    pub config: &'a Config,
}

/// The outside of a mold and its shells, without sockets and channels.
pub struct Division {
    /// Outside of the closed mold.
    pub outside: Solid,
    /// Shells, and the base if there is one, taken apart in reverse order.
    pub shells: Vec<Piece>,
    /// Keys, bolts and slots.
    pub features: Vec<Feature>,
    /// What a person should know.
    pub findings: Vec<Finding>,
}

impl Division {
    /// The outside around the body and the rims of its channels, divided as the body stands.
    pub fn new(blank: &Blank, rims: &[Vec3]) -> Result<Self> {
        let Blank { body, block, orientation, pull, config, .. } = blank;
        let below = Block::below(orientation.portion, config);
        let points = [&body.surface.vertices, rims].concat();
        let hull = hull(&points, block, below, config);
        match (&orientation.parting, pull) {
            (PartingSurface::Open, _) => Ok(blank.tray(&hull)),
            (PartingSurface::Seat, _) => Ok(blank.cup_on_plate(&hull)),
            (_, Pull::Z) => blank.upper_and_lower(&hull),
            (_, Pull::Y) => blank.sides_on_base(&hull),
        }
    }
}

/// What is above a seat and what is below, with the plugs of holes that open there, such as those of screws: nothing
/// else holds them, and they leave the body with the piece on which it stands.
fn with_plugs(above: Solid, below: Solid, seat: f64) -> Sides {
    let stands = |piece: &Solid| (piece.bounds().0.z - seat).abs() <= ON_SEAT;
    let mut pieces = above.decompose();
    pieces.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
    let plugs: Vec<&Solid> = pieces.iter().skip(1).filter(|piece| stands(piece)).collect();
    Sides {
        above: plugs.iter().fold(above.clone(), |rest, plug| rest.difference(plug)),
        below: plugs.iter().fold(below, |all, plug| all.union(plug)),
        findings: Vec::new(),
    }
}

impl Blank<'_> {
    /// One piece, open above, with a plate in front, as the front of the hull may be too
    /// small for all letters of its name.
    fn tray(&self, hull: &Solid) -> Division {
        let Block { min, max } = &self.block;
        let behind = min.y + self.config.flange.thickness;
        let outside = self.widened(hull, [*min, Vec3::new(max.x, behind, max.z)]);
        let face = front(min, max, [min.z, max.z], -Vec3::z());
        let (outside, findings) = self.labelled(outside, [("tray", face)]);
        let tray = shell("tray", outside.difference(&self.body.filled), -Vec3::z());
        let features = Vec::new();
        Division { outside, shells: vec![tray], features, findings }
    }

    /// A cup, and the plate on which it stands.
    fn cup_on_plate(&self, hull: &Solid) -> Division {
        let seat = self.body.seat;
        let names = match self.orientation.portion {
            Portion::Whole => ["upper", "lower"],
            Portion::Above(_) | Portion::Below(_) => ["cup", "lid"],
        };
        let levels = [self.block.min.z, seat, seat + self.config.flange.thickness];
        self.above_each_other(hull, names, levels, |outside| self.cut_at_seat(outside))
    }

    /// Two shells that part above each other.
    fn upper_and_lower(&self, hull: &Solid) -> Result<Division> {
        let split = self.split()?;
        let Block { min, max } = &self.block;
        let (level, thickness) = (split.level, self.config.flange.thickness);
        let [bottom, top] = [level - thickness, level + thickness].map(|z| z.clamp(min.z, max.z));
        let divided = |outside: &Solid| {
            let sides = divide(outside, &self.body.filled, &split);
            Sides { findings: [split.findings.clone(), sides.findings].concat(), ..sides }
        };
        Ok(self.above_each_other(hull, ["upper", "lower"], [bottom, level, top], divided))
    }

    /// Two shells that `divided` makes of the outside, which meet at a level in the flange from `bottom` to `top`.
    fn above_each_other(
        &self,
        hull: &Solid,
        [upper, lower]: [&str; 2],
        [bottom, level, top]: [f64; 3],
        divided: impl FnOnce(&Solid) -> Sides,
    ) -> Division {
        let Block { min, max } = &self.block;
        let flange = [Vec3::new(min.x, min.y, bottom), Vec3::new(max.x, max.y, top)];
        let faces = [
            (upper, front(min, max, [level, top], Vec3::z())),
            (lower, front(min, max, [bottom, level], -Vec3::z())),
        ];
        let (outside, unlabelled) = self.labelled(self.widened(hull, flange), faces);
        let Sides { above, below, findings } = divided(&outside);
        let joint = self.joint(level);
        let keys = self.keys(&joint);
        let shells = vec![
            shell(upper, holed(above, &keys, Turn::NONE), Vec3::z()),
            shell(lower, coned(below, &keys, Turn::NONE), -Vec3::z()),
        ];
        let bolts = self.bolts(&joint, Turn::NONE);
        Division {
            outside,
            shells: cut(shells, &bolts),
            features: [seats(&keys, Turn::NONE), bolts].concat(),
            findings: [findings, unlabelled].concat(),
        }
    }

    /// Two shells side by side, on a base.
    fn sides_on_base(&self, hull: &Solid) -> Result<Division> {
        let split = self.split()?;
        let Block { min, max } = &self.block;
        let thickness = self.config.flange.thickness;
        let (level, joint) = (split.level, self.body.seat);
        let foot = joint + thickness;
        let name = match self.orientation.portion {
            Portion::Whole => "base",
            Portion::Above(_) | Portion::Below(_) => "lid",
        };
        let outside = self.widened(hull, [*min, Vec3::new(max.x, max.y, foot)]);
        let low = Vec3::new(min.x, level - thickness, min.z);
        let outside = self.widened(&outside, [low, Vec3::new(max.x, level + thickness, max.z)]);
        let [left, right] = self.rims(level, foot);
        let below = front(min, max, [min.z, joint], -Vec3::z());
        let faces = [(name, below), ("left", left), ("right", right)];
        let (outside, unlabelled) = self.labelled(outside, faces);

        let Sides { above, below: base, .. } = self.cut_at_seat(&outside);
        let empty = Solid::cube(&Vec3::zeros(), &Vec3::zeros());
        let turn = Turn::lowering(-Vec3::y()).inverse();
        let sides = divide(&above, &empty, &split.turned(turn));
        let on_base = self.keys(&self.joint(joint));
        // Seen along the pull, x runs to the right and z down.
        let rim = Joint { low: [min.x, -max.z], high: [max.x, -foot], level };
        let between = self.keys(&rim);
        let left = holed(holed(sides.above, &on_base, Turn::NONE), &between, turn);
        let right = coned(holed(sides.below, &on_base, Turn::NONE), &between, turn);
        let shells = vec![
            shell("left", left, Vec3::y()),
            shell("right", right, -Vec3::y()),
            shell(name, coned(base, &on_base, Turn::NONE), -Vec3::z()),
        ];
        let corners = self.joint(joint).corner_bolts(min.z, foot, self.config);
        let corners = corners.into_iter().map(|frustum| hole(Purpose::Bolt, frustum));
        let bolts: Vec<Feature> = self.bolts(&rim, turn).into_iter().chain(corners).collect();
        Ok(Division {
            outside,
            shells: cut(shells, &bolts),
            features: [seats(&on_base, Turn::NONE), seats(&between, turn), bolts].concat(),
            findings: [sides.findings, unlabelled].concat(),
        })
    }

    /// Faces of the flanges of left and right shell, above the foot.
    fn rims(&self, level: f64, foot: f64) -> [Face; 2] {
        let (max, thickness) = (&self.block.max, self.config.flange.thickness);
        let rim = |along: Vec3, y: f64, down: Vec3| Face {
            middle: Vec3::new(max.x, y, (foot + max.z) / 2.0),
            along,
            up: along.cross(&Vec3::x()) * -1.0,
            size: [max.z - foot, thickness],
            down,
        };
        [
            rim(Vec3::z(), level + thickness / 2.0, Vec3::y()),
            rim(-Vec3::z(), level - thickness / 2.0, -Vec3::y()),
        ]
    }

    /// What is above the seat, without the part, and what is below. A part that is cut
    /// there has its core on what is below.
    fn cut_at_seat(&self, outside: &Solid) -> Sides {
        let CastBody { filled, cores, seat, .. } = &self.body;
        let above = outside.trim_by_plane(&Vec3::z(), *seat).difference(filled);
        let region = outside.trim_by_plane(&-Vec3::z(), -seat);
        let below = match self.orientation.portion {
            Portion::Whole => return with_plugs(above, region.difference(filled), *seat),
            // Not what is left by body and cup: where their surfaces differ in the last bits,
            // that has films.
            Portion::Above(_) | Portion::Below(_) => {
                cores.iter().fold(region, |all, core| all.union(&core.solid))
            }
        };
        Sides { above, below, findings: Vec::new() }
    }

    /// The level rectangle over all of the block.
    fn joint(&self, level: f64) -> Joint {
        let Block { min, max } = &self.block;
        Joint { low: [min.x, min.y], high: [max.x, max.y], level }
    }

    /// An outside with a box added to it.
    fn widened(&self, outside: &Solid, [min, max]: [Vec3; 2]) -> Solid {
        outside.union(&slab(&self.block, min, max))
    }

    /// An outside with the names of pieces raised on its faces, and which do not fit.
    fn labelled<const N: usize>(
        &self,
        mut outside: Solid,
        names: [(&str, Face); N],
    ) -> (Solid, Vec<Finding>) {
        let mut findings = Vec::new();
        for (name, face) in names.iter().filter(|_| self.config.labels) {
            match label::word(name, face) {
                Some(letters) => outside = outside.union(&letters),
                None => findings.push(unlabelled(name, face)),
            }
        }
        (outside, findings)
    }

    /// The keys of a joint.
    fn keys(&self, joint: &Joint) -> Vec<Key> {
        let sizes = Sizes::of(self.config);
        let sites = sizes.sites(joint.low, joint.high).into_iter();
        sites.map(|[x, y]| sizes.key(Vec3::new(x, y, joint.level))).collect()
    }

    /// Holes for bolts and a slot for a screwdriver. The joint has z along the pull; `turn`
    /// leads from there to the mold.
    fn bolts(&self, joint: &Joint, turn: Turn) -> Vec<Feature> {
        let bolts = joint.bolts(self.config).into_iter();
        let bolts = bolts.map(|frustum| hole(Purpose::Bolt, turned(&frustum, turn)));
        let pry = hole(Purpose::Pry, turned(&joint.pry(self.config), turn));
        bolts.chain([pry]).collect()
    }

    /// The parting surface, in coordinates with z along the pull.
    fn split(&self) -> Result<Split> {
        let Blank { body, block, pull, config, .. } = self;
        let turn = Turn::lowering(-pull.vector());
        let corners = [turn.0 * block.min, turn.0 * block.max];
        let (min, max) = measure::bounds(&corners);
        let rim = match pull {
            Pull::Z => [Joint::band(config), Block::rim(config)],
            Pull::Y => [Joint::band(config), 0.0],
        };
        let site = Site { min, max, rim };
        match &self.orientation.parting {
            PartingSurface::HeightField(field) => {
                let columns = (max.x - min.x) * (max.y - min.y) / field.cell.powi(2);
                ensure!(
                    columns <= MOST_COLUMNS,
                    "parting.cell = {} m makes {columns:.1e} columns over the mold, at most {MOST_COLUMNS:.1e} are allowed; \
                     enlarge it",
                    field.cell
                );
                Ok(Split::height_field(&site, &moved(&body.surface, |p| turn.0 * p), field))
            }
            PartingSurface::Plane(position) => {
                let point = self.frame.point(&(self.orientation.pull * *position));
                Ok(Split::plane(&site, point.dot(&pull.vector())))
            }
            PartingSurface::Seat | PartingSurface::Open => Ok(Split::plane(&site, body.seat)),
        }
    }
}

/// A piece without its name.
fn unlabelled(name: &str, face: &Face) -> Finding {
    let [width, height] = face.size.map(|size| size * 1e3);
    Finding {
        rule: "label",
        message: format!(
            "the name {name:?} does not fit on a face of {width:.1} × {height:.1} mm in letters of \
             {:.1} mm or higher: mark the piece by hand, or increase flange.thickness",
            label::LOWEST * 1e3
        ),
        count: 1,
    }
}

fn shell(name: &str, solid: Solid, demolding: Vec3) -> Piece {
    Piece { name: name.into(), solid, demolding }
}

fn hole(purpose: Purpose, frustum: Frustum) -> Feature {
    Feature { purpose, frustum }
}

/// A frustum of a joint as a solid of the mold.
fn placed(frustum: &Frustum, turn: Turn) -> Solid {
    match turn == Turn::NONE {
        true => frustum.solid(),
        false => frustum.solid().transform(&affine(turn)),
    }
}

/// A piece with the cones of keys.
fn coned(piece: Solid, keys: &[Key], turn: Turn) -> Solid {
    keys.iter().fold(piece, |piece, key| piece.union(&placed(&key.male, turn)))
}

/// A piece with the holes for keys.
fn holed(piece: Solid, keys: &[Key], turn: Turn) -> Solid {
    keys.iter().fold(piece, |piece, key| piece.difference(&placed(&key.female, turn)))
}

/// The holes for keys as they are reported.
fn seats(keys: &[Key], turn: Turn) -> Vec<Feature> {
    keys.iter().map(|key| hole(Purpose::Key, turned(&key.seat, turn))).collect()
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
