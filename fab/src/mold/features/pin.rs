//! The second support of a core: pins of the mold that stand in pits of the core.
//!
//! A pin belongs to one shell and points against the direction in which that is demolded, so that it leaves core and
//! silicone with its shell, whether the core dissolves later or is pulled out. It reaches through the silicone and a
//! radius deep into the core. The hole that it leaves in the silicone is closed while the core is still inside.

use std::collections::BTreeMap;

use geometry::frustum::Frustum;
use mesh::bvh::SurfaceBvh;
use mesh::measure::{bounds, longest_edge};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

use super::support::{Contact, Sag, Stand};

/// Depth of the pit in the core below its rim, in radii of the pin.
const DEPTH: f64 = 1.0;

/// How far a pin is rooted in its shell beyond the silicone, in radii.
const ROOT: f64 = 1.5;

/// A shell fills the section of a pin from here on, beyond the silicone, in radii.
const FILLED: f64 = 0.3;

/// Least cosine of the angle between a pin and the normal of the core where it stands (35°).
const STEEP: f64 = 0.82;

/// Largest difference of height around the rim of a pin, in radii: on both sides of the silicone it stands within
/// about 40° of the normal.
const UNEVEN: f64 = 1.7;

/// Distance of the places that are tried, in radii: a core that is slender has room for pits only along its middle.
const STEP: f64 = 0.75;

/// A pin that was asked for stands within this distance of its point, in radii.
pub const NEAR: f64 = 4.0;

/// Silicone thicker than this holds a plug no better, in radii.
const THICK: f64 = 6.0;

/// Points of a rim that are looked at.
const RIM: usize = 12;

/// Where places and points of a rim lie in their cells: not in planes in which bodies are symmetric, in which
/// triangles of a model meet and rays would hit two at once.
const OBLIQUE: [f64; 2] = [0.3171, 0.3529];

/// Pins of a core at most.
const MOST: usize = 4;

/// A further pin, and all of them together, must take away this part of the motion.
const WORTH: f64 = 0.1;

/// Places that are looked at more closely for each pin, the best first.
const TRIES: usize = 24;

/// Distance between those of them that do not fit, in radii.
const BESIDE: f64 = 2.0;

/// Least mold between a pin and a sprue or vent [m].
pub const LAND: f64 = 1e-3;

/// A pin.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// Index of its shell.
    pub shell: usize,
    /// The pin, from the pit's bottom into its shell.
    pub frustum: Frustum,
    /// The pin with the play around it, as wide as the pit in the core.
    pub pit: Frustum,
    /// Where it holds the core.
    pub contact: Contact,
    /// Thickness of the silicone along it [m].
    pub length: f64,
    /// Volume of the hole in the silicone and of the pit, which is to be closed [m³].
    pub hole: f64,
}

/// Where pins can stand.
pub struct Site<'a> {
    /// Wall of the chamber and caps.
    pub chamber: &'a SurfaceMesh,
    /// The core with its stub and its bore.
    pub core: &'a SurfaceBvh,
    /// The body with its chambers filled.
    pub filled: &'a SurfaceBvh,
    /// All cores of the body.
    pub cores: &'a [SurfaceBvh],
    /// Each shell with the direction in which it is demolded [1].
    pub shells: &'a [(SurfaceBvh, Vec3)],
    /// Radius of pins [m].
    pub radius: f64,
    /// Play around a pin in its pit [m].
    pub play: f64,
    /// Least thickness of the core around a pit [m].
    pub skin: f64,
}

/// Places that were tried.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tried {
    /// All of them.
    places: usize,
    /// For each reason where no pin can stand.
    unfit: [usize; 3],
}

impl std::fmt::Display for Tried {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { places, unfit: [uneven, thin, loose] } = *self;
        write!(
            f,
            "of {places} places across a shell's demolding direction, the silicone or the core is uneven at {uneven}, \
             the core too thin around a pit at {thin}, and the shell missing at {loose}"
        )
    }
}

