//! Pages of the viewer: what they show is what the run has, their size, texts of others in them, and their behaviour in a browser.

#[path = "../common/mod.rs"]
mod common;

mod pictures;
mod studies;

use crate::common::program::{ROOT, durometer, ended};
use crate::common::tools;
use durometer::math::statistics::larger;
use durometer::mesh::grid_file::{Grid, read_collection, read_grid};
use durometer::report::viewer::film::Film;
use durometer::report::viewer::footage::About;
use durometer::report::viewer::pack::Packed;
use durometer::report::viewer::page;
use durometer::report::viewer::shape::Limits;
use durometer::scene::SceneBuilder;
use durometer::scene::output::FieldSpec;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A title that breaks out of whatever is not escaped.
const TITLE: &str = "</script><img src=x onerror=alert(1)> \\\"quotes\\\" & <b>bold</b> 指 ∂u/∂t {{x}} ${y}";

/// A run with fields and a page, under a title.
fn run(folder: &Path, title: &str) -> PathBuf {
    let scene = std::fs::read_to_string(Path::new(ROOT).join("tests/cli/scene.toml")).expect("a scene");
    let (_, scene) = scene.split_once('\n').expect("the title is the first line");
    let mesh = Path::new(ROOT).join("tests/bad/good/boxes.msh");
    let scene = scene.replace("../bad/good/boxes.msh", &mesh.to_string_lossy());
    let text =
        format!("title = \"{title}\"\n{scene}\n[output]\nfields = {{ what = [\"displacement\", \"stress\"] }}\n");
    let file = folder.join("scene.toml");
    std::fs::write(&file, text).expect("room");
    let output = durometer(ROOT, &["simulate", &file.to_string_lossy(), "--out", &folder.to_string_lossy()]);
    assert!(output.is_success(), "{}", output.err);
    folder.join("scene.html")
}

/// The numbers of a page, read without the code that wrote them.
struct Numbers {
    head: Value,
    bytes: Vec<u8>,
}

impl Numbers {
    fn of(case: &Packed) -> Self {
        let mut bytes = vec![];
        flate2::read::ZlibDecoder::new(&case.data[..]).read_to_end(&mut bytes).expect("zlib");
        Self { head: case.head.clone(), bytes }
    }

    /// The bytes of number k of an array, most significant first.
    fn word<const N: usize>(&self, array: &Value, k: usize) -> [u8; N] {
        let [at, count] = ["at", "count"].map(|key| array[key].as_u64().expect("a place") as usize);
        std::array::from_fn(|plane| self.bytes[at + plane * count + k])
    }

    fn count(array: &Value) -> usize {
        array["count"].as_u64().expect("a number") as usize
    }

    /// [points] a history at a state.
    fn history(&self, modes: &Value, state: usize) -> Vec<Vec<f64>> {
        let components = modes["components"].as_u64().expect("a number") as usize;
        let shapes = modes["shapes"].as_array().expect("a list");
        let points = shapes.first().map_or(0, Self::count) / components;
        let value = |i: usize, p: usize| -> f64 {
            let of = |(k, shape): (usize, &Value)| {
                let q = i16::from_be_bytes(self.word(shape, i * points + p));
                f64::from(q) * modes["amplitudes"][k][state].as_f64().expect("a number")
            };
            shapes.iter().enumerate().map(of).sum()
        };
        (0..points).map(|p| (0..components).map(|i| value(i, p)).collect()).collect()
    }

    fn rest(&self) -> Vec<[f64; 3]> {
        let array = &self.head["points"];
        let count = Self::count(array) / 3;
        let at = |p: usize, i: usize| {
            let origin = self.head["origin"][i].as_f64().expect("a number");
            origin + f64::from(f32::from_be_bytes(self.word(array, i * count + p)))
        };
        (0..count).map(|p| std::array::from_fn(|i| at(p, i))).collect()
    }
}

/// The states that the run wrote for ParaView.
fn written(folder: &Path) -> Vec<(f64, Grid)> {
    let files = read_collection(&folder.join("scene.pvd")).expect("a collection");
    files.into_iter().map(|(t, file)| (t, read_grid(&file, 1.0).expect("a grid"))).collect()
}

