//! Mutated input to every reader: none panics, hangs, or takes more than 256 MB for a file below 1 MB.
//!
//! A few hundred mutations of each seed file run here; `DUROMETER_FUZZ=100000 cargo test --release --test fuzz` draws so many for each reader. The
//! seeds are the sound and the bad files of the other tests. What a reader is given lies in a file when it is called: it is there after an abort.

mod common;

use common::scene;
use durometer::calibrate::{
    Accuracy, Card, ColumnChoice, Experiment, FitOptions, Mode, Preparation, fit_experiment, read_law_file,
};
use durometer::material::keywords::{Program, read, write};
use durometer::math::formula::Formula;
use durometer::math::random::SplitMix;
use durometer::math::units;
use durometer::mesh::generate::read_manifest;
use durometer::mesh::structured::block;
use durometer::mesh::surface_file::read_surface;
use durometer::mesh::{Order, Reading, format, read_as};
use durometer::motion::{ReadOptions, Tracks};
use durometer::scene::{Checkpoint, RunOptions, Scene, open_scene, read_scene};
use durometer::storage;
use durometer::study::expand::Study;
use durometer::study::store::record::CaseRecord;
use durometer::study::store::skin::Skin;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Bytes that are in use, and the most since the last reset.
static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: every call is passed on to the system's allocator with the same arguments; only the sizes are counted.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let used = USED.fetch_add(layout.size(), Relaxed) + layout.size();
        MOST.fetch_max(used, Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Memory that a file below 1 MB may take [bytes].
const MEMORY: usize = 256 << 20;
/// CPU time of one input [s], on a loaded machine
const TIME: f64 = 20.0;
/// Mutations for each reader, where nothing is said
const QUICK: usize = 400;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Pieces of text that mutations put in.
const WORDS: [&str; 40] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "9223372036854775807",
    "-9223372036854775808",
    "4294967295",
    "18446744073709551616",
    "\"",
    "\\",
    "\n",
    "\r\n",
    ",",
    ";",
    "\t",
    "[",
    "]",
    "{",
    "}",
    "((((",
    "[[[[",
    "= ",
    "'''",
    "\u{feff}",
    "\u{0}",
    "\u{301}",
    "\u{e000}",
    " mm",
    "^127",
    "$Nodes\n",
    "$Elements\n",
    "$EndNodes\n",
    "vertex ",
    "f 1 2 3\n",
    "CELLS ",
    "1e9",
    "null",
];

type Reader<'a> = Box<dyn Fn(&Path) + 'a>;

/// A reader, the name of its file, and seeds.
struct Target<'a> {
    name: &'static str,
    file: &'static str,
    seeds: Vec<Vec<u8>>,
    read: Reader<'a>,
}

fn files(paths: &[&str]) -> Vec<Vec<u8>> {
    paths
        .iter()
        .map(|path| std::fs::read(Path::new(ROOT).join(path)).unwrap_or_else(|e| panic!("{path}: {e}")))
        .collect()
}

fn folder(path: &str, ending: &str) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(Path::new(ROOT).join(path)).expect("a folder of this project").flatten();
    let mut found: Vec<PathBuf> =
        entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == ending)).collect();
    found.sort();
    found.iter().map(|p| std::fs::read(p).expect("readable")).collect()
}

fn pick(random: &mut SplitMix, n: usize) -> usize {
    (random.bits() % n.max(1) as u64) as usize
}

