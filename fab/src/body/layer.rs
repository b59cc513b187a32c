//! Sheets inside the body, such as paper, that are laid in while it is cast.

use std::fmt::Write as _;

use mesh::io::MshFile;
use mesh::topology::{boundary_loops, submesh};
use mesh::{SurfaceMesh, Vec3, measure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::MM;
use crate::geometry::frame::Frame;

/// A sheet counts as level if it keeps to a plane within this [mm].
const LEVEL: f64 = 0.1;

/// A sheet in the design's coordinates.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The tag.
    pub tag: String,
    /// The facets [m].
    pub surface: SurfaceMesh,
}

/// A sheet where it is cast, in the mold's coordinates.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LaidIn {
    /// The tag.
    pub tag: String,
    /// Height above the floor of the mold, where it is laid in [mm].
    pub height: f64,
    /// Silicone below it [mL].
    pub below_ml: f64,
    /// The outlines, seen from above [mm].
    pub outlines: Vec<Vec<[f64; 2]>>,
}

impl Layer {
    /// The sheet with a tag.
    pub fn find(file: &MshFile, tag: &str) -> Result<Self, String> {
        let id = file.tags.id(tag);
        let facets = id.map(|id| file.tags.facets_of(id)).unwrap_or_default();
        if facets.is_empty() {
            return Err(format!(
                "layers: no facet has the tag {tag:?}; the mesh has: {}",
                file.tags.names.join(", ")
            ));
        }
        let oriented = oriented(&facets);
        Ok(Self { tag: tag.into(), surface: submesh(&file.mesh.vertices, &oriented).0 })
    }

    /// Lowest and highest point in a frame [m].
    pub fn heights(&self, frame: &Frame) -> [f64; 2] {
        let (low, high) = measure::bounds(&self.places(frame));
        [low.z, high.z]
    }

    /// The place above the floor of a mold, with the volume of silicone below it [m³].
    pub fn laid_in(&self, frame: &Frame, floor: f64, below: f64) -> Result<LaidIn, String> {
        let [low, high] = self.heights(frame);
        let rise = (high - low) * MM;
        if rise > LEVEL {
            return Err(format!(
                "layers: {:?} is not level while it is cast, it rises by {rise:.2} mm, at most {LEVEL} \
                 mm are allowed: choose `up` across it",
                self.tag
            ));
        }
        let places = self.places(frame);
        let outline = |rim: Vec<usize>| -> Vec<[f64; 2]> {
            rim.into_iter().map(|v| [places[v].x * MM, places[v].y * MM]).collect()
        };
        Ok(LaidIn {
            tag: self.tag.clone(),
            height: ((low + high) / 2.0 - floor) * MM,
            below_ml: below * MM.powi(3) / 1e3,
            outlines: boundary_loops(&self.surface.triangles).into_iter().map(outline).collect(),
        })
    }

    fn places(&self, frame: &Frame) -> Vec<Vec3> {
        self.surface.vertices.iter().map(|p| frame.point(p)).collect()
    }
}

impl LaidIn {
    /// Width and depth [mm].
    pub fn size(&self) -> [f64; 2] {
        let [low, high] = self.extent();
        [high[0] - low[0], high[1] - low[1]]
    }

    fn extent(&self) -> [[f64; 2]; 2] {
        let all = || self.outlines.iter().flatten();
        let fold =
            |i: usize, start: f64, f: fn(f64, f64) -> f64| all().map(|p| p[i]).fold(start, f);
        [
            [0, 1].map(|i| fold(i, f64::INFINITY, f64::min)),
            [0, 1].map(|i| fold(i, f64::NEG_INFINITY, f64::max)),
        ]
    }

    /// The file with its outline.
    pub fn file(&self) -> String {
        format!("{}.svg", self.tag)
    }

