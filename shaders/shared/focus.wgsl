// The focus of a picture: about it everything has its full contrast, and away from it less.
#define_import_path hachure::focus
#import hachure::view::{View, distance_from_eye}

// What the focus is about.
const NO_FOCUS: u32 = 0u;
const AT_DISTANCE: u32 = 1u;
const ON_PICTURE: u32 = 2u;
const AT_PLACE: u32 = 3u;

// What ink that is far from the focus loses of its width, where it loses all of its contrast.
const THINNER: f32 = 0.4;

struct Focus {
    // A place, in metres from the rig's origin; or one on the picture, in parts of its width and of its height.
    at: vec3<f32>,
    about: u32,
    // Unit: along it a place has no height of its own. 0: it has one.
    axis: vec3<f32>,
    // From the eye.
    distance_m: f32,
    // Full contrast reaches so far: metres, or parts of the picture's height.
    extent: f32,
    // How much of the contrast is gone far from it.
    strength: f32,
}

// What is left of contrast at a place, which is seen at `sheet_px` of the whole picture: 1 within the focus, and everywhere
// if there is none.
fn in_focus(focus: Focus, view: View, at_m: vec3<f32>, sheet_px: vec2<f32>) -> f32 {
    if focus.about == NO_FOCUS {
        return 1.0;
    }
    var off = abs(distance_from_eye(view, at_m) - focus.distance_m);
    if focus.about == ON_PICTURE {
        off = distance(sheet_px, focus.at.xy * view.picture_px) / view.picture_px.y;
    }
    if focus.about == AT_PLACE {
        let beside = at_m - focus.at;
        off = length(beside - focus.axis * dot(beside, focus.axis));
    }
    let t = max(off / focus.extent - 1.0, 0.0);
    return 1.0 - focus.strength * (1.0 - exp(-t * t));
}

// Half of what is left, as a factor: marks have one in their tone and one in their ink, lines one in their ink and the
// other in their width.
fn half_of_focus(clear: f32) -> f32 {
    return sqrt(clear);
}

// How wide a line is where so much of its contrast is left, by its full width.
fn focus_width(clear: f32) -> f32 {
    return 1.0 - THINNER * (1.0 - clear);
}
