//! Chains of line pieces: the GPU's are the twin's, to the bit, and they are what chains must be.
//!
//! 10,000 inputs: 9,400 small scenes (none to some 40 pieces; 21 kinds) that lie 1024 px apart in planes of 470, and 600
//! that have the GPU to themselves. Each scene of a plane is compared with the twin of that scene alone: chains stand in
//! the order of their first pieces, so a scene's chains are a stretch of the plane's.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod common;

use std::collections::BTreeSet;
use std::time::Instant;

use common::random;
use hachure::gpu::Gpu;
use hachure::gpu::readback::read_buffer;
use hachure::gpu::timer::Timer;
use hachure::lines::strokes::chain::{ChainPass, MAX_PIECES};
use hachure::lines::strokes::scan::{MAX_VALUES, ScanPass, ScanSize};
use hachure::lines::strokes::twin::{self, Chained};
use hachure::lines::strokes::{Chain, ChainRules, Piece, Place, StrokeCounts};

/// Random whole numbers, the same in each run.
struct Dice {
    seed: i64,
    thrown: i64,
}

impl Dice {
    fn new(seed: i64) -> Self {
        Self { seed, thrown: 0 }
    }

    /// In begin..end.
    fn range(&mut self, begin: i32, end: i32) -> i32 {
        self.thrown += 1;
        begin + (random(self.seed, self.thrown) * f64::from(end - begin)) as i32
    }

    fn point(&mut self, side: i32) -> [i32; 2] {
        [self.range(0, side), self.range(0, side)]
    }
}

fn piece(a: [i32; 2], b: [i32; 2], key: u32) -> Piece {
    Piece { a, b, depths_m: [1.0, 2.0], edge: 0, key }
}

fn moved(piece: &Piece, by: [i32; 2]) -> Piece {
    let to = |p: [i32; 2]| [p[0] + by[0], p[1] + by[1]];
    Piece { a: to(piece.a), b: to(piece.b), ..*piece }
}

/// A polygon around a middle, its pieces in mixed directions.
fn ring(dice: &mut Dice, middle: [i32; 2], radius: f64, count: i32) -> Vec<Piece> {
    let corner = |i: i32| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        [middle[0] + (radius * angle.cos()) as i32, middle[1] + (radius * angle.sin()) as i32]
    };
    (0..count)
        .map(|i| {
            let (a, b) = (corner(i), corner(i + 1));
            let key = dice.range(0, 30) as u32;
            if dice.range(0, 2) == 0 { piece(a, b, key) } else { piece(b, a, key) }
        })
        .collect()
}

/// A line of pieces with small gaps and turns, half of them turned around.
fn wander(dice: &mut Dice, count: i32, step: i32, gap: i32) -> Vec<Piece> {
    let mut at = [0, 0];
    let mut angle = f64::from(dice.range(0, 628)) / 100.0;
    (0..count)
        .map(|_| {
            angle += f64::from(dice.range(-60, 61)) / 100.0;
            let end = [at[0] + (f64::from(step) * angle.cos()) as i32, at[1] + (f64::from(step) * angle.sin()) as i32];
            let key = dice.range(0, 20) as u32;
            let made = if dice.range(0, 2) == 0 { piece(at, end, key) } else { piece(end, at, key) };
            at = [end[0] + dice.range(-gap, gap + 1), end[1] + dice.range(-gap, gap + 1)];
            made
        })
        .collect()
}

fn shuffled(dice: &mut Dice, mut pieces: Vec<Piece>) -> Vec<Piece> {
    for i in (1..pieces.len()).rev() {
        pieces.swap(i, dice.range(0, i as i32 + 1) as usize);
    }
    pieces
}

const KINDS: i64 = 21;

