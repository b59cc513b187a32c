use super::*;

/// Values of the ideal gas law from the design document, ambient 101.3 kPa.
#[test]
fn compressed_air_has_the_pressures_of_the_gas_law() {
    let pressure = |exponent: f64, ratio: f64| {
        IdealGas { fill: 0.0.into(), ambient: 101.3e3, exponent }
            .at(ratio * 2e-5, 2e-5, 1.0, Multiplier::default())
            .pressure
    };
    for (exponent, ratio, expected) in
        [(1.0, 0.9, 11255.556), (1.4, 0.9, 16100.496), (1.0, 0.8, 25325.0), (1.4, 0.8, 37146.973)]
    {
        assert!((pressure(exponent, ratio) - expected).abs() < 1e-3, "{exponent} {ratio}");
    }
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
    ];
    let multiplier = Multiplier { pressure: 2e4, penalty: 3e4 };
    for law in laws {
        let (v, rest) = (1.3, 0.9);
        let at = |v: f64, rest: f64| law.at(v, rest, 0.7, multiplier);
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
    assert!(ideal(1.4).at(-1e-3, 0.9, 0.7, multiplier).value.is_infinite());
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

/// A law gives back what its row built it from.
#[test]
fn every_row_builds_a_law_with_its_keys() {
    for row in GAS_LAWS {
        let (selecting, others): (Vec<&Key>, _) = row.keys.iter().partition(|key| key.selects);
        let numbers: Vec<f64> = (0..others.len()).map(|i| 1.5 + i as f64).collect();
        for key in selecting {
            let law = (row.build)(key.name, 7.5.into(), &numbers);
            assert_eq!((law.key(), law.numbers()), (key.name, numbers.clone()), "{}", row.name);
            assert_eq!(*law.schedule(), Schedule::from(7.5));
        }
    }
}
