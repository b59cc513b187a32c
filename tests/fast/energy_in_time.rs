//! The energy that integrators add to a chamber that is blown up at once.

use tests::chamber;

/// Growth of oscillations of which `bdf3` warns shows in the energy; generalized-α adds next to none.
#[test]
fn the_energy_that_steps_add_is_reported() {
    let dir = chamber::workdir();
    let scene = dir.text("p1.toml").replace("d1 = 1e6", "d1 = 1e6\ndensity = 1000");
    let gain = |method: &str| {
        let time = format!("\n[time]\nend = 0.1\nsteps = 100\nmethod = \"{method}\"\n");
        dir.write("blown.toml", &(scene.clone() + &time));
        let run = dir.solver(&format!("simulate blown.toml -o {method} --final-only"));
        run.assert_good();
        let report = dir.json(&format!("{method}/report.json"));
        let gain = report["energy_balance"]["largest_gain"].as_f64().unwrap();
        let warned = run.stderr.contains("add energy");
        assert_eq!(warned, gain > 0.1, "{gain} {}", run.stderr);
        gain
    };
    let (grows, stays) = (gain("bdf3"), gain("generalized-alpha"));
    assert!(grows > 0.1, "{grows}");
    assert!(stays < 0.05, "{stays}");
}
