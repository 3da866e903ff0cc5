//! Coordinates of places: how the window shows them, and how they are typed.
//!
//! Three forms name a place, and none can be taken for another: `46.5370,7.9622` is a latitude and a longitude, as on the
//! command line; `E594123,N5189456` are coordinates of the world's reference system; `x1200,y-300` are metres east and
//! north of the centre of the world, as in `--camera`. Six numbers are a whole camera.

use std::str::FromStr;

use glam::{DVec2, DVec3};

use crate::file::message::{named, shown};
use crate::scene::camera::Camera;
use crate::scene::sun_time::LatLon;
use crate::source::WorldMapping;
use crate::source::georeference::Crs;
use crate::source::lon_lat::GridOnWgs84;
use crate::tiles::Terrain;

/// The forms of a place, for hints and messages.
pub(super) const FORMS: &str = "a latitude and longitude like 46.5370,7.9622, projected coordinates like \
     E594123,N5189456, metres from the centre of the world like x1200,y-300, or a camera x,y,z,yaw,pitch,fov";

/// A place or a camera, as it is typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TypedPlace {
    /// Latitude and longitude.
    Earth(LatLon),
    /// Easting and northing of the world's reference system, in its units.
    Projected(DVec2),
    /// Metres east and north of the centre of the world.
    World(DVec2),
    /// A whole camera.
    Camera(Camera),
}

impl FromStr for TypedPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Groups of digits may be separated, as the window shows them.
        let compact: String = text.chars().filter(|sign| !sign.is_whitespace()).collect();
        let compact = compact.replace('\u{2212}', "-").replace('°', "");
        if compact.split(',').count() == 6 {
            return compact
                .parse()
                .map(Self::Camera)
                .map_err(|error: crate::scene::camera::CameraError| error.to_string());
        }
        let pair = |first: char, second: char| {
            let lower = compact.to_lowercase();
            let (a, b) = lower.split_once(',')?;
            let number = |text: &str, letter: char| {
                let (number, _) = without_unit(text.strip_prefix(letter)?);
                number.parse().ok().filter(|it: &f64| it.is_finite())
            };
            Some(DVec2::new(number(a, first)?, number(b, second)?))
        };
        if let Some(projected) = pair('e', 'n') {
            return Ok(Self::Projected(projected));
        }
        if let Some(world_m) = pair('x', 'y') {
            return Ok(Self::World(world_m));
        }
        let earth = compact.parse().map(Self::Earth);
        earth.map_err(|_| format!("{}: it must be {FORMS}", shown(text.trim())))
    }
}

/// Units of projected coordinates, in metres. Units of other reference systems have no name here.
const UNITS: [(&str, f64); 3] = [("m", 1.0), ("ft", 0.3048), ("US ft", 1200.0 / 3937.0)];

/// Splits a number, which may have no spaces, from the unit behind it, if it has one.
fn without_unit(text: &str) -> (&str, Option<&'static str>) {
    for (written, unit) in [("usft", "US ft"), ("ft", "ft"), ("m", "m")] {
        if let Some(number) = text.strip_suffix(written) {
            return (number, Some(unit));
        }
    }
    (text, None)
}

/// Returns the unit at the end of typed coordinates, if they have one.
fn typed_unit(text: &str) -> Option<&'static str> {
    let compact: String = text.to_lowercase().chars().filter(|sign| !sign.is_whitespace()).collect();
    without_unit(&compact).1
}

/// The reference systems of a world.
pub(super) struct Places {
    mapping: WorldMapping,
    /// Conversion to WGS 84, or why there is none.
    earth: Result<GridOnWgs84, String>,
    /// Name of the projected reference system, if the world has one.
    projected: Option<String>,
    /// Unit of the projected coordinates; empty if it has no name.
    unit: &'static str,
    corners_m: [DVec2; 2],
    name: String,
}

impl Places {
    /// Returns the reference systems of the world of a terrain.
    pub(super) fn of(terrain: &Terrain) -> Self {
        let store = terrain.store();
        let georeference = store.georeference();
        let size = store.levels()[0];
        let earth = match &georeference.crs {
            Crs::Local => {
                Err(format!("{} has no reference system; give metres, such as x1200,y-300", named(store.name())))
            }
            _ => GridOnWgs84::new(georeference, [size.width, size.height]),
        };
        let projected = match &georeference.crs {
            Crs::Projected { name, .. } => Some(name.clone()),
            Crs::Local | Crs::Geographic { .. } => None,
        };
        let unit = match &georeference.crs {
            Crs::Projected { metres_per_unit, .. } => unit_of(*metres_per_unit),
            Crs::Local | Crs::Geographic { .. } => "m",
        };
        let (mapping, corners_m) = (terrain.mapping().clone(), terrain.corners_m());
        Self { mapping, earth, projected, unit, corners_m, name: store.name() }
    }

