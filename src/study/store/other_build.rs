//! Stored files that this build cannot read because another build wrote them, and which build that was.

use crate::study::store::identity::Build;
use serde::Deserialize;
use serde_json::Value;

/// The build that wrote a record, in words; `None` if it was this one, or if the file does not say.
pub fn writer(bytes: &[u8]) -> Option<String> {
    let file: Value = serde_json::from_slice(bytes).ok()?;
    let provenance = &file["provenance"];
    match Build::deserialize(&provenance["build"]) {
        Ok(build) if build == Build::this() => None,
        Ok(build) if !build.version.is_empty() => Some(format!("durometer {}", build.words())),
        _ => {
            let version = provenance["version"].as_str().or(file["version"].as_str())?;
            Some(format!("an earlier build of durometer {version}, which did not yet record its sources,"))
        }
    }
}

/// The reason why a file does not parse: another build wrote it, or it is not a record.
pub fn explain(bytes: &[u8], why: &serde_json::Error) -> String {
    match writer(bytes) {
        Some(build) => format!("{build} has written it in a form that this build does not read: {why}"),
        None => format!("it is not a record: {why}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_build_that_wrote_a_file_is_named_unless_it_is_this_one() {
        let of = |provenance: Value| writer(json!({ "provenance": provenance }).to_string().as_bytes());
        let mut build = json!(Build::this());
        assert_eq!(of(json!({ "build": build })), None);
        build["source_sha256"] = "4f2a00112233445566".into();
        let words = of(json!({ "build": build })).expect("another build");
        assert!(words.contains("sources 4f2a00112233"), "{words}");
        assert!(of(json!({ "version": "0.0.3" })).is_some_and(|words| words.contains("durometer 0.0.3")));
        assert!(of(json!({})).is_none() && writer(b"{").is_none());
    }
}