/// A small scene, of one of several kinds, within some 500 px.
fn scene(number: i64) -> Vec<Piece> {
    let mut dice = Dice::new(number);
    let dice = &mut dice;
    let count = dice.range(2, 40);
    let key = |dice: &mut Dice| dice.range(0, 5) as u32;
    let pieces: Vec<Piece> = match number % KINDS {
        0 => Vec::new(),
        1 => vec![piece(dice.point(500), dice.point(500), 7)],
        // All in one pixel, and in a few.
        2 => (0..count).map(|_| piece(dice.point(16), dice.point(16), key(dice))).collect(),
        3 => (0..count).map(|_| piece(dice.point(64), dice.point(64), key(dice))).collect(),
        4 => (0..count).map(|_| piece(dice.point(400), dice.point(400), key(dice))).collect(),
        // Short pieces, dense: many candidates.
        5 | 6 => (0..count)
            .map(|_| {
                let a = dice.point(300);
                piece(a, [a[0] + dice.range(-40, 41), a[1] + dice.range(-40, 41)], key(dice))
            })
            .collect(),
        // A grid: ties everywhere.
        7 => (0..count)
            .flat_map(|i| {
                let a = [i % 6 * 32, i / 6 * 32];
                [piece(a, [a[0] + 32, a[1]], 1), piece([a[0], a[1] + 32], a, 1)]
            })
            .collect(),
        // A star, and one whose rays do not meet.
        8 | 9 => (0..count)
            .map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
                let at = |r: f64| [(r * angle.cos()) as i32, (r * angle.sin()) as i32];
                let near = if number % KINDS == 8 { 0.0 } else { 20.0 };
                if dice.range(0, 2) == 0 { piece(at(near), at(300.0), 3) } else { piece(at(300.0), at(near), 3) }
            })
            .collect(),
        // Loops: one, two, one inside another.
        10 => ring(dice, [500, 500], 400.0, count.max(8)),
        11 => [ring(dice, [0, 0], 200.0, 12), ring(dice, [900, 0], 220.0, 9)].concat(),
        12 => [ring(dice, [0, 0], 200.0, 12), ring(dice, [0, 0], 230.0, 15)].concat(),
        // Two pieces, bent towards each other: a loop where the angle is wide.
        13 => {
            let gap = dice.range(0, 40);
            vec![piece([0, 0], [gap, 10], key(dice)), piece([gap, 10 + dice.range(0, 9)], [0, dice.range(0, 9)], 2)]
        }
        // Zigzag: sharp turns are not joined, blunt ones are.
        14 => {
            let height = dice.range(5, 60);
            let corner = |i: i32| [i * 40, (i % 2) * height];
            (0..count).map(|i| piece(corner(i), corner(i + 1), i as u32 / 3)).collect()
        }
        15 | 16 => wander(dice, count, 30, 5),
        17 => wander(dice, count, 20, 40),
        // Zero lengths among others.
        18 => {
            let mut pieces = wander(dice, count, 40, 10);
            for piece in pieces.iter_mut().step_by(3) {
                piece.b = piece.a;
            }
            pieces
        }
        // Duplicates, also reversed.
        19 => {
            let pieces = wander(dice, count / 2 + 1, 40, 10);
            let copies = pieces.iter().map(|p| if p.key % 2 == 0 { *p } else { piece(p.b, p.a, p.key) });
            pieces.iter().copied().chain(copies.collect::<Vec<_>>()).collect()
        }
        // One point, many times.
        _ => (0..count).map(|_| piece([5, 5], [5, 5], key(dice))).collect(),
    };
    if dice.range(0, 2) == 0 { pieces } else { shuffled(dice, pieces) }
}

/// A GPU and what chaining needs there.
struct Bench {
    gpu: Gpu,
    timer: Timer,
    pass: ChainPass,
    pieces: wgpu::Buffer,
    counts: wgpu::Buffer,
}

impl Bench {
    fn new(capacity: u32, rules: ChainRules) -> Option<Self> {
        let gpu = common::gpu()?;
        let pass = ChainPass::new(&gpu, capacity, rules).unwrap();
        let buffer = |size| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            gpu.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let (pieces, counts) = (buffer(pass.pieces_bytes()), buffer(size_of::<StrokeCounts>() as u64));
        Some(Self { timer: Timer::new(&gpu).unwrap(), gpu, pass, pieces, counts })
    }

