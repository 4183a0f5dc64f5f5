//! The `reseflow` command: arguments in, exit code out.

use std::process::ExitCode;

use reseflow::cli::{Parsed, parse};
use reseflow::{commands, error, output};

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = match parse(std::env::args_os()) {
        Parsed::Run(cli) => cli,
        Parsed::Help(text) => {
            output::print_help(&text);
            return ExitCode::SUCCESS;
        }
        Parsed::Wrong(sentence) => {
            output::print_error(&sentence);
            return ExitCode::from(error::EXIT_BAD_INPUT);
        }
    };
    output::start_log(cli.verbose);
    match commands::execute(*cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            output::print_error(&error::sentence(&fault));
            ExitCode::from(error::exit_code(&fault))
        }
    }
}
