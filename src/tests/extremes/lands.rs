//! Worlds of extreme spacing and far from the origin, and the cameras that look at them.

use std::sync::Arc;

use glam::DVec2;
use hachure::pyramid::TileStore;
use hachure::pyramid::store::{MemoryStore, MosaicStore};
use hachure::scene::earth::Earth;
use hachure::scene::view::Pose;
use hachure::source::{HeightGrid, Silent};
use hachure::tiles::Terrain;
use hachure::tiles::terrain::TerrainOptions;

use crate::tests::common::{World, grid_of, rough_height_m};

/// Number of samples along a side.
pub(super) const SAMPLES: u32 = 257;
/// Spacing of ordinary land, in metres.
pub(super) const SPACING_M: f64 = 30.0;
/// How far the distant land is from the origin, in metres: a whole number of samples.
pub(super) const FAR_M: f64 = 333_333.0 * SPACING_M;

/// A world, and the factor between its lengths and those of ordinary land.
pub(super) struct Land {
    pub name: String,
    pub world: World,
    pub factor: f64,
    /// East and north of the middle of the land, in metres.
    pub middle_m: DVec2,
}

/// Returns the heights of rough land with lakes.
fn grid(spacing_m: f64) -> HeightGrid {
    let factor = spacing_m / SPACING_M;
    // No land is higher than the highest mountains.
    let raised = factor.min(4.0);
    grid_of(SAMPLES, SAMPLES, spacing_m, |x, y| raised * rough_height_m(x / factor, y / factor).max(400.0))
}

impl Land {
    /// Returns rough land of a spacing in metres; that of more than 1 km is on a bent earth.
    pub(super) fn of_spacing(spacing_m: f64) -> Option<Self> {
        let mut land = Self::of_grid(grid(spacing_m), spacing_m)?;
        if spacing_m > 1000.0 {
            let inverse_radius = Earth { refraction: 0.13 }.inverse_radius();
            let options = TerrainOptions { inverse_radius, ..TerrainOptions::default() };
            let store = Arc::clone(land.world.surfaces.terrain.store());
            land.world.surfaces = Terrain::new(&land.world.gpu, store, options).unwrap().into();
        }
        Some(land)
    }

    /// Returns the flat land of a grid.
    pub(super) fn of_grid(grid: HeightGrid, spacing_m: f64) -> Option<Self> {
        let (world, name) = (World::new(grid, 1.0)?, format!("{spacing_m} m between samples"));
        Some(Self { name, world, factor: spacing_m / SPACING_M, middle_m: DVec2::ZERO })
    }

    /// Returns rough land of ordinary spacing [`FAR_M`] east of the origin, on a plain whose middle is the origin.
    pub(super) fn far() -> Option<Self> {
        Self::far_of(&grid(SPACING_M))
    }

    /// Returns the land of a grid of ordinary spacing at the place of [`Land::far`].
    pub(super) fn far_of(grid: &HeightGrid) -> Option<Self> {
        let member =
            |grid: HeightGrid| Arc::new(MemoryStore::new(grid, "land", &Silent).unwrap()) as Arc<dyn TileStore>;
        let mut there = grid.clone();
        there.georeference.crs_from_grid[0] += FAR_M;
        // The world reaches as far west as east, and its middle is the origin.
        let plain_spacing_m = 1024.0 * SPACING_M;
        let half = ((FAR_M + f64::from(SAMPLES) * SPACING_M) / plain_spacing_m).ceil() as u32;
        let plain = grid_of(2 * half + 1, 9, plain_spacing_m, |_, _| 400.0);
        let store = Arc::new(MosaicStore::new(vec![member(there), member(plain)]).unwrap());
        let world = World::of_store(grid.clone(), tempfile::tempdir().unwrap(), store, 1.0)?;
        let middle_m = DVec2::new(FAR_M, 0.0);
        assert!(world.surfaces.terrain.height_m(middle_m).is_some(), "there is land");
        Some(Self { name: format!("{FAR_M} m east"), world, factor: 1.0, middle_m })
    }

    /// Returns the pose of a camera whose lengths are those of ordinary land; `ground_m` above or below the ground if it
    /// is given, else `z_m` above sea level.
    pub(super) fn pose(&self, camera: &Camera) -> Pose {
        let Camera { at_m: [x, y], z_m, yaw_deg, pitch_deg, fov_deg, .. } = *camera;
        let at = DVec2::new(x, y) * self.factor + self.middle_m;
        let z = match z_m {
            Height::Ground(above_m) => format!("{:+}", above_m * self.factor.min(4.0)),
            // A camera is at most 100,000 km away.
            Height::Sea(z_m) => format!("{}", (z_m * self.factor).clamp(-1e8, 1e8)),
        };
        self.world.pose(&format!("{},{},{z},{yaw_deg},{pitch_deg},{fov_deg}", at.x, at.y))
    }
}

/// Height of a camera in metres.
#[derive(Clone, Copy, Debug)]
pub(super) enum Height {
    Ground(f64),
    Sea(f64),
}

/// A camera over ordinary land.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    pub name: &'static str,
    pub at_m: [f64; 2],
    pub z_m: Height,
    pub yaw_deg: f64,
    pub pitch_deg: f64,
    pub fov_deg: f64,
}

const fn camera(name: &'static str, at_m: [f64; 2], z_m: Height, pitch_deg: f64, fov_deg: f64) -> Camera {
    Camera { name, at_m, z_m, yaw_deg: 17.0, pitch_deg, fov_deg }
}

/// The ordinary view: land, a lake, and the sky.
pub(super) const ORDINARY: Camera = camera("an ordinary view", [-300.0, -2600.0], Height::Ground(300.0), -9.0, 55.0);

/// Extreme views. Those that show other kinds of pixels come first.
pub(super) const EXTREME: [Camera; 15] = [
    camera("a lens of 1 degree", [-300.0, -2600.0], Height::Ground(300.0), -12.0, 1.0),
    camera("a lens of 150 degrees", [-300.0, -2600.0], Height::Ground(300.0), -9.0, 150.0),
    camera("straight down", [100.0, -900.0], Height::Ground(900.0), -90.0, 60.0),
    camera("straight up", [100.0, -900.0], Height::Ground(300.0), 90.0, 60.0),
    camera("below the ground", [100.0, -900.0], Height::Ground(-200.0), 10.0, 70.0),
    camera("below the ground, straight up", [100.0, -900.0], Height::Ground(-200.0), 90.0, 70.0),
    camera("10 cm above the ground", [100.0, -900.0], Height::Ground(0.1), -3.0, 90.0),
    camera("on the ground, straight down", [100.0, -900.0], Height::Ground(0.001), -90.0, 90.0),
    camera("1000 km up", [0.0, 0.0], Height::Sea(1e6), -89.9, 1.0),
    camera("below the ground, straight down", [100.0, -900.0], Height::Ground(-200.0), -90.0, 70.0),
    camera("the longest lens", [-300.0, -2600.0], Height::Ground(300.0), -12.0, 0.1),
    camera("the widest lens", [-300.0, -2600.0], Height::Ground(300.0), -9.0, 170.0),
    camera("far outside", [0.0, -60_000.0], Height::Sea(3000.0), -2.0, 4.0),
    camera("in the ground", [100.0, -900.0], Height::Ground(0.0), -1.0, 150.0),
    camera("deep below", [0.0, 0.0], Height::Sea(-50_000.0), 80.0, 30.0),
];
