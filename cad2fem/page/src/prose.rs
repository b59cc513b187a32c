//! Text that is safe to put into a page, whatever it says.

use maud::{Markup, PreEscaped};
use serde_json::Value;

/// JSON as content of a `script` element, which nothing in it can end.
pub fn script_data(value: &Value) -> Markup {
    // only strings have such a character
    PreEscaped(value.to_string().replace('<', "\\u003c"))
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
    fn quantities_have_units_of_daily_life() {
        assert_eq!(quantity(0.013_871_5, "m"), "13.87 mm");
        assert_eq!(quantity(55e3, "Pa"), "55.00 kPa");
        assert_eq!(quantity(2.5, "1"), "2.500");
        assert_eq!(quantity(-3e-9, "N"), "-3.000e-9 N");
        assert_eq!(quantity(0.0, "N"), "0 N");
    }
}
