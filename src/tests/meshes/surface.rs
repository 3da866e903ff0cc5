//! Tests that the position and normal of a model's pixels are those of an exact ray, and that models do not change the
//! land.

use std::sync::Arc;

use glam::DVec3;
use hachure::measure::lod_error;
use hachure::mesh::Mesh;
use hachure::mesh::placed::{Placed, Standing};
use hachure::picture::PartRule;
use hachure::style::Style;

use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::full;
use crate::tests::common::hill::Hill;
use crate::tests::common::shot::{Shot, ink, shoot_style};
use crate::tests::helpers::styles::of_outlines;
use crate::tests::meshes::shapes;

const SIZE_PX: [u32; 2] = [480, 270];

fn standing_on(hill: &Hill, x_m: f64, y_m: f64, up_m: f64) -> DVec3 {
    DVec3::new(x_m, y_m, hill.height_m(x_m, y_m) + up_m)
}

/// Intersects a ray with the plane of a triangle. Returns the distance in units of the ray and the normal toward the
/// eye, or `None` if the ray misses the triangle.
fn cast(mesh: &Mesh, standing: &Standing, triangle: usize, eye_m: DVec3, ray: DVec3) -> Option<(f64, DVec3)> {
    let [a, b, c] = shapes::corners_m(mesh, standing, triangle).map(|corner| corner - eye_m);
    let face = (b - a).cross(c - a);
    let t = a.dot(face) / ray.dot(face);
    let at = ray * t;
    let area = face.length_squared();
    let by_b = (at - a).cross(c - a).dot(face) / area;
    let by_c = (b - a).cross(at - a).dot(face) / area;
    let parts = [1.0 - by_b - by_c, by_b, by_c];
    let own = &mesh.triangles[triangle].normals;
    let mixed = own[0] * parts[0] + own[1] * parts[1] + own[2] * parts[2];
    let normal = (standing.world_from_mesh * mixed).normalize();
    let front = if face.dot(ray) > 0.0 { -face } else { face };
    let normal = if normal.dot(front) < 0.0 { -normal } else { normal };
    (t > 0.0 && parts.iter().all(|part| *part >= -1e-3)).then_some((t, normal))
}

/// Returns the pixels of a mesh, and for each of them the intersection of its ray with the triangle that it shows.
fn hits(shot: &Shot, mesh: &Mesh, standing: &Standing) -> Vec<(usize, Option<(f64, DVec3)>)> {
    let hit = |pixel: usize| {
        let number = (shot.id[pixel] & 0x7fff_ffff) as usize;
        (pixel, cast(mesh, standing, number, shot.view.pose.position_m, shot.ray(pixel)))
    };
    (0..shot.id.len()).filter(|&pixel| shot.id[pixel] >> 31 == 1).map(hit).collect()
}

/// Counts pixels of a mesh: those off in position by more than 1e-5 of the distance, and those off in the normal by
/// more than 2e-3 rad.
fn off(shot: &Shot, mesh: &Mesh, standing: &Standing) -> [usize; 2] {
    let mut counts = [0; 2];
    for (pixel, hit) in hits(shot, mesh, standing) {
        let Some((t, normal)) = hit else { continue };
        let ray = shot.ray(pixel);
        counts[0] += usize::from(shot.position_m[pixel].distance(ray * t) > 1e-5 * ray.length() * t);
        counts[1] += usize::from(shot.normal[pixel].angle_between(normal) > 2e-3);
    }
    counts
}

/// Counts pixels of a mesh: all of them, and those that show a triangle which is not the nearest.
fn hidden(shot: &Shot, mesh: &Mesh, standing: &Standing) -> [usize; 2] {
    let hits = hits(shot, mesh, standing);
    let is_hidden = |(pixel, hit): &&(usize, Option<(f64, DVec3)>)| {
        let of = |triangle| cast(mesh, standing, triangle, shot.view.pose.position_m, shot.ray(*pixel));
        hit.is_none_or(|(t, _)| (0..mesh.triangles.len()).filter_map(of).any(|hit| hit.0 < t * (1.0 - 1e-4)))
    };
    [hits.len(), hits.iter().filter(is_hidden).count()]
}

