//! Pictures of a sheet: pixels as a PDF holds them.

use std::io::{Cursor, Write as _};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use mesh::io::{IoError, read_bytes};

/// Pixels of a picture.
pub struct Picture {
    /// Width and height [px].
    pub size: [u32; 2],
    /// Red, green and blue of each pixel, as zlib.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// Reads one of the PNG files that `fab` writes.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        let wrong = |message: String| IoError::content(path, message);
        let decoder = png::Decoder::new(Cursor::new(read_bytes(path)?));
        let mut reader = decoder.read_info().map_err(|e| wrong(e.to_string()))?;
        let length = reader.output_buffer_size().ok_or_else(|| wrong("too large".into()))?;
        let mut raw = vec![0; length];
        let info = reader.next_frame(&mut raw).map_err(|e| wrong(e.to_string()))?;
        if info.bit_depth != png::BitDepth::Eight || info.color_type != png::ColorType::Rgb {
            return Err(wrong("must have 8 bits of red, green and blue".into()));
        }
        Ok(Self { size: [info.width, info.height], pixels: packed(&raw[..info.buffer_size()]) })
    }

    /// Width over height.
    pub fn ratio(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }
}

/// Bytes as zlib.
pub fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // a vector takes all that is written to it
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.unwrap_or_default()
}
