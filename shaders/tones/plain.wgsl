// Blinn-Phong over an elevation tint: the baseline of every comparison.
#import hachure::power::power
#import hachure::view::{View, from_eye}
#import hachure::seen::{place_seen, surface_seen}
#import hachure::earth::unbend
#ifdef DRAPED_IMAGE
#import hachure::image_tone::{image_light, with_image_hue}
#endif
#ifdef LOCAL_COLOR
#import hachure::local_color::{hue_of, glaze}
#import hachure::surface_id::{has_trait, LOCALLY_COLORED}
#endif

struct Plain {
    to_sun: vec3<f32>,
    camera_z_m: f32,
    // Heights at which the tint begins and ends.
    low_m: f32,
    high_m: f32,
    shininess: f32,
    specular: f32,
    // Weight of the colours of trees and models, 0 to 1.
    local: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> plain: Plain;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var tone: texture_storage_2d<rgba16float, write>;
#ifdef LOCAL_COLOR
@group(0) @binding(5) var surface_id: texture_2d<u32>;
@group(0) @binding(6) var local_color: texture_2d<u32>;

// Reflectance of a material as light as bare land, and exponent for darker ones, since lightness is perceptual.
const LIGHTEST: f32 = 0.7;
const BY_LIGHTNESS: f32 = 2.2;
#endif

fn tint(height_m: f32, up: f32) -> vec3<f32> {
    let t = clamp((height_m - plain.low_m) / (plain.high_m - plain.low_m), 0.0, 1.0);
    let valley = vec3<f32>(0.135, 0.225, 0.085);
    let meadow = vec3<f32>(0.305, 0.335, 0.135);
    let rock = vec3<f32>(0.315, 0.270, 0.225);
    let snow = vec3<f32>(0.880, 0.900, 0.930);
    var color = mix(valley, meadow, smoothstep(0.0, 0.4, t));
    color = mix(color, rock, smoothstep(0.3, 0.65, t));
    color = mix(color, snow, smoothstep(0.68, 0.85, t));
    // On walls there is neither vegetation nor snow.
    return mix(rock, color, smoothstep(0.45, 0.75, up));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(tone, pixel, vec4<f32>(1.0));
        return;
    }
    let surface = surface_seen(normal, pixel);
    let n = surface.xyz;
    let to_eye = -normalize(from_eye(view, at.xyz));
    let diffuse = max(dot(n, plain.to_sun), 0.0);
    let half_way = normalize(to_eye + plain.to_sun);
    let gloss = plain.specular * power(dot(n, half_way), plain.shininess) * f32(diffuse > 0.0);
    let sky_light = 0.22 + 0.10 * n.z;
    // The earth's surface curves away; heights above the sea are measured from it.
    let height_m = unbend(at.xyz).flat_m.z + plain.camera_z_m;
#ifdef LOCAL_COLOR
    var body = surface.w * tint(height_m, n.z);
    if has_trait(textureLoad(surface_id, pixel, 0).r, LOCALLY_COLORED) {
        let hue = hue_of(textureLoad(local_color, pixel, 0).r);
        body = mix(body, glaze(hue.rgb, LIGHTEST * power(surface.w, BY_LIGHTNESS)), plain.local * hue.a);
    }
    var color = body * (sky_light + 0.95 * diffuse) + surface.w * gloss;
#else
    var color = surface.w * (tint(height_m, n.z) * (sky_light + 0.95 * diffuse) + gloss);
#endif
    var asked = surface.w * clamp(sky_light + 0.7 * diffuse, 0.0, 1.0);
#ifdef DRAPED_IMAGE
    // A tone is perceptual, a colour is light.
    let factor = image_light(pixel);
    color = with_image_hue(pixel, color * factor * factor);
    asked *= factor;
#endif
    textureStore(tone, pixel, vec4<f32>(color, asked));
}
