//! Finds the nearest shore in the column of each sample: the first half of a distance transform. See
//! `shaders/surface/lakes/columns.wgsl`.

use super::{COLUMNS_OFFSET, Inputs};
use crate::gpu::recorder::Recorder;

/// Searches the columns of the tiles that have water, which `found` lists. Adds to each sample in `shores` how many
/// rows away the nearest shore of its column is.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [("found", inputs.found.binding()), ("shores", inputs.shores.binding())];
    recorder.indirect("surface/lakes/columns", &inputs.arguments, COLUMNS_OFFSET, &resources);
}
