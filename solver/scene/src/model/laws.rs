//! What the bodies of a scene are made of: one law for each, or one for each volume of its mesh.

use std::ops::Range;

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::energy::{Branch, Elastic, Mullins, Viscous};
use mechanics::material::{LAWS, Lame, Law, NeoHookean, OgdenRoxburgh, Specification};
use mesh::{Tags, TetMesh, Volumes};
use program::{KeyPath, misfit, unknown};

use super::Scene;
use crate::config::{BodyConfig, Dilatation, MaterialConfig};
use crate::term::mullins::MullinsConfig;

/// The law of a body or of one of its volumes.
#[derive(Clone)]
pub struct SceneLaw {
    /// The body, by its place among all.
    pub part: usize,
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
}

impl Scene {
    /// What reports and messages call a law: as the body or its volume; `body.volume` where there
    /// are several bodies.
    pub fn law_name(&self, law: &SceneLaw) -> String {
        let body = &self.parts[law.part].config.name;
        match &law.volume {
            None => body.clone(),
            Some(volume) if self.parts.len() == 1 => volume.clone(),
            Some(volume) => format!("{body}.{volume}"),
        }
    }

    /// The overstress of a law, of all tables that are of it.
    pub fn branches(&self, law: &SceneLaw) -> Vec<Branch> {
        let own =
            self.config.relaxation.iter().filter(|table| self.is_of(table.on.as_deref(), law));
        own.map(|own| Branch { overstress: own.overstress, time: own.time }).collect()
    }

    /// The softening of a law after a first stretch, if it has any.
    pub fn mullins(&self, law: &SceneLaw) -> Option<OgdenRoxburgh> {
        let mut tables = self.config.mullins.iter();
        tables.find(|table| self.is_of(table.on.as_deref(), law)).map(MullinsConfig::law)
    }

    /// Whether what stands beside laws, [[relaxation]] and [[mullins]], is beside laws that can have it.
    pub(super) fn check_beside_laws(&self) -> Result<()> {
        for table in &self.config.relaxation {
            self.isochoric_laws("relaxation", table.on.as_deref())?;
        }
        let mut softened = vec![false; self.laws.len()];
        for table in &self.config.mullins {
            for i in self.isochoric_laws("mullins", table.on.as_deref())? {
                let twice = std::mem::replace(&mut softened[i], true);
                ensure!(
                    !twice,
                    misfit!(
                        KeyPath::list("mullins").on(table.on.as_deref().unwrap_or_default()),
                        ": \"{}\" is softened by two tables; expected one, with on where volumes differ",
                        self.law_name(&self.laws[i])
                    )
                );
            }
        }
        Ok(())
    }

    /// The laws that a table of a list is of, by their places; all of them without a name.
    fn isochoric_laws(&self, list: &str, on: Option<&str>) -> Result<Vec<usize>> {
        let own: Vec<usize> =
            (0..self.laws.len()).filter(|&i| self.is_of(on, &self.laws[i])).collect();
        let names = || self.laws.iter().map(|law| self.law_name(law)).collect::<Vec<_>>();
        ensure!(
            !own.is_empty(),
            misfit!(
                KeyPath::list(list).on(on.unwrap_or_default()),
                ": no body or volume has this name; there are: {}",
                names().join(", ")
            )
        );
        for &i in &own {
            let law = &self.laws[i];
            ensure!(
                law.material.build().isochoric().is_some(),
                misfit!(
                    KeyPath::list(list),
                    ": the law {} of \"{}\" has no isochoric part in Ī₁ and Ī₂; expected one of: {}",
                    law.material.law.key,
                    self.law_name(law),
                    with_isochoric_part().join(", ")
                )
            );
        }
        Ok(own)
    }

    /// Largest shear modulus of all materials, at rest [Pa].
    pub(super) fn largest_shear_modulus(&self) -> f64 {
        self.laws[self.stiffest_law()].material.moduli().shear
    }

    /// The law with the largest shear modulus at rest, the first of several.
    fn stiffest_law(&self) -> usize {
        let shear = |law: usize| self.laws[law].material.moduli().shear;
        (1..self.laws.len()).fold(0, |best, law| if shear(law) > shear(best) { law } else { best })
    }

