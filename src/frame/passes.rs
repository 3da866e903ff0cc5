//! The passes of a frame, in the order in which they run.
//!
//! First, for each eye, the surface, its lines and its strokes ([`see`]). Then the lines of all eyes are finished, and
//! those of a stereo pair are compared ([`finish_lines`]). Then, for each eye, tones and marks ([`shade`]) and the
//! picture ([`finish`]). All eyes share the lists of edges and strokes, so the lists of an eye are used before those of
//! the next eye overwrite them.

use super::bend::{self, Bends};
use super::inks::{self, Pictures};
use super::lines as frame_lines;
use super::shade::{Shaded, shade};
use super::trees::{self as frame_trees, SeenTrees};
use super::{EyeMemory, FrameInputs, land_maps, water as frame_water};
use crate::composite::sky::{self, SKY};
use crate::composite::{self, temporal_aa};
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::lines::crowd::{self, Cap};
use crate::lines::smooth;
use crate::lines::stereo::{agree, fade_out};
use crate::lines::strokes::history::Step;
use crate::lines::strokes::partner::{Partner, SeenSurface};
use crate::lines::strokes::{self, FrameStrokes};
use crate::style::{Layer, Lines, Stereo};
use crate::surface::edges::EdgeList;
use crate::surface::meshes::DrawnMeshes;
use crate::surface::{self, land, meshes, motion, trees};
use crate::tones::balance;

/// The surface that an eye sees, with its lines and strokes.
pub(super) struct Seen {
    pub(super) view: Resource,
    /// The view without jitter, for strokes: they compute exactly how much of each pixel they cover.
    pub(super) still_view: Resource,
    /// Surface ids, or a placeholder of one texel if they are not needed and all is land.
    pub(super) surface_id: Target,
    pub(super) distance: Target,
    pub(super) normal: Target,
    /// Own colours of trees and models, in a style that needs them.
    pub(super) local_color: Option<Target>,
    /// Share of sunlight that trees block, in a style with shadows.
    pub(super) tree_shadow: Option<Target>,
    /// Rounded forms of trees, in a world with a forest.
    pub(super) tree_form: Option<Target>,
    /// Distance to the shore, in a style with water.
    pub(super) water: Option<Target>,
    /// The pictures that the style's marks and light derive from the curvature.
    pub(super) bends: Bends,
    /// The rims of holes, if the land in view has holes.
    rim: Option<Target>,
    /// The detected lines. [`finish_lines`] replaces them with the finished ones.
    pub(super) line: Option<Target>,
    strokes: Option<SeenStrokes>,
    /// Whether trees that wind moves may be in view.
    pub(super) may_sway: bool,
}

/// The strokes of an eye.
struct SeenStrokes {
    frame: FrameStrokes,
    ink: Target,
    /// The strokes for comparison with those of the other eye of a stereo pair; `None` if they were not rebuilt.
    drawn: Option<Partner>,
}

