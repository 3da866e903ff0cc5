// Selects which lines among trees are drawn: those that a pen would draw.
//
// A detector finds an edge wherever one leaf hides another, and all of them would be black. Near the eye, a tree's
// outline is drawn, and inside it edges that are well clear of what is behind them, so that clumps of leaves are open
// arcs and not cells. The smaller trees are on the picture, the fewer of them are drawn: each tree's own random number
// decides, so each fades in and out by itself, the same for both eyes. Outlines against the sky or against land far
// behind are always drawn. Trees that have strokes get no lines in addition.
//
// The line of a small tree is fine: it is full on the tree and faint on what is behind, in the corners of stairs, and
// around a gap of one pixel. Without its faint side it would be as fine, but flicker twice as much.
//
// Errors of the detector are retained or removed before the density filter, which then sees the actual lines.
#import hachure::view::View
#import hachure::surface_id::{kind_of, TREE}
#import hachure::trees::shows_strokes

struct TreeLines {
    // Mean height of a tree.
    height_m: f32,
    // 1: only lines of trees are wanted.
    only_trees: u32,
    // Errors at which a line begins, and at which it is full.
    ramp: vec2<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> tree_lines: TreeLines;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
@group(0) @binding(4) var errors: texture_2d<f32>;
// Its last channel indicates whether the visible tree has strokes.
@group(0) @binding(5) var tree_normal: texture_2d<f32>;
@group(0) @binding(6) var tree_errors: texture_storage_2d<rgba16float, write>;

// Heights on the picture from which on all trees are outlined against land, and against each other; and the parts of
// smaller trees that are outlined at least.
const OUTLINED_PX: f32 = 34.0;
const APART_PX: f32 = 80.0;
const FEWEST_OUTLINED: f32 = 0.3;
const FEWEST_APART: f32 = 0.1;
// Heights on the picture at which lines within a tree begin to be drawn, and at which all are.
const WITHIN_PX: vec2<f32> = vec2<f32>(70.0, 140.0);
// Heights on the picture up to which lines are fine, and from which on they are as broad as those of the land.
const BROAD_PX: vec2<f32> = vec2<f32>(100.0, 220.0);
// Ink of a fine line on its faint side.
const OUTER_INK: f32 = 0.28;
// Distance to what is behind a line, in heights of the tree, over which the line fades in: within a tree, among trees,
// and against land.
const BEHIND_WITHIN: vec2<f32> = vec2<f32>(0.05, 0.12);
const BEHIND_APART: vec2<f32> = vec2<f32>(0.1, 0.3);
const BEHIND_LAND: vec2<f32> = vec2<f32>(0.06, 0.2);
// Distances beyond which the land behind is another slope: in heights of the tree, and relative to the distance from
// the eye, because land at a flat angle extends far behind.
const BEHIND_ALL: vec2<f32> = vec2<f32>(6.0, 12.0);
const BEHIND_BY_DISTANCE: vec2<f32> = vec2<f32>(0.1, 0.25);

// Returns how far a tree is among the share that is drawn, 0 to 1; it fades in.
fn is_chosen(tree: u32, share: f32) -> f32 {
    let own = fract(f32((tree >> 3u) & 0xffffu) * 0.61803399);
    return clamp((share * 1.1 - own) / 0.1, 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    let last = vec2<i32>(view.size_px) - 1;
    let own = textureLoad(surface_id, p, 0).r;
    var front = 0.0;
    var tree = 0u;
    var tree_at = p;
    var back = 1e30;
    var is_one = true;
    var is_all_trees = true;
    var nears: array<f32, 9>;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let q = clamp(p + vec2<i32>(x, y), vec2<i32>(0), last);
            let other = textureLoad(surface_id, q, 0).r;
            let near = textureLoad(depth, q, 0);
            nears[3 * y + x + 4] = near;
            back = min(back, near);
            is_one = is_one && other == own;
            if kind_of(other) != TREE {
                is_all_trees = false;
            } else if near > front {
                front = near;
                tree = other;
                tree_at = q;
            }
        }
    }
    let found = textureLoad(errors, p, 0);
    if tree == 0u {
        textureStore(tree_errors, p, select(found, vec4<f32>(0.0), tree_lines.only_trees != 0u));
        return;
    }
    if tree_lines.only_trees != 0u && shows_strokes(textureLoad(tree_normal, tree_at, 0).w) {
        textureStore(tree_errors, p, vec4<f32>(0.0));
        return;
    }
    let along_m = view.near_m / front;
    let size_px = tree_lines.height_m * view.focal_px / along_m;
    // In heights of the tree; the sky is far.
    let behind_m = view.near_m / max(back, 1e-12) - along_m;
    let behind = behind_m / tree_lines.height_m;
    var drawn = 0.0;
    if is_one {
        drawn = smoothstep(WITHIN_PX.x, WITHIN_PX.y, size_px) * smoothstep(BEHIND_WITHIN.x, BEHIND_WITHIN.y, behind);
    } else if is_all_trees {
        let share = clamp(size_px / APART_PX, FEWEST_APART, 1.0);
        drawn = is_chosen(tree, share) * smoothstep(BEHIND_APART.x, BEHIND_APART.y, behind);
    } else {
        // Open arcs: there is no line where a crown meets the ground below it.
        let share = clamp(size_px / OUTLINED_PX, FEWEST_OUTLINED, 1.0);
        drawn = is_chosen(tree, share) * smoothstep(BEHIND_LAND.x, BEHIND_LAND.y, behind);
    }
    let is_ridge = smoothstep(BEHIND_ALL.x, BEHIND_ALL.y, behind)
        * smoothstep(BEHIND_BY_DISTANCE.x, BEHIND_BY_DISTANCE.y, behind_m / along_m);
    drawn = max(drawn, is_ridge);
    var pixels_behind = 0;
    for (var i = 0; i < 9; i++) {
        pixels_behind += i32(nears[i] < 0.5 * (front + back));
    }
    // Greater than any error.
    var most = 4.0;
    if nears[4] < 0.5 * (front + back) || pixels_behind < 2 {
        let soft = mix(tree_lines.ramp.x, tree_lines.ramp.y, OUTER_INK);
        most = mix(soft, most, smoothstep(BROAD_PX.x, BROAD_PX.y, size_px));
    }
    textureStore(tree_errors, p, min(found * drawn, vec4<f32>(most)));
}
