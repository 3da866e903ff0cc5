//! The damage that is done to files: to their bytes, to numbers in them, to the words of a text.

use std::ops::Range;

/// Half of the damage is done to this many bytes at the beginning, where it has the most effect.
const HEADER_BYTES: usize = 1100;

/// Numbers that parsers often handle wrongly.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "1e400",
    "4294967295",
    "4294967296",
    "2147483647",
    "-2147483648",
    "18446744073709551615",
    "99999999999999999999",
    "0.1",
    "-0",
    "1.5.2",
    "1,5",
    "0x10",
    "65536",
    "1e9",
    "3000000",
    "-32768",
    "00000000000000000000000000000001",
    "",
    "0.5",
    "3",
    "10",
    "100",
    "1000",
    "-0.5",
];

/// Words and characters that are unexpected in a text.
const WORDS: &[&str] = &[
    "\0",
    "\u{1b}[31m",
    "\u{feff}",
    "é",
    "\u{202e}",
    "\"",
    "'",
    "[",
    "]",
    "[[",
    "{",
    "}",
    "=",
    ",",
    ";",
    "\r",
    "\n",
    "\t",
    "#",
    "\\",
    "/",
    "..",
    "*",
    "true",
    "[[[[",
    "\"\"\"",
    "+5",
    "%s",
];

/// A xorshift generator, so that the damage is the same in every run.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(text: &str) -> Self {
        // FNV-1a, and never 0.
        let fold = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        let mut random = Self(text.bytes().fold(0xcbf2_9ce4_8422_2325, fold) | 1);
        // Texts that differ only in the last letter give similar first numbers.
        for _ in 0..8 {
            random.next();
        }
        random
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Returns a number from 0 to below the limit; 0 for a limit of 0.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        ((self.next() >> 11) % limit.max(1) as u64) as usize
    }

    fn one_of<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }

    fn range(&mut self, length: usize, longest: usize) -> Range<usize> {
        let first = self.below(length);
        first..(first + 1 + self.below(longest)).min(length)
    }
}

/// Returns a damaged copy; `donor` is another file of the kind.
pub(crate) fn damaged(bytes: &[u8], donor: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let is_text = bytes.iter().take(4096).all(|&byte| byte != 0) && std::str::from_utf8(&bytes).is_ok();
    // Half of the copies have a single flaw, mostly in a number, because a file with several flaws is refused at the
    // first.
    let is_gentle = random.below(2) == 0;
    for _ in 0..if is_gentle { 1 } else { 1 + random.below(4) } {
        if is_text && (is_gentle || random.below(4) > 0) {
            bytes = in_text(&String::from_utf8_lossy(&bytes), is_gentle, random).into_bytes();
        } else {
            in_bytes(&mut bytes, donor, random);
        }
    }
    // A wrong checksum would keep most damage of a PNG from the parser.
    if random.below(4) > 0 {
        mend_png(&mut bytes);
    }
    bytes
}

fn in_bytes(bytes: &mut Vec<u8>, donor: &[u8], random: &mut Random) {
    let at = match random.below(2) {
        0 => random.below(bytes.len().min(HEADER_BYTES)),
        _ => random.below(bytes.len()),
    };
    match random.below(12) {
        0 => bytes.truncate(at),
        1..=2 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << random.below(8);
            }
        }
        3..=4 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = random.below(256) as u8;
            }
        }
        // A field that holds a number is replaced by an unusual number.
        5..=7 => {
            let length = *random.one_of(&[1, 2, 2, 4, 4, 8]);
            let file_bytes = bytes.len() as u64;
            let fields = [0, 1, 2, u64::MAX, u64::MAX - 1, u64::MAX >> 1, 1 << 63, 0x7fff, 0x8000, 0x7fff_ffff];
            let more = [0x8000_0000, 0x1_0000, 0x10_0000, file_bytes, file_bytes - 1.min(file_bytes), 8];
            let value = *random.one_of(&[&fields[..], &more[..]].concat());
            let is_big_endian = random.below(2) == 0;
            let mut field = value.to_le_bytes()[..length].to_vec();
            // The highest bit is the sign of a field of any length.
            if value == 1 << 63 {
                field[length - 1] = 0x80;
            }
            if is_big_endian {
                field.reverse();
            }
            // Fields begin at even offsets.
            let at = at & !1;
            for (byte, new) in bytes.iter_mut().skip(at).zip(field) {
                *byte = new;
            }
        }
        8 => {
            let block = random.range(bytes.len(), 64);
            let block = bytes.get(block).unwrap_or_default().repeat(1 + random.below(40));
            bytes.splice(at.min(bytes.len())..at.min(bytes.len()), block);
        }
        9 => drop(bytes.drain(random.range(bytes.len(), 64))),
        10 => {
            let block = donor.get(random.range(donor.len(), 400)).unwrap_or_default().to_vec();
            let end = (at + block.len()).min(bytes.len());
            bytes.splice(at.min(end)..end, block);
        }
        _ => {
            let fill = *random.one_of(&[0, 0xff, 0x20]);
            let block = random.range(bytes.len(), 200);
            bytes.get_mut(block).unwrap_or_default().fill(fill);
        }
    }
}

