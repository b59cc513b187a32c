//! The owner of the terms of the potential energy.
//!
//! Every kind of term has its own field, and is found there by its type. Sums over
//! all terms go through [`Energies::terms`], always in the same order, so that they
//! round in the same way.

use std::sync::Arc;

use super::{
    BodyForce, Chamber, Contact, Elastic, Energy, Fibres, Friction, GasLaw, Held, Inertia, Iterate,
    Membrane, Mullins, Rigid, RigidLoad, RigidMass, RigidMoment, Springs, Traction, Viscous,
    Winding,
};
use crate::element::FunctionSpace;
use crate::material::Material;
use crate::schedule::Schedule;

/// The terms of the potential energy of some bodies. A copy shares the large terms.
#[derive(Clone, Default)]
pub struct Energies {
    /// Terms of each body.
    pub bodies: Vec<BodyEnergies>,
    /// Thin sheets on facets.
    pub membranes: Vec<Membrane>,
    /// Families of fibres in volumes.
    pub fibres: Vec<Fibres>,
    /// Threads on facets.
    pub windings: Vec<Winding>,
    /// Chambers with gas.
    chambers: Vec<NamedChamber>,
    /// Barrier between surfaces.
    pub contact: Option<Arc<Contact>>,
    /// Friction between surfaces.
    pub friction: Option<Friction>,
    /// Forces per volume on all bodies, beside their weight.
    pub body_forces: Vec<BodyForce>,
    /// Forces per area.
    pub tractions: Vec<Traction>,
    /// Terms of each rigid part.
    pub rigid: Vec<RigidEnergies>,
    /// What pulls supports while they are released.
    pub springs: Option<Springs>,
    /// Terms that no scene has, such as manufactured forces.
    pub others: Vec<Arc<dyn Energy>>,
}

/// The terms of one body.
#[derive(Clone)]
pub struct BodyEnergies {
    /// Elastic energy.
    pub elastic: Elastic,
    /// The overstress beside the elastic stress, if the body is viscoelastic.
    pub viscous: Option<Viscous>,
    /// What a first stretch takes from its stress, if it is softened by one.
    pub mullins: Option<Mullins>,
    /// Energy in the field of gravity, if there is one.
    pub weight: Option<BodyForce>,
    /// Inertia, or the tiny mass of a body that is loose.
    pub inertia: Option<Inertia>,
}

/// The terms of one rigid part.
#[derive(Clone)]
pub struct RigidEnergies {
    /// What the user calls it.
    pub name: String,
    /// What keeps it rigid; none where it cannot turn.
    pub stiffness: Option<Rigid>,
    /// Inertia of its mass, where bodies have inertia.
    pub mass: Option<RigidMass>,
    /// Force on it, with its weight.
    pub load: RigidLoad,
    /// Moment on it, if there is any.
    pub moment: Option<RigidMoment>,
}

/// A chamber by its name.
#[derive(Clone)]
pub struct NamedChamber {
    /// What the user calls it.
    pub name: String,
    /// The wall and gas.
    pub chamber: Chamber,
}

/// One of the chambers of some [`Energies`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChamberId(usize);

impl ChamberId {
    /// The id of a chamber by its place among all.
    pub fn of(place: usize) -> Self {
        Self(place)
    }
}

/// Which term of the energy one is; bodies by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Elastic energy of a body.
    Elastic(usize),
    /// Overstress of a body.
    Viscous(usize),
    /// Softening of a body.
    Mullins(usize),
    /// Weight of a body.
    Weight(usize),
    /// Elastic energy of a sheet, by its index.
    Membrane(usize),
    /// Energy of a family of fibres, by its index.
    Fibre(usize),
    /// Energy of a thread, by its index.
    Winding(usize),
    /// Inertia of a body.
    Inertia(usize),
    /// Tiny mass of a loose body.
    TinyMass(usize),
    /// Gas in a chamber.
    Chamber(ChamberId),
    /// Barrier between surfaces.
    Contact,
    /// Friction between surfaces.
    Friction,
    /// Force per volume on all bodies.
    BodyForce,
    /// Force per area, by its index.
    Traction(usize),
    /// What keeps a part rigid, by its index.
    Rigid(usize),
    /// Inertia of a rigid part.
    RigidMass(usize),
    /// Force on a rigid part, with its weight.
    RigidLoad(usize),
    /// Moment on a rigid part.
    RigidMoment(usize),
    /// Springs of released supports.
    Springs,
    /// None of these.
    Other,
}

