//! Contours and open borders of near trees → the edge list. See `shaders/surface/trees/edges.wgsl`.

use super::DrawnTrees;
use super::near::{self, MAX_NEAR};
use super::sway::Swaying;
use crate::forest::edges::edges;
use crate::forest::model::TreeCorner;
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::wgsl::surface::trees::edges::{TreeEdge, TreeEdgeRules, TreeEdges};
use crate::surface::edges::EdgeList;

/// Threads of a workgroup.
const WORKGROUP: u32 = 64;
/// An edge within a crown becomes a line if what is behind it is farther away than this, as a fraction of the tree's
/// height: arcs within a crown are drawn, single leaves against each other are not.
const CLEARANCE: f32 = 0.1;

/// [`TreeEdge`]s of all species.
const EDGES: BufferKind = BufferKind::storage("tree edges");
/// [`TreeEdgeRules`], then [`TreeEdges`] of each species.
const OF_SPECIES: BufferKind = BufferKind::storage("edges of species");

/// The edges of the near meshes of all species, on the GPU.
pub(super) struct EdgesOfSpecies {
    edges: Buffer,
    of_species: Buffer,
    /// Workgroups per tree: as many as the species with the most edges needs.
    groups: u32,
}

impl EdgesOfSpecies {
    /// Finds the edges of near meshes, which are given as triangle corners.
    pub(super) fn new<'a>(gpu: &Gpu, meshes: impl Iterator<Item = &'a [TreeCorner]>) -> Self {
        let mut all: Vec<TreeEdge> = Vec::new();
        let mut of_species: Vec<TreeEdges> = Vec::new();
        for corners in meshes {
            let first = all.len() as u32;
            all.extend(packed(corners));
            of_species.push(TreeEdges { first, count: all.len() as u32 - first });
        }
        let most = of_species.iter().map(|edges| edges.count).max().unwrap_or(0);
        let groups = most.div_ceil(WORKGROUP).max(1);
        let rules = TreeEdgeRules { groups, clearance: CLEARANCE };
        let packed_corner = [bytemuck::bytes_of(&rules), bytemuck::cast_slice(&of_species)].concat();
        if all.is_empty() {
            // wgpu does not allow empty buffers.
            all.push(TreeEdge::default());
        }
        Self {
            edges: Buffer::with(gpu, &EDGES, &all),
            of_species: Buffer::with(gpu, &OF_SPECIES, &packed_corner),
            groups,
        }
    }
}

fn packed(corners: &[TreeCorner]) -> Vec<TreeEdge> {
    let places: Vec<_> = corners.iter().map(|corner| corner.at).collect();
    let packed_corner = |corner: usize| corners[corner].at.as_vec3().extend(corners[corner].sway as f32).to_array();
    let border = [0.0, 0.0, 0.0, -1.0];
    edges(&places)
        .iter()
        .map(|edge| TreeEdge {
            a: packed_corner(edge.ends[0]),
            b: packed_corner(edge.ends[1]),
            c: packed_corner(edge.across),
            d: edge.across_other.map_or(border, packed_corner),
        })
        .collect()
}

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The terrain uniform, for the curvature of the earth.
    pub terrain: Named,
    /// The trees in view.
    pub trees: &'a DrawnTrees,
    /// The sway of the trees, if wind blows.
    pub swaying: Option<&'a Swaying>,
}

/// Adds the edges to the list.
pub(crate) fn run(recorder: &mut Recorder<'_>, list: &EdgeList, inputs: &Inputs<'_>) {
    let &Inputs { view, ref terrain, trees, swaying } = inputs;
    let of_species = &trees.shared.edges;
    let near = near::run(recorder, view, trees, of_species.groups);
    let mut resources = vec![
        ("view", view.clone()),
        terrain.clone(),
        ("tree_instances", trees.instances.binding()),
        ("near_order", near.order.binding()),
        ("tree_edges", of_species.edges.binding()),
        ("edges_of_species", of_species.of_species.binding()),
    ];
    resources.extend(list.resources());
    resources.extend(swaying.into_iter().flat_map(Swaying::resources));
    let shader = |definitions| Compute { name: "surface/trees/edges", definitions };
    let (find, shader) = match swaying {
        Some(_) => (Some(shader(&["WIND", "COUNTS"])), shader(&["WIND", "WRITES"])),
        None => (None, shader(&[])),
    };
    let groups = Groups::Counted { arguments: &near.dispatch, offset: 0, max_groups: MAX_NEAR * of_species.groups };
    Ordered { shader, first_stage_shader: find, groups, words_per_group: 0 }.run(recorder, &resources);
}