    /// The outline in its own size, to be printed and cut.
    pub fn svg(&self) -> String {
        const MARGIN: f64 = 5.0;
        let [low, _] = self.extent();
        let [width, depth] = self.size().map(|x| x + 2.0 * MARGIN);
        let mut path = String::new();
        for outline in &self.outlines {
            for (i, p) in outline.iter().enumerate() {
                let (x, y) = (p[0] - low[0] + MARGIN, depth - MARGIN - (p[1] - low[1]));
                let command = if i == 0 { "M" } else { "L" };
                let _ = write!(path, "{command}{x:.3} {y:.3} ");
            }
            path += "Z ";
        }
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}mm\" height=\"{depth:.3}mm\" \
             viewBox=\"0 0 {width:.3} {depth:.3}\">\n<title>{}: cut along the line, 1:1</title>\n\
             <path d=\"{}\" fill=\"none\" stroke=\"black\" stroke-width=\"0.1\"/>\n</svg>\n",
            self.tag,
            path.trim_end()
        )
    }
}

/// The facets of a surface, neighbours winding alike as far as each edge has two.
fn oriented(facets: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let mut all = facets.to_vec();
    let edges = mesh::topology::edge_facets(&all);
    let mut done = vec![false; all.len()];
    for start in 0..all.len() {
        let mut stack = vec![start];
        while let Some(f) = stack.pop() {
            if std::mem::replace(&mut done[f], true) {
                continue;
            }
            for [a, b] in mesh::topology::directed_edges(all[f]) {
                let near = &edges[&[a.min(b), a.max(b)]];
                for &other in near.iter().filter(|&&other| !done[other]) {
                    if mesh::topology::directed_edges(all[other]).contains(&[a, b]) {
                        all[other].swap(1, 2);
                    }
                    stack.push(other);
                }
            }
        }
    }
    all
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use mesh::{Tags, TetMesh};

    /// A pyramid above and one below a square of 20 × 10 mm at z = 1 mm, which has the tag.
    fn layered() -> MshFile {
        let square = [(0.0, 0.0), (0.02, 0.0), (0.02, 0.01), (0.0, 0.01)];
        let mut vertices: Vec<Vec3> = square.map(|(x, y)| Vec3::new(x, y, 1e-3)).to_vec();
        vertices.extend([Vec3::new(0.01, 0.005, 3e-3), Vec3::new(0.01, 0.005, 0.0)]);
        let tets = vec![[0, 1, 2, 4], [0, 2, 3, 4], [0, 2, 1, 5], [0, 3, 2, 5]];
        let mut tags = Tags::new(vec!["paper".into()]);
        tags.set([0, 1, 2], 1);
        tags.set([0, 2, 3], 1);
        MshFile { mesh: TetMesh { vertices, tets }, tags }
    }

    #[test]
    fn a_sheet_is_laid_in_where_it_lies() {
        let layer = Layer::find(&layered(), "paper").unwrap();
        let (frame, _) = Frame::new(Vec3::z(), Vec3::z()).unwrap();
        let laid = layer.laid_in(&frame, 0.0, 2e-7).unwrap();
        assert!((laid.height - 1.0).abs() < 1e-12 && (laid.below_ml - 0.2).abs() < 1e-12);
        assert_eq!(laid.outlines.len(), 1);
        let [width, depth] = laid.size();
        let (long, short) = (width.max(depth), width.min(depth));
        assert!((long - 20.0).abs() < 1e-9 && (short - 10.0).abs() < 1e-9);
        // with a margin of 5 mm on all sides, in millimetres
        assert!(laid.svg().contains("viewBox=\"0 0 ") && laid.svg().contains("30.000"));
    }

    #[test]
    fn what_cannot_be_laid_in_is_told() {
        let message = Layer::find(&layered(), "card").unwrap_err();
        assert!(message.contains("\"card\"; the mesh has: paper"), "{message}");
        let layer = Layer::find(&layered(), "paper").unwrap();
        let (frame, _) = Frame::new(Vec3::x(), Vec3::z()).unwrap();
        let message = layer.laid_in(&frame, 0.0, 0.0).unwrap_err();
        assert!(message.contains("not level") && message.contains("20.00 mm"), "{message}");
    }
}