    fn upload(&self, pieces: &[Piece], said: u32) {
        self.gpu.queue.write_buffer(&self.pieces, 0, bytemuck::cast_slice(pieces));
        // What a frame before left must not matter.
        let counts = StrokeCounts { pieces: said, chains: 77, points: 5, ..StrokeCounts::default() };
        self.gpu.queue.write_buffer(&self.counts, 0, bytemuck::bytes_of(&counts));
    }

    fn run(&mut self) {
        let mut recorder = self.timer.record(&self.gpu);
        self.pass.run(&self.gpu, &mut recorder, &self.pieces, &self.counts);
        recorder.submit();
        self.gpu.wait();
    }

    fn chain(&mut self, pieces: &[Piece]) -> Chained {
        self.upload(pieces, pieces.len() as u32);
        self.run();
        self.read(pieces.len())
    }

    fn read(&self, pieces: usize) -> Chained {
        self.gpu.check().unwrap();
        let counts = read_buffer::<StrokeCounts>(&self.gpu, &self.counts, 1).unwrap()[0];
        assert_eq!(counts.points, 5, "only the number of chains is ours");
        Chained {
            ordered: read_buffer(&self.gpu, self.pass.ordered(), pieces).unwrap(),
            chains: read_buffer(&self.gpu, self.pass.chains(), counts.chains as usize).unwrap(),
            places: read_buffer(&self.gpu, self.pass.places(), pieces).unwrap(),
        }
    }
}

/// The chains of pieces first..first + count, as if they were alone.
fn part(all: &Chained, first: usize, count: usize) -> Chained {
    let of_place = |place: usize| all.ordered[place] as usize / 2;
    let begin = all.chains.partition_point(|chain| of_place(chain.first as usize) < first);
    let end = all.chains.partition_point(|chain| of_place(chain.first as usize) < first + count);
    let places = first..first + count;
    Chained {
        ordered: all.ordered[places.clone()].iter().map(|state| state.wrapping_sub(2 * first as u32)).collect(),
        chains: all.chains[begin..end]
            .iter()
            .map(|chain| Chain { first: chain.first.wrapping_sub(first as u32), ..*chain })
            .collect(),
        places: all.places[places]
            .iter()
            .map(|place| Place { chain: place.chain.wrapping_sub(begin as u32), ..*place })
            .collect(),
    }
}

/// What chains must be, whatever the twin says.
fn assert_chains(pieces: &[Piece], chained: &Chained, rules: &ChainRules) {
    let mut seen = vec![false; pieces.len()];
    for state in &chained.ordered {
        assert!(!std::mem::replace(&mut seen[*state as usize / 2], true), "piece {} twice", state / 2);
    }
    assert_eq!(chained.ordered.len(), pieces.len());
    let end = |end: u32| {
        let p = &pieces[end as usize / 2];
        if end.is_multiple_of(2) { p.a } else { p.b }
    };
    let vector = |a: [i32; 2], b: [i32; 2]| [f64::from(b[0]) - f64::from(a[0]), f64::from(b[1]) - f64::from(a[1])];
    let length = |v: [f64; 2]| v[0].hypot(v[1]);
    let mut joined = BTreeSet::new();
    let mut join = |left: u32, entered: u32| {
        assert!(joined.insert(left) && joined.insert(entered), "an end is joined twice");
        let delta = vector(end(left), end(entered));
        assert!(length(delta) <= f64::from(rules.reach_units), "{left} to {entered} is too far");
        let (u, v) = (vector(end(left ^ 1), end(left)), vector(end(entered), end(entered ^ 1)));
        if length(u) > 0.0 && length(v) > 0.0 {
            let widest = (f64::from(rules.least_cos_squared) / 4096.0).sqrt().acos();
            let angle = ((u[0] * v[0] + u[1] * v[1]) / length(u) / length(v)).clamp(-1.0, 1.0).acos();
            // Directions are rounded to 1/64 at worst, one end each.
            assert!(angle <= widest + 0.04, "{left} to {entered} turns by {angle}");
        }
        length(delta)
    };
    let mut place = 0;
    let mut previous_head = None;
    for (number, chain) in chained.chains.iter().enumerate() {
        assert_eq!(chain.first as usize, place);
        assert!(chain.count > 0);
        let states = &chained.ordered[place..place + chain.count as usize];
        let head = states[0] / 2;
        assert!(previous_head < Some(head), "chains stand in the order of their heads");
        previous_head = Some(head);
        assert_eq!(chain.key, pieces[head as usize].key);
        let mut sum = 0.0;
        for (i, state) in states.iter().enumerate() {
            if i > 0 {
                sum += join(states[i - 1] ^ 1, *state);
            }
            let begin = chained.places[place + i];
            assert_eq!(begin.chain as usize, number);
            // Two lengths are rounded down for each piece, by a unit or by 2^-14.
            assert!((sum - f64::from(begin.begin_units)).abs() <= 2.0 * i as f64 + sum / 16000.0, "{sum} {begin:?}");
            sum += length(vector(end(*state), end(state ^ 1)));
        }
        if chain.is_closed == 1 {
            sum += join(states[states.len() - 1] ^ 1, states[0]);
        }
        assert!((sum - f64::from(chain.length_units)).abs() <= 2.0 * states.len() as f64 + sum / 16000.0);
        place += chain.count as usize;
    }
    assert_eq!(place, pieces.len());
}

