//! Maps grid coordinates to world metres and back.
//!
//! The world's origin is the centre of the sample lattice; x runs east, y along the grid's north. A world metre is a
//! metre on the ground, within the bounds of [`GroundScale`]:
//!
//! - A projected grid whose scale departs little from 1 is only scaled to metres.
//! - Other grids are projected to a transverse Mercator projection whose centre is the origin, on the file's own
//!   ellipsoid. For a projected grid it is rotated so that y runs along the file's own northings.
//! - A grid that is too wide for that stays in the file's plane, which gets the ground's lengths at the origin; for a
//!   geographic grid that is the equidistant cylindrical projection.
//!
//! Why: `docs/decisions/ground-metres.md`.

mod ground_scale;
mod picture;
mod plane;

use glam::DVec2;

use super::earth_projection::{EarthProjection, turn_in_crs};
use super::georeference::{Crs, Georeference, GeoreferenceError};
pub(crate) use ground_scale::ScaleRange;
use plane::{GridOnEarth, Plane};

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
    /// The file's coordinates on the earth, if they are known.
    earth: Option<Earth>,
    plane: Plane,
    ground_scale: Option<GroundScale>,
    crs_name: String,
}

/// How the metres of a file and of its world compare with metres on the ground.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct GroundScale {
    /// Metres of the file's projection per metre on the ground; `None` for longitudes and latitudes.
    pub file: Option<ScaleRange>,
    /// World metres per metre on the ground.
    pub world: ScaleRange,
}

/// Converts between offsets from a grid's centre and longitudes relative to the centre's, with latitudes, in radians.
#[derive(Clone, Debug)]
enum Earth {
    Degrees {
        radians_per_unit: f64,
        ellipsoid: [f64; 2],
        /// Longitude of the prime meridian, east of Greenwich.
        prime_meridian_rad: f64,
    },
    Projected {
        projection: Box<EarthProjection>,
        centre_rad: DVec2,
        /// The distance after which eastings repeat themselves, for projections whose meridians are parallel lines.
        turn_crs: Option<f64>,
    },
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
        let (metres_per_unit, crs_name) = match &georeference.crs {
            Crs::Local => (1.0, "a local grid".to_owned()),
            Crs::Projected { metres_per_unit, name } => (*metres_per_unit, name.clone()),
            Crs::Geographic { name, .. } => (1.0, name.clone()),
        };
        let mut mapping = Self {
            centre_grid,
            centre_crs,
            step_column_crs,
            step_row_crs,
            earth: Earth::of(georeference, centre_crs),
            plane: Plane::Scaled { metres_per_unit },
            ground_scale: None,
            crs_name,
        };
        if let Crs::Geographic { radians_per_unit, .. } = georeference.crs {
            // Half a step beyond ±90° is allowed for files whose corners, not centres, are on the pole.
            let slack = (c.abs() + d.abs()) / 2.0;
            check_latitudes(corners.map(|corner| corner.y * radians_per_unit), slack * radians_per_unit)?;
        }
        if let Some(earth) = &mapping.earth {
            let frame = GridOnEarth { earth, last, centre_crs, steps_crs: [step_column_crs, step_row_crs] };
            (mapping.plane, mapping.ground_scale) = frame.choose(metres_per_unit)?;
        }
        Ok(mapping)
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

    /// Returns the world position in metres of coordinates in the file's CRS and its units: the inverse of
    /// [`WorldMapping::crs_from_world`]. Coordinates that differ by a turn around the earth are the same.
    #[must_use]
    pub(crate) fn world_from_crs(&self, crs: DVec2) -> DVec2 {
        let mut offset = crs - self.centre_crs;
        let turn = match &self.earth {
            Some(Earth::Degrees { radians_per_unit, .. }) => Some(std::f64::consts::TAU / radians_per_unit),
            Some(Earth::Projected { turn_crs, .. }) => *turn_crs,
            None => None,
        };
        if let Some(turn) = turn {
            offset.x -= turn * (offset.x / turn).round();
        }
        self.world_from_offset(offset)
    }

