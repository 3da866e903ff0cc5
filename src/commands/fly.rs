//! `hachure fly`, and `hachure` alone: a window to fly over a world in.

use std::path::Path;

use clap::Args;

use super::arguments;
use super::height_args::HeightArgs;
use super::render::parse_size;
use crate::gpu::device::AdapterWish;
use crate::scene::camera::Camera;
use crate::scene::reach::Reach;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::window::{FlightOptions, FlightWorld, Windowing};
use crate::world::{self, OpenWorld};

/// Arguments of `fly`.
#[derive(Clone, Debug, Args)]
pub struct FlyArgs {
    /// Scene file, DEM or baked pyramid; without one, the embedded world
    pub world: Option<String>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Let a scene file name files outside of its folder, and addresses
    #[arg(long)]
    pub trust_scene: bool,
    /// A preset or a style file
    #[arg(long, default_value = "ink")]
    pub style: String,
    /// Where to start: x,y,z,yaw,pitch,fov in metres (z as +h above ground) and degrees
    #[arg(long, allow_hyphen_values = true)]
    pub camera: Option<Camera>,
    /// Width and height of the window in pixels, like 1280x720
    #[arg(long, default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// How many eyes: mono
    #[arg(long, default_value = "mono", value_parser = super::parse_eyes)]
    pub eyes: String,
    /// Height error that may be seen, in pixels
    #[arg(long, default_value_t = 1.0, value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub lod_error: f64,
    /// Memory for tiles on the GPU, in MiB
    #[arg(long, default_value_t = 512, value_parser = arguments::whole::<u64>(1, 1 << 20))]
    pub tile_memory: u64,
    /// Render without rest, print the frame times, and quit after this many pictures
    #[arg(long, hide = true, value_parser = arguments::whole::<u64>(1, u64::MAX))]
    pub frames: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// When there is no display, an input does not hold, or the GPU fails.
pub fn run(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    // What is wrong is told before a window opens.
    arguments::style(&args.style)?;
    arguments::check_world(args.world.as_deref())?;
    let windowing = Windowing::new()?;
    let options =
        FlightOptions { style: args.style.clone(), size_px: args.size, adapter: adapter.clone(), frames: args.frames };
    // As early: a DEM that is seen for the first time takes a while to bake.
    let scene = args.heights.over(world::scene_of(args.world.as_deref(), Reach::trusting(args.trust_scene))?);
    let store = world::open_store(&scene, &super::progress::Bar::default())?;
    let args = args.clone();
    let open = move |gpu: &crate::gpu::Gpu| {
        let (lod_error_px, tile_memory_bytes) = (args.lod_error, args.tile_memory << 20);
        let options =
            TerrainOptions { lod_error_px, tile_memory_bytes, loading: Loading::Stream, ..TerrainOptions::default() };
        let world = OpenWorld::on_gpu(gpu, scene, store, options)?;
        let start = args.camera.unwrap_or_else(|| world.default_camera());
        let start = start.on_ground(|east_m, north_m| world.ground_m(east_m, north_m));
        if let Err(error) = world.ground_was_read() {
            tracing::warn!("{error}");
        }
        Ok(FlightWorld {
            name: title(args.world.as_deref()),
            light: world.light(),
            sun: world.scene.sun,
            start,
            surfaces: world.surfaces,
        })
    };
    Ok(windowing.run(options, Box::new(open))?)
}

/// The file's name without its folders.
fn title(world: Option<&str>) -> String {
    let Some(world) = world else { return "the embedded world".to_owned() };
    Path::new(world).file_name().map_or_else(|| world.to_owned(), |name| name.to_string_lossy().into_owned())
}
