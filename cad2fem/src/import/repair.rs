//! Triangles of others → a solid.
//!
//! In this order, as far as it is needed: vertices are welded and needles taken out; shells that
//! are sound each by itself, and may touch or cross others, are united or subtracted exactly; anything else, with holes, crossings
//! or edges of three triangles, goes through fTetWild, whose tetrahedra are inside where the winding
//! number of the triangles exceeds 1/2 (Jacobson et al. 2013, doi:10.1145/2461912.2461916), and
//! whose boundary stays within an envelope of them.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use mesh::bvh::{SurfaceBvh, closest_on_triangle};
use mesh::check::findings;
use mesh::check::{self, orient_by_nesting};
use mesh::crossings::self_intersecting_pairs;
use mesh::inside::WindingNumber;
use mesh::measure::{diagonal, enclosed_volume, hausdorff};
use mesh::needles::take_out;
use mesh::solid::Solid;
use mesh::topology::{boundary, boundary_edges, boundary_loops, components, edge_facets};
use mesh::{SurfaceMesh, Vec3};
use program::Unusable;

use super::fill::fill;
use super::split::across_edges;
use super::weld::weld;
use super::{Patched, Patches, THIN};
use crate::mesher::TetMesher as _;
use crate::mesher::ftetwild::FTetWild;
use crate::mesher::layers::Layers;
use crate::mesher::python::Python;
use crate::model::record::Record;
use crate::tetmesh::config::Tetmesh;
use crate::tetmesh::{settle, tidy};

/// Vertices of a shell by which it is said to lie inside another.
const PROBES: usize = 200;

/// How often fTetWild, which is not deterministic, may try.
const ATTEMPTS: u32 = 3;

/// Points at which distances between surfaces are measured.
const SAMPLES: usize = 60_000;

/// Patches that a message names.
const SHOWN: usize = 8;

/// Triangles that enclose less are no body [diagonal³].
const SMALLEST_VOLUME: f64 = 1e-7;

/// How far repair may go.
#[derive(Clone, Debug, clap::Args)]
pub struct Repair {
    /// Vertices at the rims of openings that are closer become one [m]; 1e-5 of the diagonal if not
    /// given
    #[arg(long, value_name = "M", value_parser = parse_positive)]
    pub weld: Option<f64>,
    /// How far the surface may move where it has to be remade [m]; 1e-3 of the diagonal if not given
    #[arg(long, value_name = "M", value_parser = parse_positive)]
    pub envelope: Option<f64>,
    /// Refuse a surface that only fTetWild can repair
    #[arg(long)]
    pub no_repair: bool,
    /// Longest time gmsh or fTetWild may take [s]
    #[arg(long, value_name = "S", default_value_t = 600)]
    pub timeout: u64,
}

/// Reads a positive number.
pub fn parse_positive(text: &str) -> Result<f64> {
    let number: f64 = text.parse()?;
    ensure!(number > 0.0 && number.is_finite(), "{text} must be positive");
    Ok(number)
}

/// What a surface must be before its shells are made a solid; their orientation follows.
const NEEDED: [&str; 4] = ["degenerate", "closed", "manifold", "intersecting"];

