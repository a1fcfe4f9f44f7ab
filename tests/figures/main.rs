//! Every kind of figure in every style: type of the chosen size, nothing beyond the sheet, no text over another.

#[path = "../common/mod.rs"]
mod common;

mod awkward;
mod latex;
mod pdf;

use common::program::{ROOT, durometer};
use durometer::report::style::{STYLES, Style};
use resvg::usvg;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Studies of a bar, small enough to be run in seconds, one for each kind of study and of figure.
const STUDIES: [&str; 11] = [
    "calibration",
    "comparison",
    "convergence",
    "cost",
    "coverage",
    "formulations",
    "reduction",
    "robustness",
    "sequence",
    "sweep",
    "validation",
];
/// Sources of figures with the beginning of a name that they give; a source that is not here fails the test. Not in a style of one's own: `body.rs` (`check`,
/// `mesh`), and the overlays that `simulate` draws.
const DRAWN: [(&str, &str); 32] = [
    ("report/body.rs", ""),
    ("study/overlay/figure.rs", ""),
    ("study/overlay/markers_figure.rs", ""),
    ("report/fit/figure.rs", "fit"),
    ("report/service_fit/figure.rs", "fit"),
    ("report/motion/picture.rs", "gravity_a"),
    ("study/figures/sheet.rs", "error-h"),
    ("study/figures/sheet.rs", "work-precision"),
    ("study/figures/sheet.rs", "work-amounts-"),
    ("study/figures/time.rs", "time"),
    ("study/kinds/calibration/figures/band.rs", "band-"),
    ("study/kinds/calibration/figures/curves.rs", "calibration-"),
    ("study/kinds/comparison/figures/curves.rs", "comparison-"),
    ("study/kinds/comparison/figures/sequence.rs", "sequence-"),
    ("study/kinds/convergence/figures/bodies.rs", "meshes"),
    ("study/kinds/convergence/figures/bodies.rs", "bent"),
    ("study/kinds/convergence/figures/cost.rs", "cost-size"),
    ("study/kinds/convergence/figures/curves.rs", "curves-"),
    ("study/kinds/convergence/figures/formulations.rs", "formulations"),
    ("study/kinds/cost/figures/growth.rs", "growth"),
    ("study/kinds/coverage/figure.rs", "coverage"),
    ("study/kinds/reduction/figures/mod.rs", "work-precision"),
    ("study/kinds/reduction/figures/mod.rs", "bars"),
    ("study/kinds/reduction/figures/mod.rs", "singular-values"),
    ("study/kinds/reduction/figures/mod.rs", "meshes"),
    ("study/kinds/reduction/figures/mod.rs", "search"),
    ("study/kinds/robustness/figures/failed.rs", "failures"),
    ("study/kinds/robustness/figures/matrix.rs", "matrix"),
    ("study/kinds/robustness/figures/region.rs", "map-dt-nu"),
    ("study/kinds/sweep/figures.rs", "against-"),
    ("study/kinds/validation/figures/budget.rs", "budget"),
    ("study/kinds/validation/figures/score.rs", "score"),
];
const OVERLAYS: [(&str, &str); 2] =
    [("study/overlay/in_study.rs", "compare-"), ("study/overlay/markers_in_study.rs", "markers-")];

/// A call that draws.
fn drawn(folder: &Path, words: &[&str]) {
    let ended = durometer(folder, words);
    // 3: a study without a verdict is drawn as well
    assert!(matches!(ended.code, Some(0 | 3)), "{words:?}: {}", ended.err);
}

/// Results of every kind, and the flags that draw them again: folders of reports.
fn results(folder: &Path) -> Vec<PathBuf> {
    for file in std::fs::read_dir(Path::new(ROOT).join("tests/figures")).expect("a folder").flatten() {
        if file.path().extension().is_some_and(|e| e != "rs") {
            std::fs::copy(file.path(), folder.join(file.file_name())).expect("writable");
        }
    }
    for study in STUDIES {
        drawn(folder, &["run", &format!("{study}.toml"), "--out", &format!("out/{study}")]);
    }
    let treloar = format!("{ROOT}/data/treloar-1944/treloar-1944.csv");
    let modes = ["--modes", "uniaxial,equibiaxial,planar", "--range", "1..2", "--out", "out/fit"];
    drawn(folder, &[&["fit", &treloar, "--law", "yeoh"], &modes[..]].concat());
    drawn(folder, &["prony", "relaxation.csv", "--experiment", "relaxation", "--ramp", "0 s", "--out", "out/prony"]);
    let out = STUDIES.into_iter().chain(["fit", "prony"]);
    out.map(|name| folder.join("out").join(name)).collect()
}

