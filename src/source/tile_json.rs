//! TileJSON ("TileJSON 3.0.0", Mapbox): the scheme, the encoding and the place of tiles. The tiles must be local, in the
//! folder of the file or below.

use std::path::{Component, Path, PathBuf};

use serde_json::Value;

use super::place::{inconsistent, small_text, unclear};
use super::sidecar::{OpenOptions, RasterInfo};
use super::tile_folder::{self, TILE_ENDINGS};
use super::tile_set::TileSetReader;
use super::{Encoding, SourceError, TileRows};

/// The parts of a TileJSON file that heights need.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TileJson {
    /// The template of the tiles' names.
    pub tiles: Option<String>,
    pub rows: Option<TileRows>,
    pub encoding: Option<Encoding>,
    /// Metres per step of the colour code, and the height of code 0, of the encoding `custom`.
    pub interval_m: Option<f64>,
    pub base_m: Option<f64>,
}

impl TileJson {
    /// Reads a file; returns `None` if it is JSON, but does not describe tiles.
    ///
    /// # Errors
    /// Fails if the file cannot be read, or names an encoding that is not known.
    pub(super) fn read(path: &Path) -> Result<Option<Self>, SourceError> {
        let text = small_text(path)?;
        Self::parse(&text).map_err(|why| unclear(path, why))
    }

    /// Parses the text of a file, or the metadata of an archive.
    pub(super) fn parse(text: &str) -> Result<Option<Self>, String> {
        let Ok(json) = serde_json::from_str::<Value>(text.trim_start_matches('\u{feff}')) else { return Ok(None) };
        let text = |key: &str| json.get(key).and_then(Value::as_str);
        // Some programs write numbers as strings, which may also be "nan".
        let number = |key: &str| {
            let number = match json.get(key) {
                Some(Value::String(text)) => text.trim().parse::<f64>().ok(),
                value => value.and_then(Value::as_f64),
            };
            number.filter(|number| number.is_finite())
        };
        let tiles = json.get("tiles").and_then(|tiles| tiles.get(0)).and_then(Value::as_str).map(str::to_owned);
        let rows = match text("scheme") {
            Some("tms") => Some(TileRows::Tms),
            Some("xyz") => Some(TileRows::Xyz),
            _ => None,
        };
        let mut found = Self { tiles, rows, ..Self::default() };
        match text("encoding").map(str::to_ascii_lowercase).as_deref() {
            Some("mapbox" | "terrain-rgb" | "terrainrgb") => found.encoding = Some(Encoding::Mapbox),
            Some("terrarium") => found.encoding = Some(Encoding::Terrarium),
            Some("gsi") => found.encoding = Some(Encoding::Gsi),
            Some("custom") => {
                // MapLibre: red × redFactor + green × greenFactor + blue × blueFactor − baseShift.
                let factors = ["redFactor", "greenFactor", "blueFactor"].map(number);
                let [Some(red), Some(green), Some(blue)] = factors else {
                    return Err(
                        "its encoding is custom, but redFactor, greenFactor and blueFactor are not all numbers"
                            .to_owned(),
                    );
                };
                let shift = match json.get("baseShift") {
                    None | Some(Value::Null) => 0.0,
                    Some(_) => number("baseShift").ok_or("its baseShift is not a number")?,
                };
                let is_code = (red / blue - 65_536.0).abs() < 1.0 && (green / blue - 256.0).abs() < 0.01;
                if !is_code || blue == 0.0 {
                    let why =
                        "unsupported custom encoding: redFactor : greenFactor : blueFactor must be 65536 : 256 : 1";
                    return Err(format!("{why}, not {red} : {green} : {blue}"));
                }
                found.encoding = Some(Encoding::Mapbox);
                found.interval_m = Some(blue);
                found.base_m = Some(-shift);
            }
            Some(other) if found.tiles.is_some() => return Err(format!("its encoding {other:?} is not known")),
            _ => {}
        }
        let is_empty = found == Self::default();
        Ok((!is_empty).then_some(found))
    }
}

/// Returns whether a file is TileJSON that names tiles.
pub(super) fn is_tile_json(path: &Path) -> bool {
    matches!(TileJson::read(path), Ok(Some(TileJson { tiles: Some(_), .. })) | Err(SourceError::Unclear { .. }))
}

/// Returns the folder of the tiles that a TileJSON file names, for the list of inputs.
pub(super) fn folder_of(path: &Path) -> Option<PathBuf> {
    let described = TileJson::read(path).ok()??;
    template(path, described.tiles.as_deref()?).ok().map(|(folder, ..)| folder)
}

