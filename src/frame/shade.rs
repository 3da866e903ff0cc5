//! The tones of an eye and the inks that reproduce them, before lines and paper.

use super::passes::Seen;
use super::trees as frame_trees;
use super::{EyeMemory, FrameInputs, inks, mark_sets, rows, water as frame_water};
use crate::composite;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::lines::tone::{self, tone_image};
use crate::style::Layer;
use crate::surface::{draped_image, form, mark_normal};
use crate::tiles::Terrain;
use crate::tones::light::LightUniform;
use crate::tones::masses::FrameMasses;
use crate::tones::{self, Local, TONE, balance, hatching, relief, watercolor};

/// The least range of heights over which tints run, as a part of the longer side of the world.
const LEAST_TINTED: f64 = 1e-4;

/// The tones of an eye.
pub(super) struct Shaded {
    /// Colours of the surface for the composite, with water and watercolour.
    pub(super) colors: Target,
    /// Cover and ink balance of the hatching marks, in a style with hatching.
    pub(super) balance: Option<balance::Inputs>,
    /// The picture of each layer's ink, by the index of the layer; `None` for layers that other functions draw:
    /// hatching, rims, detected lines and strokes.
    pub(super) inks: Vec<Option<Target>>,
}

/// Draws the tones of an eye and the inks that depend on them. Hatching marks are only counted: [`balance::draw`] draws
/// them when the counts of all eyes are known. The eye that `leads` sets the curve of the tones of all, so it comes first.
pub(super) fn shade(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    seen: &Seen,
    leads: bool,
    memory: &mut EyeMemory,
) -> Shaded {
    let &FrameInputs { world, rig, style, light, .. } = inputs;
    let (terrain, origin_m, gpu) = (&world.terrain, rig.origin_m, recorder.gpu());
    let Seen { view, surface_id, distance, normal, local_color, tree_shadow, tree_form, water, bends, .. } = seen;
    let water = water.as_ref();
    let targets = &mut memory.targets;

    // Marks are placed on the land, and on trees as if these were flat; their normals have the scale of marks.
    let hatching = rows::drawn_hatching(inputs);
    let of_trees = tree_form.as_ref().filter(|_| hatching.is_some());
    let of_trees =
        of_trees.map(|form| frame_trees::marks(recorder, [surface_id, distance, normal, form], view, targets));
    let (mark_distance, mark_surface) =
        of_trees.as_ref().map_or((distance, normal), |[place, surface]| (place, surface));
    let off_land =
        hatching.and_then(|_| rows::off_land_distance(recorder, inputs, view, [surface_id, mark_distance], targets));
    let mark_distance = off_land.as_ref().unwrap_or(mark_distance);
    let mark_normal = hatching.map(|hatching| {
        let size = mark_normal::mark_normal_size(targets.size_px());
        let mark_normal = &targets.sized(gpu, &mark_normal::MARK_NORMAL, size);
        let heights = &terrain.resources();
        let (distance, normal) = (mark_distance, mark_surface);
        let ground =
            mark_normal::Inputs { view, hatching, terrain: heights, surface_id, distance, normal, mark_normal };
        mark_normal::run(recorder, &ground);
        mark_normal.clone()
    });
    let form_normal = style.needs_form().then(|| {
        let size = mark_normal::mark_normal_size(targets.size_px());
        let form_normal = targets.sized(gpu, &form::FORM_NORMAL, size);
        let planes = style.has_planes().then(|| targets.sized(gpu, &form::PLANES, size));
        let heights = &terrain.resources();
        let (planes, form_normal) = (planes.as_ref(), &form_normal);
        let shading = form::Inputs { view, terrain: heights, style, light, surface_id, distance, form_normal, planes };
        form::run(recorder, &shading);
        form_normal.clone()
    });
    let image = world.imagery().filter(|_| style.image.is_used()).map(|imagery| {
        let draped_image = targets.whole(gpu, &draped_image::DRAPED_IMAGE);
        let seen = draped_image::Inputs {
            view,
            terrain: terrain.uniform(),
            imagery,
            style: &style.image,
            surface_id,
            distance,
            normal,
            draped_image: &draped_image,
        };
        draped_image::run(recorder, &seen);
        draped_image
    });
    let nothing = &targets.sized(gpu, &composite::NOTHING, [1, 1]);
    let tone = targets.whole(gpu, &TONE);
    // A prewarming run binds nothing, so it needs no maps for the pipelines that read them.
    let is_mapped = style.needs_horizons() && (terrain.horizon_maps().is_some() || recorder.prewarms());
    let horizon_maps = is_mapped.then(|| terrain.horizon_map_resources().unwrap_or_else(|| terrain.resources()));
    let relief_light = style.drawn_relief().map(|relief| {
        let lit = relief::Inputs {
            view,
            relief,
            style,
            light,
            pose: &rig.eyes[0].pose,
            terrain: &terrain.resources(),
            horizon_maps: horizon_maps.clone().map(|maps| (terrain.uniform(), maps)),
            tree_shadow: tree_shadow.as_ref(),
            surface_id,
            distance,
            normal,
            form_normal: form_normal.as_ref().unwrap_or(nothing),
        };
        relief::run(recorder, &lit, targets)
    });
    let toned = tones::Inputs {
        view,
        terrain: terrain.uniform(),
        horizon_maps,
        style,
        light,
        camera_z_m: origin_m.z as f32,
        range_m: tinted_range_m(terrain),
        distance,
        normal,
        form_normal: form_normal.as_ref().unwrap_or(nothing),
        relief_light: relief_light.as_ref(),
        crest_light: bends.crest_light.as_ref(),
        nothing,
        mark_surface: of_trees.as_ref().map(|[_, surface]| surface),
        tree_shadow: tree_shadow.as_ref(),
        image: image.as_ref(),
        local: local_color.as_ref().map(|color| Local { surface_id, color, amount: style.tone.local_color() }),
        fit: inputs.fit.as_ref(),
        masses: None,
        tone: &tone,
    };
    if let Some(fit) = inputs.fit.as_ref().filter(|_| leads) {
        tones::fit::run(recorder, &toned, water, fit);
    }
    let masses = inputs.masses.as_ref().zip(style.edited_masses()).map(|(masses, toon)| match masses {
        FrameMasses::Given(given) => given.clone(),
        FrameMasses::Own => tones::masses::run(recorder, &toned, rig.eyes[0].picture_px, water, toon),
    });
    tones::run(recorder, &tones::Inputs { masses: masses.as_ref(), ..toned });
    let tone_ink = style.tone_lines().map(|lines| {
        let cells = tone::cells(lines, targets.size_px());
        let tone_image = &targets.sized(gpu, &tone_image::TONE_IMAGE, cells);
        let uniform = LightUniform::new(style, light);
        let shading = tone_image::Inputs {
            view,
            style: lines,
            light: recorder.uniform("light", &uniform),
            to_sun: light.to_sun,
            pose: &rig.eyes[0].pose,
            distance,
            normal,
            form_normal: form_normal.as_ref(),
            nothing,
            tone_image,
        };
        tone_image::run(recorder, &shading);
        tone::trace(recorder, &tone::Inputs { view, style: lines, distance, tone_image }, targets)
    });
    // Water sets the requested tone to 1, so no marks are drawn on it.
    let of_water = frame_water::EyeInputs { view, distance, water, tone: &tone };
    let watered = frame_water::draw(recorder, inputs, &of_water, targets);
    let (tone, water_ink) = watered.map_or((tone, None), |watered| (watered.tone, Some(watered.ink)));
    let colors = style.watercolor.as_ref().map_or(tone.clone(), |watercolor| {
        let washed = targets.whole(gpu, &watercolor::WASHED);
        let wet = watercolor::Inputs { view, watercolor, origin_m, distance, tone: &tone, washed: &washed };
        watercolor::run(recorder, &wet);
        washed
    });
    let balance = hatching.zip(mark_normal.as_ref()).map(|(hatching, mark_normal)| {
        let balance = balance::Inputs::new(recorder, targets, view, hatching);
        let (tone, cover, distance, normal) = (&tone, &balance.cover, mark_distance, mark_surface);
        let set = None;
        let bend_axis = bends.axis.as_ref().unwrap_or(nothing);
        let marks =
            hatching::Inputs { view, hatching, origin_m, distance, normal, mark_normal, bend_axis, tone, set, cover };
        mark_sets::hatch(recorder, &marks);
        balance::count(recorder, &balance);
        if inputs.wants_mark_sets {
            mark_sets::draw(recorder, &marks, &balance, targets);
        }
        balance
    });
    let rows = rows::draw(recorder, inputs, view, [surface_id, distance, &tone], targets);
    let at_eye = inks::EyeInputs { view, surface_id, distance, normal, tone: &tone, water: water.unwrap_or(nothing) };
    let inks = style.layers.iter().enumerate().map(|(index, layer)| match layer {
        Layer::ToneLines(_) => tone_ink.clone(),
        Layer::Rows(_) => rows.clone(),
        Layer::Water(_) => water_ink.clone(),
        Layer::Drainage(layer) => {
            inks::draw_drainage(recorder, inputs, (layer, style.layers.number(index)), &at_eye, targets)
        }
        Layer::Features(layer) => {
            inks::draw_features(recorder, inputs, (layer, style.layers.number(index)), &at_eye, targets)
        }
        _ => inks::draw(recorder, inputs, layer, style.layers.number(index), &at_eye, targets),
    });
    let inks = inks.collect();
    Shaded { colors, balance, inks }
}

/// Returns the heights over which tints of land run, in metres: those of the land. Level land gets a range of its own,
/// which is a metre, or less where the whole world is small, such as that of a model: how high something stands above
/// the ground would otherwise tint models by their size.
fn tinted_range_m(terrain: &Terrain) -> [f32; 2] {
    let [low_m, high_m] = terrain.range_m();
    let least_m = (LEAST_TINTED * terrain.extent_m().into_iter().fold(0.0, f64::max)).min(1.0);
    [low_m, high_m.max(low_m + least_m as f32).max(low_m.next_up())]
}