/// Positions of the nodes of a state in the VTU file.
fn positions(grid: &Grid) -> Vec<[f64; 3]> {
    let u = grid.data.iter().find(|d| d.name == "displacement_m").expect("the displacement");
    let at = |(p, u): (&durometer::math::tensor::Vec3, &[f64])| [p.x + u[0], p.y + u[1], p.z + u[2]];
    grid.points.iter().zip(u.values.chunks_exact(3)).map(at).collect()
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Length of the two cubes of the scene [m]
const EXTENT: f64 = 0.025;
/// Reference positions and histories come from single precision: half a unit in the last place of both, in three components.
const SINGLE: f64 = 2.0 * 1.8 * 6e-8 * EXTENT;

#[test]
fn the_page_of_a_run_has_the_positions_and_stresses_of_its_vtu_to_the_stated_errors() {
    let folder = TempDir::new().expect("a temporary folder");
    let cases = page::read(&run(folder.path(), "cubes")).expect("a page");
    let [case] = &cases[..] else { panic!("one case") };
    let numbers = Numbers::of(case);
    let (rest, states) = (numbers.rest(), written(folder.path()));
    assert_eq!(numbers.head["times"].as_array().expect("times").len(), states.len());
    let motion = &numbers.head["motion"];
    let stated = motion["error"].as_f64().expect("a number");
    assert!(stated < 1e-4 * EXTENT, "{stated}");
    let stress =
        numbers.head["fields"].as_array().expect("fields").iter().find(|f| f["name"] == "stress").expect("recorded");
    let (mut largest, mut size) = (0.0f64, 0.0f64);
    for (k, (t, grid)) in states.iter().enumerate() {
        assert_eq!(numbers.head["times"][k].as_f64(), Some(*t));
        let u = numbers.history(motion, k);
        for (p, x) in positions(grid).iter().enumerate() {
            let shown: [f64; 3] = std::array::from_fn(|i| rest[p][i] + u[p][i]);
            let off = distance(&shown, x);
            assert!(off <= stated + SINGLE, "node {p} at t = {t} is off by {off}, stated {stated}");
        }
        let of_vtu = grid.data.iter().find(|d| d.name == "stress_Pa" && d.at_points).expect("recorded");
        for (own, s) in numbers.history(&stress["modes"], k).iter().zip(of_vtu.values.chunks_exact(9)) {
            let s = [s[0], s[4], s[8], s[1], s[5], s[2]];
            let off = own.iter().zip(s).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            (largest, size) = (larger(largest, off), s.iter().fold(size, |m, v| larger(m, v.abs())));
        }
    }
    let stated = stress["modes"]["error"].as_f64().expect("a number");
    assert!(largest <= stated + 1e-6 * size && stated < 0.01 * size, "{largest} of {size}, stated {stated}");
}

/// A history as of a study of 36 000 cells: a bar that bends and twists, with stretch and stress.
#[test]
fn a_history_of_36_000_cells_takes_less_than_5_mb() {
    for element in ["tet4", "tet10"] {
        let scene = format!(
            "[mesh]\ngrid = {{ kind = \"box\", size = [\"100 mm\", \"20 mm\", \"20 mm\"], divisions = [60, 10, 10] }}\nelement = \"{element}\"\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"1 MPa\"\nnu = 0.45\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
        );
        let scene = SceneBuilder::parse(&scene).and_then(SceneBuilder::build).expect("a scene");
        assert_eq!(scene.body.mesh.cell_count(), 36_000);
        let mut film = Film::new(&scene, &[FieldSpec::VonMises], &Limits::USUAL);
        let mut state = scene.start();
        for k in 0..11 {
            state.t = f64::from(k) / 10.0;
            for (n, p) in scene.body.mesh.points.iter().enumerate() {
                let (turn, twist) = (1.3 * state.t * p.x / 0.1 + 1e-9, 0.8 * (6.0 * state.t).sin() * p.x / 0.1);
                let (y, z) = (p.y * twist.cos() - p.z * twist.sin(), p.y * twist.sin() + p.z * twist.cos());
                let radius = p.x / turn;
                let x = [(radius - z) * turn.sin(), y, radius - (radius - z) * turn.cos()];
                (0..3).for_each(|i| state.x[3 * n + i] = x[i] - p[i]);
            }
            film.add(&scene, &state);
        }
        let packed = film.finish(&scene, About::default());
        let error = packed.head["motion"]["error"].as_f64().expect("a number");
        let html = page::page("a bar", &[packed]);
        println!("{element}: {} bytes, positions to {error} m", html.len());
        assert!(html.len() <= 5_000_000, "{element}: {} bytes", html.len());
        assert!(error <= 4.0 * 5e-5 * 0.15, "{element}: {error} m");
    }
}

/// Two cases next to each other, a scene, a mesh and a collection become pages; what cannot be shown is refused with a remedy.
#[test]
fn files_of_all_kinds_are_shown_or_refused() {
    let folder = TempDir::new().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let run = run(folder.path(), "cubes").to_string_lossy().into_owned();
    let out = path("out.html");
    let shows = |files: &[&str], cases: usize| {
        let output = durometer(ROOT, &[&["view", "--out", &out], files].concat());
        assert!(output.is_success(), "{files:?}: {}", output.err);
        let found = page::read(Path::new(&out)).expect("a page");
        assert_eq!(found.len(), cases, "{files:?}");
        found
    };
    let both = shows(&[&run, &path("scene.json")], 2);
    let titles = [&both[0], &both[1]].map(|case| case.title().to_string());
    assert!(titles[0].ends_with("scene.html") && titles[1].ends_with("scene.json"), "{titles:?}");
    assert_eq!(shows(&[&run], 1), shows(&[&path("scene.json")], 1));
    let scene = shows(&["tests/cli/scene.toml"], 1);
    assert_eq!(scene[0].head["parts"][0]["kind"], "cable");
    let kinds: Vec<&str> =
        scene[0].head["marked"].as_array().expect("a list").iter().filter_map(|m| m["kind"].as_str()).collect();
    assert!(kinds.contains(&"held") && kinds.contains(&"region"), "{kinds:?}");
    shows(&["tests/bad/good/boxes.msh", "--unit", "cm"], 1);
    let collection = shows(&[&path("scene.pvd")], 1);
    assert_eq!(collection[0].head["times"], both[0].head["times"]);
    assert_eq!(collection[0].head["motion"]["error"].as_f64().map(|e| e < 1e-6), Some(true));

    std::fs::copy(path("scene.json"), path("other.json")).expect("room");
    std::fs::write(
        path("newer.html"),
        std::fs::read_to_string(&run).expect("text").replace("{\"format\":2", "{\"format\":7"),
    )
    .expect("room");
    std::fs::write(path("plain.html"), "<p>").expect("room");
    let sets = [0, 1].map(|part| format!("<DataSet timestep=\"0\" part=\"{part}\" file=\"scene-000{part}.vtu\"/>"));
    std::fs::write(path("parts.pvd"), format!("<VTKFile><Collection>{}</Collection></VTKFile>", sets.concat()))
        .expect("room");
    std::fs::write(path("broken.vtu"), "<VTKFile>").expect("room");
    std::fs::write(path("image.vtu"), "<VTKFile type=\"ImageData\"></VTKFile>").expect("room");
    for (file, words) in [
        ("other.json", "without --no-view"),
        ("newer.html", "newer version"),
        ("plain.html", "no page of the viewer"),
        ("parts.pvd", "several parts"),
        ("broken.vtu", "not well-formed"),
        ("image.vtu", "ImageData"),
        ("none.html", "cannot be read"),
    ] {
        let output = durometer(ROOT, &["view", &path(file), "--out", &out]);
        let said = output.err;
        assert!(output.code == Some(2) && said.contains(words), "{file}: {said}");
    }
}

/// The report of a study links to its cases at their peaks: each with the surface that is stored of it.
#[test]
fn the_report_of_a_study_has_its_cases_in_three_dimensions() {
    let folder = TempDir::new().expect("a temporary folder");
    let out = folder.path().to_string_lossy().into_owned();
    let output = durometer(ROOT, &["run", "tests/cli/study.toml", "--out", &out]);
    assert!(output.is_success(), "{}", output.err);
    let index = std::fs::read_to_string(folder.path().join("index.html")).expect("the report");
    assert!(index.contains("href=\"view.html\""));
    let found = page::read(&folder.path().join("view.html")).expect("a page");
    let stored = durometer::study::store::results::read(folder.path()).expect("results");
    assert_eq!(found.len(), stored.skins.len());
    for case in &found {
        let skin = &stored.skins[case.title()];
        let numbers = Numbers::of(case);
        let u = numbers.history(&numbers.head["motion"], 0);
        let stated = numbers.head["motion"]["error"].as_f64().expect("a number");
        for (k, displacement) in skin.displacement.iter().enumerate() {
            let off = distance(&std::array::from_fn(|i| u[k][i]), displacement);
            assert!(off <= stated + SINGLE, "{}: node {k} is off by {off}, stated {stated}", case.title());
        }
    }
    // The nodes of a stored surface have no numbers of the mesh, and its state a time
    if let Some(driven) = driven(&folder.path().join("view.html"), false) {
        assert_eq!(driven["errors"], serde_json::json!([]));
        let said: Vec<&str> = driven["said"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
        let time = format!("t = {} s", stored.skins[found[0].title()].t_s);
        assert!(said.len() == 3 && said[0].starts_with("point "), "{said:?}");
        assert!(said[1].ends_with(&format!(" at {time}")) && said[2].starts_with(&format!("state{time}")), "{said:?}");
    }
    let again = durometer(ROOT, &["view", &out, "--out", &folder.path().join("out.html").to_string_lossy()]);
    assert!(again.is_success(), "{}", again.err);
}

#[test]
fn a_run_can_be_without_a_page_and_names_the_keys_of_fields_that_are_missing() {
    let folder = TempDir::new().expect("a temporary folder");
    let out = folder.path().to_string_lossy().into_owned();
    assert!(durometer(ROOT, &["simulate", "tests/cli/scene.toml", "--no-view", "--out", &out]).is_success());
    assert!(!folder.path().join("scene.html").exists());
    assert!(durometer(ROOT, &["simulate", "tests/cli/scene.toml", "--out", &out]).is_success());
    let case = &page::read(&folder.path().join("scene.html")).expect("a page")[0];
    let absent = case.head["absent"].to_string();
    assert!(absent.contains("[output] fields = { what = [\\\"stress\\\"] }"), "{absent}");
}

/// The digest of the sources that the build writes into the program: the same without node.
#[test]
fn the_program_of_the_page_is_built_from_its_sources() {
    let root = Path::new(ROOT).join("viewer");
    let mut names: Vec<String> =
        ["package-lock.json", "package.json", "start.js", "style.css"].map(String::from).into();
    let sources = std::fs::read_dir(root.join("src")).expect("the sources").flatten();
    names.extend(sources.map(|e| format!("src/{}", e.file_name().to_string_lossy())));
    names.sort();
    let mut hash = Sha256::new();
    for name in names {
        let bytes = std::fs::read(root.join(&name)).expect("a source");
        hash.update(format!("{name}\n{}\n", bytes.len()));
        hash.update(bytes);
    }
    let digest: String = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
    let packed = std::fs::read(Path::new(ROOT).join("src/report/viewer/bundle/viewer.js.z")).expect("the program");
    let mut program = String::new();
    flate2::read::ZlibDecoder::new(&packed[..]).read_to_string(&mut program).expect("zlib");
    assert!(program.contains(&digest), "the sources have changed: run `npm ci && npm run build` in viewer/");
    let lock = std::fs::read_to_string(root.join("package-lock.json")).expect("the lock");
    assert!(
        !lock.contains("\"resolved\""),
        "the lock records addresses: npm install --omit-lockfile-registry-resolved"
    );
}

/// The same bundle comes out of the build, where its tools are installed.
#[test]
fn the_build_makes_the_program_that_is_committed() {
    let root = Path::new(ROOT).join("viewer");
    if tools::is_missing(root.join("node_modules/esbuild").is_dir(), "esbuild (npm ci in viewer/)") {
        return;
    }
    let output = ended(Command::new("node").arg("build.mjs").arg("--check").current_dir(root));
    assert!(output.is_success(), "{}", output.err);
}

/// Runs a test of the sources of the page.
fn passes_in_node(test: &str) {
    if tools::is_missing(is_there("node"), "node") {
        return;
    }
    let root = Path::new(ROOT).join("viewer");
    let output = Command::new("node").arg(test).current_dir(root).output().expect("node starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Marks of axes and colour bars have texts that tell neighbours apart, in one notation.
#[test]
fn marks_are_written_with_the_digits_of_their_distance() {
    passes_in_node("test/units.mjs");
}

/// Each state has the value of its own row and a time that tells it from its neighbours, and no field hides another one.
#[test]
fn states_have_their_rows_and_fields_their_names() {
    passes_in_node("test/data.mjs");
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success())
}

/// Drives a page in headless Chromium; none where it is not installed. With a reference the views are compared with the pictures there.
fn driven(page: &Path, reference: bool) -> Option<Value> {
    if tools::is_missing(is_there("chromium") && is_there("node"), "chromium with node") {
        return None;
    }
    let mut node = Command::new("node");
    node.arg(Path::new(ROOT).join("viewer/test/drive.mjs")).arg(page);
    Some(found(if reference { node.env("REFERENCE", reference_pictures()) } else { &mut node }))
}

fn reference_pictures() -> PathBuf {
    Path::new(ROOT).join("viewer/test/reference")
}

/// What the driver prints.
fn found(driver: &mut Command) -> Value {
    let output = ended(driver);
    assert!(output.is_success(), "{}", output.err);
    serde_json::from_str(&output.out).expect("JSON")
}

/// Every act of keys, mouse and fingers did what it should, and every view is its reference picture: of its squares of 4 × 4 pixels no more than
/// `share` differ by a tenth of full colour. Between two browsers that is the smoothing of lines, up to 0.7 %; a view of another state differs by 6 % and more.
fn assert_as_expected(found: &Value, share: f64) {
    let acts = found["acts"].as_object().expect("acts");
    assert!(acts.len() >= 16 && acts.values().all(|did| *did == true), "{acts:?}");
    let views = found["reference"].as_object().expect("views");
    assert!(views.len() == 8 && views.values().all(|d| d.as_f64().is_some_and(|d| d <= share)), "{views:?}");
}

fn single(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().expect("4 bytes")))).collect()
}

