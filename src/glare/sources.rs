//! Grouping of glare pixels into sources.
//!
//! Two glare pixels belong to one source if a chain of glare pixels joins them whose links are no
//! longer than half the search radius (evalglare takes its radius as a full angle). So the result
//! does not depend on the order of the pixels, and all sums run over ascending pixel numbers: it is
//! the same, bit for bit, however the pixels were found.

use super::geometry::{PixelGeometry, cross, dot, normalise};
use super::position::angles;
use super::{Settings, ViewFrame};

/// Where in the view a source stands; its position index and angles are those of this place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SourcePosition {
    /// The pixel whose column and row (from the bottom) are the centroid's cut to integers, as in
    /// evalglare. Half a pixel too far left and down on average, so that a mirrored picture gives
    /// slightly different results.
    #[default]
    TruncatedPixel,
    /// The mean direction weighted by luminance and solid angle.
    Centroid,
}

/// A glare source.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Its pixels, ascending.
    pub pixels: Vec<u32>,
    /// Column of its centroid weighted by luminance and solid angle, from the left, from 0.
    pub x: f64,
    /// Row of its centroid from the bottom, from 0.
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
    /// Whether it was taken out of another source for its luminance.
    pub is_peak: bool,
}

/// Two blocks of pixels that may hold neighbours.
#[derive(Debug, Clone, Copy)]
struct Pair {
    other: u32,
    /// Every pixel of one is within reach of every pixel of the other.
    surely: bool,
}

/// Which pixels of a view are within reach of one another: the view in small blocks, with the pairs
/// of blocks that may hold neighbours. Computed once per view and search radius.
#[derive(Debug, Clone)]
pub struct Neighbourhood {
    cos_reach: f64,
    block_of: Vec<u32>,
    /// Whether all pixels of a block are within reach of one another.
    tight: Vec<bool>,
    pairs_from: Vec<u32>,
    pairs: Vec<Pair>,
}

impl Neighbourhood {
    /// Neighbours by a search radius (rad, a full angle: pixels up to half of it apart are neighbours).
    pub fn new(geometry: &PixelGeometry, search_radius: f64) -> Self {
        let reach = (search_radius / 2.0).clamp(0.0, std::f64::consts::PI);
        // The largest block whose diagonal is within reach in the middle of the view.
        let side = (reach / (std::f64::consts::SQRT_2 * geometry.pixel_pitch())).floor().clamp(1.0, 64.0) as usize;
        let across = geometry.width.div_ceil(side);
        let blocks = across * geometry.height.div_ceil(side);
        let mut block_of = Vec::with_capacity(geometry.pixel_count());
        let mut sums = vec![[0.0; 3]; blocks];
        for i in 0..geometry.pixel_count() {
            let block = i / geometry.width / side * across + i % geometry.width / side;
            block_of.push(block as u32);
            if geometry.is_inside(i) {
                let d = geometry.directions[i];
                let s = &mut sums[block];
                *s = [s[0] + d[0], s[1] + d[1], s[2] + d[2]];
            }
        }
        // Caps around the blocks' pixels. A block without a mean direction gets the whole sphere.
        let centres: Vec<Option<[f64; 3]>> = sums.iter().map(|&s| normalise(s)).collect();
        let mut chords = vec![0.0f64; blocks];
        for (i, &block) in block_of.iter().enumerate() {
            if let (Some(c), true) = (centres[block as usize], geometry.is_inside(i)) {
                chords[block as usize] = chords[block as usize].max(distance_squared(c, geometry.directions[i]));
            }
        }
        const ROUNDING: f64 = 1e-9;
        let caps: Vec<Option<Cap>> = centres
            .iter()
            .zip(&chords)
            .map(|(c, &chord)| c.map(|centre| Cap { centre, radius: 2.0 * (chord.sqrt() / 2.0).min(1.0).asin() + ROUNDING }))
            .collect();
        let tight = caps.iter().map(|c| c.as_ref().is_some_and(|c| 2.0 * c.radius <= reach)).collect();
        let (pairs_from, pairs) = neighbouring_caps(&caps, reach);
        Self { cos_reach: reach.cos(), block_of, tight, pairs_from, pairs }
    }

