//! The grid projection: the map from the grid to the world as a polynomial, so that the GPU can evaluate a curved
//! projection in camera-relative f32.
//!
//! For a projected grid the map is affine, and degree 1 is exact. A geographic grid is mapped by transverse Mercator,
//! which is smooth: a polynomial of total degree at most 7, fitted once by least squares (Householder QR in f64),
//! approximates it to well under a thousandth of a sample over a degree or two. For each frame both directions are
//! expanded again around a place near the camera, in f64; the f32 coefficients then lose nothing near the eye.
//!
//! Why: `docs/decisions/grid-projection.md`.

use glam::DVec2;

use crate::source::WorldMapping;

/// Number of terms of two variables up to degree 7.
pub(crate) const MAX_TERMS: usize = 36;
const MAX_DEGREE: usize = 7;

/// The fitted maps between grid coordinates (column, row) and the world (east, north in metres).
#[derive(Clone, Debug)]
pub struct GridProjection {
    degree: usize,
    world_from_grid: Polynomial,
    grid_from_world: Polynomial,
    last_sample: DVec2,
    worst_samples: f64,
}

/// [`GridProjection`] expanded around a place near the camera; see `shaders/shared/terrain.wgsl`.
pub struct LocalProjection {
    /// The coefficients: xy for world_from_grid relative to the camera; zw for grid_from_world relative to the anchor.
    pub terms: [[f32; 4]; MAX_TERMS],
    /// The total degree of both polynomials: 1 to 7.
    pub degree: u32,
    /// Scale of the first polynomial's variable, which is (grid coordinate − anchor) × this.
    pub grid_unit: f32,
    /// Scale of the second's, which is (place relative to the camera − `world_origin_m`) × this.
    pub world_unit: f32,
    /// The place around which the second is expanded, in metres relative to the camera.
    pub world_origin_m: [f32; 2],
}

/// A polynomial from the plane to the plane, whose variables are `(v − centre) / half`.
#[derive(Clone, Debug)]
struct Polynomial {
    degree: usize,
    centre: DVec2,
    half: f64,
    terms: Vec<DVec2>,
}

impl GridProjection {
    /// Fits the map of a grid of `width` × `height` samples.
    pub fn fit(mapping: &WorldMapping, width: u32, height: u32) -> Self {
        let last_sample = DVec2::new(f64::from(width - 1), f64::from(height - 1));
        let mut best: Option<Self> = None;
        for degree in [1, 3, 5, MAX_DEGREE] {
            let fitted = Self::fit_degree(mapping, last_sample, degree);
            let enough = fitted.worst_samples < 1e-5;
            if best.as_ref().is_none_or(|best| fitted.worst_samples < best.worst_samples) {
                best = Some(fitted);
            }
            if enough {
                break;
            }
        }
        let best = best.unwrap_or_else(|| unreachable!("the list of degrees is not empty"));
        if best.worst_samples > 0.01 {
            tracing::warn!(
                "positions are off by up to {:.3} samples: the extent is large for its projection",
                best.worst_samples
            );
        }
        best
    }

    /// Returns the largest distance between the fitted maps and the true one, in samples.
    pub fn worst_samples(&self) -> f64 {
        self.worst_samples
    }

    /// Returns the place in the world, in metres, of a grid coordinate.
    pub fn world_from_grid(&self, grid: DVec2) -> DVec2 {
        self.world_from_grid.at(grid)
    }

    /// Returns the grid coordinate of a place in the world, in metres.
    pub fn grid_from_world(&self, world_m: DVec2) -> DVec2 {
        self.grid_from_world.at(world_m)
    }

    /// Returns a box (least, greatest corner) around the places of the grid's rectangle from `first` to `end`, in
    /// metres. The sides of a wide rectangle are curved: each is sampled at five points, and the possible bulge between
    /// these is added to the margin.
    pub fn bounds(&self, first: DVec2, end: DVec2) -> (DVec2, DVec2) {
        let steps = if self.degree == 1 { 1 } else { 4 };
        let place = |i: i32, k: i32| {
            let part = DVec2::new(f64::from(i), f64::from(k)) / f64::from(steps);
            self.world_from_grid(first + (end - first) * part)
        };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (i, k) in (0..=steps).flat_map(|k| (0..=steps).map(move |i| (i, k))) {
            low = low.min(place(i, k));
            high = high.max(place(i, k));
        }
        let mut margin = (high - low) * 0.02;
        if steps > 1 {
            // A parabola bulges a sixteenth as much over a quarter of its length.
            let bulge = |a: DVec2, middle: DVec2, b: DVec2| (middle - (a + b) * 0.5).abs();
            let across = bulge(place(0, 0), place(2, 0), place(4, 0)).max(bulge(place(0, 4), place(2, 4), place(4, 4)));
            let down = bulge(place(0, 0), place(0, 2), place(0, 4)).max(bulge(place(4, 0), place(4, 2), place(4, 4)));
            margin += (across + down) / 8.0;
        }
        (low - margin, high + margin)
    }

