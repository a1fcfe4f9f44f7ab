//! `ro-crate-metadata.json` according to the RO-Crate 1.1 specification: the root, every file with its digest, the program, and the run.

use crate::study::store::identity::Build;
use crate::study::store::record::StudyRecord;
use serde_json::{Value, json};

/// A file of a bundle and its digest.
pub struct Stored {
    /// Path from the root of the bundle
    pub name: String,
    pub bytes: u64,
    pub sha256: String,
}

/// Facts about the whole bundle.
pub struct About<'a> {
    pub study: &'a StudyRecord,
    pub license: &'a str,
    /// End of the last run \[s since 1970-01-01 UTC\]
    pub run_unix_s: u64,
    pub builds: &'a [Build],
}

/// Builds the metadata, which the specification requires as one flat list of entities.
pub fn metadata(about: &About, files: &[Stored]) -> Value {
    let refer = |name: &str| json!({ "@id": encoded(name) });
    let date = iso_date(about.run_unix_s);
    let programs: Vec<String> = (0..about.builds.len()).map(|k| format!("#durometer-{}", k + 1)).collect();
    let is_address = about.license.starts_with("https://") || about.license.starts_with("http://");
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json",
            "@type": "CreativeWork",
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" },
            "about": { "@id": "./" },
        }),
        json!({
            "@id": "./",
            "@type": "Dataset",
            "name": about.study.study,
            "description": about.study.question,
            "datePublished": date,
            "license": if is_address { json!({ "@id": about.license }) } else { json!(about.license) },
            "hasPart": files.iter().map(|f| refer(&f.name)).collect::<Vec<_>>(),
            "mentions": { "@id": "#run" },
        }),
    ];
    let of = |inputs: bool| {
        files
            .iter()
            .filter(|f| f.name.starts_with(if inputs { "home/" } else { "results/" }))
            .map(|f| refer(&f.name))
            .collect::<Vec<_>>()
    };
    graph.push(json!({
        "@id": "#run",
        "@type": "CreateAction",
        "name": format!("durometer run {}", about.study.study),
        "endTime": date,
        "instrument": single_or_list(programs.iter().map(|id| json!({ "@id": id })).collect()),
        "object": of(true),
        "result": of(false),
    }));
    graph.extend(about.builds.iter().zip(&programs).map(|(build, id)| {
        json!({
            "@id": id,
            "@type": "SoftwareApplication",
            "name": "Durometer",
            "softwareVersion": build.version,
            "description": build.words(),
        })
    }));
    graph.extend(files.iter().map(|f| {
        json!({
            "@id": encoded(&f.name),
            "@type": "File",
            "name": f.name,
            "contentSize": f.bytes.to_string(),
            "sha256": f.sha256,
            "encodingFormat": format_of(&f.name),
        })
    }));
    if is_address {
        graph.push(json!({ "@id": about.license, "@type": "CreativeWork", "name": about.license }));
    }
    // The context of RO-Crate 1.1 has no term for digests: without a definition here, readers of JSON-LD ignore them
    let context = json!(["https://w3id.org/ro/crate/1.1/context", { "sha256": "http://schema.org/sha256" }]);
    json!({ "@context": context, "@graph": graph })
}

/// A single value instead of a list of one, as the specification recommends.
fn single_or_list(mut values: Vec<Value>) -> Value {
    if values.len() == 1 { values.remove(0) } else { Value::Array(values) }
}

/// Percent-encodes a path as part of a URI: all characters except unreserved ones and `/` become their UTF-8 bytes.
fn encoded(name: &str) -> String {
    let one = |b: u8| match b {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => char::from(b).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(one).collect()
}

fn format_of(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or_default() {
        "json" => "application/json",
        "csv" => "text/csv",
        "html" => "text/html",
        "md" => "text/markdown",
        "toml" => "application/toml",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "pdf" => "application/pdf",
        "tex" | "bib" => "application/x-tex",
        "gz" => "application/gzip",
        "py" => "text/x-python",
        "txt" => "text/plain",
        _ => "application/octet-stream",
    }
}

/// The date of a Unix time in the Gregorian calendar, such as `2026-03-01` (Hinnant, *chrono-compatible low-level date algorithms*, 2013).
fn iso_date(unix_s: u64) -> String {
    let days = (unix_s / 86_400) as i64 + 719_468;
    let era = days / 146_097;
    let of_era = days - era * 146_097;
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, later) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", year_of_era + 400 * era + later)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_their_dates() {
        let days = [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (1_709_251_199, "2024-02-29"),
            (4_107_542_400, "2100-03-01"),
        ];
        for (s, date) in days {
            assert_eq!(iso_date(s), date);
        }
    }

    #[test]
    fn paths_are_parts_of_uris() {
        assert_eq!(encoded("results/cases/a b-ν.csv"), "results/cases/a%20b-%CE%BD.csv");
    }
}
