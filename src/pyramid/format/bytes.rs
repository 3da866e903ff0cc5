//! Reading and writing of little-endian numbers, for hachure's own file formats.

use crate::pyramid::surface::statistics::Voids;

/// The unread rest of a byte slice. Every read returns `None` beyond its end.
pub(crate) struct Cursor<'a> {
    pub bytes: &'a [u8],
}

impl<'a> Cursor<'a> {
    pub(crate) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.array().map(|[byte]| byte)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// Reads `count` numbers. Returns `None`, before allocating anything, if fewer are left.
    pub(crate) fn f32s(&mut self, count: usize) -> Option<Vec<f32>> {
        let bytes = self.take(count.checked_mul(4)?)?;
        Some(bytes.as_chunks::<4>().0.iter().map(|&number| f32::from_le_bytes(number)).collect())
    }

    pub(crate) fn voids(&mut self) -> Option<Voids> {
        Voids::from_code(self.u8()?)
    }
}

/// Appends numbers, little-endian.
pub(crate) fn put_f32s(bytes: &mut Vec<u8>, numbers: &[f32]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

impl Voids {
    /// Returns the two-bit code: 0 none, 1 some, 2 all.
    pub(in crate::pyramid) fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Some => 1,
            Self::All => 2,
        }
    }

    /// Inverts [`Voids::code`]; returns `None` for any other number.
    pub(in crate::pyramid) fn from_code(code: u8) -> Option<Self> {
        [Self::None, Self::Some, Self::All].get(usize::from(code)).copied()
    }
}

/// Returns the 64-bit FNV-1a hash, which detects accidental damage but not malice.
pub(crate) fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