    /// Returns the world's origin in the file's CRS and its units.
    #[must_use]
    pub fn origin_crs(&self) -> DVec2 {
        self.centre_crs
    }

    /// Returns how world metres compare with metres on the ground; `None` if the file's projection is unknown.
    pub(crate) fn ground_scale(&self) -> Option<&GroundScale> {
        self.ground_scale.as_ref()
    }

    /// Returns longitude (−π to π) and latitude in radians, on the file's own datum, at a world position in metres.
    /// Returns `None` if the file's projection is unknown or has no such place.
    pub(crate) fn longitude_latitude_rad(&self, world_m: DVec2) -> Option<DVec2> {
        let earth = self.earth.as_ref()?;
        let mut place = earth.relative_rad(self.centre_crs, self.offset_from_world(world_m));
        place.x += match earth {
            Earth::Degrees { radians_per_unit, prime_meridian_rad, .. } => {
                self.centre_crs.x * radians_per_unit + prime_meridian_rad
            }
            Earth::Projected { centre_rad, .. } => centre_rad.x,
        };
        place.x = wrapped(place.x);
        (place.is_finite() && place.y.abs() <= std::f64::consts::FRAC_PI_2).then_some(place)
    }

    /// Returns the azimuth of true north at a world position in metres: the angle in radians, clockwise from the
    /// world's y axis. Returns `None` if the file's projection is unknown, and at a pole.
    pub(crate) fn true_north_rad(&self, world_m: DVec2) -> Option<f64> {
        let earth = self.earth.as_ref()?;
        let place = earth.relative_rad(self.centre_crs, self.offset_from_world(world_m));
        let world = |rad: DVec2| self.world_from_offset(earth.offset(self.centre_crs, rad));
        let derivative = ground_scale::map_from_ground(earth.ellipsoid(), place, world)?;
        let north = derivative.y_axis;
        (north.length() > 0.0).then(|| north.x.atan2(north.y))
    }

    /// Returns a description for users in one line: the projection and the origin.
    #[must_use]
    pub(crate) fn describe(&self) -> String {
        let (name, origin) = (&self.crs_name, self.centre_crs);
        let unit = match &self.plane {
            Plane::Scaled { metres_per_unit } if *metres_per_unit != 1.0 => format!("× {metres_per_unit} m"),
            _ => "m".to_owned(),
        };
        let at = match self.earth {
            Some(Earth::Degrees { radians_per_unit, .. }) => {
                let degrees = origin * radians_per_unit.to_degrees();
                format!("longitude {:.6}°, latitude {:.6}°", degrees.x, degrees.y)
            }
            _ => format!("({:.3}, {:.3}) {unit}", origin.x, origin.y),
        };
        match &self.plane {
            Plane::Scaled { .. } => format!("{name}, origin at {at}"),
            Plane::Fitted { .. } => format!("{name} scaled to ground metres at its origin, {at}"),
            Plane::TransverseMercator { .. } => format!("transverse Mercator of {name} about {at}"),
            Plane::EquidistantCylindrical { .. } => {
                format!("equidistant cylindrical projection of {name} about {at}")
            }
        }
    }

    /// Converts an offset from the centre in CRS units to world metres.
    fn world_from_offset(&self, offset: DVec2) -> DVec2 {
        self.plane.world(offset, |offset| self.relative_rad(offset))
    }

    /// Converts world metres to an offset from the centre in CRS units.
    fn offset_from_world(&self, world_m: DVec2) -> DVec2 {
        self.plane.offset(world_m, |rad| self.earth.as_ref().map_or(DVec2::NAN, |it| it.offset(self.centre_crs, rad)))
    }

