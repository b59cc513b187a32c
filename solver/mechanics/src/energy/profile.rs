//! Numbers that change along an axis: clamped uniform B-splines of the height.
//!
//! f(z) = Σ_i c_i N_i(s)      s = (n − p) (z − z₀)/(z₁ − z₀), held in [0, n − p]      p = min(3, n − 1)
//!
//! n   number of the control values c_i
//! z   height of a place X along the axis: k · (X − P), with the point P and the unit vector k of the axis
//! z₀, z₁ heights of both ends, beyond which f is constant
//! N_i B-splines of degree p over the knots 0, 1, …, n − p, of which the first and the last count p + 1 times
//!
//! N_i ≥ 0 and Σ N_i = 1, so that f lies between the smallest and the largest value: bounds of the values hold
//! everywhere. A spline that interpolates its values would leave them in between. The curve begins at the first
//! value and ends at the last, and is p − 1 times continuously differentiable between the ends. At an end the
//! slope jumps to zero.
//!
//! Source: Piegl and Tiller 1997, "The NURBS Book", algorithms A2.1 and A2.2, and equation 3.8 for the slope.

use mesh::Vec3;

use super::Axis;

/// Largest degree of the splines.
const DEGREE: usize = 3;

/// A number that changes along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    axis: Axis,
    heights: [f64; 2],
    values: Vec<f64>,
}

/// The B-splines that are not zero at a height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// The control value that the first of them belongs to; the others follow it.
    pub first: usize,
    /// How many there are: the degree and one.
    pub count: usize,
    /// Their values [1]; behind `count` zero.
    pub weights: [f64; DEGREE + 1],
}

impl Basis {
    /// The control values that it is about, each with its weight.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let Self { first, count, weights } = *self;
        (0..count).map(move |i| (first + i, weights[i]))
    }
}

impl Profile {
    /// Most control values.
    pub const MOST_VALUES: usize = 64;

    /// From its axis, the heights of its ends along that [m], and its control values. None if there are fewer than 2
    /// values or more than [`Self::MOST_VALUES`], if a number is not finite, or if the second height is not above the first.
    pub fn new(axis: Axis, heights: [f64; 2], values: Vec<f64>) -> Option<Self> {
        let finite = values.iter().chain(&heights).all(|x| x.is_finite());
        let good = (2..=Self::MOST_VALUES).contains(&values.len()) && heights[0] < heights[1];
        (finite && good).then_some(Self { axis, heights, values })
    }

    /// The line that heights are along.
    pub fn axis(&self) -> &Axis {
        &self.axis
    }

    /// The heights of its ends [m].
    pub fn heights(&self) -> [f64; 2] {
        self.heights
    }

    /// The heights between which it is a polynomial, from its start to its end [m].
    pub fn knots(&self) -> Vec<f64> {
        let ([start, end], spans) = (self.heights, self.spans());
        (0..=spans).map(|i| start + (end - start) * i as f64 / spans as f64).collect()
    }

    /// The control values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// This profile with all values times a factor.
    pub fn times(mut self, factor: f64) -> Self {
        self.values.iter_mut().for_each(|value| *value *= factor);
        self
    }

    /// The height of a rest position, k · (X − P) [m].
    #[inline]
    pub fn height(&self, x: Vec3) -> f64 {
        (x - self.axis.point).dot(&self.axis.along)
    }

    /// f at a rest position.
    #[inline]
    pub fn at(&self, x: Vec3) -> f64 {
        self.value(self.height(x))
    }

    /// ∂f/∂X at a rest position [1/m times its unit].
    pub fn gradient(&self, x: Vec3) -> Vec3 {
        self.slope(self.height(x)) * self.axis.along
    }

    /// f at a height [m].
    #[inline]
    pub fn value(&self, height: f64) -> f64 {
        let Basis { first, count, weights } = self.basis(height);
        weights[..count].iter().zip(&self.values[first..]).map(|(w, value)| w * value).sum()
    }