impl Repair {
    /// The solid that triangles bound; its labels are patches. Shells inside others are patches
    /// of their own if their file has no others.
    pub fn solid(
        &self,
        mut raw: Patched,
        file: &Path,
        patches: &mut Patches,
        record: &mut Record,
    ) -> Result<Solid> {
        let shown = file.display();
        self.clean(&mut raw, file, record);
        let mut found = check::run(&raw.surface, &NEEDED);
        if !self.no_repair && !found.is_empty() && boundary_is_open(&raw) {
            let at = places(&raw, patches);
            record.change(format!("{shown}: not sound{at}:{}", findings(&found)));
            let filled = fill(&mut raw);
            record.change(format!("{shown}: {filled} holes filled by triangles of least area"));
            found = check::run(&raw.surface, &NEEDED);
        }
        if found.is_empty() {
            orient_by_nesting(&mut raw.surface);
            name_cavities(&mut raw, patches);
            return solid_of(&raw).with_context(|| shown.to_string());
        }
        // shells that meet in edges, of which welding has made one, are several again
        let (shells, inward) = shells_of(&raw, &across_edges(&raw.surface.triangles, |_, _| true));
        let sound = |shell: &Patched| check::run(&shell.surface, &NEEDED).is_empty();
        if shells.len() > 1 && shells.iter().all(sound) {
            return united(&shells, &inward, file, record);
        }
        if self.no_repair {
            bail!(Unusable(format!(
                "{shown}: it is not sound{}:{}\n  without --no-repair fTetWild would remake it",
                places(&raw, patches),
                findings(&found)
            )));
        }
        let at = places(&raw, patches);
        record.change(format!("{shown}: not sound{at}:{}", findings(&found)));
        require_volume(&raw.surface).with_context(|| shown.to_string())?;
        let mut remade = self.remesh(&raw, record).with_context(|| shown.to_string())?;
        name_cavities(&mut remade, patches);
        solid_of(&remade).with_context(|| shown.to_string())
    }

    /// Welds, and takes out needles where there are crossings or triangles without area.
    fn clean(&self, raw: &mut Patched, file: &Path, record: &mut Record) {
        let size = diagonal(&raw.surface.vertices);
        let reach = self.weld.unwrap_or(1e-5 * size);
        let welded = weld(raw, reach);
        if welded.vertices > 0 {
            record.change(format!(
                "{}: {} vertices closer than {:.2e} m welded: {} open edges, now {}",
                file.display(),
                welded.vertices,
                reach,
                welded.open_before,
                welded.open_after
            ));
        }
        if welded.triangles > 0 {
            record.change(format!(
                "{}: {} triangles left out that had no area or were there twice",
                file.display(),
                welded.triangles
            ));
        }
        let needles = ["degenerate", "intersecting"];
        let found = check::run(&raw.surface, &needles);
        if found.is_empty() {
            return;
        }
        let mut surface = raw.surface.clone();
        let mut source: Vec<usize> = (0..surface.triangles.len()).collect();
        take_out(&mut surface, &mut source, THIN * size);
        let taken = raw.patch.len() - surface.triangles.len();
        if taken > 0 {
            let patch = source.iter().map(|&t| raw.patch[t]).collect();
            *raw = Patched { surface, patch };
            record.change(format!(
                "{}: {taken} needles thinner than {:.1e} m taken out",
                file.display(),
                THIN * size
            ));
        }
    }

    /// The boundary of fTetWild's tetrahedra; each triangle has the patch of the nearest one that
    /// faces the same way.
    pub fn remesh(&self, raw: &Patched, record: &mut Record) -> Result<Patched> {
        let size = diagonal(&raw.surface.vertices);
        let envelope = self.envelope.unwrap_or(1e-3 * size);
        let coarse = Tetmesh { envelope: Some(envelope), coarsen: true, ..Tetmesh::default() };
        let mut options = coarse.options(size)?;
        let (python, timeout) = (Python::find()?, Duration::from_secs(self.timeout));
        let package = python.first_of(FTetWild.packages())?;
        let oriented = oriented(raw);
        let mut attempt = 1;
        let surface = loop {
            let layers = Layers::default();
            let mut mesh =
                FTetWild.mesh(&package, &oriented.surface, &layers, &options, timeout)?;
            settle(&mut mesh, envelope);
            let rough = mesh.clone();
            tidy(&mut mesh, &oriented.surface, envelope);
            let (mut surface, _) = boundary(&mesh).surface(&mesh);
            let mut found = check::check_surface(&surface);
            if !found.is_empty() {
                // planar faces of what crosses itself pull vertices across each other
                surface = boundary(&rough).surface(&rough).0;
                found = check::check_surface(&surface);
            }
            if found.is_empty() {
                break surface;
            }
            let message =
                format!("fTetWild leaves a surface that is not sound:{}", findings(&found));
            if attempt == ATTEMPTS {
                return Err(Unusable(message).into());
            }
            log::warn!("{message}; again");
            attempt += 1;
            options.seed = attempt;
        };
        let gone = hausdorff(&raw.surface, &surface, SAMPLES);
        let moved = hausdorff(&surface, &raw.surface, SAMPLES);
        record.moved = record.moved.max(moved);
        record.change(format!(
            "remade by fTetWild: {} triangles, now {}; {} openings closed; volume {:.4} cm3; it is up \
             to {:.4} mm beside what was given (envelope {:.4} mm)",
            raw.patch.len(),
            surface.triangles.len(),
            boundary_loops(&raw.surface.triangles).len(),
            enclosed_volume(&surface) * 1e6,
            moved * 1e3,
            envelope * 1e3,
        ));
        if gone > 2.0 * envelope {
            record.change(format!(
                "what was given up to {:.4} mm beside it is gone: it bounds nothing, or lies inside",
                gone * 1e3
            ));
        }
        let patch = nearest(&oriented, &surface, envelope);
        Ok(Patched { surface, patch })
    }
}

