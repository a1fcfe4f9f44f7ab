//! A study of kind `reduction` from end to end: runs, models, report, and the program that steps a model.

use crate::bar::SCENE;
use crate::common::program::{durometer, durometer_with, program};
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};

pub(super) const STUDY: &str = r#"
kind = "reduction"
question = "How few?"
expectation = "Few."
scene = "scene.toml"
tolerance = "1 %"
training = 24
held_back = 20
modes = [2, 5]
[[input]]
name = "tension"
key = "constraint.cable.drive.signal"
range = ["0 N", "0.4 N"]
[[input]]
name = "weight"
key = "effect.gravity.acceleration"
range = ["-10 m/s^2", "10 m/s^2"]
[[quantity]]
name = "xmax_z_m"
label = "height of the tip"
symbol = "z"
unit = "m"
"#;

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

pub(super) fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("room");
}

#[test]
fn a_study_makes_models_that_the_program_steps() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write(at, "scene.toml", SCENE);
    write(at, "study.toml", STUDY);
    let ran = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    let summary: Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("out/summary.json")).expect("it is there"))
            .expect("JSON");
    let verdict = summary["verdict"].as_str().expect("words");
    assert!(verdict.starts_with("The model of"), "{verdict}");
    let derived = std::fs::read(at.join("out/derived.json")).expect("it is there");
    let record: Value = serde_json::from_slice(&derived).expect("JSON");
    assert_eq!((&record["training"], record["models"].as_array().map(Vec::len)), (&24.into(), Some(2)));
    medians_are_those_of_the_errors(&record);
    a_full_step_is_that_between_neighbours(at, &record);

    // Nothing is made again where nothing has changed; a lost model is
    let again = durometer(at, &["report", "out"]);
    assert_eq!(again.code, Some(0), "{}", again.err);
    assert_eq!(std::fs::read(at.join("out/derived.json")).expect("it is there"), derived);
    let name = record["models"][1]["file"].as_str().expect("a file").to_string();
    let before = std::fs::read(at.join("out").join(&name)).expect("a model");
    std::fs::remove_file(at.join("out").join(&name)).expect("it was there");
    assert_eq!(durometer(at, &["report", "out"]).code, Some(0));
    assert!(
        std::fs::read(at.join("out").join(&name)).expect("a model") == before,
        "the same states give the same bits"
    );

    let model = format!("out/{name}");
    let protocol = "{\"inputs\": {\"cable_imposed_tension_N\": 0.2}}\n{\"inputs\": {\"body_acceleration_m_s2\": 100}}\n{\"inputs\": {\"none\": 1}}\nno JSON\n\
        {\"reset\": true, \"target\": {\"xmax_z_m\": 0.0055}, \"moving\": [\"body_acceleration_m_s2\"]}\n\
        {\"reset\": true, \"target\": {\"xmax_z_m\": 0.0055}}\n{\"moving\": [\"body_acceleration_m_s2\"]}\n";
    let stepped = durometer_with(at, &["twin", &model], protocol);
    assert_eq!(stepped.code, Some(0), "{}", stepped.err);
    let answers = lines(&stepped.out);
    assert_eq!(answers.len(), 8, "{}", stepped.out);
    let inputs: Vec<&str> =
        answers[0]["inputs"].as_array().expect("inputs").iter().filter_map(|i| i["name"].as_str()).collect();
    assert_eq!(inputs.len(), 2, "{inputs:?}");
    assert_eq!((&answers[0]["modes"], &answers[0]["supremisers"]), (&5.into(), &0.into()), "{}", answers[0]);
    assert!(
        answers[1]["in_range"] == true && answers[1]["quantities"]["xmax_z_m"]["bar"].is_number(),
        "{}",
        answers[1]
    );
    assert!(answers[2]["in_range"] == false && answers[2]["quantities"]["xmax_z_m"]["bar"].is_null(), "{}", answers[2]);
    for refused in &answers[3..5] {
        assert!(refused["error"].is_string(), "{refused}");
    }
    the_weight_is_held(&answers);

    refused_lines_have_no_effect(at, &model);
    let strict = durometer_with(at, &["twin", &model, "--tolerance", "1e-9", "--stop"], protocol);
    assert_eq!(strict.code, Some(3), "{}", strict.out);
    assert_eq!(durometer(at, &["twin", "scene.toml"]).code, Some(2));
    clients_have_the_answers_of_a_pipe(at, &model);

    // Models answer what the study asks for now
    write(at, "study.toml", &STUDY.replace("xmax_z_m", "xmax_x_m"));
    for out in ["out", "fresh"] {
        let ran = durometer(at, &["run", "study.toml", "--out", out]);
        assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    }
    let of = |out: &str| -> Value {
        let text = std::fs::read(at.join(out).join("derived.json")).expect("it is there");
        let record: Value = serde_json::from_slice(&text).expect("JSON");
        record["models"].as_array().expect("models").iter().map(|m| m["quantities"].clone()).collect()
    };
    assert_eq!(of("out")[0][0]["name"], "xmax_x_m");
    assert_eq!(of("out"), of("fresh"));
}

