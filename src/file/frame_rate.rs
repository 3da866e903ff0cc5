//! Frames per second, as a number or as an exact fraction such as 30000/1001 (NTSC's 29.97).

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Largest rate in frames per second.
const LARGEST: f64 = 1000.0;

/// A number of frames per second, above 0 and at most 1000.
///
/// In an imprint, a number is a number and a fraction is a text.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub enum FrameRate {
    /// A number of frames per second.
    Number(f64),
    /// A number of frames and the number of seconds in which they are shown.
    Fraction(u32, u32),
}

/// A rate as it is written in TOML.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Text(String),
}

impl FrameRate {
    /// Returns frames per second.
    pub(crate) fn per_second(self) -> f64 {
        match self {
            Self::Number(rate) => rate,
            Self::Fraction(frames, seconds) => f64::from(frames) / f64::from(seconds),
        }
    }

    /// Returns the time from the first frame to a frame, in seconds.
    pub(crate) fn time_s(self, frame: u64) -> f64 {
        match self {
            Self::Number(rate) => frame as f64 / rate,
            Self::Fraction(frames, seconds) => frame as f64 * f64::from(seconds) / f64::from(frames),
        }
    }

    /// Returns whether it is a number that a film can have.
    pub(crate) fn is_valid(self) -> bool {
        let rate = self.per_second();
        rate.is_finite() && rate > 0.0 && rate <= LARGEST
    }
}

impl From<f64> for FrameRate {
    fn from(rate: f64) -> Self {
        Self::Number(rate)
    }
}

impl FromStr for FrameRate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let rate = match text.split_once('/') {
            None => text.parse().ok().map(Self::Number),
            Some((frames, seconds)) => {
                frames.trim().parse().ok().zip(seconds.trim().parse().ok()).map(|(a, b)| Self::Fraction(a, b))
            }
        };
        rate.filter(|rate| rate.is_valid()).ok_or_else(|| {
            "it must be a number above 0, at most 1000, or a fraction of whole numbers such as 30000/1001".to_owned()
        })
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(rate) => write!(out, "{rate}"),
            Self::Fraction(frames, seconds) => write!(out, "{frames}/{seconds}"),
        }
    }
}

impl TryFrom<Written> for FrameRate {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        match written {
            // The reader of imprints checks the range, and names the key.
            Written::Number(rate) => Ok(Self::Number(rate)),
            Written::Text(text) => text.parse(),
        }
    }
}

impl From<FrameRate> for Written {
    fn from(rate: FrameRate) -> Self {
        match rate {
            FrameRate::Number(rate) => Self::Number(rate),
            FrameRate::Fraction(..) => Self::Text(rate.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn rates_are_read_as_they_are_written() {
        for text in ["30", "23.976", "30000/1001", "24/1"] {
            assert_eq!(text.parse::<FrameRate>().unwrap().to_string(), text);
        }
        let ntsc: FrameRate = "30000/1001".parse().unwrap();
        assert!((ntsc.per_second() - 29.970_029_97).abs() < 1e-8);
        // Frame 30,000 is at 1001 s exactly; the rounded rate is off.
        assert_eq!(ntsc.time_s(30_000), 1001.0);
        assert_ne!(FrameRate::Number(29.97).time_s(30_000), 1001.0, "planted error");
        for text in ["0", "-1", "inf", "NaN", "1001", "30/0", "0/5", "1/2/3", "x", "", "30000/1"] {
            assert!(text.parse::<FrameRate>().unwrap_err().contains("30000/1001"), "{text}");
        }
    }

    #[test]
    fn an_imprint_has_a_number_or_a_fraction() {
        #[derive(PartialEq, Debug, Serialize, Deserialize)]
        struct Held {
            fps: FrameRate,
        }
        for (fps, text) in
            [(FrameRate::Number(24.0), "fps = 24.0\n"), (FrameRate::Fraction(30_000, 1001), "fps = \"30000/1001\"\n")]
        {
            assert_eq!(toml::to_string(&Held { fps }).unwrap(), text);
            assert_eq!(toml::from_str::<Held>(text).unwrap(), Held { fps });
        }
        for text in ["fps = \"x\"", "fps = \"1/0\"", "fps = true"] {
            assert!(toml::from_str::<Held>(text).is_err(), "{text}");
        }
    }
}
