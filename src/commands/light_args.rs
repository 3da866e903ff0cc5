//! Options of all commands that draw, for light that replaces the scene's.

use std::str::FromStr;

use clap::Args;

use super::arguments;
use super::misuse::Misuse;
use crate::scene::camera::Camera;
use crate::scene::ranges;
use crate::scene::sun_time::{LatLon, Moment};
use crate::scene::{Scene, SceneFocus, Sun, SunTime};

/// How light falls.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct LightArgs {
    /// Position of the sun, in degrees: azimuth clockwise from north, elevation above the horizon [default: the
    /// scene's, or 315,40]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = Sun::from_str, allow_hyphen_values = true)]
    pub sun: Option<Sun>,
    /// Azimuth of the sun relative to the first camera, in degrees to the right of its view (negative: left), while the
    /// sun's elevation stays the same
    #[arg(
        long,
        value_name = "DEGREES",
        conflicts_with_all = ["sun", "date"],
        value_parser = degrees,
        allow_hyphen_values = true
    )]
    pub side_light: Option<f64>,
    /// Sun at this date and local time with its UTC offset, like 2026-06-21T09:30+02:00, over the location of the
    /// heights
    #[arg(long, conflicts_with = "sun", value_parser = Moment::from_str)]
    pub date: Option<Moment>,
    /// Location for --date, if the heights have none, in degrees
    #[arg(long, value_name = "LAT,LON", value_parser = LatLon::from_str, allow_hyphen_values = true)]
    pub place: Option<LatLon>,
    /// Centre (east, north) and radius in metres of an area of full contrast; around it contrast falls, and from about
    /// three radii on it is reduced by STRENGTH, 0 to 1 [default strength: 0.7]
    #[arg(long, value_name = "EAST,NORTH,RADIUS[,STRENGTH]", value_parser = SceneFocus::from_str, allow_hyphen_values = true)]
    pub focus: Option<SceneFocus>,
    /// Distance at which haze takes 63 % of the contrast, in metres [default: the scene's, or from the size of the
    /// world]
    #[arg(long, value_name = "METRES", value_parser = arguments::within(ranges::HAZE_M), allow_hyphen_values = true)]
    pub haze: Option<f64>,
}

impl LightArgs {
    /// Checks that `--place` has a date.
    ///
    /// # Errors
    /// Returns the misuse, in one line.
    pub(crate) fn check(&self) -> Result<(), Misuse> {
        match (self.place, self.date) {
            (Some(_), None) => Err(Misuse("--place: requires --date, which is not given".to_owned())),
            _ => Ok(()),
        }
    }

    /// Returns the scene with this light; options that are not given keep the scene's values.
    #[must_use]
    pub(crate) fn apply_to(&self, mut scene: Scene) -> Scene {
        if let Some(sun) = self.sun {
            (scene.sun, scene.sun_time) = (sun, None);
        }
        if let Some(moment) = self.date {
            let place = self.place.or_else(|| scene.sun_time.and_then(|time| time.place));
            scene.sun_time = Some(SunTime { moment, place });
        }
        scene.focus = self.focus.or(scene.focus);
        scene.haze.distance_m = self.haze.or(scene.haze.distance_m);
        scene
    }

    /// Places the sun relative to the first camera, if `--side-light` is given.
    pub(crate) fn place_sun(&self, sun: &mut Sun, first: &Camera) {
        if let Some(side_deg) = self.side_light {
            sun.azimuth_deg = (first.yaw_deg + side_deg).rem_euclid(360.0);
        }
    }
}

/// Parses a signed angle in degrees.
fn degrees(text: &str) -> Result<f64, String> {
    let degrees = text.trim().parse().ok().filter(|degrees| (-180.0..=180.0).contains(degrees));
    degrees.ok_or_else(|| "it must be an angle from -180 to 180 degrees, like -70".to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn the_command_line_comes_before_the_scene() {
        let scene = Scene::default();
        assert_eq!(LightArgs::default().apply_to(scene.clone()).sun, scene.sun);
        let low = LightArgs { sun: Some("-90, 5.5".parse().unwrap()), ..LightArgs::default() };
        assert_eq!(low.apply_to(scene.clone()).sun, Sun { azimuth_deg: -90.0, elevation_deg: 5.5 });
        let noon = LightArgs { date: Some("2026-06-21T12:00Z".parse().unwrap()), ..LightArgs::default() };
        let at_noon = noon.apply_to(Scene::default());
        assert_eq!(at_noon.sun_time.unwrap().moment.to_string(), "2026-06-21T12:00+00:00");
        assert_eq!(low.apply_to(at_noon).sun_time, None, "--sun comes before the date of a scene");
        let hazy = LightArgs { haze: Some(2500.0), ..LightArgs::default() };
        assert_eq!(hazy.apply_to(Scene::default()).light([1e5, 1e5]).haze_m, 2500.0);
        assert_eq!(LightArgs::default().apply_to(hazy.apply_to(Scene::default())).haze.distance_m, Some(2500.0));
        let mut sun = Sun { azimuth_deg: 315.0, elevation_deg: 12.0 };
        let camera: Camera = "0,0,+300,30,-5,50".parse().unwrap();
        LightArgs::default().place_sun(&mut sun, &camera);
        assert_eq!(sun.azimuth_deg, 315.0);
        LightArgs { side_light: Some(-70.0), ..LightArgs::default() }.place_sun(&mut sun, &camera);
        assert_eq!(sun, Sun { azimuth_deg: 320.0, elevation_deg: 12.0 });
        assert!(degrees("-70").is_ok() && ["", "left", "181", "nan"].iter().all(|wrong| degrees(wrong).is_err()));
        for wrong in ["", "315", "315,", "north,40", "400,40", "315,91", "315,40,1", "nan,40"] {
            assert!(wrong.parse::<Sun>().is_err(), "{wrong}");
        }
    }
}
