//! The command line: parse, call, print. All work is in the library.

mod cli;

fn main() -> std::process::ExitCode {
    cli::bring_files();
    cli::main(std::env::args_os()).into()
}
