//! Thick spheres and long tubes under inner pressure by their radial equation, as a judge of the solver.
//!
//! d(P_rr)/dR = k (P_θθ − P_rr)/R,   k = 2 for a sphere, 1 for a tube in plane strain
//!
//! with P = ∂ψ/∂λ of principal stretches, λ_r = dr/dR and λ_θ = r/R, by the rule of Runge and Kutta and a shooting
//! method. Its formulas are not those of the solver.

/// Steps through the wall.
const STEPS: usize = 200;
/// Places at which a maximum is looked for first.
const SCANNED: usize = 20;

/// First Piola–Kirchhoff stresses [Pa] at principal stretches.
pub type Stress = dyn Fn([f64; 3]) -> [f64; 3];

/// ψ = ½μ(I₁ − 3 − 2 ln J) + ½λ ln²J, by μ and λ [Pa].
pub fn neo_hookean(mu: f64, lambda: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    move |l| {
        let log_j = (l[0] * l[1] * l[2]).ln();
        l.map(|l| mu * (l - 1.0 / l) + lambda * log_j / l)
    }
}

/// ψ = c₁(Ī₁ − 3) + c₂(Ī₂ − 3) + ½ K ln²J.
pub fn mooney_rivlin(c1: f64, c2: f64, bulk: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    move |l| {
        let j = l[0] * l[1] * l[2];
        let squares = l.map(|l| l * l);
        let first: f64 = squares.iter().sum();
        let second = squares[0] * squares[1] + squares[1] * squares[2] + squares[2] * squares[0];
        let (by_first, by_second) = (2.0 * c1 * j.powf(-2.0 / 3.0), 2.0 * c2 * j.powf(-4.0 / 3.0));
        l.map(|l| {
            by_first * (l - first / (3.0 * l))
                + by_second * (l * (first - l * l) - 2.0 * second / (3.0 * l))
                + bulk * j.ln() / l
        })
    }
}

/// ψ = μ/α Σ(λ̄ᵢ^α − 1) + ½ K ln²J.
pub fn ogden(mu: f64, alpha: f64, bulk: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    move |l| {
        let j = l[0] * l[1] * l[2];
        let powers = l.map(|l| (l * j.powf(-1.0 / 3.0)).powf(alpha));
        let mean = powers.iter().sum::<f64>() / 3.0;
        [0, 1, 2].map(|i| (mu * (powers[i] - mean) + bulk * j.ln()) / l[i])
    }
}

/// A wall between two radii at rest [m].
pub struct Wall<'a> {
    /// Inner and outer radius [m].
    pub radii: [f64; 2],
    /// A sphere, or else a tube.
    pub sphere: bool,
    /// The law.
    pub stress: &'a Stress,
}

impl Wall<'_> {
    /// The pressure [Pa] at which the inner radius is so many times that at rest, sought next to a guess [Pa].
    pub fn pressure(&self, stretch: f64, guess: f64) -> f64 {
        let (mut last, mut now) = (guess, guess * 1.001);
        let mut before = self.outside(stretch, last);
        for _ in 0..30 {
            let here = self.outside(stretch, now);
            let next = now - here * (now - last) / (here - before);
            (last, before) = (now, here);
            if (next - now).abs() <= 1e-12 * now.abs() {
                return next;
            }
            now = next;
        }
        now
    }

    /// Stretch of the inner wall and pressure [Pa] where the pressure has a maximum within a tenth of a stretch, with a
    /// guess of the pressure at a stretch.
    pub fn limit(&self, near: f64, guess: impl Fn(f64) -> f64) -> [f64; 2] {
        let pressure = |stretch: f64| self.pressure(stretch, guess(stretch));
        maximum([0.9 * near, 1.1 * near], pressure).expect("a limit as without compressibility")
    }

    /// P_rr at the outer wall [Pa], of a stretch of the inner one and a pressure [Pa].
    pub fn outside(&self, stretch: f64, pressure: f64) -> f64 {
        let [inner, outer] = self.radii;
        let around = if self.sphere { 2.0 } else { 1.0 };
        let stretches =
            |radial: f64, hoop: f64| [radial, hoop, if self.sphere { hoop } else { 1.0 }];
        let mut slope = stretch.powf(-around);
        let by = |at: f64, [r, radial]: [f64; 2]| {
            let hoop = r / at;
            for _ in 0..50 {
                let stress = |slope: f64| (self.stress)(stretches(slope, hoop))[0];
                let d = 1e-6 * slope;
                let by_slope = (stress(slope + d) - stress(slope - d)) / (2.0 * d);
                let step = (stress(slope) - radial) / by_slope;
                slope = (slope - step).max(0.5 * slope);
                if step.abs() < 1e-13 * slope {
                    break;
                }
            }
            [slope, around * ((self.stress)(stretches(slope, hoop))[1] - radial) / at]
        };
        let start = [stretch * inner, -pressure * stretch.powf(around)];
        runge_kutta([inner, outer], STEPS, start, by)[1]
    }
}

/// y at the end of an interval, where y′ = `by`(x, y), by the classic rule of Runge and Kutta.
fn runge_kutta(
    [from, to]: [f64; 2],
    steps: usize,
    start: [f64; 2],
    mut by: impl FnMut(f64, [f64; 2]) -> [f64; 2],
) -> [f64; 2] {
    let h = (to - from) / steps as f64;
    let mut y = start;
    for i in 0..steps {
        let at = from + i as f64 * h;
        let add = |k: [f64; 2], by: f64| [y[0] + by * k[0], y[1] + by * k[1]];
        let k1 = by(at, y);
        let k2 = by(at + 0.5 * h, add(k1, 0.5 * h));
        let k3 = by(at + 0.5 * h, add(k2, 0.5 * h));
        let k4 = by(at + h, add(k3, h));
        for j in 0..2 {
            y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
        }
    }
    y
}

/// Where a smooth function has its largest value inside an interval, and that value; none where it is at an end.
pub fn maximum([from, to]: [f64; 2], f: impl Fn(f64) -> f64) -> Option<[f64; 2]> {
    let grid = |i: usize| from + (to - from) * i as f64 / SCANNED as f64;
    let best = (0..=SCANNED).max_by(|&i, &j| f(grid(i)).total_cmp(&f(grid(j))))?;
    if best == 0 || best == SCANNED {
        return None;
    }
    // of fourth order
    let d = 4e-3;
    let slope = |x: f64| 8.0 * (f(x + d) - f(x - d)) - (f(x + 2.0 * d) - f(x - 2.0 * d));
    let (mut low, mut high) = (grid(best - 1), grid(best + 1));
    for _ in 0..40 {
        let middle = f64::midpoint(low, high);
        if slope(middle) > 0.0 { low = middle } else { high = middle }
    }
    let at = f64::midpoint(low, high);
    Some([at, f(at)])
}
