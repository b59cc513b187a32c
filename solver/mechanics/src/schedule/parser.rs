//! From the text of an expression to its terms, by recursive descent.

use super::node::{Node, Unknown};

/// Names and numbers of arguments.
pub const FUNCTIONS: [(&str, usize); 10] = [
    ("sin", 1),
    ("cos", 1),
    ("exp", 1),
    ("log", 1),
    ("sqrt", 1),
    ("abs", 1),
    ("half_smoothstep", 1),
    ("min", 2),
    ("max", 2),
    ("if", 3),
];

/// Deepest nesting of parentheses and operators, far from the end of the stack.
const DEEPEST: usize = 100;
/// Longest text [characters]; sums are as deep as they are long.
const LONGEST: usize = 1000;

/// What is wrong with the text of an expression, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{}\": {what}, at character {position}", shortened(text))]
pub struct Malformed {
    text: String,
    what: String,
    /// From 1.
    position: usize,
    unknown: Option<UnknownName>,
}

/// A name that an expression may not have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The name.
    pub name: String,
    /// Names that it may have.
    pub known: Vec<String>,
}

fn shortened(text: &str) -> String {
    let start: String = text.chars().take(80).collect();
    if start.len() < text.len() { start + "…" } else { start }
}

/// The terms of an expression.
pub(super) fn parse(text: &str) -> Result<Node, Malformed> {
    let characters: Vec<char> = text.chars().collect();
    let mut parser = Parser { text, characters: &characters, next: 0, depth: 0 };
    if characters.len() > LONGEST {
        parser.next = LONGEST;
        return Err(parser.malformed(format!("longer than {LONGEST} characters")));
    }
    let root = parser.sum()?;
    match parser.peek() {
        None => Ok(root),
        Some(c) => Err(parser.malformed(match unit(&characters[parser.next..]) {
            Some((unit, [value, of])) => format!(
                "\"{unit}\" is no part of a value: values are in {of}, so multiply by {value}"
            ),
            None => format!("'{c}' where it should end"),
        })),
    }
}

/// Units that people write after a number, each with what it is in that of the SI.
const UNITS: [(&[&str], [&str; 2]); 12] = [
    (&["Pa"], ["1", "pascals"]),
    (&["mbar", "hPa"], ["1e2", "pascals"]),
    (&["kPa"], ["1e3", "pascals"]),
    (&["bar"], ["1e5", "pascals"]),
    (&["MPa"], ["1e6", "pascals"]),
    (&["psi"], ["6894.76", "pascals"]),
    (&["um", "µm"], ["1e-6", "metres"]),
    (&["mm"], ["1e-3", "metres"]),
    (&["cm"], ["1e-2", "metres"]),
    (&["ml", "mL"], ["1e-6", "cubic metres"]),
    (&["ms"], ["1e-3", "seconds"]),
    (&["mN"], ["1e-3", "newtons"]),
];

/// The unit that the rest of a text is.
fn unit(rest: &[char]) -> Option<(String, [&'static str; 2])> {
    let rest: String = rest.iter().collect();
    let rest = rest.trim();
    let (_, meaning) = UNITS.iter().find(|(names, _)| names.contains(&rest))?;
    Some((rest.to_owned(), *meaning))
}

struct Parser<'a> {
    text: &'a str,
    characters: &'a [char],
    next: usize,
    depth: usize,
}

impl Malformed {
    /// A name that nothing explains, at a character from 0.
    pub(super) fn unknown_name(
        text: &str,
        used: Unknown,
        name: String,
        at: usize,
        known: &[&str],
    ) -> Self {
        let used = match used {
            Unknown::Name => "name",
            Unknown::Function => "function",
        };
        let what = format!("unknown {used} \"{name}\" (known: {})", known.join(", "));
        let known = known.iter().map(|&k| k.to_owned()).collect();
        let unknown = Some(UnknownName { name, known });
        Self { text: text.to_owned(), what, position: at + 1, unknown }
    }

    /// The name that nothing explains, if that is what is wrong.
    pub fn unknown(&self) -> Option<&UnknownName> {
        self.unknown.as_ref()
    }
}

/// What a name means by itself, if anything.
fn constant(name: &str) -> Option<Node> {
    Some(match name {
        "t" => Node::Time,
        "x" => Node::Position(0),
        "y" => Node::Position(1),
        "z" => Node::Position(2),
        "pi" => Node::Number(std::f64::consts::PI),
        _ => return None,
    })
}

/// Whether a name may be given to a parameter.
pub fn is_free_name(name: &str) -> bool {
    let letter = |c: char| c.is_alphabetic() || c == '_';
    name.starts_with(letter)
        && name.chars().all(|c| letter(c) || c.is_numeric())
        && constant(name).is_none()
        && FUNCTIONS.iter().all(|f| f.0 != name)
}

