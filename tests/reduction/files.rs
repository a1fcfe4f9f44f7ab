//! The files of reduced models, and those that their scene names: a model is under the report of the inputs that it was made of.

use crate::bar::SCENE;
use crate::common::program::{durometer, durometer_with};
use crate::study::{STUDY, write};
use durometer::reduction::training::full_model::FullModelError;
use durometer::reduction::{FullModel, ReducedModel};
use serde_json::Value;
use std::path::Path;

/// The scene with the places of its cable in a file, and the study with models of 2 and 5 modes.
fn written(at: &Path) {
    let guides = "guides = [[\"15 mm\", \"5 mm\", \"2 mm\"], [\"35 mm\", \"5 mm\", \"2 mm\"]]";
    assert!(SCENE.contains(guides));
    let scene = SCENE.replace(guides, "guides = { file = \"guides.csv\", unit = \"mm\" }");
    write(at, "scene.toml", &(scene + COMPARED));
    write(at, "measured.csv", "t,z\n0,5\n1,5\n");
    write(at, "guides.csv", LOW);
    write(at, "study.toml", STUDY);
}

/// Measured data, on which no state depends.
const COMPARED: &str = "[[compare]]\ncolumn = \"xmax_z_m\"\nfile = \"measured.csv\"\n\
    x = { column = \"t\", unit = \"s\" }\ny = { column = \"z\", unit = \"mm\" }\n";
const LOW: &str = "x,y,z\n15,5,2\n35,5,2\n";
const HIGH: &str = "x,y,z\n15,5,4\n35,5,4\n";

fn json(file: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(file).expect("it is there")).expect("JSON")
}

/// The files of the models in a folder of results, as its record has them.
fn models(dir: &Path) -> Vec<String> {
    let record = json(&dir.join("derived.json"));
    let files = record["models"].as_array().expect("models").iter().filter_map(|m| m["file"].as_str());
    files.map(String::from).collect()
}

/// A model in the place of another one is no model of the report; where inputs have changed, no model of others stays, also where no new one is made yet.
#[test]
fn a_model_is_that_of_the_present_inputs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    written(at);
    let run = |more: &[&str]| {
        let ran = durometer(at, &[&["run", "study.toml", "--out", "out"][..], more].concat());
        assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    };
    run(&[]);
    let out = at.join("out");
    let files = models(&out);
    let read = |file: &String| std::fs::read(out.join(file)).expect("a model");
    let made: Vec<Vec<u8>> = files.iter().map(read).collect();
    assert_eq!(files.len(), 2);

    std::fs::copy(out.join(&files[1]), out.join(&files[0])).expect("room");
    run(&[]);
    assert!(files.iter().map(read).eq(made.iter().cloned()), "each is the one that was made");

    // Models that were not made anew are those of the report
    std::fs::remove_file(out.join("report.json")).expect("it was there");
    assert_eq!(durometer(at, &["report", "out"]).code, Some(0));
    let scene = std::fs::read_to_string(at.join("scene.toml")).expect("it is there");
    write(at, "scene.toml", &scene.replace("60 kPa", "120 kPa"));
    run(&["--only", "training"]);
    assert!(files.iter().all(|file| !out.join(file).exists()), "they are of 60 kPa");
    assert_eq!(json(&out.join("report.json"))["derived"], Value::Null);

    run(&[]);
    assert_eq!(models(&out), files);
    assert!(files.iter().map(read).zip(&made).all(|(now, before)| now != *before));
    write(at, "scene.toml", &scene);
    run(&[]);
    assert!(files.iter().map(read).eq(made));
}

