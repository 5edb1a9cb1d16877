//! The pixels of a view that can be glare, in tiles: what a detector works on.

/// Pixels of a tile across.
pub(super) const TILE_WIDTH: usize = 16;
/// Rows of pixels in a tile and in a band.
pub(super) const TILE_HEIGHT: usize = 4;
/// Places for pixels in a tile.
pub(super) const SLOTS: usize = TILE_WIDTH * TILE_HEIGHT;
/// Place without a pixel.
const NO_PIXEL: u32 = u32::MAX;

/// Four lines of pixels of a view, in tiles.
pub(super) struct Band {
    pub tiles: Vec<Tile>,
    /// `[tile][term][slot]`
    pub values: Vec<f32>,
    /// Greatest value of each tile, `[tile][term]`.
    pub greatest: Vec<f32>,
    /// Least value.
    pub least: Vec<f32>,
    pub first_line: usize,
}

/// Up to [`SLOTS`] pixels near one another.
pub(super) struct Tile {
    /// Ascending; [`NO_PIXEL`] behind the last.
    pixels: [u32; SLOTS],
    pub used: usize,
}

impl Tile {
    pub fn pixels(&self) -> &[u32] {
        &self.pixels[..self.used]
    }
}

impl Band {
    /// No tiles yet.
    pub fn new(first_line: usize) -> Self {
        Self { tiles: Vec::new(), values: Vec::new(), greatest: Vec::new(), least: Vec::new(), first_line }
    }

    /// Bytes that it occupies.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.values) + size_of_val(&*self.greatest) * 2 + size_of_val(&*self.tiles)) as u64
    }

    /// Begins the next tile.
    pub(crate) fn begin_tile(&mut self) {
        self.tiles.push(Tile { pixels: [NO_PIXEL; SLOTS], used: 0 });
    }

    /// Drops the last tile if it got no pixel.
    pub(crate) fn end_tile(&mut self) {
        self.tiles.pop_if(|tile| tile.used == 0);
    }

    /// Adds a pixel to the last tile.
    pub fn put(&mut self, pixel: usize, row: &[f32]) {
        let terms = row.len();
        let Some(tile) = self.tiles.last_mut() else { return };
        if tile.used == 0 {
            self.values.resize(self.values.len() + terms * SLOTS, 0.0);
            self.greatest.extend_from_slice(row);
            self.least.extend_from_slice(row);
        }
        let (values, bounds) = (self.values.len() - terms * SLOTS, self.greatest.len() - terms);
        for (k, &v) in row.iter().enumerate() {
            self.values[values + k * SLOTS + tile.used] = v;
            self.greatest[bounds + k] = self.greatest[bounds + k].max(v);
            self.least[bounds + k] = self.least[bounds + k].min(v);
        }
        tile.pixels[tile.used] = pixel as u32;
        tile.used += 1;
    }
}