/// Numbers that terms are made with, by which there are derivatives; bodies by their
/// index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterId {
    /// Parameters of the law of a body.
    Material(usize),
    /// Overstress and time of each branch of a body.
    Relaxation(usize),
    /// r, m and β of the softening of a body.
    Mullins(usize),
    /// Thickness of a sheet, then the parameters of its law, then the angle [rad] of its axes, if it has some.
    Membrane(usize),
    /// k₁, k₂, dispersion and angle [rad] of a family of fibres.
    Fibre(usize),
    /// Stiffness EA [N] and pretension [N] of a thread; what the pitch of its helix is made of, and its phase [rad].
    Winding(usize),
    /// Density of a body in its weight, then the three components of what is added to gravity.
    Weight(usize),
    /// Density of a body in its inertia, or in its tiny mass.
    Density(usize),
    /// The three components of what is added to a traction.
    Traction(usize),
    /// Mass of a rigid part in its inertia.
    RigidMass(usize),
    /// Mass of a rigid part in its weight, then the three components of what is added to the force on it, and to
    /// gravity.
    RigidLoad(usize),
    /// The three components of what is added to the moment on a rigid part.
    RigidMoment(usize),
    /// Coefficient of friction.
    Friction,
    /// Stiffness of the barrier, in its own forces and in those of friction.
    ContactStiffness,
    /// What a chamber is prescribed by: pressure, fill, change or factor of the volume, injected volume or supply.
    Chamber(ChamberId),
}

/// One term of the energy.
#[derive(Clone, Copy)]
pub struct Term<'a> {
    /// Which one.
    pub kind: Kind,
    /// Value and derivatives.
    pub energy: &'a dyn Energy,
}

impl Kind {
    /// Whether its forces count as those of contact.
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Contact | Self::Friction)
    }

    /// Whether its forces are internal ones: they depend on differences of the displacement
    /// and have no resultant.
    pub fn is_elastic(self) -> bool {
        let reinforces = matches!(self, Self::Membrane(_) | Self::Fibre(_) | Self::Winding(_));
        let of_body = matches!(self, Self::Elastic(_) | Self::Viscous(_) | Self::Mullins(_));
        reinforces || of_body || matches!(self, Self::Rigid(_))
    }

    /// Whether its forces are given and do not depend on the displacement.
    pub fn is_dead_load(self) -> bool {
        matches!(self, Self::Weight(_) | Self::BodyForce | Self::Traction(_) | Self::RigidLoad(_))
    }

    /// Whether energy is stored in it: what inertia, viscosity and friction add to the potential of
    /// a time step is not. Elastic energy and softening together are the work done on a body, of which the part that
    /// is lost cannot be had back.
    pub fn is_stored(self) -> bool {
        !matches!(
            self,
            Self::Viscous(_)
                | Self::Inertia(_)
                | Self::TinyMass(_)
                | Self::RigidMass(_)
                | Self::Friction
        )
    }

    /// The numbers that it is made with.
    pub fn parameter(self) -> Option<ParameterId> {
        match self {
            Self::Elastic(body) | Self::Viscous(body) | Self::Mullins(body) => {
                Some(ParameterId::Material(body))
            }
            Self::Membrane(sheet) => Some(ParameterId::Membrane(sheet)),
            Self::Fibre(family) => Some(ParameterId::Fibre(family)),
            Self::Winding(thread) => Some(ParameterId::Winding(thread)),
            Self::Weight(body) => Some(ParameterId::Weight(body)),
            Self::Inertia(body) | Self::TinyMass(body) => Some(ParameterId::Density(body)),
            Self::Traction(load) => Some(ParameterId::Traction(load)),
            Self::Chamber(chamber) => Some(ParameterId::Chamber(chamber)),
            Self::RigidMass(part) => Some(ParameterId::RigidMass(part)),
            Self::RigidLoad(part) => Some(ParameterId::RigidLoad(part)),
            Self::RigidMoment(part) => Some(ParameterId::RigidMoment(part)),
            Self::Contact => Some(ParameterId::ContactStiffness),
            Self::Friction => Some(ParameterId::Friction),
            _ => None,
        }
    }
}

impl BodyEnergies {
    /// Without weight and inertia.
    pub fn new(elastic: Elastic) -> Self {
        Self { elastic, viscous: None, mullins: None, weight: None, inertia: None }
    }
}

impl Energies {
    /// One body of all elements with one law.
    pub fn elastic(material: Box<dyn Material>) -> Self {
        Self::bodies(vec![BodyEnergies::new(Elastic::whole(material))])
    }

    /// Some bodies.
    pub fn bodies(bodies: Vec<BodyEnergies>) -> Self {
        Self { bodies, ..Self::default() }
    }

