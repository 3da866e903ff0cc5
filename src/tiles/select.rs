//! From a viewpoint to its [`Selection`]: walks the quadtree of patches from its root.
//!
//! Why: `docs/decisions/level-of-detail.md`.

use glam::DVec2;

use super::grid_projection::GridProjection;
use super::patches::Patches;
use super::selection::{PatchKey, Selection, Viewpoint};
use super::walk::{ParentError, Walk};

/// Selects the patches for a viewpoint, as many as necessary.
pub fn select(
    patches: &dyn Patches,
    grid_projection: &GridProjection,
    anchor: DVec2,
    viewpoint: &Viewpoint,
) -> Selection {
    select_within(patches, grid_projection, anchor, viewpoint, usize::MAX).unwrap_or_default()
}

/// Selects the patches for a viewpoint. Returns `None` if that takes more than `max_patches`, which is detected
/// without selecting many more.
pub fn select_within(
    patches: &dyn Patches,
    grid_projection: &GridProjection,
    anchor: DVec2,
    viewpoint: &Viewpoint,
    max_patches: usize,
) -> Option<Selection> {
    let mut walk = Walk::new(patches, grid_projection, viewpoint, max_patches);
    let top = patches.strides() as i32 - 1;
    walk.visit(PatchKey { level: top, x: 0, y: 0 }, ParentError::NONE);
    walk.limit_steps();
    (!walk.has_exceeded_limit()).then(|| walk.finish(anchor))
}
