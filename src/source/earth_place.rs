//! The position of a world's origin on the earth, and the angle between its grid north and true north.

use glam::DVec2;

use super::WorldMapping;
use super::georeference::Georeference;

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

impl EarthPlace {
    /// Returns the position of the centre of a grid. Returns `None` for a grid without georeference, or in a projection
    /// that is not known or that cannot be inverted. Datums other than WGS 84 are treated as WGS 84, which is an error
    /// of a few hundred metres.
    pub fn of_grid(georeference: &Georeference, width: u32, height: u32) -> Option<Self> {
        let mapping = WorldMapping::new(georeference, width, height).ok()?;
        let place = mapping.longitude_latitude_rad(DVec2::ZERO)?;
        let grid_north_deg = -mapping.true_north_rad(DVec2::ZERO)?.to_degrees();
        Some(Self { latitude_deg: place.y.to_degrees(), longitude_deg: place.x.to_degrees(), grid_north_deg })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::source::GeoKeys;
    use crate::source::georeference::Crs;

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
