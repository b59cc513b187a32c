//! Expressions in t [s], the rest position x, y, z [m] and named parameters, with
//! their derivatives by position and parameters.
//!
//! Operators + − * / ^ with the usual precedence (−x^2 is −(x^2), ^ groups from
//! the right), parentheses, numbers, `pi`, and the functions of [`FUNCTIONS`](super::FUNCTIONS).
//! Only the branch of `if(c, a, b)` that is chosen is evaluated.
//!
//! Parsers among the libraries that have functions of three arguments have no
//! derivatives, which the adjoint needs. The parser exmex has derivatives, but
//! no such functions.

use std::collections::BTreeMap;

use mesh::Vec3;

use super::jet::Jet;
use super::node::{Node, Unknown};
use super::parser::{FUNCTIONS, Malformed, parse};

/// An expression. Its names have values once [`Self::with`] gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    root: Node,
}

impl Expression {
    /// Reads an expression with parameters. [`Self::with`] refuses functions that nobody knows.
    pub fn open(text: &str) -> Result<Self, Malformed> {
        parse(text).map(|root| Self { text: text.to_owned(), root })
    }

    /// Reads an expression without parameters.
    pub fn parse(text: &str) -> Result<Self, Malformed> {
        Self::open(text)?.with(&BTreeMap::new())
    }

    /// The expression with the values of all its names.
    pub fn with(&self, parameters: &BTreeMap<String, f64>) -> Result<Self, Malformed> {
        let Self { text, mut root } = self.clone();
        root.give(parameters).map_err(|(what, name, at)| {
            let known: Vec<&str> = match what {
                Unknown::Function => FUNCTIONS.iter().map(|f| f.0).collect(),
                Unknown::Name => {
                    let known = ["t", "x", "y", "z", "pi"].into_iter();
                    known.chain(parameters.keys().map(String::as_str)).collect()
                }
            };
            Malformed::unknown_name(&text, what, name, at, &known)
        })?;
        Ok(Self { text, root })
    }

    /// A factor times t.
    pub fn proportional(factor: f64) -> Self {
        let number = if factor < 0.0 {
            Node::Minus(Box::new(Node::Number(-factor)))
        } else {
            Node::Number(factor)
        };
        let root = Node::Binary(b'*', Box::new(number), Box::new(Node::Time));
        Self { text: format!("({factor:e})*t"), root }
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether a parameter without a value occurs.
    pub fn uses(&self, parameter: &str) -> bool {
        self.root.any(&|node| matches!(node, Node::Name { name, .. } if name == parameter))
    }

    /// Whether x, y or z occurs.
    pub fn uses_position(&self) -> bool {
        self.root.any(&|node| matches!(node, Node::Position(_)))
    }

    /// Value and gradient at a position [m] and time [s]; not finite where it
    /// is not defined.
    pub fn at(&self, position: Vec3, time: f64) -> Jet {
        self.root.at(position, time, None)
    }

    /// Derivative by a parameter at a time [s], where the position does not matter.
    pub fn by_parameter(&self, parameter: &str, time: f64) -> f64 {
        self.root.at(Vec3::zeros(), time, Some(parameter)).gradient.x
    }
}

impl Node {
    fn any(&self, holds: &dyn Fn(&Self) -> bool) -> bool {
        holds(self)
            || match self {
                Self::Minus(a) => a.any(holds),
                Self::Binary(_, a, b) => a.any(holds) || b.any(holds),
                Self::Call(_, arguments) => arguments.iter().any(|a| a.any(holds)),
                Self::Number(_)
                | Self::Time
                | Self::Position(_)
                | Self::Name { .. }
                | Self::Parameter { .. } => false,
            }
    }

    /// Gives names their values; the error is a name without a meaning, and where.
    fn give(&mut self, parameters: &BTreeMap<String, f64>) -> Result<(), (Unknown, String, usize)> {
        match self {
            Self::Name { used, name, at } => {
                let value = match used {
                    Unknown::Name => parameters.get(name),
                    Unknown::Function => None,
                };
                let value = *value.ok_or_else(|| (*used, name.clone(), *at))?;
                *self = Self::Parameter { name: std::mem::take(name), value };
                Ok(())
            }
            Self::Minus(a) => a.give(parameters),
            Self::Binary(_, a, b) => a.give(parameters).and_then(|()| b.give(parameters)),
            Self::Call(_, arguments) => arguments.iter_mut().try_for_each(|a| a.give(parameters)),
            Self::Number(_) | Self::Time | Self::Position(_) | Self::Parameter { .. } => Ok(()),
        }
    }

