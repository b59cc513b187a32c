//! Configuration files in TOML.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use mesh::io::read_text;
use serde::de::DeserializeOwned;

/// Reads a TOML file.
///
/// # Errors
/// As for [`read_checked`] and [`parse_toml`].
pub fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T> {
    read_checked(path, parse_toml)
}

/// Reads a text file and hands its text to `parse`, which also checks the values.
///
/// # Errors
/// If the file cannot be read, is not UTF-8, or `parse` fails; the message names the file.
pub fn read_checked<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T>) -> Result<T> {
    parse(&read_text(path)?).with_context(|| path.display().to_string())
}

/// Parses a TOML text.
///
/// # Errors
/// If the text does not fit `T`. The message shows the line and, for types that deny
/// unknown fields, lists the valid keys.
pub fn parse_toml<T: DeserializeOwned>(text: &str) -> Result<T> {
    // the message of `toml` ends with a line break
    toml::from_str(text).map_err(|error| anyhow!("{}", error.to_string().trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only the names matter")]
    struct Mold {
        wall: f64,
        clearance: f64,
    }

    #[test]
    fn an_unknown_key_names_file_line_and_valid_keys() {
        let file = tempfile::Builder::new().suffix(".toml").tempfile().expect("a temporary file");
        std::fs::write(file.path(), "wall = 2.0\nclearence = 0.2\n").expect("it is writable");
        let error = read_toml::<Mold>(file.path()).expect_err("misspelt");
        let message = format!("{error:#}");
        for needed in [".toml", "line 2", "clearence", "`wall`", "`clearance`"] {
            assert!(message.contains(needed), "{needed} is not in: {message}");
        }
        assert!(!message.ends_with('\n'));
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = read_toml::<Mold>(Path::new("/no/such.toml")).expect_err("missing");
        assert!(format!("{error:#}").contains("/no/such.toml"), "{error:#}");
    }
}
