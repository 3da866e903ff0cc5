//! Prefix sums on the GPU equal those of a loop.

use hachure::gpu::buffer::{Buffer, BufferKind};
use hachure::gpu::pools::Pools;
use hachure::gpu::readback::read_buffer;
use hachure::gpu::recorder::{Recorder, Submits};
use hachure::gpu::scan::{self, Count, MAX_VALUES};
use hachure::gpu::timer::Timer;

use crate::tests::common::{self, random};

#[test]
fn prefix_sums() {
    let Some(gpu) = common::gpu() else { return };
    let mut timer = Timer::new(&gpu).unwrap();
    let mut pools = Pools::new(&gpu);
    let [values, numbers] =
        [(); 2].map(|()| Buffer::new(&gpu, &BufferKind::storage("test"), 4 * (u64::from(MAX_VALUES) + 1)));
    let sizes = [
        (0_u32, 10),
        (1, 10),
        (255, 1000),
        (256, 1000),
        (2047, 3000),
        (2048, 3000),
        (2049, 3000),
        (2049, 100_000),
        (5000, 3000),
        (100_001, u32::MAX),
        (MAX_VALUES, u32::MAX),
        (u32::MAX, u32::MAX),
    ];
    // The CPU or the GPU knows the number of values.
    for (is_known, (count, capacity)) in
        [false, true].into_iter().flat_map(|is_known| sizes.map(|size| (is_known, size)))
    {
        let mut expected: Vec<u32> = (0..=MAX_VALUES as i64).map(|i| (random(i, 4) * 4e9) as u32).collect();
        gpu.queue.write_buffer(&values.raw, 0, bytemuck::cast_slice(&expected));
        gpu.queue.write_buffer(&numbers.raw, 0, bytemuck::cast_slice(&[7, 7, 7, count]));
        let mut recorder = Recorder::new(&gpu, &mut pools, &mut timer, Submits::default(), false);
        let counted = Count::Counted { numbers: &numbers, index: 3, capacity };
        scan::run(&mut recorder, if is_known { Count::Of(count.min(capacity)) } else { counted }, &values);
        recorder.submit().unwrap();
        let mut sum = 0_u32;
        let used = count.min(capacity).min(MAX_VALUES) as usize;
        for value in &mut expected[..=used] {
            let own = std::mem::replace(value, sum);
            sum = sum.wrapping_add(own);
        }
        let found = read_buffer::<u32>(&gpu, &values.raw, MAX_VALUES as usize + 1).unwrap();
        gpu.check().unwrap();
        assert!(found == expected, "the prefix sums of {count} values with capacity {capacity} are wrong");
    }
}
