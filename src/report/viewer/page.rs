//! The page: data, program and style in one file that opens from disk and makes no requests.
//!
//! A content security policy forbids every request and every script except the two whose digests it lists. Texts of cases occur only in the data, as
//! JSON with `<` escaped, and the program writes them as text. The program is compressed; the browser unpacks it.

use super::pack::{FORMAT, Packed};
use crate::report::page::escape;
use crate::storage;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::io::{self, Read};
use std::path::Path;

/// The built program, compressed by zlib.
static PROGRAM: &[u8] = include_bytes!("bundle/viewer.js.z");
static STYLE: &str = include_str!("bundle/viewer.css");
/// Unpacks the program and starts it; if the browser cannot do this, the page says so.
static START: &str = include_str!("bundle/start.js");

const HEAD: &str = "<script type=\"application/json\" class=\"head\">";
const DATA: &str = "<script type=\"text/plain\" class=\"data\">";
const END: &str = "</script>";
/// Largest size of a page that is read, in bytes.
const LIMIT: u64 = 256 << 20;

/// Error of a page that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    #[error("{file}: cannot be read: {source}")]
    Unreadable { file: String, source: io::Error },
    #[error(
        "{file}: this is no page of the viewer; give one that `durometer simulate` or `durometer view` has written"
    )]
    NoPage { file: String },
    #[error("{file}: its data are damaged ({what}); make the page again from its results")]
    Damaged { file: String, what: String },
    #[error(
        "{file}: a newer version of this program has written it (format {found}, known is {FORMAT}); use that version"
    )]
    Newer { file: String, found: u64 },
}

/// Returns a page with one case, or several side by side.
pub fn page(title: &str, cases: &[Packed]) -> String {
    document(title, cases, None)
}

/// Returns a page with one case that requests the states of a run from its server, as `settings` say. It may request nothing else.
pub fn live_page(title: &str, case: &Packed, settings: &Value) -> String {
    document(title, std::slice::from_ref(case), Some(settings))
}

fn document(title: &str, cases: &[Packed], live: Option<&Value>) -> String {
    let mut program = Vec::new();
    let unpacked = flate2::read::ZlibDecoder::new(PROGRAM).read_to_end(&mut program);
    unpacked.expect("a test unpacks the program of the page");
    let policy = format!(
        "default-src 'none'; script-src '{}' '{}'; style-src '{}'; img-src data: blob:; media-src blob:; base-uri 'none'; form-action 'none'{}",
        digest(START.as_bytes()),
        digest(&program),
        digest(STYLE.as_bytes()),
        if live.is_some() { "; connect-src 'self'" } else { "" }
    );
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{} – Durometer</title>\n<style>{STYLE}</style></head><body>\n\
         <main id=\"viewer\"><h1>{0}</h1><p id=\"state\">Loading …</p></main>\n\
         <noscript>This page draws in three dimensions and needs JavaScript.</noscript>\n",
        escape(title)
    );
    let json = |value: &Value| {
        let text = serde_json::to_string(value).expect("numbers, strings and string keys only");
        text.replace('<', "\\u003c")
    };
    for case in cases {
        html += &format!("{HEAD}{}{END}\n{DATA}{}{END}\n", json(&case.head), STANDARD.encode(&case.data));
    }
    if let Some(settings) = live {
        html += &format!("<script type=\"application/json\" id=\"live\">{}{END}\n", json(settings));
    }
    html += &format!("<script type=\"text/plain\" id=\"program\">{}{END}\n", STANDARD.encode(PROGRAM));
    html + &format!("<script>{START}{END}\n</body></html>\n")
}

/// Reads the cases of a page.
pub fn read(path: &Path) -> Result<Vec<Packed>, PageError> {
    let file = path.display().to_string();
    let text =
        storage::read_text(path, LIMIT).map_err(|source| PageError::Unreadable { file: file.clone(), source })?;
    let mut cases = vec![];
    for part in text.split(HEAD).skip(1) {
        let damaged = |what: &str| PageError::Damaged { file: file.clone(), what: what.into() };
        let (head, rest) = part.split_once(END).ok_or_else(|| damaged("the description has no end"))?;
        let head: Value = serde_json::from_str(head).map_err(|e| damaged(&e.to_string()))?;
        let found = head["format"].as_u64().ok_or_else(|| damaged("there is no format"))?;
        if found > FORMAT {
            return Err(PageError::Newer { file, found });
        }
        let data = rest.split_once(DATA).and_then(|(_, data)| Some(data.split_once(END)?.0));
        let data = data.ok_or_else(|| damaged("there are no numbers"))?;
        let data = STANDARD.decode(data).map_err(|e| damaged(&e.to_string()))?;
        cases.push(Packed { head, data }.labelled());
    }
    if cases.is_empty() { Err(PageError::NoPage { file }) } else { Ok(cases) }
}

/// The digest of a script or style, in the form of a content security policy.
fn digest(bytes: &[u8]) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn texts_of_a_case_do_not_leave_the_data_and_a_page_is_read_back() {
        let name = "</script><script>alert(1)</script> & \"quotes\" ü";
        let case = Packed { head: json!({ "format": FORMAT, "title": name }), data: vec![1, 2, 3] };
        let html = page(name, &[case.clone(), case.clone()]);
        assert_eq!(html.matches("alert(1)").count(), 4, "title, heading and two descriptions");
        assert!(!html.contains("<script>alert") && html.contains("\\u003c/script>"));
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.html");
        std::fs::write(&path, &html).expect("room");
        assert_eq!(read(&path).expect("a page"), [case.clone(), case]);
        std::fs::write(&path, html.replace(&format!("\"format\":{FORMAT}"), "\"format\":99")).expect("room");
        assert!(read(&path).expect_err("newer").to_string().contains("newer version"));
        std::fs::write(&path, "<p>").expect("room");
        assert!(read(&path).expect_err("no page").to_string().contains("no page of the viewer"));
    }

    #[test]
    fn columns_of_a_page_of_an_earlier_version_get_words_and_units() {
        let columns = ["t_s", "line_1_curvature_per_m", "grip_moment_z_Nm", "bending_angle_deg", "stretch_p95"];
        let head = json!({ "format": FORMAT, "curves": { "columns": columns } });
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.html");
        std::fs::write(&path, page("earlier", &[Packed { head, data: vec![] }])).expect("room");
        let labels = [
            ["t", "s"],
            ["line 1 curvature", "1/m"],
            ["grip moment z", "N m"],
            ["bending angle", "°"],
            ["stretch p95", ""],
        ];
        assert_eq!(read(&path).expect("a page")[0].head["curves"]["labels"], json!(labels));
    }
}
