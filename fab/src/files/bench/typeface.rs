//! The two weights of the typeface that the sheet is set in: those of the crate `render`, subsets of Inter.

use ttf_parser::{Face, GlyphId, Tag};

const REGULAR: &[u8] = include_bytes!("../../../../cad2fem/render/fonts/Inter-Regular.otf");
const BOLD: &[u8] = include_bytes!("../../../../cad2fem/render/fonts/Inter-Bold.otf");

/// One weight.
pub struct Typeface {
    face: Face<'static>,
    /// Name of the typeface in the PDF file.
    pub name: &'static str,
}

/// Both weights.
pub struct Typefaces {
    /// For text.
    pub regular: Typeface,
    /// For headings and numbers to be weighed.
    pub bold: Typeface,
}

impl Typefaces {
    /// The weights that are built in.
    pub fn new() -> Self {
        let read = |bytes, name| {
            let face = Face::parse(bytes, 0).expect("tests read the fonts");
            Typeface { face, name }
        };
        Self { regular: read(REGULAR, "Inter-Regular"), bold: read(BOLD, "Inter-Bold") }
    }

    /// One of them.
    pub fn of(&self, bold: bool) -> &Typeface {
        if bold { &self.bold } else { &self.regular }
    }
}

impl Default for Typefaces {
    fn default() -> Self {
        Self::new()
    }
}

impl Typeface {
    /// The glyph of a character; that of a question mark where the typeface has none.
    pub fn glyph(&self, character: char) -> u16 {
        let known = self.face.glyph_index(character).or_else(|| self.face.glyph_index('?'));
        known.unwrap_or(GlyphId(0)).0
    }

    /// Width of a text [same unit as `size`].
    pub fn width(&self, text: &str, size: f64) -> f64 {
        text.chars().map(|c| self.advance(self.glyph(c))).sum::<f64>() * size / 1e3
    }

    /// Width of a glyph [thousandths of the size].
    pub fn advance(&self, glyph: u16) -> f64 {
        let units = f64::from(self.face.units_per_em());
        f64::from(self.face.glyph_hor_advance(GlyphId(glyph)).unwrap_or(0)) * 1e3 / units
    }

    /// How many glyphs it has.
    pub fn glyphs(&self) -> u16 {
        self.face.number_of_glyphs()
    }

    /// The outlines, as a PDF holds them (Compact Font Format).
    pub fn outlines(&self) -> &'static [u8] {
        let table = self.face.raw_face().table(Tag::from_bytes(b"CFF "));
        table.expect("tests read the fonts")
    }

    /// Box around all glyphs, highest and lowest point of letters, height of capitals
    /// [thousandths of the size].
    pub fn measures(&self) -> ([f32; 4], [f32; 3]) {
        let thousandths = |x: i16| f32::from(x) * 1e3 / f32::from(self.face.units_per_em());
        let all = self.face.global_bounding_box();
        let capital = self.face.capital_height().unwrap_or(self.face.ascender());
        let heights = [self.face.ascender(), self.face.descender(), capital];
        ([all.x_min, all.y_min, all.x_max, all.y_max].map(thousandths), heights.map(thousandths))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fonts_are_there_and_measure() {
        let faces = Typefaces::new();
        for face in [&faces.regular, &faces.bold] {
            assert!(face.outlines().len() > 10_000 && face.glyphs() > 100);
            assert_eq!(face.glyph('\u{4e2d}'), face.glyph('?'), "one that it does not have");
            let [narrow, wide] = ["iii", "WWW"].map(|text| face.width(text, 10.0));
            assert!(narrow < 0.5 * wide && wide < 40.0, "{narrow} {wide}");
        }
    }
}
