//! Tests that every shader composes and validates without a GPU, and that its SPIR-V is accepted by the Khronos
//! validator.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::io::Write;
use std::process::{Command, Stdio};

use hachure::gpu::readback::read_buffer;
use hachure::gpu::shader::{MODULES, SHADERS, ShaderError, VARIANTS, compose, compose_variant};
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use crate::tests::common;
use crate::tests::helpers::probe;

#[test]
fn every_shader_validates() {
    for (name, _) in SHADERS {
        validate(name, compose(name));
    }
    for (name, definitions) in VARIANTS {
        validate(name, compose_variant(name, definitions));
        // The definitions must change the code.
        let size = |module: Result<naga::Module, ShaderError>| {
            let module = module.unwrap();
            let entries = module.entry_points.iter().map(|entry| &entry.function);
            let functions = module.functions.iter().map(|(_, function)| function).chain(entries);
            functions.map(|function| function.expressions.len()).sum::<usize>()
        };
        assert_ne!(size(compose(name)), size(compose_variant(name, definitions)), "{name}");
    }
}

fn validate(name: &str, module: Result<naga::Module, ShaderError>) -> (naga::Module, ModuleInfo) {
    let module = module.unwrap_or_else(|error| panic!("{error}"));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    let info = validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {error:?}"));
    (module, info)
}

/// Tests the number of uniform buffers: a driver writes out of bounds where branches depend on more than three
/// (docs/decisions/software-drivers.md).
#[test]
fn few_uniform_buffers_are_bound() {
    let mut with_more = std::collections::BTreeSet::new();
    let plain = SHADERS.iter().map(|(name, _)| (*name, &[][..]));
    for (name, definitions) in plain.chain(VARIANTS.iter().copied()) {
        let (module, info) = validate(name, compose_variant(name, definitions));
        for number in 0..module.entry_points.len() {
            let used = info.get_entry_point(number);
            let uniforms: Vec<&str> = module
                .global_variables
                .iter()
                .filter(|(handle, global)| global.space == naga::AddressSpace::Uniform && !used[*handle].is_empty())
                .filter_map(|(_, global)| global.name.as_deref())
                .collect();
            if uniforms.len() > 3 {
                with_more.insert(name);
            }
        }
    }
    // This shader has four, and no branch depends on one of them.
    assert_eq!(Vec::from_iter(with_more), ["tones/toon"]);
}

#[test]
fn a_wrong_shader_does_not() {
    assert!(compose("lines/none").is_err());
}

#[test]
fn every_shader_is_spirv_that_its_validator_accepts() {
    if Command::new("spirv-val").arg("--version").stdout(Stdio::null()).status().is_err() {
        println!("skipped: spirv-val (spirv-tools) is not installed");
        return;
    }
    let plain = SHADERS.iter().map(|(name, _)| (*name, &[][..]));
    let mut checked = 0;
    let mut last = Vec::new();
    for (name, definitions) in plain.chain(VARIANTS.iter().copied()) {
        let (module, info) = validate(name, compose_variant(name, definitions));
        for entry in &module.entry_points {
            // Devices with and without robust access get different code.
            for policy in [BoundsCheckPolicy::Unchecked, BoundsCheckPolicy::Restrict] {
                let words = spirv(&module, &info, entry, policy).unwrap_or_else(|error| panic!("{name}: {error}"));
                let message = spirv_val(&words);
                assert_eq!(message, None, "{name} {definitions:?}, {}", entry.name);
                checked += 1;
                last = words;
            }
        }
    }
    println!("spirv-val accepted {checked} modules");
    assert!(checked >= 2 * (SHADERS.len() + VARIANTS.len()));
    // Planted error: an invalid memory model, which is an operand of the first instruction after the capabilities.
    let at = last.iter().position(|word| *word == 3 << 16 | 14).unwrap();
    last[at + 2] = 77;
    assert!(spirv_val(&last).is_some(), "an invalid memory model was accepted");
}

/// Returns the SPIR-V of an entry point as wgpu writes it for a Vulkan 1.1 device.
fn spirv(
    module: &naga::Module,
    info: &ModuleInfo,
    entry: &naga::EntryPoint,
    policy: BoundsCheckPolicy,
) -> Result<Vec<u32>, spv::Error> {
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::FORCE_POINT_SIZE,
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: policy,
            image_load: policy,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Polyfill,
        use_storage_input_output_16: false,
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone() };
    spv::write_vec(module, info, &options, Some(&pipeline))
}

