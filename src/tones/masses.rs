//! Edits the masses of stepped tones: light or dark areas that cover too small a share of the picture are taken to the land
//! around them, as a draughtsman leaves out what would be a spot. See `shaders/tones/masses/`.
//!
//! Why: `docs/decisions/masses.md`.

use super::Inputs;
use crate::gpu::buffer::{Buffer, BufferKind, Buffers};
use crate::gpu::pipelines::{Compute, defined};
#[cfg(test)]
use crate::gpu::pools::Pools;
use crate::gpu::recorder::Recorder;
#[cfg(test)]
use crate::gpu::recorder::Submits;
use crate::gpu::target::Target;
#[cfg(test)]
use crate::gpu::timer::Timer;
pub(crate) use crate::gpu::wgsl::shared::mass_grid::MassCell;
use crate::gpu::wgsl::shared::mass_grid::{LONGEST, MassRules};
use crate::gpu::{Gpu, GpuError, readback};
use crate::scene::view::Rig;
use crate::style::{Style, Tone, Toon};

const CELLS: BufferKind = BufferKind::storage("mass cells");
const LABELS: BufferKind = BufferKind::storage("mass labels");
const AREAS: BufferKind = BufferKind::storage("mass areas");

/// Least number of levels of stepped tones with soft borders.
const SOFT_LEVELS: u32 = 12;
/// The largest softness of steps with hard borders, which have one level each. The border of such a step is too narrow for
/// levels of its own.
const HARD: f32 = 0.1;

/// The cells of a picture on the GPU.
#[derive(Clone)]
pub(crate) struct Cells {
    /// Number of cells, across and down.
    pub counts: [u32; 2],
    /// A [`MassCell`] for each cell, by rows.
    pub buffer: Buffer,
}

/// The masses of a frame.
#[derive(Clone)]
pub(crate) enum FrameMasses {
    /// Each eye has its own, of what it sees.
    Own,
    /// They are given.
    Given(Cells),
}

/// The edited masses of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Masses {
    /// Number of cells, across and down.
    pub counts: [u32; 2],
    /// The cells, by rows.
    pub cells: Vec<MassCell>,
}

impl FrameMasses {
    /// Returns the masses of a frame to which none are given; `None` if its style does not edit them, if it is a part of a
    /// picture, or if its eyes are apart and would have different masses.
    pub(crate) fn of(rig: &Rig, style: &Style) -> Option<Self> {
        let (eyes, first) = (&rig.eyes, rig.eyes.first()?);
        let is_one_place = eyes.iter().all(|eye| eye.is_whole() && eye.pose.position_m == first.pose.position_m);
        style.edited_masses().filter(|_| is_one_place).map(|_| Self::Own)
    }
}

/// Reads the masses of a picture of `picture_px` whose frame was the last that computed any; `None` if none did.
///
/// # Errors
/// [`GpuError::Readback`].
pub(crate) fn read(gpu: &Gpu, buffers: &Buffers, picture_px: [u32; 2]) -> Result<Option<Masses>, GpuError> {
    let Some(buffer) = buffers.get(&CELLS) else { return Ok(None) };
    let counts = cell_counts(picture_px);
    let count = counts.map(|count| count as usize).into_iter().product();
    Ok(Some(Masses { counts, cells: readback::read_buffer(gpu, &buffer.raw, count)? }))
}

impl Masses {
    /// Returns the masses as the passes read them.
    pub(crate) fn upload(&self, recorder: &mut Recorder<'_>) -> Cells {
        Cells { counts: self.counts, buffer: recorder.upload(&CELLS, &self.cells) }
    }

    /// Returns these masses, of tones as they are sampled, as the GPU edits them.
    #[cfg(test)]
    pub(crate) fn edited(&self, gpu: &Gpu, toon: &Toon) -> Self {
        let (mut pools, mut timer) = (Pools::new(gpu), Timer::new(gpu).unwrap());
        let cells = Cells { counts: self.counts, buffer: Buffer::with(gpu, &CELLS, &self.cells) };
        let mut recorder = Recorder::new(gpu, &mut pools, &mut timer, Submits::default(), false);
        edit(&mut recorder, &cells, toon);
        assert!(recorder.is_complete());
        recorder.submit().unwrap();
        gpu.check().unwrap();
        Self { counts: self.counts, cells: readback::read_buffer(gpu, &cells.buffer.raw, self.cells.len()).unwrap() }
    }
}

