//! Widths of texts in Computer Modern, the default typeface of LaTeX.

use super::letters::escape;

/// Advance widths from the space to the tilde in `cmr10`; of its mathematical signs if they replace the character, and of xelatex for the underscore
/// \[1/1000 em\].
const ADVANCES: [u16; 95] = [
    333, 278, 500, 833, 500, 833, 778, 278, 389, 389, 500, 778, 278, 333, 278, 500, 500, 500, 500, 500, 500, 500, 500,
    500, 500, 500, 278, 278, 778, 778, 778, 472, 778, 750, 708, 722, 764, 681, 653, 785, 750, 361, 514, 778, 625, 917,
    750, 778, 681, 778, 736, 556, 722, 750, 750, 1028, 750, 750, 611, 278, 500, 278, 500, 750, 278, 500, 556, 444, 556,
    444, 306, 500, 556, 278, 306, 528, 278, 833, 556, 500, 556, 528, 392, 394, 389, 556, 528, 722, 528, 528, 444, 500,
    278, 500, 500,
];
/// The usual type size \[pt\].
const SIZE: f64 = 10.0;

/// Returns the width of a text as written by [`escape`], in the usual type size \[pt\]; an upper bound for characters outside ASCII.
pub fn width(text: &str) -> f64 {
    SIZE * text.chars().map(advance).sum::<f64>()
}

fn advance(c: char) -> f64 {
    let of_ascii = |c: char| f64::from(ADVANCES[c as usize - 32]) / 1000.0;
    match c {
        ' '..='~' => of_ascii(c),
        c if c.is_whitespace() => of_ascii(' '),
        '·' | '‘' | '’' => 0.28,
        '–' | '“' | '”' => 0.5,
        '¹' | '²' | '³' | '°' | '⁰'..='⁹' | '₀'..='₉' => 0.5,
        c => {
            let set = escape(&c.to_string());
            let is_code_point = set.contains("U+");
            if is_code_point { set.chars().filter(char::is_ascii_graphic).map(of_ascii).sum() } else { 1.1 }
        }
    }
}

/// Largest number of characters of a word; longer words may break anywhere.
const LONGEST_PIECE: usize = 24;

/// Returns the parts of a text between which a line may break, each with the space or character that ends it: at spaces, after hyphens and after the
/// separators of paths and keys, and within words that are too long.
pub fn pieces(text: &str) -> impl Iterator<Item = &str> {
    text.split_inclusive([' ', '-', '/', '_', '=', ',']).flat_map(|piece| {
        let ends = piece.char_indices().map(|(at, _)| at).step_by(LONGEST_PIECE).skip(1).chain([piece.len()]);
        ends.scan(0, |from, to| Some(&piece[std::mem::replace(from, to)..to])).collect::<Vec<_>>()
    })
}

/// Returns the width of the widest of the [`pieces`] of a text \[pt\].
pub fn longest_piece(text: &str) -> f64 {
    pieces(text).map(|piece| width(piece.trim_end())).fold(0.0, f64::max)
}

/// Returns the number of lines of a text set as a paragraph of this width \[pt\].
pub fn lines(text: &str, room: f64) -> usize {
    let (mut lines, mut long) = (1, 0.0);
    for piece in pieces(text) {
        if long > 0.0 && long + width(piece.trim_end()) > room {
            (lines, long) = (lines + 1, 0.0);
        }
        long += width(piece);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_type() {
        assert_eq!(width("0123"), 20.0);
        assert_eq!(width("Wm"), 10.28 + 8.33);
        assert!(width("中") > width("U+4E2D"), "it is printed as its code point");
        assert_eq!(longest_piece("a long-drawn word"), width("drawn"));
    }

    #[test]
    fn a_text_breaks_at_blanks_and_within_paths() {
        let parts: Vec<&str> = pieces("see data/card_1.toml").collect();
        assert_eq!(parts, ["see ", "data/", "card_", "1.toml"]);
        let long = "é".repeat(60);
        assert_eq!(pieces(&long).map(|p| p.chars().count()).collect::<Vec<_>>(), [24, 24, 12]);
        assert_eq!([lines("one two", 100.0), lines("one two", 20.0), lines("", 20.0)], [1, 2, 1]);
    }
}
