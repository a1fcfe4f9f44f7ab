//! The program `durometer`. The library does the work; the command line is the package in `cli`.

fn main() -> std::process::ExitCode {
    durometer_commands::bring_files();
    durometer_commands::main(std::env::args_os(), true).into()
}