/// Why a pin cannot stand at a place.
enum Unfit {
    /// Silicone or core is too uneven, or another chamber lies in the way.
    Uneven,
    /// The core is too thin for a pit.
    Thin,
    /// No shell is behind the silicone.
    Loose,
}

impl Site<'_> {
    /// All pins that can stand, or those within [`NEAR`] of a point; and what was tried.
    pub fn pins(&self, near: Option<&Vec3>) -> (Vec<Pin>, Tried) {
        let (mut pins, mut tried) = (Vec::new(), Tried::default());
        for (shell, (_, out)) in self.shells.iter().enumerate() {
            for at in self.places(out, near) {
                tried.places += 1;
                match self.pin(shell, &at) {
                    Ok(pin) => pins.push(pin),
                    Err(unfit) => tried.unfit[unfit as usize] += 1,
                }
            }
        }
        (pins, tried)
    }

    /// Places on the chamber's wall that face a direction, one per cell: that nearest to its middle.
    fn places(&self, out: &Vec3, near: Option<&Vec3>) -> Vec<Vec3> {
        let [u, v] = across(out);
        let cell = STEP * self.radius;
        // So that a row of cells runs along the middle of a slender core.
        let (low, high) = bounds(&self.chamber.vertices);
        let middle = (low + high) / 2.0;
        let mut places = BTreeMap::new();
        for t in 0..self.chamber.triangles.len() {
            let [a, b, c] = self.chamber.corners(t);
            // The longest side of a large facet is divided.
            let parts = (longest_edge([a, b, c]) / cell).ceil().clamp(1.0, 100.0) as usize;
            if self.chamber.normal(t).dot(out) < STEEP {
                continue;
            }
            for i in 0..parts {
                for j in 0..parts - i {
                    let [s, t] = [i as f64 + OBLIQUE[0], j as f64 + OBLIQUE[1]];
                    let [s, t] = [s, t].map(|k| k / parts as f64);
                    let at = a + (b - a) * s + (c - a) * t;
                    if near.is_some_and(|near| (near - at).cross(out).norm() > NEAR * self.radius) {
                        continue;
                    }
                    // Near a point all are tried.
                    let fine = if near.is_some() { 0.5 } else { 1.0 };
                    let from = at - middle;
                    let key = [from.dot(&u), from.dot(&v), from.dot(out) / 3.0];
                    let in_cells = key.map(|x| x / (fine * cell) + 0.5);
                    let off = Vec3::from(in_cells.map(|x| x - x.floor() - 0.5)).norm();
                    let place = places.entry(in_cells.map(|x| x.floor() as i64));
                    let nearest: &mut (f64, Vec3) = place.or_insert((off, at));
                    if off < nearest.0 {
                        *nearest = (off, at);
                    }
                }
            }
        }
        places.into_values().map(|(_, at)| at).collect()
    }

    /// The pin of a shell that stands at a place of the chamber's wall.
    fn pin(&self, shell: usize, at: &Vec3) -> Result<Pin, Unfit> {
        let (body, out) = &self.shells[shell];
        let Self { radius, play, skin, .. } = *self;
        let [u, v] = across(out);
        let ring = |radius: f64, height: f64| {
            (0..RIM).map(move |k| {
                let angle = std::f64::consts::TAU * (k as f64 + OBLIQUE[0]) / RIM as f64;
                at + (u * angle.cos() + v * angle.sin()) * radius + out * height
            })
        };
        // Just above the chamber's wall, where a ray may begin.
        const ABOVE: f64 = 1e-6;
        let through = first(self.filled, &(at + out * ABOVE), out).ok_or(Unfit::Uneven)?;
        let middle = through / 2.0;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in ring(radius + play, middle).chain([at + out * middle]) {
            let within = self.filled.ray(&p, out).len() % 2 == 1;
            let ahead = first(self.filled, &p, out).ok_or(Unfit::Uneven)?;
            let behind = first(self.core, &p, &-out).ok_or(Unfit::Uneven)?;
            let blocked = |core: &SurfaceBvh| {
                let hits = core.ray(&p, out);
                hits.len() % 2 == 1 || hits.first().is_some_and(|hit| hit.0 < ahead)
            };
            if !within || self.cores.iter().any(blocked) {
                return Err(Unfit::Uneven);
            }
            for (i, height) in [middle - behind, middle + ahead].into_iter().enumerate() {
                (low[i], high[i]) = (low[i].min(height), high[i].max(height));
            }
        }
        let uneven = |i: usize| high[i] - low[i] > UNEVEN * radius;
        if uneven(0) || uneven(1) || low[1] <= high[0] {
            return Err(Unfit::Uneven);
        }
        let bottom = low[0] - DEPTH * radius;
        let top = high[1] + ROOT * radius;
        let in_core = |p: Vec3| self.core.ray(&p, out).len() % 2 == 1;
        let around = [ring(radius + play + skin, bottom), ring(radius, bottom - skin)];
        if !around.into_iter().flatten().chain([at + out * (bottom - skin)]).all(in_core) {
            return Err(Unfit::Thin);
        }
        let in_shell = |p: Vec3| body.ray(&p, out).len() % 2 == 1;
        let rooted = [high[1] + FILLED * radius, top];
        if !rooted.into_iter().flat_map(|height| ring(radius, height)).all(in_shell) {
            return Err(Unfit::Loose);
        }
        let column =
            |radius: f64| Frustum::cylinder(at + out * bottom, out * (top - bottom), radius);
        let [core, skin] = [low[0] + high[0], low[1] + high[1]].map(|sum| sum / 2.0);
        let area = |radius: f64| std::f64::consts::PI * radius * radius;
        Ok(Pin {
            shell,
            frustum: column(radius),
            pit: column(radius + play),
            contact: Contact { at: at + out * bottom, out: *out, play },
            length: skin - core,
            hole: area(radius) * (skin - core) + area(radius + play) * (core - bottom),
        })
    }
}