/// A line that cannot be meant so has no effect, and its answer says why.
fn refused_lines_have_no_effect(at: &Path, model: &str) {
    let held = "{\"inputs\": {\"cable_imposed_tension_N\": 0.2}}\n{\"reset\": \"yes\"}\n{\"reset\": true, \"inputs\": {\"none\": 1}}\n\
        {\"inputs\": {\"cable_imposed_tension_N\": 0.1, \"cable_imposed_tension_N\": 0.3}}\n{\"inputs\": {}}\n";
    let held = lines(&durometer_with(at, &["twin", model], held).out);
    assert!(held[2..5].iter().all(|refused| refused["error"].is_string()), "{held:?}");
    assert_eq!(held[1]["inputs"], held[5]["inputs"]);
    // Nor has a reset with inputs at which there is no equilibrium, and it is no answer to be trusted
    let far = "{\"inputs\": {\"cable_imposed_tension_N\": 0.2}}\n{\"reset\": true, \"inputs\": {\"body_acceleration_m_s2\": 1e9}}\n{\"inputs\": {}}\n";
    let answered = lines(&durometer_with(at, &["twin", model], far).out);
    assert!(answered[2]["error"].is_string(), "{answered:?}");
    assert_eq!(answered[1]["inputs"], answered[3]["inputs"]);
    let stopped = durometer_with(at, &["twin", model, "--tolerance", "5%", "--stop"], far);
    assert_eq!((stopped.code, lines(&stopped.out).len()), (Some(3), 3), "{}", stopped.out);
    // An endless line is none, and the next one is answered
    let endless = format!("{}\n{far}", "x".repeat(1 << 20));
    let stopped = durometer_with(at, &["twin", model, "--tolerance", "5%", "--stop"], &endless);
    assert_eq!((stopped.code, lines(&stopped.out).len()), (Some(3), 4), "{}", stopped.out);
    // A target is searched at the given inputs or not at all
    let elsewhere = far.replace("\"reset\": true,", "\"target\": {\"xmax_z_m\": 0.0055},");
    let answered = lines(&durometer_with(at, &["twin", model], &elsewhere).out);
    assert!(answered[2]["error"].is_string(), "{answered:?}");
    assert_eq!(answered[1]["inputs"], answered[3]["inputs"]);
}

/// The weight is that of the scene, and no search moves it that is not told so: the cable alone only bends the bar down. The first line says what the bars rest on.
fn the_weight_is_held(answers: &[Value]) {
    let weight = &answers[0]["inputs"][0];
    assert!(
        weight["name"] == "body_acceleration_m_s2" && weight["value"] == 9.81 && weight["held"] == true,
        "{weight}"
    );
    assert_eq!(answers[1]["inputs"]["body_acceleration_m_s2"], 9.81, "{}", answers[1]);
    assert!(answers[5]["target_met"] == true && answers[6]["target_met"] == false, "{} {}", answers[5], answers[6]);
    assert_eq!(answers[6]["inputs"]["body_acceleration_m_s2"], 9.81, "{}", answers[6]);
    assert!(answers[7]["error"].as_str().is_some_and(|why| why.contains("moving")), "{}", answers[7]);
    assert_eq!(answers[0]["held_back"], 20);
    let confidence = answers[0]["confidence"].as_f64().expect("a number");
    assert!((confidence - (1.0 - 0.95_f64.powi(20))).abs() < 1e-12, "{confidence}");
}