/// Returns the ranges of words of a text, which are separated by spaces and signs.
fn words(text: &str) -> Vec<Range<usize>> {
    let is_part = |c: char| c.is_alphanumeric() || matches!(c, '.' | '-' | '+' | '_');
    let mut words: Vec<Range<usize>> = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (is_part(c), start) {
            (true, None) => start = Some(at),
            (false, Some(first)) => {
                words.push(first..at);
                start = None;
            }
            _ => {}
        }
    }
    words
}

fn in_text(text: &str, is_gentle: bool, random: &mut Random) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let line = random.below(lines.len());
    match if is_gentle { 2 * random.below(6) } else { random.below(12) } {
        0 if !lines.is_empty() => {
            lines.swap(line, random.below(text.split_inclusive('\n').count()));
            lines.concat()
        }
        1 if !lines.is_empty() => {
            lines.remove(line);
            lines.concat()
        }
        2 if !lines.is_empty() => {
            let copies = vec![lines[line]; 1 + random.below(30)];
            lines.splice(line..line, copies);
            lines.concat()
        }
        // Nested brackets: a recursive parser could overflow its stack.
        3 => {
            let (open, close) = *random.one_of(&[("[", "]"), ("{a=", "}"), ("(", ")"), ("[", "")]);
            let depth = *random.one_of(&[3, 200, 20_000]);
            insert(text, &(open.repeat(depth) + &close.repeat(depth)), random)
        }
        4 => insert(text, random.one_of::<&str>(WORDS), random),
        5 => insert(text, &random.one_of(&["a", "9", "é", " ", "\n", "-"]).repeat(1 + random.below(5000)), random),
        choice => {
            let words = words(text);
            let is_number = |word: &&Range<usize>| text[(*word).clone()].parse::<f64>().is_ok();
            let numbers: Vec<_> = words.iter().filter(is_number).cloned().collect();
            let names: Vec<_> = words.iter().filter(|word| !is_number(word)).cloned().collect();
            let is_for_numbers = choice < 10;
            let among = if is_for_numbers && !numbers.is_empty() { &numbers } else { &names };
            if among.is_empty() {
                return insert(text, random.one_of::<&str>(NUMBERS), random);
            }
            let word = if random.below(3) == 0 {
                among[random.below(among.len().min(12))].clone()
            } else {
                random.one_of(among).clone()
            };
            let new = match is_for_numbers {
                true => (*random.one_of(NUMBERS)).to_owned(),
                // An unknown key, or another word of the text.
                false if random.below(2) == 0 => format!("{}x", &text[word.clone()]),
                false => text[random.one_of(&words).clone()].to_owned(),
            };
            format!("{}{new}{}", &text[..word.start], &text[word.end..])
        }
    }
}

fn insert(text: &str, new: &str, random: &mut Random) -> String {
    let mut at = random.below(text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    format!("{}{new}{}", &text[..at], &text[at..])
}

/// Corrects the checksums of a PNG's chunks, as far as the chunks can be followed.
fn mend_png(bytes: &mut [u8]) {
    if !bytes.starts_with(b"\x89PNG") {
        return;
    }
    let mut at = 8;
    while let Some(length) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes(length.try_into().unwrap()) as usize;
        let end = at + 8 + length;
        if bytes.len() < end + 4 {
            return;
        }
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&hasher.finalize().to_be_bytes());
        at = end + 4;
    }
}

#[test]
fn a_case_is_the_same_each_time_and_others_differ() {
    let bytes: Vec<u8> = (0..2000_u32).map(|it| it as u8).collect();
    let text = b"width = 12\nname = \"a b\"\n[x]\ny = 0.5\n".to_vec();
    for input in [bytes, text] {
        let case = |number: u32| damaged(&input, b"other", &mut Random::new(&format!("1 kind {number}")));
        let all: std::collections::HashSet<Vec<u8>> = (0..500).map(case).collect();
        assert!(all.len() > 300, "500 cases gave only {} different files", all.len());
        assert_eq!(case(7), case(7));
    }
}
