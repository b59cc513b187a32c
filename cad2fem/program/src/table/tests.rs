#![allow(clippy::unwrap_used)]

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Range, Table, direction, each, nested};
use crate::schema::{Format, markdown};
use crate::{KeyPath, Misfit, Settings};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Hand {
    Left,
    Right,
}

crate::table! {
    /// How it is closed.
    #[derive(Debug, PartialEq)]
    struct Lid {
        /// Radius of the bolts [m].
        bolt: f64 = 1.7e-3, Range::above(0.0).below(1.0).unit("m");
        /// Gap around the lid [m].
        gap: Option<f64> = None => "that of the printer", Range::POSITIVE.unit("m");
    }
}

crate::table! {
    /// A thread.
    #[derive(Debug)]
    struct Thread {
        /// What reports call it.
        name: String;
        /// Angles along it [°].
        angle: Vec<f64>, Range::between(-90.0, 90.0).unit("°").advice("; 90 is around the axis");
        /// Which way it turns.
        hand: Hand = Hand::Right;
    }
}

crate::table! {
    /// A box.
    #[derive(Debug)]
    struct Case {
        /// How often it is made.
        copies: usize, Range::at_least(1.0);
        /// What points up [1].
        up: Option<[f64; 3]> = None, direction;
        /// Its name.
        #[schemars(schema_with = "names")]
        title: String = "case".into(), known;
        /// Its lid.
        lid: Lid = Lid::default(), nested;
        /// What is wound on it.
        thread: Vec<Thread> = Vec::new(), each(|thread: &Thread| KeyPath::list("thread").named(&thread.name));
    }
}

fn names(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    crate::schema::one_of_these(["case", "chest"])
}

fn known(at: &KeyPath, title: &String) -> Result<(), Misfit> {
    match title.as_str() {
        "case" | "chest" => Ok(()),
        _ => Err(at.clone().says(format!(" = {title:?}: expected case or chest"))),
    }
}

fn read(text: &str) -> Result<Case, String> {
    let settings = Settings::of_text(text);
    let read = |settings: &Settings| {
        let case: Case = settings.parse()?;
        case.check_ranges(&KeyPath::default())?;
        Ok(case)
    };
    settings.checked(read).map_err(|error| format!("{error:#}"))
}

#[test]
fn what_is_left_out_has_its_default() {
    let case = read("copies = 2").unwrap();
    assert_eq!((case.copies, case.title.as_str(), case.up), (2, "case", None));
    assert_eq!(case.lid, Lid { bolt: 1.7e-3, gap: None });
    let text =
        "copies = 1\n[lid]\ngap = 1e-3\n[[thread]]\nname = 'a'\nangle = [3, 4]\nhand = 'left'";
    let case = read(text).unwrap();
    assert_eq!(case.lid, Lid { gap: Some(1e-3), ..Lid::default() });
    assert_eq!((case.thread[0].hand, case.thread[0].angle.len()), (Hand::Left, 2));
    let written = "copies = 1\ntitle = \"case\"\n\n[lid]\nbolt = 0.0017\ngap = 0.001\n\n[[thread]]\nname = \"a\"\nangle = [3.0, 4.0]\nhand = \"left\"\n";
    assert_eq!(toml::to_string(&case).unwrap(), written);
}

#[test]
fn what_does_not_fit_is_refused_where_it_is() {
    let thread = |rest: &str| format!("copies = 1\n[[thread]]\nname = 'a'\n{rest}");
    for (text, message) in [
        ("up = [0, 0, 1]".to_owned(), "missing field `copies`"),
        (thread("hand = 'left'"), "missing field `angle`"),
        (thread("angle = [1]\nhand = 'up'"), "unknown variant `up`"),
        ("copies = 1\nlid = 3".into(), "expected a table"),
        ("copies = 1\n[lid]\nbold = 3".into(), "line 3:1: unknown field `bold`"),
        ("copies = 0".into(), "line 1:1: copies = 0: must be at least 1"),
        ("copies = 1\nup = [0, 0, 0]".into(), "up = [0.0, 0.0, 0.0]: must be a direction"),
        ("copies = 1\ntitle = 'bag'".into(), "line 2:1: title = \"bag\": expected case or chest"),
        (
            "copies = 1\n[lid]\nbolt = 1".into(),
            "line 3:1: [lid]: bolt = 1 m: must be above 0 and below 1 m",
        ),
        ("copies = 1\n[lid]\ngap = -1".into(), "[lid]: gap = -1 m: must be positive and finite"),
        (
            thread("angle = [1, 91]"),
            "line 4:1: [[thread]] \"a\": angle = 91°: must lie between -90 and 90°; 90 is around the axis",
        ),
    ] {
        let found = read(&text).unwrap_err();
        assert!(found.contains(message), "{text}: {found}");
    }
}

#[test]
fn ranges_are_put_into_words() {
    let at = KeyPath::of("x");
    for (range, number, words) in [
        (Range::FINITE, f64::NAN, "x = NaN: must be finite"),
        (Range::NOT_NEGATIVE.unit("N"), -1.0, "x = -1 N: must be finite and not negative"),
        (Range::above(0.0).at_most(1.0), 0.0, "x = 0: must be above 0 and at most 1"),
        (Range::FINITE.below(2.0), 2.0, "x = 2: must be below 2"),
        (Range::above(1.0), f64::INFINITY, "x = inf: must be above 1 and finite"),
    ] {
        assert_eq!(range.admit(&at, number).unwrap_err().to_string(), words);
    }
    assert!(Range::above(0.0).at_most(1.0).contains(1.0) && Range::FINITE.contains(-1e9));
}

#[test]
fn the_schema_and_the_book_come_from_the_rows() {
    let schema = (Format::of::<Case>("case", "case.toml").schema)();
    assert_eq!(schema["else"]["required"], json!(["copies"]));
    assert_eq!(schema["properties"]["title"]["default"], "case");
    assert_eq!(schema["definitions"]["Lid"]["additionalProperties"], false);
    assert_eq!(schema["definitions"]["Thread"]["required"], json!(["name", "angle"]));
    let text = markdown(&schema, false);
    for line in [
        "| `copies` | integer | needed | How often it is made. |",
        "| `title` | `\"case\"` or `\"chest\"` | `\"case\"` | Its name. |",
        "| `bolt` | number | `0.0017` | Radius of the bolts [m]. |",
        "| `gap` | number | that of the printer | Gap around the lid [m]. |",
        "| `hand` | `\"left\"` or `\"right\"` | `\"right\"` | Which way it turns. |",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}
