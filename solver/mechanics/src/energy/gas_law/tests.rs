use super::*;

/// Values of the ideal gas law from the design document, ambient 101.3 kPa.
#[test]
fn compressed_air_has_the_pressures_of_the_gas_law() {
    let pressure = |exponent: f64, ratio: f64| {
        IdealGas { fill: 0.0.into(), ambient: 101.3e3, exponent }
            .at(ratio * 2e-5, 2e-5, &Moment { time: 1.0, ..Moment::default() })
            .pressure
    };
    for (exponent, ratio, expected) in
        [(1.0, 0.9, 11255.556), (1.4, 0.9, 16100.496), (1.0, 0.8, 25325.0), (1.4, 0.8, 37146.973)]
    {
        assert!((pressure(exponent, ratio) - expected).abs() < 1e-3, "{exponent} {ratio}");
    }
}

fn supplied(checked: bool, supply: f64) -> Box<dyn GasLaw> {
    let (resistance, leak, ambient) = (1e4, 3e-5, 101.3e3);
    Box::new(SuppliedGas { supply: supply.into(), checked, resistance, leak, ambient })
}

#[test]
fn derivatives_of_the_potential_are_those_of_its_value() {
    let ideal = |exponent| -> Box<dyn GasLaw> {
        Box::new(IdealGas { fill: 3e4.into(), ambient: 101.3e3, exponent })
    };
    let laws = [
        ideal(1.0),
        ideal(1.4),
        Box::new(PrescribedVolume::Change(0.3.into())),
        Box::new(PrescribedVolume::Factor(1.4.into())),
        Box::new(InjectedLiquid { injected: 0.6.into(), compliance: 2e-4 }),
        supplied(false, 2e4),
        supplied(true, 9e4),
        // its valve is shut
        supplied(true, 2e3),
    ];
    let multiplier = Multiplier { pressure: 2e4, penalty: 3e4 };
    let moment = Moment { time: 0.7, multiplier, past: Some(Past { h: 0.1, amount: 4e4 }) };
    for law in laws {
        let (v, rest) = (1.3, 0.9);
        let at = |v: f64, rest: f64| law.at(v, rest, &moment);
        let here = at(v, rest);
        let h = 1e-5;
        let slope = |f: &dyn Fn(f64) -> f64| (f(h) - f(-h)) / (2.0 * h);
        let by_v = slope(&|e| at(v + e, rest).value);
        let twice = slope(&|e| -at(v + e, rest).pressure);
        let by_rest = slope(&|e| at(v, rest + e).pressure);
        assert!((by_v + here.pressure).abs() < 1e-5 * here.pressure.abs(), "{law:?}");
        assert!((twice - here.stiffness).abs() < 1e-8 * here.stiffness, "{law:?}");
        assert!((by_rest / here.pressure_by_rest - 1.0).abs() < 1e-8, "{law:?}");
    }
    assert!(ideal(1.4).at(-1e-3, 0.9, &moment).value.is_infinite());
}

/// In a rigid chamber P_∞ − P falls by the formula of implicit Euler, with P_∞ = P_s/(1 + L R) and the time
/// V/(p_a (1/R + L)).
#[test]
fn a_rigid_chamber_fills_exponentially() {
    let (law, v, h) = (supplied(false, 2e4), 0.9, 0.02);
    let (settled, rate) = (2e4 / 1.3, h * 101.3e3 * 1.3e-4 / v);
    let mut amount = 0.0;
    for n in 1..=20 {
        let moment = Moment { time: 1.0, past: Some(Past { h, amount }), ..Moment::default() };
        let pressure = law.at(v, v, &moment).pressure;
        let expected = settled * (1.0 - f64::powi(1.0 + rate, -n));
        assert!((pressure / expected - 1.0).abs() < 1e-9, "{n}: {pressure} {expected}");
        amount = pressure * v;
    }
}

/// Beside the pressure of its supply, a check valve is open on one side and shut on the other, without a jump.
#[test]
fn a_check_valve_shuts_without_a_jump() {
    let law = supplied(true, 2e4);
    let moment =
        Moment { time: 1.0, past: Some(Past { h: 0.02, amount: 1e4 }), ..Moment::default() };
    let at = |v: f64| law.at(v, 0.9, &moment);
    let (mut low, mut high) = (0.5, 1.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at(middle).pressure > 2e4 { low = middle } else { high = middle }
    }
    let [shut, open] = [at(low - 1e-9), at(high + 1e-9)];
    assert!((shut.pressure - open.pressure).abs() < 1.0, "{shut:?} {open:?}");
    assert!((shut.value - open.value).abs() < 1e-3, "{shut:?} {open:?}");
    let by = |v: f64| law.pressure_by_parameter(v, 0.9, &moment).expect("not prescribed");
    assert!(by(low - 1e-9) == 0.0 && by(high + 1e-9) > 0.0);
    assert!(shut.stiffness > 1.01 * open.stiffness, "{shut:?} {open:?}");
}

#[test]
fn prescribed_volumes_begin_at_the_rest_volume() {
    for prescribed in [PrescribedVolume::Change(0.8.into()), PrescribedVolume::Factor(1.4.into())] {
        let wanted = [0.0, 0.5, 1.0, 2.0].map(|time| prescribed.at_load(2.0, time).volume);
        for (found, expected) in wanted.into_iter().zip([2.0, 2.4, 2.8, 2.8]) {
            assert!((found - expected).abs() < 1e-15, "{prescribed:?}: {wanted:?}");
        }
    }
}

/// A law has under the names of its keys what its row built it from.
#[test]
fn every_row_builds_a_law_with_its_keys() {
    for row in GAS_LAWS {
        let (selecting, others): (Vec<&Key>, _) = row.keys.iter().partition(|key| key.selects);
        let numbers: Vec<f64> = (0..others.len()).map(|i| 1.5 + i as f64).collect();
        for key in selecting {
            let law = (row.build)(key.name, 7.5.into(), &numbers);
            assert_eq!(*law.schedule(), Schedule::from(7.5));
            for (key, number) in others.iter().zip(&numbers) {
                let found = format!("{law:?}");
                assert!(found.contains(&format!("{}: {number}", key.name)), "{found}");
            }
        }
    }
}
