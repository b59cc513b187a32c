//! Where the groove for a thread runs, and where its ridge would hold back a shell.

use anyhow::{Result, ensure};
use geometry::{MM, place};
use mesh::bvh::SurfaceBvh;
use mesh::inside::WindingNumber;
use mesh::io::MshFile;
use mesh::{SurfaceMesh, Vec3};

use super::groove::{Groove, Station};
use crate::config::GrooveConfig;

/// How far a simplified line may be from that of the simulation, over the diameter of the thread [1].
const STRAIGHT: f64 = 0.02;

/// Longest piece, over the diameter of the thread [1].
const PIECE: f64 = 4.0;

/// Shortest groove that guides a thread, over its diameter: a judgement [1].
const SHORTEST: f64 = 8.0;

/// The sine of the angle by which facets at a parting plane may lean over it, as those of a round surface do.
const OVER: f64 = 0.1;

/// How far above the surface the bottom ends where a groove fades, over its depth: it leaves the body at an angle [1].
const FADE: f64 = 0.2;

/// Points nearer than this to the parting plane lie in it [m].
const SAME: f64 = 1e-9;

/// Pits are left out that would have to be widened by more than this, over their diameter [1].
const PIT: f64 = 1.0;

/// A body without its groove, and how its mold comes apart.
pub struct Ground<'a> {
    /// Boundary of the body with its chamber filled [m].
    pub filled: &'a SurfaceMesh,
    /// Unit vector along which the shells part [1].
    pub pull: Vec3,
    /// Where they part, along the pull [m].
    pub parting: f64,
    /// The mesh with its tags.
    pub file: &'a MshFile,
    /// Points of the design beside which pins stand [m].
    pub pins: &'a [[f64; 3]],
    /// How far from their axes the casting stays even [m].
    pub even: f64,
}

/// What is asked of the surface of a body along a line.
struct Surface<'a> {
    filled: &'a SurfaceMesh,
    bvh: SurfaceBvh,
    inside: WindingNumber,
    /// The facets that have tags, and whether each gets a groove.
    tagged: (SurfaceBvh, Vec<bool>),
}

/// A line on the body.
struct Line {
    stations: Vec<Station>,
    /// For each piece how it comes out.
    ways_out: Vec<WayOut>,
}

/// How a piece of the ridge comes out of the casting.
#[derive(Clone, Copy)]
enum WayOut {
    /// It comes out where its groove is widened by this beside the thread [m].
    By(f64),
    /// It is too near to a pin, or the surface leans over it.
    Never,
    /// No groove is asked for.
    Unasked,
}

impl Ground<'_> {
    /// Whether a point is where a pin stands that is asked for.
    fn is_beside_pin(&self, p: &Vec3) -> bool {
        let side = |q: &Vec3| q.dot(&self.pull) > self.parting;
        self.pins
            .iter()
            .map(|pin| Vec3::from(*pin))
            .any(|pin| side(&pin) == side(p) && (p - pin).cross(&self.pull).norm() < self.even)
    }
}

impl Groove {
    /// The groove for threads along lines, in the design's metres.
    pub fn new(lines: &[Vec<Vec3>], ground: &Ground, config: &GrooveConfig) -> Result<Self> {
        let surface = Surface::new(ground, config)?;
        let mut groove = Self {
            thread: config.thread,
            width: config.thread + config.clearance,
            depth: config.depth(),
            draft: config.draft,
            pit: config.knot * config.thread,
            pull: ground.pull.into(),
            parting: ground.parting,
            courses: Vec::new(),
            pits: Vec::new(),
            wound: 0.0,
            length: 0.0,
            widened: 0.0,
            locked: None,
        };
        for line in lines {
            let line = surface.line(&groove, line, ground)?;
            groove.add(&line, &surface, config.relief());
        }
        ensure!(
            groove.wound > 0.0,
            "groove.on: the thread of `wound` lies on none of {}; the tags of the mesh are {}",
            config.on.join(", "),
            ground.file.tags.names.join(", ")
        );
        ensure!(
            groove.length > 0.0,
            "[groove]: its ridge would hold back the shells all along: it had to be widened by up to {:.2} mm beside the \
             thread, and groove.relief allows {:.2} mm; choose a parting.pull across the thread, or enlarge groove.relief",
            groove.locked.unwrap_or(0.0) * MM,
            config.relief() * MM
        );
        Ok(groove)
    }

