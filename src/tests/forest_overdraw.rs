//! Impostors are drawn from front to back as hulls, so few of their fragments run, and what the land hides is left out.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::collections::BTreeMap;

use glam::{DMat3, DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::scene::forest::{Form, Species};
use hachure::scene::view::View;
use hachure::style::Style;
use hachure::surface::trees::{CANOPY, Hull, IMPOSTOR, Pictured, pictured};
use hachure::surface::{SURFACE_ID, id};

use crate::tests::common::World;
use crate::tests::common::draw::{NOON, draw, places, still};
use crate::tests::common::hill::Hill;
use crate::tests::helpers::forest::{DrawnTree, listed, of, order};

const SIZE_PX: [u32; 2] = [320, 180];
/// Side of the map of pictures.
const FRAMES: f64 = 24.0;

/// The polygon of an impostor as `impostor.wgsl` computes it.
struct Polygon {
    corners_px: Vec<DVec2>,
    /// Distance along the view axis at which its depth is tested.
    along_m: f64,
}

/// Returns the picture that is taken from nearest to a direction, and its axes.
fn frame_near(toward: DVec3) -> ([f64; 2], DMat3) {
    let d = toward.truncate().extend(toward.z.max(0.0));
    let p = d.truncate() / (d.x.abs() + d.y.abs() + d.z);
    let frame = [p.x + p.y, p.x - p.y].map(|uv| ((uv * 0.5 + 0.5) * (FRAMES - 1.0)).round());
    let [u, v] = frame.map(|at| at / (FRAMES - 1.0) * 2.0 - 1.0);
    let p = DVec2::new(0.5 * (u + v), 0.5 * (u - v));
    let direction = p.extend(1.0 - p.x.abs() - p.y.abs()).normalize();
    let right = DVec3::new(-direction.y, direction.x, 0.0).normalize();
    (frame, DMat3::from_cols(right, direction.cross(right), direction))
}

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Polygon {
    fn of(tree: &DrawnTree, view: &View, pictured: &Pictured, is_whole: bool) -> Option<Self> {
        let instance = &tree.instance;
        let [sin, cos] = instance.turn.map(f64::from);
        let [width_m, height_m] = [instance.width_m, instance.height_m].map(f64::from);
        let slope = DVec2::new(instance.slope[0].into(), instance.slope[1].into());
        let on_tree = |own: DVec3| {
            let across_m = DVec2::new(cos * own.x - sin * own.y, sin * own.x + cos * own.y) * width_m;
            across_m.extend(own.z * height_m + across_m.dot(slope))
        };
        let from_foot_m = view.pose.position_m - tree.at_m;
        let turned = DVec2::new(cos * from_foot_m.x + sin * from_foot_m.y, cos * from_foot_m.y - sin * from_foot_m.x);
        let up = (from_foot_m.z - from_foot_m.truncate().dot(slope)) / height_m;
        let eye = (turned / width_m).extend(up);
        let species = &pictured.species[tree.species as usize];
        let (middle, radius) = (DVec3::from_array(species.middle.map(f64::from)), f64::from(species.radius));
        let (frame, axes) = frame_near((eye - middle).normalize());
        let away_m = (on_tree(middle) - from_foot_m).length();
        let wide_px = 2.0 * radius * (width_m * height_m).sqrt() * view.focal_px() / away_m;
        let coarser = 1.2 * (1.0 - smoothstep(10.0, 44.0, wide_px));
        let level = ((f64::from(pictured.frame_px) / wide_px).log2() + coarser).round();
        let level = level.clamp(0.0, f64::from(pictured.levels - 1));
        let number = ((f64::from(tree.species * pictured.levels) + level) * FRAMES + frame[1]) * FRAMES + frame[0];
        let mut hull: Hull = pictured.hulls[number as usize];
        if is_whole {
            for (i, side) in hull.sides.iter_mut().enumerate() {
                let [x, y] = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]][i / 2];
                let turned = DVec2::new(x, y).rotate(DVec2::from_angle(if i % 2 == 0 { -0.01 } else { 0.01 }));
                *side = [turned.x as f32, turned.y as f32, 1.0, 0.0];
            }
        }
        let (near, far) = (f64::from(hull.near), f64::from(hull.far));
        if near < far {
            return None;
        }
        let on_picture = axes.transpose() * (eye - middle) / radius;
        let away = on_picture.z - near;
        let slope = on_picture.truncate() / away;
        if away < 2.0 || slope.length() > 0.7 {
            // A square that holds the sphere, and is tested as if it were at the eye.
            let toward = (eye - middle).normalize();
            let far = (eye - middle).length().max(1.01 * radius);
            let wide = radius * far / (far * far - radius * radius).sqrt();
            let right = DVec3::new(-toward.y, toward.x, 0.0).normalize();
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let corners_px = corners.map(|[x, y]| {
                view.place_px(on_tree(middle + wide * (x * right + y * toward.cross(right))) - from_foot_m)
            });
            return Some(Self { corners_px: corners_px.into_iter().collect::<Option<_>>()?, along_m: 0.0 });
        }
        let [reach, low, high] = [0, 1, 2].map(|i| f64::from(species.cylinder[i]));
        let steps = (wide_px / 2.0).floor().clamp(5.0, if tree.level == CANOPY { 8.0 } else { 16.0 });
        let level_ray = ((eye - middle).normalize().truncate().length() - 0.1).max(0.05);
        let across = (2.0 * reach).hypot(high - low).min(2.0 * reach / level_ray) / radius;
        let deep = near - far + 0.04 + across / steps;
        let f = 1.0 / (1.0 + deep / away);
        let margin_px = 0.05 * away_m / (view.focal_px() * radius * width_m.min(height_m));
        let (margin, aside, middle_f) = (0.5 * (1.0 - f) + margin_px, 0.5 * deep * f * slope, 0.5 * (1.0 + f));
        let corner = |i: usize| {
            let [a, b] = [hull.sides[i], hull.sides[(i + 1) % 8]].map(|side| side.map(f64::from));
            let reach = |side: [f64; 4]| side[2] + (margin + DVec2::new(side[0], side[1]).dot(aside).abs()) / middle_f;
            let [x, y] = [reach(a), reach(b)];
            DVec2::new(x * b[1] - y * a[1], y * a[0] - x * b[0]) / (a[0] * b[1] - a[1] * b[0])
        };
        let mut along_m = f64::INFINITY;
        let corners_px = (0..8).map(|i| {
            let p = middle_f * corner(i) + aside;
            let at_m = on_tree(middle + radius * (axes * p.extend(near))) - from_foot_m;
            let own_m = at_m.dot(view.pose.forward);
            let nearer_m = (0.5 * (width_m - height_m).max(0.0)).min(0.05 * own_m);
            along_m = along_m.min((own_m - nearer_m) / if tree.level == CANOPY { 1.005 } else { 1.0001 });
            view.place_px(at_m)
        });
        let corners_px = corners_px.collect::<Option<Vec<_>>>()?;
        Some(Self { corners_px, along_m })
    }

    /// Returns the pixels whose centres are within.
    fn pixels(&self) -> Vec<usize> {
        let (low, high) = self
            .corners_px
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), corner| (low.min(*corner), high.max(*corner)));
        let range = |low: f64, high: f64, size: u32| {
            (low - 0.5).ceil().max(0.0) as usize..((high + 0.5).floor().max(0.0) as usize).min(size as usize)
        };
        let holds = |at: DVec2| {
            let next = self.corners_px.iter().cycle().skip(1);
            let turns = self.corners_px.iter().zip(next).map(|(a, b)| (*b - *a).perp_dot(at - *a));
            let (mut left, mut right) = (false, false);
            turns.for_each(|turn| (left, right) = (left | (turn > 0.0), right | (turn < 0.0)));
            !(left && right)
        };
        let rows = range(low.y, high.y, SIZE_PX[1]);
        rows.flat_map(|y| range(low.x, high.x, SIZE_PX[0]).map(move |x| (x, y)))
            .filter(|(x, y)| holds(DVec2::new(*x as f64 + 0.5, *y as f64 + 0.5)))
            .map(|(x, y)| y * SIZE_PX[0] as usize + x)
            .collect()
    }
}

