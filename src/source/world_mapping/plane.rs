//! The planes in which a world has its metres, and the choice among them.

use glam::{DMat2, DVec2};
use proj4rs::Proj;

use super::ground_scale::{ScaleRange, map_from_ground};
use super::{Earth, GroundScale};
use crate::source::earth_projection::project;
use crate::source::georeference::GeoreferenceError;

/// Departure from scale 1 up to which a plane is taken as it is, without looking for a better one. UTM departs from 1 by
/// 0.0004 in the middle of a zone, by up to 0.001 at its edge, and by 0.0027 half a zone beyond.
const GOOD_DEPARTURE: f64 = 0.003;

/// Factor by which the departure of a plane must be smaller than that of a conformal one.
const CLEARLY_SMALLER: f64 = 0.7;

/// Largest angle from the central meridian at which the transverse Mercator projection is used, in radians. At 60° its
/// scale is 2.
const TRANSVERSE_MERCATOR_REACH_RAD: f64 = 60.0 / 180.0 * std::f64::consts::PI;

/// Largest error of a plane's inverse, as a part of the extent.
const INVERSE_ERROR: f64 = 1e-7;

/// The plane of the world's metres.
#[derive(Clone, Debug)]
pub(super) enum Plane {
    /// The file's own plane, in metres.
    Scaled { metres_per_unit: f64 },
    /// The file's own plane, transformed so that it has the ground's lengths at the origin.
    Fitted { world_from_offset: DMat2 },
    /// Transverse Mercator about the origin; the central meridian is 0 because longitudes are relative.
    TransverseMercator { geographic: Box<Proj>, projected: Box<Proj>, world_from_projected: DMat2 },
    /// Equidistant cylindrical about the origin.
    EquidistantCylindrical { centre_latitude_rad: f64, radius_m: f64 },
}

impl Plane {
    /// Returns the world position in metres of an offset from the origin in CRS units. `relative_rad` converts it to a
    /// relative longitude and a latitude.
    pub(super) fn world(&self, offset: DVec2, relative_rad: impl Fn(DVec2) -> DVec2) -> DVec2 {
        match self {
            Self::Scaled { metres_per_unit } => offset * *metres_per_unit,
            Self::Fitted { world_from_offset } => *world_from_offset * offset,
            Self::TransverseMercator { geographic, projected, world_from_projected } => {
                *world_from_projected * project(geographic, projected, relative_rad(offset))
            }
            Self::EquidistantCylindrical { centre_latitude_rad, radius_m } => {
                let place = relative_rad(offset) - DVec2::new(0.0, *centre_latitude_rad);
                place * *radius_m * DVec2::new(centre_latitude_rad.cos(), 1.0)
            }
        }
    }

    /// Returns the offset in CRS units of a world position in metres. `offset` converts a relative longitude and a
    /// latitude to it.
    pub(super) fn offset(&self, world_m: DVec2, offset: impl Fn(DVec2) -> DVec2) -> DVec2 {
        match self {
            Self::Scaled { metres_per_unit } => world_m / *metres_per_unit,
            Self::Fitted { world_from_offset } => world_from_offset.inverse() * world_m,
            // The transpose of a rotation is its inverse.
            Self::TransverseMercator { geographic, projected, world_from_projected } => {
                offset(project(projected, geographic, world_from_projected.transpose() * world_m))
            }
            Self::EquidistantCylindrical { centre_latitude_rad, radius_m } => {
                let place = world_m / (*radius_m * DVec2::new(centre_latitude_rad.cos(), 1.0));
                offset(place + DVec2::new(0.0, *centre_latitude_rad))
            }
        }
    }
}

/// A grid on the earth for which a plane is chosen.
pub(super) struct GridOnEarth<'a> {
    pub earth: &'a Earth,
    /// The last (column, row).
    pub last: DVec2,
    pub centre_crs: DVec2,
    /// Vectors of one step along columns and along rows, in CRS units.
    pub steps_crs: [DVec2; 2],
}

