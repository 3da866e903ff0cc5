//! `hachure completions`: prints a script by which a shell completes hachure's commands, options and values.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::file::standard;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell for which the script is printed
    shell: Shell,
}

/// Prints the script for the command line that `program` defines.
///
/// # Errors
/// Fails if standard output cannot be written.
pub(crate) fn run(args: &CompletionsArgs, mut program: Command) -> anyhow::Result<()> {
    let (name, mut script) = (program.get_name().to_owned(), Vec::new());
    clap_complete::generate(args.shell, &mut program, name, &mut script);
    // The script is printed as it is: escapes would change what the shell does.
    Ok(standard::print(&String::from_utf8_lossy(&script))?)
}