/// Cases whose scene names a file that was edited since have no new models, and the report says why; models that they have stay, also those of another build. Measured data that the scene is compared with are none of these files.
#[test]
fn models_are_made_with_the_files_of_their_cases() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    written(at);
    let ran = durometer(at, &["run", "study.toml", "--out", "out", "--partition", "1/1"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    let out = at.join("out");
    let reported = || durometer(at, &["report", "out"]);
    let report = || {
        reported();
        let summary = json(&out.join("summary.json"));
        (summary["verdict"].as_str().expect("words").to_string(), summary["warnings"].to_string())
    };
    write(at, "guides.csv", HIGH);
    let (verdict, warnings) = report();
    assert!(verdict.starts_with("No verdict: no model could be made"), "{verdict}");
    assert!(warnings.contains("the file guides.csv has other contents now"), "{warnings}");
    let told = reported();
    assert!(
        told.code == Some(3) && told.err.contains("not complete: ") && told.err.contains("guides.csv"),
        "{}",
        told.err
    );
    std::fs::remove_file(at.join("guides.csv")).expect("it was there");
    let (verdict, warnings) = report();
    assert!(verdict.starts_with("No verdict"), "{verdict}");
    assert!(warnings.contains("the file guides.csv cannot be read") && !out.join("models").exists(), "{warnings}");

    write(at, "guides.csv", LOW);
    write(at, "measured.csv", "t,z\n0,5\n1,4\n");
    let (of_cases, warnings) = report();
    assert!(of_cases.starts_with("The model of") && !warnings.contains("guides.csv"), "{of_cases} {warnings}");
    write(at, "guides.csv", HIGH);
    assert_eq!(report().0, of_cases, "the models that are there are of these cases");
    the_full_model_has_the_files_of_the_study(at, &format!("out/{}", models(&out)[1]));
    let own = std::fs::read_to_string(out.join("derived.json")).expect("it is there");
    let sources = json(&out.join("derived.json"))["sources_sha256"].as_str().expect("a digest").to_string();
    write(&out, "derived.json", &own.replace(&sources, "that of another build"));
    let (verdict, warnings) = report();
    assert_eq!(verdict, of_cases);
    assert!(warnings.contains("not made anew") && warnings.contains("guides.csv"), "{warnings}");
    assert!(models(&out).iter().all(|file| out.join(file).is_file()));
}

/// A study is one wherever it is called from, and a report finds its scene and the files that this names.
#[test]
fn the_folder_of_the_call_does_not_matter() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (above, at) = (folder.path(), folder.path().join("inside"));
    std::fs::create_dir(&at).expect("room");
    written(&at);
    let ran = durometer(&at, &["run", "study.toml", "--out", "out", "--partition", "1/1"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    let reported = durometer(above, &["report", "inside/out"]);
    assert_eq!(reported.code, Some(0), "{}\n{}", reported.out, reported.err);
    let summary = json(&at.join("out/summary.json"));
    assert!(summary["verdict"].as_str().is_some_and(|verdict| verdict.starts_with("The model of")), "{summary}");
    let [study, made] = ["study.json", "derived.json"].map(|name| at.join("out").join(name));
    let read = || [&study, &made].map(|file| std::fs::read(file).expect("it is there"));
    let before = read();
    let ran = durometer(above, &["run", "inside/study.toml", "--out", "inside/out"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.out, ran.err);
    assert!(read() == before, "the study is the same, and its models are not made again");
}

/// The guides are at other places now: the full model is refused, also in the library. A model that does not know the files takes them, and they are named.
fn the_full_model_has_the_files_of_the_study(at: &Path, file: &str) {
    let step = || durometer_with(at, &["twin", file, "--tolerance", "1%", "--full", "scene.toml"], "{}\n");
    let refused = step();
    assert!(refused.code == Some(2) && refused.err.contains("other contents of guides.csv"), "{}", refused.err);
    let (mut model, scene) = (ReducedModel::read(&at.join(file)).expect("a model"), at.join("scene.toml"));
    let opened = |model: &ReducedModel| FullModel::open(model, &scene);
    assert!(matches!(opened(&model), Err(FullModelError::OtherFile { other, .. }) if other == "guides.csv"));
    write(at, "guides.csv", LOW);
    write(at, "measured.csv", "t,z\n0,5\n1,3\n");
    assert_eq!(opened(&model).map(|full| full.uncompared().len()).map_err(|e| e.to_string()), Ok(0));
    let taken = step();
    assert!(taken.code == Some(0) && !taken.err.contains("guides.csv"), "{}", taken.err);
    write(at, "guides.csv", HIGH);
    model.origin.files.clear();
    let full = opened(&model).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(full.uncompared(), ["guides.csv"]);
}
