//! A table of mold.toml: each of its keys is one row, with its type, default, range and meaning.
//!
//! From the rows come the struct that is read, its defaults, its checks, and the table of keys in the book
//! (`fab keys`).

use mesh::Vec3;

/// A key as it is documented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The name with that of its table, such as `flange.bolt`.
    pub name: &'static str,
    /// The default as it would be written, or where that comes from.
    pub default: &'static str,
    /// What it means, with its unit.
    pub meaning: &'static str,
}

/// Defines a table. Each key is written as
///
/// ```text
/// /// What it means, with its unit.
/// key: type = default => "default in words", range;
/// ```
///
/// where `=> "default in words"` is left out if the default is documented as it is written. `range`
/// is a function of the key's full name and its value, such as [`length`], that returns a message
/// if the value is out of range.
macro_rules! table {
    (
        $(#[doc = $about:literal])+
        $(#[derive($($derive:ident),+)])?
        $name:ident, $prefix:literal {
            $(
                $(#[doc = $doc:literal])+
                $(#[serde($($serde:tt)+)])?
                $(#[schemars($($schemars:tt)+)])?
                $key:ident: $type:ty = $default:expr $(=> $words:literal)?, $range:expr;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema $($(, $derive)+)?)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $( $(#[doc = $doc])+ $(#[serde($($serde)+)])? $(#[schemars($($schemars)+)])? pub $key: $type, )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $( $key: $default, )+ }
            }
        }

        impl $name {
            /// The keys, in order.
            pub const KEYS: &'static [$crate::config::table::Key] = &[$(
                $crate::config::table::Key {
                    name: concat!($prefix, stringify!($key)),
                    default: $crate::config::table::first(&[$($words,)? stringify!($default)]),
                    meaning: concat!($($doc),+),
                },
            )+];

            /// Whether every value lies in its range.
            pub fn check_ranges(&self) -> Result<(), program::Misfit> {
                $(
                    let key = concat!($prefix, stringify!($key));
                    let refused = |what: String| program::KeyPath::of(key).told(what);
                    ($range)(key, &self.$key).map_err(refused)?;
                )+
                Ok(())
            }
        }
    };
}
pub(crate) use table;

/// The first element; `table!` puts a default in words before the default as it is written.
pub const fn first(words: &[&'static str]) -> &'static str {
    words[0]
}

/// A range without limits: any value of the type.
pub fn any<T>(_: &str, _: &T) -> Result<(), String> {
    Ok(())
}

/// A length above 0 and below a metre.
pub fn length(key: &str, length: &f64) -> Result<(), String> {
    match *length > 0.0 && *length < 1.0 {
        true => Ok(()),
        false => {
            Err(format!("{key} is {length}, must be above 0 and below 1 (lengths are metres)"))
        }
    }
}

/// A [`length`], if there is one.
pub fn optional_length(key: &str, value: &Option<f64>) -> Result<(), String> {
    value.as_ref().map_or(Ok(()), |value| length(key, value))
}

/// A ratio above 0.
pub fn ratio(key: &str, ratio: &f64) -> Result<(), String> {
    match *ratio > 0.0 && ratio.is_finite() {
        true => Ok(()),
        false => Err(format!("{key} is {ratio}, must be a ratio above 0")),
    }
}

/// A direction with a length, if there is one.
pub fn optional_direction(key: &str, direction: &Option<[f64; 3]>) -> Result<(), String> {
    let Some(d) = direction else { return Ok(()) };
    let norm = Vec3::from(*d).norm();
    match norm.is_finite() && norm > 1e-9 {
        true => Ok(()),
        false => Err(format!("{key} is {d:?}, must be a direction with a length above 0")),
    }
}

/// Keys as a table in Markdown. Of keys with the same name, as kinds of `[parting]` have them, the
/// first is listed.
pub fn markdown<'a>(keys: impl Iterator<Item = &'a Key>) -> String {
    let mut text = String::from("| key | default | meaning |\n|---|---|---|\n");
    let mut names = std::collections::BTreeSet::new();
    for Key { name, default, meaning } in keys.filter(|key| names.insert(key.name)) {
        // values are set as code, words are not
        let is_value = default.starts_with(|c: char| c.is_ascii_digit() || c == '"');
        let code = if is_value || ["true", "false"].contains(default) { "`" } else { "" };
        text += &format!("| `{name}` | {code}{default}{code} | {} |\n", meaning.trim());
    }
    text
}
