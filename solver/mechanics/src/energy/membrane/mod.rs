//! A thin sheet that is bonded to facets, on the boundary of a body or inside it.
//!
//! W(u; X) = t ∫_Γ ψ(E) dA          E = ½ (FᵀF − I)      F = ∂x/∂s, 3×2
//! ∂W/∂u_a = t ∫_Γ F S b_a dA       b_a = ∂φ_a/∂s        S = ∂ψ/∂E
//! ∂²W/∂u_a∂u_b = t ∫_Γ b_aᵀ S b_b I + (F B_a)ᵀ D (F B_b) dA
//!
//! t   thickness of the sheet at rest [m]
//! s   coordinates along the flat rest facet, in an orthonormal basis Q = [q₁, q₂]
//! D   ∂S/∂E; F B_a is the 3×3 matrix of δE in components [E₁₁, E₂₂, 2 E₁₂] by δu_a
//!
//! F = Q + ∂u/∂s, and E = ½ (Qᵀh + hᵀQ + hᵀh) with h = ∂u/∂s, so that small strains keep their
//! digits. The displacement is that of the elements, of their degree; the sheet has neither
//! stiffness against bending nor mass, and acts in the middle of its thickness, on the facet.
//!
//! Shape derivative of L = λ · ∂W/∂u with nodal u fixed. With Λ = ∂λ/∂s and a velocity V of the
//! rest vertices, H = ∂V/∂s and ε = sym(QᵀH): the basis of an isotropic law may be carried along
//! such that s is stretched by I + ε. Then
//!
//! δ(dA) = tr ε dA      δF = H − F ε      δΛ = −Λ ε
//! δL = t ∫ [Y + Q Z] : H dA      Y = F T + Λ S      T = D : sym(FᵀΛ)      P = F S
//! Z = sym[(P : Λ) I − FᵀY − ΛᵀP]
//!
//! A law with axes takes q₁ along the part a of a direction d in the facet, at each quadrature point. To what is above
//! comes the turn of these axes against those that are carried along. With n = q₁ × q₂, |p| = d · q₁ and L by the turn ω
//! of the axes in the plane,
//!
//! δω = [(n · H e₂)(n · d) + q₂ · δd]/|p| − ½ (q₂ · H e₁ − q₁ · H e₂)      ∂L/∂ω = τ(FᵀΛ) · S + T · τ(E)
//!
//! τ(E) = [2 E₁₂, −2 E₁₂, 2 (E₂₂ − E₁₁)], and δd by the rest position as [`Direction`] has it.
//!
//! Its parameters are t, then those of the law, and last the angle α [rad] if the direction has one.
//!
//! Source: Gruttmann and Taylor 1992, "Theory and finite element formulation of rubberlike
//! membrane shells using principal stretches", doi:10.1002/nme.1620350511.

use std::sync::Arc;

use mesh::Vec3;
use nalgebra::{Matrix2, Matrix3x2, SMatrix, Vector2};

use super::{Direction, Energy, Hessian, Iterate, Nature, Owner, Slot};
use crate::element::{FunctionSpace, add_at, at};
use crate::material::sheet::{self, Sheet, State, Strain, Stress};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat3, project_positive};
use crate::parallel::map_each;

#[cfg(test)]
pub(super) mod tests;

/// Nodes of a facet, at most.
const MOST_NODES: usize = 10;

/// ∂(F S)/∂F; row and column index are 3 α + i for the component (i, α).
type Tangent = SMatrix<f64, 6, 6>;

/// A sheet on some facets.
#[derive(Clone)]
pub struct Membrane {
    /// Thickness at rest [m].
    pub thickness: f64,
    /// The law.
    pub sheet: Arc<dyn Sheet>,
    facets: Vec<Facet>,
    /// Along the first axis of the law, where that has axes.
    direction: Option<Direction>,
}

/// A facet of the sheet as vertices and nodes.
#[derive(Clone)]
struct Facet {
    vertices: [usize; 3],
    nodes: Vec<usize>,
}

/// A flat facet at rest.
#[derive(Clone, Copy)]
struct Rest {
    /// q₁ and q₂.
    basis: Matrix3x2<f64>,
    /// Maps gradients by reference coordinates to gradients by s [1/m].
    to_rest: Matrix2<f64>,
    /// [m²]
    area: f64,
}

/// One quadrature point.
struct Point<'a> {
    rest: Rest,
    /// Barycentric coordinates and rest position [m].
    place: (&'a [f64], Vec3),
    /// t times the share of the area [m³].
    volume: f64,
    /// b_a of all nodes [1/m].
    gradients: [Vector2<f64>; MOST_NODES],
    /// F.
    f: Matrix3x2<f64>,
    /// E.
    strain: Strain,
}

