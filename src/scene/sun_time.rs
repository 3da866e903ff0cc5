//! The position of the sun from date and place, instead of azimuth and elevation.
//!
//! The position comes from NREL's Solar Position Algorithm (Reda and Andreas 2004), implemented by the crate
//! `solar-positioning`, within 0.0003°, with the refraction of standard air, so it is the apparent position. Azimuths
//! in the world count from grid north, so the convergence of the meridians is subtracted.

use std::fmt;
use std::str::FromStr;

use solar_positioning::time::JulianDate;
use solar_positioning::{Location, RefractionCorrection, SolarPositions, delta_t};

use super::Sun;
use crate::source::EarthPlace;

/// A date and time with a time zone: `2026-06-21T09:30+02:00`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    year: i32,
    month: u32,
    day: u32,
    hour: u32,
    minute: u32,
    second: u32,
    /// Offset of the time zone from UTC, in minutes, positive to the east.
    zone_min: i32,
}

/// Latitude and longitude in degrees: `46.55,7.98`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatLon {
    /// Latitude, north of the equator positive.
    pub latitude_deg: f64,
    /// Longitude, east of Greenwich positive.
    pub longitude_deg: f64,
}

/// The date and place from which the sun's position is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunTime {
    pub moment: Moment,
    /// Place; `None` is the location of the heights.
    pub place: Option<LatLon>,
}

/// Why the sun's position cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SunTimeError {
    /// Neither the user nor the heights give a place.
    #[error(
        "the sun's position at {0} depends on the place, but the location of the elevation data is unknown; \
         give --place LAT,LON, or sun.place in the scene"
    )]
    NoPlace(Moment),
    /// The sun is below the horizon.
    #[error("at {moment} the sun is {below_deg:.1}° below the horizon at {place}; choose another time, or give --sun")]
    Night {
        moment: Moment,
        /// Place on the earth.
        place: LatLon,
        /// Angle below the horizon, in degrees.
        below_deg: f64,
    },
    /// The date is outside of the years that the algorithm covers.
    #[error("cannot compute the sun's position at {0}: {1}")]
    Unknown(Moment, String),
}

impl SunTime {
    /// Computes the sun over a world whose heights are located at `earth`, if that is known. Azimuths count from the
    /// world's grid north, or from true north if grid north is not known.
    ///
    /// # Errors
    /// [`SunTimeError`].
    pub fn sun(&self, earth: Option<EarthPlace>) -> Result<Sun, SunTimeError> {
        let moment = self.moment;
        let of_heights =
            earth.map(|EarthPlace { latitude_deg, longitude_deg, .. }| LatLon { latitude_deg, longitude_deg });
        let place = self.place.or(of_heights).ok_or(SunTimeError::NoPlace(moment))?;
        let unknown = |error: solar_positioning::Error| SunTimeError::Unknown(moment, error.to_string());
        let Moment { year, month, day, hour, minute, second, zone_min } = moment;
        let delta_t = delta_t::estimate_from_date(year, month).map_err(unknown)?;
        let local =
            JulianDate::from_utc(year, month, day, hour, minute, f64::from(second), delta_t).map_err(unknown)?;
        let utc = JulianDate::new(local.julian_date() - f64::from(zone_min) / 1440.0, delta_t).map_err(unknown)?;
        let location = Location { latitude: place.latitude_deg, longitude: place.longitude_deg };
        let air = Some(RefractionCorrection::standard());
        let sun = SolarPositions::new().at_from_julian(utc, location, 0.0, air).map_err(unknown)?;
        let elevation_deg = sun.elevation_angle();
        if elevation_deg < 0.0 {
            return Err(SunTimeError::Night { moment, place, below_deg: -elevation_deg });
        }
        let grid_north_deg = earth.map_or(0.0, |earth| earth.grid_north_deg);
        Ok(Sun { azimuth_deg: (sun.azimuth() - grid_north_deg).rem_euclid(360.0), elevation_deg })
    }
}

/// Parses a number of exactly `count` digits, at most `most`.
fn digits(text: &str, count: usize, most: u32) -> Option<u32> {
    let is_number = text.len() == count && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|number| is_number && *number <= most)
}

/// Returns the number of days of a month.
fn days(year: u32, month: u32) -> u32 {
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    match month {
        4 | 6 | 9 | 11 => 30,
        2 if is_leap => 29,
        2 => 28,
        _ => 31,
    }
}

fn moment(text: &str) -> Option<Moment> {
    let (date, rest) = text.trim().split_once(['T', ' '])?;
    let mut parts = date.split('-');
    let (year, month) = (digits(parts.next()?, 4, 9999)?, digits(parts.next()?, 2, 12).filter(|month| *month > 0)?);
    let day = digits(parts.next()?, 2, days(year, month)).filter(|day| *day > 0)?;
    let (time, zone_min) = match rest.strip_suffix(['Z', 'z']) {
        Some(time) => (time, 0),
        None => {
            let at = rest.find(['+', '-'])?;
            let (hour, minute) = rest[at + 1..].split_once(':')?;
            let minutes = (digits(hour, 2, 14)? * 60 + digits(minute, 2, 59)?) as i32;
            (&rest[..at], if rest[at..].starts_with('-') { -minutes } else { minutes })
        }
    };
    let mut clock = time.split(':');
    let (hour, minute) = (digits(clock.next()?, 2, 23)?, digits(clock.next()?, 2, 59)?);
    let second = clock.next().map_or(Some(0), |second| digits(second, 2, 59))?;
    let is_whole = parts.next().is_none() && clock.next().is_none();
    is_whole.then_some(Moment { year: year as i32, month, day, hour, minute, second, zone_min })
}

impl FromStr for Moment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        moment(text).ok_or_else(|| {
            "it must be a date and time with a UTC offset, like 2026-06-21T09:30+02:00 or 2026-06-21T07:30Z".to_owned()
        })
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { year, month, day, hour, minute, second, zone_min } = self;
        write!(out, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}")?;
        if *second > 0 {
            write!(out, ":{second:02}")?;
        }
        let (sign, zone_min) = (if *zone_min < 0 { '-' } else { '+' }, zone_min.abs());
        write!(out, "{sign}{:02}:{:02}", zone_min / 60, zone_min % 60)
    }
}

impl FromStr for LatLon {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let within = |text: &str, most: f64| text.trim().parse().ok().filter(|number| (-most..=most).contains(number));
        let place = text.split_once(',').and_then(|(latitude, longitude)| {
            Some(Self { latitude_deg: within(latitude, 90.0)?, longitude_deg: within(longitude, 180.0)? })
        });
        place.ok_or_else(|| {
            "it must be a latitude from -90 to 90 and a longitude from -180 to 180, like 46.55,7.98".to_owned()
        })
    }
}

impl fmt::Display for LatLon {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{:.3},{:.3}", self.latitude_deg, self.longitude_deg)
    }
}
