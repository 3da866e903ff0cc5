// The tone of the light on what a pixel shows of the land, for passes that measure or edit tones before they are drawn. Water
// and sky are not land.
#define_import_path hachure::land_tone
#import hachure::seen::place_seen
#import hachure::lit_surface::{LitSurface, lit_surface, view, distance_m}
#import hachure::lit_tone::lit_tone

// Whether the tone comes from light that emphasises relief, and whether crests are lighter. They are no uniform, since a
// pass has at most three (docs/decisions/software-drivers.md).
#ifdef RELIEF
const HAS_RELIEF: bool = true;
#else
const HAS_RELIEF: bool = false;
#endif
#ifdef CRESTS
const HAS_CRESTS: bool = true;
#else
const HAS_CRESTS: bool = false;
#endif

#ifdef WATER
// See surface/water.wgsl.
@group(0) @binding(9) var water: texture_2d<f32>;
#endif

struct LandTone {
    // Whether the pixel shows land, or what stands on it; the rest is only valid there.
    is_land: bool,
    // Position, and distance along the view axis.
    at: vec4<f32>,
    surface: LitSurface,
    tone: f32,
}

fn land_tone(pixel: vec2<i32>) -> LandTone {
    var seen: LandTone;
    seen.at = place_seen(view, distance_m, pixel);
    seen.is_land = seen.at.w > 0.0;
#ifdef WATER
    seen.is_land = seen.is_land && textureLoad(water, pixel, 0).r <= 0.0;
#endif
    if seen.is_land {
        seen.surface = lit_surface(pixel, seen.at);
        seen.tone = lit_tone(seen.surface, pixel, HAS_RELIEF, HAS_CRESTS);
    }
    return seen;
}
