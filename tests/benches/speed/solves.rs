//! Whole static solves from rest, each in a process of its own.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use mechanics::energy::Hessian;
use mechanics::forward::{Timings, solve};
use mechanics::math::linear::Precision;
use program::peak_rss_mb;
use serde::{Deserialize, Serialize};

use crate::cases;
use crate::row::{Row, Seconds, Work, find};

/// Runs of one solve, and the time after which there is no further one [s].
const RUNS: usize = 3;
const ENOUGH_SECONDS: f64 = 20.0;

/// What one process has measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solve {
    /// Name of the case.
    pub body: String,
    /// Degrees of freedom.
    pub dofs: usize,
    /// Newton iterations, those of rejected load steps included.
    pub newton_iterations: usize,
    /// Accepted load steps.
    pub load_steps: usize,
    /// Numbering, pattern, ordering and symbolic factorisation [s].
    pub setup_s: f64,
    /// From rest to the certified equilibrium, without the set-up [s].
    pub solve_s: f64,
    /// Parts of it.
    pub timings: Timings,
    /// Stored entries of the factor.
    pub factor_len: usize,
    /// Operations of one factorisation.
    pub factor_flops: f64,
    /// Operations of supernodes that must follow one another; none in histories from before
    /// it was measured.
    #[serde(default)]
    pub chain_flops: Option<f64>,
    /// Largest resident set of the whole solve [MiB].
    pub peak_mb: f64,
    /// Gradient and Hessian once more, at the equilibrium [s].
    pub assembly_once_s: f64,
    /// The factorisation there [s].
    pub factor_once_s: f64,
}

impl Solve {
    /// Set-up and solve [s].
    pub fn total_s(&self) -> f64 {
        self.setup_s + self.solve_s
    }

    /// Time of a Newton iteration, with its share of the set-up [s].
    fn iteration_s(&self) -> f64 {
        self.total_s() / self.newton_iterations as f64
    }

    /// That in units of the time in which a dense product of this run makes the operations of one factorisation: a
    /// number that does not depend on how fast the machine is.
    fn units(&self, dgemm: f64) -> f64 {
        self.iteration_s() * dgemm / self.factor_flops
    }

    /// The solve without its named parts [s].
    fn rest_s(&self) -> f64 {
        let t = &self.timings;
        self.solve_s - t.assembly.wall_s - t.factor.wall_s - t.solve.wall_s - t.certificate.wall_s
    }
}

/// Solves a case in this process and prints the measurement; prints nothing
/// where the body is not at hand.
pub fn child(name: &str) -> Result<()> {
    let Some(scene) = cases::scene(name)? else { return Ok(()) };
    let rest = &scene.body.mesh.vertices;
    let clock = Instant::now();
    let (problem, mut workspace) = scene.problem(&scene.body)?;
    let setup_s = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let solution = solve(&problem, &mut workspace, rest, &scene.stepping(), |_| ())?;
    let solve_s = clock.elapsed().as_secs_f64();
    let timings = workspace.timings;
    let peak_mb = peak_rss_mb().context("no VmHWM in /proc/self/status")?;
    let clock = Instant::now();
    let at = problem.iterate(rest, &solution.u, 1.0);
    workspace.gradient(&problem, &at);
    let hessian = workspace.hessian(&problem, &at, Hessian::Exact);
    let assembly_once_s = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    workspace
        .factor(|linear| linear.factor_positive(hessian, Precision::Single).map(drop))
        .context("the equilibrium is not stable")?;
    let factor_once_s = clock.elapsed().as_secs_f64();
    let cost = workspace.linear().cost();
    let measured = Solve {
        body: name.to_owned(),
        dofs: problem.dofs(),
        newton_iterations: solution.newton_iterations,
        load_steps: solution.steps.len(),
        setup_s,
        solve_s,
        timings,
        factor_len: cost.entries,
        factor_flops: cost.flops,
        chain_flops: Some(cost.chain_flops),
        peak_mb,
        assembly_once_s,
        factor_once_s,
    };
    serde_json::to_writer(std::io::stdout(), &measured)?;
    Ok(())
}

