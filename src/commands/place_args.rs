//! Options that name places by latitude and longitude: `--look-at` of `render` and `fly`, and `--at` of a map.

use std::path::Path;
use std::str::FromStr;

use anyhow::bail;
use clap::Args;
use glam::DVec2;

use super::arguments;
use crate::file::message::named;
use crate::pyramid::TileStore;
use crate::scene::World;
use crate::scene::camera::Camera;
use crate::scene::look::StandPoint;
use crate::scene::map::MapArea;
use crate::scene::ranges;
use crate::scene::sun_time::LatLon;
use crate::source::georeference::Crs;
use crate::source::lon_lat::GridOnWgs84;
use crate::world::OpenWorld;

/// A place to look at.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct LookArgs {
    /// Look at this place instead of giving --camera: latitude and longitude in WGS 84, in degrees, like 46.5370,7.9622
    #[arg(long, value_name = "LAT,LON", value_parser = LatLon::from_str, allow_hyphen_values = true, conflicts_with = "camera")]
    pub look_at: Option<LatLon>,
    /// Where the camera of --look-at is: its direction from the place in degrees, clockwise from north, and its distance
    /// on the map in metres [default: where the place is seen well, with light from the side]
    #[arg(long, value_name = "AZIMUTH,DISTANCE", value_parser = StandPoint::from_str, allow_hyphen_values = true, requires = "look_at")]
    pub from: Option<StandPoint>,
}

impl LookArgs {
    /// Returns the position of the place, if one is given: east and north in metres.
    ///
    /// # Errors
    /// Fails if the heights have no position on the earth, or do not contain the place.
    pub(crate) fn place_m(&self, world: Option<&str>, store: &dyn TileStore) -> anyhow::Result<Option<DVec2>> {
        self.look_at.map(|place| place_m("--look-at", place, world, store)).transpose()
    }

    /// Returns the camera that looks at the place.
    ///
    /// # Errors
    /// Fails if the place has no height, or if heights cannot be read.
    pub(crate) fn camera(&self, place_m: DVec2, world: &OpenWorld, aspect: f64) -> anyhow::Result<Camera> {
        let camera = world.camera_looking_at(place_m, self.from, aspect)?;
        world.ground_was_read()?;
        let Some(camera) = camera else {
            let place = self.look_at.map(text).unwrap_or_default();
            bail!("--look-at {place}: {} has no heights there", named(world.surfaces.terrain.store().name()));
        };
        Ok(camera)
    }
}

/// The centre of a map by latitude and longitude.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct MapPlaceArgs {
    /// Centre of --map: latitude and longitude in WGS 84, in degrees, like 46.5370,7.9622
    #[arg(long, value_name = "LAT,LON", value_parser = LatLon::from_str, allow_hyphen_values = true, requires = "map")]
    pub at: Option<LatLon>,
    /// Width of a map --at a place, in metres [default: a quarter of the width of the land]
    #[arg(long, value_name = "METRES", value_parser = arguments::within(ranges::MAP_WIDTH_M), allow_hyphen_values = true, requires = "at")]
    pub map_width: Option<f64>,
}

impl MapPlaceArgs {
    /// Returns the area around the place, if one is given. `width_m` is that of the land.
    ///
    /// # Errors
    /// Fails if the heights have no position on the earth, or do not contain the place.
    pub(crate) fn area(
        &self,
        world: Option<&str>,
        store: &dyn TileStore,
        width_m: f64,
    ) -> anyhow::Result<Option<MapArea>> {
        let Some(place) = self.at else { return Ok(None) };
        let centre_m = place_m("--at", place, world, store)?;
        // To the millimetre, so that the imprint of a picture is short.
        let centre_m = (centre_m * 1000.0).round() / 1000.0;
        let width_m = self.map_width.unwrap_or_else(|| (0.25 * width_m).round().max(1.0));
        Ok(Some(MapArea::Around { centre_m, width_m }))
    }
}

/// Returns a place as it is given on the command line.
fn text(LatLon { latitude_deg, longitude_deg }: LatLon) -> String {
    format!("{latitude_deg},{longitude_deg}")
}

/// Returns the position of a place in the world of a store: east and north in metres.
fn place_m(option: &str, place: LatLon, world: Option<&str>, store: &dyn TileStore) -> anyhow::Result<DVec2> {
    let given = text(place);
    let georeference = store.georeference();
    let size = store.levels()[0];
    let grid = match GridOnWgs84::new(georeference, [size.width, size.height]) {
        Ok(grid) => grid,
        Err(_) if georeference.crs == Crs::Local => bail!(has_no_place(option, place, world)),
        Err(cause) => bail!("{option} {given}: {}: {cause}", named(store.name())),
    };
    if let Some(place_m) = grid.world_m(DVec2::new(place.longitude_deg, place.latitude_deg)) {
        return Ok(place_m);
    }
    let extent = grid.extent_text().map(|extent| format!(", whose {extent}"));
    bail!("{option} {given}: outside of {}{}", named(store.name()), extent.unwrap_or_default())
}

/// Returns the error for a place in degrees in a world without a reference system.
fn has_no_place(option: &str, place: LatLon, world: Option<&str>) -> String {
    let metres = if option == "--at" { "--map=EAST,NORTH,WIDTH" } else { "--camera x,y,z,yaw,pitch,fov" };
    format!("{option} {}: {}; give metres, with {metres}", text(place), no_crs(world))
}

/// Checks, before the world is opened, that no place is given in degrees in a procedural world, which has no position on
/// the earth: generating its land takes seconds.
pub(crate) fn check_procedural(
    look: &LookArgs,
    map: &MapPlaceArgs,
    world: Option<&str>,
    opened: &World,
) -> anyhow::Result<()> {
    if matches!(opened, World::Procedural { .. } | World::Continent { .. })
        && let Some((option, place)) =
            look.look_at.map(|place| ("--look-at", place)).or(map.at.map(|place| ("--at", place)))
    {
        bail!(has_no_place(option, place, world));
    }
    Ok(())
}

/// Extensions of heights whose reference system a sidecar file may give.
const DESCRIBED_ENDINGS: [&str; 5] = ["png", "webp", "exr", "r16", "raw"];

/// Returns the cause that a world has no reference system, and what to do.
pub(crate) fn no_crs(world: Option<&str>) -> String {
    let Some(world) = world.map(Path::new) else {
        return "the built-in world has no reference system".to_owned();
    };
    let ending = world.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let world = named(world);
    match DESCRIBED_ENDINGS.contains(&&*ending) {
        true => format!("{world} has no reference system; set crs and origin in {world}.toml"),
        false => format!("{world} has no reference system"),
    }
}
