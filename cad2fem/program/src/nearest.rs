//! What somebody may have meant.

/// Words at least as similar as this are proposed for an unknown one; 1 is equality
/// (normalised Damerau–Levenshtein similarity).
const SIMILAR: f64 = 0.5;

/// The known word that is most similar to `word`, if any is similar.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let similarity = |known: &str| strsim::normalized_damerau_levenshtein(word, known);
    let rated = known.into_iter().map(|known| (similarity(known), known));
    // of equals the first
    let best = rated.reduce(|best, next| if next.0 > best.0 { next } else { best })?;
    (best.0 >= SIMILAR).then_some(best.1)
}

/// `; did you mean …?` for a word that is not known, or nothing where none is similar.
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or_else(String::new, |known| format!("; did you mean `{known}`?"))
}

/// A message about a word that is not known: `before`, what may be meant, and `list`, which has all that is known;
/// a `separator` is between them where nothing is similar.
pub fn unknown<'a>(
    before: &str,
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
    separator: char,
    list: &str,
) -> String {
    match did_you_mean(word, known) {
        none if none.is_empty() => format!("{before}{separator} {list}"),
        proposal => format!("{before}{proposal} {list}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_words_are_proposed() {
        assert_eq!(nearest("presure", ["on", "pressure", "fill"]), Some("pressure"));
        assert_eq!(nearest("x", ["on", "pressure"]), None);
        assert_eq!(nearest("x", []), None);
        let said =
            |word: &str| unknown("no such tag", word, ["seat", "top"], ';', "it has seat, top");
        assert_eq!(said("seta"), "no such tag; did you mean `seat`? it has seat, top");
        assert_eq!(said("x"), "no such tag; it has seat, top");
    }
}
