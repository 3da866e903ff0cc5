//! The commands for programs in which hachure is embedded. The Python package uses them: options are the words of the
//! command line, so that values, results and errors are the same.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;
use clap::{CommandFactory, Parser};

use super::misuse::{self, Misuse};
use super::program::{Cli, Command};
use super::progress::Bar;
use super::render::hosted::{Host, Opened};
use super::render::{self, RenderArgs};
use super::{arguments, bench, styles};
use crate::file::message::{chain, printable};
use crate::file::open_files::raise_file_limit;
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::pyramid::TileStore;
use crate::pyramid::store::MemoryStore;
use crate::scene::{Scene, World};
use crate::source::samples::MAX_HEIGHT_M;
use crate::source::voids::fill_grid;
use crate::source::{HeightGrid, Silent, VoidMode};
use crate::style::{self, Style};
use crate::world;

pub use super::render::hosted::DrawnPicture;

/// The name of heights that have no file, in messages and in the descriptions of pictures.
pub const IN_MEMORY: &str = "heights in memory";
/// Names of outputs that are not written. An EXR may have all channels, and no files next to it.
const PICTURE: &str = "picture in memory.exr";
const FRAMES: &str = "frame %07d in memory.exr";
/// Longest message, in characters.
const LONGEST_LINE: usize = 480;

/// Returns the one line that the program prints for an error, without its name.
pub fn message(error: &anyhow::Error) -> String {
    printable(&chain(error.as_ref()), LONGEST_LINE)
}

/// Opens a GPU. `wish` is `best`, `software`, or a part of a GPU's name.
///
/// # Errors
/// No GPU matches, or its driver fails.
pub fn open_gpu(wish: &str) -> anyhow::Result<Gpu> {
    raise_file_limit();
    let Ok(wish) = wish.parse::<AdapterWish>();
    let gpu = Gpu::open(&wish)?;
    world::store_pipelines(&gpu);
    Ok(gpu)
}

/// A world for many pictures. Its heights are opened once.
pub struct HostWorld {
    gpu: Gpu,
    name: String,
    /// Options of the world, as words of the command line.
    options: Vec<String>,
    /// The scene for which the heights were opened.
    scene: Scene,
    store: Arc<dyn TileStore>,
    opened: Option<Opened>,
}

impl HostWorld {
    /// Opens a world by its name: a path, an address, or a built-in scene. An empty name is the built-in world.
    /// `options` are words such as `--exaggeration=2`.
    ///
    /// # Errors
    /// The errors of the command line.
    pub fn open(gpu: &Gpu, name: &str, options: &[String]) -> anyhow::Result<Self> {
        let args = parsed(name, options, &[], Path::new(PICTURE))?;
        args.world.check()?;
        let scene = args.world.scene()?;
        let store = world::open_store(&scene, &Bar::default()).map_err(|error| args.world.or_drawing(error))?;
        Ok(Self::of(gpu, name, options, scene, store))
    }

    /// Opens heights in memory.
    ///
    /// # Errors
    /// Heights that cannot be drawn, and the errors of the options.
    pub fn of_heights(gpu: &Gpu, mut grid: HeightGrid, options: &[String]) -> anyhow::Result<Self> {
        let scene = parsed(IN_MEMORY, options, &[], Path::new(PICTURE))?.world.scene_in_memory()?;
        let is_height = |height_m: f32| f64::from(height_m).abs() <= MAX_HEIGHT_M;
        grid.heights_m.iter_mut().filter(|height| !is_height(**height)).for_each(|height| *height = f32::NAN);
        let samples = u64::from(grid.width) * u64::from(grid.height);
        if grid.width < 2 || grid.height < 2 || samples != grid.heights_m.len() as u64 {
            bail!("{IN_MEMORY}: {} x {} samples are too few; a world has at least 2 x 2", grid.width, grid.height);
        }
        if scene.heights.voids == VoidMode::Fill {
            fill_grid(&mut grid);
        }
        let store = Arc::new(MemoryStore::new(grid, IN_MEMORY, &Silent)?);
        Ok(Self::of(gpu, IN_MEMORY, options, scene, store))
    }

    fn of(gpu: &Gpu, name: &str, options: &[String], scene: Scene, store: Arc<dyn TileStore>) -> Self {
        Self { gpu: gpu.clone(), name: name.to_owned(), options: options.to_vec(), scene, store, opened: None }
    }

