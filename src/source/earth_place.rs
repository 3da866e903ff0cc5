//! The position of a world's origin on the earth, and the angle between its grid north and true north.

use glam::DVec2;
use proj4rs::Proj;
use proj4rs::transform::transform;

use super::WorldMapping;
use super::georeference::{Crs, Georeference};

/// A position on the earth, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthPlace {
    /// Latitude, positive north of the equator.
    pub latitude_deg: f64,
    /// Longitude, positive east of Greenwich, −180 to 180.
    pub longitude_deg: f64,
    /// Azimuth of the world's north (grid north), clockwise from true north: the convergence of the meridians.
    pub grid_north_deg: f64,
}

/// Distance in metres over which grid north is measured.
const STEP_M: f64 = 100.0;

impl EarthPlace {
    /// Returns the position of the centre of a grid. Returns `None` for a grid without georeference, or in a projection
    /// that the catalogue does not know or that cannot be inverted. Datums other than WGS 84 are treated as WGS 84,
    /// which is an error of a few hundred metres.
    pub fn of_grid(georeference: &Georeference, width: u32, height: u32) -> Option<Self> {
        let origin = WorldMapping::new(georeference, width, height).ok()?.origin_crs();
        match &georeference.crs {
            Crs::Local => None,
            // The central meridian of the world passes through its centre, where grid north is true north.
            Crs::Geographic { radians_per_unit, .. } => Self::checked(origin * radians_per_unit.to_degrees(), 0.0),
            Crs::Projected { metres_per_unit, name } => {
                let code = name.strip_prefix("EPSG:")?.parse().ok()?;
                let projected = Proj::from_proj_string(crs_definitions::from_code(code)?.proj4).ok()?;
                let geographic = Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").ok()?;
                let degrees = |place: DVec2| {
                    let mut point = (place.x, place.y, 0.0);
                    transform(&projected, &geographic, &mut point).ok()?;
                    Some(DVec2::new(point.0.to_degrees(), point.1.to_degrees()))
                };
                let here = degrees(origin)?;
                let way = degrees(origin + DVec2::new(0.0, STEP_M / metres_per_unit))? - here;
                let north_deg = (way.x * here.y.to_radians().cos()).atan2(way.y).to_degrees();
                Self::checked(here, north_deg)
            }
        }
    }

    fn checked(longitude_latitude_deg: DVec2, grid_north_deg: f64) -> Option<Self> {
        let DVec2 { x, y } = longitude_latitude_deg;
        let is_there = x.is_finite() && y.abs() <= 90.0 && grid_north_deg.is_finite();
        let longitude_deg = (x + 180.0).rem_euclid(360.0) - 180.0;
        is_there.then_some(Self { latitude_deg: y, longitude_deg, grid_north_deg })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::source::GeoKeys;

    fn place(code: u16, origin: [f64; 2]) -> Option<EarthPlace> {
        let crs = Crs::Projected { metres_per_unit: 1.0, name: format!("EPSG:{code}") };
        let crs_from_grid = [origin[0] - 10.0, 10.0, 0.0, origin[1] + 10.0, 0.0, -10.0];
        EarthPlace::of_grid(&Georeference { crs_from_grid, crs, geokeys: GeoKeys::default() }, 3, 3)
    }

    #[test]
    fn a_projected_grid_knows_its_place_and_its_north() {
        // On the central meridian of zone 32, 9° east, grid north is true north. An easting of 500 km is on it by
        // definition.
        let middle = place(32632, [500_000.0, 5_200_000.0]).unwrap();
        assert!((middle.longitude_deg - 9.0).abs() < 1e-9 && middle.grid_north_deg.abs() < 1e-6, "{middle:?}");
        assert!((46.9..47.0).contains(&middle.latitude_deg), "{middle:?}");
        // East of the meridian grid north is east of true north, by the difference of longitudes times the sine of the
        // latitude.
        let east = place(32632, [650_000.0, 5_200_000.0]).unwrap();
        let expected = (east.longitude_deg - 9.0) * east.latitude_deg.to_radians().sin();
        assert!(expected > 1.0 && (east.grid_north_deg - expected).abs() < 0.01, "{east:?}, {expected}");
        assert!((east.grid_north_deg + expected).abs() > 2.0, "the opposite sign is detected");
        // A position south of the equator.
        let south = place(32732, [500_000.0, 6_000_000.0]).unwrap();
        assert!((-37.0..-36.0).contains(&south.latitude_deg), "{south:?}");
        assert_eq!(place(1, [0.0, 0.0]), None);
    }

    #[test]
    fn degrees_are_a_place() {
        let degree = std::f64::consts::PI / 180.0;
        let crs = Crs::Geographic {
            radians_per_unit: degree,
            semi_major_axis_m: 6_378_137.0,
            inverse_flattening: 298.257_223_563,
            name: "EPSG:4326".into(),
        };
        let georeference =
            Georeference { crs_from_grid: [190.0, 0.1, 0.0, 46.1, 0.0, -0.1], crs, geokeys: GeoKeys::default() };
        let place = EarthPlace::of_grid(&georeference, 3, 3).unwrap();
        assert!((place.longitude_deg + 169.9).abs() < 1e-9 && (place.latitude_deg - 46.0).abs() < 1e-9, "{place:?}");
        let local = Georeference { crs: Crs::Local, ..georeference };
        assert_eq!(EarthPlace::of_grid(&local, 3, 3), None);
    }
}
