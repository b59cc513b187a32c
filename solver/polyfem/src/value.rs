//! Numbers, expressions and lists over time.
//!
//! Expressions of PolyFEM are those of tinyexpr with some functions more. They
//! are kept, except for names with another meaning here: `e` is
//! exp(1), `ln` is `log`, and time begins at 0.

use anyhow::{Result, anyhow};
use mechanics::schedule::Expression;

use toml::Value;

use super::document::Key;
use super::tables::table;

/// Two times are the same when they differ by less [s].
const SAME_TIME: f64 = 1e-9;

/// When a scene looks at its loads.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    /// Where the scene begins, which becomes t = 0 [s].
    pub start: f64,
    /// Ends of the time steps since then [s]; none in a static scene.
    pub ends: Vec<f64>,
    /// Whether the scene is plane, where z is 0.
    pub planar: bool,
}

/// Whether an amount is the number zero.
pub fn is_zero(amount: &Value) -> bool {
    amount.as_float() == Some(0.0)
}

/// Minus an amount.
pub fn negated(amount: Value) -> Value {
    match amount {
        // 0.0 and not -0.0
        Value::Float(number) => (0.0 - number).into(),
        Value::String(text) => format!("-({text})").into(),
        Value::Array(values) => Value::Array(values.into_iter().map(negated).collect()),
        Value::Table(mut over_time) => {
            let values = over_time.remove("value").map(negated);
            over_time.extend(values.map(|values| ("value".to_owned(), values)));
            over_time.into()
        }
        other => other,
    }
}

/// An amount that may change with time, as a scene of ours has it: a number, an expression in t, x, y and z, or a table of
/// times and values. Theirs is a number, an expression, or a list with one entry per time step or per entry of `times`,
/// the times it is for.
pub fn amount(key: &Key, times: Option<&Key>, clock: &Clock) -> Result<Value> {
    if let Some(text) = key.value.as_str() {
        return match text.trim().parse::<f64>() {
            Ok(number) => Ok(number.into()),
            Err(_) => Ok(expression(key, text, clock)?.into()),
        };
    }
    if !key.value.is_array() {
        return Ok(key.number()?.into());
    }
    if clock.ends.is_empty() {
        return Err(key.wrong("a list over time in a scene without \"time\""));
    }
    let values: Vec<f64> = key.items().iter().map(Key::number).collect::<Result<_>>()?;
    let all = std::iter::once(0.0).chain(clock.ends.iter().copied());
    let Some(times) = times else {
        if values.len() <= clock.ends.len() {
            return Err(key.wrong(&format!(
                "{} values; expected one for the start and each of {} time steps",
                values.len(),
                clock.ends.len()
            )));
        }
        return Ok(over_time(all.zip(values)));
    };
    let listed = times.numbers(values.len())?;
    let row = |t: f64| {
        // as PolyFEM looks it up
        let rounded = ((clock.start + t) * 1e3).round() * 1e-3;
        let place = listed.iter().position(|l| (l - rounded).abs() < SAME_TIME);
        place.map(|i| (t, values[i])).ok_or_else(|| {
            times.wrong(&format!(
                "there is no {rounded} s among its {} times; expected every end of a time step",
                listed.len()
            ))
        })
    };
    Ok(over_time(all.map(row).collect::<Result<Vec<_>>>()?))
}

/// Times and values.
fn over_time(rows: impl IntoIterator<Item = (f64, f64)>) -> Value {
    let (times, values): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
    table([("t", times.into()), ("value", values.into())]).into()
}

/// Values of `dimension` components.
pub fn amounts(
    key: &Key,
    times: Option<&Key>,
    clock: &Clock,
    dimension: usize,
) -> Result<Vec<Value>> {
    let items = key.items();
    if items.len() != dimension || !key.value.is_array() {
        return Err(key.wrong(&format!("expected {dimension} values, one for each axis")));
    }
    items.iter().map(|item| amount(item, times, clock)).collect()
}