impl Pin {
    /// Whether it reaches into none of the shells to which it does not belong.
    pub fn is_beside<'a>(&self, mut others: impl Iterator<Item = &'a Solid>) -> bool {
        let pin = self.frustum.solid();
        others.all(|other| other.intersection(&pin).is_empty())
    }

    /// Whether mold is left between its outline and the channels, and `skin` [m] of core between its pit and others.
    pub fn is_clear(&self, channels: &[Solid], others: &[Self], skin: f64) -> bool {
        let around = self.pit.grown(LAND).solid();
        let pit = self.pit.grown(skin).solid();
        channels.iter().all(|channel| channel.intersection(&around).is_empty())
            && others.iter().all(|other| other.pit.solid().intersection(&pit).is_empty())
    }
}

/// The fewest pins of those offered with which a core moves by at most `limit` [m], up to four: where one is enough,
/// that with the thickest silicone around it; else one after the other, each where it takes away most of the motion.
/// `fits` looks at one more closely, with those already chosen.
pub fn choose(
    stand: &Stand,
    offered: &[Pin],
    limit: f64,
    fits: impl Fn(&Pin, &[Pin]) -> bool,
) -> Vec<Pin> {
    let mut chosen: Vec<Pin> = Vec::new();
    let mut sag = stand.sag(&[]);
    while sag.most() > limit && chosen.len() < MOST {
        let with = |pin: &Pin| sag_with(stand, chosen.iter().chain([pin]));
        let mut ranked: Vec<(Sag, &Pin)> = offered.iter().map(|pin| (with(pin), pin)).collect();
        let thick = |pin: &Pin| pin.length.min(THICK * pin.frustum.base_radius);
        let rank = |(sag, pin): &(Sag, &Pin)| match sag.most() <= limit {
            true => (0.0, -thick(pin), sag.most()),
            false => (1.0, sag.mean, sag.most()),
        };
        ranked.sort_by(|a, b| rank(a).partial_cmp(&rank(b)).expect("numbers"));
        let found = first_that_fits(ranked, |pin| fits(pin, &chosen));
        let Some((held, pin)) = found.filter(|(held, _)| held.mean <= (1.0 - WORTH) * sag.mean)
        else {
            break;
        };
        chosen.push(pin.clone());
        sag = held;
    }
    chosen
}

