//! Names of sets, as all programs read them.

use std::collections::BTreeSet;

/// Letters of a name at most; CalculiX reads 80.
const LONGEST: usize = 60;

/// Names that differ, whatever the case of their letters.
#[derive(Default)]
pub struct Names(BTreeSet<String>);

impl Names {
    /// A new name of letters, digits and underscores.
    pub fn add(&mut self, kind: &str, name: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let first: String =
            format!("{kind}_").chars().chain(name.chars().map(plain)).take(LONGEST).collect();
        let numbered = (2..).map(|n| format!("{first}_{n}"));
        let mut all = [first.clone()].into_iter().chain(numbered);
        let is_new = |name: &String| self.0.insert(name.to_ascii_uppercase());
        all.find(is_new).unwrap_or(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ_whatever_their_case() {
        let mut names = Names::default();
        assert_eq!(names.add("S", "tip"), "S_tip");
        assert_eq!(names.add("S", "Tip"), "S_Tip_2");
        assert_eq!(names.add("S", "links außen"), "S_links_au_en");
    }
}
