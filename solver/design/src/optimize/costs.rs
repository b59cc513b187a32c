//! What keeps designed parameters small: a term (p/s)² for each that has one.
//!
//! p = p₀ + c y     parameter of a variable y of the loads [m], c its change per metre
//! s                the value at which the term is 1

use scene::config::ParameterDesign;

use crate::variables::DesignMap;

/// The terms of a level.
pub struct Costs(Vec<Cost>);

struct Cost {
    /// Name of the parameter.
    name: String,
    /// Index of its variable among those of the loads.
    variable: usize,
    /// p₀/s, and c/s [1/m].
    at_zero: f64,
    per_metre: f64,
}

impl Costs {
    /// Collects the terms of the parameters of a design.
    pub fn new(parameters: &[ParameterDesign], map: &DesignMap) -> Self {
        let named = map.named_load_variables();
        let at_zero = map.parameters(&vec![0.0; map.variables()]);
        let one = |parameter: &ParameterDesign| {
            let unit = parameter.unit_cost()?;
            let variable = named.iter().position(|own| own.path == parameter.name)?;
            Some(Cost {
                variable,
                at_zero: at_zero.get(&parameter.name)? / unit,
                per_metre: named[variable].per_metre / unit,
                name: parameter.name.clone(),
            })
        };
        Self(parameters.iter().filter_map(one).collect())
    }

    /// The terms at variables of the loads, by name.
    pub fn values<'a>(&'a self, loads: &'a [f64]) -> impl Iterator<Item = (String, f64)> + 'a {
        self.0.iter().map(|cost| (cost.name.clone(), cost.at(loads).powi(2)))
    }

    /// Their derivatives by the variables, each with the index of its own.
    pub fn slopes<'a>(&'a self, loads: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.0.iter().map(|cost| (cost.variable, 2.0 * cost.at(loads) * cost.per_metre))
    }

    /// Their second derivatives.
    pub fn bends(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.0.iter().map(|cost| (cost.variable, 2.0 * cost.per_metre.powi(2)))
    }
}

impl Cost {
    /// p/s.
    fn at(&self, loads: &[f64]) -> f64 {
        self.at_zero + self.per_metre * loads[self.variable]
    }
}
