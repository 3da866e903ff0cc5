//! Where a camera stands that looks at a place.

use std::fmt;
use std::str::FromStr;

use super::ranges;

/// A point from which a place is looked at, written `AZIMUTH,DISTANCE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandPoint {
    /// Direction of the camera as seen from the place, clockwise from the world's north, in degrees.
    pub azimuth_deg: f64,
    /// Distance on the map, in metres.
    pub distance_m: f64,
}

impl FromStr for StandPoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = text.split_once(',').and_then(|(azimuth, distance)| {
            Some(Self {
                azimuth_deg: ranges::AZIMUTH_DEG.parse(azimuth.trim()).ok()?,
                distance_m: ranges::STAND_DISTANCE_M.parse(distance.trim()).ok()?,
            })
        });
        found.ok_or_else(|| {
            "it must be an azimuth in degrees (-360 to 360) and a distance in metres (0.01 to 10000000), like 220,5000"
                .to_owned()
        })
    }
}

impl fmt::Display for StandPoint {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{},{}", self.azimuth_deg, self.distance_m)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn stand_points_are_read_as_they_are_written() {
        let from: StandPoint = "220, 5000.5".parse().unwrap();
        assert_eq!(from, StandPoint { azimuth_deg: 220.0, distance_m: 5000.5 });
        assert_eq!(from.to_string().parse(), Ok(from));
        for wrong in ["", "220", "220,", "220,0", "220,-5", "400,5000", "nan,1", "220,inf", "220,5000,1", "S,500"] {
            assert!(wrong.parse::<StandPoint>().is_err(), "{wrong}");
        }
    }
}