    /// Returns the coordinates of a place, as [`TypedPlace`] reads them: latitude and longitude, and those of the
    /// reference system or of the world.
    pub(super) fn texts(&self, world_m: DVec2) -> Vec<String> {
        let degrees = self.earth.as_ref().ok().and_then(|grid| grid.degrees(world_m));
        // A hundred-thousandth of a degree is about a metre.
        let earth = degrees.map(|at| format!("{:.5}°, {:.5}°", at.y, at.x));
        let plane = match &self.projected {
            Some(_) => {
                let at = self.mapping.crs_from_world(world_m);
                let space = if self.unit.is_empty() { "" } else { " " };
                format!("E {:.0}{space}{unit}, N {:.0}{space}{unit}", at.x, at.y, unit = self.unit)
            }
            None => format!("x {:.0} m, y {:.0} m", world_m.x, world_m.y),
        };
        earth.into_iter().chain([plane]).collect()
    }

    /// Returns the name of the projected reference system, if the world has one.
    pub(super) fn projection(&self) -> Option<&str> {
        self.projected.as_deref()
    }

    /// Returns the position of a place in the world, east and north in metres; `text` is what was typed.
    ///
    /// # Errors
    /// The place is outside of the world, or the world has no such coordinates. The message is one line.
    pub(super) fn world_m(&self, typed: &TypedPlace, text: &str) -> Result<DVec2, String> {
        let text = shown(text.trim());
        match typed {
            TypedPlace::Earth(LatLon { latitude_deg, longitude_deg }) => {
                let grid = self.earth.as_ref().map_err(|cause| format!("{text}: {cause}"))?;
                grid.world_m(DVec2::new(*longitude_deg, *latitude_deg)).ok_or_else(|| {
                    let extent = grid.extent_text().map(|extent| format!(", whose {extent}")).unwrap_or_default();
                    format!("{text}: outside of {}{extent}", named(&self.name))
                })
            }
            TypedPlace::Projected(_) if self.projected.is_none() => {
                Err(format!("{text}: the world has no projected coordinates"))
            }
            TypedPlace::Projected(_) | TypedPlace::World(_) if let Some(unit) = self.wrong_unit(typed, &text) => {
                Err(format!("{text}: these coordinates are not in {unit}; leave the unit out"))
            }
            TypedPlace::Projected(crs) => self.inside(self.mapping.world_from_crs(*crs), &text),
            TypedPlace::World(world_m) => self.inside(*world_m, &text),
            TypedPlace::Camera(camera) => Ok(camera.position_m.truncate()),
        }
    }

    /// Returns the unit that was typed, if it is not that of the coordinates.
    fn wrong_unit(&self, typed: &TypedPlace, text: &str) -> Option<&'static str> {
        let unit = if matches!(typed, TypedPlace::World(_)) { "m" } else { self.unit };
        typed_unit(text).filter(|typed| *typed != unit)
    }

    fn inside(&self, world_m: DVec2, text: &str) -> Result<DVec2, String> {
        let [low_m, high_m] = self.corners_m;
        if world_m.cmpge(low_m).all() && world_m.cmple(high_m).all() {
            return Ok(world_m);
        }
        let corners = match self.projected {
            Some(_) => [low_m, high_m].map(|corner| self.mapping.crs_from_world(corner)),
            None => self.corners_m,
        };
        let [west, south, east, north] = [corners[0].x, corners[0].y, corners[1].x, corners[1].y];
        let axes = if self.projected.is_some() { ["E", "N"] } else { ["x", "y"] };
        Err(format!(
            "{text}: outside of {}, which reaches from {} {west:.0} to {east:.0} and from {} {south:.0} to {north:.0}",
            named(&self.name),
            axes[0],
            axes[1]
        ))
    }
}

