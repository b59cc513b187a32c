//! Sheets inside the body, such as paper, that are laid in while it is cast.

use std::fmt::Write as _;

use mesh::io::MshFile;
use mesh::topology::{boundary_loops, submesh};
use mesh::{SurfaceMesh, Vec3, measure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use geometry::MM;
use geometry::frame::Frame;

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
        Ok(Self { tag: tag.into(), surface: submesh(&file.mesh.vertices, &facets).0 })
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
        // Facets inside a body wind either way; here they do as the first of them.
        let places = self.places(frame);
        let looks_up =
            |[a, b, c]: [usize; 3]| (places[b] - places[a]).cross(&(places[c] - places[a])).z > 0.0;
        let facets = &self.surface.triangles;
        let as_first = |&[a, b, c]: &[usize; 3]| match looks_up([a, b, c]) == looks_up(facets[0]) {
            true => [a, b, c],
            false => [a, c, b],
        };
        let facets: Vec<_> = facets.iter().map(as_first).collect();
        let outline = |rim: Vec<usize>| -> Vec<[f64; 2]> {
            rim.into_iter().map(|v| [places[v].x * MM, places[v].y * MM]).collect()
        };
        Ok(LaidIn {
            tag: self.tag.clone(),
            height: ((low + high) / 2.0 - floor) * MM,
            below_ml: below * MM.powi(3) / 1e3,
            outlines: boundary_loops(&facets).into_iter().map(outline).collect(),
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
        let all = self.outlines.iter().flatten().map(|p| Vec3::new(p[0], p[1], 0.0));
        let (low, high) = measure::bounds(&all.collect::<Vec<_>>());
        [low, high].map(|p| [p.x, p.y])
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use mesh::{Tags, TetMesh};

    /// A square of 20 × 10 mm at z = 1 mm between a pyramid above and one below.
    #[test]
    fn a_sheet_is_laid_in_where_it_lies_and_level() {
        let square = [(0.0, 0.0), (0.02, 0.0), (0.02, 0.01), (0.0, 0.01)];
        let mut vertices: Vec<Vec3> = square.map(|(x, y)| Vec3::new(x, y, 1e-3)).to_vec();
        vertices.extend([Vec3::new(0.01, 0.005, 3e-3), Vec3::new(0.01, 0.005, 0.0)]);
        let tets = vec![[0, 1, 2, 4], [0, 2, 3, 4], [0, 2, 1, 5], [0, 3, 2, 5]];
        let mut tags = Tags::new(vec!["paper".into()]);
        tags.set([0, 1, 2], 1);
        tags.set([0, 2, 3], 1);
        let file = MshFile { mesh: TetMesh { vertices, tets }, tags };
        let layer = Layer::find(&file, "paper").unwrap();
        let laid = |up: Vec3| layer.laid_in(&Frame::new(up, Vec3::z()).unwrap().0, 0.0, 2e-7);
        let level = laid(Vec3::z()).unwrap();
        assert!((level.height - 1.0).abs() < 1e-12 && (level.below_ml - 0.2).abs() < 1e-12);
        let [width, depth] = level.size();
        assert!((width + depth - 30.0).abs() < 1e-9 && level.outlines.len() == 1, "{level:?}");
        // with a margin of 5 mm on all sides, in millimetres
        assert!(level.svg().contains("viewBox=\"0 0 ") && level.svg().contains("30.000"));
        let message = laid(Vec3::x()).unwrap_err();
        assert!(message.contains("not level") && message.contains("20.00 mm"), "{message}");
    }
}
