//! The extension module `_hachure` of the Python package `hachure`.
//!
//! It passes arrays and words between Python and [`hachure::commands::host`]. Everything that needs no GPU is in
//! `hachure/__init__.py`.

mod log;
mod style;
mod world;

use std::path::Path;

use anyhow::Context as _;
use hachure::commands::host;
use hachure::file::imprint::Notes;
use hachure::file::png::{PngPixels, PngWriter};
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

create_exception!(
    hachure,
    HachureError,
    PyException,
    "An input cannot be drawn. The message is the one line that the program hachure prints."
);

/// Converts an error: one of Python stays what it is, all others become [`HachureError`].
pub(crate) fn to_python(error: anyhow::Error) -> PyErr {
    match error.downcast::<PyErr>() {
        Ok(error) => error,
        Err(error) => HachureError::new_err(host::message(&error)),
    }
}

/// Returns the bytes of a picture, height × width × 4, row by row.
fn bytes(picture: &PyReadonlyArray3<'_, u8>) -> anyhow::Result<(Vec<u8>, [u32; 2])> {
    let [height, width, channels] = [0, 1, 2].map(|axis| picture.shape()[axis]);
    anyhow::ensure!(channels == 4, "a picture has four channels, and this array has {channels}");
    let side = |pixels: usize| u32::try_from(pixels).context("the picture is too large");
    let size_px = [side(width)?, side(height)?];
    Ok((picture.as_array().iter().copied().collect(), size_px))
}

/// Returns a picture as the bytes of a PNG.
#[pyfunction]
fn png_of<'py>(py: Python<'py>, picture: PyReadonlyArray3<'py, u8>) -> PyResult<Bound<'py, PyBytes>> {
    let (rgba, [width, height]) = bytes(&picture).map_err(to_python)?;
    let png = py.detach(|| -> anyhow::Result<Vec<u8>> {
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&rgba)?;
        writer.finish()?;
        Ok(png)
    });
    Ok(PyBytes::new(py, &png.map_err(to_python)?))
}

/// Writes a picture as a PNG with the description of how it was drawn.
#[pyfunction]
fn write_png(
    py: Python<'_>,
    path: &str,
    picture: PyReadonlyArray3<'_, u8>,
    imprint: Option<&str>,
    dpi: Option<f64>,
) -> PyResult<()> {
    let (rgba, [width, height]) = bytes(&picture).map_err(to_python)?;
    let written = py.detach(|| -> anyhow::Result<()> {
        let notes = Notes { imprint, dpi, ..Notes::default() };
        let mut writer = PngWriter::create_noted(Path::new(path), width, height, PngPixels::Rgba8, &notes)?;
        writer.write_rows(&rgba)?;
        writer.finish()?;
        Ok(())
    });
    written.map_err(to_python)
}

/// Reads a PNG as an array: height × width × 4, uint8.
#[pyfunction]
fn read_png<'py>(py: Python<'py>, path: &str) -> PyResult<Bound<'py, numpy::PyArray3<u8>>> {
    let read = py.detach(|| hachure::file::png::read_rgba8(Path::new(path)));
    let read = read.map_err(|error| to_python(error.into()))?;
    world::picture_array(py, read.rgba, [read.width, read.height])
}

#[pymodule]
fn _hachure(module: &Bound<'_, PyModule>) -> PyResult<()> {
    log::start();
    module.add("HachureError", module.py().get_type::<HachureError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<world::World>()?;
    module.add_class::<world::Drawn>()?;
    module.add_class::<style::Style>()?;
    module.add_function(wrap_pyfunction!(png_of, module)?)?;
    module.add_function(wrap_pyfunction!(write_png, module)?)?;
    module.add_function(wrap_pyfunction!(read_png, module)?)?;
    module.add_function(wrap_pyfunction!(style::style_names, module)?)?;
    module.add_function(wrap_pyfunction!(log::take_warnings, module)?)?;
    Ok(())
}
