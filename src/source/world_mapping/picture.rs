//! The georeference of a picture of the world from straight above, north up, as world files, GeoTIFF tags and a `.prj`
//! state it.
//!
//! A picture of a projected grid has the file's own CRS. A picture of a geographic grid has the projection in which the
//! world has its metres, a transverse Mercator that is written with its parameters; if the world is too wide for that,
//! the picture has the file's longitudes and latitudes.

use glam::DVec2;

use super::super::geokeys::{self as key, GeoKey, GeoKeys, USER_DEFINED};
use super::super::georeference::{Crs, Georeference};
use super::{Projection, WorldMapping};

/// GeoKeys of a geographic CRS.
const GEOGRAPHIC_KEYS: std::ops::RangeInclusive<u16> = 2048..=2061;
/// GeoKeys of a vertical CRS, which a picture does not have.
const VERTICAL_KEYS: std::ops::RangeInclusive<u16> = 4096..=4099;
/// GeoTIFF code of the transverse Mercator projection, and the GeoKeys of its parameters.
const TRANSVERSE_MERCATOR: u16 = 1;
const ORIGIN_LONGITUDE: u16 = 3080;
const ORIGIN_LATITUDE: u16 = 3081;
const FALSE_EASTING: u16 = 3082;
const FALSE_NORTHING: u16 = 3083;
const SCALE: u16 = 3092;

impl WorldMapping {
    /// Returns the georeference of a picture whose first pixel has its centre at `first_m` and whose pixels have sides
    /// of `pixel_m`, both in world metres; `world` is the georeference that this mapping was built from.
    #[must_use]
    pub(crate) fn picture_georeference(&self, world: &Georeference, first_m: DVec2, pixel_m: f64) -> Georeference {
        let north_up = |first: DVec2, step: DVec2| [first.x, step.x, 0.0, first.y, 0.0, -step.y];
        let plain = |first: DVec2, step: DVec2| {
            let mut keys = world.geokeys.keys.clone();
            keys.retain(|key| !VERTICAL_KEYS.contains(&key.id) && key.id != key::RASTER_TYPE);
            let geokeys = GeoKeys::from_keys(keys);
            Georeference { crs_from_grid: north_up(first, step), crs: world.crs.clone(), geokeys }
        };
        match &self.projection {
            Projection::Scaled { metres_per_unit } => {
                plain(self.crs_from_world(first_m), DVec2::splat(pixel_m / metres_per_unit))
            }
            Projection::EquidistantCylindrical { .. } => {
                let step = self.offset_from_world(DVec2::splat(pixel_m));
                plain(self.crs_from_world(first_m), step)
            }
            Projection::TransverseMercator { radians_per_unit, .. } => {
                let geokeys = GeoKeys::from_keys(self.transverse_mercator_keys(world, *radians_per_unit));
                let crs = Crs::Projected { metres_per_unit: 1.0, name: self.describe() };
                Georeference { crs_from_grid: north_up(first_m, DVec2::splat(pixel_m)), crs, geokeys }
            }
        }
    }

    /// Returns the GeoKeys of the world's projection: on the file's own geographic CRS, centred on the world's origin.
    fn transverse_mercator_keys(&self, world: &Georeference, radians_per_unit: f64) -> Vec<GeoKey> {
        let turn = std::f64::consts::TAU / radians_per_unit;
        let longitude = (self.centre_crs.x + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
        let citation = format!("hachure: {}", self.describe());
        let mut keys = vec![GeoKey::short(key::MODEL_TYPE, 1), GeoKey::ascii(key::CITATION, &citation)];
        let own = world.geokeys.keys.iter().filter(|key| GEOGRAPHIC_KEYS.contains(&key.id));
        keys.extend(own.cloned());
        if !keys.iter().any(|key| key.id == key::GEOGRAPHIC_CRS) {
            keys.extend(named_geographic_keys(&world.crs));
        }
        keys.extend([
            GeoKey::short(key::PROJECTED_CRS, USER_DEFINED),
            GeoKey::short(key::PROJECTION, USER_DEFINED),
            GeoKey::short(key::PROJECTION_METHOD, TRANSVERSE_MERCATOR),
            GeoKey::short(key::LINEAR_UNITS, key::METRE),
            GeoKey::double(ORIGIN_LONGITUDE, longitude),
            GeoKey::double(ORIGIN_LATITUDE, self.centre_crs.y),
            GeoKey::double(FALSE_EASTING, 0.0),
            GeoKey::double(FALSE_NORTHING, 0.0),
            GeoKey::double(SCALE, 1.0),
        ]);
        keys
    }
}

/// Returns the GeoKeys of a geographic CRS for files that have none.
fn named_geographic_keys(crs: &Crs) -> Vec<GeoKey> {
    let Crs::Geographic { semi_major_axis_m, inverse_flattening, name, .. } = crs else { return Vec::new() };
    match name.strip_prefix("EPSG:").and_then(|code| code.parse().ok()) {
        Some(code) => vec![GeoKey::short(key::GEOGRAPHIC_CRS, code)],
        None => vec![
            GeoKey::short(key::GEOGRAPHIC_CRS, USER_DEFINED),
            GeoKey::ascii(key::GEOGRAPHIC_CITATION, name),
            GeoKey::short(key::GEOGRAPHIC_DATUM, USER_DEFINED),
            GeoKey::short(key::ANGULAR_UNITS, key::DEGREE),
            GeoKey::short(key::ELLIPSOID, USER_DEFINED),
            GeoKey::double(key::SEMI_MAJOR_AXIS, *semi_major_axis_m),
            GeoKey::double(key::INVERSE_FLATTENING, *inverse_flattening),
        ],
    }
}
