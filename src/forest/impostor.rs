//! Impostors: pictures of a tree from many directions, with normals, depths, lightness and colours, from which the tree
//! is drawn with two triangles.
//!
//! The directions are evenly distributed over the upper hemisphere by the hemi-octahedral map (Cigolle and others 2014,
//! "A Survey of Efficient Representations for Independent Unit Vectors", section 3.3): [`FRAMES`] × [`FRAMES`]
//! directions, and for each a picture, its *frame*. [`FRAMES`] is even, so no frame looks straight down, where a
//! picture has no upright direction. Each frame is an orthographic projection of the tree's bounding sphere. To draw a
//! pixel, its ray is traced through the depths of the frame with the nearest direction
//! (`shaders/surface/trees/impostor.wgsl`), so the pixel has the depth of the mesh, as lines, hatching marks and stereo
//! pairs require. The frames are drawn when a forest is first drawn, in f64, and are the same on every machine.
//!
//! Aliasing: if a distant tree read single texels of the finest frame, it would show other leaves after each move by a
//! fraction of a pixel, and its outline and lines would flicker. So there are mip [levels](Level), each the mean of the
//! texels of the one before; the level that matches the pixel size is read with interpolation. Each texel has a
//! coverage, and a point is inside of the tree where coverage is at least ½. Thin branches cover no texel by half, so
//! coverage is scaled until the number of texels with a coverage of at least ½ is the area of the tree in texels
//! (Castaño 2010, "Computing Alpha Mipmaps").

use glam::{DVec2, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

/// Number of frames along each of the map's axes.
pub(crate) const FRAMES: u32 = crate::gpu::wgsl::shared::tree_pictures::FRAMES as u32;
const _: () = assert!(FRAMES.is_multiple_of(2));

/// A corner of a triangle of a tree of height 1. A list holds three for each triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImpostorCorner {
    /// Position; z is up.
    pub at: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// Lightness: 0 is black, 1 is as light as bare land.
    pub lightness: f64,
    /// Index of the colour in a palette ([`super::colors`]), the same for all corners of a triangle.
    pub color_index: u8,
}

/// The frames of a tree.
pub(crate) struct Impostor {
    /// Side of a frame of the finest level.
    pub frame_px: u32,
    /// Centre of the tree's bounding sphere.
    pub middle: DVec3,
    /// Radius of the tree's bounding sphere.
    pub radius: f64,
    /// The mip levels, finest first, each with half as many texels along a side as the one before.
    pub levels: Vec<Level>,
}

/// A mip level: all frames at one size in one atlas, row by row. The atlas has [`FRAMES`] × [`Level::frame_px`] texels
/// along each side.
pub(crate) struct Level {
    /// Side of a frame.
    pub frame_px: u32,
    /// Normal in octahedral coordinates (2), depth toward the eye relative to the radius (−1 to 1), and lightness. The
    /// sign of lightness is negative where the scaled coverage is less than ½. All are 0 where nothing is seen.
    pub texels: Vec<[f16; 4]>,
    /// Depth toward the eye times the scaled coverage, and the scaled coverage, which is ½ at the outline.
    pub outlines: Vec<[f16; 2]>,
    /// Index of the texel's colour in the palette; where nothing is seen, that of a coarser level.
    pub color_indices: Vec<u8>,
}

/// Smallest side of a frame, in texels.
const SMALLEST_PX: u32 = 5;
/// Largest scale of coverage; with a larger one, the few texels that a thin tree covers would show as spots.
const MAX_SCALE: f32 = 4.0;

/// A texel of a frame; except for coverage, its values are means over the covered part.
#[derive(Clone, Copy, Default)]
struct Texel {
    normal: Vec3,
    /// Depth toward the eye relative to the radius, −1 to 1.
    depth: f32,
    lightness: f32,
    /// Coverage, 0 to 1.
    covered: f32,
    /// Index of the colour that covers most of the texel.
    color_index: u8,
}