/// The time of the full model is that of one of the ten states of each run that was held back: in the median the mean of two runs.
fn a_full_step_is_that_between_neighbours(folder: &Path, record: &Value) {
    let cpu_s = |run: usize| {
        let file = folder.join(format!("out/cases/held-back-static-{run}.json"));
        let case: Value = serde_json::from_slice(&std::fs::read(file).expect("its record")).expect("JSON");
        case["cpu_s"].as_f64().expect("a time")
    };
    let (found, expected) = (record["full_step_s"].as_f64().expect("a time"), 0.05 * (cpu_s(1) + cpu_s(2)));
    assert!((found - expected).abs() <= 1e-9 * expected, "{found} s and {expected} s");
    assert_eq!(record["full_from_rest"], false);
}

/// The states that were held back are of an even number, so that a median is the mean of the two in the middle.
fn medians_are_those_of_the_errors(record: &Value) {
    for model in record["models"].as_array().expect("models") {
        for quantity in model["quantities"].as_array().expect("quantities") {
            let errors = quantity["errors"].as_array().expect("errors").iter();
            let mut sizes: Vec<f64> = errors.map(|e| e[0].as_f64().expect("an error").abs()).collect();
            sizes.sort_by(f64::total_cmp);
            assert!(sizes.len() == 20 && quantity["largest"] == sizes[19], "{quantity}");
            assert_eq!(quantity["median"], 0.5 * (sizes[9] + sizes[10]), "{quantity}");
        }
    }
}

/// A program that ends with the test, also where an assertion fails.
struct Server(Child);

impl Drop for Server {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Two clients after one another have the same answers as a pipe; one that sends no text, and one that sends an endless line, harm nobody.
fn clients_have_the_answers_of_a_pipe(folder: &Path, model: &str) {
    let line = "{\"inputs\": {\"cable_imposed_tension_N\": 0.2}}\n";
    let values = |answer: &Value| answer["quantities"].clone();
    let piped = values(&lines(&durometer_with(folder, &["twin", model], line).out)[1]);
    let mut command = program(folder, &["twin", model, "--listen", "0"]);
    let child = command.stdout(Stdio::piped()).spawn().expect("the program starts");
    let mut server = Server(child);
    let mut first = String::new();
    BufReader::new(server.0.stdout.take().expect("it is piped")).read_line(&mut first).expect("a line");
    let listening: Value = serde_json::from_str(&first).expect("JSON");
    let address = listening["listening"].as_str().expect("an address").to_string();
    assert!(address.starts_with("127.0.0.1:"), "{address}");
    let connect = |text: &[u8], answers: usize| -> Vec<Value> {
        let mut stream = TcpStream::connect(&address).expect("it listens");
        stream.write_all(text).ok();
        let read = BufReader::new(&stream).lines().take(answers).map_while(Result::ok);
        read.map(|line| serde_json::from_str(&line).expect("JSON")).collect()
    };
    connect(&[0xff, b'\n'], 1);
    connect(&vec![b'x'; 2 << 20], 1);
    connect(b"", 0);
    for _ in 0..2 {
        let answers = connect(line.as_bytes(), 2);
        assert_eq!(values(&answers[1]), piped);
    }
    let port = address.rsplit(':').next().expect("a port");
    assert_eq!(durometer(folder, &["twin", model, "--listen", port]).code, Some(2), "the port is taken");
}

/// The bar with its mass and a relaxing rubber, whose inputs change in time: the models move, and the program takes a step in time for each line, with the bits
/// that it had before.
#[test]
fn a_study_makes_models_that_move() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let parts = "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1100 kg/m^3\"\nmass = \"consistent\"\n\
        [[effect]]\nkind = \"viscous_damping\"\nregion = \"body\"\neta = \"100 Pa s\"\n\
        [[effect]]\nkind = \"viscoelastic\"\nregion = \"body\"\nlaw = \"rubber\"\nmoduli = \"instantaneous\"\n\
        prony = [{ g = 0.2, tau = \"20 ms\" }]\n[[stage]]\nintegrator = \"bdf2\"\nduration = \"1 s\"\ndt = \"10 ms\"\n";
    write(
        at,
        "scene.toml",
        &SCENE
            .replace("\"neo_hookean\"", "\"neo_hookean_split\"")
            .replace("[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n", parts),
    );
    let in_time = "modes = [3, 6]\nmotion = { duration = \"0.2 s\", corner = \"0.1 s\" }";
    let study = STUDY.replace("modes = [2, 5]", in_time).replace("training = 24", "training = 8");
    let study = study.replace("held_back = 20", "held_back = 12").replace("\"-10 m/s^2\"", "\"0 m/s^2\"");
    write(at, "study.toml", &study);
    let ran = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    let read = |name: &str| std::fs::read_to_string(at.join("out").join(name)).expect("it is there");
    let record: Value = serde_json::from_str(&read("derived.json")).expect("JSON");
    assert!(record["dt"] == 0.01 && record["training"] == 8 && record["held_back"] == 12, "{record}");
    assert_eq!(record["models"].as_array().map(Vec::len), Some(2), "{}", record["left_out"]);
    let summary: Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    let verdict = summary["verdict"].as_str().expect("words");
    assert!(verdict.contains("every step of"), "{verdict}");
    assert!(read("index.html").contains("in at least 95 % of further runs"));

