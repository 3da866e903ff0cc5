//! Passes features to the caller, and writes the summary.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::model::{Attributes, Feature, Geometry, Value};
use super::shapes::Shapes;
use super::summary::{Attribute, Bounds, Crs, Layer, Reason, Skipped, Summary};

/// Largest number of different names of attributes in a summary. An extract of OpenStreetMap has a few thousand.
const MOST_NAMES: usize = 1 << 16;

/// A name that has been interned.
#[derive(Clone, Debug)]
pub(super) struct Name {
    text: Arc<str>,
    /// Index into the attributes of the summary; `None` if it has too many.
    index: Option<usize>,
}

/// Takes the features of a file one after the other.
pub(super) struct Sink<'a> {
    each: &'a mut dyn FnMut(Feature) -> ControlFlow<()>,
    summary: Summary,
    names: HashMap<Arc<str>, usize>,
    has_ended: bool,
}

impl<'a> Sink<'a> {
    /// Creates a sink that passes features to `each`.
    pub(super) fn new(each: &'a mut dyn FnMut(Feature) -> ControlFlow<()>) -> Self {
        Self { each, summary: Summary::default(), names: HashMap::new(), has_ended: false }
    }

    /// Sets what the summary says about the format; `record_noun` is what a record is called.
    pub(super) fn begin(&mut self, format: &'static str, record_noun: &'static str) {
        self.summary.format = format;
        self.summary.record_noun = record_noun;
    }

    /// Adds a layer, and returns its index.
    pub(super) fn add_layer(&mut self, name: impl Into<String>) -> usize {
        self.summary.layers.push(Layer { name: name.into(), features: 0 });
        self.summary.layers.len() - 1
    }

    /// Renames a layer.
    pub(super) fn rename_layer(&mut self, layer: usize, name: String) {
        if let Some(layer) = self.summary.layers.get_mut(layer) {
            layer.name = name;
        }
    }

    /// Sets the reference system.
    pub(super) fn set_crs(&mut self, crs: Option<Crs>) {
        self.summary.crs = crs;
    }

    /// Returns whether the caller wants no more features.
    pub(super) fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// Returns the interned form of the name of an attribute.
    pub(super) fn name(&mut self, text: &str) -> Name {
        if let Some((own, index)) = self.names.get_key_value(text) {
            return Name { text: Arc::clone(own), index: Some(*index) };
        }
        let text: Arc<str> = Arc::from(text);
        if self.names.len() >= MOST_NAMES {
            return Name { text, index: None };
        }
        let index = self.summary.attributes.len();
        let name = Arc::clone(&text);
        self.summary.attributes.push(Attribute { name, texts: 0, numbers: 0, bools: 0, binaries: 0 });
        self.names.insert(Arc::clone(&text), index);
        Name { text, index: Some(index) }
    }

    /// Adds an attribute to those of a feature, and counts it. There is no entry for a value that is none, so that
    /// formats with a fixed set of columns give the same attributes as others.
    pub(super) fn add(&mut self, attributes: &mut Attributes, name: &Name, value: Value) {
        match name.index.and_then(|index| self.summary.attributes.get_mut(index)) {
            None => self.summary.unlisted_values += 1,
            Some(attribute) => match value {
                Value::Text(_) => attribute.texts += 1,
                Value::Number(_) => attribute.numbers += 1,
                Value::Bool(_) => attribute.bools += 1,
                Value::None => {}
            },
        }
        if value != Value::None {
            attributes.push(Arc::clone(&name.text), value);
        }
    }

    /// Counts a value that is left out because it is binary data.
    pub(super) fn leave_out_binary(&mut self, name: &Name) {
        if let Some(attribute) = name.index.and_then(|index| self.summary.attributes.get_mut(index)) {
            attribute.binaries += 1;
        }
    }

    /// Counts a feature of which nothing can be used.
    pub(super) fn skip(&mut self, record: u64, reason: Reason) {
        self.count_skipped(record, reason, 1, 0);
    }

    /// Passes a feature on, and counts the parts that are left out of it.
    pub(super) fn take(
        &mut self,
        layer: usize,
        record: u64,
        shapes: Shapes,
        attributes: Attributes,
    ) -> ControlFlow<()> {
        if shapes.is_empty() {
            let reason = shapes.faults.first().map_or(Reason::Empty, |(reason, _)| *reason);
            self.skip(record, reason);
            return ControlFlow::Continue(());
        }
        for (reason, parts) in &shapes.faults {
            self.count_skipped(record, *reason, 0, *parts);
        }
        let Shapes { points, lines, areas, .. } = shapes;
        let kinds = [
            (!points.is_empty()).then_some(Geometry::Points(points)),
            (!lines.is_empty()).then_some(Geometry::Lines(lines)),
            (!areas.is_empty()).then_some(Geometry::Areas(areas)),
        ];
        for geometry in kinds.into_iter().flatten() {
            for &[x, y, _] in geometry.positions() {
                self.summary.bounds = Some(Bounds::with([x, y], self.summary.bounds));
            }
            if let Some(layer) = self.summary.layers.get_mut(layer) {
                layer.features += 1;
            }
            let flow = (self.each)(Feature { geometry, attributes: attributes.clone(), layer, record });
            if flow.is_break() {
                self.has_ended = true;
                return flow;
            }
        }
        ControlFlow::Continue(())
    }

    /// Returns the summary.
    pub(super) fn finish(mut self) -> Summary {
        self.summary.is_complete = !self.has_ended;
        self.summary
    }

    fn count_skipped(&mut self, record: u64, reason: Reason, features: u64, parts: u64) {
        match self.summary.skipped.iter_mut().find(|skipped| skipped.reason == reason) {
            Some(skipped) => {
                skipped.features += features;
                skipped.parts += parts;
            }
            None => self.summary.skipped.push(Skipped { reason, features, parts, first: record }),
        }
    }
}
