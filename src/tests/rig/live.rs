//! Tests editing shaders live: a valid shader is used, an invalid one is reported, and the old pipeline stays in use.

use std::path::Path;
use std::time::{Duration, Instant};

use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::GpuError;
use hachure::gpu::pipelines::Builds;
use hachure::gpu::texts::Texts;
use hachure::scene::view::Rig;
use hachure::style::Style;

use crate::tests::common::{World, full};
use crate::tests::rig::{START, bytes, draw_rig, hill_apart, view};

const COMPOSITE: &str = include_str!("../../../shaders/composite/composite.wgsl");
const VIEW: &str = include_str!("../../../shaders/shared/view.wgsl");

/// A renderer whose shaders are read from a folder.
struct Live {
    world: World,
    renderer: Renderer,
    style: Style,
    rig: Rig,
    folder: tempfile::TempDir,
}

impl Live {
    fn new(style: &str) -> Option<Self> {
        let world = hill_apart()?;
        let pose = world.pose(START);
        let folder = tempfile::tempdir().unwrap();
        for part in ["composite", "shared"] {
            std::fs::create_dir(folder.path().join(part)).unwrap();
        }
        let renderer = Renderer::new(&world.gpu).unwrap();
        world.gpu.pipelines().set_texts(texts(folder.path()));
        let style = Style::load(style).unwrap();
        Some(Self { world, renderer, style, rig: Rig::mono(view(pose, pose)), folder })
    }

    /// Writes a shader, and returns how many pipelines are rebuilt.
    fn write(&mut self, name: &str, text: &str) -> usize {
        std::fs::write(self.folder.path().join(format!("{name}.wgsl")), text).unwrap();
        self.renderer.reload_shaders(&self.world.gpu)
    }

    fn picture(&mut self) -> Vec<u8> {
        draw_rig(&mut self.world, &mut self.renderer, &self.style, &self.rig);
        bytes(&self.world, &self.renderer, 0, &PICTURE)
    }

    fn troubles(&self) -> Vec<String> {
        self.world.gpu.pipelines().shader_errors().iter().map(ToString::to_string).collect()
    }
}

fn texts(folder: &Path) -> Texts {
    Texts::of(Some(folder.to_owned()))
}

/// Returns the composite shader with `old` replaced by `new`.
fn changed(old: &str, new: &str) -> String {
    assert!(COMPOSITE.contains(old), "the shader has changed: {old}");
    COMPOSITE.replace(old, new)
}

/// Returns the position that a message should contain: `:83:`, the first line of the composite that contains `text`.
fn line_of(text: &str) -> String {
    let line = COMPOSITE.lines().position(|line| line.contains(text));
    format!(":{}:", line.expect("the shader has changed") + 1)
}

const LAST: &str = "textureStore(picture, pixel, vec4<f32>(color, alpha));";
const LAST_INVERTED: &str = "textureStore(picture, pixel, vec4<f32>(1.0 - color, alpha));";

#[test]
fn a_changed_shader_is_drawn_with_and_a_wrong_one_is_not() {
    let Some(mut live) = Live::new("lsa") else { return };
    let first = live.picture();
    assert_eq!(live.renderer.reload_shaders(&live.world.gpu), 0);
    assert_eq!(live.write("composite/composite", &changed(LAST, LAST_INVERTED)), 1);
    let inverted = live.picture();
    let differing = first.iter().zip(&inverted).filter(|(a, b)| a != b).count();
    assert!(differing > first.len() / 4, "{differing} bytes of {}", first.len());

    let (size, paper) = (line_of("if any(id.xy"), line_of("composite.paper;"));
    let wrong = [
        // Invalid syntax, then an unknown name.
        (changed("if any(id.xy", "if any id.xy"), size.as_str()),
        (changed("composite.paper;", "composite.papyrus;"), paper.as_str()),
        (changed("#import hachure::view::{View, ", "#import hachure::viw::{View, "), "viw"),
        ("@compute @workgroup_size(8, 8)\nfn other() {}\n".to_owned(), "no entry point main"),
        // A binding that the pass does not provide.
        (
            changed(LAST, "textureStore(picture, pixel, vec4<f32>(color, paper_px));").replace(
                "// The pictures that hold",
                "@group(0) @binding(30) var<uniform> paper_px: f32;\n// These hold",
            ),
            "nothing is bound to paper_px",
        ),
        // A binding of another type than the pass provides.
        (changed("rgba16float", "rgba32float"), "composite/composite.wgsl: "),
        // A uniform larger than the pass provides.
        (
            changed("    is_sample: u32,\n", "    is_sample: u32,\n    more: array<vec4<f32>, 64>,\n"),
            "composite/composite.wgsl: ",
        ),
        // A workgroup larger than any GPU supports.
        (changed("@workgroup_size(8, 8)", "@workgroup_size(2048, 2048)"), "composite/composite.wgsl: "),
    ];
    // In the fast tier one shader that is wrong in itself, and one that does not fit its pass.
    for (text, cause) in wrong.into_iter().step_by(if full() { 1 } else { 4 }) {
        assert_eq!(live.write("composite/composite", &text), 1, "{cause}");
        assert!(live.picture() == inverted, "{cause}: the old pipeline must stay in use");
        let troubles = live.troubles();
        assert_eq!(troubles.len(), 1, "{cause}: {troubles:?}");
        println!("{}", troubles[0]);
        assert!(troubles[0].starts_with("composite/composite.wgsl") && troubles[0].contains(cause), "{troubles:?}");
        assert!(!troubles[0].contains('\n'), "{troubles:?}");
    }

    // A repaired shader is used again: first with another layout, which omits one of the pictures (that of water, of which there is none), then the original.
    let without_ink = changed("textureLoad(ink_0, pixel, 0)", "vec4<f32>(0.0)");
    assert_eq!(live.write("composite/composite", &without_ink), 1);
    assert!(live.picture() == first && live.troubles().is_empty(), "{:?}", live.troubles());
    live.write("composite/composite", COMPOSITE);
    assert!(live.picture() == first && live.troubles().is_empty(), "{:?}", live.troubles());
}

