//! The first trial step of an iteration: its direction and its length.

use mechanics::math::linear::norm;
use scene::config::OptimizerConfig;

use super::Level;
use super::checkpoint::Checkpoint;

/// Length of the first trial relative to the free fraction of a step.
const NEARLY: f64 = 0.9;

/// The longest step that is tried: that of L-BFGS, within bounds if there are any, as
/// far as vertices may move in one iteration and the rest shape does not intersect itself.
pub(super) fn trial_step(
    level: &Level,
    checkpoint: &Checkpoint,
    optimizer: &OptimizerConfig,
) -> Vec<f64> {
    let (theta, gradient) = (&checkpoint.theta, &checkpoint.gradient);
    let fresh = checkpoint.lbfgs.is_empty();
    let edges = if fresh { optimizer.first_step } else { optimizer.largest_step };
    let wanted = edges * level.map().mean_edge();
    let mut step = match level.map().bounds(theta) {
        None => capped(level, theta, checkpoint.lbfgs.direction(gradient), wanted, fresh),
        Some((lower, upper)) if fresh => {
            let down = gradient.iter().map(|g| -g).collect();
            let down = capped(level, theta, down, wanted, true);
            let end = |i: usize| (theta[i] + down[i]).clamp(lower[i], upper[i]);
            (0..theta.len()).map(|i| end(i) - theta[i]).collect()
        }
        Some((lower, upper)) => {
            let end = checkpoint.lbfgs.step(theta, gradient, &lower, &upper);
            let step = end.iter().zip(theta).map(|(e, t)| e - t).collect();
            capped(level, theta, step, wanted, false)
        }
    };
    let free = level.free_fraction(theta, &step);
    if free < 1.0 {
        step.iter_mut().for_each(|d| *d *= NEARLY * free);
    }
    step
}

/// A step from θ that moves exactly as far as `wanted` [m], or its vertices at most as
/// far: pressures have bounds of their own.
fn capped(level: &Level, theta: &[f64], step: Vec<f64>, wanted: f64, exactly: bool) -> Vec<f64> {
    let map = level.map();
    let motion_of = |alpha: f64| {
        let end: Vec<f64> = theta.iter().zip(&step).map(|(t, d)| t + alpha * d).collect();
        if exactly { map.motion(theta, &end) } else { map.vertex_motion(theta, &end) }
    };
    // motion is linear in small steps, so probe with one
    let mut alpha = 1.0;
    let mut motion = motion_of(alpha);
    while motion > 0.1 * wanted {
        alpha *= 0.1;
        motion = motion_of(alpha);
    }
    let scaled = alpha * wanted / motion.max(f64::MIN_POSITIVE);
    let factor = if exactly { scaled } else { scaled.min(1.0) };
    step.into_iter().map(|d| factor * d).collect()
}

/// Norm of the gradient along which θ can go down.
pub(super) fn projected_norm(level: &Level, theta: &[f64], gradient: &[f64]) -> f64 {
    let Some((lower, upper)) = level.map().bounds(theta) else { return norm(gradient) };
    let held = |i: usize| {
        (gradient[i] > 0.0 && theta[i] <= lower[i]) || (gradient[i] < 0.0 && theta[i] >= upper[i])
    };
    let free: Vec<f64> = (0..theta.len()).filter(|&i| !held(i)).map(|i| gradient[i]).collect();
    norm(&free)
}
