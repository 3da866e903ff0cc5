//! Tests that the program draws without messages of the Khronos validation layer, synchronisation included.
//!
//! Presets with strokes, hatching, watercolour, shadows and models cover every kind of pass; the fast tier draws three
//! of them. The layer writes to a file, including that it is active and what it checks, so that a missing layer is not
//! taken for a silent one.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::process::Command;

use hachure::file::atomic;

/// One of each kind: marks, strokes and shadows; running colour; trees with lines. Then those of the long tier: lines
/// and models, chained strokes, fractal marks, and trees with strokes and marks.
const DRAWN: [(&str, &str); 7] = [
    ("hut", "crosshatch"),
    ("hut", "wash"),
    ("forest", "ink"),
    ("hut", "ink"),
    ("hut", "pen"),
    ("hut", "stipple"),
    ("forest", "crosshatch"),
];

/// Messages of the layer that concern all programs, by the beginning of their name, with the reason to ignore them.
const OTHERS: [(&str, &str); 2] = [
    ("UNASSIGNED-khronos-validation-createinstance-status-message", "the layer says that it is there"),
    ("UNASSIGNED-cache-file-error", "the layer's own cache of shaders is not there yet"),
];

/// Messages of the checks that `enables` turns on, and the layer's status about itself.
struct Report {
    messages: Vec<String>,
    status: String,
}

/// Draws two frames under the layer, so that strokes are carried over from the first. Returns `None` if the layer is
/// not installed.
fn validate(folder: &Path, (world, preset): (&str, &str), enables: &str) -> Option<Report> {
    let log = folder.join("layer.log");
    let _ = std::fs::remove_file(&log);
    let settings = format!(
        "khronos_validation.enables = {enables}\n\
         khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n\
         khronos_validation.report_flags = error,warn,perf,info\n\
         khronos_validation.log_filename = {}\n",
        log.display()
    );
    atomic::write(&folder.join("vk_layer_settings.txt"), settings.as_bytes()).unwrap();
    let flight = "t,x,y,z,yaw,pitch,fov\n0,1310,-4630,+4.5,16,3,50\n0.04,1310,-4629,+4.5,17,3,50\n";
    atomic::write(&folder.join("flight.csv"), flight.as_bytes()).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hachure"))
        .args(["render", world, "--size", "96x54", "--style", preset, "--path", "flight.csv", "--fps", "25"])
        .args(["-o", "frame%02d.png", "--antialias", "temporal"])
        .current_dir(folder)
        // Other test programs share the land of the built-in scenes, and Mesa's compiled shaders.
        .env("HACHURE_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("built-in-land"))
        .env("MESA_SHADER_CACHE_DIR", directories::BaseDirs::new().unwrap().cache_dir())
        .env("XDG_RUNTIME_DIR", folder)
        .env("XDG_CACHE_HOME", folder)
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_SETTINGS_PATH", folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{preset}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.join("frame00.png").exists() && folder.join("frame01.png").exists());
    let text = std::fs::read_to_string(&log).ok()?;
    // A message begins with its name and its kind, and continues until the next one.
    let mut all: Vec<String> = Vec::new();
    for line in text.lines() {
        let begins = [" / SPEC): msgNum", " / PERF): msgNum", " / GENERAL): msgNum"].iter().any(|it| line.contains(it));
        match all.last_mut() {
            Some(last) if !begins => last.extend(["\n", line]),
            _ => all.push(line.to_owned()),
        }
    }
    let (status, messages) = all.into_iter().partition::<Vec<_>, _>(|message| message.starts_with(OTHERS[0].0));
    let messages = messages.into_iter().filter(|text| !OTHERS.iter().any(|(name, _)| text.starts_with(name))).collect();
    Some(Report { messages, status: status.concat() })
}

#[test]
fn the_validation_layer_has_nothing_to_say() {
    if hachure::gpu::Gpu::open(&hachure::gpu::device::AdapterWish::Best).is_err() {
        println!("skipped: no Vulkan driver");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let synchronisation = "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT";
    let is_full = std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full");
    for drawn in DRAWN.into_iter().take(if is_full { 7 } else { 3 }) {
        let Some(report) = validate(folder.path(), drawn, synchronisation) else {
            println!("skipped: the Khronos validation layer is not installed (vulkan-validationlayers)");
            return;
        };
        let looks = report.status.contains("Current Enables: VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION");
        assert!(looks, "the layer does not check synchronisation: {}", report.status);
        assert!(report.messages.is_empty(), "{drawn:?}: {}", report.messages.join("\n"));
    }
    // Control: with best-practice advice turned on, the layer has messages about the same frames, for example about
    // small allocations, and they arrive here.
    let advice = validate(folder.path(), ("hut", "ink"), "VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT").unwrap();
    println!("{} pieces of advice", advice.messages.len());
    assert!(!advice.messages.is_empty(), "no message of the layer arrived");
}
