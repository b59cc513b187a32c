//! What a gmsh script may do. The language of `.geo` scripts runs programs, and reads and writes
//! files; without leave of the user only geometry is made.
//!
//! gmsh runs not the script but what was checked, without its comments: it begins anew in the middle of one where it
//! repeats a loop, and skips what an `If` leaves out without looking at them.

use anyhow::{Result, anyhow, bail};

/// Words that reach outside of the geometry, and what they do (gmsh 4.15, reference manual).
const WORDS: &[(&str, &[&str])] = &[
    (
        "runs programs",
        &[
            "CommandLine",
            "ExternalProcess",
            "NonBlockingSystemCall",
            "OnelabRun",
            "Solver",
            "System",
            "SystemCall",
        ],
    ),
    (
        "reads other files",
        &[
            "FileExists",
            "Include",
            "ListFromFile",
            "Merge",
            "MergeWithBoundingBox",
            "ShapeFromFile",
        ],
    ),
    ("writes files", &["CreateDir", "Print", "Save", "SaveOptions", "SaveSession", "SendToServer"]),
    ("runs a plugin of gmsh, which may read and write files", &["Plugin"]),
    ("reads the environment", &["GetEnv"]),
    ("ends gmsh before the result is read", &["Exit"]),
    ("makes names of commands from text", &["S2N", "StringToName"]),
];

/// The script as it may be run. Words are looked for at the ends of longer ones, and in texts: where gmsh skips what an
/// `If` leaves out, it may begin again in the middle of either.
pub fn without_reach(script: &[u8]) -> Result<Vec<u8>> {
    let script = without_comments(script)?;
    for (line, text) in (1..).zip(script.split(|&b| b == b'\n')) {
        for word in text.split(|b| *b != b'_' && !b.is_ascii_alphanumeric()) {
            if let Some(what) = reach(word) {
                refuse(line, &String::from_utf8_lossy(word), what)?;
            }
        }
    }
    for at in (0..script.len()).filter(|&at| script[at..].starts_with(b"Printf")) {
        if is_redirected(&script[at..]) {
            refuse(line_after(&script[..at]), "Printf(…) >", "writes files")?;
        }
    }
    Ok(script)
}

/// The script with a blank and its line breaks in place of each comment; texts stay.
fn without_comments(script: &[u8]) -> Result<Vec<u8>> {
    let mut left = Vec::with_capacity(script.len());
    let mut rest = script;
    while !rest.is_empty() {
        let length = first(rest).map_err(|what| anyhow!("line {}: {what}", line_after(&left)))?;
        let (token, after) = rest.split_at(length);
        if is_comment(token) {
            left.push(b' ');
            left.extend(token.iter().filter(|&&b| b == b'\n'));
        } else {
            left.extend(token);
        }
        rest = after;
    }
    Ok(left)
}

/// The number of the line that follows.
fn line_after(text: &[u8]) -> usize {
    1 + text.iter().filter(|&&b| b == b'\n').count()
}

/// The length of the comment, text or other byte that is first.
fn first(rest: &[u8]) -> Result<usize, String> {
    let end = |from: usize, end: &[u8]| rest[from..].windows(end.len()).position(|w| w == end);
    Ok(match rest[0] {
        b'/' if rest.starts_with(b"//") => end(0, b"\n").unwrap_or(rest.len()),
        b'/' if rest.starts_with(b"/*") => end(2, b"*/").ok_or("this comment has no end")? + 4,
        quote @ (b'"' | b'\'') => match end(1, &[quote]) {
            Some(inside) if !rest[1..=inside].iter().any(u8::is_ascii_control) => inside + 2,
            _ => return Err("this text has no end, or a line break".into()),
        },
        b if b.is_ascii_control() && !b.is_ascii_whitespace() => {
            return Err(format!("it has the control character {b:#04x}"));
        }
        _ => 1,
    })
}

fn is_comment(token: &[u8]) -> bool {
    token.starts_with(b"//") || token.starts_with(b"/*")
}

fn reach(word: &[u8]) -> Option<&'static str> {
    let ends = |name: &&str| word.ends_with(name.as_bytes());
    let known = WORDS.iter().find(|(_, words)| words.iter().any(&ends));
    let path = word.ends_with(b"FileName") && word != b"CurrentFileName";
    known.map(|&(what, _)| what).or(path.then_some("names a file"))
}

/// Whether a `Printf`, read as gmsh reads it, prints to a file: there is a `>` behind its arguments. One that cannot be
/// read stands in a text, and may do anything.
fn is_redirected(mut rest: &[u8]) -> bool {
    let mut depth = 0;
    while !rest.is_empty() {
        let Ok(length) = first(rest) else { return true };
        match rest[0] {
            b'(' => depth += 1,
            b')' => depth -= 1,
            b'>' if depth <= 0 => return true,
            b';' => return false,
            _ => {}
        }
        rest = &rest[length..];
    }
    false
}

fn refuse(line: usize, word: &str, what: &str) -> Result<()> {
    bail!(
        "line {line}: {word} {what}; a script may only make geometry. Remove it, or give --trust \
         if you trust who wrote the script with all that you may do yourself"
    )
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_reaches_outside_or_cannot_be_read_is_refused_with_its_line() {
        for (command, words) in [
            ("SystemCall \"touch x\";", "SystemCall runs programs"),
            ("Field[1] = ExternalProcess;", "--trust"),
            ("Merge Str(\"other\", \".geo\");", "reads other files"),
            ("CreateDir \"x\";", "writes files"),
            ("Plugin(Crack).Run;", "runs a plugin"),
            ("General.SessionFileName = \"x\";", "names a file"),
            ("Printf(\"%g\", (a)) > \"x\";", "Printf(…) > writes files"),
            ("Printf(\"a\")>>Str(\"x\");", "Printf(…) > writes files"),
            ("Printf(\"; //\") // ;\n > \"x\";", "Printf(…) > writes files"),
            ("a = \" Printf('a') > 'x'; \";", "Printf(…) > writes files"),
            ("EndIfSystemCall 'touch x';", "SystemCall runs programs"),
            ("S2N[\"SystemCall\"] \"touch x\";", "line 3"),
            ("Macro \"Merge\"", "reads other files"),
            ("\0", "control character"),
            ("Printf(\"\n touch\");", "a line break"),
            ("/* Point", "comment has no end"),
            ("Printf('", "text has no end"),
        ] {
            let script = format!("a = 1;\n// Save the day\n{command}\n");
            let message = without_reach(script.as_bytes()).unwrap_err().to_string();
            assert!(message.starts_with("line 3: ") && message.contains(words), "{message}");
        }
    }

    #[test]
    fn geometry_stays_as_it_is_without_comments() {
        let script = "h = DefineNumber[1.5e-3, Name \"h // \"]; // Merge\n/* Include\n */ If (h > .5)\n\
                      a[] = {1:3, 2E3, newp...4};\nPrintf(\"%g > ; \", h > 2);\nEndIf\nMesh.SaveAll = 1;\n";
        let written = String::from_utf8(without_reach(script.as_bytes()).unwrap()).unwrap();
        let plain = script.replace("// Merge", " ").replace("/* Include\n */", " \n");
        assert_eq!(written, plain);
    }
}
