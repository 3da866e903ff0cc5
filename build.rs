//! Lists the shaders, and translates their structs and constants to Rust, so that each is defined once, in WGSL. Also
//! writes the commit of a packed crate, for `hachure --version`.
//!
//! `src/gpu/shader.rs` includes the list, and `src/gpu/wgsl.rs` the structs and constants. Each struct becomes a
//! `repr(C)` struct with the same field offsets as in WGSL (specification, "Memory Layout"); a test compares all of
//! them with naga's layout. Only structs that buffers contain are translated, and only constants that are numeric
//! literals.

#![allow(
    clippy::disallowed_methods,
    reason = "half-written files do no harm: Cargo runs this script again if a build was interrupted"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// A type that Rust and WGSL share.
#[derive(Clone)]
struct Shared {
    /// The type in Rust.
    rust: String,
    /// Alignment in WGSL, in bytes.
    align: usize,
    /// Size in WGSL, in bytes.
    size: usize,
    /// Whether it consists of integers only, and so can implement `Eq` and `Hash`.
    is_whole: bool,
}

impl Shared {
    fn new(rust: impl Into<String>, align: usize, size: usize, is_whole: bool) -> Self {
        Self { rust: rust.into(), align, size, is_whole }
    }
}

/// The Rust module of a shader, of a folder of shaders, or of both.
#[derive(Default)]
struct Room {
    rooms: BTreeMap<String, Room>,
    /// The generated code of the shader; empty for a mere folder.
    text: String,
}

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=shaders");
    println!("cargo::rerun-if-changed=build.rs");
    // The extension of the Python package, which is an example here: Python itself has the functions that it calls.
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "macos") {
        println!("cargo::rustc-link-arg-examples=-Wl,-undefined,dynamic_lookup");
    }
    let mut files = Vec::new();
    list(Path::new("shaders"), &mut files)?;
    files.sort();
    let sources = files.iter().map(fs::read_to_string).collect::<Result<Vec<_>, _>>()?;
    let bound = bound(&sources);
    let (mut root, mut names) = (Room::default(), String::new());
    for (file, source) in files.iter().zip(&sources) {
        let path = file.strip_prefix("shaders").unwrap_or(file).with_extension("");
        let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        let (text, structs) = shader(source, &bound);
        if text.is_empty() {
            continue;
        }
        let room = parts.iter().fold(&mut root, |room, part| room.rooms.entry(part.clone()).or_default());
        writeln!(room.text, "//! Structs and constants of `shaders/{}.wgsl`.\n{text}", parts.join("/"))
            .map_err(io::Error::other)?;
        for name in structs {
            let of = format!("{}::{name}", parts.join("::"));
            writeln!(names, "    describe::<{of}>(\"{name}\", {of}::FIELDS),").map_err(io::Error::other)?;
        }
    }
    let mut out = String::new();
    write_room(&root, &mut out);
    out += &format!(
        "/// Lists every struct above.\n#[cfg(test)]\npub(crate) fn structs() -> Vec<SharedStruct> {{\n    vec![\n{names}    ]\n}}\n"
    );
    let folder = PathBuf::from(
        env::var_os("OUT_DIR").ok_or_else(|| io::Error::other("the variable OUT_DIR is not set; Cargo sets it"))?,
    );
    fs::write(folder.join("wgsl.rs"), out)?;
    fs::write(folder.join("shaders.rs"), tables(&files, &sources)?)?;
    fs::write(folder.join("packed_commit.txt"), packed_commit())
}

/// Returns the commit from which a crate was packed, which Cargo records in the crate; an empty text in a clone.
///
/// Git is not asked here: whenever this script runs again, Cargo compiles the whole library again, so each commit would
/// cost minutes. `packaging/release` names the commit in a variable that only the program reads (`src/version.rs`).
fn packed_commit() -> String {
    const RECORD: &str = ".cargo_vcs_info.json";
    let Ok(record) = fs::read_to_string(RECORD) else {
        // Cargo would take a missing file for a changed one, and run this script in every build.
        return String::new();
    };
    println!("cargo::rerun-if-changed={RECORD}");
    let value = |key: &str| {
        let (_, rest) = record.split_once(&format!("\"{key}\":"))?;
        Some(rest.trim_start().trim_start_matches('"'))
    };
    let commit: String =
        value("sha1").unwrap_or_default().chars().take_while(char::is_ascii_hexdigit).take(12).collect();
    let has_changes = !commit.is_empty() && value("dirty").is_some_and(|rest| rest.starts_with("true"));
    commit + if has_changes { "+changes" } else { "" }
}

