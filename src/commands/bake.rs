//! `hachure bake`: height files become a pyramid, a cloud-optimised GeoTIFF with measured errors beside it.
//!
//! A long bake keeps what is done in a work folder beside the output. Ctrl-C, a kill or a power cut lose the chunks
//! that were under way; `--resume` goes on. With `--shard I/N` several machines fill one work folder, and a last call
//! with `--resume` joins the parts.

use std::path::{Path, PathBuf};
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
use crate::file::message::named;
use crate::pyramid::bake::{BakeWork, Baked, parts_path};
use crate::pyramid::format::sidecar_path;
use crate::pyramid::{self, BakeOptions, Pyramid, PyramidError};
use crate::source::mosaic::MosaicReader;
use crate::source::{self, HeightReader, Kind, OpenOptions, VoidMode};

/// Arguments of `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// Height files, or folders of them: several become one grid
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// The pyramid: a cloud-optimised GeoTIFF
    #[arg(short, long, value_name = "OUT.tif")]
    pub output: PathBuf,
    /// How far a stored height may be from the original one, in metres; 0 keeps every bit
    #[arg(long, value_name = "METRES", default_value_t = 0.01, value_parser = arguments::from_to(0.0, 1e6), allow_hyphen_values = true)]
    pub max_error: f64,
    /// Bake part I of N into the work folder OUT.tif.parts and stop; a last call with --resume joins all
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<(u32, u32)>,
    /// Go on with the parts that an earlier call left in the work folder
    #[arg(long)]
    pub resume: bool,
    /// Metres between samples, for heightmaps that do not say
    #[arg(long, value_name = "METRES", value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub spacing: Option<f64>,
    /// Width and height of a raw heightmap
    #[arg(long, value_name = "WxH", value_parser = super::render::parse_size)]
    pub raw_size: Option<[u32; 2]>,
    /// Whether a raw heightmap has its high bytes first
    #[arg(long)]
    pub raw_big_endian: Option<bool>,
    /// Metres per step of a heightmap
    #[arg(long, value_name = "METRES", value_parser = arguments::not_0, allow_hyphen_values = true)]
    pub height_scale: Option<f64>,
    /// Height of a heightmap's 0
    #[arg(long, value_name = "METRES", value_parser = arguments::number, allow_hyphen_values = true)]
    pub height_offset: Option<f64>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Tiles along the side of a chunk, as a power of 2; for tests
    #[arg(long, hide = true, default_value_t = 4, value_parser = arguments::whole::<u32>(1, 6))]
    pub chunk_levels: u32,
    /// Print what was baked, for programs
    #[arg(long)]
    pub json: bool,
}

impl BakeArgs {
    /// What heightmaps without a header mean.
    fn meaning(&self) -> OpenOptions {
        OpenOptions {
            spacing_m: self.spacing,
            size: self.raw_size,
            height_scale_m: self.height_scale,
            height_offset_m: self.height_offset,
            big_endian: self.raw_big_endian,
            ..self.heights.options()
        }
    }
}

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

fn parse_shard(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    let shard = parsed.filter(|&(i, n): &(u32, u32)| 1 <= i && i <= n);
    shard.ok_or_else(|| "it must be I/N with 1 ≤ I ≤ N, like 3/8".to_owned())
}

