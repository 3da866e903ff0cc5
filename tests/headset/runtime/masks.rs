//! The parts of each eye's picture that are hidden by the lenses (`XR_KHR_visibility_mask`): its four corners.

use openxr_sys as xr;

use super::head::lens;
use super::state::{array, hold, status_of};

/// The part of each side that a corner takes, before and after the mask changes.
const PARTS: [f32; 2] = [0.25, 0.4];

pub(crate) unsafe extern "system" fn visibility_mask(
    session: xr::Session,
    views: xr::ViewConfigurationType,
    eye: u32,
    kind: xr::VisibilityMaskTypeKHR,
    out: *mut xr::VisibilityMaskKHR,
) -> xr::Result {
    const CALL: &str = "xrGetVisibilityMaskKHR";
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        state.session(CALL, session)?;
        state.check(CALL, (out.ty, out.next), xr::VisibilityMaskKHR::TYPE)?;
        if !state.enabled_masks {
            return Err(state.violation(CALL, "it is not enabled", xr::Result::ERROR_FUNCTION_UNSUPPORTED));
        }
        let is_known = views == xr::ViewConfigurationType::PRIMARY_STEREO
            && eye < 2
            && kind == xr::VisibilityMaskTypeKHR::HIDDEN_TRIANGLE_MESH;
        if !is_known {
            return Err(state.violation(CALL, "no such mask", xr::Result::ERROR_VALIDATION_FAILURE));
        }
        let part = PARTS[usize::from(state.script.change_mask.is_some_and(|frame| state.frames > frame))];
        let fov = lens(if eye == 0 { -1.0 } else { 1.0 });
        let [left, right, up, down] = [fov.angle_left, fov.angle_right, fov.angle_up, fov.angle_down].map(f32::tan);
        let (wide, high) = (part * (right - left), part * (up - down));
        let corners = [[left, up], [right, up], [right, down], [left, down]];
        let triangle = |[x, y]: [f32; 2]| {
            let inward = [if x == left { wide } else { -wide }, if y == up { -high } else { high }];
            [[x, y], [x + inward[0], y], [x, y + inward[1]]].map(|[x, y]| xr::Vector2f { x, y })
        };
        let vertices: Vec<_> = corners.into_iter().flat_map(triangle).collect();
        let indices: Vec<u32> = (0..vertices.len() as u32).collect();
        let both = [
            array(&vertices, out.vertex_capacity_input, &mut out.vertex_count_output, out.vertices),
            array(&indices, out.index_capacity_input, &mut out.index_count_output, out.indices),
        ];
        both.into_iter().find(|result| *result != xr::Result::SUCCESS).map_or(Ok(xr::Result::SUCCESS), Err)
    })())
}
