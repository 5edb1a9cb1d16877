//! Grouping of glare pixels into sources.
//!
//! Two glare pixels belong to one source if a chain of glare pixels joins them whose links are no
//! longer than half the search radius (evalglare takes its radius as a full angle). So the result
//! does not depend on the order of the pixels, and all sums run over ascending pixel numbers: it is
//! the same, bit for bit, however the pixels were found.

use super::geometry::{PixelGeometry, cross, dot, normalise};
use super::position::angles;
use super::{Convention, Settings};

/// A glare source.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Its pixels, ascending; none of a [disc](super::Disc).
    pub pixels: Vec<u32>,
    /// Column of its centroid weighted by luminance and solid angle, from the left, from 0; not a number
    /// for a disc.
    pub x: f64,
    /// Row of its centroid from the bottom, from 0; not a number for a disc.
    pub y: f64,
    /// Unit vector to it.
    pub direction: [f64; 3],
    /// Mean luminance weighted by solid angle, cd/m².
    pub luminance: f64,
    /// Greatest luminance, cd/m².
    pub peak_luminance: f64,
    /// Solid angle, sr.
    pub solid_angle: f64,
    /// Illuminance it gives at the eye, lx.
    pub illuminance: f64,
    /// Position index.
    pub position_index: f64,
    /// Angle from the view direction, degrees.
    pub sigma: f64,
    /// Angle from upwards, degrees.
    pub tau: f64,
    /// Whether it was taken out of another source for its luminance, or is a disc.
    pub is_peak: bool,
}

/// A block of pixels that are all within reach of one another, in a cap around them.
#[derive(Debug, Clone, Copy)]
struct Block {
    centre: [f64; 3],
    radius: f64,
    /// Cosine of the angle to the centre beyond which nothing is within reach of the block.
    cos_beyond: f64,
}

/// Two blocks that may hold neighbours.
#[derive(Debug, Clone, Copy)]
struct Pair {
    other: u32,
    /// Every pixel of one is within reach of every pixel of the other.
    surely: bool,
}

/// Which pixels of a view are within reach of one another: the view in blocks, with the pairs of
/// blocks that may hold neighbours. Computed once per view and search radius.
#[derive(Debug, Clone)]
pub(crate) struct Neighbourhood {
    cos_reach: f64,
    block_of: Vec<u32>,
    blocks: Vec<Block>,
    pairs_from: Vec<u32>,
    pairs: Vec<Pair>,
}

/// Room for rounding when caps are compared with the reach.
const ROUNDING: f64 = 1e-9;

impl Neighbourhood {
    /// Neighbours by a search radius (rad, a full angle: pixels up to half of it apart are neighbours).
    pub fn new(geometry: &PixelGeometry, search_radius: f64) -> Self {
        let reach = (search_radius / 2.0).clamp(0.0, std::f64::consts::PI);
        let mut blocks = Vec::new();
        // 0 for pixels outside the view, which are never asked for.
        let mut block_of = vec![0; geometry.pixel_count()];
        // Blocks whose diagonal is within reach in the middle of the view; where they are larger
        // than that, in quarters. Even for long reaches small enough to be nearly flat.
        let side = (reach.min(0.2) / (std::f64::consts::SQRT_2 * geometry.pixel_pitch())).floor().clamp(1.0, 64.0) as usize;
        let mut squares: Vec<[usize; 3]> = Vec::new();
        for y in (0..geometry.height).step_by(side).rev() {
            squares.extend((0..geometry.width).step_by(side).rev().map(|x| [x, y, side]));
        }
        while let Some([left, top, side]) = squares.pop() {
            let pixels: Vec<u32> = (top..(top + side).min(geometry.height))
                .flat_map(|y| (left..(left + side).min(geometry.width)).map(move |x| (y * geometry.width + x) as u32))
                .filter(|&p| geometry.is_inside(p as usize))
                .collect();
            if pixels.is_empty() {
                continue;
            }
            match Block::around(&pixels, geometry, reach) {
                Some(block) => {
                    pixels.iter().for_each(|&p| block_of[p as usize] = blocks.len() as u32);
                    blocks.push(block);
                }
                None => {
                    let half = side.div_ceil(2);
                    squares.extend([[half, half], [0, half], [half, 0], [0, 0]].map(|[x, y]| [left + x, top + y, half]));
                }
            }
        }
        let (pairs_from, pairs) = neighbouring_blocks(&blocks, reach);
        Self { cos_reach: reach.cos(), block_of, blocks, pairs_from, pairs }
    }