#[derive(Serialize)]
struct Report<'a> {
    input: &'a Path,
    output: &'a Path,
    #[serde(flatten)]
    heights: Heights,
    #[serde(flatten)]
    levels: Levels,
    /// Chunks that an earlier call had left.
    resumed_chunks: u64,
    /// Reading the input included.
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
/// When the input cannot be read or the output not written; the output then is what it was.
pub fn run(args: &BakeArgs) -> anyhow::Result<()> {
    let start = std::time::Instant::now();
    let output = &args.output;
    args.inputs.iter().try_for_each(|input| arguments::check_local(input, "bake"))?;
    check_output(&args.inputs, output)?;
    use_granted_threads();
    let reader = open(&args.inputs, &args.meaning())?;
    // Where it cannot be had, Ctrl-C ends the program as it always does, and nothing is lost either.
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed)) {
        tracing::debug!("no handler for Ctrl-C: {error}");
    }
    let [width, height] = reader.size();
    let bar = Bar::of_samples(u64::from(width) * u64::from(height));
    let work = BakeWork {
        chunk_levels: args.chunk_levels,
        in_folder: true,
        resume: args.resume,
        shard: args.shard,
        stop: &STOP,
    };
    let baked = pyramid::bake::bake_reader(&*reader, output, &BakeOptions { max_error_m: args.max_error }, &work, &bar);
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
            let there = told_resumed(resumed_chunks);
            print(&format!("{}: shard {shard}/{shards}, {chunks} chunks in {duration_s:.2} s{there}", named(&parts)))
        }
        Ok(Baked::Pyramid(baked)) => {
            // What is told is what a reader finds.
            let of = || named(output);
            let pyramid = Pyramid::open(output)?;
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
            let there = told_resumed(baked.resumed_chunks);
            let text = format!("baked in {duration_s:.2} s{there}\n{}{}", heights.lines(), levels.lines());
            print(&format!("{}: {text}", named(output)))
        }
    }
}

fn told_resumed(chunks: u64) -> String {
    if chunks == 0 { String::new() } else { format!("; {chunks} chunks were there") }
}

fn stopped(args: &BakeArgs) -> String {
    let (output, parts) = (named(&args.output), parts_path(&args.output));
    if parts.is_dir() {
        format!("{output}: stopped; what is done is in {}, and --resume goes on with it", named(&parts))
    } else {
        format!("{output}: stopped; nothing was written")
    }
}

/// The heights of the inputs; those of several as one grid.
fn open(inputs: &[PathBuf], options: &OpenOptions) -> anyhow::Result<Box<dyn HeightReader>> {
    let mut files = Vec::new();
    for input in inputs {
        match source::kind_of(input) {
            Kind::Folder => files.extend(source::members(input)?),
            Kind::File | Kind::TileFolder => files.push(input.clone()),
        }
    }
    if let [file] = &files[..] {
        return Ok(source::open_reader_with(file, options)?);
    }
    // A void of one file may be land in another, so holes are those of all together.
    let bare = OpenOptions { voids: VoidMode::Holes, ..*options };
    let readers = files.iter().map(|file| source::open_reader_with(file, &bare)).collect::<Result<Vec<_>, _>>()?;
    let mosaic = Box::new(MosaicReader::new(readers)?);
    Ok(match options.voids {
        VoidMode::Fill => source::voids::filled(mosaic),
        VoidMode::Holes => mosaic,
    })
}

/// Under Slurm, as many threads as were granted, unless `RAYON_NUM_THREADS` says otherwise.
fn use_granted_threads() {
    let granted = std::env::var("SLURM_CPUS_PER_TASK").ok().and_then(|text| text.parse().ok());
    if let Some(threads) = granted.filter(|_| std::env::var_os("RAYON_NUM_THREADS").is_none()) {
        // Fails only where there are threads already.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
}

/// What can be known to go wrong before hours of work.
fn check_output(inputs: &[PathBuf], output: &Path) -> anyhow::Result<()> {
    if !output.extension().is_some_and(|ending| ["tif", "tiff"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
    {
        let name = named(output);
        return Err(Misuse(format!("{name}: a pyramid is a GeoTIFF; its name ends with .tif")).into());
    }
    if output.is_dir() {
        bail!("{}: is a folder", named(output));
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        bail!("{}: there is no folder {}", named(output), named(folder));
    }
    let mut read = Inputs::default();
    inputs.iter().for_each(|input| source::add_inputs(input, &mut read));
    read.check(output)?;
    read.check(&sidecar_path(output))?;
    Ok(read.check_folder(&parts_path(output))?)
}
