//! Sweeps: cases through Snakemake to one table and a page, failures kept, killed and continued,
//! and sweeps that cannot be used.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use tests::chromium::Chromium;
use tests::skip::skip;
use tests::workdir::{Workdir, program, repository};

/// Parameters of a name that would run where a page took it for markup.
const HOSTILE: &str = "<script>window.hit = 1</script><img src=x onerror='window.hit = 1'>";

/// The Python that sweeps run with; none where there is none, and the test is counted as skipped.
pub fn python() -> Option<PathBuf> {
    let python = repository().join(".venv-sweep/bin/python");
    if python.is_file() {
        return Some(python);
    }
    skip("the Python packages of sweeps are missing: run `make .venv-sweep/installed`");
    None
}

/// A sweep in `dir` with programs from the folder `programs`.
fn sweep(python: &Path, dir: &Workdir, programs: &Path, arguments: &str) -> Command {
    let mut command = Command::new(python);
    command.arg(repository().join("pipelines/sweep/sweep.py"));
    command.args(format!("sweep.toml -o out {arguments}").split_whitespace());
    command.current_dir(dir.path("")).env("PUFFER_BIN", programs);
    command
}

/// What a program printed.
pub fn said(output: &Output) -> String {
    let all = [output.stdout.clone(), output.stderr.clone()].concat();
    String::from_utf8_lossy(&all).into_owned()
}

/// A folder with the files of a body.
fn body(sweep: &str) -> Workdir {
    let dir = Workdir::new();
    for file in ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml"] {
        fs::copy(repository().join("pipelines/beam").join(file), dir.path(file)).unwrap();
    }
    dir.write("sweep.toml", sweep);
    dir
}

/// The table, a list of texts for each row.
fn table(dir: &Workdir) -> Vec<Vec<String>> {
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).from_path(dir.path("out/table.csv")).unwrap();
    reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

fn column(table: &[Vec<String>], name: &str) -> Vec<String> {
    let at = table[0].iter().position(|n| n == name).unwrap_or_else(|| panic!("{name}: {table:?}"));
    table[1..].iter().map(|row| row[at].clone()).collect()
}

#[test]
fn cases_become_one_table_and_a_page() {
    let Some(python) = python() else { return };
    let programs = program("solver").parent().unwrap().to_path_buf();
    let dir = body(&format!(
        "kind = \"list\"\n\
         [parameters.silicone]\nfile = \"sim.toml\"\nset = \"material\"\n\
         values = [\"ecoflex-00-50\", \"dragon-skin-20\", \"no-such-silicone\"]\n\
         [parameters.\"{HOSTILE}\"]\nfile = \"sim.toml\"\nset = \"chamber.cavity.pressure\"\n\
         values = [2e3, 4e3, 6e3]\n\
         [parameters.degree]\nfile = \"sim.toml\"\nset = \"degree\"\nvalue = 1\n\
         [parameters.\"=edge\"]\nfile = \"cad2fem.toml\"\nset = \"tetmesh.edge_length\"\nvalue = 12e-3\n"
    ));
    let output = sweep(&python, &dir, &programs, "").output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    let words = ["2 of 3 cases", "case 3 failed", "no-such-silicone"];
    words.iter().for_each(|w| assert!(said(&output).contains(w), "{w}: {}", said(&output)));

    let table = table(&dir);
    assert_eq!(column(&table, "status"), ["ok", "ok", "failed"]);
    assert_eq!(column(&table, HOSTILE), ["2000.0", "4000.0", "6000.0"]);
    assert!(column(&table, "failure")[2].starts_with("solver simulate: "), "{table:?}");
    // the same as one run by hand
    let meshes = dir.files("out/bodies");
    assert_eq!(meshes.len(), 1, "cases share a body: {meshes:?}");
    let by_hand = format!(
        "simulate sim.toml --mesh out/bodies/{}/tagged.msh --set material=dragon-skin-20 --set degree=1 \
         --set chamber.cavity.pressure=4e3 --final-only -o by-hand",
        meshes[0]
    );
    dir.solver(&by_hand).assert_good();
    let volume = &dir.json("by-hand/report.json")["chambers"]["cavity"]["volume"];
    let found: f64 = column(&table, "chambers.cavity.volume")[1].parse().unwrap();
    assert_eq!(volume.as_f64(), Some(found));
    let same = "import pandas as p; a = p.read_parquet('out/table.parquet'); b = p.read_csv('out/table.csv'); \
                assert ' =edge' in b; b = b.rename(columns=str.strip); assert list(a) == list(b); n = a.select_dtypes('number').columns; assert len(n) > 10; \
                p.testing.assert_frame_equal(a[n], b[n], check_dtype=False)";
    let same = Command::new(&python).args(["-c", same]).current_dir(dir.path("")).output().unwrap();
    assert!(same.status.success(), "{}", said(&same));
    page(&dir);
}

