//! Blocks of text, tables and pictures, one below the other, on pages of A4.
//!
//! Lengths are points, 1/72 inch; heights count from the lower edge of the page, as in a PDF.

use super::picture::Picture;
use super::typeface::Typefaces;

/// A page of A4.
pub const PAGE: [f64; 2] = [595.28, 841.89];
/// Distance of the content from the left and right edge.
const SIDE: f64 = 45.0;
/// Distance of the first line from the upper edge.
const TOP: f64 = 48.0;
/// Distance of the last line from the lower edge, above the footer.
const BOTTOM: f64 = 62.0;
/// Width of the content.
pub const WIDTH: f64 = PAGE[0] - 2.0 * SIDE;
/// Size of text, before it is scaled.
const TEXT: f64 = 9.5;
/// From one line to the next, in sizes.
const LEADING: f64 = 1.32;

/// A text that is as wide as its column fits, whatever the order in which widths were added.
const WIDTH_ROUNDING: f64 = 1e-6;
/// Text is made smaller down to this so that one page is enough, and down to the least for two.
const ONE_PAGE: f64 = 0.85;
const LEAST: f64 = 0.76;

/// What is drawn on a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// Letters whose baseline begins at a point.
    Text {
        /// The point.
        at: [f64; 2],
        /// Size of the letters.
        size: f64,
        /// Whether they are bold.
        bold: bool,
        /// The letters.
        text: String,
    },
    /// A line.
    Line {
        /// Where it begins.
        at: [f64; 2],
        /// From there to its end.
        along: [f64; 2],
    },
    /// A square to be ticked, by its lower left corner.
    Square {
        /// The corner.
        at: [f64; 2],
        /// Length of a side.
        side: f64,
    },
    /// A picture, by its number and its lower left corner.
    Picture {
        /// Number of the picture.
        number: usize,
        /// The corner.
        at: [f64; 2],
        /// Width and height of the picture.
        size: [f64; 2],
    },
}

/// A part of the sheet.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// What the sheet is of, and what stands at the right of it.
    Title(String, String),
    /// What follows.
    Heading(String),
    /// A paragraph; a bold one is a warning.
    Text(String, bool),
    /// A table with its head; columns are as wide as their contents, the last one takes the rest.
    Table(Vec<&'static str>, Vec<Vec<String>>),
    /// Steps to be ticked, in order.
    Steps(Vec<String>),
    /// Pictures beside each other, by their numbers.
    Pictures(Vec<usize>),
}

/// Pages on which all blocks are: one, if text of 85 % of its size makes that possible, or else two, if text of
/// 76 % does; the text is as large as it can be.
pub fn pages(blocks: &[Block], pictures: &[Picture], faces: &Typefaces) -> Vec<Vec<Mark>> {
    let at = |scale: f64| {
        let mut flow = Flow { faces, pictures, scale, y: PAGE[1] - TOP, pages: vec![Vec::new()] };
        blocks.iter().for_each(|block| flow.add(block));
        flow.pages
    };
    let down_to =
        |least: f64| (0..).map(|i| 1.0 - 0.03 * f64::from(i)).take_while(move |s| *s >= least);
    let one = down_to(ONE_PAGE).map(at).find(|pages| pages.len() == 1);
    one.or_else(|| down_to(LEAST).map(at).find(|pages| pages.len() == 2))
        .unwrap_or_else(|| at(LEAST))
}

/// Where the next block goes.
struct Flow<'a> {
    faces: &'a Typefaces,
    pictures: &'a [Picture],
    scale: f64,
    y: f64,
    pages: Vec<Vec<Mark>>,
}

