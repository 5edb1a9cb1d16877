//! Changes of files as accidents and strangers make them: the same seed, the same changes.

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `count`, which is at least 1.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    /// Small mostly, below two to the power `most`.
    fn up_to(&mut self, most: usize) -> usize {
        let power = self.below(most);
        self.below(1 << power)
    }

    fn pick<'a, T: ?Sized>(&mut self, of: &[&'a T]) -> &'a T {
        of[self.below(of.len())]
    }
}

/// Longest input.
pub const MOST_BYTES: usize = 1 << 15;

/// Numbers that readers have stumbled over, or may.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "3",
    "-0",
    "1e308",
    "-1e308",
    "1e-320",
    "1e39",
    "nan",
    "inf",
    "-inf",
    "255",
    "256",
    "65536",
    "99999999",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775808",
    "18446744073709551615",
    "1e400",
    "0x10",
    "1.5.2",
    ".",
    "1e",
    "0.5,",
    "1000000",
    "0.1",
    "90",
    "180",
    "360",
];

/// What stands between words in one format or another.
const TOKENS: &[&str] = &[
    "\n",
    "\r\n",
    " ",
    "\t",
    ",",
    ";",
    "\"",
    "'",
    "{",
    "}",
    "[",
    "]",
    "<",
    ">",
    "/",
    "=",
    "#",
    "!",
    "|",
    "%",
    "\\",
    "\0",
    "\u{feff}",
    "..",
    "é",
    "\u{1b}[2J",
    "null",
    "true",
    "[[",
    "&#x0;",
    "<!--",
    "<![CDATA[",
    "void",
    "-a",
    "-i",
    "!xform ",
    "!genbox ",
    " | xform -rz 90",
];

/// Bytes of numbers in binary formats.
const WORDS: &[u32] =
    &[0, 1, 0x7f, 0xff, 0x100, 0x7fff, 0xffff, 0x10000, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0000, 0x7fc0_0000, 2];

/// One to several changes of `bytes`, some with parts of `other`.
pub fn mutate(bytes: &mut Vec<u8>, other: &[u8], words: &[&str], random: &mut Random) {
    let changes = 1 + [0, 0, 0, 1, 1, 2, 4, 12][random.below(8)];
    for _ in 0..changes {
        change(bytes, other, words, random);
        bytes.truncate(MOST_BYTES);
    }
}

fn change(bytes: &mut Vec<u8>, other: &[u8], words: &[&str], random: &mut Random) {
    let at = random.below(bytes.len() + 1);
    let end = (at + 1 + random.up_to(9)).min(bytes.len());
    match random.below(16) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
        1 if at < bytes.len() => bytes[at] = random.next() as u8,
        2 if at < end => {
            bytes.drain(at..end);
        }
        3 if at < end => {
            let part = bytes[at..end].to_vec();
            insert(bytes, random.below(at + 1), &part);
        }
        4 => insert(bytes, at, random.pick(TOKENS).as_bytes()),
        5 => insert(bytes, at, random.pick(NUMBERS).as_bytes()),
        6 if !words.is_empty() => insert(bytes, at, random.pick(words).as_bytes()),
        7 | 8 => replace_number(bytes, at, random),
        9 => word(bytes, at, random),
        10 if !other.is_empty() => {
            let from = random.below(other.len());
            let to = (from + 1 + random.up_to(10)).min(other.len());
            insert(bytes, at, &other[from..to]);
        }
        11 => lines(bytes, random),
        12 if random.below(4) == 0 => bytes.truncate(at),
        13 if at < end && random.below(4) == 0 => {
            // Many of the same: nesting, long lists.
            let part = bytes[at..end].to_vec();
            let count = 1 << random.below(11);
            let many: Vec<u8> = part.iter().copied().cycle().take((part.len() * count).min(MOST_BYTES)).collect();
            insert(bytes, at, &many);
        }
        14 if !words.is_empty() => replace_word(bytes, at, words, random),
        _ if at < end => bytes[at..end].iter_mut().for_each(|b| *b = b.wrapping_add(1)),
        _ => {}
    }
}

fn insert(bytes: &mut Vec<u8>, at: usize, part: &[u8]) {
    bytes.splice(at..at, part.iter().copied());
}

/// The run of bytes that `is` holds for, at or after a place.
fn run(bytes: &[u8], at: usize, is: fn(&u8) -> bool) -> Option<std::ops::Range<usize>> {
    let start = at + bytes[at..].iter().position(is)?;
    let length = bytes[start..].iter().position(|b| !is(b)).unwrap_or(bytes.len() - start);
    Some(start..start + length)
}

fn replace_number(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let Some(place) = run(bytes, at, |b| b.is_ascii_digit() || b".+-".contains(b)) else { return };
    let number = random.pick(NUMBERS).bytes();
    bytes.splice(place, number);
}

fn replace_word(bytes: &mut Vec<u8>, at: usize, words: &[&str], random: &mut Random) {
    let Some(place) = run(bytes, at, |b| b.is_ascii_alphanumeric() || *b == b'_') else { return };
    let word = random.pick(words).bytes();
    bytes.splice(place, word);
}

fn word(bytes: &mut [u8], at: usize, random: &mut Random) {
    let value = WORDS[random.below(WORDS.len())];
    let (width, little) = ([1, 2, 4][random.below(3)], random.below(2) == 0);
    let Some(place) = bytes.get_mut(at..at + width) else { return };
    if little { place.copy_from_slice(&value.to_le_bytes()[..width]) } else { place.copy_from_slice(&value.to_be_bytes()[4 - width..]) }
}

/// Swaps, doubles or drops a line.
fn lines(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|b| *b == b'\n').collect();
    if lines.len() < 2 {
        return;
    }
    let (a, b) = (random.below(lines.len()), random.below(lines.len()));
    match random.below(3) {
        0 => lines.swap(a, b),
        1 => lines.insert(b, lines[a]),
        _ => {
            lines.remove(a);
        }
    }
    *bytes = lines.concat();
}
