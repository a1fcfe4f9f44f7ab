//! Comparison of members with a reference: curves with known differences, loops with a known area, refusals.

// It serves the tests of another kind of study too.
#[allow(dead_code)]
use crate::common::synthetic;
use durometer::report::style::{self, STYLES};
use durometer::report::{canvas, measure};
use durometer::study::analysis::Analysis;
use durometer::study::curve::Curve;
use durometer::study::expand::Study;
use durometer::study::kinds::comparison::findings::{ComparedMember, ComparisonFindings, ComparisonRecord};
use durometer::study::kinds::comparison::{analysis, finer};
use durometer::study::report;
use durometer::study::store::record::{FamilyRecord, Role, Series, StoredCase, StudyQuantity, StudyRecord};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

/// Three cycles; the tension follows the length L = 0.05 + 0.01 cos φ [m] with T = a (1 − cos(φ − δ)) [N].
fn case(family: &str, member: &str, a: f64, delta: f64, template: &StoredCase) -> StoredCase {
    let mut c = template.clone();
    let n = 600;
    let phase = |k: usize| 6.0 * PI * k as f64 / n as f64;
    let of = |f: &dyn Fn(f64) -> f64| (0..=n).map(|k| f(phase(k))).collect::<Vec<f64>>();
    let length = of(&|phi| 0.05 + 0.01 * phi.cos());
    let tension = of(&|phi| a * (1.0 - (phi - delta).cos()));
    c.record.id = format!("{family}-length-{member}");
    (c.record.family, c.record.variant, c.record.member) = (family.into(), "length".into(), member.into());
    c.record.status = "Converged".into();
    c.record.cpu_s = a;
    c.record.probes.get_mut("cable_tension_N").expect("probe").peak = 2.0 * a;
    let columns = BTreeMap::from([("cable_tension_N".into(), tension), ("cable_length_m".into(), length)]);
    c.series = Series { t_s: (0..=n).map(|k| k as f64 / 200.0).collect(), columns };
    c
}

fn study() -> (StudyRecord, Vec<StoredCase>) {
    let (mut study, cases) = synthetic::study();
    let template = &cases[0];
    let stored = vec![
        case("laws", "base", 2.0, 0.0, template),
        case("laws", "stiff", 2.4, 0.0, template),
        case("laws", "near", 2.02, 0.0, template),
        case("laws", "lossy", 2.0, 0.3, template),
        case("fine", "base", 1.9, 0.0, template),
        case("fine", "stiff", 2.318, 0.0, template),
    ];
    let ids = |family: &str| stored.iter().filter(|c| c.record.family == family).map(|c| c.record.id.clone()).collect();
    let family = |name: &str, role| FamilyRecord {
        name: name.into(),
        role,
        formulation: "tet10".into(),
        cases: ids(name),
        members: vec![],
    };
    study.kind = "comparison".into();
    study.details = serde_json::json!({ "reference": "base" });
    study.variants = vec!["length".into()];
    study.families = vec![family("laws", Role::Members), family("fine", Role::Finer)];
    let q = |name: &str, against| StudyQuantity {
        name: name.into(),
        label: name[..name.rfind('_').unwrap_or(0)].replace('_', " "),
        symbol: "q".into(),
        unit: "N".into(),
        against,
        ..StudyQuantity::default()
    };
    let length = q("cable_length_m", None);
    // The imposed length is the same under every law and is left out.
    let tension = q("cable_tension_N", Some(Box::new(length.clone())));
    study.quantities = BTreeMap::from([("length".into(), vec![tension, length])]);
    (study, stored)
}

fn analyse(study: &StudyRecord, stored: &[StoredCase]) -> Analysis<ComparisonFindings> {
    analysis::analyse(study, &ComparisonRecord { reference: "base".into() }, stored)
}

/// A quantity that starts at a thousand, as a position far from the origin, differs by the same shares as one that starts at zero.
#[test]
fn differences_are_shares_of_changes() {
    let (study, mut stored) = study();
    for case in &mut stored {
        let tension = case.series.columns.get_mut("cable_tension_N").expect("recorded");
        tension.iter_mut().for_each(|value| *value += 1e3);
        case.record.probes.get_mut("cable_tension_N").expect("probe").peak += 1e3;
    }
    let a = analyse(&study, &stored);
    let stiff = a.quantities[0].members.iter().find(|c| c.member == "stiff").expect("a member");
    for share in [stiff.peak_difference, stiff.distance, stiff.largest] {
        assert!((share - 0.2).abs() < 1e-9, "{stiff:?}");
    }
}

