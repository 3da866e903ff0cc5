//! Impostors: pictures of a tree from many sides, with normals, depths, lightness and colours, from which the tree is
//! drawn with two triangles.
//!
//! The sides are evenly distributed over the upper half of the directions by the hemi-octahedral map (Cigolle and
//! others 2014, "A Survey of Efficient Representations for Independent Unit Vectors", section 3.3): [`FRAMES`] ×
//! [`FRAMES`] sides. [`FRAMES`] is even, so no side looks straight down, where a picture has no upright direction. Each
//! picture is an orthographic projection of the tree's bounding sphere. To draw a pixel, its ray is traced through the
//! depths of the picture from the nearest side (`shaders/surface/trees/impostor.wgsl`), so the pixel has the depth of
//! the mesh, and lines, hatching marks and both eyes see it like a mesh. The pictures are taken when a forest is first
//! drawn, in f64, and are the same on every machine.
//!
//! A tree of ten pixels that read single texels of a picture of a hundred would show different leaves after each move
//! by a fraction of a pixel, and its outline and lines would flicker. So there are coarser [levels](Level), each the
//! mean of the texels of the one before; the level that matches the pixel size is read with interpolation. Each texel
//! has a coverage, and a point is inside of the tree where coverage is at least a half. Thin branches cover no texel by
//! half, so coverage is scaled until as many texels of a level are covered by half as the tree really covers (Castaño
//! 2010, "Computing Alpha Mipmaps").

use glam::{DVec2, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

/// Number of sides along each of the map's axes.
pub(crate) const FRAMES: u32 = crate::gpu::wgsl::shared::tree_pictures::FRAMES as u32;
const _: () = assert!(FRAMES.is_multiple_of(2));

/// A corner of a triangle, three to each, of a tree of height 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImpostorCorner {
    /// Position; z is up.
    pub at: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// Lightness: 0 is black, 1 is as light as bare land.
    pub lightness: f64,
    /// Index of the colour in a palette ([`super::colors`]), the same for all corners of a triangle.
    pub paint: u8,
}

/// The pictures of a tree.
pub(crate) struct Impostor {
    /// Side of a picture in the finest level.
    pub frame_px: u32,
    /// Centre of the tree's bounding sphere.
    pub middle: DVec3,
    /// Radius of the tree's bounding sphere.
    pub radius: f64,
    /// Levels from the finest on, each with half as many texels along a side as the one before.
    pub levels: Vec<Level>,
}

/// All pictures at one size, in one atlas: row by row, [`FRAMES`] × [`Level::frame_px`] texels along each side.
pub(crate) struct Level {
    /// Side of one picture.
    pub frame_px: u32,
    /// Normal in octahedral coordinates (2), depth toward the eye relative to the radius (−1 to 1), and lightness,
    /// which is negative where coverage is less than a half. 0 where nothing is seen.
    pub texels: Vec<[f16; 4]>,
    /// Depth toward the eye times coverage, and coverage, scaled so that a half is the outline.
    pub outlines: Vec<[f16; 2]>,
    /// Index of the texel's colour in the palette; where nothing is seen, that of a coarser level.
    pub paints: Vec<u8>,
}

/// Pictures are not made smaller than this.
const SMALLEST_PX: u32 = 5;
/// Largest scale of coverage; with a larger one, the few texels that a thin tree covers would show as spots.
const MOST_SCALE: f32 = 4.0;

/// A texel; the values are means over what is covered.
#[derive(Clone, Copy, Default)]
struct Texel {
    normal: Vec3,
    toward: f32,
    lightness: f32,
    /// Coverage, 0 to 1.
    covered: f32,
    /// Index of the colour that covers most of it.
    paint: u8,
}

/// Returns the unit vector toward the eye of a side.
pub(crate) fn direction(frame: [u32; 2]) -> DVec3 {
    let [u, v] = frame.map(|at| 2.0 * f64::from(at) / f64::from(FRAMES - 1) - 1.0);
    let (x, y) = (0.5 * (u + v), 0.5 * (u - v));
    DVec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize()
}

/// Returns the axes of a side's picture: right and up.
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

