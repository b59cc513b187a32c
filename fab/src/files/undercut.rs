//! A picture of the undercuts, coloured by their depth.

use std::path::Path;

use geometry::MM;
use geometry::frame::{Frame, moved};
use mesh::Vec3;
use mesh::io::IoError;
use nalgebra::Matrix3;
use render::annotate::Key;
use render::camera::Projection;
use render::color::{self, Scale};
use render::cut::cut;
use render::panel::Look;
use render::raster::Lines;
use render::sheet::{Panel, Sheet, draw_sheet};
use render::view::View;

use super::picture::shape;
use crate::plan::{Casting, Plan};

/// Name of the picture in the top folder.
pub const FILE: &str = "undercut.png";

/// Width and height of the picture of one casting, of which each more adds a height [px].
const SIZE: [usize; 2] = [1200, 560];

/// Castings are seen from obliquely above.
const VIEW: View = View { azimuth: -58.0, elevation: 38.0 };

/// The least range of the colours: undercuts less deep than this do not matter [mm].
const RANGE: f64 = 0.5;

/// Draws every casting as seen along the pull, and against it.
pub fn draw(path: &Path, plan: &Plan) -> Result<(), IoError> {
    let deepest = plan.castings.iter().flat_map(|casting| &casting.undercut);
    let max = deepest.fold(RANGE, |max, depth| max.max(depth * MM));
    let scale = Scale { min: 0.0, max };
    let panels: Vec<Panel> = plan.castings.iter().flat_map(panels).collect();
    let sheet = Sheet {
        size: [SIZE[0], SIZE[1] * plan.castings.len()],
        title: "undercuts".into(),
        view: VIEW,
        projection: Projection::Orthographic,
        look: Look {
            scale: Some(scale),
            lines: Lines { edges: false, features: true },
            ground: None,
        },
        key: Key::Scale { name: "depth".into(), unit: "mm".into(), scale },
        shown: None,
    };
    draw_sheet(&sheet, &panels).write_png(path)
}

/// A casting with its pull up, and with its pull down.
fn panels(casting: &Casting) -> [Panel; 2] {
    let pull = casting.orientation.pull;
    let (frame, _) = Frame::new(pull, pull).expect("a direction is along itself");
    let worst = casting.worst.map_or("free".into(), |worst| {
        let both = (worst.depth + worst.opposite) * MM;
        format!("{both:.1} of {:.1} mm", worst.width * MM)
    });
    let over = Matrix3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
    let sides = [("along its pull", Matrix3::identity()), ("against it", over)];
    sides.map(|(side, turn)| {
        let turn = turn * frame.rotation;
        let surface = moved(&casting.filled, |p| turn * p * MM);
        let depth = |t: usize| casting.undercut[t] * MM;
        let shape = shape(&surface, depth, color::material());
        Panel {
            pieces: vec![cut(&shape, None)],
            caption: format!("{} {side}: at worst {worst}", casting.name),
            labels: Vec::new(),
        }
    })
}
