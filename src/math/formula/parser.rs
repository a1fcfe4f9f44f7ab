//! Parser of formulas. A sign applies to the power that follows it, and powers group from the right, so that `-t^2` is −(t²) and `2^3^2` is 2⁹, as in
//! Python and in mathematics:
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = signed { ("*" | "/") signed }
//! signed  = { "+" | "-" } power
//! power   = operand [ "^" signed ]
//! operand = number | name | name "(" sum { "," sum } ")" | "(" sum ")"
//! ```

use super::functions::{CONSTANTS, FUNCTIONS, Operation, PAIRS};
use super::program::{Program, Step};
use crate::wording::hint;
use std::collections::BTreeSet;

/// Largest nesting depth of brackets and powers.
const DEEPEST: usize = 64;

/// A token of a formula.
#[derive(Clone, Copy, PartialEq)]
enum Token<'a> {
    Number(&'a str),
    /// The name of a variable, a constant or a function
    Name(&'a str),
    Symbol(char),
}

impl Token<'_> {
    fn words(self) -> String {
        match self {
            Self::Number(text) | Self::Name(text) => format!("\"{text}\""),
            Self::Symbol(c) => format!("\"{c}\""),
        }
    }
}

/// Parses a formula into its steps and the names of its variables in alphabetical order; the error message names the part that cannot be read.
pub fn parse(text: &str) -> Result<(Program, Vec<String>), String> {
    let tokens = tokens(text)?;
    let variables = variables(&tokens);
    let mut parser = Parser { tokens, at: 0, depth: 0, variables, steps: vec![] };
    parser.sum()?;
    match parser.tokens.get(parser.at) {
        None => Ok((Program(parser.steps), parser.variables.into_iter().map(String::from).collect())),
        Some(Token::Symbol(')')) => Err("a \")\" has no opening bracket".into()),
        Some(token) => {
            let before = parser.tokens[parser.at - 1].words();
            Err(format!("between {before} and {} there is no operator", token.words()))
        }
    }
}

fn tokens(text: &str) -> Result<Vec<Token<'_>>, String> {
    let mut out = vec![];
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let is_number = first.is_ascii_digit() || first == '.';
        let length = match first {
            '{' => rest.find('}').ok_or("a \"{\" has no \"}\"")? + 1,
            _ if is_number => number(rest),
            c if is_of_name(c) => rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let (token, behind) = rest.split_at(length);
        out.push(match first {
            _ if is_number => Token::Number(token),
            '{' => Token::Name(&token[1..length - 1]),
            c if is_of_name(c) => Token::Name(token),
            c if "+-*/^(),".contains(c) => Token::Symbol(c),
            c => return Err(format!("\"{c}\" has no meaning in it; operators are + - * / ^")),
        });
        rest = behind.trim_start();
    }
    Ok(out)
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Length of the number at the beginning of the text: digits with an optional point, and an exponent if it is complete.
fn number(text: &str) -> usize {
    let digits = |from: usize, more: &str| {
        let is_part = |c: char| c.is_ascii_digit() || more.contains(c);
        text[from..].find(|c| !is_part(c)).map_or(text.len(), |n| from + n)
    };
    let mantissa = digits(0, ".");
    let Some(behind) = text[mantissa..].strip_prefix(['e', 'E']) else { return mantissa };
    let from = text.len() - behind.strip_prefix(['+', '-']).unwrap_or(behind).len();
    let end = digits(from, "");
    if end > from { end } else { mantissa }
}

/// Names that are neither functions nor constants.
fn variables<'a>(tokens: &[Token<'a>]) -> Vec<&'a str> {
    let is_called = |k: usize| tokens.get(k + 1) == Some(&Token::Symbol('('));
    let names = tokens.iter().enumerate().filter_map(|(k, token)| match token {
        Token::Name(name) if !is_called(k) && CONSTANTS.iter().all(|(known, _)| known != name) => Some(*name),
        _ => None,
    });
    names.collect::<BTreeSet<&str>>().into_iter().collect()
}

struct Parser<'a> {
    tokens: Vec<Token<'a>>,
    at: usize,
    /// Number of brackets and powers around this position
    depth: usize,
    variables: Vec<&'a str>,
    steps: Vec<Step>,
}

