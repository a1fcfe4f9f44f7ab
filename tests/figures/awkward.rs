//! Figures of awkward results: long names, many families, numbers of any sign and size, a single point, gaps, letters of any script.

use crate::common::synthetic;
use crate::{LONGEST, attribute, drawings, faults};
use durometer::math::statistics::larger;
use durometer::report::figure::Drawn;
use durometer::report::style::{Style, within};
use durometer::study::analysis::Analysis;
use durometer::study::case_outcome::CaseOutcome;
use durometer::study::kinds::convergence::figures::bodies;
use durometer::study::kinds::robustness::analysis::{JudgedCase, RobustnessFindings};
use durometer::study::kinds::robustness::figures::{failed, matrix};
use durometer::study::kinds::validation::budget::Contribution;
use durometer::study::kinds::validation::figures::{budget, score};
use durometer::study::kinds::validation::findings::{Prediction, ValidationFindings};
use durometer::study::report;
use durometer::study::store::record::{Role, StoredCase, StudyRecord};
use durometer::study::store::results::Results;
use durometer::study::store::skin::Skin;

type Study = (StudyRecord, Vec<StoredCase>);

const LONG: &str = "the silicone finger with a very long name that no journal would print in a column";
const SCRIPTS: &str = "Prüfkörper № 5, ψ̄ → 試験片";
const STYLES: [&str; 2] = ["default", "one-column"];

fn style(name: &str) -> Style {
    Style::named(name, None, None).expect("a style")
}

/// The study with the names of its families replaced, also those of its cases.
fn with_families(mut study: Study, name: impl Fn(&str) -> String) -> Study {
    for family in &mut study.0.families {
        let old = family.name.clone();
        family.name = name(&old);
        for case in study.1.iter_mut().filter(|c| c.record.family == old) {
            case.record.family.clone_from(&family.name);
        }
    }
    study
}

/// The study with every quantity, variant and member in these words.
fn with_words(mut study: Study, words: &str) -> Study {
    for quantity in study.0.quantities.values_mut().flatten() {
        quantity.label = format!("{words} {}", quantity.label);
    }
    study.0.labels.values_mut().for_each(|label| *label = format!("{words}, {label}"));
    for case in &mut study.1 {
        case.record.effects.iter_mut().for_each(|e| e.name = format!("{}_{}", words.replace(' ', "_"), e.name));
    }
    study
}

/// The study with more families of the same element as the family `element`.
fn with_more_families(mut study: Study, more: usize) -> Study {
    let of: Vec<StoredCase> = study.1.iter().filter(|c| c.record.family == "element").cloned().collect();
    let family = study.0.families.iter().find(|f| f.name == "element").expect("a family").clone();
    for k in 0..more {
        let name = format!("element-{k}");
        let mut own = family.clone();
        own.name.clone_from(&name);
        own.cases = own.cases.iter().map(|id| id.replacen("element", &name, 1)).collect();
        study.0.families.push(own);
        study.1.extend(of.iter().cloned().map(|mut case| {
            case.record.id = case.record.id.replacen("element", &name, 1);
            case.record.family.clone_from(&name);
            case
        }));
    }
    study
}

/// The study with the tension multiplied.
fn scaled(mut study: Study, factor: f64) -> Study {
    for case in &mut study.1 {
        let name = "cable_tension_N";
        case.series.columns.get_mut(name).expect("a column").iter_mut().for_each(|v| *v *= factor);
        let probe = case.record.probes.get_mut(name).expect("a probe");
        (probe.peak, probe.last) = (factor * probe.peak, factor * probe.last);
    }
    study
}

/// The study with the first case of each variant only.
fn of_one_case(mut study: Study) -> Study {
    study.0.families.truncate(1);
    study.0.families[0].cases.truncate(2);
    study.1.retain(|c| study.0.families[0].cases.contains(&c.record.id));
    study
}

