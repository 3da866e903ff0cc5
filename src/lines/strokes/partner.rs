//! Stereo agreement of strokes: both eyes draw the same strokes.
//!
//! Each eye builds its strokes from the edges that it sees: contours are at different places for each, and chains begin
//! and end where nearer land hides them. But a stroke is one thing in the world. So one eye, the leading one, draws
//! first; the samples of the other eye look for its strokes (`look`) and take over their identity, texture parameter
//! and width (`adopt`). Then the leading eye looks back. Both use the greater of their two pen pressures, and a stroke
//! that the other eye should see but does not have tapers.
//!
//! He, Wang and Bao 2019 test whether contours are epipolar-slidable by a search along epipolar lines, and erase those
//! that are not. Here the surface gives the position of a place in the other eye, so the search begins there; the test
//! is applied to strokes and not to pixels; and strokes keep their identity from frame to frame as well.
//!
//! Why: `docs/decisions/stereo.md`.

use super::samples::{SampleList, SampleWork};
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::lines::crowd::Cells;

/// The strokes of the other eye, as they were drawn.
#[derive(Clone)]
pub(crate) struct Partner {
    /// The other eye's `View`.
    pub view: Resource,
    /// The other eye's samples.
    pub samples: SampleList,
    pub centres: Target,
    /// The surface as the other eye sees it.
    pub surface: SeenSurface,
    /// The cells of the other eye, if the style has a cap.
    pub cells: Option<Cells>,
}

/// The surface as an eye sees it.
#[derive(Clone)]
pub(crate) struct SeenSurface {
    /// The `View`, with jitter, with which the surface was drawn.
    pub view: Resource,
    /// Reversed depth: near / distance.
    pub depth: Target,
    /// Metres along the view axis.
    pub distance: Target,
    /// Unit normals in world space, as words.
    pub normal: Target,
}

/// The role of an eye in a stereo pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// The eye whose strokes are taken over.
    Leader,
    /// The eye that takes them over.
    Follower,
}

/// Lets an eye's samples take over the strokes that they find in the other eye.
pub(crate) fn agree(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork, partner: &Partner, role: Role) {
    let resources = [
        ("view", view.clone()),
        ("other_view", partner.view.clone()),
        work.sample_counts(),
        work.samples(),
        ("old_samples", partner.samples.samples.binding()),
        ("seen_view", partner.surface.view.clone()),
        ("ids", (&partner.centres).into()),
        ("depth", (&partner.surface.depth).into()),
        ("distance_m", (&partner.surface.distance).into()),
        ("normal", (&partner.surface.normal).into()),
        work.matches(),
    ];
    let (arguments, offset) = work.per_fresh();
    let look = Compute { name: "lines/strokes/look", definitions: &["PAIR"] };
    recorder.indirect(look, arguments, offset, &resources);
    let definitions: &[&str] = if role == Role::Follower { &["FOLLOWER"] } else { &[] };
    let mut resources = vec![work.temporal(), work.sample_counts(), work.matches(), work.samples()];
    resources.extend((role == Role::Follower).then(|| ("view", view.clone())));
    recorder.indirect(Compute { name: "lines/strokes/adopt", definitions }, arguments, offset, &resources);
}