#[test]
fn a_module_rebuilds_all_that_imports_it() {
    let Some(mut live) = Live::new(if full() { "lsa" } else { "plain" }) else { return };
    let first = live.picture();
    let pipelines = live.renderer.built_at_once() as usize;
    let rebuilt = live.write("shared/view", VIEW);
    assert!(rebuilt > 3 && rebuilt < pipelines, "{rebuilt} of {pipelines}");
    assert!(live.picture() == first);
    // An error in a module is a single message that names the module, even if several shaders import it.
    assert_eq!(live.write("shared/view", &VIEW.replace("struct View {", "struct View [")), rebuilt);
    assert!(live.picture() == first);
    let troubles = live.troubles();
    assert_eq!(troubles.len(), 1, "{troubles:?}");
    assert!(troubles[0].starts_with("shared/view.wgsl:"), "{troubles:?}");
    live.write("shared/view", VIEW);
    assert!(live.picture() == first && live.troubles().is_empty(), "{:?}", live.troubles());
}

#[test]
fn a_frame_that_has_no_old_pipeline_says_what_is_wrong() {
    let Some(mut live) = Live::new("lsa") else { return };
    live.write("composite/composite", &changed("composite.paper;", "composite.papyrus;"));
    let World { gpu, surfaces, .. } = &mut live.world;
    let drawn = live.renderer.render(gpu, surfaces, &live.rig.eyes[0], &live.style, &crate::tests::rig::light());
    let error = drawn.map(|_| ()).unwrap_err();
    assert!(matches!(&error, GpuError::Shader(_)), "{error}");
    let place = format!("composite/composite.wgsl{}", line_of("composite.paper;"));
    assert!(error.to_string().starts_with(&place), "{error}");
    live.write("composite/composite", COMPOSITE);
    assert!(!live.picture().is_empty());
}

#[test]
fn in_the_background_the_old_picture_stays_until_the_new_one_is_there() {
    let Some(mut live) = Live::new(if full() { "lsa" } else { "plain" }) else { return };
    let first = live.picture();
    live.renderer.set_builds(Builds::InBackground);
    let step = |live: &mut Live| {
        let World { gpu, surfaces, .. } = &mut live.world;
        live.renderer.render(gpu, surfaces, &live.rig.eyes[0], &live.style, &crate::tests::rig::light()).unwrap();
        live.world.gpu.check().unwrap();
        bytes(&live.world, &live.renderer, 0, &PICTURE)
    };
    let until = |live: &mut Live, what: &str, is_so: &dyn Fn(&Live, &[u8]) -> bool| {
        let begun = Instant::now();
        loop {
            let picture = step(live);
            if is_so(live, &picture) {
                return picture;
            }
            assert!(picture == first, "{what}: the picture is neither the old nor the new one");
            assert!(begun.elapsed() < Duration::from_secs(120), "{what} did not come in time");
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    let built = live.renderer.built_at_once();
    until(&mut live, "the style", &|live, _| live.renderer.shows(&live.style));
    live.write("composite/composite", &changed("composite.paper;", "composite.papyrus;"));
    until(&mut live, "the message", &|live, _| !live.troubles().is_empty());
    live.write("composite/composite", &changed(LAST, LAST_INVERTED));
    let inverted = until(&mut live, "the change", &|live, picture| live.troubles().is_empty() && picture != first);
    let other = live.write("composite/composite", COMPOSITE);
    assert_eq!((other, live.renderer.built_at_once()), (1, built));
    assert!(inverted != first);
}
