//! Tests that a vector file shows the inks of the picture in their colours and in their order, for every preset and for
//! layers that a style file repeats or reorders.

use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::frame::{Light, Renderer};
use hachure::gpu::readback::read_as;
use hachure::picture::PictureRequest;
use hachure::picture::strokes::render_strokes;
use hachure::style::color::{linear_from_srgb, srgb_from_linear};
use hachure::style::layers::Trace;
use hachure::style::{Color, Layer, Style, StyleInk, Tone};
use hachure::vector::sheet::Sheet;
use hachure::vector::{Group, Settings, groups, layers};

use crate::tests::common::draw::{draw, still};
use crate::tests::common::{World, absolute, full, presets};
use crate::tests::vector::svg::{Read, rasterised_at, read, written_layers};

const SIZE_PX: [u32; 2] = [256, 192];
const WINDOW_PX: usize = 64;
const CAMERA: &str = "-12000,9000,+900,120,-12,50";
/// Largest difference of the mean colour of a window, from 0 to 1 in linear light.
const ALLOWED: f64 = 0.03;
/// The marks of these presets are ragged, and lines of one width cover a little less or more.
const RAGGED: [(&str, f64); 4] = [("charcoal", 0.045), ("dry-ink", 0.05), ("pencil", 0.037), ("woodcut", 0.036)];

/// Returns the style without what a vector file leaves out: tones, detected lines, stroke textures, paper and sky.
fn of_inks(style: &Style) -> Style {
    let mut style = style.clone().without(&["lines"]);
    if let Tone::Toon(toon) = &mut style.tone {
        toon.wash = 0.0;
    }
    (style.watercolor, style.focus, style.haze.color) = (None, None, Color::WHITE);
    (style.paper.color, style.paper.grain) = (Color::WHITE, 0.0);
    (style.paper.margin_px, style.paper.border_px) = (0.0, 0.0);
    let sky = &mut style.sky;
    (sky.zenith, sky.horizon, sky.cloud, sky.sun) = (Color::WHITE, Color::WHITE, Color::WHITE, Color::WHITE);
    (sky.bokashi, sky.horizon_bokashi, sky.stars) = (0.0, 0.0, 0.0);
    for layer in style.layers.iter_mut() {
        match layer {
            Layer::Water(water) => (water.tint, water.mirror) = (Color::WHITE, 0.0),
            Layer::Strokes(strokes) => (strokes.texture, strokes.texture_name) = (None, None),
            _ => {}
        }
    }
    style
}

fn light() -> Light {
    Light { haze_srgb: None, ..crate::tests::common::draw::north_west() }
}