    /// Adds the parts of a line where the ridge comes out.
    fn add(&mut self, line: &Line, surface: &Surface, relief: f64) {
        let length = |piece: usize| {
            let [a, b] = [piece, piece + 1].map(|i| Vec3::from(line.stations[i].at));
            (b - a).norm()
        };
        let pieces = line.ways_out.len();
        let widened = |i: usize| match line.ways_out[i] {
            WayOut::By(widened) => Some(widened),
            WayOut::Never | WayOut::Unasked => None,
        };
        let is_asked = |i: &usize| !matches!(line.ways_out[*i], WayOut::Unasked);
        self.wound += (0..pieces).filter(is_asked).map(length).sum::<f64>();
        let comes_out = |i: usize| widened(i).is_some_and(|widened| widened <= relief);
        for widened in (0..pieces).filter_map(widened).filter(|&widened| widened > relief) {
            self.locked = Some(self.locked.unwrap_or(0.0).max(widened));
        }
        let mut start = 0;
        while start < pieces {
            let end = (start..pieces).find(|&i| !comes_out(i)).unwrap_or(pieces);
            let run: f64 = (start..end).map(length).sum();
            if run >= SHORTEST * self.thread {
                self.length += run;
                self.widened = (start..end).filter_map(widened).fold(self.widened, f64::max);
                let mut course = line.stations[start..=end].to_vec();
                // Where the ridge fades, the thread does not bend over an edge.
                if start > 0 {
                    course[0].depth = -FADE * self.depth;
                } else {
                    self.pits.extend(surface.pit(self, &line.stations[0]));
                }
                if end < pieces {
                    course[end - start].depth = -FADE * self.depth;
                } else {
                    self.pits.extend(surface.pit(self, &line.stations[pieces]));
                }
                self.courses.push(course);
            }
            start = end.max(start + 1);
        }
    }
}

impl<'a> Surface<'a> {
    fn new(ground: &Ground<'a>, config: &GrooveConfig) -> Result<Self> {
        let filled = ground.filled;
        let (bvh, inside) = (SurfaceBvh::new(filled), WindingNumber::new(filled));
        Ok(Self { filled, bvh, inside, tagged: tagged(ground.file, &config.on)? })
    }

    /// The line of a thread, on the surface.
    fn line(&self, groove: &Groove, points: &[Vec3], ground: &Ground) -> Result<Line> {
        let thread = groove.thread;
        let off = points.iter().map(|p| (self.bvh.closest(p).distance, p));
        let off = off.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((off, at)) = off {
            let at = place(at, 2);
            ensure!(
                off <= thread,
                "[groove]: the thread of `wound` at {at} is {:.2} mm from the surface of the \
                 casting, more than its diameter: expected the report of a body whose thread lies on this one",
                off * MM
            );
        }
        let points = parted(&simplified(points, STRAIGHT * thread), |p| groove.beyond(p));
        let onto = |p: &Vec3| {
            let on = self.bvh.closest(p).point;
            // A point between both shells stays there.
            if groove.beyond(p).abs() < SAME { on - ground.pull * groove.beyond(&on) } else { on }
        };
        let points: Vec<Vec3> = divided(&points, PIECE * thread).iter().map(onto).collect();
        let last = points.len() - 1;
        let mut stations = Vec::new();
        for (i, p) in points.iter().enumerate() {
            let along = (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).normalize();
            let beside = [-0.5, 0.0, 0.5].map(|part| p + along * (part * thread));
            let normal: Vec3 =
                beside.iter().map(|q| self.filled.normal(self.bvh.closest(q).triangle)).sum();
            // The section between both shells lies in the parting plane: no part of it leaves with the other shell.
            let between = groove.beyond(p).abs() < SAME;
            let along =
                if between { ground.pull * along.dot(&ground.pull).signum() } else { along };
            let normal = (normal - along * normal.dot(&along)).normalize();
            let depth = groove.depth;
            let (at, normal, along) = ((*p).into(), normal.into(), along.into());
            stations.push(Station { at, normal, along, depth, reach: 0.0 });
        }
        let mut ways_out = Vec::new();
        for i in 0..last {
            let pair = [&stations[i], &stations[i + 1]];
            let corners = pair.map(|station| groove.section(station)).concat();
            let way = groove.way_out(pair);
            let reach = self.reach(&corners, &[way]) + 0.25 * groove.depth;
            let wanted = |station: &&Station| {
                let at = Vec3::from(station.at);
                let (facets, wanted) = &self.tagged;
                wanted[facets.closest(&at).triangle].then(|| !ground.is_beside_pin(&at))
            };
            let over = pair.iter().any(|s| Vec3::from(s.normal).dot(&way) < -OVER);
            let beside = pair.iter().map(|s| (s.across().dot(&way) * reach).abs());
            let way_out = match pair.map(|station| wanted(&station)) {
                [Some(true), Some(true)] if !over => WayOut::By(beside.fold(0.0, f64::max)),
                [Some(_), Some(_)] => WayOut::Never,
                _ => WayOut::Unasked,
            };
            ways_out.push(way_out);
            stations[i].reach = reach;
        }
        Ok(Line { stations, ways_out })
    }