/// The drawings of a folder by name.
fn drawings(folder: &Path) -> Vec<(String, String)> {
    let files = std::fs::read_dir(folder.join("figures")).expect("figures").flatten().map(|f| f.path());
    let svg = files.filter(|f| f.extension().is_some_and(|e| e == "svg"));
    svg.map(|f| {
        (f.file_stem().expect("a name").to_string_lossy().into_owned(), std::fs::read_to_string(f).expect("text"))
    })
    .collect()
}

/// Number behind `key="` in the first tag.
fn attribute(svg: &str, key: &str) -> f64 {
    let text = svg.split_once(&format!(" {key}=\"")).expect("an attribute").1.split('"').next().expect("its end");
    text.split(' ')
        .next_back()
        .expect("a number")
        .trim_end_matches("mm")
        .parse()
        .unwrap_or_else(|_| panic!("{key} {text}"))
}

fn parsed(svg: &str) -> usvg::Tree {
    let mut fonts = usvg::fontdb::Database::new();
    for name in ["LiberationSans-Regular", "LiberationSans-Italic"] {
        let file = Path::new(ROOT).join(format!("src/report/fonts/{name}.ttf"));
        fonts.load_font_data(std::fs::read(file).expect("a font"));
    }
    let options =
        usvg::Options { font_family: "Liberation Sans".into(), fontdb: Arc::new(fonts), ..Default::default() };
    usvg::Tree::from_str(svg, &options).expect("a drawing")
}

fn texts(group: &usvg::Group, out: &mut Vec<(String, usvg::Rect)>) {
    for node in group.children() {
        match node {
            usvg::Node::Group(inner) => texts(inner, out),
            usvg::Node::Text(text) => {
                let words = text.chunks().iter().map(|c| c.text()).collect::<String>();
                out.push((words, text.abs_bounding_box()));
            }
            _ => {}
        }
    }
}

/// Height of the tallest figure \[mm\].
const LONGEST: f64 = 230.0;

/// What is wrong with a drawing in a style.
fn faults(name: &str, svg: &str, style: Style) -> Vec<String> {
    let mut out = vec![];
    let view: Vec<f64> = svg
        .split_once("viewBox=\"")
        .expect("a view box")
        .1
        .split('"')
        .next()
        .expect("its end")
        .split(' ')
        .map(|v| v.parse().expect("a number"))
        .collect();
    let wide = attribute(svg, "width");
    // A unit of the sheet is a tenth of a point, and labels have 80 of them
    let label_pt = 8.0 * wide / (view[2] * 25.4 / 720.0);
    if wide > style.width_mm + 0.01 {
        out.push(format!("{name}: {wide} mm wide"));
    }
    let tall = attribute(svg, "height");
    // A slide has another height
    if style.width_mm <= 180.0 && tall > LONGEST + 0.01 {
        out.push(format!("{name}: {tall} mm tall"));
    }
    // The width is stated in hundredths of a millimetre, and the sheet in whole units
    if (label_pt / style.font_pt - 1.0).abs() > 2e-3 {
        out.push(format!("{name}: labels of {label_pt:.2} points"));
    }
    let tree = parsed(svg);
    let (w, h) = (tree.size().width(), tree.size().height());
    let per_mm = w / wide as f32;
    let mut all = vec![];
    texts(tree.root(), &mut all);
    for (words, b) in &all {
        let over = [-b.left(), -b.top(), b.right() - w, b.bottom() - h].into_iter().fold(f32::MIN, f32::max) / per_mm;
        if over > 0.3 {
            out.push(format!("{name}: {words:?} is {over:.1} mm outside"));
        }
    }
    for (k, (a, p)) in all.iter().enumerate() {
        for (b, q) in &all[k + 1..] {
            let x = p.right().min(q.right()) - p.left().max(q.left());
            let y = p.bottom().min(q.bottom()) - p.top().max(q.top());
            // Boxes have the ascent and descent of the type, which letters seldom fill
            if x > 0.3 * per_mm && y > 0.35 * p.height().min(q.height()).min(p.width().min(q.width()).max(1.0)) {
                out.push(format!("{name}: {a:?} lies over {b:?}"));
            }
        }
    }
    out
}