/// Runs of one case, the one with the median time first.
pub fn repeat(name: &str) -> Result<Option<(Row, Solve)>> {
    eprintln!("solving {name}");
    let mut runs = Vec::new();
    while runs.len() < RUNS && runs.iter().map(Solve::total_s).sum::<f64>() < ENOUGH_SECONDS {
        let Some(run) = once(name, None)? else { return Ok(None) };
        runs.push(run);
    }
    runs.sort_by(|a, b| a.total_s().total_cmp(&b.total_s()));
    let one_thread_s = once(name, Some(1))?.map(|run| run.total_s());
    let row = Row {
        one_thread_s,
        what: "static solve".to_owned(),
        body: name.to_owned(),
        dofs: Some(runs[0].dofs),
        seconds: Seconds::new(runs.iter().map(Solve::total_s).collect()),
        work: Work::Dofs(runs[0].dofs as f64),
        peak_mb: runs.iter().map(|r| r.peak_mb).reduce(f64::max),
        beside: String::new(),
    };
    Ok(Some((row, runs.swap_remove(runs.len() / 2))))
}

/// On a number of threads; on all without one.
fn once(name: &str, threads: Option<usize>) -> Result<Option<Solve>> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["--solve", name]).stderr(Stdio::inherit());
    if let Some(threads) = threads {
        command.env("RAYON_NUM_THREADS", threads.to_string());
    }
    let output = command.output()?;
    ensure!(output.status.success(), "the solve of {name} failed: {}", output.status);
    if output.stdout.is_empty() {
        return Ok(None);
    }
    Ok(Some(serde_json::from_slice(&output.stdout)?))
}

/// The parts of the solves as a table, with the rate of a dense product in double precision [operations/s].
pub fn parts(solves: &[Solve], dgemm: Option<f64>) -> String {
    let mut text = format!(
        "{:<12}{:>8}{:>7}{:>8}{:>10}{:>8}{:>8}{:>7}{:>7}{:>8}{:>10}{:>8}{:>8}{:>8}{:>8}\n",
        "static solve",
        "dofs",
        "Newton",
        "set-up",
        "assembly",
        "factor",
        "solves",
        "proof",
        "rest",
        "peak MB",
        "entries M",
        "GFlop",
        "chain %",
        "Mdof/s",
        "units"
    );
    for s in solves {
        let t = &s.timings;
        text += &format!(
            "{:<12}{:>8}{:>7}{:>8.2}{:>10.2}{:>8.2}{:>8.2}{:>7.2}{:>7.2}{:>8.0}{:>10.1}{:>8.1}{:>8}{:>8.2}{:>8}\n",
            s.body,
            s.dofs,
            s.newton_iterations,
            s.setup_s,
            t.assembly.wall_s,
            t.factor.wall_s,
            t.solve.wall_s,
            t.certificate.wall_s,
            s.rest_s(),
            s.peak_mb,
            1e-6 * s.factor_len as f64,
            1e-9 * s.factor_flops,
            s.chain_flops
                .map_or_else(|| "-".to_owned(), |c| format!("{:.0}", 100.0 * c / s.factor_flops)),
            1e-6 * s.dofs as f64 / s.iteration_s(),
            dgemm.map_or_else(|| "-".to_owned(), |rate| format!("{:.2}", s.units(rate))),
        );
    }
    text += "Mdof/s: degrees of freedom per time of a Newton iteration; units: that time in those in which dgemm of this \
             run makes the operations of one factorisation\n";
    text
}

/// The cores that were busy in the tasks of some runs, by name, with their share of the
/// time; tasks below 3 % are left out.
pub fn busy_cores<'a>(runs: impl Iterator<Item = (String, &'a Timings)>) -> String {
    let mut text = String::from("cores busy (share of the time)\n");
    for (name, timings) in runs {
        let total = timings.total();
        text += &format!("{name:<20}");
        for (task, time) in timings.tasks() {
            let share = time.wall_s / total.wall_s;
            if let (true, Some(busy)) = (share > 0.03, time.busy_cores()) {
                text += &format!("  {task} {busy:.2} ({:.0} %)", 100.0 * share);
            }
        }
        let whole = total.busy_cores().unwrap_or_default();
        text += &format!("  together {whole:.2}\n");
    }
    text
}

