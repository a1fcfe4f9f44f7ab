//! Exports of Instron Bluehill, Zwick testXpert, MTS TestSuite and Shimadzu Trapezium, written from their layouts.

use super::Expected::{Doubted, Logged, Read, Refused};
use super::{Case, case, lines, nominal, stretches};
use durometer::calibrate::Sign;

/// Length \[mm\] and cross-section \[m²\] of the test piece.
const LENGTH: f64 = 33.0;
const SECTION: f64 = 18e-6;

fn travel(l: f64) -> f64 {
    LENGTH * (l - 1.0)
}

fn force(l: f64) -> f64 {
    nominal(l) * SECTION
}

fn dimensions(c: Case) -> Case {
    c.with(|choice| {
        for (key, value) in [("gauge_length", "33 mm"), ("width", "6 mm"), ("thickness", "3 mm")] {
            choice.dimensions.set(key, value).expect("a length");
        }
        choice.strain_measurement = Some("extensometer".into());
    })
}

fn cp1252(text: &str) -> Vec<u8> {
    let one = |c: char| match c {
        '€' => 0x80,
        'ε' => panic!("not in Windows-1252"),
        c => u8::try_from(u32::from(c)).expect("Latin-1"),
    };
    text.chars().map(one).collect()
}

fn utf16(text: &str, big: bool, mark: bool) -> Vec<u8> {
    let mark = mark.then_some(0xfeff);
    let bytes = |u: u16| if big { u.to_be_bytes() } else { u.to_le_bytes() };
    mark.into_iter().chain(text.encode_utf16()).flat_map(bytes).collect()
}

pub fn cases() -> Vec<Case> {
    [bluehill(), bluehill_compression(), headers(), testxpert(), test_suite(), trapezium()]
        .into_iter()
        .flatten()
        .collect()
}

fn bluehill() -> Vec<Case> {
    let raw = |head: &str, row: &dyn Fn(usize, f64) -> String| lines(head, &stretches(), row);
    let quoted = |k: usize, l: f64| {
        format!(
            "\"{}\",\"{}\",\"{}\",\"{}\",\"{}\"",
            0.1 * k as f64,
            travel(l),
            force(l),
            100.0 * (l - 1.0),
            1e-6 * nominal(l)
        )
    };
    let units = "\"(s)\",\"(mm)\",\"(N)\",\"(%)\",\"(MPa)\"";
    let block = "\"Specimen label\",\"A1\"\n\"Width\",\"6.00000\",\"mm\"\n\"Thickness\",\"3.00000\",\"mm\"\n\"Rate 1\",\"450\",\"mm/min\"\n\n";
    let results = "Results Table 1\n,Maximum Load (N),Tensile stress at Maximum Load (MPa),Tensile strain at Break (%)\n1,12.5,0.7,430\nMean,12.5,0.7,430\n\nRaw Data\n";
    let names = "\"Time\",\"Extension\",\"Load\",\"Tensile strain (Strain 1)\",\"Tensile stress\"";
    let stacked = |label: &str| {
        format!("Specimen label,{label}\n")
            + &raw("Time (s),Tensile strain (%),Tensile stress (MPa)", &|k, l| {
                format!("{k},{},{}", 100.0 * (l - 1.0), 1e-6 * nominal(l))
            })
    };
    vec![
        case("bluehill, names and units in two lines", &raw(&format!("{block}{names}\n{units}"), &quoted), Read),
        case("bluehill, results above raw data", &raw(&format!("{results}{names}\n{units}"), &quoted), Read),
        case(
            "bluehill, extensometer channel in brackets",
            &raw("Time (s),Tensile strain (Strain 1) [%],Tensile stress (Corrected) [MPa]", &|k, l| {
                format!("{k},{},{}", 100.0 * (l - 1.0), 1e-6 * nominal(l))
            }),
            Read,
        ),
        case(
            "bluehill universal, strain of the crosshead",
            &raw(
                "Time (s),Displacement (mm),Force (N),Tensile strain (Displacement) (mm/mm),Tensile stress (MPa)",
                &|k, l| format!("{k},{},{},{},{}", travel(l), force(l), l - 1.0, 1e-6 * nominal(l)),
            ),
            Doubted(&["crosshead travel"]),
        ),
        dimensions(case(
            "bluehill, extension and load",
            &raw("Time (s),Extension (mm),Load (N)", &|k, l| format!("{k},{},{}", travel(l), force(l))),
            Read,
        )),
        case(
            "bluehill, extension and load without dimensions",
            &raw("Time (s),Extension (mm),Load (N)", &|k, l| format!("{k},{},{}", travel(l), force(l))),
            Refused(&["--gauge-length"]),
        ),
        case(
            "bluehill, two specimens below one another",
            &(stacked("A") + "\n" + &stacked("B")),
            Logged(&["the file holds 2 tables"]),
        ),
        case(
            "bluehill, specimens with other dimensions",
            &("Width,6 mm\n".to_string() + &stacked("A") + "Width,5 mm\n" + &stacked("B")),
            Refused(&["other dimensions of the test piece", "divide the file"]),
        ),
        case(
            "bluehill, bending",
            &raw("Flexure strain (%),Flexure stress (MPa)", &|_, l| format!("{},{}", 100.0 * (l - 1.0), nominal(l))),
            Refused(&["no column of"]),
        ),
    ]
}

