//! `cad2fem info`: counts, sizes, quality and validity of any surface or mesh.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use mesh::check::{Finding, check_surface, check_tets, coincident};
use mesh::io::{read_surface, read_tets};
use mesh::measure::{
    Quality, area, bounds, diagonal, enclosed_volume, quality, triangle_area, unlikely_size, volume,
};
use mesh::topology::{boundary, boundary_edges, boundary_loops, components};
use mesh::{SurfaceMesh, Tags};
use program::Unusable;
use serde::Serialize;

use mesh::check::findings;
use program::units::Unit;

/// Findings are listed, and are an error with --check
#[derive(Debug, clap::Args)]
pub struct Args {
    /// .stl, .obj, .ply or .msh
    file: PathBuf,
    /// Unit of the file, if not metres: the printed parts of a mold are in mm
    #[arg(long)]
    unit: Option<Unit>,
    /// One line of JSON on stdout
    #[arg(long)]
    json: bool,
    /// Exit with 1 if there are findings
    #[arg(long)]
    check: bool,
}

/// What is known about a file.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    /// Unit of the lengths in the file; all below are in metres.
    unit: Unit,
    vertices: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    tets: Option<usize>,
    /// Number of triangles of the surface or of the boundary.
    triangles: usize,
    components: usize,
    open_edges: usize,
    open_loops: usize,
    /// [m]
    bounds: [[f64; 3]; 2],
    /// [m]
    diagonal: f64,
    /// [m²]
    area: f64,
    /// Enclosed, signed; of an open surface there is none [m³].
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<Quality>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tags: Vec<TagInfo>,
    findings: Vec<Finding>,
}

#[derive(Debug, Serialize)]
struct TagInfo {
    id: u32,
    name: String,
    facets: usize,
    /// [m²]
    area: f64,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let is_mesh = mesh::io::extension(&args.file) == "msh";
    let info = if is_mesh { of_tets(args)? } else { of_surface(args)? };
    if args.json {
        writeln!(std::io::stdout().lock(), "{}", serde_json::to_string(&info)?)?;
    } else {
        info.print(&mut program::stdout())?;
    }
    if args.check && !info.findings.is_empty() {
        let message = format!("{}:{}", args.file.display(), findings(&info.findings));
        return Err(Unusable(message).into());
    }
    Ok(())
}

fn of_surface(args: &Args) -> Result<Info> {
    let mut surface = read_surface(&args.file)?;
    if let (None, Some(remark)) = (args.unit, unlikely_size(&surface.vertices)) {
        log::warn!("{}: {remark}, or say --unit", args.file.display());
    }
    let unit = args.unit.unwrap_or(Unit::M);
    surface.vertices.iter_mut().for_each(|v| *v *= unit.metres());
    let mut info = Info::of(args, unit, &surface, check_surface(&surface));
    info.volume = (info.open_edges == 0).then(|| enclosed_volume(&surface));
    Ok(info)
}

fn of_tets(args: &Args) -> Result<Info> {
    let mut file = read_tets(&args.file)?;
    let unit = args.unit.unwrap_or(Unit::M);
    file.mesh.vertices.iter_mut().for_each(|v| *v *= unit.metres());
    let mut found = check_tets(&file.mesh);
    if found.is_empty() {
        found.extend(coincident(&file.mesh));
    }
    let (skin, _) = boundary(&file.mesh).surface(&file.mesh);
    let mut info = Info::of(args, unit, &skin, found);
    info.vertices = file.mesh.vertices.len();
    info.tets = Some(file.mesh.tets.len());
    info.volume = Some(volume(&file.mesh));
    info.quality = Some(quality(&file.mesh));
    info.tags = tags(&file.tags, &file.mesh.vertices);
    Ok(info)
}

fn tags(tags: &Tags, vertices: &[mesh::Vec3]) -> Vec<TagInfo> {
    let info = |(id, name): (u32, &String)| {
        let facets = tags.facets_of(id);
        let area = |f: &[usize; 3]| triangle_area(vertices[f[0]], vertices[f[1]], vertices[f[2]]);
        let area = facets.iter().map(area).sum();
        TagInfo { id, name: name.clone(), facets: facets.len(), area }
    };
    (1..).zip(&tags.names).map(info).collect()
}

impl Info {
    fn of(args: &Args, unit: Unit, surface: &SurfaceMesh, findings: Vec<Finding>) -> Self {
        let (min, max) = bounds(&surface.vertices);
        Self {
            file: args.file.display().to_string(),
            unit,
            vertices: surface.vertices.len(),
            tets: None,
            triangles: surface.triangles.len(),
            components: components(&surface.triangles).len(),
            open_edges: boundary_edges(&surface.triangles).len(),
            open_loops: boundary_loops(&surface.triangles).len(),
            bounds: [min.into(), max.into()],
            diagonal: diagonal(&surface.vertices),
            area: area(surface),
            volume: None,
            quality: None,
            tags: Vec::new(),
            findings,
        }
    }

    fn print(&self, out: &mut impl std::io::Write) -> std::io::Result<()> {
        match self.unit {
            Unit::M => writeln!(out, "{}", self.file)?,
            unit => writeln!(out, "{}, lengths in {}", self.file, unit.symbol())?,
        }
        match self.tets {
            Some(tets) => writeln!(
                out,
                "  {tets} tets, {} vertices, {} boundary facets",
                self.vertices, self.triangles
            )?,
            None => writeln!(out, "  {} triangles, {} vertices", self.triangles, self.vertices)?,
        }
        writeln!(
            out,
            "  {} component(s), {} open edge(s) in {} loop(s)",
            self.components, self.open_edges, self.open_loops
        )?;
        let [min, max] = self.bounds.map(|p| p.map(|x| x * 1e3));
        writeln!(
            out,
            "  box {:.3} {:.3} {:.3} .. {:.3} {:.3} {:.3} mm, diagonal {:.3} mm",
            min[0],
            min[1],
            min[2],
            max[0],
            max[1],
            max[2],
            self.diagonal * 1e3
        )?;
        write!(out, "  area {:.4} cm2", self.area * 1e4)?;
        match self.volume {
            Some(volume) => writeln!(out, ", volume {:.5} cm3", volume * 1e6)?,
            None => writeln!(out, ", open: no volume")?,
        }
        if let Some(q) = &self.quality {
            writeln!(out, "  {q} (shortest, mean, longest)")?;
        }
        for tag in &self.tags {
            writeln!(
                out,
                "  tag {:>2} {:<12} {:>6} facets {:>10.4} cm2",
                tag.id,
                tag.name,
                tag.facets,
                tag.area * 1e4
            )?;
        }
        for finding in &self.findings {
            writeln!(out, "  {}: {}", finding.rule, finding.message)?;
        }
        if self.findings.is_empty() {
            writeln!(out, "  no findings")?;
        }
        Ok(())
    }
}