/// Writes the tables of shaders: the modules that others import, each after those that it imports, and the passes.
fn tables(files: &[PathBuf], sources: &[String]) -> io::Result<String> {
    let (shared, passes): (Vec<_>, Vec<_>) =
        files.iter().zip(sources).partition(|(file, _)| file.starts_with("shaders/shared"));
    let path_of =
        |source: &str| Some(source.split_once("#define_import_path ")?.1.split_whitespace().next()?.to_owned());
    let (mut waiting, mut modules, mut known) = (shared, Vec::new(), BTreeSet::new());
    while !waiting.is_empty() {
        let (ready, rest): (Vec<_>, Vec<_>) =
            waiting.iter().partition(|(_, source)| imports(source).all(|path| known.contains(&path)));
        if ready.is_empty() {
            let names: Vec<_> = rest.iter().map(|(file, _)| file.display().to_string()).collect();
            return Err(io::Error::other(format!(
                "these shaders import each other, or a module that does not exist: {}",
                names.join(", ")
            )));
        }
        known.extend(ready.iter().filter_map(|(_, source)| path_of(source)));
        modules.extend(ready.iter().map(|(file, _)| *file));
        waiting = rest;
    }
    let passes = passes.into_iter().map(|(file, _)| file);
    let mut out = String::new();
    let tables: [(&str, &str, Vec<&PathBuf>); 2] = [
        (
            "pub(crate) const MODULES",
            "The modules that shaders import. Each is listed after the modules that it imports itself.",
            modules,
        ),
        ("pub(crate) const SHADERS", "The shaders that become pipelines, one for each pass.", passes.collect()),
    ];
    for (table, help, files) in tables {
        writeln!(out, "/// {help}\n{table}: &[(&str, &str)] = &[").map_err(io::Error::other)?;
        for file in files {
            let path = file.to_string_lossy().replace('\\', "/");
            let name = path.trim_start_matches("shaders/").trim_end_matches(".wgsl");
            writeln!(
                out,
                "    ({name:?}, include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), {:?}))),",
                format!("/{path}")
            )
            .map_err(io::Error::other)?;
        }
        out += "];\n";
    }
    Ok(out)
}

/// Returns the import paths of the modules that a shader imports.
fn imports(source: &str) -> impl Iterator<Item = String> {
    let module = |line: &str| {
        let path = line.strip_prefix("#import ")?.trim();
        // The path may be `hachure::view::View` or `hachure::view::{View, place_at}`; the module is `hachure::view`.
        Some(path.split("::").take(2).collect::<Vec<_>>().join("::"))
    };
    source.lines().filter_map(module).collect::<Vec<_>>().into_iter()
}

/// Appends all `.wgsl` files in a folder and its subfolders.
fn list(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            list(&path, files)?;
        } else if path.extension().is_some_and(|ending| ending == "wgsl") {
            files.push(path);
        }
    }
    Ok(())
}

/// Returns the names of the structs that buffers contain, directly or in another struct.
fn bound(sources: &[String]) -> BTreeSet<String> {
    let names = |text: &str| -> Vec<String> {
        let words = text.split(|c: char| !c.is_alphanumeric());
        words.filter(|word| word.starts_with(|c: char| c.is_ascii_uppercase())).map(str::to_owned).collect()
    };
    let lines = || sources.iter().flat_map(|source| source.lines());
    let is_buffer = |line: &&str| line.contains(" var<uniform> ") || line.contains(" var<storage");
    let mut bound: BTreeSet<_> = lines().filter(is_buffer).flat_map(names).collect();
    let mut outer = None;
    for line in lines() {
        outer = line.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")).or(outer);
        if line == "}" {
            outer = None;
        }
        if let (Some(outer), Some((_, kind))) =
            (outer, line.strip_prefix("    ").and_then(|field| field.split_once(": ")))
            && bound.contains(outer)
        {
            bound.extend(names(kind));
        }
    }
    bound
}

fn write_room(room: &Room, out: &mut String) {
    *out += &room.text;
    for (name, inner) in &room.rooms {
        *out += &format!("pub(crate) mod {name} {{\n");
        if inner.text.is_empty() {
            *out += &format!("//! Shaders in `{name}/`.\n");
        }
        write_room(inner, out);
        *out += "}\n";
    }
}

/// Translates a shader to Rust, and returns the names of the structs in it.
fn shader(source: &str, bound: &BTreeSet<String>) -> (String, Vec<String>) {
    let mut known = BTreeMap::new();
    let (mut out, mut names) = (String::new(), Vec::new());
    let mut lines = source.lines();
    let mut help = Vec::new();
    while let Some(line) = lines.next() {
        if let Some(comment) = line.strip_prefix("//") {
            help.push(comment.trim().to_owned());
            continue;
        }
        let help = std::mem::take(&mut help);
        if let Some(constant) = line.strip_prefix("const ").and_then(constant) {
            out += &format!("{}{constant}\n", docs(&help, ""));
        } else if let Some(name) = line.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")) {
            let body: Vec<_> = lines.by_ref().take_while(|line| *line != "}").collect();
            let shared = structure(name, &help, &body, &known).filter(|_| bound.contains(name));
            if let Some((text, shared)) = shared {
                out += &text;
                known.insert(name.to_owned(), shared);
                names.push(name.to_owned());
            }
        }
    }
    (out, names)
}

