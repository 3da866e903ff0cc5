//! Reads a few numbers back from the GPU without waiting: they arrive some frames later. Code that may wait uses
//! [`readback`](super::readback).

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::Gpu;

/// Largest number of requests in flight; further requests are dropped.
const MAX_OPEN: usize = 8;

type Mapped = Result<(), wgpu::BufferAsyncError>;

/// A queue of asynchronous readbacks.
pub(crate) struct AsyncReadback {
    /// Unmapped staging buffers.
    spare: Vec<wgpu::Buffer>,
    /// Requests in flight, oldest first.
    open: VecDeque<(wgpu::Buffer, Receiver<Mapped>)>,
    bytes: u64,
}

impl AsyncReadback {
    /// Creates a queue for answers of `bytes` bytes, which must be a multiple of 4.
    pub(crate) fn new(bytes: u64) -> Self {
        Self { spare: Vec::new(), open: VecDeque::new(), bytes }
    }

    /// Requests the first bytes of some buffers, as they are after everything submitted so far. All parts together make
    /// one answer. Returns `false` if too many requests are in flight.
    pub(crate) fn request(&mut self, gpu: &Gpu, parts: &[(&wgpu::Buffer, u64)]) -> bool {
        if self.open.len() == MAX_OPEN {
            return false;
        }
        let buffer = self.spare.pop().unwrap_or_else(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("async readback"),
                size: self.bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("async readback") });
        let mut at = 0;
        for (part, bytes) in parts {
            encoder.copy_buffer_to_buffer(part, 0, &buffer, at, *bytes);
            at += bytes;
        }
        gpu.queue.submit([encoder.finish()]);
        let (sender, receiver) = channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // The receiver is gone if the request was dropped.
            let _ = sender.send(mapped);
        });
        self.open.push_back((buffer, receiver));
        true
    }

    /// Returns the oldest answer that has arrived and has not been taken. Answers arrive while the device is polled.
    pub(crate) fn take(&mut self) -> Option<Vec<u8>> {
        let mapped = match self.open.front()?.1.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(mapped) => mapped.is_ok(),
            Err(TryRecvError::Disconnected) => false,
        };
        let (buffer, _) = self.open.pop_front()?;
        if !mapped {
            // The device is lost; whatever draws next reports that.
            return None;
        }
        let bytes = buffer.get_mapped_range(..).ok().map(|bytes| bytes.to_vec());
        buffer.unmap();
        self.spare.push(buffer);
        bytes
    }

    /// Drops all requests in flight.
    pub(crate) fn forget(&mut self) {
        self.open.clear();
    }
}
