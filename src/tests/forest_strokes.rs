//! Near trees have strokes: the edges that the GPU finds equal those of the meshes in f64, and the strokes drawn from
//! them are outlines.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use crate::tests::helpers::forest::{DrawnTree, listed, of};
use crate::tests::helpers::stroke_lines::strokes_left;
use common::World;
use common::draw::{NOON, draw, places, still};
use common::grid_of;
use glam::{DVec2, DVec3, Vec3};
use hachure::forest::edges::{MeshEdge, edges};
use hachure::forest::species::{Detail, Grown};
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::lines::strokes::stroke::INK;
use hachure::scene::forest::{Form, Species};
use hachure::scene::view::View;
use hachure::style::Style;
use hachure::surface::edges::{EDGE_DRAW, EDGES, Edge};
use hachure::surface::trees::NEAR;
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [480, 270];
const CAMERA: &str = "40,-300,9,10,3,60";
/// Parts of trees nearer than this, along the view axis, are not drawn.
const CLEAR_M: f64 = 5.0;
const CLEARING_M: f64 = 2.0;
/// Tolerance of positions, which are computed in f32.
const EXACT_M: f64 = 0.01;

const FORMS: [(Form, Grown); 4] = [
    (Form::Conifer, Grown::Conifer),
    (Form::Broadleaf, Grown::Broadleaf),
    (Form::Birch, Grown::Birch),
    (Form::Snag, Grown::Snag),
];

struct Bench {
    world: World,
    renderer: Renderer,
    style: Style,
    view: View,
}

impl Bench {
    /// Creates a plain with all species, and a style whose strokes are rebuilt in each frame.
    fn new(camera: &str) -> Option<Self> {
        let mut world = World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02)?;
        let mut forest = of(Form::Conifer, 250.0, 18.0);
        forest.species = FORMS.iter().map(|(form, _)| Species::new(*form, 1.0, 18.0)).collect();
        world.surfaces.set_forest(Some(forest));
        let mut style = common::all_lines("strokes");
        style.strokes_mut().unwrap().update_every = 1;
        let view = still(world.pose(camera), SIZE_PX);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_only_strokes(!common::full());
        Some(Self { world, renderer, style, view })
    }

    /// Draws frames and reads the edges of trees.
    fn edges(&mut self, frames: u32) -> Vec<Edge> {
        let Self { world, renderer, style, view } = self;
        for _ in 0..frames {
            draw(&world.gpu, &mut world.surfaces, renderer, view, style, &NOON);
        }
        let vertices: u32 = strokes_left(&world.gpu, renderer, &EDGE_DRAW, 1)[0];
        let all: Vec<Edge> = strokes_left(&world.gpu, renderer, &EDGES, vertices as usize / 2);
        // Edges of the land request no test of what is behind them.
        all.into_iter().filter(|edge| edge.kind >> 8 > 0).collect()
    }

    /// Returns the trees that have strokes, from near to far, relative to the eye.
    fn near_trees(&self) -> Vec<DrawnTree> {
        let origin_m = self.view.pose.position_m;
        let mut trees = listed(&self.world, &self.renderer, origin_m);
        // At least half of the dither pattern shows the near mesh.
        trees.retain(|tree| tree.level == NEAR && tree.shown[1] >= 0.5);
        let key = |tree: &DrawnTree| ((Vec3::from(tree.instance.flat_m)).length_squared(), tree.instance.id);
        trees.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap());
        trees
    }
}

/// Returns the vertices of a tree's near mesh, relative to the eye, and its edges.
fn standing(tree: &DrawnTree) -> (Vec<DVec3>, Vec<MeshEdge>) {
    let own: Vec<DVec3> = FORMS[tree.species as usize].1.grow(Detail::Near).iter().map(|corner| corner.at).collect();
    let instance = &tree.instance;
    let foot_m = Vec3::from(instance.flat_m).as_dvec3();
    let [sine, cosine] = instance.turn.map(f64::from);
    let at = |corner: &DVec3| {
        let across_m = DVec2::new(cosine, sine).rotate(corner.truncate()) * f64::from(instance.width_m);
        foot_m + across_m.extend(corner.z * f64::from(instance.height_m))
    };
    (own.iter().map(at).collect(), edges(&own))
}

/// Returns the distance up to which a tree is not drawn: the whole tree is left out if its trunk is too near.
fn clear_m(tree: &DrawnTree) -> f64 {
    let foot_m = Vec3::from(tree.instance.flat_m).as_dvec3();
    let height_m = f64::from(tree.instance.height_m);
    let to_trunk_m = foot_m.truncate().extend(0.0_f64.clamp(foot_m.z, foot_m.z + height_m)).length();
    let part = ((to_trunk_m - CLEAR_M) / CLEARING_M).clamp(0.0, 1.0);
    let all_m = to_trunk_m + height_m;
    all_m + part * part * (3.0 - 2.0 * part) * (CLEAR_M - all_m)
}

