//! `durometer schema FILE`

use super::outcome::{CommandResult, Outcome};
use durometer::study::schema::{Described, SCHEMAS};

/// Print the JSON Schema of a file, so that editors complete and check its keys
///
/// A line `#:schema ./scene.schema.json` at the top of a TOML file tells editors its schema; projects of `durometer new` have one.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer schema scene > scene.schema.json
  durometer schema summary")]
pub struct Args {
    /// File that the schema describes: scene.toml, study.toml or summary.json
    #[arg(value_parser = SCHEMAS.map(|described| described.name))]
    file: String,
}

pub fn main(args: &Args) -> CommandResult {
    if let Some(Described { schema, .. }) = SCHEMAS.iter().find(|described| described.name == args.file) {
        say!("{:#}", schema().as_value());
    }
    Ok(Outcome::Complete)
}
