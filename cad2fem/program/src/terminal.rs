//! What people read on a terminal or in a log. Names and texts from files can neither move the cursor there,
//! nor hide, nor fill the screen.

use std::borrow::Cow;
use std::io::{self, StdoutLock, Write};

/// Longer lines and texts lose their middle [characters, lines].
const LONGEST_LINE: usize = 2000;
const MOST_LINES: usize = 300;

/// A failure to write to standard error cannot be reported and is ignored.
pub fn to_stderr(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", shown(text));
}

/// Standard output for people to read: control characters are escaped. JSON and files go to that of `std`.
pub fn stdout() -> Stdout {
    Stdout(io::stdout().lock())
}

/// [`stdout`].
#[derive(Debug)]
pub struct Stdout(StdoutLock<'static>);

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // what is formatted comes in whole strings
        self.0.write_all(escaped(&String::from_utf8_lossy(bytes)).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// A message as it is shown.
fn shown(text: &str) -> String {
    let lines: Vec<Cow<str>> = text.split('\n').map(shortened).collect();
    if lines.len() <= MOST_LINES {
        return lines.join("\n");
    }
    let (first, last) = (&lines[..MOST_LINES / 2], &lines[lines.len() - MOST_LINES / 2..]);
    format!("{}\n… ({} lines)\n{}", first.join("\n"), lines.len(), last.join("\n"))
}

/// A line; of a long one the beginning and the end.
fn shortened(line: &str) -> Cow<'_, str> {
    let count = line.chars().count();
    if count <= LONGEST_LINE {
        return escaped(line);
    }
    let place = |i: usize| line.char_indices().nth(i).map_or(line.len(), |(at, _)| at);
    let (begin, end) = (&line[..place(LONGEST_LINE / 2)], &line[place(count - LONGEST_LINE / 4)..]);
    format!("{} … ({count} characters) … {}", escaped(begin), escaped(end)).into()
}

/// A text in which what a terminal would act on is written as in Rust: `\u{1b}`.
fn escaped(text: &str) -> Cow<'_, str> {
    if !text.chars().any(acts) {
        return text.into();
    }
    let one = |c: char| if acts(c) { c.escape_unicode().to_string() } else { c.into() };
    text.chars().map(one).collect::<String>().into()
}

/// Whether a terminal acts on a character: control characters (C0, DEL, C1) except newline and tab,
/// and those of Unicode that change the direction of writing or end a line.
fn acts(c: char) -> bool {
    let directs = matches!(c,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    directs || (c.is_control() && c != '\n' && c != '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_act_on_is_escaped() {
        let text = "a\u{1b}[2J\r\u{7f}\u{9b}31m\u{202e}ö\tµm\nnext";
        let expected = "a\\u{1b}[2J\\u{d}\\u{7f}\\u{9b}31m\\u{202e}ö\tµm\nnext";
        assert_eq!(shown(text), expected);
        assert!(matches!(escaped("café, 3 mm²\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn long_texts_lose_their_middle() {
        let name = "é".repeat(100_000);
        let message = shown(&format!("tags.toml: tag \"{name}\" is empty"));
        assert!(message.starts_with("tags.toml: tag \"éé"), "{message}");
        assert!(message.ends_with("éé\" is empty"), "{message}");
        assert!(message.contains(" … (100026 characters) … ") && message.len() < 4000, "{message}");
        let lines = shown(&"line\n".repeat(10_000));
        assert!(lines.contains("… (10001 lines)") && lines.len() < 2000, "{lines}");
        let whole = "x".repeat(LONGEST_LINE);
        assert_eq!(shown(&whole), whole);
    }
}
