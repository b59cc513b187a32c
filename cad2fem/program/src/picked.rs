//! Faces of a body as a tag file has them since they were picked, and which faces of a changed body they are.

use std::collections::BTreeMap;

use anyhow::{Result, bail};
use mesh::Vec3;
use mesh::faces::{Again, Face, found_again};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// More faces than these are only counted.
const MOST: usize = 10;

/// A face as it was when it was picked.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Picked {
    /// [m²]
    area: f64,
    /// Middle of its area [m].
    middle: [f64; 3],
    /// Mean of its unit normals: 1 long where it is flat, 0 where it goes around.
    normal: [f64; 3],
    /// Files of the faces that meet it.
    #[serde(default)]
    beside: Vec<String>,
}

/// Which faces of a body are those that were picked.
#[derive(Debug, Default)]
pub struct Recognized {
    before: Vec<(String, Face)>,
    now: Vec<(String, Face)>,
    again: Vec<Option<Again>>,
}

impl Recognized {
    /// Looks for the faces of a tag file, by the names of their files, among those of a body.
    pub fn new(picked: &BTreeMap<String, Picked>, now: Vec<(String, Face)>) -> Self {
        let numbers: BTreeMap<&String, usize> =
            picked.keys().enumerate().map(|(i, name)| (name, i)).collect();
        let face = |(name, picked): (&String, &Picked)| {
            let (middle, normal) = (Vec3::from(picked.middle), Vec3::from(picked.normal));
            let beside =
                picked.beside.iter().filter_map(|name| numbers.get(name).copied()).collect();
            (name.clone(), Face { area: picked.area, middle, normal, beside })
        };
        let before: Vec<(String, Face)> = picked.iter().map(face).collect();
        let faces =
            |list: &[(String, Face)]| list.iter().map(|(_, face)| face.clone()).collect::<Vec<_>>();
        let again = found_again(&faces(&before), &faces(&now));
        Self { before, now, again }
    }

    /// The file that a face has now; that of its name, where the tag file says no more of it.
    pub fn file<'a>(&'a self, name: &'a str) -> Result<&'a str> {
        let Some(b) = self.before.iter().position(|(known, _)| known == name) else {
            return Ok(name);
        };
        let Some(again) = self.again[b] else {
            let face = &self.before[b].1;
            let apart = |n: &&(String, Face)| (n.1.middle - face.middle).norm();
            let nearest = self.now.iter().min_by(|m, n| apart(m).total_cmp(&apart(n)));
            let nearest = nearest.map_or(String::new(), |(name, face)| {
                format!("; the nearest is {name} of {}", measures(face))
            });
            bail!(
                "no face is like {name} any more, which had {}{nearest}: pick it again",
                measures(face)
            );
        };
        Ok(&self.now[again.face].0)
    }

    /// Whether anything is known of the faces.
    pub fn is_empty(&self) -> bool {
        self.before.is_empty()
    }

    /// What has changed and yet needs nobody to look: other numbers, and faces that have moved among their neighbours.
    pub fn changes(&self) -> Vec<String> {
        let found =
            || self.before.iter().zip(&self.again).filter_map(|(b, again)| Some((b, (*again)?)));
        let renamed = found().filter(|((name, _), again)| self.now[again.face].0 != *name).count();
        let mut told = Vec::new();
        if renamed > 0 {
            told.push(format!("faces with other names than when they were picked: {renamed}"));
        }
        let moved: Vec<_> =
            found().filter(|(b, again)| !again.same && !is_doubtful(&b.1, again)).collect();
        if !moved.is_empty() {
            let differs = |i: usize| {
                let each = moved.iter().map(|(b, again)| b.1.differs(&self.now[again.face].1)[i]);
                each.fold(0.0, f64::max)
            };
            told.push(format!(
                "faces that have changed since they were picked, between the same neighbours: {}, moved by up to {:.2} mm, area by \
                 up to {:.0} %, turned by up to {:.0}°",
                moved.len(),
                1e3 * differs(0),
                100.0 * differs(1).exp_m1(),
                turned(differs(2))
            ));
        }
        told
    }

    /// Faces that may be others now, with the name of the face as it was picked first.
    pub fn doubts(&self) -> Vec<(&str, String)> {
        let mut told = Vec::new();
        for ((name, before), again) in self.before.iter().zip(&self.again) {
            let Some(again) = again.filter(|again| is_doubtful(before, again)) else { continue };
            let (file, now) = &self.now[again.face];
            let [moved, _, normal] = before.differs(now);
            let text = format!(
                "{name} of {} is taken for {file} of {}: moved by {:.2} mm, turned by {:.0}°, and {} of its {} neighbours are the same",
                measures(before),
                measures(now),
                1e3 * moved,
                turned(normal),
                again.beside,
                before.beside.len()
            );
            told.push((name.as_str(), text));
        }
        told
    }