    /// Returns the smallest and the largest east and north of the whole grid, in metres. Its sides may be curved: each is
    /// sampled at 65 points.
    pub(crate) fn extent_m(&self) -> [DVec2; 2] {
        let steps: u32 = if self.degree == 1 { 1 } else { 64 };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for i in 0..=steps {
            let along = f64::from(i) / f64::from(steps);
            for part in [[along, 0.0], [along, 1.0], [0.0, along], [1.0, along]] {
                let place = self.world_from_grid(self.last_sample * DVec2::from(part));
                (low, high) = (low.min(place), high.max(place));
            }
        }
        [low, high]
    }

    /// Returns the mean distance between samples in metres, in the middle of the grid.
    pub fn spacing_m(&self) -> f64 {
        let middle = self.last_sample * 0.5;
        let here = self.world_from_grid(middle);
        let right = self.world_from_grid(middle + DVec2::X) - here;
        let down = self.world_from_grid(middle + DVec2::Y) - here;
        right.perp_dot(down).abs().sqrt()
    }

    /// Returns the sample of the grid that is nearest to a camera: on the grid's edge if the camera is outside.
    pub fn anchor(&self, camera_m: DVec2) -> DVec2 {
        let grid = self.grid_from_world(self.clamp_to_extent(camera_m));
        let grid = if grid.is_finite() { grid } else { self.last_sample * 0.5 };
        grid.round().clamp(DVec2::ZERO, self.last_sample)
    }

    /// Expands the maps relative to a camera and to a sample near it.
    pub fn around(&self, anchor: DVec2, camera_m: DVec2) -> LocalProjection {
        let origin_m = self.clamp_to_extent(camera_m);
        let mut forward = self.world_from_grid.around(anchor);
        let mut inverse = self.grid_from_world.around(origin_m);
        forward[0] -= camera_m;
        inverse[0] -= anchor;
        let mut terms = [[0.0; 4]; MAX_TERMS];
        for (term, (forward, inverse)) in terms.iter_mut().zip(forward.iter().zip(&inverse)) {
            *term = [forward.x as f32, forward.y as f32, inverse.x as f32, inverse.y as f32];
        }
        LocalProjection {
            terms,
            degree: self.degree as u32,
            grid_unit: (1.0 / self.world_from_grid.half) as f32,
            world_unit: (1.0 / self.grid_from_world.half) as f32,
            world_origin_m: (origin_m - camera_m).as_vec2().to_array(),
        }
    }

    fn clamp_to_extent(&self, world_m: DVec2) -> DVec2 {
        let reach = DVec2::splat(self.grid_from_world.half);
        world_m.clamp(self.grid_from_world.centre - reach, self.grid_from_world.centre + reach)
    }

    fn fit_degree(mapping: &WorldMapping, last_sample: DVec2, degree: usize) -> Self {
        let nodes = nodes(last_sample, 2 * degree + 3);
        let places: Vec<_> = nodes.iter().map(|grid| mapping.world_from_grid(grid.x, grid.y)).collect();
        let world_from_grid = Polynomial::fit(&nodes, &places, degree);
        let grid_from_world = Polynomial::fit(&places, &nodes, degree);
        let metres_per_sample = {
            let span = world_from_grid.at(last_sample) - world_from_grid.at(DVec2::ZERO);
            (span.length() / last_sample.length()).max(f64::MIN_POSITIVE)
        };
        let worst_samples = self::nodes(last_sample, 4 * degree + 7)
            .into_iter()
            .map(|grid| {
                let place = mapping.world_from_grid(grid.x, grid.y);
                let forward = (world_from_grid.at(grid) - place).length() / metres_per_sample;
                forward.max((grid_from_world.at(place) - grid).length())
            })
            .fold(0.0, f64::max);
        Self { degree, world_from_grid, grid_from_world, last_sample, worst_samples }
    }
}