    /// These energies with another chamber.
    pub fn with_chamber(mut self, name: impl Into<String>, chamber: Chamber) -> Self {
        self.chambers.push(NamedChamber { name: name.into(), chamber });
        self
    }

    /// These energies with a term that no scene has.
    pub fn with(mut self, term: impl Energy + 'static) -> Self {
        self.others.push(Arc::new(term));
        self
    }

    /// All terms: elastic energy, overstress, softening and weight of each body, sheets, fibres, threads, inertia of each,
    /// chambers, contact, friction, body forces, tractions, rigid parts, springs, others.
    pub fn terms(&self) -> impl Iterator<Item = Term<'_>> {
        fn term(kind: Kind, energy: &dyn Energy) -> Term<'_> {
            Term { kind, energy }
        }
        let statics = self.bodies.iter().enumerate().flat_map(|(i, body)| {
            let weight = body.weight.as_ref().map(|weight| term(Kind::Weight(i), weight));
            let viscous = body.viscous.as_ref().map(|viscous| term(Kind::Viscous(i), viscous));
            let mullins = body.mullins.as_ref().map(|mullins| term(Kind::Mullins(i), mullins));
            let elastic = [term(Kind::Elastic(i), &body.elastic)].into_iter();
            elastic.chain(viscous).chain(mullins).chain(weight)
        });
        let sheets = self.membranes.iter().enumerate();
        let sheets = sheets.map(|(i, sheet)| term(Kind::Membrane(i), sheet));
        let fibres = self.fibres.iter().enumerate();
        let fibres = fibres.map(|(i, family)| term(Kind::Fibre(i), family));
        let threads = self.windings.iter().enumerate();
        let threads = threads.map(|(i, thread)| term(Kind::Winding(i), thread));
        let inertia = self.bodies.iter().enumerate().filter_map(|(i, body)| {
            let inertia = body.inertia.as_ref()?;
            let kind = if inertia.is_tiny() { Kind::TinyMass(i) } else { Kind::Inertia(i) };
            Some(term(kind, inertia))
        });
        let chambers = self.chambers().map(|(id, named)| term(Kind::Chamber(id), &named.chamber));
        let contact = self.contact.as_deref().map(|contact| term(Kind::Contact, contact));
        let friction = self.friction.as_ref().map(|friction| term(Kind::Friction, friction));
        let forces = self.body_forces.iter().map(|force| term(Kind::BodyForce, force));
        let tractions = self.tractions.iter().enumerate();
        let tractions = tractions.map(|(i, traction)| term(Kind::Traction(i), traction));
        let rigid = self.rigid.iter().enumerate().flat_map(|(i, part)| {
            let stiffness = part.stiffness.as_ref().map(|own| term(Kind::Rigid(i), own));
            let mass = part.mass.as_ref().map(|own| term(Kind::RigidMass(i), own));
            let moment = part.moment.as_ref().map(|own| term(Kind::RigidMoment(i), own));
            let load = term(Kind::RigidLoad(i), &part.load);
            stiffness.into_iter().chain(mass).chain([load]).chain(moment)
        });
        let springs = self.springs.as_ref().map(|springs| term(Kind::Springs, springs));
        let others = self.others.iter().map(|other| term(Kind::Other, &**other));
        let loads = forces.chain(tractions).chain(rigid).chain(springs).chain(others);
        let statics = statics.chain(sheets).chain(fibres).chain(threads);
        statics.chain(inertia).chain(chambers).chain(contact).chain(friction).chain(loads)
    }

    /// The terms without their kinds.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Energy> {
        self.terms().map(|term| term.energy)
    }

    /// The terms whose forces count as those of contact.
    pub fn contact_terms(&self) -> impl Iterator<Item = &dyn Energy> {
        self.terms().filter(|term| term.kind.is_contact()).map(|term| term.energy)
    }

    /// All chambers.
    pub fn chambers(&self) -> impl Iterator<Item = (ChamberId, &NamedChamber)> {
        self.chambers.iter().enumerate().map(|(i, named)| (ChamberId(i), named))
    }

    /// One chamber.
    pub fn chamber(&self, id: ChamberId) -> &Chamber {
        &self.chambers[id.0].chamber
    }

    /// Gives a chamber another gas law.
    pub fn set_gas_law(&mut self, id: ChamberId, gas: Box<dyn GasLaw>) {
        self.chambers[id.0].chamber.gas = gas;
    }

    /// Energies whose loads are held as they are at a time, except the pressures of some chambers, which grow
    /// in proportion to the time from there. Loads that no derivative by numbers asks for become terms without a kind.
    pub fn with_scaled_pressures(&self, time: f64, scaled: &[ChamberId]) -> Self {
        let mut held = self.clone();
        let mut loads: Vec<Arc<dyn Energy>> = Vec::new();
        for body in &mut held.bodies {
            loads.extend(body.weight.take().map(|weight| Arc::new(weight) as Arc<dyn Energy>));
        }
        let forces = std::mem::take(&mut held.body_forces).into_iter();
        loads.extend(forces.map(|force| Arc::new(force) as Arc<dyn Energy>));
        let tractions = std::mem::take(&mut held.tractions).into_iter();
        loads.extend(tractions.map(|traction| Arc::new(traction) as Arc<dyn Energy>));
        loads.append(&mut held.others);
        for part in &mut held.rigid {
            part.load = part.load.held(time);
            part.moment = part.moment.as_ref().map(|moment| moment.held(time));
        }
        held.others =
            loads.into_iter().map(|energy| Arc::new(Held { energy, time }) as _).collect();
        for (place, named) in held.chambers.iter_mut().enumerate() {
            let gas = &mut named.chamber.gas;
            let grows = gas.pressure().is_some() && scaled.contains(&ChamberId(place));
            let value = gas.schedule().at(time);
            let then =
                if grows { Schedule::proportional(value, time) } else { Schedule::held(value) };
            *gas.schedule_mut() = then;
        }
        held
    }

    /// Inertia of all bodies, without tiny masses.
    pub fn inertia(&self) -> impl Iterator<Item = &Inertia> {
        self.bodies.iter().filter_map(|body| body.inertia.as_ref()).filter(|i| !i.is_tiny())
    }

    /// The internal variables of all terms at the end of a step, one term after the other; empty where
    /// there are none.
    pub fn internal(&self, at: &Iterate) -> Vec<f64> {
        let variables = self.iter().filter_map(Energy::internal_variables);
        variables.flat_map(|variables| variables.values(at)).collect()
    }

    /// Number of internal variables of all terms.
    pub fn internal_count(&self, space: &FunctionSpace) -> usize {
        self.iter().filter_map(Energy::internal_variables).map(|of| of.count(space)).sum()
    }

    /// Nodal forces of contact and friction, −∂E/∂u [N], three components per node.
    pub fn contact_forces(&self, at: &Iterate) -> Vec<f64> {
        let mut pull = vec![0.0; at.u.len()];
        self.contact_terms().for_each(|energy| energy.add_gradient(at, &mut pull));
        pull.iter_mut().for_each(|p| *p = -*p);
        pull
    }
}

