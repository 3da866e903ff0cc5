//! Checks submitted layers against the located views, and dumps copies of the images.

use openxr_sys as xr;
use xr::Handle as _;

use super::state::{Frame, State, time_of};

/// Returns whether a frame may end with these layers.
pub(crate) fn check_layers(
    state: &mut State,
    frame: Frame,
    is_held: bool,
    info: &xr::FrameEndInfo,
) -> Result<(), xr::Result> {
    const CALL: &str = "xrEndFrame";
    let mut wrong = |what: &str, error| Err(state.violation(CALL, what, error));
    if info.display_time.as_nanos() != time_of(frame.number) {
        return wrong("another display time than that of the frame", xr::Result::ERROR_TIME_INVALID);
    }
    if info.environment_blend_mode != xr::EnvironmentBlendMode::OPAQUE {
        return wrong("no such blend mode", xr::Result::ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED);
    }
    if is_held {
        return wrong("an image is still acquired", xr::Result::ERROR_CALL_ORDER_INVALID);
    }
    if info.layer_count > 0 && !frame.should_render {
        return wrong("layers, though nothing is to be rendered", xr::Result::ERROR_LAYER_INVALID);
    }
    for i in 0..info.layer_count as usize {
        let base = unsafe { *info.layers.add(i) };
        if unsafe { (*base).ty } == xr::CompositionLayerQuad::TYPE {
            let layer = unsafe { &*base.cast::<xr::CompositionLayerQuad>() };
            state.check(CALL, (layer.ty, layer.next), xr::CompositionLayerQuad::TYPE)?;
            check_quad(state, frame, layer)?;
        } else {
            let layer = unsafe { &*base.cast::<xr::CompositionLayerProjection>() };
            state.check(CALL, (layer.ty, layer.next), xr::CompositionLayerProjection::TYPE)?;
            check_projection(state, frame, layer)?;
        }
    }
    let is_located = state.session.as_ref().and_then(|session| session.located).is_some();
    if info.layer_count == 0 && frame.should_render && is_located {
        state.empty_frames += 1;
    }
    Ok(())
}

/// Checks which image a layer shows, and which part of it. Returns the handle of its swapchain.
fn check_image(state: &mut State, image: &xr::SwapchainSubImage) -> Result<u64, xr::Result> {
    const CALL: &str = "xrEndFrame";
    let handle = image.swapchain.into_raw();
    let Some(chain) = state.session.as_ref().and_then(|session| session.chains.get(&handle)) else {
        return Err(state.violation(CALL, "no such swapchain", xr::Result::ERROR_HANDLE_INVALID));
    };
    if !chain.was_released {
        return Err(state.violation(CALL, "an image that was never released", xr::Result::ERROR_LAYER_INVALID));
    }
    let (rect, size_px) = (image.image_rect, chain.size_px.map(|side| side as i32));
    let is_inside = rect.offset.x >= 0
        && rect.offset.y >= 0
        && rect.extent.width > 0
        && rect.extent.height > 0
        && rect.offset.x + rect.extent.width <= size_px[0]
        && rect.offset.y + rect.extent.height <= size_px[1]
        && image.image_array_index == 0;
    if !is_inside {
        return Err(state.violation(CALL, "a part beyond the image", xr::Result::ERROR_SWAPCHAIN_RECT_INVALID));
    }
    Ok(handle)
}

fn check_quad(state: &mut State, frame: Frame, layer: &xr::CompositionLayerQuad) -> Result<(), xr::Result> {
    const CALL: &str = "xrEndFrame";
    let mut wrong = |what: &str, error| Err(state.violation(CALL, what, error));
    let (q, p) = (layer.pose.orientation, layer.pose.position);
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    if !(0.99..1.01).contains(&length) || ![p.x, p.y, p.z].into_iter().all(f32::is_finite) {
        return wrong("a quad without a pose", xr::Result::ERROR_POSE_INVALID);
    }
    let is_size = |side: f32| side.is_finite() && side > 0.0;
    if !is_size(layer.size.width) || !is_size(layer.size.height) {
        return wrong("a quad without a size", xr::Result::ERROR_VALIDATION_FAILURE);
    }
    if !(0..=2).contains(&layer.eye_visibility.into_raw()) {
        return wrong("a quad for no such eyes", xr::Result::ERROR_VALIDATION_FAILURE);
    }
    let space = state.session.as_ref().and_then(|session| session.spaces.get(&layer.space.into_raw())).copied();
    let Some(space) = space else {
        return Err(state.violation(CALL, "a quad in no such space", xr::Result::ERROR_HANDLE_INVALID));
    };
    let handle = check_image(state, &layer.sub_image)?;
    dump_quad(state, frame, layer, space, handle);
    Ok(())
}

