//! Tests which edges are visible, and the segments that are extracted from the image of edge ids, with synthetic edges
//! and depths.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use glam::DVec3;
use hachure::gpu::Gpu;
use hachure::gpu::buffer::Buffer;
use hachure::gpu::pools::Pools;
use hachure::gpu::readback::read_buffer;
use hachure::gpu::recorder::{Recorder, Submits};
use hachure::gpu::target::Target;
use hachure::gpu::timer::Timer;
use hachure::lines::strokes::id_image::{EDGE_DEPTH, EDGE_IDS};
use hachure::lines::strokes::{
    ChainRules, Lists, MAX_FRAME_SEGMENTS, Segment, StrokeCounts, chain, extract, id_image, image_px, outlines, points,
};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;
use hachure::surface::edges::{Edge, EdgeList, EdgeRules};
use hachure::surface::{DEPTH, DEPTH_FORMAT};

/// The near constant of `scene/view.rs`: reversed depth is this divided by the distance.
const NEAR_M: f32 = 1e-4;
const SKY: f32 = f32::INFINITY;

/// First column and row, column and row after the last, and the distance of the block.
type Block = ([u32; 4], f32);

/// A name, the blocks in front of the sky, and the visible parts of the edge.
type Case<'a> = (&'a str, Vec<Block>, &'a [[f32; 2]]);

struct Bench {
    gpu: Gpu,
    timer: Timer,
    size_px: [u32; 2],
    pools: Pools,
}

impl Bench {
    fn new(size_px: [u32; 2]) -> Option<Self> {
        let gpu = common::gpu()?;
        Some(Self { timer: Timer::new(&gpu).unwrap(), pools: Pools::new(&gpu), size_px, gpu })
    }

    /// Returns a view from the origin to the north; at a distance of 100 m a pixel is 1 m wide.
    fn view(&self) -> View {
        let [width, height] = self.size_px;
        let pose = Pose {
            position_m: DVec3::ZERO,
            forward: DVec3::Y,
            right: DVec3::X,
            up: DVec3::Z,
            fov_rad: 2.0 * (f64::from(height) / 200.0).atan(),
        };
        View::whole(pose, pose, [width, height])
    }

    /// Returns the point that a pixel shows at a distance.
    fn place_m(&self, px: [f32; 2], distance_m: f32) -> [f32; 3] {
        let [x, z] = [px[0] - self.size_px[0] as f32 / 2.0, self.size_px[1] as f32 / 2.0 - px[1]];
        [x * distance_m / 100.0, distance_m, z * distance_m / 100.0]
    }

    fn edge(&self, a_px: [f32; 2], b_px: [f32; 2], distance_m: f32) -> Edge {
        let [a_m, b_m] = [a_px, b_px].map(|px| self.place_m(px, distance_m));
        Edge { a_m, key: 77, b_m, kind: 0 }
    }

