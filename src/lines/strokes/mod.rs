//! Strokes: edges of the surface become pen lines, on the GPU (Pietrok 2021, sections 4.2 and 4.3, without the thesis's
//! list on the CPU).
//!
//! The edge list ([`crate::surface::edges`]) → the ID reference image ([`id_image`]), thinned ([`thin`]) → visible
//! segments ([`extract`], and [`outlines`] where edges are missing) → chains ([`chain`], specified by [`twin`]) → points ([`points`]) → samples ([`samples`]),
//! which continue those of the previous frame ([`temporal`], when [`history`] says so) and agree with the other eye's
//! ([`partner`]) → ink ([`stroke`]), solid or through a [`texture`].
//!
//! Each pass is dispatched or drawn indirectly with the counts of the previous one: nothing is read back within a
//! frame. [`polylines`] reads the strokes of a frame back afterwards, for files; [`left_out`] reads back how many were
//! not drawn.
//!
//! Why: `docs/decisions/stroke-pipeline.md`.

pub(crate) mod temporal;
pub(crate) mod centres;
pub(crate) mod chain;
pub(crate) mod crowd;
pub(crate) mod extract;
pub(crate) mod history;
pub(crate) mod id_image;
pub(crate) mod left_out;
pub(crate) mod outlines;
pub(crate) mod partner;
pub(crate) mod points;
pub(crate) mod polylines;
mod records;
pub(crate) mod samples;
pub(crate) mod stroke;
pub mod texture;
pub(crate) mod thin;
#[cfg(test)]
pub(crate) mod twin;

use std::sync::Arc;

use bytemuck::Zeroable;

use self::history::History;
pub(crate) use self::left_out::{AsyncStrokeNumbers, LeftOut, StrokeNumbers};
use self::partner::{Partner, Role, SeenSurface};
#[cfg(test)]
pub(crate) use self::records::{Chain, ChainPosition, SegmentInOrder};
pub(crate) use self::records::{ChainRules, Segment, StrokeCounts};
use self::samples::{SampleList, SampleWork, TemporalUniform};
use self::stroke::Which;
use self::texture::StrokeTexture;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pools::Pools;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
pub(crate) use crate::gpu::wgsl::shared::stroke_style::Strokes as StrokesUniform;
use crate::gpu::{Gpu, GpuError};
use crate::lines::crowd::{Cap, Cells};
use crate::scene::Light;
use crate::scene::focus::{Focus, FocusUniform};
use crate::scene::view::{View, ViewUniform};
use crate::style;
use crate::surface::edges::{EdgeList, EdgeRules};

/// Largest number of segments of a frame.
pub(crate) const MAX_FRAME_SEGMENTS: u32 = 1 << 19;

/// The camera's position is passed to shaders as a whole number of blocks of this size, in metres, and a rest.
const BLOCK_M: f64 = 4096.0;

/// Returns the size of the ID reference image of a picture.
pub(crate) fn image_px(size_px: [u32; 2], resolution: f32) -> [u32; 2] {
    size_px.map(|side| ((side as f32 * resolution).ceil() as u32).max(1))
}

/// [`StrokeCounts`].
pub(crate) const COUNTS: BufferKind = BufferKind::storage("stroke counts");
/// The visible [`Segment`]s of edges.
pub(crate) const SEGMENTS: BufferKind = BufferKind::storage("segments");

/// The lists that the passes of a frame share.
pub(crate) struct Lists {
    /// `Strokes` in `shaders/shared/stroke_style.wgsl`.
    uniform: Resource,
    pub counts: Buffer,
    pub segments: Buffer,
}

impl Lists {
    /// Allocates the lists for a style's strokes on a picture of `size_px`.
    #[cfg(test)]
    pub(crate) fn of(recorder: &mut Recorder<'_>, strokes: &style::Strokes, size_px: [u32; 2], haze_m: f64) -> Self {
        Self::new(recorder, &StrokesUniform::new(strokes, size_px, haze_m))
    }

    fn new(recorder: &mut Recorder<'_>, uniform: &StrokesUniform) -> Self {
        Self {
            uniform: recorder.uniform("strokes", uniform),
            counts: recorder.buffer(&COUNTS, size_of::<StrokeCounts>() as u64),
            segments: recorder.buffer(&SEGMENTS, u64::from(uniform.segment_capacity) * size_of::<Segment>() as u64),
        }
    }

    /// Resets the counts to zero.
    pub(crate) fn clear(&self, recorder: &mut Recorder<'_>) {
        recorder.reset(&self.counts, &[StrokeCounts::default()]);
    }

    fn strokes(&self) -> Named {
        ("strokes", self.uniform.clone())
    }

