//! From a viewpoint to its [`Selection`]: walks the quadtree of patches from its root.
//!
//! Why: `docs/decisions/level-of-detail.md`.

use glam::DVec2;

use super::grid_projection::GridProjection;
use super::patch_tree::PatchTree;
use super::patches::Patches;
use super::selection::{Selection, Viewpoint};
use super::skyline::Skyline;
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
    let selected =
        select_in(&mut PatchTree::default(), patches, grid_projection, anchor, viewpoint, max_patches, false);
    selected.map(|(selection, _)| selection)
}

/// Selects like [`select_within`], with the quadtree of earlier selections from the same patches. Also returns the
/// skyline of the selected patches, which is layered on request.
pub(crate) fn select_in(
    tree: &mut PatchTree,
    patches: &dyn Patches,
    grid_projection: &GridProjection,
    anchor: DVec2,
    viewpoint: &Viewpoint,
    max_patches: usize,
    is_layered: bool,
) -> Option<(Selection, Skyline)> {
    let (mut walk, root) = Walk::new(tree, patches, grid_projection, viewpoint, max_patches, is_layered);
    walk.visit(root, ParentError::NONE);
    walk.limit_steps();
    (!walk.has_exceeded_limit()).then(|| walk.finish(anchor))
}
