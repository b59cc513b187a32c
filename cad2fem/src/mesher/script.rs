//! What a gmsh script may do. The language of `.geo` scripts runs programs, and reads and writes
//! files; without leave of the user only geometry is made.
//!
//! The script is not run as it is, but rewritten from the tokens that were checked: without
//! comments, with blanks around words and strings. gmsh jumps to the start of a line when it
//! repeats a loop, and skips what an `If` leaves out without looking at quotes; a rewritten
//! script means the same to it and to us.

use anyhow::{Result, anyhow, bail};

/// Words that reach outside of the geometry, and what they do (gmsh 4.15, reference manual).
const WORDS: &[(&str, &str)] = &[
    ("CommandLine", RUNS),
    ("ExternalProcess", RUNS),
    ("NonBlockingSystemCall", RUNS),
    ("OnelabRun", RUNS),
    ("Solver", RUNS),
    ("System", RUNS),
    ("SystemCall", RUNS),
    ("FileExists", READS),
    ("Include", READS),
    ("ListFromFile", READS),
    ("Merge", READS),
    ("MergeWithBoundingBox", READS),
    ("ShapeFromFile", READS),
    ("CreateDir", WRITES),
    ("Print", WRITES),
    ("Save", WRITES),
    ("SaveOptions", WRITES),
    ("SaveSession", WRITES),
    ("SendToServer", WRITES),
    ("Plugin", "runs a plugin of gmsh, which may read and write files"),
    ("GetEnv", "reads the environment"),
    ("Exit", "ends gmsh before the result is read"),
    ("S2N", NAMES),
    ("StringToName", NAMES),
];
const RUNS: &str = "runs programs";
const READS: &str = "reads other files";
const WRITES: &str = "writes files";
const NAMES: &str = "makes names of commands from text";

/// Options of gmsh that end so are paths.
const PATHS: &str = "FileName";

/// gmsh reads no longer text between quotes [bytes].
const LONGEST_STRING: usize = 1000;

/// More than gmsh swallows after a word where it skips what an `If` leaves out.
const PADDING: &[u8] = b"        ";

/// The script as it may be run.
pub fn without_reach(script: &[u8]) -> Result<Vec<u8>> {
    let tokens = tokens(script)?;
    refuse_reach(&tokens)?;
    Ok(rewritten(&tokens))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Word,
    Number,
    Text,
    Comment,
    Blank,
    Sign,
}

#[derive(Debug)]
struct Token<'a> {
    kind: Kind,
    bytes: &'a [u8],
    line: usize,
}

fn tokens(script: &[u8]) -> Result<Vec<Token<'_>>> {
    let mut found = Vec::new();
    let (mut rest, mut line) = (script, 1);
    while !rest.is_empty() {
        let (kind, length) = first(rest).map_err(|what| anyhow!("line {line}: {what}"))?;
        let (bytes, after) = rest.split_at(length);
        found.push(Token { kind, bytes, line });
        line += bytes.iter().filter(|&&b| b == b'\n').count();
        rest = after;
    }
    Ok(found)
}

/// Kind and length of the first token.
fn first(rest: &[u8]) -> Result<(Kind, usize), String> {
    let run = |holds: fn(&u8) -> bool| rest.iter().take_while(|b| holds(b)).count();
    Ok(match rest[0] {
        b'/' if rest.starts_with(b"//") => (Kind::Comment, run(|&b| b != b'\n')),
        b'/' if rest.starts_with(b"/*") => {
            let end = rest[2..].windows(2).position(|w| w == b"*/");
            (Kind::Comment, end.ok_or("this comment has no end")? + 4)
        }
        quote @ (b'"' | b'\'') => (Kind::Text, text_length(rest, quote)?),
        b' ' | b'\t' | b'\n' | b'\r' | b'\x0c' => (Kind::Blank, 1),
        b'0'..=b'9' | b'.' => (Kind::Number, number_length(rest)),
        b if b.is_ascii_control() => return Err(format!("it has the control character {b:#04x}")),
        b if b == b'_' || b.is_ascii_alphabetic() => {
            (Kind::Word, run(|&b| b == b'_' || b.is_ascii_alphanumeric()))
        }
        _ => (Kind::Sign, 1),
    })
}

fn text_length(rest: &[u8], quote: u8) -> Result<usize, String> {
    let inside = rest[1..].iter().position(|&b| b == quote).ok_or("this text has no end")?;
    if inside > LONGEST_STRING {
        return Err(format!("this text has {inside} bytes, gmsh reads up to {LONGEST_STRING}"));
    }
    if rest[1..=inside].iter().any(u8::is_ascii_control) {
        return Err("this text has a line break or another control character".into());
    }
    Ok(inside + 2)
}

