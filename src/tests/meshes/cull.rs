//! Tests which meshes an eye sees, and at which level of detail: the GPU's list against that of the CPU twin.

use std::sync::Arc;

use glam::DVec3;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::readback::read_buffer;
use hachure::mesh::levels::coarser;
use hachure::mesh::placed::Placed;
use hachure::scene::view::{Pose, View};
use hachure::style::Style;
use hachure::surface::meshes::INSTANCES;
use hachure::surface::meshes::cull::{VisibleInstance, seen};
use hachure::tiles::Terrain;
use hachure::tiles::terrain::TerrainOptions;
use hachure::world::Surfaces;

use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::{full, grid_of, in_memory, random};
use crate::tests::helpers::styles::of_outlines;
use crate::tests::meshes::shapes::{cube, mesh, sheet, sphere, stance};

const SIZE_PX: [u32; 2] = [128, 72];
const STANDING: i64 = 3000;

/// Returns cubes, sheets and balls of all sizes, some on the land, some far above and below it.
pub fn town() -> Placed {
    let meshes = [cube(), sheet(), sphere(3)].map(|soup| Arc::new(mesh(soup)));
    let mut placed = Placed::default();
    for mesh in &meshes {
        placed.add_levels(mesh, coarser(mesh)).unwrap();
    }
    for i in 0..STANDING {
        let at = |j: i64| 2.0 * random(i, j) - 1.0;
        // Denser near the middle.
        let away_m = 30_000.0 * random(i, 3).powi(4);
        let origin_m = DVec3::new(away_m * at(0), away_m * at(1), 300.0 * at(2));
        let scale = 0.01 * 3000.0_f64.powf(random(i, 4));
        placed.add(&meshes[i as usize % 3], &stance(origin_m, 360.0 * random(i, 5), scale)).unwrap();
    }
    placed
}

/// Reads the GPU's list: the mesh, the level (identified by its number of triangles), and whether its edges are
/// collected.
pub fn listed(gpu: &Gpu, renderer: &Renderer, placed: &Placed) -> Vec<VisibleInstance> {
    const WORDS: usize = 24;
    let count = renderer.drawn_meshes(gpu).unwrap().unwrap().instances as usize;
    let buffer = renderer.buffer(&INSTANCES).unwrap();
    let words: Vec<u32> = read_buffer(gpu, &buffer.raw, count * WORDS).unwrap();
    let of = |instance: &[u32]| {
        let standing = instance[22] as usize;
        let mesh = placed.standing[standing].mesh;
        let levels = placed.coarser(mesh).iter().map(|level| level.mesh.triangles.len());
        let counts: Vec<usize> = [placed.meshes[mesh].triangles.len()].into_iter().chain(levels).collect();
        let level = counts.iter().position(|count| *count == instance[16] as usize).unwrap();
        VisibleInstance { standing, level, is_near: instance[18] == 1 }
    };
    words.chunks(WORDS).map(of).collect()
}

/// Counts instances that are in only one of the lists, or near in only one of them.
fn differing(a: &[VisibleInstance], b: &[VisibleInstance]) -> usize {
    a.iter().filter(|seen| !b.contains(seen)).count() + b.iter().filter(|seen| !a.contains(seen)).count()
}

#[test]
fn the_gpu_sees_the_meshes_that_its_twin_sees() {
    let Some(gpu) = crate::tests::common::gpu() else { return };
    let style = of_outlines(Style::load("pen").unwrap());
    let placed = town();
    let store = in_memory(&grid_of(65, 65, 1000.0, |x_m, _| 0.01 * x_m));
    // The fast tier has the most curved of the earths.
    let inverse_radii = [0.0, 1.0 / 6_371_008.8, 1.0 / 200_000.0];
    for inverse_radius in inverse_radii.into_iter().skip(if full() { 0 } else { 2 }) {
        let options = TerrainOptions { inverse_radius, ..TerrainOptions::default() };
        let mut surfaces = Surfaces::from(Terrain::new(&gpu, Arc::clone(&store), options).unwrap());
        surfaces.set_meshes(placed.clone());
        let mut renderer = Renderer::new(&gpu).unwrap();
        let (mut most, mut least) = (0, usize::MAX);
        let mut of_level = [0; 3];
        for camera in ["0,0,60,0,-10,60", "-700,350,400,110,-35,40", "9000,-9000,900,315,0,20", "5,5,2500,0,-90,70"] {
            let pose = crate::tests::common::pose_of(&camera.parse().unwrap());
            let view = still(pose, SIZE_PX);
            draw(&gpu, &mut surfaces, &mut renderer, &view, &style, &NOON);
            let wanted = seen(&placed, &view, &surfaces.terrain.earth_curvature(pose.position_m.z));
            let found = listed(&gpu, &renderer, &placed);
            let off = differing(&wanted, &found);
            assert!(found.is_sorted_by(|a, b| a.standing < b.standing));
            println!("1/R {inverse_radius:.1e}, {camera}: {} seen, {off} differ", wanted.len());
            // A few instances at a threshold may differ: f32 has a relative precision of some 1e-6.
            assert!(off <= 1 + wanted.len() / 200, "{camera}: {off} of {}", wanted.len());
            (most, least) = (most.max(wanted.len()), least.min(wanted.len()));
            (0..3).for_each(|level| of_level[level] += wanted.iter().filter(|seen| seen.level == level).count());
            // Planted: all instances at full detail.
            let whole: Vec<_> = wanted.iter().map(|seen| VisibleInstance { level: 0, ..*seen }).collect();
            assert!(wanted.iter().all(|seen| seen.level == 0) || differing(&whole, &found) > 1 + wanted.len() / 200);
            // Planted: an eye rotated by 17°.
            let forward = (pose.forward + 0.3 * pose.right).normalize();
            let turned = Pose { forward, right: forward.cross(pose.up).normalize(), ..pose };
            let turned = seen(
                &placed,
                &View::whole(turned, turned, SIZE_PX),
                &surfaces.terrain.earth_curvature(pose.position_m.z),
            );
            assert!(differing(&turned, &found) > 1 + wanted.len() / 200, "{camera}");
        }
        assert!(of_level.iter().all(|count| *count > 0), "{of_level:?}");
        assert!(least > 5 && most > 60 && most < STANDING as usize / 2, "{least} {most}");
    }
}
