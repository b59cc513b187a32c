//! Panels side by side with title, captions and key.

use mesh::Vec3;

use super::annotate::{Key, Type};
use super::camera::{Camera, Projection};
use super::color::encode;
use super::font::{Anchor, draw};
use super::image::Image;
use super::label;
use super::panel::{self, Look, Rows};
use super::view::View;
use super::{Piece, bounds};

/// Everything that is written or chosen for a whole sheet.
pub struct Sheet {
    /// Width and height [px].
    pub size: [usize; 2],
    /// Written above everything; empty for none.
    pub title: String,
    /// Camera of all panels.
    pub view: View,
    /// Depth of all panels.
    pub projection: Projection,
    /// Scale, lines and ground of all panels.
    pub look: Look,
    /// What explains the colours.
    pub key: Key,
    /// Ends of the diagonal of the box that is shown; if there is none, all that is drawn.
    pub shown: Option<(Vec3, Vec3)>,
}

/// One scene of a sheet.
pub struct Panel {
    /// What to draw.
    pub pieces: Vec<Piece>,
    /// Written below it; empty for none.
    pub caption: String,
    /// Written on each piece where it is seen; empty for none.
    pub labels: Vec<String>,
}

/// Draws a sheet. All panels share one camera, so that sizes can be compared.
pub fn draw_sheet(sheet: &Sheet, panels: &[Panel]) -> Image {
    let ty = Type::for_sheet(sheet.size);
    let h = ty.height;
    let mut image = blank(sheet.size);
    let [width, height] = sheet.size.map(|s| s as f64);
    let top = if sheet.title.is_empty() { 0.0 } else { 5.2 * h };
    let right = width - sheet.key.width(&ty);
    let caption = if panels.iter().all(|p| p.caption.is_empty()) { 0.0 } else { 3.6 * h };

    let points = sheet.shown.map_or_else(|| outline(panels), corners);
    let grid = Grid::choose(sheet, &points, panels.len(), [right, height - top], caption);
    let camera = Camera::fit(sheet.view, sheet.projection, &points, grid.panel);
    for (i, panel) in panels.iter().enumerate() {
        let (column, row) = (i % grid.columns, i / grid.columns);
        let left = column * grid.panel[0];
        let upper = top as usize + row * (grid.panel[1] + caption as usize);
        let rows = Rows { top: upper, of: sheet.size[1] };
        let picture = panel::draw(&panel.pieces, &camera, grid.panel, &sheet.look, rows);
        image.paste(&picture, left, upper);
        let Panel { pieces, labels, .. } = panel;
        let corner = [left, upper];
        let missing = label::write(&mut image, pieces, labels, &camera, grid.panel, corner, &ty);
        if !missing.is_empty() {
            let names: Vec<&str> = missing.iter().map(|&i| panel.labels[i].as_str()).collect();
            log::info!("hidden or small from here, without a label: {}", names.join(", "));
        }
        let at =
            [left as f64 + 0.5 * grid.panel[0] as f64, (upper + grid.panel[1]) as f64 + 1.4 * h];
        draw(&mut image, &panel.caption, at, Anchor::Center, &ty.text());
    }
    draw(&mut image, &sheet.title, [3.0 * h, 4.2 * h], Anchor::Left, &ty.title());
    sheet.key.draw(&mut image, &ty, right + 0.5 * h, top, height);
    image
}

fn blank(size: [usize; 2]) -> Image {
    let mut image = Image::new(size[0], size[1], [1.0; 3]);
    for (row, pixels) in image.pixels.chunks_exact_mut(size[0]).enumerate() {
        pixels.fill(encode(panel::background(row, size[1])));
    }
    image
}

/// Points that the camera must show: all corners of all facets.
fn outline(panels: &[Panel]) -> Vec<Vec3> {
    panels.iter().flat_map(|p| &p.pieces).flat_map(|p| &p.facets).flat_map(|f| f.points).collect()
}

/// The corners of a box.
fn corners((min, max): (Vec3, Vec3)) -> Vec<Vec3> {
    let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
    (0..8).map(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect()
}

/// Lowest point of all panels.
pub fn floor(panels: &[Panel]) -> Option<f64> {
    panels.iter().filter_map(|p| bounds(&p.pieces)).map(|(min, _)| min.z).reduce(f64::min)
}

struct Grid {
    columns: usize,
    /// Size of a panel [px].
    panel: [usize; 2],
}

impl Grid {
    /// The number of columns that shows the scene largest.
    fn choose(sheet: &Sheet, points: &[Vec3], count: usize, room: [f64; 2], caption: f64) -> Self {
        let square = Camera::fit(sheet.view, sheet.projection, points, [1000, 1000]);
        let extent = square.extent(points).map(|e| e.max(1.0));
        let grid = |columns: usize| {
            let rows = count.div_ceil(columns) as f64;
            let panel = [room[0] / columns as f64, room[1] / rows - caption];
            (panel[0] / extent[0]).min(panel[1] / extent[1])
        };
        let columns = (1..=count.max(1)).max_by(|&a, &b| grid(a).total_cmp(&grid(b))).unwrap_or(1);
        let rows = count.div_ceil(columns) as f64;
        let panel = [room[0] / columns as f64, room[1] / rows - caption];
        Self { columns, panel: panel.map(|s| s.max(1.0) as usize) }
    }
}