/// Lines above the table that name dimensions of jaws, grips and the whole piece, or of the piece after the test.
fn headers() -> Vec<Case> {
    let under = |head: &str| {
        lines(&format!("{head}\nExtension (mm);Load (N)"), &stretches(), |_, l| format!("{};{}", travel(l), force(l)))
    };
    let measured = |c: Case| c.with(|choice| choice.strain_measurement = Some("extensometer".into()));
    let read = |name: &str, head: &str| measured(case(name, &under(head), Read));
    let two = under("Gauge length;33 mm\nWidth 1;6 mm\nWidth 2;6.4 mm\nThickness;3 mm");
    vec![
        read("jaws above the piece", "Gauge length;33 mm\nJaw face width;50 mm\nWidth;6 mm\nThickness;3 mm"),
        read(
            "the piece after the test",
            "Gauge length;33 mm\nFinal width;4 mm\nFinal thickness;2 mm\nWidth;6 mm\nThickness;3 mm",
        ),
        read("the whole piece", "Specimen length;115 mm\nGauge length;33 mm\nWidth;6 mm\nThickness;3 mm"),
        read(
            "the whole piece, overall",
            "Overall specimen length;115 mm\nGage length;33 mm\nWidth;6 mm\nThickness;3 mm",
        ),
        read("grips", "Einspannlänge;65 mm\nMesslänge;33 mm\nProbenbreite;6 mm\nProbendicke;3 mm"),
        read("equal twice", "L0;33 mm\nMesslänge;33,0 mm\nSpecimen width (mm);6\nb0;6 mm\nThickness;3 mm"),
        measured(case(
            "two widths",
            &two,
            Refused(&["the width of the test piece: \"Width 1: 6 mm\"", "\"Width 2: 6.4 mm\"", "pass --width"]),
        )),
        measured(case("two widths and a request", &two, Read))
            .with(|c| c.dimensions.set("width", "6 mm").expect("a length")),
        measured(case(
            "the whole piece alone",
            &under("Specimen length;115 mm\nWidth;6 mm\nThickness;3 mm"),
            Refused(&["--gauge-length"]),
        )),
    ]
}

fn bluehill_compression() -> Vec<Case> {
    let compressed: Vec<f64> = (0..30).map(|k| 1.0 - 0.015 * f64::from(k)).collect();
    let pressed = |head: &str, sign: f64| {
        lines(head, &compressed, |k, l| format!("{k},{},{}", sign * 100.0 * (1.0 - l), -sign * 1e-3 * nominal(l)))
    };
    vec![
        case(
            "bluehill, compression given as positive",
            &pressed("Time (s),Compressive strain (%),Compressive stress (kPa)", 1.0),
            Logged(&["\"Compressive strain (%)\" counts compression as positive (by its name)"]),
        ),
        case(
            "bluehill, compression given as negative",
            &pressed("Time (s),Compressive strain (%),Compressive stress (kPa)", -1.0),
            Logged(&["is negative already"]),
        ),
        case(
            "bluehill, positive compression under names of tension",
            &pressed("Test type,Compression\nTime (s),Strain (%),Stress (kPa)", 1.0),
            Refused(&["the header speaks of compression (\"Test type: Compression\")", "--positive compression"]),
        ),
        case(
            "bluehill, positive compression, as stated",
            &pressed("Test type,Compression\nTime (s),Strain (%),Stress (kPa)", 1.0),
            Logged(&["(as requested); its sign was changed"]),
        )
        .with(|c| c.positive = Some(Sign::Compression)),
    ]
}

