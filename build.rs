//! Leaves the lines for debuggers out of test programs.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // Each test program with the lines of the library would take 200 MB.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo::rustc-link-arg-tests=-Wl,--strip-debug");
    }
}
