//! Input segments: small scenes of many kinds, large ones, and lines such as a picture has.

use hachure::lines::strokes::Segment;

use crate::tests::common::random;

/// Random integers, the same in each run.
pub struct Dice {
    seed: i64,
    thrown: i64,
}

impl Dice {
    pub fn new(seed: i64) -> Self {
        Self { seed, thrown: 0 }
    }

    /// Returns a number in begin..end.
    pub fn range(&mut self, begin: i32, end: i32) -> i32 {
        self.thrown += 1;
        begin + (random(self.seed, self.thrown) * f64::from(end - begin)) as i32
    }

    pub fn point(&mut self, side: i32) -> [i32; 2] {
        [self.range(0, side), self.range(0, side)]
    }
}

pub fn segment(a: [i32; 2], b: [i32; 2], key: u32) -> Segment {
    Segment { a, b, depths_m: [1.0, 2.0], edge: 0, key }
}

pub fn moved(segment: &Segment, by: [i32; 2]) -> Segment {
    let to = |p: [i32; 2]| [p[0] + by[0], p[1] + by[1]];
    Segment { a: to(segment.a), b: to(segment.b), ..*segment }
}

/// Returns a polygon around a centre, with segments in mixed directions.
pub fn ring(dice: &mut Dice, middle: [i32; 2], radius: f64, count: i32) -> Vec<Segment> {
    let corner = |i: i32| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        [middle[0] + (radius * angle.cos()) as i32, middle[1] + (radius * angle.sin()) as i32]
    };
    (0..count)
        .map(|i| {
            let (a, b) = (corner(i), corner(i + 1));
            let key = dice.range(0, 30) as u32;
            if dice.range(0, 2) == 0 { segment(a, b, key) } else { segment(b, a, key) }
        })
        .collect()
}

/// Returns a line of segments with small gaps and turns, half of them reversed.
pub fn wander(dice: &mut Dice, count: i32, step: i32, gap: i32) -> Vec<Segment> {
    let mut at = [0, 0];
    let mut angle = f64::from(dice.range(0, 628)) / 100.0;
    (0..count)
        .map(|_| {
            angle += f64::from(dice.range(-60, 61)) / 100.0;
            let end = [at[0] + (f64::from(step) * angle.cos()) as i32, at[1] + (f64::from(step) * angle.sin()) as i32];
            let key = dice.range(0, 20) as u32;
            let made = if dice.range(0, 2) == 0 { segment(at, end, key) } else { segment(end, at, key) };
            at = [end[0] + dice.range(-gap, gap + 1), end[1] + dice.range(-gap, gap + 1)];
            made
        })
        .collect()
}

pub fn shuffled(dice: &mut Dice, mut segments: Vec<Segment>) -> Vec<Segment> {
    for i in (1..segments.len()).rev() {
        segments.swap(i, dice.range(0, i as i32 + 1) as usize);
    }
    segments
}

pub const KINDS: i64 = 21;

