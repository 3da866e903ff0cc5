//! The ranges of options, each defined once: the command line, imprints of pictures and scene files read them here.

/// The allowed numbers of an option. No range contains infinity or NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NumberRange {
    /// Every finite number.
    Finite,
    /// Every finite number other than 0.
    Not0,
    /// Every finite number above 0.
    Above0,
    /// Every number above 0, at most this.
    Above0To(f64),
    /// Every number from the first to the second, both included.
    Within(f64, f64),
    /// Every whole number from the first to the second, both included.
    Whole(u64, u64),
}

impl NumberRange {
    /// Returns whether a number is allowed.
    pub(crate) fn holds(self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Self::Finite => true,
                Self::Not0 => number != 0.0,
                Self::Above0 => number > 0.0,
                Self::Above0To(most) => number > 0.0 && number <= most,
                Self::Within(least, most) => (least..=most).contains(&number),
                Self::Whole(least, most) => number.fract() == 0.0 && (least as f64..=most as f64).contains(&number),
            }
    }

    /// Returns what a value must be, as the clause of a message.
    pub(crate) fn rule(self) -> String {
        match self {
            Self::Finite => "it must be a number".to_owned(),
            Self::Not0 => "it must be a number other than 0".to_owned(),
            Self::Above0 => "it must be a number above 0".to_owned(),
            Self::Above0To(most) => format!("it must be a number above 0, at most {most}"),
            Self::Within(least, most) => format!("it must be a number between {least} and {most}"),
            Self::Whole(least, most) => format!("it must be a whole number from {least} to {most}"),
        }
    }

    /// Parses a number and checks it.
    ///
    /// # Errors
    /// Returns [`NumberRange::rule`].
    pub(crate) fn parse(self, text: &str) -> Result<f64, String> {
        text.parse().ok().filter(|number| self.holds(*number)).ok_or_else(|| self.rule())
    }

    /// Parses a whole number and checks it.
    ///
    /// # Errors
    /// Returns [`NumberRange::rule`].
    pub(crate) fn parse_whole<T: TryFrom<u64>>(self, text: &str) -> Result<T, String> {
        let number = text.parse::<u64>().ok().filter(|number| self.holds(*number as f64));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| self.rule())
    }
}

/// Checks the number of pixels of a picture whose sides are valid.
///
/// # Errors
/// Returns the rule, as [`NumberRange::rule`] does.
pub(crate) fn check_pixels([width, height]: [u32; 2]) -> Result<(), String> {
    let pixels = u64::from(width) * u64::from(height);
    match pixels > MAX_PIXELS {
        true => Err(format!("it must have at most {MAX_PIXELS} pixels, and {width}x{height} are {pixels}")),
        false => Ok(()),
    }
}