    fn counts(&self) -> Named {
        ("counts", self.counts.binding())
    }
}

impl StrokesUniform {
    /// Returns the uniform of a style, for a picture of `size_px`.
    pub(crate) fn new(strokes: &style::Strokes, size_px: [u32; 2], haze_m: f64) -> Self {
        let image_px = image_px(size_px, strokes.resolution);
        Self {
            resolution: strokes.resolution,
            image_px,
            segment_capacity: (image_px[0].saturating_mul(image_px[1])).min(MAX_FRAME_SEGMENTS),
            half_width_px: strokes.width_px * 0.5,
            taper_px: strokes.taper_px,
            haze_m: haze_m as f32 * strokes.reach,
            faintest: strokes.faintest,
            depth_width: strokes.depth_width,
            occluding_width: strokes.occluding_width,
            interior_width: strokes.interior_width,
            shortest_px: strokes.shortest_px,
            shortest_interior_px: strokes.shortest_interior_px,
            curve_width: strokes.curve_width,
            wobble_px: strokes.wobble_px,
            merge_px: strokes.merge_px,
            slender: strokes.slender,
            suggestive_width: strokes.suggestive_width,
            ridge_width: strokes.ridge_width,
            valley_width: strokes.valley_width,
        }
    }
}

/// The state of an eye's strokes that is kept from frame to frame.
pub(crate) struct StrokeMemory {
    history: History,
    lists: [SampleList; 2],
    current: usize,
    /// Whether the last frame was an update.
    rebuilt: bool,
    uniform: StrokesUniform,
    /// The focus of the last frame, and the view in which it was drawn.
    focus: Option<(Focus, ViewUniform)>,
    texture: Option<Arc<StrokeTexture>>,
}

impl StrokeMemory {
    /// Creates the state of an eye that has drawn no frame.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when the lists are larger than the device can bind.
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        chain::check(gpu, MAX_FRAME_SEGMENTS)?;
        let lists = [SampleList::new(gpu), SampleList::new(gpu)];
        let history = History::default();
        let uniform = StrokesUniform::zeroed();
        Ok(Self { history, lists, current: 0, rebuilt: false, uniform, focus: None, texture: None })
    }

    /// Returns the samples of the last frame.
    pub(crate) fn samples(&self) -> &SampleList {
        &self.lists[self.current]
    }

    /// Returns the samples of the last two frames.
    pub(crate) fn both_lists(&self) -> &[SampleList; 2] {
        &self.lists
    }

    /// Returns whether strokes are still coming or going.
    pub(crate) fn is_settling(&self) -> bool {
        self.history.is_settling()
    }

    /// Makes the next frame rebuild its strokes, which continue those of the last one.
    pub(crate) fn rebuild_next(&mut self) {
        self.history.rebuild_next();
    }

    /// Prevents the next frame from continuing the last one: it is not of the same sequence.
    pub(crate) fn forget(&mut self) {
        self.history.forget();
    }
}

/// The strokes of an eye's last frame, for files and measurements.
#[derive(Clone, Copy)]
pub(crate) struct DrawnStrokes<'a> {
    memory: &'a StrokeMemory,
    pools: &'a Pools,
}

impl<'a> DrawnStrokes<'a> {
    pub(crate) fn new(memory: &'a StrokeMemory, pools: &'a Pools) -> Self {
        Self { memory, pools }
    }

    /// Returns the samples of the last frame.
    pub(crate) fn samples(&self) -> &'a SampleList {
        self.memory.samples()
    }

    /// Returns whether the last frame's strokes continued those of the frame before it.
    #[cfg(test)]
    pub(crate) fn continued(&self) -> bool {
        self.memory.history.continued()
    }

    /// Returns whether the last frame rebuilt its strokes; otherwise it moved those of the previous frame.
    pub(crate) fn rebuilt(&self) -> bool {
        self.memory.rebuilt
    }

    /// Returns a buffer of the eye that was drawn last: [`COUNTS`], [`SEGMENTS`] or one of the submodules'. `None` if
    /// no recent frame has used it.
    pub(crate) fn buffer(&self, kind: &BufferKind) -> Option<Buffer> {
        self.pools.buffers.get(kind)
    }

    /// Returns the stroke texture of the last frame, if the style has one.
    #[cfg(test)]
    pub(crate) fn texture(&self) -> Option<&'a StrokeTexture> {
        self.memory.texture.as_deref()
    }
}

/// The strokes of one frame, a step after the last one: they are either rebuilt, for which edges must be found before
/// they are drawn, or moved along.
pub(crate) struct FrameStrokes {
    plan: history::Plan,
    edge_rules: EdgeRules,
    lists: Lists,
    focus: Resource,
    rules: ChainRules,
    merges: bool,
    cap: Option<Cap>,
    /// The cells of the density control, of an update whose style has a cap.
    cells: Option<Cells>,
    work: SampleWork,
    texture: Option<Arc<StrokeTexture>>,
}

