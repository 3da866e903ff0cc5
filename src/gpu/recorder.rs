//! Records the passes of a frame, with their bindings, times and trace.
//!
//! A pass is a function of a [`Recorder`] and its inputs, and owns nothing, so the same pass can be recorded for many
//! eyes and styles in one submit.
//!
//! A frame is one submit, or several if a pass requests it ([`Recorder::submit_so_far`]). Consecutive dispatches are
//! recorded into one compute pass of wgpu, so that wgpu places only the barriers that they need. To measure pass times,
//! each of them is a compute pass of its own with timestamps around it, and on a software driver a submit of its own
//! ([`Submits::Timed`], [`timer`](super::timer)). Nothing is submitted before the whole frame is recorded; a frame that
//! lacks a pipeline is not submitted at all.
//!
//! A prewarming run ([`Recorder::prewarm`]) records nothing. It only requests the pipelines and cached values that a
//! frame would need.

mod buffers;

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;

use super::bind::{Bound, Named, Resource};
use super::buffer::{Buffer, BufferKind};
use super::drawer::Drawer;
use super::finite::{self, NonFinite, WrittenFloats};
use super::pipelines::{Builds, Compute, Draw, Key, Raw, Ready};
use super::pools::Pools;
use super::target::Target;
use super::timer::{Mark, Timer};
use super::trace::{PassTrace, Traced, Work, uses};
use super::{Gpu, GpuError};

/// Side of a workgroup of a picture pass, in pixels. The shaders have `@workgroup_size(8, 8)`.
pub(crate) const WORKGROUP_PX: u32 = 8;

/// Size in bytes of the buffer that replaces every other in a prewarming run. It exceeds every offset that a pass
/// subtracts from the size of a buffer.
const BLANK_BYTES: u64 = 1 << 12;

/// How the passes of a frame are submitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Submits {
    /// One submit for all passes, and no times.
    #[default]
    Whole,
    /// One submit for all passes, and the time of the whole frame. On a software driver the frame is waited for.
    Framed,
    /// Each pass is timed. On a GPU all passes are one submit, with timestamps around each; on a software driver each
    /// pass is submitted alone, at the cost of two more submits and two waits per pass.
    Timed,
    /// Each pass is submitted alone, and what it wrote is read back and searched for NaN and infinity
    /// ([`finite`](super::finite)).
    Checked,
}

/// Records a frame.
pub struct Recorder<'a> {
    gpu: &'a Gpu,
    pools: &'a mut Pools,
    timer: &'a mut Timer,
    encoder: wgpu::CommandEncoder,
    /// The compute pass to which further dispatches are added, and the pipeline that is set in it. It is closed before
    /// anything else is recorded.
    open: Option<(wgpu::ComputePass<'static>, Option<wgpu::ComputePipeline>)>,
    submits: Submits,
    trace: Option<Vec<PassTrace>>,
    /// Resets of buffers, which are submitted before everything else.
    resets: Option<wgpu::CommandEncoder>,
    /// The buffers that have been reset in this frame, each with its offset.
    reset: Vec<(wgpu::Buffer, u64)>,
    /// Names of the buffers that were copied to or cleared since the last traced pass.
    copied: Vec<&'static str>,
    /// The earlier submits of the frame, each with the name under which it is timed, if any.
    recorded: Vec<(Option<&'static str>, wgpu::CommandEncoder)>,
    /// The buffer that a prewarming run returns for every request. `None` in a frame that is drawn.
    blank: Option<wgpu::Buffer>,
    /// The buffers with floats that the passes of a checked frame write.
    written_floats: Vec<WrittenFloats>,
    /// Whether everything that the passes requested so far was available.
    is_complete: bool,
}

/// The result of [`Recorder::submit`].
#[derive(Debug)]
pub struct Submitted {
    /// The passes, if they were traced; an empty list if nothing was submitted.
    pub trace: Option<Vec<PassTrace>>,
    /// CPU time to upload uniforms and to hand the recorded commands to the driver, in milliseconds. If each pass is
    /// submitted alone, it includes the work of the passes.
    pub submit_ms: f64,
    /// With [`Submits::Checked`], the first number that is not finite of each picture and buffer that each pass wrote.
    pub non_finite: Vec<NonFinite>,
}

/// A render pipeline with its bindings. It is empty while the pipeline is being compiled; then nothing is drawn with
/// it.
#[derive(Clone, Debug)]
pub struct Drawing {
    ready: Option<(wgpu::RenderPipeline, Bound)>,
    /// The resources that the pass reads and those that it writes, if the frame is traced.
    uses: Option<(Vec<Traced>, Vec<Traced>)>,
}

impl Drawing {
    /// Sets the pipeline and its bind group in a render pass.
    pub fn set(&self, pass: &mut Drawer<'_>) {
        if let Some((pipeline, bound)) = &self.ready {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bound.group, &bound.offsets);
        }
    }
}