/// The study with a gap of values that are no numbers in every curve.
fn with_gaps(mut study: Study) -> Study {
    for case in &mut study.1 {
        let n = case.series.t_s.len();
        for column in case.series.columns.values_mut() {
            column[n / 3..n / 2].fill(f64::NAN);
        }
    }
    study
}

#[test]
fn figures_of_awkward_studies_are_legible() {
    let plain = synthetic::study;
    let studies: [(&str, Study); 9] = [
        ("long names", with_words(with_families(plain(), |name| format!("{name} of {LONG}")), LONG)),
        ("scripts", with_words(with_families(plain(), |name| format!("{name} {SCRIPTS}")), SCRIPTS)),
        ("twelve families", with_more_families(plain(), 6)),
        ("negative", scaled(plain(), -1.0)),
        ("tiny", scaled(plain(), 1e-9)),
        ("huge", scaled(plain(), 1e9)),
        ("one case", of_one_case(plain())),
        ("constant", scaled(plain(), 0.0)),
        ("gaps", with_gaps(plain())),
    ];
    let mut wrong = vec![];
    for (name, study) in &studies {
        let dir = tempfile::tempdir().expect("a folder");
        synthetic::store(dir.path(), study);
        for of in STYLES {
            within(style(of), || report::write_report(dir.path())).unwrap_or_else(|e| panic!("{name}: {e}"));
            let drawn = drawings(dir.path());
            assert!(!drawn.is_empty(), "{name}: no figure");
            wrong.extend(
                drawn.iter().flat_map(|(figure, svg)| faults(&format!("{name}, {of}, {figure}"), svg, style(of))),
            );
        }
    }
    assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
}

/// Predictions of several records and quantities, whose numbers have every size.
fn predictions(records: usize, quantities: usize, words: &str) -> Analysis<ValidationFindings> {
    let one = |(record, quantity): (usize, usize)| {
        let size: f64 = [1.0, 1e-9, 1e9, -3.0][quantity % 4];
        let group = |k: usize| Contribution {
            group: format!("group {k} {words}"),
            deviation: size.abs() * 0.1f64.powi(k as i32),
            without: 0.0,
        };
        Prediction {
            record: format!("r{record}"),
            record_label: format!("record {record} {words}"),
            experiment: String::new(),
            quantity: format!("q{quantity}"),
            label: format!("quantity {quantity} {words}"),
            symbol: "u".into(),
            unit: "mm".into(),
            value: size,
            interval: [size - 1.0, size + 1.0],
            budget: (0..12).map(group).collect(),
            deviations: [size.abs(); 2],
            curved: false,
            measured: Some(size),
            inside: Some(true),
            score: Some(0.4 * quantity as f64 - 1.3 * record as f64),
            lacks: vec![],
            doubts: vec![],
        }
    };
    let all = (0..records).flat_map(|r| (0..quantities).map(move |q| (r, q)));
    Analysis {
        tolerance: 0.05,
        found: ValidationFindings {
            constants: vec![],
            fitted: vec![],
            widened: 1.0,
            chi2: 0.0,
            freedom: 0,
            predictions: all.map(one).collect(),
            reference: None,
            sources: vec![],
            scatter: vec![],
            tracks: vec![],
        },
        incomplete: vec![],
        warnings: vec![],
        verdict: String::new(),
    }
}

fn drawn_in(figures: Vec<Drawn>, of: &str, name: &str) -> Vec<String> {
    let figures = figures.into_iter().map(|f| f.unwrap_or_else(|e| panic!("{name}: {e}")));
    figures.flat_map(|f| faults(&format!("{name}, {of}, {}", f.name), &f.svg, style(of))).collect()
}

