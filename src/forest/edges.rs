//! Edges of a tree's mesh, each with the corners opposite to it; contours and open borders are found among them.
//!
//! Corners of triangles at the same position are one vertex. An edge shared by more than two triangles is listed once
//! for each pair of them, in the order of triangles; a triangle that is left over makes it a border. The winding of
//! triangles does not matter.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::DVec3;

/// An edge of a mesh, as indices of corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MeshEdge {
    /// The two ends.
    pub ends: [usize; 2],
    /// The corner of the first triangle that is opposite to the edge.
    pub across: usize,
    /// The corner of the second triangle that is opposite to the edge; `None` at a border.
    pub across_other: Option<usize>,
}

/// Returns the edges of triangles with three corners each, in the order of triangles. Triangles with zero area are left
/// out.
pub(crate) fn edges(corners: &[DVec3]) -> Vec<MeshEdge> {
    let mut vertices: HashMap<[u64; 3], usize> = HashMap::new();
    // Adding 0.0 turns −0.0 into 0.0.
    let vertex_of: Vec<usize> = corners
        .iter()
        .enumerate()
        .map(|(corner, at)| *vertices.entry(at.to_array().map(|along| (along + 0.0).to_bits())).or_insert(corner))
        .collect();
    let mut edges: Vec<MeshEdge> = Vec::new();
    // For each pair of vertices, the edge that still lacks its second triangle.
    let mut waiting: HashMap<[usize; 2], usize> = HashMap::new();
    for (number, triangle) in vertex_of.chunks_exact(3).enumerate() {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        if a == b || b == c || c == a {
            continue;
        }
        let first = 3 * number;
        for [from, to, across] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let (one, other) = (triangle[from], triangle[to]);
            match waiting.entry([one.min(other), one.max(other)]) {
                Entry::Occupied(entry) => edges[entry.remove()].across_other = Some(first + across),
                Entry::Vacant(entry) => {
                    entry.insert(edges.len());
                    let ends = [first + from, first + to];
                    edges.push(MeshEdge { ends, across: first + across, across_other: None });
                }
            }
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forest::species::{Detail, Grown};

    fn places(grown: Grown) -> Vec<DVec3> {
        grown.grow(Detail::Near).iter().map(|corner| corner.at).collect()
    }

    #[test]
    fn every_side_of_every_triangle_is_on_one_edge() {
        for grown in Grown::ALL {
            let corners = places(grown);
            let found = edges(&corners);
            let sides: usize = found.iter().map(|edge| 1 + usize::from(edge.across_other.is_some())).sum();
            assert_eq!(sides, corners.len(), "{grown:?}");
            for edge in &found {
                let [a, b] = edge.ends.map(|end| corners[end]);
                for across in [Some(edge.across), edge.across_other].into_iter().flatten() {
                    let triangle = &corners[across / 3 * 3..across / 3 * 3 + 3];
                    assert!(triangle.contains(&a) && triangle.contains(&b) && !edge.ends.contains(&across));
                    assert!(corners[across] != a && corners[across] != b);
                }
            }
        }
    }

    #[test]
    fn closed_meshes_have_no_border_and_holes_have_one_all_around() {
        let corners = places(Grown::Conifer);
        let borders = |corners: &[DVec3]| edges(corners).iter().filter(|edge| edge.across_other.is_none()).count();
        let closed = borders(&corners);
        // Planted: one triangle of a spray is missing.
        let holed: Vec<DVec3> = corners[..corners.len() - 3].to_vec();
        assert_eq!(borders(&holed), closed + 3);
    }

    #[test]
    fn winding_and_triangles_without_area_do_not_matter() {
        let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5)];
        let one_way = edges(&[a, b, c, c, b, d]);
        let other_way = edges(&[a, b, c, c, d, b, a, a, d]);
        for found in [one_way, other_way] {
            assert_eq!(found.len(), 5);
            assert_eq!(found.iter().filter(|edge| edge.across_other.is_some()).count(), 1);
        }
        // Three triangles at one edge: a pair and one left over.
        let fan = edges(&[a, b, c, a, b, d, a, b, DVec3::Z]);
        assert_eq!(fan.iter().filter(|edge| edge.across_other.is_some()).count(), 1);
        assert_eq!(fan.len(), 8);
    }
}
