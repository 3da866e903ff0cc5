//! Cameras that hachure chooses: the start view of a world, and a view of a given place.
//!
//! The start view shows the most prominent summit, with light from the side, the horizon above the middle, and no view
//! onto no-data. Why: `docs/decisions/start-view.md`.

mod above;
mod framing;
mod ground;
mod model;
mod raster;
mod summit;

use glam::{DVec2, DVec3};

use self::ground::Land;
use self::raster::Raster;
use super::OpenWorld;
use crate::pyramid::PyramidError;
use crate::pyramid::store::DataArea;
use crate::scene::camera::{Camera, LARGEST_COORDINATE_M};
use crate::scene::look::StandPoint;

/// Width over height of a picture whose shape is not known.
const USUAL_ASPECT: f64 = 16.0 / 9.0;
/// Narrowest and widest picture for which a camera is chosen.
const ASPECTS: [f64; 2] = [0.3, 4.0];
/// Radius around the summit in which a finer raster is read, in samples of the coarse one; and how much finer it must
/// be.
const NEAR_CELLS: f64 = 160.0;
const LEAST_FINER: f64 = 0.7;

impl OpenWorld {
    /// Returns the scene's start, or else a camera that frames the most prominent summit, for a picture of 16 : 9.
    pub fn default_camera(&self) -> Camera {
        self.start_camera(USUAL_ASPECT)
    }

    /// Returns the scene's start, or else a camera that frames the most prominent summit: within the middle half of the
    /// picture, with light from the side, the horizon above the middle, at most 40 % of sky, and no view onto no-data.
    /// `aspect` is the width of the picture over its height.
    ///
    /// A model that is opened by itself is seen from in front and above, all of it.
    ///
    /// Heights that cannot be read, which drawing reports, are seen from above the middle of the world.
    pub fn start_camera(&self, aspect: f64) -> Camera {
        let summit = || self.summit_camera(aspect).ok().flatten();
        let of_world = || model::camera(self, usable(aspect)).or_else(summit).unwrap_or_else(|| self.camera_above());
        self.scene.start.unwrap_or_else(of_world)
    }

    /// Returns a camera that looks at a place, east and north in metres, in the same way; or from where `from` says.
    /// Returns `None` if there is no land at the place.
    ///
    /// # Errors
    /// Fails if the heights cannot be read.
    pub fn camera_looking_at(
        &self,
        place_m: DVec2,
        from: Option<StandPoint>,
        aspect: f64,
    ) -> Result<Option<Camera>, PyramidError> {
        let terrain = &self.surfaces.terrain;
        let Some(height_m) = terrain.height_m(place_m) else { return Ok(None) };
        let whole = Raster::read(terrain, terrain.corners_m())?;
        let from = from.map(|StandPoint { azimuth_deg, distance_m }| [azimuth_deg, distance_m]);
        self.framed(&whole, place_m.extend(height_m), 0.0, from, aspect)
    }

    fn summit_camera(&self, aspect: f64) -> Result<Option<Camera>, PyramidError> {
        let terrain = &self.surfaces.terrain;
        let mut whole = Raster::read(terrain, terrain.corners_m())?;
        if whole.data().is_none()
            && let Some(corners_m) = self.highest_cell_m()
        {
            // The data are narrower than a cell, as a strip of LiDAR in a large raster may be.
            whole = Raster::read(terrain, corners_m)?;
        }
        let Some(summit) = summit::most_prominent(&whole) else { return Ok(None) };
        let place_m = whole.place_m(summit.cell).extend(f64::from(summit.height_m));
        self.framed(&whole, self.refined(&whole, place_m)?, summit.top_m, None, aspect)
    }

    /// Returns the highest place of the finer raster within a cell of a summit: means of cells are lower.
    fn refined(&self, whole: &Raster, summit_m: DVec3) -> Result<DVec3, PyramidError> {
        let terrain = &self.surfaces.terrain;
        let reach_m = 1.5 * whole.cell_m;
        let around = Raster::read(terrain, [summit_m.truncate() - reach_m, summit_m.truncate() + reach_m])?;
        let places = around.heights_m.iter().enumerate().filter(|(_, height_m)| f64::from(**height_m) > summit_m.z);
        let highest = places.max_by(|a, b| a.1.total_cmp(b.1));
        Ok(highest.map_or(summit_m, |(at, height_m)| around.place_m(around.cell(at)).extend(f64::from(*height_m))))
    }

