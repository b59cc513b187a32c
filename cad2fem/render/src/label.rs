//! Names written on the pieces of a picture, where they are seen best.
//!
//! Where a piece is seen, its label is centred on the pixel with the largest square around it
//! that shows nothing else. A label that would cover an earlier one, of a piece that is seen
//! better, is left out, as is that of a piece that is not seen.

use super::Piece;
use super::annotate::Type;
use super::camera::Camera;
use super::font::{Anchor, Style, draw, width};
use super::image::Image;
use super::zbuffer::{NOTHING, Samples};

/// Paper behind a label, and how much of it covers the picture.
const PAPER: ([f32; 3], f32) = ([1.0; 3], 0.78);

/// Where a piece is seen best.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    piece: usize,
    /// Pixels from the centre to the border of the square.
    reach: u32,
    /// The centre [px].
    at: [f64; 2],
}

/// Writes labels on the pieces that a panel of `size` pixels shows with its upper left corner at
/// `corner`, the largest first. Returns the numbers of the pieces that have none.
pub fn write(
    image: &mut Image,
    pieces: &[Piece],
    labels: &[String],
    camera: &Camera,
    size: [usize; 2],
    corner: [usize; 2],
    ty: &Type,
) -> Vec<usize> {
    let style = ty.text();
    let mut places = places(&owners(pieces, camera, size), pieces.len(), size[0]);
    places.sort_by_key(|place| (std::cmp::Reverse(place.reach), place.piece));
    let mut written: Vec<[[f64; 2]; 2]> = Vec::new();
    let mut missing: Vec<usize> = (0..labels.len()).filter(|&i| !labels[i].is_empty()).collect();
    for place in places {
        let Some(text) = labels.get(place.piece).filter(|text| !text.is_empty()) else { continue };
        let at = [0, 1].map(|k| place.at[k] + corner[k] as f64);
        let paper = paper(text, at, &style);
        if written.iter().any(|other| overlap(other, &paper)) {
            continue;
        }
        image.fill(paper[0], paper[1], PAPER.0, PAPER.1);
        draw(image, text, [at[0], at[1] + 0.5 * style.height], Anchor::Center, &style);
        written.push(paper);
        missing.retain(|&piece| piece != place.piece);
    }
    missing
}

/// Upper left and lower right corner of the paper of a text that is centred at a point.
fn paper(text: &str, at: [f64; 2], style: &Style) -> [[f64; 2]; 2] {
    let half = [0.5 * width(text, style) + 0.5 * style.height, style.height];
    [[at[0] - half[0], at[1] - half[1]], [at[0] + half[0], at[1] + half[1]]]
}

fn overlap(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> bool {
    (0..2).all(|k| a[0][k] < b[1][k] && b[0][k] < a[1][k])
}

/// Which piece each pixel shows; [`NOTHING`] for the background.
fn owners(pieces: &[Piece], camera: &Camera, size: [usize; 2]) -> Vec<u32> {
    let mut samples = Samples::new(size[0], size[1], 0);
    for (number, piece) in pieces.iter().enumerate() {
        for facet in &piece.facets {
            samples.draw(number as u32, &facet.points.each_ref().map(|p| camera.project(p)));
        }
    }
    samples.ids
}

/// Where each piece that is seen is seen best: the chessboard distance of each pixel to the next
/// one of another piece, by one pass from the upper left and one back.
fn places(owners: &[u32], pieces: usize, columns: usize) -> Vec<Place> {
    let mut reach = vec![0_u32; owners.len()];
    let same = |i: usize, j: usize| owners[i] == owners[j];
    let before = [1, columns - 1, columns, columns + 1];
    for i in 0..owners.len() {
        if i >= columns && i % columns > 0 && (i + 1) % columns > 0 {
            let nearest =
                before.map(|back| if same(i, i - back) { reach[i - back] + 1 } else { 0 });
            reach[i] = nearest.into_iter().min().unwrap_or(0);
        }
    }
    for i in (0..owners.len()).rev() {
        if i + columns < owners.len() && i % columns > 0 && (i + 1) % columns > 0 {
            let next = before.map(|on| if same(i, i + on) { reach[i + on] + 1 } else { 0 });
            reach[i] = next.into_iter().fold(reach[i], u32::min);
        } else {
            reach[i] = 0;
        }
    }
    let mut best: Vec<(u32, Vec<usize>)> = vec![(0, Vec::new()); pieces];
    for (i, &owner) in owners.iter().enumerate().filter(|(_, owner)| **owner != NOTHING) {
        let (most, pixels) = &mut best[owner as usize];
        if reach[i] > *most {
            (*most, *pixels) = (reach[i], Vec::new());
        }
        if reach[i] == *most {
            pixels.push(i);
        }
    }
    let place = |(piece, (reach, pixels)): (usize, (u32, Vec<usize>))| {
        let middle = *pixels.get(pixels.len() / 2)?;
        let at = [middle % columns, middle / columns].map(|k| k as f64 + 0.5);
        Some(Place { piece, reach, at })
    };
    best.into_iter().enumerate().filter_map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_stands_in_the_middle_of_the_widest_part_that_is_seen() {
        // piece 0 is a frame around piece 1 with a wide left side, piece 2 is hidden
        let (columns, rows) = (40, 20);
        let owner = |i: usize| match (i % columns, i / columns) {
            (x, y) if (1..39).contains(&x) && (1..19).contains(&y) => {
                u32::from((20..36).contains(&x) && (4..16).contains(&y))
            }
            _ => NOTHING,
        };
        let owners: Vec<u32> = (0..columns * rows).map(owner).collect();
        let found = places(&owners, 3, columns);
        assert_eq!(found.iter().map(|place| place.piece).collect::<Vec<_>>(), [0, 1]);
        // 18 rows and 19 columns of the frame, 12 rows of the piece within: squares around a pixel
        assert_eq!((found[0].reach, found[1].reach), (8, 5));
        let [x, y] = found[0].at;
        assert!(x > 8.0 && x < 13.0 && y > 8.0 && y < 12.0, "{x} {y}");
        let [x, y] = found[1].at;
        assert!(x > 25.0 && x < 31.0 && y > 8.0 && y < 12.0, "{x} {y}");
    }
}
