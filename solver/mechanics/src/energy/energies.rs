//! The terms of the potential energy, in a list.
//!
//! Sums over all terms go through [`Energies::terms`], always in the order in which they were added, so that they round
//! in the same way. What a term is to balances and to the adjoint method it says itself ([`Energy::nature`],
//! [`Energy::constraint_vjp`]); the list only knows whose numbers it is made with. A term is found by its type.

use std::any::Any;
use std::sync::Arc;

use super::owner::Owner;
use super::{Chamber, Contact, Elastic, Energy, GasLaw, Inertia, Iterate, Nature};
use crate::element::FunctionSpace;
use crate::material::Material;
use crate::schedule::Schedule;

/// One term of the energy, with whose numbers it is made with.
#[derive(Clone)]
pub struct Term {
    /// Value and derivatives.
    pub energy: Arc<dyn Energy>,
    /// The owners of its numbers with how many each has, in the order of [`Energy::parameter_vjp`]; the last one has
    /// the rest.
    pub owners: Vec<(Owner, usize)>,
}

impl Term {
    /// A term whose numbers nobody asks for.
    pub fn new(energy: impl Energy) -> Self {
        Self { energy: Arc::new(energy), owners: Vec::new() }
    }

    /// A term with numbers of one owner.
    pub fn of(owner: Owner, energy: impl Energy) -> Self {
        Self { energy: Arc::new(energy), owners: vec![(owner, usize::MAX)] }
    }

    /// A term with some numbers of a first owner, and the rest of a second one.
    pub fn of_both(first: (Owner, usize), second: Owner, energy: impl Energy) -> Self {
        Self { energy: Arc::new(energy), owners: vec![first, (second, usize::MAX)] }
    }

    /// What it is.
    pub fn nature(&self) -> Nature {
        self.energy.nature()
    }

    /// It as what it is, where it is that.
    pub fn downcast<T: Energy>(&self) -> Option<&T> {
        (&*self.energy as &dyn Any).downcast_ref()
    }

    /// This term with its load as it is at a time, but for the pressures of chambers.
    fn held(&self, time: f64) -> Self {
        let energy = self.energy.held(time).unwrap_or_else(|| Arc::clone(&self.energy));
        Self { energy, owners: self.owners.clone() }
    }
}

/// The terms of the potential energy of some bodies. A copy shares them.
#[derive(Clone, Default)]
pub struct Energies {
    terms: Vec<Term>,
}

/// One of the chambers of some [`Energies`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChamberId(usize);

impl ChamberId {
    /// The id of a chamber by its place among all.
    pub fn of(place: usize) -> Self {
        Self(place)
    }

    /// Who owns what its chamber is prescribed by.
    pub fn owner(self) -> Owner {
        Owner::new("chamber", self.0)
    }
}

impl FromIterator<Term> for Energies {
    fn from_iter<I: IntoIterator<Item = Term>>(terms: I) -> Self {
        Self { terms: terms.into_iter().collect() }
    }
}

impl Energies {
    /// One body of all elements with one law.
    pub fn elastic(material: Box<dyn Material>) -> Self {
        Self::bodies([Elastic::whole(material)])
    }

    /// The elastic energies of some bodies.
    pub fn bodies(bodies: impl IntoIterator<Item = Elastic>) -> Self {
        let place = bodies.into_iter().enumerate();
        place.map(|(place, elastic)| Term::of(Elastic::owner(place), elastic)).collect()
    }

    /// These energies with another term.
    pub fn with_term(mut self, term: Term) -> Self {
        self.terms.push(term);
        self
    }

    /// These energies with another term whose numbers nobody asks for.
    pub fn with(self, energy: impl Energy) -> Self {
        self.with_term(Term::new(energy))
    }

    /// These energies with another chamber, called by a name.
    pub fn with_chamber(self, name: impl Into<String>, chamber: Chamber) -> Self {
        let owner = ChamberId(self.chambers().count()).owner();
        self.with_term(Term::of(owner, Chamber { name: name.into(), ..chamber }))
    }

    /// Adds terms behind those that are there.
    pub fn extend(&mut self, terms: impl IntoIterator<Item = Term>) {
        self.terms.extend(terms);
    }

    /// All terms, in the order in which they were added.
    pub fn terms(&self) -> impl Iterator<Item = &Term> {
        self.terms.iter()
    }

    /// All terms of a type, in their order.
    pub fn each<T: Energy>(&self) -> impl Iterator<Item = &T> {
        self.terms.iter().filter_map(Term::downcast)
    }

    /// The term of a type with numbers of an owner.
    pub fn of<T: Energy>(&self, owner: Owner) -> Option<&T> {
        let owns = |term: &&Term| term.owners.iter().any(|(own, _)| *own == owner);
        self.terms.iter().filter(owns).find_map(Term::downcast)
    }

    /// Puts a changed one in the place of each term of a type, which is given with the place of its owner.
    pub fn change<T: Energy>(&mut self, mut change: impl FnMut(usize, &T) -> T) {
        for term in &mut self.terms {
            let place = term.owners.first().map_or(0, |(owner, _)| owner.place());
            if let Some(changed) = term.downcast::<T>().map(|own| change(place, own)) {
                term.energy = Arc::new(changed);
            }
        }
    }

    /// The terms without their owners.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Energy> {
        self.terms.iter().map(|term| &*term.energy)
    }

    /// Barrier between surfaces.
    pub fn contact(&self) -> Option<&Contact> {
        self.each().next()
    }

    /// The terms whose forces count as those of contact.
    pub fn contact_terms(&self) -> impl Iterator<Item = &dyn Energy> {
        self.iter().filter(|energy| energy.nature().is_contact())
    }

    /// All chambers.
    pub fn chambers(&self) -> impl Iterator<Item = (ChamberId, &Chamber)> {
        self.each::<Chamber>().enumerate().map(|(i, chamber)| (ChamberId(i), chamber))
    }

    /// One chamber.
    pub fn chamber(&self, id: ChamberId) -> &Chamber {
        self.each::<Chamber>().nth(id.0).expect("the id is that of a chamber")
    }

    /// Gives a chamber another gas law.
    pub fn set_gas_law(&mut self, id: ChamberId, gas: Box<dyn GasLaw>) {
        self.change(|place, chamber: &Chamber| {
            let gas = if place == id.0 { gas.clone() } else { chamber.gas.clone() };
            Chamber { gas, ..chamber.clone() }
        });
    }

    /// Energies whose loads are held as they are at a time, except the pressures of some chambers, which grow
    /// in proportion to the time from there.
    pub fn with_scaled_pressures(&self, time: f64, scaled: &[ChamberId]) -> Self {
        let mut held: Self = self.terms.iter().map(|term| term.held(time)).collect();
        held.change(|place, chamber: &Chamber| {
            let gas = &chamber.gas;
            let grows = gas.pressure().is_some() && scaled.contains(&ChamberId(place));
            let value = gas.schedule().at(time);
            let then =
                if grows { Schedule::proportional(value, time) } else { Schedule::held(value) };
            Chamber { gas: gas.with_schedule(then), ..chamber.clone() }
        });
        held
    }

    /// Inertia of all bodies, without tiny masses.
    pub fn inertia(&self) -> impl Iterator<Item = &Inertia> {
        self.each::<Inertia>().filter(|inertia| !inertia.is_tiny())
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