/// Returns the unit vector from the tree toward the eye of a frame, given by its column and row.
pub(crate) fn direction(frame: [u32; 2]) -> DVec3 {
    let [u, v] = frame.map(|at| 2.0 * f64::from(at) / f64::from(FRAMES - 1) - 1.0);
    let (x, y) = (0.5 * (u + v), 0.5 * (u - v));
    DVec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize()
}

/// Returns the axes of the frame with a direction: right and up.
pub(crate) fn axes(direction: DVec3) -> [DVec3; 2] {
    let right = DVec3::new(-direction.y, direction.x, 0.0).normalize();
    [right, direction.cross(right)]
}

/// Returns a unit vector in octahedral coordinates, −1 to 1 each.
pub(crate) fn octahedral(n: DVec3) -> DVec2 {
    let p = n / (n.x.abs() + n.y.abs() + n.z.abs());
    if p.z >= 0.0 {
        return p.truncate();
    }
    let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
    DVec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

/// Returns how many mip levels pictures of this side have.
pub(crate) fn levels_of(frame_px: u32) -> u32 {
    let (mut levels, mut px) = (1, frame_px);
    while px.is_multiple_of(2) && px / 2 >= SMALLEST_PX {
        (levels, px) = (levels + 1, px / 2);
    }
    levels
}

impl Impostor {
    /// Draws the frames, each of `frame_px` × `frame_px`, which must be more than 2.
    pub(crate) fn draw(corners: &[ImpostorCorner], frame_px: u32) -> Self {
        let low = corners.iter().map(|corner| corner.at).fold(DVec3::INFINITY, DVec3::min);
        let high = corners.iter().map(|corner| corner.at).fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = if corners.is_empty() { DVec3::ZERO } else { 0.5 * (low + high) };
        let farthest = corners.iter().map(|corner| corner.at.distance(middle)).fold(1e-6, f64::max);
        // Leaves a margin of one empty texel all around.
        let radius = farthest * f64::from(frame_px) / f64::from(frame_px - 2);
        let sphere = (middle, radius);
        // Each frame is drawn at twice the size of the finest level, so that its outlines have partial coverage. Only a
        // few such drawings are in memory at a time.
        let mip_levels_of = |frame: u32| {
            let direction = direction([frame % FRAMES, frame / FRAMES]);
            mip_levels(&draw_frame(corners, sphere, 2 * frame_px, direction), 2 * frame_px)
        };
        let frames: Vec<Vec<Vec<Texel>>> = (0..FRAMES * FRAMES).into_par_iter().map(mip_levels_of).collect();
        let mut levels: Vec<Level> = (0..frames[0].len())
            .into_par_iter()
            .map(|number| {
                let at_level: Vec<&[Texel]> = frames.iter().map(|levels| levels[number].as_slice()).collect();
                Level::of(&at_level, frame_px >> number)
            })
            .collect();
        fill_color_indices(&mut levels);
        Self { frame_px, middle, radius, levels }
    }
}

impl Level {
    /// Packs the frames of a level into an atlas.
    fn of(frames: &[&[Texel]], frame_px: u32) -> Self {
        let scale = coverage_scale(frames);
        let side = (FRAMES * frame_px) as usize;
        let (columns, px) = (FRAMES as usize, frame_px as usize);
        let at = |number: usize| {
            let (x, y) = (number % side, number / side);
            &frames[y / px * columns + x / px][y % px * px + x % px]
        };
        let covered = |texel: &Texel| (scale * texel.covered).min(1.0);
        let packed = |texel: &Texel| {
            if texel.covered <= 0.0 {
                return [f16::ZERO; 4];
            }
            let normal = octahedral(texel.normal.normalize_or(Vec3::Z).as_dvec3()).as_vec2();
            let lightness = texel.lightness.max(1e-3) * if covered(texel) >= 0.5 { 1.0 } else { -1.0 };
            [normal.x, normal.y, texel.depth, lightness].map(f16::from_f32)
        };
        let outline = |texel: &Texel| [texel.depth * covered(texel), covered(texel)].map(f16::from_f32);
        let texels = (0..side * side).into_par_iter().map(|number| packed(at(number))).collect();
        let color_indices = (0..side * side).into_par_iter().map(|number| at(number).color_index).collect();
        let outlines = (0..side * side).into_par_iter().map(|number| outline(at(number))).collect();
        Self { frame_px, texels, outlines, color_indices }
    }
}

/// Where nothing is seen, takes the colour index from the next coarser level, because outlines are interpolated between
/// texels.
fn fill_color_indices(levels: &mut [Level]) {
    for finer in (0..levels.len().saturating_sub(1)).rev() {
        let (own, coarser) = levels.split_at_mut(finer + 1);
        let (Some(level), Some(coarser)) = (own.last_mut(), coarser.first()) else { return };
        let side = (FRAMES * level.frame_px) as usize;
        for (number, (color_index, texel)) in level.color_indices.iter_mut().zip(&level.texels).enumerate() {
            if texel[3] == f16::ZERO {
                *color_index = coarser.color_indices[number / side / 2 * (side / 2) + number % side / 2];
            }
        }
    }
}

/// Returns the factor of coverage for which the number of texels with a coverage of at least ½ is the covered area in
/// texels.
fn coverage_scale(frames: &[&[Texel]]) -> f32 {
    let texels = frames.iter().copied().flatten();
    let mut covered: Vec<f32> = texels.map(|texel| texel.covered).filter(|coverage| *coverage > 0.0).collect();
    let area = covered.iter().map(|coverage| f64::from(*coverage)).sum::<f64>().round() as usize;
    if area == 0 {
        return 1.0;
    }
    let last = (area - 1).min(covered.len() - 1);
    let (_, least, _) = covered.select_nth_unstable_by(last, |a, b| b.total_cmp(a));
    (0.5 / *least).clamp(1.0, MAX_SCALE)
}

/// Returns the mip levels of a frame that is drawn with `px` × `px` texels, from half that size on.
fn mip_levels(drawn: &[Texel], mut px: u32) -> Vec<Vec<Texel>> {
    let mut levels = vec![halved(drawn, px as usize)];
    px /= 2;
    while px.is_multiple_of(2) && px / 2 >= SMALLEST_PX {
        levels.push(halved(&levels[levels.len() - 1], px as usize));
        px /= 2;
    }
    levels
}

/// Returns a frame with half as many texels along a side.
fn halved(frame: &[Texel], px: usize) -> Vec<Texel> {
    let half = px / 2;
    let mut coarser = vec![Texel::default(); half * half];
    for (rows, means) in frame.chunks_exact(2 * px).zip(coarser.chunks_exact_mut(half)) {
        let (upper, lower) = rows.split_at(px);
        for ((upper, lower), mean) in upper.chunks_exact(2).zip(lower.chunks_exact(2)).zip(means) {
            *mean = mean_of([&upper[0], &upper[1], &lower[0], &lower[1]]);
        }
    }
    coarser
}

/// Returns the mean of four texels, weighted by their coverage.
fn mean_of(four: [&Texel; 4]) -> Texel {
    let covered = four[0].covered + four[1].covered + four[2].covered + four[3].covered;
    if covered <= 0.0 {
        return Texel::default();
    }
    let (mut mean, mut most) = (Texel { covered: 0.25 * covered, ..Texel::default() }, 0.0);
    for texel in four {
        let share = texel.covered / covered;
        mean.normal += texel.normal * share;
        mean.depth += texel.depth * share;
        mean.lightness += texel.lightness * share;
        if texel.covered > most {
            (most, mean.color_index) = (texel.covered, texel.color_index);
        }
    }
    mean
}

/// Draws the frame with a direction, with `side_px` × `side_px` texels: the nearest triangle at the centre of each.
fn draw_frame(
    corners: &[ImpostorCorner],
    (middle, radius): (DVec3, f64),
    side_px: u32,
    direction: DVec3,
) -> Vec<Texel> {
    let [right, up] = axes(direction);
    let half = 0.5 * f64::from(side_px);
    let px = side_px as usize;
    let projected = |corner: &ImpostorCorner| {
        let at = (corner.at - middle) / radius;
        DVec3::new(half + half * at.dot(right), half - half * at.dot(up), at.dot(direction))
    };
    // Most of what is drawn is hidden by later triangles, so attributes are computed once the nearest ones are known.
    let mut nearest = vec![f64::NEG_INFINITY; px * px];
    let mut seen = vec![u32::MAX; px * px];
    for (number, triangle) in corners.chunks_exact(3).enumerate() {
        let [a, b, c] = [projected(&triangle[0]), projected(&triangle[1]), projected(&triangle[2])];
        let Some(shares) = Shares::of([a, b, c]) else { continue };
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64| {
            (low - 0.5).ceil().max(0.0) as usize..((high + 0.5).floor().max(0.0) as usize).min(px)
        };
        for y in range(low.y, high.y) {
            for x in range(low.x, high.x) {
                let share = shares.at(x, y);
                let depth = share.x * a.z + share.y * b.z + share.z * c.z;
                if share.min_element() >= 0.0 && depth > nearest[y * px + x] {
                    nearest[y * px + x] = depth;
                    seen[y * px + x] = number as u32;
                }
            }
        }
    }
    let mut texels = vec![Texel::default(); px * px];
    for (at, number) in seen.into_iter().enumerate().filter(|(_, number)| *number != u32::MAX) {
        let triangle = &corners[3 * number as usize..][..3];
        let [a, b, c] = [projected(&triangle[0]), projected(&triangle[1]), projected(&triangle[2])];
        let Some(shares) = Shares::of([a, b, c]) else { continue };
        let share = shares.at(at % px, at / px);
        let normal = triangle[0].normal * share.x + triangle[1].normal * share.y + triangle[2].normal * share.z;
        // A sheet seen from behind gets the opposite normal: in a frame, whose y runs down, the signed area of
        // back-facing triangles is positive.
        let is_seen_from_behind = normal.dot(direction) < 0.0 && shares.area > 0.0;
        let normal = if is_seen_from_behind { -normal } else { normal };
        let lightness = DVec3::new(triangle[0].lightness, triangle[1].lightness, triangle[2].lightness).dot(share);
        texels[at] = Texel {
            normal: normal.normalize_or(DVec3::Z).as_vec3(),
            depth: nearest[at] as f32,
            lightness: lightness as f32,
            covered: 1.0,
            color_index: triangle[0].color_index,
        };
    }
    texels
}

/// Barycentric coordinates in a triangle, as linear functions of the texel.
struct Shares {
    /// Coordinates at the centre of the first texel.
    first: DVec3,
    /// Increments for each texel to the right, and down.
    steps: [DVec3; 2],
    /// Twice the signed area of the triangle.
    area: f64,
}

impl Shares {
    /// Returns `None` for a triangle seen edge-on.
    fn of([a, b, c]: [DVec3; 3]) -> Option<Self> {
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area == 0.0 {
            return None;
        }
        let right = DVec3::new(b.y - c.y, c.y - a.y, a.y - b.y) / area;
        let down = DVec3::new(c.x - b.x, a.x - c.x, b.x - a.x) / area;
        let at_origin = DVec3::new(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x) / area;
        Some(Self { first: at_origin + 0.5 * (right + down), steps: [right, down], area })
    }

    /// Returns the coordinates at the centre of a texel.
    fn at(&self, x: usize, y: usize) -> DVec3 {
        self.first + self.steps[0] * x as f64 + self.steps[1] * y as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_octahedral(p: DVec2) -> DVec3 {
        let z = 1.0 - p.x.abs() - p.y.abs();
        let fold = (-z).max(0.0);
        DVec3::new(p.x - fold.copysign(p.x), p.y - fold.copysign(p.y), z).normalize()
    }

    #[test]
    fn frames_look_from_all_over_the_upper_hemisphere() {
        let all: Vec<DVec3> = (0..FRAMES * FRAMES).map(|i| direction([i % FRAMES, i / FRAMES])).collect();
        let farthest_deg = |directions: &[DVec3]| {
            let nearest =
                |d: DVec3| directions.iter().map(|direction| direction.angle_between(d)).fold(f64::INFINITY, f64::min);
            let directions = (0..400).map(|i| {
                let (turn, z) = (2.399_963 * f64::from(i), (f64::from(i) + 0.5) / 400.0);
                DVec3::new(turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z)
            });
            directions.map(nearest).fold(0.0, f64::max).to_degrees()
        };
        assert!(all.iter().all(|d| d.z > -1e-12) && farthest_deg(&all) < 6.0, "{}", farthest_deg(&all));
        // Planted: some sides are missing.
        assert!(farthest_deg(&all[..all.len() - 20]) > 6.0);
        for d in all {
            let [right, up] = axes(d);
            assert!((right.cross(up) - d).length() < 1e-12 && up.z >= 0.0);
            assert!((from_octahedral(octahedral(-d)) + d).length() < 1e-9);
        }
    }

    #[test]
    fn a_ball_looks_the_same_from_everywhere() {
        // A sphere of latitudes and longitudes.
        let at = |i: i32, j: i32| {
            let (a, b) = (f64::from(i) / 32.0 * std::f64::consts::TAU, f64::from(j) / 16.0 * std::f64::consts::PI);
            DVec3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos())
        };
        let corner =
            |n: DVec3| ImpostorCorner { at: n * 0.4 + DVec3::Z * 0.5, normal: n, lightness: 0.5, color_index: 0 };
        let quads = (0..32).flat_map(|i| (0..16).map(move |j| (i, j)));
        let corners: Vec<ImpostorCorner> = quads
            .flat_map(|(i, j)| [(i, j), (i, j + 1), (i + 1, j + 1), (i, j), (i + 1, j + 1), (i + 1, j)])
            .map(|(i, j)| corner(at(i, j)))
            .collect();
        const FRAME_PX: u32 = 64;
        let impostor = Impostor::draw(&corners, FRAME_PX);
        let side = (FRAMES * FRAME_PX) as usize;
        let mut worst = [0.0_f64; 2];
        for (number, texel) in impostor.levels[0].texels.iter().enumerate() {
            let [x, y] = [number % side, number / side].map(|at| at as u32);
            let d = direction([x / FRAME_PX, y / FRAME_PX]);
            let [right, up] = axes(d);
            let [px, py] =
                [x % FRAME_PX, y % FRAME_PX].map(|at| (f64::from(at) + 0.5) / (0.5 * f64::from(FRAME_PX)) - 1.0);
            let [u, v, depth, lightness] = texel.map(f16::to_f64);
            let within = px.hypot(py) * impostor.radius / 0.4;
            if !(0.95..=1.02).contains(&within) {
                assert_eq!(lightness > 0.0, within < 1.0, "{x} {y}");
            }
            if within < 0.95 {
                let n = from_octahedral(DVec2::new(u, v));
                let expected = (right * px - up * py) * impostor.radius / 0.4;
                let expected = expected + d * (1.0 - expected.length_squared()).sqrt();
                worst[0] = worst[0].max(n.angle_between(expected).to_degrees());
                worst[1] = worst[1].max((depth * impostor.radius - 0.4 * expected.dot(d)).abs());
            }
        }
        assert!(worst[0] < 4.0 && worst[1] < 0.015, "{worst:?}");
    }
}
