//! `hachure bake`: turns height files into a pyramid, a cloud-optimised GeoTIFF with measured errors in a sidecar file.
//!
//! A long bake stores finished chunks in a work folder next to the output. Ctrl-C, a kill or a power cut lose only the
//! chunks in progress; `--resume` continues. With `--shard I/N` several machines fill one work folder, and a final call
//! with `--resume` joins the parts.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;

use super::describe::{Heights, Levels};
use super::height_args::HeightArgs;
use super::misuse::Misuse;
use super::progress::Bar;
use super::{arguments, print, print_json};
use crate::file::guard::Inputs;
use crate::file::interrupt;
use crate::file::message::named;
use crate::file::unnamed;
use crate::pyramid::bake::{BakeLock, BakeWork, Baked, parts_path};
use crate::pyramid::format::{is_sidecar, next_path, sidecar_path};
use crate::pyramid::{self, BakeOptions, Pyramid, PyramidError};
use crate::source::mosaic::Choice;
use crate::source::{self, HeightReader, OpenOptions};

/// Arguments of `bake`.
#[derive(Debug, Args)]
pub(crate) struct BakeArgs {
    /// Height files, or folders of them; several inputs are combined into one grid
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Output pyramid, a cloud-optimised GeoTIFF
    #[arg(short, long, value_name = "OUT.tif")]
    pub output: PathBuf,
    /// Largest difference between a stored height and the original, in metres; 0 is lossless
    #[arg(long, value_name = "METRES", default_value_t = 0.01, value_parser = arguments::from_to(0.0, 1e6), allow_hyphen_values = true)]
    pub max_error: f64,
    /// Bake only part I of N, I from 1 to N, into the work folder OUT.tif.parts; a final call with --resume joins all
    /// parts
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<(u32, u32)>,
    /// Continue with the parts that an earlier call left in the work folder
    #[arg(long)]
    pub resume: bool,
    /// Distance between the samples of a heightmap (PNG or raw), in metres [default: from its NAME.ext.toml, or 1]
    #[arg(long, value_name = "METRES", value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub spacing: Option<f64>,
    /// Width and height of a raw heightmap, in samples [default: from its NAME.ext.toml, or a square]
    #[arg(long, value_name = "WxH", value_parser = super::render::parse_size)]
    pub raw_size: Option<[u32; 2]>,
    /// Whether the samples of a raw heightmap are big-endian: true or false [default: from its NAME.ext.toml, or false]
    #[arg(long)]
    pub raw_big_endian: Option<bool>,
    /// How to read height files.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Replace the statistics OUT.tif.tiles even if hachure did not write the file. OUT.tif itself is always replaced
    #[arg(long)]
    pub overwrite: bool,
    /// Side of a chunk in tiles, as a power of 2; for tests
    #[arg(long, hide = true, default_value_t = 4, value_parser = arguments::whole::<u32>(1, 6))]
    pub chunk_levels: u32,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

impl BakeArgs {
    /// Returns how to interpret heightmaps without a header.
    fn meaning(&self) -> OpenOptions {
        OpenOptions {
            spacing_m: self.spacing,
            size: self.raw_size,
            big_endian: self.raw_big_endian,
            ..self.heights.options()
        }
    }
}

/// Whether Ctrl-C was pressed.
static STOP: AtomicBool = AtomicBool::new(false);

fn parse_shard(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    let shard = parsed.filter(|&(i, n): &(u32, u32)| 1 <= i && i <= n);
    shard.ok_or_else(|| "it must be I/N with 1 ≤ I ≤ N, such as 3/8".to_owned())
}

#[derive(Serialize)]
struct Report<'a> {
    input: &'a Path,
    output: &'a Path,
    #[serde(flatten)]
    heights: Heights,
    #[serde(flatten)]
    levels: Levels,
    /// Chunks reused from an earlier call.
    resumed_chunks: u64,
    /// Including the time for reading the input.
    duration_s: f64,
}

#[derive(Serialize)]
struct ShardReport<'a> {
    input: &'a Path,
    output: &'a Path,
    shard: u32,
    shards: u32,
    chunks: u64,
    resumed_chunks: u64,
    duration_s: f64,
}