fn testxpert() -> Vec<Case> {
    let comma = |x: f64| x.to_string().replace('.', ",");
    let head = "\"Prüfnorm\";\"DIN 53504\"\n\"Probenbreite b0\";\"6,00\";\"mm\"\n\"Probendicke a0\";\"3,00\";\"mm\"\n\"Messlänge\";\"33,0\";\"mm\"\n";
    let raw = |names: &str, units: &str, row: &dyn Fn(f64) -> [f64; 2]| {
        lines(&format!("{head}{names}\n{units}"), &stretches(), |k, l| {
            let [x, y] = row(l);
            format!("{};{};{}", comma(0.1 * k as f64), comma(x), comma(y))
        })
    };
    let travelled = raw("Prüfzeit;Standardweg;Standardkraft", "s;mm;N", &|l| [travel(l), force(l)]);
    let strained = raw("Prüfzeit;Dehnung;Standardkraft", "s;%;N/mm²", &|l| [100.0 * (l - 1.0), 1e-6 * nominal(l)]);
    let measured = |c: Case| c.with(|choice| choice.strain_measurement = Some("extensometer".into()));
    vec![
        measured(case("testxpert, UTF-8", &travelled, Read)),
        measured(case("testxpert, Windows-1252", &travelled, Logged(&["it was read as windows-1252"])).bytes(cp1252)),
        case("testxpert, strain and stress, Windows-1252", &strained, Read).bytes(cp1252),
        case("testxpert, strain and stress, UTF-16", &strained, Read).bytes(|t| utf16(t, false, true)),
        case(
            "testxpert, deformation in per cent",
            &raw("Prüfzeit;Verformung;Nennspannung", "s;%;Mpa", &|l| [100.0 * (l - 1.0), 1e-6 * nominal(l)]),
            Read,
        ),
        case(
            "testxpert, grip separation is no travel",
            &raw("Prüfzeit;Werkzeugabstand;Standardkraft", "s;mm;N", &|l| [travel(l) + 50.0, force(l)]),
            Refused(&["no column of"]),
        ),
        case("testxpert, tabs", &strained.replace(';', "\t"), Read),
        measured(case(
            "testxpert, symbols of dimensions",
            &travelled.replace(head, "L0;33,0;mm\na0;3,00;mm\nb0 [mm];6,00\n"),
            Logged(&["18.000000 mm² (6 mm × 3 mm)", "33"]),
        )),
        measured(case(
            "testxpert, table of results",
            &travelled.replace(head, "\"Nr\";\"L0\";\"S0\"\n\"\";\"mm\";\"mm²\"\n1;33;18\n"),
            Logged(&["18.000000 mm² (as given)"]),
        )),
        measured(case(
            "testxpert, results of specimens with other sections",
            &travelled.replace(head, "\"Nr\";\"L0\";\"S0\"\n\"\";\"mm\";\"mm²\"\n1;33;18\n2;33;17\n"),
            Refused(&["give the undeformed cross-section"]),
        )),
        case(
            "testxpert, characteristic values only",
            "Bruchdehnung;Höchstkraft\n%;N\n430;12,5\n",
            Refused(&["no column of"]),
        ),
        case(
            "testxpert, positive compression",
            &lines("Stauchung;Druckspannung\n%;kPa", &[0.98, 0.95, 0.9, 0.85, 0.8, 0.7, 0.6], |_, l| {
                format!("{};{}", comma(100.0 * (1.0 - l)), comma(-1e-3 * nominal(l)))
            }),
            Logged(&["\"Druckspannung (kPa)\" counts compression as positive"]),
        ),
    ]
}

