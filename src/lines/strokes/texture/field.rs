//! Periodic noise: white noise, blurred by boxes that wrap around.
//!
//! Three boxes approximate a Gaussian to a few per cent. Boxes of any length have a fraction at both ends (Gwosdek and
//! others 2011). Only sums, products, quotients and roots are used, which IEEE 754 rounds in one way: every machine
//! grows the same tile.

/// Numbers along × across the stroke that repeat in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    size_px: [usize; 2],
    values: Vec<f32>,
}

/// PCG hash in two dimensions (Jarzynski and Olano 2020), as in `shaders/shared/pcg.wgsl`.
pub fn hash(mut v: [u32; 2]) -> [u32; 2] {
    v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for _ in 0..2 {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(1_664_525));
        v[1] = v[1].wrapping_add(v[0].wrapping_mul(1_664_525));
        v = v.map(|x| x ^ (x >> 16));
    }
    v
}

/// Returns white noise in −0.5 … 0.5.
fn white(place: usize, seed: u32, stream: u32) -> f32 {
    let [x, y] = hash([place as u32, seed.wrapping_add(stream.wrapping_mul(0x85eb_ca6b))]);
    ((x ^ y) >> 8) as f32 / 16_777_216.0 - 0.5
}

/// Blurs with a box of `length` around each value, three times.
fn blur(values: &mut [f32], length: f32) {
    let count = values.len();
    let length = length.min(count as f32 / 3.0);
    let half = 0.5 * (length - 1.0);
    if half <= 0.0 {
        return;
    }
    let (whole, rest) = (half as usize, half - (half as usize) as f32);
    let reach = whole + 1;
    // Prefix sums, which begin `reach` before the first value and wrap around.
    let mut before = Vec::with_capacity(count + 2 * reach + 1);
    for _ in 0..3 {
        let around = (0..count + 2 * reach).map(|i| values[(i + count - reach % count) % count]);
        before.clear();
        before.push(0.0_f64);
        before.extend(around.scan(0.0, |sum, value| {
            *sum += f64::from(value);
            Some(*sum)
        }));
        for (i, value) in values.iter_mut().enumerate() {
            let inner = before[i + reach + whole + 1] - before[i + reach - whole];
            let outer = before[i + 2 * reach + 1] - before[i] - inner;
            *value = ((inner + f64::from(rest) * outer) / f64::from(length)) as f32;
        }
    }
}

impl Field {
    /// Returns a field of zeros.
    pub fn zero(size_px: [usize; 2]) -> Self {
        Self { size_px, values: vec![0.0; size_px[0] * size_px[1]] }
    }

    /// Returns marks of about `mark_px` pixels along and across, with mean 0 and variance 1; a size of 1 is white
    /// noise.
    pub fn noise(size_px: [usize; 2], mark_px: [f32; 2], seed: u32, stream: u32) -> Self {
        let [along, across] = size_px;
        let mut values: Vec<f32> = (0..along * across).map(|place| white(place, seed, stream)).collect();
        values.chunks_exact_mut(along).for_each(|row| blur(row, mark_px[0]));
        let mut column = vec![0.0; across];
        for x in 0..along {
            (0..across).for_each(|y| column[y] = values[y * along + x]);
            blur(&mut column, mark_px[1]);
            (0..across).for_each(|y| values[y * along + x] = column[y]);
        }
        let mut field = Self { size_px, values };
        field.normalise();
        field
    }

    fn normalise(&mut self) {
        let count = self.values.len() as f64;
        let mean = self.values.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
        let variance = self.values.iter().map(|value| (f64::from(*value) - mean) * (f64::from(*value) - mean));
        let deviation = (variance.sum::<f64>() / count).sqrt().max(1e-12);
        self.values.iter_mut().for_each(|value| *value = ((f64::from(*value) - mean) / deviation) as f32);
    }

    /// Moves each column across by up to about `wander_px`; the shift varies slowly along the stroke.
    pub fn swerved(self, wander_px: f32, seed: u32, stream: u32) -> Self {
        if wander_px <= 0.0 {
            return self;
        }
        let [along, across] = self.size_px;
        // The period of a swerve is an eighth of the tile.
        let way = Self::noise([along, 1], [along as f32 / 8.0, 1.0], seed, stream + 64);
        let mut moved = Self::zero(self.size_px);
        for (place, value) in moved.values.iter_mut().enumerate() {
            let (x, y) = (place % along, place / along);
            let from = (y as f32 + wander_px * 0.5 * way.values[x]).rem_euclid(across as f32);
            let (low, part) = (from as usize % across, from - from.floor());
            let [a, b] = [low, (low + 1) % across].map(|row| self.values[row * along + x]);
            *value = a + (b - a) * part;
        }
        moved
    }

    /// Adds a weighted field of the same size.
    pub fn add(&mut self, other: &Self, weight: f32) {
        self.values.iter_mut().zip(&other.values).for_each(|(value, more)| *value += weight * more);
    }

    /// Applies a function to each value.
    pub fn map(mut self, change: impl Fn(f32) -> f32) -> Self {
        self.values.iter_mut().for_each(|value| *value = change(*value));
        self
    }

    /// Returns each value's rank, 0 to 1: any distribution becomes uniform.
    pub fn ranks(&self) -> Self {
        let mut order: Vec<u32> = (0..self.values.len() as u32).collect();
        order.sort_by(|a, b| self.values[*a as usize].total_cmp(&self.values[*b as usize]));
        let mut ranks = Self::zero(self.size_px);
        for (rank, place) in order.into_iter().enumerate() {
            ranks.values[place as usize] = (rank as f32 + 0.5) / self.values.len() as f32;
        }
        ranks
    }

    /// Returns a field of given values, in rows along the stroke.
    ///
    /// # Panics
    /// If the number of values is not that of the size.
    pub(super) fn of(size_px: [usize; 2], values: Vec<f32>) -> Self {
        assert_eq!(values.len(), size_px[0] * size_px[1]);
        Self { size_px, values }
    }

    /// Returns averages of 2 × 2 values; both sides must be even.
    pub fn halved(&self) -> Self {
        let [along, across] = self.size_px;
        let mut half = Self::zero([along / 2, across / 2]);
        for (place, value) in half.values.iter_mut().enumerate() {
            let first = place / (along / 2) * 2 * along + place % (along / 2) * 2;
            let at = |step: usize| self.values[first + step];
            *value = 0.25 * (at(0) + at(1) + at(along) + at(along + 1));
        }
        half
    }

    /// Returns the size along and across the stroke.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Returns the values, in rows along the stroke.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}