/// Runs all passes of all eyes. Returns whether trees that wind moves may be in view.
pub(super) fn render_eyes(recorder: &mut Recorder<'_>, inputs: &FrameInputs<'_>, eyes: &mut [EyeMemory]) -> bool {
    // The left eye leads, and the other one adopts its strokes, in whatever order the rig lists the eyes: so eyes that
    // are exchanged exchange their pictures.
    let mut order: Vec<usize> = (0..eyes.len()).collect();
    order.sort_by(|a, b| inputs.rig.aside_m(*a).total_cmp(&inputs.rig.aside_m(*b)));
    let mut seen: Vec<Option<Seen>> = (0..eyes.len()).map(|_| None).collect();
    for (turn, &eye) in order.iter().enumerate() {
        let leader = seen[order[0]].as_ref().filter(|_| inputs.rig.is_pair());
        seen[eye] = Some(see(recorder, inputs, eye, turn == 0, leader, &mut eyes[eye]));
    }
    let mut seen: Vec<Seen> = seen.into_iter().flatten().collect();
    if let (true, [leader, follower]) = (inputs.rig.is_pair(), order.as_slice()) {
        let follower = seen[*follower].strokes.as_ref().and_then(|strokes| strokes.drawn.as_ref());
        if let Some((strokes, follower)) = seen[*leader].strokes.as_ref().zip(follower) {
            strokes.frame.draw_agreed(recorder, &seen[*leader].still_view, &mut eyes[*leader].targets, follower);
        }
    }
    if inputs.only_strokes {
        return seen.iter().any(|seen| seen.may_sway);
    }
    if let Some(lines) = inputs.lines {
        finish_lines(recorder, inputs, lines, &mut seen, eyes);
    }
    let mut shaded: Vec<Option<Shaded>> = (0..eyes.len()).map(|_| None).collect();
    for (turn, &eye) in order.iter().enumerate() {
        shaded[eye] = Some(shade(recorder, inputs, &seen[eye], turn == 0, &mut eyes[eye]));
    }
    let shaded: Vec<Shaded> = shaded.into_iter().flatten().collect();
    for (eye, memory) in eyes.iter_mut().enumerate() {
        finish(recorder, inputs, &seen, &shaded, eye, memory);
    }
    seen.iter().any(|seen| seen.may_sway)
}

