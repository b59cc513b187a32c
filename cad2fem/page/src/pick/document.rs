//! The page from its parts.

use maud::{Markup, html};
use serde_json::Value;

use crate::document::{LICENCE, STYLE, page};
use crate::script::PICK;
use crate::store::Store;

const CANVAS: &str = "The body. Tab goes from face to face, Enter chooses, arrow keys turn.";

/// Keys and what they do.
const KEYS: [(&[&str], &str); 11] = [
    (&["Tab"], "next face; with Shift the one before"),
    (&["Enter"], "choose the face, or give it back"),
    (&["1", "…", "9"], "the tag that clicks go to"),
    (&["N"], "new tag: then type its name, Enter"),
    (&["F", "T", "A"], "a click takes a face, tangent faces, all connected"),
    (&["P"], "a drag paints, or turns again"),
    (&["X"], "see through faces without a tag"),
    (&["L"], "number the faces that are seen"),
    (&["H"], "hide faces that have a tag"),
    (&["←", "→", "↑", "↓", "+", "−", "0"], "turn, zoom, show all"),
    (&["Ctrl Z", "Ctrl Y"], "undo, redo"),
];

/// Puts the page together.
pub fn assemble(title: &str, data: &Value, store: &Store) -> String {
    let style = format!("{STYLE}{}", include_str!("../../web/pick/pick.css"));
    let content = html! {
        header {
            h1 { (title) }
            p #lead { "Click faces, name them, download " code { "tags.toml" } "." }
            div #history.row {
                button #undo type="button" disabled { "↶ undo" }
                button #redo type="button" disabled { "↷ redo" }
            }
        }
        main {
            noscript { p.notice { "This page needs scripts." } }
            p.notice #notice hidden {}
            section #viewer aria-label="Faces of the body" {
                div #stage {
                    canvas tabindex="0" aria-label=(CANVAS) {}
                    div #names {}
                    div #labels aria-hidden="true" {}
                    svg #axes viewBox="-50 -50 100 100" aria-hidden="true" {}
                    div #scale aria-hidden="true" { span {} }
                    div #views.row {}
                    div #tools.row role="toolbar" aria-label="What a click and a drag do" {}
                    output #tip hidden {}
                    output #said aria-live="polite" {}
                    p #loading { "loading" }
                }
                form #panel {}
            }
            (about())
        }
    };
    page(title, &style, &content, data, store, PICK)
}

fn about() -> Markup {
    html! {
        section #about {
            details {
                summary { "Keys" }
                dl #keys {
                    @for (keys, meaning) in KEYS {
                        dt { @for key in keys { kbd { (key) } " " } }
                        dd { (meaning) }
                    }
                }
                p { "Click the body first. Tab beyond the last face leaves it." }
            }
            details {
                summary { "About this page" }
                p {
                    "Made by " code { "cad2fem pick" } ". It is one file and asks no server for \
                     anything. The browser keeps what you choose until you choose again. To go on \
                     from a file, make the page with " code { "--tags tags.toml" } "."
                }
                pre { (LICENCE) }
            }
        }
    }
}
