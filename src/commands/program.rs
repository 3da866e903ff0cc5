//! The whole command line: every command with its options, as clap parses it.

use clap::{CommandFactory, Parser, Subcommand};

use super::{bake, bench, fly, info, render, styles};
use crate::gpu::device::AdapterWish;

/// Draws real terrain of any size in real time as ink, pencil, wash or print
#[derive(Debug, Parser)]
#[command(version, override_usage = "hachure [OPTIONS] [WORLD]\n       hachure [OPTIONS] <COMMAND>")]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub fly: fly::FlyArgs,
    /// GPU for drawing: best, software, or part of a GPU's name
    #[arg(long, global = true, default_value = "best")]
    pub adapter: AdapterWish,
    /// Print more; -vv prints everything
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly over a world in a window (the default command)
    Fly(fly::FlyArgs),
    /// Draw a picture, a sequence of frames, or a film
    Render(Box<render::RenderArgs>),
    /// Fly a camera path and report what each style costs
    Bench(bench::BenchArgs),
    /// Bake elevation data into a tile pyramid (a cloud-optimised GeoTIFF)
    Bake(bake::BakeArgs),
    /// Describe a DEM, pyramid, scene, style or camera path
    Info(info::InfoArgs),
    /// List, show and check styles
    Styles(styles::StylesArgs),
}

/// Returns clap's definition of the command line, for help, messages and `docs/commands.md`.
pub fn definition() -> clap::Command {
    Cli::command()
}
