//! The command-line program.

fn main() -> std::process::ExitCode {
    immersa::cli::main()
}
