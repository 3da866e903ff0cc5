//! Measured error of the drawn surface against the full-resolution heights, in pixels (not the bound).

use glam::DVec2;
use rayon::prelude::*;

use crate::frame::Renderer;
use crate::gpu::{Gpu, GpuError};
use crate::pyramid::tile::TILE_SAMPLES;
use crate::scene::view::View;
use crate::surface::id::Kind;
use crate::tiles::Terrain;

/// Largest number of pixels that are tested, spread over the picture.
const SAMPLES: u32 = 2048;

/// Returns the largest projected error on a lattice of pixels of the picture that `renderer` drew last: the height of
/// the drawn position against the level-0 surface at the same place, |dz| · focal length / distance. Pixels of the sky,
/// of meshes, beyond the extent and in no-data areas are ignored; `None` if no pixel is left. `turn` shifts the
/// lattice.
///
/// # Errors
/// [`GpuError::Readback`].
pub fn largest_px(
    gpu: &Gpu,
    renderer: &Renderer,
    view: &View,
    terrain: &Terrain,
    turn: u32,
) -> Result<Option<f64>, GpuError> {
    let [width, height] = renderer.size_px();
    let Some(texels) = renderer.places(gpu, 0, [0, 0], [width, height])? else { return Ok(None) };
    let Some(kinds) = renderer.kinds(gpu, 0, [0, 0], [width, height])? else { return Ok(None) };
    let pixels = f64::from(width) * f64::from(height);
    let stride = (pixels / f64::from(SAMPLES)).sqrt().ceil().max(1.0) as u32;
    // 5 and 7 have no factor in common with most strides, so each turn visits other pixels.
    let [left, top] = [turn.wrapping_mul(5) % stride, turn.wrapping_mul(7) % stride];
    let lattice = (top..height)
        .step_by(stride as usize)
        .flat_map(|y| (left..width).step_by(stride as usize).map(move |x| (y as usize, x as usize)));
    let camera_m = view.pose.position_m;
    let earth_curvature = terrain.earth_curvature(camera_m.z);
    let mut drawn: Vec<Drawn> = lattice
        .map(|(y, x)| y * width as usize + x)
        .filter(|pixel| kinds[*pixel] == Kind::Land)
        .map(|pixel| texels[pixel])
        .filter(|texel| texel[3] > 0.0)
        .map(|[x, y, z, _]| {
            let from_eye_m = glam::Vec3::new(x, y, z).as_dvec3();
            let place_m = camera_m + earth_curvature.unbend(from_eye_m);
            let grid = terrain.mapping().grid_from_world(place_m.truncate());
            Drawn { grid, z_m: place_m.z, distance_m: from_eye_m.length() }
        })
        .filter(|drawn| drawn.grid.is_finite())
        .collect();
    // Sorted by tile, so that each tile is read once.
    drawn.sort_by_key(Drawn::tile);
    let focal_px = view.focal_px();
    let ground = terrain.ground();
    let errors_px = drawn.par_chunk_by(|a, b| a.tile() == b.tile()).flat_map_iter(|drawn| {
        drawn.iter().filter_map(|drawn| {
            let true_m = ground.height_m(drawn.grid.x, drawn.grid.y)?;
            Some((drawn.z_m - true_m).abs() * focal_px / drawn.distance_m)
        })
    });
    Ok(errors_px.reduce_with(f64::max))
}

/// A tested pixel: its position on the grid, its height and its distance from the eye.
struct Drawn {
    grid: DVec2,
    z_m: f64,
    distance_m: f64,
}

impl Drawn {
    /// Returns row and column of the level-0 tile; arbitrary far outside.
    fn tile(&self) -> [i64; 2] {
        let side = f64::from(TILE_SAMPLES);
        [(self.grid.y / side).floor() as i64, (self.grid.x / side).floor() as i64]
    }
}
