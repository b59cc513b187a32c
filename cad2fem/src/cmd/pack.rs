//! `cad2fem pack`: results and sources of a body → one file to send.

use std::collections::BTreeSet;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use mesh::io::{read_bytes, read_text, write_atomic};
use page::contents;
use page::reported::{Model, Provenance, read};
use page::survey::{Survey, entries, name};
use system::canonical;
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

use super::new;
use crate::template::{TEMPLATES, Template};

/// Ends of the names of sources.
const SOURCES: [&str; 16] = [
    "toml", "geo", "py", "step", "stp", "brep", "iges", "igs", "stl", "obj", "ply", "3mf", "msh",
    "csv", "json", "md",
];

/// Ends of the name of the model that the rules of make look for.
const MODELS: [&str; 10] =
    ["toml", "geo", "step", "stp", "brep", "iges", "3mf", "stl", "obj", "ply"];

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
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
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
        files.extend(makefile(sources)?);
        files.extend(model_by_hand(sources, &args.folder)?);
    }
    files.retain(|(place, _)| has_plain_name(place));
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

/// Whether make and a shell take a name as it is, wherever the package is unpacked; says what is left out.
fn has_plain_name(place: &str) -> bool {
    let odd = place.chars().find(|&c| !(c.is_ascii_alphanumeric() || "._-/".contains(c)));
    if let Some(c) = odd {
        log::warn!(
            "{place}: left out of the package, as make or a shell may take the {c:?} in its name for their own: give it a \
             name of letters, digits, - . and _"
        );
    }
    odd.is_none()
}

/// A Makefile for the sources, as `cad2fem new` writes it: one that lies there may run anything.
fn makefile(sources: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let full = canonical(sources).with_context(|| sources.display().to_string())?;
    if new::is_in_pipelines(&full) {
        return Ok(Vec::new());
    }
    let there = sources.join("Makefile");
    let text = if there.is_file() { read_text(&there)? } else { String::new() };
    let like = text.lines().find_map(|line| line.strip_prefix("LIKE := "));
    let template = like.and_then(|name| Template::find(name.trim()).ok()).unwrap_or(&TEMPLATES[0]);
    let rules = template.files.iter().filter(|(name, _)| *name == "rules.mk");
    let rules = rules.map(|(name, text)| (format!("sources/{name}"), text.as_bytes().to_vec()));
    let makefile = new::makefile(template, None).into_bytes();
    Ok(rules.chain([("sources/Makefile".to_owned(), makefile)]).collect())
}

/// The model of a body that was imported by hand, so that its sources hold no file of it, and the files that it was imported
/// from. The model lies where the rules of make look for it.
fn model_by_hand(sources: &Path, results: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let folder = results.join("model");
    let report = folder.join("model.json");
    let own = MODELS.iter().any(|end| sources.join(format!("model.{end}")).exists());
    if own || !report.is_file() {
        return Ok(Vec::new());
    }
    let mut files = Vec::new();
    let patches = folder.join("patches");
    let all = if patches.is_dir() { entries(&patches)? } else { Vec::new() };
    for path in all.into_iter().chain([report.clone(), folder.join("model.stl")]) {
        files
            .push((format!("sources/build/model/{}", inside(&path, &folder)?), read_bytes(&path)?));
    }
    let imported = read::<Model>(&report)?.import;
    let top = canonical(sources)?;
    for file in imported.files {
        match file.find(&folder) {
            Ok(path) if canonical(&path).is_ok_and(|path| path.starts_with(&top)) => {}
            Ok(path) => files.push((format!("sources/cad/{}", name(&path)), read_bytes(&path)?)),
            Err(error) => log::warn!("{}: left out of the package: {error:#}", report.display()),
        }
    }
    Ok(files)
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