/// Measures of a sheet.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct MembraneSummary {
    /// Rest area [m²].
    pub area: f64,
    /// W [J].
    pub energy: f64,
    /// Smallest and largest principal stretch.
    pub stretch: [f64; 2],
    /// Largest principal force per width, pulled back to the rest sheet: t S₁ [N/m].
    pub tension: f64,
    /// Share of the area in tension along both principal directions.
    pub taut: f64,
    /// Share that is compressed across its largest strain.
    pub wrinkled: f64,
    /// Share where nothing is stretched.
    pub slack: f64,
}

impl Rest {
    fn new(facet: [usize; 3], x: &[Vec3]) -> Self {
        let [a, b, c] = facet.map(|v| x[v]);
        let (g1, g2) = (b - a, c - a);
        let long = g1.norm();
        let q1 = g1 / long;
        let along = q1.dot(&g2);
        let across = g2 - along * q1;
        let high = across.norm();
        Self {
            basis: Matrix3x2::from_columns(&[q1, across / high]),
            // R⁻ᵀ of [g₁, g₂] = Q R
            to_rest: Matrix2::new(1.0 / long, 0.0, -along / (long * high), 1.0 / high),
            area: 0.5 * long * high,
        }
    }

    /// This rest facet in another basis: its first vector is the direction, projected on the facet.
    fn along(&self, direction: Vec3) -> Self {
        let part = (self.basis.transpose() * direction).normalize();
        let turn = Matrix2::new(part.x, -part.y, part.y, part.x);
        Self { basis: self.basis * turn, to_rest: turn.transpose() * self.to_rest, ..*self }
    }

    /// Gradients of the three barycentric coordinates [1/m].
    fn corners(&self) -> [Vector2<f64>; 3] {
        let (b, c) = (self.to_rest.column(0).into_owned(), self.to_rest.column(1).into_owned());
        [-(b + c), b, c]
    }
}

/// [A₁₁, A₂₂, A₁₂ + A₂₁].
fn strain_like(a: &Matrix2<f64>) -> Strain {
    Strain::new(a[(0, 0)], a[(1, 1)], a[(0, 1)] + a[(1, 0)])
}

/// The symmetric matrix of [S₁₁, S₂₂, S₁₂].
fn matrix(s: &Stress) -> Matrix2<f64> {
    Matrix2::new(s[0], s[2], s[2], s[1])
}

/// τ(E): the derivative of components by a turn of the axes.
fn turned(e: &Strain) -> Strain {
    Strain::new(e[2], -e[2], 2.0 * (e[1] - e[0]))
}

/// How axes turn against those that are carried along with a facet.
struct Turn {
    /// By H.
    by_gradient: Matrix3x2<f64>,
    /// By δd [1].
    by_direction: Vec3,
}

impl Point<'_> {
    /// δω where the first axis is along the part of a direction.
    fn turn(&self, direction: Vec3) -> Turn {
        let [q1, q2] = [0, 1].map(|k| self.rest.basis.column(k).into_owned());
        let (normal, part) = (q1.cross(&q2), direction.dot(&q1));
        let tilt = normal.dot(&direction) / part * normal;
        let by_gradient = Matrix3x2::from_columns(&[-0.5 * q2, tilt + 0.5 * q1]);
        Turn { by_gradient, by_direction: q2 / part }
    }

    /// ∂L/∂ω.
    fn by_turn(&self, law: &dyn Sheet, l: &Matrix3x2<f64>) -> f64 {
        let bar = strain_like(&(self.f.transpose() * l));
        let (s, t) = (law.stress(&self.strain), law.tangent(&self.strain) * bar);
        self.volume * (turned(&bar).dot(&s) + t.dot(&turned(&self.strain)))
    }

    /// ∂w/∂s of a nodal field.
    fn gradient_of(&self, nodes: &[usize], field: &[f64]) -> Matrix3x2<f64> {
        field_gradient(nodes, &self.gradients, field)
    }

    fn stress(&self, law: &dyn Sheet) -> Matrix2<f64> {
        matrix(&law.stress(&self.strain))
    }

    /// ∂(F S)/∂F, but for the volume; none where it vanishes.
    fn tangent(&self, law: &dyn Sheet) -> Option<Tangent> {
        let (s, d) = (self.stress(law), law.tangent(&self.strain));
        if s.amax() == 0.0 && d.amax() == 0.0 {
            return None;
        }
        // δE by δF
        let mut by = SMatrix::<f64, 3, 6>::zeros();
        for i in 0..3 {
            (by[(0, i)], by[(1, 3 + i)]) = (self.f[(i, 0)], self.f[(i, 1)]);
            (by[(2, i)], by[(2, 3 + i)]) = (self.f[(i, 1)], self.f[(i, 0)]);
        }
        Some(by.transpose() * d * by + s.kronecker(&Mat3::identity()))
    }
}

