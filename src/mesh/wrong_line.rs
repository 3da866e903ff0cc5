//! Finding the line of an OBJ text that contains an error.
//!
//! The mesh reader reports an error but not its line. So if it fails, and only then, the lines are checked again here.

use super::build::LARGEST_COORDINATE_M;
use crate::file::message::quoted;

/// Numbers of elements up to a line, or in all.
#[derive(Clone, Copy, Default)]
struct Counts {
    vertices: i64,
    normals: i64,
}

/// Returns the first invalid line, and the reason. `lines` are whole lines with their numbers, counted from 1.
pub(super) fn wrong_line<'a>(lines: impl Iterator<Item = (usize, &'a str)> + Clone) -> Option<(usize, String)> {
    let mut all = Counts::default();
    lines.clone().for_each(|(_, line)| all.count(line));
    // A face may use vertices defined below it, but not in all files; so vertices that exist nowhere come first.
    let with = |limit: Option<Counts>| {
        let mut before = Counts::default();
        lines.clone().find_map(|(number, line)| {
            before.count(line);
            cause(line, before, limit.unwrap_or(before)).map(|cause| (number, cause))
        })
    };
    with(Some(all)).or_else(|| with(None))
}

impl Counts {
    fn count(&mut self, line: &str) {
        match line.split_ascii_whitespace().next() {
            Some("v") => self.vertices += 1,
            Some("vn") => self.normals += 1,
            _ => {}
        }
    }
}

/// Returns what is wrong with a line. Negative indices count back from `before`; others may be as large as `limit`.
fn cause(line: &str, before: Counts, limit: Counts) -> Option<String> {
    let mut words = line.split_ascii_whitespace();
    let kind = words.next()?;
    let words: Vec<&str> = words.collect();
    match kind {
        "v" => vertex(&words),
        "vn" => numbers(&words).err().or_else(|| {
            (words.len() < 3).then(|| format!("a normal needs 3 numbers, but this one has {}", words.len()))
        }),
        "f" if words.len() < 3 => Some(format!("a face needs 3 corners, but this one has {}", words.len())),
        "f" => words.iter().find_map(|word| corner(word, before, limit)),
        _ => None,
    }
}

fn numbers(words: &[&str]) -> Result<Vec<f64>, String> {
    let number = |word: &&str| word.parse::<f64>().map_err(|_| format!("{} is not a number", quoted(word)));
    words.iter().map(number).collect()
}

fn vertex(words: &[&str]) -> Option<String> {
    let numbers = match numbers(words) {
        Ok(numbers) => numbers,
        Err(cause) => return Some(cause),
    };
    // x y z, optionally with a weight or a colour.
    if ![3, 4, 6, 7].contains(&numbers.len()) {
        return Some(format!("a vertex needs 3 numbers, but this one has {}", numbers.len()));
    }
    let weight = if numbers.len() == 4 { numbers[3] } else { 1.0 };
    let place = numbers[..3].iter().map(|number| number / weight);
    if weight == 0.0 || place.clone().any(|number| !number.is_finite()) {
        return Some("the vertex is not finite".to_owned());
    }
    let is_far = place.into_iter().any(|number| number.abs() > LARGEST_COORDINATE_M);
    is_far.then(|| format!("the vertex is farther than {LARGEST_COORDINATE_M:e} m from the origin"))
}

fn corner(word: &str, before: Counts, limit: Counts) -> Option<String> {
    let mut parts = word.split('/');
    let (vertex, normal) = (parts.next().unwrap_or_default(), parts.nth(1).unwrap_or_default());
    let check = |what: &str, text: &str, before: i64, limit: i64| {
        let Ok(index) = text.parse::<i64>() else { return Some(format!("{} is not a face's {what}", quoted(word))) };
        let is_there = if index < 0 { index >= -before } else { (1..=limit).contains(&index) };
        (!is_there).then(|| format!("the face uses {what} {index}, but there are {limit}"))
    };
    let wrong = check("vertex", vertex, before.vertices, limit.vertices);
    wrong.or_else(|| if normal.is_empty() { None } else { check("normal", normal, before.normals, limit.normals) })
}