/// Choices on an axis choose cases, and no name of a parameter becomes markup.
fn page(dir: &Workdir) {
    let Some(mut browser) = Chromium::start([1200, 900]) else { return };
    browser.open(&dir.path("out/sweep.html"));
    browser.wait("document.getElementById('count')?.textContent.startsWith('3 cases, 1 failed')");
    let count = |browser: &mut Chromium, what: &str| {
        browser.evaluate(&format!("document.querySelectorAll('{what}').length")).as_u64().unwrap()
    };
    assert_eq!(count(&mut browser, "#pictures img"), 2);
    assert_eq!(count(&mut browser, "#table tbody tr"), 3);
    assert_eq!(count(&mut browser, "#failures tbody tr"), 1);
    // numbers as people read them, with their units
    let head = browser.evaluate("document.querySelector('#table thead').textContent");
    let head = head.as_str().unwrap();
    for words in
        ["chambers.cavity.pressure [kPa]", "chambers.cavity.volume [mL]", "energies.total [mJ]"]
    {
        assert!(head.contains(words), "{words}: {head}");
    }
    let pressure =
        "data.rows.map((r) => r[data.columns.indexOf('chambers.cavity.pressure')]).slice(0, 2)";
    assert_eq!(browser.evaluate(pressure), serde_json::json!([2, 4]));
    // the least of the pressures, on the axis that is called so
    let axis = "parallel.getOption().parallelAxis.findIndex((a) => a.name.startsWith('<script>'))";
    browser.evaluate(&format!(
        "parallel.dispatchAction({{ type: 'axisAreaSelect', intervals: [[1900, 2100]], \
         parallelAxisId: parallel.getModel().getComponent('parallelAxis', {axis}).id }})"
    ));
    browser.wait("document.querySelectorAll('#table tbody tr').length === 1");
    assert!(browser.picture().colors() > 100);
    assert_eq!(browser.evaluate("window.hit ?? null"), serde_json::Value::Null);
    assert_eq!(browser.complaints(), [""; 0]);
    assert_eq!(browser.requests().len(), 1, "the page alone: {:?}", browser.requests());
}