/// Inputs of drawing strokes.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The same view without jitter: the visibility of edges is sampled with jitter, strokes are not.
    pub still_view: &'a Resource,
    /// Depth of the surface.
    pub depth: &'a Target,
    pub surface_id: &'a Target,
    /// Whether the land in view has holes.
    pub has_holes: bool,
    /// The edges of the surface, if they were [wanted](FrameStrokes::wants_edges).
    pub edges: Option<&'a EdgeList>,
    /// The targets of an eye, for the reference image and the ink.
    pub targets: &'a mut Targets,
    /// Pixels of the reference image per pixel of the picture.
    pub resolution: f32,
    /// The other eye of a stereo pair, if it has been drawn before.
    pub leader: Option<&'a Partner>,
    /// Distance to that eye, in metres; 0 if the eye is alone.
    pub apart_m: f32,
}

impl FrameStrokes {
    /// Begins a frame of an eye whose view is `view`; the second eye of a stereo pair updates when the leading one
    /// does.
    pub(crate) fn begin(
        recorder: &mut Recorder<'_>,
        memory: &mut StrokeMemory,
        strokes: &style::Strokes,
        view: &View,
        light: &Light,
        step: history::Step,
        leader: Option<&Self>,
    ) -> Self {
        let plan = memory.history.plan(strokes, view, step, leader.map(|leader| leader.plan.is_update));
        memory.current = 1 - memory.current;
        memory.rebuilt = plan.is_update;
        memory.uniform = StrokesUniform::new(strokes, view.part.size_px, light.haze_m);
        memory.focus = light.focus.map(|focus| (focus, view.still_uniform(step.origin_m)));
        let focus = FocusUniform::on_gpu(recorder, light.focus.as_ref());
        let (now, before) = (&memory.lists[memory.current], &memory.lists[1 - memory.current]);
        let work = SampleWork::new(recorder, [now, before], carry_uniform(&plan, strokes, step));
        let texture = strokes.texture.as_ref().and_then(|recipe| StrokeTexture::of(recorder, recipe));
        memory.texture.clone_from(&texture);
        let lists = Lists::new(recorder, &memory.uniform);
        if plan.is_update {
            lists.clear(recorder);
        }
        let rules = ChainRules::new(strokes.join_px, strokes.join_deg.to_radians());
        let edge_rules = EdgeRules { crease_deg: strokes.crease_deg, borders: strokes.borders };
        let (merges, cap) = (strokes.merge_px > 0.0, Cap::of(strokes.crowd, strokes.crowd_px));
        Self { plan, edge_rules, lists, focus, rules, merges, cap, cells: None, work, texture }
    }

    /// Returns which edges must be found, if strokes are rebuilt.
    pub(crate) fn wants_edges(&self) -> Option<EdgeRules> {
        self.plan.is_update.then_some(self.edge_rules)
    }

