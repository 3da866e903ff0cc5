//! The whole command line: every command with its options, as clap parses it.

use clap::{CommandFactory, Parser, Subcommand};

use super::{bake, bench, completions, fly, info, man, render, styles};
use crate::file::interrupt;
use crate::gpu::device::AdapterWish;

/// Draws real terrain of any size in real time as ink, pencil, wash or print
#[derive(Debug, Parser)]
#[command(version, override_usage = "hachure [OPTIONS] [WORLD]\n       hachure [OPTIONS] <COMMAND>")]
pub struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) fly: fly::FlyArgs,
    /// GPU for drawing: best, software, or part of a GPU's name; commands that draw nothing ignore it
    #[arg(long, global = true, default_value = "best")]
    pub(crate) adapter: AdapterWish,
    /// Print more; -vv prints everything
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fly over a world in a window (the default command; without a world, `hachure` alone opens that of the last flight)
    Fly(fly::FlyArgs),
    /// Draw a picture, a sequence of frames, or a film
    Render(Box<render::RenderArgs>),
    /// Fly a camera path and report what each style costs
    Bench(bench::BenchArgs),
    /// Bake elevation data into a tile pyramid (a cloud-optimised GeoTIFF)
    Bake(bake::BakeArgs),
    /// Describe a DEM, folder, URL, pyramid, scene, style, camera path or drawn picture
    Info(info::InfoArgs),
    /// List, show and check styles
    Styles(styles::StylesArgs),
    /// Print the script by which a shell completes commands, options and values
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write those of all commands to a folder
    Man(man::ManArgs),
}

impl Cli {
    /// Runs the command; without one, flies.
    ///
    /// # Errors
    /// The errors of the command.
    pub fn run(&self) -> anyhow::Result<()> {
        interrupt::handle_requests();
        match &self.command {
            Some(Command::Render(args)) => render::run(args, &self.adapter),
            Some(Command::Bench(args)) => bench::run(args, &self.adapter),
            Some(Command::Bake(args)) => bake::run(args),
            Some(Command::Info(args)) => info::run(args),
            Some(Command::Styles(args)) => styles::run(args),
            Some(Command::Completions(args)) => completions::run(args, definition()),
            Some(Command::Man(args)) => man::run(args, &definition()),
            Some(Command::Fly(args)) => fly::run(args, &self.adapter),
            None => fly::run_again(&self.fly, &self.adapter),
        }
    }
}

/// Returns clap's definition of the command line, for help, messages and `docs/commands.md`.
pub fn definition() -> clap::Command {
    Cli::command()
}