/// Whether an edge should be in the list.
#[derive(Clone, Copy, PartialEq)]
enum Verdict {
    Yes,
    No,
    /// Rounding or the border of the picture decides.
    Unsure,
}

/// Finds contours by brute force: in the picture, the opposite corners of both triangles are on one side of the edge.
fn verdict(view: &View, clear_m: f64, places: &[DVec3], edge: &MeshEdge) -> Verdict {
    let on_picture = |corner: usize| {
        let at_m = places[corner];
        let is_ahead = at_m.dot(view.pose.forward) > clear_m + 0.01;
        view.place_px(at_m).filter(|_| is_ahead)
    };
    let [Some(a), Some(b)] = edge.ends.map(on_picture) else { return Verdict::Unsure };
    let size = DVec2::new(f64::from(SIZE_PX[0]), f64::from(SIZE_PX[1]));
    let is_within = |p: DVec2| p.cmpgt(DVec2::splat(1.0)).all() && p.cmplt(size - 1.0).all();
    if !is_within(a) || !is_within(b) {
        return Verdict::Unsure;
    }
    let Some(other) = edge.across_other else { return Verdict::Yes };
    let [Some(c), Some(d)] = [edge.across, other].map(on_picture) else { return Verdict::Unsure };
    // The distance from the line through the edge, in pixels.
    let off_px = |p: DVec2| (b - a).perp_dot(p - a) / (b - a).length().max(1e-9);
    if off_px(c).abs().min(off_px(d).abs()) < 0.02 || (b - a).length() < 0.02 {
        return Verdict::Unsure;
    }
    if (off_px(c) > 0.0) == (off_px(d) > 0.0) { Verdict::Yes } else { Verdict::No }
}

/// Compares the list of edges with those of the trees, in order; returns how many edges are right, and how many wrong.
fn compare(bench: &Bench, found: &[Edge], trees: &[DrawnTree], spoil: bool) -> (usize, usize) {
    let is_same = |edge: &Edge, places: &[DVec3], mesh_edge: &MeshEdge| {
        let [a, b] = [edge.a_m, edge.b_m].map(|at_m| Vec3::from(at_m).as_dvec3());
        a.distance(places[mesh_edge.ends[0]]) < EXACT_M && b.distance(places[mesh_edge.ends[1]]) < EXACT_M
    };
    let (mut right, mut wrong, mut next) = (0, 0, 0);
    for tree in trees {
        let (places, edges) = standing(tree);
        let clear_m = clear_m(tree);
        for mesh_edge in &edges {
            let mut verdict = verdict(&bench.view, clear_m, &places, mesh_edge);
            if spoil && mesh_edge.across_other.is_some() {
                verdict = match verdict {
                    Verdict::Yes => Verdict::No,
                    Verdict::No => Verdict::Yes,
                    Verdict::Unsure => Verdict::Unsure,
                };
            }
            let is_found = found.get(next).is_some_and(|edge| is_same(edge, &places, mesh_edge));
            next += usize::from(is_found);
            match verdict {
                Verdict::Unsure => {
                    // An edge that is cut at the near limit has other ends.
                    let is_cut = |edge: &Edge| {
                        let [a, b] = [edge.a_m, edge.b_m].map(|at_m| Vec3::from(at_m).as_dvec3());
                        let [p, q] = mesh_edge.ends.map(|end| places[end]);
                        let off_m = |at: DVec3| (at - p).cross(q - p).length() / p.distance(q).max(1e-9);
                        let cut_m = a.dot(bench.view.pose.forward).min(b.dot(bench.view.pose.forward));
                        (cut_m - clear_m).abs() < EXACT_M && off_m(a).max(off_m(b)) < EXACT_M
                    };
                    next += usize::from(!is_found && found.get(next).is_some_and(is_cut));
                }
                Verdict::Yes | Verdict::No => {
                    if is_found == (verdict == Verdict::Yes) {
                        right += 1;
                    } else {
                        wrong += 1;
                    }
                }
            }
        }
    }
    (right, wrong + found.len() - next)
}

