//! Chambers with a prescribed volume against the pressures that lead there.

use tests::bar::{HELD, difference, simulate};

/// Pressures of the three chambers [Pa], one of them a vacuum.
const PRESSURES: [(&str, f64); 3] = [("left", 30e3), ("middle", -10e3), ("right", 55e3)];

#[test]
fn the_volume_of_a_pressure_needs_that_pressure() {
    let pressures: String = PRESSURES
        .iter()
        .map(|(on, p)| format!("[[chamber]]\non = \"{on}\"\npressure = {p}\n"))
        .collect();
    let isobaric = simulate(&format!("{HELD}{pressures}"));
    let chambers = isobaric.last_chambers();
    // by change, and by factor
    let volumes = PRESSURES.iter().enumerate().map(|(i, (on, _))| {
        let chamber = &chambers[*on];
        let value = match i % 2 {
            0 => format!("volume_change = {:e}", chamber.volume - chamber.volume_rest),
            _ => format!("volume_factor = {:e}", chamber.volume / chamber.volume_rest),
        };
        format!("[[chamber]]\non = \"{on}\"\n{value}\n")
    });
    let volumes: String = volumes.collect();
    let held = simulate(&format!("{HELD}{volumes}"));
    let found = held.last_chambers();
    eprintln!(
        "three chambers by volume: {} Newton iterations, by pressure {}",
        held.solution.newton_iterations, isobaric.solution.newton_iterations
    );
    for (on, pressure) in PRESSURES {
        let chamber = &found[on];
        let (gap, error) =
            (chamber.volume / chambers[on].volume - 1.0, chamber.pressure / pressure - 1.0);
        eprintln!("  {on}: V off by {gap:.1e}, P {:.6} Pa, off by {error:.1e}", chamber.pressure);
        assert!(gap.abs() < 1e-10 && error.abs() < 1e-8);
    }
    let gap = difference(&held.solution.u, &isobaric.solution.u);
    assert!(gap < 1e-8, "{gap:e}");
}

/// One chamber of each kind; each agrees with its own law.
#[test]
fn volume_gas_and_pressure_work_together() {
    let loads = "[[chamber]]\non = \"left\"\nvolume_factor = 1.2\n\
                 [[chamber]]\non = \"middle\"\nfill = 0\nambient = 101.3e3\nexponent = 1.4\n\
                 [[chamber]]\non = \"right\"\npressure = 40e3\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    let chambers = simulated.last_chambers();
    let [left, middle, right] = ["left", "middle", "right"].map(|on| &chambers[on]);
    assert!((left.volume / left.volume_rest / 1.2 - 1.0).abs() < 1e-10);
    assert!(left.pressure > 1e3, "{}", left.pressure);
    let by_law = 101.3e3 * ((middle.volume_rest / middle.volume).powf(1.4) - 1.0);
    assert!((middle.pressure / by_law - 1.0).abs() < 1e-10 && by_law.abs() > 10.0, "{by_law}");
    assert_eq!(right.pressure, 40e3);
    // nothing but the three pressures acts: prescribing them gives the same shape
    let same: String = [("left", left), ("middle", middle), ("right", right)]
        .iter()
        .map(|(on, chamber)| {
            format!("[[chamber]]\non = \"{on}\"\npressure = {:e}\n", chamber.pressure)
        })
        .collect();
    let isobaric = simulate(&format!("{HELD}{same}"));
    assert!(difference(&simulated.solution.u, &isobaric.solution.u) < 1e-8);
}

/// A pump that fills the chamber, keeps its volume and empties it.
#[test]
fn a_volume_follows_its_schedule() {
    let loads = "[time]\nmethod = \"quasistatic\"\nend = 2.0\nsteps = 4\n\
                 [[chamber]]\non = \"middle\"\n\
                 volume_change = { t = [0, 1, 1.5, 2], value = [0, 4e-7, 4e-7, 0] }\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    let ends = simulated.ends();
    let chambers: Vec<_> =
        ends.iter().map(|step| simulated.chambers(step)["middle"].clone()).collect();
    for (chamber, change) in chambers.iter().zip([2e-7, 4e-7, 4e-7, 0.0]) {
        let gap = (chamber.volume - chamber.volume_rest - change) / chamber.volume;
        assert!(gap.abs() < 1e-10, "{gap:e}");
    }
    assert!(chambers[0].pressure > 1e3 && chambers[1].pressure > 1.2 * chambers[0].pressure);
    assert!((chambers[2].pressure / chambers[1].pressure - 1.0).abs() < 1e-8);
    assert!(chambers[3].pressure.abs() < 1e-6 * chambers[1].pressure, "{}", chambers[3].pressure);
}

/// Air let in over time: at every moment the amount of gas of that moment.
#[test]
fn a_fill_follows_its_schedule() {
    let loads = "[time]\nmethod = \"quasistatic\"\nat = [0.25, 1.0, 1.5]\n\
                 [[chamber]]\non = \"middle\"\nfill = \"60e3*t*(2 - t)\"\nambient = 101.3e3\nexponent = 1.4\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    for step in simulated.ends() {
        let chamber = simulated.chambers(&step)["middle"].clone();
        let fill = 60e3 * step.time * (2.0 - step.time);
        let by_law = (fill + 101.3e3) * (chamber.volume_rest / chamber.volume).powf(1.4) - 101.3e3;
        assert!((chamber.pressure / by_law - 1.0).abs() < 1e-10 && by_law > 5e3, "{by_law}");
    }
}

/// What left the syringe is in the chamber or in the tubing, and stiff tubing prescribes the volume.
#[test]
fn an_injected_volume_is_shared_with_the_tubing() {
    let injected = 4e-7;
    let with = |compliance: f64| {
        let chamber = format!(
            "[[chamber]]\non = \"middle\"\ninjected = {injected:e}\ncompliance = {compliance:e}\n"
        );
        let simulated = simulate(&format!("{HELD}{chamber}"));
        simulated.last_chambers()["middle"].clone()
    };
    for compliance in [1e-11, 1e-14] {
        let chamber = with(compliance);
        let (inside, in_tubing) =
            (chamber.volume - chamber.volume_rest, compliance * chamber.pressure);
        assert!(((inside + in_tubing) / injected - 1.0).abs() < 1e-9, "{inside:e} {in_tubing:e}");
        assert!(chamber.pressure > 1e3, "{}", chamber.pressure);
    }
    let prescribed =
        simulate(&format!("{HELD}[[chamber]]\non = \"middle\"\nvolume_change = {injected:e}\n"));
    let prescribed = prescribed.last_chambers()["middle"].pressure;
    // what is left is what 1e-16 m³/Pa take up
    let stiff = with(1e-16).pressure;
    assert!((stiff / prescribed - 1.0).abs() < 1e-4, "{stiff} {prescribed}");
}
