//! Tests that every preset draws on a device that has only the default limits of WebGPU.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::sync::Arc;

use crate::tests::helpers::shapes;
use common::draw::{NOON, draw, north_west, still};

use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::gpu::readback::read;
use hachure::imagery::Imagery;
use hachure::imagery::tests::write_png;
use hachure::mesh::placed::Placed;
use hachure::pyramid::TileStore;
use hachure::scene::ImageFile;
use hachure::scene::view::{Pose, View};
use hachure::style::Style;
use hachure::tiles::Terrain;
use hachure::tiles::terrain::TerrainOptions;
use hachure::world::Surfaces;

const SIZE_PX: [u32; 2] = [96, 54];

/// Returns the picture after two frames, so that strokes are carried over from the first.
fn drawing(gpu: &Gpu, surfaces: &mut Surfaces, style: &Style, pose: Pose) -> Vec<u8> {
    let mut renderer = Renderer::new(gpu).unwrap();
    let mut previous = pose;
    for i in 0..2 {
        let now = Pose { position_m: pose.position_m + pose.forward * f64::from(i), ..pose };
        let view = View::whole(previous, now, SIZE_PX);
        previous = now;
        draw(gpu, surfaces, &mut renderer, &view, style, &north_west());
    }
    read(gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap()
}

#[test]
fn every_preset_draws_within_the_default_limits() {
    let Some((hill, mut world)) = shapes::hill() else { return };
    let gpu = match Gpu::open_within(&AdapterWish::Best, wgpu::Limits::default()) {
        Ok(gpu) => gpu,
        Err(error) => panic!("{error}"),
    };
    assert_eq!(gpu.device.limits().max_storage_buffers_per_shader_stage, 8);
    let pose = world.pose("900,-900,+20,315,3,60");
    let at_m = DVec3::new(850.0, -850.0, 0.0);
    let at_m = at_m.with_z(hill.height_m(at_m.x, at_m.y) + 10.0);
    let stance = shapes::stance(at_m, 0.0, 10.0);
    let mesh = Arc::new(shapes::mesh(shapes::cube()));
    shapes::place(&mut world, &mesh, &stance);
    let store = Arc::clone(world.surfaces.terrain.store());
    let mut surfaces = Surfaces::from(Terrain::new(&gpu, store, TerrainOptions::default()).unwrap());
    let placed: &Placed = world.surfaces.meshes().unwrap();
    surfaces.set_meshes(placed.clone());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    write_png(&path, [300, 300], |x, y| [x as u8, y as u8, 0, 255]);
    let open = |store: &dyn TileStore| {
        let size = store.levels()[0];
        let files = [ImageFile { path: path.clone() }];
        Imagery::open(&files, store.georeference(), [size.width, size.height]).unwrap()
    };
    surfaces.set_imagery(&gpu, open(&**surfaces.terrain.store()));
    world.surfaces.set_imagery(&world.gpu, open(&**world.surfaces.terrain.store()));
    // No other passes bind as many storage buffers as those of strokes.
    let mut names = if common::full() { common::presets() } else { vec!["plain", "strokes"] };
    names.sort_unstable();
    let mut pictures = Vec::new();
    for name in names {
        let style = common::preset(name);
        let (within, beyond) =
            (drawing(&gpu, &mut surfaces, &style, pose), drawing(&world.gpu, &mut world.surfaces, &style, pose));
        // Higher limits of a device do not change the picture.
        assert!(within == beyond, "{name}");
        pictures.push(within);
    }
    // Planted: another style.
    assert!(pictures[0] != pictures[pictures.len() - 1]);
    // A device with lower limits is refused with an error.
    let less = wgpu::Limits { max_storage_buffers_per_shader_stage: 7, ..wgpu::Limits::default() };
    let gpu = Gpu::open_within(&AdapterWish::Best, less).unwrap();
    let store = Arc::clone(world.surfaces.terrain.store());
    let mut surfaces = Terrain::new(&gpu, store, TerrainOptions::default()).unwrap().into();
    let style = Style::load("pen").unwrap();
    let refused = Renderer::new(&gpu).unwrap().render(&gpu, &mut surfaces, &still(pose, SIZE_PX), &style, &NOON);
    let error = refused.map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("storage") && !error.contains('\n'), "{error}");
}
