//! Trees cast the shadows of their meshes, also from outside the picture, and are flat to hatching marks.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use crate::tests::helpers::forest::{DrawnTree, listed, of};
use common::World;
use common::draw::{draw, floats, places_m, still};
use common::grid_of;
use glam::{DVec2, DVec3};
use hachure::forest::species::{Detail, Grown};
use hachure::frame::{Light, Renderer};
use hachure::gpu::readback::read;
use hachure::scene::Wind;
use hachure::scene::forest::Form;
use hachure::scene::view::Pose;
use hachure::style::Style;
use hachure::surface::trees::CANOPY;
use hachure::surface::trees::marks::MARK_DISTANCE;
use hachure::surface::trees::shadow::TREE_SHADOW;
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [160, 120];

fn sun(elevation_deg: f64, azimuth_deg: f64) -> Light {
    let (elevation, azimuth) = (elevation_deg.to_radians(), azimuth_deg.to_radians());
    let to_sun = DVec3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin());
    Light { to_sun, haze_m: 1e6, haze_srgb: None, focus: None }
}

fn draw_in(world: &mut World, renderer: &mut Renderer, pose: Pose, style: &str, light: &Light) {
    let style = Style::load(style).unwrap();
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), &style, light);
}

fn ids(world: &World, renderer: &Renderer) -> Vec<u32> {
    let target = renderer.target(&SURFACE_ID).unwrap();
    let bytes = read(&world.gpu, target, [0, 0], target.size_px()).unwrap();
    bytes.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect()
}

/// Returns the position of a vertex of a tree, relative to its foot, in metres.
fn on_tree(tree: &DrawnTree, own: DVec3) -> DVec3 {
    let [sine, cosine] = tree.instance.turn.map(f64::from);
    let across_m = DVec2::new(cosine, sine).rotate(own.truncate()) * f64::from(tree.instance.width_m);
    across_m.extend(own.z * f64::from(tree.instance.height_m))
}

/// The triangles of trees in the world, with a bounding sphere (centre, radius) for each tree.
type Meshes = Vec<(DVec3, f64, Vec<[DVec3; 3]>)>;

/// Returns the meshes of trees at time 0, in `wind` if there is any.
fn meshes(trees: &[DrawnTree], grown: Grown, wind: Option<Wind>) -> Meshes {
    let corners = grown.grow(Detail::Near);
    let mesh = |tree: &DrawnTree| {
        let place_m = |own: DVec3| {
            let from_foot_m = on_tree(tree, own);
            let leans_m = wind.map_or(DVec2::ZERO, |wind| wind.lean_m(tree.at_m.truncate(), from_foot_m.z, 0.0));
            tree.at_m + from_foot_m + leans_m.extend(0.0)
        };
        let places: Vec<DVec3> = corners.iter().map(|corner| place_m(corner.at)).collect();
        let middle_m = places.iter().sum::<DVec3>() / places.len() as f64;
        let radius_m = places.iter().map(|at| at.distance(middle_m)).fold(0.0, f64::max);
        (middle_m, radius_m, places.chunks_exact(3).map(|triangle| [triangle[0], triangle[1], triangle[2]]).collect())
    };
    trees.iter().map(mesh).collect()
}

/// Returns whether a ray hits a triangle, by Möller and Trumbore (1997).
fn is_hit(origin: DVec3, ray: DVec3, [a, b, c]: &[DVec3; 3]) -> bool {
    let (u, v) = (b - a, c - a);
    let p = ray.cross(v);
    let area = u.dot(p);
    if area.abs() < 1e-12 {
        return false;
    }
    let from_a = origin - a;
    let by_b = from_a.dot(p) / area;
    let q = from_a.cross(u);
    let by_c = ray.dot(q) / area;
    by_b >= 0.0 && by_c >= 0.0 && by_b + by_c <= 1.0 && v.dot(q) / area > 0.0
}

fn is_shaded(at_m: DVec3, to_sun: DVec3, meshes: &Meshes) -> bool {
    meshes.iter().any(|(middle_m, radius_m, triangles)| {
        let to_middle = *middle_m - at_m;
        let beside_m = to_middle.reject_from(to_sun).length();
        beside_m < *radius_m && triangles.iter().any(|triangle| is_hit(at_m, to_sun, triangle))
    })
}

