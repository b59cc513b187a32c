//! Chambers with a prescribed volume against the pressures that lead there.

use tests::bar::{HELD, difference, simulate};

/// Pressures of the three chambers [Pa], one of them a vacuum.
const PRESSURES: [(&str, f64); 3] = [("left", 30e3), ("middle", -10e3), ("right", 55e3)];

#[test]
fn the_volume_of_a_pressure_needs_that_pressure() {
    let pressures: String = PRESSURES
        .iter()
        .map(|(on, p)| format!("[[pressure]]\non = \"{on}\"\npressure = {p}\n"))
        .collect();
    let isobaric = simulate(&format!("{HELD}{pressures}"));
    let walls = isobaric.last_walls();
    // by change, and by factor
    let volumes = PRESSURES.iter().enumerate().map(|(i, (on, _))| {
        let wall = &walls[*on];
        let value = match i % 2 {
            0 => format!("change = {:e}", wall.volume - wall.volume_rest),
            _ => format!("factor = {:e}", wall.volume / wall.volume_rest),
        };
        format!("[[volume]]\non = \"{on}\"\n{value}\n")
    });
    let volumes: String = volumes.collect();
    let held = simulate(&format!("{HELD}{volumes}"));
    let found = held.last_walls();
    eprintln!(
        "three chambers by volume: {} Newton iterations, by pressure {}",
        held.solution.newton_iterations, isobaric.solution.newton_iterations
    );
    for (on, pressure) in PRESSURES {
        let wall = &found[on];
        let (gap, error) = (wall.volume / walls[on].volume - 1.0, wall.pressure / pressure - 1.0);
        eprintln!("  {on}: V off by {gap:.1e}, P {:.6} Pa, off by {error:.1e}", wall.pressure);
        assert!(gap.abs() < 1e-10 && error.abs() < 1e-8);
    }
    let gap = difference(&held.solution.u, &isobaric.solution.u);
    assert!(gap < 1e-8, "{gap:e}");
}

/// One chamber of each kind; each agrees with its own law.
#[test]
fn volume_gas_and_pressure_work_together() {
    let loads = "[[volume]]\non = \"left\"\nfactor = 1.2\n\
                 [[gas]]\non = \"middle\"\nfill = 0\nambient = 101.3e3\nexponent = 1.4\n\
                 [[pressure]]\non = \"right\"\npressure = 40e3\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    let walls = simulated.last_walls();
    let [left, middle, right] = ["left", "middle", "right"].map(|on| &walls[on]);
    assert!((left.volume / left.volume_rest / 1.2 - 1.0).abs() < 1e-10);
    assert!(left.pressure > 1e3, "{}", left.pressure);
    let by_law = 101.3e3 * ((middle.volume_rest / middle.volume).powf(1.4) - 1.0);
    assert!((middle.pressure / by_law - 1.0).abs() < 1e-10 && by_law.abs() > 10.0, "{by_law}");
    assert_eq!(right.pressure, 40e3);
    // nothing but the three pressures acts: prescribing them gives the same shape
    let same: String = [("left", left), ("middle", middle), ("right", right)]
        .iter()
        .map(|(on, wall)| format!("[[pressure]]\non = \"{on}\"\npressure = {:e}\n", wall.pressure))
        .collect();
    let isobaric = simulate(&format!("{HELD}{same}"));
    assert!(difference(&simulated.solution.u, &isobaric.solution.u) < 1e-8);
}

/// A pump that fills, holds and empties the chamber.
#[test]
fn a_volume_follows_its_schedule() {
    let loads = "[time]\nmethod = \"quasistatic\"\nend = 2.0\nsteps = 4\n\
                 [[volume]]\non = \"middle\"\n\
                 change = { t = [0, 1, 1.5, 2], value = [0, 4e-7, 4e-7, 0] }\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    let ends = simulated.ends();
    let walls: Vec<_> = ends.iter().map(|step| simulated.walls(step)["middle"].clone()).collect();
    for (wall, change) in walls.iter().zip([2e-7, 4e-7, 4e-7, 0.0]) {
        let gap = (wall.volume - wall.volume_rest - change) / wall.volume;
        assert!(gap.abs() < 1e-10, "{gap:e}");
    }
    assert!(walls[0].pressure > 1e3 && walls[1].pressure > 1.2 * walls[0].pressure);
    assert!((walls[2].pressure / walls[1].pressure - 1.0).abs() < 1e-8);
    assert!(walls[3].pressure.abs() < 1e-6 * walls[1].pressure, "{}", walls[3].pressure);
}

/// Air let in over time: at every moment the amount of gas of that moment.
#[test]
fn a_fill_follows_its_schedule() {
    let loads = "[time]\nmethod = \"quasistatic\"\nat = [0.25, 1.0, 1.5]\n\
                 [[gas]]\non = \"middle\"\nfill = \"60e3*t*(2 - t)\"\nambient = 101.3e3\nexponent = 1.4\n";
    let simulated = simulate(&format!("{HELD}{loads}"));
    for step in simulated.ends() {
        let wall = simulated.walls(&step)["middle"].clone();
        let fill = 60e3 * step.load * (2.0 - step.load);
        let by_law = (fill + 101.3e3) * (wall.volume_rest / wall.volume).powf(1.4) - 101.3e3;
        assert!((wall.pressure / by_law - 1.0).abs() < 1e-10 && by_law > 5e3, "{by_law}");
    }
}
