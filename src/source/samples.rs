//! Conversion of a file's samples to metres: which samples are no-data, and what the others mean.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::file::message::quoted;

/// The stored type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

/// Largest possible height in metres: the highest relief in the solar system is under 30 km. A larger value is a
/// no-data value that the file does not declare (-3.4e38, 1e20, -2147483648 …).
pub(crate) const MAX_HEIGHT_M: f64 = 1e6;

/// The meaning of the samples of one band.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Meaning {
    pub sample_type: SampleType,
    /// The value that the file declares as no-data, in raw sample units.
    pub no_data: Option<f64>,
    pub scale: f64,
    /// Added after the scale, in the file's unit.
    pub offset: f64,
    pub metres_per_unit: f64,
    /// Whether the file declares the unit; otherwise it is taken to be metres.
    pub has_unit: bool,
}

/// Counts of what was found while reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tally {
    /// Samples that are heights.
    pub heights: u64,
    /// Samples beyond ±[`MAX_HEIGHT_M`], which are treated as no-data.
    pub absurd: u64,
    /// Undeclared samples of -32767 and -32768, which are treated as no-data.
    pub implied_voids: u64,
}

const ABSURD: &str = "samples beyond ±1000 km are treated as no-data";
const IMPLIED_VOIDS: &str = "samples of -32767 or -32768 are treated as no-data";

/// Warns once per file about samples that are treated as no-data without being declared. Windows are read by many
/// threads and in any order, so the warning appears at the first such sample and gives no count.
#[derive(Debug, Default)]
pub(super) struct WarnOnce {
    absurd: AtomicBool,
    implied_voids: AtomicBool,
}

impl WarnOnce {
    /// Warns about the findings in `tally`, unless the same warning was given before.
    pub(super) fn warn(&self, path: &Path, tally: &Tally) {
        let name = path.display();
        if tally.absurd > 0 && !self.absurd.swap(true, Ordering::Relaxed) {
            tracing::warn!("{name}: {ABSURD}");
        }
        if tally.implied_voids > 0 && !self.implied_voids.swap(true, Ordering::Relaxed) {
            tracing::warn!("{name}: {IMPLIED_VOIDS}");
        }
    }

    /// Returns the warnings that were given.
    pub(super) fn given(&self) -> Vec<String> {
        let all = [(&self.absurd, ABSURD), (&self.implied_voids, IMPLIED_VOIDS)];
        all.iter()
            .filter(|(is_given, _)| is_given.load(Ordering::Relaxed))
            .map(|(_, text)| (*text).to_owned())
            .collect()
    }
}

impl SampleType {
    /// Returns the type for a TIFF's SampleFormat (1 unsigned, 2 signed, 3 floating point) and the bytes of a decoded
    /// sample.
    pub(super) fn from_format(format: u16, bytes: usize) -> Option<Self> {
        Some(match (format, bytes) {
            (1, 1) => Self::U8,
            (2, 1) => Self::I8,
            (1, 2) => Self::U16,
            (2, 2) => Self::I16,
            (1, 4) => Self::U32,
            (2, 4) => Self::I32,
            (1, 8) => Self::U64,
            (2, 8) => Self::I64,
            (3, 4) => Self::F32,
            (3, 8) => Self::F64,
            _ => return None,
        })
    }

