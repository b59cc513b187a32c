//! The first steps of published scenes against those of PolyFEM.

use polyfem::Options;
use serde_json::Value;
use solver::plot::{Axes, Series, Style, draw};
use tests::polyfem::{Compared, Touch, compare, reference, scene};
use tests::workdir::repository;

/// Asserts how far probes and elastic energies are off before and after surfaces meet, as a fraction
/// of the largest displacement.
fn agree(steps: &[Compared], contact: usize, before: f64, after: f64) {
    assert!(!steps.is_empty());
    for &Compared { step, difference, elastic: [ours, theirs], .. } in steps {
        let limit = if step < contact { before } else { after };
        assert!(difference < limit, "step {step}: {difference:.2e}, not below {limit:.0e}");
        // six digits are known, and it grows with the square of the displacement
        let limit = 1e-5 + 10.0 * limit;
        assert!((ours / theirs - 1.0).abs() < limit, "step {step}: {ours} and {theirs} J");
    }
}

fn as_published(_: &mut Value) {}

/// Until the legs touch the ground in step 5. In a slab the field may vary
/// over the depth, where theirs may not: the less the thinner it is. The slab of the default
/// thickness goes the same way, and further, in the next test.
#[test]
fn the_walker_in_flight() {
    let Some(reference) = reference("walker_dyn50") else { return };
    let file = "walker/state_walker.json";
    let options = Options { form: None, thickness: Some(3e-4) };
    let Some((_dir, scene)) = scene(file, &options, as_published) else { return };
    agree(&compare(scene, &reference, 4), usize::MAX, 2e-6, 0.0);
}

/// Largest difference of what `of` measures of all steps in contact, over its
/// largest value.
fn apart(steps: &[Compared], of: impl Fn(&Touch) -> f64) -> f64 {
    let touching = || steps.iter().filter(|s| s.touch.iter().all(|t| t.gap.is_some()));
    let both = || touching().map(|s| s.touch.each_ref().map(&of));
    let largest = both().map(|[_, theirs]| theirs.abs()).fold(0.0, f64::max);
    both().map(|[ours, theirs]| (ours - theirs).abs()).fold(0.0, f64::max) / largest
}

/// Draws what `of` measures of every step, ours and theirs.
fn picture(name: &str, y: &str, steps: &[Compared], of: impl Fn(&Touch) -> Option<f64>) {
    let curve = |which: usize| -> Vec<(f64, f64)> {
        let point = |s: &Compared| Some((s.step as f64, of(&s.touch[which])?));
        steps.iter().filter_map(point).collect()
    };
    let one = |which: usize, label: &str, style: Style| Series {
        label: Some(label.to_owned()),
        points: curve(which),
        style,
        turn: which,
    };
    let series =
        [one(1, "PolyFEM, in the plane", Style::Circles(5)), one(0, "slab", Style::Dotted(2))];
    let axes = Axes { x: "time step of 20 ms".to_owned(), y: y.to_owned(), ..Axes::default() };
    draw(&repository().join("build").join(name), &axes, &series).unwrap();
}

#[test]
#[ignore = "a minute, and draws build/walker-force.svg and -gap.svg: runs in make test-all"]
fn the_walker_on_its_way() {
    let Some(reference) = reference("walker_dyn50") else { return };
    let file = "walker/state_walker.json";
    let Some((_dir, scene)) = scene(file, &Options::default(), as_published) else { return };
    let activation = scene.config.contact().unwrap().activation.unwrap();
    let steps = compare(scene, &reference, 50);
    agree(&steps, 5, 1e-4, 1e-2);
    let force = apart(&steps, |t| t.force.y);
    let gap = apart(&steps, |t| t.gap.unwrap());
    eprintln!("force off by {force:.2e} of the largest, gap by {gap:.2e}");
    assert!(force < 0.02, "{force:e}");
    let up = "force of contact [N per metre of depth]";
    picture("walker-force.svg", up, &steps, |t| Some(t.force.y));
    picture("walker-gap.svg", "smallest gap / activation", &steps, |t| Some(t.gap? / activation));
}

#[test]
#[ignore = "two minutes: runs in make test-all"]
fn the_worm_falls_and_lands() {
    let Some(reference) = reference("worm_dyn_steps1to2") else { return };
    let file = "worm/state_worm.json";
    let Some((_dir, scene)) = scene(file, &Options::default(), as_published) else { return };
    let steps = compare(scene, &reference, 2);
    agree(&steps, 2, 1e-9, 1e-6);
    let [force, gap] = [apart(&steps, |t| t.force.z), apart(&steps, |t| t.gap.unwrap())];
    eprintln!("force off by {force:.1e}, gap by {gap:.1e}");
    assert!(force < 1e-6 && gap < 1e-6, "{force:e} {gap:e}");
}