/// Opens the tiles that a TileJSON file names.
pub(super) fn open(path: &Path, options: &OpenOptions) -> Result<TileSetReader, SourceError> {
    let described = TileJson::read(path)?.unwrap_or_default();
    let Some(tiles) = &described.tiles else { return Err(unclear(path, "this TileJSON file names no tiles")) };
    let (folder, ending, is_reversed) = template(path, tiles)?;
    let mut info = RasterInfo::of(path, options)?;
    info.declare(&described);
    let rows = if is_reversed { Some(TileRows::Tms) } else { described.rows };
    if !folder.is_dir() {
        return Err(inconsistent(path, format!("the folder of its tiles, {}, does not exist", folder.display())));
    }
    tile_folder::open_described(path, &folder, &[ending], &info, rows)
}

/// Returns the folder, the extension and whether rows count from the south, of a template such as
/// `tiles/{z}/{x}/{y}.png`.
fn template(path: &Path, tiles: &str) -> Result<(PathBuf, &'static str, bool), SourceError> {
    if tiles.contains("://") {
        let why = "its tiles are on a server; hachure reads local tiles, so download them, or use PMTiles or a COG";
        return Err(unclear(path, why));
    }
    let shape = || unclear(path, "the names of its tiles must be like FOLDER/{z}/{x}/{y}.png or .webp");
    let (before, ending) = tiles.split_once("{z}/{x}/").ok_or_else(shape)?;
    let (is_reversed, ending) = match (ending.strip_prefix("{y}."), ending.strip_prefix("{-y}.")) {
        (Some(ending), _) => (false, ending),
        (_, Some(ending)) => (true, ending),
        _ => return Err(shape()),
    };
    let ending = TILE_ENDINGS.into_iter().find(|known| *known == ending).ok_or_else(shape)?;
    let before = Path::new(before);
    if before.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Err(unclear(path, "its tiles must be in its own folder or below"));
    }
    Ok((path.parent().unwrap_or(Path::new("")).join(before), ending, is_reversed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_say_rows_and_encoding() {
        let parse = |text: &str| TileJson::parse(text).unwrap();
        let found =
            parse(r#"{"tilejson":"3.0.0","scheme":"tms","encoding":"terrarium","tiles":["t/{z}/{x}/{y}.png"]}"#);
        let found = found.unwrap();
        assert_eq!((found.rows, found.encoding), (Some(TileRows::Tms), Some(Encoding::Terrarium)));
        let custom = r#"{"encoding":"custom","redFactor":6553.6,"greenFactor":25.6,"blueFactor":0.1,"baseShift":500}"#;
        let found = parse(custom).unwrap();
        assert_eq!((found.interval_m, found.base_m), (Some(0.1), Some(-500.0)));
        assert_eq!(parse("{\"a\": 1}"), None);
        assert_eq!(parse("no JSON"), None);
        let error = TileJson::parse(&custom.replace("25.6", "2.56")).unwrap_err();
        assert!(error.contains("must be 65536 : 256 : 1, not 6553.6 : 2.56 : 0.1"), "{error}");
        for (number, wrong) in [("500", "\"nan\""), ("500", "\"-inf\""), ("500", "[]"), ("0.1", "\"inf\"")] {
            let text = custom.replace(number, wrong);
            assert!(TileJson::parse(&text).unwrap_err().contains("number"), "{text}");
        }
        let shift = |text: &str| parse(&custom.replace("500", text)).unwrap().base_m;
        assert_eq!((shift("\"12.5\""), shift("null")), (Some(-12.5), Some(-0.0)));
        assert!(TileJson::parse(r#"{"encoding":"rot13","tiles":["{z}/{x}/{y}.png"]}"#).is_err());
    }

    #[test]
    fn tiles_are_local_and_below_the_file() {
        let path = Path::new("a/tiles.json");
        assert_eq!(template(path, "t/{z}/{x}/{y}.webp").unwrap(), (PathBuf::from("a/t/"), "webp", false));
        assert!(template(path, "./{z}/{x}/{-y}.png").unwrap().2);
        for wrong in
            ["https://a/{z}/{x}/{y}.png", "../{z}/{x}/{y}.png", "/t/{z}/{x}/{y}.png", "{z}/{y}/{x}.png", "t.png"]
        {
            assert!(template(path, wrong).is_err(), "{wrong}");
        }
    }
}
