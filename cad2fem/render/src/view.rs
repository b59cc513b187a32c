//! Directions to look from.

use std::str::FromStr;

use mesh::Vec3;

/// Named views: name, azimuth and elevation in degrees.
///
/// The azimuth turns the camera about the z axis, from +x towards +y.
pub const VIEWS: [(&str, f64, f64); 8] = [
    ("iso", -50.0, 28.0),
    ("front", -90.0, 0.0),
    ("back", 90.0, 0.0),
    ("left", 180.0, 0.0),
    ("right", 0.0, 0.0),
    ("top", -90.0, 90.0),
    ("bottom", -90.0, -90.0),
    ("under", -50.0, -32.0),
];

/// Where the camera stands, seen from the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Angle about z from +x [degrees].
    pub azimuth: f64,
    /// Angle above the horizontal plane [degrees].
    pub elevation: f64,
}

impl View {
    /// Unit vectors to the right, up, and from the scene to the camera.
    pub fn frame(&self) -> [Vec3; 3] {
        let (sa, ca) = self.azimuth.to_radians().sin_cos();
        let (se, ce) = self.elevation.to_radians().sin_cos();
        let toward = Vec3::new(ca * ce, sa * ce, se);
        let right = Vec3::new(-sa, ca, 0.0);
        [right, toward.cross(&right), toward]
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(&(_, azimuth, elevation)) = VIEWS.iter().find(|(name, ..)| *name == text) {
            return Ok(Self { azimuth, elevation });
        }
        let names = || VIEWS.map(|(name, ..)| name).join(", ");
        let wrong =
            || format!("`{text}` is no view; use {} or azimuth,elevation in degrees", names());
        let (azimuth, elevation) = text.split_once(',').ok_or_else(wrong)?;
        let azimuth = azimuth.trim().parse::<f64>().map_err(|_| wrong())?;
        let elevation = elevation.trim().parse::<f64>().map_err(|_| wrong())?;
        if !azimuth.is_finite() || !(-90.0..=90.0).contains(&elevation) {
            return Err(format!("{}: the elevation must be within -90 and 90 degrees", wrong()));
        }
        Ok(Self { azimuth, elevation })
    }
}