impl Parser<'_> {
    fn malformed(&self, what: String) -> Malformed {
        let (text, position) = (self.text.to_owned(), self.next + 1);
        Malformed { text, what, position, unknown: None }
    }

    /// The next character that is not a blank.
    fn peek(&mut self) -> Option<char> {
        while self.characters.get(self.next).is_some_and(|c| c.is_whitespace()) {
            self.next += 1;
        }
        self.characters.get(self.next).copied()
    }

    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let found = self.peek().filter(|c| wanted.contains(c))?;
        self.next += 1;
        Some(found)
    }

    fn sum(&mut self) -> Result<Node, Malformed> {
        let mut left = self.product()?;
        while let Some(operator) = self.take(&['+', '-']) {
            left = binary(operator, left, self.product()?);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Node, Malformed> {
        let mut left = self.signed()?;
        while let Some(operator) = self.take(&['*', '/']) {
            left = binary(operator, left, self.signed()?);
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<Node, Malformed> {
        if self.depth == DEEPEST {
            return Err(self.malformed(format!("nested deeper than {DEEPEST}")));
        }
        self.depth += 1;
        let node = match self.take(&['+', '-']) {
            Some('-') => Node::Minus(Box::new(self.signed()?)),
            Some(_) => self.signed()?,
            None => self.power()?,
        };
        self.depth -= 1;
        Ok(node)
    }

    fn power(&mut self) -> Result<Node, Malformed> {
        let base = self.atom()?;
        match self.take(&['^']) {
            Some(operator) => Ok(binary(operator, base, self.signed()?)),
            None => Ok(base),
        }
    }

    fn atom(&mut self) -> Result<Node, Malformed> {
        match self.peek() {
            Some('(') => {
                self.next += 1;
                let inner = self.sum()?;
                self.expect(')')?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some(c) => Err(self.malformed(format!("'{c}' where a value is needed"))),
            None => Err(self.malformed("it ends where a value is needed".to_owned())),
        }
    }

    fn expect(&mut self, wanted: char) -> Result<(), Malformed> {
        if self.take(&[wanted]).is_some() {
            return Ok(());
        }
        let found = self.peek().map_or("it ends".to_owned(), |c| format!("'{c}'"));
        Err(self.malformed(format!("{found} where '{wanted}' is needed")))
    }

    fn take_while(&mut self, holds: impl Fn(char) -> bool) -> String {
        let rest = &self.characters[self.next..];
        let found: String = rest.iter().copied().take_while(|c| holds(*c)).collect();
        self.next += found.chars().count();
        found
    }

    fn number(&mut self) -> Result<Node, Malformed> {
        let start = self.next;
        let mut text = self.take_while(|c| c.is_ascii_digit() || c == '.');
        // an exponent, unless it is the name that begins with e
        let rest = &self.characters[self.next..];
        let sign = usize::from(matches!(rest.get(1), Some('+' | '-')));
        let exponent = matches!(rest.first(), Some('e' | 'E'));
        if exponent && rest.get(1 + sign).is_some_and(char::is_ascii_digit) {
            text.extend(&rest[..=sign]);
            self.next += 1 + sign;
            text += &self.take_while(|c| c.is_ascii_digit());
        }
        text.parse().map(Node::Number).map_err(|_| {
            self.next = start;
            self.malformed(format!("{text} is not a number"))
        })
    }

    fn name(&mut self) -> Result<Node, Malformed> {
        let start = self.next;
        let name = self.take_while(|c| c.is_alphanumeric() || c == '_');
        if self.peek() != Some('(') {
            let parameter = || Node::Name { used: Unknown::Name, name: name.clone(), at: start };
            return Ok(constant(&name).unwrap_or_else(parameter));
        }
        let arguments = self.arguments()?;
        let Some(&(known, count)) = FUNCTIONS.iter().find(|f| f.0 == name) else {
            return Ok(Node::Name { used: Unknown::Function, name, at: start });
        };
        if arguments.len() == count {
            return Ok(Node::Call(known, arguments));
        }
        self.next = start;
        Err(self.malformed(format!("{name} has {} arguments, needs {count}", arguments.len())))
    }

    fn arguments(&mut self) -> Result<Vec<Node>, Malformed> {
        self.expect('(')?;
        let mut arguments = vec![self.sum()?];
        while self.take(&[',']).is_some() {
            arguments.push(self.sum()?);
        }
        self.expect(')')?;
        Ok(arguments)
    }
}

fn binary(operator: char, left: Node, right: Node) -> Node {
    // all operators are ASCII
    Node::Binary(operator as u8, Box::new(left), Box::new(right))
}
