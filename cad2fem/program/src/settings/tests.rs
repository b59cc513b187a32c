#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;

use anyhow::anyhow;
use serde::Deserialize;

use super::*;
use crate::misfit;

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Scene {
    mesh: PathBuf,
    degree: usize,
    material: String,
    gravity: Vec<f64>,
    chamber: Vec<Chamber>,
    parameters: BTreeMap<String, f64>,
    time: Time,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Chamber {
    on: String,
    pressure: Option<toml::Value>,
    fill: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Time {
    end: f64,
    steps: usize,
}

const KEYS: Keys = Keys { paths: &["mesh"], named: &["parameters"], meaning: None };

const SCENE: &str = "\
mesh = \"body.msh\"
degree = 2

[[chamber]]
on = \"cavity\"
pressure = 50e3

[[chamber]]
on = \"arm.left\"
pressure = \"2e3*t\"

[parameters]
peak = 3.0
";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            let path = folder.0.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    fn read(&self, name: &str, set: &[&str]) -> Result<Settings> {
        let changes: Vec<Change> = set.iter().map(|text| text.parse().unwrap()).collect();
        Settings::read(&self.0.path().join(name), &changes, KEYS)
    }

    /// What it says, with the folder left out.
    fn refuses(&self, name: &str, set: &[&str]) -> String {
        let parsed = self.read(name, set).and_then(|settings| settings.parse::<Scene>());
        let message = format!("{:#}", parsed.unwrap_err());
        message.replace(&format!("{}/", self.0.path().display()), "")
    }
}

#[test]
fn an_unknown_key_is_shown_with_its_place_and_the_nearest() {
    let folder = Folder::new(&[("sim.toml", &SCENE.replace("degree", "\tdegre"))]);
    assert_eq!(
        folder.refuses("sim.toml", &[]),
        "sim.toml:2:2: unknown field `degre`; did you mean `degree`? expected one of `mesh`, \
         `degree`, `material`, `gravity`, `chamber`, `parameters`, `time`\n  |\n2 | \tdegre = 2\n  \
         | \t^^^^^"
    );
    let folder = Folder::new(&[("sim.toml", &SCENE.replace("degree = 2", "degree = \"two\""))]);
    let message = folder.refuses("sim.toml", &[]);
    assert!(message.starts_with("sim.toml:2:10: invalid type: string \"two\""), "{message}");
    assert!(message.ends_with("2 | degree = \"two\"\n  |          ^^^^^"), "{message}");
    let folder = Folder::new(&[("sim.toml", "mesh = \"ä\" x\n")]);
    let message = folder.refuses("sim.toml", &[]);
    assert!(message.starts_with("sim.toml:1:12: "), "{message}");
    // the table that it is in counts, although another has that key
    let elsewhere = format!("{SCENE}[time]\ndegree = 2\n");
    let message = Folder::new(&[("sim.toml", &elsewhere)]).refuses("sim.toml", &[]);
    assert!(
        message.starts_with("sim.toml:15:1: unknown field `degree`, expected `end`"),
        "{message}"
    );
    let missing = folder.read("no.toml", &[]).unwrap_err();
    assert!(format!("{missing:#}").contains("no.toml"), "{missing:#}");
}

#[test]
fn values_are_set_from_outside() {
    let folder = Folder::new(&[("sim.toml", SCENE)]);
    let set = [
        "chamber.cavity.pressure=30e3",
        "chamber.arm.left.pressure = 5e3*t",
        "chamber.1.fill=2",
        "parameters.peak=-4",
        "material=ecoflex-00-30",
        "time.steps=7",
        "gravity=[0, 0, 1]",
        "gravity.2=-9.81",
    ];
    let settings = folder.read("sim.toml", &set).unwrap();
    let scene: Scene = settings.parse().unwrap();
    assert_eq!(scene.chamber[0].pressure, Some(toml::Value::Float(30e3)));
    assert_eq!(scene.chamber[1].pressure, Some(toml::Value::String("5e3*t".into())));
    assert_eq!(scene.chamber[1].fill, Some(2.0));
    assert_eq!((scene.parameters["peak"], scene.time.steps), (-4.0, 7));
    assert_eq!((scene.material.as_str(), scene.gravity[2]), ("ecoflex-00-30", -9.81));
    assert_eq!(settings.changes(), set);
}

