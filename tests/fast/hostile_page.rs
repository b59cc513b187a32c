//! Each text of a folder of results is replaced by what would run if a page took it for markup.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::json;
use tests::chromium::Chromium;
use tests::hostile::{Hostile, assert_text_alone, files, shown, without_policy};
use tests::workdir::{Run, Workdir};

/// An SVG file that would run, ask a server and open its page.
const SVG: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" onload=\"parent.hit=1;window.hit=1\">\
                   <script>parent.hit=1</script><image href=\"http://localhost/x.png\" onerror=\"parent.hit=1\"/>\
                   <foreignObject><iframe xmlns=\"http://www.w3.org/1999/xhtml\" src=\"javascript:parent.hit=1\"/>\
                   </foreignObject></svg>";

/// Small, as it is drawn in software [px].
const SIZE: [u32; 2] = [500, 400];

/// Pages of the results in `dir/out`, which are in no other folder, with hostile texts in all files.
pub fn every_text_is_text(program: &str, dir: &Workdir) {
    let mut hostile = Hostile::but(vec!["folder"]);
    let folder = altered(dir, &mut hostile, "hostile");
    assert!(hostile.count() > 100, "{} texts", hostile.count());
    let page = dir.path("hostile.html");
    let title = hostile.text("title");
    report(dir, &folder, &page, &title).assert_good();
    let mut most = 0;
    for page in [without_policy(&page), page] {
        let mut browser = Chromium::start(program, SIZE);
        browser.show(&page);
        most = most.max(look_around(&mut browser));
        assert_text_alone(&mut browser);
    }
    assert!(most > 40, "{most} texts of {} are shown", hostile.count());
}

fn report(dir: &Workdir, folder: &Path, page: &Path, title: &str) -> Run {
    let mut command: Command = dir.command_of("cad2fem", "report");
    command.arg(folder).arg("-o").arg(page).arg(format!("--title={title}")).output().unwrap().into()
}

/// A copy of the results in which all texts, names of files and of tags are hostile.
fn altered(dir: &Workdir, hostile: &mut Hostile, to: &str) -> PathBuf {
    let to = dir.path(to);
    let status = Command::new("cp").arg("-r").arg(dir.path("out")).arg(&to).status().unwrap();
    assert!(status.success());
    for mesh in files(&dir.path("")).iter().filter(|path| path.parent() == Some(&dir.path(""))) {
        if mesh.extension().is_some_and(|e| e == "msh") {
            fs::copy(mesh, to.join(mesh.file_name().unwrap())).unwrap();
        }
    }
    // meshes first: reports find them by their hashes
    let of = |extension: &str| {
        let all = files(&to).into_iter();
        all.filter(|path| path.extension().is_some_and(|e| e == extension)).collect::<Vec<_>>()
    };
    for path in of("msh") {
        let before = sha256(&path);
        let mut file = mesh::io::read_tets(&path).unwrap();
        file.tags.names.iter_mut().for_each(|name| *name = hostile.name(name));
        replace(&path, |new| mesh::io::write_tets(new, &file.mesh, &file.tags));
        hostile.kept.insert(before, sha256(&path));
    }
    for path in of("json").into_iter().chain(of("jsonl")) {
        hostile.json_file(&path);
    }
    for path in of("md").into_iter().chain(of("txt")) {
        let text = fs::read_to_string(&path).unwrap();
        let cells = |line: &str| {
            let cell = |cell: &str| match cell.trim() {
                "" | "ok" | "warn" | "FAIL" => cell.to_owned(),
                text => format!("{text} {}", hostile.text(text)),
            };
            line.split("  ").map(cell).collect::<Vec<_>>().join("  ") + "\n"
        };
        fs::write(&path, text.lines().map(cells).collect::<String>()).unwrap();
    }
    for path in of("vtu") {
        fields(&path, hostile);
    }
    fs::create_dir_all(to.join("pictures")).unwrap();
    fs::write(to.join("pictures").join(hostile.name("svg") + ".svg"), SVG).unwrap();
    fs::write(to.join("pictures").join(hostile.name("png") + ".png"), SVG).unwrap();
    for folder in fs::read_dir(&to).unwrap().flatten().map(|entry| entry.path()) {
        let name = folder.file_name().unwrap().to_str().unwrap().to_owned();
        if folder.is_dir() && name != "pictures" && name != "mold" {
            fs::rename(&folder, to.join(hostile.name(&name))).unwrap();
        }
    }
    to
}

/// Renames the fields of a state, but for those that the page needs.
fn fields(path: &Path, hostile: &mut Hostile) {
    let mut grid = mesh::io::vtu::read_vtu(path).unwrap();
    for field in grid.point_fields.iter_mut().chain(&mut grid.cell_fields) {
        if !["displacement", "apart", "part"].contains(&field.name.as_str()) {
            field.name = hostile.text(&field.name);
        }
    }
    replace(path, |new| mesh::io::vtu::write_vtu(new, &grid));
}

/// Writes a file anew that this program has read, which it would not do itself.
fn replace(path: &Path, write: impl FnOnce(&Path) -> Result<(), mesh::io::IoError>) {
    let new = path.with_file_name(format!("new.{}", path.extension().unwrap().display()));
    write(&new).unwrap();
    fs::rename(&new, path).unwrap();
}

fn sha256(path: &Path) -> String {
    program::sha256(&fs::read(path).unwrap())
}

/// Goes through all that a page can show; how many of the texts were seen at most.
fn look_around(browser: &mut Chromium) -> u64 {
    let mut most = 0;
    for view in ["Shapes", "Mold", "Under load"] {
        let tab = format!(
            "[...document.querySelectorAll('.tabs button')].find((b) => b.textContent.startsWith('{view}'))"
        );
        browser.evaluate(&format!("{tab}?.click()"));
        browser.wait("document.getElementById('loading').hidden");
        let all = "(async () => { for (const select of document.querySelectorAll('select')) \
                     for (const option of [...select.options].slice(0, 4)) { \
                       select.value = option.value; select.dispatchEvent(new Event('change')); } \
                   for (const dot of [...document.querySelectorAll('svg *')].slice(0, 400)) \
                     for (const kind of ['pointerenter', 'pointermove', 'mouseover', 'focus']) \
                       dot.dispatchEvent(new Event(kind)); })()";
        browser.evaluate(all);
        most = most.max(shown(browser));
    }
    assert_ne!(browser.evaluate("window.puffer.state().view"), json!(null));
    most
}
