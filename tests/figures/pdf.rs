//! Figures as PDF: the size that was asked for, text that can be selected, fonts that are embedded, and the same bytes every time.

use crate::common::tools;
use durometer::report::canvas::{INK, figure, line, mm};
use durometer::report::export::pdf;
use durometer::report::plot::{Axis, Plot};
use std::path::Path;
use std::process::Command;

/// 80 mm × 60 mm.
fn drawing() -> String {
    let x: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
    let y: Vec<f64> = x.iter().map(|x| x * x).collect();
    figure(80.0, 60.0, "", |area| {
        let frame = [mm(15.0), mm(5.0), mm(75.0), mm(48.0)];
        let axis = |values: &[f64], label| Axis::linear(values.iter().copied(), label);
        let plot = Plot { area, frame, x: axis(&x, "stretch λ"), y: axis(&y, "energy") };
        plot.grid();
        line(area, &plot.path(&x, &y), INK, 10);
        plot.axes(true);
    })
}

fn said(program: &str, file: &Path) -> String {
    let mut command = Command::new(program);
    let output = if program == "pdftotext" { command.arg(file).arg("-").output() } else { command.arg(file).output() };
    let output = output.expect("it starts");
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_pdf_has_its_size_its_text_and_its_fonts() {
    let found = Command::new("pdffonts").arg("-v").output().is_ok();
    if tools::is_missing(found, "pdffonts (Debian package poppler-utils)") {
        return;
    }
    let keep = tempfile::tempdir().expect("a temporary folder");
    let file = keep.path().join("figure.pdf");
    std::fs::write(&file, pdf("figure", &drawing()).unwrap_or_else(|e| panic!("{e}"))).expect("room");
    let text = said("pdftotext", &file);
    assert!(text.contains("stretch λ") && text.contains("energy"), "{text}");
    // 72 points per inch of 25.4 mm
    let size = said("pdfinfo", &file).lines().find_map(|line| line.strip_prefix("Page size:").map(String::from));
    let size = size.expect("a page");
    let sides: Vec<f64> = size.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    for (points, mm) in sides.iter().zip([80.0, 60.0]) {
        assert!((points * 25.4 / 72.0 - mm).abs() < 0.1, "{size}");
    }
    // name, type (one or two words), encoding, emb, sub, uni, object
    let fonts = said("pdffonts", &file);
    let listed: Vec<&str> = fonts.lines().skip(2).collect();
    assert!(!listed.is_empty(), "{fonts}");
    for font in listed {
        let words: Vec<&str> = font.split_whitespace().rev().skip(2).take(3).collect();
        assert!(font.contains("Liberation") && words == ["yes"; 3], "{fonts}");
    }
}

/// Hash maps of a converter have another order in each call.
#[test]
fn the_same_figure_has_the_same_bytes() {
    let svg = drawing();
    let first = pdf("figure", &svg).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..30 {
        assert!(pdf("figure", &svg).unwrap_or_else(|e| panic!("{e}")) == first);
    }
}