/// Returns the output of the validator if it rejects the words.
fn spirv_val(words: &[u32]) -> Option<String> {
    let mut child = Command::new("spirv-val")
        .args(["--target-env", "vulkan1.1", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap();
    let message = [output.stdout, output.stderr].concat();
    (!output.status.success()).then(|| String::from_utf8_lossy(&message).into_owned())
}

/// Evaluates the text of `hachure::power` with a `pow` as GPUs compute it: exp2(y log2(x)), where log2(0) is minus
/// infinity, log2 of a negative number is not a number, and infinity times 0 is not a number.
const POWER_PROBE: &str = r"
struct Question { base: f32, exponent: f32, minus_infinity: f32, not_a_number: f32 }
@group(0) @binding(0) var<storage, read> questions: array<Question>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec2<f32>>;
var<private> question: Question;
fn strict_pow(base: f32, exponent: f32) -> f32 {
    if base < 0.0 || (base == 0.0 && exponent == 0.0) {
        return question.not_a_number;
    }
    return select(exp2(exponent * log2(base)), 0.0, base == 0.0);
}
TEXT
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    question = questions[id.x];
    answers[id.x] = vec2<f32>(power(question.base, question.exponent), strict_pow(question.base, question.exponent));
}
";

#[test]
fn powers_of_zero_and_below_are_numbers() {
    let Some(gpu) = common::gpu() else { return };
    let (_, text) = MODULES.iter().find(|(name, _)| *name == "shared/power").unwrap();
    let text: String =
        text.lines().filter(|line| !line.starts_with("#define_import_path")).collect::<Vec<_>>().join("\n");
    assert_eq!(text.matches(" pow(").count(), 1);
    let probe = POWER_PROBE.replace("TEXT", &text.replace(" pow(", " strict_pow("));
    let bases = [-1e-7_f32, -0.0, 0.0, 1e-38, 1e-7, 0.25, 0.5, 1.0];
    let exponents = [0.0_f32, 0.01, 0.2, 1.0, 2.0, 5.0, 64.0, 256.0];
    let questions: Vec<[f32; 4]> = bases
        .iter()
        .flat_map(|base| exponents.iter().map(|exponent| [*base, *exponent, f32::NEG_INFINITY, f32::NAN]))
        .collect();
    let answers = vec![0_u8; questions.len() * 8];
    let buffers = [bytemuck::cast_slice(&questions), &answers[..]].map(|contents| probe::storage(&gpu, contents));
    probe::run(&gpu, &probe, buffers.iter().map(wgpu::Buffer::as_entire_binding), questions.len());
    let answers: Vec<[f32; 2]> = read_buffer(&gpu, &buffers[1], questions.len()).unwrap();
    let mut planted = 0;
    for ([base, exponent, ..], [own, raw]) in questions.into_iter().zip(answers) {
        let expected = base.max(1e-37).powf(exponent);
        assert!((0.0..=1.0).contains(&own) && (own - expected).abs() < 1e-4, "{base}^{exponent}: {own}");
        // Planted: without the least base, powers of 0 and below are not numbers.
        planted += u32::from(raw.is_nan());
    }
    assert!(planted > 8, "{planted}");
}

/// A power of a base that may be 0 or slightly negative is not a number on some GPUs, so passes call `power`.
#[test]
fn passes_call_power() {
    // Bases that are above 0, or whose power is not selected otherwise.
    const SAFE: [&str; 3] = ["shared/power", "shared/color", "shared/local_color"];
    let calls = |text: &str| {
        let code = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
        let found = text.lines().map(code).filter(|line| {
            line.match_indices("pow(").any(|(at, _)| !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
        });
        found.count()
    };
    let raw = MODULES.iter().chain(SHADERS).filter(|(name, text)| calls(text) > 0 && !SAFE.contains(name));
    assert_eq!(raw.map(|(name, _)| *name).collect::<Vec<_>>(), [""; 0]);
    // Planted.
    assert_eq!(calls("let a = pow(b, c); // pow(\nlet d = strict_pow(b, c);"), 1);
}
