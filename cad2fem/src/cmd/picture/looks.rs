//! How things look: options that pictures and films share.

use anyhow::{Result, bail, ensure};
use render::annotate::Key;
use render::camera::Projection;
use render::color::{Rgb, Scale};
use render::cut::Plane;
use render::panel::Look;
use render::raster::Lines;
use render::sheet::{Panel, Sheet};
use render::view::View;

use super::load::{Loaded, Paint};
use super::options::{Component, Cut, Pair};

/// Largest width or height [px].
const LARGEST: usize = 16_384;

/// How things look, in pictures and films.
#[derive(Clone, Debug, clap::Args)]
pub struct Looks {
    /// Where to look from: iso, front, back, left, right, top, bottom, under, or
    /// azimuth,elevation in degrees
    #[arg(long, default_value = "iso", allow_hyphen_values = true)]
    pub view: View,
    /// Width and height in pixels
    #[arg(long, default_value = "1600x900")]
    pub size: Pair<'x', usize>,
    /// Parallel lines stay parallel
    #[arg(long)]
    pub orthographic: bool,
    /// Plane that cuts everything: x=V, y=V or z=V removes the side of the camera;
    /// nx,ny,nz,V removes n·x > V for the unit normal n
    #[arg(long, allow_hyphen_values = true)]
    pub cut: Option<Cut>,
    /// Colour by a field of a .vtu: NAME is a scalar or the length of a vector,
    /// NAME.x, NAME.y, NAME.z or NAME.0 to NAME.8 a component
    #[arg(long)]
    pub color: Option<Component>,
    /// Values at the ends of the colour scale [default: those of all files]
    #[arg(long, allow_hyphen_values = true)]
    pub range: Option<Pair<',', f64>>,
    /// Point field of a .vtu that moves its points; none keeps them
    /// [default: displacement, where there is one]
    #[arg(long)]
    pub deform: Option<String>,
    /// Factor on the deformation
    #[arg(long, default_value_t = 1.0, allow_hyphen_values = true)]
    pub magnify: f64,
    /// Draw the edges of the mesh
    #[arg(long)]
    pub edges: bool,
    /// Leave out the lines at sharp edges
    #[arg(long)]
    pub smooth: bool,
    /// Leave out shadows on the ground
    #[arg(long)]
    pub no_ground: bool,
    /// Written above everything
    #[arg(long, default_value = "")]
    pub title: String,
}

impl Looks {
    /// Refuses what cannot be drawn.
    pub fn check(&self) -> Result<()> {
        let Pair(width, height) = self.size;
        let fits = |s: usize| (64..=LARGEST).contains(&s);
        ensure!(
            fits(width) && fits(height),
            "--size {width}x{height}: each must be 64 to {LARGEST}"
        );
        ensure!(self.magnify.is_finite(), "--magnify {} is not a number", self.magnify);
        Ok(())
    }

    /// How a file is coloured and deformed.
    pub fn paint(&self, color: Rgb, tags: bool) -> Paint<'_> {
        let (field, deform) = (self.color.as_ref(), self.deform.as_deref());
        Paint { color, field, deform, magnify: self.magnify, tags }
    }

    /// The plane that cuts, if there is one.
    pub fn plane(&self) -> Option<Plane> {
        self.cut.as_ref().map(|cut| cut.plane(&self.view.frame()[2]))
    }

    /// The colour scale over a range of values, unless the user gives one.
    pub fn scale(&self, range: Option<(f64, f64)>) -> Result<Option<Scale>> {
        let Some(field) = &self.color else { return Ok(None) };
        if let Some(Pair(min, max)) = self.range {
            ensure!(min < max, "--range {min},{max}: the first must be smaller");
            return Ok(Some(Scale { min, max }));
        }
        let Some((min, max)) = range else {
            bail!("--color {field}: no finite value is left to draw");
        };
        Ok(Some(Scale { min, max }))
    }

    /// What explains the colours of a field, if there is one.
    pub fn key(&self, loaded: &[Loaded], scale: Option<Scale>) -> Option<Key> {
        let unit = loaded.iter().find_map(|l| l.unit.clone()).unwrap_or_default();
        Some(Key::Scale { name: self.color.as_ref()?.to_string(), unit, scale: scale? })
    }

    /// A sheet over a ground at a height.
    pub fn sheet(&self, scale: Option<Scale>, ground: Option<f64>, key: Key) -> Sheet {
        let projection =
            if self.orthographic { Projection::Orthographic } else { Projection::Perspective };
        let lines = Lines { edges: self.edges, features: !self.smooth };
        let ground = ground.filter(|_| !self.no_ground);
        Sheet {
            size: [self.size.0, self.size.1],
            title: self.title.clone(),
            view: self.view,
            projection,
            look: Look { scale, lines, ground },
            key,
            shown: None,
        }
    }
}

/// The least and the largest finite value of all facets, if there are any.
pub fn values(panels: &[Panel]) -> Option<(f64, f64)> {
    let facets = panels.iter().flat_map(|p| &p.pieces).flat_map(|p| &p.facets);
    let finite = facets.flat_map(|f| f.values).filter(|v| v.is_finite());
    finite.map(|v| (v, v)).reduce(|(a, b), (v, _)| (a.min(v), b.max(v)))
}
