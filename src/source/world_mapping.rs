//! Maps grid coordinates to world metres and back.
//!
//! The world's origin is the centre of the sample lattice; x runs east, y north. A projected grid is only scaled to
//! metres. A geographic grid is projected to a transverse Mercator projection whose centre is the origin, on the file's
//! own ellipsoid; a grid that is too wide for it uses the equidistant cylindrical projection.

mod picture;

use glam::DVec2;
use proj4rs::Proj;
use proj4rs::transform::transform;

use super::georeference::{Crs, Georeference, GeoreferenceError};

/// Largest angle from the central meridian at which the transverse Mercator projection is used, in radians. At 60° its
/// scale is 2.
const TRANSVERSE_MERCATOR_REACH_RAD: f64 = 60.0 / 180.0 * std::f64::consts::PI;

/// The mapping between a height grid's (column, row), its CRS, and world metres.
///
/// Points are `f64` throughout; a point that the projection cannot represent becomes NaN.
#[derive(Clone, Debug)]
pub struct WorldMapping {
    /// (column, row) of the world's origin.
    centre_grid: DVec2,
    /// The origin in the CRS.
    centre_crs: DVec2,
    /// Vectors of one step along columns and along rows, in CRS units.
    step_column_crs: DVec2,
    step_row_crs: DVec2,
    projection: Projection,
    crs_name: String,
}

#[derive(Clone, Debug)]
enum Projection {
    Scaled { metres_per_unit: f64 },
    TransverseMercator { radians_per_unit: f64, centre_latitude_rad: f64, geographic: Box<Proj>, projected: Box<Proj> },
    EquidistantCylindrical { radians_per_unit: f64, centre_latitude_rad: f64, radius_m: f64 },
}

impl WorldMapping {
    /// Builds the mapping of a grid of `width × height` samples.
    ///
    /// # Errors
    /// Fails if latitudes reach beyond a pole, if the transform has no inverse, or if the projection rejects the
    /// ellipsoid.
    pub fn new(georeference: &Georeference, width: u32, height: u32) -> Result<Self, GeoreferenceError> {
        let [x0, a, b, y0, c, d] = georeference.crs_from_grid;
        let (step_column_crs, step_row_crs) = (DVec2::new(a, c), DVec2::new(b, d));
        let determinant = step_column_crs.perp_dot(step_row_crs);
        if !(determinant.is_finite() && determinant != 0.0) {
            return Err(GeoreferenceError::PixelSize);
        }
        let last = DVec2::new(f64::from(width.max(1) - 1), f64::from(height.max(1) - 1));
        let centre_grid = last / 2.0;
        let crs_of = |grid: DVec2| DVec2::new(x0, y0) + step_column_crs * grid.x + step_row_crs * grid.y;
        let centre_crs = crs_of(centre_grid);
        let corners = [DVec2::ZERO, DVec2::new(last.x, 0.0), DVec2::new(0.0, last.y), last].map(crs_of);
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Err(GeoreferenceError::PixelSize);
        }
        let (projection, crs_name) = match &georeference.crs {
            Crs::Local => (Projection::Scaled { metres_per_unit: 1.0 }, "a local grid".to_owned()),
            Crs::Projected { metres_per_unit, name } => {
                (Projection::Scaled { metres_per_unit: *metres_per_unit }, name.clone())
            }
            Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, name } => {
                // Half a step beyond ±90° is allowed for files whose corners, not centres, are on the pole.
                let slack = (c.abs() + d.abs()) / 2.0;
                let ellipsoid = [*semi_major_axis_m, *inverse_flattening];
                (geographic_projection(centre_crs, &corners, slack, *radians_per_unit, ellipsoid)?, name.clone())
            }
        };
        Ok(Self { centre_grid, centre_crs, step_column_crs, step_row_crs, projection, crs_name })
    }

    /// Returns world metres (east, north) at a grid position; whole numbers are sample centres.
    #[must_use]
    pub fn world_from_grid(&self, column: f64, row: f64) -> DVec2 {
        let grid = DVec2::new(column, row) - self.centre_grid;
        self.world_from_offset(self.step_column_crs * grid.x + self.step_row_crs * grid.y)
    }

    /// Returns (column, row) at a world position in metres.
    #[must_use]
    pub fn grid_from_world(&self, world_m: DVec2) -> DVec2 {
        let offset = self.offset_from_world(world_m);
        let determinant = self.step_column_crs.perp_dot(self.step_row_crs);
        let grid = DVec2::new(offset.perp_dot(self.step_row_crs), self.step_column_crs.perp_dot(offset)) / determinant;
        self.centre_grid + grid
    }

    /// Returns the coordinates in the file's CRS and its units at a world position in metres. Longitudes continue
    /// beyond ±180°, starting from the centre's longitude.
    #[must_use]
    pub fn crs_from_world(&self, world_m: DVec2) -> DVec2 {
        self.centre_crs + self.offset_from_world(world_m)
    }

    /// Returns the world's origin in the file's CRS and its units.
    #[must_use]
    pub fn origin_crs(&self) -> DVec2 {
        self.centre_crs
    }

    /// Returns a description for users in one line: the projection and the origin.
    #[must_use]
    pub(crate) fn describe(&self) -> String {
        let (name, origin) = (&self.crs_name, self.centre_crs);
        let degrees = |radians_per_unit: f64| {
            let degrees = origin * radians_per_unit.to_degrees();
            format!("longitude {:.6}°, latitude {:.6}°", degrees.x, degrees.y)
        };
        match &self.projection {
            Projection::Scaled { metres_per_unit } => {
                let unit = if *metres_per_unit == 1.0 { "m".to_owned() } else { format!("× {metres_per_unit} m") };
                format!("{name}, origin at ({:.3}, {:.3}) {unit}", origin.x, origin.y)
            }
            Projection::TransverseMercator { radians_per_unit, .. } => {
                format!("transverse Mercator of {name} about {}", degrees(*radians_per_unit))
            }
            Projection::EquidistantCylindrical { radians_per_unit, .. } => {
                format!("equidistant cylindrical projection of {name} about {}", degrees(*radians_per_unit))
            }
        }
    }

    /// Converts an offset from the centre in CRS units to world metres.
    fn world_from_offset(&self, offset: DVec2) -> DVec2 {
        match &self.projection {
            Projection::Scaled { metres_per_unit } => offset * *metres_per_unit,
            Projection::TransverseMercator { radians_per_unit, centre_latitude_rad, geographic, projected } => {
                let longitude_latitude = offset * *radians_per_unit + DVec2::new(0.0, *centre_latitude_rad);
                project(geographic, projected, longitude_latitude)
            }
            Projection::EquidistantCylindrical { radians_per_unit, centre_latitude_rad, radius_m } => {
                offset * *radians_per_unit * *radius_m * DVec2::new(centre_latitude_rad.cos(), 1.0)
            }
        }
    }

    /// Converts world metres to an offset from the centre in CRS units.
    fn offset_from_world(&self, world_m: DVec2) -> DVec2 {
        match &self.projection {
            Projection::Scaled { metres_per_unit } => world_m / *metres_per_unit,
            Projection::TransverseMercator { radians_per_unit, centre_latitude_rad, geographic, projected } => {
                let longitude_latitude = project(projected, geographic, world_m);
                (longitude_latitude - DVec2::new(0.0, *centre_latitude_rad)) / *radians_per_unit
            }
            Projection::EquidistantCylindrical { radians_per_unit, centre_latitude_rad, radius_m } => {
                world_m / (*radians_per_unit * *radius_m * DVec2::new(centre_latitude_rad.cos(), 1.0))
            }
        }
    }
}