/// Under the reversed load the same member is as much stiffer: its magnitude is larger, not its value higher. A member whose peak has the other sign is said to.
#[test]
fn peaks_of_negative_quantities_differ_by_their_magnitudes() {
    let stiff_of = |factors: [f64; 2]| {
        let (study, mut stored) = study();
        for case in &mut stored {
            let factor = factors[usize::from(case.record.member == "stiff")];
            let tension = case.series.columns.get_mut("cable_tension_N").expect("recorded");
            tension.iter_mut().for_each(|value| *value *= factor);
            case.record.probes.get_mut("cable_tension_N").expect("probe").peak *= factor;
        }
        let a = analyse(&study, &stored);
        let stiff = a.quantities[0].members.iter().find(|c| c.member == "stiff").expect("a member").peak_difference;
        (stiff, a.verdict.clone(), a.quantities[0].sentence.clone())
    };
    let words = ["20 % higher", "20 % larger in magnitude", "has the other sign and differs by 220 %"];
    for (factors, share, words) in
        [([1.0, 1.0], 0.2, words[0]), ([-1.0, -1.0], 0.2, words[1]), ([-1.0, 1.0], -2.2, words[2])]
    {
        let (found, verdict, sentence) = stiff_of(factors);
        assert!((found - share).abs() < 1e-12, "{found}");
        assert!(verdict.contains(words), "{verdict}");
        let sign = if share < 0.0 { "−220 %" } else { "+20 %" };
        assert!(sentence.contains(&format!("stiff {sign}")), "{sentence}");
    }
}

/// Tensions of rounding differ by 20 %, which decides nothing where the absolute tolerance of the quantity is larger; the words are in the unit.
/// A difference beyond that tolerance decides, and a reference that is zero is comparable.
#[test]
fn an_absolute_tolerance_decides_near_zero() {
    let verdict = |factor: f64, absolute: Option<f64>| {
        let (mut study, mut stored) = study();
        study.quantities.get_mut("length").expect("quantities")[0].absolute_tolerance = absolute;
        for case in &mut stored {
            let tension = case.series.columns.get_mut("cable_tension_N").expect("recorded");
            tension.iter_mut().for_each(|value| *value *= factor);
            case.record.probes.get_mut("cable_tension_N").expect("probe").peak *= factor;
        }
        let a = analyse(&study, &stored);
        (a.verdict.clone(), a.quantities[0].sentence.clone(), a.quantities[0].members.clone())
    };
    let (noise, _, _) = verdict(1e-10, None);
    assert!(noise.contains("stiff by 20 %"), "{noise}");
    let (small, sentence, _) = verdict(1e-10, Some(0.01));
    assert!(small.contains("or the absolute tolerance, in every curve") && small.contains("can replace"), "{small}");
    assert!(!small.contains("differ"), "{small}");
    assert!(sentence.contains("within 0.01"), "{sentence}");
    // The peaks 4 N and 4.8 N are 0.8 N apart
    let (large, _, members) = verdict(1.0, Some(0.5));
    assert!(large.contains("stiff by 0.8"), "{large}");
    let (accepted, _, _) = verdict(1.0, Some(0.81));
    assert!(!accepted.contains("stiff by"), "{accepted}");
    let stiff = members.iter().find(|c| c.member == "stiff").expect("a member");
    let (study, _) = study();
    assert!((stiff.largest - 0.8 * study.tolerance / 0.5).abs() < 1e-12, "{stiff:?}");
}