/// A frame of a forest, read back.
struct Drawn {
    view: View,
    ids: Vec<u32>,
    /// Distance along the axis of what each pixel shows; infinite for the sky.
    along_m: Vec<f64>,
    trees: Vec<DrawnTree>,
    /// Indices in `trees`, in the order in which impostors are drawn.
    drawn: Vec<usize>,
    pictured: [Pictured; 2],
}

impl Drawn {
    fn new(world: &mut World, camera: &str) -> Self {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let view = still(world.pose(camera), SIZE_PX);
        let style = Style::load("plain").unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
        let ids = read(&world.gpu, renderer.target(&SURFACE_ID).unwrap(), [0, 0], SIZE_PX).unwrap();
        let ids = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
        let along_m = places(&world.gpu, &renderer, 0).into_iter().map(|[.., along]| f64::from(along));
        let along_m = along_m.map(|along_m| if along_m > 0.0 { along_m } else { f64::INFINITY }).collect();
        let trees = listed(world, &renderer, view.pose.position_m);
        let places: BTreeMap<u32, usize> = trees.iter().enumerate().map(|(i, tree)| (tree.number, i)).collect();
        let lists = order(world, &renderer);
        let drawn = lists[lists.len() - 2..].iter().flatten().map(|number| places[number]).collect();
        Self { view, ids, along_m, trees, drawn, pictured: pictured(&world.gpu, world.surfaces.forest().unwrap()) }
    }