/// An expression in our words.
fn expression(key: &Key, text: &str, clock: &Clock) -> Result<String> {
    let wrong = |what: String| key.wrong(&format!("\"{text}\": {what}"));
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut ours = String::new();
    for piece in text.split_inclusive(|c| !is_word(c)) {
        let (name, after) = piece.split_at(piece.find(|c| !is_word(c)).unwrap_or(piece.len()));
        // the exponent may follow a point
        let is_number = name.starts_with(|c: char| c.is_ascii_digit()) || ours.ends_with('.');
        match is_number || name.is_empty() {
            true => ours += name,
            false => ours += &word(name, clock).map_err(wrong)?,
        }
        ours += after;
    }
    let is_sign = |(at, _): (usize, &str)| {
        let before = text[..at].trim_end().chars().next_back();
        before.is_none_or(|c| "(,+-*/^".contains(c))
    };
    let has_sign = text.match_indices('-').any(is_sign);
    if has_sign && text.contains('^') || text.matches('^').count() > 1 {
        return Err(wrong(
            "powers beside a sign or another power group differently there and here; write them \
             as products"
                .to_owned(),
        ));
    }
    Expression::parse(&ours).map_err(|e| anyhow!("{}", wrong(e.to_string())))?;
    Ok(ours)
}

/// A name in our words.
fn word(name: &str, clock: &Clock) -> Result<String, String> {
    Ok(match name {
        "t" if clock.start != 0.0 => format!("(t + {:?})", clock.start),
        "z" if clock.planar => "0".to_owned(),
        "e" => "exp(1)".to_owned(),
        "ln" => "log".to_owned(),
        "log" => return Err("log is decadic there; write ln(...)/ln(10)".to_owned()),
        same => same.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::document::Document;
    use super::*;

    fn read(json: &str, clock: &Clock) -> Result<Value> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.json");
        std::fs::write(&path, json).expect("writable");
        let document = Document::read(&path).expect("sound");
        let root = document.root();
        amount(&root.need("v", "").expect("there"), root.get("times").as_ref(), clock)
    }

    fn at_rest() -> Clock {
        Clock { start: 0.0, ends: vec![0.02, 0.04], planar: false }
    }

    #[test]
    fn signs_are_turned() {
        let turned = |json: &str| negated(read(json, &at_rest()).expect(json));
        let text = turned("{\"v\": \"-2*-t\"}");
        let value = Expression::parse(text.as_str().expect("an expression")).expect("sound");
        assert_eq!(value.at(mesh::Vec3::zeros(), 0.3).value, -0.6);
        assert_eq!(turned("{\"v\": \"-55000\"}").as_float(), Some(55000.0));
        assert_eq!(turned("{\"v\": 0}").to_string(), "0.0");
        let table = over_time([(0.0, -7.0), (0.02, -5.0), (0.04, -3.0)]);
        assert_eq!(turned("{\"v\": [7, 5, 3]}"), table);
    }

    #[test]
    fn what_means_something_else_there_is_rewritten_or_refused() {
        let late = Clock { start: 0.5, planar: true, ..at_rest() };
        let ours = read("{\"v\": \"e*ln(2e3)*t + z*1e-3\"}", &late).expect("known");
        let expected = "exp(1)*log(2e3)*(t + 0.5) + 0*1e-3";
        assert_eq!(ours.as_str(), Some(expected));
        for (text, words) in [
            ("log(t)", "/v: \"log(t)\": log is decadic"),
            ("-t^2", "as products"),
            ("2^3^t", "as products"),
            ("tanh(t)", "unknown function \"tanh\""),
            ("1 +", "where a value is needed"),
        ] {
            let message = read(&format!("{{\"v\": \"{text}\"}}"), &late).expect_err(text);
            assert!(message.to_string().contains(words), "{message}");
        }
        assert!(read("{\"v\": \"(x - 1)^2\"}", &late).is_ok());
    }

    #[test]
    fn lists_are_looked_up_at_the_ends_of_time_steps() {
        let table = over_time([(0.0, 7.0), (0.02, 5.0), (0.04, 3.0)]);
        assert_eq!(read("{\"v\": [7, 5, 3, 1]}", &at_rest()).expect("long enough"), table);
        let timed = r#"{"v": [3, 9, 7, 5], "times": [0.04, 0.03, 0.0, 0.0200000000001]}"#;
        assert_eq!(read(timed, &at_rest()).expect("all there"), table);
        for (json, words) in [
            (r#"{"v": [7, 5]}"#, "2 values; expected one for the start and each of 2"),
            (r#"{"v": [7, 5, 1], "times": [0, 0.02, 0.05]}"#, "/times: there is no 0.04 s among"),
            (
                r#"{"v": [7, 5, 1], "times": [0, 0.02]}"#,
                "/times: found [0,0.02], expected a list of 3",
            ),
            (r#"{"v": true}"#, "/v: found true, expected a number"),
        ] {
            let message = read(json, &at_rest()).expect_err(json).to_string();
            assert!(message.contains(words), "{message}");
        }
        let message = read(r#"{"v": [1]}"#, &Clock::default()).expect_err("static").to_string();
        assert!(message.contains("without \"time\""), "{message}");
    }
}