fn test_suite() -> Vec<Case> {
    let raw = |head: &str, row: &dyn Fn(usize, f64) -> String| lines(head, &stretches(), row);
    let axial = |k: usize, l: f64| format!("{}\t{}\t{}\t{}", 0.1 * k as f64, travel(l), force(l), l - 1.0);
    let head = "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\nTest Name:\tTension\nSection Width:\t6 mm\nThickness:\t3 mm\n\n";
    vec![
        dimensions(case(
            "testsuite, tabs and a line of units",
            &raw(
                &format!("{head}Running Time\tAxial Displacement\tAxial Force\tAxial Strain\nsec\tmm\tN\tmm/mm"),
                &axial,
            ),
            Read,
        )),
        case(
            "testsuite, dimensions of the block",
            &raw(&format!("{head}Time\tAxial Force\tAxial Strain\ns\tN\tmm/mm"), &|k, l| {
                format!("{k}\t{}\t{}", force(l), l - 1.0)
            }),
            Logged(&["6 mm × 3 mm"]),
        ),
        dimensions(case(
            "testsuite, names with units and quotes",
            &raw("\"Crosshead (mm)\",\"Load (lbf)\",\"Time (sec)\"", &|k, l| {
                format!("{},{},{k}", travel(l), force(l) / 4.4482216152605)
            }),
            Read,
        )),
        case(
            "testsuite, extensometer in fractions",
            &raw("Time (s),Load (N),Extensometer (mm/mm),Stress (psi)", &|k, l| {
                format!("{k},{},{},{}", force(l), l - 1.0, nominal(l) / 6894.757293168361)
            }),
            Read,
        ),
    ]
}

fn trapezium() -> Vec<Case> {
    let pair = |l: f64, f: f64| format!("{},{}", travel(l), f);
    let two = |names: &str, units: &str| {
        lines(&format!("\"1 _ 1\",\"\",\"\",\"1 _ 2\",\"\",\"\"\n{names}\n{units}"), &stretches(), |k, l| {
            let t = 0.1 * k as f64;
            format!("{t},{},{t},{}", pair(l, force(l)), pair(l, 2.0 * force(l)))
        })
    };
    let abreast =
        two("\"Time\",\"Stroke\",\"Force\",\"Time\",\"Stroke\",\"Force\"", "\"sec\",\"mm\",\"N\",\"sec\",\"mm\",\"N\"");
    let single =
        lines("\"1 _ 1\",\"\",\"\"\n\"Time\",\"Strain\",\"Stress\"\n\"sec\",\"%\",\"N/mm2\"", &stretches(), |k, l| {
            format!("\"{k}\",\"{}\",\"{}\"", 100.0 * (l - 1.0), 1e-6 * nominal(l))
        });
    let unequal = lines("Strain (%),Stress (kPa),Strain (%),Stress (kPa)", &stretches(), |k, l| {
        let second = format!("{},{}", 100.0 * (l - 1.0), 2e-3 * nominal(l));
        if k < 20 { format!("{},{},{second}", 100.0 * (l - 1.0), 1e-3 * nominal(l)) } else { format!(",,{second}") }
    });
    vec![
        case("trapezium, one specimen", &single, Read),
        case("trapezium, UTF-16 without a mark", &single, Read).bytes(|t| utf16(t, false, false)),
        case("trapezium, UTF-16 of the other order", &single, Read).bytes(|t| utf16(t, true, true)),
        case(
            "trapezium, two specimens side by side",
            &abreast,
            Refused(&[
                "2 tests stand side by side",
                "\"Stroke (mm)\" (#2) with \"Force (N)\" (#3)",
                "--test 1 to --test 2",
            ]),
        ),
        dimensions(case("trapezium, the first one", &abreast, Logged(&["number 1 is read"])))
            .with(|c| c.test = Some(1)),
        dimensions(case("trapezium, the first one by its number", &abreast, Read))
            .with(|c| c.strain = Some("#2".into())),
        case("trapezium, a third one", &abreast, Refused(&["--test 3", "2 stand side by side"]))
            .with(|c| c.test = Some(3)),
        case("a shorter test next to a longer one", &unequal, Logged(&["lines without strain and stress"]))
            .with(|c| c.test = Some(1)),
    ]
}
