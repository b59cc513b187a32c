//! `gravity`, `[[body_force]]` and `[[traction]]`: forces that do not turn with the body.

use anyhow::{Result, ensure};
use measure::written::FieldSchema;
use mechanics::energy::{BodyForce, Term, Traction};
use mechanics::schedule::{Field, WrittenField};
use mechanics::symmetry::AXES;
use mesh::Vec3;
use program::KeyPath;

use super::values::{Values, components as scheduled};
use super::{
    About, Around, Ground, Known, Room, RoomNumber, Scheduled, Stage, check_off_cuts, components,
    each, owned,
};
use crate::meaning::cut;

program::table! {
    /// A force per rest volume.
    #[derive(Clone, Debug)]
    pub struct BodyForceConfig {
        /// Force per volume, for gravity density times acceleration [N/m³].
        #[schemars(with = "FieldSchema")]
        force: WrittenField;
    }
}

program::table! {
    /// A force per rest area.
    #[derive(Clone, Debug)]
    pub struct TractionConfig {
        /// Tag name.
        on: String;
        /// Force per area [Pa].
        #[schemars(with = "FieldSchema")]
        traction: WrittenField;
    }
}

/// Acceleration by gravity.
impl Room for WrittenField {
    fn about(&self) -> About {
        About {
            list: "gravity",
            stage: Stage::Load,
            paths: "gravity.x, .y or .z",
            meaning: "what is added to a component of gravity",
            example: "",
        }
    }

    fn schedules(&self) -> Vec<Scheduled<'_>> {
        scheduled(KeyPath::of("gravity"), true, self)
    }

    /// The weight of the bodies.
    fn beside(&self, law: usize, ground: &Ground, _: usize) -> Result<Option<Term>> {
        if self.is_zero() {
            return Ok(None);
        }
        let Ground { around, laws, body, .. } = ground;
        let (field, own) = (around.values.field(self), &laws[law]);
        let weight = BodyForce::weight(field, own.density(around.method)?, own.elements(body));
        Ok(Some(Term::of(BodyForce::weight_owner(law), weight)))
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        everywhere(&KeyPath::of("gravity"), self, ground).map(|_| Vec::new())
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        let acts = usize::from(!self.is_zero());
        each(&mut std::slice::from_mut(self)[..acts], |_, own| {
            (String::new(), components("", "m/s²", own).collect())
        })
    }

    fn derivative(&self, _: usize, key: &str, known: &Known) -> f64 {
        known.by_all(&format!("gravity.{key}"))
    }
}

impl Room for Vec<BodyForceConfig> {
    fn about(&self) -> About {
        About { list: "body_force", stage: Stage::Load, paths: "", meaning: "", example: "" }
    }

    fn schedules(&self) -> Vec<Scheduled<'_>> {
        let key = || KeyPath::list("body_force").key("force");
        self.iter().flat_map(|load| scheduled(key(), true, &load.force)).collect()
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        let key = || KeyPath::list("body_force").key("force");
        let force = |load: &BodyForceConfig| everywhere(&key(), &load.force, ground);
        let terms = self.iter().map(|load| Ok(Term::new(BodyForce::whole(force(load)?))));
        terms.collect()
    }
}

impl TractionConfig {
    fn key(&self) -> KeyPath {
        KeyPath::list("traction").on(&self.on).key("traction")
    }
}

impl Room for Vec<TractionConfig> {
    fn about(&self) -> About {
        About {
            list: "traction",
            stage: Stage::Load,
            paths: "traction.TAG.x, .y or .z",
            meaning: "what is added to a component of the traction on a tag that has one",
            example: "",
        }
    }

    fn schedules(&self) -> Vec<Scheduled<'_>> {
        self.iter().flat_map(|load| scheduled(load.key(), true, &load.traction)).collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        check_off_cuts("traction", |tag| self.iter().any(|load| load.on == tag), &around.cuts)
    }

    fn stress(&self, _: f64, values: &Values) -> f64 {
        self.iter().map(|load| values.length(&load.traction)).fold(0.0, f64::max)
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        let Ground { around, body, space, .. } = ground;
        let nodes = space.node_positions(&body.mesh.vertices);
        let one = |load: &TractionConfig| {
            let facets = body.facets(&load.on)?;
            let ids = facets.iter().flat_map(|&f| space.facet_nodes(f));
            let places: Vec<Vec3> = ids.map(|node| nodes[node]).collect();
            let traction = around.values.defined(&load.key(), &load.traction, &places)?;
            Ok(Traction::new(space, &facets, traction))
        };
        Ok(owned("traction", self.iter().map(one).collect::<Result<Vec<_>>>()?))
    }

    /// Of a tag with several there is no path.
    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        let on: Vec<String> = self.iter().map(|load| load.on.clone()).collect();
        let mut all = each(self, |_, TractionConfig { on, traction }| {
            (on.clone(), components("", "Pa", traction).collect())
        });
        all.retain(|number| on.iter().filter(|tag| **tag == number.name).count() == 1);
        all
    }

    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64 {
        known.by(Traction::owner(table), &format!("traction.{key}"))
    }
}

/// A force on all of a body, if it is defined there and does not point across a plane of symmetry; with other numbers as
/// it is.
fn everywhere(key: &KeyPath, written: &WrittenField, ground: &Ground) -> Result<Field> {
    let Ground { around: Around { values, .. }, body, space, last, .. } = ground;
    if last.is_some() {
        return Ok(values.field(written));
    }
    let nodes = space.node_positions(&body.mesh.vertices);
    let field = values.defined(key, written, &nodes)?;
    // the full load first, for the message
    let moments: Vec<f64> = values.moments().into_iter().rev().collect();
    for plane in &body.planes {
        let places = plane.vertices().iter().map(|&v| body.mesh.vertices[v]);
        for (t, p) in moments.iter().flat_map(|t| places.clone().map(move |p| (*t, p))) {
            let (across, axis) = (field.at(p, t)[plane.axis], AXES[plane.axis]);
            ensure!(
                across == 0.0,
                cut(&plane.tags).told(format!(
                    "{}: {key} is {across:.3e} along {axis} at ({:.5}, {:.5}, {:.5}) m and t = {t}, \
                     across the plane {}; expected 0 there, as its mirror image points the other way: \
                     simulate the whole body (solver mirror), or turn the load",
                    plane.title(),
                    p.x,
                    p.y,
                    p.z,
                    plane.equation()
                ))
            );
        }
    }
    Ok(field)
}