/// Returns the name of a unit of projected coordinates; an empty text if it has none.
fn unit_of(metres_per_unit: f64) -> &'static str {
    // A US survey foot differs from a foot by two millionths.
    let is_unit = |(_, metres): &&(&str, f64)| (metres_per_unit / metres - 1.0).abs() < 1e-7;
    UNITS.iter().find(is_unit).map_or("", |(unit, _)| unit)
}

/// Formats a distance: metres below 1 km, otherwise kilometres.
pub(super) fn distance_text(distance_m: f64) -> String {
    if distance_m < 1000.0 { format!("{distance_m:.0} m") } else { format!("{:.1} km", distance_m / 1000.0) }
}

/// Returns the corners of a box around the land: its corners on the map, between the lowest and the highest height.
pub(super) fn box_m([low_m, high_m]: [DVec2; 2], heights_m: [f64; 2]) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let side = |bit: usize, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
        DVec3::new(side(0, low_m.x, high_m.x), side(1, low_m.y, high_m.y), side(2, heights_m[0], heights_m[1]))
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn no_form_is_taken_for_another() {
        let earth = TypedPlace::Earth(LatLon { latitude_deg: 46.537, longitude_deg: 7.9622 });
        for text in ["46.5370,7.9622", " 46.537, 7.9622 ", "46.537°, 7.9622°"] {
            assert_eq!(text.parse(), Ok(earth), "{text}");
        }
        let south = TypedPlace::Earth(LatLon { latitude_deg: -3.5, longitude_deg: -70.25 });
        assert_eq!("\u{2212}3.5,\u{2212}70.25".parse(), Ok(south));
        let projected = TypedPlace::Projected(DVec2::new(594_123.0, 5_189_456.5));
        for text in ["E594123,N5189456.5", "e 594 123, n 5 189 456.5"] {
            assert_eq!(text.parse(), Ok(projected), "{text}");
        }
        // Small projected coordinates are no degrees, and metres of the world are neither.
        assert_eq!("E46,N7".parse(), Ok(TypedPlace::Projected(DVec2::new(46.0, 7.0))));
        assert_eq!("x46,y-7".parse(), Ok(TypedPlace::World(DVec2::new(46.0, -7.0))));
        assert!(matches!("1,2,+300,0,-10,50".parse(), Ok(TypedPlace::Camera(_))));
        // Planted errors: projected coordinates without letters, letters the wrong way round, and others.
        for wrong in ["594123,5189456", "N5189456,E594123", "E594123,5189456", "x1,N2", "", "46.5", "1,2,3", "Enan,N1"]
        {
            let error = wrong.parse::<TypedPlace>().unwrap_err();
            assert!(error.contains("46.5370,7.9622") && !error.contains('\n'), "{wrong}: {error}");
        }
        assert!("1,2,x,0,-10,50".parse::<TypedPlace>().unwrap_err().contains("camera"));
    }

    #[test]
    fn units_are_shown_and_read_again() {
        for (metres, unit) in [(1.0, "m"), (0.3048, "ft"), (0.304_800_609_6, "US ft"), (0.9, "")] {
            assert_eq!(unit_of(metres), unit, "{metres}");
        }
        for text in ["E 594123 m, N 5189456 m", "E594123ft,N5189456ft", "e 594123 US ft, n 5189456 US ft"] {
            assert_eq!(text.parse(), Ok(TypedPlace::Projected(DVec2::new(594_123.0, 5_189_456.0))), "{text}");
        }
        assert_eq!("x 46 m, y -7 m".parse(), Ok(TypedPlace::World(DVec2::new(46.0, -7.0))));
        assert_eq!(
            [typed_unit("E 1 US ft, N 2 US ft"), typed_unit("E1,N2m"), typed_unit("E1,N2")],
            [Some("US ft"), Some("m"), None]
        );
        // Planted: other units are refused, not ignored.
        for wrong in ["E594km,N5189km", "x46 cm,y7 cm"] {
            assert!(wrong.parse::<TypedPlace>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_box_has_eight_corners() {
        let corners = box_m([DVec2::new(-1.0, -2.0), DVec2::new(3.0, 4.0)], [5.0, 6.0]);
        let distinct: std::collections::BTreeSet<_> =
            corners.iter().map(|at| at.to_array().map(f64::to_bits)).collect();
        assert_eq!(distinct.len(), 8);
        assert!(corners.contains(&DVec3::new(3.0, -2.0, 6.0)));
    }
}
