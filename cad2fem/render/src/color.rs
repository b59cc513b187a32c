//! Colours: transfer curve, colour maps and the palette of parts.

use std::sync::LazyLock;

/// Linear red, green and blue, 0 to 1.
pub type Rgb = [f32; 3];

/// Linear colour of a 24-bit sRGB code.
pub fn from_hex(code: u32) -> Rgb {
    [16, 8, 0].map(|shift| decode(((code >> shift) & 0xff) as f32 / 255.0))
}

/// sRGB → linear (IEC 61966-2-1).
fn decode(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Linear → sRGB (IEC 61966-2-1), clamped to 0..1.
pub fn encode(color: Rgb) -> Rgb {
    color.map(|v| match v.clamp(0.0, 1.0) {
        v if v <= 0.003_130_8 => 12.92 * v,
        v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    })
}

/// (1 − t) a + t b.
pub fn mix(a: Rgb, b: Rgb, t: f32) -> Rgb {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// Colour of the `i`-th part or tag. Neighbours differ in lightness as well as
/// in hue, so that they stay apart without colour vision.
pub fn palette(i: usize) -> Rgb {
    const CODES: [u32; 10] = [
        0x5b8db8, 0xe8a33d, 0x6aa564, 0xcf5f53, 0x8fc1c9, 0x9a76b3, 0xd9cf6a, 0x8a6a52, 0xe7a6b4,
        0x7d8791,
    ];
    from_hex(CODES[i % CODES.len()])
}

/// Colour of a body that nothing else gives a colour: silicone, tinted.
pub fn material() -> Rgb {
    from_hex(0x8cbf88)
}

/// Colour of a facet without a tag.
pub fn untagged() -> Rgb {
    from_hex(0xc9ccd1)
}

/// The inside of a surface whose outside has this colour.
pub fn inside(color: Rgb) -> Rgb {
    mix(color, from_hex(0xb5654a), 0.75)
}

/// The cut face of a body whose outside has this colour.
pub fn section(color: Rgb) -> Rgb {
    mix(color, from_hex(0xfff6e6), 0.5)
}

/// Viridis at 0, 0.1, ..., 1 (the public-domain map of matplotlib).
const VIRIDIS: [u32; 11] = [
    0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151,
    0xbddf26, 0xfde725,
];

const ENTRIES: usize = 512;
static TABLE: LazyLock<Vec<Rgb>> = LazyLock::new(table);

/// Colour of Viridis at `t` in 0..1, clamped.
pub fn viridis(t: f64) -> Rgb {
    TABLE[(t.clamp(0.0, 1.0) * (ENTRIES - 1) as f64).round() as usize]
}

/// The codes interpolated in sRGB, where the maps are near to uniform.
fn table() -> Vec<Rgb> {
    let stops: Vec<Rgb> = VIRIDIS.iter().map(|&code| encode(from_hex(code))).collect();
    (0..ENTRIES)
        .map(|i| {
            let x = i as f32 / (ENTRIES - 1) as f32 * (stops.len() - 1) as f32;
            let k = (x as usize).min(stops.len() - 2);
            mix(stops[k], stops[k + 1], x - k as f32).map(decode)
        })
        .collect()
}

/// A range of values, coloured from dark blue to yellow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value at the lower end.
    pub min: f64,
    /// Value at the upper end.
    pub max: f64,
}

impl Scale {
    /// Colour of a value.
    pub fn color(&self, value: f64) -> Rgb {
        let span = self.max - self.min;
        viridis(if span > 0.0 { (value - self.min) / span } else { 0.5 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_clamps_and_survives_a_constant_field() {
        let scale = Scale { min: 1.0, max: 3.0 };
        assert_eq!(scale.color(-5.0), from_hex(VIRIDIS[0]));
        assert_eq!(scale.color(9.0), viridis(1.0));
        let flat = Scale { max: 1.0, ..scale };
        assert_eq!(flat.color(1.0), viridis(0.5));
    }
}