    /// Returns a camera that shows a place whose top has the radius `top_m`.
    fn framed(
        &self,
        whole: &Raster,
        place_m: DVec3,
        top_m: f64,
        from: Option<[f64; 2]>,
        aspect: f64,
    ) -> Result<Option<Camera>, PyramidError> {
        let terrain = &self.surfaces.terrain;
        let Some(([low_m, high_m], _)) = whole.data() else { return Ok(None) };
        let size_m = (high_m - low_m).max_element();
        let near = self.near(whole, place_m.truncate(), from.map_or(0.0, |[_, distance_m]| distance_m))?;
        let levels = terrain.store().levels()[0];
        let spacing_m = size_m.min((terrain.corners_m()[1] - terrain.corners_m()[0]).max_element())
            / f64::from(levels.width.max(levels.height));
        let land = Land::new(whole, near.as_ref(), spacing_m, self.light(), place_m.truncate(), size_m);
        let subject = land.subject(place_m, top_m, size_m, from);
        let mut camera = land.framed(&subject, usable(aspect)).camera;
        // The land of the finest level may be higher than that of the raster.
        let ground_m = terrain.height_m(camera.position_m.truncate()).unwrap_or(f64::NEG_INFINITY);
        camera.position_m.z = camera.position_m.z.max(ground_m + 2.0 * land.spacing_m.min(20.0));
        camera.position_m = rounded(camera.position_m, land.spacing_m);
        let steps_per_deg = if camera.fov_deg < 10.0 { 100.0 } else { 10.0 };
        camera.yaw_deg = (camera.yaw_deg * steps_per_deg).round() / steps_per_deg;
        camera.pitch_deg = (camera.pitch_deg * steps_per_deg).round() / steps_per_deg;
        Ok(Some(camera))
    }

    /// Returns the corners of the highest patch that has heights, with some space around.
    fn highest_cell_m(&self) -> Option<[DVec2; 2]> {
        let terrain = &self.surfaces.terrain;
        let area = DataArea::of(terrain.store()).ok()?;
        let highest = area.cells.iter().max_by(|a, b| a.range_m[1].total_cmp(&b.range_m[1]))?;
        let place = |at: [f64; 2]| terrain.mapping().world_from_grid(at[0], at[1]);
        let [a, b] = [place(highest.low), place(highest.high)];
        let around_m = 2.0 * (b - a).abs().max_element().max(1e-6);
        Some([a.min(b) - around_m, a.max(b) + around_m])
    }

    /// Reads a finer raster of the land around a place, if the coarse one is not as fine as the heights.
    fn near(&self, whole: &Raster, place_m: DVec2, least_m: f64) -> Result<Option<Raster>, PyramidError> {
        let radius_m = (NEAR_CELLS * whole.cell_m).max(1.5 * least_m);
        let [low_m, high_m] = whole.corners_m();
        let corners_m = [(place_m - radius_m).max(low_m), (place_m + radius_m).min(high_m)];
        if !corners_m[0].cmplt(corners_m[1]).all() {
            return Ok(None);
        }
        let near = Raster::read(&self.surfaces.terrain, corners_m)?;
        Ok((near.cell_m < LEAST_FINER * whole.cell_m).then_some(near))
    }

    /// Returns a camera that looks down at the whole extent.
    fn camera_above(&self) -> Camera {
        let size_m = DVec2::from_array(self.extent_m()).max_element();
        let [low_m, high_m] = self.surfaces.terrain.range_m().map(f64::from);
        let z_m = high_m + 1.3 * size_m;
        let z_m = if z_m.is_finite() { z_m } else { low_m.max(0.0) };
        Camera {
            position_m: DVec3::new(0.0, 0.0, z_m.min(LARGEST_COORDINATE_M)),
            height_above_ground: false,
            yaw_deg: 0.0,
            pitch_deg: -89.0,
            fov_deg: framing::FOV_DEG,
        }
    }

    /// Returns the extent of the heights: west, south, east and north in metres; `None` if all of the world has
    /// heights, or if they cannot be read, which drawing reports.
    pub(crate) fn data_extent_m(&self) -> Option<[f64; 4]> {
        let terrain = &self.surfaces.terrain;
        let area = DataArea::of(terrain.store()).ok().filter(|area| !area.is_whole)?;
        let corners = area.cells.iter().flat_map(|cell| {
            let steps = [0.0, 0.5, 1.0];
            steps.into_iter().flat_map(move |v| steps.map(|u| (u, v))).map(|(u, v)| {
                let at = |axis: usize, t: f64| cell.low[axis] + (cell.high[axis] - cell.low[axis]) * t;
                terrain.mapping().world_from_grid(at(0, u), at(1, v))
            })
        });
        let (mut low_m, mut high_m) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners {
            (low_m, high_m) = (low_m.min(corner), high_m.max(corner));
        }
        // A single row or column has no width.
        let least_m = DVec2::from_array(self.extent_m()).max_element() * 1e-4;
        let [low_m, high_m] = [low_m - least_m, high_m + least_m];
        (low_m.is_finite() && high_m.is_finite()).then_some([low_m.x, low_m.y, high_m.x, high_m.y])
    }
}

/// Returns the nearest shape of a picture for which a camera is chosen.
fn usable(aspect: f64) -> f64 {
    if aspect.is_finite() { aspect.clamp(ASPECTS[0], ASPECTS[1]) } else { USUAL_ASPECT }
}

/// Rounds a position to a tenth of a sample or finer, so that a camera can be read and repeated.
fn rounded(position_m: DVec3, spacing_m: f64) -> DVec3 {
    let step_m = 10.0_f64.powf((0.1 * spacing_m).log10().floor()).clamp(1e-3, 1.0);
    DVec3::new(
        (position_m.x / step_m).round() * step_m,
        (position_m.y / step_m).round() * step_m,
        (position_m.z / step_m).ceil() * step_m,
    )
}