#[test]
fn what_is_not_there_cannot_be_set() {
    let folder =
        Folder::new(&[("sim.toml", &format!("{SCENE}[[fixed]]\non = 'a'\n[[fixed]]\non = 'a'\n"))]);
    for (set, words) in [
        (
            "parameters.peek=3",
            "sim.toml: --set parameters.peek=3: [parameters] has no peek; did you mean `peak`? it \
             has peak\n  | parameters.peek=3\n  |            ^^^^",
        ),
        (
            "chamber.cavty.pressure=3",
            "[[chamber]] has no cavty; did you mean `cavity`? it has cavity, arm.left\n",
        ),
        ("chamber.2.pressure=3", "chamber has 2, counted from 0\n"),
        (
            "fixed.a.displacement=[0, 0, 0]",
            "several [[fixed]] are called a: count them from 0, as in fixed.0 and fixed.1\n",
        ),
        ("degree.x=3", "degree is no table, and has no x\n"),
    ] {
        let message = folder.refuses("sim.toml", &[set]);
        assert!(message.contains(words), "{set}: {message}");
    }
    let folder = Folder::new(&[("sim.toml", SCENE)]);
    assert!(folder.refuses("sim.toml", &["chamber.cavity.presure=3"]).ends_with(
        "--set chamber.cavity.presure=3: unknown field `presure`; did you mean `pressure`? \
         expected one of `on`, `pressure`, `fill`\n  | chamber.cavity.presure=3\n  |                \
         ^^^^^^^"
    ));
    let message = folder.refuses("sim.toml", &["degree=two"]);
    assert!(message.contains("--set degree=two: invalid type: string \"two\""), "{message}");
    for text in ["", "degree", "=3", "a b=3", "a=1\nb=2"] {
        assert!(text.parse::<Change>().unwrap_err().contains("expected PATH=VALUE"), "{text:?}");
    }
}

#[test]
fn a_file_stands_over_what_it_includes() {
    let pressures = "[[chamber]]\non = \"cavity\"\npressure = { t = [0, 1], value = [0, 9] }\n\
                     [[chamber]]\non = \"new\"\n";
    let folder = Folder::new(&[
        ("in/sim.toml", SCENE),
        ("out/pressures.toml", pressures),
        ("out/parameters.toml", "[parameters]\npeak = 5.0\nother = 1.0\n"),
        ("loads.toml", "include = ['out/pressures.toml', 'out/parameters.toml']"),
        (
            "both.toml",
            "include = ['in/sim.toml', 'loads.toml']\ndegree = 3\n\
             [parameters]\nother = 2.0\n",
        ),
    ]);
    let settings = folder.read("both.toml", &["degree=1"]).unwrap();
    let scene: Scene = settings.parse().unwrap();
    assert_eq!((scene.mesh.as_path(), scene.degree), (Path::new("in/body.msh"), 1));
    let on: Vec<&str> = scene.chamber.iter().map(|c| c.on.as_str()).collect();
    assert_eq!(on, ["cavity", "arm.left", "new"]);
    assert!(scene.chamber[0].pressure.as_ref().unwrap().is_table());
    assert_eq!((scene.parameters["peak"], scene.parameters["other"]), (5.0, 2.0));
    let included: Vec<PathBuf> = settings.included().into_iter().map(|f| f.path).collect();
    assert_eq!(included.len(), 4);
    assert!(included[0].ends_with("in/sim.toml"));
}