/// A seed with one to a few changes: bits, bytes, words, numbers, pieces that are removed, doubled, or taken from another seed.
fn mutated(random: &mut SplitMix, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[pick(random, seeds.len())].clone();
    for _ in 0..1 + pick(random, 4) {
        let at = pick(random, bytes.len() + 1);
        let end = (at + pick(random, 64)).min(bytes.len());
        match pick(random, 8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << pick(random, 8),
            1 if at < bytes.len() => bytes[at] = random.bits() as u8,
            2 => drop(bytes.splice(at..at, WORDS[pick(random, WORDS.len())].bytes())),
            3 => drop(bytes.splice(at..end, WORDS[pick(random, WORDS.len())].bytes())),
            4 => drop(bytes.drain(at..end)),
            5 => {
                let piece = bytes[at..end].repeat(1 + pick(random, 200));
                drop(bytes.splice(at..at, piece));
            }
            6 => {
                let other = &seeds[pick(random, seeds.len())];
                let from = pick(random, other.len() + 1);
                let to = (from + pick(random, 400)).min(other.len());
                drop(bytes.splice(at..end, other[from..to].iter().copied()));
            }
            _ => bytes.truncate(if pick(random, 4) == 0 { at } else { bytes.len() }),
        }
    }
    bytes.truncate(1 << 20);
    bytes
}

/// What went wrong with an input, if anything did.
fn fault(read: &Reader, file: &Path) -> Option<String> {
    let before = USED.load(Relaxed);
    MOST.store(before, Relaxed);
    let clock = cpu_time::ThreadTime::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| read(file)));
    let (taken, seconds) = (MOST.load(Relaxed).saturating_sub(before), clock.elapsed().as_secs_f64());
    if outcome.is_err() {
        return Some("it panics".into());
    }
    if taken > MEMORY {
        return Some(format!("it takes {} MB", taken >> 20));
    }
    (seconds > TIME).then(|| format!("it takes {seconds:.1} s"))
}

fn meshes(file: &Path) {
    let how = Reading { unit_m: 1e-3, split: true, merge: None };
    let own = |reader: &format::Reader| matches!(reader, format::Reader::Msh | format::Reader::Vtk);
    if let Some(reader) = format::recognise(file).ok().map(|format| format.reader).filter(own) {
        read_as(file, file, reader, &how).ok();
    }
}

fn text(file: &Path) -> String {
    String::from_utf8_lossy(&std::fs::read(file).expect("just written")).into_owned()
}

/// A small scene whose signal is the table next to it.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 1] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "1 mm", end = "1 s" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
[[probe]]
kind = "reaction"
region = "xmax"
"#;

/// A saved state with a sum that fits whatever was changed after it.
fn state(file: &Path, scene: &Scene) {
    let bytes = std::fs::read(file).expect("just written");
    let rest = bytes.iter().position(|b| *b == b'\n').map_or(&bytes[..], |end| &bytes[end + 1..]);
    let whole = [format!("durometer state 10 {}\n", storage::sha256(rest)).as_bytes(), rest].concat();
    std::fs::write(file, whole).expect("writable");
    if let Ok(restart) = Checkpoint::read(file, scene) {
        scene.run_with(RunOptions { restart: Some(restart), ..RunOptions::default() });
    }
}

fn saved_state(scene: &Scene, folder: &Path) -> Vec<u8> {
    let file = folder.join("seed.state");
    let mut save = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).unwrap_or_else(|e| panic!("{e}"));
    scene.run_with(RunOptions { save_at: vec![0.5], on_save: Some(&mut save), ..RunOptions::default() });
    std::fs::read(&file).expect("saved")
}

fn target<'a>(name: &'static str, file: &'static str, seeds: Vec<Vec<u8>>, read: Reader<'a>) -> Target<'a> {
    Target { name, file, seeds, read }
}

/// A surface of a result as JSON, and gzipped.
fn skin() -> [Vec<u8>; 2] {
    let plain = br#"{"points":[[0,0,0],[1,0,0],[0,1,0]],"triangles":[[0,1,2]],"t_s":1.0,"displacement":[[0,0,0],[0,0,0],[0,0,0]],"stretch":[1,1,1],"cables":[]}"#;
    [plain.to_vec(), Skin::unpacked(plain).expect("sound").packed()]
}