impl GridOnEarth<'_> {
    /// Chooses the plane: the first that is good enough, or else the one whose scale departs least
    /// from 1; among planes that are nearly alike the conformal one, which is tried first.
    /// `metres_per_unit` is the unit of a projected CRS.
    ///
    /// # Errors
    /// Fails if the projection library rejects the ellipsoid of a geographic grid.
    pub(super) fn choose(&self, metres_per_unit: f64) -> Result<(Plane, Option<GroundScale>), GeoreferenceError> {
        match self.earth {
            Earth::Degrees { ellipsoid, .. } => {
                let cylindrical =
                    Plane::EquidistantCylindrical { centre_latitude_rad: self.centre_rad().y, radius_m: ellipsoid[0] };
                let mercator = match self.is_in_reach() {
                    true => Some(self.transverse_mercator(DMat2::IDENTITY)?),
                    false => None,
                };
                let (plane, world) = self.best(mercator.into_iter().chain([cylindrical.clone()]));
                Ok((plane.unwrap_or(cylindrical), world.map(|world| GroundScale { file: None, world })))
            }
            Earth::Projected { .. } => {
                let own = Plane::Scaled { metres_per_unit };
                let Some(file) = self.scale(&own) else { return Ok((own, None)) };
                if file.departure() <= GOOD_DEPARTURE {
                    return Ok((own, Some(GroundScale { file: Some(file), world: file })));
                }
                let Some(ground_from_file) = self.ground_from(&own) else { return Ok((own, None)) };
                // World and file agree about the direction of y.
                let north = (ground_from_file * DVec2::Y).normalize();
                let world_from_ground = DMat2::from_cols(DVec2::new(north.y, north.x), DVec2::new(-north.x, north.y));
                let world_from_offset = world_from_ground * ground_from_file * metres_per_unit;
                // A projection that rejects the ellipsoid is not a candidate.
                let mercator = self.transverse_mercator(world_from_ground).ok();
                let (plane, world) = self.best(mercator.into_iter().chain([Plane::Fitted { world_from_offset }]));
                let scale = world.map(|world| GroundScale { file: Some(file), world });
                Ok((plane.unwrap_or(own), scale))
            }
        }
    }

    fn best(&self, planes: impl Iterator<Item = Plane>) -> (Option<Plane>, Option<ScaleRange>) {
        let mut best: Option<(Plane, ScaleRange)> = None;
        for plane in planes.filter(|plane| self.has_inverse(plane)) {
            if best.as_ref().is_some_and(|(_, scale)| scale.departure() <= GOOD_DEPARTURE) {
                break;
            }
            if let Some(scale) = self.scale(&plane)
                && best.as_ref().is_none_or(|(_, other)| scale.departure() < CLEARLY_SMALLER * other.departure())
            {
                best = Some((plane, scale));
            }
        }
        best.map_or((None, None), |(plane, scale)| (Some(plane), Some(scale)))
    }

    fn offset(&self, grid: DVec2) -> DVec2 {
        let grid = grid - 0.5 * self.last;
        self.steps_crs[0] * grid.x + self.steps_crs[1] * grid.y
    }

    fn relative_rad(&self, offset: DVec2) -> DVec2 {
        self.earth.relative_rad(self.centre_crs, offset)
    }

    fn centre_rad(&self) -> DVec2 {
        self.relative_rad(DVec2::ZERO)
    }

    /// Returns the position on a plane of a relative longitude and a latitude.
    fn on_plane(&self, plane: &Plane, relative_rad: DVec2) -> DVec2 {
        plane.world(self.earth.offset(self.centre_crs, relative_rad), |_| relative_rad)
    }

    fn scale(&self, plane: &Plane) -> Option<ScaleRange> {
        let place = |grid: DVec2| self.relative_rad(self.offset(grid));
        ScaleRange::over(self.last, self.earth.ellipsoid(), place, |rad| self.on_plane(plane, rad))
    }

    /// Returns metres on the ground (east, north) per metre on a plane, at the centre.
    fn ground_from(&self, plane: &Plane) -> Option<DMat2> {
        let derivative = map_from_ground(self.earth.ellipsoid(), self.centre_rad(), |rad| self.on_plane(plane, rad))?;
        Some(derivative.inverse()).filter(|inverse| inverse.is_finite())
    }

    /// Returns whether positions along the border of the extent come back from a plane.
    fn has_inverse(&self, plane: &Plane) -> bool {
        let size = self.offset(self.last).length().max(f64::MIN_POSITIVE);
        (0..8).flat_map(|i| [[0.125 * f64::from(i), 0.0], [1.0, 0.125 * f64::from(i)]]).all(|[x, y]| {
            [DVec2::new(x, y), DVec2::new(1.0 - x, 1.0 - y)].into_iter().all(|part| {
                let offset = self.offset(part * self.last);
                let world_m = plane.world(offset, |offset| self.relative_rad(offset));
                let back = plane.offset(world_m, |rad| self.earth.offset(self.centre_crs, rad));
                back.distance(offset) < INVERSE_ERROR * size
            })
        })
    }

    /// Returns whether a geographic grid is within the transverse Mercator's reach.
    fn is_in_reach(&self) -> bool {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
            .map(|part| self.relative_rad(self.offset(DVec2::from_array(part) * self.last)));
        let fold = |of: fn(f64, f64) -> f64, start: f64| corners.iter().fold(start, |sum, rad| of(sum, rad.y));
        let (south, north) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let half_width = corners.iter().fold(0.0, |sum: f64, rad| sum.max(rad.x.abs()));
        let pole = std::f64::consts::FRAC_PI_2;
        // The angle from the central meridian is largest where the parallels are longest.
        let widest_latitude = if south <= 0.0 && north >= 0.0 { 0.0 } else { south.abs().min(north.abs()) };
        let reach = (widest_latitude.cos() * half_width.min(pole).sin()).clamp(-1.0, 1.0).asin();
        north.max(-south) <= pole && half_width < pole && reach <= TRANSVERSE_MERCATOR_REACH_RAD
    }

    fn transverse_mercator(&self, world_from_projected: DMat2) -> Result<Plane, GeoreferenceError> {
        let [semi_major_axis_m, inverse_flattening] = self.earth.ellipsoid();
        // `etmerc` is Poder and Engsager's exact algorithm; it does not support a sphere, for which `tmerc` is exact.
        let (shape, algorithm) = match inverse_flattening {
            0.0 => (format!("+R={semi_major_axis_m}"), "tmerc"),
            _ => (format!("+a={semi_major_axis_m} +rf={inverse_flattening}"), "etmerc"),
        };
        let set_up = |text: String| {
            let failed = |error: proj4rs::errors::Error| GeoreferenceError::Projection { reason: error.to_string() };
            Proj::from_proj_string(&text).map(Box::new).map_err(failed)
        };
        let latitude_degrees = self.centre_rad().y.to_degrees();
        Ok(Plane::TransverseMercator {
            geographic: set_up(format!("+proj=longlat {shape}"))?,
            projected: set_up(format!("+proj={algorithm} +lat_0={latitude_degrees} +lon_0=0 +k=1 {shape}"))?,
            world_from_projected,
        })
    }
}