    /// Groups pixels (ascending) of the geometry this was made for. The label of a group is the
    /// place in the list of its first pixel.
    pub fn group(&self, pixels: &[u32], geometry: &PixelGeometry) -> Vec<u32> {
        let mut groups = Groups::new(pixels.len());
        let blocks = Buckets::new(pixels, &self.block_of, self.tight.len());
        let direction = |place: u32| geometry.directions[pixels[place as usize] as usize];
        let near = |a: [f64; 3], b: u32| dot(a, direction(b)) >= self.cos_reach;
        for &block in &blocks.occupied {
            let here = blocks.places(block);
            for (n, &a) in here.iter().enumerate() {
                if self.tight[block as usize] {
                    groups.join(here[0], a);
                    continue;
                }
                let from = direction(a);
                here[n + 1..].iter().filter(|&&b| near(from, b)).for_each(|&b| groups.join(a, b));
            }
        }
        for &block in &blocks.occupied {
            let here = blocks.places(block);
            for pair in &self.pairs[self.pairs_from[block as usize] as usize..self.pairs_from[block as usize + 1] as usize] {
                let there = blocks.places(pair.other);
                if there.is_empty() {
                    continue;
                }
                let whole = self.tight[block as usize] && self.tight[pair.other as usize];
                if whole && groups.find(here[0]) == groups.find(there[0]) {
                    continue;
                }
                if pair.surely {
                    here.iter().for_each(|&a| groups.join(a, there[0]));
                    there.iter().for_each(|&b| groups.join(here[0], b));
                } else if whole {
                    if here.iter().any(|&a| there.iter().any(|&b| near(direction(a), b))) {
                        groups.join(here[0], there[0]);
                    }
                } else {
                    for &a in here {
                        there.iter().filter(|&&b| near(direction(a), b)).for_each(|&b| groups.join(a, b));
                    }
                }
            }
        }
        (0..pixels.len() as u32).map(|place| groups.find(place)).collect()
    }
}

#[derive(Debug, Clone, Copy)]
struct Cap {
    centre: [f64; 3],
    radius: f64,
}

fn distance_squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(d, d)
}

/// Pairs of caps with points within reach of one another: for each cap its partners of higher number.
fn neighbouring_caps(caps: &[Option<Cap>], reach: f64) -> (Vec<u32>, Vec<Pair>) {
    let widest = caps.iter().flatten().fold(0.0f64, |a, c| a.max(c.radius));
    // Centres further apart than this never matter; a grid of this spacing finds the others.
    let furthest = 2.0 * ((reach + 2.0 * widest).min(std::f64::consts::PI) / 2.0).sin();
    let spacing = furthest.max(2.0 / 64.0);
    let per_axis = (2.0 / spacing).floor() as usize + 1;
    let coordinate = |x: f64| (((x + 1.0) / spacing) as usize).min(per_axis - 1);
    let mut grid: Vec<Vec<u32>> = vec![Vec::new(); per_axis.pow(3)];
    let mut place_of = Vec::with_capacity(caps.len());
    for (i, cap) in caps.iter().enumerate() {
        let place = cap.map(|c| c.centre.map(coordinate));
        if let Some([x, y, z]) = place {
            grid[(z * per_axis + y) * per_axis + x].push(i as u32);
        }
        place_of.push(place);
    }
    let (mut from, mut pairs) = (vec![0], Vec::new());
    for (i, cap) in caps.iter().enumerate() {
        let first = pairs.len();
        if let (Some(a), Some([x, y, z])) = (cap, place_of[i]) {
            let around = |c: usize| c.saturating_sub(1)..=(c + 1).min(per_axis - 1);
            for (gz, gy, gx) in around(z).flat_map(|gz| around(y).flat_map(move |gy| around(x).map(move |gx| (gz, gy, gx)))) {
                for &j in grid[(gz * per_axis + gy) * per_axis + gx].iter().filter(|&&j| j as usize > i) {
                    let Some(b) = caps[j as usize] else { continue };
                    if distance_squared(a.centre, b.centre) > furthest * furthest {
                        continue;
                    }
                    let apart = dot(cross(a.centre, b.centre), cross(a.centre, b.centre)).sqrt().atan2(dot(a.centre, b.centre));
                    if apart - a.radius - b.radius <= reach {
                        pairs.push(Pair { other: j, surely: apart + a.radius + b.radius <= reach });
                    }
                }
            }
        }
        pairs[first..].sort_unstable_by_key(|p: &Pair| p.other);
        from.push(pairs.len() as u32);
    }
    (from, pairs)
}

