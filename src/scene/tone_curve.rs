//! The curve that fits the tones of a style to a picture, written as `dark,white,metres`.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Which tones of the light become the darkest and the lightest of a style that fits its tones to the picture, and which
/// land is near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToneCurve {
    /// Tone of the light that becomes dark, 0 to 1.
    pub dark: f32,
    /// Tone of the light that becomes paper, above `dark`, up to 1.
    pub white: f32,
    /// Distance from the eye within which half of the land in view lies, in metres. Land nearer than that is lighter.
    pub middle_m: f32,
}

/// Least difference of the two tones.
const LEAST_SPAN: f32 = 0.01;

impl ToneCurve {
    /// Returns the mean of two curves with the weights `1 - part` and `part`.
    #[must_use]
    pub(crate) fn mixed(self, other: Self, part: f32) -> Self {
        if self == other {
            return self;
        }
        let mix = |a: f32, b: f32| a + (b - a) * part;
        Self {
            dark: mix(self.dark, other.dark),
            white: mix(self.white, other.white),
            middle_m: mix(self.middle_m.log2(), other.middle_m.log2()).exp2(),
        }
    }
}

impl FromStr for ToneCurve {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "it must be DARK,WHITE,METRES: two tones from 0 to 1, the second one lighter by 0.01 or more, and a distance \
             from 0.001 to 1e9 m, like 0.2,0.95,3500"
                .to_owned()
        };
        let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        let &[dark, white, middle_m] = numbers.as_deref().ok_or_else(wrong)? else { return Err(wrong()) };
        let is_in_range = (0.0..=1.0).contains(&dark) && white <= 1.0 && white - dark >= LEAST_SPAN * 0.999;
        if is_in_range && (1e-3..=1e9).contains(&middle_m) { Ok(Self { dark, white, middle_m }) } else { Err(wrong()) }
    }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The shortest text from which the same numbers are parsed.
        write!(out, "{},{},{}", self.dark, self.white, self.middle_m)
    }
}

/// Seconds between two pictures of a film that are measured.
const KEY_S: f64 = 1.0;
/// Weights of the measured pictures around one, by which the curve of a film is smoothed.
const SMOOTH: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// The curves of the frames of a film: pictures a second apart are measured before the film is drawn, so that the curve of
/// a frame does not depend on which frames are drawn before it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FilmCurves {
    /// Number of frames from one measured picture to the next.
    stride: usize,
    /// Number of the measured picture to which the first of `keys` belongs.
    first: usize,
    /// Smoothed curves of the measured pictures; `None` where no picture within two seconds shows land.
    keys: Vec<Option<ToneCurve>>,
}

impl FilmCurves {
    /// Measures what the frames `frames` of a film of `count` frames need with `measure`, which gets the number of a frame.
    ///
    /// # Errors
    /// The errors of `measure`.
    pub(crate) fn measured<E>(
        count: usize,
        per_second: f64,
        frames: Range<usize>,
        mut measure: impl FnMut(usize) -> Result<Option<ToneCurve>, E>,
    ) -> Result<Self, E> {
        let stride = ((per_second * KEY_S).round() as usize).max(1);
        let last = count.saturating_sub(1);
        let reach = SMOOTH.len() / 2;
        let first_key = (frames.start / stride).saturating_sub(reach);
        let last_key = (frames.end / stride + 1 + reach).min(last.div_ceil(stride));
        let keys = (first_key..=last_key).map(|key| measure((key * stride).min(last)));
        let found: Vec<Option<ToneCurve>> = keys.collect::<Result<_, E>>()?;
        // Beyond the ends of the film the first and the last picture continue.
        let at = |key: isize| found[key.clamp(0, found.len() as isize - 1) as usize];
        let smoothed = |key: usize| {
            let around =
                (key as isize - reach as isize..).zip(SMOOTH).filter_map(|(key, weight)| Some((at(key)?, weight)));
            let mean = around
                .reduce(|(mean, sum), (curve, weight)| (mean.mixed(curve, weight / (sum + weight)), sum + weight));
            mean.map(|(mean, _)| mean)
        };
        Ok(Self { stride, first: first_key, keys: (0..found.len()).map(smoothed).collect() })
    }