    /// Groups pixels (ascending, inside the view) of the geometry this was made for. The label of a
    /// group is the place in the list of its first pixel.
    pub fn group(&self, pixels: &[u32], geometry: &PixelGeometry) -> Vec<u32> {
        let members = Members::new(pixels, &self.block_of, self.blocks.len());
        let direction = |p: u32| geometry.directions[p as usize];
        let mut groups = Groups::new(self.blocks.len());
        for &block in &members.occupied {
            for pair in &self.pairs[self.pairs_from[block as usize] as usize..self.pairs_from[block as usize + 1] as usize] {
                let there = members.of(pair.other);
                if there.is_empty() || groups.find(block) == groups.find(pair.other) {
                    continue;
                }
                let other = &self.blocks[pair.other as usize];
                let joined = pair.surely
                    || members
                        .of(block)
                        .iter()
                        .map(|&a| direction(a))
                        .filter(|&a| dot(a, other.centre) >= other.cos_beyond)
                        .any(|a| there.iter().any(|&b| dot(a, direction(b)) >= self.cos_reach));
                if joined {
                    groups.join(block, pair.other);
                }
            }
        }
        // Groups of blocks are named after blocks; their first pixel names them for the caller.
        let mut first = vec![u32::MAX; self.blocks.len()];
        let block_of = pixels.iter().map(|&p| self.block_of[p as usize]);
        let labels = block_of.zip(0..).map(|(block, place)| {
            let name = &mut first[groups.find(block) as usize];
            *name = (*name).min(place);
            *name
        });
        labels.collect()
    }
}

impl Block {
    /// The block of some pixels, or `None` if they are not all within reach of one another.
    fn around(pixels: &[u32], geometry: &PixelGeometry, reach: f64) -> Option<Self> {
        let direction = |&p: &u32| geometry.directions[p as usize];
        let sum = pixels.iter().map(direction).fold([0.0; 3], |s, d| [s[0] + d[0], s[1] + d[1], s[2] + d[2]]);
        let [first, .., last] = pixels else {
            return Some(Self::cap(geometry.directions[pixels[0] as usize], 0.0, reach));
        };
        // The pixels furthest apart are ends of rows.
        let row = |p: u32| p as usize / geometry.width;
        let inner = pixels.windows(2).filter(|pair| row(pair[0]) != row(pair[1])).flatten();
        let ends: Vec<[f64; 3]> = [first].into_iter().chain(inner).chain([last]).map(direction).collect();
        let limit = 4.0 * (reach / 2.0).sin().powi(2);
        let far = |(i, &a): (usize, &[f64; 3])| ends[i + 1..].iter().any(|&b| distance_squared(a, b) > limit);
        if ends.iter().enumerate().any(far) {
            return None;
        }
        let centre = normalise(sum)?;
        let chord = ends.iter().map(|&d| distance_squared(centre, d)).fold(0.0, f64::max).sqrt();
        Some(Self::cap(centre, 2.0 * (chord / 2.0).min(1.0).asin(), reach))
    }

    fn cap(centre: [f64; 3], radius: f64, reach: f64) -> Self {
        let radius = radius + ROUNDING;
        Self { centre, radius, cos_beyond: (reach + radius).min(std::f64::consts::PI).cos() }
    }
}

fn distance_squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(d, d)
}