/// The patches in which triangles are open or cross others.
fn places(raw: &Patched, patches: &Patches) -> String {
    let edges = edge_facets(&raw.surface.triangles);
    let open = edges.values().filter(|beside| beside.len() != 2).flatten().copied();
    let crossing = self_intersecting_pairs(&raw.surface).into_iter().flat_map(|(s, t)| [s, t]);
    let found: BTreeSet<u32> = open.chain(crossing).map(|t| raw.patch[t]).collect();
    let all: BTreeSet<&u32> = raw.patch.iter().collect();
    if all.len() < 2 || found.is_empty() {
        return String::new();
    }
    let more = if found.len() > SHOWN { ", ..." } else { "" };
    let names: Vec<&str> = found.iter().take(SHOWN).map(|&patch| patches.name(patch)).collect();
    format!(" at {}{more}", names.join(", "))
}

fn boundary_is_open(raw: &Patched) -> bool {
    // a sheet that bounds nothing has no holes
    !boundary_edges(&raw.surface.triangles).is_empty() && require_volume(&raw.surface).is_ok()
}

/// Triangles that enclose nothing are no body, however large.
fn require_volume(surface: &SurfaceMesh) -> Result<()> {
    let centre = surface.vertices.iter().sum::<Vec3>() / surface.vertices.len().max(1) as f64;
    let around = SurfaceMesh {
        vertices: surface.vertices.iter().map(|p| p - centre).collect(),
        triangles: surface.triangles.clone(),
    };
    let (volume, least) = (enclosed_volume(&around).abs(), diagonal(&surface.vertices).powi(3));
    if volume > SMALLEST_VOLUME * least {
        return Ok(());
    }
    Err(Unusable(format!(
        "its triangles enclose {:.3e} cm3, which is no body: it may be a single face, or a sheet \
         without thickness",
        volume * 1e6
    ))
    .into())
}