#[test]
fn ten_thousand_inputs_are_chained_as_by_the_twin() {
    const PLANES: i64 = 20;
    const SCENES: i64 = 470;
    let mut rules = ChainRules::default();
    let Some(mut bench) = Bench::new(1 << 15, rules) else { return };
    let mut compared = 0;
    let (mut closed, mut longest) = (0, 0);
    for plane in 0..PLANES {
        // Most with the usual rules, some with others.
        rules = match plane {
            17 => ChainRules::new(1.0, 0.5),
            18 => ChainRules::new(20.0, 1.5),
            19 => ChainRules { reach_units: 1023, least_cos_squared: 0 },
            _ => ChainRules::default(),
        };
        bench.pass.set_rules(&bench.gpu, rules);
        let scenes: Vec<Vec<Piece>> = (0..SCENES).map(|i| scene(plane * SCENES + i)).collect();
        let all: Vec<Piece> = (0..SCENES as i32)
            .zip(&scenes)
            .flat_map(|(i, scene)| {
                let by = [(i % 25 - 12) * 16384 + 5, (i / 25 - 9) * 16384 - 11];
                scene.iter().map(move |piece| moved(piece, by))
            })
            .collect();
        let chained = bench.chain(&all);
        let mut first = 0;
        for (i, scene) in scenes.iter().enumerate() {
            let expected = twin::chain(scene, &rules);
            assert_eq!(part(&chained, first, scene.len()), expected, "plane {plane}, scene {i}");
            assert_chains(scene, &expected, &rules);
            closed += expected.chains.iter().filter(|chain| chain.is_closed == 1).count();
            longest = expected.chains.iter().map(|chain| chain.count).max().unwrap_or(0).max(longest);
            first += scene.len();
            compared += 1;
        }
    }
    assert!(closed > 1000 && longest > 20, "{closed} loops, at most {longest} pieces: the scenes try nothing");
    rules = ChainRules::default();
    bench.pass.set_rules(&bench.gpu, rules);
    for number in 0..600 {
        let pieces = alone(number);
        let expected = twin::chain(&pieces, &rules);
        assert_eq!(bench.chain(&pieces), expected, "input {number}");
        compared += 1;
    }
    assert_eq!(compared, 10_000);
}

