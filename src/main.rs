//! The program `hachure`: parses the arguments and runs the command; the work is done in `commands`.
#![warn(clippy::print_stdout, clippy::print_stderr, reason = "they panic on a closed pipe: use file::standard")]

mod version;

use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use hachure::commands::log;
use hachure::commands::misuse::{self, Misuse};
use hachure::commands::program::Cli;
use hachure::internals::{chain, print_to_stderr, printable, raise_file_limit};

/// Longest error line, in characters: enough for two long file names and a cause.
const LONGEST_LINE: usize = 480;

fn main() -> ExitCode {
    hush_libraries();
    raise_file_limit();
    let cli = match parsed() {
        Ok(cli) => cli,
        Err(exit) => return exit,
    };
    log::start(cli.verbose);
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if error.is::<Misuse>() { 2 } else { 1 };
            fail(&chain(error.as_ref()), status)
        }
    }
}

/// Sets environment variables that are unset or empty, so that libraries do not write to standard error.
///
/// - `XDG_RUNTIME_DIR`: Mesa looks for Wayland even if no window is wanted, and libwayland writes two lines if the
///   variable is unset, as it is in every run without a desktop. The folder named here does not exist, so nothing is
///   found, as without the variable. The runtime of a headset looks for its service in this folder, so with `--vr` the
///   variable is left alone.
/// - `XR_LOADER_DEBUG`: the loader of OpenXR would write several lines about what is missing; hachure writes one.
fn hush_libraries() {
    let with_headset = std::env::args_os().any(|word| word == "--vr");
    let (name, value) = if with_headset { ("XR_LOADER_DEBUG", "none") } else { ("XDG_RUNTIME_DIR", "/nonexistent") };
    if cfg!(target_os = "linux") && std::env::var_os(name).is_none_or(|value| value.is_empty()) {
        // SAFETY: nothing else runs yet, so no other thread reads the environment.
        #[allow(unsafe_code, reason = "these libraries offer no other way to silence them")]
        unsafe {
            std::env::set_var(name, value);
        }
    }
}

/// Prints one line to standard error, escaped and cut to [`LONGEST_LINE`], and returns the exit status.
fn fail(message: &str, status: u8) -> ExitCode {
    print_to_stderr(&format!("hachure: {}", printable(message, LONGEST_LINE)));
    ExitCode::from(status)
}

/// Parses the arguments; returns an exit code if the program ends without any work (help, version, misuse).
fn parsed() -> Result<Cli, ExitCode> {
    let matches = Cli::command().version(version::line()).try_get_matches();
    let cli = matches.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, stray(&matches))));
    match cli {
        Ok((cli, None)) => Ok(cli),
        Ok((_, Some(misuse))) => Err(fail(&misuse.to_string(), 2)),
        Err(error) if !error.use_stderr() => {
            // Help or version; the reader may have closed the pipe.
            let _ = error.print();
            Err(ExitCode::SUCCESS)
        }
        Err(error) => {
            let words: Vec<String> =
                std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
            Err(fail(&misuse::describe(&error, &words, &Cli::command()), 2))
        }
    }
}

/// Returns the misuse if an argument of `fly` is before another command. `-v` and `--adapter` may be anywhere.
fn stray(matches: &ArgMatches) -> Option<Misuse> {
    let command = matches.subcommand_name()?;
    let parser = Cli::command();
    // The arguments of `fly`; the ids of argument groups are skipped.
    let mut arguments = parser.get_arguments().map(clap::Arg::get_id).filter(|id| *id != "adapter" && *id != "verbose");
    let id = arguments.find(|id| {
        matches.try_contains_id(id.as_str()).is_ok()
            && matches.value_source(id.as_str()) == Some(ValueSource::CommandLine)
    })?;
    let name = id.as_str().replace('_', "-");
    let argument = match matches.try_get_one::<String>("world") {
        Ok(Some(world)) if name == "world" => world.clone(),
        _ => format!("--{name}"),
    };
    Some(misuse::before_command(&argument, command))
}
