//! Tests the program in a simulated headset: the OpenXR loader loads our own runtime (`runtime`), which plays a script,
//! checks every call, and logs violations.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]
#![cfg(target_os = "linux")]

#[path = "../../src/tests/common/mod.rs"]
mod common;

mod client;
mod flights;
mod monado;
mod panel;
mod pictures;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use hachure::headset::{HeadsetError, Runtime};

use crate::common::hill::Hill;

/// Name of the validation layer's synchronisation checks.
const SYNCHRONISATION: &str = "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT";

/// A folder with a world, a manifest of the runtime, and the logs of a run.
pub struct Room(tempfile::TempDir);

/// Output of a run.
pub struct Run {
    /// Exit status of the process.
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    /// The runtime's log.
    pub log: String,
    /// Messages of the validation layer, or `None` if the layer is not installed.
    pub layer: Option<Vec<String>>,
}

impl Room {
    /// Returns `None` with a printed reason if the loader or a driver is missing.
    pub fn new() -> Option<Self> {
        static MISSING: OnceLock<Option<String>> = OnceLock::new();
        let missing = MISSING.get_or_init(|| match Runtime::connect() {
            Err(error @ HeadsetError::NoLoader { .. }) => Some(error.to_string()),
            _ => hachure::gpu::Gpu::open(&hachure::gpu::device::AdapterWish::Best).err().map(|it| it.to_string()),
        });
        if let Some(missing) = missing {
            println!("skipped: {missing}");
            return None;
        }
        let room = Self(tempfile::tempdir().unwrap());
        let runtime = runtime();
        let manifest = format!(
            "{{\"file_format_version\": \"1.0.0\", \"runtime\": {{\"library_path\": \"{}\"}}}}",
            runtime.display()
        );
        std::fs::write(room.path("runtime.json"), manifest).unwrap();
        Some(room)
    }

    /// Returns a folder with a hill of 3 km in `world.tif`.
    pub fn with_hill() -> Option<Self> {
        let room = Self::new()?;
        let grid = Hill::square(321, 10.0).1;
        let options = hachure::pyramid::BakeOptions::default();
        hachure::pyramid::bake(&grid, &room.path("world.tif"), &options, &hachure::source::Silent).unwrap();
        Some(room)
    }

    /// Returns the path of a file in the folder, whether it exists or not.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns a command that runs a program with the runtime and the validation layer.
    pub fn command(&self, program: &Path, script: &[(&str, &str)]) -> Command {
        let settings = format!(
            "khronos_validation.enables = {SYNCHRONISATION}\n\
             khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n\
             khronos_validation.report_flags = error,warn,perf,info\n\
             khronos_validation.log_filename = {}\n",
            self.path("layer.log").display()
        );
        std::fs::write(self.path("vk_layer_settings.txt"), settings).unwrap();
        let mut command = Command::new(program);
        command
            .current_dir(self.0.path())
            .env("HACHURE_CACHE", self.path("cache"))
            .env("XDG_RUNTIME_DIR", self.0.path())
            .env("XDG_CACHE_HOME", self.0.path())
            // The user's settings have other favourites.
            .env("XDG_CONFIG_HOME", self.0.path())
            // Mesa's compiled shaders are shared by all runs, and with the other tests.
            .env("MESA_SHADER_CACHE_DIR", directories::BaseDirs::new().unwrap().cache_dir())
            .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
            .env("VK_LAYER_SETTINGS_PATH", self.0.path())
            .env("XR_RUNTIME_JSON", self.path("runtime.json"))
            .env("HACHURE_XR_LOG", self.path("runtime.log"))
            .env_remove("RUST_LOG")
            // Without a mirror window.
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY");
        for (name, value) in script {
            // A name that begins with `=` is the full name of an environment variable.
            match name.strip_prefix('=') {
                Some(name) => command.env(name, value),
                None => command.env(format!("HACHURE_XR_{name}"), value),
            };
        }
        command
    }

