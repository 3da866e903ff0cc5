//! The page `docs/portable-figures.md`: the work that a frame of each preset gives the GPU. Its figures depend on the
//! size of the picture, the world and the style, not on the GPU.

use std::fmt::Write;
use std::path::Path;

use rustc_hash::FxHashSet;

use crate::frame::Renderer;
use crate::gpu::Gpu;
use crate::gpu::trace::{PassBytes, PassTrace};
use crate::measure::work::FrameWork;
use crate::scene::path::CameraPath;
use crate::scene::view::{Clock, View};
use crate::style::{self, Style};
use crate::tiles::terrain::TerrainOptions;
use crate::world::OpenWorld;

/// Time between two frames along the path.
const STEP_S: f64 = 1.0 / 30.0;
/// The camera's place on the path `tour`, in seconds.
const START_S: f64 = 6.0;
/// Frames before the first one that is traced: buffers grow to what the strokes of a frame need.
const FIRST_FRAMES: usize = 3;

/// Draws some frames of each preset on the built-in world, and returns the page in Markdown. `report` is called with the
/// name of each preset.
///
/// # Errors
/// The errors of opening the world and of drawing.
pub fn page(gpu: &Gpu, size_px: [u32; 2], mut report: impl FnMut(&str)) -> anyhow::Result<String> {
    let (mut world, path) = open(gpu)?;
    let mut page = head(size_px);
    for name in style::names() {
        report(name);
        let most = Most::of(gpu, &mut world, &path, size_px, &Style::load(name)?)?;
        page += &row(name, &most, size_px);
    }
    Ok(page)
}

/// Returns the beginning of the page, up to the first row of its table.
fn head([width, height]: [u32; 2]) -> String {
    let tiles_mib = TerrainOptions::default().tile_memory_bytes >> 20;
    format!(
        "# Portable figures\n\n\
         What one frame of each preset gives the GPU to do, on the built-in world at {width} × {height}, one eye, on the \
         path `tour`. These figures do not depend on the GPU. `hachure bench` reports them for other worlds, sizes and \
         styles, and `--compare` names what became worse.\n\n\
         - GB read and written: what the passes declare to read and write. Each resource counts once for a pass: a picture \
         whole, a list as far as the frame filled it, an atlas with the tiles that the view needs \
         ([bytes-of-a-frame](decisions/bytes-of-a-frame.md)).\n\
         - Bytes per pixel: read and written, divided by the pixels of the picture.\n\
         - wgpu passes: compute and render passes of the API; dispatches that follow each other share one. The passes that \
         `hachure bench` lists by name are shaders, of which a wgpu pass may run several.\n\
         - Barriers: how often work must wait for earlier work of the frame.\n\
         - MB of memory: the pictures and buffers that the passes of a frame bind, each whole, blocks of rows of hachures, \
         and the maps that shadows and water need for every tile, but not the tiles of the land, which are the same in all \
         styles (`--tile-memory`; {tiles_mib} MiB here).\n\
         - Of the frames of a style that rebuilds its strokes every few frames, the one that moves most bytes counts.\n\n\
         This page is generated: `cargo run --release --example portable_figures`. It needs no GPU, but over half an hour \
         on Mesa's software driver with two cores.\n\n\
         | style | GB read | GB written | bytes per pixel | wgpu passes | dispatches | draws | copies and clears | barriers | MB \
         of memory |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n"
    )
}

/// Returns the row of a style.
fn row(name: &str, most: &Most, [width, height]: [u32; 2]) -> String {
    let work = &most.work;
    let &FrameWork { bytes_read, bytes_written, wgpu_passes, dispatches, draws, copies, barriers } = work;
    let [read, written] = [bytes_read, bytes_written].map(|bytes| bytes as f64 / 1e9);
    let per_pixel = work.bytes() / (u64::from(width) * u64::from(height));
    let memory = most.memory_bytes as f64 / 1e6;
    format!(
        "| `{name}` | {read:.3} | {written:.3} | {per_pixel} | {wgpu_passes} | {dispatches} | {draws} | {copies} | {barriers} | \
         {memory:.0} |\n"
    )
}

