// Draws the sky. It is a function of the direction, or of the position on the sheet, and has no distance: two eyes see
// the same sky, parts of a picture join, and it rotates with the world.
//
// Ruled lines are parallel to the horizon, and their distance from it is measured on the sheet. The height of a ray at
// unit distance along the axis is linear over the picture, so the lines are straight, like those of an engraver's
// ruling machine (Hind 1923, "A History of Engraving and Etching"), and stay in place when the eye turns.
//
// Clouds are heaps of discs on a level base, or bands, in rows of the sky that are closer and flatter toward the
// horizon, like clouds of one altitude. Each cloud is in a cell of its row, and every pixel knows the distance to its
// outline, so that outlines are crisp at any size and have no speckle around them, unlike octaves of noise.
//
// Stars are in the cells of a cube's faces, at most one per cell, placed by a hash. Bokashi is the printer's band of
// graded colour at the top of the sheet, and above the horizon.
#import hachure::view::{View, above_horizon, ray_of_pixel}
#import hachure::pcg::pcg
#import hachure::line_ink::line_ink
#import hachure::power::power

struct SkyLook {
    // Linear colour, like all colours here.
    zenith: vec3<f32>,
    rules_px: f32,
    horizon: vec3<f32>,
    spacing_px: f32,
    cloud: vec3<f32>,
    // Part of their width that ruled lines lose at the horizon; negative: high up.
    fade: f32,
    bokashi_color: vec3<f32>,
    // Height of the band at the top, as a part of the sheet's height.
    bokashi: f32,
    sun: vec3<f32>,
    sun_rad: f32,
    to_sun: vec3<f32>,
    // Part of the cells that have a cloud.
    clouds: f32,
    star: vec3<f32>,
    // Part of the cells that have a star.
    stars: f32,
    // Diameter of the brightest star.
    star_px: f32,
    outline_px: f32,
    horizon_bokashi: f32,
    // 1: clouds are bands.
    streaks: u32,
    // Cosine and sine of the horizon's depression below level.
    below_level: vec2<f32>,
    // Factor of a cloud's colour at its base.
    cloud_shade: vec3<f32>,
    // Width of the ruled lines that shade a cloud's base.
    cloud_rules_px: f32,
    // Left, top, right and bottom of the area inside the paper's margin.
    frame_px: vec4<f32>,
    // 1: clouds are composed for this one picture, so no cloud is cut; 0: they depend on directions alone.
    composed: u32,
    // 1: the disc of a composed picture has its place on the sheet; 0: it is where the light comes from.
    sun_in_view: u32,
    // Width of the glow around the sun, over which it loses half of its light; 0: no glow.
    glow_rad: f32,
    pad_a: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> sky_look: SkyLook;
// rgb: linear colour, before the paper; a: ink of ruled lines and outlines.
@group(0) @binding(2) var sky: texture_storage_2d<rgba16float, write>;

const TURN: f32 = 6.2831855;
// Height above the horizon at which ruled lines have their full width (or, for a negative fade, their least), in focal
// lengths.
const FADED: f32 = 0.6;
// How far below the level of the eye ruled lines begin to narrow, and where they end, in focal lengths: from a height the
// skyline is lower, and heights of a small area end before the horizon.
const DEEP: vec2<f32> = vec2<f32>(0.1, 0.35);
// Gap between ruled lines and clouds or the sun.
const GAP_PX: f32 = 1.5;
// Rows of clouds, elevation of the lowest base in radians, and ratio between the elevations of consecutive bases.
const ROWS: u32 = 6u;
const LOWEST_RAD: f32 = 0.045;
const NEXT_ROW: f32 = 1.75;
// Width of a cell relative to the width of its widest cloud.
const CELL: f32 = 1.5;
// Discs of a heap along its base, and in all; discs of a band.
const BASE_DISCS: u32 = 6u;
const DISCS: u32 = 14u;
const STREAK_DISCS: u32 = 8u;
// Height of the tallest cloud in half widths, before it is flattened, and up to which part of that it has shade.
const TALLEST: f32 = 0.72;
const SHADED: f32 = 0.34;
// Place of a composed sun: its distance from the middle of the frame as a part of the width, on the side that light comes
// from, and its distance from above as a part of the sky's height. Sine of the light's direction, counted from that of the
// view, from which on the distance is the whole one. Least height of a sky that has a sun, in radii.
const SUN_ASIDE: f32 = 0.3;
const SUN_DOWN: f32 = 0.4;
const WHOLLY_ASIDE: f32 = 0.3;
const LEAST_SKY: f32 = 3.5;
// Part of the sun's light next to its disc, with a glow.
const GLOW: f32 = 0.35;
// Air between clouds and the frame, as a part of the picture's width and height.
const AIR: f32 = 0.02;
// Size below which a cloud at the frame is left out, as a part of its own.
const LEAST_FIT: f32 = 0.35;
// Part of an outline's width that is left where it faces the light.
const LIT_OUTLINE: f32 = 0.45;
// Cells along the side of a cube's face; each may have a star.
const STAR_CELLS: f32 = 72.0;
// Border of a cell that is kept free of star centres, as a fraction of the cell's side.
const STAR_BORDER: f32 = 0.2;
const FAR_PX: f32 = 1e6;

// Returns two random numbers in [0, 1) for a cell and a number.
fn chance(cell: vec2<i32>, number: u32) -> vec2<f32> {
    let mixed = pcg(pcg(vec2<u32>(cell)) + vec2<u32>(number * 747796405u, number));
    return vec2<f32>(mixed >> vec2<u32>(8u)) / 16777216.0;
}

// Returns the part of a pixel inside an outline at a signed distance, negative inside.
fn cover(away_px: f32) -> f32 {
    return clamp(0.5 - away_px, 0.0, 1.0);
}

// Returns the ink of ruled lines of a width at a height above the horizon.
fn rules(above_px: f32, width_px: f32) -> f32 {
    let number = floor(above_px / sky_look.spacing_px);
    let middle_px = (number + 0.5) * sky_look.spacing_px;
    let high = clamp(middle_px / (FADED * view.focal_px), 0.0, 1.0);
    let lost = max(sky_look.fade, 0.0) * (1.0 - high) + max(-sky_look.fade, 0.0) * high;
    let deep = smoothstep(DEEP.x, DEEP.y, -middle_px / view.focal_px);
    return line_ink(above_px - middle_px, width_px * (1.0 - lost) * (1.0 - deep));
}

// What a pixel has of the nearest cloud.
struct Cloud {
    // Signed distance to the outline, negative inside.
    away_px: f32,
    // How much the nearest piece of the outline faces the light, 0 to 1; a level base faces away.
    lit: f32,
    // Shade inside the cloud: 1 at its base, 0 toward its top.
    shade: f32,
    // 1 where the nearest piece of the outline is the level base.
    at_base: f32,
}

// Returns the signed distance to the outline of a cloud, negative inside, the gradient's length, and the outline's
// outward direction. `at` is the position relative to the middle of the cloud's base, in half widths; `flat` is the
// vertical scale of its discs.
fn cloud_at(at: vec2<f32>, flat: f32, cell: vec2<i32>) -> vec4<f32> {
    let p = vec2<f32>(at.x, at.y / flat);
    var nearest = vec4<f32>(1e9, 1.0, 0.0, 1.0);
    let is_streak = sky_look.streaks == 1u;
    let discs = select(DISCS, STREAK_DISCS, is_streak);
    for (var i = 0u; i < discs; i++) {
        let by_chance = chance(cell, 8u + i);
        let place = f32(i);
        var middle: vec2<f32>;
        var radius: f32;
        if is_streak && i < 5u {
            let along = (place - 2.0) * 0.36 + 0.1 * (by_chance.x - 0.5);
            radius = (0.36 - 0.3 * along * along) * (0.8 + 0.35 * by_chance.y);
            middle = vec2<f32>(along, 0.45 * radius);
        } else if is_streak {
            // A second, shorter band next to the first.
            let side = select(-1.0, 1.0, (pcg(vec2<u32>(cell)).x & 1u) == 1u);
            radius = 0.2 + 0.08 * by_chance.y;
            middle = vec2<f32>(side * 0.35 + (place - 6.0) * 0.2, 0.5);
        } else if i < BASE_DISCS {
            let along = (place - 2.5) * 0.29 + 0.08 * (by_chance.x - 0.5);
            radius = (0.3 - 0.24 * along * along) * (0.75 + 0.5 * by_chance.y);
            middle = vec2<f32>(along, 0.45 * radius);
        } else {
            let along = (place - 9.5) * 0.17 + 0.12 * (by_chance.x - 0.5);
            let high = pcg(vec2<u32>(cell) + vec2<u32>(i, 77u)).y >> 8u;
            radius = 0.1 + 0.12 * by_chance.y;
            middle = vec2<f32>(along, 0.16 + 0.34 * f32(high) / 16777216.0 * (1.0 - 1.7 * along * along));
        }
        let way = p - middle;
        let away = length(way);
        if away - radius < nearest.x {
            let along = way / max(away, 1e-6);
            nearest = vec4<f32>(away - radius, length(vec2<f32>(along.x, along.y / flat)), along);
        }
    }
    // The base is level, but not by a ruler.
    let phase = chance(cell, 4u);
    let base = 0.025 * (sin(7.0 * p.x + 6.3 * phase.x) + sin(13.0 * p.x + 6.3 * phase.y));
    if !is_streak && base - p.y > nearest.x {
        return vec4<f32>(base - p.y, 1.0 / flat, 0.0, -1.0);
    }
    return nearest;
}

// Returns the position of a direction on the picture, and a third number that is positive in front of the eye.
fn on_sheet(toward: vec3<f32>) -> vec3<f32> {
    let across = normalize(cross(view.ray_dx, view.ray_dy));
    let axis = select(-across, across, dot(across, view.ray_corner) > 0.0);
    let ahead = dot(toward, axis);
    let off = toward / max(ahead, 1e-4) - view.ray_corner;
    return vec3<f32>(vec2<f32>(dot(off, view.ray_dx), dot(off, view.ray_dy)) / dot(view.ray_dx, view.ray_dx), ahead);
}

// Returns the middle of the sun's disc on a composed picture, and its radius, in pixels; a radius of 0 is no sun.
fn sun_on_sheet() -> vec3<f32> {
    let radius_px = sky_look.sun_rad * view.focal_px;
    if sky_look.sun_in_view == 0u {
        let middle = on_sheet(sky_look.to_sun);
        return vec3<f32>(middle.xy, select(0.0, radius_px, middle.z > 0.0));
    }
    let frame_px = sky_look.frame_px;
    let right = view.ray_dx.xy / max(length(view.ray_dx.xy), 1e-12);
    let aside = dot(sky_look.to_sun.xy, right) / max(length(sky_look.to_sun.xy), 1e-6);
    let x = mix(frame_px.x, frame_px.z, 0.5 + SUN_ASIDE * clamp(aside / WHOLLY_ASIDE, -1.0, 1.0));
    // The horizon at that column.
    let horizon_px = -(view.ray_corner.z + x * view.ray_dx.z) / select(view.ray_dy.z, -1e-9, view.ray_dy.z > -1e-9);
    let sky_px = min(horizon_px, frame_px.w) - frame_px.y;
    return vec3<f32>(x, frame_px.y + SUN_DOWN * sky_px, select(0.0, radius_px, sky_px > LEAST_SKY * radius_px));
}

// Returns what a pixel at a position on the picture has of clouds.
fn cloud_seen(px: vec2<f32>, azimuth: f32, elevation: f32, pixel_rad: f32) -> Cloud {
    var seen = Cloud(FAR_PX, 0.0, 0.0, 0.0);
    let is_streak = sky_look.streaks == 1u;
    // Upward on the sheet, away from the horizon.
    let up = normalize(vec2<f32>(view.ray_dx.z, view.ray_dy.z) + vec2<f32>(0.0, -1e-12));
    let disc = sun_on_sheet();
    for (var row = 0u; row < ROWS; row++) {
        let base = LOWEST_RAD * power(NEXT_ROW, f32(row));
        let half_width = 0.85 * base + 0.03;
        let low = mix(0.6, 1.0, f32(row) / f32(ROWS - 1u)) * select(1.0, 0.2, is_streak);
        if abs(elevation - base) < half_width {
            let around = cos(base);
            let cells = floor(TURN * around / (2.0 * CELL * half_width));
            let place = (azimuth / TURN + 0.37 * f32(row)) * cells;
            let wrapped = (floor(place) % cells + cells) % cells;
            let cell = vec2<i32>(i32(wrapped), i32(row));
            let size = chance(cell, 1u);
            let flat = low * (0.65 + 0.35 * size.y);
            if chance(cell, 0u).x < sky_look.clouds {
                var half = half_width * (0.55 + 0.45 * size.x);
                let shift = (chance(cell, 2u) - 0.5) * vec2<f32>(0.6 * half_width, 0.4 * base);
                let x = (place - floor(place) - 0.5) * TURN * around / cells - shift.x;
                var at = vec2<f32>(x, elevation - base - shift.y);
                var px_of_one = half / pixel_rad;
                if sky_look.composed == 1u {
                    // The base is level on the sheet, and the whole cloud is within the frame: it is smaller near it.
                    let middle_azimuth = azimuth - x / around;
                    let high = base + shift.y;
                    let toward = vec3<f32>(vec2<f32>(sin(middle_azimuth), cos(middle_azimuth)) * cos(high), sin(high));
                    let middle = on_sheet(toward);
                    if middle.z <= 0.0 {
                        continue;
                    }
                    let middle_px = middle.xy;
                    let whole_px = half * view.focal_px;
                    let tall_px = whole_px * flat * TALLEST;
                    let air_px = AIR * (sky_look.frame_px.zw - sky_look.frame_px.xy);
                    let aside_px = min(middle_px.x - sky_look.frame_px.x, sky_look.frame_px.z - middle_px.x) - air_px.x;
                    let above_px = middle_px.y - sky_look.frame_px.y - air_px.y;
                    var fits = min(1.0, min(aside_px / whole_px, above_px / tall_px));
                    if sky_look.sun_in_view == 1u {
                        // Nor does a cloud cover the sun.
                        let clear_px = length((middle_px - disc.xy) * vec2<f32>(1.0, 1.6)) - 1.3 * disc.z;
                        fits = select(fits, min(fits, clear_px / whole_px), disc.z > 0.0);
                    }
                    if fits < LEAST_FIT {
                        continue;
                    }
                    half *= fits * smoothstep(LEAST_FIT, LEAST_FIT + 0.2, fits);
                    let way = px - middle_px;
                    at = vec2<f32>(-up.y * way.x + up.x * way.y, dot(up, way)) / view.focal_px;
                    px_of_one = half * view.focal_px;
                }
                let found = cloud_at(at / half, flat, cell);
                let away_px = found.x * px_of_one / found.y;
                if away_px < seen.away_px {
                    let aside = vec2<f32>(cos(azimuth), -sin(azimuth));
                    let light = normalize(vec2<f32>(dot(sky_look.to_sun.xy, aside), sky_look.to_sun.z + 0.35));
                    let high = at.y / (half * flat) + 0.2 * at.x / half * light.x;
                    seen.away_px = away_px;
                    seen.lit = smoothstep(-0.2, 0.7, dot(found.zw, light));
                    seen.shade = 1.0 - smoothstep(0.04, SHADED, high);
                    seen.at_base = f32(found.w == -1.0);
                }
            }
        }
    }
    return seen;
}

// Returns the brightness at this direction of the star in the direction's cell, 0 to 1.
fn star_light(way: vec3<f32>, height: f32, pixel_rad: f32) -> f32 {
    let size = abs(way);
    var face = 0;
    var major = way.x;
    var minor = way.yz;
    if size.y > size.x && size.y >= size.z {
        face = 2;
        major = way.y;
        minor = way.zx;
    } else if size.z > size.x && size.z > size.y {
        face = 4;
        major = way.z;
        minor = way.xy;
    }
    face += select(0, 1, major < 0.0);
    // Angles divide a face into cells of nearly one size.
    let on_face = atan(minor / abs(major)) * (8.0 / TURN);
    let place = (on_face * 0.5 + 0.5) * STAR_CELLS;
    let cell = vec2<i32>(floor(place)) + vec2<i32>(face * 1000, 5000);
    let has = chance(cell, 0u);
    // The air absorbs faint stars near the horizon.
    if has.x >= sky_look.stars * smoothstep(0.0, 0.45, height) {
        return 0.0;
    }
    let centre = floor(place) + STAR_BORDER + (1.0 - 2.0 * STAR_BORDER) * chance(cell, 1u);
    let angles = (centre / STAR_CELLS * 2.0 - 1.0) * (TURN / 8.0);
    let on_cube = tan(angles) * abs(major);
    var toward = vec3<f32>(major, on_cube);
    if face / 2 == 1 {
        toward = vec3<f32>(on_cube.y, major, on_cube.x);
    } else if face / 2 == 2 {
        toward = vec3<f32>(on_cube, major);
    }
    let away_px = length(cross(normalize(toward), way)) / pixel_rad;
    let bright = has.y * has.y;
    // The star stays inside its cell, however small the picture is.
    let border_px = STAR_BORDER * TURN / (4.0 * STAR_CELLS) / pixel_rad;
    let radius_px = min(0.5 * sky_look.star_px * mix(0.5, 1.0, bright), border_px);
    // A star smaller than a pixel is fainter instead.
    return mix(0.35, 1.0, bright) * min(4.0 * radius_px * radius_px, 1.0)
        * clamp(max(radius_px, 0.5) + 0.5 - away_px, 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let ray = ray_of_pixel(view, pixel);
    let away = length(ray);
    let way = ray / away;
    // The mean of a pixel's angular size along the radius and across it.
    let pixel_rad = 1.0 / (view.focal_px * away * sqrt(away));
    // Sine of the height above the horizon.
    let height = above_horizon(way.z, sky_look.below_level);
    var color = mix(sky_look.horizon, sky_look.zenith, clamp(height * 2.0, 0.0, 1.0));
    // Pixels above the horizon, on the sheet. A view straight down or up has no horizon.
    let rise = length(vec2<f32>(view.ray_dx.z, view.ray_dy.z));
    let above_px = clamp(ray.z / max(rise, 1e-9), -FAR_PX, FAR_PX);
    let top = (f32(pixel.y + view.origin_px.y) + 0.5) / view.picture_px.y;
    // Far below the horizon, as around a map, there is no sky.
    let is_sky = clamp(1.0 + 4.0 * height, 0.0, 1.0);
    if sky_look.bokashi > 0.0 {
        color = mix(color, sky_look.bokashi_color, is_sky * (1.0 - smoothstep(0.0, sky_look.bokashi, top)));
    }
    if sky_look.horizon_bokashi > 0.0 {
        let high = max(above_px, 0.0) / view.picture_px.y;
        color = mix(color, sky_look.bokashi_color, is_sky * (1.0 - smoothstep(0.0, sky_look.horizon_bokashi, high)));
    }
    if sky_look.stars > 0.0 && height > 0.0 {
        color = mix(color, sky_look.star, star_light(way, height, pixel_rad));
    }
    var ink = 0.0;
    if sky_look.rules_px > 0.0 && above_px > -DEEP.y * view.focal_px && rise > 1e-6 {
        ink = rules(above_px, sky_look.rules_px);
    }
    if sky_look.sun_rad > 0.0 {
        let angle = atan2(length(cross(way, sky_look.to_sun)), dot(way, sky_look.to_sun));
        var sun_px = (angle - sky_look.sun_rad) / pixel_rad;
        if sky_look.composed == 1u {
            // A disc on the sheet, also where a lens would draw it as an ellipse.
            let disc = sun_on_sheet();
            sun_px = length(vec2<f32>(pixel + view.origin_px) + 0.5 - disc.xy) - disc.z;
            sun_px = select(FAR_PX, sun_px, disc.z > 0.0);
        }
        if sky_look.glow_rad > 0.0 {
            let glow_px = sky_look.glow_rad * select(1.0 / pixel_rad, view.focal_px, sky_look.composed == 1u);
            color = mix(color, sky_look.sun, GLOW * exp2(-max(sun_px, 0.0) / glow_px));
        }
        color = mix(color, sky_look.sun, cover(sun_px));
        ink = max(ink * (1.0 - cover(sun_px - GAP_PX)), line_ink(sun_px, sky_look.outline_px));
    }
    if sky_look.clouds > 0.0 && height > 0.0 {
        let px = vec2<f32>(pixel + view.origin_px) + 0.5;
        let cloud = cloud_seen(px, atan2(way.x, way.y), asin(min(height, 1.0)), pixel_rad);
        let color_there = sky_look.cloud * mix(vec3<f32>(1.0), sky_look.cloud_shade, cloud.shade);
        color = mix(color, color_there, cover(cloud.away_px));
        ink *= 1.0 - cover(cloud.away_px - GAP_PX);
        // Ruled lines end the shade at the base in place of an outline.
        let is_ruled = sky_look.cloud_rules_px > 0.0;
        let open = cloud.at_base * f32(is_ruled);
        let width_px = sky_look.outline_px * mix(1.0, LIT_OUTLINE, cloud.lit) * (1.0 - open);
        ink = max(ink, line_ink(cloud.away_px, width_px));
        if is_ruled && above_px > -DEEP.y * view.focal_px && rise > 1e-6 {
            // Strokes of a hand: each begins and ends at a place of its own.
            let row = i32(floor(above_px / sky_look.spacing_px));
            let ends = chance(vec2<i32>(row, i32(floor(px.x / (23.0 * sky_look.spacing_px)))), 3u);
            let inset_px = GAP_PX + ends.x * ends.y * 9.0 * sky_look.spacing_px;
            let shade_ink = rules(above_px, sky_look.cloud_rules_px * cloud.shade);
            ink = max(ink, shade_ink * cover(cloud.away_px + inset_px * (1.0 - cloud.at_base)));
        }
    }
    textureStore(sky, pixel, vec4<f32>(color, ink));
}
