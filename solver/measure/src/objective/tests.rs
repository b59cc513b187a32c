use super::*;
use crate::quantity::Kind;

/// Own keys of a kind with all that it needs.
fn sound(kind: &str) -> String {
    let kind = kinds::find(List::Objective, kind).unwrap();
    format!("kind = '{}'\n{}", kind.key, kind.example)
}

fn all() -> impl Iterator<Item = (String, &'static Kind)> {
    kinds::of(List::Objective).map(|kind| (sound(kind.key), kind))
}

fn read(text: &str, weight: &str) -> anyhow::Result<ObjectiveConfig> {
    let config: ObjectiveConfig =
        toml::from_str(&format!("name = 'n'\nweight = {weight}\n{text}"))?;
    config.check().map(|()| config)
}

#[test]
fn every_kind_is_read_and_has_its_row() {
    for (text, kind) in all() {
        let config = read(&text, "2").unwrap();
        assert_eq!(
            (config.kind().key, config.name(), config.weight()),
            (kind.key, "n", Weight::Factor(2.0))
        );
        let written = toml::Table::try_from(&config).unwrap();
        assert_eq!(written["kind"].as_str(), Some(kind.key));
        // what may be written is what is listed
        let mut keys: Vec<&str> = kind.keys().iter().map(|key| key.name).collect();
        keys.extend(["kind", "name", "weight", "share", "over"]);
        let unknown = written.keys().find(|key| !keys.contains(&key.as_str()));
        assert_eq!(unknown, None, "{}", kind.key);
        let error = read(&format!("{text}\nodd = 1"), "1").unwrap_err().to_string();
        let all = keys.iter().filter(|key| **key != "kind");
        all.for_each(|key| assert!(error.contains(&format!("`{key}`")), "{key}: {error}"));
    }
    let over = |over: &str| read(&(sound("smoothness") + over), "1").unwrap().over().clone();
    assert_eq!(over("\nover = 'simpson'"), TimeIntegral::Simpson);
    assert_eq!(over("\nover = { steps = [53, 54] }"), TimeIntegral::Steps(vec![53, 54]));
    assert_eq!(over(""), TimeIntegral::Final);
}

#[test]
fn only_what_can_be_maximised_may_weigh_less_than_nothing() {
    let open = "kind = 'volume'\non = 'a'".to_owned();
    for text in all().map(|(text, _)| text).chain([open.clone()]) {
        let may = text.contains("contact") || text == open;
        assert_eq!(read(&text, "-1").is_ok(), may, "{text}");
        assert!(read(&text, "nan").unwrap_err().to_string().contains("NaN"));
    }
}

#[test]
fn a_share_stands_in_place_of_a_weight() {
    let read = |text: &str| {
        let config: ObjectiveConfig =
            toml::from_str(&format!("name = 'n'\n{text}\n{}", sound("contact-proxy")))?;
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
        let text = format!("name = 'n'\n{weight}\n{}", sound("contact-proxy"));
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
    for (kind, from, to, words) in [
        ("target", "distance = 'signed'", "spacing = 0", "spacing = 0 m: must be positive"),
        ("position", "'zx'", "'zz'", "some of x, y, z"),
        ("position", "'zx'", "''", "some of x, y, z"),
        ("contact-force", "direction = [0, 0, 1]", "", "needs direction"),
        ("contact-force", "[0, 0, 1]", "[0, 0, 0]", "not zero"),
        ("contact-force", "'along'", "'squared'", "for form = \"along\" only"),
        ("contact-proxy", "['left', 'right']", "'left'", "two tags or more"),
        ("contact-proxy", "1.3", "inf", "activation = inf m"),
        ("wall-thickness", "against = ['right']", "", "one side of a wall"),
        ("wall-thickness", "minimum = 0.5", "", "needs a minimum"),
        ("wall-thickness", "minimum = 0.5", "minimum = -1.0", "minimum = -1 m"),
        ("wall-thickness", "minimum = 0.5", "minimum = 0.5\ndensity = 'quadratic'", "has none"),
        ("volume", "0.3", "0", "volume = 0 m³"),
        ("stress", "4", "1.5", "at least 2"),
        ("strain-limit", "1.05", "0.9", "above 1"),
        ("strain-limit", "0.95", "1.5", "at least 0 and below 1"),
        ("probe", "0.5", "0", "scale = 0: must be positive"),
        ("probe", "0.1*t", "0.1*x", "must depend on t alone"),
    ] {
        let text = sound(kind).replace(from, to);
        assert_ne!(text, sound(kind));
        let error = read(&text, "1").unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}
