//! Styles.

use hachure::commands::host::HostStyle;
use pyo3::prelude::*;

use crate::to_python;

/// A style. The package's class of the same name wraps it.
#[pyclass(frozen)]
pub(crate) struct Style(pub(crate) HostStyle);

#[pymethods]
impl Style {
    /// Loads a preset or a style file, with other values: texts such as "strokes.width_px=2".
    #[staticmethod]
    fn load(py: Python<'_>, name: &str, values: Vec<String>) -> PyResult<Self> {
        py.detach(|| HostStyle::load(name, &values)).map(Self).map_err(to_python)
    }

    /// Reads a style from TOML text; errors call it `name`.
    #[staticmethod]
    fn parse(py: Python<'_>, name: &str, text: &str) -> PyResult<Self> {
        py.detach(|| HostStyle::parse(name, text)).map(Self).map_err(to_python)
    }

    /// Returns the style with other values at some keys.
    fn with_values(&self, py: Python<'_>, values: Vec<String>) -> PyResult<Self> {
        py.detach(|| self.0.with(&values)).map(Self).map_err(to_python)
    }

    /// The name of the preset, or the path of the file.
    #[getter]
    fn name(&self) -> &str {
        &self.0.style().name
    }

    /// One sentence about the style.
    #[getter]
    fn description(&self) -> &str {
        &self.0.style().description
    }

    /// The style as TOML text with every parameter that has a value.
    fn text(&self) -> String {
        self.0.style().text()
    }

    /// All parameters as JSON: key, value, unit, range, default, help.
    fn parameters(&self) -> PyResult<String> {
        self.0.parameters().map_err(to_python)
    }
}

/// Returns the names of the presets.
#[pyfunction]
pub(crate) fn style_names() -> Vec<&'static str> {
    hachure::style::names()
}