    /// Returns a depth picture: blocks in front of a background, later ones over earlier ones.
    fn depth(&self, background_m: f32, blocks: &[Block]) -> Target {
        let [width, height] = self.size_px;
        let target = Target::new(&self.gpu, &DEPTH, self.size_px);
        let module = self.gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(
                "@vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
                     return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
                 }"
                .into(),
            ),
        });
        let pipeline = self.gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            fragment: None,
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &target.view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(NEAR_M / background_m),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&pipeline);
            for ([left, top, right, bottom], distance_m) in blocks {
                let depth = NEAR_M / distance_m;
                pass.set_viewport(0.0, 0.0, width as f32, height as f32, depth, depth);
                pass.set_scissor_rect(*left, *top, right - left, bottom - top);
                pass.draw(0..3, 0..1);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        target
    }

    /// Returns the visible segments; with `chains`, also runs chaining and points.
    fn segments(
        &mut self,
        edges: &[Edge],
        depth: &Target,
        resolution: f32,
        chains: bool,
    ) -> (StrokeCounts, Vec<Segment>) {
        self.extracted(edges, depth, resolution, chains, None)
    }

    /// Returns the visible segments, and with `has_holes` also those of outlines without edges.
    fn extracted(
        &mut self,
        edges: &[Edge],
        depth: &Target,
        resolution: f32,
        chains: bool,
        has_holes: Option<bool>,
    ) -> (StrokeCounts, Vec<Segment>) {
        let mut style = Style::load("strokes").unwrap().strokes().cloned().unwrap();
        style.resolution = resolution;
        let view = self.view();
        let ids_px = image_px(self.size_px, resolution);
        let ids = &Target::new(&self.gpu, &EDGE_IDS, ids_px);
        let edge_depth = &Target::new(&self.gpu, &EDGE_DEPTH, ids_px);
        let mut recorder = Recorder::new(&self.gpu, &mut self.pools, &mut self.timer, Submits::default(), false);
        let view = &recorder.uniform("view", &view.uniform(DVec3::ZERO));
        let lists = &Lists::of(&mut recorder, &style, self.size_px, 1e4);
        lists.clear(&mut recorder);
        let list = &EdgeList::begin(&mut recorder, EdgeRules::default());
        recorder.write(&list.draw, &[2 * edges.len() as u32, 1, 0, 0]);
        self.gpu.queue.write_buffer(&list.edges.raw, 0, bytemuck::cast_slice(edges));
        id_image::run(&mut recorder, list, &id_image::Inputs { view, depth, ids, edge_depth });
        extract::run(&mut recorder, lists, list, view, ids);
        if let Some(has_holes) = has_holes {
            let surface_id = &hachure::surface::id::only_land(&mut recorder);
            outlines::run(&mut recorder, lists, list, &outlines::Inputs { view, depth, ids, surface_id, has_holes });
        }
        if chains {
            let (rules, capacity) = (ChainRules::default(), MAX_FRAME_SEGMENTS);
            let inputs = chain::Inputs { rules, capacity, segments: &lists.segments, counts: &lists.counts };
            let chains = chain::run(&mut recorder, &inputs);
            points::run(&mut recorder, lists, list, &chains);
        }
        recorder.submit().unwrap();
        self.gpu.wait();
        self.gpu.check().unwrap();
        let counts: StrokeCounts = read_buffer(&self.gpu, &lists.counts.raw, 1).unwrap()[0];
        let room = read_as_room(&lists.segments);
        let mut segments: Vec<Segment> =
            read_buffer(&self.gpu, &lists.segments.raw, (counts.segments as usize).min(room)).unwrap();
        segments.sort_by_key(|segment| (segment.edge, segment.a, segment.b));
        (counts, segments)
    }
}

fn read_as_room(segments: &Buffer) -> usize {
    segments.raw.size() as usize / size_of::<Segment>()
}

/// Returns the first and last columns, in pixels, of segments along a row.
fn columns(segments: &[Segment]) -> Vec<[f32; 2]> {
    segments.iter().map(|segment| [segment.a, segment.b].map(|end| end[0] as f32 / 16.0)).collect()
}

fn assert_columns(segments: &[Segment], wanted: &[[f32; 2]], max_px: f32) {
    let found = columns(segments);
    let is_near = |(found, wanted): (&[f32; 2], &[f32; 2])| (0..2).all(|i| (found[i] - wanted[i]).abs() <= max_px);
    assert!(
        found.len() == wanted.len() && found.iter().zip(wanted).all(is_near),
        "found {found:?}, expected {wanted:?}"
    );
}

const SIZE_PX: [u32; 2] = [320, 180];
/// Ends of an edge through the middle of row 90.
const A_PX: [f32; 2] = [40.3, 90.5];
const B_PX: [f32; 2] = [280.6, 90.5];

#[test]
fn an_edge_is_seen_where_nothing_nearer_lies_all_around_it() {
    let Some(mut bench) = Bench::new(SIZE_PX) else { return };
    let edge = [bench.edge(A_PX, B_PX, 100.0)];
    let whole = [[A_PX[0], B_PX[0]]];
    let all = [0, 0, 320, 180];
    let cases: [Case; 8] = [
        ("far behind it", vec![(all, 400.0)], &whole),
        // The surface to which the edge belongs: rounding must not hide it.
        ("its own distance", vec![(all, 100.0)], &whole),
        ("a thousandth nearer", vec![(all, 99.9)], &[]),
        ("half as far", vec![(all, 50.0)], &[]),
        ("half as far below, far above: a contour", vec![(all, 400.0), ([0, 91, 320, 180], 50.0)], &whole),
        (
            "a pixel higher: one of the four centres still sees past it",
            vec![(all, 400.0), ([0, 90, 320, 180], 50.0)],
            &whole,
        ),
        ("hidden by two pixels", vec![(all, 400.0), ([0, 88, 320, 180], 50.0)], &[]),
        // The data have a hole.
        ("nothing but sky", vec![], &[]),
    ];
    for (name, blocks, wanted) in cases {
        let depth = bench.depth(SKY, &blocks);
        let (counts, segments) = bench.segments(&edge, &depth, 1.0, false);
        println!("{name}: {:?}", columns(&segments));
        assert_eq!(counts.segments as usize, segments.len(), "{name}");
        assert_columns(&segments, wanted, 0.6);
    }
}

