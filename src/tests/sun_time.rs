//! Tests the sun by date and place against published positions.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

use hachure::scene::sun_time::{LatLon, Moment, SunTimeError};
use hachure::scene::{Scene, Sun, SunTime};
use hachure::source::EarthPlace;

fn at(moment: &str, place: &str) -> Result<Sun, SunTimeError> {
    SunTime { moment: moment.parse().unwrap(), place: Some(place.parse().unwrap()) }.sun(None)
}

/// Returns whether both angles are within 0.1° of the published ones.
fn is_near(sun: Sun, azimuth_deg: f64, elevation_deg: f64) -> bool {
    let turn = (sun.azimuth_deg - azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
    turn.abs() < 0.1 && (sun.elevation_deg - elevation_deg).abs() < 0.1
}

#[test]
fn positions_are_those_that_were_published() {
    // Reda and Andreas, Solar Position Algorithm (NREL/TP-560-34302), table A5.1.
    let nrel = at("2003-10-17T12:30:30-07:00", "39.742476,-105.1786").unwrap();
    assert!(is_near(nrel, 194.34024, 90.0 - 50.11162), "{nrel:?}");
    // Meeus, Astronomical Algorithms, examples 25.a and 28.a: on 1992 October 13 at 0 h TD, which is 59 s later than
    // UT, the declination is -7.78507°, and the equation of time 13 min 42.6 s. The sun is on the meridian where that
    // makes it noon, and elevations at 40° north are 50° higher than the declination. Refraction adds 0.02°.
    let noon_longitude_deg = 180.0 - 15.0 * (13.0 / 60.0 + 42.6 / 3600.0) + 15.0 * 59.0 / 3600.0;
    let meridian = at("1992-10-12T23:59:01Z", &format!("40,{noon_longitude_deg}")).unwrap();
    assert!(is_near(meridian, 180.0, 50.0 - 7.78507), "{meridian:?}");
    // At the south pole the elevation is the declination, and refraction at 7.8° is 0.11° (Bennett 1982).
    let pole = at("1992-10-12T23:59:01Z", "-90,0").unwrap();
    assert!((pole.elevation_deg - 7.78507 - 0.114).abs() < 0.02, "{pole:?}");

    // Frequent mistakes would be detected: the time zone, and the order of latitude and longitude.
    let nrel = |moment: &str, place: &str| at(moment, place).is_ok_and(|sun| is_near(sun, 194.34024, 39.88838));
    assert!(
        nrel("2003-10-17T19:30:30Z", "39.742476,-105.1786"),
        "the same moment in another zone must give the same position"
    );
    assert!(!nrel("2003-10-17T12:30:30Z", "39.742476,-105.1786"));
    assert!(!nrel("2003-10-17T12:30:30+07:00", "39.742476,-105.1786"));
    assert!(!nrel("2003-10-17T12:30:30-07:00", "-39.742476,-105.1786"));
}

#[test]
fn azimuths_count_from_the_north_of_the_grid() {
    let moment = "2003-10-17T12:30:30-07:00".parse().unwrap();
    let grid = |grid_north_deg| EarthPlace { latitude_deg: 39.742476, longitude_deg: -105.1786, grid_north_deg };
    let time = SunTime { moment, place: None };
    assert!(is_near(time.sun(Some(grid(0.0))).unwrap(), 194.34024, 39.88838));
    // In a grid whose north is east of true north, the sun's azimuth is smaller.
    assert!(is_near(time.sun(Some(grid(2.0))).unwrap(), 192.34024, 39.88838));
    assert!(!is_near(time.sun(Some(grid(-2.0))).unwrap(), 192.34024, 39.88838));
    // A given place overrides that of the heights.
    let place = Some(LatLon { latitude_deg: -90.0, longitude_deg: 0.0 });
    assert!(SunTime { moment, place }.sun(Some(grid(0.0))).unwrap().elevation_deg < 10.0);
}

#[test]
fn what_has_no_sun_is_one_line() {
    let night = at("2026-06-21T23:30+02:00", "46.55,7.98").unwrap_err().to_string();
    assert!(
        night.starts_with("at 2026-06-21T23:30+02:00 the sun is 1")
            && night.contains("46.550,7.980; choose another time"),
        "{night}"
    );
    let nowhere = SunTime { moment: "2026-06-21T12:00Z".parse().unwrap(), place: None }.sun(None).unwrap_err();
    assert!(nowhere.to_string().contains("--place LAT,LON"), "{nowhere}");
    assert!(![night, nowhere.to_string()].concat().contains('\n'));
}

#[test]
fn moments_have_a_zone() {
    for (text, shown) in [
        ("2026-06-21T09:30+02:00", "2026-06-21T09:30+02:00"),
        ("2024-02-29T00:00:05Z", "2024-02-29T00:00:05+00:00"),
        ("2026-06-21 09:30-03:30", "2026-06-21T09:30-03:30"),
    ] {
        assert_eq!(text.parse::<Moment>().unwrap().to_string(), shown);
    }
    for wrong in [
        "",
        "2026-06-21",
        "2026-06-21T09:30",
        "2026-13-21T09:30Z",
        "2026-02-29T09:30Z",
        "2026-06-00T09:30Z",
        "2026-06-21T24:00Z",
        "2026-06-21T9:30Z",
        "2026-06-21T09:30+2",
        "2026-06-21T09:30:00:00Z",
        "26-06-21T09:30Z",
        "2026-06-21T09:30+02:00Z",
        "+026-06-21T09:30Z",
        "2026-06-21T09:30é",
    ] {
        assert!(wrong.parse::<Moment>().is_err(), "{wrong}");
    }
    for wrong in ["", "46.5", "91,0", "0,181", "a,b", "46,7,8", "nan,0"] {
        assert!(wrong.parse::<LatLon>().is_err(), "{wrong}");
    }
}

#[test]
fn a_scene_may_have_a_date() {
    let parse = |sun: &str| {
        Scene::parse("s.toml".as_ref(), &format!("[world]\nprocedural = {{ seed = 1 }}\n[sun]\n{sun}"))
            .map_err(|error| error.to_string())
    };
    let scene = parse("date = \"2003-10-17T12:30:30-07:00\"\nplace = \"39.742476,-105.1786\"").unwrap();
    assert!(is_near(scene.sun_time.unwrap().sun(None).unwrap(), 194.34024, 39.88838));
    assert_eq!(parse("azimuth_deg = 100").unwrap().sun_time, None);
    for (sun, message) in [
        ("date = \"2003-10-17\"", "s.toml:4:8: sun.date: it must be a date and time with a UTC offset"),
        ("date = \"2003-10-17T12:30Z\"\nplace = \"Bern\"", "s.toml:5:9: sun.place: it must be a latitude"),
        ("place = \"46,7\"", "s.toml:4:9: sun.place: it is only used with sun.date"),
        ("date = \"2003-10-17T12:30Z\"\nazimuth_deg = 3", "s.toml:4:8: sun.date: it cannot be combined with"),
    ] {
        let error = parse(sun).unwrap_err();
        assert!(error.starts_with(message), "{error}");
    }
}