/// Inputs that have the GPU to themselves.
fn alone(number: i64) -> Vec<Piece> {
    let dice = &mut Dice::new(1_000_000 + number);
    let count = dice.range(1, 400);
    match number % 8 {
        0 => scene(number / 8),
        1 => (0..count).map(|_| piece(dice.point(16), dice.point(16), dice.range(0, 9) as u32)).collect(),
        2 => {
            // Far outside, on all sides, and beyond what is allowed.
            let far = |dice: &mut Dice| dice.point(1 << 23).map(|units| units - (1 << 22));
            (0..count).map(|_| piece(far(dice), far(dice), 1)).collect()
        }
        3 => {
            // At the border of what is allowed, where the cells begin and end.
            let edge = 1 << 21;
            let signs = [dice.range(0, 2) * 2 - 1, dice.range(0, 2) * 2 - 1];
            wander(dice, count, 30, 5)
                .iter()
                .map(|piece| moved(piece, [signs[0] * (edge - 300), signs[1] * (edge - 300)]))
                .collect()
        }
        4 => wander(dice, count, 30, 5),
        5 => (0..20).flat_map(|i| ring(dice, [i * 3000, 0], 600.0, 24)).collect(),
        6 => {
            // A long zigzag, straight enough to be one chain.
            let corner = |i: i32| [i * 50 - 90_000, (i % 2) * 20];
            let pieces = (0..count * 4).map(|i| piece(corner(i), corner(i + 1), 0)).collect();
            shuffled(dice, pieces)
        }
        _ => {
            let pieces = wander(dice, count, 2000, 12);
            shuffled(dice, pieces)
        }
    }
}

#[test]
fn a_loop_is_one_closed_chain() {
    let rules = ChainRules::new(4.0, 1.4);
    let dice = &mut Dice::new(3);
    for count in [5, 6, 17, 255, 256, 257, 1023, 4097] {
        let pieces = ring(dice, [0, 0], f64::from(count) * 40.0, count);
        let pieces = shuffled(dice, pieces);
        let chained = twin::chain(&pieces, &rules);
        assert_chains(&pieces, &chained, &rules);
        assert_eq!(chained.chains.len(), 1, "{count}");
        assert_eq!((chained.chains[0].count, chained.chains[0].is_closed), (count as u32, 1));
        let least = (0..pieces.len()).min_by_key(|&p| (pieces[p].key, p)).unwrap();
        assert_eq!(chained.ordered[0], 2 * least as u32, "begins at its least piece, from a to b");
        let Some(mut bench) = Bench::new(1 << 13, rules) else { continue };
        assert_eq!(bench.chain(&pieces), chained, "{count}");
    }
    // Two pieces face each other: a turn of nearly 90 degrees at each end, and each end a little before the other.
    let rules = ChainRules { reach_units: 200, least_cos_squared: 0 };
    let pieces = [piece([0, 0], [300, 0], 9), piece([300, 0], [0, 0], 4)];
    assert_eq!(twin::chain(&pieces, &rules).chains.len(), 2, "a turn back is no joint");
    let pieces = [piece([0, 0], [0, 0], 9), piece([3, 0], [3, 0], 4)];
    let chained = twin::chain(&pieces, &rules);
    assert_eq!((chained.chains.len(), chained.chains[0].is_closed, chained.ordered[0]), (1, 1, 2));
}

/// A chain by what lasts: key, direction and beginning of each piece; whether it is closed; its length.
type Named = (Vec<(u32, u32, u32)>, u32, u32);

#[test]
fn the_order_of_pieces_does_not_matter_where_keys_differ() {
    let rules = ChainRules::default();
    let mut bench = Bench::new(1 << 12, rules);
    for number in 0..400 {
        let dice = &mut Dice::new(77_000 + number);
        let mut pieces = scene(number);
        let keys = shuffled(dice, (0..pieces.len() as u32).map(|key| piece([0; 2], [0; 2], key)).collect());
        pieces.iter_mut().zip(keys).for_each(|(piece, from)| piece.key = from.key * 3 + 1);
        let other = shuffled(dice, pieces.clone());
        let by_key = |pieces: &[Piece], chained: &Chained| -> BTreeSet<Named> {
            let of_chain = |chain: &Chain| {
                let range = chain.first as usize..(chain.first + chain.count) as usize;
                let states = chained.ordered[range.clone()].iter().zip(&chained.places[range]);
                let named = states.map(|(s, place)| (pieces[*s as usize / 2].key, s & 1, place.begin_units));
                (named.collect(), chain.is_closed, chain.length_units)
            };
            chained.chains.iter().map(of_chain).collect()
        };
        let expected = by_key(&pieces, &twin::chain(&pieces, &rules));
        assert_eq!(by_key(&other, &twin::chain(&other, &rules)), expected, "scene {number}");
        if let (Some(bench), 0..60) = (&mut bench, number) {
            assert_eq!(by_key(&other, &bench.chain(&other)), expected, "scene {number} on the GPU");
        }
    }
}