/// The sums over 200 samples a cycle are exact for sines up to rounding, the interpolation of a peak between them is
/// not needed: every difference is that of two samples.
#[test]
fn differences_and_loops_have_their_closed_forms() {
    let (study, stored) = study();
    let a = analyse(&study, &stored);
    assert_eq!(a.quantities.len(), 1, "the length is imposed: {:?}", a.quantities);
    let law = |member: &str| -> &ComparedMember {
        a.quantities[0].members.iter().find(|c| c.member == member).expect(member)
    };
    let close = |got: f64, want: f64, tolerance: f64| assert!((got - want).abs() <= tolerance, "{got} is not {want}");
    close(law("stiff").peak_difference, 0.2, 1e-12);
    close(law("stiff").distance, 0.2, 1e-12);
    close(law("stiff").largest, 0.2, 1e-12);
    // 0.22 on the finer mesh, 0.2 on the other
    close(law("stiff").mesh_drift.expect("both"), 0.02, 1e-12);
    assert_eq!(law("lossy").mesh_drift, None);
    // max |cos(φ − δ) − cos φ| = 2 sin(δ/2), of the peak 2; the samples miss the top by (Δφ)²/8 at most
    close(law("lossy").largest, (0.3_f64 / 2.0).sin(), (2.0 * PI / 200.0).powi(2) / 8.0);
    // ∮ T dL = π a b sin δ over a cycle, with the sign of L; polygons of 200 sides have sin(Δφ)/Δφ of an ellipse
    let polygon = (2.0 * PI / 200.0).sin() / (2.0 * PI / 200.0);
    close(law("lossy").loop_area.expect("a cycle").abs(), PI * 2.0 * 0.01 * 0.3_f64.sin() * polygon, 1e-12);
    close(law("base").loop_area.expect("a cycle"), 0.0, 1e-12);
    // Ranges 2a and 2b; the samples may miss the ends of the range of T by (Δφ)²/8
    let box_error = (2.0 * PI / 200.0).powi(2) / 4.0;
    close(law("lossy").loop_share.expect("a cycle"), PI / 4.0 * 0.3_f64.sin() * polygon, box_error);
    // First order in the lag: tan δ for δ, over ω = 2π
    close(law("lossy").lag_s.expect("a small lag"), 0.3_f64.sin() / (2.0 * PI), 1e-3);
    let cost = a.costs.iter().find(|p| p.member == "stiff").expect("a cost");
    close(cost.ratio.expect("a reference"), 1.2, 1e-12);
    // Not all runs start at zero, so that the peaks are changes: 4 N − 2 N (1 − cos δ) of the one that lags behind
    let peaks = ["is 20 % higher: 4.80 N against 4.00 N)", "is 2.23 % lower: 3.91 N against 4.00 N)"];
    for words in ["near", "can replace base", "stiff by 20 %", "lossy by 15 %"].into_iter().chain(peaks) {
        assert!(a.verdict.contains(words), "{words}: {}", a.verdict);
    }
    assert!(a.quantities[0].sentence.contains("at most 2 %"), "{}", a.quantities[0].sentence);
}

/// The same results, and those of the members in another variant that no finer mesh was run in.
fn in_two_variants(study: &StudyRecord, stored: &[StoredCase]) -> (StudyRecord, Vec<StoredCase>) {
    let (mut study, mut stored) = (study.clone(), stored.to_vec());
    study.variants.push("short".into());
    study.labels.insert("short".into(), "shortened".into());
    study.quantities.insert("short".into(), study.quantities["length"].clone());
    let of_members = stored.iter().filter(|c| c.record.family == "laws").cloned().collect::<Vec<_>>();
    for mut case in of_members {
        case.record.id = format!("laws-short-{}", case.record.member);
        case.record.variant = "short".into();
        study.families[0].cases.push(case.record.id.clone());
        stored.push(case);
    }
    (study, stored)
}

