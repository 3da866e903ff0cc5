//! Arguments of two eyes, which all commands that draw share.

use std::fmt;
use std::str::FromStr;

use clap::Args;

use super::arguments;
use super::misuse::Misuse;
use crate::scene::stereo::{Eyes, HYPERSTEREO, IPD_M, Pair};

/// `--eyes` and what belongs to it.
#[derive(Clone, Debug, Args)]
pub struct StereoArgs {
    /// Which eyes: mono, left or right (of a pair), side-by-side (each of --size), anaglyph or grey-anaglyph (for a red
    /// and a cyan glass) [default: mono]
    #[arg(long)]
    pub eyes: Option<Eyes>,
    /// Of two eyes: how far apart they are, in metres, or auto: a thirtieth of the nearest land [default: 0.065]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    pub ipd: Option<Ipd>,
    /// Of two eyes: how far away the picture's plane is, where both see the same [default: infinitely far]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true, value_parser = arguments::above_0)]
    pub convergence: Option<f64>,
}

/// How far apart two eyes are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ipd {
    /// In metres.
    Metres(f64),
    /// By the nearest land.
    Auto,
}

impl FromStr for Ipd {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let metres = arguments::from_to(0.0, 1e6)(text).map(Self::Metres);
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
    /// Which eyes.
    pub fn eyes(&self) -> Eyes {
        self.eyes.unwrap_or(Eyes::Mono)
    }

    /// That nothing is said of two eyes where one is drawn.
    ///
    /// # Errors
    /// [`Misuse`].
    pub fn check(&self) -> Result<(), Misuse> {
        let stray = self.ipd.map(|_| "--ipd").or(self.convergence.map(|_| "--convergence"));
        match stray.filter(|_| self.eyes() == Eyes::Mono) {
            Some(name) => Err(Misuse(format!("{name}: it is for two eyes, and --eyes is mono"))),
            None => Ok(()),
        }
    }

    /// Whether the nearest land is to be found.
    pub fn asks_for_nearest(&self) -> bool {
        self.eyes() != Eyes::Mono && self.ipd == Some(Ipd::Auto)
    }

    /// How two eyes stand to each other, if there are two. `nearest_m` is infinite where no land is seen.
    pub fn pair(&self, nearest_m: f64) -> Option<Pair> {
        let ipd_m = match self.ipd {
            None => IPD_M,
            Some(Ipd::Metres(metres)) => metres,
            Some(Ipd::Auto) if nearest_m.is_finite() => HYPERSTEREO * nearest_m,
            // Over nothing but sky eyes stand as anybody's do.
            Some(Ipd::Auto) => IPD_M,
        };
        (self.eyes() != Eyes::Mono).then_some(Pair { ipd_m, convergence_m: self.convergence })
    }
}
