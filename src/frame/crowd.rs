//! Crowded lines of the eyes of a frame, thinned out.

use super::EyeMemory;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;
use crate::lines::crowd::thin::{self, Ranked};
use crate::lines::crowd::{Cap, Cells, bar, count, rank};
use crate::style::Lines;

/// The lines of an eye.
pub(super) struct AtEye<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub position: &'a Target,
    /// In and out.
    pub line: &'a mut Target,
    /// For its pictures.
    pub memory: &'a mut EyeMemory,
}

/// Thins the lines of every eye, if the style has a cap; two eyes that agree leave out the same ones.
pub(super) fn thin_out(cx: &mut Cx<'_>, lines: &Lines, agrees: bool, mut eyes: Vec<AtEye<'_>>) {
    let Some(cap) = Cap::of(lines.crowd, lines.crowd_px) else { return };
    let ranked: Vec<Ranked> = eyes.iter_mut().map(|eye| ranked(cx, eye, cap)).collect();
    for (number, (eye, own)) in eyes.iter_mut().zip(&ranked).enumerate() {
        let other = if agrees && ranked.len() == 2 { ranked.get(1 - number) } else { None };
        let thinned = eye.memory.targets.whole(cx.gpu(), &thin::UNCROWDED);
        thin::run(cx, own, other, &thinned);
        *eye.line = thinned;
    }
}

/// The lines of an eye with their ranks, and which are too many.
fn ranked(cx: &mut Cx<'_>, eye: &mut AtEye<'_>, cap: Cap) -> Ranked {
    let AtEye { view, position, line, memory } = eye;
    let targets = &mut memory.targets;
    let cells = Cells::new(cx, targets, cap);
    let rank = targets.whole(cx.gpu(), &rank::RANK);
    rank::run(cx, &rank::Inputs { view, cells: &cells, position, line, rank: &rank });
    count::run(cx, view, line, &rank, &cells);
    bar::run(cx, view, &cells);
    Ranked { view: (*view).clone(), position: (*position).clone(), line: line.clone(), rank, cells }
}
