//! Marks on pages as a PDF file: no date, so that the same marks are the same bits.

use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

use super::layout::{Mark, PAGE};
use super::picture::{Picture, packed};
use super::typeface::{Typeface, Typefaces};

const IDENTITY: SystemInfo =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
/// Names of the regular and the bold typeface in the resources of a page.
const FONTS: [Name; 2] = [Name(b"R"), Name(b"B")];
/// Grey of lines [1].
const GREY: f32 = 0.72;

/// The file with a title.
pub fn file(title: &str, pages: &[Vec<Mark>], pictures: &[Picture], faces: &Typefaces) -> Vec<u8> {
    let mut pdf = Pdf::new();
    let mut next = Ref::new(1);
    let mut new = || next.bump();
    let (catalog, tree, information) = (new(), new(), new());
    let fonts = [&faces.regular, &faces.bold].map(|face| font(&mut pdf, face, &mut new));
    let images: Vec<Ref> = pictures.iter().map(|one| image(&mut pdf, one, new())).collect();
    let mut leaves = Vec::new();
    for marks in pages {
        let (leaf, stream) = (new(), new());
        leaves.push(leaf);
        let drawn = packed(&content(marks, faces));
        pdf.stream(stream, &drawn).filter(Filter::FlateDecode);
        let mut page = pdf.page(leaf);
        let [width, height] = PAGE.map(|x| x as f32);
        page.media_box(Rect::new(0.0, 0.0, width, height)).parent(tree).contents(stream);
        let mut resources = page.resources();
        resources.fonts().pairs(FONTS.into_iter().zip(fonts));
        let mut objects = resources.x_objects();
        for (i, image) in images.iter().enumerate() {
            objects.pair(Name(image_name(i).as_bytes()), *image);
        }
    }
    pdf.catalog(catalog).pages(tree);
    pdf.pages(tree).count(leaves.len() as i32).kids(leaves);
    let mut about = pdf.document_info(information);
    about.title(TextStr(title));
    about.producer(TextStr(concat!("fab ", env!("CARGO_PKG_VERSION"))));
    about.finish();
    pdf.finish()
}

fn image_name(number: usize) -> String {
    format!("I{number}")
}

fn image(pdf: &mut Pdf, picture: &Picture, id: Ref) -> Ref {
    let mut object = pdf.image_xobject(id, &picture.pixels);
    let [width, height] = picture.size.map(|n| n as i32);
    object.width(width).height(height).bits_per_component(8).filter(Filter::FlateDecode);
    object.color_space().device_rgb();
    id
}

/// The drawing of a page.
fn content(marks: &[Mark], faces: &Typefaces) -> Vec<u8> {
    let mut out = Content::new();
    let single = |at: &[f64; 2]| at.map(|x| x as f32);
    out.set_stroke_gray(GREY).set_line_width(0.6);
    for mark in marks {
        match mark {
            Mark::Text { at, size, bold, text } => {
                let ([x, y], face) = (single(at), faces.of(*bold));
                let glyphs: Vec<u8> =
                    text.chars().flat_map(|c| face.glyph(c).to_be_bytes()).collect();
                out.begin_text().set_font(FONTS[usize::from(*bold)], *size as f32);
                out.next_line(x, y).show(Str(&glyphs)).end_text();
            }
            Mark::Line { at, along } => {
                let ([x, y], [dx, dy]) = (single(at), single(along));
                out.move_to(x, y).line_to(x + dx, y + dy).stroke();
            }
            Mark::Square { at, side } => {
                let ([x, y], side) = (single(at), *side as f32);
                out.save_state().set_stroke_gray(0.2);
                out.rect(x, y, side, side).stroke().restore_state();
            }
            Mark::Picture { number, at, size } => {
                let ([x, y], [width, height]) = (single(at), single(size));
                out.save_state().transform([width, 0.0, 0.0, height, x, y]);
                out.x_object(Name(image_name(*number).as_bytes())).restore_state();
            }
        }
    }
    out.finish().to_vec()
}

/// A typeface with all of its glyphs, by whose numbers texts are written.
fn font(pdf: &mut Pdf, face: &Typeface, new: &mut impl FnMut() -> Ref) -> Ref {
    let [id, descendant, descriptor, outlines, letters] = std::array::from_fn(|_| new());
    let name = Name(face.name.as_bytes());
    pdf.type0_font(id)
        .base_font(name)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(descendant)
        .to_unicode(letters);
    let mut cid = pdf.cid_font(descendant);
    cid.subtype(CidFontType::Type0).base_font(name).system_info(IDENTITY);
    cid.font_descriptor(descriptor).default_width(0.0);
    cid.widths().consecutive(0, (0..face.glyphs()).map(|glyph| face.advance(glyph) as f32));
    cid.finish();
    let ([left, low, right, high], [ascent, descent, capital]) = face.measures();
    pdf.font_descriptor(descriptor)
        .name(name)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(left, low, right, high))
        .italic_angle(0.0)
        .ascent(ascent)
        .descent(descent)
        .cap_height(capital)
        .stem_v(90.0)
        .font_file3(outlines);
    let bytes = packed(face.outlines());
    let mut file = pdf.stream(outlines, &bytes);
    file.filter(Filter::FlateDecode);
    file.pair(Name(b"Subtype"), Name(b"CIDFontType0C"));
    file.finish();
    let mut map = UnicodeCmap::new(Name(b"Custom"), IDENTITY);
    // what the subset has lies below
    for character in '\u{20}'..'\u{2600}' {
        let glyph = face.glyph(character);
        if character == '?' || glyph != face.glyph('?') {
            map.pair(glyph, character);
        }
    }
    pdf.cmap(letters, &map.finish());
    id
}