    let model = format!("out/{}", record["models"][1]["file"].as_str().expect("a file"));
    let lines_in = "{\"inputs\": {\"cable_imposed_tension_N\": 0.01}}\n{}\n{\"reset\": true}\n{\"inputs\": {\"cable_imposed_tension_N\": 0.01}}\n\
        {\"target\": {\"xmax_z_m\": 0.005001}}\n{\"inputs\": {}, \"target\": {\"xmax_z_m\": 0.005}}\n{\"inputs\": {\"cable_imposed_tension_N\": 0.4}}\n";
    let stepped = durometer_with(at, &["twin", &model], lines_in);
    assert_eq!(stepped.code, Some(0), "{}", stepped.err);
    let answers = lines(&stepped.out);
    assert!(answers[0]["dt_s"] == 0.01 && answers[0]["inputs"][0]["largest_change"].is_number(), "{}", answers[0]);
    let times: Vec<f64> = answers[1..6].iter().filter_map(|a| a["t_s"].as_f64()).collect();
    assert_eq!(times, [0.01, 0.02, 0.0, 0.01, 0.02], "{}", stepped.out);
    assert_eq!(answers[1]["quantities"], answers[4]["quantities"]);
    assert!(answers[1]["quantities"]["xmax_z_m"]["bar"].is_number(), "{}", answers[1]);
    assert!(answers[5]["target_met"].is_boolean() && answers[6]["error"].is_string(), "{}", stepped.out);
    assert!(answers[7]["in_range"] == false && answers[7]["quantities"]["xmax_z_m"]["bar"].is_null(), "{}", answers[7]);

    // Inputs that are not given are those of the last step, also where a target has found them
    let targeted = "{\"inputs\": {\"cable_imposed_tension_N\": 0.01}}\n{\"target\": {\"xmax_z_m\": 0.005001}}\n{\"inputs\": {}}\n\
        {\"reset\": true, \"inputs\": {}, \"target\": {\"xmax_z_m\": 0.005}}\n{}\n";
    let targeted = lines(&durometer_with(at, &["twin", &model], targeted).out);
    assert_ne!(targeted[1]["inputs"], targeted[2]["inputs"]);
    assert_eq!(targeted[2]["inputs"], targeted[3]["inputs"]);
    assert!(
        targeted[4]["error"].is_string() && targeted[5]["t_s"] == 0.04,
        "a refused line resets nothing: {targeted:?}"
    );

    // The duration of a run is that of one stage
    let second = "[[stage]]\nintegrator = \"bdf2\"\nduration = \"1 s\"\ndt = \"10 ms\"\n";
    let scene = std::fs::read_to_string(at.join("scene.toml")).expect("it was written");
    write(at, "scene.toml", &(scene.clone() + second));
    let ran = durometer(at, &["check", "study.toml"]);
    assert!(ran.code == Some(2) && ran.err.contains("the scene has 2 stages"), "{}\n{}", ran.out, ran.err);
    let (before, stage) = scene.split_once("[[stage]]").expect("a stage");
    let line = stage.lines().find(|line| line.starts_with("integrator")).expect("an integrator");
    write(at, "scene.toml", &format!("{before}[[stage]]{}", stage.replacen(line, "integrator = \"static\"", 1)));
    let ran = durometer(at, &["check", "study.toml"]);
    assert!(ran.code == Some(2) && ran.err.contains("static: it has no time"), "{}\n{}", ran.out, ran.err);
    write(at, "scene.toml", &scene);

