//! Text that is safe to put into a page, whatever it says.

use maud::{Markup, PreEscaped};
use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};
use serde_json::Value;

/// JSON as content of a `script` element, which nothing in it can end.
pub fn script_data(value: &Value) -> Markup {
    // only strings have such a character
    PreEscaped(value.to_string().replace('<', "\\u003c"))
}

/// Markdown as HTML of headings, paragraphs, lists, tables and code; HTML in it is shown as
/// text, and of links and pictures the words.
pub fn markdown(text: &str) -> Markup {
    let safe = |event| match event {
        Event::Html(t) | Event::InlineHtml(t) => Some(Event::Text(t)),
        Event::Start(Tag::Link { .. } | Tag::Image { .. })
        | Event::End(TagEnd::Link | TagEnd::Image) => None,
        Event::Start(Tag::Heading { level, .. }) => {
            let level = below(level);
            Some(Event::Start(Tag::Heading { level, id: None, classes: vec![], attrs: vec![] }))
        }
        Event::End(TagEnd::Heading(level)) => Some(Event::End(TagEnd::Heading(below(level)))),
        Event::Start(Tag::CodeBlock(_)) => Some(Event::Start(Tag::CodeBlock(
            pulldown_cmark::CodeBlockKind::Fenced(CowStr::Borrowed("")),
        ))),
        other => Some(other),
    };
    let mut page = String::new();
    let events = Parser::new_ext(text, Options::ENABLE_TABLES).filter_map(safe);
    html::push_html(&mut page, events);
    PreEscaped(page)
}

/// The page has a title and sections of its own.
fn below(level: HeadingLevel) -> HeadingLevel {
    match level {
        HeadingLevel::H1 => HeadingLevel::H3,
        HeadingLevel::H2 => HeadingLevel::H4,
        HeadingLevel::H3 => HeadingLevel::H5,
        _ => HeadingLevel::H6,
    }
}

/// A number with its unit as people write it: 0.0138 m is 13.8 mm.
pub fn quantity(value: f64, unit: &str) -> String {
    let (factor, unit) = match unit {
        "m" => (1e3, "mm"),
        "m3" | "m³" => (1e6, "mL"),
        "Pa" => (1e-3, "kPa"),
        "rad" => (180.0 / std::f64::consts::PI, "°"),
        "1" => (1.0, ""),
        other => (1.0, other),
    };
    format!("{} {unit}", digits(factor * value)).trim_end().to_owned()
}

/// Four digits that count.
pub fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let order = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&order) {
        return format!("{value:.3e}");
    }
    let decimals = (3.0 - order).max(0.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const HOSTILE: &str = "</script><script>alert(1)</script><img src=x onerror='alert(1)'>\"";

    #[test]
    fn nothing_leaves_its_element() {
        let page = maud::html! { p title=(HOSTILE) { (HOSTILE) } }.into_string();
        assert_eq!(page.matches(['<', '>']).count(), 4, "{page}");
        assert_eq!(page.matches('"').count(), 2, "{page}");
        let data = script_data(&json!({ "name": HOSTILE })).into_string();
        assert!(!data.contains('<'), "{data}");
        let read: Value = serde_json::from_str(&data).expect("still JSON");
        assert_eq!(read["name"], HOSTILE);
    }

    #[test]
    fn markdown_makes_no_elements_but_its_own() {
        let page = markdown(&format!(
            "# A\n\n{HOSTILE}\n\n|a|b|\n|-|-|\n|{HOSTILE}|*x*|\n\n[go](javascript:alert(1)) \
             ![see](http://example.com/a.png)\n\n```\"><b>\n<i>\n```\n"
        ))
        .into_string();
        for tag in ["<script", "<img", "<a", "<b>", "<i>"] {
            assert!(!page.contains(tag), "{tag} in {page}");
        }
        assert!(!page.contains("http") && !page.contains("javascript"), "{page}");
        assert!(page.contains("<h3>A</h3>") && page.contains("<table>"), "{page}");
        assert!(page.contains("go") && page.contains("<em>x</em>"), "{page}");
    }
}