/// Places of a pixel list, sorted by block.
struct Buckets {
    occupied: Vec<u32>,
    from: Vec<u32>,
    places: Vec<u32>,
}

impl Buckets {
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
        let mut places = vec![0; pixels.len()];
        for (place, &p) in pixels.iter().enumerate() {
            let slot = &mut next[block_of[p as usize] as usize];
            places[*slot as usize] = place as u32;
            *slot += 1;
        }
        Self { occupied, from, places }
    }

    fn places(&self, block: u32) -> &[u32] {
        &self.places[self.from[block as usize] as usize..self.from[block as usize + 1] as usize]
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

/// Sources of a luminance image from its glare pixels (ascending), peaks taken out as the settings say.
pub fn find(
    luminance: &[f32],
    pixels: &[u32],
    geometry: &PixelGeometry,
    neighbourhood: &Neighbourhood,
    settings: &Settings,
) -> Vec<Source> {
    let mut groups = collect(pixels, &neighbourhood.group(pixels, geometry));
    let mut peaks = Vec::new();
    if let Some(limit) = settings.peak_limit {
        let bright = |&p: &u32| f64::from(luminance[p as usize]) >= limit;
        let peak_pixels: Vec<u32> = pixels.iter().copied().filter(bright).collect();
        // evalglare looks for peaks only if something exceeds the limit, then takes all that reach it.
        if peak_pixels.iter().any(|&p| f64::from(luminance[p as usize]) > limit) {
            groups.iter_mut().for_each(|g| g.retain(|p| !bright(p)));
            groups.retain(|g| !g.is_empty());
            peaks = collect(&peak_pixels, &neighbourhood.group(&peak_pixels, geometry));
        }
    }
    let sources = groups.into_iter().map(|g| (g, false)).chain(peaks.into_iter().map(|g| (g, true)));
    sources.map(|(g, is_peak)| describe(g, is_peak, luminance, geometry, settings)).collect()
}

/// Pixels by label, groups in the order of their first pixel.
fn collect(pixels: &[u32], labels: &[u32]) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut group_of = vec![0usize; pixels.len()];
    for (place, (&pixel, &label)) in pixels.iter().zip(labels).enumerate() {
        if label as usize == place {
            group_of[place] = groups.len();
            groups.push(Vec::new());
        }
        groups[group_of[label as usize]].push(pixel);
    }
    groups
}

fn describe(pixels: Vec<u32>, is_peak: bool, luminance: &[f32], geometry: &PixelGeometry, settings: &Settings) -> Source {
    let (mut solid_angle, mut flux, mut illuminance, mut peak) = (0.0, 0.0, 0.0, 0.0f64);
    let (mut x, mut y, mut direction) = (0.0, 0.0, [0.0; 3]);
    for &p in &pixels {
        let p = p as usize;
        let l = f64::from(luminance[p]);
        let weight = l * geometry.solid_angles[p];
        solid_angle += geometry.solid_angles[p];
        flux += weight;
        illuminance += l * geometry.projected_solid_angles[p];
        peak = peak.max(l);
        x += weight * (p % geometry.width) as f64;
        y += weight * (geometry.height - 1 - p / geometry.width) as f64;
        let d = geometry.directions[p];
        direction = [direction[0] + weight * d[0], direction[1] + weight * d[1], direction[2] + weight * d[2]];
    }
    (x, y) = (x / flux, y / flux);
    let place = source_direction(x, y, direction, geometry, settings.source_position);
    let frame: &ViewFrame = &geometry.frame;
    let (sigma, tau) = angles(frame, place);
    Source {
        x,
        y,
        direction: place,
        luminance: flux / solid_angle,
        peak_luminance: peak,
        solid_angle,
        illuminance,
        position_index: settings.position_index.of(frame, place),
        sigma,
        tau,
        is_peak,
        pixels,
    }
}

fn source_direction(x: f64, y: f64, mean: [f64; 3], geometry: &PixelGeometry, position: SourcePosition) -> [f64; 3] {
    // A hair more than the centroid, so that rounding does not cut 12 - 1e-13 to 11.
    const HAIR: f64 = 1e-6;
    if position == SourcePosition::TruncatedPixel {
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
