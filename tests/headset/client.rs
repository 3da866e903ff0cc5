//! Runs a small program that does what the specification forbids; the runtime and the validation layer must detect it.
//!
//! The runtime is a part of the process that uses it, so each mistake is made in its own process: this test executable,
//! run again with [`client`].
//! again for [`client`].

use hachure::headset::Runtime;
use hachure::internals::{Headset, SessionPhase, VIEWS};
use openxr as xr;

use crate::common::full;
use crate::{Room, Run};

const MISTAKE: &str = "HACHURE_TEST_MISTAKE";

fn made(room: &Room, mistake: &str) -> Run {
    let mut command = room.command(&std::env::current_exe().unwrap(), &[]);
    command.args(["client::client", "--exact", "--ignored", "--nocapture", "--test-threads=1"]).env(MISTAKE, mistake);
    room.run(command)
}

#[test]
fn mistakes_are_noticed() {
    let Some(room) = Room::new() else { return };
    let right = made(&room, "none");
    assert!(right.log.contains(" with 0 violations"), "{}{}", right.log, right.stderr);
    assert!(right.layer.is_none_or(|messages| messages.is_empty()));
    for (mistake, words) in [
        ("begin before wait", "xrBeginFrame: no frame was waited for"),
        ("begin twice", "xrBeginFrame: the frame before was not ended"),
        ("end without begin", "xrEndFrame: no frame was begun"),
        ("another time", "xrEndFrame: another display time"),
        ("image held", "xrEndFrame: an image is still acquired"),
        ("image not acquired", "xrWaitSwapchainImage: nothing to wait for"),
        ("image never drawn", "xrEndFrame: an image that was never released"),
        ("eyes exchanged", "eye 0 has another pose or lens"),
        ("views of another frame", "the views were not located for this time"),
        ("beyond the image", "a part beyond the image"),
        ("quad without a pose", "a quad without a pose"),
        ("quad without a size", "a quad without a size"),
        ("quad beyond its image", "a part beyond the image"),
        ("quad never drawn", "xrEndFrame: an image that was never released"),
        ("session begun twice", "xrBeginSession: it runs already"),
        ("session ended early", "xrEndSession: it is not stopping"),
    ]
    .into_iter()
    .step_by(if full() { 1 } else { 3 })
    {
        let run = made(&room, mistake);
        assert!(run.log.contains(words), "{mistake}: {}{}", run.log, run.stderr);
    }
    match made(&room, "wrong layout").layer {
        Some(messages) => {
            assert!(
                messages.iter().any(|message| message.contains("layout")),
                "the validation layer did not report a layout: {messages:?}"
            );
        }
        None => println!("skipped: the Khronos validation layer is not installed (vulkan-validationlayers)"),
    }
}

/// Makes one mistake; the other test of this file starts it in its own process.
#[test]
#[ignore = "a part of another test"]
fn client() {
    let Ok(mistake) = std::env::var(MISTAKE) else { return };
    let mut headset = Headset::open(Runtime::connect().unwrap()).unwrap();
    while headset.follow_events().unwrap() != SessionPhase::Running {}
    if mistake == "begin before wait" {
        assert!(headset.stream.begin().is_err());
    }
    // Waits for a frame that should be rendered.
    let state = loop {
        let state = headset.waiter.wait().unwrap();
        headset.stream.begin().unwrap();
        headset.follow_events().unwrap();
        if state.should_render {
            break state;
        }
        headset.stream.end(state.predicted_display_time, headset.blend, &[]).unwrap();
    };
    let time = state.predicted_display_time;
    let located = |headset: &Headset| headset.session.locate_views(VIEWS, time, &headset.space).unwrap().1;
    match mistake.as_str() {
        "begin twice" => {
            headset.waiter.wait().unwrap();
            headset.stream.begin().unwrap();
        }
        "end without begin" => {
            headset.stream.end(time, headset.blend, &[]).unwrap();
            headset.stream.end(time, headset.blend, &[]).unwrap_err();
        }
        "another time" => {
            let other = xr::Time::from_nanos(time.as_nanos() + 1);
            headset.stream.end(other, headset.blend, &[]).unwrap_err();
        }
        "image held" => {
            headset.eyes[0].acquire().unwrap();
            headset.stream.end(time, headset.blend, &[]).unwrap_err();
        }
        "image not acquired" => drop(headset.eyes[0].swapchain.wait_image(xr::Duration::INFINITE).unwrap_err()),
        "session begun twice" => drop(headset.session.begin(VIEWS).unwrap_err()),
        "session ended early" => drop(headset.session.end().unwrap_err()),
        "image never drawn" => drop(shown(&mut headset, time, |headset| located(headset)).unwrap_err()),
        "eyes exchanged" => {
            drawn(&mut headset, wgpu::TextureUses::COLOR_TARGET);
            let exchanged = |headset: &mut Headset| located(headset).into_iter().rev().collect();
            shown(&mut headset, time, exchanged).unwrap_err();
        }
        "views of another frame" => {
            drawn(&mut headset, wgpu::TextureUses::COLOR_TARGET);
            let later = xr::Time::from_nanos(time.as_nanos() + 11_111_111);
            let views = |headset: &mut Headset| headset.session.locate_views(VIEWS, later, &headset.space).unwrap().1;
            shown(&mut headset, time, views).unwrap_err();
        }
        "beyond the image" => {
            drawn(&mut headset, wgpu::TextureUses::COLOR_TARGET);
            let views = located(&headset);
            end(&mut headset, time, &views, 1).unwrap_err();
        }
        "quad without a pose" | "quad without a size" | "quad beyond its image" => {
            drawn(&mut headset, wgpu::TextureUses::COLOR_TARGET);
            with_quad(&mut headset, time, &mistake).unwrap_err();
        }
        "quad never drawn" => drop(with_quad(&mut headset, time, &mistake).unwrap_err()),
        "wrong layout" => drawn(&mut headset, wgpu::TextureUses::PRESENT),
        _ => {
            drawn(&mut headset, wgpu::TextureUses::COLOR_TARGET);
            shown(&mut headset, time, |headset| located(headset)).unwrap();
            let state = headset.waiter.wait().unwrap();
            headset.stream.begin().unwrap();
            with_quad(&mut headset, state.predicted_display_time, &mistake).unwrap();
        }
    }
}