fn docs(help: &[String], indent: &str) -> String {
    // An attribute, because brackets in it are not links.
    help.iter().map(|line| format!("{indent}#[doc = {line:?}]\n")).collect()
}

/// Translates a constant such as `NAME: u32 = 5u;` if its value is a numeric literal.
fn constant(text: &str) -> Option<String> {
    let (name, rest) = text.split_once(": ")?;
    let (kind, value) = rest.split_once(" = ")?;
    let value = value.split(';').next()?;
    let digits = value.trim_end_matches(['u', 'i']);
    let digits = if kind == "f32" { digits.trim_end_matches('f') } else { digits };
    let is_number = match kind {
        "u32" | "i32" => {
            let parsed = digits.strip_prefix("0x").map(|hex| u32::from_str_radix(hex, 16).map(i64::from));
            parsed.unwrap_or_else(|| digits.parse()).is_ok()
        }
        "f32" => digits.parse::<f32>().is_ok(),
        _ => false,
    };
    is_number.then(|| format!("pub(crate) const {name}: {kind} = {digits};"))
}

/// Translates a struct, with padding where Rust needs it. Returns `None` if it has a field of an unsupported type.
fn structure(name: &str, help: &[String], body: &[&str], known: &BTreeMap<String, Shared>) -> Option<(String, Shared)> {
    let (mut fields, mut names) = (String::new(), String::new());
    let (mut offset, mut align, mut is_whole, mut pads) = (0, 4, true, 0);
    let mut field_help = Vec::new();
    for line in body.iter().map(|line| line.trim()) {
        if let Some(comment) = line.strip_prefix("//") {
            field_help.push(comment.trim().to_owned());
            continue;
        }
        let (field, kind) = line.trim_end_matches(',').split_once(": ")?;
        let shared = shared(kind, known)?;
        let at = offset_of(offset, shared.align);
        pad(&mut fields, &mut pads, at - offset);
        fields += &format!("{}    pub {field}: {},\n", docs(&std::mem::take(&mut field_help), "    "), shared.rust);
        names += &format!("(\"{field}\", std::mem::offset_of!(Self, {field})), ");
        offset = at + shared.size;
        align = align.max(shared.align);
        is_whole &= shared.is_whole;
    }
    let size = offset_of(offset, align);
    pad(&mut fields, &mut pads, size - offset);
    let derives = if is_whole { ", Eq, Hash" } else { "" };
    let text = format!(
        "{}#[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq{derives}, bytemuck::Pod, bytemuck::Zeroable)]\npub struct {name} {{\n{fields}}}\n\
         impl {name} {{\n    #[cfg(test)]\n    pub(crate) const FIELDS: &'static [(&'static str, usize)] = &[{names}];\n}}\n\
         impl Default for {name} {{\n    fn default() -> Self {{\n        bytemuck::Zeroable::zeroed()\n    }}\n}}\n",
        docs(help, "")
    );
    Some((text, Shared::new(name, align, size, is_whole)))
}

fn offset_of(offset: usize, align: usize) -> usize {
    offset.next_multiple_of(align)
}

/// Adds a padding field of `bytes` bytes, if any.
fn pad(fields: &mut String, pads: &mut u32, bytes: usize) {
    if bytes > 0 {
        *fields += &format!("    #[doc = \"Padding.\"]\n    pub pad_{pads}: [u32; {}],\n", bytes / 4);
        *pads += 1;
    }
}

/// Returns the Rust type for a type of WGSL, or `None` if it is not supported.
fn shared(kind: &str, known: &BTreeMap<String, Shared>) -> Option<Shared> {
    let scalar = |name: &str| matches!(name, "u32" | "i32" | "f32").then(|| name.to_owned());
    if let Some(name) = scalar(kind) {
        return Some(Shared::new(&*name, 4, 4, name != "f32"));
    }
    if let Some(known) = known.get(kind) {
        return Some(known.clone());
    }
    let (outer, inner) = kind.strip_suffix('>')?.split_once('<')?;
    match outer {
        "vec2" | "vec3" | "vec4" => {
            let (name, count) = (scalar(inner)?, outer[3..].parse::<usize>().ok()?);
            let align = if count == 2 { 8 } else { 16 };
            Some(Shared::new(format!("[{name}; {count}]"), align, 4 * count, name != "f32"))
        }
        "mat4x4" => Some(Shared::new("[[f32; 4]; 4]", 16, 64, false)),
        "array" => {
            let (element, count) = inner.rsplit_once(", ")?;
            let (element, count) = (shared(element, known)?, count.trim_end_matches('u').parse::<usize>().ok()?);
            // Rust has no gaps between elements.
            let is_dense = element.size.is_multiple_of(element.align);
            let rust = format!("[{}; {count}]", element.rust);
            is_dense.then(|| Shared::new(rust, element.align, element.size * count, element.is_whole))
        }
        _ => None,
    }
}