/// Pairs of blocks with points within reach of one another: for each block its partners of higher number.
fn neighbouring_blocks(blocks: &[Block], reach: f64) -> (Vec<u32>, Vec<Pair>) {
    let widest = blocks.iter().fold(0.0f64, |a, c| a.max(c.radius));
    // Centres further apart than this never matter; a grid of this spacing finds the others.
    let furthest = 2.0 * ((reach + 2.0 * widest).min(std::f64::consts::PI) / 2.0).sin() + ROUNDING;
    let spacing = furthest.max(2.0 / 64.0);
    let per_axis = (2.0 / spacing).floor() as usize + 1;
    let coordinate = |x: f64| (((x + 1.0) / spacing) as usize).min(per_axis - 1);
    let place = |[x, y, z]: [usize; 3]| (z * per_axis + y) * per_axis + x;
    let mut grid: Vec<Vec<u32>> = vec![Vec::new(); per_axis.pow(3)];
    for (i, block) in blocks.iter().enumerate() {
        grid[place(block.centre.map(coordinate))].push(i as u32);
    }
    let (mut from, mut pairs) = (vec![0], Vec::new());
    for (i, a) in blocks.iter().enumerate() {
        let first = pairs.len();
        let [x, y, z] = a.centre.map(coordinate).map(|c| c.saturating_sub(1)..=(c + 1).min(per_axis - 1));
        for cell in z.flat_map(|z| y.clone().map(move |y| [y, z])).flat_map(|[y, z]| x.clone().map(move |x| [x, y, z])) {
            for &j in grid[place(cell)].iter().filter(|&&j| j as usize > i) {
                let b = &blocks[j as usize];
                if distance_squared(a.centre, b.centre) > furthest * furthest {
                    continue;
                }
                let across = cross(a.centre, b.centre);
                let apart = dot(across, across).sqrt().atan2(dot(a.centre, b.centre));
                if apart - a.radius - b.radius <= reach {
                    pairs.push(Pair { other: j, surely: apart + a.radius + b.radius <= reach });
                }
            }
        }
        // Near blocks first: they join the most, and what is joined needs no look at its pixels.
        pairs[first..].sort_unstable_by_key(|p: &Pair| (!p.surely, p.other));
        from.push(pairs.len() as u32);
    }
    (from, pairs)
}

/// A list of pixels sorted by block.
struct Members {
    occupied: Vec<u32>,
    from: Vec<u32>,
    pixels: Vec<u32>,
}

impl Members {
    fn new(pixels: &[u32], block_of: &[u32], blocks: usize) -> Self {
        let mut from = vec![0u32; blocks + 1];
        for &p in pixels {
            from[block_of[p as usize] as usize + 1] += 1;
        }
        let occupied = (0..blocks as u32).filter(|&b| from[b as usize + 1] > 0).collect();
        for b in 0..blocks {
            from[b + 1] += from[b];
        }
        let mut next = from.clone();
        let mut sorted = vec![0; pixels.len()];
        for &p in pixels {
            let slot = &mut next[block_of[p as usize] as usize];
            sorted[*slot as usize] = p;
            *slot += 1;
        }
        Self { occupied, from, pixels: sorted }
    }

    fn of(&self, block: u32) -> &[u32] {
        &self.pixels[self.from[block as usize] as usize..self.from[block as usize + 1] as usize]
    }
}

/// Disjoint sets; each is named after its lowest member.
struct Groups(Vec<u32>);

impl Groups {
    fn new(members: usize) -> Self {
        Self((0..members as u32).collect())
    }

    fn find(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let parent = self.0[member as usize];
            self.0[member as usize] = self.0[parent as usize];
            member = parent;
        }
        member
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        let (low, high) = (a.min(b), a.max(b));
        self.0[high as usize] = low;
    }
}