#[test]
fn edges_are_contours_of_the_meshes_in_order_of_distance() {
    let Some(mut bench) = Bench::new(CAMERA) else { return };
    let frames = if common::full() { 2 } else { 1 };
    let found = bench.edges(frames);
    let trees = bench.near_trees();
    let (right, wrong) = compare(&bench, &found, &trees, false);
    println!("{} edges of {} trees; {right} verdicts are right, {wrong} wrong", found.len(), trees.len());
    assert!(trees.len() > 10 && found.len() > 1000 && right > 10_000);
    assert!(wrong * 1000 < right, "{wrong} edges are wrong, {right} right");
    // Planted errors: inverted verdicts, and trees in another order.
    let (right, wrong) = compare(&bench, &found, &trees, true);
    assert!(wrong * 2 > right);
    let mut others = trees.clone();
    others.reverse();
    let (_, wrong) = compare(&bench, &found, &others, false);
    assert!(wrong * 2 > found.len(), "trees in another order have only {wrong} wrong edges");
    // The same list again, in any order of workgroups.
    let again = bench.edges(frames);
    assert_eq!(bytemuck::cast_slice::<Edge, u8>(&again), bytemuck::cast_slice::<Edge, u8>(&found));
}

/// Returns which pixels of near trees have three pixels far behind them on one side, and which have only near pixels
/// around them.
fn outline(bench: &Bench) -> [Vec<bool>; 2] {
    let Bench { world, renderer, .. } = bench;
    let ids = read(&world.gpu, renderer.target(&SURFACE_ID).unwrap(), [0, 0], SIZE_PX).unwrap();
    let ids: Vec<u32> = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
    let along_m: Vec<f64> =
        places(&world.gpu, renderer, 0).iter().map(|at| if at[3] == 0.0 { 1e6 } else { f64::from(at[3]) }).collect();
    let near: Vec<u32> = bench.near_trees().iter().map(|tree| tree.instance.id).collect();
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let is_tree = |i: usize| {
        let (x, y) = (i % width, i / width);
        let is_inside = x > 8 && y > 8 && x + 9 < width && y + 9 < height;
        is_inside && ids[i] >= id::FIRST_TREE && along_m[i] > CLEAR_M + 1.0 && near.contains(&ids[i])
    };
    let is_outline = |i: usize| {
        let is_clear = |step: isize| (1..=3).all(|n| along_m[i.wrapping_add_signed(step * n)] > along_m[i] + 6.0);
        is_tree(i) && [1, -1, width as isize, -(width as isize)].into_iter().any(is_clear)
    };
    let is_within = |i: usize| {
        let around = (-3..=3_isize).flat_map(|y| (-3..=3).map(move |x| y * width as isize + x));
        let is_near = |j: usize| (along_m[j] - along_m[i]).abs() < 0.6;
        is_tree(i) && around.map(|step| i.wrapping_add_signed(step)).all(is_near)
    };
    let all = || 0..width * height;
    [all().map(is_outline).collect(), all().map(is_within).collect()]
}

#[test]
fn outlines_of_near_trees_are_strokes_and_nothing_else_of_them_is() {
    let Some(mut bench) = Bench::new(CAMERA) else { return };
    // Strokes as wide as a line, without tapering, and without the limit on crowded ones.
    let strokes = bench.style.strokes_mut().unwrap();
    (strokes.width_px, strokes.taper_px) = (1.5, 0.0);
    bench.edges(2);
    let [outline, within] = outline(&bench);
    let target = bench.renderer.target(&INK).unwrap();
    let bytes = read(&bench.world.gpu, target, [0, 0], SIZE_PX).unwrap();
    let ink: Vec<bool> =
        bytes.chunks_exact(2).map(|ink| half::f16::from_le_bytes([ink[0], ink[1]]).to_f32() > 0.3).collect();
    let width = SIZE_PX[0] as usize;
    let is_near = |all: &[bool], i: usize, dx: usize| {
        let reach = -2..=2_isize;
        reach
            .clone()
            .any(|y| reach.clone().any(|x| all.get(i.wrapping_add_signed(y * width as isize + x) + dx) == Some(&true)))
    };
    let recall = |dx: usize| {
        let all: Vec<usize> = (0..outline.len()).filter(|i| outline[*i]).collect();
        (all.iter().filter(|i| is_near(&ink, **i, dx)).count() as f64 / all.len() as f64, all.len())
    };
    let (found, all) = recall(0);
    const SHIFT_PX: usize = 9;
    let (shifted, _) = recall(SHIFT_PX);
    let needless = |dx: usize| {
        let all = (0..within.len() - dx).filter(|i| within[*i]);
        let (all, inked) = all.fold((0, 0), |(all, inked), i| (all + 1, inked + usize::from(ink[i + dx])));
        f64::from(inked as u32) / f64::from(all)
    };
    println!("{found:.3} of {all} pixels of outlines have a stroke; {shifted:.3} when shifted by {SHIFT_PX} pixels");
    println!("{:.4} of the pixels within crowns are ink; {:.4} when shifted", needless(0), needless(SHIFT_PX));
    assert!(all > 1000 && found > 0.95 && needless(0) < 0.01);
    // Planted error: strokes that are shifted.
    assert!(shifted < 0.8 && needless(SHIFT_PX) > 3.0 * needless(0) + 0.01);
}