    /// Runs a command and collects its output and logs.
    pub fn run(&self, mut command: Command) -> Run {
        for log in ["layer.log", "runtime.log"] {
            let _ = std::fs::remove_file(self.path(log));
        }
        let Output { status, stdout, stderr } = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let layer = std::fs::read_to_string(self.path("layer.log")).ok().map(|text| complaints(&text));
        Run {
            status: status.code(),
            stdout: text(stdout),
            stderr: text(stderr),
            log: std::fs::read_to_string(self.path("runtime.log")).unwrap_or_default(),
            layer,
        }
    }

    /// Flies over the hill with a script and arguments.
    pub fn fly(&self, script: &[(&str, &str)], arguments: &[&str]) -> Run {
        let mut command = self.command(Path::new(env!("CARGO_BIN_EXE_hachure")), script);
        command.args(["fly", "world.tif", "--vr", "--camera=900,-900,+20,315,3,60"]).args(arguments);
        self.run(command)
    }
}

impl Run {
    /// Checks that a flight ended well and caused no complaints. Returns its output.
    pub fn well(&self, what: &str) -> &str {
        assert_eq!(self.status, Some(0), "{what}: {}", self.stderr);
        assert!(self.stderr.is_empty(), "{what}: {}", self.stderr);
        assert!(self.log.contains(" with 0 violations"), "{what}: {}", self.log);
        match &self.layer {
            Some(messages) => assert!(messages.is_empty(), "{what}: {}", messages.join("\n")),
            None => println!("skipped: the Khronos validation layer is not installed (vulkan-validationlayers)"),
        }
        &self.stdout
    }

    /// Checks that a flight failed, and returns its one line of error.
    pub fn line(&self) -> &str {
        assert_eq!(self.status, Some(1), "{}", self.stderr);
        assert!(!self.log.contains("violation:"), "{}", self.log);
        let line = self.stderr.trim_end().strip_prefix("hachure: ").unwrap_or_else(|| panic!("{}", self.stderr));
        assert_eq!(line.lines().count(), 1, "{}", self.stderr);
        line
    }
}

/// Returns the layer's messages about the program, without those about the layer itself or its cache.
fn complaints(text: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for line in text.lines() {
        let begins = [" / SPEC): msgNum", " / PERF): msgNum", " / GENERAL): msgNum"].iter().any(|it| line.contains(it));
        match all.last_mut() {
            Some(last) if !begins => last.extend(["\n", line]),
            _ => all.push(line.to_owned()),
        }
    }
    let own = ["UNASSIGNED-khronos-validation-createinstance-status-message", "UNASSIGNED-cache-file-error"];
    all.retain(|message| !own.iter().any(|name| message.starts_with(name)));
    all
}

/// Returns whether a file is missing, or older than one of the files of a folder.
fn is_older(file: &Path, folder: &Path) -> bool {
    let changed = |path: &Path| std::fs::metadata(path).and_then(|it| it.modified()).ok();
    let Some(made) = changed(file) else { return true };
    let sources = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    sources.filter_map(|source| changed(&source)).any(|source| source > made)
}

/// Returns the runtime's library, which cargo builds with the examples. `cargo test --test headset` does not build it,
/// so in that case it is built here.
fn runtime() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let library = test.parent().unwrap().parent().unwrap().join("examples/libhachure_test_runtime.so");
    if is_older(&library, &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/headset/runtime")) {
        // The folder of the profile with which this test was built; only that of `dev` has another name.
        let profile = library.ancestors().nth(2).and_then(Path::file_name).unwrap().to_str().unwrap();
        let profile = if profile == "debug" { "dev" } else { profile };
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--profile", profile, "--example", "hachure_test_runtime"]);
        cargo.current_dir(env!("CARGO_MANIFEST_DIR"));
        cargo.env_remove("RUSTC_BOOTSTRAP");
        cargo.env("CARGO_TARGET_DIR", library.ancestors().nth(3).unwrap());
        let built = cargo.output().unwrap();
        assert!(library.exists(), "{}", String::from_utf8_lossy(&built.stderr));
    }
    library
}
