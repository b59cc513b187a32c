//! Terms of a part against those of the whole.

use mechanics::contact::density::{Density, Repulsion};
use mechanics::element::at;
use mechanics::symmetry::Plane;
use mechanics::testing::{half, whole};

use crate::kinds::clearance;
use crate::kinds::contact_proxy::ContactProxy;
use crate::kinds::wall_thickness::Barrier;
use crate::quantity::tests::Case;
use crate::quantity::{ClosePairs, Measure, Quantity};

const RANGE: f64 = 0.15;

/// A term of a case whose first vertices are those of the part, with the planes that cut it.
type Make = dyn Fn(&Case, &[Plane]) -> Box<dyn Quantity>;

fn terms() -> Vec<Box<Make>> {
    let limits = Repulsion { density: Density::Log, minimum: 0.01, activation: RANGE };
    let wall = move |measure| -> Box<Make> {
        Box::new(move |case, planes| {
            let close = ClosePairs::between(planes, &sides(case)).expect("sides are apart");
            Box::new(Barrier { close, limits, measure })
        })
    };
    let open = |case: &Case| case.facets_where(|x| x.x != 0.0);
    vec![
        wall(Measure::Rest),
        wall(Measure::Deformed),
        Box::new(move |case, planes| {
            Box::new(clearance::barrier(ClosePairs::within(planes, &open(case)), RANGE))
        }),
        Box::new(|case, planes| {
            let limits = Repulsion { density: Density::Log, minimum: 0.0, activation: RANGE };
            let term = ContactProxy::new(planes, &case.space, &sides(case), limits);
            Box::new(term.expect("sides are apart"))
        }),
    ]
}

/// The top of the block that is cut, and all of the other one.
fn sides(case: &Case) -> [Vec<[usize; 3]>; 2] {
    [case.facets_where(|x| (x.y - 1.0).abs() < 1e-9), case.facets_where(|x| x.y > 1.0 + 1e-9)]
}

/// The part, and the whole at the same state.
fn cases() -> (Case, Case, Plane) {
    let (part, plane) = half();
    let (mut own, mut all) = (Case::of(&part, 1, 1.0), Case::of(&whole(&part), 1, 1.0));
    let count = own.rest.len();
    own.u.iter_mut().for_each(|u| *u *= 0.1);
    let off: Vec<usize> = (0..count).filter(|&v| own.rest[v].x != 0.0).collect();
    (0..count).filter(|v| !off.contains(v)).for_each(|v| own.u[3 * v] = 0.0);
    all.u[..3 * count].copy_from_slice(&own.u);
    for (image, v) in (count..).zip(off) {
        let u = at(&own.u, v);
        all.u[3 * image..3 * image + 3].copy_from_slice(&[-u.x, u.y, u.z]);
    }
    (own, all, plane)
}

#[test]
fn a_part_has_its_share_of_the_value_and_the_derivatives() {
    let (own, all, plane) = cases();
    for (i, make) in terms().iter().enumerate() {
        let (half, whole) = (make(&own, std::slice::from_ref(&plane)), make(&all, &[]));
        let (value, expected) = (half.value(&own.at()), whole.value(&all.at()));
        assert!(expected > 0.0 && (2.0 * value / expected - 1.0).abs() < 1e-11);
        let gradient = |term: &dyn Quantity, case: &Case| {
            let by = case.partials(term, 1.0);
            [by.u, by.rest]
        };
        for (by, expected) in gradient(&*half, &own).iter().zip(gradient(&*whole, &all)) {
            let largest = expected.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
            for (v, x) in own.rest.iter().enumerate() {
                // in the plane the image has the other half, and nothing points across
                let share = if x.x == 0.0 { 0.5 } else { 1.0 };
                let apart = (at(by, v) - share * at(&expected, v)).norm();
                assert!(apart <= 1e-10 * largest, "{i} {v} {apart:e} {largest:e}");
            }
        }
        // without the image less is close
        assert!(make(&own, &[]).value(&own.at()) < 0.99 * value, "{i}");
    }
}

#[test]
fn facets_in_a_plane_count_once() {
    let (own, _, plane) = cases();
    let limits = Repulsion { density: Density::Quadratic, minimum: 0.0, activation: 0.3 };
    let parts = [own.facets_where(|x| x.y > 1.0 + 1e-9), own.facets_where(|x| x.x == 0.0)];
    let value = |planes: &[Plane]| {
        let close = ClosePairs::between(planes, &parts).expect("apart");
        Barrier { close, limits, measure: Measure::Rest }.value(&own.at())
    };
    let (with, without) = (value(std::slice::from_ref(&plane)), value(&[]));
    assert!(without > 0.0 && (with / without - 1.0).abs() < 1e-12, "{with} {without}");
}
