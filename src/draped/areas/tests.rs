//! Tests of the cells of areas against winding numbers of all edges, with planted errors that the checks must find.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DVec2, IVec2, UVec2, Vec2};

use super::{AreaRings, AreaTree, CELL_BITS, DIVIDED, FEW_EDGES};

/// A generator of pseudo-random numbers (splitmix64).
struct Random(u64);

impl Random {
    /// Returns a number from 0 to 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn place_m(&mut self, [low_m, high_m]: [DVec2; 2]) -> DVec2 {
        low_m + (high_m - low_m) * DVec2::new(self.unit(), self.unit())
    }
}

/// Returns a star-shaped ring of random radii around a place, counter-clockwise.
fn star(random: &mut Random, middle_m: DVec2, radius_m: f64, count: usize) -> Vec<DVec2> {
    let corner = |i: usize| {
        let angle = i as f64 / count as f64 * TAU;
        middle_m + DVec2::from_angle(angle) * radius_m * (0.3 + 0.7 * random.unit())
    };
    (0..count).map(corner).collect()
}

/// Land of 60 km in Swiss coordinates.
const LAND_M: [DVec2; 2] = [DVec2::new(2_600_000.0, 1_200_000.0), DVec2::new(2_660_000.0, 1_260_000.0)];

/// Returns areas that overlap, touch, have holes, and are large and small.
fn areas() -> Vec<AreaRings> {
    let mut random = Random(7);
    let mut areas = Vec::new();
    for (count, radius_m) in
        [(3, 40_000.0), (5, 9000.0), (40, 5000.0), (3000, 20_000.0), (700, 300.0), (12, 3.0), (60, 0.5)]
    {
        for _ in 0..3 {
            let middle_m = random.place_m(LAND_M);
            let outer = star(&mut random, middle_m, radius_m, count);
            let mut hole: Vec<DVec2> = outer.iter().map(|at| middle_m + 0.5 * (*at - middle_m)).collect();
            hole.reverse();
            areas.push(AreaRings { area: areas.len() as u32, rings: vec![outer, hole] });
        }
    }
    // Squares that share their borders, whose coordinates are round numbers.
    for (row, column) in (0..12).flat_map(|row| (0..12).map(move |column| (row, column))) {
        let low_m = LAND_M[0] + 5000.0 * DVec2::new(f64::from(column), f64::from(row));
        let corners = [DVec2::ZERO, DVec2::new(5000.0, 0.0), DVec2::splat(5000.0), DVec2::new(0.0, 5000.0)];
        let ring = corners.map(|corner| low_m + corner).to_vec();
        areas.push(AreaRings { area: areas.len() as u32, rings: vec![ring] });
    }
    // A fan: many corners at one place.
    let middle_m = LAND_M[0] + 31_000.0;
    for i in 0..40 {
        let [first, last] = [i, i + 1].map(|i| middle_m + 4000.0 * DVec2::from_angle(f64::from(i) / 40.0 * TAU));
        areas.push(AreaRings { area: areas.len() as u32, rings: vec![vec![middle_m, first, last]] });
    }
    // Rings that cross themselves: a figure of eight, and a spiral that winds around its middle several times.
    let eight = |i: i32| {
        let angle = f64::from(i) / 80.0 * TAU;
        LAND_M[0] + 20_000.0 + DVec2::new(6000.0 * angle.sin(), 3000.0 * (2.0 * angle).sin())
    };
    let spiral =
        |i: i32| LAND_M[0] + 45_000.0 + DVec2::from_angle(f64::from(i) / 20.0 * TAU) * (500.0 + 30.0 * f64::from(i));
    for ring in [(0..80).map(eight).collect(), (0..100).map(spiral).collect()] {
        areas.push(AreaRings { area: areas.len() as u32, rings: vec![ring] });
    }
    areas
}

/// Returns the winding number of an area around a place, by all edges.
fn winding(rings: &AreaRings, at_m: DVec2) -> i32 {
    let mut winding = 0;
    for ring in &rings.rings {
        for (begin, end) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (begin, end) = (*begin - at_m, *end - at_m);
            if (begin.y <= 0.0) != (end.y <= 0.0) {
                let is_left = begin.perp_dot(end) > 0.0;
                if is_left == (end.y > 0.0) {
                    winding += if is_left { 1 } else { -1 };
                }
            }
        }
    }
    winding
}

