//! Why a scene cannot be simulated: always the place, the fact and the remedy.

use std::path::PathBuf;

/// A scene file with a mistake in it.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("{}: cannot be read: {reason}", file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: {message}", file.display())]
    Syntax { file: PathBuf, message: String },
    #[error("{}: {place}: {fact}; {remedy}", file.display())]
    Content { file: PathBuf, place: String, fact: String, remedy: String },
    #[error("{}: {place}: {source}", file.display())]
    Part {
        file: PathBuf,
        place: String,
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// Message of the TOML reader, with the nearest known key added where a key is unknown.
pub fn explain(error: &toml::de::Error) -> String {
    let text = error.to_string();
    let quoted: Vec<&str> = error.message().split('`').skip(1).step_by(2).collect();
    let unknown = error.message().starts_with("unknown field") || error.message().starts_with("unknown variant");
    match quoted.split_first() {
        Some((word, known)) if unknown => {
            let near = known.iter().max_by(|a, b| strsim::jaro(word, a).total_cmp(&strsim::jaro(word, b)));
            near.map_or(text.clone(), |near| format!("{}\nDid you mean `{near}`?", text.trim_end()))
        }
        _ => text.trim_end().into(),
    }
}