fn field_gradient(nodes: &[usize], by: &[Vector2<f64>], field: &[f64]) -> Matrix3x2<f64> {
    nodes.iter().zip(by).map(|(&node, b)| at(field, node) * b.transpose()).sum()
}

/// Calls `f` with each quadrature point of a facet of a sheet.
fn points(sheet: &Membrane, facet: &Facet, iterate: &Iterate, mut f: impl FnMut(&Point)) {
    let table = iterate.space.facet_table();
    let flat = Rest::new(facet.vertices, iterate.rest);
    let rules = table.gradients.iter().zip(&table.weights).zip(&table.points);
    for ((reference, weight), lambda) in rules {
        let corners = facet.vertices.iter().zip(lambda);
        let x = corners.map(|(&v, l)| *l * iterate.rest[v]).sum();
        let rest = sheet.direction.map_or(flat, |direction| flat.along(direction.at(x)));
        let mut gradients = [Vector2::zeros(); MOST_NODES];
        for (b, [d1, d2, _]) in gradients.iter_mut().zip(reference) {
            *b = rest.to_rest * Vector2::new(*d1, *d2);
        }
        let h = field_gradient(&facet.nodes, &gradients, iterate.u);
        let strain = strain_like(&(rest.basis.transpose() * h + 0.5 * h.transpose() * h));
        let (volume, f_here) = (sheet.thickness * weight * rest.area, rest.basis + h);
        f(&Point { rest, place: (lambda, x), volume, gradients, f: f_here, strain });
    }
}

impl Membrane {
    /// Who owns the numbers of a sheet, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("membrane", place)
    }

    /// A sheet of a thickness [m] on facets of the mesh (vertex ids in any order).
    ///
    /// # Panics
    /// When one is no facet of the mesh and the degree is above 1.
    pub fn new(
        space: &FunctionSpace,
        facets: &[[usize; 3]],
        thickness: f64,
        sheet: Box<dyn Sheet>,
    ) -> Self {
        let facet = |&vertices: &[usize; 3]| Facet { vertices, nodes: space.facet_nodes(vertices) };
        let facets = facets.iter().map(facet).collect();
        Self { thickness, sheet: sheet.into(), facets, direction: None }
    }

    /// This membrane with an orthotropic law: its first axis is the direction, projected on the sheet.
    pub fn along(self, direction: Direction) -> Self {
        Self { direction: Some(direction), ..self }
    }

    /// Calls `of_point` with each facet's nodes and points, in parallel, which changes a value
    /// that begins as `T::default()`, and `merge` with each facet and its value, in their order.
    fn for_each_facet<T: Default + Send>(
        &self,
        iterate: &Iterate,
        of_point: impl Fn(&[usize], &Point, &mut T) + Sync,
        merge: impl FnMut(&Facet, T),
    ) {
        let one = |facet: &Facet| {
            let mut value = T::default();
            points(self, facet, iterate, |p| of_point(&facet.nodes, p, &mut value));
            value
        };
        map_each(&self.facets, one, merge);
    }

    /// Measures of the sheet at a state.
    pub fn summary(&self, iterate: &Iterate) -> MembraneSummary {
        let mut all = MembraneSummary { stretch: [f64::INFINITY, 0.0], ..Default::default() };
        let mut volumes = [0.0; 3];
        for facet in &self.facets {
            points(self, facet, iterate, |p| {
                let [first, second] = sheet::principal(&p.strain);
                let stretch = |e: f64| (1.0 + 2.0 * e).max(0.0).sqrt();
                all.stretch[0] = all.stretch[0].min(stretch(second));
                all.stretch[1] = all.stretch[1].max(stretch(first));
                let s = self.sheet.stress(&p.strain);
                let largest = 0.5 * (s[0] + s[1] + (s[0] - s[1]).hypot(2.0 * s[2]));
                all.tension = all.tension.max(self.thickness * largest);
                all.energy += p.volume * self.sheet.energy_density(&p.strain);
                volumes[self.sheet.state(&p.strain) as usize] += p.volume;
            });
        }
        let sum: f64 = volumes.iter().sum();
        let [taut, wrinkled, slack] =
            [State::Taut, State::Wrinkled, State::Slack].map(|s| volumes[s as usize] / sum);
        MembraneSummary { area: sum / self.thickness, taut, wrinkled, slack, ..all }
    }
}

