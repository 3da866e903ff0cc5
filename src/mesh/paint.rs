//! The materials that a model uses, from the libraries that it names.
//!
//! A material is a plain colour: the mean of its texture if that is a readable PNG, otherwise its `Kd`. Missing or
//! damaged files cause a warning of one line and the plain colour; the triangles are drawn all the same.

use std::path::Path;

use rustc_hash::{FxHashMap, FxHashSet};

use super::Material;
use super::mtl::{self, Entry, linear_from_srgb};
use super::obj_text::MaterialStatements;
use super::sidecar::Sidecars;
use crate::file::guard::{Identity, identity};
use crate::file::input::read_bytes;
use crate::file::message::{named, quoted};
use crate::file::one_line;
use crate::file::png::{Picture, decoded_bytes, read_rgba8};

/// Largest size of a library, in bytes.
const LARGEST_LIBRARY_BYTES: u64 = 16 << 20;

/// Bytes of decoded textures of a model that are read whatever the size of their files: one of the largest.
const FREE_TEXTURE_BYTES: u64 = 1 << 29;
/// Decoded bytes that are read for each byte of a file: photographs have 2 to 10.
const USUAL_RATIO: u64 = 64;

/// The materials of triangles.
#[derive(Clone, Debug)]
pub(crate) struct Paint {
    /// The materials, as in [`super::Mesh::materials`].
    pub materials: Vec<Material>,
    /// The material index of each triangle; 0 where the list is too short.
    pub of_triangles: Vec<u16>,
}

impl Default for Paint {
    fn default() -> Self {
        Self { materials: vec![Material::plain(String::new())], of_triangles: Vec::new() }
    }
}

/// The location of a model's files, and the receiver of warnings.
pub(super) struct Place<'a> {
    /// The path of the model.
    pub path: &'a Path,
    pub warn: &'a mut dyn FnMut(String),
}

impl Paint {
    /// Finds the materials of a text, for a model of `triangles` triangles. Without a place all colours are plain.
    pub(super) fn of(statements: &MaterialStatements, triangles: usize, mut place: Option<Place<'_>>) -> Self {
        let mut paint = Self::default();
        let mut warn = |cause: String| {
            if let Some(place) = &mut place {
                (place.warn)(format!("{}: {cause}", named(place.path)));
            }
        };
        let counted: u64 = statements.runs.iter().map(|(_, triangles)| triangles).sum();
        if counted != triangles as u64 {
            if !statements.names.is_empty() {
                warn("its materials are ignored, because they could not be assigned to its faces".to_owned());
            }
            return paint;
        }
        // Indexed by the number of the name, in the order of use by triangles.
        let mut numbers: Vec<Option<u16>> = vec![None; statements.names.len()];
        let mut used: Vec<u32> = Vec::new();
        let mut too_many = 0;
        for name in statements.runs.iter().filter(|(_, triangles)| *triangles > 0).filter_map(|(name, _)| *name) {
            if numbers[name as usize].is_some() {
                continue;
            }
            let next = u16::try_from(1 + used.len()).ok();
            too_many += u32::from(next.is_none());
            numbers[name as usize] = Some(next.unwrap_or(0));
            used.extend(next.map(|_| name));
        }
        if too_many > 0 {
            warn(format!("it has more than {} materials; {too_many} are ignored", u16::MAX));
        }
        let names: Vec<&[u8]> = used.iter().map(|&name| statements.names[name as usize].as_slice()).collect();
        paint.materials.extend(names.iter().map(|name| Material::plain(String::from_utf8_lossy(name).into_owned())));
        if let Some(place) = &mut place {
            let colors = colors(&statements.libraries, &names, place);
            for (material, color) in paint.materials[1..].iter_mut().zip(colors) {
                material.color = color.unwrap_or(Material::PLAIN_COLOR);
            }
        }
        paint.of_triangles.reserve_exact(triangles);
        for (name, triangles) in &statements.runs {
            let number = name.and_then(|name| numbers[name as usize]).unwrap_or(0);
            paint.of_triangles.extend(std::iter::repeat_n(number, *triangles as usize));
        }
        if paint.materials.len() == 1 {
            paint.of_triangles = Vec::new();
        }
        paint
    }
}