/// Sentences on a finer mesh are of the members that were run on one, and of no member where none was.
#[test]
fn the_error_of_the_mesh_is_claimed_where_it_is_known() {
    let (study, stored) = study();
    let a = analyse(&study, &stored);
    let sentence = &a.quantities[0].sentence;
    assert!(sentence.contains("changes the difference of stiff by at most 2 %; the other 2 members"), "{sentence}");
    let unknown = |a: &Analysis<ComparisonFindings>| {
        a.warnings.iter().find(|w| w.contains("The error of the mesh")).cloned().unwrap_or_default()
    };
    assert!(unknown(&a).contains("in the differences of near and lossy is unknown"), "{:?}", a.warnings);
    assert!(finer::errors(&study, &a).ends_with("This change is known of stiff, and unknown of near and lossy."));
    let of = |keep: &dyn Fn(&StoredCase) -> bool| stored.iter().filter(|c| keep(c)).cloned().collect::<Vec<_>>();
    let known = analyse(&study, &of(&|c| ["base", "stiff"].contains(&c.record.member.as_str())));
    assert!(known.quantities[0].sentence.contains("changes these differences by at most 2 %."));
    assert!(unknown(&known).is_empty() && finer::errors(&study, &known).ends_with("both do not share."));
    let (study_of_two, stored_of_two) = in_two_variants(&study, &stored);
    let two = analyse(&study_of_two, &stored_of_two);
    let errors = finer::errors(&study_of_two, &two);
    let (known_of, unknown_of) = ("stiff (length control)", "near, lossy and stiff (shortened)");
    assert!(errors.ends_with(&format!("This change is known of {known_of}, and unknown of {unknown_of}.")), "{errors}");
    assert!(unknown(&two).contains(&format!("in the differences of {unknown_of} is unknown")), "{:?}", two.warnings);
    let coarse = of(&|c| c.record.family == "laws");
    let none = analyse(&study, &coarse);
    assert!(unknown(&none).contains("between members is unknown"), "{:?}", none.warnings);
    assert!(!none.quantities[0].sentence.contains("finer mesh"), "{}", none.quantities[0].sentence);
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, coarse));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let read = |name: &str| std::fs::read_to_string(dir.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (methods, figure) = (read("paper/methods.md"), read("figures/comparison-length.tex"));
    assert!(
        methods.contains("No error bar is computed") && !methods.contains("counts where it is larger"),
        "{methods}"
    );
    for words in [figure, read("tables/comparison.tex")] {
        assert!(!words.contains("finer mesh changes"), "{words}");
    }
}

/// A cable that is slack at the end does not come back to where its cycle began. Half a percent of the range off, the loop
/// is that of the closed cycle up to the piece that is cut off, 0.005 of the box and less, and the samples between.
#[test]
fn a_loop_may_miss_its_start_by_half_a_percent() {
    let n = 200;
    let curve = |f: &dyn Fn(f64) -> f64| Curve {
        t: (0..=n).map(f64::from).collect(),
        f: (0..=n).map(|k| f(4.0 * PI * f64::from(k) / f64::from(n))).collect(),
    };
    let mut x = curve(&|phi| 0.5 * (1.0 + phi.cos()));
    *x.f.last_mut().expect("samples") -= 0.005;
    let (_, share) = curve(&|phi| (phi - 0.3).cos()).hysteresis(&x).expect("a cycle");
    assert!((share - PI / 4.0 * 0.3_f64.sin()).abs() < 0.01, "{share}");
}

#[test]
fn the_report_holds_both_figures() {
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &study());
    let summary = report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(summary.kind, "comparison");
    assert!(summary.analysis["cable_tension_N"]["length"]["members"].is_array());
    for file in
        ["figures/comparison-length.svg", "figures/loops-length.pdf", "tables/costs.csv", "tables/comparison.tex"]
    {
        assert!(dir.path().join(file).is_file(), "{file}");
    }
}

/// The caption of the curves names what has no panel, no curve and no difference, and the legend only what is drawn. Differences have no axis where none of them is drawn.
#[test]
fn a_caption_of_curves_says_what_is_left_out() {
    let (mut study, mut stored) = study();
    let template = stored[0].clone();
    stored.push(case("laws", "far", 6.0, 0.0, &template));
    let mut brief = case("laws", "brief", 2.0, 0.0, &template);
    brief.series.t_s.iter_mut().for_each(|t| *t *= 0.5);
    stored.push(brief);
    for case in &stored[6..] {
        study.families[0].cases.push(case.record.id.clone());
    }
    let names = ["one_N", "two_N", "three_N"];
    for case in &mut stored {
        let (wave, probe) =
            (case.series.columns["cable_tension_N"].clone(), case.record.probes["cable_tension_N"].clone());
        for name in names {
            case.series.columns.insert(name.into(), wave.clone());
            case.record.probes.insert(name.into(), probe.clone());
        }
    }
    let quantities = study.quantities.get_mut("length").expect("quantities");
    let tension = quantities[0].clone();
    quantities.extend(names.map(|name| StudyQuantity { name: name.into(), against: None, ..tension.clone() }));
    let drawn = |stored: Vec<StoredCase>| {
        let dir = tempfile::tempdir().expect("temporary folder");
        synthetic::store(dir.path(), &(study.clone(), stored));
        report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        ["figures/comparison-length.svg", "index.html"]
            .map(|file| std::fs::read_to_string(dir.path().join(file)).expect("written"))
    };
    let [svg, page] = drawn(stored.clone());
    assert!(page.contains(" Of 4 quantities the first 3."), "{page}");
    assert!(page.contains(" Without a curve to compare: brief.") && !svg.contains("brief"), "{page}");
    for panel in ["drawn there: in (a)", "; in (b)", "; in (c)"] {
        assert!(page.contains(&format!("{panel} far, by more than half of its ")), "{page}");
    }
    assert!(svg.contains("(reference) [N]"), "{svg}");
    let [svg, _] = drawn(stored.into_iter().filter(|c| ["base", "far"].contains(&c.record.member.as_str())).collect());
    assert!(svg.contains("base (reference)") && !svg.contains("(reference) [N]"), "{svg}");
}

