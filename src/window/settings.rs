//! What can be changed while flying.

use crate::scene::Sun;
use crate::style::{self, Style};
use crate::tones::hatching::maps;

/// The picture's size as parts of the window's.
pub const SCALES: [f64; 3] = [1.0, 0.75, 0.5];

/// The knobs of the panel. The camera's are its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Which of [`Styles`].
    pub style: usize,
    /// Which of [`SCALES`].
    pub scale: usize,
    /// The height error that may be seen.
    pub lod_error_px: f64,
    /// The light.
    pub sun: Sun,
    /// The distance at which haze has taken 63 %.
    pub haze_m: f64,
}

impl Settings {
    /// The picture's size in a window of `window_px`.
    pub fn picture_px(&self, window_px: [u32; 2]) -> [u32; 2] {
        window_px.map(|side| ((f64::from(side) * SCALES[self.scale]).round() as u32).max(1))
    }

    /// A finer (1) or coarser (−1) picture.
    pub fn step_scale(&mut self, step: i32) {
        self.scale = self.scale.saturating_add_signed(-step as isize).min(SCALES.len() - 1);
    }

    /// The style so many further in the list, around its end.
    pub fn step_style(&mut self, step: i32, styles: usize) {
        self.style = (self.style as i64 + i64::from(step)).rem_euclid(styles as i64) as usize;
    }
}

/// The styles to choose from: the presets, and the one of the command line.
pub struct Styles {
    list: Vec<Style>,
}

impl Styles {
    /// The presets and `asked`, and the place of `asked` in the list.
    ///
    /// # Errors
    /// When `asked` is no style.
    pub fn with(asked: &str) -> Result<(Self, usize), style::StyleError> {
        let names = style::names();
        let mut list = names.iter().map(|name| Style::load(name)).collect::<Result<Vec<_>, _>>()?;
        let place = match names.iter().position(|name| *name == asked) {
            Some(place) => place,
            None => {
                let style = Style::load(asked)?;
                maps::check(&style)?;
                list.push(style);
                list.len() - 1
            }
        };
        Ok((Self { list }, place))
    }

    /// All of them; at least one.
    pub fn list(&self) -> &[Style] {
        &self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings { style: 0, scale: 0, lod_error_px: 1.0, sun: Sun::default(), haze_m: 1000.0 }
    }

    #[test]
    fn steps_stay_in_their_lists() {
        let mut settings = settings();
        settings.step_scale(1);
        assert_eq!(settings.scale, 0);
        (0..9).for_each(|_| settings.step_scale(-1));
        assert_eq!(settings.picture_px([641, 1]), [321, 1]);
        settings.step_style(-1, 4);
        assert_eq!(settings.style, 3);
        settings.step_style(1, 4);
        assert_eq!(settings.style, 0);
    }

    #[test]
    fn every_preset_is_there_and_the_asked_one_is_found() {
        let (styles, place) = Styles::with("ink").unwrap();
        assert_eq!(styles.list().len(), style::names().len());
        assert_eq!(style::names()[place], "ink");
        assert!(Styles::with("no such style").is_err());
    }
}