fn project(from: &Proj, to: &Proj, point: DVec2) -> DVec2 {
    let mut point = (point.x, point.y, 0.0);
    match transform(from, to, &mut point) {
        Ok(()) => DVec2::new(point.0, point.1),
        Err(_) => DVec2::NAN,
    }
}

/// Chooses the projection of a geographic grid. `slack` is how far the latitudes may reach beyond a pole. `slack`,
/// `centre_crs` and `corners` are in units of the CRS.
fn geographic_projection(
    centre_crs: DVec2,
    corners: &[DVec2; 4],
    slack: f64,
    radians_per_unit: f64,
    ellipsoid: [f64; 2],
) -> Result<Projection, GeoreferenceError> {
    let latitudes = corners.map(|corner| corner.y * radians_per_unit);
    let south = latitudes.into_iter().fold(f64::INFINITY, f64::min);
    let north = latitudes.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let pole = std::f64::consts::FRAC_PI_2;
    if north.max(-south) > pole + slack * radians_per_unit * (1.0 + 1e-9) {
        let (south_degrees, north_degrees) = (south.to_degrees(), north.to_degrees());
        return Err(GeoreferenceError::BeyondPole { south_degrees, north_degrees });
    }
    let half_width = corners.map(|it| (it.x - centre_crs.x).abs() * radians_per_unit).into_iter().fold(0.0, f64::max);
    // The angle from the central meridian is largest where the parallels are longest.
    let widest_latitude = if south <= 0.0 && north >= 0.0 { 0.0 } else { south.abs().min(north.abs()) };
    let reach = (widest_latitude.cos() * half_width.min(pole).sin()).clamp(-1.0, 1.0).asin();
    let [semi_major_axis_m, inverse_flattening] = ellipsoid;
    let centre_latitude_rad = centre_crs.y * radians_per_unit;
    if reach > TRANSVERSE_MERCATOR_REACH_RAD || half_width >= pole || north.max(-south) > pole {
        tracing::warn!(
            "{:.0}° of longitude are too wide for a transverse Mercator projection; east–west distances are only true \
             along the parallel through the centre",
            2.0 * half_width.to_degrees()
        );
        return Ok(Projection::EquidistantCylindrical {
            radians_per_unit,
            centre_latitude_rad,
            radius_m: semi_major_axis_m,
        });
    }
    // Longitudes are relative to the centre's here, so the central meridian is 0 and the date line is never crossed.
    // `etmerc` is Poder and Engsager's exact algorithm; it does not support a sphere, for which `tmerc` is exact.
    let (shape, algorithm) = match inverse_flattening {
        0.0 => (format!("+R={semi_major_axis_m}"), "tmerc"),
        _ => (format!("+a={semi_major_axis_m} +rf={inverse_flattening}"), "etmerc"),
    };
    let set_up = |text: String| {
        let failed = |error: proj4rs::errors::Error| GeoreferenceError::Projection { reason: error.to_string() };
        Proj::from_proj_string(&text).map(Box::new).map_err(failed)
    };
    let latitude_degrees = centre_latitude_rad.to_degrees();
    Ok(Projection::TransverseMercator {
        radians_per_unit,
        centre_latitude_rad,
        geographic: set_up(format!("+proj=longlat {shape}"))?,
        projected: set_up(format!("+proj={algorithm} +lat_0={latitude_degrees} +lon_0=0 +k=1 {shape}"))?,
    })
}