/// Side of a picture, in pixels.
pub(crate) const SIDE_PX: NumberRange = NumberRange::Whole(1, 1 << 20);
/// Largest number of pixels of a picture: that of ten metres by ten at 300 dots per inch, which takes hours.
const MAX_PIXELS: u64 = 1 << 34;
/// Resolution on paper, in dots per inch.
pub(crate) const DPI: NumberRange = NumberRange::Within(1.0, 10_000.0);
/// Time at which wind is drawn, in seconds: at most a year from 0, as on a camera path.
pub(crate) const TIME_S: NumberRange = NumberRange::Within(-super::path::LATEST_S, super::path::LATEST_S);
/// Frames per second.
pub(crate) const FPS: NumberRange = NumberRange::Above0To(1000.0);
/// Frames before a part of a film.
pub(crate) const WARM_UP_FRAMES: NumberRange = NumberRange::Whole(0, 10_000_000);
/// Samples per pixel.
pub(crate) const SAMPLES: NumberRange = NumberRange::Whole(1, 1024);
/// Allowed error of the drawn surface, in pixels.
pub(crate) const LOD_ERROR_PX: NumberRange = NumberRange::Above0;
/// Time that a frame may take, in milliseconds.
pub(crate) const BUDGET_MS: NumberRange = NumberRange::Above0To(60_000.0);
/// Memory for tiles, in MiB.
pub(crate) const TILE_MEMORY_MIB: NumberRange = NumberRange::Whole(1, 1 << 20);
/// Distance of zero parallax, in metres.
pub(crate) const CONVERGENCE_M: NumberRange = NumberRange::Above0;
/// Distance between two eyes, in metres.
pub(crate) const IPD_M: NumberRange = NumberRange::Within(0.0, 1e6);
/// Additional no-data value, in metres.
pub(crate) const NO_DATA_M: NumberRange = NumberRange::Finite;
/// Metres per step of a height.
pub(crate) const HEIGHT_SCALE_M: NumberRange = NumberRange::Not0;
/// Height of step 0, in metres.
pub(crate) const HEIGHT_OFFSET_M: NumberRange = NumberRange::Finite;
/// Distance between fitted curves and strokes, in pixels.
pub(crate) const TOLERANCE_PX: NumberRange = NumberRange::Within(0.01, 100.0);
/// Margin around an SVG, in millimetres.
pub(crate) const MARGIN_MM: NumberRange = NumberRange::Within(0.0, 100_000.0);
/// Number of pens of a drawing.
pub(crate) const PENS: NumberRange = NumberRange::Whole(1, MAX_PENS);
/// Largest number of pens in one drawing.
pub(crate) const MAX_PENS: u64 = 3;
/// Azimuth of the sun, in degrees.
pub(crate) const AZIMUTH_DEG: NumberRange = NumberRange::Within(-360.0, 360.0);
/// Width of a map, in metres.
pub(crate) const MAP_WIDTH_M: NumberRange = NumberRange::Within(1e-3, super::camera::LARGEST_COORDINATE_M);
/// Denominator of the scale of a map.
pub(crate) const MAP_SCALE: NumberRange = NumberRange::Within(1.0, 1e10);
/// Distance on the map from which a place is looked at, in metres.
pub(crate) const STAND_DISTANCE_M: NumberRange = NumberRange::Within(0.01, 1e7);
/// Factor on all heights.
pub(crate) const EXAGGERATION: NumberRange = NumberRange::Above0To(1000.0);
/// Distance at which haze has taken 63 % of the contrast, in metres.
pub(crate) const HAZE_M: NumberRange = NumberRange::Above0;
/// Height of the sea, in metres.
pub(crate) const SEA_LEVEL_M: NumberRange = NumberRange::Within(-12_000.0, 9000.0);
/// Number of summits; 0 has none.
pub(crate) const PEAKS: NumberRange = NumberRange::Whole(0, 1_000_000);
/// Prominence of a summit, in metres: at most more than on any planet.
pub(crate) const PROMINENCE_M: NumberRange = NumberRange::Within(0.0, 30_000.0);
/// Seed of a random generator.
pub(crate) const SEED: NumberRange = NumberRange::Whole(0, u32::MAX as u64);
/// Elevation of the sun, in degrees.
pub(crate) const ELEVATION_DEG: NumberRange = NumberRange::Within(-90.0, 90.0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_range_contains_what_is_no_number() {
        let ranges = [
            SIDE_PX,
            DPI,
            TIME_S,
            FPS,
            SAMPLES,
            LOD_ERROR_PX,
            BUDGET_MS,
            TILE_MEMORY_MIB,
            CONVERGENCE_M,
            IPD_M,
            NO_DATA_M,
            HEIGHT_SCALE_M,
            HEIGHT_OFFSET_M,
            TOLERANCE_PX,
            MARGIN_MM,
            PENS,
            AZIMUTH_DEG,
            MAP_WIDTH_M,
            MAP_SCALE,
            STAND_DISTANCE_M,
            EXAGGERATION,
            HAZE_M,
            SEA_LEVEL_M,
            SEED,
            ELEVATION_DEG,
        ];
        for range in ranges {
            for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(!range.holds(number), "{range:?} {number}");
            }
            for text in ["", "nan", "inf", "-inf", "1e999", "1x"] {
                assert_eq!(range.parse(text), Err(range.rule()), "{range:?} {text}");
            }
            assert!(range.holds(1.0), "{range:?}");
        }
    }

    #[test]
    fn both_ends_belong_to_a_range() {
        let within = NumberRange::Within(-1.0, 2.5);
        assert!([-1.0, 2.5].iter().all(|number| within.holds(*number)) && !within.holds(2.6) && !within.holds(-1.1));
        let above = NumberRange::Above0To(9.0);
        assert!(above.holds(9.0) && above.holds(1e-300) && !above.holds(0.0) && !above.holds(9.1));
        let whole = NumberRange::Whole(1, 3);
        assert!(whole.holds(3.0) && !whole.holds(2.5) && !whole.holds(0.0) && !whole.holds(4.0));
        assert_eq!((whole.parse_whole::<u32>("3"), whole.parse_whole::<u32>("2.0").is_err()), (Ok(3), true));
    }
}
