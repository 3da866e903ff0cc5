//! Models of trees from files: a [`Mesh`] normalised to a tree of height 1, with its levels of detail.
//!
//! The tree's foot is on the plane of the lowest vertex, with the centre of its lowest part at the origin. Levels of
//! detail come from [`simplify`]; far away the tree is the canopy of the generated species whose outline is most
//! similar. Sheets of leaves have no outside: their triangles wind according to their normals, and normals of sheets
//! seen from behind are flipped toward the eye, as for all trees.

use glam::{DMat3, DVec2, DVec3};

use super::species::{Corner, Grown, canopy};
use crate::mesh::placed::Stance;
use crate::mesh::silhouette::{SIDE_PX, cover};
use crate::mesh::simplify::simplify;
use crate::mesh::{Material, Mesh};

/// Largest number of triangles of a near tree.
pub(crate) const NEAR_TRIANGLES: usize = 1800;
/// Largest number of triangles of a tree in the middle distance.
pub(crate) const MIDDLE_TRIANGLES: usize = 300;

/// Meshes with more triangles than this get their middle level of detail from the near one, to save time.
pub(crate) const MANY_TRIANGLES: usize = 50_000;

/// Largest width relative to height: a wider model cannot be a tree; probably another axis points up.
const WIDEST: f64 = 20.0;
/// Height of the foot, relative to the tree's height.
const FOOT: f64 = 0.05;
/// Height above which the crown begins, relative to the tree's height.
const CROWN: f64 = 0.35;
/// Least cosine between a vertex normal and the triangle's normal: see [`super::species`].
const MIN_AGREEMENT: f64 = 0.15;

/// Lightness of materials without a chosen colour.
const PLAIN_LIGHTNESS: f64 = 0.62;
/// Largest number of colours of a tree; further materials use the first.
const MAX_COLORS: usize = 255;
/// Smallest and largest lightness of any part of a tree.
const LIGHTNESS: [f64; 2] = [0.3, 0.97];

/// A corner of a triangle of a tree of height 1 whose foot is at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TreeCorner {
    /// Position; z is up, 0 to 1.
    pub at: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// Lightness: 0 is black, 1 is as light as bare land.
    pub lightness: f64,
    /// Index of the colour in a palette ([`super::colors`]), the same for all corners of a triangle.
    pub color_index: u8,
    /// Share of the wind's motion: 0 at the foot, 1 at the ends of twigs.
    pub sway: f64,
}

/// A model of a tree at all distances, as lists of triangles with three corners each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TreeModel {
    /// Near level of detail, at most [`NEAR_TRIANGLES`].
    pub near: Vec<TreeCorner>,
    /// Middle level of detail, at most [`MIDDLE_TRIANGLES`].
    pub middle: Vec<TreeCorner>,
    /// The generated species whose canopy is used far away.
    pub clump: Grown,
    /// Triangles of that [`canopy`], with the lightness of the model's crown.
    pub canopy: Vec<TreeCorner>,
    /// Colours of the materials in linear light, at most 255; `None` if no colour was chosen. The canopy's index is the
    /// next one.
    pub colors: Vec<Option<[f32; 3]>>,
    /// Shares of the crown's area with each colour; they sum to 1.
    pub crown: Vec<f64>,
}

impl TreeModel {
    /// Builds the tree from a mesh of any size.
    ///
    /// # Errors
    /// A cause in words: the mesh has no height, is too wide, or has no area.
    pub(crate) fn new(mesh: &Mesh, z_up: bool) -> Result<Self, String> {
        let own = Own::of(mesh, z_up)?;
        let less = simplify(mesh, NEAR_TRIANGLES);
        let near = own.corners(&less);
        // Simplifying a very large mesh again would double the time.
        let from = if mesh.triangles.len() > MANY_TRIANGLES { &less } else { mesh };
        let middle = own.corners(&simplify(from, MIDDLE_TRIANGLES));
        if near.is_empty() || middle.is_empty() {
            return Err("all of its triangles have zero area".to_owned());
        }
        let clump = Shape::of(&near).clump();
        let mut colors: Vec<Option<[f32; 3]>> = mesh.materials.iter().map(chosen_color).collect();
        colors.truncate(MAX_COLORS);
        let crown = crown_shares(&near, colors.len());
        let (lightness, color_index) = (lightness_of_crown(&near), colors.len() as u8);
        let toned = |corner: Corner| {
            let Corner { at, normal, sway, .. } = corner;
            TreeCorner { at, normal, lightness, color_index, sway }
        };
        let canopy = canopy(clump).into_iter().map(toned).collect();
        Ok(Self { near, middle, clump, canopy, colors, crown })
    }
}