#[test]
fn position_and_normal_are_those_of_an_exact_ray() {
    let Some((hill, mut world)) = shapes::hill() else {
        return;
    };
    let (mut renderer, style) = (None, of_outlines(ink("footprint")));
    let soups = [("sphere", shapes::sphere(3)), ("sheet", shapes::sheet()), ("cube", shapes::cube())];
    for (name, soup) in soups.into_iter().take(if full() { 3 } else { 2 }) {
        let mesh = Arc::new(shapes::mesh(soup));
        // In the fast tier the sphere is seen from near, and the sheet from above.
        let cameras = [("-320,-620,+8,8,3,40", 20.0), ("-900,-1200,+300,40,-14,20", 60.0)];
        let is_drawn = |(_, radius_m): &(&str, f64)| full() || (*radius_m == 20.0) == (name == "sphere");
        for (camera, radius_m) in cameras.into_iter().filter(is_drawn) {
            let stance = shapes::stance(standing_on(&hill, -300.0, -500.0, 0.5 * radius_m), 33.0, radius_m);
            let standing = shapes::place(&mut world, &mesh, &stance);
            let pose = world.pose(camera);
            let shot = shoot_style(&mut world, &mut renderer, pose, pose, SIZE_PX, &style, &PartRule::default());
            let ([position, normal], [pixels, other]) = (off(&shot, &mesh, &standing), hidden(&shot, &mesh, &standing));
            println!("{name} {camera}: {pixels} px; off: {position} positions, {normal} normals; {other} triangles");
            assert!(pixels > 1500, "{pixels}");
            assert!(position * 1000 <= pixels && normal * 1000 <= pixels && other * 100 <= pixels);
            // Models do not count as an error of the land.
            let drawn = renderer.as_ref().unwrap();
            let lod_px = lod_error::largest_px(&world.gpu, drawn, &shot.view, &world.surfaces.terrain, 0).unwrap();
            assert!(lod_px.is_some_and(|lod_px| lod_px < 1.0), "{lod_px:?}");
            // Planted: a mesh 20 cm aside, and one with leaning normals.
            let aside = Standing { middle_m: standing.middle_m + DVec3::new(0.1, 0.1, 0.14), ..standing.clone() };
            assert!(off(&shot, &mesh, &aside)[0] > pixels / 2);
            let mut leaning = (*mesh).clone();
            for triangle in &mut leaning.triangles {
                triangle.normals = triangle.normals.map(|normal| (normal + DVec3::splat(0.02)).normalize());
            }
            assert!(off(&shot, &leaning, &standing)[1] > pixels / 2);
        }
    }
}

fn same_land(one: &Shot, other: &Shot) -> usize {
    (0..one.id.len())
        .filter(|&i| {
            let is_same = one.position_m[i] == other.position_m[i]
                && one.normal[i] == other.normal[i]
                && one.depth_m[i].to_bits() == other.depth_m[i].to_bits()
                && one.id[i] == other.id[i];
            one.id[i] >> 31 == 0 && other.id[i] >> 31 == 0 && !is_same
        })
        .count()
}

#[test]
fn the_land_is_to_the_bit_what_it_is_without_meshes() {
    let Some((hill, mut world)) = shapes::hill() else {
        return;
    };
    let mesh = Arc::new(shapes::mesh(shapes::sphere(3)));
    let pose = world.pose("-320,-620,+8,8,3,40");
    let styles = [of_outlines(ink("footprint")), Style::load("lsa").unwrap()];
    let (size_px, least) = if full() { (SIZE_PX, [1500, 1000]) } else { (SIZE_PX.map(|side| side / 2), [375, 250]) };
    for style in styles.into_iter().take(if full() { 2 } else { 1 }) {
        let take = |world: &mut crate::tests::common::World| {
            shoot_style(world, &mut None, pose, pose, size_px, &style, &PartRule::default())
        };
        world.surfaces.set_meshes(Placed::default());
        let bare = take(&mut world);
        // A model behind the eye, and one so small that it is not drawn.
        for (x_m, scale) in [(-330.0, 15.0), (-300.0, 1e-3)] {
            let y_m = if scale > 1.0 { -700.0 } else { -500.0 };
            shapes::place(&mut world, &mesh, &shapes::stance(standing_on(&hill, x_m, y_m, 2.0), 0.0, scale));
            let with = take(&mut world);
            assert_eq!(bare.picture, with.picture);
            assert_eq!(same_land(&bare, &with), 0);
        }
        shapes::place(&mut world, &mesh, &shapes::stance(standing_on(&hill, -300.0, -500.0, 10.0), 0.0, 20.0));
        let with = take(&mut world);
        let pixels = with.id.iter().filter(|id| *id >> 31 == 1).count();
        assert!(pixels > least[0] && pixels < with.id.len() / 2 && same_land(&bare, &with) == 0);
        assert!(bare.id.iter().all(|id| id >> 31 == 0));
        // Planted: another eye.
        let other = world.pose("-320,-620,+8.01,8,3,40");
        let moved = shoot_style(&mut world, &mut None, other, other, size_px, &style, &PartRule::default());
        assert!(same_land(&bare, &moved) > least[1]);
    }
}