/// How far a core moves that pins hold.
pub fn sag_with<'a>(stand: &Stand, pins: impl IntoIterator<Item = &'a Pin>) -> Sag {
    stand.sag(&pins.into_iter().map(|pin| pin.contact).collect::<Vec<_>>())
}

/// Whether pins take away enough of the motion of a core's farthest point.
pub fn hold(stand: &Stand, pins: &[Pin]) -> bool {
    sag_with(stand, pins).most() <= (1.0 - WORTH) * stand.sag(&[]).most()
}

/// The first of ranked pins that fits. Beside one that does not, no other is tried: what is in its way is in theirs.
fn first_that_fits(ranked: Vec<(Sag, &Pin)>, fits: impl Fn(&Pin) -> bool) -> Option<(Sag, &Pin)> {
    let mut failed: Vec<Vec3> = Vec::new();
    for (sag, pin) in ranked {
        let (at, beside) = (pin.frustum.base, BESIDE * pin.frustum.base_radius);
        if failed.len() == TRIES || failed.iter().any(|failed| (failed - at).norm() < beside) {
            continue;
        }
        if fits(pin) {
            return Some((sag, pin));
        }
        failed.push(at);
    }
    None
}

/// Distance of the first facet along a ray.
fn first(surface: &SurfaceBvh, from: &Vec3, along: &Vec3) -> Option<f64> {
    surface.ray(from, along).first().map(|hit| hit.0)
}

