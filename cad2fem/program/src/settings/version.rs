//! `puffer = "0.1"` in a file: the version that it was written for.

/// Version of the programs, whose first two numbers are those of the files.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Refuses a file that was written for a later version. An older one is read; keys that have
/// another form today are refused by their readers, with that form.
pub fn check(found: Option<&str>) -> Result<(), String> {
    let text = found.unwrap_or_default();
    let Some(numbers) = numbers(text) else {
        return Err("puffer: expected the version that the file was written for, as \"0.1\"".into());
    };
    if numbers > self::numbers(VERSION).unwrap_or_default() {
        return Err(format!(
            "written for puffer {text}, and this is {VERSION}: take a newer program, or lower the \
             number if the file needs nothing new"
        ));
    }
    Ok(())
}

/// The first two numbers of a version.
fn numbers(version: &str) -> Option<[u32; 2]> {
    let mut parts = version.split('.').map(|part| part.parse().ok());
    Some([parts.next()??, parts.next()??])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_versions_are_refused() {
        let check = |text| check(Some(text));
        assert_eq!(check("0.1"), Ok(()));
        assert_eq!(check("0.0.7"), Ok(()));
        assert_eq!(check(VERSION), Ok(()));
        for later in ["1.0", "0.99"] {
            let message = check(later).expect_err("later");
            assert!(message.contains(&format!("for puffer {later}, and this is 0.")), "{message}");
        }
        for none in ["", "1", "x.1", "0.x"] {
            assert!(check(none).expect_err("no version").contains("expected the version"));
        }
        assert!(super::check(None).is_err());
    }
}