/// What keeps a program from reading the tables of a folder of results: headings that one has twice, and numbers with the signs of print.
fn unreadable(results: &Path) -> Vec<String> {
    let files = std::fs::read_dir(results.join("tables")).into_iter().flatten().flatten().map(|f| f.path());
    let mut out = vec![];
    for path in files.filter(|f| f.extension().is_some_and(|e| e == "csv")) {
        let mut table = csv::Reader::from_path(&path).expect("a table");
        let mut seen = BTreeSet::new();
        let twice = table.headers().expect("headings").iter().filter(|h| !seen.insert(h.to_string()));
        out.extend(twice.map(|h| format!("{}: {h:?}", path.display())));
        let is_number = |part: &str| part.contains('−') && part.trim().replace('−', "-").parse::<f64>().is_ok();
        for row in table.records().flatten() {
            let cells = row.iter().filter(|cell| cell.split(" to ").any(is_number));
            out.extend(cells.map(|cell| format!("{}: {cell:?}", path.display())));
        }
    }
    out
}

#[test]
fn every_figure_has_type_of_the_chosen_size_within_its_sheet() {
    let folder = tempfile::tempdir().expect("a folder");
    let results = results(folder.path());
    let unreadable: Vec<String> = results.iter().flat_map(|folder| unreadable(folder)).collect();
    assert!(unreadable.is_empty(), "{}", unreadable.join("\n"));
    let mut names: BTreeSet<String> = BTreeSet::new();
    let mut wrong = vec![];
    let larger = ("one-column", Some("8"));
    for (style, size) in STYLES.map(|(name, _)| (name, None)).into_iter().chain([larger]) {
        let of = Style::named(style, size.map(|s| s.parse().expect("a size")), None).expect("a style");
        let flags: Vec<&str> =
            ["--style", style].into_iter().chain(size.iter().flat_map(|s| ["--font-size", *s])).collect();
        let mut check = |folder: &Path| {
            for (name, svg) in drawings(folder) {
                wrong.extend(faults(&format!("{style} {size:?} {name}"), &svg, of));
                names.insert(name);
            }
        };
        for result in &results {
            drawn(folder.path(), &[&["report", &result.to_string_lossy()], &flags[..]].concat());
            check(result);
        }
        let record = format!("{ROOT}/tests/motion/gravity_a.csv");
        let ring = [
            "--body",
            "tip1,tip2,tip3",
            "--ring-down",
            "displacement_z_m",
            "--window",
            "0.3 s,1.6 s",
            "--threshold",
            "0.1 mm",
        ];
        let words = [&["motion", &record, "--out", "out/motion"], &ring[..], &flags[..]].concat();
        drawn(folder.path(), &words);
        check(&folder.path().join("out/motion"));
    }
    assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
    for (source, name) in DRAWN.into_iter().chain(OVERLAYS) {
        assert!(names.iter().any(|n| n.starts_with(name)), "{source}: no figure {name} in {names:?}");
    }
}

/// Every source that draws is in the list above.
#[test]
fn every_source_of_figures_is_tested() {
    let mut sources = BTreeSet::new();
    let folder = Path::new(ROOT).join("src");
    for path in common::files::files_below(&folder) {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        if text
            .lines()
            .any(|l| [" figure(", "(figure("].iter().any(|call| l.contains(call) && !l.contains("fn figure(")))
        {
            let name = path.strip_prefix(&folder).expect("a source");
            sources.insert(name.to_string_lossy().replace('\\', "/"));
        }
    }
    let known: BTreeSet<String> = DRAWN.into_iter().chain(OVERLAYS).map(|(source, _)| source.to_string()).collect();
    assert_eq!(sources, known);
}