    /// The way that points have to go until they have left the body.
    fn reach(&self, points: &[Vec3], ways: &[Vec3]) -> f64 {
        let inside = points.iter().filter(|p| self.inside.contains(p));
        let exit = |p: &Vec3, way: &Vec3| self.bvh.ray(p, way).first().map_or(0.0, |hit| hit.0);
        inside.flat_map(|p| ways.iter().map(|way| exit(p, way))).fold(0.0, f64::max)
    }

    /// The pit for a knot, where it comes out.
    fn pit(&self, groove: &Groove, station: &Station) -> Option<Station> {
        let mut pit = Station { depth: groove.depth + groove.thread / 2.0, ..station.clone() };
        let corners = groove.pit(&pit);
        pit.reach = self.reach(&corners, &groove.leaving(&corners)) + 0.25 * groove.depth;
        (groove.pit > 0.0 && pit.reach - pit.depth <= PIT * groove.pit).then_some(pit)
    }
}

/// The facets that have tags, and whether each gets a groove.
fn tagged(file: &MshFile, on: &[String]) -> Result<(SurfaceBvh, Vec<bool>)> {
    for tag in on {
        ensure!(
            file.tags.id(tag).is_some(),
            "groove.on: no facet has the tag {tag:?}; the mesh has: {}",
            file.tags.names.join(", ")
        );
    }
    let asked: Vec<u32> = on.iter().filter_map(|tag| file.tags.id(tag)).collect();
    let (triangles, wanted) = (file.tags.facets.iter())
        .map(|(facet, id)| (*facet, on.is_empty() || asked.contains(id)))
        .unzip();
    let surface = SurfaceMesh { vertices: file.mesh.vertices.clone(), triangles };
    Ok((SurfaceBvh::new(&surface), wanted))
}

/// A line with as few points as it needs to keep within a tolerance (Douglas and Peucker).
fn simplified(points: &[Vec3], tolerance: f64) -> Vec<Vec3> {
    let mut kept = vec![0];
    let mut open = vec![(0, points.len() - 1)];
    while let Some((start, end)) = open.pop() {
        let (a, b) = (points[start], points[end]);
        let off = |p: &Vec3| {
            let chord = b - a;
            let part = (p - a).dot(&chord) / chord.norm_squared().max(f64::MIN_POSITIVE);
            (p - a - chord * part.clamp(0.0, 1.0)).norm()
        };
        let far = (start + 1..end).max_by(|&i, &j| off(&points[i]).total_cmp(&off(&points[j])));
        match far.filter(|&i| off(&points[i]) > tolerance) {
            Some(middle) => open.extend([(middle, end), (start, middle)]),
            None => kept.push(end),
        }
    }
    kept.into_iter().map(|i| points[i]).collect()
}

/// A line with a point wherever it passes through a plane, from which its points are at `heights`.
fn parted(points: &[Vec3], heights: impl Fn(&Vec3) -> f64) -> Vec<Vec3> {
    let mut all = vec![points[0]];
    for pair in points.windows(2) {
        let [a, b] = [heights(&pair[0]), heights(&pair[1])];
        if a * b < 0.0 {
            all.push(pair[0] + (pair[1] - pair[0]) * (a / (a - b)));
        }
        all.push(pair[1]);
    }
    all
}

/// A line whose pieces are no longer than `longest`.
fn divided(points: &[Vec3], longest: f64) -> Vec<Vec3> {
    let mut all = vec![points[0]];
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        let parts = (step.norm() / longest).ceil().max(1.0);
        all.extend((1..=parts as usize).map(|k| pair[0] + step * (k as f64 / parts)));
    }
    all
}
