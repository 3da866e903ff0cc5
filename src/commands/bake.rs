//! `hachure bake`: a height file becomes a pyramid, a cloud-optimised GeoTIFF with measured errors beside it.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;

use super::describe::{Heights, Levels};
use super::progress::Bar;
use super::{tell, tell_json};
use crate::pyramid::{self, BakeOptions, Pyramid, sidecar_path};
use crate::source;

/// Arguments of `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// A height file
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// The pyramid: a cloud-optimised GeoTIFF
    #[arg(short, long, value_name = "OUT.tif")]
    pub output: PathBuf,
    /// How far a stored height may be from the original one, in metres; 0 keeps every bit
    #[arg(long, value_name = "METRES", default_value_t = 0.01, value_parser = parse_max_error_m)]
    pub max_error: f64,
    /// Bake part I of N
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Print what was baked, for programs
    #[arg(long)]
    pub json: bool,
}

fn parse_max_error_m(text: &str) -> Result<f64, String> {
    let metres = text.parse().ok().filter(|metres: &f64| (0.0..=1e6).contains(metres));
    metres.ok_or_else(|| format!("{text:?} is not a number of metres, 0 or more"))
}

#[derive(Serialize)]
struct Report<'a> {
    input: &'a Path,
    output: &'a Path,
    #[serde(flatten)]
    heights: Heights,
    #[serde(flatten)]
    levels: Levels,
    /// Reading the input included.
    duration_s: f64,
}

/// Runs the command.
///
/// # Errors
/// When the input cannot be read or the output not written; the output then is what it was.
pub fn run(args: &BakeArgs) -> anyhow::Result<()> {
    let start = std::time::Instant::now();
    let input = match &args.inputs[..] {
        [input] if args.shard.is_none() => input,
        [_, second, ..] => bail!("{}: a second input; this version bakes one file at a time", second.display()),
        _ => bail!("--shard: this version bakes one file in one go"),
    };
    let output = &args.output;
    check_output(input, output)?;
    let bar = Bar::default();
    let grid = source::open(input, &bar)?;
    pyramid::bake(&grid, output, &BakeOptions { max_error_m: args.max_error }, &bar)?;
    drop((grid, bar));

    // What is told is what a reader finds.
    let of = || output.display().to_string();
    let baked = Pyramid::open(output)?;
    let report = Report {
        input,
        output,
        heights: Heights::of_pyramid(&baked).with_context(of)?,
        levels: Levels::of(&baked).with_context(of)?,
        duration_s: start.elapsed().as_secs_f64(),
    };
    if args.json {
        return tell_json(&report);
    }
    let Report { heights, levels, duration_s, .. } = &report;
    tell(&format!("{}: baked in {duration_s:.2} s\n{}{}", output.display(), heights.lines(), levels.lines()))
}

/// What can be known to go wrong before hours of work.
fn check_output(input: &Path, output: &Path) -> anyhow::Result<()> {
    if !output.extension().is_some_and(|ending| ["tif", "tiff"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
    {
        bail!("{}: a pyramid is a GeoTIFF; its name ends with .tif", output.display());
    }
    if output.is_dir() {
        bail!("{}: is a folder", output.display());
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        bail!("{}: there is no folder {}", output.display(), folder.display());
    }
    // Links included; what is not there yet is not the input.
    let same = |other: &Path| matches!((input.canonicalize(), other.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if same(output) || same(&sidecar_path(output)) {
        bail!("{}: is the input; a bake does not overwrite what it reads", output.display());
    }
    Ok(())
}