    fn polygon(&self, tree: usize, is_whole: bool) -> Option<Polygon> {
        let tree = &self.trees[tree];
        Polygon::of(tree, &self.view, &self.pictured[usize::from(tree.level == CANOPY)], is_whole)
    }

    /// Returns how many fragments of impostors run, at most, for each pixel that shows an impostor, and how many such
    /// pixels there are. Before the tree that a pixel shows is drawn, each fragment there is counted; afterwards those
    /// whose polygon is nearer.
    fn overdraw(&self, drawn: impl Iterator<Item = usize>, is_whole: bool) -> (f64, usize) {
        let mut is_final: Vec<bool> = self.ids.iter().map(|id| *id < id::FIRST_TREE).collect();
        let (mut fragments, mut shown) = (0_u32, vec![false; self.ids.len()]);
        for number in drawn {
            let Some(polygon) = self.polygon(number, is_whole) else { continue };
            for pixel in polygon.pixels() {
                fragments += u32::from(!is_final[pixel] || polygon.along_m < self.along_m[pixel]);
                if self.ids[pixel] == self.trees[number].instance.id {
                    (is_final[pixel], shown[pixel]) = (true, true);
                }
            }
        }
        let shown = shown.iter().filter(|shown| **shown).count();
        (f64::from(fragments) / shown as f64, shown)
    }
}

fn wooded() -> Option<World> {
    let mut world = World::new(Hill::square(321, 10.0).1, 0.02)?;
    let mut forest = of(Form::Conifer, 320.0, 18.0);
    forest.species = Species::mixed(18.0);
    world.surfaces.set_forest(Some(forest));
    Some(world)
}

#[test]
fn few_fragments_of_impostors_run() {
    let Some(mut world) = wooded() else { return };
    let drawn = Drawn::new(&mut world, "-300,-1300,+60,15,-4,50");
    let in_order = || drawn.drawn.iter().copied();
    let (overdraw, shown) = drawn.overdraw(in_order(), false);
    let (of_squares, _) = drawn.overdraw(in_order(), true);
    let (backward, _) = drawn.overdraw(in_order().rev(), false);
    println!("{} impostors on {shown} pixels: {overdraw:.2} fragments for each", drawn.drawn.len());
    println!("with squares {of_squares:.2}, from back to front {backward:.2}");
    assert!(shown > 10_000 && overdraw < 3.4);
    // Planted errors.
    assert!(of_squares > 3.0 * overdraw && backward > 2.0 * overdraw);
}

