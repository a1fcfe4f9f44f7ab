//! Tools and data outside of the project that some tests need.

use std::path::PathBuf;

/// Whether a test ends here because a tool is missing. Where `DUROMETER_ALL_TOOLS` is set, as in `.ci/run`, that is a failure.
pub fn is_missing(found: bool, tool: &str) -> bool {
    let demanded = std::env::var_os("DUROMETER_ALL_TOOLS").is_some();
    assert!(found || !demanded, "{tool} is missing, and DUROMETER_ALL_TOOLS asks for all tools");
    if !found {
        println!("skipped: {tool} is missing");
    }
    !found
}

/// A folder or file of public data that is not part of the project, below the folder that `DUROMETER_SHARED` names.
pub fn shared(path: &str) -> PathBuf {
    let folder = std::env::var_os("DUROMETER_SHARED").expect("DUROMETER_SHARED names the folder of the data");
    PathBuf::from(folder).join(path)
}