    for (from, to, word) in [
        ("corner = \"0.1 s\"", "corner = \"0.3 s\"", "longer"),
        ("duration = \"0.2 s\"", "duration = \"0.2 m\"", "duration"),
    ] {
        write(at, "study.toml", &study.replacen(from, to, 1));
        let ran = durometer(at, &["run", "study.toml", "--out", "refused"]);
        assert!(ran.code == Some(2) && ran.err.contains(word), "{to}: {}\n{}", ran.out, ran.err);
    }
}

/// Two iterations are too few for the largest loads: their steps are cut, and a model of one step is not made of states at other times. The runs and the step are
/// named.
#[test]
fn runs_with_cut_steps_make_no_model() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let parts = "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1100 kg/m^3\"\nmass = \"consistent\"\n\
        [[stage]]\nintegrator = \"implicit_euler\"\nduration = \"1 s\"\ndt = \"20 ms\"\n[numerics]\nmax_iterations = 2\n";
    let scene = SCENE.replace("[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n", parts);
    write(at, "scene.toml", &scene.replace("[8, 2, 2]", "[4, 1, 1]"));
    let in_time = "modes = [3]\nmotion = { duration = \"0.2 s\", corner = \"0.1 s\" }";
    let study = STUDY.replace("modes = [2, 5]", in_time).replace("training = 24", "training = 3");
    let study = study.replace("held_back = 20", "held_back = 2").replace("\"-10 m/s^2\"", "\"0 m/s^2\"");
    write(at, "study.toml", &study);
    let ran = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert_eq!(ran.code, Some(3), "{}\n{}", ran.out, ran.err);
    for words in ["no model could be made", "dt = 0.02 s were cut", "training-in-time-1", "held-back-in-time-2"] {
        assert!(ran.err.contains(words), "{words}: {}", ran.err);
    }
}

/// Few points of little accuracy far from rest: the model with 8 modes has no equilibrium at states that were held back. The others are not lost by it,
/// and every model that is kept can be read.
#[test]
fn a_model_without_an_equilibrium_is_left_out_with_a_warning() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write(at, "scene.toml", SCENE);
    let harder = [
        ("\"0.4 N\"", "\"5 N\""),
        ("modes = [2, 5]", "modes = [5, 8]"),
        ("[[input]]", "sampling = \"5 %\"\n[[input]]"),
    ];
    let study = harder.iter().fold(STUDY.to_string(), |text, (from, to)| text.replacen(from, to, 1));
    write(at, "study.toml", &study);
    let ran = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    let read = |name: &str| std::fs::read_to_string(at.join("out").join(name)).expect("it is there");
    let record: Value = serde_json::from_str(&read("derived.json")).expect("JSON");
    let kept: Vec<&str> =
        record["models"].as_array().expect("models").iter().filter_map(|m| m["file"].as_str()).collect();
    assert!(kept.len() == 1 && kept[0].ends_with("-5.durom"), "{kept:?}");
    assert_eq!(durometer_with(at, &["twin", &format!("out/{}", kept[0])], "{}\n").code, Some(0));
    let summary: Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    let warnings = summary["warnings"].to_string();
    assert!(warnings.contains("8 modes") && warnings.contains("no equilibrium"), "{warnings}");
    assert!(!read("index.html").contains("run is missing"));
}

