//! Reads GPX 1.0 and 1.1: waypoints are points, routes and tracks are lines. Each segment of a track is a line of its own
//! in one feature.
//!
//! The file is read as a stream of XML events, one feature in memory at a time. Extensions are skipped.

use std::ops::ControlFlow;
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesRef, BytesStart, Event};

use super::MAX_POSITIONS;
use super::bounded::{Bounded, Gauge};
use super::error::Cause;
use super::model::{Attributes, Position, Value};
use super::shapes::{Shapes, too_many_positions};
use super::sink::Sink;
use super::summary::{Crs, CrsOrigin, Reason};

/// Deepest nesting of elements.
const DEEPEST: usize = 64;
/// Longest text of an element in bytes.
const LONGEST_TEXT: usize = 1 << 20;

/// The layers, as GDAL names them.
const LAYERS: [&str; 3] = ["waypoints", "routes", "tracks"];
/// Elements that become attributes.
const FIELDS: [&str; 9] = ["name", "cmt", "desc", "src", "sym", "type", "time", "ele", "number"];

/// Reads a file.
pub(super) fn read(path: &Path, layer: Option<&str>, sink: &mut Sink<'_>) -> Result<(), Cause> {
    if let Some(layer) = layer.filter(|layer| !LAYERS.contains(layer)) {
        let layers = LAYERS.map(str::to_owned).to_vec();
        return Err(Cause::Layers { wanted: Some(layer.to_owned()), layers });
    }
    sink.begin("GPX", "element");
    sink.set_crs(Some(Crs::epsg(4326, CrsOrigin::Format)));
    let layers = LAYERS.map(|name| layer.is_none_or(|layer| layer == name).then(|| sink.add_layer(name)));
    let (file, gauge) = Bounded::open(path)?;
    let mut reader = Reader::from_reader(file);
    let mut walk =
        Walk { sink, gauge, layers, path: Vec::new(), object: Object::default(), record: 0, text: String::new() };
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = reader.read_event_into(&mut buffer);
        let flow = match event {
            Ok(Event::Eof) if walk.path.is_empty() => return Ok(()),
            Ok(Event::Eof) => Err("ends before its last element does; it is truncated".to_owned().into()),
            Ok(event) => walk.take(&event),
            Err(error) => Err(Fault::Xml(error)),
        };
        match flow {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(())) => return Ok(()),
            Err(Fault::Cause(cause)) => return Err(cause),
            Err(Fault::Text(text)) => {
                return Err(Cause::content(format!("{text} (byte {})", reader.buffer_position())));
            }
            Err(Fault::Xml(quick_xml::Error::Io(error))) => {
                return Err(Cause::Read(std::io::Error::new(error.kind(), error.to_string())));
            }
            Err(Fault::Xml(error)) => {
                return Err(Cause::content(format!("is not valid GPX: {error} (byte {})", reader.error_position())));
            }
        }
    }
}

/// An error before its position is added.
enum Fault {
    Cause(Cause),
    Text(String),
    Xml(quick_xml::Error),
}

impl From<String> for Fault {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<quick_xml::Error> for Fault {
    fn from(error: quick_xml::Error) -> Self {
        Self::Xml(error)
    }
}

type Flow = Result<ControlFlow<()>, Fault>;

/// A start tag of the GPX file, as far as the reader uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Element {
    Root,
    Waypoint,
    Route,
    RoutePoint,
    Track,
    Segment,
    TrackPoint,
    /// An element whose text is an attribute of the object, or the height of a point.
    Field(&'static str),
    Other,
}

impl Element {
    fn new(name: &[u8], parent: Option<Self>) -> Self {
        let field = || FIELDS.into_iter().find(|field| field.as_bytes() == name);
        match (parent, name) {
            (None, b"gpx") => Self::Root,
            (Some(Self::Root), b"wpt") => Self::Waypoint,
            (Some(Self::Root), b"rte") => Self::Route,
            (Some(Self::Root), b"trk") => Self::Track,
            (Some(Self::Route), b"rtept") => Self::RoutePoint,
            (Some(Self::Track), b"trkseg") => Self::Segment,
            (Some(Self::Segment), b"trkpt") => Self::TrackPoint,
            (Some(Self::Waypoint | Self::Route | Self::Track), _) => field().map_or(Self::Other, Self::Field),
            (Some(Self::RoutePoint | Self::TrackPoint), b"ele") => Self::Field("ele"),
            _ => Self::Other,
        }
    }

    /// Returns the index of the layer whose features are elements of this kind.
    fn layer(self) -> Option<usize> {
        match self {
            Self::Waypoint => Some(0),
            Self::Route => Some(1),
            Self::Track => Some(2),
            _ => None,
        }
    }
}

/// The waypoint, route or track that is being read.
#[derive(Default)]
struct Object {
    shapes: Shapes,
    line: Vec<Position>,
    fields: Vec<(&'static str, Value)>,
    point: Position,
    positions: usize,
}

struct Walk<'a, 'e> {
    sink: &'a mut Sink<'e>,
    gauge: Gauge,
    /// The layers of waypoints, routes and tracks in the summary; `None` for those that are not read.
    layers: [Option<usize>; 3],
    path: Vec<Element>,
    object: Object,
    record: u64,
    /// The text of the present field.
    text: String,
}

impl Walk<'_, '_> {
    fn take(&mut self, event: &Event<'_>) -> Flow {
        match event {
            Event::Start(start) => self.open(start)?,
            Event::Empty(start) => {
                self.open(start)?;
                return self.close();
            }
            Event::End(_) => return self.close(),
            Event::Text(text) => self.push(&text.decode().map_err(|error| Fault::Xml(error.into()))?)?,
            Event::CData(text) => self.push(&text.decode().map_err(|error| Fault::Xml(error.into()))?)?,
            Event::GeneralRef(reference) => self.push(&resolved(reference)?)?,
            Event::Decl(declaration) => {
                let encoding = declaration.encoding().and_then(Result::ok).unwrap_or_default();
                if !encoding.is_empty()
                    && ![&b"UTF-8"[..], b"UTF8", b"US-ASCII"].contains(&&*encoding.to_ascii_uppercase())
                {
                    let encoding = String::from_utf8_lossy(&encoding);
                    return Err(format!("is {encoding} text; convert it to UTF-8, also in its first line").into());
                }
            }
            Event::Comment(_) | Event::PI(_) | Event::DocType(_) | Event::Eof => {}
        }
        Ok(ControlFlow::Continue(()))
    }

