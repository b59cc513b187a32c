//! What the bodies of a scene are made of: one law for each, or one for each volume of its mesh.

use std::ops::Range;

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::energy::{Elastic, Owner};
use mechanics::forward::Method;
use mechanics::material::{LAWS, Lame, Law, NeoHookean, Specification};
use mesh::{Tags, TetMesh, Volumes};
use program::{KeyPath, misfit, unknown};

use super::MaterialConfig;

/// The law of a body or of one of its volumes.
#[derive(Clone)]
pub struct SceneLaw {
    /// What reports and messages call it: as the body or its volume; `body.volume` where there are several bodies.
    pub name: String,
    /// The name of the body.
    pub body: String,
    /// The body, by its place among all.
    pub part: usize,
    /// Whether all of that is rigid.
    pub is_rigid: bool,
    /// The volume; none where the body has one law.
    pub volume: Option<String>,
    /// The settings, of this law alone.
    pub config: MaterialConfig,
    /// Law and parameters.
    pub material: Specification,
}

impl SceneLaw {
    /// The tetrahedra that have this law, on a body with the volumes of the scene.
    pub fn elements(&self, body: &Body) -> Range<usize> {
        match &self.volume {
            None => body.parts[self.part].tets.clone(),
            Some(volume) => body.volume(self.part, volume),
        }
    }

    /// Whether it is called so, or is of a body that is; each is without a name.
    pub fn is_of(&self, on: Option<&str>) -> bool {
        on.is_none_or(|on| self.name == on || self.body == on)
    }

    /// Its shear modulus at rest [Pa].
    pub fn shear_modulus(&self) -> f64 {
        self.material.moduli().shear
    }

    /// Whether its numbers may be so.
    pub fn check(&self) -> Result<()> {
        let Specification { law, values, density, .. } = &self.material;
        law.check(values)?;
        if let Some(density) = density {
            let sound = *density > 0.0 && density.is_finite();
            ensure!(sound, "a density must be positive, not {density}");
        }
        Ok(())
    }

    /// The density [kg/m³].
    pub fn density(&self, method: Method) -> Result<f64> {
        self.material.density.with_context(|| {
            format!(
                "{} \"{}\": inertia and gravity need the density of its material; add density \
                 = ... [kg/m³] to its table, about 1000 to 1100 for silicone{}",
                if self.volume.is_some() { "volume" } else { "body" },
                self.name,
                if method.has_inertia() {
                    ", or neglect inertia by method = \"quasistatic\" in [time]"
                } else {
                    ""
                }
            )
        })
    }

    /// Who owns its numbers as the one at this place among all, and how many it has.
    pub(crate) fn numbers(&self, place: usize) -> (Owner, usize) {
        (Elastic::owner(place), self.material.build().parameter_count())
    }

    /// Its elastic energy on some elements. A rigid body has no strain to speak of: a law of this `rigid` shear modulus, no
    /// stiffer than those around it, does as well.
    pub(crate) fn elastic(
        &self,
        elements: Range<usize>,
        mean: bool,
        rigid: f64,
    ) -> Result<Elastic> {
        if self.is_rigid {
            return Ok(Elastic::part(Box::new(NeoHookean(Lame::new(3.0 * rigid, 0.4))), elements));
        }
        let elastic = Elastic::part(self.material.build(), elements);
        if !mean {
            return Ok(elastic);
        }
        Ok(elastic.with_mean_dilatation().ok_or_else(|| {
            let has = |law: &&Law| (law.build)(law.sample).split().is_some();
            let known: Vec<_> = LAWS.iter().filter(has).map(|law| law.key).collect();
            KeyPath::table("solver").key("dilatation").told(format!(
                "[solver] dilatation = \"mean\": the law {} of \"{}\" has no term of the change of \
                 volume alone, of which a mean could be taken; expected one of: {}",
                self.material.law.key,
                self.name,
                known.join(", ")
            ))
        })?)
    }
}

/// Largest shear modulus of some laws at rest [Pa].
pub fn largest_shear_modulus<'a>(laws: impl IntoIterator<Item = &'a SceneLaw>) -> f64 {
    laws.into_iter().map(SceneLaw::shear_modulus).fold(0.0, f64::max)
}

/// The laws of one body. Tetrahedra of each volume with a law of its own follow each other from now
/// on; names of volumes that share one law are dropped.
pub(crate) fn laws(
    (part, body, is_rigid): (usize, &str, bool),
    config: &MaterialConfig,
    mesh: &mut TetMesh,
    tags: &mut Tags,
) -> Result<Vec<SceneLaw>> {
    let law = |volume: Option<&String>, config: MaterialConfig| -> Result<SceneLaw> {
        let (material, volume) = (config.specification()?, volume.cloned());
        let name = volume.clone().unwrap_or_else(|| body.to_owned());
        Ok(SceneLaw { name, body: body.to_owned(), part, is_rigid, volume, config, material })
    };
    let MaterialConfig::Volumes(materials) = config else {
        tags.volumes = Volumes::default();
        return Ok(vec![law(None, config.clone())?]);
    };
    if tags.volumes.names.is_empty() {
        let names = vec![mesh::io::msh::BODY.to_owned()];
        tags.volumes = Volumes { names, of: vec![0; mesh.tets.len()] };
    }
    let names = &tags.volumes.names;
    for (i, material) in materials.iter().enumerate() {
        let title = KeyPath::list("material").on(&material.on);
        let has = format!("the mesh has: {}", names.join(", "));
        let known = names.iter().map(String::as_str);
        ensure!(
            names.contains(&material.on),
            misfit!(title, ": {}", unknown("unknown volume", &material.on, known, ';', &has))
        );
        ensure!(
            materials[..i].iter().all(|other| other.on != material.on),
            misfit!(title, " is given twice; a volume has one law")
        );
    }
    let mut found = Vec::new();
    for (id, name) in names.iter().enumerate() {
        let Some(material) = materials.iter().find(|material| material.on == *name) else {
            let count = tags.volumes.of.iter().filter(|&&i| i == id).count();
            bail!(
                "the volume \"{name}\" of the mesh, {count} of {} tetrahedra, has no law; add \
                 [[material]] with on = \"{name}\"",
                mesh.tets.len()
            );
        };
        let context = || KeyPath::list("material").on(name);
        let config = material.material().with_context(context)?;
        found.push(law(Some(name), config).with_context(context)?);
    }
    sort_by_volume(mesh, &mut tags.volumes);
    Ok(found)
}

/// Puts the tetrahedra of each volume together, otherwise in their order.
fn sort_by_volume(mesh: &mut TetMesh, volumes: &mut Volumes) {
    let mut order: Vec<usize> = (0..mesh.tets.len()).collect();
    order.sort_by_key(|&t| volumes.of[t]);
    mesh.tets = order.iter().map(|&t| mesh.tets[t]).collect();
    volumes.of.sort_unstable();
}