impl Impostor {
    /// Takes the pictures, each of `frame_px` × `frame_px`.
    pub(crate) fn take(corners: &[ImpostorCorner], frame_px: u32) -> Self {
        let low = corners.iter().map(|corner| corner.at).fold(DVec3::INFINITY, DVec3::min);
        let high = corners.iter().map(|corner| corner.at).fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = if corners.is_empty() { DVec3::ZERO } else { 0.5 * (low + high) };
        let farthest = corners.iter().map(|corner| corner.at.distance(middle)).fold(1e-6, f64::max);
        // Leaves a margin of one empty texel all around.
        let radius = farthest * f64::from(frame_px) / f64::from(frame_px - 2);
        let sphere = (middle, radius);
        // Drawn at twice the finest level, so that its outlines have partial coverage. Only a few are in memory at a
        // time.
        let of_side = |side: u32| {
            let direction = direction([side % FRAMES, side / FRAMES]);
            halvings(&picture(corners, sphere, 2 * frame_px, direction), 2 * frame_px)
        };
        let sides: Vec<Vec<Vec<Texel>>> = (0..FRAMES * FRAMES).into_par_iter().map(of_side).collect();
        let mut levels: Vec<Level> = (0..sides[0].len())
            .into_par_iter()
            .map(|number| {
                let pictures: Vec<&[Texel]> = sides.iter().map(|levels| levels[number].as_slice()).collect();
                Level::of(&pictures, frame_px >> number)
            })
            .collect();
        fill_paints(&mut levels);
        Self { frame_px, middle, radius, levels }
    }
}

impl Level {
    fn of(pictures: &[&[Texel]], frame_px: u32) -> Self {
        let scale = scale_of(pictures);
        let side = (FRAMES * frame_px) as usize;
        let (frames, px) = (FRAMES as usize, frame_px as usize);
        let at = |number: usize| {
            let (x, y) = (number % side, number / side);
            &pictures[y / px * frames + x / px][y % px * px + x % px]
        };
        let covered = |texel: &Texel| (scale * texel.covered).min(1.0);
        let packed = |texel: &Texel| {
            if texel.covered <= 0.0 {
                return [f16::ZERO; 4];
            }
            let normal = octahedral(texel.normal.normalize_or(Vec3::Z).as_dvec3()).as_vec2();
            let lightness = texel.lightness.max(1e-3) * if covered(texel) >= 0.5 { 1.0 } else { -1.0 };
            [normal.x, normal.y, texel.toward, lightness].map(f16::from_f32)
        };
        let outline = |texel: &Texel| [texel.toward * covered(texel), covered(texel)].map(f16::from_f32);
        let texels = (0..side * side).into_par_iter().map(|number| packed(at(number))).collect();
        let paints = (0..side * side).into_par_iter().map(|number| at(number).paint).collect();
        let outlines = (0..side * side).into_par_iter().map(|number| outline(at(number))).collect();
        Self { frame_px, texels, outlines, paints }
    }
}

/// Fills paints where nothing is seen from the next coarser level, because outlines are interpolated between texels.
fn fill_paints(levels: &mut [Level]) {
    for finer in (0..levels.len().saturating_sub(1)).rev() {
        let (own, coarser) = levels.split_at_mut(finer + 1);
        let (Some(level), Some(coarser)) = (own.last_mut(), coarser.first()) else { return };
        let side = (FRAMES * level.frame_px) as usize;
        for (number, (paint, texel)) in level.paints.iter_mut().zip(&level.texels).enumerate() {
            if texel[3] == f16::ZERO {
                *paint = coarser.paints[number / side / 2 * (side / 2) + number % side / 2];
            }
        }
    }
}

/// Returns the scale of coverage for which as many texels are covered by half as are covered in total.
fn scale_of(pictures: &[&[Texel]]) -> f32 {
    let texels = pictures.iter().copied().flatten();
    let mut covered: Vec<f32> = texels.map(|texel| texel.covered).filter(|part| *part > 0.0).collect();
    let area = covered.iter().map(|part| f64::from(*part)).sum::<f64>().round() as usize;
    if area == 0 {
        return 1.0;
    }
    let last = (area - 1).min(covered.len() - 1);
    let (_, least, _) = covered.select_nth_unstable_by(last, |a, b| b.total_cmp(a));
    (0.5 / *least).clamp(1.0, MOST_SCALE)
}

/// Returns a picture of `px` × `px` at half its size, at a quarter, and so on.
fn halvings(picture: &[Texel], mut px: u32) -> Vec<Vec<Texel>> {
    let mut levels = vec![halved(picture, px as usize)];
    px /= 2;
    while px.is_multiple_of(2) && px / 2 >= SMALLEST_PX {
        levels.push(halved(&levels[levels.len() - 1], px as usize));
        px /= 2;
    }
    levels
}

/// Returns a picture with half as many texels along a side.
fn halved(picture: &[Texel], px: usize) -> Vec<Texel> {
    let half = px / 2;
    let mut coarser = vec![Texel::default(); half * half];
    for (rows, means) in picture.chunks_exact(2 * px).zip(coarser.chunks_exact_mut(half)) {
        let (upper, lower) = rows.split_at(px);
        for ((upper, lower), mean) in upper.chunks_exact(2).zip(lower.chunks_exact(2)).zip(means) {
            *mean = mean_of([&upper[0], &upper[1], &lower[0], &lower[1]]);
        }
    }
    coarser
}

