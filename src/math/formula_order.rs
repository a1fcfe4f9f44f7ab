//! The order of operations in formulas, written out with brackets: a sign applies to the power behind it, and powers group from the right, so that
//! `-t^2` is −(t²) and `2^3^2` is 2⁹, as in Python and on paper. The parser behind [`Formula`](super::formula::Formula) takes signs first and powers from the left.

/// A piece of a formula.
#[derive(Clone, Copy, PartialEq)]
enum Token<'a> {
    Number(&'a str),
    /// Of a variable, a constant or a function
    Name(&'a str),
    Symbol(char),
}

/// The formula with its order in brackets; `None` where it has none, because a value or a bracket is missing.
pub fn bracketed(text: &str) -> Option<String> {
    let mut reader = Reader { rest: tokens(text)?, at: 0, depth: 0 };
    let all = reader.sum()?;
    (reader.at == reader.rest.len()).then_some(all)
}

fn tokens(text: &str) -> Option<Vec<Token<'_>>> {
    let mut out = vec![];
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '{' => rest.find('}')? + 1,
            c if c.is_ascii_digit() || c == '.' => number(rest),
            c if is_of_name(c) => rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let (token, behind) = rest.split_at(length);
        out.push(match first {
            c if c.is_ascii_digit() || c == '.' => Token::Number(token),
            c if c == '{' || is_of_name(c) => Token::Name(token),
            c => Token::Symbol(c),
        });
        rest = behind.trim_start();
    }
    Some(out)
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Length of the number with which the text begins: digits with a point, and an exponent where there is a whole one.
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

struct Reader<'a> {
    rest: Vec<Token<'a>>,
    at: usize,
    /// Powers of powers, functions of functions and brackets around this place
    depth: usize,
}

/// Most of them.
const DEEPEST: usize = 200;

impl Reader<'_> {
    /// The next symbol, if it is one of these.
    fn symbol(&mut self, of: &str) -> Option<char> {
        match self.rest.get(self.at) {
            Some(Token::Symbol(c)) if of.contains(*c) => {
                self.at += 1;
                Some(*c)
            }
            _ => None,
        }
    }

    /// Values between `+ - * / %`, whose order is that of the parser.
    fn sum(&mut self) -> Option<String> {
        let mut out = self.signed()?;
        while let Some(operator) = self.symbol("+-*/%") {
            out += &format!(" {operator} {}", self.signed()?);
        }
        Some(out)
    }

    /// Signs and the power behind them.
    fn signed(&mut self) -> Option<String> {
        self.depth += 1;
        let found = if self.depth > DEEPEST { None } else { self.power() };
        self.depth -= 1;
        found
    }

    fn power(&mut self) -> Option<String> {
        let mut signs = String::new();
        while let Some(sign) = self.symbol("+-") {
            signs.push(sign);
        }
        let base = self.operand()?;
        match self.symbol("^") {
            None => Some(signs + &base),
            Some(_) => {
                let power = format!("{base}^({})", self.signed()?);
                Some(if signs.is_empty() { power } else { format!("{signs}({power})") })
            }
        }
    }

    /// A number, a name, a function with what it takes, or a sum in brackets.
    fn operand(&mut self) -> Option<String> {
        if let Some(inner) = self.in_brackets() {
            return inner;
        }
        let token = *self.rest.get(self.at)?;
        self.at += 1;
        match token {
            Token::Symbol(_) => None,
            Token::Number(number) => Some(number.into()),
            Token::Name(name) => match self.in_brackets() {
                Some(inner) => Some(format!("{name}{}", inner?)),
                None if matches!(self.rest.get(self.at), Some(Token::Name(_) | Token::Number(_))) => {
                    Some(format!("{name} {}", self.signed()?))
                }
                None => Some(name.into()),
            },
        }
    }

    /// Sums between commas in brackets, if a bracket opens here.
    fn in_brackets(&mut self) -> Option<Option<String>> {
        self.symbol("(")?;
        Some(self.list().map(|list| format!("({list})")))
    }

    fn list(&mut self) -> Option<String> {
        let mut list = self.sum()?;
        while self.symbol(",").is_some() {
            list += &format!(", {}", self.sum()?);
        }
        self.symbol(")").map(|_| list)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_behind_powers_which_group_from_the_right() {
        for (text, expected) in [
            ("-t^2", "-(t^(2))"),
            ("2^3^2", "2^(3^(2))"),
            ("2^-t^2/3", "2^(-(t^(2))) / 3"),
            ("- -x + 1e-3*-y", "--x + 1e-3 * -y"),
            ("max(-a^2, b) - sin t", "max(-(a^(2)), b) - sin t"),
            ("-sin(t)^2", "-(sin(t)^(2))"),
            ("{my x}^2", "{my x}^(2)"),
        ] {
            assert_eq!(bracketed(text).as_deref(), Some(expected));
        }
        for text in ["", "2 *", "(t", "t)", "2e", "a b c +", "sin()", "2 3"] {
            assert_eq!(bracketed(text), None, "{text}");
        }
    }
}
