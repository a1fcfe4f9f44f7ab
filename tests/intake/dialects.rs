//! Encodings, delimiters, decimal marks, units and names: the same test in many spellings.

use super::Expected::{Doubted, Logged, Read, Refused};
use super::{Case, Expected, case, lines, nominal, stretches, table};

pub fn cases() -> Vec<Case> {
    [units(), marks(), names(), requests()].into_iter().flatten().collect()
}

/// The unit in the name of the stress and of the strain, in its many spellings.
fn units() -> Vec<Case> {
    let mut found = vec![];
    let psi = 6894.757293168361;
    for (unit, pascal) in [
        ("(MPa)", 1e6),
        ("[MPa]", 1e6),
        ("(Mpa)", 1e6),
        ("(MPA)", 1e6),
        ("[N/mm2]", 1e6),
        ("[N/mm^2]", 1e6),
        ("[N/mm²]", 1e6),
        ("(N/mm**2)", 1e6),
        ("in N/mm²", 1e6),
        ("/ kPa", 1e3),
        ("(KPa)", 1e3),
        ("(kN/m2)", 1e3),
        ("(N/m2)", 1.0),
        ("(pa)", 1.0),
        ("(psi)", psi),
        ("(PSI)", psi),
        ("(lbf/in2)", psi),
        ("(ksi)", 1e3 * psi),
        ("(bar)", 1e5),
        ("(kgf/cm2)", 98066.5),
    ] {
        let text = table(&format!("strain (%),nominal stress {unit}"), |l| (100.0 * (l - 1.0), nominal(l) / pascal));
        found.push(case(&format!("stress {unit}"), &text, Read));
    }
    for (unit, fraction) in [
        ("(%)", 0.01),
        ("[percent]", 0.01),
        ("(mm/mm)", 1.0),
        ("(in/in)", 1.0),
        ("(-)", 1.0),
        ("(mm/m)", 1e-3),
        ("(µε)", 1e-6),
    ] {
        let text = table(&format!("Tensile strain {unit},Tensile stress (kPa)"), |l| {
            ((l - 1.0) / fraction, 1e-3 * nominal(l))
        });
        found.push(case(&format!("strain {unit}"), &text, Read));
    }
    for unit in ["(mpa)", "(mPa)", "(V)", "(kips)", "(kg/cm2)", ""] {
        let text = table(&format!("strain (%),nominal stress {unit}"), |l| (100.0 * (l - 1.0), nominal(l)));
        found.push(case(&format!("stress {unit} is refused"), &text, Refused(&["--stress-unit"])));
    }
    let text = table("strain (10^-3),stress (kPa)", |l| (1e3 * (l - 1.0), 1e-3 * nominal(l)));
    found.push(case("an unknown unit of strain", &text, Refused(&["unit \"10^-3\"", "--strain-unit"])));
    found
}

fn marks() -> Vec<Case> {
    let text = table("strain (%),stress (kPa)", |l| (100.0 * (l - 1.0), 1e-3 * nominal(l)));
    let cases = spellings(&text, "strain,stress\n,\n%,kPa").into_iter();
    cases.map(|(name, bytes, expected)| case(name, "", expected).bytes(|_| bytes)).collect()
}

/// A table with decimal points and commas in its many spellings: each gives the same numbers, or is refused with these words. Its first row has a cell `0`, of which the first
/// one is a number. `below`: its names with an empty line and the line of units.
pub fn spellings(text: &str, below: &str) -> Vec<(&'static str, Vec<u8>, Expected)> {
    let (head, rest) = text.split_once('\n').expect("names");
    let (first, rows) = rest.split_once('\n').expect("rows");
    let with_first = |first: &str, text: &str| {
        let own: Vec<&str> = text.splitn(3, '\n').collect();
        format!("{}\n{first}\n{}", own[0], own[2])
    };
    let with_zero = |zero: &str, most: usize, delimiter: &str| {
        let mut left = most;
        let mut cell = |c| {
            let is_changed = c == "0" && left > 0;
            left -= usize::from(is_changed);
            if is_changed { zero } else { c }
        };
        first.split(',').map(&mut cell).collect::<Vec<&str>>().join(delimiter)
    };
    let semicolons = text.replace(',', ";");
    let comma = semicolons.replace('.', ",");
    let utf16 = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let text_of = |text: &str| text.as_bytes().to_vec();
    vec![
        ("semicolons", text_of(&semicolons), Read),
        ("tabs", text_of(&text.replace(',', "\t")), Read),
        ("decimal commas and semicolons", text_of(&comma), Read),
        ("decimal commas and tabs", text_of(&comma.replace(';', "\t")), Read),
        (
            "decimal commas and commas",
            text_of(&comma.replace(';', ",")),
            Refused(&["line 3 has", "cells under", "too many are in lines 4, 5", "export it with ;"]),
        ),
        ("lines end as in Windows", text_of(&text.replace('\n', "\r\n")), Read),
        ("lines end as on old machines", text_of(&text.replace('\n', "\r")), Read),
        ("the line that Excel reads", text_of(&format!("sep=;\n{semicolons}")), Read),
        ("a mark of UTF-8", text_of(&format!("\u{feff}{text}")), Read),
        ("UTF-16", utf16(&format!("\u{feff}{text}")), Read),
        ("empty lines", text_of(&text.replace('\n', "\n\n")), Read),
        ("the line of units after an empty one", text_of(&format!("{below}\n{rest}")), Read),
        ("a minus sign of print", text_of(&with_first(&with_zero("\u{2212}0", usize::MAX, ","), text)), Read),
        (
            "two decimal marks",
            text_of(&with_first(&with_zero("0,0", 1, ";"), &semicolons)),
            Refused(&["line 2 \"0,0\" has the other one"]),
        ),
        ("no text but an Excel workbook", text_of("PK\u{3}\u{4}rest"), Refused(&["Excel workbook", "export the data"])),
        ("zero bytes", text_of(&format!("{head}\0\n{first}\n{rows}")), Refused(&["zero bytes"])),
        (
            "a quotation mark that is not closed",
            text_of(&with_first(&format!("\"{first}"), text)),
            Refused(&["line 2 or above is not closed"]),
        ),
    ]
}