    /// Returns the largest integer with this number of bits; 1 for floating-point types.
    pub(super) fn largest(self, bits: u16) -> f64 {
        match self {
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => 2f64.powi(bits.into()) - 1.0,
            Self::I8 | Self::I16 | Self::I32 | Self::I64 => 2f64.powi(i32::from(bits) - 1) - 1.0,
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// Returns the bytes of a decoded sample.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

impl Meaning {
    /// Returns the meaning of samples that are metres without scale or offset.
    pub(super) fn metres(sample_type: SampleType, no_data: Option<f64>) -> Self {
        Self { sample_type, no_data, scale: 1.0, offset: 0.0, metres_per_unit: 1.0, has_unit: false }
    }

    /// Returns metres per unit, if the file declares the unit.
    pub(super) fn declared_unit_m(&self) -> Option<f64> {
        self.has_unit.then_some(self.metres_per_unit)
    }

    /// Appends one height in metres, or NaN, for each sample in `bytes`, which have the machine's byte order.
    pub(super) fn append_heights_m(&self, bytes: &[u8], heights_m: &mut Vec<f32>, tally: &mut Tally) {
        match self.sample_type {
            SampleType::U8 => self.append(bytes, |[b]: [u8; 1]| f64::from(b), heights_m, tally),
            SampleType::I8 => self.append(bytes, |b| f64::from(i8::from_ne_bytes(b)), heights_m, tally),
            SampleType::U16 => self.append(bytes, |b| f64::from(u16::from_ne_bytes(b)), heights_m, tally),
            SampleType::I16 => self.append(bytes, |b| f64::from(i16::from_ne_bytes(b)), heights_m, tally),
            SampleType::U32 => self.append(bytes, |b| f64::from(u32::from_ne_bytes(b)), heights_m, tally),
            SampleType::I32 => self.append(bytes, |b| f64::from(i32::from_ne_bytes(b)), heights_m, tally),
            // Values that an f64 cannot represent exactly are beyond every height.
            SampleType::U64 => self.append(bytes, |b| u64::from_ne_bytes(b) as f64, heights_m, tally),
            SampleType::I64 => self.append(bytes, |b| i64::from_ne_bytes(b) as f64, heights_m, tally),
            SampleType::F32 => self.append(bytes, |b| f64::from(f32::from_ne_bytes(b)), heights_m, tally),
            SampleType::F64 => self.append(bytes, f64::from_ne_bytes, heights_m, tally),
        }
    }

    fn append<const N: usize>(
        &self,
        bytes: &[u8],
        value: impl Fn([u8; N]) -> f64,
        heights_m: &mut Vec<f32>,
        tally: &mut Tally,
    ) {
        let (samples, _rest) = bytes.as_chunks::<N>();
        heights_m.extend(samples.iter().map(|&sample| self.height_m(value(sample), tally)));
    }

    /// Converts one sample to a height in metres, or NaN.
    pub(super) fn height_m(&self, value: f64, tally: &mut Tally) -> f32 {
        if !value.is_finite() || self.is_no_data(value) {
            return f32::NAN;
        }
        // No-data values of 16-bit formats: -32768 is SRTM's and -32767 DTED's. They are no-data even if the tag was
        // lost, as neither the Earth nor a drawing of it goes 32 km down.
        if self.no_data.is_none() && self.sample_type == SampleType::I16 && value <= -32767.0 {
            tally.implied_voids += 1;
            return f32::NAN;
        }
        let height_m = (value * self.scale + self.offset) * self.metres_per_unit;
        if height_m.abs() <= MAX_HEIGHT_M {
            tally.heights += 1;
            height_m as f32
        } else {
            tally.absurd += 1;
            f32::NAN
        }
    }

    fn is_no_data(&self, value: f64) -> bool {
        let Some(no_data) = self.no_data else { return false };
        // The tag is decimal text and the sample binary: "-3.4e+38" must match the nearest f32. Beyond the range of f32
        // the conversion would give an infinity, which a finite sample never equals, so the value is clamped to the
        // largest f32.
        value == no_data
            // For integer samples GDAL compares with the truncated no-data value.
            || !matches!(self.sample_type, SampleType::F32 | SampleType::F64) && value == no_data.trunc()
            || self.sample_type == SampleType::F32 && {
                let nearest = (no_data as f32).clamp(f32::MIN, f32::MAX);
                (value - f64::from(nearest)).abs() <= 2.0 * f64::from(f32::EPSILON) * f64::from(nearest.abs())
            }
    }
}

/// Parses the text of a GDAL_NODATA tag; returns `None` if it is not a number. NaN and infinities are accepted: such
/// samples are no-data anyway.
pub(super) fn parse_no_data(text: &str) -> Option<f64> {
    let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_ascii_lowercase();
    match text.as_str() {
        // Spellings that old C libraries of Windows wrote.
        "-1.#inf" => Some(f64::NEG_INFINITY),
        "1.#inf" => Some(f64::INFINITY),
        "-1.#ind" | "1.#qnan" | "-1.#qnan" | "-nan" => Some(f64::NAN),
        text => text.parse().ok(),
    }
}

/// Scale, offset and unit of the first band, from GDAL's XML metadata (tag 42112).
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BandMetadata {
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    pub unit: Option<String>,
}

impl BandMetadata {
    /// Parses the text of the tag. Unknown items are ignored, because the tag may hold arbitrary metadata.
    pub(super) fn parse(xml: &str) -> Self {
        let mut found = Self::default();
        for item in xml.split("<Item ").skip(1) {
            let Some((attributes, rest)) = item.split_once('>') else { continue };
            let value = rest.split('<').next().unwrap_or("").trim();
            let attribute = |name: &str| {
                let start = attributes.find(&format!("{name}=\""))? + name.len() + 2;
                attributes.get(start..)?.split('"').next()
            };
            if !matches!(attribute("sample"), None | Some("0")) {
                continue;
            }
            let number = || value.parse::<f64>().ok().filter(|number| number.is_finite());
            match attribute("role") {
                Some("scale") => found.scale = number().filter(|&scale| scale != 0.0),
                Some("offset") => found.offset = number(),
                Some("unittype") => found.unit = Some(value.to_ascii_lowercase()),
                _ => {}
            }
        }
        found
    }

    /// Returns metres per unit for the units of length that GDAL writes; `None` without a unit and for other units.
    pub(super) fn metres_per_unit(&self) -> Option<f64> {
        match self.unit.as_deref()? {
            "m" | "metre" | "meter" | "metres" | "meters" => Some(1.0),
            "ft" | "foot" | "feet" | "international foot" => Some(0.3048),
            "us-ft" | "ftus" | "us survey foot" | "foot_us" | "us_survey_foot" => Some(1200.0 / 3937.0),
            "km" | "kilometre" | "kilometer" | "kilometres" | "kilometers" => Some(1000.0),
            "dm" | "decimetre" | "decimeter" | "decimetres" | "decimeters" => Some(0.1),
            "cm" | "centimetre" | "centimeter" | "centimetres" | "centimeters" => Some(0.01),
            "mm" | "millimetre" | "millimeter" | "millimetres" | "millimeters" => Some(0.001),
            _ => None,
        }
    }

    /// Warns if the unit is unknown, so that heights are taken as metres.
    pub(super) fn warn_of_unit(&self, path: &Path) {
        if let Some(unit) = self.unit.as_deref().filter(|unit| !unit.is_empty() && self.metres_per_unit().is_none()) {
            tracing::warn!("{}: unknown unit of heights {}; taken as metres", path.display(), quoted(unit));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_text_matches_the_nearest_single() {
        for text in ["-3.4e+38", "-3.39999999999999996e+38", "-3.4028234663852886e+38", "-3.4028235e+38", "-9999.9"] {
            let no_data = parse_no_data(text).unwrap();
            let meaning = Meaning::metres(SampleType::F32, Some(no_data));
            assert!(meaning.is_no_data(f64::from(no_data as f32)), "{text}");
            assert!(!meaning.is_no_data(-9999.0), "{text}");
        }
        assert!(Meaning::metres(SampleType::F32, Some(-1.797e308)).is_no_data(f64::from(f32::MIN)));
        assert_eq!(parse_no_data(" -1.#INF\0"), Some(f64::NEG_INFINITY));
        assert_eq!(parse_no_data("none"), None);
    }

    #[test]
    fn voids_and_absurd_numbers_are_not_heights() {
        let mut tally = Tally::default();
        let mut heights_m = Vec::new();
        let samples: Vec<u8> = [-32768i16, -32767, -32766, 8848].into_iter().flat_map(i16::to_ne_bytes).collect();
        Meaning::metres(SampleType::I16, None).append_heights_m(&samples, &mut heights_m, &mut tally);
        assert!(heights_m[0].is_nan() && heights_m[1].is_nan());
        assert_eq!(heights_m[2..], [-32766.0, 8848.0]);
        assert_eq!(tally, Tally { heights: 2, absurd: 0, implied_voids: 2 });

        let samples: Vec<u8> = [f64::NAN, f64::INFINITY, 1e7, 5.0].into_iter().flat_map(f64::to_ne_bytes).collect();
        heights_m.clear();
        Meaning::metres(SampleType::F64, None).append_heights_m(&samples, &mut heights_m, &mut tally);
        assert_eq!(heights_m.iter().filter(|height| height.is_nan()).count(), 3);
        assert_eq!(tally.absurd, 1);
    }

    #[test]
    fn band_metadata_is_found() {
        let xml = r#"<GDALMetadata><Item name="A">x</Item><Item name="SCALE" sample="0" role="scale">0.5</Item>
            <Item name="SCALE" sample="1" role="scale">7</Item><Item name="OFFSET" sample="0" role="offset">-3</Item>
            <Item name="UNITTYPE" sample="0" role="unittype">US survey foot</Item></GDALMetadata>"#;
        let found = BandMetadata::parse(xml);
        assert_eq!((found.scale, found.offset), (Some(0.5), Some(-3.0)));
        assert_eq!(found.metres_per_unit(), Some(1200.0 / 3937.0));
        let warnings = |unit: Option<&str>| {
            let band = BandMetadata { unit: unit.map(str::to_owned), ..BandMetadata::default() };
            crate::tests::common::log::with_warnings(|| band.warn_of_unit(Path::new("a.tif"))).1
        };
        assert!(warnings(Some("furlong")).contains("a.tif: unknown unit of heights \"furlong\"; taken as metres"));
        assert_eq!([None, Some(""), Some("m"), Some("ft")].map(warnings), [""; 4]);
        assert_eq!(BandMetadata::parse("<Item <Item>"), BandMetadata::default());
    }
}
