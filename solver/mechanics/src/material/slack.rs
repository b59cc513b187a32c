//! The square of a strain that counts in tension only, with a smooth beginning.
//!
//! q(ε) = 0 for ε ≤ 0      q′(ε) = 2 ε g(ε/w), g(t) = 3t² − 2t³ for 0 < ε < w      q′(ε) = 2 ε for ε ≥ w
//!
//! with the slack w. q is twice continuously differentiable and convex, as q″ = 18t² − 16t³ ≥ 0 for t ≤ 1.
//! Beyond the slack q = ε² − 0.3 w²: the force ½ k q′ is k ε exactly, and the slack costs a constant alone.
//! At ε = 0 there is no stiffness, so that rest is free of stress.

/// Strain over which fibres and threads become taut, unless a scene says otherwise [1].
pub const DEFAULT_SLACK: f64 = 1e-3;

/// q, q′ and q″ of a strain; without a slack ε², 2 ε and 2: compression counts as tension does.
#[inline]
pub fn square(strain: f64, slack: Option<f64>) -> [f64; 3] {
    let Some(w) = slack.filter(|w| strain < *w) else {
        let constant = slack.map_or(0.0, |w| 0.3 * w * w);
        return [strain * strain - constant, 2.0 * strain, 2.0];
    };
    if strain <= 0.0 {
        return [0.0; 3];
    }
    let t = strain / w;
    let t2 = t * t;
    [w * w * t2 * t2 * (1.5 - 0.8 * t), 2.0 * w * t * t2 * (3.0 - 2.0 * t), t2 * (18.0 - 16.0 * t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_twice_continuously_differentiable() {
        let w = 0.02;
        for edge in [0.0, w] {
            let [before, after] = [edge - 1e-12, edge + 1e-12].map(|e| square(e, Some(w)));
            for k in 0..3 {
                assert!((before[k] - after[k]).abs() < 1e-8, "{edge} {k}: {before:?} {after:?}");
            }
        }
    }

    #[test]
    fn beyond_the_slack_the_force_is_exact() {
        let [_, force, stiffness] = square(0.05, Some(0.02));
        assert_eq!((force, stiffness), (0.1, 2.0));
        assert_eq!(square(-0.05, Some(0.02)), [0.0; 3]);
    }
}
