//! Every reader of a text table: the same numbers of every spelling, and the same refusals.

use super::Expected::{Read, Refused};
use super::compared;
use super::dialects::spellings;
use durometer::calibrate::inverse::Measured;
use durometer::calibrate::volume::{VolumeRequest, VolumeTest, fit_volume};
use durometer::motion::{ReadOptions, Tracks};
use durometer::study::kinds::validation::measured;
use std::path::Path;

/// The numbers that a reader takes from a file in a folder.
type Reader = fn(&Path, &[u8]) -> Result<Vec<f64>, String>;

/// `[[compare]]` of a scene.
fn scene(folder: &Path, bytes: &[u8]) -> Result<Vec<f64>, String> {
    let read = compared::read(folder, bytes, compared::OF_THE_TABLE)?;
    Ok([read.x, read.y].concat())
}

fn written(folder: &Path, bytes: &[u8]) {
    std::fs::write(folder.join("table.csv"), bytes).expect("writable");
}

/// `measured` of a study of kind `calibration`.
fn calibration(folder: &Path, bytes: &[u8]) -> Result<Vec<f64>, String> {
    written(folder, bytes);
    let spec = "file = \"table.csv\"\nx = { column = \"u\", unit = \"mm\", is = \"cable_length_m\" }\ny = { column = \"F\", unit = \"N\", is = \"cable_tension_N\" }";
    let read = Measured::read(folder, &toml::from_str(spec).expect("sound")).map_err(|e| e.to_string())?;
    Ok([read.x, read.y].concat())
}

/// The columns of `prony` and `volume`.
fn roles(folder: &Path, bytes: &[u8]) -> Result<Vec<f64>, String> {
    written(folder, bytes);
    let request = VolumeRequest::new(folder.join("table.csv"), VolumeTest::Lateral);
    fit_volume(&request).map(|fit| vec![fit.value.value]).map_err(|e| e.to_string())
}

/// Tracks of markers.
fn motion(_: &Path, bytes: &[u8]) -> Result<Vec<f64>, String> {
    let read = Tracks::parse("table.csv", bytes, &ReadOptions::default()).map_err(|e| e.to_string())?;
    let points = read.markers.iter().flat_map(|m| m.points.iter().flatten().flatten().copied());
    Ok(read.time_s.iter().copied().chain(points).collect())
}

/// `table` of a quantity of a validation.
fn validation(folder: &Path, bytes: &[u8]) -> Result<Vec<f64>, String> {
    written(folder, bytes);
    let spec = "file = \"table.csv\"\ncolumn = \"x\"\nunit = \"mm\"\nwhere = { experiment = \"{experiment}\" }";
    measured::table(folder, &toml::from_str(spec).expect("sound"), "mm")?.values("bend")
}

/// The fit of a tensile test is in `dialects`.
fn readers() -> [(&'static str, Reader, String, &'static str); 5] {
    let row = |k: u32| {
        let e = 0.005 * f64::from(k);
        format!("{},{}\n", 100.0 * e, 100.0 * ((1.0 + e).powf(-0.43) - 1.0))
    };
    let lateral: String = (0..40).map(row).collect();
    let curve = "0,0\n0.5,1.25\n1.5,2.5\n2.25,3.75\n";
    let tracks = "0,10,2,3\n0.25,11.5,2.25,3.5\n0.5,12.25,2.5,3.25\n0.75,13.5,2.25,3.5\n";
    let rows = "bend,0\nbend,0.5\ntwist,7.5\nbend,2.25\n";
    [
        ("a scene", scene, format!("t (s),F (N)\n{curve}"), "t,F\n,\ns,N"),
        ("a calibration", calibration, format!("u (mm),F (N)\n{curve}"), "u,F\n,\nmm,N"),
        (
            "a change of volume",
            roles,
            format!("strain [%],transverse strain [%]\n{lateral}"),
            "strain,transverse strain\n,\n%,%",
        ),
        ("motion", motion, format!("t_s,a_x_mm,a_y_mm,a_z_mm\n{tracks}"), "t_s,a_x,a_y,a_z\n,,,\ns,mm,mm,mm"),
        ("a validation", validation, format!("experiment,x (mm)\n{rows}"), "experiment,x\n,\n,mm"),
    ]
}

#[test]
fn every_reader_takes_and_refuses_the_same_spellings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut faults = vec![];
    for (name, read, text, below) in readers() {
        let numbers = read(folder.path(), text.as_bytes()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let is_same = |own: &[f64]| {
            own.len() == numbers.len() && own.iter().zip(&numbers).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs())
        };
        for (spelling, bytes, expected) in spellings(&text, below) {
            match (read(folder.path(), &bytes), expected) {
                (Ok(own), Read) if is_same(&own) => {}
                (Err(error), Refused(facts)) if facts.iter().all(|fact| error.contains(fact)) => {}
                (found, _) => faults.push(format!("{name}, {spelling}: {found:?}")),
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The decimal commas of a table divided by commas once gave u = 1, 2 and F = 5, 5 without a word.
#[test]
fn decimal_commas_between_commas_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let error = calibration(folder.path(), b"u,F\n1,5,2,3\n2,5,2,9\n").expect_err("two readings");
    let fact = "table.csv: line 2 has 4 cells under 2 names, and too many are in line 3 as well";
    assert!(error.contains(fact) && error.contains("export it with ;"), "{error}");
}

/// A value is looked up in its row by a name, with the unit that the table states.
#[test]
fn tables_of_a_validation_are_checked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let read = |text: &str| validation(folder.path(), text.as_bytes());
    assert_eq!(read("Camera;7\n\nexperiment;x;X\nbend;0,5;7\ntwist;2,5;8\n"), Ok(vec![0.5]));
    for (text, facts) in [
        ("experiment,x (m)\nbend,0.5\n", ["\"x (m)\" is in m by the table and in mm by the study", "correct one"]),
        ("experiment;x\nbend;1,234\n", ["line 2: \"1,234\" may be a decimal fraction", "without separators"]),
        ("experiment,x\nbend,0.5\nbend,y\nbend,\n", ["line 3: \"y\" in column x, line 4: \"\"", "remove the lines"]),
        ("x,experiment,note\n0.5,bend\n1,bend,a,b\n", ["lines 2, 3 have other numbers of cells", "quotation marks"]),
        ("y,z\n1,2\n", ["there are no columns \"x\", \"experiment\"", "known: y, z"]),
    ] {
        let error = read(text).expect_err(text);
        assert!(facts.iter().all(|fact| error.contains(fact)), "{text}: {error}");
    }
}