/// Draws the surface, lines and strokes of an eye. The first eye also computes what all eyes share: the vertices,
/// unless they need several batches, and the maps of the land. The second eye of a stereo pair adopts the strokes of
/// its leader.
fn see(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    eye: usize,
    is_first: bool,
    leader: Option<&Seen>,
    memory: &mut EyeMemory,
) -> Seen {
    let &FrameInputs { world, mesh, rig, style, light, .. } = inputs;
    let terrain = &world.terrain;
    let gpu = recorder.gpu();
    let view_of_eye = &rig.eyes[eye];
    let view = recorder.uniform("view", &view_of_eye.uniform(rig.origin_m));
    let still_view = recorder.uniform("view", &view_of_eye.still_uniform(rig.origin_m));
    let heights = &terrain.resources();
    let EyeMemory { targets, strokes: stroke_memory, .. } = memory;

    let strokes = style.strokes().zip(stroke_memory.as_mut()).map(|(strokes, memory)| {
        let nearest_m = world.nearest_m(rig.origin_m);
        let FrameInputs { step_s, stroke_pause_s: pause_s, land_changes, .. } = *inputs;
        let step = Step { step_s, pause_s, nearest_m, origin_m: rig.origin_m, land_changes };
        let leader = leader.and_then(|leader| Some(&leader.strokes.as_ref()?.frame));
        FrameStrokes::begin(recorder, memory, strokes, view_of_eye, light, step, leader)
    });
    let edges = strokes.as_ref().and_then(FrameStrokes::wants_edges).map(|rules| EdgeList::begin(recorder, rules));
    let edges = edges.as_ref();

    // The surface: compute vertices, rasterise depth and id, and resolve the rest.
    let depth = &targets.whole(gpu, &surface::DEPTH);
    // A world that is only land needs no ids.
    let has_ids = inputs.wants_ids || world.has_local_colors();
    let surface_id = &if has_ids { targets.whole(gpu, &surface::SURFACE_ID) } else { surface::id::only_land(recorder) };
    let drawn_id = has_ids.then_some(surface_id);
    let hidden = inputs.hidden.get(eye).filter(|area| !area.corners.is_empty());
    if let Some(area) = hidden {
        surface::hidden::run(recorder, area, depth, drawn_id);
    }
    for &batch in &mesh.batches {
        let clears = batch[0] == 0 && hidden.is_none();
        if is_first || mesh.batches.len() > 1 {
            mesh.place(recorder, batch, heights);
        }
        let (view, terrain, surface_id) = (&view, heights, drawn_id);
        let raster = land::raster::Inputs { view, terrain, mesh, batch, clears, depth, surface_id };
        land::raster::run(recorder, &raster);
        if let Some(edges) = edges {
            land::edges::run(recorder, edges, &land::edges::Inputs { view, terrain, mesh, batch });
        }
    }
    // The models on the land, in the same steps.
    let meshes = world.meshes().map(|placed| {
        let meshes = DrawnMeshes::of(recorder, placed);
        meshes::cull::run(recorder, &view, rig, terrain.uniform(), &meshes);
        meshes::vertices::run(recorder, &meshes, terrain.uniform());
        meshes::raster::run(recorder, &meshes::raster::Inputs { view: &view, meshes: &meshes, depth, surface_id });
        if let Some(edges) = edges {
            meshes::edges::run(recorder, edges, &view, &meshes);
        }
        meshes
    });
    let local_color = world.has_local_colors() && style.needs_local_colors();
    let local_color = local_color.then(|| targets.whole(gpu, &surface::local_color::LOCAL_COLOR));
    let local_color = local_color.as_ref();
    let at_eye = frame_trees::EyeInputs { view: &view, view_of_eye, depth, surface_id, local_color };
    let trees = frame_trees::see(recorder, inputs, &at_eye, edges, targets);
    // Bare land is equally light everywhere.
    let normal = if world.has_local_colors() { &surface::NORMAL_AND_LIGHTNESS } else { &surface::NORMAL };
    let (distance, normal) = (targets.whole(gpu, &surface::DISTANCE), targets.whole(gpu, normal));
    let resolved = land::resolve::Inputs { view: &view, terrain: heights, depth, distance: &distance, normal: &normal };
    land::resolve::run(recorder, &resolved);
    if let Some(meshes) = &meshes {
        let (distance, normal) = (&distance, &normal);
        let over = meshes::resolve::Inputs { view: &view, meshes, surface_id, depth, distance, normal, local_color };
        meshes::resolve::run(recorder, &over);
    }
    let tree_shadow = trees.as_ref().and_then(|trees| {
        let (distance, normal) = (&distance, &normal);
        let tree_normal = &trees.normal;
        let resolved = trees::resolve::Inputs { view: &view, surface_id, depth, tree_normal, distance, normal };
        trees::resolve::run(recorder, &resolved);
        frame_trees::shadow(recorder, inputs, &at_eye, trees, distance, targets)
    });
    if inputs.wants_motion || inputs.temporal_aa.is_some() {
        let motion = &targets.whole(gpu, &motion::MOTION);
        let tree_step = trees.as_ref().and_then(SeenTrees::step);
        motion::run(recorder, &motion::Inputs { view: &view, distance: &distance, surface_id, tree_step, motion });
    }
    if is_first {
        land_maps::make(recorder, inputs);
    }

    let water = frame_water::find(recorder, inputs, &view, [surface_id, &distance], targets);
    // The rims of holes, along which detected lines are removed. Most land has none.
    let rims = style.rims().filter(|_| mesh.has_holes() || recorder.prewarms());
    let rim = rims.map(|rims| {
        let rim = targets.whole(gpu, &surface::rims::RIM);
        let (terrain, style) = (heights, rims);
        let (distance, normal) = (&distance, &normal);
        let drawn = surface::rims::Inputs { view: &view, terrain, style, surface_id, distance, normal, rim: &rim };
        surface::rims::run(recorder, &drawn);
        rim
    });
    // Detected lines, and the edges that are found on the visible surface: suggestive contours, ridges and valleys.
    let on_surface = frame_lines::OnSurface {
        view: &view,
        meshes: meshes.as_ref(),
        heights,
        surface_id,
        depth,
        distance: &distance,
        normal: &normal,
        water: water.as_ref(),
        rim: rim.as_ref(),
        other_eye_m: rig.is_pair().then(|| (rig.eyes[1 - eye].pose.position_m - rig.origin_m).as_vec3().to_array()),
    };
    let line = inputs.lines.map(|lines| frame_lines::find(recorder, inputs, lines, &on_surface, targets));
    if let Some((edges, strokes)) = edges.zip(style.strokes()) {
        frame_lines::add_edges(recorder, edges, strokes, &on_surface, targets);
    }
    let bends = bend::find(recorder, inputs, &on_surface.bend_inputs(), targets);
    // Strokes: find the visible parts of edges, chain them, and draw them.
    let strokes = style.strokes().zip(strokes).map(|(style, mut frame)| {
        let leader = leader.and_then(|leader| leader.strokes.as_ref()?.drawn.as_ref());
        let resolution = style.resolution;
        let ink = frame.draw(
            recorder,
            strokes::Inputs {
                view: &view,
                still_view: &still_view,
                depth,
                surface_id,
                has_holes: mesh.has_holes(),
                edges,
                targets,
                resolution,
                leader,
                apart_m: rig.apart_m() as f32,
            },
        );
        let surface = SeenSurface {
            view: view.clone(),
            depth: depth.clone(),
            distance: distance.clone(),
            normal: normal.clone(),
        };
        let drawn = if rig.is_pair() { frame.partner(recorder, &still_view, surface, targets) } else { None };
        SeenStrokes { frame, ink, drawn }
    });
    let may_sway = trees.as_ref().is_some_and(|trees| trees.placed.may_sway);
    let tree_form = trees.map(|trees| trees.form);
    let (surface_id, local_color) = (surface_id.clone(), local_color.cloned());
    Seen {
        view,
        still_view,
        surface_id,
        distance,
        normal,
        local_color,
        tree_shadow,
        tree_form,
        water,
        bends,
        rim,
        line,
        strokes,
        may_sway,
    }
}