    /// Draws the strokes, and returns their ink. An update draws the reference image, extracts visible segments, chains
    /// them and lets them continue the previous frame's strokes; otherwise the strokes of the previous frame move with
    /// the world.
    pub(crate) fn draw(&mut self, recorder: &mut Recorder<'_>, inputs: Inputs<'_>) -> Target {
        let Inputs { view, still_view, depth, surface_id, has_holes, edges, targets, resolution, leader, apart_m } =
            inputs;
        let Self { plan, lists, work, .. } = self;
        let gpu = recorder.gpu();
        let (ink, ids) = (targets.whole(gpu, &stroke::INK), targets.whole(gpu, &stroke::STROKE_IDS));
        let (texture, ink, ids) = (self.texture.as_deref(), &ink, &ids);
        if plan.last_px != targets.size_px() && (plan.takes_over || !plan.is_update) {
            temporal::resize(recorder, still_view, work);
        }
        let drawn = stroke::Inputs { view: still_view, focus: &self.focus, lists, work, texture, ink, ids };
        let Some(edges) = edges else {
            temporal::advance(recorder, still_view, work);
            stroke::run(recorder, Which::Fresh, &drawn);
            return ink.clone();
        };
        let image_px = image_px(targets.size_px(), resolution);
        let edge_ids = targets.sized(gpu, &id_image::EDGE_IDS, image_px);
        let edge_depth = targets.sized(gpu, &id_image::EDGE_DEPTH, image_px);
        id_image::run(recorder, edges, &id_image::Inputs { view, depth, ids: &edge_ids, edge_depth: &edge_depth });
        let line_ids = if self.merges {
            let [thinned, between] = thin::THINNED.each_ref().map(|kind| targets.sized(gpu, kind, image_px));
            let thinned = [&thinned, &between];
            thin::run(recorder, lists, edges, &thin::Inputs { view, depth, ids: &edge_ids, thinned });
            thinned[0].clone()
        } else {
            edge_ids
        };
        extract::run(recorder, lists, edges, view, &line_ids);
        // Without borders, the land may end where no line is wanted.
        if self.edge_rules.borders {
            let ids = &line_ids;
            outlines::run(recorder, lists, edges, &outlines::Inputs { view, depth, ids, surface_id, has_holes });
        }
        let (segments, counts) = (&lists.segments, &lists.counts);
        let chains =
            &chain::run(recorder, &chain::Inputs { rules: self.rules, capacity: MAX_FRAME_SEGMENTS, segments, counts });
        let points = &points::run(recorder, lists, edges, chains);
        let view = still_view;
        samples::run(recorder, &samples::Inputs { view, depth, ids: &line_ids, lists, chains, points, work });
        if let Some(cap) = self.cap {
            let leader = leader.and_then(|leader| Some((&leader.view, leader.cells.as_ref()?)));
            self.cells =
                Some(crowd::run(recorder, &crowd::Inputs { view, depth, work, cap, apart_m, leader }, targets));
        }
        if plan.takes_over {
            temporal::look(recorder, view, work, ids);
        }
        temporal::take_over(recorder, view, lists, chains, work);
        if let Some(leader) = leader {
            partner::agree(recorder, view, work, leader, Role::Follower);
        }
        stroke::run(recorder, Which::Fresh, &drawn);
        if plan.takes_over {
            temporal::keep(recorder, view, work, ids, depth);
            stroke::run(recorder, Which::Fading, &drawn);
        }
        ink.clone()
    }

    /// Redraws the strokes of the leading eye, without those that the other eye should have but does not.
    pub(crate) fn draw_agreed(
        &self,
        recorder: &mut Recorder<'_>,
        view: &Resource,
        targets: &mut Targets,
        follower: &Partner,
    ) {
        if !self.plan.is_update {
            return;
        }
        let (lists, work) = (&self.lists, &self.work);
        partner::agree(recorder, view, work, follower, Role::Leader);
        let gpu = recorder.gpu();
        let (ink, ids) = (targets.whole(gpu, &stroke::INK), targets.whole(gpu, &stroke::STROKE_IDS));
        let (focus, texture) = (&self.focus, self.texture.as_deref());
        let drawn = stroke::Inputs { view, focus, lists, work, texture, ink: &ink, ids: &ids };
        stroke::run(recorder, Which::Fresh, &drawn);
        if self.plan.takes_over {
            stroke::run(recorder, Which::Fading, &drawn);
        }
    }

    /// Returns the strokes and pictures that the other eye of a stereo pair reads, if strokes were rebuilt.
    pub(crate) fn partner(
        &self,
        recorder: &mut Recorder<'_>,
        view: &Resource,
        surface: SeenSurface,
        targets: &mut Targets,
    ) -> Option<Partner> {
        let centres = targets.whole(recorder.gpu(), &centres::CENTRES);
        self.plan.is_update.then(|| {
            centres::run(recorder, view, &self.work, &centres);
            let (samples, cells) = (self.work.now.clone(), self.cells.clone());
            Partner { view: view.clone(), samples, centres, surface, cells }
        })
    }
}

fn carry_uniform(plan: &history::Plan, strokes: &style::Strokes, step: history::Step) -> TemporalUniform {
    let history::Plan { is_update, takes_over, step_m, updated, rests, last_px, frame } = *plan;
    let origin_m = step.origin_m;
    // The part of a stroke's whole coming or going that happens in this frame.
    let progress = step.progress(strokes);
    TemporalUniform {
        step_m: step_m.as_vec3().to_array(),
        has_history: u32::from(takes_over || !is_update),
        pressure_step: progress as f32,
        growth_px: (progress * samples::GROWTH_PX) as f32,
        hold: strokes.hold,
        capacity: (strokes.budget_px / samples::SPACING_PX) as u32,
        // A picture that is drawn on its own is always the same.
        seed: if takes_over { frame } else { 0 },
        rests: u32::from(rests),
        last_px,
        camera_blocks: (origin_m / BLOCK_M).floor().as_ivec3().to_array(),
        camera_rest_m: (origin_m - (origin_m / BLOCK_M).floor() * BLOCK_M).as_vec3().to_array(),
        updated_clip_from_camera: updated.map_or([[0.0; 4]; 4], |view| view.still_uniform(origin_m).clip_from_camera),
        ..TemporalUniform::default()
    }
}
