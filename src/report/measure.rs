//! Widths of texts in the type of the figures, and texts fitted to a width.

use crate::report::canvas::{BELOW, ITALIC, LABEL, RAISED, SMALL};

/// Advance widths from the space to the tilde in Liberation Sans \[1/1000 em\]; Liberation Serif is narrower.
const ADVANCES: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833,
    722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556,
    556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334,
    260, 334, 584,
];
/// Size of raised digits relative to the surrounding type.
pub const RAISED_SIZE: f64 = 0.7;

fn advance(c: char) -> f64 {
    match c {
        ' '..='~' => f64::from(ADVANCES[c as usize - 32]) / 1000.0,
        '·' | '\u{2000}'..='\u{200a}' | '\u{202f}' => 0.28,
        '¹' | '²' | '³' => 0.34,
        '°' => 0.4,
        '…' | '\u{2190}'..='\u{21ff}' => 1.0,
        '№' => 1.1,
        // East Asian characters are as wide as they are high
        '\u{2e80}'..='\u{9fff}' | '\u{ac00}'..='\u{d7af}' | '\u{ff00}'..='\u{ff60}' => 1.0,
        c if c.is_uppercase() => 0.75,
        _ => 0.6,
    }
}

/// Returns the width of a text \[units\].
pub fn width(s: &str, size: i32) -> i32 {
    let (mut ems, mut of) = (0.0, 1.0);
    for c in s.chars() {
        match c {
            _ if c == ITALIC.0 || c == ITALIC.1 => {}
            _ if c == RAISED.0 || c == BELOW.0 => of = RAISED_SIZE,
            _ if c == RAISED.1 || c == BELOW.1 => of = 1.0,
            c => ems += of * advance(c),
        }
    }
    (ems * f64::from(size)).round() as i32
}

/// Returns the width of a text \[mm\].
pub fn width_in_mm(s: &str, size: i32) -> f64 {
    f64::from(width(s, size)) * 25.4 / 720.0
}

/// Returns the text, or its beginning with an ellipsis if it is wider than `room` \[units\].
pub fn shortened(s: &str, size: i32, room: i32) -> String {
    if width(s, size) <= room {
        return s.into();
    }
    let mut out = String::new();
    for c in s.chars() {
        if width(&format!("{out}{c}…"), size) > room {
            break;
        }
        out.push(c);
    }
    format!("{}…", out.trim_end())
}

/// Divides the text at spaces into at most `count` lines; the last line is shortened if the rest is too long.
pub fn wrapped(s: &str, size: i32, room: i32, count: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in s.split(' ') {
        let is_full = lines.len() >= count;
        match lines.last_mut() {
            Some(last) if is_full || width(&format!("{last} {word}"), size) <= room => *last = format!("{last} {word}"),
            _ => lines.push(word.into()),
        }
    }
    lines.into_iter().map(|line| shortened(&line, size, room)).collect()
}

/// Returns the type size and the lines of a heading for this room \[units\]: in label size if it fits, otherwise smaller, then in two lines.
pub fn heading_lines(words: &str, room: i32) -> (i32, Vec<String>) {
    let size = if width(words, LABEL) <= room { LABEL } else { SMALL };
    (size, wrapped(words, size, room, 2))
}

/// Returns the type size and the label of an axis within this room \[units\]: words are shortened, the symbol and the unit after them are kept.
pub fn label_within(label: &str, room: i32) -> (i32, String) {
    let size = if width(label, LABEL) <= room { LABEL } else { SMALL };
    let (words, kept) = symbol_and_unit(label);
    (size, format!("{}{kept}", shortened(words, size, room - width(kept, size))))
}

/// Returns the label of an axis in two lines if its words would be shortened in one.
pub fn label_lines(label: &str, room: i32) -> (i32, Vec<String>) {
    let (size, line) = label_within(label, room);
    let (words, kept) = symbol_and_unit(label);
    let first = wrapped(words, size, room, 2).swap_remove(0);
    match words.strip_prefix(&first).map(str::trim_start) {
        Some(rest) if line != label && !rest.is_empty() => {
            let rest = shortened(rest, size, room - width(kept, size));
            (size, vec![first, format!("{rest}{kept}")])
        }
        _ => (size, vec![line]),
    }
}

/// Splits a label into its words and the symbol and unit after them; several symbols, as in `modulus E (with ρ) [kPa]`, are all kept.
fn symbol_and_unit(label: &str) -> (&str, &str) {
    let unit = label.rfind(" [").unwrap_or(label.len());
    let symbol = label[..unit].find(&format!(" {}", ITALIC.0));
    label.split_at(symbol.unwrap_or(unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::canvas::italic;

    #[test]
    fn texts_fit_into_their_room() {
        let long = "error of the largest displacement of a tip with a long name, own weight";
        for room in [200, 700, 1500, 4000] {
            assert!(width(&shortened(long, SMALL, room), SMALL) <= room);
            let (size, lines) = heading_lines(long, room);
            assert!(lines.len() <= 2 && lines.iter().all(|l| width(l, size) <= room), "{lines:?}");
            let kept = format!(" {} [kPa]", italic("u"));
            let (size, line) = label_within(&format!("{long}{kept}"), room);
            let (small, lines) = label_lines(&format!("{long}{kept}"), room);
            assert!(size == small && lines.len() <= 2);
            for line in lines.iter().chain([&line]) {
                assert!(room < 300 || width(line, size) <= room, "{line}");
            }
            assert!([lines.last(), Some(&line)].iter().all(|l| l.is_some_and(|l| l.ends_with(&kept))), "{lines:?}");
        }
        assert_eq!(shortened("short", SMALL, 1000), "short");
        assert_eq!(heading_lines(long, 1600).1.len(), 2);
        let lines = |label: &str| label_lines(label, 900).1;
        assert_eq!(lines(&format!("reach {} [m]", italic("x"))).len(), 1);
        let [modulus, density] = ["E", "rho"].map(italic);
        let with = format!(" {modulus} (with {density}) [kPa]");
        assert!(label_within(&format!("{long}{with}"), 900).1.ends_with(&with));
        let tip = format!("displacement of the tip of the finger {} [m]", italic("z_tip"));
        assert!(lines(&tip).len() == 2 && lines(&tip).join(" ") == tip, "no word is lost: {:?}", lines(&tip));
        assert_eq!(wrapped("one two", SMALL, 1, 1), ["…"]);
    }
}
