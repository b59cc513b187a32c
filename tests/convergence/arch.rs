//! Shallow arches that snap through or bend sideways under a load.
//!
//! An arch z = ½a h(1 − cos κx), κ = 2π/L, of thickness h and Poisson's ratio 0, clamped at both ends, under a load per
//! area of E κ⁴ h⁴ p cos κx, stays of that form with an amplitude b in place of a:
//!
//! p(b) = (a − b)/24 + (a² − b²) b/32
//!
//! from its bending and its thrust N = E b h κ²h²(a² − b²)/16. It snaps at the largest p, b² = (a² − 4/3)/3, if the
//! thrust stays below N L²/(EI) = 4 x², tan x = x; else it bends sideways there. What the formula neglects goes with the square of
//! κh.

use std::f64::consts::PI;

use mechanics::energy::{BodyForce, Energies};
use mechanics::forward::Singularity;
use mechanics::material::{Lame, NeoHookean};
use mechanics::schedule::{Field, Schedule};
use mechanics::stability::FirstLimit;
use mechanics::testing::whole;
use mesh::{TetMesh, Vec3};
use tests::block;
use tests::equilibrium::{Equilibrium, draw_path};

/// Distance of the ends [m], and Young's modulus [Pa].
const LENGTH: f64 = 1.0;
const YOUNG: f64 = 1e6;

fn load(rise: f64, b: f64) -> f64 {
    (rise - b) / 24.0 + (rise * rise - b * b) * b / 32.0
}

/// The cube [0, 1]³ in so many cells along x, an even number, 1 and 2, symmetrical to x = ½.
fn symmetrical(cells: usize) -> TetMesh {
    let (size, half) = (Vec3::new(1.0 / cells as f64, 1.0, 0.5), Vec3::new(0.5, 0.0, 0.0));
    let place = |p: Vec3| p.component_mul(&size) - half;
    let mut mesh = whole(&block([cells / 2, 1, 2], 1.0, |_| false, place));
    mesh.vertices.iter_mut().for_each(|x| *x += half);
    mesh
}

/// An arch of a thickness [m] in so many cells, with a full load.
fn arch(rise: f64, to: f64, h: f64, cells: usize) -> Equilibrium {
    let k = 2.0 * PI / LENGTH;
    let place = |s: Vec3| {
        let angle = 2.0 * PI * s.x;
        let normal = Vec3::new(-0.5 * rise * h * k * angle.sin(), 0.0, 1.0).normalize();
        let line = Vec3::new(LENGTH * s.x, 0.05 * s.y, 0.5 * rise * h * (1.0 - angle.cos()));
        line + (s.z - 0.5) * h * normal
    };
    let mut mesh = symmetrical(cells);
    mesh.vertices.iter_mut().for_each(|x| *x = place(*x));
    let force = format!("{:e}*t*cos({k}*x)", to * YOUNG * k.powi(4) * h.powi(3));
    let energies = |_: &_| {
        let field = Field([0.0.into(), 0.0.into(), force.parse::<Schedule>().unwrap()]);
        let law = NeoHookean(Lame::new(YOUNG, 0.0));
        Energies::elastic(Box::new(law)).with(BodyForce::whole(field))
    };
    let held = |p: Vec3| {
        let clamped = p.x < 1e-9 || p.x > LENGTH - 1e-9;
        [clamped, true, clamped]
    };
    Equilibrium::new(mesh, 2, energies, held)
}

/// The node in the middle of the crown.
fn crown(arch: &Equilibrium, height: f64) -> usize {
    let place = Vec3::new(0.5 * LENGTH, 0.0, height);
    let nodes = arch.problem.space.node_positions(&arch.rest);
    nodes.iter().position(|x| (x - place).norm() < 1e-9).expect("a node at the crown")
}

/// p and b at the first limit.
fn first_limit(rise: f64, to: f64, h: f64, cells: usize, kind: Singularity) -> [f64; 2] {
    let mut arch = arch(rise, to, h, cells);
    let FirstLimit::Found(limit, _) = arch.first_limit(|_| ()) else { panic!("no limit") };
    assert!(limit.kind == kind && limit.others == 0, "{:?}", limit.kind);
    [limit.at.time * to, rise + limit.at.u[3 * crown(&arch, rise * h) + 2] / h]
}

