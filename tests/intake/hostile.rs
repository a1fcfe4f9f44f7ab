//! Tables that say one thing and hold another: percent, fractions, stretch, positions, compression, rupture, offsets, slack, several tests.

use super::Expected::{Doubted, Logged, Read, Refused};
use super::{Case, case, lines, nominal, stretches, table};
use durometer::calibrate::Cycle;

pub fn cases() -> Vec<Case> {
    [percent(), stretch(), beginning(), rupture(), several(), broken()].into_iter().flatten().collect()
}

/// The table with strains up to `to`.
fn up_to(to: f64, head: &str, row: impl Fn(f64) -> (f64, f64)) -> String {
    let all: Vec<f64> = (0..40).map(|k| 1.0 + to * f64::from(k) / 39.0).collect();
    lines(head, &all, |_, l| {
        let (x, y) = row(l);
        format!("{x},{y}")
    })
}

fn percent() -> Vec<Case> {
    let kpa = |l: f64| 1e-3 * nominal(l);
    let mut found = vec![];
    for to in [3.0, 8.0, 15.0, 19.0] {
        let text = up_to(0.01 * to, "strain,stress (kPa)", |l| (100.0 * (l - 1.0), kpa(l)));
        found.push(case(
            &format!("percent up to {to} without a unit"),
            &text,
            Refused(&["in percent", "--strain-unit %"]),
        ));
        let text = up_to(to, "strain,stress (kPa)", |l| (l - 1.0, kpa(l)));
        found.push(case(&format!("fractions up to {to} without a unit"), &text, Refused(&["--strain-unit 1"])));
        found.push(
            case(&format!("fractions up to {to}, as stated"), &text, Read).with(|c| c.strain_unit = Some("1".into())),
        );
    }
    let text = up_to(2.5, "strain (%),stress (kPa)", |l| (l - 1.0, kpa(l)));
    found.push(case("fractions up to 2.5 under %", &text, Doubted(&["reaches 2.500 %", "--strain-unit 1"])));
    let text = up_to(1.5, "strain (%),stress (kPa)", |l| (100.0 * (l - 1.0), kpa(l)));
    let against = Doubted(&["reaches a strain of 150.0000 in the unit 1", "1.5000 in %", "leave --strain-unit out"]);
    found.push(
        case("percent under %, asked for as fractions", &text, against).with(|c| c.strain_unit = Some("1".into())),
    );
    let text = up_to(2.5, "strain (%),stress (kPa)", |l| (l - 1.0, kpa(l)));
    found.push(case("fractions under %, asked for", &text, Read).with(|c| c.strain_unit = Some("1".into())));
    let text = up_to(0.08, "strain (%),stress (kPa)", |l| (100.0 * (l - 1.0), kpa(l)));
    found.push(case("a test up to 8 %", &text, Doubted(&["reaches 8.000 %"])));
    let text = up_to(4.0, "strain (%),true strain,stress (kPa)", |l| (l - 1.0, 0.0))
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let e: f64 = line.split(',').next().and_then(|x| x.parse().ok()).unwrap_or(0.0);
            if k == 0 { format!("{line}\n") } else { format!("{e},{},{}\n", (1.0 + e).ln(), kpa(1.0 + e)) }
        })
        .collect::<String>();
    found.push(case(
        "fractions under %, next to a true strain",
        &text,
        Refused(&["by a factor of about 100", "\"true strain\""]),
    ));
    let agree = text.replacen("strain (%)", "strain", 1);
    found.push(case(
        "fractions next to a true strain",
        &agree,
        Logged(&["holds fractions, as column \"true strain\""]),
    ));
    found.push(case(
        "percent up to 500 without a unit",
        &up_to(5.0, "strain,stress (kPa)", |l| (100.0 * (l - 1.0), kpa(l))),
        Refused(&["in percent"]),
    ));
    found.push(case(
        "strain without a unit up to 0.87",
        &table("strain,stress (kPa)", |l| (l - 1.0, kpa(l))),
        Logged(&["is read in fractions"]),
    ));
    found
}

fn stretch() -> Vec<Case> {
    let kpa = |l: f64| 1e-3 * nominal(l);
    let all = stretches();
    let from = |k: usize, head: &str, row: &dyn Fn(f64) -> f64| {
        lines(head, &all[k..], |_, l| format!("{},{}", row(l), kpa(l)))
    };
    let remedy = Refused(&["as a stretch or a position of the machine does", "--strain-kind stretch"]);
    let same = || Refused(&["--strain-kind stretch"]);
    let zero = || Refused(&["as a strain does", "--strain-kind engineering"]);
    vec![
        case("a strain that is a stretch", &from(0, "strain,stress (kPa)", &|l| l), remedy),
        case("a strain that is a stretch, from 1.09 on", &from(3, "strain,stress (kPa)", &|l| l), same()),
        case("a strain that is a stretch in percent", &from(0, "strain (%),stress (kPa)", &|l| 100.0 * l), same()),
        case(
            "a strain that is a stretch, as stated",
            &from(0, "strain,stress (kPa)", &|l| l),
            Logged(&["is read as stretch as requested"]),
        )
        .with(|c| c.strain_kind = Some("stretch".parse().expect("known"))),
        case("a stretch that is a strain", &from(1, "stretch,stress (kPa)", &|l| l - 1.0), zero()),
        case("a stretch that is a strain up to 3", &up_to(3.0, "stretch,stress (kPa)", |l| (l - 1.0, kpa(l))), zero()),
        case("a stretch in percent", &from(0, "stretch,stress (kPa)", &|l| 100.0 * l), Refused(&["in percent"])),
        case("a position of the machine", &from(0, "Position (mm),stress (kPa)", &|l| 45.0 + 33.0 * (l - 1.0)), same())
            .with(|c| c.dimensions.set("gauge_length", "33 mm").expect("a length")),
        case(
            "a position near the start",
            &from(0, "Position (mm),stress (kPa)", &|l| 4.0 + 33.0 * (l - 1.0)),
            Doubted(&["the piece was slack"]),
        )
        .with(|c| c.dimensions.set("gauge_length", "33 mm").expect("a length")),
        case(
            "stress against the strain",
            &table("strain (%),stress (kPa)", |l| (100.0 * (l - 1.0), -kpa(l))),
            Refused(&["pass --stress-positive compression"]),
        ),
    ]
}

