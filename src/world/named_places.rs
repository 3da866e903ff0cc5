//! Named places of a file of features, in the world: summits, passes, huts, villages.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use glam::DVec2;

use crate::features::when::{When, WhenError};
use crate::features::{self, Attributes, Choice, Feature, FeatureError, Geometry, OnLand, OnLandError, Value};
use crate::file::message::{named, printable, quoted};
use crate::source::georeference::Georeference;

/// Largest number of places on the land that are read.
const MAX_PLACES: usize = 1 << 20;
/// Attributes that hold names, the first that a file has; in lower case.
const NAME_FIELDS: [&str; 6] = ["name", "title", "label", "text", "gnis_name", "feature_name"];
/// Attributes that hold heights in metres, in lower case.
const HEIGHT_FIELDS: [&str; 6] = ["ele", "elevation", "elevation_m", "height_m", "altitude", "hoehe"];
/// Largest number of attributes that an error lists.
const MAX_LISTED: usize = 20;

/// A place with a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedPlace {
    /// East and north of the centre of the world, in metres.
    pub world_m: DVec2,
    pub name: String,
    /// Height in metres, if the file states it.
    pub height_m: Option<f64>,
}

/// The named places of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct NamedPlaces {
    pub places: Vec<NamedPlace>,
    /// What was left out, each as a clause that follows the name of the file.
    pub doubts: Vec<String>,
}

/// Which names are read from a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct WantedNames<'a> {
    /// Layer of the file; `None` reads its only one.
    pub layer: Option<String>,
    /// Attribute that holds the names; `None` chooses one.
    pub field: Option<&'a str>,
    /// Condition that the attributes of a feature must meet.
    pub when: Option<&'a str>,
}

/// Why there are no names.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NamesError {
    #[error(transparent)]
    Feature(#[from] FeatureError),
    #[error(transparent)]
    OnLand(#[from] OnLandError),
    #[error(
        "{}: no attribute is called name, title, label or text; choose one with --name-field: {found}",
        named(path)
    )]
    NoNames { path: PathBuf, found: String },
    #[error("{}: has no attribute {}; {found}", named(path), quoted(field))]
    NoField { path: PathBuf, field: String, found: String },
    #[error("{}: {cause}, in the condition {}", named(path), quoted(condition))]
    When { path: PathBuf, condition: String, cause: WhenError },
    #[error("{}: more than {MAX_PLACES} named points are on the land; limit them with --name-when", named(path))]
    TooMany { path: PathBuf },
}