#[test]
fn an_edge_that_is_seen_in_two_places_gives_two_segments() {
    let Some(mut bench) = Bench::new(SIZE_PX) else { return };
    let edges = [bench.edge(A_PX, B_PX, 100.0), bench.edge([40.0, 30.5], [280.0, 30.5], 100.0)];
    let middle: Block = ([120, 80, 200, 100], 50.0);
    let halves = [[A_PX[0], 120.0], [200.0, B_PX[0]], [40.0, 280.0]];
    for (resolution, max_px) in [(1.0, 1.1), (0.5, 2.1), (0.25, 4.1)] {
        let depth = bench.depth(400.0, &[middle]);
        let (_, segments) = bench.segments(&edges, &depth, resolution, false);
        println!("at {resolution}: {:?}", columns(&segments));
        assert_columns(&segments, &halves, max_px);
        // Each segment has the number of its edge, and its distance.
        assert_eq!(segments.iter().map(|segment| segment.edge).collect::<Vec<_>>(), [0, 0, 1]);
        assert!(
            segments
                .iter()
                .all(|segment| segment.key == 77 && segment.depths_m.iter().all(|m| (m - 100.0).abs() < 0.1))
        );
        // Planted: without the block in front there is only one segment, and with a block elsewhere there are others.
        let depth = bench.depth(400.0, &[]);
        assert_columns(&bench.segments(&edges, &depth, resolution, false).1, &[[A_PX[0], B_PX[0]], halves[2]], max_px);
        let depth = bench.depth(400.0, &[([60, 80, 140, 100], 50.0)]);
        let found = columns(&bench.segments(&edges, &depth, resolution, false).1);
        assert!((found[0][1] - halves[0][1]).abs() > 20.0, "{found:?}");
    }
}

#[test]
fn a_line_that_crosses_does_not_cut() {
    let Some(mut bench) = Bench::new(SIZE_PX) else { return };
    // The crossing edge is nearer, so it is in front.
    let edges = [bench.edge(A_PX, B_PX, 100.0), bench.edge([150.5, 10.0], [160.5, 170.0], 90.0)];
    let depth = bench.depth(400.0, &[]);
    let (_, segments) = bench.segments(&edges, &depth, 1.0, false);
    assert_columns(&segments[..1], &[[A_PX[0], B_PX[0]]], 0.6);
    assert_eq!(segments.len(), 2);
    // Many adjacent crossing edges form a line of their own, which does cut.
    let bundle = (0..12).map(|i| bench.edge([150.5 + i as f32, 10.0], [150.5 + i as f32, 170.0], 90.0));
    let edges: Vec<Edge> = [edges[0]].into_iter().chain(bundle).collect();
    let (_, segments) = bench.segments(&edges, &depth, 1.0, false);
    assert_eq!(segments.iter().filter(|segment| segment.edge == 0).count(), 2);
}

#[test]
fn directions_and_sizes_make_no_difference() {
    let Some(mut bench) = Bench::new(SIZE_PX) else { return };
    let depth = bench.depth(400.0, &[]);
    let middle = [160.5_f32, 90.5];
    for step in 0..32 {
        let turn = step as f32 * std::f32::consts::TAU / 32.0 + 0.01;
        for length_px in [0.3_f32, 1.0, 2.5, 7.0, 60.0] {
            let half = [turn.cos() * length_px / 2.0, turn.sin() * length_px / 2.0];
            let (a, b) = ([middle[0] - half[0], middle[1] - half[1]], [middle[0] + half[0], middle[1] + half[1]]);
            let edge = [bench.edge(a, b, 100.0)];
            let (_, segments) = bench.segments(&edge, &depth, 1.0, false);
            // An edge shorter than a pixel may miss the centres of all pixels.
            assert!(
                segments.len() == 1 || (segments.is_empty() && length_px < 1.5),
                "{turn} {length_px}: {segments:?}"
            );
            for segment in segments {
                let apart =
                    |end: [i32; 2], px: [f32; 2]| (end[0] as f32 / 16.0 - px[0]).hypot(end[1] as f32 / 16.0 - px[1]);
                assert!(
                    apart(segment.a, a) < 1.1 && apart(segment.b, b) < 1.1,
                    "{turn} {length_px}: {segment:?} {a:?} {b:?}"
                );
            }
        }
    }
}

