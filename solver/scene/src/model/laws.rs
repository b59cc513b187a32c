//! What the bodies of a scene are made of: one law for each, or one for each volume of its mesh.

use std::ops::Range;

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mechanics::energy::{Branch, Elastic, Viscous};
use mechanics::material::{LAWS, Lame, Law, NeoHookean, Specification};
use mesh::{Tags, TetMesh, Volumes};
use program::{KeyPath, misfit, unknown};

use super::Scene;
use crate::config::{BodyConfig, Dilatation, MaterialConfig, RelaxationConfig};

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
    /// The overstress.
    pub branches: Vec<Branch>,
}

impl SceneLaw {
    /// The tetrahedra that have this law, on a body with the volumes of the scene.
    #[must_use]
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
    #[must_use]
    pub fn law_name(&self, law: &SceneLaw) -> String {
        let body = &self.parts[law.part].config.name;
        match &law.volume {
            None => body.clone(),
            Some(volume) if self.parts.len() == 1 => volume.clone(),
            Some(volume) => format!("{body}.{volume}"),
        }
    }

    /// Gives the laws the overstress of `[[relaxation]]`, and no other.
    ///
    /// # Errors
    /// When a name is none of the bodies and volumes, or a law has no isochoric part.
    pub fn set_branches(&mut self) -> Result<()> {
        self.laws.iter_mut().for_each(|law| law.branches.clear());
        for table in self.config.relaxation.clone() {
            let is_own = |&i: &usize| self.relaxes(&table, &self.laws[i]);
            let own: Vec<usize> = (0..self.laws.len()).filter(is_own).collect();
            let names = || self.laws.iter().map(|law| self.law_name(law)).collect::<Vec<_>>();
            ensure!(
                !own.is_empty(),
                misfit!(
                    KeyPath::list("relaxation").on(table.on.as_deref().unwrap_or_default()),
                    ": no body or volume has this name; there are: {}",
                    names().join(", ")
                )
            );
            for &i in &own {
                let law = &self.laws[i];
                ensure!(
                    law.material.build().isochoric().is_some(),
                    misfit!(
                        KeyPath::list("relaxation"),
                        ": the law {} of \"{}\" has no isochoric part in Ī₁ and Ī₂; expected one of: {}",
                        law.material.law.key,
                        self.law_name(law),
                        with_isochoric_part().join(", ")
                    )
                );
            }
            let branch = Branch { overstress: table.overstress, time: table.time };
            own.iter().for_each(|&i| self.laws[i].branches.push(branch));
        }
        Ok(())
    }

    /// Whether all laws can have the dilatation of the scene.
    ///
    /// # Errors
    /// When one has no term of the change of volume alone.
    pub(super) fn check_dilatation(&self) -> Result<()> {
        self.laws.iter().try_for_each(|law| self.elastic(law, 0..0).map(drop))
    }

    /// The elastic energy of a law on some elements.
    ///
    /// # Errors
    /// When the law cannot have the dilatation of the scene.
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

    /// The place of a `[[relaxation]]` among the branches of a law, if it is of that.
    #[must_use]
    pub fn branch_of(&self, law: &SceneLaw, table: usize) -> Option<usize> {
        let is_own = |table: &&RelaxationConfig| self.relaxes(table, law);
        let tables = &self.config.relaxation;
        tables.get(table).filter(is_own)?;
        Some(tables[..table].iter().filter(is_own).count())
    }

    /// Whether a `[[relaxation]]` is of a law.
    fn relaxes(&self, table: &RelaxationConfig, law: &SceneLaw) -> bool {
        table.on.as_ref().is_none_or(|on| self.is_law_of(law, on))
    }

    /// The overstress of a law on some elements, if it has any; `first` relaxed stresses are of the
    /// terms before.
    pub(super) fn overstress(
        &self,
        law: &SceneLaw,
        elements: Range<usize>,
        first: usize,
    ) -> Option<Viscous> {
        let isochoric = law.material.build().isochoric();
        let isochoric = isochoric.filter(|_| !law.branches.is_empty())?;
        Some(Viscous::new(isochoric, law.branches.clone(), elements, first))
    }

    /// Whether a law is called so, or is of a body that is.
    #[must_use]
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
///
/// # Errors
/// When a volume of the mesh has no law or two, or a law is of none.
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
        return Ok(vec![SceneLaw { part, volume: None, config, material, branches: Vec::new() }]);
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
        let (volume, branches) = (Some(name.clone()), Vec::new());
        found.push(SceneLaw { part, volume, config, material, branches });
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
