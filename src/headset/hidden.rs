//! The part of the pictures that the lenses hide, if the runtime reports it (`XR_KHR_visibility_mask`).

use openxr as xr;

use super::error::{During, HeadsetError};
use super::session::VIEWS;
use super::stage::Eye;
use crate::scene::view::Lens;
use crate::surface::hidden::HiddenArea;

/// The hidden area is drawn this much smaller, scaled about the middle of the picture: line detectors look at
/// neighbouring pixels, and would outline the area's edge.
const MARGIN_PX: f64 = 4.0;

/// Corners of the triangles of each eye, three per triangle: tangents of the angles from the eye's axis, x right, y up.
pub(super) type Triangles = [Vec<[f64; 2]>; 2];

/// Queries the hidden triangles from the runtime.
///
/// # Errors
/// Returns the error of the runtime.
pub(super) fn query(session: &xr::Session<xr::Vulkan>) -> Result<Triangles, HeadsetError> {
    let of = |eye: u32| {
        let kind = xr::VisibilityMaskTypeKHR::HIDDEN_TRIANGLE_MESH;
        let mask = session.get_visibility_mask_khr(VIEWS, eye, kind).during("xrGetVisibilityMaskKHR")?;
        let corner = |index: &u32| {
            let at = mask.vertices.get(*index as usize)?;
            Some([f64::from(at.x), f64::from(at.y)]).filter(|at| at.iter().all(|tangent| tangent.is_finite()))
        };
        // Triangles with missing corners are skipped.
        let triangles = mask.indices.chunks_exact(3).filter_map(|of| of.iter().map(corner).collect::<Option<Vec<_>>>());
        Ok::<_, HeadsetError>(triangles.flatten().collect())
    };
    Ok([of(0)?, of(1)?])
}

/// Converts the triangles to areas of both eyes' pictures.
pub(super) fn areas(triangles: &Triangles, eyes: &[Eye; 2], sizes_px: [[u32; 2]; 2]) -> Vec<HiddenArea> {
    let area = |eye: usize| {
        let Lens { left, right, up, down } = eyes[eye].lens;
        let grown = sizes_px[eye].map(|side| 1.0 + 2.0 * MARGIN_PX / f64::from(side));
        let place = |[x, y]: &[f64; 2]| {
            let x = (2.0 * x - right + left) / (right + left) * grown[0];
            let y = (2.0 * y - up + down) / (up + down) * grown[1];
            [x as f32, y as f32]
        };
        HiddenArea { corners: triangles[eye].iter().map(place).collect() }
    };
    vec![area(0), area(1)]
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;

    #[test]
    fn the_edges_of_the_lens_are_those_of_the_picture() {
        let lens = Lens { left: 1.2, right: 0.8, up: 0.9, down: 1.1 };
        let eye = Eye { at_m: DVec3::ZERO, room_from_eye: DQuat::IDENTITY, lens };
        let corners = vec![[-1.2, 0.9], [0.8, 0.9], [0.8, -1.1]];
        let areas = areas(&[corners, Vec::new()], &[eye, eye], [[100, 200], [100, 200]]);
        let [x, y] = [1.08, 1.04];
        let expected = [[-x, y], [x, y], [x, -y]];
        for (found, expected) in areas[0].corners.iter().zip(expected) {
            assert!((0..2).all(|i| (f64::from(found[i]) - expected[i]).abs() < 1e-6), "{found:?} {expected:?}");
        }
        assert!(areas[0].corners.len() == 3 && areas[1].corners.is_empty());
    }
}
