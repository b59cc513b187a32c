//! Laws by their names there and here.

use anyhow::Result;
use toml::Table;

use super::document::Key;

/// Density where a material gives none, as PolyFEM assumes it [kg/m³].
const DENSITY: f64 = 1.0;

/// A law with its parameters here.
type Translated = (&'static str, Vec<(&'static str, f64)>);

/// The material of the bodies with a volume id.
///
/// A plane NeoHookean body has λ = Eν/(1 − ν²) there. Its slab gets the E and ν
/// that give the same λ and μ in space, with which its energy is the same:
/// tr FᵀF − 3 of a plane strain is tr FᵀF − 2 in the plane.
pub fn material(materials: &Key, id: i64, planar: bool) -> Result<Table> {
    for key in materials.items() {
        if key.optional("id", Key::ids)?.is_some_and(|ids| !ids.contains(&id)) {
            continue;
        }
        let (kind, parameters) = law(&key, planar)?;
        let density = key.optional("rho", Key::positive)?.unwrap_or(DENSITY);
        let numbers = parameters.into_iter().chain([("density", density)]);
        let numbers = numbers.map(|(name, value)| (name.to_owned(), value.into()));
        return Ok(numbers.chain([("kind".to_owned(), kind.into())]).collect());
    }
    Err(materials.wrong(&format!(
        "no material has the id {id}, the volume_selection of a body: expected one, or one \
         without id for all"
    )))
}

fn law(key: &Key, planar: bool) -> Result<Translated> {
    let name = key.need("type", "the name of the law")?;
    let rivlin = |kind| -> Result<Translated> {
        let parameter = |own| Ok((own, key.need(own, "a parameter of its law [Pa]")?.number()?));
        let parameters = ["c1", "c2", "c3", "d1"].map(parameter).into_iter();
        Ok((kind, parameters.collect::<Result<_>>()?))
    };
    match name.text()? {
        // in the plane it is another law, in which c₂ has no part
        "MooneyRivlin3ParamSymbolic" if planar => Err(name.wrong(
            "in the plane this law is not that of a slab in plane strain; expected NeoHookean or \
             MooneyRivlin3Param",
        )),
        "MooneyRivlin3ParamSymbolic" => rivlin("mooney-rivlin"),
        "MooneyRivlin3Param" => rivlin("mooney-rivlin-quadratic"),
        "NeoHookean" => lame("neo-hookean", key, planar),
        "SaintVenant" => lame("saint-venant-kirchhoff", key, planar),
        "LinearElasticity" => lame("linear-elastic", key, planar),
        _ => Err(name.wrong(&format!(
            "unknown law {}; known are MooneyRivlin3ParamSymbolic, MooneyRivlin3Param, NeoHookean, \
             SaintVenant and LinearElasticity",
            name.value
        ))),
    }
}

/// Laws that are linear in λ and μ, given by E and ν, or by λ and μ.
fn lame(kind: &'static str, key: &Key, planar: bool) -> Result<Translated> {
    let [lambda, mu] = match (key.get("lambda"), key.get("mu")) {
        (Some(lambda), Some(mu)) => [lambda.number()?, mu.number()?],
        _ => {
            let e = key.need("E", "Young's modulus [Pa]")?.positive()?;
            let nu = key.need("nu", "Poisson's ratio")?.number()?;
            if !planar {
                return Ok((kind, vec![("young", e), ("poisson", nu)]));
            }
            [e * nu / (1.0 - nu * nu), e / (2.0 * (1.0 + nu))]
        }
    };
    let nu = lambda / (2.0 * (lambda + mu));
    Ok((kind, vec![("young", 2.0 * mu * (1.0 + nu)), ("poisson", nu)]))
}