/// Turns the lines that each eye detected into those that are drawn: contours of a stereo pair fade out toward those of
/// the other eye, stairs are smoothed, crowded lines are thinned out, and lines without a partner in the other eye are
/// removed.
fn finish_lines(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    lines: &Lines,
    seen: &mut [Seen],
    eyes: &mut [EyeMemory],
) {
    let gpu = recorder.gpu();
    let stereo = if inputs.rig.is_pair() { lines.stereo } else { Stereo::Alone };
    // Eyes that are drawn independently thin out lines as a single eye does.
    let apart_m = if stereo == Stereo::Alone { 0.0 } else { inputs.rig.apart_m() as f32 };
    for (Seen { view, distance, normal, line, .. }, memory) in seen.iter_mut().zip(eyes.iter_mut()) {
        let Some(line) = line else { continue };
        if stereo == Stereo::Full {
            let faded = memory.targets.whole(gpu, &fade_out::FADED);
            fade_out::run(
                recorder,
                lines,
                inputs.rig,
                &fade_out::Inputs { view, distance, normal, line, faded: &faded },
            );
            *line = faded;
        }
        if lines.antialias {
            let smoothed = memory.targets.whole(gpu, &smooth::SMOOTHED);
            smooth::run(recorder, &smooth::Inputs { view, line, smoothed: &smoothed });
            *line = smoothed;
        }
        if let Some(cap) = Cap::of(lines.crowd, lines.crowd_px) {
            *line = crowd::run(recorder, &crowd::Inputs { view, distance, line, cap, apart_m }, &mut memory.targets);
        }
    }
    if stereo == Stereo::Alone {
        return;
    }
    let eye_of = |Seen { view, distance, line, .. }: &Seen| {
        Some(agree::Eye { view: view.clone(), distance: distance.clone(), line: line.clone()? })
    };
    let before: Vec<agree::Eye> = seen.iter().filter_map(eye_of).collect();
    for (eye, own) in before.iter().enumerate() {
        let agreed = eyes[eye].targets.whole(gpu, &agree::AGREED);
        agree::run(recorder, &agree::Inputs { own, other: &before[1 - eye], agreed: &agreed });
        seen[eye].line = Some(agreed);
    }
}

