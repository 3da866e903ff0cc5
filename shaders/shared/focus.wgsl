// The focus of a picture: contrast is full around it and falls away from it.
#define_import_path hachure::focus
#import hachure::view::{View, distance_from_eye}

// Kinds of focus: by distance from the eye, around a position on the picture, or around a position in the world.
const NO_FOCUS: u32 = 0u;
const AT_DISTANCE: u32 = 1u;
const ON_PICTURE: u32 = 2u;
const AT_PLACE: u32 = 3u;

// Fraction of its width that ink loses far from the focus, where all contrast is lost.
const THINNER: f32 = 0.4;

struct Focus {
    // A position in metres from the rig's origin; for ON_PICTURE a position in parts of the picture's width and height.
    at: vec3<f32>,
    about: u32,
    // Unit vector along which distance from the focus does not count; 0 if it counts in every direction.
    axis: vec3<f32>,
    // Distance of the focus from the eye, in metres.
    distance_m: f32,
    // Radius of full contrast: metres, or parts of the picture's height.
    extent: f32,
    // Part of the contrast that is lost far from the focus, 0 to 1.
    strength: f32,
}

// Returns the part of the contrast that is left at a position seen at `sheet_px` of the whole picture: 1 within the
// focus, and everywhere if there is none.
fn in_focus(focus: Focus, view: View, at_m: vec3<f32>, sheet_px: vec2<f32>) -> f32 {
    if focus.about == NO_FOCUS {
        return 1.0;
    }
    var off = abs(distance_from_eye(view, at_m) - focus.distance_m);
    if focus.about == ON_PICTURE {
        off = distance(sheet_px, focus.at.xy * view.picture_px) / view.picture_px.y;
    }
    if focus.about == AT_PLACE {
        let away_m = at_m - focus.at;
        off = length(away_m - focus.axis * dot(away_m, focus.axis));
    }
    let t = max(off / focus.extent - 1.0, 0.0);
    return 1.0 - focus.strength * (1.0 - exp(-t * t));
}

// Returns the square root of the contrast that is left. Marks take it once in their tone and once in their ink, lines
// once in their ink and once in their width.
fn half_of_focus(clear: f32) -> f32 {
    return sqrt(clear);
}

// Returns the width of a line relative to its full width, where `clear` of its contrast is left.
fn focus_width(clear: f32) -> f32 {
    return 1.0 - THINNER * (1.0 - clear);
}
