//! The command line: parse, call, print. All work is in the library.

mod cli;

fn main() -> std::process::ExitCode {
    durometer::catalogue::bring(durometer::catalogue::Archive {
        packed: durometer_files::PACKED,
        list: durometer_files::LIST,
        digest: durometer_files::DIGEST,
    });
    cli::main()
}