fn solid_of(body: &Patched) -> Result<Solid> {
    let mut body = body.clone();
    if enclosed_volume(&body.surface) < 0.0 {
        body.surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(Solid::from_labelled_surface(&body.surface, &body.patch)?)
}

/// Whether each shell lies inside how many others, as far as all of its probes do.
fn depths(shells: &[Patched]) -> Vec<usize> {
    let winding: Vec<_> = shells.iter().map(|s| WindingNumber::new(&s.surface)).collect();
    let within = |shell: &Patched, other: &WindingNumber| {
        let vertices = &shell.surface.vertices;
        let step = (vertices.len() / PROBES).max(1);
        vertices.iter().step_by(step).all(|p| other.contains(p))
    };
    let depth =
        |i: usize| (0..shells.len()).filter(|&j| j != i && within(&shells[i], &winding[j])).count();
    (0..shells.len()).map(depth).collect()
}

/// Shells with vertices of their own. Those that are closed face outward; which of them faced inward.
fn shells_of(raw: &Patched, groups: &[Vec<usize>]) -> (Vec<Patched>, Vec<bool>) {
    let turned = |shell: &Vec<usize>| {
        let mut part = raw.part(shell);
        let closed = boundary_edges(&part.surface.triangles).is_empty();
        let inward = closed && enclosed_volume(&part.surface) < 0.0;
        if closed {
            orient_by_nesting(&mut part.surface);
        }
        (part, inward)
    };
    groups.iter().map(turned).unzip()
}

/// Shells that are sound each by itself, but cross: the union of those at even depth without those
/// at odd depth. One that faces inward where it crosses another is a cavity.
fn united(shells: &[Patched], inward: &[bool], file: &Path, record: &mut Record) -> Result<Solid> {
    let depth = depths(shells);
    let is_cavity = |i: &usize| depth[*i] % 2 == 1 || (depth[*i] == 0 && inward[*i]);
    let solids = shells.iter().map(solid_of).collect::<Result<Vec<Solid>>>()?;
    let (cavities, bodies): (Vec<usize>, Vec<usize>) = (0..solids.len()).partition(is_cavity);
    let body = bodies.iter().map(|&i| solids[i].clone()).reduce(|a, b| a.union(&b));
    let body = body.with_context(|| format!("{}: all shells face inward", file.display()))?;
    let body = cavities.iter().fold(body, |body, &i| body.difference(&solids[i]));
    record.change(format!(
        "{}: {} shells that cross, each sound: the union of {} without {} inside or facing inward",
        file.display(),
        solids.len(),
        bodies.len(),
        cavities.len()
    ));
    Ok(body)
}

/// All shells together; those that are closed and inside an odd number of others face inward.
fn oriented(raw: &Patched) -> Patched {
    let (mut shells, _) = shells_of(raw, &components(&raw.surface.triangles));
    let depth = depths(&shells);
    for (shell, depth) in shells.iter_mut().zip(depth) {
        if depth % 2 == 1 && boundary_edges(&shell.surface.triangles).is_empty() {
            shell.surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
    shells.into_iter().fold(Patched::default(), |mut all, shell| {
        all.add(shell);
        all
    })
}

/// For each triangle of `surface` the patch of the nearest of `given` that faces the same way; if
/// none within `reach` does, of the nearest whichever way it faces.
fn nearest(given: &Patched, surface: &SurfaceMesh, reach: f64) -> Vec<u32> {
    let bvh = SurfaceBvh::new(&given.surface);
    let distance = |p: &Vec3, corners: &[Vec3; 3]| (closest_on_triangle(p, corners) - p).norm();
    let owner = |t: usize| {
        let (centre, own) = (surface.centroid(t), surface.normal(t));
        let around = Vec3::repeat(2.0 * reach);
        let alike = bvh
            .overlaps(&(centre - around), &(centre + around))
            .into_iter()
            .filter(|&other| given.surface.normal(other).dot(&own) > 0.5)
            .map(|other| (distance(&centre, &given.surface.corners(other)), other))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        given.patch[alike.map_or_else(|| bvh.closest(&centre).triangle, |(_, other)| other)]
    };
    (0..surface.triangles.len()).map(owner).collect()
}

/// Cavities of a body that is one patch become patches of their own.
fn name_cavities(body: &mut Patched, patches: &mut Patches) {
    let shells = components(&body.surface.triangles);
    let Some(&first) = body.patch.first() else { return };
    if shells.len() == 1 || body.patch.iter().any(|&patch| patch != first) {
        return;
    }
    let outer = patches.name(first).to_owned();
    let base = if outer == "outer" { "cavity".into() } else { format!("{outer}-cavity") };
    let volume = |shell: &Vec<usize>| enclosed_volume(&body.part(shell).surface);
    let mut cavities: Vec<(f64, &Vec<usize>)> =
        shells.iter().map(|shell| (volume(shell), shell)).filter(|(v, _)| *v < 0.0).collect();
    cavities.sort_by(|a, b| a.0.total_cmp(&b.0));
    let several = cavities.len() > 1;
    let named: Vec<_> = cavities.into_iter().map(|(_, shell)| shell.clone()).collect();
    for (i, shell) in named.iter().enumerate() {
        let name = if several { format!("{base}-{}", i + 1) } else { base.clone() };
        let index = patches.index(&name);
        shell.iter().for_each(|&t| body.patch[t] = index);
    }
}