/// Returns the intersection over union of the points in shadow and those that should be.
fn overlap(places: &[(DVec3, f64)], to_sun: DVec3, meshes: &Meshes) -> f64 {
    let (mut both, mut any) = (0, 0);
    for (at_m, shade) in places {
        let (is, should) = (*shade > 0.5, is_shaded(*at_m, to_sun, meshes));
        both += u32::from(is && should);
        any += u32::from(is || should);
    }
    f64::from(both) / f64::from(any.max(1))
}

/// Tests shadows on the ground with rays to the sun through the triangles of all trees around; many of these are
/// outside the picture.
#[test]
fn shadows_are_those_of_the_meshes() {
    let Some(mut world) = World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let all = [
        (Form::Conifer, Grown::Conifer, 0.85),
        (Form::Broadleaf, Grown::Broadleaf, 0.9),
        (Form::Birch, Grown::Birch, 0.85),
    ];
    for (form, grown, least) in all.into_iter().take(if common::full() { 3 } else { 1 }) {
        world.surfaces.set_forest(Some(of(form, 25.0, 20.0)));
        // At this detail no tree is left out.
        world.surfaces.set_tree_detail(4.0);
        let light = sun(28.0, 250.0);
        let around = world.pose("40,30,90,0,-89,100");
        draw_in(&mut world, &mut renderer, around, "crosshatch", &light);
        let trees = listed(&world, &renderer, around.position_m);
        let mut by_id = std::collections::BTreeMap::new();
        for tree in trees.iter().filter(|tree| tree.level != CANOPY) {
            by_id.insert(tree.instance.id, *tree);
        }
        let trees: Vec<DrawnTree> = by_id.into_values().collect();
        let pose = world.pose("40,30,90,0,-89,40");
        draw_in(&mut world, &mut renderer, pose, "crosshatch", &light);
        let places = shaded(&world, &renderer, pose.position_m);
        let all = meshes(&trees, grown, None);
        let found = overlap(&places, light.to_sun, &all);
        // Planted errors: a sun that has moved on, and missing trees outside the picture.
        let turned = overlap(&places, sun(28.0, 256.0).to_sun, &all);
        let lower = overlap(&places, sun(24.0, 250.0).to_sun, &all);
        let view = still(pose, SIZE_PX);
        let frustum = view.frustum();
        let in_view: Vec<DrawnTree> =
            trees.iter().filter(|tree| frustum.may_see_sphere(tree.at_m - pose.position_m, 0.0)).copied().collect();
        let forgotten = overlap(&places, light.to_sun, &meshes(&in_view, grown, None));
        println!(
            "{form:?}: {} of {} trees in view; shadows overlap {found:.3}, with other suns {turned:.3} and {lower:.3}, \
             without trees outside the picture {forgotten:.3}",
            in_view.len(),
            trees.len()
        );
        assert!(in_view.len() > 5 && in_view.len() < trees.len());
        assert!(found > least && turned < found - 0.1 && lower < found - 0.05 && forgotten < found - 0.05);
    }
}

/// Returns the positions of the land in a frame, and how much of the sun trees block there, from 0 to 1.
fn shaded(world: &World, renderer: &Renderer, origin_m: DVec3) -> Vec<(DVec3, f64)> {
    let shadow = renderer.target(&TREE_SHADOW).unwrap();
    let shadow = read(&world.gpu, shadow, [0, 0], shadow.size_px()).unwrap();
    let (ids, seen_m) = (ids(world, renderer), places_m(&world.gpu, renderer, origin_m));
    (0..ids.len())
        .filter(|i| ids[*i] < id::FIRST_MESH)
        .filter_map(|i| Some((seen_m[i]?, f64::from(shadow[i]) / 255.0)))
        .collect()
}

/// Tests that leaning trees cast leaning shadows.
#[test]
fn shadows_lean_with_their_trees() {
    let Some(mut world) = World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let wind = Wind { speed_m_s: 20.0, from_deg: 340.0 };
    world.surfaces.set_forest(Some(of(Form::Conifer, 25.0, 20.0)));
    world.surfaces.set_tree_detail(4.0);
    world.surfaces.set_wind(Some(wind));
    let light = sun(40.0, 250.0);
    let pose = world.pose("40,30,90,0,-89,60");
    draw_in(&mut world, &mut renderer, pose, "crosshatch", &light);
    let trees = listed(&world, &renderer, pose.position_m);
    let trees: Vec<DrawnTree> =
        trees.into_iter().filter(|tree| tree.level != CANOPY && tree.shown == [0.0, 1.0]).collect();
    let places = shaded(&world, &renderer, pose.position_m);
    let leaning = overlap(&places, light.to_sun, &meshes(&trees, Grown::Conifer, Some(wind)));
    // Planted error: upright trees.
    let upright = overlap(&places, light.to_sun, &meshes(&trees, Grown::Conifer, None));
    println!("{} trees; shadows overlap {leaning:.3}, of upright trees {upright:.3}", trees.len());
    assert!(
        trees.len() > 20 && leaning > 0.75 && upright < leaning - 0.1,
        "overlap with leaning trees {leaning}, with upright ones {upright}"
    );
}