/// A cable that is slack in most of the states, where its tension is exact: bars are of the size of the errors in the others, and every model is kept and read.
#[test]
fn a_cable_that_is_often_slack_has_bars_of_the_size_of_its_errors() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let length = "drive = { kind = \"length\", signal = \"0 mm\" }";
    write(at, "scene.toml", &SCENE.replace("drive = { kind = \"tension\", signal = \"0 N\" }", length));
    let slack = [
        ("\"0 N\", \"0.4 N\"", "\"-3 mm\", \"1 mm\""),
        ("xmax_z_m", "cable_tension_N"),
        ("unit = \"m\"", "unit = \"N\""),
    ];
    write(at, "study.toml", &slack.iter().fold(STUDY.to_string(), |text, (from, to)| text.replacen(from, to, 1)));
    let ran = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert!(!ran.out.contains("No verdict"), "{}\n{}", ran.out, ran.err);
    let methods = std::fs::read_to_string(at.join("out/paper/methods.md")).expect("it is there");
    assert!(methods.contains("tension from −3 to 1 mm") && methods.contains("made of 24 states"), "{methods}");
    let record = std::fs::read(at.join("out/derived.json")).expect("it is there");
    let record: Value = serde_json::from_slice(&record).expect("JSON");
    let models = record["models"].as_array().expect("models");
    assert_eq!(models.len(), 2, "{record}");
    for model in models {
        let tension = &model["quantities"][0];
        let number = |key: &str| tension[key].as_f64().unwrap_or(f64::NAN);
        let exact = tension["errors"].as_array().expect("errors").iter().filter(|e| e[0] == 0.0).count();
        assert!(exact >= 5, "slack in {exact} states");
        let bar = number("factor") * number("floor");
        assert!(bar > 1e-6 * number("largest") && number("factor") < 1e3, "{tension}");
        // The ratio of bar and error is that of the errors that are more than rounding
        let errors = tension["errors"]
            .as_array()
            .expect("errors")
            .iter()
            .filter_map(|e| Some((e[0].as_f64()?.abs(), e[1].as_f64()?.abs())));
        let counting = errors.filter(|(error, _)| *error > 1e-9 * number("size"));
        let mut ratios: Vec<f64> =
            counting.map(|(error, estimate)| number("factor") * (estimate + number("floor")) / error).collect();
        ratios.sort_by(f64::total_cmp);
        let middle = 0.5 * (ratios[(ratios.len() - 1) / 2] + ratios[ratios.len() / 2]);
        assert!((number("bar_over_error") / middle - 1.0).abs() < 1e-9, "{tension}");
        let answer = durometer_with(at, &["twin", &format!("out/{}", model["file"].as_str().expect("a file"))], "{}\n");
        assert_eq!(answer.code, Some(0), "{}", answer.err);
    }
}

/// Every mistake of a study file is named with a remedy before anything runs.
#[test]
fn mistakes_of_a_study_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write(at, "scene.toml", SCENE);
    for (from, to, word) in [
        ("range = [\"0 N\", \"0.4 N\"]", "range = [\"0.4 N\", \"0 N\"]", "write range = [\"0 N\", \"0.4 N\"]"),
        ("range = [\"0 N\", \"0.4 N\"]", "range = [0, 0.4]", "unit"),
        ("range = [\"0 N\", \"0.4 N\"]", "range = [\"0\", \"0.4\"]", "unit"),
        ("range = [\"0 N\", \"0.4 N\"]", "range = [\"0 mm\", \"0.4 mm\"]", "dimension"),
        ("key = \"effect.gravity.acceleration\"", "key = \"effect.none.acceleration\"", "none"),
        (
            "key = \"effect.gravity.acceleration\"",
            "key = \"constraint.1.drive.signal\"",
            "is that of the input tension too",
        ),
        ("training = 24", "training = 6", "twice"),
        ("modes = [2, 5]", "modes = []", "modes"),
        ("name = \"xmax_z_m\"", "name = \"xmax_q_m\"", "xmax_q_m"),
        ("held_back = 20", "held_back = 20\nruns = 0", "run"),
        ("held_back = 20", "held_back = 0", "59 or more"),
        ("held_back = 20", "held_back = 20\nsampling = \"6 %\"", "5 %"),
        // What only models at rest have
        (
            "training = 24",
            "motion = { duration = \"2 s\", corner = \"1 s\" }\ntraining = { kind = \"grid\", each = 5 }",
            "plan",
        ),
        (
            "held_back = 20",
            "held_back = 20\nmotion = { duration = \"2 s\", corner = \"1 s\" }\nreference = { \"mesh.grid.divisions\" = [9, 2, 2] }",
            "meshes",
        ),
    ] {
        assert!(STUDY.contains(from), "{from}");
        write(at, "study.toml", &STUDY.replacen(from, to, 1));
        let ran = durometer(at, &["run", "study.toml", "--out", "refused"]);
        assert_eq!(ran.code, Some(2), "{to}: {}\n{}", ran.out, ran.err);
        assert!(ran.err.contains(word), "{to}: {}", ran.err);
    }
}

