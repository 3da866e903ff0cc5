//! Finds the columns of coordinates in the header of a CSV file.

use super::error::{Cause, list};

/// Names of the columns of x and y, in lower case. Spaces and underscores in a header do not matter.
const PAIRS: [[&str; 2]; 17] = [
    ["lon", "lat"],
    ["long", "lat"],
    ["lng", "lat"],
    ["longitude", "latitude"],
    ["decimallongitude", "decimallatitude"],
    ["x", "y"],
    ["easting", "northing"],
    ["east", "north"],
    ["e", "n"],
    ["xcoord", "ycoord"],
    ["coordx", "coordy"],
    ["xcoordinate", "ycoordinate"],
    ["pointx", "pointy"],
    ["coordslon", "coordslat"],
    ["ostwert", "nordwert"],
    ["rechtswert", "hochwert"],
    ["xutm", "yutm"],
];
/// Number of pairs at the beginning of [`PAIRS`] that are degrees.
const DEGREES: usize = 5;
/// Names of a column of Well-Known Text.
const TEXTS: [&str; 7] = ["wkt", "geometry", "geom", "thegeom", "wktgeom", "geometrywkt", "shape"];
/// Names of the column of heights. Its values are also an attribute, except under the name `z`.
const HEIGHTS: [&str; 5] = ["z", "ele", "elevation", "altitude", "alt"];
/// The separators, in the order in which they are tried.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// Where a row has its geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Columns {
        x: usize,
        y: usize,
        z: Option<usize>,
        are_degrees: bool,
    },
    /// A column of Well-Known Text.
    Text(usize),
}

/// The header of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) separator: u8,
    pub(super) names: Vec<String>,
    pub(super) place: Place,
}

impl Header {
    /// Finds the separator and the columns in the beginning of a file.
    pub(super) fn find(head: &[u8]) -> Result<Self, Cause> {
        let mut widest: Vec<String> = Vec::new();
        for separator in SEPARATORS {
            let names = names(head, separator)?;
            if let Some(place) = place(&names) {
                return Ok(Self { separator, names, place });
            }
            if names.len() > widest.len() {
                widest = names;
            }
        }
        let pairs: Vec<String> = PAIRS.iter().map(|[x, y]| format!("{x}/{y}")).collect();
        Err(Cause::content(format!(
            "has no columns of coordinates; its columns are {}; tried {} and WKT in {}",
            list(&widest),
            pairs.join(", "),
            TEXTS.join(", ")
        )))
    }

    /// Returns whether the column is only part of the geometry, not an attribute.
    pub(super) fn is_geometry(&self, column: usize) -> bool {
        match self.place {
            Place::Text(text) => column == text,
            Place::Columns { x, y, z, .. } => {
                let is_z = z == Some(column) && self.names.get(column).is_some_and(|name| normal(name) == "z");
                column == x || column == y || is_z
            }
        }
    }
}

fn names(head: &[u8], separator: u8) -> Result<Vec<String>, Cause> {
    // A carriage return without a line feed ends the line, too.
    let end = if head.contains(&b'\n') { None } else { head.iter().position(|byte| *byte == b'\r') };
    let head = end.and_then(|end| head.get(..end)).unwrap_or(head);
    let mut reader = super::delimited::reader(separator, head);
    let mut record = csv::ByteRecord::new();
    // Reading from memory does not fail.
    let _ = reader.read_byte_record(&mut record);
    let name = |field: &[u8]| match std::str::from_utf8(field) {
        Ok(name) => Ok(name.trim().to_owned()),
        Err(_) => Err(Cause::content("is not UTF-8 text (line 1); convert it with iconv -f LATIN1 -t UTF-8")),
    };
    record.iter().map(name).collect()
}

/// Returns a name in lower case, without spaces and signs.
fn normal(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn place(names: &[String]) -> Option<Place> {
    let names: Vec<String> = names.iter().map(|name| normal(name)).collect();
    let column = |name: &str| names.iter().position(|own| own == name);
    if let Some(text) = TEXTS.iter().find_map(|name| column(name)) {
        return Some(Place::Text(text));
    }
    let pairs = PAIRS.iter().enumerate();
    let (index, x, y) = pairs.into_iter().find_map(|(index, [x, y])| Some((index, column(x)?, column(y)?)))?;
    let z = HEIGHTS.iter().find_map(|name| column(name));
    Some(Place::Columns { x, y, z, are_degrees: index < DEGREES })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_in_any_case_and_order() {
        for (header, separator, expected) in [
            ("name,LAT,Lon\n", b',', Place::Columns { x: 2, y: 1, z: None, are_degrees: true }),
            ("Easting;Northing;Z\r\n1,5;2;3", b';', Place::Columns { x: 0, y: 1, z: Some(2), are_degrees: false }),
            ("X_Coord\tY Coord\tele", b'\t', Place::Columns { x: 0, y: 1, z: Some(2), are_degrees: false }),
            ("id,\"WKT\",x,y\n", b',', Place::Text(1)),
            ("\"a;b\",x,y", b',', Place::Columns { x: 1, y: 2, z: None, are_degrees: false }),
        ] {
            let found = Header::find(header.as_bytes()).unwrap();
            assert_eq!((found.separator, found.place), (separator, expected), "{header}");
        }
        let Err(Cause::Content(cause)) = Header::find(b"name;breite;laenge\n") else { panic!("found columns") };
        assert!(cause.contains("its columns are name, breite, laenge; tried lon/lat,"), "{cause}");
        assert!(matches!(Header::find(b"name,h\xf6he,x,y\n"), Err(Cause::Content(cause)) if cause.contains("UTF-8")));
    }
}