/// The attachments of a render pass that are cleared to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clears {
    Nothing,
    /// The colours but not the depth.
    Colors,
    /// The colours and the depth.
    All,
}

/// The targets that a render pass draws on.
#[derive(Clone, Copy, Debug)]
pub struct Attachments<'a> {
    /// The colour targets, all of one size, in the order of the shader's outputs.
    pub colors: &'a [&'a Target],
    /// The depth target, of the same size. Depth is reversed: a greater value is nearer.
    pub depth: Option<&'a Target>,
    /// The targets that are cleared first.
    pub clears: Clears,
}

impl<'a> Recorder<'a> {
    /// Begins a frame. With `traces`, [`submit`](Self::submit) returns a trace of its passes.
    pub fn new(gpu: &'a Gpu, pools: &'a mut Pools, timer: &'a mut Timer, submits: Submits, traces: bool) -> Self {
        let mut first = encoder(gpu);
        if submits == Submits::Framed {
            timer.mark(Mark::Begin, &mut first);
        }
        Self {
            gpu,
            pools,
            timer,
            encoder: first,
            open: None,
            submits,
            trace: (traces || submits == Submits::Checked).then(Vec::new),
            resets: None,
            reset: Vec::new(),
            copied: Vec::new(),
            recorded: Vec::new(),
            blank: None,
            written_floats: Vec::new(),
            is_complete: true,
        }
    }

    /// Begins a prewarming run: passes request their pipelines and cached values, and nothing is recorded, bound or
    /// written.
    pub fn prewarm(gpu: &'a Gpu, pools: &'a mut Pools, timer: &'a mut Timer) -> Self {
        let blank = Buffer::new(gpu, &BufferKind::storage("prewarm"), BLANK_BYTES).raw;
        Self { blank: Some(blank), ..Self::new(gpu, pools, timer, Submits::Whole, false) }
    }

    /// Returns whether this is a prewarming run. A pass then requests its pipelines even if this frame gives it nothing
    /// to do.
    pub fn prewarms(&self) -> bool {
        self.blank.is_some()
    }

