//! The panel in the room: a quad layer of OpenXR with a swapchain of its own.

use glam::{DQuat, DVec3};
use openxr as xr;

use super::error::HeadsetError;
use super::panel::{DISTANCE_M, Page, SIZE_M, SIZE_PX};
use super::show::ShowPass;
use super::stage::{Eye, middle_m};
use super::swapchains::SwapchainImages;
use crate::gpu::Gpu;
use crate::gpu::target::{Group, Target, TargetKind};

/// Height of the eyes above the middle of the panel: people look slightly down.
const BELOW_EYES_M: f64 = 0.15;
const PANEL: TargetKind = TargetKind {
    name: "panel of the headset",
    content: Group::Whole.shows("The panel inside the headset"),
    format: wgpu::TextureFormat::Rgba8UnormSrgb,
    usage: wgpu::TextureUsages::COPY_DST,
};

/// The panel. It is fixed in the room, not to the head, until it is placed again.
pub(super) struct Quad {
    images: SwapchainImages,
    show: ShowPass,
    picture: Target,
    gpu: Gpu,
    /// The page on the last image.
    page: Option<Page>,
    pose: Option<xr::Posef>,
}

impl Quad {
    /// Creates a panel that shows nothing.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn new(gpu: &Gpu, session: &xr::Session<xr::Vulkan>) -> Result<Self, HeadsetError> {
        Ok(Self {
            images: SwapchainImages::new(gpu, session, SIZE_PX)?,
            show: ShowPass::new(gpu),
            picture: Target::new(gpu, &PANEL, SIZE_PX),
            gpu: gpu.clone(),
            page: None,
            pose: None,
        })
    }

    /// Returns whether the panel has a place in the room.
    pub(super) fn is_placed(&self) -> bool {
        self.pose.is_some()
    }

    /// Puts the panel in front of the eyes, upright. `floor_m` is the height of the floor in the space of the poses.
    pub(super) fn place(&mut self, eyes: &[Eye; 2], floor_m: f64) {
        self.pose = Some(pose(eyes, floor_m));
    }

    /// Draws a page, unless the last image shows it already.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn draw(&mut self, page: Page) -> Result<(), HeadsetError> {
        if self.page.as_ref() == Some(&page) {
            return Ok(());
        }
        let gpu = &self.gpu;
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE_PX[0]), rows_per_image: None };
        gpu.queue.write_texture(
            self.picture.texture.as_image_copy(),
            &page.pixels(),
            layout,
            self.picture.texture.size(),
        );
        let index = self.images.acquire()?;
        let label = Some("panel of the headset");
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
        if let Some((texture, view)) = self.images.image(index) {
            self.show.copy(gpu, &mut encoder, &self.picture, (view, self.images.format()));
            let state = wgpu::TextureUses::COLOR_TARGET;
            let as_attachment = wgpu::TextureTransition { texture, selector: None, state };
            encoder.transition_resources(std::iter::empty(), std::iter::once(as_attachment));
        }
        self.show.flush(gpu);
        gpu.queue.submit([encoder.finish()]);
        self.images.release()?;
        self.page = Some(page);
        Ok(())
    }

    /// Returns the layer, if the panel has been placed and drawn.
    pub(super) fn layer<'a>(&'a self, space: &'a xr::Space) -> Option<xr::CompositionLayerQuad<'a, xr::Vulkan>> {
        let (pose, _) = (self.pose?, self.page.as_ref()?);
        let extent = self.images.size_px().map(|side| side as i32);
        let image = xr::SwapchainSubImage::new().swapchain(&self.images.swapchain).image_rect(xr::Rect2Di {
            offset: xr::Offset2Di { x: 0, y: 0 },
            extent: xr::Extent2Di { width: extent[0], height: extent[1] },
        });
        let size = xr::Extent2Df { width: SIZE_M[0], height: SIZE_M[1] };
        let layer = xr::CompositionLayerQuad::new().space(space).eye_visibility(xr::EyeVisibility::BOTH);
        Some(layer.sub_image(image).pose(pose).size(size))
    }
}

impl Drop for Quad {
    fn drop(&mut self) {
        // The GPU must not draw on images that are about to be dropped.
        self.gpu.wait();
    }
}

/// Returns the pose of a panel in front of the eyes: at their height, upright, and facing them.
fn pose(eyes: &[Eye; 2], floor_m: f64) -> xr::Posef {
    let head = eyes[0].room_from_eye;
    let level = |direction: DVec3| DVec3::new(direction.x, 0.0, direction.z);
    let (ahead, up) = (level(head * DVec3::NEG_Z), level(head * DVec3::Y));
    // Who looks straight down or up has the top of the head, or the chin, in front.
    let looks_down = (head * DVec3::NEG_Z).y < 0.0;
    let ahead = if ahead.length() > 0.2 {
        ahead
    } else if looks_down {
        up
    } else {
        -up
    };
    let ahead = ahead.try_normalize().unwrap_or(DVec3::NEG_Z);
    let at_m = middle_m(eyes) + ahead * DISTANCE_M - DVec3::Y * (BELOW_EYES_M - floor_m);
    let turn = DQuat::from_rotation_y((-ahead.x).atan2(-ahead.z));
    xr::Posef {
        orientation: xr::Quaternionf { x: turn.x as f32, y: turn.y as f32, z: turn.z as f32, w: turn.w as f32 },
        position: xr::Vector3f { x: at_m.x as f32, y: at_m.y as f32, z: at_m.z as f32 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::view::Lens;

    #[test]
    fn the_panel_is_upright_ahead_and_faces_the_eyes() {
        let lens = Lens { left: 1.0, right: 1.0, up: 1.0, down: 1.0 };
        let down = 1.5;
        for (yaw, pitch, roll) in
            [(0.0, 0.0, 0.0), (1.0, 0.3, 0.2), (-2.5, -0.4, 0.0), (0.7, -down, 0.0), (0.7, down, 0.0)]
        {
            let head = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch) * DQuat::from_rotation_z(roll);
            let at_m = DVec3::new(0.3, 1.6, -0.4);
            let eyes = [Eye { at_m, room_from_eye: head, lens }; 2];
            let xr::Posef { orientation: q, position: p } = pose(&eyes, -1.6);
            let turn = DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into());
            let off_m = DVec3::new(p.x.into(), p.y.into(), p.z.into()) - at_m - DVec3::Y * -1.6;
            // Its front looks back to the eyes, and its upper edge is up.
            let front = turn * DVec3::Z;
            assert!((front * DISTANCE_M + off_m + DVec3::Y * BELOW_EYES_M).length() < 1e-5, "{yaw} {pitch}: {off_m}");
            assert!((turn * DVec3::Y).distance(DVec3::Y) < 1e-6);
            // It is in the direction of the head's heading.
            let heading = DVec3::new(-f64::sin(yaw), 0.0, -f64::cos(yaw));
            assert!(heading.dot(-front) > 0.999, "{yaw} {pitch}: {front}");
        }
    }
}