/// Digits, points and an exponent; signs such as `...` go with them.
fn number_length(rest: &[u8]) -> usize {
    let mantissa = rest.iter().take_while(|&&b| b == b'.' || b.is_ascii_digit()).count();
    let exponent = match &rest[mantissa..] {
        [b'e' | b'E', b'+' | b'-', digit, ..] if digit.is_ascii_digit() => 2,
        [b'e' | b'E', digit, ..] if digit.is_ascii_digit() => 1,
        _ => return mantissa,
    };
    let digits = rest[mantissa + exponent..].iter().take_while(|b| b.is_ascii_digit()).count();
    mantissa + exponent + digits
}

fn refuse_reach(tokens: &[Token]) -> Result<()> {
    for (i, token) in tokens.iter().enumerate() {
        let words = match token.kind {
            Kind::Word | Kind::Text => token.bytes,
            _ => continue,
        };
        for word in words.split(|b| *b != b'_' && !b.is_ascii_alphanumeric()) {
            if let Some(what) = reach(word) {
                refuse(token.line, &String::from_utf8_lossy(word), what)?;
            }
        }
        if token.bytes == b"Printf" && redirected(&tokens[i + 1..]) {
            refuse(token.line, "Printf(…) >", WRITES)?;
        }
    }
    Ok(())
}

fn reach(word: &[u8]) -> Option<&'static str> {
    let known = WORDS.iter().find(|(name, _)| name.as_bytes() == word);
    let path = word.ends_with(PATHS.as_bytes()) && word != b"CurrentFileName";
    known.map(|&(_, what)| what).or(path.then_some("names a file"))
}

/// Whether the arguments of a `Printf` are followed by `>` before the statement ends.
fn redirected(after: &[Token]) -> bool {
    let mut depth = 0;
    for token in after.iter().filter(|token| token.kind == Kind::Sign) {
        match token.bytes[0] {
            b'(' => depth += 1,
            b')' => depth -= 1,
            b'>' if depth == 0 => return true,
            b';' => return false,
            _ => {}
        }
    }
    false
}

fn refuse(line: usize, word: &str, what: &str) -> Result<()> {
    bail!(
        "line {line}: {word} {what}; a script may only make geometry. Remove it, or give --trust \
         if you trust who wrote the script with all that you may do yourself"
    )
}

fn rewritten(tokens: &[Token]) -> Vec<u8> {
    let mut script = Vec::new();
    for token in tokens {
        match token.kind {
            Kind::Word => script.extend([token.bytes, PADDING].concat()),
            Kind::Text => script.extend([PADDING, token.bytes].concat()),
            // the lines stay, for the messages of gmsh
            Kind::Comment => {
                let breaks = token.bytes.iter().filter(|&&b| b == b'\n').count();
                script.extend([b" ", "\n".repeat(breaks).as_bytes()].concat());
            }
            Kind::Number | Kind::Blank | Kind::Sign => script.extend(token.bytes),
        }
    }
    script
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn refused(script: &str) -> String {
        without_reach(script.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn commands_that_reach_outside_are_refused_with_their_line() {
        for command in [
            "SystemCall \"touch x\";",
            "NonBlockingSystemCall 'touch x';",
            "OnelabRun(\"a\", \"touch x\");",
            "Field[1] = ExternalProcess;",
            "Include \"other.geo\";",
            "Merge Str(\"other\", \".geo\");",
            "Save \"x.msh\";",
            "Print \"x.png\";",
            "CreateDir \"x\";",
            "Plugin(Crack).Run;",
            "General.SessionFileName = \"x\";",
            "Printf(\"%g\", (a)) > \"x\";",
            "Printf(\"a\")>>Str(\"x\");",
            "S2N[\"SystemCall\"] \"touch x\";",
            "Macro \"Merge\"",
        ] {
            let message = refused(&format!("a = 1;\n// Save the day\n{command}\n"));
            assert!(message.starts_with("line 3: ") && message.contains("--trust"), "{message}");
        }
    }

    #[test]
    fn text_that_gmsh_may_read_otherwise_is_refused() {
        assert!(refused("a = 1;\n\0").contains("line 2: it has the control character"));
        assert!(refused("Printf(\"\n touch\");").contains("line break"));
        assert!(refused("/* Point").contains("comment has no end"));
        assert!(refused("Printf('").contains("text has no end"));
        assert!(refused(&format!("Printf(\"{}\");", "x".repeat(1024))).contains("1024 bytes"));
    }

    #[test]
    fn geometry_keeps_its_meaning_and_its_lines() {
        let script = "h = DefineNumber[1.5e-3, Name \"h\"]; // Merge\n/* Include\n */ If (h > .5)\n\
                      a[] = {1:3, 2E3, newp...4};\nPrintf(\"%g\", h > 2);\nEndIf\nMesh.SaveAll = 1;\n";
        let written = String::from_utf8(without_reach(script.as_bytes()).unwrap()).unwrap();
        assert_eq!(written.lines().count(), script.lines().count());
        let tight = |text: &str| text.split_whitespace().collect::<String>();
        let plain = script.replace("// Merge", "").replace("/* Include\n */", "");
        assert_eq!(tight(&written), tight(&plain));
        assert!(written.contains("1.5e-3") && written.contains("If        "), "{written}");
    }
}
