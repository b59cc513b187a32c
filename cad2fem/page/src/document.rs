//! The page from its parts: markup, style, script and data in one file.

use std::path::Path;

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::prose::script_data;
use crate::script::{RESULTS, linked};
use crate::store::Store;
use crate::survey::Survey;
use crate::{Shown, contents, facts, validation};

pub(crate) const STYLE: &str = include_str!("../web/page.css");
pub(crate) const LICENCE: &str = include_str!("../vendor/three/LICENSE");

const CANVAS: &str = "3-D view. Arrow keys turn it, plus and minus zoom, 0 shows all, comma and full stop step, r measures.";

const LAST: &str = "The last state of each simulation and the last shape of each optimisation; the others are left out (--final-only).";

/// Puts a page together, which is to lie at `output`.
pub fn assemble(
    title: &str,
    survey: &Survey,
    shown: Shown,
    data: &Value,
    store: &Store,
    output: &Path,
) -> Result<String> {
    let content = html! {
        header {
            h1 { (title) }
            (facts::headlines(survey)?)
        }
        main {
            @if shown == Shown::Last { p.notice { (LAST) } }
            (viewer())
            (facts::results(survey))
            (validation::all(survey)?)
            (facts::checks(survey)?)
            (facts::casting(survey)?)
            (contents::links(survey, output)?)
            (facts::pictures(&survey.pictures)?)
            (facts::provenance(survey)?)
            (about())
        }
    };
    Ok(page(title, STYLE, &content, data, store, RESULTS))
}

/// A page of some content with a style, data and a script, of which `main` is the main module.
pub(crate) fn page(
    title: &str,
    style: &str,
    content: &Markup,
    data: &Value,
    store: &Store,
    main: &str,
) -> String {
    let script = linked(main);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy(&script));
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(style)) }
            }
            body {
                (content)
                script type="application/json" id="data" { (script_data(data)) }
                @for (i, blob) in store.blobs.iter().enumerate() {
                    script type="application/octet-stream" id={ "blob-" (i) } { (blob) }
                }
                script type="module" { (PreEscaped(&script)) }
            }
        }
    };
    page.into_string()
}

/// What scripts fill: the 3-D view and the charts.
fn viewer() -> Markup {
    html! {
        noscript {
            p.notice { "Without scripts there is no 3-D view; everything else is below." }
        }
        p.notice #notice hidden {}
        section #viewer hidden aria-label="3-D view" {
            div #stage.keyed {
                canvas tabindex="0" aria-label=(CANVAS) {}
                svg #over aria-hidden="true" {}
                button #grip type="button" hidden role="slider" aria-label="place of the cut"
                    aria-valuemin="0" aria-valuemax="100" { "↔" }
                output #said {}
                div #names {}
                div #legend {}
                svg #axes viewBox="-50 -50 100 100" aria-hidden="true" {}
                div #scale aria-hidden="true" { span {} }
                div #views.row {}
                p #loading { "loading" }
            }
            form #panel {}
        }
        section #history hidden { h2 { "History of the optimisation" } }
        section #path hidden { h2 { "Path" } }
        section #response hidden { h2 { "Response" } }
    }
}

fn about() -> Markup {
    html! {
        section #about {
            h2 { "About this page" }
            p {
                "Made by " code { "cad2fem report" }
                ". It is one file and asks no server for anything. Keys in the 3-D view: arrows turn, "
                kbd { "+" } " and " kbd { "−" } " zoom, " kbd { "0" } " shows all, " kbd { "," } " and "
                kbd { "." } " go to the step before and after, " kbd { "r" } " measures between two points that are clicked, or set in the middle by " kbd { "Enter" } ". The round handle drags the cut. Numbers in the 3-D view have 16 bits of \
                their range."
            }
            details {
                summary { "licence of three.js 0.170.0, which draws the 3-D view" }
                pre { (LICENCE) }
            }
        }
    }
}

/// What the browser may do for this page: run this one script, and show pictures that are in the
/// page. It asks no server for anything, and makes no markup of texts.
fn policy(script: &str) -> String {
    let hash = STANDARD.encode(Sha256::digest(script));
    format!(
        "default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'; img-src data:; \
         base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'; trusted-types 'none'"
    )
}