#[test]
fn impostors_are_within_and_behind_their_polygons() {
    let Some(mut world) = wooded() else { return };
    for camera in ["-300,-1300,+60,15,-4,50", "-300,-1300,+300,15,-40,50"] {
        let drawn = Drawn::new(&mut world, camera);
        let mut shows: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        drawn.ids.iter().enumerate().for_each(|(pixel, id)| shows.entry(*id).or_default().push(pixel));
        let (mut checked, mut cut) = (0, 0);
        let mut levels: BTreeMap<u32, u32> = BTreeMap::new();
        drawn.trees.iter().for_each(|tree| *levels.entry(tree.instance.id).or_default() += 1);
        // A pixel of a tree that is drawn in two ways may be of either.
        let alone = drawn.drawn.iter().filter(|tree| levels[&drawn.trees[**tree].instance.id] == 1);
        for number in alone {
            let Some(pixels) = shows.get(&drawn.trees[*number].instance.id) else { continue };
            let polygon = drawn.polygon(*number, false).unwrap();
            let within = polygon.pixels();
            for pixel in pixels {
                assert!(within.contains(pixel), "a pixel of {:?} is outside", drawn.trees[*number]);
                assert!(drawn.along_m[*pixel] > polygon.along_m, "a pixel of {:?} is nearer", drawn.trees[*number]);
                checked += 1;
            }
            // Planted error: polygons that are a tenth smaller.
            let middle = polygon.corners_px.iter().sum::<DVec2>() / polygon.corners_px.len() as f64;
            let corners_px = polygon.corners_px.iter().map(|corner| middle.lerp(*corner, 0.9)).collect();
            let smaller = Polygon { corners_px, ..polygon }.pixels();
            cut += pixels.iter().filter(|pixel| !smaller.contains(pixel)).count();
        }
        println!("{checked} pixels of impostors; {cut} outside of smaller polygons");
        assert!(checked > 5_000 && cut > 20);
    }
}

#[test]
fn trees_behind_the_land_are_not_drawn() {
    let Some(mut world) = wooded() else { return };
    // Behind the hill there are trees, too.
    let drawn = Drawn::new(&mut world, "0,-1100,+30,0,2,50");
    let hidden: Vec<&DrawnTree> = drawn.trees.iter().filter(|tree| tree.is_hidden).collect();
    println!("{} of {} trees are hidden", hidden.len(), drawn.trees.len());
    assert!(hidden.len() > drawn.trees.len() / 20);
    assert!(hidden.iter().all(|tree| [IMPOSTOR, CANOPY].contains(&tree.level) || tree.level == 1));
    // Nothing of a hidden tree is in front of what the picture shows.
    let nearer = |tree: &DrawnTree| {
        let number = drawn.trees.iter().position(|other| other.number == tree.number).unwrap();
        let Some(polygon) = drawn.polygon(number, false).filter(|polygon| polygon.along_m > 0.0) else { return 0 };
        polygon.pixels().iter().filter(|pixel| drawn.along_m[**pixel] > polygon.along_m).count()
    };
    let impostors =
        |is_hidden: bool| drawn.trees.iter().filter(move |tree| tree.level >= IMPOSTOR && tree.is_hidden == is_hidden);
    assert_eq!(impostors(true).map(nearer).sum::<usize>(), 0);
    // Planted error: trees that are drawn.
    assert!(impostors(false).map(nearer).sum::<usize>() > 300);
}

#[test]
fn blocks_of_trees_come_from_near_to_far() {
    let Some(mut world) = wooded() else { return };
    let drawn = Drawn::new(&mut world, "-300,-1300,+60,15,-4,50");
    let eye_m = drawn.view.pose.position_m;
    let alone: Vec<f64> = drawn
        .drawn
        .iter()
        .map(|tree| &drawn.trees[*tree])
        .filter(|tree| tree.level == IMPOSTOR)
        .map(|tree| tree.at_m.distance(eye_m))
        .collect();
    // The blocks of near trees are 32 m wide; how far a tree is behind the farthest of those before it.
    let behind = |distances: &[f64]| {
        let (mut farthest, mut most) = (0.0_f64, 0.0_f64);
        for away_m in distances {
            most = most.max(farthest - away_m);
            farthest = farthest.max(*away_m);
        }
        most
    };
    let own = behind(&alone);
    let mut shuffled = alone.clone();
    shuffled.rotate_left(alone.len() / 2);
    println!("{} impostors; one is at most {own:.1} m nearer than one before it", alone.len());
    assert!(alone.len() > 500 && own < 100.0 && behind(&shuffled) > 2.0 * own);
    // The same frame again has the same order, instance by instance.
    let again = Drawn::new(&mut world, "-300,-1300,+60,15,-4,50");
    let ids = |drawn: &Drawn| drawn.drawn.iter().map(|tree| drawn.trees[*tree].instance.id).collect::<Vec<_>>();
    assert!(ids(&drawn) == ids(&again));
}