impl Parser<'_> {
    /// Takes the next symbol if it is one of these.
    fn symbol(&mut self, of: &str) -> Option<char> {
        match self.tokens.get(self.at) {
            Some(Token::Symbol(c)) if of.contains(*c) => {
                self.at += 1;
                Some(*c)
            }
            _ => None,
        }
    }

    fn sum(&mut self) -> Result<(), String> {
        self.product()?;
        while let Some(operator) = self.symbol("+-") {
            self.product()?;
            self.steps.push(Step::Combine(if operator == '+' { Operation::Add } else { Operation::Subtract }));
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), String> {
        self.signed()?;
        while let Some(operator) = self.symbol("*/") {
            self.signed()?;
            self.steps.push(Step::Combine(if operator == '*' { Operation::Multiply } else { Operation::Divide }));
        }
        Ok(())
    }

    fn signed(&mut self) -> Result<(), String> {
        let mut is_negative = false;
        while let Some(sign) = self.symbol("+-") {
            is_negative ^= sign == '-';
        }
        self.operand()?;
        if self.symbol("^").is_some() {
            self.within(Self::signed)?;
            self.steps.push(Step::Combine(Operation::Power));
        }
        if is_negative {
            self.steps.push(Step::Negate);
        }
        Ok(())
    }

    /// Parses a part one level deeper.
    fn within(&mut self, part: fn(&mut Self) -> Result<(), String>) -> Result<(), String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("its brackets and powers are more than {DEEPEST} deep"));
        }
        part(self)?;
        self.depth -= 1;
        Ok(())
    }

    fn operand(&mut self) -> Result<(), String> {
        let before = self.at.checked_sub(1).map(|k| self.tokens[k]);
        let missing = || match before {
            None => "a value is missing at its beginning".to_string(),
            Some(token) => format!("a value is missing after {}", token.words()),
        };
        let token = *self.tokens.get(self.at).ok_or_else(missing)?;
        match token {
            Token::Symbol('(') => {
                self.at += 1;
                self.within(Self::sum)?;
                return self.close();
            }
            Token::Symbol(_) => return Err(missing()),
            Token::Number(text) => {
                let number = text.parse().map_err(|_| format!("\"{text}\" is no number"))?;
                self.steps.push(Step::Number(number));
            }
            Token::Name(name) if self.tokens.get(self.at + 1) == Some(&Token::Symbol('(')) => return self.call(name),
            Token::Name(name) if is_function(name) => return Err(format!("{name} has no argument in brackets")),
            Token::Name(name) => self.steps.push(match CONSTANTS.iter().find(|(known, _)| *known == name) {
                Some((_, value)) => Step::Number(*value),
                None => Step::Variable(self.variables.binary_search(&name).expect("all names were gathered")),
            }),
        }
        self.at += 1;
        Ok(())
    }

    fn close(&mut self) -> Result<(), String> {
        self.symbol(")").map(|_| ()).ok_or_else(|| match self.tokens.get(self.at) {
            Some(Token::Symbol(',')) => "a \",\" is outside of the arguments of a function".into(),
            Some(token) => {
                format!("between {} and {} there is no operator", self.tokens[self.at - 1].words(), token.words())
            }
            None => "a \"(\" has no \")\"".into(),
        })
    }

    /// Parses the call of a function with its arguments in brackets.
    fn call(&mut self, name: &str) -> Result<(), String> {
        let single = FUNCTIONS.iter().find(|function| function.name == name);
        let pair = PAIRS.iter().find(|(known, _)| *known == name);
        if single.is_none() && pair.is_none() {
            let names: Vec<&str> = FUNCTIONS.iter().map(|f| f.name).chain(PAIRS.map(|(name, _)| name)).collect();
            return Err(format!("there is no function {name}; {}", hint(name, &names)));
        }
        self.at += 2;
        self.within(Self::sum)?;
        let mut count = 1;
        while self.symbol(",").is_some() {
            self.within(Self::sum)?;
            count += 1;
            if let Some((_, operation)) = pair {
                self.steps.push(Step::Combine(*operation));
            }
        }
        self.close()?;
        let wanted = match pair {
            None => (count != 1).then_some("one argument"),
            Some((_, Operation::Atan2)) => (count != 2).then_some("two arguments, y and x"),
            Some(_) => (count < 2).then_some("two or more arguments"),
        };
        if let Some(wanted) = wanted {
            return Err(format!("{name} takes {wanted}, not {count}"));
        }
        self.steps.extend(single.map(Step::Apply));
        Ok(())
    }
}

fn is_function(name: &str) -> bool {
    FUNCTIONS.iter().any(|function| function.name == name) || PAIRS.iter().any(|(known, _)| *known == name)
}
