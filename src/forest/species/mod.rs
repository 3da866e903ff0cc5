//! Generated species of trees: triangles grown from a few rules each.
//!
//! A tree is drawn by its contours and tones, so what matters is its outline: how far a pen would go in and out along a
//! spruce, an oak, a birch or a dead tree. A species first places its branches and clumps of leaves, with random
//! numbers that are the same on every machine; the level of detail then decides how many triangles each of them has. So
//! a tree keeps its outline from near to the middle distance. From far away a forest is its [`canopy`].

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

pub(crate) use self::canopy::canopy;

/// The material of a part of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Trunk and limbs.
    Bark,
    /// Leaves and needles.
    Leaf,
}

/// A corner of a triangle of a tree of height 1 whose foot is at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// Position; z is up, 0 to 1.
    pub at: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// Material of the surface.
    pub part: Part,
    /// Share of the wind's motion: 0 at the foot, 1 at the ends of twigs.
    pub sway: f64,
}

/// A generated species.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Grown {
    /// A spruce: a spire of drooping branches.
    Conifer,
    /// An oak or a beech: a wide crown of clumps on a forked trunk.
    Broadleaf,
    /// A birch: a slender tree with hanging clumps.
    Birch,
    /// A dead tree, its top broken off.
    Snag,
}

/// Level of detail of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Detail {
    /// Up to 1800 triangles.
    Near,
    /// Up to 300 triangles.
    Middle,
}

impl Detail {
    /// Returns the value for this level of detail.
    fn pick<T>(self, near: T, middle: T) -> T {
        match self {
            Self::Near => near,
            Self::Middle => middle,
        }
    }
}

impl Grown {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 4] = [Self::Conifer, Self::Broadleaf, Self::Birch, Self::Snag];

    /// Returns the species' name in scene files.
    #[cfg(test)]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Conifer => "conifer",
            Self::Broadleaf => "broadleaf",
            Self::Birch => "birch",
            Self::Snag => "snag",
        }
    }

    /// Grows the tree: three corners to a triangle, counter-clockwise from outside. Surfaces are closed, except for the
    /// feet of trunks, on the ground, and of limbs, inside of other parts.
    pub(crate) fn grow(self, detail: Detail) -> Vec<Corner> {
        match self {
            Self::Conifer => conifer::grow(detail),
            Self::Broadleaf => broadleaf::grow(detail),
            Self::Birch => birch::grow(detail),
            Self::Snag => snag::grow(detail),
        }
    }
}