/// Sources from the glare pixels (ascending) of a luminance image and their luminances, cd/m²;
/// peaks taken out as the settings say.
pub(crate) fn find(
    pixels: &[u32],
    luminance: &[f32],
    geometry: &PixelGeometry,
    neighbourhood: &Neighbourhood,
    settings: &Settings,
) -> Vec<Source> {
    let mut groups = collect(&neighbourhood.group(pixels, geometry));
    let mut peaks = Vec::new();
    if let Some(limit) = settings.peak_limit {
        let bright = |&place: &u32| f64::from(luminance[place as usize]) >= limit;
        // evalglare looks for peaks only if something exceeds the limit, then takes all that reach it.
        if luminance.iter().any(|&l| f64::from(l) > limit) {
            let places: Vec<u32> = (0..pixels.len() as u32).filter(bright).collect();
            groups.iter_mut().for_each(|g| g.retain(|place| !bright(place)));
            groups.retain(|g| !g.is_empty());
            let peak_pixels: Vec<u32> = places.iter().map(|&place| pixels[place as usize]).collect();
            peaks = collect(&neighbourhood.group(&peak_pixels, geometry));
            peaks.iter_mut().flatten().for_each(|place| *place = places[*place as usize]);
        }
    }
    let sources = groups.into_iter().map(|g| (g, false)).chain(peaks.into_iter().map(|g| (g, true)));
    sources.map(|(g, is_peak)| describe(g, is_peak, pixels, luminance, geometry, settings)).collect()
}

/// Places by label, groups in the order of their first place.
fn collect(labels: &[u32]) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut group_of = vec![0usize; labels.len()];
    for (place, &label) in (0..).zip(labels) {
        if label == place {
            group_of[place as usize] = groups.len();
            groups.push(Vec::new());
        }
        groups[group_of[label as usize]].push(place);
    }
    groups
}

fn describe(places: Vec<u32>, is_peak: bool, pixels: &[u32], luminance: &[f32], geometry: &PixelGeometry, settings: &Settings) -> Source {
    let (mut solid_angle, mut flux, mut illuminance, mut peak) = (0.0, 0.0, 0.0, 0.0f64);
    let (mut x, mut y, mut direction) = (0.0, 0.0, [0.0; 3]);
    let (width, last_row) = (geometry.width as u32, geometry.height as u32 - 1);
    for &place in &places {
        let (p, l) = (pixels[place as usize], f64::from(luminance[place as usize]));
        let (column, row) = (p % width, last_row - p / width);
        let p = p as usize;
        let weight = l * geometry.solid_angles[p];
        solid_angle += geometry.solid_angles[p];
        flux += weight;
        illuminance += l * geometry.projected_solid_angles[p];
        peak = peak.max(l);
        x += weight * f64::from(column);
        y += weight * f64::from(row);
        let d = geometry.directions[p];
        direction = [direction[0] + weight * d[0], direction[1] + weight * d[1], direction[2] + weight * d[2]];
    }
    (x, y) = (x / flux, y / flux);
    let place = source_direction(x, y, direction, geometry, settings.convention);
    let frame = settings.convention.frame(geometry);
    let (sigma, tau) = angles(&frame, place);
    let mut pixels_of_source = places;
    pixels_of_source.iter_mut().for_each(|place| *place = pixels[*place as usize]);
    Source {
        pixels: pixels_of_source,
        x,
        y,
        direction: place,
        luminance: flux / solid_angle,
        peak_luminance: peak,
        solid_angle,
        illuminance,
        position_index: settings.position_index.of(&frame, place),
        sigma,
        tau,
        is_peak,
    }
}

fn source_direction(x: f64, y: f64, mean: [f64; 3], geometry: &PixelGeometry, convention: Convention) -> [f64; 3] {
    // A hair more than the centroid, so that rounding does not cut 12 - 1e-13 to 11.
    const HAIR: f64 = 1e-6;
    if convention == Convention::Evalglare {
        let (column, row) = ((x + HAIR) as usize, (y + HAIR) as usize);
        let pixel = (geometry.height - 1 - row.min(geometry.height - 1)) * geometry.width + column.min(geometry.width - 1);
        if geometry.is_inside(pixel) {
            return geometry.directions[pixel];
        }
    }
    // Sources lie in front of the viewer, so that their mean direction has a length; a source all
    // around the rim of a picture without middle is the exception.
    normalise(mean).unwrap_or(geometry.frame.forward)
}