/// Tests that without sun there are no shadows, and that styles without shadows do not compute them.
#[test]
fn shadows_are_made_where_they_are_asked_for() {
    let Some(mut world) = World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02) else { return };
    world.surfaces.set_forest(Some(of(Form::Conifer, 60.0, 20.0)));
    let pose = world.pose("40,30,60,0,-50,50");
    let shaded = |world: &mut World, style: &str, light: &Light| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw_in(world, &mut renderer, pose, style, light);
        let shadow = renderer.target(&TREE_SHADOW)?;
        Some(read(&world.gpu, shadow, [0, 0], shadow.size_px()).unwrap().iter().filter(|shade| **shade > 127).count())
    };
    assert_eq!(shaded(&mut world, "crosshatch", &sun(-5.0, 250.0)), Some(0));
    assert!(shaded(&mut world, "crosshatch", &sun(30.0, 250.0)).unwrap() > 500);
    assert_eq!(shaded(&mut world, "lsa", &sun(30.0, 250.0)), None);
}

/// Tests that the marks of a tree are on one plane, which faces the eye and passes through its body.
#[test]
fn trees_are_flat_to_marks() {
    let Some(mut world) = World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02) else { return };
    world.surfaces.set_forest(Some(of(Form::Broadleaf, 40.0, 20.0)));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let pose = world.pose("0,0,25,0,-8,50");
    draw_in(&mut world, &mut renderer, pose, "crosshatch", &sun(30.0, 250.0));
    let ids = ids(&world, &renderer);
    let marks_m: Vec<DVec3> = floats::<1>(&world.gpu, renderer.target(&MARK_DISTANCE).unwrap())
        .into_iter()
        .enumerate()
        .map(|(i, [along_m])| {
            let [x, y] = [i % SIZE_PX[0] as usize, i / SIZE_PX[0] as usize].map(|at| at as f64 + 0.5);
            still(pose, SIZE_PX).ray(DVec2::new(x, y)) * f64::from(along_m) + pose.position_m
        })
        .collect();
    let seen_m = places_m(&world.gpu, &renderer, pose.position_m);
    // The largest distance of points from the plane through the tree's centre that faces the eye, relative to the
    // tree's height.
    let off = |tree: &DrawnTree, places_m: &[DVec3]| {
        let height_m = f64::from(tree.instance.height_m);
        let middle_m = tree.at_m + DVec3::Z * 0.5 * height_m;
        let toward = (pose.position_m - middle_m).normalize();
        places_m.iter().map(|at_m| (*at_m - middle_m).dot(toward).abs() / height_m).fold(0.0, f64::max)
    };
    let (mut seen, mut worst, mut of_surface) = (0, 0.0_f64, 0);
    for tree in listed(&world, &renderer, pose.position_m) {
        let own: Vec<usize> = (0..ids.len()).filter(|i| ids[*i] == tree.instance.id).collect();
        if own.len() < 60 || tree.level == CANOPY {
            continue;
        }
        seen += 1;
        let marks: Vec<DVec3> = own.iter().map(|i| marks_m[*i]).collect();
        worst = worst.max(off(&tree, &marks));
        // Planted error: the surface itself.
        let surface: Vec<DVec3> = own.iter().filter_map(|i| seen_m[*i]).collect();
        of_surface += u32::from(off(&tree, &surface) > 0.16);
    }
    println!(
        "{seen} trees, largest distance of marks from the plane {worst:.4} of the height; {of_surface} trees whose surface is farther off"
    );
    assert!(
        seen > 8 && worst < 0.08 && of_surface > seen / 2,
        "{seen} trees, marks off by {worst} of the height, surfaces off for {of_surface}"
    );
}
