//! Converts between coordinates of a reference system and longitudes and latitudes in WGS 84.

use glam::DVec2;
use proj4rs::Proj;
use proj4rs::transform::transform;

use super::WorldMapping;
use super::datum::{DatumShift, datum_shift};
use super::earth_projection;
use super::georeference::{Crs, Georeference};

/// Number of intervals along each side of a grid at which its longitudes and latitudes are computed.
const SIDE_STEPS: u32 = 16;

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

    /// Returns the coordinates at a longitude and latitude in degrees, the inverse of [`Self::degrees`]; NaN where the
    /// projection has none.
    pub(crate) fn coordinates(&self, degrees: DVec2) -> DVec2 {
        let place = DVec2::new(degrees.x.to_radians(), degrees.y.to_radians());
        let Some((from, to)) = &self.from else { return place / self.per_unit };
        let mut point = (place.x, place.y, 0.0);
        match transform(to, from, &mut point) {
            Ok(()) => DVec2::new(point.0, point.1) / self.per_unit,
            Err(_) => DVec2::NAN,
        }
    }
}

/// A grid on the earth: its places by latitude and longitude in WGS 84.
pub(crate) struct GridOnWgs84 {
    mapping: WorldMapping,
    to_wgs84: ToWgs84,
    size: [u32; 2],
}

impl GridOnWgs84 {
    /// Relates a grid of `size` samples to WGS 84.
    ///
    /// # Errors
    /// Fails for a grid without reference system, and for an unknown projection; the message is one line.
    pub(crate) fn new(place: &Georeference, size: [u32; 2]) -> Result<Self, String> {
        let to_wgs84 = ToWgs84::new(place)?;
        let mapping = WorldMapping::new(place, size[0], size[1]).map_err(|error| error.to_string())?;
        Ok(Self { mapping, to_wgs84, size })
    }

    /// Returns the position in the world, in metres, of a longitude and latitude in degrees. `None` outside of the grid.
    pub(crate) fn world_m(&self, degrees: DVec2) -> Option<DVec2> {
        let world_m = self.mapping.world_from_crs(self.to_wgs84.coordinates(degrees));
        let grid = self.mapping.grid_from_world(world_m);
        let last = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1])) - 1.0;
        (grid.is_finite() && grid.cmpge(DVec2::splat(-0.5)).all() && grid.cmple(last + 0.5).all()).then_some(world_m)
    }

    /// Returns longitude and latitude in degrees at a position in the world, in metres; `None` where there is none.
    pub(crate) fn degrees(&self, world_m: DVec2) -> Option<DVec2> {
        let degrees = self.to_wgs84.degrees(self.mapping.crs_from_world(world_m));
        degrees.is_finite().then(|| DVec2::new(wrapped(degrees.x), degrees.y))
    }

    /// Returns the latitudes and longitudes of the grid for messages, if its sides have any.
    pub(crate) fn extent_text(&self) -> Option<String> {
        let [west, south, east, north] = self.bounds_deg()?;
        Some(format!("latitudes are {south:.4} to {north:.4} and longitudes {west:.4} to {east:.4}"))
    }

    /// Returns west, south, east and north of the grid in degrees; west is larger than east across the antimeridian.
    /// `None` if a place on its sides has no longitude.
    pub(crate) fn bounds_deg(&self) -> Option<[f64; 4]> {
        let last = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1])) - 1.0;
        let place = |grid: DVec2| {
            self.to_wgs84.degrees(self.mapping.crs_from_world(self.mapping.world_from_grid(grid.x, grid.y)))
        };
        let middle = place(0.5 * last);
        let sides = (0..=SIDE_STEPS).flat_map(|step| {
            let part = f64::from(step) / f64::from(SIDE_STEPS);
            [[part, 0.0], [part, 1.0], [0.0, part], [1.0, part]].map(|at| DVec2::from_array(at) * last)
        });
        let (mut low, mut high) = (middle, middle);
        for grid in sides {
            let mut at = place(grid);
            // A side of a globe is half a turn from its middle: rounding must not take it to the other side.
            let beyond = at.x - middle.x;
            at.x -= if beyond.abs() > 180.0 + 1e-6 { 360.0 * (beyond / 360.0).round() } else { 0.0 };
            (low, high) = (low.min(at), high.max(at));
        }
        if !(low.is_finite() && high.is_finite()) {
            return None;
        }
        let [west, east] = if high.x - low.x >= 360.0 { [-180.0, 180.0] } else { [wrapped(low.x), wrapped(high.x)] };
        Some([west, low.y.max(-90.0), east, high.y.min(90.0)])
    }
}

/// Returns a longitude from −180 to 180.
fn wrapped(degrees: f64) -> f64 {
    if degrees.abs() <= 180.0 { degrees } else { (degrees + 180.0).rem_euclid(360.0) - 180.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use glam::Vec2Swizzles as _;

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

    #[test]
    fn latitude_and_longitude_lead_back() {
        // Without a shift of the datum, with one, across the antimeridian, and in degrees beyond 180.
        let geographic = |west: f64| {
            let crs = Crs::Geographic {
                radians_per_unit: std::f64::consts::PI / 180.0,
                semi_major_axis_m: 6_378_137.0,
                inverse_flattening: 298.257_223_563,
                name: "EPSG:4326".to_owned(),
            };
            Georeference { crs_from_grid: [west, 0.01, 0.0, 47.0, 0.0, -0.01], crs, geokeys: GeoKeys::default() }
        };
        let metres = |name: &str, corner: [f64; 2]| Georeference {
            crs_from_grid: [corner[0], 100.0, 0.0, corner[1], 0.0, -100.0],
            ..projected(name, 1.0)
        };
        for georeference in [
            metres("EPSG:32632", [640_000.0, 5_160_000.0]),
            metres("EPSG:21781", [600_000.0, 200_000.0]),
            metres("EPSG:3857", [-20_040_000.0, 5_600_000.0]),
            geographic(8.0),
            geographic(179.5),
        ] {
            let grid = GridOnWgs84::new(&georeference, [101, 101]).unwrap();
            let mut off_m = 0.0_f64;
            for at in [[0.0, 0.0], [10.0, 77.0], [100.0, 100.0], [50.0, 50.0]] {
                let world_m = grid.mapping.world_from_grid(at[0], at[1]);
                let degrees = grid.degrees(world_m).unwrap();
                assert!(degrees.x.abs() <= 180.0, "{degrees}");
                off_m = off_m.max(grid.world_m(degrees).unwrap().distance(world_m));
                // Planted: latitude and longitude exchanged.
                assert_eq!(grid.world_m(degrees.yx()), None);
            }
            assert!(off_m < 0.01, "{georeference:?}: {off_m} m");
            assert_eq!(grid.world_m(DVec2::new(100.0, 10.0)), None);
            let [west, south, east, north] = grid.bounds_deg().unwrap();
            let middle = grid.degrees(DVec2::ZERO).unwrap();
            assert!((south..north).contains(&middle.y), "{middle}");
            assert!(if west < east { (west..east).contains(&middle.x) } else { middle.x > west || middle.x < east });
        }
    }
}
