// What images on the land make of a tone. See surface/draped_image.wgsl.
#define_import_path hachure::image_tone
#import hachure::color::luminance
#import hachure::local_color::{hue_of, glaze}

@group(0) @binding(25) var draped_image: texture_2d<u32>;

// Returns the factor of the light at a pixel.
fn image_light(pixel: vec2<i32>) -> f32 {
    return bitcast<f32>(textureLoad(draped_image, pixel, 0).g);
}

// Returns a colour with the hue of the images at a pixel; its luminance stays.
fn with_image_hue(pixel: vec2<i32>, color: vec3<f32>) -> vec3<f32> {
    let hue = hue_of(textureLoad(draped_image, pixel, 0).r);
    return mix(color, glaze(hue.rgb, luminance(color)), hue.a);
}
