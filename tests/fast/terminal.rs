//! Names and texts from files on the terminal.

use tests::chamber;
use tests::workdir::Run;

/// Clears the screen, turns the direction of writing, and asks the terminal for an answer.
const HOSTILE: &str = "a\u{1b}[2J\u{9b}31m\u{202e}\u{7f}\rb";

fn assert_harmless(run: &Run) {
    let acts = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
    for text in [&run.stdout, &run.stderr] {
        assert!(!text.contains(acts), "{text:?}");
    }
    let escaped = "a\\u{1b}[2J\\u{9b}31m\\u{202e}\\u{7f}";
    let said = format!("{}{}", run.stdout, run.stderr);
    assert!(said.contains(escaped), "{said}");
}

#[test]
fn names_cannot_act_on_the_terminal() {
    let dir = chamber::workdir();
    let named = format!("\"{HOSTILE}\"");
    dir.write("named.msh", &dir.text("body.msh").replacen("\"seat\"", &named, 1));
    dir.write("other.toml", &chamber::SIM.replace("body.msh", "named.msh"));
    dir.write("\u{1b}[2J.toml", "x");
    for shown in [dir.run("tagger", "show named.msh"), dir.run("cad2fem", "info named.msh")] {
        shown.assert_good();
        assert_harmless(&shown);
    }
    let refused = dir.solver("simulate other.toml -o out");
    refused.assert_refused(2, &["seat"]);
    assert_harmless(&refused);
    let named = dir.solver("simulate \u{1b}[2J.toml -o out");
    named.assert_refused(2, &["\\u{1b}[2J.toml"]);
    // JSON keeps what it says
    let json = dir.run("cad2fem", "info --json named.msh");
    let value: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(value["tags"][0]["name"], HOSTILE);
}

#[test]
fn long_names_do_not_fill_the_screen() {
    let dir = chamber::workdir();
    let name = "x".repeat(100_000);
    let solid = "unit = \"mm\"\ngrid = 3\n\
        [[solid]]\nname = \"box\"\nshape.box = { center = [0, 0, 0], size = [16, 16, 16] }\n";
    for (code, text, words) in [
        (1, format!("{solid}[[region]]\nname = \"{name}\"\ncavity = true\n"), "is empty"),
        (2, format!("{name} = 1\n"), "unknown field"),
        (2, format!("unit = \"{name}\"\n"), "unit"),
        (2, format!("unit = \"mm\" # {name}\ngrid = \"a\" # {name}\n"), "grid"),
    ] {
        dir.write("model.toml", &text);
        let run = dir.run("cad2fem", "model model.toml -o out");
        run.assert_refused(code, &[words]);
        assert!(run.stderr.len() < 10_000, "{} bytes", run.stderr.len());
    }
}