    fn push(&mut self, text: &str) -> Result<(), Fault> {
        if matches!(self.path.last(), Some(Element::Field(_))) {
            if self.text.len() + text.len() > LONGEST_TEXT {
                return Err(format!("has an element with more than {LONGEST_TEXT} bytes of text").into());
            }
            self.text.push_str(text);
        }
        Ok(())
    }

    fn open(&mut self, start: &BytesStart<'_>) -> Result<(), Fault> {
        if self.path.len() >= DEEPEST {
            return Err(format!("has elements that are nested more than {DEEPEST} deep").into());
        }
        let element = Element::new(start.local_name().as_ref(), self.path.last().copied());
        if self.path.is_empty() && element != Element::Root {
            return Err("is XML, but has an element outside of gpx".to_owned().into());
        }
        self.path.push(element);
        match element {
            Element::Waypoint | Element::Route | Element::Track => {
                self.object = Object::default();
                self.record += 1;
            }
            _ => {}
        }
        if matches!(element, Element::Waypoint | Element::RoutePoint | Element::TrackPoint) {
            self.object.point = [degrees(start, "lon", 360.0)?, degrees(start, "lat", 90.0)?, f64::NAN];
        }
        self.text.clear();
        Ok(())
    }

    fn close(&mut self) -> Flow {
        let Some(element) = self.path.pop() else { return Ok(ControlFlow::Continue(())) };
        let object = &mut self.object;
        match element {
            Element::Field("ele") => {
                let height = self.text.trim().parse().ok().filter(|height: &f64| height.is_finite());
                object.point[2] = height.unwrap_or(f64::NAN);
                if self.path.last() == Some(&Element::Waypoint) {
                    object.fields.push(("ele", height.map_or(Value::None, Value::Number)));
                }
            }
            Element::Field(name @ "number") => object.fields.push((name, Value::guessed(&self.text, false))),
            Element::Field(name) => object.fields.push((name, Value::text(self.text.trim()))),
            Element::RoutePoint | Element::TrackPoint => {
                object.positions += 1;
                if object.positions > MAX_POSITIONS {
                    return Err(Fault::Cause(too_many_positions()));
                }
                object.line.push(object.point);
            }
            // The height of a waypoint is read after its position.
            Element::Waypoint => object.shapes.point(object.point),
            Element::Segment | Element::Route => object.shapes.line(std::mem::take(&mut object.line)),
            Element::Track if object.shapes.is_empty() && object.shapes.faults.is_empty() => {
                object.shapes.fault(Reason::Empty);
            }
            Element::Track | Element::Root | Element::Other => {}
        }
        self.text.clear();
        match element.layer() {
            Some(layer) => Ok(self.finish(layer)),
            None => Ok(ControlFlow::Continue(())),
        }
    }

    /// Passes the object on.
    fn finish(&mut self, layer: usize) -> ControlFlow<()> {
        self.gauge.reset();
        let Object { shapes, fields, .. } = std::mem::take(&mut self.object);
        let Some(layer) = self.layers.get(layer).copied().flatten() else { return ControlFlow::Continue(()) };
        let mut attributes = Attributes::default();
        for (name, value) in fields {
            let name = self.sink.name(name);
            self.sink.add(&mut attributes, &name, value);
        }
        self.sink.take(layer, self.record, shapes, attributes)
    }
}

/// Returns a coordinate of a point; NaN if it is missing, not a number, or not on the globe.
fn degrees(start: &BytesStart<'_>, name: &str, largest: f64) -> Result<f64, Fault> {
    let attribute = start.try_get_attribute(name).map_err(|error| Fault::Xml(error.into()))?;
    let number = attribute.and_then(|it| std::str::from_utf8(&it.value).ok()?.trim().parse::<f64>().ok());
    Ok(number.filter(|number| number.abs() <= largest).unwrap_or(f64::NAN))
}

/// Returns the text of `&name;`. Unknown entities remain as they are.
fn resolved(reference: &BytesRef<'_>) -> Result<String, Fault> {
    if let Some(character) = reference.resolve_char_ref()? {
        return Ok(character.to_string());
    }
    let name = reference.decode().map_err(|error| Fault::Xml(error.into()))?;
    Ok(match &*name {
        "amp" => "&".to_owned(),
        "lt" => "<".to_owned(),
        "gt" => ">".to_owned(),
        "quot" => "\"".to_owned(),
        "apos" => "'".to_owned(),
        other => format!("&{other};"),
    })
}
