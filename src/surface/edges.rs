//! The edge list: contours, borders and creases of the surface as drawn, of all kinds of surface.
//!
//! Each kind of surface adds its edges (`land/edges`, `meshes/edges`, `trees/edges`), and strokes are drawn from the
//! list alone. The list is written and read on the GPU; its length is the vertex count of an indirect draw. Its order
//! does not depend on timing ([`crate::gpu::scan::Ordered`]).
//!
//! Why: `docs/decisions/edge-visibility.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::shared::edges::EdgeRules as EdgeRulesUniform;
pub(crate) use crate::gpu::wgsl::shared::edges::{Edge, MAX_EDGES};
#[cfg(test)]
pub(crate) use crate::gpu::wgsl::shared::edges::{KIND_RIDGE, KIND_SUGGESTIVE, KIND_VALLEY};

/// The kinds of edge that are wanted besides contours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EdgeRules {
    /// The edge between two triangles is a crease if their normals differ by more than this, in degrees; `None`
    /// disables creases.
    pub crease_deg: Option<f32>,
    /// Whether the borders of the land are edges.
    pub borders: bool,
}

/// The indirect draw of an empty list: two vertices are added for each edge, and there is one instance.
const NO_EDGES: [u32; 4] = [0, 1, 0, 0];

/// Arguments of an indirect draw of the edges as lines.
pub(crate) const EDGE_DRAW: BufferKind = BufferKind::indirect("edge draw");
/// The [`Edge`]s of all kinds of surface.
pub(crate) const EDGES: BufferKind = BufferKind::storage("edges");

/// The edges of one frame.
pub(crate) struct EdgeList {
    rules: Resource,
    pub edges: Buffer,
    pub draw: Buffer,
}

impl EdgeList {
    /// Begins an empty list.
    pub(crate) fn begin(recorder: &mut Recorder<'_>, rules: EdgeRules) -> Self {
        let uniform = EdgeRulesUniform {
            // No cosine is below −1, so nothing is a crease.
            crease_cosine: rules.crease_deg.map_or(-2.0, |degrees| degrees.to_radians().cos()),
            borders: u32::from(rules.borders),
        };
        let list = Self {
            rules: recorder.uniform("edge rules", &uniform),
            edges: recorder.buffer(&EDGES, u64::from(MAX_EDGES) * size_of::<Edge>() as u64),
            draw: recorder.buffer(&EDGE_DRAW, size_of_val(&NO_EDGES) as u64),
        };
        recorder.reset(&list.draw, &NO_EDGES);
        list
    }

    /// Returns the binding of `EdgeRules` in `shaders/shared/edges.wgsl`.
    pub(crate) fn rules(&self) -> Named {
        ("edge_rules", self.rules.clone())
    }

    /// Returns the binding of the edges.
    pub(crate) fn edges(&self) -> Named {
        ("edges", self.edges.binding())
    }

    /// Returns the binding of the indirect draw, whose first word is twice the number of edges.
    pub(crate) fn draw(&self) -> Named {
        ("edge_draw", self.draw.binding())
    }

    /// Returns all bindings that a pass needs to add edges.
    pub(crate) fn resources(&self) -> [Named; 3] {
        [self.rules(), self.edges(), self.draw()]
    }
}