/// Dumps the image of a quad if it is new, and a row for each frame with a quad: frame of the runtime, frame of the
/// script, pose, size, space, and the name of the image's file.
fn dump_quad(
    state: &mut State,
    frame: Frame,
    layer: &xr::CompositionLayerQuad,
    space: xr::ReferenceSpaceType,
    handle: u64,
) {
    use std::io::Write as _;
    let (script_frame, Some(folder)) = (state.frames, state.script.dump.clone()) else { return };
    let Some(chain) = state.session.as_mut().and_then(|session| session.chains.get_mut(&handle)) else { return };
    if std::mem::replace(&mut chain.is_new, false) {
        let [width, height] = chain.size_px;
        chain.file = format!("panel-{:06}-{width}x{height}.raw", frame.number);
        std::fs::write(folder.join(&chain.file), &chain.bytes).unwrap();
    }
    let table = std::fs::OpenOptions::new().create(true).append(true).open(folder.join("quads.csv"));
    let (q, p, size) = (layer.pose.orientation, layer.pose.position, layer.size);
    let numbers = [p.x, p.y, p.z, q.x, q.y, q.z, q.w, size.width, size.height];
    let numbers = numbers.map(|number| number.to_string()).join(",");
    writeln!(table.unwrap(), "{},{script_frame},{numbers},{space:?},{}", frame.number, chain.file).unwrap();
}

fn check_projection(state: &mut State, frame: Frame, layer: &xr::CompositionLayerProjection) -> Result<(), xr::Result> {
    const CALL: &str = "xrEndFrame";
    let located = state.session.as_ref().and_then(|session| session.located);
    let Some((_, _, views)) =
        located.filter(|(time, space, _)| *time == time_of(frame.number) && *space == layer.space.into_raw())
    else {
        let error = xr::Result::ERROR_LAYER_INVALID;
        return Err(state.violation(CALL, "the views were not located for this time and space", error));
    };
    if layer.view_count != 2 {
        return Err(state.violation(CALL, "not two views", xr::Result::ERROR_LAYER_INVALID));
    }
    let mut handles = [0; 2];
    for (eye, handle) in handles.iter_mut().enumerate() {
        let view = unsafe { *layer.views.add(eye) };
        state.check(CALL, (view.ty, view.next), xr::CompositionLayerProjectionView::TYPE)?;
        *handle = check_image(state, &view.sub_image)?;
    }
    // If no image is new, the layers show the previous images, from the views for which those were drawn.
    let session = state.session.as_mut().ok_or(xr::Result::ERROR_HANDLE_INVALID)?;
    let mut is_new = false;
    for handle in handles {
        is_new |= session.chains.get_mut(&handle).is_some_and(|chain| std::mem::replace(&mut chain.is_new, false));
    }
    let views = if is_new { views } else { session.shown.unwrap_or(views) };
    session.shown = Some(views);
    let mut bytes = Vec::new();
    for (eye, (located, handle)) in views.iter().zip(handles).enumerate() {
        let view = unsafe { *layer.views.add(eye) };
        if view.pose != located.pose || view.fov != located.fov {
            let what = format!("eye {eye} has another pose or lens than was located");
            return Err(state.violation(CALL, &what, xr::Result::ERROR_LAYER_INVALID));
        }
        let chain = state.session.as_ref().and_then(|session| session.chains.get(&handle));
        bytes.extend(chain.map(|chain| (chain.number, chain.size_px, chain.bytes.clone())));
    }
    dump(state, &views, &bytes);
    Ok(())
}

/// Dumps the images as they are, and a row for each eye: frame, eye, position, orientation, angles of the lens.
fn dump(state: &State, views: &[xr::View; 2], shown: &[(usize, [u32; 2], Vec<u8>)]) {
    use std::io::Write as _;
    let Some(folder) = &state.script.dump else { return };
    let table = std::fs::OpenOptions::new().create(true).append(true).open(folder.join("poses.csv"));
    let mut table = table.unwrap();
    for (eye, (view, (_, [width, height], bytes))) in views.iter().zip(shown).enumerate() {
        let name = format!("{:05}-{eye}-{width}x{height}.raw", state.frames);
        std::fs::write(folder.join(name), bytes).unwrap();
        let (p, q, fov) = (view.pose.position, view.pose.orientation, view.fov);
        let numbers =
            [p.x, p.y, p.z, q.x, q.y, q.z, q.w, fov.angle_left, fov.angle_right, fov.angle_up, fov.angle_down];
        let numbers = numbers.map(|number| number.to_string()).join(",");
        writeln!(table, "{},{eye},{numbers}", state.frames).unwrap();
    }
}