/// In every style the type has the size of the style, and no word of a legend ends outside of the figure, however long the name of a member is.
#[test]
fn figures_of_every_style_keep_their_type_and_their_legends() {
    let (mut study, stored) = study();
    study.members.insert("base".into(), "a law with a name of more than forty letters".into());
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, stored));
    for (name, style) in STYLES {
        style::within(style, || report::write_report(dir.path())).unwrap_or_else(|e| panic!("{e}"));
        let svg = std::fs::read_to_string(dir.path().join("figures/comparison-length.svg")).expect("a figure");
        let (_, view) = svg.split_once("viewBox=\"0 0 ").expect("a view box");
        let units: f64 = view.split(' ').next().and_then(|w| w.parse().ok()).expect("a width");
        // A label has 80 units of a tenth of a point at eight points
        let zoom = canvas::width_mm(&svg) * 720.0 / 25.4 / units;
        assert!(zoom >= 0.999 * style.font_pt / 8.0, "{name}: type is shrunk to {zoom} of its size");
        let entry = svg.split("<text ").find(|t| t.contains("forty letters")).expect("a legend");
        let x: f64 = entry.split('"').nth(1).and_then(|x| x.parse().ok()).expect("a place");
        let words = "a law with a name of more than forty letters (reference)";
        assert!(x + f64::from(measure::width(words, canvas::SMALL)) <= units, "{name}: the legend ends outside");
    }
}

/// Costs of two members are one number, which is that of the other member; without a result of the reference there is none.
#[test]
fn a_range_is_that_of_the_other_members() {
    let (study, stored) = study();
    let of = |names: &[&str]| -> Vec<StoredCase> {
        stored.iter().filter(|c| names.contains(&c.record.member.as_str())).cloned().collect()
    };
    let pair = analyse(&study, &of(&["base", "stiff"]));
    assert!(pair.verdict.contains("Stiff costs 1.20 times as much as base."), "{}", pair.verdict);
    let alone = analyse(&study, &of(&["stiff", "lossy"]));
    assert!(alone.costs.iter().all(|p| p.ratio.is_none()) && !alone.verdict.contains("NaN"), "{:?}", alone.costs);
}

/// Where every case has failed the page has no heading above nothing, and no table of a head alone.
#[test]
fn a_page_has_no_empty_part() {
    let (study, mut stored) = study();
    stored.iter_mut().for_each(|c| c.record.status = "StepTooSmall".into());
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, stored));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let page = std::fs::read_to_string(dir.path().join("index.html")).expect("a page");
    for part in page.split("<table>").skip(1) {
        let table = part.split("</table>").next().expect("a table");
        assert!(table.matches("<tr").count() > 1, "{table}");
    }
    for part in page.split("<h2>").skip(1) {
        let (heading, body) = part.split_once("</h2>").expect("a heading");
        assert!(!body.trim().is_empty(), "{heading}");
    }
}

#[test]
fn without_a_pair_there_is_no_verdict() {
    let (study, mut stored) = study();
    for c in stored.iter_mut().filter(|c| c.record.member == "base") {
        c.record.status = "StepTooSmall".into();
    }
    let a = analyse(&study, &stored);
    assert!(a.verdict.starts_with("No verdict"), "{}", a.verdict);
    assert!(a.warnings.iter().any(|w| w.contains("laws-length-base: StepTooSmall")), "{:?}", a.warnings);
}

