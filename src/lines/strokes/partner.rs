//! Strokes of two eyes are the same strokes.
//!
//! Each eye makes its strokes of the edges that it sees: contours lie elsewhere for each, and chains begin and end where
//! nearer land hides them. But a stroke is one thing in the world. So one eye, the leading one, draws first; the samples
//! of the other one look for its strokes (`look`) and take over who they are, where on their texture they are and how
//! wide they are (`adopt`). Then the leading eye looks back. Both press the pen as hard as the one that presses harder,
//! and a stroke that the other eye should see and does not have tapers.
//!
//! He, Wang and Bao 2019 test whether contours are epipolar-slidable by a search along epipolar lines, and erase those
//! that are not. Here a surface tells where a place lies in the other eye, so the search begins there; it is asked of
//! strokes and not of pixels; and strokes keep their identity from frame to frame as well.
//!
//! Why: `docs/decisions/stereo.md`.

use super::samples::{GROUPS, SampleList, SampleWork};
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::lines::crowd::Cells;

/// The strokes of the other eye, as they were drawn.
#[derive(Clone)]
pub struct Partner {
    /// Its `View`.
    pub view: Resource,
    /// Its samples.
    pub samples: SampleList,
    /// [`super::centres::CENTRES`].
    pub centres: Target,
    /// Of the surface that it sees.
    pub surface: SeenSurface,
    /// Which of its strokes were too many, of a style with a cap.
    pub cells: Option<Cells>,
}

/// The surface as an eye sees it.
#[derive(Clone)]
pub struct SeenSurface {
    /// Reversed: near / distance.
    pub depth: Target,
    /// From the rig's origin.
    pub position: Target,
    /// In the world.
    pub normal: Target,
}

/// Which of two eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Strokes are its.
    Leader,
    /// It takes them over.
    Follower,
}

/// Lets an eye's samples take over what they find in the other one.
pub fn agree(recorder: &mut Recorder<'_>, view: &Resource, work: &SampleWork, partner: &Partner, role: Role) {
    let resources = [
        ("view", view.clone()),
        ("other_view", partner.view.clone()),
        work.list(),
        work.samples(),
        ("old_samples", partner.samples.samples.binding()),
        ("ids", (&partner.centres).into()),
        ("depth", (&partner.surface.depth).into()),
        ("position", (&partner.surface.position).into()),
        ("normal", (&partner.surface.normal).into()),
        work.matches(),
    ];
    recorder.groups(Compute { name: "lines/strokes/look", definitions: &["PAIR"] }, GROUPS, &resources);
    let definitions: &[&str] = if role == Role::Follower { &["FOLLOWER"] } else { &[] };
    let mut resources = vec![work.temporal(), work.list(), work.matches(), work.samples()];
    resources.extend((role == Role::Follower).then(|| ("view", view.clone())));
    recorder.groups(Compute { name: "lines/strokes/adopt", definitions }, GROUPS, &resources);
}