/// Returns a small scene of one of several kinds, within about 500 px.
pub fn scene(number: i64) -> Vec<Segment> {
    let mut dice = Dice::new(number);
    let dice = &mut dice;
    let count = dice.range(2, 40);
    let key = |dice: &mut Dice| dice.range(0, 5) as u32;
    let segments: Vec<Segment> = match number % KINDS {
        0 => Vec::new(),
        1 => vec![segment(dice.point(500), dice.point(500), 7)],
        // All segments in one pixel, and in a few.
        2 => (0..count).map(|_| segment(dice.point(16), dice.point(16), key(dice))).collect(),
        3 => (0..count).map(|_| segment(dice.point(64), dice.point(64), key(dice))).collect(),
        4 => (0..count).map(|_| segment(dice.point(400), dice.point(400), key(dice))).collect(),
        // Short segments, dense: many candidates.
        5 | 6 => (0..count)
            .map(|_| {
                let a = dice.point(300);
                segment(a, [a[0] + dice.range(-40, 41), a[1] + dice.range(-40, 41)], key(dice))
            })
            .collect(),
        // A grid, which has ties everywhere.
        7 => (0..count)
            .flat_map(|i| {
                let a = [i % 6 * 32, i / 6 * 32];
                [segment(a, [a[0] + 32, a[1]], 1), segment([a[0], a[1] + 32], a, 1)]
            })
            .collect(),
        // A star, and one whose rays do not meet.
        8 | 9 => (0..count)
            .map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
                let at = |r: f64| [(r * angle.cos()) as i32, (r * angle.sin()) as i32];
                let near = if number % KINDS == 8 { 0.0 } else { 20.0 };
                if dice.range(0, 2) == 0 { segment(at(near), at(300.0), 3) } else { segment(at(300.0), at(near), 3) }
            })
            .collect(),
        // Loops: one, two, one inside another.
        10 => ring(dice, [500, 500], 400.0, count.max(8)),
        11 => [ring(dice, [0, 0], 200.0, 12), ring(dice, [900, 0], 220.0, 9)].concat(),
        12 => [ring(dice, [0, 0], 200.0, 12), ring(dice, [0, 0], 230.0, 15)].concat(),
        // Two segments bent towards each other: a loop if the largest angle allows it.
        13 => {
            let gap = dice.range(0, 40);
            vec![segment([0, 0], [gap, 10], key(dice)), segment([gap, 10 + dice.range(0, 9)], [0, dice.range(0, 9)], 2)]
        }
        // A zigzag: sharp turns are not joined, blunt ones are.
        14 => {
            let height = dice.range(5, 60);
            let corner = |i: i32| [i * 40, (i % 2) * height];
            (0..count).map(|i| segment(corner(i), corner(i + 1), i as u32 / 3)).collect()
        }
        15 | 16 => wander(dice, count, 30, 5),
        17 => wander(dice, count, 20, 40),
        // Zero lengths among others.
        18 => {
            let mut segments = wander(dice, count, 40, 10);
            for segment in segments.iter_mut().step_by(3) {
                segment.b = segment.a;
            }
            segments
        }
        // Duplicates, also reversed.
        19 => {
            let segments = wander(dice, count / 2 + 1, 40, 10);
            let copies = segments.iter().map(|p| if p.key % 2 == 0 { *p } else { segment(p.b, p.a, p.key) });
            segments.iter().copied().chain(copies.collect::<Vec<_>>()).collect()
        }
        // One point, many times.
        _ => (0..count).map(|_| segment([5, 5], [5, 5], key(dice))).collect(),
    };
    if dice.range(0, 2) == 0 { segments } else { shuffled(dice, segments) }
}

/// Returns an input that uses the GPU alone.
pub fn alone(number: i64) -> Vec<Segment> {
    let dice = &mut Dice::new(1_000_000 + number);
    let count = dice.range(1, 400);
    match number % 8 {
        0 => scene(number / 8),
        1 => (0..count).map(|_| segment(dice.point(16), dice.point(16), dice.range(0, 9) as u32)).collect(),
        2 => {
            // Far outside on all sides, beyond the allowed range.
            let far = |dice: &mut Dice| dice.point(1 << 23).map(|units| units - (1 << 22));
            (0..count).map(|_| segment(far(dice), far(dice), 1)).collect()
        }
        3 => {
            // At the border of the allowed range, where the cells begin and end.
            let edge = 1 << 21;
            let signs = [dice.range(0, 2) * 2 - 1, dice.range(0, 2) * 2 - 1];
            wander(dice, count, 30, 5)
                .iter()
                .map(|segment| moved(segment, [signs[0] * (edge - 300), signs[1] * (edge - 300)]))
                .collect()
        }
        4 => wander(dice, count, 30, 5),
        5 => (0..20).flat_map(|i| ring(dice, [i * 3000, 0], 600.0, 24)).collect(),
        6 => {
            // A long zigzag, straight enough to be one chain.
            let corner = |i: i32| [i * 50 - 90_000, (i % 2) * 20];
            let segments = (0..count * 4).map(|i| segment(corner(i), corner(i + 1), 0)).collect();
            shuffled(dice, segments)
        }
        _ => {
            let segments = wander(dice, count, 2000, 12);
            shuffled(dice, segments)
        }
    }
}

/// Returns lines such as a picture has, wandering or closed. Their segments are shuffled, which is the worst order for
/// memory access.
pub fn picture(count: usize) -> Vec<Segment> {
    let dice = &mut Dice::new(count as i64);
    let mut segments = Vec::with_capacity(count + 300);
    // The area per segment is the same for all counts.
    let side = (300.0 * (count as f64).sqrt()) as i32;
    while segments.len() < count {
        let by = dice.point(side);
        let length = dice.range(10, 300);
        let line = if dice.range(0, 4) == 0 {
            ring(dice, [0, 0], 3.0 * f64::from(length), length)
        } else {
            wander(dice, length, 20, 1)
        };
        segments.extend(line.iter().map(|segment| moved(segment, by)));
    }
    segments.truncate(count);
    shuffled(dice, segments)
}
