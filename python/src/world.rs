//! Worlds, and the pictures that are drawn of them.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use anyhow::{Context as _, bail};
use hachure::commands::host::{DrawnPicture, HostWorld, IN_MEMORY, open_gpu};
use hachure::file::exr::Samples;
use hachure::gpu::Gpu;
use hachure::source::HeightGrid;
use hachure::source::georeference::Georeference;
use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::style::Style;
use crate::to_python;

/// The open GPUs, by what was asked for. They stay open: opening one, and compiling its pipelines, takes seconds.
static GPUS: Mutex<Option<HashMap<String, Gpu>>> = Mutex::new(None);

thread_local! {
    /// Whether this thread is inside a function of Python that takes pictures.
    static IS_TAKING: Cell<bool> = const { Cell::new(false) };
}

fn gpu(adapter: &str) -> anyhow::Result<Gpu> {
    let mut gpus = GPUS.lock().unwrap_or_else(PoisonError::into_inner);
    let gpus = gpus.get_or_insert_default();
    if let Some(gpu) = gpus.get(adapter) {
        return Ok(gpu.clone());
    }
    let gpu = open_gpu(adapter)?;
    gpus.insert(adapter.to_owned(), gpu.clone());
    Ok(gpu)
}

/// Returns bytes as an array, height × width × 4, without copying them.
pub(crate) fn picture_array<'py>(
    py: Python<'py>,
    rgba: Vec<u8>,
    [width, height]: [u32; 2],
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    rgba.into_pyarray(py).reshape([height as usize, width as usize, 4])
}

/// A picture as it was drawn. The package's class `Picture` wraps it.
#[pyclass(frozen, get_all)]
pub(crate) struct Drawn {
    /// Height × width × 4, uint8.
    array: Py<PyArray3<u8>>,
    /// Channels by name: height × width, float32 or uint32.
    channels: Py<PyDict>,
    camera: String,
    /// GDAL's geotransform of the pixel centres of a map.
    crs_from_grid: Option<[f64; 6]>,
    /// The reference system of a map as Well-Known Text.
    crs: Option<String>,
    imprint: String,
    dpi: Option<f64>,
    report: Py<PyDict>,
}

impl Drawn {
    fn new(py: Python<'_>, drawn: DrawnPicture) -> PyResult<Self> {
        let DrawnPicture { size_px, rgba, channels, camera, georeference, imprint, dpi, report } = drawn;
        let of_names = PyDict::new(py);
        let eye_px = |samples: usize| -> [usize; 2] {
            // Both eyes of a pair have channels of their own.
            let height = (size_px[1] as usize).max(1);
            [height, samples / height]
        };
        for (name, samples) in channels {
            match samples {
                Samples::F32(samples) => {
                    let shape = eye_px(samples.len());
                    of_names.set_item(name, samples.into_pyarray(py).reshape(shape)?)?;
                }
                Samples::U32(samples) => {
                    let shape = eye_px(samples.len());
                    of_names.set_item(name, samples.into_pyarray(py).reshape(shape)?)?;
                }
            }
        }
        let of_report = PyDict::new(py);
        of_report.set_item("wall_ms", report.wall_ms)?;
        of_report.set_item("triangles", report.triangles)?;
        of_report.set_item("parts", report.parts)?;
        of_report.set_item("tiles_loaded", report.tiles_loaded)?;
        of_report.set_item("tiles_missing", report.tiles_missing)?;
        of_report.set_item("allowed_error_px", report.error_px)?;
        of_report.set_item("is_empty", report.empty > 0)?;
        Ok(Self {
            array: picture_array(py, rgba, size_px)?.unbind(),
            channels: of_names.unbind(),
            camera,
            crs_from_grid: georeference.as_ref().map(|georeference| georeference.crs_from_grid),
            crs: georeference.and_then(|georeference| georeference.wkt()),
            imprint,
            dpi,
            report: of_report.unbind(),
        })
    }
}

/// An open world. The package's class of the same name wraps it.
#[pyclass(frozen)]
pub(crate) struct World(Mutex<HostWorld>);