    /// df/dz at a height [1/m times its unit]: that inside at an end, and zero beyond.
    pub fn slope(&self, height: f64) -> f64 {
        let [start, end] = self.heights;
        if !(start..=end).contains(&height) {
            return 0.0;
        }
        let p = self.degree();
        let (span, s) = self.place(height);
        let below = self.weights(p - 1, span, s);
        let mut sum = 0.0;
        for (i, weight) in below[..p].iter().enumerate() {
            let rise = self.values[span + i + 1] - self.values[span + i];
            sum += weight * rise / (self.knot(span + i + p + 1) - self.knot(span + i + 1));
        }
        p as f64 * sum * self.spans() as f64 / (end - start)
    }

    /// The B-splines that are not zero at a height [m]: ∂f/∂c_i of the values that count there.
    #[inline]
    pub fn basis(&self, height: f64) -> Basis {
        let p = self.degree();
        let (span, s) = self.place(height);
        Basis { first: span, count: p + 1, weights: self.weights(p, span, s) }
    }

    /// The smallest and the largest of the control values that count between two heights [m]; f lies between them there.
    pub fn bounds(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let [first, last] = [low, high].map(|height| self.place(height).0);
        let counted = &self.values[first..=last.max(first) + self.degree()];
        counted.iter().fold([f64::INFINITY, -f64::INFINITY], |[least, most], &value| {
            [least.min(value), most.max(value)]
        })
    }

    #[inline]
    fn degree(&self) -> usize {
        DEGREE.min(self.values.len() - 1)
    }

    /// Number of pieces, each a polynomial.
    #[inline]
    fn spans(&self) -> usize {
        self.values.len() - self.degree()
    }

    /// A knot by its place in the list.
    #[inline]
    fn knot(&self, i: usize) -> f64 {
        i.saturating_sub(self.degree()).min(self.spans()) as f64
    }

    /// The piece that a height is in, and s.
    #[inline]
    fn place(&self, height: f64) -> (usize, f64) {
        let [start, end] = self.heights;
        let spans = self.spans();
        let s = ((height - start) / (end - start) * spans as f64).clamp(0.0, spans as f64);
        ((s as usize).min(spans - 1), s)
    }

