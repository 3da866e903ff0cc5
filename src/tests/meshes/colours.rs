//! Tests that models have the lightness of their materials in every kind of tone, and that they differ from land.

use std::sync::Arc;

use glam::DVec3;
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::mesh::paint::Paint;
use hachure::mesh::placed::Placed;
use hachure::mesh::{Material, Mesh};
use hachure::surface::SURFACE_ID;
use hachure::tones::TONE;

use crate::tests::common::draw::{draw, halves, normals, north_west, still};
use crate::tests::common::{absolute, full};
use crate::tests::meshes::shapes;

const SIZE_PX: [u32; 2] = [320, 180];

fn painted(color: [f32; 3]) -> Mesh {
    let soup = shapes::sphere(3);
    let materials = vec![Material::plain(String::new()), Material { name: "paint".to_owned(), color }];
    let of_triangles = vec![1; soup.triangles.len()];
    soup.into_painted_mesh("ball.obj".to_owned(), Paint { materials, of_triangles }).unwrap()
}

#[test]
fn lightness_follows_colours() {
    let of = |color: [f32; 3]| Material { name: "a".to_owned(), color }.lightness();
    let of = [[0.0; 3], [0.05, 0.03, 0.02], [0.2, 0.2, 0.2], [0.6, 0.5, 0.4], [1.0; 3]].map(of);
    assert!(of.is_sorted() && of[0] == 0.3 && of[4] < 1.0 && of[4] > 0.999, "{of:?}");
    // A material without a colour is as light as the land, but its value differs from that of the land.
    assert!((0.999_999..1.0).contains(&Material::plain(String::new()).lightness()));
}

#[test]
fn a_model_is_as_light_as_its_material_in_every_tone() {
    let Some((hill, mut world)) = shapes::hill() else { return };
    let meshes = [[1.0; 3], [0.02, 0.03, 0.01], Material::PLAIN_COLOR].map(|color| Arc::new(painted(color)));
    let lightness = meshes.each_ref().map(|mesh| mesh.materials[1].lightness());
    // A ball with and one without materials.
    let bare = Arc::new(shapes::mesh(shapes::sphere(3)));
    let at_m = DVec3::new(-300.0, -500.0, hill.height_m(-300.0, -500.0) + 30.0);
    let pose = world.pose("-320,-620,+8,8,3,40");
    // Blinn-Phong shading, light in steps, and darkness by slope.
    for (name, most) in [("plain", 0.7), ("lsa", 0.995), ("hachures", 0.95)] {
        let mut style = absolute(name);
        if !full() {
            // Lines and marks do not change the tone of a pixel.
            style = style.of_tones().without(&["water"]);
        }
        if name == "lsa" {
            // Otherwise the whole model is in the darkest step.
            (style.light.wrap, style.light.contrast) = (1.0, 1.0);
        }
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let mut tones = Vec::new();
        for mesh in meshes.iter().chain([&bare]) {
            let mut placed = Placed::default();
            placed.add(mesh, &shapes::stance(at_m, 0.0, 20.0)).unwrap();
            world.surfaces.set_meshes(placed);
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &north_west());
            let normals = normals(&world.gpu, &renderer);
            let ids = read(&world.gpu, renderer.target(&SURFACE_ID).unwrap(), [0, 0], SIZE_PX).unwrap();
            let is_mesh: Vec<bool> = ids.chunks_exact(4).map(|id| id[3] >> 6 == 2).collect();
            let wanted = mesh.materials.last().unwrap().lightness();
            let fits = |(normal, is_mesh): (&[f32; 4], &bool)| match is_mesh {
                true => normal[3] == wanted,
                false => normal[3] == 1.0 || normal[3] == 0.0,
            };
            assert!(normals.iter().zip(&is_mesh).all(fits), "{name}");
            let shown = halves(&world.gpu, renderer.target(&TONE).unwrap());
            let own = shown.iter().zip(&is_mesh).filter(|own| *own.1).map(|own| own.0[3]);
            let own: Vec<f64> = own.collect();
            assert!(own.len() > 1500);
            tones.push(own.iter().sum::<f64>() / own.len() as f64);
        }
        println!("{name}: {tones:.4?} of {lightness:.4?}");
        let [white, dark, plain, bare] = tones.try_into().unwrap();
        // The model is as light as the land, whether it has no material or a plain one.
        assert!((plain - bare).abs() < 1e-6_f64 && (white - plain).abs() < 1e-3, "{name}");
        // Control: without lightness, the dark model would equal the others.
        assert!(dark < most * white && dark > 0.1 * white, "{name}");
    }
}
