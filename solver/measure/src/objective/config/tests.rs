use super::*;

/// A term of each kind with all that it needs.
const SOUND: [&str; 13] = [
    "kind = 'target'\non = 'a'\ntarget = 'a.stl'\ndistance = 'signed'",
    "kind = 'displacement'\non = ['a', 'b']\ndisplacement = [0.03, '0.1*t', 0]\nover = 'simpson'",
    "kind = 'position'\non = 'a'\nposition = [0, 0, 1]\ncomponents = 'zx'\nmeasure = 'deformed'",
    "kind = 'contact-force'\non = 'a'\nform = 'along'\ndirection = [0, 0, 1]",
    "kind = 'contact-proxy'\non = ['a', 'b']\nactivation = 1e-3\nover = { steps = [53, 54] }",
    "kind = 'wall-thickness'\non = 'a'\nagainst = ['b']\nminimum = 1e-3\nactivation = 1e-3",
    "kind = 'smoothness'\non = 'a'\nform = 'plain'",
    "kind = 'clearance'\nactivation = 1e-4",
    "kind = 'volume'\non = 'a'\nvolume = 1e-6",
    "kind = 'stress'\npower = 8",
    "kind = 'strain-limit'\nlargest = 3",
    "kind = 'probe'\nprobe = 'tip'\ntarget = '2*t'\nscale = 0.5",
    "kind = 'draft'\non = 'a'\npull = [0, 0, 1]\ndraft = 0.03",
];

fn read(text: &str, weight: &str) -> anyhow::Result<ObjectiveConfig> {
    let config: ObjectiveConfig =
        toml::from_str(&format!("name = 'n'\nweight = {weight}\n{text}"))?;
    config.check().map(|()| config)
}

#[test]
fn every_kind_is_read_and_has_its_row() {
    assert_eq!(SOUND.len(), KINDS.len());
    for (text, kind) in SOUND.iter().zip(KINDS) {
        let config = read(text, "2").unwrap();
        assert_eq!(
            (config.kind().key, config.name(), config.weight()),
            (kind.key, "n", Weight::Factor(2.0))
        );
        let written = toml::Table::try_from(&config).unwrap();
        assert_eq!(written["kind"].as_str(), Some(kind.key));
        // what may be written is what is listed
        let mut keys: Vec<&str> = kind.keys.iter().map(|k| k.0).collect();
        keys.extend(["kind", "name", "weight", "share", "over"]);
        let unknown = written.keys().find(|key| !keys.contains(&key.as_str()));
        assert_eq!(unknown, None, "{}", kind.key);
        let error = read(&format!("{text}\nodd = 1"), "1").unwrap_err().to_string();
        let all = keys.iter().filter(|key| **key != "kind");
        all.for_each(|key| assert!(error.contains(&format!("`{key}`")), "{key}: {error}"));
    }
    assert_eq!(*read(SOUND[1], "1").unwrap().over(), TimeIntegral::Simpson);
    assert_eq!(*read(SOUND[4], "1").unwrap().over(), TimeIntegral::Steps(vec![53, 54]));
    assert_eq!(*read(SOUND[0], "1").unwrap().over(), TimeIntegral::Final);
}

#[test]
fn only_what_can_be_maximised_may_weigh_less_than_nothing() {
    let open = "kind = 'volume'\non = 'a'";
    for text in SOUND.iter().chain([&open]) {
        let may = text.contains("contact") || *text == open;
        assert_eq!(read(text, "-1").is_ok(), may, "{text}");
        assert!(read(text, "nan").unwrap_err().to_string().contains("NaN"));
    }
}

#[test]
fn a_share_stands_in_place_of_a_weight() {
    let read = |text: &str| {
        let config: ObjectiveConfig = toml::from_str(&format!("name = 'n'\n{text}\n{}", SOUND[4]))?;
        config.check().map(|()| config)
    };
    assert_eq!(read("share = -0.3").unwrap().weight(), Weight::Share(-0.3));
    let written = toml::to_string(&read("share = 0.5").unwrap()).unwrap();
    assert!(written.contains("share = 0.5") && !written.contains("weight"), "{written}");
    for (text, words) in [
        ("share = 0", "must be a part of the objective, up to 1"),
        ("share = 1.5", "share = 1.5"),
        ("share = nan", "finite"),
        ("weight = 1\nshare = 0.5", "one of weight"),
        ("", "one of weight"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}

#[test]
fn shares_leave_what_weights_need() {
    let one = |weight: &str| {
        let text = format!("name = 'n'\n{weight}\n{}", SOUND[4]);
        toml::from_str::<ObjectiveConfig>(&text).unwrap()
    };
    let check = |weights: &[&str]| {
        check_shares(&weights.iter().map(|weight| one(weight)).collect::<Vec<_>>())
    };
    assert!(check(&["weight = 1", "weight = 2"]).is_ok());
    assert!(check(&["weight = 1", "share = -0.9"]).is_ok());
    assert!(check(&["share = 0.6", "share = -0.4", "weight = 0"]).is_ok());
    assert!(check(&["weight = 1", "share = 0.6", "share = 0.4"]).is_err());
    let error = check(&["share = 0.6", "share = 0.3"]).unwrap_err().to_string();
    assert!(error.contains("come to 0.900"), "{error}");
}

#[test]
fn what_makes_no_sense_is_refused_with_what_is_needed() {
    for (row, from, to, words) in [
        (0, "distance = 'signed'", "spacing = 0", "spacing = 0 m must be positive"),
        (2, "'zx'", "'zz'", "some of x, y, z"),
        (2, "'zx'", "''", "some of x, y, z"),
        (3, "direction = [0, 0, 1]", "", "needs direction"),
        (3, "[0, 0, 1]", "[0, 0, 0]", "not zero"),
        (3, "'along'", "'squared'", "for form = \"along\" only"),
        (4, "['a', 'b']", "'a'", "two tags or more"),
        (4, "1e-3", "inf", "activation = inf m"),
        (5, "against = ['b']", "", "one side of a wall"),
        (5, "minimum = 1e-3", "", "needs a minimum"),
        (5, "minimum = 1e-3", "minimum = -1.0", "minimum = -1 m"),
        (5, "minimum = 1e-3", "minimum = 1e-3\ndensity = 'quadratic'", "has none"),
        (8, "1e-6", "0", "volume = 0 m³"),
        (8, "1e-6", "0", "volume = 0 m³"),
        (9, "8", "1.5", "2 or more"),
        (10, "3", "0.9", "above 1"),
        (10, "3", "3\nsmallest = 1.5", "from 0 to 1"),
        (11, "0.5", "0", "scale = 0: must be positive"),
        (11, "2*t", "2*x", "must depend on t alone"),
    ] {
        let text = SOUND[row].replace(from, to);
        assert_ne!(text, SOUND[row]);
        let error = read(&text, "1").unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}
