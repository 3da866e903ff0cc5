//! A few numbers from the GPU while frames go on: nobody waits, they come some frames later. Where one can wait, there
//! is [`readback`](super::readback).

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::Gpu;

/// So many questions are open at most; more are not asked.
const MOST_OPEN: usize = 8;

type Mapped = Result<(), wgpu::BufferAsyncError>;

/// Questions to the GPU, and the answers that have come.
pub struct AsyncReadback {
    spare: Vec<wgpu::Buffer>,
    /// The oldest first.
    open: VecDeque<(wgpu::Buffer, Receiver<Mapped>)>,
    bytes: u64,
}

impl AsyncReadback {
    /// For answers of so many bytes, a multiple of 4.
    pub fn new(bytes: u64) -> Self {
        Self { spare: Vec::new(), open: VecDeque::new(), bytes }
    }

    /// Asks for the first bytes of some buffers, as they are after what was submitted so far. Together they are an
    /// answer.
    pub fn ask(&mut self, gpu: &Gpu, parts: &[(&wgpu::Buffer, u64)]) {
        if self.open.len() == MOST_OPEN {
            return;
        }
        let buffer = self.spare.pop().unwrap_or_else(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("later"),
                size: self.bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("later") });
        let mut at = 0;
        for (part, bytes) in parts {
            encoder.copy_buffer_to_buffer(part, 0, &buffer, at, *bytes);
            at += bytes;
        }
        gpu.queue.submit([encoder.finish()]);
        let (sender, receiver) = channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // Nobody listens any more when the questions were forgotten.
            let _ = sender.send(mapped);
        });
        self.open.push_back((buffer, receiver));
    }

    /// The oldest answer that has come and was not taken. They come while the device is polled.
    pub fn take(&mut self) -> Option<Vec<u8>> {
        let mapped = match self.open.front()?.1.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(mapped) => mapped.is_ok(),
            Err(TryRecvError::Disconnected) => false,
        };
        let (buffer, _) = self.open.pop_front()?;
        if !mapped {
            // The device is lost, and says so to whoever draws.
            return None;
        }
        let bytes = buffer.get_mapped_range(..).ok().map(|bytes| bytes.to_vec());
        buffer.unmap();
        self.spare.push(buffer);
        bytes
    }

    /// Drops all questions.
    pub fn forget(&mut self) {
        self.open.clear();
    }
}
