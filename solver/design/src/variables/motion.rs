//! A rigid motion of a handle, with the offset of the surface at it.

use mesh::Vec3;

type Mat3 = nalgebra::Matrix3<f64>;

/// Numbers of a motion: three rotations, three translations, an offset.
pub const NUMBERS: usize = 7;

/// A rigid motion about a handle's center.
pub struct Motion {
    /// Angles about x, y, z [rad].
    pub angles: [f64; 3],
    /// Translation [m].
    pub translation: Vec3,
    /// o [m].
    pub offset: f64,
    /// Q: rotation and translation are the images of these.
    pub frame: Mat3,
}

impl Motion {
    /// Q R_z R_y R_x Qᵀ.
    pub fn rotation(&self) -> Mat3 {
        let [x, y, z] = self.axes();
        self.image(z.0 * y.0 * x.0)
    }

    /// The derivatives of the rotation by α₁, α₂, α₃.
    pub fn rotation_slopes(&self) -> [Mat3; 3] {
        let [x, y, z] = self.axes();
        let slopes = [z.0 * y.0 * x.1, z.0 * y.1 * x.0, z.1 * y.0 * x.0];
        slopes.map(|slope| self.image(slope))
    }

    fn image(&self, rotation: Mat3) -> Mat3 {
        self.frame * rotation * self.frame.transpose()
    }

    /// Rotation about each axis with its derivative.
    fn axes(&self) -> [(Mat3, Mat3); 3] {
        let mut axes = [(Mat3::identity(), Mat3::zeros()); 3];
        for (k, (rotation, slope)) in axes.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let (sin, cos) = self.angles[k].sin_cos();
            for (matrix, on, off) in [(rotation, cos, sin), (slope, -sin, cos)] {
                matrix[(i, i)] = on;
                matrix[(j, j)] = on;
                matrix[(i, j)] = -off;
                matrix[(j, i)] = off;
            }
        }
        axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn about x, then y, then z: e_z → −e_y → −e_y → e_x.
    #[test]
    fn rotations_are_about_x_then_y_then_z() {
        let motion = Motion {
            angles: [std::f64::consts::FRAC_PI_2; 3],
            translation: Vec3::zeros(),
            offset: 0.0,
            frame: Mat3::identity(),
        };
        assert!((motion.rotation() * Vec3::z() - Vec3::x()).norm() < 1e-15);
    }
}