/// Runs the command.
///
/// # Errors
/// Fails if the input cannot be read or the output cannot be written; an existing output is then unchanged.
pub(crate) fn run(args: &BakeArgs) -> anyhow::Result<()> {
    let start = std::time::Instant::now();
    let output = &args.output;
    args.inputs.iter().try_for_each(|input| arguments::check_local(input, "bake"))?;
    check_output(&args.inputs, output, args.overwrite)?;
    use_granted_threads();
    let _lock = BakeLock::take(output, args.shard.is_some())?;
    let reader = open(&args.inputs, &args.meaning())?;
    interrupt::on_first_request(|| STOP.store(true, Ordering::Relaxed));
    let [width, height] = reader.size();
    let bar = Bar::of_samples(u64::from(width) * u64::from(height));
    let work = BakeWork {
        chunk_levels: args.chunk_levels,
        in_folder: true,
        resume: args.resume,
        shard: args.shard,
        is_private: false,
        stop: &STOP,
    };
    let baked = pyramid::bake::bake_reader(&*reader, output, &BakeOptions { max_error_m: args.max_error }, &work, &bar);
    // A part, or the remains of a bake, may lack the samples with the value.
    let is_whole = args.shard.is_none() && !args.resume && baked.is_ok();
    if let (true, Some(no_data)) = (is_whole && reader.has_unmatched_no_data(), args.heights.nodata) {
        tracing::warn!("{}: no sample is {no_data}, so --nodata {no_data} changes nothing", named(&args.inputs[0]));
    }
    drop((reader, bar));
    let duration_s = start.elapsed().as_secs_f64();
    match baked {
        Err(PyramidError::Stopped) => bail!("{}", stopped(args)),
        Err(error) => Err(error.into()),
        Ok(Baked::Shard { chunks, resumed_chunks }) => {
            let (shard, shards) = args.shard.unwrap_or((1, 1));
            let input = &args.inputs[0];
            if args.json {
                let report = ShardReport { input, output, shard, shards, chunks, resumed_chunks, duration_s };
                return print_json(&report);
            }
            let parts = parts_path(output);
            let there = resumed_note(resumed_chunks);
            print(&format!("{}: shard {shard}/{shards}, {chunks} chunks in {duration_s:.2} s{there}", named(&parts)))
        }
        Ok(Baked::Pyramid(baked)) => {
            // Report the statistics that a reader of the file finds.
            let of = || named(output);
            let pyramid = Arc::new(Pyramid::open(output)?);
            let report = Report {
                input: &args.inputs[0],
                output,
                heights: Heights::of_pyramid(&pyramid).with_context(of)?,
                levels: Levels::of(&pyramid).with_context(of)?,
                resumed_chunks: baked.resumed_chunks,
                duration_s,
            };
            if args.json {
                return print_json(&report);
            }
            let Report { heights, levels, .. } = &report;
            let there = resumed_note(baked.resumed_chunks);
            let text = format!("baked in {duration_s:.2} s{there}\n{}{}", heights.lines(), levels.lines());
            print(&format!("{}: {text}", named(output)))
        }
    }
}

fn resumed_note(chunks: u64) -> String {
    if chunks == 0 { String::new() } else { format!("; {chunks} chunks reused") }
}

fn stopped(args: &BakeArgs) -> String {
    let (output, parts) = (named(&args.output), parts_path(&args.output));
    if parts.is_dir() {
        format!("{output}: stopped; finished chunks are in {}; --resume continues with them", named(&parts))
    } else {
        format!("{output}: stopped; nothing was written")
    }
}

/// Opens the inputs; several files become one grid.
fn open(inputs: &[PathBuf], options: &OpenOptions) -> anyhow::Result<Box<dyn HeightReader>> {
    let choice = Choice::of(inputs, options)?;
    choice.warn();
    Ok(choice.open(options)?)
}

/// Under Slurm, uses as many threads as were granted, unless `RAYON_NUM_THREADS` is set.
fn use_granted_threads() {
    let granted = std::env::var("SLURM_CPUS_PER_TASK").ok().and_then(|text| text.parse().ok());
    if let Some(threads) = granted.filter(|_| std::env::var_os("RAYON_NUM_THREADS").is_none()) {
        // Fails only if the thread pool exists already.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
}

/// Checks everything that can be known to fail before hours of work.
fn check_output(inputs: &[PathBuf], output: &Path, overwrite: bool) -> anyhow::Result<()> {
    if !output.extension().is_some_and(|ending| ["tif", "tiff"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
    {
        let name = named(output);
        return Err(Misuse(format!("{name}: a pyramid is a GeoTIFF; its name must end with .tif")).into());
    }
    if output.is_dir() {
        bail!("{}: is a folder; name a .tif file", named(output));
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        bail!("{}: there is no folder {}", named(output), named(folder));
    }
    let mut read = Inputs::default();
    inputs.iter().for_each(|input| source::add_inputs(input, &mut read));
    read.check(output)?;
    for path in [sidecar_path(output), next_path(output)] {
        read.check(&path)?;
        unnamed::check(&path, overwrite, is_sidecar)?;
    }
    Ok(read.check_folder(&parts_path(output))?)
}