/// Draws the same frames of a style, and returns its row and the bytes per pixel that each pass reads and writes.
///
/// # Errors
/// The errors of opening the world and of drawing; the name of a style that does not exist.
pub fn passes(gpu: &Gpu, size_px: [u32; 2], style: &str) -> anyhow::Result<String> {
    let (mut world, path) = open(gpu)?;
    let most = Most::of(gpu, &mut world, &path, size_px, &Style::load(style)?)?;
    let trace = &most.trace;
    let pixels = size_px.map(f64::from).iter().product::<f64>();
    let mut known = FxHashSet::default();
    let names = trace.iter().map(|pass| pass.name).filter(|name| known.insert(*name));
    let mut text = row(style, &most, size_px);
    for name in names {
        let PassBytes { read, written } = PassBytes::of(trace, name);
        let [read, written] = [read, written].map(|bytes| bytes as f64 / pixels);
        let runs = trace.iter().filter(|pass| pass.name == name).count();
        writeln!(text, "{name:32} {runs:3} × {read:6.1} read {written:6.1} written")?;
    }
    Ok(text)
}

/// Opens the built-in world, and the path along which its frames are drawn.
fn open(gpu: &Gpu) -> anyhow::Result<(OpenWorld, CameraPath)> {
    let world = OpenWorld::open(gpu, None, TerrainOptions::default())?;
    let tour = Path::new("tour");
    let text = CameraPath::read_text(tour)?;
    let path = CameraPath::parse_on_ground(tour, text.as_bytes(), |x, y| world.ground_m(x, y))?;
    Ok((world, path))
}

/// The most that a frame of a style gives the GPU to do, and the most memory that it binds.
#[derive(Default)]
struct Most {
    /// Work of the frame that moves most bytes, and its trace.
    work: FrameWork,
    trace: Vec<PassTrace>,
    memory_bytes: u64,
}

impl Most {
    /// Draws frames of a style, and traces the last ones.
    fn of(
        gpu: &Gpu,
        world: &mut OpenWorld,
        path: &CameraPath,
        size_px: [u32; 2],
        style: &Style,
    ) -> anyhow::Result<Self> {
        let mut renderer = Renderer::new(gpu)?;
        renderer.set_step_s(STEP_S);
        let light = world.light();
        let traced = style.strokes().map_or(1, |strokes| strokes.update_every.max(1) as usize);
        let mut most = Self::default();
        let mut previous = None;
        for frame in 0..FIRST_FRAMES + traced {
            renderer.set_traces(frame >= FIRST_FRAMES);
            let t_s = START_S + frame as f64 * STEP_S;
            let pose = world.pose(&path.sample(t_s));
            let (before, before_s) = previous.replace((pose, t_s)).unwrap_or((pose, t_s));
            let view = View::whole(before, pose, size_px).at(Clock { now_s: t_s, before_s });
            renderer.render(gpu, &mut world.surfaces, &view, style, &light)?;
            gpu.wait();
            gpu.check()?;
            let trace = renderer.trace();
            let memory_bytes = renderer.drawing_bytes(&world.surfaces).unwrap_or_default();
            most.memory_bytes = most.memory_bytes.max(memory_bytes);
            let work = FrameWork::of(trace);
            if work.bytes() > most.work.bytes() {
                (most.work, most.trace) = (work, trace.to_vec());
            }
        }
        Ok(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_explains_its_figures_as_the_generator_does() {
        let page = include_str!("../../../docs/portable-figures.md");
        let rows = page.strip_prefix(&head([1920, 1080])).unwrap_or_default();
        assert_eq!(rows.lines().count(), style::names().len(), "regenerate the page, or its head: {page}");
        assert!(rows.lines().all(|row| row.starts_with("| `") && row.matches('|').count() == 11), "{rows}");
    }
}