#[test]
fn a_count_above_the_capacity_is_cut() {
    let rules = ChainRules::default();
    let Some(mut bench) = Bench::new(100, rules) else { return };
    let pieces = wander(&mut Dice::new(5), 100, 30, 5);
    bench.upload(&pieces, 5000);
    bench.run();
    assert_eq!(bench.read(100), twin::chain(&pieces, &rules));
    assert!(bench.chain(&[]).chains.is_empty());
}

/// What differs is seen: a link, an order, a distance, an angle.
#[test]
fn planted_errors_are_found() {
    let rules = ChainRules::default();
    let Some(mut bench) = Bench::new(1 << 12, rules) else { return };
    let pieces = shuffled(&mut Dice::new(8), wander(&mut Dice::new(9), 300, 30, 5));
    let chained = bench.chain(&pieces);
    assert_eq!(chained, twin::chain(&pieces, &rules));
    assert!(chained.chains.iter().any(|chain| chain.count > 3));

    // A link: a piece moved out of the reach of its neighbours.
    let mut changed = pieces.clone();
    let middle = chained.ordered[chained.chains.iter().find(|chain| chain.count > 3).unwrap().first as usize + 1];
    changed[middle as usize / 2] = moved(&changed[middle as usize / 2], [0, 5000]);
    assert_ne!(bench.chain(&changed), twin::chain(&pieces, &rules));
    // An order: two pieces change places in memory.
    let mut swapped = pieces.clone();
    swapped.swap(0, 1);
    assert_ne!(bench.chain(&swapped), twin::chain(&pieces, &rules));
    // D a unit shorter, where a gap has just that.
    let gap = [piece([0, 0], [100, 0], 1), piece([164, 0], [300, 0], 2)];
    assert_eq!(bench.chain(&gap), twin::chain(&gap, &rules));
    assert_eq!(bench.chain(&gap).chains.len(), 1);
    bench.pass.set_rules(&bench.gpu, ChainRules { reach_units: 63, ..rules });
    assert_ne!(bench.chain(&gap), twin::chain(&gap, &rules));
    // A, on the wandering line.
    bench.pass.set_rules(&bench.gpu, ChainRules::new(4.0, 0.3));
    assert_ne!(bench.chain(&pieces), twin::chain(&pieces, &rules));
    // The properties see a chain that runs the wrong way, and one that is torn.
    let spoiled = |spoil: fn(&mut Chained)| {
        let mut wrong = chained.clone();
        spoil(&mut wrong);
        std::panic::catch_unwind(|| assert_chains(&pieces, &wrong, &rules)).is_err()
    };
    assert!(!spoiled(|_| ()));
    assert!(spoiled(|wrong| wrong.ordered[1] ^= 1));
    assert!(spoiled(|wrong| wrong.ordered.swap(0, 2)));
    assert!(spoiled(|wrong| wrong.places[1].begin_units += 100));
    assert!(spoiled(|wrong| wrong.chains[0].count -= 1));
    assert!(spoiled(|wrong| wrong.ordered[0] = wrong.ordered[1]));
}

/// Lines such as a picture has, wandering or closed. Their pieces are shuffled, which is the worst order for memory.
fn picture(count: usize) -> Vec<Piece> {
    let dice = &mut Dice::new(count as i64);
    let mut pieces = Vec::with_capacity(count + 300);
    // As many pixels for each piece, however many there are.
    let side = (300.0 * (count as f64).sqrt()) as i32;
    while pieces.len() < count {
        let by = dice.point(side);
        let length = dice.range(10, 300);
        let line = if dice.range(0, 4) == 0 {
            ring(dice, [0, 0], 3.0 * f64::from(length), length)
        } else {
            wander(dice, length, 20, 1)
        };
        pieces.extend(line.iter().map(|piece| moved(piece, by)));
    }
    pieces.truncate(count);
    shuffled(dice, pieces)
}