#[test]
fn includes_that_cannot_be_meant_are_refused() {
    let folder = Folder::new(&[
        ("a.toml", "include = 'b.toml'"),
        ("b.toml", "include = 'a.toml'"),
        ("number.toml", "degree = 1\ninclude = 3\n"),
        ("wrong.toml", "include = 'there/wrong.toml'\n"),
        ("there/wrong.toml", "degree = 1\nmash = ''\n"),
        ("later.toml", "degree = 1\npuffer = '7.5'\n"),
        ("gone.toml", "include = 'none.toml'\n"),
        ("bytes.toml", "include = 'environ'\n"),
        ("environ", "TOKEN=secret\0PATH=/bin\0"),
        ("body.msh", "$MeshFormat\n4.1 0 8\n"),
    ]);
    let message = folder.refuses("body.msh", &[]);
    assert_eq!(
        message,
        "body.msh: a .msh file is a shape or a mesh, and a file with settings is needed here, such \
         as sim.toml"
    );
    assert!(folder.refuses("a.toml", &[]).contains("included by itself"));
    let message = folder.refuses("bytes.toml", &[]);
    assert!(message.contains("environ: it has characters without meaning"), "{message}");
    assert!(!message.contains("secret"), "{message}");
    let message = folder.refuses("number.toml", &[]);
    assert!(
        message.starts_with("number.toml:2:11: include: expected the name of a file"),
        "{message}"
    );
    let message = folder.refuses("wrong.toml", &[]);
    assert!(
        message.starts_with("there/wrong.toml:2:1: unknown field `mash`; did you mean `mesh`?"),
        "{message}"
    );
    let message = folder.refuses("later.toml", &[]);
    assert!(
        message.starts_with("later.toml:2:10: written for puffer 7.5, and this is"),
        "{message}"
    );
    assert!(folder.refuses("gone.toml", &[]).contains("none.toml"));
}

#[test]
fn the_hash_is_that_of_the_file_unless_there_is_more() {
    let folder = Folder::new(&[("sim.toml", SCENE), ("all.toml", "include = 'sim.toml'")]);
    let hash = |name: &str, set: &[&str]| folder.read(name, set).unwrap().hash();
    let alone = hash("sim.toml", &[]);
    assert_eq!(alone, crate::sha256(SCENE.as_bytes()));
    assert_ne!(hash("sim.toml", &["degree=1"]), alone);
    assert_ne!(hash("sim.toml", &["degree=1"]), hash("sim.toml", &["degree=2"]));
    let before = hash("all.toml", &[]);
    fs::write(folder.0.path().join("sim.toml"), "degree = 1").unwrap();
    assert_ne!(hash("all.toml", &[]), before);
}

#[test]
fn what_settings_mean_is_refused_with_its_place() {
    let folder = Folder::new(&[("sim.toml", SCENE)]);
    let settings = folder.read("sim.toml", &["time.steps=0"]).unwrap();
    let place = |error: anyhow::Error| {
        let message = format!("{:#}", settings.place(error));
        message.replace(&format!("{}/", folder.0.path().display()), "")
    };
    let steps = KeyPath::table("time").key("steps");
    let left = || KeyPath::list("chamber").on("arm.left");
    let inner = KeyPath::of("pressure").says(" is odd");
    let context = anyhow::Error::from(inner).context(KeyPath::list("chamber").number(2));
    let carried = KeyPath::table("parameters").key("peak").told("three is odd");
    for (error, words) in [
        (
            misfit!(KeyPath::of("degree"), " = {}: must be 7", 2).into(),
            "sim.toml:2:1: degree = 2: must be 7\n  |\n2 | degree = 2\n  | ^^^^^^^^^^",
        ),
        (
            misfit!(left().key("pressure"), ": \"2e3*t\" is odd").into(),
            "sim.toml:10:1: [[chamber]] on \"arm.left\": pressure: \"2e3*t\" is odd\n   |\n10 | \
             pressure = \"2e3*t\"\n   | ^^^^^^^^^^^^^^^^^^",
        ),
        (KeyPath::of("parameters.peak").says(" is 3").into(), "sim.toml:13:1: "),
        (steps.says(" = 0").into(), "sim.toml: --set time.steps=0: [time]: steps = 0"),
        (context, "sim.toml:10:1: [[chamber]] 2: pressure is odd\n"),
        (anyhow::Error::from(carried).context("peaks"), "sim.toml:13:1: peaks: three is odd\n"),
        (anyhow!("is odd").context(KeyPath::list("chamber").number(1)), "sim.toml:4:1: "),
        (KeyPath::table("contact").says(": is odd").into(), "sim.toml: [contact]: is odd"),
        // texts say nothing of places
        (anyhow!("degree = 2: must be 7"), "sim.toml: degree = 2: must be 7"),
    ] {
        let message = place(error);
        assert!(message.starts_with(words), "{words}: {message}");
    }
    let unusable = settings.place(crate::Unusable("degree = 2".into()).into());
    assert!(unusable.is::<crate::Unusable>());
}