fn shapes() -> Vec<Target<'static>> {
    let bad = |ending: &str| [folder("tests/bad", ending), folder("tests/bad/good", ending)].concat();
    let stl = b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n".to_vec();
    let mut binary = vec![0u8; 80];
    binary.extend(2u32.to_le_bytes());
    binary.extend([7; 100]);
    let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/1/3 3 -1\n".to_vec();
    vec![
        target("MSH", "a.msh", bad("msh"), Box::new(meshes)),
        target("VTK", "a.vtk", bad("vtk"), Box::new(meshes)),
        target("gzip", "a.msh.gz", vec![skin()[1].clone()], Box::new(meshes)),
        target("STL", "a.stl", vec![stl, binary], Box::new(|p| drop(read_surface(p, 1e-3)))),
        target("OBJ", "a.obj", vec![obj], Box::new(|p| drop(read_surface(p, 1e-3)))),
    ]
}

const FORMULAS: [&str; 4] = [
    "15 * (1 - cos(2 * PI * t)) / 2",
    "max(alpha, 1) ^ 2 - min(t, 3)",
    "0.4 * (30 - bending_angle_deg)",
    "-atan2(t, -2) / (1 + sqrt(abs(t)))",
];

fn texts<'a>(scene: &'a Scene, at: &'a Path) -> Vec<Target<'a>> {
    let scenes = [folder("tests/bad/scenes", "toml"), vec![SCENE.as_bytes().to_vec()]].concat();
    let manifests = folder("meshes/finger", "json").into_iter().take(2).collect::<Vec<_>>();
    let manifests = if manifests.is_empty() { vec![b"{}".to_vec()] } else { manifests };
    let lines = |all: &[&str]| all.iter().map(|s| s.as_bytes().to_vec()).collect::<Vec<_>>();
    let sizes = |p: &Path| drop(units::quantity(&text(p)));
    let study_at = at.to_path_buf();
    vec![
        target("scene", "scene.toml", scenes, Box::new(|p| drop(read_scene(p, &[])))),
        target(
            "study",
            "study.toml",
            files(&["studies/finger-convergence/study.toml"]).into_iter().chain(sweeps()).collect(),
            Box::new(move |p| {
                std::fs::write(study_at.join("scene.toml"), SCENE).expect("writable");
                drop(Study::read(p, &[]));
            }),
        ),
        target(
            "table of a signal",
            "way.csv",
            lines(&["t_s,w\n0,0\n0.5,0.25\n1,1\n", "0,0\n1,1\n"]),
            Box::new(|p| {
                let table = "{ kind = \"table\", file = \"way.csv\", unit = \"mm\" }";
                let ramp = "{ kind = \"ramp\", from = \"0 mm\", to = \"1 mm\", end = \"1 s\" }";
                let scene = p.with_file_name("table.toml");
                std::fs::write(&scene, SCENE.replace(ramp, table)).expect("writable");
                drop(open_scene(&scene));
            }),
        ),
        target("manifest", "a.json", manifests, Box::new(|p| drop(read_manifest(p)))),
        target(
            "surface of a result",
            "skin.json",
            skin().to_vec(),
            Box::new(|p| {
                drop(Skin::unpacked(&std::fs::read(p).expect("just written")));
            }),
        ),
        target(
            "record",
            "record.json",
            vec![serde_json::to_vec(&CaseRecord::default()).expect("JSON")],
            Box::new(|p| {
                drop(serde_json::from_slice::<CaseRecord>(&std::fs::read(p).expect("just written")));
            }),
        ),
        target("saved state", "a.state", vec![saved_state(scene, at)], Box::new(move |p| state(p, scene))),
        target(
            "formula",
            "formula",
            lines(&FORMULAS),
            Box::new(|p| {
                if let Ok(formula) = Formula::new(&text(p), 1.0) {
                    formula.value(&vec![0.5; formula.variables().len()]);
                }
            }),
        ),
        target(
            "quantity",
            "quantity",
            lines(&["1.07 g/cm^3", "7.5mm", "2 Pa s", "9.81 m/s²", "-3e-4 1/s"]),
            Box::new(sizes),
        ),
    ]
}

