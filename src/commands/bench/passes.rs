//! The passes of a style, with the bytes that they read and write, and the memory that they need, from all frames that were traced: those of the warm-up,
//! and some that are drawn again after the flight.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::gpu::trace::{PassBytes, PassTrace};
use crate::measure::report::{Pass, Run};
use crate::measure::work::FrameWork;

/// The passes found in traces.
#[derive(Default)]
pub(super) struct TracedPasses {
    /// Passes of the last traced frame, in order.
    names: Vec<&'static str>,
    /// Bytes and number of runs of each pass in the last traced frame that ran it: some passes do not run in every frame.
    bytes: FxHashMap<&'static str, (PassBytes, u64)>,
    /// Largest memory that a traced frame needed; `None` before the first.
    memory_bytes: Option<u64>,
}

impl TracedPasses {
    /// Adds the trace of a frame and the memory that it needed, and returns the work that the frame gave the GPU.
    pub(super) fn take(&mut self, trace: &[PassTrace], drawing_bytes: Option<u64>) -> FrameWork {
        let mut known = FxHashSet::default();
        self.names = trace.iter().map(|pass| pass.name).filter(|name| known.insert(*name)).collect();
        let runs = |name| trace.iter().filter(|pass| pass.name == name).count() as u64;
        self.bytes.extend(self.names.iter().map(|name| (*name, (PassBytes::of(trace, name), runs(*name)))));
        self.memory_bytes = self.memory_bytes.max(drawing_bytes);
        FrameWork::of(trace)
    }

    /// Adds the passes, their bytes and their memory to the report; if nothing was timed, the report still lists the passes.
    pub(super) fn fill(&self, run: &mut Run) {
        if run.passes.is_empty() {
            run.passes = self.names.iter().map(|name| Pass { name: (*name).to_owned(), ..Pass::default() }).collect();
        }
        for pass in &mut run.passes {
            let traced = self.bytes.get(pass.name.as_str());
            pass.bytes_read = traced.map(|(bytes, _)| bytes.read);
            pass.bytes_written = traced.map(|(bytes, _)| bytes.written);
            pass.runs = traced.map(|(_, runs)| *runs);
        }
        run.memory.drawing_bytes = self.memory_bytes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::trace::{Traced, Work};

    fn used(name: &'static str, bytes: u64) -> Traced {
        Traced { name, content: None, texture: None, buffer: None, bytes }
    }

    #[test]
    fn a_pass_that_did_not_run_again_keeps_its_bytes() {
        let pass = |name, reads: &[Traced]| PassTrace {
            name,
            submit: 0,
            work: Work::Dispatch,
            copied: Vec::new(),
            reads: reads.to_vec(),
            writes: vec![used("depth", 100)],
        };
        let mut traced = TracedPasses::default();
        traced.take(&[pass("once", &[used("tiles", 7)]), pass("always", &[])], Some(300));
        // Two batches: both read the tiles, and one reads the patches.
        let work = traced.take(
            &[pass("always", &[used("tiles", 7)]), pass("always", &[used("tiles", 7), used("patches", 3)])],
            Some(200),
        );
        assert_eq!((work.bytes_read, work.bytes_written, work.dispatches), (10, 100, 2));
        let passes = ["always", "once", "never"].map(|name| Pass { name: name.to_owned(), ..Pass::default() });
        let mut run = Run { passes: passes.into(), ..Run::default() };
        traced.fill(&mut run);
        let bytes: Vec<_> = run.passes.iter().map(|pass| (pass.bytes_read, pass.bytes_written, pass.runs)).collect();
        assert_eq!(bytes, [(Some(10), Some(100), Some(2)), (Some(7), Some(100), Some(1)), (None, None, None)]);
        assert_eq!(run.memory.drawing_bytes, Some(300));
        // Nothing was timed.
        let mut run = Run::default();
        traced.fill(&mut run);
        assert_eq!(run.passes.len(), 1);
        assert_eq!((run.passes[0].name.as_str(), run.passes[0].gpu_ms), ("always", None));
    }
}