/// Draws the picture of an eye.
fn finish(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    seen: &[Seen],
    shaded: &[Shaded],
    eye: usize,
    memory: &mut EyeMemory,
) {
    let &FrameInputs { rig, style, light, .. } = inputs;
    let gpu = recorder.gpu();
    let Seen { view, distance, rim, line, strokes, .. } = &seen[eye];
    let EyeMemory { targets, layer_inks, .. } = memory;
    let marks = shaded[eye].balance.as_ref().map(|balance| {
        // The correction of the ink is the mean of both eyes of a stereo pair.
        let partner = if rig.is_pair() { seen.get(1 - eye).zip(shaded.get(1 - eye)) } else { None };
        let partner = partner.and_then(|(seen, shaded)| {
            Some(balance::Partner { view: &seen.view, distance, more: &shaded.balance.as_ref()?.more })
        });
        balance::draw(recorder, balance, partner.as_ref());
        &balance.marks
    });
    let picture = &targets.whole(gpu, &composite::PICTURE);
    let stroke_ink = strokes.as_ref().map(|strokes| &strokes.ink);
    let sky = style.sky.is_drawn().then(|| {
        let sky = targets.whole(gpu, &SKY);
        let [width, height] = rig.eyes[eye].picture_px.map(|side| side as f32);
        let margin_px = style.paper.margin_px;
        let drawn = sky::Inputs {
            view,
            style: &style.sky,
            panorama: &style.panorama,
            light,
            sky: &sky,
            frame_px: [margin_px, margin_px, width - margin_px, height - margin_px - style.paper.foot_px],
            is_composed: rig.eyes.iter().all(|other| other.pose.position_m == rig.eyes[0].pose.position_m),
        };
        sky::run(recorder, &drawn);
        sky
    });
    let (tone, sky, is_sample) = (&shaded[eye].colors, sky.as_ref(), false);
    let picture_of = |(index, layer): (usize, &Layer)| match layer {
        Layer::Lines(_) => line.clone(),
        Layer::Strokes(_) => stroke_ink.cloned(),
        Layer::Rims(_) => rim.clone(),
        Layer::Hatching(_) => marks.cloned(),
        Layer::ToneLines(_)
        | Layer::HeightLines(_)
        | Layer::Drainage(_)
        | Layer::Features(_)
        | Layer::Cuts(_)
        | Layer::Ground(_)
        | Layer::Rows(_)
        | Layer::Water(_) => shaded[eye].inks[index].clone(),
    };
    *layer_inks = style.layers.iter().enumerate().map(picture_of).collect();
    let nothing = &targets.sized(gpu, &composite::NOTHING, [1, 1]);
    let inks = &inks::drawn(style, inputs.lines, &Pictures { of_layers: layer_inks, line: line.as_ref(), nothing });
    let drawn = composite::Inputs { view, style, light, distance, tone, sky, inks, is_sample, picture };
    let Some(plan) = inputs.temporal_aa else {
        composite::run(recorder, &drawn);
        return;
    };
    let sample = &targets.whole(gpu, &temporal_aa::SAMPLE);
    // Strokes on top are drawn over the mean, because they move on their own. Strokes below other inks are part of the
    // sample, as those inks are.
    let is_on_top = matches!(style.layers.last(), Some(Layer::Strokes(_)));
    let (over, inks) = match stroke_ink.filter(|_| is_on_top) {
        Some(ink) => (Some(ink), &inks[..inks.len() - 1]),
        None => (None, inks.as_slice()),
    };
    composite::run(recorder, &composite::Inputs { inks, is_sample: true, picture: sample, ..drawn });
    let (histories, motion) = (&temporal_aa::Histories::of(gpu, targets, plan), &targets.whole(gpu, &motion::MOTION));
    let mean = temporal_aa::Inputs { view, plan, style, sample, distance, motion, ink: over, histories, picture };
    temporal_aa::run(recorder, &mean);
}
