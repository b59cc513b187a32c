//! What somebody may have meant.

/// Words at least as similar as this are proposed for an unknown one; 1 is equality
/// (normalised Damerau–Levenshtein similarity).
const SIMILAR: f64 = 0.5;

/// The known word that is most similar to `word`, if any is similar.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let similarity = |known: &str| strsim::normalized_damerau_levenshtein(word, known);
    let rated = known.into_iter().map(|known| (similarity(known), known));
    // of equals the first
    let best = rated.reduce(|best, next| if next.0 > best.0 { next } else { best })?;
    (best.0 >= SIMILAR).then_some(best.1)
}

/// `; did you mean …?` for a word that is not known, or nothing where none is similar.
#[must_use]
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or_else(String::new, |known| format!("; did you mean `{known}`?"))
}

/// What a message says before it lists what is known.
const LISTS: [&str; 4] = ["expected ", "known are ", "known: ", " has: "];

/// Proposes a name for the unknown one in a message of the form "unknown field `x`, expected one
/// of `a`, `b`", as serde has them, or "unknown tag \"x\"; the mesh has: a, b".
pub(crate) fn with_proposal(message: &str) -> String {
    let Some((before, unknown, after)) = unknown(message) else { return message.to_owned() };
    let proposal = did_you_mean(unknown, known(after));
    if proposal.is_empty() {
        return message.to_owned();
    }
    let after = after.trim_start_matches([',', ':', ';']);
    let gap = if after.is_empty() || after.starts_with(' ') { "" } else { " " };
    format!("{before}{unknown}{}{proposal}{gap}{after}", &message[before.len() - 1..before.len()])
}

/// The names in a list, quoted or separated by commas, each perhaps with its unit.
fn known(message: &str) -> Vec<&str> {
    let list = LISTS.iter().find_map(|before| message.split_once(before));
    let list = list.map_or("", |(_, list)| list.split(['\n', ')']).next().unwrap_or(""));
    if list.contains('`') {
        return list.split('`').skip(1).step_by(2).collect();
    }
    list.split(", ").filter_map(|item| item.split_whitespace().next()).collect()
}

/// What a message calls unknown, with the text before, quote included, and after it.
pub(crate) fn unknown(message: &str) -> Option<(&str, &str, &str)> {
    let start = message.find("unknown ")? + "unknown ".len();
    let kind = message[start..].find(|c: char| !c.is_ascii_alphabetic())?;
    let rest = message[start + kind..].strip_prefix(' ')?;
    let quote = rest.chars().next().filter(|c| ['`', '"'].contains(c))?;
    let begin = start + kind + 2;
    let length = message[begin..].find(quote)?;
    let end = begin + length;
    Some((&message[..begin], &message[begin..end], &message[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_words_are_proposed() {
        assert_eq!(nearest("presure", ["on", "pressure", "fill"]), Some("pressure"));
        assert_eq!(nearest("x", ["on", "pressure"]), None);
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn messages_of_serde_get_a_proposal() {
        for (message, wanted) in [
            (
                "unknown field `degre`, expected one of `mesh`, `degree`",
                "unknown field `degre`; did you mean `degree`? expected one of `mesh`, `degree`",
            ),
            (
                "[[probe]] \"q\": unknown kind `gab`, expected one of `gap`, `angle`\n  a list",
                "[[probe]] \"q\": unknown kind `gab`; did you mean `gap`? expected one of `gap`, \
                 `angle`\n  a list",
            ),
            (
                "unknown tag \"seta\"; the mesh has: seat, top",
                "unknown tag \"seta\"; did you mean `seat`? the mesh has: seat, top",
            ),
            (
                "yeoh: unknown parameter \"c9\"; expected c1 [Pa], d1 [Pa]",
                "yeoh: unknown parameter \"c9\"; did you mean `c1`? expected c1 [Pa], d1 [Pa]",
            ),
            ("unknown variant `q`, expected `left` or `right`", ""),
            ("missing field `name`", ""),
            ("unknown", ""),
        ] {
            let wanted = if wanted.is_empty() { message } else { wanted };
            assert_eq!(with_proposal(message), wanted);
        }
    }
}
