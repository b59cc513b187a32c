//! Names of several files in one word.

/// Whether a name fits a pattern in which `*` stands for anything.
pub fn fits(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((before, after)) => name.strip_prefix(before).is_some_and(|rest| {
            let ends = rest.char_indices().map(|(i, _)| i).chain([rest.len()]);
            ends.into_iter().any(|i| fits(&rest[i..], after))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_anything() {
        for (pattern, name, meant) in [
            ("face-*.stl", "face-12.stl", true),
            ("face-*.stl", "lid.stl", false),
            ("*", "lid.stl", true),
            ("*-1*.stl", "a-b-12.stl", true),
            ("a*b*c", "abbc", true),
            ("a*b*c", "acb", false),
        ] {
            assert_eq!(fits(name, pattern), meant, "{pattern} {name}");
        }
    }
}
