//! What the log says of a cascade.

use mechanics::forward::about;
use scene::config::LevelConfig;

use crate::optimize::{Checkpoint, Level, shares};

/// Time for the iterations that are left, if they take as long as in this level.
pub fn time_left(levels: &[LevelConfig], checkpoint: &Checkpoint) -> String {
    if checkpoint.iteration == 0 {
        return String::new();
    }
    let all: usize = levels[checkpoint.level..].iter().map(|l| l.iterations).sum();
    let left = all.saturating_sub(checkpoint.iteration) as f64;
    let seconds = left * checkpoint.spent_s / (checkpoint.iteration + 1) as f64;
    format!("  about {} left", about(seconds))
}

/// Says what a level has gained, and whether one term has hidden the others.
pub fn say_gain(checkpoint: &Checkpoint) {
    let level = checkpoint.level + 1;
    let first = checkpoint.merit_of_level;
    let gain = (first - checkpoint.merit) / first.abs();
    let costs = if checkpoint.bounds.is_empty() { "" } else { " with what violations cost" };
    log::info!("level {level} has lowered the objective{costs} by {:.2} %", 100.0 * gain);
    if let Some(hint) = shares::drowns(&checkpoint.first_terms, &checkpoint.terms) {
        log::warn!("level {level}: {hint}");
    }
}

/// Names the variables of loads that are held back by their bounds.
pub fn say_bounds(level: &Level, checkpoint: &Checkpoint) {
    let Some((low, high)) = level.map().bounds(&checkpoint.theta) else { return };
    let first = level.map().shape_variables();
    let named = level.map().named_load_variables().iter().enumerate();
    let held: Vec<&str> = named
        .filter(|(k, _)| {
            let i = first + k;
            let (own, slope) = (checkpoint.theta[i], checkpoint.gradient[i]);
            let near = 1e-6 * (high[i] - low[i]);
            own - low[i] <= near && slope > 0.0 || high[i] - own <= near && slope < 0.0
        })
        .map(|(_, variable)| variable.path.as_str())
        .collect();
    if let [first, others @ ..] = &held[..] {
        let more = match others.len() {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        log::info!(
            "{first}{more}: at the bounds of the design, beyond which the objective would fall"
        );
    }
}

/// What changes in a level, for the log.
pub fn variables(level: &Level, settings: &LevelConfig) -> String {
    match settings.describe() {
        said if said.is_empty() => format!("{} variables of loads", level.variables()),
        said => said,
    }
}