/// Returns the colours of materials by their names.
fn colors(libraries: &[Vec<u8>], names: &[&[u8]], place: &mut Place<'_>) -> Vec<Option<[f32; 3]>> {
    let mut sidecars = Sidecars::of(place.path);
    let mut known: FxHashMap<Vec<u8>, Entry> = FxHashMap::default();
    for file in library_files(libraries, &mut sidecars, place) {
        match read_bytes(&file, LARGEST_LIBRARY_BYTES) {
            Ok(text) => {
                let library = mtl::parse(&text);
                if let Some((line, cause)) = library.wrong {
                    (place.warn)(format!("{}: line {line} is ignored: {cause}", named(&file)));
                }
                for entry in library.entries {
                    known.entry(entry.name.clone()).or_insert(entry);
                }
            }
            Err(error) => (place.warn)(format!("cannot read the material library {}: {error}", named(&file))),
        }
    }
    let mut textures =
        Textures { sidecars, by_name: FxHashMap::default(), by_file: FxHashMap::default(), room: FREE_TEXTURE_BYTES };
    let (mut unknown, mut clear): (Vec<&[u8]>, Vec<&[u8]>) = (Vec::new(), Vec::new());
    let colors = names.iter().map(|&name| {
        let Some(entry) = known.get(name) else {
            // `usemtl` without a name means no material.
            unknown.extend((!name.is_empty()).then_some(name));
            return None;
        };
        clear.extend(entry.opacity.is_some_and(|opacity| opacity < 1.0).then_some(name));
        let texture = entry.texture.as_deref();
        let texture = texture.and_then(|name| textures.color(name, place));
        texture.or(entry.diffuse)
    });
    let colors = colors.collect();
    for (names, cause) in [
        (unknown, "these materials are not in its libraries and are drawn plain"),
        (clear, "these materials are transparent, but drawn opaque"),
    ] {
        if !names.is_empty() {
            (place.warn)(format!("{}: {cause}: {}", named(place.path), list(&names)));
        }
    }
    colors
}

/// Returns a list of the first names, short enough for a line.
fn list(names: &[&[u8]]) -> String {
    let shown: Vec<String> = names.iter().take(3).map(|name| quoted(&String::from_utf8_lossy(name))).collect();
    let more = if names.len() > 3 { format!(" and {} more", names.len() - 3) } else { String::new() };
    shown.join(", ") + &more
}

/// Returns the existing libraries. A line may name several, and a name may contain spaces: so the line is one name if
/// there is such a file, and otherwise names end at `.mtl`.
fn library_files(libraries: &[Vec<u8>], sidecars: &mut Sidecars, place: &mut Place<'_>) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    for line in libraries {
        if let Some(file) = sidecars.find(line) {
            files.push(file);
            continue;
        }
        for name in names_of(line) {
            match sidecars.find(name) {
                Some(file) => files.push(file),
                None => {
                    let name = quoted(&String::from_utf8_lossy(name));
                    (place.warn)(format!("{}: its material library {name} is not in its folder", named(place.path)));
                }
            }
        }
    }
    // Libraries that are named twice are read, and warned about, only once.
    let mut once = FxHashSet::default();
    files.retain(|file| identity(file).is_none_or(|identity| once.insert(identity)));
    files
}

fn names_of(line: &[u8]) -> Vec<&[u8]> {
    let (mut names, mut from) = (Vec::new(), 0);
    for end in 0..=line.len() {
        let is_end = end == line.len() || line[end].is_ascii_whitespace();
        if is_end && (end == line.len() || line[..end].to_ascii_lowercase().ends_with(b".mtl")) {
            let name = line[from..end].trim_ascii();
            names.extend((!name.is_empty()).then_some(name));
            from = end;
        }
    }
    names
}

