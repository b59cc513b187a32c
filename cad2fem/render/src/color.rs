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

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Map {
    /// Perceptually uniform, dark blue to yellow: for magnitudes.
    Viridis,
    /// Blue, light grey, red: for values on both sides of zero.
    Diverging,
}

/// Viridis at 0, 0.1, ..., 1 (the public-domain map of matplotlib).
const VIRIDIS: [u32; 11] = [
    0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151,
    0xbddf26, 0xfde725,
];
const DIVERGING: [u32; 9] =
    [0x2a4b8d, 0x4a78b5, 0x85a9d1, 0xbfd0e0, 0xeae6e1, 0xe8c3b0, 0xd98f78, 0xbd5a4c, 0x8f2732];

const ENTRIES: usize = 512;
static TABLES: LazyLock<[Vec<Rgb>; 2]> = LazyLock::new(|| [table(&VIRIDIS), table(&DIVERGING)]);

impl Map {
    /// Colour at `t` in 0..1, clamped.
    pub fn at(self, t: f64) -> Rgb {
        let index = (t.clamp(0.0, 1.0) * (ENTRIES - 1) as f64).round() as usize;
        TABLES[self as usize][index]
    }
}

/// The codes interpolated in sRGB, where the maps are near to uniform.
fn table(codes: &[u32]) -> Vec<Rgb> {
    let stops: Vec<Rgb> = codes.iter().map(|&code| encode(from_hex(code))).collect();
    (0..ENTRIES)
        .map(|i| {
            let x = i as f32 / (ENTRIES - 1) as f32 * (stops.len() - 1) as f32;
            let k = (x as usize).min(stops.len() - 2);
            mix(stops[k], stops[k + 1], x - k as f32).map(decode)
        })
        .collect()
}

/// A range of values and the map that colours it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value at the lower end.
    pub min: f64,
    /// Value at the upper end.
    pub max: f64,
    /// Colours from lower to upper end.
    pub map: Map,
}

impl Scale {
    /// Colour of a value.
    pub fn color(&self, value: f64) -> Rgb {
        let span = self.max - self.min;
        self.map.at(if span > 0.0 { (value - self.min) / span } else { 0.5 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_is_its_own_inverse() {
        for code in [0x000000, 0x01020a, 0x7f8081, 0xffffff] {
            let back = encode(from_hex(code)).map(|v| (255.0 * v).round() as u32);
            assert_eq!((back[0] << 16) | (back[1] << 8) | back[2], code);
        }
    }

    #[test]
    fn viridis_gets_lighter_all_the_way() {
        let luminance = |c: Rgb| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        let steps: Vec<f32> =
            (0..=32).map(|i| luminance(Map::Viridis.at(f64::from(i) / 32.0))).collect();
        assert!(steps.windows(2).all(|w| w[0] < w[1]), "{steps:?}");
    }

    #[test]
    fn scale_clamps_and_survives_a_constant_field() {
        let scale = Scale { min: 1.0, max: 3.0, map: Map::Viridis };
        assert_eq!(scale.color(-5.0), from_hex(VIRIDIS[0]));
        assert_eq!(scale.color(9.0), Map::Viridis.at(1.0));
        let flat = Scale { max: 1.0, ..scale };
        assert_eq!(flat.color(1.0), Map::Viridis.at(0.5));
    }
}