/// Readers of tests of materials and of their laws, and the fits that follow.
fn materials() -> Vec<Target<'static>> {
    let lines = |all: &[&str]| all.iter().map(|s| s.as_bytes().to_vec()).collect::<Vec<_>>();
    vec![
        target("law", "law.toml", folder("data/treloar-1944", "toml"), Box::new(|p| drop(read_law_file(p)))),
        target(
            "table of a test",
            "a.csv",
            [files(&["data/treloar-1944/treloar-1944.csv", "data/synthetic-dumbbell/pull.csv"]), lines(&TABLES)]
                .concat(),
            Box::new(|p| {
                let read = Experiment::read(p, None, &ColumnChoice::default(), Some(Mode::Uniaxial));
                drop(read.and_then(|e| e.prepare(&Preparation::default())));
            }),
        ),
        target("fit", "a.csv", lines(&TABLES), Box::new(fits)),
        target(
            "card of a test",
            "card.toml",
            lines(&CARDS),
            Box::new(|p| drop(Card::read(p).and_then(|c| c.choice()))),
        ),
        target("law of another program", "rubber.inp", lines(&KEYWORDS), Box::new(foreign)),
    ]
}

/// Readers of measured motion.
fn motion() -> Vec<Target<'static>> {
    let read = |p: &Path| drop(Tracks::read(p, &ReadOptions::default()));
    let lines = |all: &[&str]| all.iter().map(|s| s.as_bytes().to_vec()).collect::<Vec<_>>();
    vec![
        target("C3D", "a.c3d", folder("tests/motion/c3d", "c3d"), Box::new(read)),
        target("TRC", "a.trc", lines(&TRACKS[..1]), Box::new(read)),
        target("table of markers", "a.csv", lines(&TRACKS[1..]), Box::new(read)),
    ]
}

/// Marker tracks as OpenSim writes them, with one row per time, and with one row per marker.
const TRACKS: [&str; 3] = [
    "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t2\t1\tmm\nFrame#\tTime\ta\t\t\n\t\tX1\tY1\tZ1\n\n\
     1\t0\t1\t2\t3\n2\t0.01\t\t\t\n",
    "t_s,n_avg,a_x_m,a_y_m,a_z_m\n0,1,0.1,0.2,0.3\n0.1,1,0.1,0.2,0.3\n0.2,10,,,\n",
    "experiment;marker;x_mm;y_mm;z_mm\nr;a;1,5;2;3\nr;b;1,5;2;4\n",
];

const CARDS: [&str; 1] = [
    "name = \"a\"\nfile = \"a.csv\"\nstatus = \"own\"\nmode = \"uniaxial\"\n[specimen]\ngauge_length = \"33 mm\"\n\
compliance = \"0.002 mm/N\"\n[accuracy]\nstress_scale = \"2 %\"\nforce_zero = \"0.05 N\"\n[columns]\nstress = \"#2\"\n[preparation]\nzero = 5\n\
toe = \"5 kPa\"\n",
];

/// Fits of a linear and of a separable law with every error of the measurement stated.
fn fits(path: &Path) {
    let mut choice = ColumnChoice::default();
    for (key, text) in [("gauge_length", "33 mm"), ("area", "18 mm^2")] {
        choice.dimensions.set(key, text).expect("valid");
    }
    let read = Experiment::read(path, None, &choice, Some(Mode::Uniaxial));
    let Ok(experiment) = read.and_then(|e| e.prepare(&Preparation::default())) else { return };
    for (law, terms) in [("yeoh", 2), ("gent", 1)] {
        let mut options = FitOptions::new(law);
        options.terms = Some(terms);
        let stated = ["stress_zero=1kPa", "stress_scale=2%", "strain_scale=1%", "compliance=0.001 mm/N"];
        options.accuracy =
            stated.iter().fold(options.accuracy, |all, one| one.parse::<Accuracy>().expect("valid").or(&all));
        drop(fit_experiment(&experiment, &options).map(|r| r.law_text()));
    }
}