    fn relative_rad(&self, offset: DVec2) -> DVec2 {
        self.earth.as_ref().map_or(DVec2::NAN, |earth| earth.relative_rad(self.centre_crs, offset))
    }
}

impl Earth {
    fn of(georeference: &Georeference, centre_crs: DVec2) -> Option<Self> {
        match &georeference.crs {
            Crs::Local => None,
            Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, .. } => {
                let greenwich = EarthProjection::of(georeference).map(|it| it.longitude_latitude_rad(DVec2::ZERO).x);
                Some(Self::Degrees {
                    radians_per_unit: *radians_per_unit,
                    ellipsoid: [*semi_major_axis_m, *inverse_flattening],
                    prime_meridian_rad: greenwich.filter(|angle| angle.is_finite()).unwrap_or(0.0),
                })
            }
            Crs::Projected { .. } => {
                let projection = EarthProjection::of(georeference)?;
                let centre_rad = projection.longitude_latitude_rad(centre_crs);
                let turn_crs = turn_in_crs(georeference);
                let projection = Box::new(projection);
                centre_rad.is_finite().then_some(Self::Projected { projection, centre_rad, turn_crs })
            }
        }
    }

    /// Returns semi-major axis in metres and inverse flattening, 0 for a sphere.
    fn ellipsoid(&self) -> [f64; 2] {
        match self {
            Self::Degrees { ellipsoid, .. } => *ellipsoid,
            Self::Projected { projection, .. } => projection.ellipsoid,
        }
    }

    /// Returns the longitude relative to the centre's, and the latitude, in radians.
    fn relative_rad(&self, centre_crs: DVec2, offset: DVec2) -> DVec2 {
        match self {
            // Longitudes are relative to the centre's here, so that the date line is never crossed.
            Self::Degrees { radians_per_unit, .. } => {
                offset * *radians_per_unit + DVec2::new(0.0, centre_crs.y * radians_per_unit)
            }
            Self::Projected { projection, centre_rad, .. } => {
                let place = projection.longitude_latitude_rad(centre_crs + offset);
                DVec2::new(wrapped(place.x - centre_rad.x), place.y)
            }
        }
    }

    /// Returns the offset from the centre in CRS units: the inverse of [`Self::relative_rad`].
    fn offset(&self, centre_crs: DVec2, relative_rad: DVec2) -> DVec2 {
        match self {
            Self::Degrees { radians_per_unit, .. } => {
                (relative_rad - DVec2::new(0.0, centre_crs.y * radians_per_unit)) / *radians_per_unit
            }
            Self::Projected { projection, centre_rad, turn_crs } => {
                let mut offset = projection.crs(relative_rad + DVec2::new(centre_rad.x, 0.0)) - centre_crs;
                // The projection has its antimeridian somewhere; an extent may lie across it.
                if let Some(turn) = turn_crs {
                    offset.x += turn * (relative_rad.x / std::f64::consts::TAU - offset.x / turn).round();
                }
                offset
            }
        }
    }
}

/// Returns an angle from −π to π.
fn wrapped(angle_rad: f64) -> f64 {
    let half = std::f64::consts::PI;
    if angle_rad.abs() <= half { angle_rad } else { (angle_rad + half).rem_euclid(2.0 * half) - half }
}

/// Checks that latitudes, in radians, are at most `slack_rad` beyond a pole.
fn check_latitudes(latitudes_rad: [f64; 4], slack_rad: f64) -> Result<(), GeoreferenceError> {
    let south = latitudes_rad.into_iter().fold(f64::INFINITY, f64::min);
    let north = latitudes_rad.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let pole = std::f64::consts::FRAC_PI_2;
    if north.max(-south) > pole + slack_rad * (1.0 + 1e-9) {
        let (south_degrees, north_degrees) = (south.to_degrees(), north.to_degrees());
        return Err(GeoreferenceError::BeyondPole { south_degrees, north_degrees });
    }
    Ok(())
}