/// Returns Chebyshev nodes of the grid, in `count` columns and rows: dense at the border, where polynomials oscillate.
fn nodes(last_sample: DVec2, count: usize) -> Vec<DVec2> {
    let place = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / (count - 1) as f64).cos();
    (0..count * count).map(|i| DVec2::new(place(i % count), place(i / count)) * last_sample).collect()
}

impl Polynomial {
    /// Fits a polynomial by least squares; `from` and `to` have the same length, at least the number of terms.
    fn fit(from: &[DVec2], to: &[DVec2], degree: usize) -> Self {
        let (low, high) =
            from.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let centre = (low + high) * 0.5;
        let half = ((high - low).max_element() * 0.5).max(f64::MIN_POSITIVE);
        let rows: Vec<Vec<f64>> = from.iter().map(|v| basis((*v - centre) / half, degree)).collect();
        let terms = least_squares(rows, to.to_vec());
        Self { degree, centre, half, terms }
    }

    fn at(&self, v: DVec2) -> DVec2 {
        let v = (v - self.centre) / self.half;
        if self.degree == 1 {
            return self.terms[2] * v.y + (self.terms[1] * v.x + self.terms[0]);
        }
        let mut sum = DVec2::ZERO;
        for row in (0..=self.degree).rev() {
            let first = first_term_of_row(self.degree, row);
            let inner = (0..=self.degree - row).rev().fold(DVec2::ZERO, |inner, i| inner * v.x + self.terms[first + i]);
            sum = sum * v.y + inner;
        }
        sum
    }

    /// Returns the coefficients of the same polynomial in `(v − place) / half`.
    fn around(&self, place: DVec2) -> Vec<DVec2> {
        let shift = (place - self.centre) / self.half;
        let mut terms = vec![DVec2::ZERO; self.terms.len()];
        for row in 0..=self.degree {
            for column in 0..=self.degree - row {
                let term = self.terms[first_term_of_row(self.degree, row) + column];
                for new_row in 0..=row {
                    let y = binomial(row, new_row) * shift.y.powi((row - new_row) as i32);
                    for new_column in 0..=column {
                        let x = binomial(column, new_column) * shift.x.powi((column - new_column) as i32);
                        terms[first_term_of_row(self.degree, new_row) + new_column] += term * (x * y);
                    }
                }
            }
        }
        terms
    }
}

fn first_term_of_row(degree: usize, row: usize) -> usize {
    row * (degree + 1) - (row * row.saturating_sub(1)) / 2
}

fn basis(v: DVec2, degree: usize) -> Vec<f64> {
    (0..=degree)
        .flat_map(|row| (0..=degree - row).map(move |column| v.x.powi(column as i32) * v.y.powi(row as i32)))
        .collect()
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// Solves by Householder QR; the normal equations would lose half of the digits.
fn least_squares(mut rows: Vec<Vec<f64>>, mut right: Vec<DVec2>) -> Vec<DVec2> {
    let unknowns = rows[0].len();
    for k in 0..unknowns {
        let norm = rows[k..].iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
        if norm == 0.0 {
            continue;
        }
        let alpha = if rows[k][k] > 0.0 { -norm } else { norm };
        let mut v: Vec<f64> = rows[k..].iter().map(|row| row[k]).collect();
        v[0] -= alpha;
        let scale = 2.0 / v.iter().map(|x| x * x).sum::<f64>();
        for column in k..unknowns {
            let dot: f64 = v.iter().zip(&rows[k..]).map(|(v, row)| v * row[column]).sum();
            for (v, row) in v.iter().zip(&mut rows[k..]) {
                row[column] -= scale * dot * v;
            }
        }
        let dot = v.iter().zip(&right[k..]).fold(DVec2::ZERO, |sum, (v, right)| sum + *right * *v);
        for (v, right) in v.iter().zip(&mut right[k..]) {
            *right -= dot * (scale * v);
        }
    }
    let mut solution = vec![DVec2::ZERO; unknowns];
    for k in (0..unknowns).rev() {
        let known = (k + 1..unknowns).fold(DVec2::ZERO, |sum, j| sum + solution[j] * rows[k][j]);
        let pivot = rows[k][k];
        solution[k] = if pivot == 0.0 { DVec2::ZERO } else { (right[k] - known) / pivot };
    }
    solution
}