    /// Faces that were not there when the others were picked, without those that `has_tag`; in words, if there are any.
    pub fn new_faces(&self, has_tag: impl Fn(&str) -> bool) -> Option<String> {
        let known = |n: usize| self.again.iter().flatten().any(|again| again.face == n);
        let new = self.now.iter().enumerate().filter(|(n, (file, _))| !known(*n) && !has_tag(file));
        let new: Vec<String> =
            new.map(|(_, (file, face))| format!("{file} of {}", measures(face))).collect();
        let more = if new.len() > MOST {
            format!(" and {} more", new.len() - MOST)
        } else {
            String::new()
        };
        let first = new.iter().take(MOST).cloned().collect::<Vec<_>>().join("; ");
        (!self.is_empty() && !new.is_empty()).then(|| {
            format!(
                "faces that were not there when the others were picked have no tag: {first}{more}"
            )
        })
    }
}

/// Whether a face that is like an earlier one may be another: it measures something else, and other faces are beside it.
fn is_doubtful(before: &Face, again: &Again) -> bool {
    !again.same && again.beside < before.beside.len()
}

/// What a difference of unit normals is as an angle [deg].
fn turned(difference: f64) -> f64 {
    2.0 * (difference / 2.0).min(1.0).asin().to_degrees()
}

fn measures(face: &Face) -> String {
    let [x, y, z] = (1e3 * face.middle).into();
    format!("{:.3} cm² at ({x:.1}, {y:.1}, {z:.1}) mm", 1e4 * face.area)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A row of flat faces of 1 cm², each beside the next, and what a tag file says of them.
    fn row(count: usize) -> Vec<(String, Face)> {
        let face = |i: usize| {
            let beside = [i.checked_sub(1), (i + 1 < count).then_some(i + 1)]
                .into_iter()
                .flatten()
                .collect();
            let middle = Vec3::new(0.01 * i as f64, 0.0, 0.0);
            (format!("face-{i}.stl"), Face { area: 1e-4, middle, normal: Vec3::z(), beside })
        };
        (0..count).map(face).collect()
    }

    fn picked(faces: &[(String, Face)]) -> BTreeMap<String, Picked> {
        let one = |(name, face): &(String, Face)| {
            let beside = face.beside.iter().map(|&i| faces[i].0.clone()).collect();
            let (middle, normal) = (face.middle.into(), face.normal.into());
            (name.clone(), Picked { area: face.area, middle, normal, beside })
        };
        faces.iter().map(one).collect()
    }

    #[test]
    fn what_has_moved_among_its_neighbours_is_told_and_what_has_not_is_doubted() {
        let before = row(4);
        let mut now = before.clone();
        now[1].0 = "lid.stl".into();
        now[2].1.middle.y = 2e-3;
        now[2].1.area = 1.1e-4;
        let found = Recognized::new(&picked(&before), now.clone());
        assert_eq!(found.file("face-1.stl").unwrap(), "lid.stl");
        assert_eq!(found.file("nobody.stl").unwrap(), "nobody.stl");
        let told = found.changes();
        assert!(told[0].ends_with("other names than when they were picked: 1"), "{told:?}");
        assert!(told[1].contains(": 1, moved by up to 2.00 mm, area by up to 10 %"), "{told:?}");
        assert!(found.doubts().is_empty() && found.new_faces(|_| false).is_none());

        now[2].1.beside = vec![1];
        now.push(("new.stl".into(), Face { area: 2e-4, middle: Vec3::y(), ..now[0].1.clone() }));
        let found = Recognized::new(&picked(&before), now.clone());
        let doubts = found.doubts();
        assert_eq!(doubts.len(), 1);
        assert!(
            doubts[0].0 == "face-2.stl" && doubts[0].1.contains("1 of its 2 neighbours"),
            "{doubts:?}"
        );
        assert!(found.new_faces(|_| false).unwrap().contains("new.stl of 2.000 cm²"));
        assert_eq!(found.new_faces(|file| file == "new.stl"), None);

        now.remove(0);
        now.iter_mut().for_each(|(_, face)| face.beside.clear());
        let found = Recognized::new(&picked(&before), now);
        let error = found.file("face-0.stl").unwrap_err().to_string();
        assert!(
            error.contains("had 1.000 cm² at (0.0, 0.0, 0.0) mm; the nearest is lid.stl"),
            "{error}"
        );
    }
}
