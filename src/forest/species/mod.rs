//! Species of trees, grown as triangles from a few rules each.
//!
//! A tree is drawn by its contours and by its tones, so what matters is its outline: how far a pen would go in and out
//! along a spruce, an oak, a birch or a dead tree. A species first says where its branches and clumps of leaves are, by
//! numbers that are the same on every machine; then a detail says of how many triangles they are. So a tree keeps its
//! outline when it goes from near to the middle distance. From far away a forest is its [`canopy`].

mod birch;
mod blob;
mod broadleaf;
mod canopy;
mod conifer;
mod patch;
mod random;
#[cfg(test)]
mod silhouette;
mod snag;

use glam::DVec3;

pub use self::canopy::canopy;

/// What a part of a tree is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Trunk and limbs.
    Bark,
    /// Leaves and needles.
    Leaf,
}

/// A corner of a triangle of a tree that is 1 tall and stands at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where it is.
    pub at: DVec3,
    /// Of the surface there; of length 1.
    pub normal: DVec3,
    /// What the surface is.
    pub part: Part,
    /// How far wind moves it: 0 at the foot, 1 at the ends of twigs.
    pub sway: f64,
}

/// How a tree grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grown {
    /// A spruce: a spire of drooping branches.
    Conifer,
    /// An oak or a beech: a wide crown of clumps on a forked trunk.
    Broadleaf,
    /// Slender, with hanging clumps.
    Birch,
    /// A dead tree, its top broken off.
    Snag,
}

/// Of how many triangles a tree is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Up to 1800.
    Near,
    /// Up to 300.
    Middle,
}

impl Detail {
    /// One of two.
    fn pick<T>(self, near: T, middle: T) -> T {
        match self {
            Self::Near => near,
            Self::Middle => middle,
        }
    }
}

impl Grown {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Conifer, Self::Broadleaf, Self::Birch, Self::Snag];

    /// What scenes call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Conifer => "conifer",
            Self::Broadleaf => "broadleaf",
            Self::Birch => "birch",
            Self::Snag => "snag",
        }
    }

    /// Three corners to a triangle, counterclockwise from outside. Surfaces are closed, but for the feet of trunks, on
    /// the ground, and of limbs, inside others.
    pub fn grow(self, detail: Detail) -> Vec<Corner> {
        match self {
            Self::Conifer => conifer::grow(detail),
            Self::Broadleaf => broadleaf::grow(detail),
            Self::Birch => birch::grow(detail),
            Self::Snag => snag::grow(detail),
        }
    }
}
