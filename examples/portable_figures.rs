//! Writes `docs/portable-figures.md`: what a frame of each preset gives the GPU to do.
//!
//! `cargo run --release --example portable_figures [WIDTHxHEIGHT [STYLE...]]`
//!
//! Given names of styles, it writes no file, but prints the bytes that each pass of their frames reads and writes.

use std::path::Path;

use anyhow::Context;
use hachure::file::atomic;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::internals::{portable_figures, portable_passes};

fn main() -> anyhow::Result<()> {
    let size = std::env::args().nth(1).unwrap_or_else(|| "1920x1080".to_owned());
    let sides = size.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let size_px = sides.filter(|sides| !sides.contains(&0)).with_context(|| format!("{size}: not WIDTHxHEIGHT"))?;
    let gpu = Gpu::open(&AdapterWish::Best)?;
    let styles: Vec<String> = std::env::args().skip(2).collect();
    for style in &styles {
        println!("{}", portable_passes(&gpu, size_px, style)?);
    }
    if !styles.is_empty() {
        return Ok(());
    }
    let page = portable_figures(&gpu, size_px, |style| eprintln!("{style}"))?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/portable-figures.md");
    atomic::write(&path, page.as_bytes()).with_context(|| path.display().to_string())
}
