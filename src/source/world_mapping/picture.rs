//! The georeference of a picture of the world from straight above, north up, as world files, GeoTIFF tags and a `.prj`
//! state it.
//!
//! A picture of a grid in ground metres has the file's own CRS. Pictures of other grids have the projection in which the
//! world has its metres, a transverse Mercator that is written with its parameters, or, if the world is too wide for
//! that, the file's own coordinates.

use glam::DVec2;

use super::super::crs_catalogue as catalogue;
use super::super::datum::GeographicBase;
use super::super::geokeys::{self as key, GeoKey, GeoKeys, USER_DEFINED};
use super::super::georeference::{Crs, Georeference};
use super::super::wkt;
use super::{Earth, Plane, WorldMapping};

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
        match &self.plane {
            Plane::Scaled { metres_per_unit } => {
                plain(self.crs_from_world(first_m), DVec2::splat(pixel_m / metres_per_unit))
            }
            Plane::EquidistantCylindrical { .. } => {
                let step = self.offset_from_world(DVec2::splat(pixel_m));
                plain(self.crs_from_world(first_m), step)
            }
            Plane::Fitted { world_from_offset } => {
                let first = self.crs_from_world(first_m);
                let [x, y] = [world_from_offset.inverse() * DVec2::X, world_from_offset.inverse() * -DVec2::Y];
                let [x, y] = [x, y].map(|step| step * pixel_m);
                let crs_from_grid = [first.x, x.x, y.x, first.y, x.y, y.y];
                Georeference { crs_from_grid, ..plain(first, DVec2::ONE) }
            }
            Plane::TransverseMercator { world_from_projected, .. } => {
                let geokeys = GeoKeys::from_keys(self.transverse_mercator_keys(world));
                let crs = Crs::Projected { metres_per_unit: 1.0, name: self.describe() };
                let projected = world_from_projected.transpose();
                let [first, x, y] = [first_m, DVec2::X * pixel_m, -DVec2::Y * pixel_m].map(|at| projected * at);
                Georeference { crs_from_grid: [first.x, x.x, y.x, first.y, x.y, y.y], crs, geokeys }
            }
        }
    }

    /// Returns the GeoKeys of the world's projection: on the file's own geographic CRS, centred on the world's origin.
    fn transverse_mercator_keys(&self, world: &Georeference) -> Vec<GeoKey> {
        let citation = format!("hachure: {}", self.describe());
        let mut keys = vec![GeoKey::short(key::MODEL_TYPE, 1), GeoKey::ascii(key::CITATION, &citation)];
        let own = world.geokeys.keys.iter().filter(|key| GEOGRAPHIC_KEYS.contains(&key.id));
        keys.extend(own.cloned());
        if !keys.iter().any(|key| key.id == key::GEOGRAPHIC_CRS) {
            keys.extend(self.geographic_keys(&world.crs));
        }
        // The origin has the unit and the prime meridian of the geographic CRS.
        let ellipsoid = self.earth.as_ref().map(Earth::ellipsoid).unwrap_or_default();
        let base = GeographicBase::of(&GeoKeys::from_keys(keys.clone()), ellipsoid);
        let (degrees_per_unit, prime_meridian_deg) =
            base.map_or((1.0, 0.0), |base| (base.degrees_per_unit, base.prime_meridian_deg));
        let origin_rad = self.longitude_latitude_rad(DVec2::ZERO).unwrap_or(DVec2::NAN);
        let origin = (origin_rad - DVec2::new(prime_meridian_deg.to_radians(), 0.0)) / degrees_per_unit.to_radians();
        keys.extend([
            GeoKey::short(key::PROJECTED_CRS, USER_DEFINED),
            GeoKey::short(key::PROJECTION, USER_DEFINED),
            GeoKey::short(key::PROJECTION_METHOD, TRANSVERSE_MERCATOR),
            GeoKey::short(key::LINEAR_UNITS, key::METRE),
            GeoKey::double(ORIGIN_LONGITUDE, origin.x),
            GeoKey::double(ORIGIN_LATITUDE, origin.y),
            GeoKey::double(FALSE_EASTING, 0.0),
            GeoKey::double(FALSE_NORTHING, 0.0),
            GeoKey::double(SCALE, 1.0),
        ]);
        keys
    }

    /// Returns the GeoKeys of the geographic CRS for files that have none.
    fn geographic_keys(&self, crs: &Crs) -> Vec<GeoKey> {
        let (Crs::Geographic { name, .. } | Crs::Projected { name, .. }) = crs else { return Vec::new() };
        let code = name.strip_prefix("EPSG:").and_then(|code| code.parse().ok());
        let ellipsoid = self.earth.as_ref().map(Earth::ellipsoid);
        match (crs, code) {
            (Crs::Geographic { .. }, Some(code)) => vec![GeoKey::short(key::GEOGRAPHIC_CRS, code)],
            (Crs::Projected { .. }, Some(code)) => {
                catalogue::text(code).and_then(wkt::base_geographic_keys).unwrap_or_default()
            }
            _ => {
                let [semi_major_axis_m, inverse_flattening] = ellipsoid.unwrap_or_default();
                vec![
                    GeoKey::short(key::GEOGRAPHIC_CRS, USER_DEFINED),
                    GeoKey::ascii(key::GEOGRAPHIC_CITATION, name),
                    GeoKey::short(key::GEOGRAPHIC_DATUM, USER_DEFINED),
                    GeoKey::short(key::ANGULAR_UNITS, key::DEGREE),
                    GeoKey::short(key::ELLIPSOID, USER_DEFINED),
                    GeoKey::double(key::SEMI_MAJOR_AXIS, semi_major_axis_m),
                    GeoKey::double(key::INVERSE_FLATTENING, inverse_flattening),
                ]
            }
        }
    }
}