    /// Returns the curve of a frame; `None` if no measured picture near it shows land.
    pub(crate) fn of_frame(&self, number: usize) -> Option<ToneCurve> {
        let stride = self.stride.max(1);
        let (key, within) = ((number / stride).saturating_sub(self.first), number % stride);
        let curve = |key: usize| *self.keys.get(key).or(self.keys.last())?;
        match (curve(key), curve(key + 1)) {
            (Some(curve), Some(next)) => Some(curve.mixed(next, within as f32 / stride as f32)),
            (curve, next) => curve.or(next),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_as_they_are_written() {
        let curve: ToneCurve = "0.2,0.95,3500".parse().unwrap();
        assert_eq!(curve, ToneCurve { dark: 0.2, white: 0.95, middle_m: 3500.0 });
        let third = ToneCurve { dark: 1.0 / 3.0, ..curve };
        assert_eq!(third.to_string().parse(), Ok(third));
        for text in [
            "",
            "0.2",
            "0.2,0.1,5",
            "0.2,0.2,5",
            "-0.1,0.5,5",
            "0.1,1.5,5",
            "0.1,0.5,0",
            "0.1,0.5,nan",
            "a,b,c",
            "0,1,5,6",
        ] {
            assert!(text.parse::<ToneCurve>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_tones_of_a_film_change_slowly_where_the_land_changes_at_once() {
        // The land is gentle for five seconds, and then steep.
        let of = |number: usize| {
            let [dark, white] = if number < 150 { [0.6, 0.95] } else { [0.1, 0.8] };
            Ok::<_, ()>((number != 30 && number < 400).then_some(ToneCurve { dark, white, middle_m: 1000.0 }))
        };
        let film = FilmCurves::measured(301, 30.0, 0..301, of).unwrap();
        let tone = |number: usize, lit: f32| {
            let curve = film.of_frame(number).unwrap();
            ((lit - curve.dark) / (curve.white - curve.dark)).clamp(0.0, 1.0)
        };
        let largest = |tone: &dyn Fn(usize, f32) -> f32| {
            let changes = (1..301).flat_map(|number| (0..=20).map(move |lit| (number, lit as f32 / 20.0)));
            changes.map(|(number, lit)| (tone(number, lit) - tone(number - 1, lit)).abs()).fold(0.0, f32::max)
        };
        assert!(largest(&tone) <= 0.02, "{}", largest(&tone));
        // It arrives: the first and the last frame have the curves that were measured.
        for end in [0, 300] {
            let (found, wanted) = (film.of_frame(end).unwrap(), of(end).unwrap().unwrap());
            assert!(
                (found.dark - wanted.dark).abs() + (found.white - wanted.white).abs() < 1e-5,
                "{found:?} {wanted:?}"
            );
        }
        // A part of it has the same curves.
        let part = FilmCurves::measured(301, 30.0, 140..200, of).unwrap();
        assert!((140..200).all(|number| part.of_frame(number) == film.of_frame(number)));
        // Planted: each picture with its own curve.
        let hard = |number: usize, lit: f32| {
            let curve = of(number).unwrap().unwrap_or_else(|| of(0).unwrap().unwrap());
            ((lit - curve.dark) / (curve.white - curve.dark)).clamp(0.0, 1.0)
        };
        assert!(largest(&hard) > 0.5);
        // Land that is out of view for long leaves no trace in a part that begins there.
        let [whole, part] = [0..900, 600..900].map(|frames| FilmCurves::measured(900, 30.0, frames, of).unwrap());
        assert!((600..900).all(|number| part.of_frame(number) == whole.of_frame(number)));
        assert!(whole.of_frame(390).is_some() && whole.of_frame(700).is_none());
        // A film without land has no curve.
        assert_eq!(FilmCurves::measured(10, 30.0, 0..10, |_| Ok::<_, ()>(None)).unwrap().of_frame(3), None);
    }
}