/// Run by hand on an idle machine: `cargo test --release --lib tests::visible_edges -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn time_grows_linearly_with_the_edges() {
    let Some(mut bench) = Bench::new([1920, 1080]) else { return };
    let depth = bench.depth(400.0, &[]);
    let mut number = 1_u32;
    let mut random = move || {
        number = number.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        f64::from(number >> 8) as f32 / 16_777_216.0
    };
    let mut times_ms = Vec::new();
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        let mut edge = || {
            let a = [random() * 1920.0, random() * 1080.0];
            let turn = random() * std::f32::consts::TAU;
            let length_px = 1.0 + 3.0 * random();
            bench.edge(a, [a[0] + turn.cos() * length_px, a[1] + turn.sin() * length_px], 100.0)
        };
        let edges: Vec<Edge> = (0..count).map(|_| edge()).collect();
        bench.segments(&edges, &depth, 1.0, true);
        let start = std::time::Instant::now();
        let runs = 3;
        let mut counts = StrokeCounts::default();
        for _ in 0..runs {
            counts = bench.segments(&edges, &depth, 1.0, true).0;
        }
        let ms = start.elapsed().as_secs_f64() * 1000.0 / f64::from(runs);
        println!("{count} edges: {} segments, {} chains, {ms:.0} ms", counts.segments, counts.chains);
        times_ms.push(ms);
    }
    // Every run includes a pass over the picture; beyond that, time must not grow faster than the number of edges.
    assert!(times_ms.windows(2).all(|pair| pair[1] < 15.0 * pair[0]), "{times_ms:?}");
}

/// The length of segments, in pixels.
fn length_px(segments: &[Segment]) -> f64 {
    let length = |own: &Segment| {
        [0, 1].map(|i| f64::from(own.b[i] - own.a[i]) / 16.0).into_iter().map(|d| d * d).sum::<f64>().sqrt()
    };
    segments.iter().map(length).sum()
}

/// Tests that an outline without an edge is found on the picture, and not where it has one.
#[test]
fn outlines_without_edges_are_found_on_the_picture() {
    let Some(mut bench) = Bench::new(SIZE_PX) else { return };
    let block = [100, 60, 200, 120];
    let mut outline =
        |background_m: f32, distance_m: f32, edges: &[[[f32; 2]; 2]], resolution: f32, has_holes: bool| {
            let depth = bench.depth(background_m, &[(block, distance_m)]);
            let edges: Vec<Edge> = edges.iter().map(|[a, b]| bench.edge(*a, *b, distance_m)).collect();
            let (counts, segments) = bench.extracted(&edges, &depth, resolution, false, Some(has_holes));
            assert_eq!(counts.segments as usize, segments.len());
            // Corners are cut by half a pixel.
            let (found, own): (Vec<Segment>, Vec<Segment>) = segments.iter().partition(|own| own.edge == u32::MAX);
            assert_eq!(own.len(), edges.len());
            for own in &found {
                let [x, y] = [0, 1].map(|i| f32::from(own.a[i] as i16) / 16.0);
                let apart = [(x - 100.0).abs(), (x - 200.0).abs(), (y - 60.0).abs(), (y - 120.0).abs()];
                assert!(apart.iter().any(|apart| *apart <= 0.5), "{x}, {y}");
                assert!(own.depths_m.iter().all(|depth_m| (depth_m / distance_m - 1.0).abs() < 1e-3), "{own:?}");
            }
            length_px(&found)
        };
    let whole_px = 2.0 * (100.0 + 60.0);
    for (background_m, resolution) in [(SKY, 1.0), (SKY, 0.5), (100.0, 1.0)] {
        let found_px = outline(background_m, 50.0, &[], resolution, false);
        assert!((found_px - whole_px).abs() < 4.0, "{background_m}, {resolution}: {found_px} px");
    }
    // An edge along the upper side leaves the other three.
    let found_px = outline(SKY, 50.0, &[[[100.0, 60.2], [200.0, 60.2]]], 1.0, false);
    assert!((found_px - (whole_px - 100.0)).abs() < 10.0, "{found_px} px");
    // Planted: a step of 2 % is no outline, and neither is a hole through which one sees the sky below the horizon: the
    // lower half of the block is there.
    assert_eq!(outline(100.0, 98.0, &[], 1.0, false), 0.0);
    let above_px = outline(SKY, 50.0, &[], 1.0, true);
    assert!((above_px - (100.0 + 2.0 * 30.0)).abs() < 4.0, "{above_px} px");
}