/// Reads the points of a file that are on the land and have a name. Coordinates without a reference system are in that of
/// the heights.
///
/// # Errors
/// The file cannot be read, its reference system is unknown, or no attribute holds names.
pub(crate) fn read(
    path: &Path,
    wanted: &WantedNames<'_>,
    place: &Georeference,
    samples: [u32; 2],
) -> Result<NamedPlaces, NamesError> {
    let (choice, owned) = (Choice { layer: wanted.layer.clone() }, || path.to_owned());
    let summary = features::survey(path, &choice)?;
    let mut keys: Vec<String> = summary.attributes.iter().map(|attribute| attribute.name.to_string()).collect();
    let when = wanted.when.map(|text| {
        let parsed = When::parse(text)
            .and_then(|when| when.check(&keys.iter().map(String::as_str).collect::<Vec<_>>()).map(|()| when));
        parsed.map_err(|cause| NamesError::When { path: owned(), condition: text.to_owned(), cause })
    });
    let when = when.transpose()?;
    let name_key = match wanted.field {
        Some(field) if keys.iter().any(|key| key == field) => field.to_owned(),
        Some(field) => {
            return Err(NamesError::NoField { path: owned(), field: field.to_owned(), found: listed(&mut keys) });
        }
        None => match first_of(&keys, &NAME_FIELDS) {
            Some(key) => key,
            None => return Err(NamesError::NoNames { path: owned(), found: listed(&mut keys) }),
        },
    };
    let height_key = first_of(&keys, &HEIGHT_FIELDS);
    let land = OnLand::new(path, summary.crs.as_ref(), place, samples)?;
    let mut found = Found::default();
    let on_land = |at: &[f64; 3]| {
        let grid = land.grid(at);
        land.holds(grid).then(|| land.world_m(grid))
    };
    let read = features::read(path, &choice, &mut |feature| {
        if when.as_ref().is_none_or(|when| when.is_met(&feature.attributes)) {
            found.add(&feature, &name_key, height_key.as_deref(), &on_land);
        } else {
            found.unmet += 1;
        }
        if found.places.len() > MAX_PLACES { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if found.places.len() > MAX_PLACES {
        return Err(NamesError::TooMany { path: owned() });
    }
    let mut doubts: Vec<String> = found.doubt(&name_key).into_iter().collect();
    doubts.extend(read.skipped.iter().map(|skipped| skipped.clause(read.record_noun)));
    Ok(NamedPlaces { places: found.places, doubts })
}

/// Returns the first attribute of a list of names that a file has, whatever its case.
fn first_of(keys: &[String], wanted: &[&str]) -> Option<String> {
    wanted.iter().find_map(|wanted| keys.iter().find(|key| key.to_lowercase() == **wanted)).cloned()
}

/// Returns the attributes of a file as a clause.
fn listed(keys: &mut Vec<String>) -> String {
    if keys.is_empty() {
        return "it has no attributes".to_owned();
    }
    let more = if keys.len() > MAX_LISTED { ", …" } else { "" };
    keys.truncate(MAX_LISTED);
    format!("its attributes are {}{more}", printable(&keys.join(", "), 400))
}

/// The places that were found so far, and how many features have none.
#[derive(Default)]
struct Found {
    places: Vec<NamedPlace>,
    without_name: u64,
    not_points: u64,
    outside: u64,
    unmet: u64,
}

impl Found {
    fn add(
        &mut self,
        feature: &Feature,
        name_key: &str,
        height_key: Option<&str>,
        on_land: &dyn Fn(&[f64; 3]) -> Option<DVec2>,
    ) {
        let Geometry::Points(points) = &feature.geometry else {
            self.not_points += 1;
            return;
        };
        let Some(name) = text_of(feature.attributes.get(name_key)) else {
            self.without_name += 1;
            return;
        };
        let stated_m = height_key.and_then(|key| number_of(&feature.attributes, key));
        for at in points {
            let Some(world_m) = on_land(at) else {
                self.outside += 1;
                continue;
            };
            // Many programs write 0 where there is no height.
            let height_m = stated_m.or(Some(at[2]).filter(|height_m| height_m.is_finite() && *height_m != 0.0));
            self.places.push(NamedPlace { world_m, name: name.clone(), height_m });
        }
    }

    /// Returns what was left out, as a clause; `None` if all points have labels.
    fn doubt(&self, name_key: &str) -> Option<String> {
        let Self { places, without_name, not_points, outside, unmet } = self;
        let why = [
            (*outside, "outside of the land"),
            (*without_name, "without a value of the attribute for names"),
            (*not_points, "lines or areas"),
            (*unmet, "that do not meet --name-when"),
        ];
        let why: Vec<String> =
            why.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
        let is_expected = *outside + *without_name == 0 && !places.is_empty();
        let found = if places.is_empty() { "no feature has a label" } else { "some features have no label" };
        let attribute = printable(name_key, 40);
        (!why.is_empty() && !is_expected).then(|| format!("{found} ({attribute}): {}", why.join(", ")))
    }
}

/// Returns the text of a value, without white space around it; `None` if there is none.
fn text_of(value: &Value) -> Option<String> {
    let text = value.key()?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// Returns the height of an attribute in metres. Text may have a unit: `4392 m`, `14411 ft`.
fn number_of(attributes: &Attributes, key: &str) -> Option<f64> {
    match attributes.get(key) {
        Value::Number(number) => Some(*number).filter(|number| number.is_finite()),
        Value::Text(text) => metres_of(text),
        Value::Bool(_) | Value::None => None,
    }
}

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;

/// Returns the metres that a text such as `4392 m` or `14411 ft` states; `None` for anything else.
fn metres_of(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|it: char| !(it.is_ascii_digit() || matches!(it, '.' | '-' | '+'))).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let number = number.parse::<f64>().ok().filter(|number| number.is_finite())?;
    match unit.trim().to_lowercase().as_str() {
        "" | "m" | "metres" | "meters" | "metre" | "meter" => Some(number),
        "ft" | "feet" | "foot" | "'" => Some(number * FOOT_M),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    /// A degree of latitude and longitude north of the equator, with 1001 × 1001 samples.
    fn land() -> Georeference {
        let step = 1e-3;
        Georeference {
            crs_from_grid: [7.0, step, 0.0, 1.0, 0.0, -step],
            ..Georeference::of_coordinates(Some(4326)).unwrap()
        }
    }

    fn file(ending: &str, text: &str) -> tempfile::TempPath {
        use std::io::Write as _;
        let mut file = tempfile::Builder::new().suffix(ending).tempfile().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        file.into_temp_path()
    }

    #[test]
    fn named_points_of_each_format_are_at_their_places() {
        let csv = file(".csv", "lon,lat,name,ele\n7.5,0.5,Middle,1200\n7.25,0.5,West,\n20,0.5,Outside,3\n7.3,0.6,,4\n");
        let gpx = file(
            ".gpx",
            "<gpx version=\"1.1\" xmlns=\"http://www.topografix.com/GPX/1/1\"><wpt lat=\"0.5\" lon=\"7.5\">\
             <ele>1200</ele><name>Middle</name></wpt><wpt lat=\"0.5\" lon=\"7.25\"><name>West</name></wpt></gpx>",
        );
        let places = |path: &Path| read(path, &WantedNames::default(), &land(), [1001, 1001]).unwrap().places;
        for path in [&csv, &gpx] {
            let found = places(path);
            assert_eq!(found.len(), 2, "{found:?}");
            assert_eq!((found[0].name.as_str(), found[0].height_m), ("Middle", Some(1200.0)));
            assert_eq!((found[1].name.as_str(), found[1].height_m), ("West", None));
            assert!(found[0].world_m.length() < 0.01, "{found:?}");
            // A quarter of a degree at the equator.
            let west_m = DVec2::new(-0.25_f64.to_radians() * 6_378_137.0, 0.0);
            assert!(found[1].world_m.distance(west_m) < 10.0, "{found:?}");
            // Planted: exchanged names.
            assert!(found[0].world_m.distance(west_m) > 1000.0);
        }
    }

    #[test]
    fn a_file_without_names_says_what_it_has() {
        let csv = file(".csv", "lon,lat,code,kind\n7.5,0.5,17,peak\n");
        let of = |field| WantedNames { field, ..WantedNames::default() };
        let error = |field| read(&csv, &of(field), &land(), [1001, 1001]).unwrap_err().to_string();
        assert!(
            error(None)
                .ends_with("no attribute is called name, title, label or text; choose one with --name-field: its attributes are code, kind")
        );
        assert!(error(Some("nome")).ends_with("has no attribute \"nome\"; its attributes are code, kind"));
        let found = read(&csv, &of(Some("kind")), &land(), [1001, 1001]).unwrap().places;
        assert_eq!(found[0].name, "peak");
        let with = |when| WantedNames { when: Some(when), ..of(Some("kind")) };
        let none = read(&csv, &with("code > 17"), &land(), [1001, 1001]).unwrap();
        assert_eq!((none.places, none.doubts.len()), (vec![], 1));
        assert_eq!(read(&csv, &with("code == 17"), &land(), [1001, 1001]).unwrap().places, found);
        let error_of = |when| read(&csv, &with(when), &land(), [1001, 1001]).unwrap_err().to_string();
        assert!(error_of("cod > 1").contains("column 1: there is no attribute"), "{}", error_of("cod > 1"));
        let local = Georeference::local(10, 10, 1.0);
        let error = read(&csv, &of(Some("kind")), &local, [10, 10]).unwrap_err().to_string();
        assert!(error.contains("the heights have no coordinate reference system"), "{error}");
    }

    #[test]
    fn heights_may_have_units() {
        assert_eq!(["4392", "4392 m", "-3.5m", "1e3"].map(metres_of), [Some(4392.0), Some(4392.0), Some(-3.5), None]);
        assert!((metres_of("14411 ft").unwrap() - 4392.47).abs() < 0.01);
        assert_eq!(["1 234 m", "4,392", "high", ""].map(metres_of), [None; 4]);
        let gpx = file(
            ".gpx",
            "<gpx version=\"1.1\" xmlns=\"http://www.topografix.com/GPX/1/1\"><wpt lat=\"0.5\" lon=\"7.5\">\
             <name>Middle</name></wpt></gpx>",
        );
        let csv = file(".csv", "lon,lat,z,name\n7.5,0.5,0,Middle\n");
        for path in [&gpx, &csv] {
            let found = read(path, &WantedNames::default(), &land(), [1001, 1001]).unwrap();
            assert_eq!((found.places[0].height_m, found.doubts.len()), (None, 0), "{found:?}");
        }
    }
}
