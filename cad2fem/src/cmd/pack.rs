//! `cad2fem pack`: results and sources of a body → one file to send.

use std::collections::BTreeSet;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use mesh::io::{note_results, read_bytes, write_atomic};
use page::contents;
use page::reported::{Provenance, read};
use page::survey::{Survey, entries, name};
use system::canonical;
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// Ends of the names of sources.
const SOURCES: [&str; 16] = [
    "toml", "geo", "py", "step", "stp", "brep", "iges", "igs", "stl", "obj", "ply", "3mf", "msh",
    "csv", "json", "md",
];

/// Folders in the folder of sources that are looked into, one in the other.
const DEEP: usize = 3;

/// What printer, bench and colleagues need of a body, in one file: parts and their settings, the sheet for the bench,
/// the page, curves, sources, versions and hashes; the same bits for the same files
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of results with their page report.html, such as build/frog
    folder: PathBuf,
    /// Folder of the files that they were made from, such as pipelines/frog
    #[arg(long)]
    sources: Option<PathBuf>,
    /// File to write (.zip); what is in it lies in a folder of its name
    #[arg(short, long)]
    output: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// If the folder holds nothing that is known or has no page, a file in it cannot be read, or the
/// package cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    note_results(&args.folder);
    let is_zip = args.output.extension().is_some_and(|e| e == "zip");
    ensure!(is_zip, "{}: the name must end with .zip", args.output.display());
    let survey = Survey::of(&args.folder)?;
    let page = args.folder.join("report.html");
    let command = format!("cad2fem report {0} -o {0}/report.html", args.folder.display());
    ensure!(page.is_file(), "{}: is not there; make it: {command}", page.display());
    let mut files = vec![("report.html".to_owned(), read_bytes(&page)?)];
    let pictures = survey.pictures.iter().cloned();
    for path in contents::all(&survey)?.into_iter().map(|c| c.path).chain(pictures) {
        let place = inside(&path, &args.folder)?;
        files.push((place, read_bytes(&path)?));
    }
    if let Some(sources) = &args.sources {
        for path in sources_in(sources, &args.folder, DEEP)? {
            files.push((format!("sources/{}", inside(&path, sources)?), read_bytes(&path)?));
        }
    }
    files.push(("versions.txt".into(), versions(&survey)?.into_bytes()));
    files.sort();
    files.dedup_by(|a, b| a.0 == b.0);
    let sums: String = files
        .iter()
        .map(|(place, bytes)| format!("{}  {place}\n", program::sha256(bytes)))
        .collect();
    files.push(("SHA256SUMS".into(), sums.into_bytes()));
    let bytes = packed(&name(&args.output.with_extension("")), &files)
        .with_context(|| args.output.display().to_string())?;
    write_atomic(&args.output, |out| out.write_all(&bytes))?;
    log::info!(
        "{}: {} files, {:.1} MB, {:.1} s",
        args.output.display(),
        files.len(),
        bytes.len() as f64 * 1e-6,
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

/// The place of a file in the package: as it lies in its folder.
fn inside(path: &Path, folder: &Path) -> Result<String> {
    let place = path.strip_prefix(folder).with_context(|| path.display().to_string())?;
    Ok(system::portable(place))
}

/// The sources in a folder, without results and what is hidden.
fn sources_in(folder: &Path, results: &Path, deep: usize) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for path in entries(folder)? {
        let (own, hidden) = (name(&path), name(&path).starts_with('.'));
        let is_results = || same(&path, results) || own == "build";
        if hidden || (path.is_dir() && (deep == 0 || is_results())) {
            continue;
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if path.is_dir() {
            found.extend(sources_in(&path, results, deep - 1)?);
        } else if SOURCES.contains(&extension.to_lowercase().as_str()) {
            found.push(path);
        }
    }
    Ok(found)
}

fn same(a: &Path, b: &Path) -> bool {
    matches!((canonical(a), canonical(b)), (Ok(a), Ok(b)) if a == b)
}

/// Programs, and the files that every report was made from with their hashes, as text.
fn versions(survey: &Survey) -> Result<String> {
    let mut programs = BTreeSet::from([format!("cad2fem {}", env!("CARGO_PKG_VERSION"))]);
    let mut inputs = String::new();
    for path in &survey.reports {
        let report: Provenance = read(path)?;
        programs.extend(report.program.clone());
        inputs += &format!("\n{}\n", inside(path, &survey.folder)?);
        for input in report.files() {
            inputs += &format!("  {}  {}\n", input.sha256, input.path.display());
        }
    }
    let programs: String = programs.iter().map(|program| format!("  {program}\n")).collect();
    Ok(format!("Programs\n{programs}\nFiles that each report was made from, SHA-256\n{inputs}"))
}

/// The archive. Its entries have no date of their own, so that the same files are the same bits.
fn packed(folder: &str, files: &[(String, Vec<u8>)]) -> Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let plain = SimpleFileOptions::default().last_modified_time(DateTime::default());
    for (place, bytes) in files {
        archive.start_file(format!("{folder}/{place}"), plain.unix_permissions(0o644))?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}