    /// Returns whether everything that the passes requested so far was available.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    pub fn gpu(&self) -> &'a Gpu {
        self.gpu
    }

    /// Returns the cached value that `find` accepts; without one, creates it with `make` and caches it. A value that
    /// has not been requested for a while is released.
    ///
    /// # Errors
    /// The errors of `make`.
    pub fn cached<T: Send + Sync + 'static, E>(
        &mut self,
        find: impl Fn(&T) -> bool,
        make: impl FnOnce(&Gpu) -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        self.gpu.cache().get(find, || make(self.gpu))
    }

    /// Returns a cached value like [`Recorder::cached`], for values that take long to create. If pipelines are compiled
    /// in the background, so is the value: until it is ready, returns `None`, and the frame is not drawn.
    pub fn cached_in_background<T: Send + Sync + 'static>(
        &mut self,
        find: impl Fn(&T) -> bool,
        make: impl FnOnce(&Gpu) -> T + Send + 'static,
    ) -> Option<Arc<T>> {
        let found = match self.pools.compiles.builds {
            Builds::AtOnce | Builds::Collected => {
                self.gpu.cache().get(find, || Ok::<_, Infallible>(make(self.gpu))).ok()
            }
            Builds::Spare => self.gpu.cache().known(find),
            Builds::InBackground => {
                let gpu = self.gpu.for_background();
                self.gpu.cache().request(find, move || make(&gpu))
            }
        };
        self.is_complete &= found.is_some();
        found
    }

    /// Runs a shader once for each pixel of a `size_px` picture.
    pub fn pixels(&mut self, shader: impl Into<Compute>, size_px: [u32; 2], resources: &[Named]) {
        self.groups(shader, size_px.map(|side| side.div_ceil(WORKGROUP_PX)), resources);
    }

    /// Runs a shader with the given numbers of workgroups in x and y.
    pub fn groups(&mut self, shader: impl Into<Compute>, groups: [u32; 2], resources: &[Named]) {
        let run = |pass: &mut wgpu::ComputePass<'_>| pass.dispatch_workgroups(groups[0], groups[1], 1);
        self.dispatch(shader.into(), resources, Work::Dispatch, run);
    }

    /// Runs a shader with the numbers of workgroups in x, y and z that are stored at byte `offset` of `arguments`.
    /// `arguments` must not be among the resources: wgpu forbids a buffer to be indirect arguments and a writable
    /// binding in one dispatch, and reports a validation error (`Gpu::check`).
    pub fn indirect(&mut self, shader: impl Into<Compute>, arguments: &Buffer, offset: u64, resources: &[Named]) {
        let offset = arguments.offset + offset;
        let run = |pass: &mut wgpu::ComputePass<'_>| pass.dispatch_workgroups_indirect(&arguments.raw, offset);
        self.dispatch(shader.into(), resources, Work::Indirect(arguments.name), run);
    }

    fn dispatch(
        &mut self,
        key: Compute,
        resources: &[Named],
        work: Work,
        run: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) {
        let name = key.name;
        let Pools { compiles, groups, .. } = &mut *self.pools;
        let (key, pipelines) = (Key::Compute(key), self.gpu.pipelines());
        if self.blank.is_some() {
            self.is_complete &= pipelines.request(self.gpu, &key, compiles);
            return;
        }
        let Some((Ready { raw: Raw::Compute(pipeline), bound }, made)) =
            pipelines.ready(self.gpu, groups, &key, resources, compiles)
        else {
            self.is_complete = false;
            return;
        };
        if self.trace.is_some() {
            let (reads, writes) = uses(&made.variables, resources);
            self.push_trace(name, work, reads, writes);
        }
        if self.submits == Submits::Checked {
            let submit = self.recorded.len() as u32;
            for variable in made.variables.iter().filter(|variable| variable.is_written && variable.floats.has_any()) {
                let bound = resources.iter().find(|(bound, _)| *bound == variable.name);
                if let Some((_, Resource::Buffer(buffer))) = bound {
                    let (buffer, floats) = (buffer.clone(), variable.floats.clone());
                    self.written_floats.push(WrittenFloats { submit, pass: name, buffer, floats });
                }
            }
        }
        if matches!(self.submits, Submits::Whole | Submits::Framed) {
            let encoder = &mut self.encoder;
            let (pass, set) = self.open.get_or_insert_with(|| {
                let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes: None };
                (encoder.begin_compute_pass(&descriptor).forget_lifetime(), None)
            });
            if set.as_ref() != Some(&pipeline) {
                pass.set_pipeline(&pipeline);
                *set = Some(pipeline);
            }
            pass.set_bind_group(0, &bound.group, &bound.offsets);
            run(pass);
            return;
        }
        let query = self.begin_timed_pass(name);
        {
            let timestamp_writes = query.as_ref().and_then(|query| query.compute_pass_timestamp_writes());
            let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
            let mut pass = self.encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bound.group, &bound.offsets);
            run(&mut pass);
        }
        self.end_timed_pass(name, query);
    }

    fn push_trace(&mut self, name: &'static str, work: Work, reads: Vec<Traced>, writes: Vec<Traced>) {
        let (submit, copied) = (self.recorded.len() as u32, std::mem::take(&mut self.copied));
        if let Some(trace) = &mut self.trace {
            trace.push(PassTrace { name, submit, work, copied, reads, writes });
        }
    }

    /// Prepares a render pipeline with its bindings for [`Recorder::render`].
    pub fn drawing(&mut self, key: &Draw, resources: &[Named]) -> Drawing {
        let Pools { compiles, groups, .. } = &mut *self.pools;
        let (key, pipelines) = (Key::Draw(key.clone()), self.gpu.pipelines());
        if self.blank.is_some() {
            self.is_complete &= pipelines.request(self.gpu, &key, compiles);
            return Drawing { ready: None, uses: None };
        }
        let Some((Ready { raw: Raw::Draw(pipeline), bound }, made)) =
            pipelines.ready(self.gpu, groups, &key, resources, compiles)
        else {
            self.is_complete = false;
            return Drawing { ready: None, uses: None };
        };
        let uses = self.trace.is_some().then(|| uses(&made.variables, resources));
        Drawing { ready: Some((pipeline, bound)), uses }
    }

    /// Records a render pass, unless one of its drawings is not ready.
    pub fn render(
        &mut self,
        name: &'static str,
        drawings: &[&Drawing],
        on: Attachments<'_>,
        record: impl FnOnce(&mut Drawer<'_>),
    ) {
        if drawings.iter().any(|drawing| drawing.ready.is_none()) {
            return;
        }
        self.open = None;
        if self.trace.is_some() {
            let mut reads = Vec::new();
            let mut writes: Vec<_> = on.colors.iter().copied().chain(on.depth).map(Traced::of).collect();
            for (read, written) in drawings.iter().filter_map(|drawing| drawing.uses.as_ref()) {
                reads.extend(read.iter().cloned());
                writes.extend(written.iter().cloned());
            }
            reads.dedup();
            self.push_trace(name, Work::Draws(0), reads, writes);
        }
        let query = self.begin_timed_pass(name);
        let draws = {
            let store = wgpu::StoreOp::Store;
            let load = if on.clears != Clears::Nothing {
                wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT)
            } else {
                wgpu::LoadOp::Load
            };
            let mut colors = Vec::with_capacity(on.colors.len());
            for target in on.colors {
                let ops = wgpu::Operations { load, store };
                colors.push(Some(wgpu::RenderPassColorAttachment {
                    view: &target.view,
                    depth_slice: None,
                    resolve_target: None,
                    ops,
                }));
            }
            let pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(name),
                color_attachments: &colors,
                depth_stencil_attachment: on.depth.map(|depth| wgpu::RenderPassDepthStencilAttachment {
                    view: &depth.view,
                    depth_ops: Some(wgpu::Operations {
                        load: if on.clears == Clears::All { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load },
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: query.as_ref().and_then(|query| query.render_pass_timestamp_writes()),
                ..Default::default()
            });
            let mut drawer = Drawer::new(pass);
            if let Some(part) = on.colors.iter().copied().chain(on.depth).find(|target| target.is_part()) {
                drawer.limit_to(part.size_px());
            }
            record(&mut drawer);
            drawer.draws()
        };
        if let Some(pass) = self.trace.as_mut().and_then(|trace| trace.last_mut()) {
            pass.work = Work::Draws(draws);
        }
        self.end_timed_pass(name, query);
    }

    /// Ends a submit here and begins the next. Long work is split in this way, so that no single submit keeps the GPU
    /// busy for too long.
    pub fn submit_so_far(&mut self) {
        if !self.prewarms() {
            self.end_submit(None);
        }
    }

    /// Submits the frame if it is complete.
    ///
    /// # Errors
    /// With [`Submits::Checked`], [`GpuError::Readback`] if the device is lost or out of memory.
    pub fn submit(mut self) -> Result<Submitted, GpuError> {
        let mut non_finite = Vec::new();
        if self.prewarms() {
            return Ok(Submitted { trace: None, submit_ms: 0.0, non_finite });
        }
        self.open = None;
        let is_timed = matches!(self.submits, Submits::Timed | Submits::Framed);
        if !self.is_complete {
            if is_timed {
                self.timer.forget(self.gpu);
            }
            self.pools.end_frame();
            self.gpu.cache().end_frame();
            return Ok(Submitted { trace: self.trace.map(|_| Vec::new()), submit_ms: 0.0, non_finite });
        }
        if self.submits == Submits::Framed {
            self.timer.mark(Mark::End, &mut self.encoder);
        }
        if is_timed {
            self.timer.resolve(&mut self.encoder);
        }
        // wgpu encodes the commands for the driver when an encoder is finished, so that is part of recording.
        let mut resets = self.resets.map(wgpu::CommandEncoder::finish);
        let last = self.encoder.finish();
        let finish = |(name, recorded): (Option<&'static str>, wgpu::CommandEncoder)| (name, recorded.finish());
        let recorded: Vec<_> = self.recorded.drain(..).map(finish).collect();
        let framed = (self.submits == Submits::Framed).then(|| self.timer.begin_frame(self.gpu)).flatten();
        let begun = Instant::now();
        self.pools.arena.flush(self.gpu);
        if !recorded.is_empty() {
            self.gpu.queue.submit(resets.take());
        }
        for (index, (name, recorded)) in (0..).zip(recorded) {
            match name {
                Some(name) => self.timer.submit_and_time(self.gpu, name, recorded),
                None => _ = self.gpu.queue.submit([recorded]),
            }
            if self.submits == Submits::Checked {
                for pass in self.trace.iter().flatten().filter(|pass| pass.submit == index) {
                    finite::search(self.gpu, pass, &mut non_finite)?;
                }
                for written in self.written_floats.iter().filter(|written| written.submit == index) {
                    non_finite.extend(written.search(self.gpu)?);
                }
            }
        }
        self.gpu.queue.submit(resets.into_iter().chain([last]));
        let submit_ms = begun.elapsed().as_secs_f64() * 1000.0;
        if let Some(begun) = framed {
            self.timer.end_whole_frame(self.gpu, begun);
        }
        if is_timed {
            self.timer.end_frame();
        }
        self.pools.end_frame();
        self.gpu.cache().end_frame();
        Ok(Submitted { trace: self.trace, submit_ms, non_finite })
    }

    /// Begins the timestamps of a pass, if passes are timed by them.
    fn begin_timed_pass(&mut self, name: &'static str) -> Option<wgpu_profiler::GpuProfilerQuery> {
        if self.submits != Submits::Timed {
            return None;
        }
        self.timer.begin(name, &mut self.encoder)
    }

    /// Ends the timestamps of a pass. If passes are submitted alone, ends its submit.
    fn end_timed_pass(&mut self, name: &'static str, query: Option<wgpu_profiler::GpuProfilerQuery>) {
        if let Some(query) = query {
            self.timer.end(&mut self.encoder, query);
        } else if self.timer.times_by_waiting(self.submits) {
            self.end_submit(Some(name));
        } else if self.submits == Submits::Checked {
            self.end_submit(None);
        }
    }

    /// Ends a submit, which is timed under `name`, if any.
    fn end_submit(&mut self, name: Option<&'static str>) {
        self.open = None;
        let recorded = std::mem::replace(&mut self.encoder, encoder(self.gpu));
        self.recorded.push((name, recorded));
    }
}

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
}
