//! Arguments only; the work is in `commands`.
#![warn(clippy::print_stdout, clippy::print_stderr, reason = "they panic on a closed pipe: use file::standard")]

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hachure::commands;
use hachure::file::one_line;
use hachure::file::standard::complain;
use hachure::gpu::device::AdapterWish;

/// Draws real terrain of any size in real time as ink, pencil, wash or print
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    fly: commands::fly::FlyArgs,
    /// The GPU: `software`, or a part of its name
    #[arg(long, global = true, default_value = "best")]
    adapter: AdapterWish,
    /// Tell more; twice for everything
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Fly over a world in a window; what happens without a command
    Fly(commands::fly::FlyArgs),
    /// Draw a picture, a row of pictures, or a film
    Render(commands::render::RenderArgs),
    /// Fly a camera path and report what each style costs
    Bench(commands::bench::BenchArgs),
    /// Bake a height file into a tile pyramid: a cloud-optimised GeoTIFF
    Bake(commands::bake::BakeArgs),
    /// Tell what a DEM, pyramid, scene, style or camera path is
    Info(commands::info::InfoArgs),
    /// List, show and check styles
    Styles(commands::styles::StylesArgs),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
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
            // The whole chain of causes on one line.
            complain(&format!("hachure: {}", one_line(&format!("{error:#}"))));
            ExitCode::FAILURE
        }
    }
}
