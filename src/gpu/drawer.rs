//! A render pass that counts its draws.

use std::ops::{Deref, DerefMut, Range};

/// A render pass of wgpu, whose draws are counted for the trace of a frame.
pub struct Drawer<'a> {
    pass: wgpu::RenderPass<'a>,
    draws: u32,
}

impl<'a> Drawer<'a> {
    /// Wraps a render pass in which nothing has been drawn.
    pub(super) fn new(pass: wgpu::RenderPass<'a>) -> Self {
        Self { pass, draws: 0 }
    }

    /// Limits what is drawn to the upper left part of the targets, of `size_px` pixels.
    pub(super) fn limit_to(&mut self, [width, height]: [u32; 2]) {
        self.pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        self.pass.set_scissor_rect(0, 0, width, height);
    }

    /// Returns how many draws have been recorded.
    pub(super) fn draws(&self) -> u32 {
        self.draws
    }

    /// Draws vertices. See [`wgpu::RenderPass::draw`].
    pub fn draw(&mut self, vertices: Range<u32>, instances: Range<u32>) {
        self.draws += 1;
        self.pass.draw(vertices, instances);
    }

    /// Draws vertices through an index buffer. See [`wgpu::RenderPass::draw_indexed`].
    pub fn draw_indexed(&mut self, indices: Range<u32>, base_vertex: i32, instances: Range<u32>) {
        self.draws += 1;
        self.pass.draw_indexed(indices, base_vertex, instances);
    }

    /// Draws the number of vertices that is stored in a buffer. See [`wgpu::RenderPass::draw_indirect`].
    pub fn draw_indirect(&mut self, arguments: &wgpu::Buffer, offset: u64) {
        self.draws += 1;
        self.pass.draw_indirect(arguments, offset);
    }

    /// Draws the number of indexed vertices that is stored in a buffer. See
    /// [`wgpu::RenderPass::draw_indexed_indirect`].
    pub fn draw_indexed_indirect(&mut self, arguments: &wgpu::Buffer, offset: u64) {
        self.draws += 1;
        self.pass.draw_indexed_indirect(arguments, offset);
    }
}

impl<'a> Deref for Drawer<'a> {
    type Target = wgpu::RenderPass<'a>;

    fn deref(&self) -> &Self::Target {
        &self.pass
    }
}

impl DerefMut for Drawer<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.pass
    }
}