/// A type that reads itself, from a buffer.
#[derive(Debug)]
struct Own;

impl<'de> Deserialize<'de> for Own {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keys = toml::Table::deserialize(deserializer)?;
        read_table::<Time>(&keys).map(|_| Self).map_err(|what| what.titled("own").carried())
    }
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
enum Tagged {
    A {
        #[serde(rename = "size")]
        _size: f64,
    },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Several {
    #[serde(rename = "own", default)]
    _own: Vec<Own>,
    #[serde(rename = "tagged", default)]
    _tagged: Vec<Tagged>,
    #[serde(rename = "point", default)]
    _point: Option<[f64; 3]>,
}

#[test]
fn what_does_not_fit_is_shown_at_its_key() {
    for (text, words) in [
        ("[[own]]\n[[own]]\nend = 'a'", "3:7: own: invalid type: string \"a\", expected f64\n"),
        ("[[own]]\n[[own]]\nstep = 1", "3:1: own: unknown field `step`; did you mean `steps`? "),
        ("[[tagged]]\nkind = 'A'\nsize = 'a'", "3:8: invalid type: string \"a\", expected f64\n"),
        ("[[tagged]]\nkind = 'A'\nsise = 1", "3:1: unknown field `sise`; did you mean `size`? "),
        ("tagged = [{ kind = 'A' }]", "1:11: missing field `size`\n"),
        ("[[tagged]]\nkind = 'B'", "2:8: unknown variant `B`, expected `A`\n"),
        ("point = [1, 2]", "1:9: invalid length 2, expected an array of length 3\n"),
        ("point = [1, 2, 3, 4]", "1:9: invalid length 4, expected 3\n"),
        ("point = [1, 2, true]", "1:16: invalid type: boolean `true`, expected f64\n"),
    ] {
        let read = Settings::of_text(text).parse::<Several>();
        let message = read.expect_err(text).to_string();
        assert!(message.starts_with(&format!("line {words}")), "{text}: {message}");
    }
}

#[test]
fn what_does_not_fit_in_values_has_keys_and_no_line() {
    for (text, words) in [
        ("[[own]]\n[[own]]\nend = 'a'", "own 2 end: own: invalid type: string \"a\", expected f64"),
        ("point = [1, 2, true]", "point 3: invalid type: boolean `true`, expected f64"),
        (
            "point = [1, 1e31, 0]",
            "point 2: 1e31: numbers are 0, or from 1e-30 to 1e30 in magnitude",
        ),
        ("puffer = '99.0'", "written for puffer 99.0, and this is"),
    ] {
        let read = Settings::of_values(text.parse().unwrap(), Keys::default());
        let message = read.and_then(|values| values.parse::<Several>()).expect_err(text);
        assert!(message.to_string().starts_with(words), "{text}: {message}");
    }
}

#[test]
fn numbers_whose_powers_leave_f64_are_refused() {
    let folder = Folder::new(&[("sim.toml", SCENE)]);
    let parse = |value: &str| {
        let change = format!("time.end={value}");
        let settings = folder.read("sim.toml", &[change.as_str()]).unwrap();
        settings.parse::<toml::Table>().map_err(|error| format!("{error:#}"))
    };
    for value in ["0.0", "-0.0", "1e30", "-1e-30", "1_000.5", "inf", "9223372036854775807"] {
        assert!(parse(value).is_ok(), "{value}: {:?}", parse(value));
    }
    for value in ["1e155", "-1e308", "5e-324", "1.1e30", "[[0.0, 1e200]]", "{ a = -1e-40 }"] {
        let message = parse(value).unwrap_err();
        assert!(message.contains("numbers are 0, or from 1e-30 to 1e30"), "{value}: {message}");
        assert!(message.contains("sim.toml: --set time.end="), "{value}: {message}");
    }
}
