//! Selections in order → one owner per facet.

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use mesh::{Tags, TetMesh};
use program::Unusable;

use crate::config::{Config, Tag};
use crate::facets::{self, Facets};
use crate::inside;
use crate::select::{Sources, nearest_patches};
use crate::wall;

/// Relative difference between selected and input area above which there is a warning.
const AREA_TOLERANCE: f64 = 0.03;

/// What the selections of a tag file make of a boundary.
pub struct Assignment {
    /// Index of the tag that each facet belongs to.
    pub owners: Vec<Option<usize>>,
    /// Per tag: how it got its facets.
    pub tallies: Vec<Tally>,
    /// Facets inside the body, with the index of their tag.
    pub inside: Vec<([usize; 3], usize)>,
}

/// How one tag got its facets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Facets that the selector holds.
    pub selected: usize,
    /// Selected facets that an earlier tag already had.
    pub contested: usize,
    /// Single facets that were missing inside the selection and were added.
    pub pinholes: usize,
    /// Area of the final tag [m²].
    pub area: f64,
    /// Area of the input patch [m²], where there is one.
    pub expected_area: Option<f64>,
}

impl Tally {
    /// |area − expected| / expected if that is more than 3 %.
    pub fn area_mismatch(&self) -> Option<f64> {
        let expected = self.expected_area?;
        let relative = (self.area - expected).abs() / expected;
        (relative > AREA_TOLERANCE).then_some(relative)
    }
}

impl Assignment {
    /// Facets without a tag.
    pub fn left_over(&self) -> usize {
        self.owners.iter().filter(|o| o.is_none()).count()
    }

    /// Ids and names for the facets, in the order of the tag file.
    pub fn tags(&self, config: &Config, facets: &Facets) -> Tags {
        let mut tags = Tags::new(config.tag.iter().map(|t| t.name.clone()).collect());
        let outer = facets.surface.triangles.iter().zip(&self.owners);
        let outer = outer.filter_map(|(facet, owner)| Some((*facet, (*owner)?)));
        for (facet, owner) in outer.chain(self.inside.iter().copied()) {
            if let Some(id) = tags.id(&config.tag[owner].name) {
                tags.set(facet, id);
            }
        }
        tags
    }
}

/// Gives every facet to the first selection that holds it, fills pinholes and
/// checks that the result can be simulated.
pub fn assign(
    config: &Config,
    mesh: &TetMesh,
    facets: &Facets,
    mut sources: Sources,
) -> Result<Assignment> {
    let selectors = config
        .tag
        .iter()
        .map(|tag| {
            let build = || tag.selection()?.build(&mut sources);
            (!tag.inside).then(build).transpose().with_context(|| label(tag))
        })
        .collect::<Result<Vec<_>>>()?;
    sources.nearest = nearest_patches(facets, &sources);

    let mut owners = vec![None; facets.len()];
    let (mut tallies, mut inside) = (Vec::new(), Vec::new());
    for (index, (tag, selector)) in config.tag.iter().zip(&selectors).enumerate() {
        let Some(selector) = selector else {
            let tally = claim_inside(index, tag, mesh, &sources, &mut inside);
            tallies.push(tally.with_context(|| label(tag))?);
            continue;
        };
        let selected = selector.select(facets, &sources).with_context(|| label(tag))?;
        let mut tally = claim(index, &selected, &mut owners);
        if tally.selected == tally.contested {
            return Err(empty(config, index, &tally, &owners, &selected, || {
                selector.advice(facets, &sources)
            }));
        }
        tally.expected_area = selector.expected_area(&sources);
        tallies.push(tally);
    }
    for (index, tag) in config.tag.iter().enumerate() {
        tallies[index].pinholes = wall::fill_pinholes(facets, &mut owners, index, tag.pressure);
    }
    for (index, tag) in config.tag.iter().enumerate().filter(|(_, tag)| tag.pressure) {
        wall::check(facets, &owners, index, config)
            .map_err(|message| anyhow!(Unusable(format!("{}: {message}", label(tag)))))?;
    }
    for (facet, owner) in owners.iter().enumerate() {
        if let Some(o) = owner {
            tallies[*o].area += facets.surface.area(facet);
        }
    }
    Ok(Assignment { owners, tallies, inside })
}

/// Takes the facets inside that lie on the patch of a tag.
fn claim_inside(
    index: usize,
    tag: &Tag,
    mesh: &TetMesh,
    sources: &Sources,
    all: &mut Vec<([usize; 3], usize)>,
) -> Result<Tally> {
    let [name] = tag.patches() else { bail!("`patch` must be the file of an open surface") };
    let path = sources.file(name)?;
    let patch = mesh::io::read_surface_in_metres(&path)?;
    let found = inside::select(mesh, &patch, &path, sources.epsilon)?;
    let selected = found.len();
    let free: Vec<_> =
        found.into_iter().filter(|facet| !all.iter().any(|(taken, _)| taken == facet)).collect();
    ensure!(
        !free.is_empty(),
        Unusable(format!("all {selected} facets on {} have earlier tags", path.display()))
    );
    let (contested, area) = (selected - free.len(), facets::area(mesh, &free));
    all.extend(free.into_iter().map(|facet| (facet, index)));
    let expected_area = Some(mesh::measure::area(&patch));
    Ok(Tally { selected, contested, area, expected_area, ..Tally::default() })
}

fn label(tag: &Tag) -> String {
    format!("[[tag]] `{}`", tag.name)
}

/// Takes the selected facets that have no owner yet.
fn claim(index: usize, selected: &[bool], owners: &mut [Option<usize>]) -> Tally {
    let mut tally = Tally::default();
    for (owner, _) in owners.iter_mut().zip(selected).filter(|(_, selected)| **selected) {
        tally.selected += 1;
        if owner.is_some() {
            tally.contested += 1;
        } else {
            *owner = Some(index);
        }
    }
    tally
}

/// The error for a tag without facets.
fn empty(
    config: &Config,
    index: usize,
    tally: &Tally,
    owners: &[Option<usize>],
    selected: &[bool],
    advice: impl FnOnce() -> String,
) -> anyhow::Error {
    let label = label(&config.tag[index]);
    if tally.selected == 0 {
        return anyhow!(Unusable(format!("{label}: empty selection: {}", advice())));
    }
    let taken =
        |o: usize| (0..owners.len()).filter(|&f| selected[f] && owners[f] == Some(o)).count();
    let takers: Vec<String> = (0..index)
        .map(|o| (o, taken(o)))
        .filter(|&(_, count)| count > 0)
        .map(|(o, count)| format!("`{}` ({count})", config.tag[o].name))
        .collect();
    anyhow!(Unusable(format!(
        "{label}: empty selection: all its {} facets belong to earlier tags: {}\n  \
         the first selection wins; put `{}` before them or make the selections disjoint",
        tally.selected,
        takers.join(", "),
        config.tag[index].name
    )))
}