fn mean_of(four: [&Texel; 4]) -> Texel {
    let covered = four[0].covered + four[1].covered + four[2].covered + four[3].covered;
    if covered <= 0.0 {
        return Texel::default();
    }
    let (mut mean, mut most) = (Texel { covered: 0.25 * covered, ..Texel::default() }, 0.0);
    for texel in four {
        let share = texel.covered / covered;
        mean.normal += texel.normal * share;
        mean.toward += texel.toward * share;
        mean.lightness += texel.lightness * share;
        if texel.covered > most {
            (most, mean.paint) = (texel.covered, texel.paint);
        }
    }
    mean
}

/// Draws a side's picture: the nearest triangle at the centre of each texel.
fn picture(corners: &[ImpostorCorner], (middle, radius): (DVec3, f64), frame_px: u32, direction: DVec3) -> Vec<Texel> {
    let [right, up] = axes(direction);
    let half = 0.5 * f64::from(frame_px);
    let px = frame_px as usize;
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
                let toward = share.x * a.z + share.y * b.z + share.z * c.z;
                if share.min_element() >= 0.0 && toward > nearest[y * px + x] {
                    nearest[y * px + x] = toward;
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
        // A sheet seen from behind gets the opposite normal.
        let normal = if normal.dot(direction) < 0.0 && shares.area > 0.0 { -normal } else { normal };
        let lightness = DVec3::new(triangle[0].lightness, triangle[1].lightness, triangle[2].lightness).dot(share);
        texels[at] = Texel {
            normal: normal.normalize_or(DVec3::Z).as_vec3(),
            toward: nearest[at] as f32,
            lightness: lightness as f32,
            covered: 1.0,
            paint: triangle[0].paint,
        };
    }
    texels
}

/// Barycentric coordinates of points of the picture, linear in the pixel.
struct Shares {
    /// Coordinates at the centre of the first texel.
    first: DVec3,
    /// Increments per texel to the right, and down.
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
    fn sides_look_from_all_over_the_upper_half() {
        let all: Vec<DVec3> = (0..FRAMES * FRAMES).map(|i| direction([i % FRAMES, i / FRAMES])).collect();
        let farthest_deg = |sides: &[DVec3]| {
            let nearest = |d: DVec3| sides.iter().map(|side| side.angle_between(d)).fold(f64::INFINITY, f64::min);
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
        let corner = |n: DVec3| ImpostorCorner { at: n * 0.4 + DVec3::Z * 0.5, normal: n, lightness: 0.5, paint: 0 };
        let quads = (0..32).flat_map(|i| (0..16).map(move |j| (i, j)));
        let corners: Vec<ImpostorCorner> = quads
            .flat_map(|(i, j)| [(i, j), (i, j + 1), (i + 1, j + 1), (i, j), (i + 1, j + 1), (i + 1, j)])
            .map(|(i, j)| corner(at(i, j)))
            .collect();
        const FRAME_PX: u32 = 64;
        let impostor = Impostor::take(&corners, FRAME_PX);
        let side = (FRAMES * FRAME_PX) as usize;
        let mut worst = [0.0_f64; 2];
        for (number, texel) in impostor.levels[0].texels.iter().enumerate() {
            let [x, y] = [number % side, number / side].map(|at| at as u32);
            let d = direction([x / FRAME_PX, y / FRAME_PX]);
            let [right, up] = axes(d);
            let [px, py] =
                [x % FRAME_PX, y % FRAME_PX].map(|at| (f64::from(at) + 0.5) / (0.5 * f64::from(FRAME_PX)) - 1.0);
            let [u, v, toward, lightness] = texel.map(f16::to_f64);
            let within = px.hypot(py) * impostor.radius / 0.4;
            if !(0.95..=1.02).contains(&within) {
                assert_eq!(lightness > 0.0, within < 1.0, "{x} {y}");
            }
            if within < 0.95 {
                let n = from_octahedral(DVec2::new(u, v));
                let expected = (right * px - up * py) * impostor.radius / 0.4;
                let expected = expected + d * (1.0 - expected.length_squared()).sqrt();
                worst[0] = worst[0].max(n.angle_between(expected).to_degrees());
                worst[1] = worst[1].max((toward * impostor.radius - 0.4 * expected.dot(d)).abs());
            }
        }
        assert!(worst[0] < 4.0 && worst[1] < 0.015, "{worst:?}");
    }
}