#[test]
fn figures_of_awkward_validations_are_legible() {
    let mut wrong = vec![];
    for of in STYLES {
        for (records, quantities, words) in [(1, 1, ""), (2, 6, ""), (3, 12, LONG), (9, 4, SCRIPTS)] {
            let found = predictions(records, quantities, words);
            let name = format!("{records} × {quantities} {words}");
            let score = within(style(of), || score::draw(&found)).expect("a score");
            assert!(score.svg.matches("quantity").count() >= quantities, "{name}: every mark is named");
            wrong.extend(drawn_in(vec![Ok(score)], of, &name));
            let sheets = within(style(of), || budget::draw(&found));
            let panels: usize = sheets.iter().flatten().map(|f| f.svg.matches("all together").count()).sum();
            assert_eq!(panels, (records * quantities).min(6), "{name}: no panel is lost");
            let others: usize = sheets.iter().flatten().map(|f| f.svg.matches("4 other groups").count()).sum();
            assert_eq!(others, panels, "{name}: no group is lost");
            wrong.extend(drawn_in(sheets, of, &name));
        }
    }
    assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
}

/// Predictions without a budget have no panel that could be left out.
#[test]
fn a_budget_says_which_predictions_it_shows() {
    let mut found = predictions(2, 4, "");
    found.found.predictions[0].budget.clear();
    let captions = |found: &Analysis<ValidationFindings>| -> Vec<String> {
        budget::draw(found).into_iter().flatten().map(|figure| figure.caption).collect()
    };
    assert!(captions(&found).iter().all(|c| c.ends_with(" Of 7 predictions the first 6.")), "{:?}", captions(&found));
    found.found.predictions[1].budget.clear();
    assert!(captions(&found).iter().all(|c| !c.contains("the first")), "{:?}", captions(&found));
}

#[test]
fn a_score_names_what_it_is_compared_with() {
    let mut found = predictions(1, 2, "");
    assert!(score::draw(&found).expect("a score").svg.contains("(measured − predicted)"));
    found.found.reference = Some("COMSOL".into());
    let figure = score::draw(&found).expect("a score");
    assert!(figure.svg.contains("(COMSOL − predicted)") && !figure.svg.contains("measured"), "{}", figure.svg);
    assert!(figure.caption.starts_with("COMSOL minus predicted"), "{}", figure.caption);
}

/// A case of a robustness study with long names.
fn judged(k: usize) -> JudgedCase {
    JudgedCase {
        case: format!("push_it_50-tet10-far_away_and_{k}_more_of_a_long_name"),
        suite: format!("suite {} of {LONG}", k / 70),
        member: format!("case {k}"),
        variant: ["length", "tension"][k % 2].into(),
        outcome: CaseOutcome::ALL.into_iter().filter(|o| *o != CaseOutcome::Inaccurate).nth(k % 5).expect("five"),
        reason: None,
        findings: vec![],
        status: String::new(),
        steps: 1,
        newton_iterations: 1,
        cuts: 0,
        wall_s: 1.0,
    }
}

#[test]
fn a_matrix_of_many_cases_takes_several_pages() {
    let found = RobustnessFindings { suites: vec![], cases: (0..150).map(judged).collect(), maps: vec![] };
    let (study, _) = with_words(synthetic::study(), LONG);
    let results = Results::without_cases(study);
    for of in STYLES {
        let sheets = within(style(of), || matrix::draw(&results, &found));
        assert!(sheets.len() > 2);
        let tall = sheets.iter().flatten().map(|f| attribute(&f.svg, "height")).fold(0.0, larger);
        assert!(tall <= LONGEST, "{of}: {tall} mm");
        for words in ["matches references", "no reference", "stops as demanded", "stops as is accepted", "fails"] {
            assert!(
                sheets.iter().flatten().all(|f| f.svg.contains(words)),
                "{of}: no entry of the legend says {words}"
            );
        }
        let wrong = drawn_in(sheets, of, "matrix");
        assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
    }
}