/// An input is a whole signal, and not a term of a sum or a factor in one. It is refused before anything runs, with the key of the whole.
#[test]
fn a_part_of_a_signal_is_no_input() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let whole = "constraint.cable.drive.signal";
    for (signal, key) in [
        ("{ kind = \"sum\", of = [\"0 N\", \"0.1 N\"] }", "of.0"),
        ("{ kind = \"sum\", of = [\"0 N\", { kind = \"product\", of = [\"0 N\", -1] }] }", "of.1.of.0"),
        ("{ kind = \"hold\", signal = \"0 N\", at = \"1 s\" }", "signal"),
    ] {
        write(at, "scene.toml", &SCENE.replace("signal = \"0 N\"", &format!("signal = {signal}")));
        write(at, "study.toml", &STUDY.replace(whole, &format!("{whole}.{key}")));
        for arguments in [&["check", "study.toml"][..], &["run", "study.toml", "--out", "out"]] {
            let ran = durometer(at, arguments);
            assert_eq!(ran.code, Some(2), "{key}: {}\n{}", ran.out, ran.err);
            assert!(ran.err.contains("part of the signal") && ran.err.contains(whole), "{key}: {}", ran.err);
            assert!(!at.join("out/cases").exists(), "{key}");
        }
    }
}

/// Where no model can be made the study has no result: exit code 3, with the reason on the page, in the summary and in the terminal.
#[test]
fn a_study_without_models_is_not_complete() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write(at, "scene.toml", SCENE);
    // 8 modes alone, far from rest, with the fewest points: see the test before
    let harder =
        [("\"0.4 N\"", "\"5 N\""), ("modes = [2, 5]", "modes = [8]"), ("[[input]]", "sampling = \"5 %\"\n[[input]]")];
    let study = harder.iter().fold(STUDY.to_string(), |text, (from, to)| text.replacen(from, to, 1));
    write(at, "study.toml", &study);
    let ran = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert_eq!(ran.code, Some(3), "{}\n{}", ran.out, ran.err);
    assert!(ran.err.contains("no model could be made") && ran.err.contains("8 modes"), "{}", ran.err);
    let summary: Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("out/summary.json")).expect("it is there"))
            .expect("JSON");
    assert!(summary["without_result"].as_str().is_some_and(|why| why.contains("no equilibrium")), "{summary}");
}

/// Contact has no bar that could be stated, and an energy is no function that a model gives: both are refused before a run, with what there is.
#[test]
fn what_has_no_reduced_form_is_refused_before_a_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let floor = "[[contact]]\nname = \"floor\"\nregion = \"xmax\"\nresponse = \"barrier\"\nfriction = 0.0\nobstacle = { kind = \"floor\", point = [\"0 mm\", \"0 mm\", \"-5 mm\"], normal = [0, 0, 1] }\n";
    let energy = "[[probe]]\nkind = \"energy\"\n";
    let knock = "[[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"y\"\ndisplacement = { kind = \"points\", unit = \"mm\", of = [[0, 0], [0.05, 8], [0.1, 0]] }\n";
    let of_energy = STUDY.replace("xmax_z_m", "elastic_J").replace("unit = \"m\"", "unit = \"J\"");
    for (more, study, words) in [
        (floor, STUDY, ["contact floor", "its error cannot be stated"]),
        (knock, STUDY, ["a prescribed motion", "the modes are at rest where the body is held"]),
        (energy, &of_energy, ["gives no \"elastic_J\"", "xmax_x_m, xmax_y_m, xmax_z_m"]),
    ] {
        write(at, "scene.toml", &format!("{SCENE}{more}"));
        write(at, "study.toml", study);
        for arguments in [&["check", "study.toml"][..], &["run", "study.toml", "--out", "out"]] {
            let ran = durometer(at, arguments);
            assert_eq!(ran.code, Some(2), "{}\n{}", ran.out, ran.err);
            assert!(words.iter().all(|word| ran.err.contains(word)), "{}", ran.err);
            assert!(
                !at.join("out/cases").exists() || std::fs::read_dir(at.join("out/cases")).is_ok_and(|d| d.count() == 0)
            );
        }
    }
}
