//! What is measured of whole runs, and Taylor tests of it.

use super::*;

/// J = Σ_n ω_n (a·x + ½ |x|² + b·f + ½ c |f|²) with random vectors, x = ΠX + u.
pub struct Probe {
    a: Vec<f64>,
    b: Vec<f64>,
    stiff: f64,
}

impl Probe {
    pub fn new(len: usize, forces: bool) -> Self {
        let mut random = Random::new(21);
        let (a, mut b) = (random.numbers(len), random.numbers(len));
        b.iter_mut().for_each(|b| *b *= if forces { 3e-3 } else { 0.0 });
        Self { a, b, stiff: if forces { 1e-2 } else { 0.0 } }
    }

    fn weight(n: usize) -> f64 {
        1.0 / (1.0 + n as f64)
    }

    fn forces(problem: &Problem, rest: &[Vec3], run: &Trajectory, n: usize) -> Vec<f64> {
        if n == 0 {
            return vec![0.0; problem.dofs()];
        }
        let (state, step) = (run.state(n), run.step(problem, rest, n));
        let at = problem.iterate(rest, &state.u, run.times[n]);
        problem.energies.contact_forces(&Iterate { step: Some(&step), ..at })
    }

    fn positions(problem: &Problem, rest: &[Vec3], u: &[f64]) -> Vec<f64> {
        let x = flat(&problem.space.node_positions(rest));
        x.iter().zip(u).map(|(x, u)| 10.0 * (x + u)).collect()
    }

    pub fn value(&self, problem: &Problem, rest: &[Vec3], run: &Trajectory) -> f64 {
        let mut sum = 0.0;
        for n in 0..=run.steps() {
            let x = Self::positions(problem, rest, &run.state(n).u);
            let f = Self::forces(problem, rest, run, n);
            let of_x = dot(&self.a, &x) + 0.5 * dot(&x, &x);
            let of_f = dot(&self.b, &f) + 0.5 * self.stiff * dot(&f, &f);
            sum += Self::weight(n) * (of_x + of_f);
        }
        sum
    }

    pub fn gradient(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        run: &Trajectory,
    ) -> Gradient {
        let forces: Vec<_> =
            (0..=run.steps()).map(|n| Self::forces(problem, rest, run, n)).collect();
        let xs = |n: usize| Self::positions(problem, rest, &run.state(n).u);
        let xs: Vec<_> = (0..=run.steps()).map(xs).collect();
        let mut by_x = vec![0.0; problem.dofs()];
        let partials = |_: &_, n: usize, out: &mut Partials| {
            for d in 0..by_x.len() {
                let by = 10.0 * Self::weight(n) * (self.a[d] + xs[n][d]);
                out.by_u[d] += by;
                by_x[d] += by;
                let by_force = self.b[d] + self.stiff * forces[n][d];
                out.by_contact[d] += Self::weight(n) * by_force * f64::from(n > 0);
            }
        };
        let (on, known) = ((rest, run), &Linearizations::default());
        let swept = sweep(problem, workspace, on, known, Wanted::All, partials);
        let mut gradient = swept.expect("regular");
        problem.space.add_to_vertices(&by_x, &mut gradient.rest);
        gradient
    }
}

/// A family of runs by numbers that are 1 in the run whose gradient is checked.
pub struct Runs<'a> {
    pub problem: &'a dyn Fn(&[f64]) -> (Problem, Workspace),
    pub run: &'a dyn Fn(&Problem, &mut Workspace, &[Vec3]) -> Trajectory,
    /// Whether the forces of contact are measured.
    pub forces: bool,
}

impl Runs<'_> {
    /// What is measured of the run by numbers.
    fn value(&self, numbers: &[f64], rest: &[Vec3]) -> f64 {
        let (problem, mut workspace) = (self.problem)(numbers);
        let run = (self.run)(&problem, &mut workspace, rest);
        Probe::new(problem.dofs(), self.forces).value(&problem, rest, &run)
    }

    /// Taylor tests by the rest shape with a first step [m], and by numbers with theirs; `by` are the derivatives by each
    /// group of numbers, in their order.
    pub fn check(
        &self,
        rest: &[Vec3],
        step: f64,
        groups: &[f64],
        by: impl Fn(&Gradient) -> Vec<Vec<f64>>,
    ) -> (Problem, Trajectory, Gradient) {
        let count = |by: &[Vec<f64>]| by.iter().map(Vec::len).sum::<usize>();
        let many = [1.0; 32];
        let (problem, mut workspace) = (self.problem)(&many);
        let run = (self.run)(&problem, &mut workspace, rest);
        let probe = Probe::new(problem.dofs(), self.forces);
        let gradient = probe.gradient(&problem, &mut workspace, rest, &run);
        let by = by(&gradient);
        let ones = vec![1.0; count(&by)];
        check_gradient(&flat(rest), &gradient.rest, step, |x| self.value(&ones, &points(x)));
        let mut first = 0;
        for (by, step) in by.iter().zip(groups) {
            check_gradient(&vec![1.0; by.len()], by, *step, |x| {
                let mut numbers = ones.clone();
                numbers[first..first + x.len()].copy_from_slice(x);
                self.value(&numbers, rest)
            });
            first += by.len();
        }
        (problem, run, gradient)
    }
}

/// Derivatives by numbers as those by factors of them.
pub fn by_factors(gradient: &Gradient, owner: Owner, numbers: &[f64]) -> Vec<f64> {
    let by = gradient.parameters.total(owner);
    assert_eq!(by.len(), numbers.len());
    by.iter().zip(numbers).map(|(by, number)| by * number).collect()
}