/// The transform that makes a mesh a tree of height 1.
struct Own {
    turn: DMat3,
    /// Foot of the tree in the mesh's units, after `turn`.
    foot: DVec3,
    height: f64,
}

impl Own {
    fn of(mesh: &Mesh, z_up: bool) -> Result<Self, String> {
        let turn = Stance { origin_m: DVec3::ZERO, yaw_deg: 0.0, scale: 1.0, z_up }.world_from_mesh();
        let places = || places(mesh, turn);
        let [low, high] = bounds(places());
        let size = high - low;
        let wide = size.truncate().max_element();
        // Vertices are stored as f32.
        if size.z <= 1e-6 * wide.max(f64::MIN_POSITIVE) {
            return Err("it has no height".to_owned());
        }
        if wide > WIDEST * size.z {
            let times = wide / size.z;
            return Err(format!(
                "it is {times:.0} times as wide as tall, too wide for a tree; is up = \"y\" or \"z\" right?"
            ));
        }
        let [foot_low, foot_high] = bounds(places().filter(|at| at.z <= low.z + FOOT * size.z));
        let foot = ((foot_low + foot_high) * 0.5).truncate().extend(low.z);
        Ok(Self { turn, foot, height: size.z })
    }

    /// Returns the corners of this mesh or of a simplification of it, scaled to heights 0 to 1.
    fn corners(&self, mesh: &Mesh) -> Vec<TreeCorner> {
        let at: Vec<DVec3> = places(mesh, self.turn).map(|at| (at - self.foot) / self.height).collect();
        let [low, high] = bounds(at.iter().copied());
        // A simplification may be slightly lower or taller than its mesh.
        let tall = if high.z - low.z > 0.5 { high.z - low.z } else { 1.0 };
        let at: Vec<DVec3> = at.into_iter().map(|at| at.truncate().extend((at.z - low.z) / tall)).collect();
        let lightness: Vec<f64> = mesh.materials.iter().map(lightness_of).collect();
        // Materials beyond the palette are treated like no material.
        let color_index =
            |material: u16| u8::try_from(material).ok().filter(|color_index| usize::from(*color_index) < MAX_COLORS);
        let mut corners: Vec<TreeCorner> = Vec::with_capacity(3 * mesh.triangles.len());
        for triangle in &mesh.triangles {
            let places = triangle.corners.map(|corner| at[corner as usize]);
            let [a, b, c] = places;
            let face = (b - a).cross(c - a).normalize_or_zero();
            if face == DVec3::ZERO {
                continue;
            }
            let normals = triangle.normals.map(|normal| self.turn * normal);
            let is_turned = face.dot(normals.iter().sum()) < 0.0;
            let face = if is_turned { -face } else { face };
            let order = if is_turned { [0, 2, 1] } else { [0, 1, 2] };
            corners.extend(order.map(|corner| {
                let normal = normals[corner];
                let lacks = (MIN_AGREEMENT - normal.dot(face)).max(0.0);
                TreeCorner {
                    at: places[corner],
                    normal: (normal + face * lacks).normalize_or(face),
                    lightness: lightness[usize::from(triangle.material)],
                    color_index: color_index(triangle.material).unwrap_or(0),
                    sway: 0.0,
                }
            }));
        }
        sway(&mut corners);
        corners
    }
}

fn places(mesh: &Mesh, turn: DMat3) -> impl Iterator<Item = DVec3> {
    mesh.vertices_m.iter().map(move |at_m| turn * (mesh.middle_m + DVec3::from_array(at_m.map(f64::from))))
}

fn bounds(places: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    places.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}

/// Sets the sway as for generated trees: it grows with height and with distance from the trunk.
fn sway(corners: &mut [TreeCorner]) {
    let reach = corners.iter().map(|corner| corner.at.truncate().length()).fold(1e-6, f64::max);
    for corner in corners {
        let out = corner.at.truncate().length() / reach;
        corner.sway = (corner.at.z.max(0.0) * (0.35 + 0.65 * out) * 1.25).min(1.0);
    }
}

/// Returns the colour of a material, or `None` if it is a default: none, or the grey that programs write for textures.
fn chosen_color(material: &Material) -> Option<[f32; 3]> {
    let [red, green, blue] = material.color.map(f64::from);
    let is_left = red == green && green == blue && (0.35..0.9).contains(&red);
    (!is_left).then_some(material.color)
}

