//! Which part of the boundary has which id.
//!
//! A list of rules in order of priority: the first that holds for a facet gives
//! it its id. Facets are judged by the mean of their corners after the body was
//! placed.

use std::collections::BTreeMap;

use anyhow::Result;
use mesh::Vec3;

use super::document::Key;

/// The id of facets that no rule selects, as PolyFEM numbers them.
pub const UNSELECTED: i64 = i32::MAX as i64;

/// A part of the boundary.
#[derive(Clone, Debug)]
pub struct Facet {
    /// The corners in the mesh that we write.
    pub corners: [usize; 3],
    /// The corners in the mesh that was read, ascending: three, or two in a
    /// plane.
    pub source: Vec<usize>,
    /// Mean of the corners in the mesh that was read, after it was placed [m].
    pub center: Vec3,
}

/// A rule: the id of a facet, if it holds for it.
type Rule = Box<dyn Fn(&Facet) -> Option<i64>>;

/// The rule of a part of space.
fn within(id: i64, holds: impl Fn(Vec3) -> bool + 'static) -> Rule {
    Box::new(move |facet| holds(facet.center).then_some(id))
}

/// The id of each facet of a body in `dimension` dimensions with these bounds
/// [m]; [`UNSELECTED`] where no rule holds.
pub fn select(
    selection: Option<&Key>,
    facets: &[Facet],
    dimension: usize,
    bounds: (Vec3, Vec3),
) -> Result<Vec<i64>> {
    let mut rules = Vec::new();
    for item in selection.map(Key::items).unwrap_or_default() {
        rules.push(rule(&item, facets, dimension, bounds)?);
    }
    let id = |facet: &Facet| rules.iter().find_map(|rule| rule(facet)).unwrap_or(UNSELECTED);
    Ok(facets.iter().map(id).collect())
}

fn rule(key: &Key, facets: &[Facet], dimension: usize, (low, high): (Vec3, Vec3)) -> Result<Rule> {
    if key.value.is_i64() {
        return Ok(within(key.id()?, |_| true));
    }
    if key.value.is_string() {
        return listed(key, facets, dimension);
    }
    if !key.value.is_object() {
        return Err(key.wrong("expected an id, a file of facets, or a list of selections"));
    }
    let id = key.need("id", "the id of the selection")?.id()?;
    let relative = key.optional("relative", Key::flag)?.unwrap_or(false);
    // beyond the dimensions of the body, everything is inside
    let point = |key: &Key, beyond: f64| -> Result<Vec3> {
        let given = key.numbers(dimension)?;
        Ok(Vec3::from_fn(|k, _| match given.get(k) {
            None => beyond,
            Some(x) if relative => low[k] + x * (high[k] - low[k]),
            Some(x) => *x,
        }))
    };
    if let Some(corners) = key.get("box") {
        let items = corners.items();
        let [a, b] = &items[..] else {
            return Err(corners.wrong("expected two corners"));
        };
        let (a, b) = (point(a, f64::NEG_INFINITY)?, point(b, f64::INFINITY)?);
        return Ok(within(id, move |x| (0..3).all(|k| a[k] <= x[k] && x[k] <= b[k])));
    }
    if let Some(name) = key.get("axis") {
        let (axis, sign) = axis(&name, dimension)?;
        let given = key.need("position", "where along the axis the selection begins")?.number()?;
        let along = low[axis] + given * (high[axis] - low[axis]);
        let position = if relative { along } else { given };
        return Ok(within(id, move |x| sign * x[axis] >= sign * position));
    }
    if let Some(center) = key.get("center") {
        let radius = key.need("radius", "the radius of the sphere")?.positive()?;
        let scale = if relative { (high - low).norm() } else { 1.0 };
        let (center, radius) = (point(&center, 0.0)?, scale * radius);
        return Ok(within(id, move |x| (x - center).norm() <= radius));
    }
    Err(key.wrong(
        "unknown kind of selection; known are \"box\", \"axis\" with \"position\", and \"center\" \
         with \"radius\"",
    ))
}

/// "x", "-x", …, or 1, −1, …
fn axis(key: &Key, dimension: usize) -> Result<(usize, f64)> {
    let names = ["x", "y", "z"];
    let number = match key.value.as_str() {
        Some(name) => {
            let (sign, letter) = name.strip_prefix('-').map_or((1, name), |rest| (-1, rest));
            let letter = letter.trim_start_matches('+').to_ascii_lowercase();
            let place = names.iter().position(|n| *n == letter);
            place.and_then(|p| i64::try_from(p + 1).ok()).map(|p| sign * p)
        }
        None => key.value.as_i64(),
    };
    match number.map(|n| (n.unsigned_abs() as usize, n.signum() as f64)) {
        Some((n, sign)) if (1..=dimension).contains(&n) => Ok((n - 1, sign)),
        _ => Err(key.wrong(&format!(
            "{}: expected one of {}, with a minus for the other side",
            key.value,
            names[..dimension].join(", ")
        ))),
    }
}

/// A file of `id v₀ v₁ v₂` lines; of a facet that occurs twice, the first counts.
fn listed(key: &Key, facets: &[Facet], dimension: usize) -> Result<Rule> {
    let path = key.file()?;
    let text = mesh::io::read_text(&path).map_err(|e| key.wrong(&e.to_string()))?;
    let mut ids = BTreeMap::new();
    for (line, words) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let numbers: Option<Vec<i64>> = words.split_whitespace().map(|w| w.parse().ok()).collect();
        let numbers = numbers.filter(|n| n.len() == dimension + 1);
        let corners = numbers.as_ref().and_then(|numbers| {
            numbers[1..].iter().map(|&v| usize::try_from(v).ok()).collect::<Option<Vec<_>>>()
        });
        let (Some(numbers), Some(mut corners)) = (numbers, corners) else {
            return Err(key.wrong(&format!(
                "{}: line {}: {words:?} is not an id and {dimension} vertices",
                path.display(),
                line + 1
            )));
        };
        corners.sort_unstable();
        ids.entry(corners).or_insert(numbers[0]);
    }
    let found = facets.iter().filter(|f| ids.contains_key(&f.source)).count();
    if found < ids.len() {
        return Err(key.wrong(&format!(
            "{}: {} of its {} facets are not on the boundary of the mesh: it belongs to another mesh",
            path.display(),
            ids.len() - found,
            ids.len()
        )));
    }
    Ok(Box::new(move |facet| ids.get(&facet.source).copied()))
}
