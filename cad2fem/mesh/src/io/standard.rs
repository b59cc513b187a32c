//! Standard input and output in place of a file: `stl:-`, with the format that an extension would tell.

use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

use super::{IoError, LARGEST};

/// The format before `:-`, if the path is standard input or output.
fn format(path: &Path) -> Option<&str> {
    let format = path.to_str()?.strip_suffix(":-")?;
    (!format.is_empty() && format.chars().all(|c| c.is_ascii_alphanumeric())).then_some(format)
}

/// Whether a path is standard input or output.
pub fn is_standard(path: &Path) -> Result<bool, IoError> {
    if path == Path::new("-") {
        let message = "standard input and output need a format, as in stl:- or jsonl:-";
        return Err(IoError::content(path, message));
    }
    Ok(format(path).is_some())
}

/// The format that the end of a file's name tells, or what stands before `:-`, in lower case.
pub fn extension(path: &Path) -> String {
    let of_file = || path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    format(path).unwrap_or_else(of_file).to_ascii_lowercase()
}

/// All of standard input, which is read once.
pub fn read_standard() -> io::Result<&'static [u8]> {
    static INPUT: OnceLock<Vec<u8>> = OnceLock::new();
    if let Some(bytes) = INPUT.get() {
        return Ok(bytes);
    }
    let mut bytes = Vec::new();
    if io::stdin().lock().take(LARGEST + 1).read_to_end(&mut bytes)? as u64 > LARGEST {
        return Err(io::Error::other(format!("more than {LARGEST} bytes; no more are read")));
    }
    Ok(INPUT.get_or_init(|| bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_before_the_dash_is_standard() {
        let standard = |path: &str| is_standard(Path::new(path));
        for (path, expected, of) in [
            ("stl:-", true, "stl"),
            ("JSONL:-", true, "jsonl"),
            ("a.Stl", false, "stl"),
            ("./stl:-", false, ""),
            (":-", false, ""),
        ] {
            assert_eq!(standard(path).expect("a path"), expected, "{path}");
            assert_eq!(extension(Path::new(path)), of, "{path}");
        }
        let message = standard("-").expect_err("no format").to_string();
        assert!(message.contains("stl:-"), "{message}");
    }
}
