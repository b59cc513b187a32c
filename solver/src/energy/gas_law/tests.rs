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
        let wanted = [0.0, 0.5, 1.0, 2.0].map(|load| prescribed.at_load(2.0, load).volume);
        for (found, expected) in wanted.into_iter().zip([2.0, 2.4, 2.8, 2.8]) {
            assert!((found - expected).abs() < 1e-15, "{prescribed:?}: {wanted:?}");
        }
    }
}

/// What may be written is what is listed, and is written again as it was read.
#[test]
fn every_law_is_read_by_its_keys() {
    for text in [
        "pressure = 55e3",
        "fill = \"2e4*t\"\nambient = 101.3e3\nexponent = 1.4",
        "volume_change = { t = [0, 1], value = [0, 2e-6] }",
        "volume_factor = 1.5",
    ] {
        let table: toml::Table = toml::from_str(text).expect("TOML");
        let law = read(table.clone()).expect(text);
        let row = GAS_LAWS.iter().find(|row| row.keys.iter().any(|k| k.name == law.key()));
        let row = row.expect("every law has a row");
        let again = read(law.table()).expect("as it was written");
        assert_eq!(again.table(), law.table());
        assert_eq!(again.schedule(), law.schedule());
        let names = law.table();
        assert!(names.keys().all(|name| row.keys.iter().any(|key| key.name == name)), "{names:?}");
        assert!(names.keys().eq(table.keys()), "{names:?}");
    }
}

#[test]
fn exactly_one_key_selects_the_law() {
    let all = "pressure [Pa], fill [Pa], volume_change [m³], volume_factor [1]";
    for (text, words) in [
        ("", &["expected exactly one of", all, "found none"][..]),
        ("ambient = 1e5", &[all, "found none"]),
        ("pressure = 1\nfill = 2", &[all, "found pressure and fill"]),
        ("volume_change = 1\nvolume_factor = 2", &["found volume_change and volume_factor"]),
        (
            "pressure = 1\nexponent = 1.4",
            &["exponent cannot be combined with pressure", "isobaric"],
        ),
        ("fill = 1\nambient = 1e5", &["missing field `exponent`"]),
        ("fill = 1\nambient = 1e5\nexponent = \"a\"", &["exponent", "\"a\""]),
        ("pressure = [1]", &["a number, an expression"]),
        ("pressures = 1", &["unknown field `pressures`", "`pressure`, `fill`"]),
    ] {
        let error = read(toml::from_str(text).expect("TOML")).expect_err(text).to_string();
        assert!(words.iter().all(|w| error.contains(w)), "{text}: {error}");
    }
}