    /// The law whose shear modulus is the stiffness of `[contact]`, where the scene gives none.
    pub fn law_of_contact(&self) -> Option<usize> {
        self.config.contact()?.stiffness.is_none().then(|| self.stiffest_law())
    }

    /// Whether all laws can have the dilatation of the scene.
    pub(super) fn check_dilatation(&self) -> Result<()> {
        self.laws.iter().try_for_each(|law| self.elastic(law, 0..0).map(drop))
    }

    /// The elastic energy of a law on some elements.
    pub(super) fn elastic(&self, law: &SceneLaw, elements: Range<usize>) -> Result<Elastic> {
        if self.is_rigid(&self.parts[law.part].config.name) {
            // it has no strain to speak of: a law that is no stiffer than those around it does as well
            let young = 3.0 * self.rigid_shear_modulus();
            return Ok(Elastic::part(Box::new(NeoHookean(Lame::new(young, 0.4))), elements));
        }
        let elastic = Elastic::part(law.material.build(), elements);
        if self.config.solver.dilatation == Dilatation::Pointwise {
            return Ok(elastic);
        }
        Ok(elastic.with_mean_dilatation().ok_or_else(|| {
            let has = |law: &&Law| (law.build)(law.sample).split().is_some();
            let known: Vec<_> = LAWS.iter().filter(has).map(|law| law.key).collect();
            KeyPath::table("solver").key("dilatation").told(format!(
                "[solver] dilatation = \"mean\": the law {} of \"{}\" has no term of the change of \
                 volume alone, of which a mean could be taken; expected one of: {}",
                law.material.law.key,
                self.law_name(law),
                known.join(", ")
            ))
        })?)
    }

    /// Whether a table with a name, or without one, is of a law.
    fn is_of(&self, on: Option<&str>, law: &SceneLaw) -> bool {
        on.is_none_or(|on| self.is_law_of(law, on))
    }

    /// The overstress of a law on some elements, if it has any and is not rigid; `first` relaxed stresses are of the
    /// terms before.
    pub(super) fn overstress(
        &self,
        law: &SceneLaw,
        elements: Range<usize>,
        first: usize,
    ) -> Option<Viscous> {
        // a rigid body has another elastic law, whose parameters are not those of the overstress
        let branches = self.branches(law);
        let has = !branches.is_empty() && !self.is_rigid(&self.parts[law.part].config.name);
        let isochoric = law.material.build().isochoric().filter(|_| has)?;
        Some(Viscous::new(isochoric, branches, elements, first))
    }

    /// The softening of a law on some elements, if it has any and is not rigid; `first` internal variables are
    /// of the terms before.
    pub(super) fn softening(
        &self,
        law: &SceneLaw,
        elements: Range<usize>,
        first: usize,
    ) -> Option<Mullins> {
        let is_rigid = self.is_rigid(&self.parts[law.part].config.name);
        let softening = self.mullins(law).filter(|_| !is_rigid)?;
        let isochoric = law.material.build().isochoric()?;
        Some(Mullins::new(isochoric, softening, elements, first).named(&self.law_name(law)))
    }

    /// Whether a law is called so, or is of a body that is.
    pub fn is_law_of(&self, law: &SceneLaw, name: &str) -> bool {
        self.law_name(law) == name || self.parts[law.part].config.name == name
    }
}

/// The laws that have an isochoric part.
fn with_isochoric_part() -> Vec<&'static str> {
    let has = |law: &&Law| (law.build)(law.sample).isochoric().is_some();
    LAWS.iter().filter(has).map(|law| law.key).collect()
}

/// The laws of one body. Tetrahedra of each volume with a law of its own follow each other from now
/// on; names of volumes that share one law are dropped.
pub(super) fn laws(
    part: usize,
    config: &BodyConfig,
    mesh: &mut TetMesh,
    tags: &mut Tags,
) -> Result<Vec<SceneLaw>> {
    let MaterialConfig::Volumes(materials) = &config.material else {
        tags.volumes = Volumes::default();
        let material = config.material.specification()?;
        let config = config.material.clone();
        return Ok(vec![SceneLaw { part, volume: None, config, material }]);
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
        let material = config.specification().with_context(context)?;
        found.push(SceneLaw { part, volume: Some(name.clone()), config, material });
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