    /// The B-splines of a degree, up to that of the profile, in a piece.
    #[inline]
    fn weights(&self, degree: usize, span: usize, s: f64) -> [f64; DEGREE + 1] {
        let place = span + self.degree();
        let mut weights = [1.0, 0.0, 0.0, 0.0];
        for j in 1..=degree {
            let mut carried = 0.0;
            for (r, weight) in weights[..j].iter_mut().enumerate() {
                let (right, left) = (self.knot(place + r + 1), self.knot(place + 1 + r - j));
                let part = *weight / (right - left);
                *weight = carried + (right - s) * part;
                carried = (s - left) * part;
            }
            weights[j] = carried;
        }
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHTS: [f64; 2] = [-0.02, 0.06];

    fn axis() -> Axis {
        Axis { point: Vec3::new(0.3, -0.2, 0.1), along: Vec3::new(1.0, 2.0, 2.0) / 3.0 }
    }

    fn profile(values: &[f64]) -> Profile {
        Profile::new(axis(), HEIGHTS, values.to_vec()).expect("it is good")
    }

    /// From 2 to 9 values and the most, of both signs.
    fn profiles() -> Vec<Profile> {
        let values = |n: usize| (0..n).map(|i| (1.7 * i as f64).sin() + 0.3).collect::<Vec<f64>>();
        (2..10).chain([Profile::MOST_VALUES]).map(|n| profile(&values(n))).collect()
    }

    /// Heights inside, at the ends and beyond.
    fn heights() -> Vec<f64> {
        (-3..=43).map(|i| HEIGHTS[0] + 0.002 * f64::from(i)).chain(HEIGHTS).collect()
    }

    /// Of degree p: where values on a line give that line, the means of p knots that follow each other.
    fn abscissae(of: &Profile) -> Vec<f64> {
        let (p, [start, end]) = (of.degree(), of.heights);
        let mean = |i: usize| (1..=p).map(|k| of.knot(i + k)).sum::<f64>() / p as f64;
        let height = |i: usize| start + (end - start) * mean(i) / of.spans() as f64;
        (0..of.values.len()).map(height).collect()
    }

    #[test]
    fn weights_are_a_partition_of_unity() {
        for profile in profiles() {
            for z in heights() {
                let basis = profile.basis(z);
                let sum: f64 = basis.weights.iter().sum();
                assert!((sum - 1.0).abs() < 1e-14, "{z}: {basis:?}");
                assert!(basis.weights.iter().all(|w| *w >= 0.0), "{z}: {basis:?}");
                assert!(basis.first + basis.count <= profile.values.len());
                let value: f64 = basis.pairs().map(|(i, w)| w * profile.values[i]).sum();
                assert!((value - profile.value(z)).abs() < 1e-15);
            }
        }
    }

    /// Control values of a line at their abscissae give that line, with its slope.
    #[test]
    fn lines_are_exact() {
        for mut profile in profiles() {
            profile.values = abscissae(&profile).iter().map(|z| 3.0 - 20.0 * z).collect();
            for z in heights() {
                let held = z.clamp(HEIGHTS[0], HEIGHTS[1]);
                assert!((profile.value(z) - (3.0 - 20.0 * held)).abs() < 1e-13, "{z}");
                let slope = if z == held { -20.0 } else { 0.0 };
                assert!((profile.slope(z) - slope).abs() < 1e-11, "{z} {}", profile.slope(z));
            }
        }
    }

    #[test]
    fn curves_begin_and_end_at_their_values_and_stay_between_them() {
        for profile in profiles() {
            let (first, last) = (profile.values[0], profile.values[profile.values.len() - 1]);
            for by in [0.0, 0.01, 1e3] {
                assert_eq!(profile.value(HEIGHTS[0] - by), first);
                assert_eq!(profile.value(HEIGHTS[1] + by), last);
            }
            let [least, most] = profile.bounds(HEIGHTS);
            for z in heights() {
                let value = profile.value(z);
                assert!(least - 1e-15 <= value && value <= most + 1e-15, "{z}: {value}");
                let [least, most] = profile.bounds([z, z + 0.003]);
                let other = profile.value(z + 0.002);
                assert!(least - 1e-15 <= other && other <= most + 1e-15, "{z}: {other}");
            }
        }
    }

    /// Of degree 3 the second derivative has no jump at a knot: its differences on both sides are those of a
    /// continuous one, within the step times the jump of the third derivative.
    #[test]
    fn curves_have_continuous_curvature_at_knots() {
        for profile in profiles().into_iter().filter(|profile| profile.values.len() > 4) {
            let size = (HEIGHTS[1] - HEIGHTS[0]) / profile.spans() as f64;
            for knot in 1..profile.spans() {
                let z = HEIGHTS[0] + size * knot as f64;
                let step = 1e-4 * size;
                let by = |k: f64| profile.slope(z + k * step) * size;
                let [before, after] = [by(0.0) - by(-1.0), by(2.0) - by(1.0)].map(|d| d / 1e-4);
                // third derivatives of these values are at most about 20 in units of the knots
                assert!((after - before).abs() < 0.02, "{knot}: {before} {after}");
            }
        }
    }

    #[test]
    fn what_is_no_profile_is_none() {
        for (heights, values) in [
            ([0.0, 1.0], vec![1.0]),
            ([0.0, 1.0], vec![1.0; Profile::MOST_VALUES + 1]),
            ([1.0, 1.0], vec![1.0, 2.0]),
            ([0.0, f64::INFINITY], vec![1.0, 2.0]),
            ([0.0, 1.0], vec![1.0, f64::NAN]),
        ] {
            assert_eq!(Profile::new(axis(), heights, values), None);
        }
    }
}
