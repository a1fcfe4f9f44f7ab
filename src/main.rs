//! The program. All work is in the library, and the command line in the package below `cli`.

fn main() -> std::process::ExitCode {
    durometer_commands::bring_files();
    durometer_commands::main(std::env::args_os(), true).into()
}
