//! Chambers with a prescribed volume against the pressures that lead there.

use tests::motion::{HELD, Motion, bar, difference};

/// The bar under loads, at its end.
fn simulate(loads: &str) -> Motion {
    let mut motion = bar(&format!("{HELD}{loads}"));
    motion.ends();
    motion
}

/// Pressures of the three chambers [Pa], one of them a vacuum.
const PRESSURES: [(&str, f64); 3] = [("left", 30e3), ("middle", -10e3), ("right", 55e3)];

#[test]
fn the_volume_of_a_pressure_needs_that_pressure() {
    let pressures: String = PRESSURES
        .iter()
        .map(|(on, p)| format!("[[chamber]]\non = \"{on}\"\npressure = {p}\n"))
        .collect();
    let isobaric = simulate(&pressures);
    let chambers = isobaric.chambers();
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
    let held = simulate(&volumes);
    let found = held.chambers();
    eprintln!(
        "three chambers by volume: {} Newton iterations, by pressure {}",
        held.stepper.progress.newton_iterations, isobaric.stepper.progress.newton_iterations
    );
    for (on, pressure) in PRESSURES {
        let chamber = &found[on];
        let (gap, error) =
            (chamber.volume / chambers[on].volume - 1.0, chamber.pressure / pressure - 1.0);
        eprintln!("  {on}: V off by {gap:.1e}, P {:.6} Pa, off by {error:.1e}", chamber.pressure);
        assert!(gap.abs() < 1e-10 && error.abs() < 1e-8);
    }
    let gap = difference(held.u(), isobaric.u());
    assert!(gap < 1e-8, "{gap:e}");
}

/// One chamber of each kind; each agrees with its own law.
#[test]
fn volume_gas_and_pressure_work_together() {
    let loads = "[[chamber]]\non = \"left\"\nvolume_factor = 1.2\n\
                 [[chamber]]\non = \"middle\"\nfill = 0\nambient = 101.3e3\nexponent = 1.4\n\
                 [[chamber]]\non = \"right\"\npressure = 40e3\n";
    let simulated = simulate(loads);
    let chambers = simulated.chambers();
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
    let isobaric = simulate(&same);
    assert!(difference(simulated.u(), isobaric.u()) < 1e-8);
}

/// What left the syringe is in the chamber or in the tubing, and stiff tubing prescribes the volume.
#[test]
fn an_injected_volume_is_shared_with_the_tubing() {
    let injected = 4e-7;
    let with = |compliance: f64| {
        let chamber = format!(
            "[[chamber]]\non = \"middle\"\ninjected = {injected:e}\ncompliance = {compliance:e}\n"
        );
        let simulated = simulate(&chamber);
        simulated.chambers()["middle"].clone()
    };
    for compliance in [1e-11, 1e-14] {
        let chamber = with(compliance);
        let (inside, in_tubing) =
            (chamber.volume - chamber.volume_rest, compliance * chamber.pressure);
        assert!(((inside + in_tubing) / injected - 1.0).abs() < 1e-9, "{inside:e} {in_tubing:e}");
        assert!(chamber.pressure > 1e3, "{}", chamber.pressure);
    }
    let prescribed =
        simulate(&format!("[[chamber]]\non = \"middle\"\nvolume_change = {injected:e}\n"));
    let prescribed = prescribed.chambers()["middle"].pressure;
    // what is left is what 1e-16 m³/Pa take up
    let stiff = with(1e-16).pressure;
    assert!((stiff / prescribed - 1.0).abs() < 1e-4, "{stiff} {prescribed}");
}
