// The shape of a tree for hatching marks: a round body, and a plane that faces the eye.
//
// A crown has hundreds of leaves, and marks on each of them would be speckle. A pen gives a tree one shade by the side
// of the crown, in strokes that cross it as if it were flat.
#define_import_path hachure::tree_form
#import hachure::view::View
#import hachure::earth::bend
#import hachure::trees::{TreeInstance, place_on_tree, normal_on_tree}

// Weight of the round body's normal in the shading normal of a leaf.
const ROUND: f32 = 0.6;

// Returns, for a point of a tree in its own units, the normal of the round body within its upright cylinder (radius,
// bottom, top), and how far behind the point the plane through the body's centre that faces the eye is, along the view
// axis.
fn form_of(view: View, tree: TreeInstance, cylinder: vec4<f32>, own: vec3<f32>) -> vec4<f32> {
    let middle = vec3<f32>(0.0, 0.0, 0.5 * (cylinder.y + cylinder.z));
    let half = vec3<f32>(cylinder.xx, 0.5 * (cylinder.z - cylinder.y));
    let round = normal_on_tree(tree, (own - middle) / (half * half) + vec3<f32>(0.0, 0.0, 1e-4));
    let foot_m = bend(tree.flat_m);
    let to_middle_m = foot_m + place_on_tree(tree, middle) - view.eye_m;
    let to_place_m = foot_m + place_on_tree(tree, own) - view.eye_m;
    let reaches = dot(to_middle_m, to_middle_m) / max(dot(to_middle_m, to_place_m), 1e-6 * dot(to_middle_m, to_middle_m));
    let along_m = (view.clip_from_camera * vec4<f32>(to_place_m + view.eye_m, 1.0)).w;
    let max_m = 2.0 * (tree.height_m + tree.width_m);
    return vec4<f32>(round, clamp((reaches - 1.0) * along_m, -max_m, max_m));
}

// Returns the normal for shading. Leaves vary the normal of the body, near the eye as far away, without hiding the
// body.
fn rounded(leaf: vec3<f32>, form: vec4<f32>) -> vec3<f32> {
    return normalize(mix(leaf, form.xyz, ROUND));
}
