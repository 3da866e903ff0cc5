//! The fate of the ink of one frame in another.

use std::collections::HashMap;

use glam::DVec2;
use rayon::prelude::*;

use super::follow::{Follower, Whose};
use super::{HELD_SHARE, LINE_INK, LineChange, Share, StrokePictures};

/// The fate of a pixel with ink.
pub(crate) struct Fate {
    pub pixel: usize,
    pub ink: f32,
    /// The counterpart of the pixel in the other frame; `None` if the pixel cannot be followed.
    pub there: Option<Counterpart>,
}

/// The counterpart of a pixel in the other frame.
pub(crate) struct Counterpart {
    /// Position of the pixel in the other frame.
    pub place: DVec2,
    /// Largest ink within reach.
    pub ink: f32,
    /// Nearest line pixel within reach.
    pub line: Option<usize>,
}

impl Fate {
    pub(crate) fn is_line(&self) -> bool {
        self.ink >= LINE_INK
    }
}

/// The fates of all pixels with ink, row by row.
pub(crate) struct Fates(pub Vec<Fate>);

impl Fates {
    /// Follows the ink of a frame to the other one, and looks for ink within `reach_px` of each pixel's place. Ink of
    /// `strokes` is followed at the depth of its stroke.
    pub(crate) fn of(
        follower: &Follower<'_>,
        ink: &[f32],
        ink_there: &[f32],
        reach_px: f64,
        strokes: Option<&StrokePictures>,
    ) -> Self {
        let look = |place: DVec2| {
            let (mut most, mut nearest) = (0.0_f32, None::<(usize, f64)>);
            for (at, squared) in follower.to.within(place, reach_px) {
                most = most.max(ink_there[at]);
                if ink_there[at] >= LINE_INK && nearest.is_none_or(|(_, least)| squared < least) {
                    nearest = Some((at, squared));
                }
            }
            Counterpart { place, ink: most, line: nearest.map(|(at, _)| at) }
        };
        let there = |pixel: usize| {
            let of_stroke = strokes.filter(|strokes| strokes.depth_m[pixel].is_finite());
            if let Some(strokes) = of_stroke {
                let [depth_m, half_width_px] = [&strokes.depth_m, &strokes.half_width_px].map(|of| of[pixel].into());
                return follower.place_of_stroke(pixel, depth_m, half_width_px).map(look);
            }
            let as_line = follower.place(pixel, Whose::Line).map(look);
            if as_line.as_ref().is_some_and(|there| there.line.is_some()) {
                return as_line;
            }
            let behind = follower.place_behind(pixel).map(look);
            behind.filter(|there| there.line.is_some()).or(as_line)
        };
        let width = follower.from.width();
        let rows = ink.par_chunks(width).enumerate().flat_map_iter(|(row, inks)| {
            let inked = inks.iter().enumerate().filter(|(_, ink)| **ink > 0.0);
            inked.map(move |(column, ink)| (row * width + column, *ink))
        });
        Self(rows.map(|(pixel, ink)| Fate { pixel, ink, there: there(pixel) }).collect())
    }

    fn lines(&self) -> impl Iterator<Item = &Fate> {
        self.0.iter().filter(|fate| fate.is_line())
    }

    pub(crate) fn line_pixels(&self) -> usize {
        self.lines().count()
    }

    pub(crate) fn change(&self) -> LineChange {
        let mut change = LineChange::default();
        for fate in self.lines() {
            change.masked += Share { part: f64::from(u8::from(fate.there.is_none())), whole: 1.0 };
            if let Some(there) = &fate.there {
                change.lone += Share { part: f64::from(u8::from(there.line.is_none())), whole: 1.0 };
            }
        }
        for (fate, there) in self.0.iter().filter_map(|fate| Some((fate, fate.there.as_ref()?))) {
            let lacking = (fate.ink - there.ink).max(0.0);
            change.lone_ink += Share { part: lacking.into(), whole: fate.ink.into() };
        }
        change
    }

    /// Returns the strokes of which less than [`HELD_SHARE`] continues, of those with line pixels that can be followed.
    pub(crate) fn lone_strokes(&self, id: &[u32]) -> Share {
        let mut held: HashMap<u32, Share> = HashMap::new();
        for fate in self.lines().filter(|fate| id[fate.pixel] != 0) {
            if let Some(there) = &fate.there {
                let goes_on = f64::from(u8::from(there.line.is_some()));
                *held.entry(id[fate.pixel]).or_default() += Share { part: goes_on, whole: 1.0 };
            }
        }
        let lone = held.values().filter(|held| held.part < HELD_SHARE * held.whole).count();
        Share { part: lone as f64, whole: held.len() as f64 }
    }
}