#[test]
fn parts_of_a_large_picture_join() {
    let Some((hill, mut world)) = shapes::hill() else {
        return;
    };
    let mesh = Arc::new(shapes::mesh(shapes::sphere(3)));
    shapes::place(&mut world, &mesh, &shapes::stance(standing_on(&hill, -300.0, -500.0, 10.0), 0.0, 20.0));
    let pose = world.pose("-320,-620,+8,8,3,40");
    let style = of_outlines(ink("footprint"));
    let whole = shoot_style(&mut world, &mut None, pose, pose, SIZE_PX, &style, &PartRule::default());
    let part_px = if full() { 128 } else { 192 };
    let rule = PartRule { whole_px: 0, part_px, ..PartRule::default() };
    let parts = shoot_style(&mut world, &mut None, pose, pose, SIZE_PX, &style, &rule);
    let differs = |one: &Shot, other: &Shot| {
        let far = |i: &usize| (0..3).any(|k| (one.picture[*i][k] - other.picture[*i][k]).abs() > 0.02);
        (0..one.picture.len()).filter(far).count()
    };
    assert!(parts.report.parts > 4);
    let count = differs(&whole, &parts);
    println!("{count} pixels differ");
    assert!(count * 1000 <= whole.picture.len(), "{count}");
    // Planted: without the mesh the picture differs.
    world.surfaces.set_meshes(Placed::default());
    let bare = shoot_style(&mut world, &mut None, pose, pose, SIZE_PX, &style, &rule);
    assert!(differs(&whole, &bare) * 1000 > whole.picture.len());
}

#[test]
fn a_mesh_bends_with_the_land_and_stands_on_it() {
    let (hill, grid) = Hill::far(60_000.0, 100.0);
    let Some(gpu) = crate::tests::common::gpu() else {
        return;
    };
    let options = hachure::tiles::terrain::TerrainOptions { inverse_radius: 1.0 / 6_371_008.8, ..Default::default() };
    let terrain = hachure::tiles::Terrain::new(&gpu, crate::tests::common::in_memory(&grid), options).unwrap();
    let mut surfaces = hachure::world::Surfaces::from(terrain);
    // A mast of 400 m on the hill, 55 km away, seen from 300 m above the plain.
    let foot_m = DVec3::new(-60_000.0, 0.0, hill.height_m(-60_000.0, 0.0));
    let mut placed = Placed::default();
    placed.add(&Arc::new(shapes::mesh(shapes::cube())), &shapes::stance(foot_m, 0.0, 400.0)).unwrap();
    surfaces.set_meshes(placed);
    let pose = hachure::scene::view::Pose {
        position_m: DVec3::new(-5000.0, 0.0, 300.0),
        forward: -DVec3::X,
        right: DVec3::Y,
        up: DVec3::Z,
        fov_rad: 0.05,
    };
    let style = Style::load("plain").unwrap();
    let view = still(pose, SIZE_PX);
    let mut renderer = hachure::frame::Renderer::new(&gpu).unwrap();
    let earth_curvature = surfaces.terrain.earth_curvature(pose.position_m.z);
    draw(&gpu, &mut surfaces, &mut renderer, &view, &style, &NOON);
    let drawn = renderer.drawn_mesh_vertices(&gpu, &surfaces).unwrap().unwrap();
    let mut sunk_m = 0.0_f64;
    for (i, [x, y, z, _]) in drawn.into_iter().enumerate() {
        let corner = surfaces.meshes().unwrap().meshes[0].vertices_m[i].map(f64::from);
        let flat_m = foot_m + DVec3::from_array(corner) * 400.0 - pose.position_m;
        let at_m = DVec3::new(x.into(), y.into(), z.into());
        assert!(at_m.distance(earth_curvature.bend(flat_m)) < 0.02, "{at_m} {}", earth_curvature.bend(flat_m));
        sunk_m = sunk_m.max(at_m.distance(flat_m));
    }
    assert!(sunk_m > 200.0, "the earth's curvature lowers the mast by only {sunk_m} m");
}