impl Flow<'_> {
    fn mark(&mut self, mark: Mark) {
        self.pages.last_mut().expect("there is a page").push(mark);
    }

    /// Begins a page if less than a height is left.
    fn room(&mut self, height: f64) {
        if self.y - height < BOTTOM {
            self.pages.push(Vec::new());
            self.y = PAGE[1] - TOP;
        }
    }

    fn size(&self) -> f64 {
        TEXT * self.scale
    }

    fn leading(&self) -> f64 {
        self.size() * LEADING
    }

    fn text(&mut self, x: f64, text: &str, size: f64, bold: bool) {
        let at = [SIDE + x, self.y];
        self.mark(Mark::Text { at, size, bold, text: text.into() });
    }

    fn add(&mut self, block: &Block) {
        match block {
            Block::Title(title, right) => self.title(title, right),
            Block::Heading(text) => self.heading(text),
            Block::Text(text, bold) => {
                self.paragraph(0.0, text, *bold);
                self.y -= 0.35 * self.leading();
            }
            Block::Table(head, rows) => self.table(head, rows),
            Block::Steps(steps) => self.steps(steps),
            Block::Pictures(numbers) => self.beside(numbers),
        }
    }

    fn title(&mut self, title: &str, right: &str) {
        let (large, small) = (17.0, self.size());
        self.y -= large * 0.4;
        let free = WIDTH - self.faces.regular.width(right, small) - 12.0;
        let line = self.wrapped(title, large, true, free).into_iter().next().unwrap_or_default();
        self.text(0.0, &line, large, true);
        let x = WIDTH - self.faces.regular.width(right, small);
        self.text(x, right, small, false);
        self.y -= 7.0;
        let at = [SIDE, self.y];
        self.mark(Mark::Line { at, along: [WIDTH, 0.0] });
        self.y -= 1.3 * self.leading();
    }

    fn heading(&mut self, text: &str) {
        self.y -= 0.45 * self.leading();
        // a heading is not left alone at the end of a page
        self.room(4.0 * self.leading());
        self.text(0.0, text, 1.18 * self.size(), true);
        self.y -= 1.3 * self.leading();
    }

    /// Lines from a distance from the left on.
    fn paragraph(&mut self, x: f64, text: &str, bold: bool) {
        for line in self.wrapped(text, self.size(), bold, WIDTH - x) {
            self.room(0.0);
            self.text(x, &line, self.size(), bold);
            self.y -= self.leading();
        }
    }

    fn steps(&mut self, steps: &[String]) {
        let indent = 34.0 * self.scale;
        for (i, step) in steps.iter().enumerate() {
            let lines = self.wrapped(step, self.size(), false, WIDTH - indent).len();
            self.room((lines - 1).min(5) as f64 * self.leading());
            let side = 0.8 * self.size();
            let at = [SIDE, self.y - 0.04 * self.size()];
            self.mark(Mark::Square { at, side });
            self.text(15.0 * self.scale, &format!("{}.", i + 1), self.size(), true);
            self.paragraph(indent, step, false);
            self.y -= 0.22 * self.leading();
        }
    }

    fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let size = self.size();
        let wide = |c: usize| {
            let cells = rows.iter().filter_map(|row| row.get(c));
            let widest = cells.map(|t| self.faces.regular.width(t, size)).fold(0.0, f64::max);
            widest.max(self.faces.bold.width(head[c], size))
        };
        let gap = 14.0 * self.scale;
        let mut starts = vec![0.0];
        for c in 0..head.len().saturating_sub(1) {
            // a long cell is wrapped, so that others have room
            starts.push(starts[c] + wide(c).min(0.4 * WIDTH) + gap);
        }
        let head: Vec<String> = head.iter().map(|&text| text.to_owned()).collect();
        self.row(&head, &starts, gap, true);
        for row in rows {
            self.row(row, &starts, gap, false);
        }
        self.y -= 0.5 * self.leading();
    }

    fn row(&mut self, cells: &[String], starts: &[f64], gap: f64, bold: bool) {
        let end = |c: usize| starts.get(c + 1).map_or(WIDTH, |next| next - gap);
        let lines: Vec<Vec<String>> = cells
            .iter()
            .enumerate()
            .map(|(c, text)| self.wrapped(text, self.size(), bold, end(c) - starts[c]))
            .collect();
        let height = lines.iter().map(Vec::len).max().unwrap_or(1);
        self.room((height - 1) as f64 * self.leading());
        let top = self.y;
        for (lines, x) in lines.iter().zip(starts) {
            self.y = top;
            for line in lines {
                self.text(*x, line, self.size(), bold);
                self.y -= self.leading();
            }
        }
        self.y = top - height as f64 * self.leading();
        let at = [SIDE, self.y + 0.72 * self.leading()];
        self.mark(Mark::Line { at, along: [WIDTH, 0.0] });
        self.y -= 0.12 * self.leading();
    }

    /// Pictures of one height, as large as the width allows.
    fn beside(&mut self, numbers: &[usize]) {
        let gap = 10.0;
        let ratios: Vec<f64> = numbers.iter().map(|&n| self.pictures[n].ratio()).collect();
        let free = WIDTH - gap * (numbers.len() - 1) as f64;
        let height = (free / ratios.iter().sum::<f64>()).min(215.0 * self.scale);
        self.room(height);
        let mut x = 0.0;
        self.y -= height - self.size();
        for (&number, ratio) in numbers.iter().zip(&ratios) {
            let at = [SIDE + x, self.y];
            self.mark(Mark::Picture { number, at, size: [ratio * height, height] });
            x += ratio * height + gap;
        }
        self.y -= 1.5 * self.leading();
    }

    /// A text in lines of a width. A word that is longer than a line is cut.
    fn wrapped(&self, text: &str, size: f64, bold: bool, width: f64) -> Vec<String> {
        let face = self.faces.of(bold);
        let fits = |text: &str| face.width(text, size) <= width + WIDTH_ROUNDING;
        let mut lines = vec![String::new()];
        for word in text.split_whitespace() {
            let line = lines.last_mut().expect("there is a line");
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if fits(&longer) {
                *line = longer;
                continue;
            }
            if !line.is_empty() {
                lines.push(String::new());
            }
            for c in word.chars() {
                let line = lines.last_mut().expect("there is a line");
                if !line.is_empty() && !fits(&format!("{line}{c}")) {
                    lines.push(String::new());
                }
                lines.last_mut().expect("there is a line").push(c);
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(pages: &[Vec<Mark>]) -> (f64, f64) {
        let faces = Typefaces::new();
        let mut right: f64 = 0.0;
        let mut low = f64::INFINITY;
        for mark in pages.iter().flatten() {
            if let Mark::Text { at, size, bold, text } = mark {
                right = right.max(at[0] + faces.of(*bold).width(text, *size));
                low = low.min(at[1]);
            }
        }
        (right, low)
    }

    #[test]
    fn long_texts_stay_on_the_pages() {
        let faces = Typefaces::new();
        let steps: Vec<String> =
            (0..24).map(|i| format!("step {i} {}", "long words ".repeat(25))).collect();
        let name = "x".repeat(300);
        let cells = vec![vec![name.clone(), "b".into()], vec!["a".into(), name.clone()]];
        let blocks = [
            Block::Title(name, "right".into()),
            Block::Table(vec!["one", "two"], cells),
            Block::Steps(steps),
        ];
        let pages = pages(&blocks, &[], &faces);
        assert_eq!(pages.len(), 2, "smaller letters, so that two pages are enough");
        let (right, low) = ends(&pages);
        assert!(right < PAGE[0] - SIDE + 1.0 && low > BOTTOM - 1.0, "{right} {low}");
        let few = super::pages(&[Block::Text("short".into(), false)], &[], &faces);
        assert!(matches!(few[0][0], Mark::Text { size, .. } if size == TEXT), "{few:?}");
    }
}