impl Style {
    /// Returns the tones of a style with edited masses.
    pub(crate) fn edited_masses(&self) -> Option<&Toon> {
        match &self.tone {
            Tone::Toon(toon) => Some(toon).filter(|toon| toon.steps > 1 && toon.smallest_share > 0.0),
            Tone::Plain(_) => None,
        }
    }
}

/// Returns the number of cells of a picture, across and down.
pub(crate) fn cell_counts(picture_px: [u32; 2]) -> [u32; 2] {
    let longest = picture_px.into_iter().max().unwrap_or(1).max(1);
    picture_px.map(|side| ((u64::from(side) * u64::from(2 * LONGEST) / u64::from(longest)).div_ceil(2) as u32).max(1))
}

/// Computes the masses of what an eye sees. `water` is a picture of the water, if there is any.
pub(crate) fn run(
    recorder: &mut Recorder<'_>,
    inputs: &Inputs<'_>,
    picture_px: [u32; 2],
    water: Option<&Target>,
    toon: &Toon,
) -> Cells {
    let counts = cell_counts(picture_px);
    let cells = Cells { counts, buffer: recorder.buffer(&CELLS, 16 * u64::from(counts[0] * counts[1])) };
    sample(recorder, inputs, &cells, water, toon);
    edit(recorder, &cells, toon);
    cells
}

/// Computes the fitted tone of each cell.
fn sample(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, cells: &Cells, water: Option<&Target>, toon: &Toon) {
    let rules = MassRules { cells: cells.counts, ..MassRules::default() };
    let mut resources = inputs.lit_resources(recorder, water);
    resources.push(("mass_cells", cells.buffer.binding()));
    resources.push(("mass_rules", recorder.uniform("mass rules", &rules)));
    resources.extend(inputs.fit.into_iter().flat_map(|fit| toon.fit_resources(recorder, &fit.curve)));
    let fitted = ("FITTED", inputs.fit.is_some());
    let definitions = defined(inputs.lit_definitions(water).into_iter().chain([fitted]));
    recorder.pixels(Compute { name: "tones/masses/sample", definitions }, cells.counts, &resources);
}

/// Merges small masses into the land around them: light ones, then dark ones.
fn edit(recorder: &mut Recorder<'_>, cells: &Cells, toon: &Toon) {
    let count = cells.counts[0] * cells.counts[1];
    let levels = levels(toon);
    let least = (f64::from(toon.smallest_share) * f64::from(count)).ceil() as u32;
    let [labels, areas] =
        [&LABELS, &AREAS].map(|kind| recorder.buffer(kind, 4 * u64::from(count) * u64::from(levels - 1)));
    let all = [cells.counts[0], cells.counts[1] * (levels - 1)];
    // The border of a hard step belongs to both kinds of masses: it is neither wholly light nor wholly dark.
    let rise = if toon.softness > HARD { 0.0 } else { toon.softness };
    for (dark, rise) in [(0, rise), (1, 0.0)] {
        let rules = MassRules { cells: cells.counts, levels, least, dark, rise, ..MassRules::default() };
        let rules = ("mass_rules", recorder.uniform("mass rules", &rules));
        let [cells_of, labels, areas] = [("mass_cells", &cells.buffer), ("labels", &labels), ("areas", &areas)]
            .map(|(name, buffer)| (name, buffer.binding()));
        recorder.pixels("tones/masses/label", all, &[rules.clone(), labels.clone(), areas.clone()]);
        recorder.pixels("tones/masses/join", all, &[rules.clone(), labels.clone(), cells_of.clone()]);
        let whole = [rules, labels, cells_of, areas];
        recorder.pixels("tones/masses/count", all, &whole);
        recorder.pixels("tones/masses/take", cells.counts, &whole);
    }
}

/// Returns the number of tones that levels divide: the steps, or with soft borders a multiple of them.
fn levels(toon: &Toon) -> u32 {
    if toon.softness > HARD { toon.steps * SOFT_LEVELS.div_ceil(toon.steps) } else { toon.steps }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_those_of_any_size() {
        assert_eq!(cell_counts([960, 540]), [120, 68]);
        assert_eq!(cell_counts([540, 960]), [68, 120]);
        assert_eq!(cell_counts([4000, 3000]), cell_counts([480, 360]));
        assert_eq!(cell_counts([1, 1]), [120, 120]);
        assert_eq!(cell_counts([8192, 1]), [120, 1]);
        assert!((1..9000).all(|side| cell_counts([side, side / 2])[0] == 120));
    }
}