impl Energy for Membrane {
    fn kind(&self) -> (&'static str, Nature) {
        ("membrane", Nature::Elastic)
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        let mut sum = 0.0;
        self.for_each_facet(
            iterate,
            |_, p, value: &mut f64| *value += p.volume * self.sheet.energy_density(&p.strain),
            |_, part| sum += part,
        );
        if sum.is_finite() { sum } else { f64::INFINITY }
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        self.for_each_facet(
            iterate,
            |nodes, p, forces: &mut [Vec3; MOST_NODES]| {
                let stress = p.volume * p.f * p.stress(&*self.sheet);
                let pairs = forces.iter_mut().zip(&p.gradients).take(nodes.len());
                pairs.for_each(|(force, b)| *force += stress * b);
            },
            |facet, forces| {
                facet.nodes.iter().zip(&forces).for_each(|(&node, f)| add_at(out, node, f));
            },
        );
    }

    fn add_hessian(&self, iterate: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        self.for_each_facet(
            iterate,
            |nodes, p, blocks: &mut Vec<Mat3>| {
                blocks.resize(nodes.len() * nodes.len(), Mat3::zeros());
                let Some(mut tangent) = p.tangent(&*self.sheet) else { return };
                if kind == Hessian::Projected {
                    tangent = project_positive(&tangent);
                }
                tangent *= p.volume;
                let part =
                    |i: usize, j: usize| tangent.fixed_view::<3, 3>(3 * i, 3 * j).into_owned();
                let [[t11, t12], [t21, t22]] = [[part(0, 0), part(0, 1)], [part(1, 0), part(1, 1)]];
                for (a, blocks) in p.gradients.iter().zip(blocks.chunks_exact_mut(nodes.len())) {
                    let (first, second) = (a.x * t11 + a.y * t21, a.x * t12 + a.y * t22);
                    for (b, block) in p.gradients.iter().zip(blocks) {
                        *block += first * b.x + second * b.y;
                    }
                }
            },
            |facet, blocks| out.add_dense(&facet.nodes, &blocks),
        );
    }

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        self.for_each_facet(
            iterate,
            |nodes, p, forces: &mut [Vec3; 3]| {
                let l = p.gradient_of(nodes, lambda);
                let bar = strain_like(&(p.f.transpose() * l));
                let s = p.stress(&*self.sheet);
                let t = matrix(&(self.sheet.tangent(&p.strain) * bar));
                let (y, first) = (p.f * t + l * s, p.f * s);
                let z = Matrix2::from_diagonal_element(first.dot(&l))
                    - p.f.transpose() * y
                    - l.transpose() * first;
                let mut by = p.volume * (y + p.rest.basis * (0.5 * (z + z.transpose())));
                if let Some(direction) = self.direction {
                    let (lambda, x) = p.place;
                    let turn = p.turn(direction.at(x));
                    let by_turn = p.by_turn(&*self.sheet, &l);
                    by += by_turn * turn.by_gradient;
                    let by_place = by_turn * direction.gradient(x).transpose() * turn.by_direction;
                    forces.iter_mut().zip(lambda).for_each(|(force, l)| *force += *l * by_place);
                }
                forces.iter_mut().zip(p.rest.corners()).for_each(|(force, c)| *force += by * c);
            },
            |facet, forces| {
                facet.vertices.iter().zip(&forces).for_each(|(&v, force)| add_at(out, v, force));
            },
        );
    }

    fn slots(&self) -> Vec<Slot> {
        let law = self.sheet.parameters().iter().map(|own| Slot::new(own.name, own.unit));
        let angle = self.direction.map(|_| Slot::new("angle", "rad"));
        [Slot::new("thickness", "m")].into_iter().chain(law).chain(angle).collect()
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let count = 1 + self.sheet.parameters().len();
        let angles = usize::from(self.direction.is_some());
        let mut sum = vec![0.0; count + angles];
        self.for_each_facet(
            iterate,
            |nodes, p, by: &mut Vec<f64>| {
                by.resize(count + angles, 0.0);
                let l = p.gradient_of(nodes, lambda);
                let bar = p.volume * strain_like(&(p.f.transpose() * l));
                by[0] += self.sheet.stress(&p.strain).dot(&bar) / self.thickness;
                self.sheet.add_parameter_vjp(&p.strain, &bar, &mut by[1..count]);
                if let Some(direction) = self.direction {
                    let turn = p.turn(direction.at(p.place.1)).by_direction;
                    by[count] +=
                        p.by_turn(&*self.sheet, &l) * turn.dot(&direction.by_angle(p.place.1));
                }
            },
            |_, part| sum.iter_mut().zip(&part).for_each(|(s, p)| *s += p),
        );
        sum
    }
}