/// What second order tends to from two results, the second with half as large cells or thickness.
fn tends_to(coarse: [f64; 2], fine: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| (4.0 * fine[i] - coarse[i]) / 3.0)
}

/// The limit for cells, and then for thickness, that tend to zero. Threshold, set before: 1e-3 of load and amplitude.
fn check(rise: f64, exact: [f64; 2], to: f64, kind: Singularity) {
    eprintln!("arch of rise {rise}: p, b {exact:.6?}");
    let thick = [0.02, 0.01].map(|h| {
        let found = [40, 80].map(|cells| first_limit(rise, to, h, cells, kind));
        let limit = tends_to(found[0], found[1]);
        eprintln!("  h = {h}, 40 and 80 cells: {found:.6?}, tend to {limit:.6?}");
        limit
    });
    let limit = tends_to(thick[0], thick[1]);
    let errors = [0, 1].map(|i| limit[i] / exact[i] - 1.0);
    eprintln!("  thin: {limit:.6?}, errors {errors:.6?}");
    assert!(errors.iter().all(|e| e.abs() < 1e-3), "{errors:?}");
}

#[test]
fn a_shallow_arch_snaps_at_its_closed_form() {
    let rise: f64 = 1.5;
    let turn = ((rise * rise - 4.0 / 3.0) / 3.0).sqrt();
    let top = load(rise, turn);
    check(rise, [top, turn], 1.2 * top, Singularity::LimitPoint);
}

#[test]
#[ignore = "a quarter of a minute: runs in make test-all"]
fn a_higher_arch_bends_sideways_at_its_closed_form() {
    let rise: f64 = 2.5;
    let x: f64 = 4.493_409_457_909_064;
    assert!((x.tan() / x - 1.0).abs() < 1e-9);
    // N L²/(EI) = 12 (2π)² (a² − b²)/16
    let amplitude = (rise * rise - 16.0 * x * x / (12.0 * PI * PI)).sqrt();
    let leaves = load(rise, amplitude);
    check(rise, [leaves, amplitude], 1.5 * leaves, Singularity::Bifurcation);
}

/// The load falls after the snap and rises again. Threshold, set before: 1 % of the largest load.
#[test]
#[ignore = "ten seconds, and draws build/path-arch.svg: runs in make test-all"]
fn the_path_of_an_arch_goes_on_beyond_its_snap() {
    let (rise, h) = (1.5_f64, 0.01);
    let top = load(rise, ((rise * rise - 4.0 / 3.0) / 3.0).sqrt());
    let mut arch = arch(rise, 1.3 * top, h, 80);
    let middle = 3 * crown(&arch, rise * h) + 2;
    let steps = arch.follow(0.2, |_| true);
    let states: Vec<[f64; 2]> =
        steps.iter().map(|step| [rise + step.u[middle] / h, 1.3 * top * step.time]).collect();
    let errors = states.iter().map(|&[b, p]| (p - load(rise, b)).abs() / top);
    let worst = errors.fold(0.0, f64::max);
    let lowest = states.iter().map(|s| s[1]).fold(f64::INFINITY, f64::min);
    let [end, _] = *states.last().unwrap();
    eprintln!(
        "arch beyond its snap, {} states to b = {end:.3}, off by {worst:.1e} of the largest load",
        states.len()
    );
    assert!(worst < 0.01 && end < -1.0 && lowest < top, "{worst} {end}");
    let points = || steps.iter().map(|step| step.path.as_deref().unwrap());
    let passed: Vec<Singularity> = points().flat_map(|p| &p.passed).map(|p| p.kind).collect();
    assert_eq!(passed, [Singularity::LimitPoint; 2]);
    // it falls between both, on an unstable branch
    assert!(points().all(|p| p.stability.negative == usize::from(p.load_rate < 0.0)));
    let curve: Vec<[f64; 2]> =
        (0..=150).map(|i| rise - 0.02 * f64::from(i)).map(|b| [b, load(rise, b)]).collect();
    draw_path("path-arch.svg", ["amplitude over thickness", "load over E κ⁴ h⁴"], &states, &curve);
}