/// Returns whether a place is in an area that is filled, as the shader does.
fn is_inside(tree: &AreaTree, is_filled: &dyn Fn(u32) -> bool, at_m: DVec2) -> bool {
    let position = tree.position(at_m);
    if position.units.cmplt(IVec2::ZERO).any() {
        return false;
    }
    let units = position.units.as_uvec2();
    if (units >> tree.root_bits) != UVec2::ZERO {
        return false;
    }
    let (mut cell, mut bits, mut is_in) = (&tree.cells[0], tree.root_bits, false);
    loop {
        let covers = &tree.covers[cell.covers as usize..][..cell.cover_count as usize];
        is_in |= covers.iter().any(|area| is_filled(*area));
        if cell.count == DIVIDED {
            bits -= CELL_BITS;
            let part = (units >> bits) & UVec2::splat((1 << CELL_BITS) - 1);
            cell = &tree.cells[(cell.first + (part.y << CELL_BITS) + part.x) as usize];
        } else {
            break;
        }
    }
    let to_m = (position.units - UVec2::from(cell.origin).as_ivec2()).as_vec2() * tree.unit_m as f32
        + position.rest_m.as_vec2();
    let range = cell.first as usize..(cell.first + cell.count) as usize;
    let mut windings: BTreeMap<u32, i32> = BTreeMap::new();
    for (edge, owner) in tree.edges[range.clone()].iter().zip(&tree.owners[range]) {
        let winding = windings.entry(owner.area).or_insert(owner.winding);
        let [begin, end] = [Vec2::new(edge[0], edge[1]), Vec2::new(edge[2], edge[3])];
        if (to_m.perp_dot(begin) > 0.0) == (to_m.perp_dot(end) > 0.0) {
            continue;
        }
        let from_left = (end - begin).perp_dot(-begin) > 0.0;
        let to_left = (end - begin).perp_dot(to_m - begin) > 0.0;
        if from_left != to_left {
            *winding += if to_left { 1 } else { -1 };
        }
    }
    is_in || windings.iter().any(|(area, winding)| *winding != 0 && is_filled(*area))
}

/// Returns the distance of a place from the nearest edge.
fn from_edges_m(areas: &[AreaRings], at_m: DVec2) -> f64 {
    let mut nearest_m = f64::INFINITY;
    for ring in areas.iter().flat_map(|area| &area.rings) {
        for (begin, end) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let along = *end - *begin;
            let part = ((at_m - *begin).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
            nearest_m = nearest_m.min(at_m.distance(*begin + along * part));
        }
    }
    nearest_m
}

/// Returns places: evenly on the land, and close to corners of areas.
fn probes(areas: &[AreaRings]) -> Vec<DVec2> {
    let mut random = Random(3);
    let mut probes: Vec<DVec2> = (0..3000).map(|_| random.place_m(LAND_M)).collect();
    let corners: Vec<DVec2> = areas.iter().flat_map(|area| area.rings.iter().flatten().copied()).collect();
    for _ in 0..3000 {
        let corner = corners[(random.unit() * corners.len() as f64) as usize];
        let away_m = 0.01 * 10_f64.powf(6.0 * random.unit());
        probes.push(corner + away_m * DVec2::from_angle(TAU * random.unit()));
    }
    // Rows and columns of places with equal coordinates, some of which are those of corners.
    probes.extend((0..600).map(|i| LAND_M[0] + DVec2::new(5000.0, 100.0 * f64::from(i) + 7.0)));
    probes.extend((0..600).map(|i| LAND_M[0] + DVec2::new(100.0 * f64::from(i) + 3.0, 31_000.0)));
    probes
}

#[test]
fn places_are_in_the_areas_around_them() {
    let areas = areas();
    let tree = AreaTree::new(&areas, LAND_M).unwrap();
    let probes = probes(&areas);
    let exact = |at_m: &DVec2| {
        let mut exact: Vec<bool> = areas.iter().map(|rings| winding(rings, *at_m) != 0).collect();
        // All areas together.
        exact.push(exact.contains(&true));
        (*at_m, exact)
    };
    let probes: Vec<(DVec2, Vec<bool>)> =
        probes.iter().filter(|at_m| from_edges_m(&areas, **at_m) > 0.004).map(exact).collect();
    let inside = probes.iter().flat_map(|(_, exact)| exact).filter(|is_in| **is_in).count();
    assert!(inside > 5000, "{inside}");
    let count =
        |of_tree: &dyn Fn(DVec2) -> Vec<bool>| probes.iter().filter(|(at_m, exact)| of_tree(*at_m) != *exact).count();
    let each = |tree: &AreaTree, at_m: DVec2| -> Vec<bool> {
        let of_one = (0..areas.len() as u32).map(|area| is_inside(tree, &|of| of == area, at_m));
        of_one.chain([is_inside(tree, &|_| true, at_m)]).collect()
    };
    assert_eq!(count(&|at_m| each(&tree, at_m)), 0);
    // Planted: an area that is missing where it covers cells, windings around other places, and edges of another cell.
    let mut without = AreaTree::new(&areas, LAND_M).unwrap();
    without.covers.iter_mut().for_each(|cover| *cover = if *cover == 0 { 1 } else { *cover });
    assert!(count(&|at_m| each(&without, at_m)) > 0);
    let mut unwound = AreaTree::new(&areas, LAND_M).unwrap();
    unwound.owners.iter_mut().for_each(|owner| owner.winding = 0);
    assert!(count(&|at_m| each(&unwound, at_m)) > 0);
    let mut shifted = AreaTree::new(&areas, LAND_M).unwrap();
    shifted.edges.rotate_left(1);
    assert!(count(&|at_m| each(&shifted, at_m)) > 0);
}

