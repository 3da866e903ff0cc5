//! Arguments only; the work is in `commands`.
#![warn(clippy::print_stdout, clippy::print_stderr, reason = "they panic on a closed pipe: use file::standard")]

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use hachure::commands;
use hachure::commands::misuse::{self, Misuse};
use hachure::commands::program::{Cli, Command};
use hachure::file::message::{chain, printable};
use hachure::file::standard::complain;
use tracing_subscriber::fmt::format::debug_fn;

/// Characters of an error's line, at most: enough for two long names of files and a cause.
const LONGEST_LINE: usize = 480;
/// Of a line of the log.
const LONGEST_LOG_LINE: usize = 4000;

fn main() -> ExitCode {
    hush_libraries();
    let cli = match parsed() {
        Ok(cli) => cli,
        Err(exit) => return exit,
    };
    let level = match cli.verbose {
        0 => "hachure=warn",
        1 => "hachure=info",
        _ => "hachure=debug,wgpu=info",
    };
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| level.into());
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .without_time()
        // Names of files and words of servers are in these lines, too.
        .fmt_fields(debug_fn(|writer, field, value| match field.name() {
            "message" => write!(writer, "{}", printable(&format!("{value:?}"), LONGEST_LOG_LINE)),
            name => write!(writer, " {name}={}", printable(&format!("{value:?}"), LONGEST_LOG_LINE)),
        }))
        // Else a log that cannot be written is reported with `eprintln!`, which panics for the same reason.
        .log_internal_errors(false)
        .init();
    let result = match &cli.command {
        Some(Command::Render(args)) => commands::render::run(args, &cli.adapter),
        Some(Command::Bench(args)) => commands::bench::run(args, &cli.adapter),
        Some(Command::Bake(args)) => commands::bake::run(args),
        Some(Command::Info(args)) => commands::info::run(args),
        Some(Command::Styles(args)) => commands::styles::run(args),
        Some(Command::Fly(args)) => commands::fly::run(args, &cli.adapter),
        None => commands::fly::run(&cli.fly, &cli.adapter),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if error.is::<Misuse>() { 2 } else { 1 };
            fail(&chain(error.as_ref()), status)
        }
    }
}

/// Gives variables of the environment a value where they have none, so that libraries do not write to standard error.
///
/// - `XDG_RUNTIME_DIR`: Mesa looks for Wayland whether or not a window is wanted, and libwayland writes two lines if it
///   does not know where: in every run without a desktop. Nobody finds anything in the folder of this name, which is as
///   without the variable. The runtime of a headset does look there for its service, so with `--vr` it stays as it is.
/// - `XR_LOADER_DEBUG`: the loader of OpenXR writes what is missing in lines of its own, and hachure in one.
fn hush_libraries() {
    let with_headset = std::env::args_os().any(|word| word == "--vr");
    let (name, value) = if with_headset { ("XR_LOADER_DEBUG", "none") } else { ("XDG_RUNTIME_DIR", "/nonexistent") };
    if cfg!(target_os = "linux") && std::env::var_os(name).is_none_or(|value| value.is_empty()) {
        // SAFETY: nothing else runs yet, so no thread reads the environment meanwhile.
        #[allow(unsafe_code, reason = "these libraries can be told in no other way")]
        unsafe {
            std::env::set_var(name, value);
        }
    }
}

/// One line on standard error, whatever names of files and words of servers are in it.
fn fail(message: &str, status: u8) -> ExitCode {
    complain(&format!("hachure: {}", printable(message, LONGEST_LINE)));
    ExitCode::from(status)
}

/// The arguments; or how the program ends without any work.
fn parsed() -> Result<Cli, ExitCode> {
    let matches = Cli::command().try_get_matches();
    let cli = matches.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, stray(&matches))));
    match cli {
        Ok((cli, None)) => Ok(cli),
        Ok((_, Some(misuse))) => Err(fail(&misuse.to_string(), 2)),
        Err(error) if !error.use_stderr() => {
            // Help or version, which may go to a reader that has heard enough.
            let _ = error.print();
            Err(ExitCode::SUCCESS)
        }
        Err(error) => {
            let words: Vec<String> =
                std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
            Err(fail(&misuse::told(&error, &words, &Cli::command()), 2))
        }
    }
}

/// What stands before a command and is not for all of them. `-v` and `--adapter` may stand anywhere.
fn stray(matches: &ArgMatches) -> Option<Misuse> {
    let command = matches.subcommand_name()?;
    let parser = Cli::command();
    // Those of the flight; there are groups of arguments as well.
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
