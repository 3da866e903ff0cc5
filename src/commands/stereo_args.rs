//! Options of stereo pairs, for all commands that draw.

use std::fmt;
use std::str::FromStr;

use clap::Args;

use super::arguments;
use super::misuse::Misuse;
use crate::scene::ranges;
use crate::scene::stereo::{Eyes, HYPERSTEREO, IPD_M, Pair};

/// `--eyes` and the options that depend on it.
#[derive(Clone, Debug, Args)]
pub(crate) struct StereoArgs {
    /// Eyes to draw: mono, left or right (one eye of a stereo pair), side-by-side (each of --size), anaglyph or
    /// grey-anaglyph (for red-cyan glasses) [default: mono]
    #[arg(long)]
    pub eyes: Option<Eyes>,
    /// Distance between the eyes of a stereo pair, in metres, or auto for a thirtieth of the distance to the nearest
    /// land [default: 0.065]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    pub ipd: Option<Ipd>,
    /// Distance of zero parallax of a stereo pair, in metres: what is there appears at the screen [default: infinitely
    /// far]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true, value_parser = arguments::within(ranges::CONVERGENCE_M))]
    pub convergence: Option<f64>,
}

/// Distance between two eyes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ipd {
    /// A distance in metres.
    Metres(f64),
    /// A thirtieth of the distance to the nearest land.
    Auto,
}

impl FromStr for Ipd {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let metres = ranges::IPD_M.parse(text).map(Self::Metres);
        metres.map_err(|error| format!("{error}, or auto"))
    }
}

impl fmt::Display for Ipd {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Metres(metres) => metres.fmt(out),
            Self::Auto => out.write_str("auto"),
        }
    }
}

impl StereoArgs {
    /// Returns the eyes to draw.
    pub(crate) fn eyes(&self) -> Eyes {
        self.eyes.unwrap_or(Eyes::Mono)
    }

    /// Checks that options of a stereo pair are only given if two eyes are drawn.
    ///
    /// # Errors
    /// Returns [`Misuse`] if one is given with `--eyes mono`.
    pub(crate) fn check(&self) -> Result<(), Misuse> {
        let stray = self.ipd.map(|_| "--ipd").or(self.convergence.map(|_| "--convergence"));
        match stray.filter(|_| self.eyes() == Eyes::Mono) {
            Some(name) => Err(Misuse(format!(
                "{name}: needs a stereo pair, and --eyes is mono; add --eyes side-by-side or anaglyph"
            ))),
            None => Ok(()),
        }
    }

    /// Returns whether the distance to the nearest land has to be measured.
    pub(crate) fn requests_nearest(&self) -> bool {
        self.eyes() != Eyes::Mono && self.ipd == Some(Ipd::Auto)
    }

    /// Returns the stereo pair, if two eyes are drawn. `nearest_m` is the distance to the nearest land, infinite if
    /// none is seen.
    pub(crate) fn pair(&self, nearest_m: f64) -> Option<Pair> {
        let ipd_m = match self.ipd {
            None => IPD_M,
            Some(Ipd::Metres(metres)) => metres,
            Some(Ipd::Auto) if nearest_m.is_finite() => HYPERSTEREO * nearest_m,
            // If only sky is seen, use the usual distance between human eyes.
            Some(Ipd::Auto) => IPD_M,
        };
        (self.eyes() != Eyes::Mono).then_some(Pair { ipd_m, convergence_m: self.convergence })
    }
}