/// A law may come with the scene, or by `include` of a file of its own.
#[test]
fn a_member_has_the_title_of_its_law() {
    let study = Study::read(Path::new("studies/finger-materials/study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let names = ["neo_hookean", "linear", "mooney_rivlin", "arruda_boyce", "relaxing_nominal"];
    let titles = ["Neo-Hookean", "linear elastic", "Mooney–Rivlin", "Arruda–Boyce", "relaxing (nominal)"];
    assert_eq!(names.map(|name| study.record.member(name)), titles);
}

#[test]
fn a_member_that_is_named_like_another_law_than_its_own_keeps_its_name() {
    let dir = tempfile::tempdir().expect("temporary folder");
    std::fs::copy("tests/cli/scene.toml", dir.path().join("scene.toml")).expect("copied");
    let text = r#"kind = "comparison"
question = "?"
expectation = "!"
scene = "scene.toml"
tolerance = "5 %"
reference = "base"
[[variant]]
name = "length"
quantity = [{ name = "cable_tension_N", label = "T", symbol = "T", unit = "N" }]
[[family]]
name = "all"
role = "members"
labels = { stable_neo_hookean = "three terms" }
[family.members]
base = {}
linear = { "mesh.element" = "tet4" }
corotational = { "laws.rubber.law" = "corotational" }
stable_neo_hookean = { "stage.0.dt" = "0.1 s" }
st_venant_kirchhoff = { "laws.rubber.law" = "st_venant_kirchhoff" }
"#;
    let file = dir.path().join("study.toml");
    std::fs::write(&file, text).expect("written");
    let titles = |changes: &[(String, toml::Value)]| {
        let study = Study::read(&file, changes).unwrap_or_else(|e| panic!("{e}")).record;
        ["linear", "corotational", "stable_neo_hookean", "st_venant_kirchhoff"].map(|name| study.member(name))
    };
    assert_eq!(titles(&[]), ["linear", "corotational", "three terms", "St Venant–Kirchhoff"]);
    // The law of all scenes tells none from the others
    let all = [("laws.rubber.law".to_string(), "linear".into())];
    assert_eq!(titles(&all), ["linear", "corotational", "three terms", "st venant kirchhoff"]);
}

#[test]
fn roles_and_reference_must_fit_the_kind() {
    let dir = tempfile::tempdir().expect("temporary folder");
    std::fs::copy("tests/cli/scene.toml", dir.path().join("scene.toml")).expect("copied");
    let refuse = |change: &dyn Fn(String) -> String| {
        let text = "kind = \"comparison\"\nquestion = \"?\"\nexpectation = \"!\"\nscene = \"scene.toml\"\ntolerance = \"5 %\"\nreference = \"soft\"\n\
            [[variant]]\nname = \"length\"\nquantity = [{ name = \"cable_tension_N\", label = \"T\", symbol = \"T\", unit = \"N\" }]\n\
            [[family]]\nname = \"laws\"\nrole = \"members\"\n[family.members]\nsoft = {}\nstiff = { \"stage.0.dt\" = \"0.5 s\" }\n";
        let file = dir.path().join("study.toml");
        std::fs::write(&file, change(text.into())).expect("written");
        Study::read(&file, &[]).map(|s| s.cases.len()).map_err(|e| e.to_string())
    };
    assert_eq!(refuse(&|t| t), Ok(2));
    let cases: [(&dyn Fn(String) -> String, &str); 5] = [
        (
            &|t| t.replace("reference = \"soft\"\n", ""),
            "name the member that the others are compared with: soft, stiff",
        ),
        (&|t| t.replace("reference = \"soft\"", "reference = \"sotf\""), "did you mean `soft`?"),
        (
            &|t| t.replace("role = \"members\"", "role = \"sizes\""),
            "has no role \"sizes\"; the roles are members, finer, cumulative",
        ),
        (&|t| t.replace("role = \"members\"", "role = \"finer\""), "0 families have the role \"members\""),
        (
            &|t| {
                t.replace("kind = \"comparison\"", "kind = \"convergence\"")
                    .replace("role = \"members\"", "role = \"sizes\"")
            },
            "unknown key `reference`",
        ),
    ];
    for (change, message) in cases {
        let error = refuse(change).expect_err(message);
        assert!(error.contains(message), "{error}\ndoes not say: {message}");
    }
}