/// λᵀ ∂²E/∂u∂p for the numbers p that the terms are made with, in each time step.
#[derive(Clone, Debug, Default)]
pub struct ParameterGradients {
    /// Gradients of each time step, of each term that has parameters.
    steps: Vec<Vec<(ParameterId, Vec<f64>)>>,
}

impl ParameterGradients {
    /// None yet, for some time steps.
    pub fn new(steps: usize) -> Self {
        Self { steps: vec![Vec::new(); steps] }
    }

    /// Number of time steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Adds those of a term in a time step, counted from 0.
    pub fn add(&mut self, step: usize, id: ParameterId, by: Vec<f64>) {
        self.steps[step].push((id, by));
    }

    /// Gradients of each term in a time step, counted from 0.
    pub fn of_step(&self, step: usize) -> Vec<(ParameterId, Vec<f64>)> {
        self.steps[step].clone()
    }

    /// By what a chamber is prescribed by, in a time step counted from 0.
    pub fn chamber(&self, step: usize, id: ChamberId) -> f64 {
        let own = self.steps[step].iter().filter(|(of, _)| *of == ParameterId::Chamber(id));
        own.flat_map(|(_, by)| by).sum()
    }

    /// Sum over all time steps, term by term, and over the terms that share the
    /// numbers; nothing where no term has them.
    pub fn total(&self, id: ParameterId) -> Vec<f64> {
        let of_step = |step: &Vec<(ParameterId, Vec<f64>)>| -> Vec<Vec<f64>> {
            step.iter().filter(|(of, _)| *of == id).map(|(_, by)| by.clone()).collect()
        };
        let mut steps = self.steps.iter().map(of_step);
        let Some(mut terms) = steps.next() else { return Vec::new() };
        for step in steps {
            terms.iter_mut().zip(&step).for_each(|(sum, by)| add(sum, by));
        }
        let mut terms = terms.into_iter();
        let Some(mut total) = terms.next() else { return Vec::new() };
        terms.for_each(|by| add(&mut total, &by));
        total
    }
}

fn add(sum: &mut [f64], by: &[f64]) {
    sum.iter_mut().zip(by).for_each(|(s, b)| *s += b);
}
