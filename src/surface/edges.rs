//! The edge list: contours, borders and creases of the surface as drawn, whatever its kind.
//!
//! Each kind of surface adds its edges (`land/edges`, `meshes/edges`), and strokes are drawn from the list alone. It is
//! written and read on the GPU; its length is the vertex count of an indirect draw. Lists are in an order that does not
//! depend on timing ([`crate::gpu::scan::Ordered`]).
//!
//! Why: `docs/decisions/edge-visibility.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::shared::edges::EdgeRules as EdgeRulesUniform;
pub use crate::gpu::wgsl::shared::edges::{Edge, KIND_RIDGE, KIND_SUGGESTIVE, KIND_VALLEY, MOST_EDGES};

/// Which edges are wanted beside contours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdgeRules {
    /// Where the surface bends by more than this it has a crease, in degrees; none wants no creases.
    pub crease_deg: Option<f32>,
    /// Whether the borders of the land are edges.
    pub borders: bool,
}

/// An indirect draw of lines, before an edge is found: two vertices will come for each, one instance.
const NO_EDGES: [u32; 4] = [0, 1, 0, 0];

/// An indirect draw of the edges as lines.
pub const EDGE_DRAW: BufferKind = BufferKind::indirect("edge draw");
/// [`Edge`]s.
pub const EDGES: BufferKind = BufferKind::storage("edges");

/// The edges of a frame.
pub struct EdgeList {
    rules: Resource,
    /// [`EDGES`].
    pub edges: Buffer,
    /// [`EDGE_DRAW`].
    pub draw: Buffer,
}

impl EdgeList {
    /// Begins a list of no edges.
    pub fn begin(recorder: &mut Recorder<'_>, rules: EdgeRules) -> Self {
        let uniform = EdgeRulesUniform {
            // No cosine is below.
            crease_cosine: rules.crease_deg.map_or(-2.0, |degrees| degrees.to_radians().cos()),
            borders: u32::from(rules.borders),
        };
        let list = Self {
            rules: recorder.uniform("edge rules", &uniform),
            edges: recorder.buffer(&EDGES, u64::from(MOST_EDGES) * size_of::<Edge>() as u64),
            draw: recorder.buffer(&EDGE_DRAW, size_of_val(&NO_EDGES) as u64),
        };
        recorder.write(&list.draw, &NO_EDGES);
        list
    }

    /// `EdgeRules` in `shaders/shared/edges.wgsl`.
    pub fn rules(&self) -> Named {
        ("edge_rules", self.rules.clone())
    }

    /// The edges themselves.
    pub fn edges(&self) -> Named {
        ("edges", self.edges.binding())
    }

    /// Twice their number is the first of four.
    pub fn draw(&self) -> Named {
        ("edge_draw", self.draw.binding())
    }

    /// What a pass needs that adds edges.
    pub fn resources(&self) -> [Named; 3] {
        [self.rules(), self.edges(), self.draw()]
    }
}