/// N on a section of 18 mm².
fn force(l: f64) -> f64 {
    nominal(l) * 18e-6
}

fn names() -> Vec<Case> {
    let block = "Operator;N. N.\nMaterial;silicone\nWidth: 6 mm\nThickness = 3 mm\n;;\n";
    let semicolon = |head: &str, row: &dyn Fn(f64) -> (f64, f64)| table(head, row).replace(',', ";");
    let by_time = |time: &dyn Fn(usize) -> f64, order: &dyn Fn(usize) -> usize| {
        let all = stretches();
        let shown: Vec<f64> = (0..all.len()).map(|k| all[order(k)]).collect();
        lines("time (s),stretch,nominal stress (Pa)", &shown, |k, l| format!("{},{l},{}", time(order(k)), nominal(l)))
    };
    let labelled = |label: &dyn Fn(usize) -> String| {
        lines("Specimen,stretch,nominal stress (Pa)", &[stretches(), stretches()].concat(), |k, l| {
            format!("{},{l},{}", label(k), nominal(l))
        })
    };
    vec![
        case(
            "metadata above, colons and equal signs",
            &(block.to_string() + &semicolon("strain (%);load (N)", &|l| (100.0 * (l - 1.0), force(l)))),
            Logged(&["6 mm × 3 mm"]),
        ),
        case(
            "German names",
            &semicolon("technische Dehnung [%];Nennspannung [MPa]", &|l| (100.0 * (l - 1.0), 1e-6 * nominal(l))),
            Read,
        ),
        case(
            "French names",
            &semicolon("Déformation (%);Contrainte (MPa)", &|l| (100.0 * (l - 1.0), 1e-6 * nominal(l))),
            Read,
        ),
        case("true strain and stress", &table("true strain,true stress (Pa)", |l| (l.ln(), l * nominal(l))), Read),
        case("stretch", &table("λ,nominal stress (Pa)", |l| (l, nominal(l))), Read),
        case("times out of order", &by_time(&|k| k as f64, &|k| k * 7 % 30), Read),
        case(
            "times that go back over a curve that does not",
            &by_time(&|k| (k % 10) as f64 + 0.1 * k as f64, &|k| k),
            Logged(&["the order was kept"]),
        ),
        case(
            "specimens named in a column",
            &labelled(&|k| if k < 30 { "A".into() } else { "B".into() }),
            Logged(&["each of which is a specimen: A, B"]),
        ),
        case(
            "specimens row by row",
            &labelled(&|k| format!("{}", k % 2)),
            Logged(&["each of which is a specimen: 0, 1"]),
        ),
        case(
            "a number of every row is no specimen",
            &lines("Sample,stretch,nominal stress (Pa)", &stretches(), |k, l| format!("{k},{l},{}", nominal(l))),
            Read,
        ),
    ]
}

/// Requests against the header or instead of it.
fn requests() -> Vec<Case> {
    vec![
        case(
            "a flag against the header",
            &table("strain (%),stress (kPa)", |l| (l - 1.0, 1e-6 * nominal(l))),
            Logged(&["is read in 1 as requested, its name says %", "is read in MPa as requested, its name says kPa"]),
        )
        .with(|c| (c.strain_unit, c.stress_unit) = (Some("1".into()), Some("MPa".into()))),
        case(
            "dimensions against the header",
            &("Width,5 mm\nThickness,3 mm\n".to_string()
                + &table("strain (%),load (N)", |l| (100.0 * (l - 1.0), force(l)))),
            Logged(&["width = 6.000000 mm as requested or by the card, the header says 5.000000 mm"]),
        )
        .with(|c| {
            c.dimensions.set("width", "6 mm").expect("a length");
            c.dimensions.set("thickness", "3 mm").expect("a length");
        }),
        case("columns called by their numbers", &table("a,b", |l| (l, nominal(l))), Read).with(|c| {
            (c.strain, c.stress) = (Some("#1".into()), Some("#2".into()));
            (c.strain_kind, c.stress_unit) = (Some("stretch".parse().expect("known")), Some("Pa".into()));
        }),
        case(
            "no names and no flags",
            &table("1,0", |l| (l, nominal(l))),
            Refused(&["line 1 holds numbers", "--strain-column \"#1\""]),
        ),
        case(
            "no names, and columns called by their numbers",
            table("", |l| (l + 0.01, nominal(l + 0.01))).trim_start(),
            Logged(&["no names of columns; they are taken by their numbers", "\"column 1\" is stretch"]),
        )
        .with(|c| {
            (c.strain, c.stress) = (Some("#1".into()), Some("#2".into()));
            (c.strain_kind, c.stress_unit) = (Some("stretch".parse().expect("known")), Some("Pa".into()));
        }),
        case(
            "a data point at rest",
            &table("stretch,stress (Pa)", |l| (l, nominal(l))),
            Logged(&["data points without strain and stress, which say nothing about a law"]),
        ),
        case(
            "travel of a machine",
            &table("Extension (mm),stress (Pa)", |l| (33.0 * (l - 1.0), nominal(l))),
            Doubted(&["crosshead travel"]),
        )
        .with(|c| c.dimensions.set("gauge_length", "33 mm").expect("a length")),
    ]
}