/// Two unit vectors across a third and each other.
fn across(out: &Vec3) -> [Vec3; 2] {
    let u = if out.x.abs() < 0.5 { Vec3::x() } else { Vec3::y() };
    let u = (u - out * out.dot(&u)).normalize();
    [u, out.cross(&u)]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A bar of 50 × 8 mm, half as wide as given, on a neck at its end, 10 mm above the inlet, in silicone of 5 mm and a
    /// mold of two shells.
    fn with_bar<T>(half: f64, look: impl Fn(&Stand, Vec<Pin>, Tried) -> T) -> T {
        let neck = Solid::cylinder(&(-Vec3::z() * 10e-3), &(Vec3::z() * 22e-3), 2e-3, 2e-3, 48);
        let bar = Solid::cube(&Vec3::new(-4e-3, -half, 10e-3), &Vec3::new(46e-3, half, 18e-3));
        let chamber = bar.union(&neck.trim_by_plane(&Vec3::z(), 0.0));
        let filled = Solid::cube(&Vec3::new(-9e-3, -9e-3, 0.0), &Vec3::new(51e-3, 9e-3, 23e-3));
        let around =
            Solid::cube(&Vec3::new(-14e-3, -14e-3, -8e-3), &Vec3::new(56e-3, 14e-3, 28e-3));
        let (upper, lower) = around.difference(&filled).split_by_plane(&Vec3::z(), 14e-3);
        let bvh = |solid: &Solid| SurfaceBvh::new(&solid.to_surface());
        let site = Site {
            chamber: &chamber.to_surface(),
            core: &bvh(&chamber.union(&neck)),
            filled: &bvh(&filled),
            cores: &[bvh(&chamber)],
            shells: &[(bvh(&upper), Vec3::z()), (bvh(&lower), -Vec3::z())],
            radius: 1e-3,
            play: 2e-4,
            skin: 8e-4,
        };
        let stub = Frustum::cylinder(Vec3::zeros(), -Vec3::z() * 8e-3, 2e-3);
        let stand = Stand::new(site.chamber, &Vec3::zeros(), &stub, site.play, 1070.0);
        let (pins, tried) = site.pins(None);
        look(&stand, pins, tried)
    }

    #[test]
    fn pins_reach_through_the_silicone_into_core_and_shell() {
        with_bar(4e-3, |stand, pins, tried| {
            assert!(pins.iter().any(|pin| pin.shell == 0) && pins.iter().any(|pin| pin.shell == 1));
            assert!(tried.places >= pins.len(), "{tried}");
            // Of the bar's 8 mm, 2 mm on either side are pit and skin, seen at points 30° apart.
            let middle = 4e-3 - 2e-3 * f64::to_radians(15.0).cos();
            assert!(pins.iter().all(|pin| pin.frustum.base.y.abs() <= middle), "{pins:?}");
            let alone = stand.sag(&[]).most();
            let held = choose(stand, &pins, 7e-4, |_, _| true);
            let with = sag_with(stand, &held).most();
            assert!(alone > 2e-3 && with <= 7e-4, "{alone} {with} {held:?}");
            assert!(hold(stand, &held) && !hold(stand, &[]));
            // A pit that is as wide as the core can turn holds nothing.
            let loose = |pin: &Pin| Contact { play: 2.0 * alone, ..pin.contact };
            let loose: Vec<Pin> =
                held.iter().map(|pin| Pin { contact: loose(pin), ..pin.clone() }).collect();
            assert!(!hold(stand, &loose));
            // Where no place fits, there is none.
            assert!(choose(stand, &pins, 7e-4, |_, _| false).is_empty());
        });
    }

    /// With pit and skin a pin takes 4 mm: there is room only within 0.1 mm of the middle of 4.2 mm. Some is within
    /// the distance at which a pin that is asked for may stand.
    #[test]
    fn a_slender_core_has_pins_along_its_middle() {
        with_bar(2.1e-3, |_, pins, tried| {
            for shell in [0, 1] {
                let mut along: Vec<f64> = pins
                    .iter()
                    .filter(|pin| pin.shell == shell)
                    .map(|pin| pin.frustum.base.x)
                    .collect();
                along.sort_by(f64::total_cmp);
                assert!(along.iter().any(|x| *x > 40e-3), "{tried}: {along:?}");
                let free = along.iter().filter(|x| **x > 4e-3).collect::<Vec<_>>();
                assert!(
                    free.windows(2).all(|pair| pair[1] - pair[0] < NEAR * 1e-3),
                    "{tried}: {along:?}"
                );
            }
        });
    }

    #[test]
    fn a_pin_keeps_clear_of_channels_and_of_other_shells() {
        with_bar(4e-3, |_, pins, _| {
            let pin = &pins[0];
            // Its pit is 0.2 mm wider than the pin.
            let channel = |gap: f64| {
                let at = pin.frustum.base + Vec3::y() * (2.2e-3 + gap) - pin.frustum.axis;
                Solid::cylinder(&at, &(pin.frustum.axis * 3.0), 1e-3, 1e-3, 48)
            };
            assert!(pin.is_clear(&[channel(1.01 * LAND)], &[], 0.0));
            assert!(!pin.is_clear(&[channel(0.9 * LAND)], &[], 0.0));
            let top = pin.frustum.base + pin.frustum.axis;
            let shell = |low: f64| {
                let corner = top + Vec3::new(low, -1e-2, -1e-3);
                Solid::cube(&corner, &(corner + Vec3::repeat(2e-2)))
            };
            assert!(pin.is_beside([&shell(1.01e-3)].into_iter()));
            assert!(!pin.is_beside([&shell(1.01e-3), &shell(0.9e-3)].into_iter()));
        });
    }
}