#[test]
fn cells_have_few_edges_and_are_few() {
    let mut random = Random(11);
    // A coast of 200,000 places.
    let corner = |i: usize| {
        let angle = i as f64 / 200_000.0 * TAU;
        let bays = 0.2 * (7.0 * angle).sin() + 0.05 * (90.0 * angle).sin() + 0.003 * (4000.0 * angle).sin();
        0.5 * (LAND_M[0] + LAND_M[1]) + DVec2::from_angle(angle) * 24_000.0 * (0.8 + bays + 1e-5 * random.unit())
    };
    let rings = vec![(0..200_000).map(corner).collect()];
    let tree = AreaTree::new(&[AreaRings { area: 0, rings }], LAND_M).unwrap();
    let leaves = tree.cells.iter().filter(|cell| cell.count != DIVIDED);
    let most = leaves.clone().map(|cell| cell.count).max().unwrap();
    assert!(most as usize <= FEW_EDGES);
    // Each edge is in 1.45 cells.
    assert!(tree.cells.len() < 200_000 && tree.edges.len() < 200_000 * 2, "{} {}", tree.cells.len(), tree.edges.len());
    // Where every edge is long, cells stay larger.
    let rings = vec![star(&mut random, 0.5 * (LAND_M[0] + LAND_M[1]), 25_000.0, 20_000)];
    let tree = AreaTree::new(&[AreaRings { area: 0, rings }], LAND_M).unwrap();
    assert!(tree.edges.len() <= 20_000 * 16 && tree.cells.len() < 200_000);
    // Borders that lie on each other do not separate, however small cells are.
    let square = |area: u32| {
        let corners = [(0.0, 0.0), (9000.0, 0.0), (9000.0, 9000.0), (0.0, 9000.0)];
        let ring = corners.map(|(x_m, y_m)| LAND_M[0] + 20_001.5 + DVec2::new(x_m, y_m)).to_vec();
        AreaRings { area, rings: vec![ring] }
    };
    let tree = AreaTree::new(&(0..40).map(square).collect::<Vec<_>>(), LAND_M).unwrap();
    assert!(tree.cells.len() < 30_000 && tree.most_edges <= 80);
}

#[test]
fn nothing_and_worlds_have_cells() {
    assert!(AreaTree::new(&[], LAND_M).is_none());
    let point = AreaRings { area: 0, rings: vec![vec![LAND_M[0]; 4]] };
    assert!(AreaTree::new(&[point], LAND_M).is_none());
    // What is no place is left out.
    let broken = vec![DVec2::ZERO, DVec2::NAN, DVec2::X, DVec2::ONE, DVec2::new(f64::INFINITY, 1.0)];
    let tree = AreaTree::new(&[AreaRings { area: 0, rings: vec![broken] }], [DVec2::ZERO, DVec2::ONE]).unwrap();
    assert_eq!([0.3, 0.7].map(|y_m| is_inside(&tree, &|_| true, DVec2::new(0.5, y_m))), [true, false]);
    // A hemisphere, on the whole earth.
    let world_m = [DVec2::new(-2e7, -1e7), DVec2::new(2e7, 1e7)];
    let ring = [(0.0, -1e7), (2e7, -1e7), (2e7, 1e7), (0.0, 1e7)].map(|(x, y)| DVec2::new(x, y)).to_vec();
    let tree = AreaTree::new(&[AreaRings { area: 5, rings: vec![ring] }], world_m).unwrap();
    for (x_m, expected) in [(-1e7, false), (-0.2, false), (0.2, true), (1e7, true), (2.1e7, false), (9e7, false)] {
        assert_eq!(is_inside(&tree, &|area| area == 5, DVec2::new(x_m, 12_345.0)), expected, "{x_m}");
    }
}