#[test]
fn a_browser_shows_the_run_without_errors_and_requests() {
    use base64::Engine;
    let folder = TempDir::new().expect("a temporary folder");
    let page = run(folder.path(), TITLE);
    let Some(found) = driven(&page, true) else { return };
    assert_eq!(found["errors"], serde_json::json!([]));
    assert_as_expected(&found, 0.01);
    let requests: Vec<&str> = found["requests"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(
        requests.len() == 1 && requests[0].starts_with("file:") && requests[0].ends_with("scene.html"),
        "{requests:?}"
    );
    let title = TITLE.replace("\\\"", "\"");
    assert_eq!((found["heading"].as_str(), found["elements"].as_u64()), (Some(title.as_str()), Some(0)));
    assert_eq!(found["title"].as_str(), Some(format!("{title} – Durometer").as_str()));
    let quantities = found["quantities"][0].to_string();
    assert!(["stretch", "von Mises stress", "pressure"].iter().all(|q| quantities.contains(q)), "{quantities}");

    let case = &found["cases"][0];
    let stated = case["error"].as_f64().expect("a number");
    for (k, (t, grid)) in written(folder.path()).iter().enumerate() {
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(case["states"][k].as_str().expect("text"))
            .expect("base64");
        let shown = single(&bytes);
        for (p, x) in positions(grid).iter().enumerate() {
            let off = distance(&std::array::from_fn(|i| shown[3 * p + i]), x);
            // The page adds in single precision too
            assert!(off <= stated + 2.0 * SINGLE, "node {p} at t = {t} is off by {off}, stated {stated}");
        }
    }

    let different = found["different"].to_string();
    for state in ["slider", "middle", "colour", "section", "regions", "front", "theme"] {
        assert!(different.contains(state), "{state} changes nothing: {different}");
    }
    assert_eq!(found["clock"], "t = 0 s");
    assert_eq!(found["between"], serde_json::json!(["t = 0 s", "t = 0 s", 0]));
    assert!(found["legend"].as_str().is_some_and(|l| l.contains("displacement, x [mm]")), "{}", found["legend"]);
    assert!(found["section"][0].as_u64().is_some_and(|n| n > 0), "{}", found["section"]);
    let saved: Vec<&str> = found["saved"].as_array().expect("a list").iter().filter_map(|s| s[0].as_str()).collect();
    assert!(
        saved[..3] == ["image/png", "image/svg+xml", "image/gif"] && saved[3].starts_with("video/webm"),
        "{saved:?}"
    );
    // As many pictures as there are states, in a file that ends as GIF files do
    assert_eq!(found["gif"], found["cases"][0]["states"].as_array().map(Vec::len).expect("states"));
    assert_eq!(found["webm"], true);
    let svg = &found["svg"];
    assert!(svg["shapes"].as_u64().is_some_and(|n| n > 100), "{svg}");
    // The time of the state, where the slider is at 0.55 s
    assert!(svg["text"].to_string().contains("t = 0.5 s"), "{svg}");
    assert!(
        found["saved"].as_array().expect("a list").iter().all(|s| s[1].as_u64().is_some_and(|n| n > 5000)),
        "{}",
        found["saved"]
    );
    println!(
        "first paint {} ms, first picture {} ms, {} pictures a second",
        found["firstPaint_ms"], found["firstDraw_ms"], found["frames_per_s"]
    );
}

/// The same in Firefox, which draws with WebGL where a display in memory is there.
#[test]
fn firefox_shows_the_same_views_and_follows_the_same_acts() {
    let has = is_there("firefox-esr") && is_there("node") && Command::new("xvfb-run").arg("--help").output().is_ok();
    if tools::is_missing(has, "firefox-esr with node and xvfb-run") {
        return;
    }
    let folder = TempDir::new().expect("a temporary folder");
    let mut node = Command::new("xvfb-run");
    node.args(["-a", "node"]).arg(Path::new(ROOT).join("viewer/test/drive.mjs")).arg(run(folder.path(), TITLE));
    let found = found(node.env("BROWSER", "firefox").env("REFERENCE", reference_pictures()));
    assert_eq!(found["errors"], serde_json::json!([]));
    assert_as_expected(&found, 0.02);
    let saved: Vec<&str> = found["saved"].as_array().expect("a list").iter().filter_map(|s| s[0].as_str()).collect();
    assert!(saved.len() == 4 && saved[3].starts_with("video/webm"), "{saved:?}: {}", found["busy"]);
}

#[test]
fn a_browser_shows_two_cases_and_a_scene_at_rest() {
    let folder = TempDir::new().expect("a temporary folder");
    let run = run(folder.path(), "cubes").to_string_lossy().into_owned();
    let out = folder.path().join("out.html");
    for files in [vec![run.as_str(), run.as_str()], vec!["tests/cli/scene.toml"]] {
        let output = durometer(ROOT, &[&["view", "--out", &out.to_string_lossy()][..], &files].concat());
        assert!(output.is_success(), "{}", output.err);
        let Some(found) = driven(&out, false) else { return };
        assert_eq!(found["errors"], serde_json::json!([]), "{files:?}");
        let linked = found["linked"].as_array().expect("a list");
        assert!(linked.len() == files.len() && linked.iter().all(|l| *l == linked[0]), "state and camera: {linked:?}");
        let cut = found["section"].as_array().expect("a list");
        assert!(cut.len() == files.len() && cut.iter().all(|n| n.as_u64().is_some_and(|n| n > 0)), "{cut:?}");
    }
    // Where time runs back, as on a path by arc length, the states are counted
    let sets =
        [(0.0, 0), (1.0, 1), (0.5, 2)].map(|(t, k)| format!("<DataSet timestep=\"{t}\" file=\"scene-000{k}.vtu\"/>"));
    let back = folder.path().join("back.pvd");
    std::fs::write(&back, format!("<VTKFile><Collection>{}</Collection></VTKFile>", sets.concat())).expect("room");
    let output = durometer(ROOT, &["view", "--out", &out.to_string_lossy(), &back.to_string_lossy()]);
    assert!(output.is_success(), "{}", output.err);
    let Some(found) = driven(&out, false) else { return };
    assert_eq!((&found["errors"], &found["clock"]), (&serde_json::json!([]), &"state 1, t = 0 s".into()));
}
