//! From a viewpoint to its [`Selection`]: the walk through the quadtree of patches, from its top.
//!
//! Why: `docs/decisions/level-of-detail.md`.

use glam::DVec2;

use super::grid_projection::GridProjection;
use super::patches::Patches;
use super::selection::{PatchKey, Selection, Viewpoint};
use super::walk::{Over, Walk};

/// Chooses the patches for a viewpoint, as many as it takes.
pub fn select(
    patches: &dyn Patches,
    grid_projection: &GridProjection,
    anchor: DVec2,
    viewpoint: &Viewpoint,
) -> Selection {
    select_within(patches, grid_projection, anchor, viewpoint, usize::MAX).unwrap_or_default()
}

/// Chooses the patches for a viewpoint; none if that takes more than `most_patches`, which is found without choosing
/// many more.
pub fn select_within(
    patches: &dyn Patches,
    grid_projection: &GridProjection,
    anchor: DVec2,
    viewpoint: &Viewpoint,
    most_patches: usize,
) -> Option<Selection> {
    let mut walk = Walk::new(patches, grid_projection, viewpoint, most_patches);
    let top = patches.strides() as i32 - 1;
    walk.visit(PatchKey { level: top, x: 0, y: 0 }, Over::NONE);
    walk.limit_steps();
    (!walk.is_over()).then(|| walk.finish(anchor))
}
