//! Converts coordinates of a reference system to longitudes and latitudes in WGS 84.

use glam::DVec2;
use proj4rs::Proj;
use proj4rs::transform::transform;

use super::datum::{DatumShift, datum_shift};
use super::earth_projection;
use super::georeference::{Crs, Georeference};

/// The conversion from a reference system to WGS 84.
pub(crate) struct ToWgs84 {
    /// `None` if coordinates are already in WGS 84.
    from: Option<(Proj, Proj)>,
    /// Metres or radians in a unit of the coordinates.
    per_unit: f64,
    shift: DatumShift,
}

impl ToWgs84 {
    /// Builds the conversion. A datum that is not related to WGS 84 counts as WGS 84; see [`Self::has_unknown_datum`].
    ///
    /// # Errors
    /// Fails for a world without reference system, and for an unknown projection; the message is one line.
    pub(crate) fn new(place: &Georeference) -> Result<Self, String> {
        let (text, per_unit) = match &place.crs {
            Crs::Local => return Err("the world is not georeferenced".to_owned()),
            Crs::Geographic { radians_per_unit, .. } if place.epsg() == Some(4326) => {
                return Ok(Self { from: None, per_unit: *radians_per_unit, shift: DatumShift::None });
            }
            _ => earth_projection::text(place)?,
        };
        let set_up = |text: &str| {
            Proj::from_proj_string(text).map_err(|error| format!("its reference system cannot be set up: {error}"))
        };
        let from = Some((set_up(&text)?, set_up("+proj=longlat +datum=WGS84 +no_defs")?));
        Ok(Self { from, per_unit, shift: datum_shift(&text) })
    }

    /// Returns whether coordinates are converted without the shift of their datum, because it is unknown.
    pub(crate) fn has_unknown_datum(&self) -> bool {
        self.shift == DatumShift::Unknown
    }

    /// Returns longitude and latitude in degrees; NaN where the projection has no inverse.
    pub(crate) fn degrees(&self, crs: DVec2) -> DVec2 {
        let place = crs * self.per_unit;
        let Some((from, to)) = &self.from else { return DVec2::new(place.x.to_degrees(), place.y.to_degrees()) };
        let mut point = (place.x, place.y, 0.0);
        match transform(from, to, &mut point) {
            Ok(()) => DVec2::new(point.0.to_degrees(), point.1.to_degrees()),
            Err(_) => DVec2::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::source::GeoKeys;

    fn projected(name: &str, metres_per_unit: f64) -> Georeference {
        let crs = Crs::Projected { metres_per_unit, name: name.to_owned() };
        Georeference { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0], crs, geokeys: GeoKeys::default() }
    }

    /// Compares with coordinates that PROJ gives.
    #[test]
    fn coordinates_become_longitudes_and_latitudes() {
        let off = |name: &str, crs: [f64; 2], wanted: [f64; 2]| {
            let to = ToWgs84::new(&projected(name, 1.0)).unwrap();
            (to.degrees(crs.into()) - DVec2::from(wanted)).abs().max_element()
        };
        // 9° E on the central meridian of zone 32, and the metre of the pseudo Mercator projection.
        assert!(off("EPSG:32632", [500_000.0, 0.0], [9.0, 0.0]) < 1e-9);
        assert!(off("EPSG:3857", [20_037_508.342_789, 0.0], [180.0, 0.0]) < 1e-9);
        assert!(off("EPSG:3857", [1_113_194.907_933, 5_621_521.486_192], [10.0, 45.0]) < 1e-7);
        // The fundamental point of the Swiss grid is in Bern; its datum is 200 m from WGS 84.
        let bern = off("EPSG:21781", [600_000.0, 200_000.0], [7.438_632_5, 46.951_082_9]);
        assert!(bern < 2e-5, "{bern}");
        let unshifted = off("EPSG:21781", [600_000.0, 200_000.0], [7.439_583, 46.952_406]);
        assert!(unshifted > 5e-4, "planted error, no shift of the datum: {unshifted}");
        // Lambert's zone II from Paris, and NAD27, whose usual definition names grids of corrections; its expected value
        // was computed by Krüger's series and the three translations.
        assert!(off("EPSG:27572", [600_000.0, 2_200_000.0], [2.336_5, 46.799_94]) < 2e-4);
        let nad27 = off("EPSG:26710", [600_000.0, 5_188_000.0], [-121.689_787_24, 46.839_807_67]);
        assert!(nad27 < 1e-7, "{nad27}");
        assert!(ToWgs84::new(&projected("a plan", 1.0)).err().unwrap().contains("a plan"));
    }
}