    /// Draws a picture, or with `--path` the pictures of a flight, and passes each to `take`.
    ///
    /// # Errors
    /// The errors of `hachure render` and of `take`.
    pub fn draw<'a>(
        &'a mut self,
        style: &Style,
        options: &[String],
        take: impl FnMut(DrawnPicture) -> anyhow::Result<()> + 'a,
    ) -> anyhow::Result<()> {
        let is_flight = options.iter().any(|option| option.starts_with("--path="));
        let output = Path::new(if is_flight { FRAMES } else { PICTURE });
        let args = parsed(&self.name, &self.options, options, output)?;
        if args.show.is_some() {
            bail!(Misuse("--show: applies only to files".to_owned()));
        }
        render::run_hosted(&args, Host { take: Some(Box::new(take)), ..self.host(style) })
    }

    /// Draws into a file, whose ending decides what is drawn, as `hachure render -o` does.
    ///
    /// # Errors
    /// The errors of `hachure render`.
    pub fn write(&mut self, output: &Path, style: &Style, options: &[String]) -> anyhow::Result<()> {
        let args = parsed(&self.name, &self.options, options, output)?;
        render::run_hosted(&args, self.host(style))
    }

    fn host(&mut self, style: &Style) -> Host<'_> {
        Host {
            gpu: Some(self.gpu.clone()),
            heights: Some((&self.scene, Arc::clone(&self.store))),
            style: Some(style.clone()),
            opened: Some(&mut self.opened),
            ..Host::default()
        }
    }

    /// Returns the name of the world.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns whether the heights have no file.
    pub fn is_in_memory(&self) -> bool {
        self.scene.world == World::Memory
    }

    /// Returns the heights.
    pub fn store(&self) -> &dyn TileStore {
        &*self.store
    }

    /// Flies a camera path and writes the report of the cost of styles into the folder of `--output`, as
    /// `hachure bench` does. Returns the report as JSON.
    ///
    /// # Errors
    /// The errors of `hachure bench`, and heights in memory, which it cannot open.
    pub fn bench(&self, options: &[String]) -> anyhow::Result<String> {
        if self.is_in_memory() {
            bail!(Misuse(format!("bench: opens worlds by name, and cannot measure {IN_MEMORY}; save them to a file")));
        }
        let words = [&self.options, options].concat();
        let Command::Bench(args) = command("bench", &self.name, &words)? else { bail!("bench: is no such command") };
        if args.suite.is_some() {
            bail!(Misuse("--suite: use the program, hachure bench --suite".to_owned()));
        }
        Ok(serde_json::to_string(&bench::measured(&args, || Ok(self.gpu.clone()))?)?)
    }
}

/// Parses the words of `hachure render`.
fn parsed(name: &str, world: &[String], options: &[String], output: &Path) -> anyhow::Result<RenderArgs> {
    let Some(output) = output.to_str() else { bail!("{}: the name is not Unicode", output.display()) };
    let words = [world, options, &[format!("--output={output}")]].concat();
    let Command::Render(args) = command("render", name, &words)? else { bail!("render: is no such command") };
    Ok(*args)
}

/// Parses the words of a command.
fn command(command: &str, name: &str, options: &[String]) -> anyhow::Result<Command> {
    let mut words = vec![command.to_owned()];
    words.extend_from_slice(options);
    if !name.is_empty() {
        words.extend(["--".to_owned(), name.to_owned()]);
    }
    let cli = Cli::try_parse_from(std::iter::once("hachure").chain(words.iter().map(String::as_str)));
    match cli {
        Ok(Cli { command: Some(command), .. }) => Ok(command),
        Ok(_) => bail!("{command}: is no such command"),
        Err(error) if error.use_stderr() => bail!(Misuse(misuse::describe(&error, &words, &Cli::command()))),
        Err(_) => bail!(Misuse("help and version: are those of the program".to_owned())),
    }
}

/// A style with the text that it was read from.
#[derive(Clone)]
pub struct HostStyle {
    style: Style,
    text: String,
}

impl HostStyle {
    /// Loads a preset or a style file, with other values at some keys, such as `strokes.width_px=2`.
    ///
    /// # Errors
    /// The errors of `--style` and `--set`.
    pub fn load(name: &str, values: &[String]) -> anyhow::Result<Self> {
        let (style, text) = styles::load(name)?;
        Self { style, text }.with(values)
    }

    /// Reads a style from TOML text. Errors call it `name`.
    ///
    /// # Errors
    /// The text is not a style.
    pub fn parse(name: &str, text: &str) -> anyhow::Result<Self> {
        let style = Style::parse(name, text)?;
        crate::tones::hatching::maps::check(&style)?;
        Ok(Self { style, text: text.to_owned() })
    }

    /// Returns the style with other values at some keys.
    ///
    /// # Errors
    /// A key that no parameter has, or a value that the parameter cannot have.
    pub fn with(&self, values: &[String]) -> anyhow::Result<Self> {
        let parsed = |value: &String| {
            value.parse().map_err(|cause| anyhow::Error::from(Misuse(format!("--set {value}: {cause}"))))
        };
        let values = values.iter().map(parsed).collect::<anyhow::Result<Vec<_>>>()?;
        if values.is_empty() {
            return Ok(self.clone());
        }
        let text = style::set::with_values(&self.style.name, &self.text, &self.style, &values);
        let text = text.map_err(|error| arguments::of_value("--set", error))?;
        let mut style = Style::parse(&self.style.name, &text).map_err(|error| arguments::of_value("--set", error))?;
        let is_own = |file: &&PathBuf| **file == Path::new(&self.style.name);
        style.files.extend(self.style.files.iter().filter(is_own).cloned());
        crate::tones::hatching::maps::check(&style)?;
        Ok(Self { style, text })
    }

    /// Returns the style.
    pub fn style(&self) -> &Style {
        &self.style
    }

    /// Returns the parameters as JSON, as `hachure styles show NAME --all --json` prints them.
    ///
    /// # Errors
    /// The parameters cannot be written as JSON.
    pub fn parameters(&self) -> anyhow::Result<String> {
        styles::parameters(&self.style, &self.text)
    }
}