fn sweeps() -> Vec<Vec<u8>> {
    let sweep = "kind = \"sweep\"\nquestion = \"q\"\nexpectation = \"e\"\nscene = \"scene.toml\"\ntolerance = \"2 %\"\n[[axis]]\nname = \"E\"\nkeys = [\"laws.rubber.E\"]\n\
                 label = \"modulus\"\nsymbol = \"E\"\nunit = \"kPa\"\nvalues = [\"50 kPa\", \"100 kPa\"]\n[[variant]]\nname = \"v\"\n\
                 quantity = [{ name = \"xmax_reaction_x_N\", label = \"force\", symbol = \"F\", unit = \"N\" }]\n";
    vec![sweep.as_bytes().to_vec()]
}

/// Small tests as machines write them: one stress against stretch, raw columns with times, decimal commas, two specimens.
const TABLES: [&str; 4] = [
    "stretch,stress [MPa]\n1,0\n1.1,0.05\n1.2,0.09\n1.3,0.13\n1.4,0.16\n1.5,0.18\n1.6,0.2\n",
    "Width;6;mm\nThickness;3;mm\nTime (s);Tensile strain (Strain 1) [%];Load (N)\n0;0;0\n1;10;0.9\n2;20;1.6\n3;30;2.3\n4;40;2.8\n5;50;3.2\n6;60;3.6\n",
    "Dehnung;Spannung\n%;N/mm2\n0;0\n10;0,05\n20;0,09\n30;0,13\n40;0,16\n50;0,18\n60;0,2\n",
    "Specimen,stretch,stress (kPa)\nA,1.1,50\nA,1.2,90\nA,1.3,130\nA,1.4,160\nA,1.5,180\nB,1.1,51\nB,1.2,92\nB,1.3,129\nB,1.4,163\nB,1.5,183\n",
];

const KEYWORDS: [&str; 5] = [
    "*MATERIAL, NAME=A\n*HYPERELASTIC, OGDEN, N=2\n1e-1, 2.0, 3e-2, -2.0, 1e-3, 0\n*STEP\n",
    "TB,HYPER,1,1,3,YEOH\nTBDATA,1,1e-1,-2e-3,1e-4,1e-3\n",
    "*MATERIAL, NAME=R\n*HYPERELASTIC, YEOH, MODULI=INSTANTANEOUS\n1, 2, 3, 1e-3\n*VISCOELASTIC, TIME=PRONY\n0.3, 0, 1\n",
    "<material id=\"1\" type=\"Ogden\"><c1>0.1</c1><m1>2</m1><k>10</k><pressure_model>2</pressure_model></material>",
    "<TetrahedronHyperelasticityFEMForceField materialName=\"MooneyRivlin\" ParameterSet=\"0.1 0.02 10\"/>",
];

/// Laws in the input of other programs.
fn foreign(path: &Path) {
    let text = text(path);
    for program in Program::ALL {
        if let Ok(found) = read(&text, program, "MPa") {
            drop(write(&found.energy, program, "kPa", &[]));
        }
    }
}

#[test]
fn no_reader_panics_hangs_or_fills_the_memory() {
    let count = std::env::var("DUROMETER_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(QUICK);
    let only = std::env::var("DUROMETER_FUZZ_READER").ok();
    let seed = std::env::var("DUROMETER_FUZZ_SEED").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let keep = tempfile::tempdir().expect("a temporary folder");
    let scene = scene(block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear), SCENE);
    let mut faults = vec![];
    for target in shapes().into_iter().chain(materials()).chain(motion()).chain(texts(&scene, keep.path())) {
        if only.as_ref().is_some_and(|only| only != target.name) {
            continue;
        }
        let mut random = SplitMix(seed);
        let file = keep.path().join(target.file);
        for k in 0..count {
            let input = mutated(&mut random, &target.seeds);
            std::fs::File::create(&file).and_then(|mut f| f.write_all(&input)).expect("writable");
            if let Some(what) = fault(&target.read, &file) {
                let kept = std::env::temp_dir().join(format!("durometer-fuzz-{}-{k}", target.name.replace(' ', "-")));
                std::fs::write(&kept, &input).expect("writable");
                faults.push(format!("{} {k}: {what}: {}", target.name, kept.display()));
            }
        }
        println!("{}: {count} inputs", target.name);
    }
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
}
