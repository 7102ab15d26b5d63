//! The packets that show an image in tev, and what of it the viewer has.

use kaustika_math::mix_bits;

use crate::Picture;

/// Side of a tile in pixels.
pub(super) const TILE: usize = 128;

/// Packet types.
const CLOSE_IMAGE: u8 = 2;
const CREATE_IMAGE: u8 = 4;
/// Several channels a packet, one whole channel after the other.
const UPDATE_IMAGE_V2: u8 = 5;

/// What the viewer has of an image.
#[derive(Debug)]
pub(super) struct Shown {
    pub name: String,
    pub width: usize,
    pub height: usize,
    pub channels: Vec<String>,
    pub is_created: bool,
    /// Hash of what was sent last for each tile, row after row.
    pub tiles: Vec<Option<u64>>,
}

/// A rectangle of pixels.
pub(super) struct Area {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

impl Area {
    /// The pixels of one channel, row after row.
    fn values<'a>(&'a self, data: &'a [f32], stride: usize) -> impl Iterator<Item = f32> + 'a {
        let rows = (self.y..self.y + self.height).map(move |y| y * stride + self.x);
        rows.flat_map(move |start| data[start..start + self.width].iter().copied())
    }

    pub fn hash(&self, picture: &Picture) -> u64 {
        let stride = picture.width as usize;
        let values = picture.channels.iter().flat_map(|c| self.values(&c.data, stride));
        values.fold(0, |hash, v| mix_bits(hash ^ v.to_bits() as u64).wrapping_add(1))
    }
}

impl Shown {
    pub fn tile(&self, t: usize) -> Area {
        let columns = self.width.div_ceil(TILE);
        let (x, y) = (t % columns * TILE, t / columns * TILE);
        Area { x, y, width: TILE.min(self.width - x), height: TILE.min(self.height - y) }
    }

    pub fn create_packet(&self) -> Vec<u8> {
        let mut packet = Packet::new(CREATE_IMAGE);
        packet.flag(true);
        packet.text(&self.name);
        packet.int(self.width);
        packet.int(self.height);
        packet.names(&self.channels);
        packet.finish()
    }

    pub fn close_packet(&self) -> Vec<u8> {
        let mut packet = Packet::new(CLOSE_IMAGE);
        packet.text(&self.name);
        packet.finish()
    }

    pub fn update_packet(&self, area: &Area, picture: &Picture) -> Vec<u8> {
        let mut packet = Packet::new(UPDATE_IMAGE_V2);
        packet.flag(false);
        packet.text(&self.name);
        packet.names(&self.channels);
        for n in [area.x, area.y, area.width, area.height] {
            packet.int(n);
        }
        for channel in &picture.channels {
            for v in area.values(&channel.data, self.width) {
                packet.0.extend(v.to_le_bytes());
            }
        }
        packet.finish()
    }
}

/// A packet under construction; its length is filled in at the end.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8) -> Self {
        Packet(vec![0, 0, 0, 0, kind])
    }

    fn flag(&mut self, value: bool) {
        self.0.push(value as u8);
    }

    /// Text ends in a zero byte, so that it cannot contain one.
    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&b| b != 0));
        self.0.push(0);
    }

    /// Sizes of pictures are below 2³¹ by the limits of the files they come from and go to.
    fn int(&mut self, value: usize) {
        self.0.extend((value as i32).to_le_bytes());
    }

    fn names(&mut self, names: &[String]) {
        self.int(names.len());
        for name in names {
            self.text(name);
        }
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}