/// Whole solves of PolyFEM (661588e8, Pardiso, 2 threads) of the same bodies under
/// the same load, from rest in one load step: body, seconds, peak memory [GB].
const POLYFEM: [(&str, f64, f64); 2] = [("gripper-p1", 13.5, 1.2), ("gripper-p2", 107.7, 6.3)];

/// Its steps 1 to 5 of the worm, which are dynamic and with contact, took 225.3 s
/// for 40 Newton iterations, of which assembly and linear solves are half.
const POLYFEM_WORM: f64 = 0.5 * 225.3 / 40.0;

/// Sets what PolyFEM took beside our solves.
pub fn compare(rows: &mut [Row], solves: &[Solve]) {
    for row in rows.iter_mut().filter(|r| r.what == "static solve") {
        let reference = POLYFEM.iter().find(|r| r.0 == row.body);
        if let (Some((_, seconds, gb)), Some(peak)) = (reference, row.peak_mb) {
            row.beside = format!(
                "PolyFEM {seconds} s, {gb} GB: {:.1} × as fast, {:.2} of the memory",
                seconds / row.seconds.median,
                peak * 1.048_576e-3 / gb
            );
        }
        let solve = solves.iter().find(|s| s.body == row.body);
        if let (true, Some(s)) = (row.body == "worm-p2", solve) {
            let ours =
                (s.timings.assembly.wall_s + s.timings.factor.wall_s + s.timings.solve.wall_s)
                    / s.newton_iterations as f64;
            row.beside = format!(
                "assembly and linear solve per iteration {ours:.2} s, PolyFEM's (dynamic, with \
                 contact) {POLYFEM_WORM:.2} s: {:.1} × as fast",
                POLYFEM_WORM / ours
            );
        }
    }
}

/// Targets for the times of the gripper, and whether they are met.
pub fn targets(rows: &[Row], solves: &[Solve], dgemm: Option<f64>) -> Vec<String> {
    let body = "gripper-p2";
    let seconds = |what: &str| find(rows, what, body).map(|r| r.seconds.median);
    let mut lines = Vec::new();
    let mut judge = |text: String, met: bool| {
        lines.push(format!("{}  {text}", if met { "met    " } else { "not met" }));
    };
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let dense = crate::dense::name("dense LLᵀ", all);
    if let (Some(double), Some(factor), Some(dense)) =
        (seconds("factor, double"), seconds("factor"), find(rows, &dense, &format!("as {body}")))
    {
        // like with like: the dense rate is that of double precision
        let share = dense.seconds.median / double;
        judge(
            format!("factorisation at {:.0} % of the dense rate, wanted 70 %", 100.0 * share),
            share >= 0.7,
        );
        if let (Some(gradient), Some(hessian)) = (seconds("gradient"), seconds("Hessian")) {
            let share = (gradient + hessian) / factor;
            judge(
                format!("gradient and Hessian take {share:.2} of a factorisation, wanted 0.33"),
                share <= 1.0 / 3.0,
            );
        }
    }
    if let Some(s) = solves.iter().find(|s| s.body == body) {
        let gb = s.peak_mb * 1.048_576e-3;
        if let Some(units) = dgemm.map(|rate| s.units(rate)) {
            judge(format!("a Newton iteration takes {units:.2} units, wanted 0.50"), units <= 0.5);
        }
        judge(format!("peak memory {gb:.2} GB, wanted 2.5"), gb < 2.5);
        let times = POLYFEM[1].1 / s.total_s();
        judge(format!("static solve {times:.1} × as fast as PolyFEM, wanted 8"), times >= 8.0);
    }
    lines
}
