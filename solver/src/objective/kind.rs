//! What a design problem may ask for.

/// A row of the table of objectives.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// `kind` in an `[[objective]]`.
    pub key: &'static str,
    /// What it is.
    pub formula: &'static str,
    /// SI unit of its value; a weight has the inverse.
    pub unit: &'static str,
    /// Keys besides kind, name, weight and over, with what they mean.
    pub keys: &'static [(&'static str, &'static str)],
    /// Whether its weight may be negative, so that it is maximised.
    pub may_be_maximised: bool,
}

/// Keys that several kinds have.
const TAGS: (&str, &str) = ("on", "tag, body, or list of them");
const MEASURE: (&str, &str) = ("measure", "\"rest\" (default) or \"deformed\"");
const AXES: (&str, &str) = ("components", "axes that count, such as \"xz\" (\"xyz\")");
const BODY: (&str, &str) = ("on", "body; all if not given");

/// All kinds, in the order in which they are listed.
pub const KINDS: &[Kind] = &[
    Kind {
        key: "target",
        formula: "∫ d̃²(x) dA, d̃ the distance of deformed points to a surface",
        unit: "m⁴",
        keys: &[
            TAGS,
            ("target", "surface file in metres"),
            (
                "distance",
                "\"squared\" (default), \"unsigned\" (published), \"signed\" (closed target)",
            ),
            ("spacing", "of the distance's lattice [m] (1e-3)"),
            MEASURE,
        ],
        may_be_maximised: false,
    },
    Kind {
        key: "displacement",
        formula: "∫ Σ (u_i − w_i)² dA",
        unit: "m⁴",
        keys: &[TAGS, ("displacement", "w, numbers, expressions or tables [m]"), AXES, MEASURE],
        may_be_maximised: false,
    },
    Kind {
        key: "position",
        formula: "∫ Σ (x_i − w_i)² dA, x = X + u",
        unit: "m⁴",
        keys: &[TAGS, ("position", "w, numbers, expressions or tables [m]"), AXES, MEASURE],
        may_be_maximised: false,
    },
    Kind {
        key: "contact-force",
        formula: "of the force F of contact and friction on nodes: d·F, |F|², or Σ |f_n|²",
        unit: "N or N²",
        keys: &[
            TAGS,
            ("form", "\"along\", \"squared\" (default) or \"sum-of-squares\""),
            ("direction", "d, for \"along\""),
        ],
        may_be_maximised: true,
    },
    Kind {
        key: "contact-proxy",
        formula: "Σ |f_n|² of the forces of a wide barrier between parts of the surface",
        unit: "m⁴",
        keys: &[
            ("on", "two or more tags that are apart"),
            ("density", "\"log\" (default) or \"quadratic\""),
            ("activation", "distance from which on they feel each other [m]"),
        ],
        may_be_maximised: true,
    },
    Kind {
        key: "wall-thickness",
        formula: "barrier on walls thinner than minimum + activation",
        unit: "m⁴",
        keys: &[
            TAGS,
            ("against", "tags of the other side; without them, each two of on"),
            ("density", "\"log\" (default), infinite at minimum, or \"quadratic\", without it"),
            ("minimum", "thinnest wall [m]"),
            ("activation", "[m]"),
            MEASURE,
        ],
        may_be_maximised: false,
    },
    Kind {
        key: "smoothness",
        formula: "Σ_v |Σ_w (X_v − X_w)|² / (Σ_w |X_v − X_w|)², plain: over the number of w",
        unit: "1 or m²",
        keys: &[TAGS, ("form", "\"scale-invariant\" (default) or \"plain\"")],
        may_be_maximised: false,
    },
    Kind {
        key: "clearance",
        formula: "log barrier between parts of the rest surface that are not neighbours",
        unit: "m⁴",
        keys: &[("activation", "[m]")],
        may_be_maximised: false,
    },
    Kind {
        key: "volume",
        formula: "V, or (V − V*)²",
        unit: "m³ or m⁶",
        keys: &[
            ("on", "a tag: the chamber behind it; a body; all bodies if not given"),
            ("volume", "V* [m³]"),
            MEASURE,
        ],
        may_be_maximised: true,
    },
    Kind {
        key: "stress",
        formula: "∫ |P|^q dX, P the force per rest area",
        unit: "Pa^q m³",
        keys: &[BODY, ("power", "q ≥ 2 (2)")],
        may_be_maximised: false,
    },
    Kind {
        key: "strain-limit",
        formula: "∫ Σ (λ_i − largest)₊² + (smallest − λ_i)₊² dX of the principal stretches",
        unit: "m³",
        keys: &[BODY, ("largest", "[1]"), ("smallest", "[1] (0)")],
        may_be_maximised: false,
    },
];