/// Programs that do nothing but take their time, leave a report, and count.
fn stand_ins(dir: &Workdir) -> PathBuf {
    let folder = dir.path("programs");
    fs::create_dir(&folder).unwrap();
    let solver = "#!/bin/sh\nwhile [ \"$1\" != -o ]; do shift; done\necho x >> \"$SOLVED\"\nsleep 0.2\n\
                  case \"$*\" in *=3*) [ -e \"$MENDED\" ] || { echo 'error: no equilibrium' >&2; exit 1; };; esac\n\
                  mkdir -p \"$2\"; echo '{\"tets\": 7}' > \"$2/report.json\"\n";
    for (name, text) in [("solver", solver), ("cad2fem", "#!/bin/sh\n"), ("tagger", "#!/bin/sh\n")]
    {
        fs::write(folder.join(name), text).unwrap();
        fs::set_permissions(folder.join(name), fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn failures_are_kept_and_what_was_killed_continues() {
    let Some(python) = python() else { return };
    let dir = body(
        "kind = \"grid\"\n[parameters.p]\nfile = \"sim.toml\"\nset = \"chamber.cavity.pressure\"\n\
         from = 1\nto = 8\ncount = 8\n",
    );
    let programs = stand_ins(&dir);
    let run = |arguments: &str| {
        let mut command = sweep(&python, &dir, &programs, &format!("--cores 2 {arguments}"));
        command.env("SOLVED", dir.path("solved")).env("MENDED", dir.path("mended"));
        command
    };
    let solved = || dir.text("solved").lines().count();
    let done = || {
        let cases = dir.files("out/cases");
        cases.iter().filter(|c| dir.path(&format!("out/cases/{c}/step.json")).exists()).count()
    };
    // the whole family, at once
    let mut child = run("").process_group(0).spawn().unwrap();
    let start = Instant::now();
    while done() < 2 {
        assert!(start.elapsed() < Duration::from_secs(60), "no case in a minute");
        std::thread::sleep(Duration::from_millis(20));
    }
    let kept = done();
    let killed = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).status();
    assert!(killed.unwrap().success());
    child.wait().unwrap();
    assert!(!dir.path("out/table.csv").exists());

    let output = run("").output().unwrap();
    assert!(output.status.success() && said(&output).contains("7 of 8 cases"), "{}", said(&output));
    // those that were under way may be solved twice
    assert!((8..=8 + 2).contains(&solved()), "{} of which {kept} were kept", solved());
    let rows = table(&dir);
    assert_eq!(column(&rows, "failure")[2], "solver simulate: error: no equilibrium");
    assert_eq!(column(&rows, "tets").iter().filter(|t| *t == "7.0").count(), 7);

    // nothing to do, and then the failed one alone
    let before = solved();
    assert!(run("").status().unwrap().success());
    assert_eq!(solved(), before);
    dir.write("mended", "");
    let output = run("--retry").output().unwrap();
    assert!(said(&output).contains("8 of 8 cases"), "{}", said(&output));
    assert_eq!(solved(), before + 1);
}

/// An independent validator takes what the program takes, and refuses what it refuses by its keys.
#[test]
fn the_schema_knows_the_keys() {
    let folder = repository().join("pipelines");
    let output = Command::new("python3").arg(folder.join("sweep/schema.py")).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    let schema = serde_json::from_slice(&output.stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let valid = |text: &str| {
        let value: toml::Value = toml::from_str(text).unwrap();
        validator.is_valid(&serde_json::to_value(value).unwrap())
    };
    let mut count = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path().join("sweep.toml");
        if path.is_file() {
            assert!(valid(&fs::read_to_string(&path).unwrap()), "{}", path.display());
            count += 1;
        }
    }
    assert!(count > 0);
    let p = "[parameters.p]\nfile = \"sim.toml\"\nset = \"degree\"\n";
    assert!(valid(&format!("kind = \"grid\"\n{p}values = [1, 2]")));
    for bad in [
        format!("{p}values = [1, 2]"),
        format!("kind = \"gird\"\n{p}values = [1, 2]"),
        format!("kind = \"grid\"\ncasse = 3\n{p}values = [1, 2]"),
        format!("kind = \"grid\"\n{p}values = [1]\nvalue = 2"),
        format!("kind = \"grid\"\n{p}from = 1\ncount = 3"),
    ] {
        assert!(!valid(&bad), "{bad}");
    }
}

/// Texts of a sweep, in which P and Q begin tables of parameters, and what is said of them.
const REFUSED: &[(&str, &[&str])] = &[
    ("kind = \"grid", &["sweep.toml:1:", "^"]),
    ("kind = \"gird\"", &["sweep.toml:1:1: kind = 'gird'", "'grid'"]),
    ("kind = \"grid\"", &["sweep.toml: nothing varies"]),
    ("P", &["no `kind`"]),
    ("kind = \"grid\"\nP", &["sweep.toml:2:1: [parameters.p]", "`values`"]),
    ("kind = \"grid\"\nP\nvaleus = [1]", &["sweep.toml:5:1", "did you mean `values`?"]),
    ("kind = \"grid\"\nP\nvalues = []", &["sweep.toml:5:1", "`values` is empty"]),
    ("kind = \"grid\"\nP\nvalues = [nan]", &["sweep.toml:5:1", "finite"]),
    ("kind = \"grid\"\nP\nfrom = 1\nto = 2", &["sweep.toml:5:1", "`count`"]),
    ("kind = \"latin\"\nP\nfrom = 1\nto = 2", &["`cases`", "Latin"]),
    ("kind = \"latin\"\ncases = 3\nP\nfrom = 0\nto = 2\nscale = \"log\"", &["8:1", "positive"]),
    ("kind = \"grid\"\nseed = 1\nP\nvalues = [1, 2]", &["sweep.toml:2:1: `seed`", "latin"]),
    ("kind = \"grid\"\nsimulate = \"x.toml\"\nP\nvalues = [1]", &["x.toml", "2:1"]),
    (
        "kind = \"grid\"\nP\nfrom = 1\nto = 2\ncount = 2000\nQ\nfrom = 1\nto = 2\ncount = 3000",
        &["2000 × 3000 = 6000000 cases: at most 1000000"],
    ),
    (
        "kind = \"list\"\nP\nvalues = [1, 2]\nQ\nvalues = [1]",
        &["[parameters.q]: 1 values, others have 2"],
    ),
    ("kind = \"grid\"\npicture = \"--output x\"\nP\nvalues = [1]", &["'--output'", "--color"]),
];

#[test]
fn sweeps_that_cannot_be_used_are_refused() {
    let Some(python) = python() else { return };
    let dir = body("");
    let nowhere = |arguments: &str| {
        let output = sweep(&python, &dir, Path::new("/nowhere"), arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(!said(&output).contains("Traceback"), "{}", said(&output));
        assert!(!dir.path("out").exists());
        said(&output)
    };
    let p = "[parameters.p]\nfile = \"sim.toml\"\nset = \"degree\"";
    let q = "[parameters.q]\nfile = \"sim.toml\"\nset = \"material\"";
    for (text, words) in REFUSED {
        let lines = text.lines().map(|line| match line {
            "P" => p,
            "Q" => q,
            line => line,
        });
        dir.write("sweep.toml", &(lines.collect::<Vec<_>>().join("\n") + "\n"));
        let found = nowhere("--plan");
        words.iter().for_each(|w| assert!(found.contains(w), "{text}: {w}: {found}"));
    }
    // sound, but without programs
    dir.write("sweep.toml", &format!("kind = \"grid\"\n{p}\nvalues = [1, 2]"));
    let found = nowhere("");
    assert!(found.contains("/nowhere/cad2fem is not there: make setup"), "{found}");
}