/// Clears an image of each eye, and releases it in the given state.
fn drawn(headset: &mut Headset, state: wgpu::TextureUses) {
    let gpu = headset.gpu.clone();
    for eye in &mut headset.eyes {
        let index = eye.acquire().unwrap();
        let (texture, view) = eye.image(index).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::RED), store: wgpu::StoreOp::Store };
        let attachment = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
        drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..Default::default()
        }));
        let transition = wgpu::TextureTransition { texture, selector: None, state };
        encoder.transition_resources(std::iter::empty(), std::iter::once(transition));
        gpu.queue.submit([encoder.finish()]);
        eye.release().unwrap();
    }
}

fn shown(headset: &mut Headset, time: xr::Time, views: impl FnOnce(&mut Headset) -> Vec<xr::View>) -> xr::Result<()> {
    let views = views(headset);
    end(headset, time, &views, 0)
}

/// Ends a frame with a part of the images that begins `aside_px` pixels to the right.
fn end(headset: &mut Headset, time: xr::Time, views: &[xr::View], aside_px: i32) -> xr::Result<()> {
    let projections = [0, 1].map(|eye: usize| {
        let [width, height] = headset.eyes[eye].size_px().map(|side| side as i32);
        let rect = xr::Rect2Di { offset: xr::Offset2Di { x: aside_px, y: 0 }, extent: xr::Extent2Di { width, height } };
        let image = xr::SwapchainSubImage::new().swapchain(&headset.eyes[eye].swapchain).image_rect(rect);
        xr::CompositionLayerProjectionView::new().pose(views[eye].pose).fov(views[eye].fov).sub_image(image)
    });
    let layer = xr::CompositionLayerProjection::new().space(&headset.space).views(&projections);
    headset.stream.end(time, headset.blend, &[&layer])
}

/// Ends a frame with a quad that shows the left eye's image, and makes a mistake.
fn with_quad(headset: &mut Headset, time: xr::Time, mistake: &str) -> xr::Result<()> {
    let [width, height] = headset.eyes[0].size_px().map(|side| side as i32);
    let x = if mistake == "quad beyond its image" { 1 } else { 0 };
    let rect = xr::Rect2Di { offset: xr::Offset2Di { x, y: 0 }, extent: xr::Extent2Di { width, height } };
    let image = xr::SwapchainSubImage::new().swapchain(&headset.eyes[0].swapchain).image_rect(rect);
    let mut pose = xr::Posef::IDENTITY;
    if mistake == "quad without a pose" {
        pose.orientation.w = 0.0;
    }
    let size = xr::Extent2Df { width: 1.0, height: if mistake == "quad without a size" { 0.0 } else { 1.0 } };
    let quad = xr::CompositionLayerQuad::new().space(&headset.space).sub_image(image).pose(pose).size(size);
    headset.stream.end(time, headset.blend, &[&quad])
}