/// The textures of a model, each read once, however often and by whatever names its materials call it.
struct Textures<'a> {
    sidecars: Sidecars,
    by_name: FxHashMap<&'a [u8], Option<[f32; 3]>>,
    by_file: FxHashMap<Identity, Option<[f32; 3]>>,
    /// Decoded bytes that may still be read.
    room: u64,
}

impl<'a> Textures<'a> {
    /// Returns the mean colour of a texture, weighted by coverage, or `None` if it is missing, damaged, or not a PNG.
    fn color(&mut self, name: &'a [u8], place: &mut Place<'_>) -> Option<[f32; 3]> {
        if let Some(color) = self.by_name.get(name) {
            return *color;
        }
        let color = match self.sidecars.find(name) {
            Some(file) => self.color_of(&file, place),
            None => {
                let name = quoted(&String::from_utf8_lossy(name));
                (place.warn)(format!("{}: its texture {name} is not in its folder", named(place.path)));
                None
            }
        };
        *self.by_name.entry(name).or_insert(color)
    }

    fn color_of(&mut self, file: &Path, place: &mut Place<'_>) -> Option<[f32; 3]> {
        if !file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
            return None;
        }
        let own = identity(file)?;
        if let Some(color) = self.by_file.get(&own) {
            return *color;
        }
        let color = match self.read(file) {
            Ok(picture) => mean_color(&picture),
            Err(cause) => {
                let cause = one_line(&cause);
                (place.warn)(format!("{}: cannot read its texture: {cause}", named(place.path)));
                None
            }
        };
        *self.by_file.entry(own).or_insert(color)
    }

    /// Reads a texture, if there is room for its pixels.
    fn read(&mut self, file: &Path) -> Result<Picture, String> {
        let [decoded, stored] = decoded_bytes(file).map_err(|error| error.to_string())?;
        let room = self.room.saturating_add(stored.saturating_mul(USUAL_RATIO));
        self.room = room.checked_sub(decoded).ok_or_else(|| {
            format!("{}: the model's textures have too many pixels for the size of their files", named(file))
        })?;
        read_rgba8(file).map_err(|error| error.to_string())
    }
}

/// Returns the mean of linear light of a texture.
fn mean_color(picture: &Picture) -> Option<[f32; 3]> {
    let linear: Vec<f64> = (0..256).map(|value| linear_from_srgb(f64::from(value) / 255.0)).collect();
    let (mut sum, mut weight) = ([0.0; 3], 0.0);
    for pixel in picture.rgba.chunks_exact(4) {
        let alpha = f64::from(pixel[3]);
        weight += alpha;
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += alpha * linear[usize::from(*value)];
        }
    }
    (weight > 0.0).then(|| sum.map(|sum| (sum / weight) as f32))
}

/// Returns the existing files that a model's beginning names, which a command reads besides the model.
pub(crate) fn files_of(path: &Path, beginning: &[u8]) -> Vec<std::path::PathBuf> {
    let mut lines = super::obj_text::LineReader::new(beginning);
    while let Ok(Some(_)) = lines.read_line(&mut Vec::new()) {}
    let mut place = Place { path, warn: &mut |_| () };
    let mut sidecars = Sidecars::of(path);
    let mut files = library_files(&lines.into_material_statements().libraries, &mut sidecars, &mut place);
    for library in files.clone() {
        let text = read_bytes(&library, LARGEST_LIBRARY_BYTES).unwrap_or_default();
        let mut names: Vec<Vec<u8>> = mtl::parse(&text).entries.into_iter().filter_map(|entry| entry.texture).collect();
        names.sort_unstable();
        names.dedup();
        files.extend(names.iter().filter_map(|name| sidecars.find(name)));
    }
    files
}