#[test]
fn a_million_pieces_and_how_long_they_take() {
    let rules = ChainRules::default();
    let Some(mut bench) = Bench::new(MAX_PIECES, rules) else { return };
    println!("{}", bench.gpu.description());
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        let pieces = picture(count);
        bench.upload(&pieces, count as u32);
        let mut times_ms: Vec<f64> = (0..3)
            .map(|_| {
                let start = Instant::now();
                bench.run();
                start.elapsed().as_secs_f64() * 1000.0
            })
            .collect();
        times_ms.sort_by(f64::total_cmp);
        let start = Instant::now();
        let expected = twin::chain(&pieces, &rules);
        let twin_ms = start.elapsed().as_secs_f64() * 1000.0;
        let longest = expected.chains.iter().map(|chain| chain.count).max().unwrap();
        println!(
            "{count} pieces: {:.1} ms (fastest of 3; slowest {:.1}), twin {twin_ms:.0} ms; {} chains, longest {longest}",
            times_ms[0],
            times_ms[2],
            expected.chains.len()
        );
        for time in bench.timer.take().unwrap_or_default() {
            println!("    {} {:.2} ms", time.name, time.gpu_ms);
        }
        assert!(bench.read(count) == expected, "{count} pieces differ");
    }
    // One chain, and one loop, as long as there can be.
    let side = 1 << 20;
    let row = |i: i32| [(i % side) * 3 - (side * 3) / 2, 0];
    let line: Vec<Piece> = (0..side).map(|i| piece(row(i), [row(i)[0] + 3, 0], (i ^ 0x5555) as u32)).collect();
    let start = Instant::now();
    let chained = bench.chain(&line);
    println!("one chain of {side}: {:.0} ms with reading", start.elapsed().as_secs_f64() * 1000.0);
    assert!(chained == twin::chain(&line, &rules), "the longest chain differs");
    let dice = &mut Dice::new(1);
    let pieces = ring(dice, [0, 0], 2_000_000.0, side);
    let chained = bench.chain(&pieces);
    assert!(chained == twin::chain(&pieces, &rules), "the longest loop differs");
    println!("one loop of {side}: {} chains, {} closed", chained.chains.len(), chained.chains[0].is_closed);
}

#[test]
fn prefix_sums() {
    let Some(gpu) = common::gpu() else { return };
    let mut timer = Timer::new(&gpu).unwrap();
    let pass = ScanPass::new(&gpu);
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    let size = 4 * (u64::from(MAX_VALUES) + 1);
    let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
    let (values, numbers) = (gpu.device.create_buffer(&descriptor), gpu.device.create_buffer(&descriptor));
    for (count, capacity) in [
        (0_u32, 10),
        (1, 10),
        (255, 1000),
        (256, 1000),
        (2047, 3000),
        (2048, 3000),
        (2049, 3000),
        (5000, 3000),
        (100_001, u32::MAX),
        (MAX_VALUES, u32::MAX),
        (u32::MAX, u32::MAX),
    ] {
        let mut expected: Vec<u32> = (0..=MAX_VALUES as i64).map(|i| (random(i, 4) * 4e9) as u32).collect();
        gpu.queue.write_buffer(&values, 0, bytemuck::cast_slice(&expected));
        gpu.queue.write_buffer(&numbers, 0, bytemuck::cast_slice(&[7, 7, 7, count]));
        let scan_size = ScanSize::new(&gpu, 3, capacity);
        let mut recorder = timer.record(&gpu);
        pass.run(&gpu, &mut recorder, &scan_size, &numbers, &values);
        recorder.submit();
        let mut sum = 0_u32;
        let used = count.min(capacity).min(MAX_VALUES) as usize;
        for value in &mut expected[..=used] {
            let own = std::mem::replace(value, sum);
            sum = sum.wrapping_add(own);
        }
        let found = read_buffer::<u32>(&gpu, &values, MAX_VALUES as usize + 1).unwrap();
        gpu.check().unwrap();
        assert!(found == expected, "{count} of {capacity}");
    }
}