fn beginning() -> Vec<Case> {
    let fine: Vec<f64> = (0..90).map(|k| 1.0 + 0.01 * f64::from(k)).collect();
    let curve = |stress: &dyn Fn(f64) -> f64| lines("stretch,stress (Pa)", &fine, |_, l| format!("{l},{}", stress(l)));
    let slack = |l: f64| nominal((l - 0.03).max(1.0));
    vec![
        case(
            "a force that was not zeroed",
            &curve(&|l| nominal(l) + 2e4),
            Doubted(&["Pa at stretch 1", "the force was not zeroed (--zero N"]),
        ),
        case("a force below zero", &curve(&|l| nominal(l) - 2e4), Doubted(&["extrapolate to -"])),
        case("a slack of 3 %", &curve(&slack), Doubted(&["slack", "(--slack yes)"])),
        case("a slack of 10 %", &curve(&|l| nominal((l - 0.1).max(1.0))), Doubted(&["it was slack", "--slack yes"])),
        case("neither", &curve(&nominal), Read),
        case(
            "compression that was not zeroed",
            &lines("stretch,stress (Pa)", &fine.iter().map(|l| 1.0 - 0.5 * (l - 1.0)).collect::<Vec<_>>(), |_, l| {
                format!("{l},{}", nominal(l) - 5e4)
            }),
            Doubted(&["was not zeroed"]),
        ),
    ]
}

fn rupture() -> Vec<Case> {
    let long: Vec<f64> = (0..80).map(|k| 1.0 + 0.02 * f64::from(k)).collect();
    let torn = |from: usize, rest: f64| {
        lines("stretch,stress (Pa)", &long, move |k, l| format!("{l},{}", if k < from { nominal(l) } else { rest }))
    };
    let said = || Logged(&["uniaxial data points after rupture"]);
    vec![
        case("rows after rupture", &torn(60, 0.0), said()),
        case("one row after rupture", &torn(79, 1500.0), said()),
        case("rows of negative stress after rupture", &torn(70, -800.0), said()),
        case(
            "unloading is no rupture",
            &lines("stretch,stress (Pa)", &[long.clone(), long.iter().rev().copied().collect()].concat(), |_, l| {
                format!("{l},{}", nominal(l))
            }),
            Logged(&["data points of other branches"]),
        ),
    ]
}

fn several() -> Vec<Case> {
    let twice = [stretches(), stretches()].concat();
    let timed = lines("time (s),stretch,stress (Pa)", &twice, |k, l| {
        format!("{},{l},{}", k % 30, nominal(l) * if k < 30 { 1.0 } else { 1.5 })
    });
    let untimed =
        lines("stretch,stress (Pa)", &twice, |k, l| format!("{l},{}", nominal(l) * if k < 30 { 1.0 } else { 1.5 }));
    let again = table("stretch,stress (Pa)", |l| (l, nominal(l)))
        + &table("strain (%),stress (kPa)", |l| (100.0 * (l - 1.0), 1e-3 * nominal(l)));
    let summary = lines("time (s),stretch,stress (Pa)", &stretches(), |k, l| format!("{k},{l},{}", nominal(l)));
    vec![
        case(
            "two tests, one after the other",
            &timed,
            Refused(&["time and stretch start again in line 32", "--cycle"]),
        ),
        case("two tests, the first one as asked", &timed, Read).prepared(|p| p.cycle = Some(Cycle::FirstLoading)),
        case("two tests without time", &untimed, Doubted(&["jumps back", "line 32"])),
        case("other names below", &again, Refused(&["names columns of strain and stress again, and differently"])),
        case("a mean below the data", &(summary.clone() + "Mean,1.4,900000\n"), Logged(&["\"Mean\" is no data point"])),
        case(
            "a word in the column of time",
            &(summary + "broken,1.4,900000\n"),
            Logged(&["\"broken\" is no data point"]),
        ),
    ]
}

fn broken() -> Vec<Case> {
    vec![
        case("an empty file", "", Refused(&["the file is empty"])),
        case("names only", "stretch,stress (Pa)\n", Refused(&["no data below"])),
        case(
            "numbers only",
            "1,0\n1.1,5\n1.2,9\n",
            Refused(&["line 1 holds numbers", "no line above names the columns"]),
        ),
        case(
            "numbers beyond all measure",
            "stretch,stress (MPa)\n1.1,1e308\n1.2,1e300\n",
            Refused(&["beyond 1e30 Pa"]),
        ),
        case("no numbers", "stretch,stress (Pa)\na,b\nc,d\n", Refused(&["no line holds both"])),
        case("fixed widths", "stretch   stress (Pa)\n1.1   5\n1.2   9\n", Refused(&["no column of"])),
    ]
}