/// Returns the heights of an array as the world keeps them, in one copy, with no-data as NaN.
fn heights_m(array: &PyReadonlyArray2<'_, f32>, nodata_m: Option<f64>) -> Vec<f32> {
    let nodata_m = nodata_m.map(|nodata_m| nodata_m as f32);
    let height = |height_m: &f32| if Some(*height_m) == nodata_m { f32::NAN } else { *height_m };
    // `as_slice` also takes Fortran's order, in which rows are columns.
    match array.as_slice() {
        Ok(heights_m) if array.is_c_contiguous() && nodata_m.is_none() => heights_m.to_vec(),
        Ok(heights_m) if array.is_c_contiguous() => heights_m.iter().map(height).collect(),
        _ => array.as_array().iter().map(height).collect(),
    }
}

impl World {
    /// Runs `work` with the world, while Python's other threads run.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut HostWorld) -> anyhow::Result<T> + Send,
    ) -> PyResult<T> {
        if IS_TAKING.get() {
            return Err(to_python(anyhow::anyhow!(
                "the function that takes the pictures of a flight cannot draw; collect the pictures first"
            )));
        }
        py.detach(|| work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))).map_err(to_python)
    }
}

#[pymethods]
impl World {
    /// Opens a world by its name.
    #[staticmethod]
    fn open(py: Python<'_>, name: &str, options: Vec<String>, adapter: &str) -> PyResult<Self> {
        let world = py.detach(|| HostWorld::open(&gpu(adapter)?, name, &options));
        world.map(|world| Self(Mutex::new(world))).map_err(to_python)
    }

    /// Opens heights in metres, float32, row by row, with GDAL's geotransform of sample centres.
    #[staticmethod]
    #[pyo3(signature = (heights, crs_from_grid, crs, nodata_m, options, adapter))]
    fn of_heights(
        py: Python<'_>,
        heights: PyReadonlyArray2<'_, f32>,
        crs_from_grid: [f64; 6],
        crs: Option<&str>,
        nodata_m: Option<f64>,
        options: Vec<String>,
        adapter: &str,
    ) -> PyResult<Self> {
        let [height, width] = [0, 1].map(|axis| heights.shape()[axis]);
        let side = |samples: usize| u32::try_from(samples).context("the array is too large");
        let world = || -> anyhow::Result<HostWorld> {
            let (width, height) = (side(width)?, side(height)?);
            let georeference =
                Georeference::of_transform(crs_from_grid, crs, IN_MEMORY).with_context(|| IN_MEMORY.to_owned())?;
            let heights_m = heights_m(&heights, nodata_m);
            let grid = HeightGrid { width, height, heights_m, georeference };
            py.detach(|| HostWorld::of_heights(&gpu(adapter)?, grid, &options))
        };
        world().map(|world| Self(Mutex::new(world))).map_err(to_python)
    }

    /// Draws, and passes each picture to `take`.
    fn draw(&self, py: Python<'_>, style: &Style, options: Vec<String>, take: Py<PyAny>) -> PyResult<()> {
        let style = style.0.style();
        self.with(py, |world| {
            world.draw(style, &options, |drawn| {
                Python::attach(|py| -> PyResult<()> {
                    py.check_signals()?;
                    let drawn = Drawn::new(py, drawn)?;
                    IS_TAKING.set(true);
                    let taken = take.call1(py, (drawn,));
                    IS_TAKING.set(false);
                    taken.map(drop)
                })?;
                Ok(())
            })
        })
    }

    /// Draws into a file.
    fn write(&self, py: Python<'_>, output: &str, style: &Style, options: Vec<String>) -> PyResult<()> {
        let style = style.0.style();
        self.with(py, |world| world.write(Path::new(output), style, &options))
    }

    /// Measures styles along a camera path, and returns the report as JSON.
    fn bench(&self, py: Python<'_>, options: Vec<String>) -> PyResult<String> {
        self.with(py, |world| world.bench(&options))
    }

    /// The name of the world.
    #[getter]
    fn name(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |world| Ok(world.name().to_owned()))
    }

    /// Samples per row, and rows.
    #[getter]
    fn size(&self, py: Python<'_>) -> PyResult<[u32; 2]> {
        self.with(py, |world| match world.store().levels().first() {
            Some(size) => Ok([size.width, size.height]),
            None => bail!("{}: has no heights", world.name()),
        })
    }

    /// The reference system as Well-Known Text, and GDAL's geotransform of sample centres.
    #[getter]
    fn place(&self, py: Python<'_>) -> PyResult<(Option<String>, [f64; 6])> {
        self.with(py, |world| {
            let georeference = world.store().georeference();
            Ok((georeference.wkt(), georeference.crs_from_grid))
        })
    }
}
