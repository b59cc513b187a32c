//! Values of the options of `cad2fem picture`.

use std::fmt;
use std::str::FromStr;

use mesh::Vec3;

use render::cut::Plane;

/// Two values separated by a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<const SEPARATOR: char, T>(pub T, pub T);

impl<const SEPARATOR: char, T: FromStr> FromStr for Pair<SEPARATOR, T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |s: &str| s.trim().parse::<T>().ok();
        text.split_once(SEPARATOR)
            .and_then(|(a, b)| Some(Self(parse(a)?, parse(b)?)))
            .ok_or_else(|| format!("`{text}` is not two numbers separated by `{SEPARATOR}`"))
    }
}

/// A cut plane as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// Across an axis, 0 to 2, at a coordinate; the side of the camera goes.
    Axis(usize, f64),
    /// n · x > offset goes.
    Normal(Vec3, f64),
}

impl Cut {
    /// The plane for a camera in direction `toward`.
    pub fn plane(&self, toward: &Vec3) -> Plane {
        match *self {
            Self::Axis(axis, at) => {
                let sign = if toward[axis] < 0.0 { -1.0 } else { 1.0 };
                let mut normal = Vec3::zeros();
                normal[axis] = sign;
                Plane { normal, offset: sign * at }
            }
            Self::Normal(normal, offset) => Plane { normal: normal.normalize(), offset },
        }
    }
}

impl FromStr for Cut {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is no plane; use x=V, y=V, z=V or nx,ny,nz,offset");
        let number =
            |s: &str| s.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
        if let Some((axis, at)) = text.split_once('=') {
            let axis = ["x", "y", "z"].iter().position(|a| *a == axis.trim()).ok_or_else(wrong)?;
            return Ok(Self::Axis(axis, number(at)?));
        }
        let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
        match numbers[..] {
            [x, y, z, offset] if Vec3::new(x, y, z).norm() > 0.0 => {
                Ok(Self::Normal(Vec3::new(x, y, z), offset))
            }
            _ => Err(wrong()),
        }
    }
}

/// A field, or one component of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Name of the field.
    pub field: String,
    /// Component from 0; the value of a scalar or the length of a vector if absent.
    pub index: Option<usize>,
}

impl FromStr for Component {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let whole = Self { field: text.to_owned(), index: None };
        let Some((field, component)) = text.rsplit_once('.') else { return Ok(whole) };
        let index = match component {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            digit => match digit.parse::<usize>() {
                Ok(i) if i < 9 => i,
                _ => return Ok(whole),
            },
        };
        Ok(Self { field: field.to_owned(), index: Some(index) })
    }
}

impl fmt::Display for Component {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.index {
            None => f.write_str(&self.field),
            Some(i @ 0..=2) => write!(f, "{} {}", self.field, ["x", "y", "z"][i]),
            Some(i) => write!(f, "{} {i}", self.field),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn axis_cut_removes_the_side_of_the_camera() {
        let cut: Cut = "y=0.002".parse().unwrap();
        let behind = Vec3::new(0.0, 0.001, 0.0);
        let seen_from_minus_y = cut.plane(&Vec3::new(0.5, -0.8, 0.3));
        assert!(seen_from_minus_y.beyond(&behind) > 0.0);
        assert!(cut.plane(&Vec3::y()).beyond(&behind) < 0.0);
    }

    #[test]
    fn general_cut_has_a_unit_normal() {
        let plane = "0,3,4,0.5".parse::<Cut>().unwrap().plane(&Vec3::x());
        assert_eq!(plane.normal, Vec3::new(0.0, 0.6, 0.8));
        assert_eq!(plane.offset, 0.5);
        for text in ["w=1", "x=", "1,2,3", "0,0,0,1", "x=nan"] {
            assert!(text.parse::<Cut>().is_err(), "{text}");
        }
    }

    #[test]
    fn components_by_letter_or_number() {
        let parse = |text: &str| text.parse::<Component>().unwrap();
        assert_eq!(parse("displacement").index, None);
        assert_eq!(
            parse("displacement.z"),
            Component { field: "displacement".into(), index: Some(2) }
        );
        assert_eq!(parse("stress.8").index, Some(8));
        assert_eq!(parse("p.max").field, "p.max");
        assert_eq!(parse("displacement.z").to_string(), "displacement z");
    }
}