/// Returns the picture of a style in linear colours.
fn picture(world: &mut World, style: &Style) -> Vec<DVec3> {
    let view = still(world.pose(CAMERA), SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &light());
    let texels: Vec<[u16; 4]> = read_as(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap();
    let linear = |bits: u16| f64::from(half::f16::from_bits(bits).to_f32());
    texels.into_iter().map(|[red, green, blue, _]| DVec3::new(linear(red), linear(green), linear(blue))).collect()
}

/// Returns the groups of a vector file, from the bottom to the top.
fn vector_groups(world: &mut World, style: &Style) -> Vec<Group> {
    let request = PictureRequest::still(world.pose(CAMERA), SIZE_PX, style, light());
    let drawn = render_strokes(&world.gpu, &mut None, &mut world.surfaces, &request, None).unwrap();
    let ink = style.strokes().map_or(Color::default(), |strokes| strokes.ink);
    let strokes = groups(drawn.strokes.first().map_or(&[][..], Vec::as_slice), ink);
    drawn.marks.into_iter().chain(strokes).chain(drawn.marks_above).collect()
}

/// Returns the fraction of ink that an opacity stands for: SVG blends encoded values, hachure blends light.
fn part_of_opacity(color: Color, opacity: f64) -> f64 {
    let darkest = color.srgb().into_iter().fold(1.0, f32::min);
    if darkest > 0.95 {
        return opacity;
    }
    let encoded = 1.0 - opacity as f32 * (1.0 - darkest);
    let light = linear_from_srgb(encoded);
    f64::from((1.0 - light) / (1.0 - linear_from_srgb(darkest)))
}

/// Returns the picture of the groups, drawn back from an SVG in linear colours.
fn drawn_back(groups: &[Group]) -> Vec<DVec3> {
    let settings = Settings { tolerance_px: 0.25, sheet: Sheet::pixels(SIZE_PX), ink: "#000001".parse().unwrap() };
    let (layers, _) = layers(groups, &settings, None);
    let mut paths = read(&written_layers(layers, &settings));
    let mut colors = vec![DVec3::ONE; (SIZE_PX[0] * SIZE_PX[1]) as usize];
    while !paths.is_empty() {
        let end = paths.iter().position(|path| path.layer != paths[0].layer).unwrap_or(paths.len());
        let mut layer: Vec<Read> = paths.drain(..end).collect();
        let color: Color = layer[0].color.parse().unwrap();
        layer.iter_mut().for_each(|path| path.opacity = part_of_opacity(color, path.opacity));
        let ink = DVec3::from_array(color.linear().map(f64::from));
        for (under, amount) in colors.iter_mut().zip(rasterised_at(&layer, SIZE_PX)) {
            *under += (ink - *under) * f64::from(amount);
        }
    }
    colors
}

/// Returns the largest difference of the mean colour of a window.
fn worst(one: &[DVec3], other: &[DVec3]) -> f64 {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mean = |picture: &[DVec3], x: usize, y: usize| {
        let rows = (y..y + WINDOW_PX).flat_map(|row| &picture[row * width + x..row * width + x + WINDOW_PX]);
        rows.fold(DVec3::ZERO, |sum, color| sum + *color) / (WINDOW_PX * WINDOW_PX) as f64
    };
    let corners = (0..height / WINDOW_PX).flat_map(|y| (0..width / WINDOW_PX).map(move |x| (x, y)));
    let corners = corners.map(|(x, y)| (x * WINDOW_PX, y * WINDOW_PX));
    corners.map(|(x, y)| (mean(one, x, y) - mean(other, x, y)).abs().max_element()).fold(0.0, f64::max)
}

#[test]
fn files_of_every_preset_have_the_colors_of_the_picture() {
    let Some(mut world) = World::real("dem/geotiff/mt_rainier_90m.tif", 1.0) else { return };
    let mut failed = Vec::new();
    for name in if full() { presets() } else { vec!["strokes", "stipple"] } {
        let style = of_inks(&absolute(name));
        let groups = vector_groups(&mut world, &style);
        let shown = picture(&mut world, &style);
        let difference = worst(&drawn_back(&groups), &shown);
        // Planted errors: no lines at all, and the colour of each group inverted.
        let inked = worst(&drawn_back(&[]), &shown);
        let mut wrong = groups.clone();
        for group in &mut wrong {
            group.ink = Color::from_srgb(group.ink.srgb().map(|channel| 1.0 - channel));
        }
        let inverted = worst(&drawn_back(&wrong), &shown);
        let ids: Vec<&str> = groups.iter().map(|group| group.id.as_str()).collect();
        println!("{name}: {difference:.3}; without lines {inked:.3}, inverted {inverted:.3}; {}", ids.join(" "));
        let is_drawing = |own: &StyleInk| own.ink.is_main && !matches!(own.ink.trace, Trace::LeftOut(_));
        let is_empty = groups.iter().all(|group| group.id == "rims");
        assert!(!is_empty || style.strokes().is_none() && style.hatching().is_none(), "{name} must have lines");
        if is_empty || !style.inks().iter().any(is_drawing) {
            continue;
        }
        let allowed = RAGGED.iter().find(|(ragged, _)| *ragged == name).map_or(ALLOWED, |(_, allowed)| *allowed);
        if difference > allowed || inked.max(inverted) < 1.5 * difference.max(0.02) {
            failed.push((name, difference, inked, inverted));
        }
    }
    assert!(failed.is_empty(), "{failed:.3?}");
}

/// Hatching, contour lines of height above it, and two layers of cuts around both; `order` lists the kinds.
fn layered(order: [&str; 4]) -> Style {
    let layer = |name: &&str| match *name {
        "hatching" => {
            "[[layers]]\nkind = \"hatching\"\nink = \"#000000\"\n[[layers.sets]]\nmarks = \"line\"\nsize = 2.0\n"
                .to_owned()
        }
        "heights" => {
            "[[layers]]\nkind = \"height_lines\"\nink = \"#ff2000\"\ninterval_m = 50.0\nline_px = 2.0\nindex_px = 3.0\n\
             form_px = 8.0\nfaintest = 1.0\n"
                .to_owned()
        }
        color => format!(
            "[[layers]]\nkind = \"cuts\"\nink = \"{color}\"\n[[layers.families]]\nspacing_px = 8.0\ntilt_deg = 60.0\n\
             azimuth_deg = {}\n",
            if color == "#0040ff" { 20.0 } else { 200.0 }
        ),
    };
    let layers: String = order.iter().map(layer).collect();
    let head = "name = \"layered\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0.3\nlightest = 0.7\n\
                wash = 0.0\n";
    Style::parse("layered.toml", &format!("{head}{layers}")).unwrap()
}

#[test]
fn layers_repeat_and_have_the_order_of_the_file() {
    let Some(mut world) = World::real("dem/geotiff/mt_rainier_90m.tif", 1.0) else { return };
    let style = layered(["#0040ff", "hatching", "#00a000", "heights"]).without(&["rims"]);
    let shown = picture(&mut world, &style);
    let groups = vector_groups(&mut world, &style);
    let groups: Vec<Group> = groups.into_iter().filter(|group| group.id != "rims").collect();
    let ids: Vec<&str> = groups.iter().map(|group| group.id.as_str()).collect();
    assert_eq!(ids, ["cuts-1", "cuts-1-layer-2", "heights"], "hatching is for models where the land has cuts");
    let difference = worst(&drawn_back(&groups), &shown);
    // Planted errors: only one of the two layers of cuts; contour lines below everything else.
    let one = worst(&drawn_back(&groups[1..]), &shown);
    let mut below = groups.clone();
    below.rotate_right(1);
    let below = worst(&drawn_back(&below), &shown);
    println!("difference {difference:.3}, with one layer of cuts {one:.3}, contour lines below {below:.3}");
    assert!(difference < ALLOWED && one > ALLOWED && below > ALLOWED);
    if !full() {
        return;
    }

    // Contour lines above hatching and below it, in the picture and in the file.
    let [above, below] = [["hatching", "heights"], ["heights", "hatching"]].map(|order| {
        let text = layered([order[0], order[1], "#0040ff", "#00a000"]).without(&["cuts"]);
        assert_eq!(text.layers[0].kind(), if order[0] == "hatching" { "hatching" } else { "height_lines" });
        (picture(&mut world, &text), drawn_back(&vector_groups(&mut world, &text)))
    });
    println!("orders differ by {:.3}, files by {:.3}", worst(&above.0, &below.0), worst(&above.1, &below.1));
    assert!(worst(&above.0, &above.1) < ALLOWED && worst(&below.0, &below.1) < ALLOWED);
    // Planted error: the file of the other order.
    assert!(worst(&above.0, &below.1) > ALLOWED && worst(&below.0, &above.1) > ALLOWED);
}

#[test]
fn opacities_stand_for_their_fraction_of_ink() {
    let color: Color = "#14120f".parse().unwrap();
    // On white, an opacity of 0.5 looks like the mean of the encoded values.
    let encoded = 0.5 + 0.5 * color.srgb().into_iter().fold(1.0, f32::min);
    let linear = color.linear().into_iter().fold(1.0, f32::min);
    let light = f64::from(1.0 + (linear - 1.0) * part_of_opacity(color, 0.5) as f32);
    assert!((f64::from(srgb_from_linear(light as f32)) - f64::from(encoded)).abs() < 1e-3);
}
