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
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> sky_look: SkyLook;
// rgb: linear colour, before the paper; a: ink of ruled lines and outlines.
@group(0) @binding(2) var sky: texture_storage_2d<rgba16float, write>;

const TURN: f32 = 6.2831855;
// Height above the horizon at which ruled lines have their full width (or, for a negative fade, their least), in focal
// lengths.
const FADED: f32 = 0.6;
// Gap between ruled lines and clouds or the sun.
const GAP_PX: f32 = 1.5;
// Rows of clouds, elevation of the lowest base in radians, and ratio between the elevations of consecutive bases.
const ROWS: u32 = 6u;
const LOWEST_RAD: f32 = 0.045;
const NEXT_ROW: f32 = 1.75;
// Width of a cell relative to the width of its widest cloud.
const CELL: f32 = 1.5;
// Discs of a cloud along its base, and in all.
const BASE_DISCS: u32 = 5u;
const DISCS: u32 = 8u;
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

// Returns the ink of ruled lines at a height above the horizon.
fn rules(above_px: f32) -> f32 {
    let number = floor(above_px / sky_look.spacing_px);
    let middle_px = (number + 0.5) * sky_look.spacing_px;
    let high = clamp(middle_px / (FADED * view.focal_px), 0.0, 1.0);
    let lost = max(sky_look.fade, 0.0) * (1.0 - high) + max(-sky_look.fade, 0.0) * high;
    return line_ink(above_px - middle_px, sky_look.rules_px * (1.0 - lost));
}

// Returns the signed distance to the outline of a cloud, negative inside, and its gradient's length. `at` is the
// position relative to the middle of the cloud's base, in half widths; `flat` is the vertical scale of its discs.
fn cloud_at(at: vec2<f32>, flat: f32, cell: vec2<i32>) -> vec2<f32> {
    let p = vec2<f32>(at.x, at.y / flat);
    var nearest = vec2<f32>(1e9, 1.0);
    for (var i = 0u; i < DISCS; i++) {
        let by_chance = chance(cell, 8u + i);
        var middle: vec2<f32>;
        var radius: f32;
        if i < BASE_DISCS {
            let along = (f32(i) - 2.0) * 0.36 + 0.1 * (by_chance.x - 0.5);
            radius = (0.36 - 0.3 * along * along) * (0.8 + 0.35 * by_chance.y);
            middle = vec2<f32>(along, 0.45 * radius);
        } else if sky_look.streaks == 1u {
            // A second, shorter band next to the first.
            let side = select(-1.0, 1.0, (pcg(vec2<u32>(cell)).x & 1u) == 1u);
            radius = 0.2 + 0.08 * by_chance.y;
            middle = vec2<f32>(side * 0.35 + (f32(i) - 6.0) * 0.2, 0.5);
        } else {
            radius = 0.2 + 0.14 * by_chance.y;
            middle = vec2<f32>((f32(i) - 6.0) * 0.27 + 0.16 * (by_chance.x - 0.5), 0.26 + 0.14 * by_chance.y);
        }
        let way = p - middle;
        let away = length(way);
        if away - radius < nearest.x {
            let along = way / max(away, 1e-6);
            nearest = vec2<f32>(away - radius, length(vec2<f32>(along.x, along.y / flat)));
        }
    }
    if sky_look.streaks == 0u && -p.y > nearest.x {
        return vec2<f32>(-p.y, 1.0 / flat);
    }
    return nearest;
}

// Returns the distance to the nearest outline of a cloud in pixels, negative inside.
fn clouds_px(azimuth: f32, elevation: f32, pixel_rad: f32) -> f32 {
    var nearest_px = FAR_PX;
    var base = LOWEST_RAD;
    for (var row = 0u; row < ROWS; row++) {
        let half_width = 0.85 * base + 0.03;
        var flat = mix(0.6, 1.0, f32(row) / f32(ROWS - 1u));
        if sky_look.streaks == 1u {
            flat *= 0.2;
        }
        if abs(elevation - base) < half_width {
            let around = cos(base);
            let cells = floor(TURN * around / (2.0 * CELL * half_width));
            let place = (azimuth / TURN + 0.37 * f32(row)) * cells;
            let wrapped = (floor(place) % cells + cells) % cells;
            let cell = vec2<i32>(i32(wrapped), i32(row));
            let size = chance(cell, 1u);
            if chance(cell, 0u).x < sky_look.clouds {
                let half = half_width * (0.55 + 0.45 * size.x);
                let shift = (chance(cell, 2u) - 0.5) * vec2<f32>(0.8 * half_width, 0.4 * base);
                let x = (place - floor(place) - 0.5) * TURN * around / cells - shift.x;
                let found = cloud_at(vec2<f32>(x, elevation - base - shift.y) / half, flat, cell);
                nearest_px = min(nearest_px, found.x * half / (found.y * pixel_rad));
            }
        }
        base *= NEXT_ROW;
    }
    return nearest_px;
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
    if sky_look.rules_px > 0.0 && above_px > 0.0 && rise > 1e-6 {
        ink = rules(above_px);
    }
    if sky_look.sun_rad > 0.0 {
        let angle = atan2(length(cross(way, sky_look.to_sun)), dot(way, sky_look.to_sun));
        let sun_px = (angle - sky_look.sun_rad) / pixel_rad;
        color = mix(color, sky_look.sun, cover(sun_px));
        ink = max(ink * (1.0 - cover(sun_px - GAP_PX)), line_ink(sun_px, sky_look.outline_px));
    }
    if sky_look.clouds > 0.0 && height > 0.0 {
        let away_px = clouds_px(atan2(way.x, way.y), asin(min(height, 1.0)), pixel_rad);
        color = mix(color, sky_look.cloud, cover(away_px));
        ink = max(ink * (1.0 - cover(away_px - GAP_PX)), line_ink(away_px, sky_look.outline_px));
    }
    textureStore(sky, pixel, vec4<f32>(color, ink));
}