/// The second mesh has dashes, of which each is a line.
#[test]
fn curves_of_meshes_differ_without_colour() {
    let dir = tempfile::tempdir().expect("a folder");
    synthetic::store(dir.path(), &synthetic::study());
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let (_, svg) = drawings(dir.path()).into_iter().find(|(name, _)| name == "curves-length").expect("curves");
    let lines = |color: &str| svg.matches(&format!("stroke=\"{color}\" stroke-width=\"9\"")).count();
    let (first, second) = (lines("#0072B2"), lines("#D55E00"));
    assert!(first > 0 && second > 10 * first, "{first} lines of the first mesh, {second} of the second");
}

/// A body of one cell of this height.
fn tetrahedron(height: f64) -> Skin {
    Skin {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        middles: vec![],
        t_s: 1.0,
        displacement: vec![[0.0; 3]; 4],
        stretch: vec![1.0; 4],
        cables: vec![],
        rigids: vec![],
    }
}

#[test]
fn names_of_failed_cases_are_apart_and_their_statuses_whole() {
    let case = |k: usize| JudgedCase { status: "StepTooSmall".into(), outcome: CaseOutcome::Fail, ..judged(k) };
    let found = RobustnessFindings { suites: vec![], cases: (0..5).map(case).collect(), maps: vec![] };
    let mut results = Results::without_cases(synthetic::study().0);
    let body = tetrahedron(1.0);
    results.skins = found.cases.iter().map(|c| (c.case.clone(), body.clone())).collect();
    for of in STYLES {
        let figure = within(style(of), || failed::draw(&results, &found)).expect("a figure");
        assert_eq!(figure.svg.matches("StepTooSmall").count(), 5, "{of}");
        let wrong = drawn_in(vec![Ok(figure)], of, "failures");
        assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
    }
    let many = RobustnessFindings { cases: (0..12).map(case).collect(), ..found };
    results.skins = many.cases.iter().map(|c| (c.case.clone(), body.clone())).collect();
    let caption = failed::draw(&results, &many).expect("a figure").caption;
    assert!(caption.ends_with(" Of 12 failed cases the first 9."), "{caption}");
}

/// Many meshes of a slender upright body are on one page.
#[test]
fn a_figure_of_many_meshes_is_no_taller_than_a_page() {
    let (study, cases) = synthetic::study();
    let mut family = study.families.iter().find(|f| f.role == Role::Sizes).expect("sizes").clone();
    let template = cases.iter().find(|c| family.cases.contains(&c.record.id)).expect("a case");
    let case = |k: usize| {
        let mut case = template.clone();
        (case.record.id, case.record.mesh.cells) = (format!("mesh-{k}"), 100 * (k + 1));
        case
    };
    for count in [1, 5, 9, 40] {
        let all: Vec<StoredCase> = (0..count).map(case).collect();
        family.cases = all.iter().map(|c| c.record.id.clone()).collect();
        let mut results = Results::without_cases(StudyRecord { families: vec![family.clone()], ..study.clone() });
        results.skins = all.iter().map(|c| (c.record.id.clone(), tetrahedron(20.0))).collect();
        results.cases = all;
        for of in STYLES {
            let figure = within(style(of), || bodies::meshes(&results)).expect("a figure");
            let wrong = drawn_in(vec![Ok(figure)], of, &format!("{count} meshes"));
            assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
        }
    }
}

/// A wall time far below a hundredth of a second is not printed as zero.
#[test]
fn no_cost_of_a_table_is_rounded_to_zero() {
    let mut study = of_one_case(synthetic::study());
    for case in &mut study.1 {
        (case.record.wall_s, case.record.cpu_s) = (3.21e-5, 1.23e-4);
        case.record.effects.iter_mut().for_each(|e| e.wall_s = 4.56e-8);
    }
    let dir = tempfile::tempdir().expect("a folder");
    synthetic::store(dir.path(), &study);
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let table = |name: &str| std::fs::read_to_string(dir.path().join(format!("tables/{name}.csv"))).expect("a table");
    assert!(table("cases").contains(",0.0000321,0.000123"), "{}", table("cases"));
    assert!(table("effects").contains(",0.0000456,"), "{}", table("effects"));
}