/// Returns the lightness of a material, with bare land at 1; the greens of leaves have 0.5 to 0.75.
fn lightness_of(material: &Material) -> f64 {
    let Some(color) = chosen_color(material) else { return PLAIN_LIGHTNESS };
    let [red, green, blue] = color.map(f64::from);
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    // L* of CIE 1976 without its linear segment near black.
    let perceived = 116.0 * luminance.max(0.0).cbrt() - 16.0;
    (0.3 + 0.0062 * perceived).clamp(LIGHTNESS[0], LIGHTNESS[1])
}

/// Returns the mean over the area of the crown, or over the whole tree if no triangle is that high.
fn mean_of_crown(corners: &[TreeCorner], value: impl Fn(&TreeCorner) -> f64) -> Option<f64> {
    let mean = |above: f64| {
        let (mut sum, mut all) = (0.0, 0.0);
        for [a, b, c] in corners.as_chunks().0 {
            if a.at.z + b.at.z + c.at.z >= 3.0 * above {
                let area = (b.at - a.at).cross(c.at - a.at).length();
                sum += value(a) * area;
                all += area;
            }
        }
        (all > 0.0).then(|| sum / all)
    };
    mean(CROWN).or_else(|| mean(0.0))
}

fn lightness_of_crown(corners: &[TreeCorner]) -> f64 {
    mean_of_crown(corners, |corner| corner.lightness).unwrap_or(PLAIN_LIGHTNESS)
}

/// Returns the share of the crown that has each of `count` colours; if the tree has no area, all of it has the first.
fn crown_shares(corners: &[TreeCorner], count: usize) -> Vec<f64> {
    let share = |color_index: usize| {
        mean_of_crown(corners, |corner| f64::from(u8::from(usize::from(corner.color_index) == color_index)))
    };
    (0..count).map(|color_index| share(color_index).unwrap_or(if color_index == 0 { 1.0 } else { 0.0 })).collect()
}

/// Number of views of an outline, over half a turn.
const SIDES: u32 = 6;
/// Number of rows at the top of a view that are the tip.
const TIP_ROWS: usize = 9;

// Models of dead trees have a fill of 0.53 and 0.54, all others at least 0.87; tips of conifers have 0.09 to 0.23,
// those of other trees at least 0.3. Bushes may be pointed, but are wide.
const MIN_FILL: f64 = 0.7;
const MIN_AREA: f64 = 0.05;
const BLUNT_TIP: f64 = 0.265;
const WIDE: f64 = 0.85;

/// Measures of a tree's outline seen from the side; the tree has height 1.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// Covered area, in squares of the tree's height.
    area: f64,
    /// Covered share of the width between the outermost points.
    fill: f64,
    /// Width at the widest height.
    width: f64,
    /// Width of the topmost seventh, relative to the largest width.
    tip: f64,
}

impl Shape {
    fn of(corners: &[TreeCorner]) -> Self {
        let reach = corners.iter().map(|corner| corner.at.truncate().length()).fold(1e-6, f64::max);
        // For each height: the covered width, and the width between the outermost covered points.
        let mut heights = [[0.0_f64; 2]; SIDE_PX];
        for side in 0..SIDES {
            let right = DVec2::from_angle(f64::from(side) / f64::from(SIDES) * std::f64::consts::PI);
            let on_picture = |corner: &TreeCorner| {
                DVec2::new(0.5 + 0.5 * corner.at.truncate().dot(right) / reach, corner.at.z) * SIDE_PX as f64
            };
            let mut rows = [0_u64; SIDE_PX];
            for triangle in corners.as_chunks::<3>().0 {
                cover(&mut rows, triangle.each_ref().map(on_picture));
            }
            let px = 2.0 * reach / SIDE_PX as f64 / f64::from(SIDES);
            for ([covered, between], row) in heights.iter_mut().zip(rows) {
                *covered += f64::from(row.count_ones()) * px;
                let free = if row == 0 { u64::BITS } else { row.leading_zeros() + row.trailing_zeros() };
                *between += f64::from(u64::BITS - free) * px;
            }
        }
        let [covered, between] = [0, 1].map(|which| heights.map(|height| height[which]));
        let area: f64 = covered.iter().sum();
        let width = between.iter().copied().fold(1e-9, f64::max);
        let tip = between[SIDE_PX - TIP_ROWS..].iter().sum::<f64>() / TIP_ROWS as f64 / width;
        Self { area: area / SIDE_PX as f64, fill: area / between.iter().sum::<f64>().max(1e-9), width, tip }
    }

    /// Returns the generated species with the most similar canopy.
    fn clump(self) -> Grown {
        if self.fill < MIN_FILL || self.area < MIN_AREA {
            Grown::Snag
        } else if self.tip < BLUNT_TIP && self.width < WIDE {
            Grown::Conifer
        } else {
            Grown::Broadleaf
        }
    }
}

#[cfg(test)]
mod tests;