    /// The value and its gradient by position, or in the first component by a
    /// parameter.
    fn at(&self, x: Vec3, t: f64, by: Option<&str>) -> Jet {
        match self {
            Self::Number(value) => Jet::constant(*value),
            Self::Time => Jet::constant(t),
            Self::Position(k) if by.is_none() => Jet::coordinate(x, *k),
            Self::Position(k) => Jet::constant(x[*k]),
            Self::Parameter { name, value } if by == Some(name) => {
                Jet { value: *value, gradient: Vec3::x() }
            }
            Self::Parameter { value, .. } => Jet::constant(*value),
            // it has no value
            Self::Name { .. } => Jet::constant(f64::NAN),
            Self::Minus(a) => -a.at(x, t, by),
            Self::Binary(operator, a, b) => {
                let (a, b) = (a.at(x, t, by), b.at(x, t, by));
                match operator {
                    b'+' => a + b,
                    b'-' => a - b,
                    b'*' => a * b,
                    b'/' => a / b,
                    _ => a.power(b),
                }
            }
            Self::Call(name, arguments) => {
                let a = arguments[0].at(x, t, by);
                match *name {
                    "sin" => a.sin(),
                    "cos" => a.cos(),
                    "exp" => a.exp(),
                    "log" => a.log(),
                    "sqrt" => a.sqrt(),
                    "abs" => a.abs(),
                    "half_smoothstep" => a.half_smoothstep(),
                    "min" => a.smaller(arguments[1].at(x, t, by)),
                    "max" => -(-a).smaller(-arguments[1].at(x, t, by)),
                    // NaN must not choose a branch
                    _ if a.value.is_nan() => a,
                    _ => arguments[if a.value >= 0.0 { 1 } else { 2 }].at(x, t, by),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::taylor::taylor;

    fn value(text: &str) -> f64 {
        Expression::parse(text).expect(text).at(Vec3::new(2.0, 3.0, 5.0), 0.25).value
    }

    #[test]
    fn values_are_those_of_mathematics() {
        for (text, expected) in [
            ("1 + 2*3 - 4/8", 6.5),
            ("-x^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("(-x)^2 * --y", 12.0),
            ("1e3 + 2.5e-1*.5 + 1E+1", 1010.125),
            ("x*y - z*t", 4.75),
            ("sqrt(x*2) + abs(-y) + min(x, y) + max(x, z)", 12.0),
            ("log(exp(z)) + cos(0) + sin(pi/2)", 7.0),
            ("if(t - 0.25, 1, 2) + if(t - 0.3, 10, 20)", 21.0),
            ("half_smoothstep(0.5)", (1.5 - 0.125) / 2.0),
            ("half_smoothstep(7) + half_smoothstep(-7)*3", -2.0),
            // what is not chosen is not evaluated
            ("if(1, 3, log(-1))", 3.0),
        ] {
            assert!((value(text) - expected).abs() < 1e-12, "{text} is {}", value(text));
        }
        for text in ["log(-1)", "1/0", "if(log(-1), 1, 2)", "min(sqrt(-1), 1)", "max(1, 0/0)"] {
            assert!(!value(text).is_finite(), "{text} is {}", value(text));
        }
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        let point = Vec3::new(0.3, 0.7, 0.4);
        let direction = Vec3::new(0.5, -0.8, 0.3);
        for text in [
            "x*y + z/x - 3*z",
            "x^3 + y^z + 2^x",
            "sin(x)*cos(y*z) + exp(-x*y)",
            "log(x + y) + sqrt(z)",
            "abs(x - y) + half_smoothstep(x - y)",
            "min(x*x, y*y)*max(x*x, z*z) + if(x - 1, x, x*y*z)",
        ] {
            let expression = Expression::parse(text).expect(text);
            let along = |e: f64| {
                let value = expression.at(point + e * direction, 0.3).value;
                Ok::<_, std::convert::Infallible>(value)
            };
            let slope = expression.at(point, 0.3).gradient.dot(&direction);
            let Ok(result) = taylor(1e-2, 6, slope, along);
            assert!((result.slope - 2.0).abs() < 0.1, "{text}: {result:?}");
        }
        let linear = Expression::parse("2*x - 3*y + t").expect("sound").at(point, 1.0).gradient;
        assert_eq!(linear, Vec3::new(2.0, -3.0, 0.0));
        // zero to a power has a gradient, too
        let square = Expression::parse("x^2").expect("sound").at(Vec3::zeros(), 0.0);
        assert_eq!((square.value, square.gradient), (0.0, Vec3::zeros()));
    }

    #[test]
    fn parameters_have_values_and_slopes() {
        let text = "peak*half_smoothstep((t - delay)/0.5) + peak^2/(1 + delay)";
        let open = Expression::open(text).expect("sound");
        let at = |peak: f64, delay: f64| {
            let values = [("peak".to_owned(), peak), ("delay".to_owned(), delay)];
            let expression = open.with(&values.into()).expect("both are known");
            let slopes = ["peak", "delay"].map(|p| expression.by_parameter(p, 0.4));
            (expression.at(Vec3::zeros(), 0.4).value, slopes)
        };
        let (_, [by_peak, by_delay]) = at(3.0, 0.1);
        let h = 1e-5;
        let peak = (at(3.0 + h, 0.1).0 - at(3.0 - h, 0.1).0) / (2.0 * h);
        let delay = (at(3.0, 0.1 + h).0 - at(3.0, 0.1 - h).0) / (2.0 * h);
        assert!((by_peak - peak).abs() < 1e-8 * peak.abs(), "{by_peak} {peak}");
        assert!((by_delay - delay).abs() < 1e-8 * delay.abs(), "{by_delay} {delay}");
        assert!(open.uses("peak") && !open.uses("pea"));
        let known = [("peak".to_owned(), 1.0)].into();
        let message = open.with(&known).expect_err("no delay");
        let wanted = "unknown name \"delay\" (known: t, x, y, z, pi, peak), at character 27";
        assert!(message.to_string().ends_with(wanted), "{message}");
    }

    #[test]
    fn slips_are_named_with_their_place() {
        for (text, words, position) in [
            ("20e3*sn(t)", "unknown function \"sn\"", 6),
            ("20e3*q", "unknown name \"q\" (known: t, x, y, z, pi)", 6),
            ("sin + 1", "unknown name \"sin\"", 1),
            ("t(3)", "unknown function \"t\"", 1),
            ("1 + ", "it ends where a value is needed", 5),
            ("", "it ends where a value is needed", 1),
            ("2 t", "'t' where it should end", 3),
            (
                "10 kPa",
                "\"kPa\" is no part of a value: values are in pascals, so multiply by 1e3",
                4,
            ),
            ("3 mm", "values are in metres, so multiply by 1e-3", 3),
            ("(1 + 2", "it ends where ')' is needed", 7),
            ("min(1)", "min has 1 arguments, needs 2", 1),
            ("3*if(1,2)", "if has 2 arguments, needs 3", 3),
            ("1.2.3", "1.2.3 is not a number", 1),
            ("1 + * 2", "'*' where a value is needed", 5),
            ("t; 1", "';' where it should end", 2),
            ("µ", "unknown name \"µ\"", 1),
            ("sin(t 2)", "'2' where ')' is needed", 7),
        ] {
            let message = Expression::parse(text).expect_err(text).to_string();
            let place = format!(", at character {position}");
            assert!(message.contains(words) && message.ends_with(&place), "{message}");
        }
        for deep in ["(".repeat(500), "-".repeat(500), "2^".repeat(500)] {
            let message = Expression::parse(&deep).expect_err("deep").to_string();
            assert!(message.contains("nested deeper than 100"));
        }
        let message = Expression::parse(&"1+".repeat(5000)).expect_err("long").to_string();
        assert!(message.contains("longer than 1000 characters"));
    }
}
