use super::*;
use crate::math::random::Random;

/// Triangles of different sizes, some with common vertices, and a motion.
fn cloud(seed: u64, length: f64) -> (Features, [Vec<Vec3>; 2]) {
    let mut random = Random::new(seed);
    let facets: Vec<[usize; 3]> = (0..60).map(|t| [2 * t, 2 * t + 1, 2 * t + 2]).collect();
    let x0: Vec<Vec3> =
        (0..121).map(|i| 2.0 * random.vector() * if i % 40 == 7 { 3.0 } else { 1.0 }).collect();
    let drift = random.vector();
    let x1 = x0.iter().map(|x| x + length * (drift + 0.2 * random.vector())).collect();
    (Features::new(&facets), [x0, x1])
}

/// Every pair of features without a common vertex.
fn all_pairs(features: &Features) -> Vec<Pair> {
    let Features { vertices, edges, triangles } = features;
    let corners = |t: &[usize]| -> [usize; 4] { t.try_into().expect("four corners") };
    let point_triangle = vertices.iter().flat_map(|&p| {
        triangles.iter().map(move |t| Pair::PointTriangle(corners(&[&[p], &t[..]].concat())))
    });
    let edge_edge = edges.iter().enumerate().flat_map(|(i, a)| {
        let later = edges.iter().skip(i + 1);
        later.map(move |b| Pair::EdgeEdge(corners(&[&a[..], &b[..]].concat())))
    });
    let apart = |pair: &Pair| {
        let mut corners = pair.corners();
        corners.sort_unstable();
        corners.windows(2).all(|w| w[0] != w[1])
    };
    point_triangle.chain(edge_edge).filter(apart).collect()
}

#[test]
fn without_motion_candidates_are_the_close_pairs() {
    let (features, [x, _]) = cloud(1, 0.0);
    for radius in [0.05, 0.3, 100.0] {
        let close = |p: &Pair| p.closest(&p.gather(&x)).d2 < radius * radius;
        let expected: Vec<Pair> = all_pairs(&features).into_iter().filter(close).collect();
        assert!(expected.len() > 20, "{}", expected.len());
        let found = between(&features, &x, &x, radius, &|_| false);
        assert_eq!(found, Ok(expected), "in this order");
    }
    // all in one place, and none
    let place = vec![Vec3::zeros(); x.len()];
    assert_eq!(between(&features, &place, &place, 0.1, &|_| false), Ok(all_pairs(&features)));
    assert_eq!(between(&Features::new(&[]), &[], &[], 0.1, &|_| false), Ok(Vec::new()));
}

/// Sampling in time finds no pair that is not among the candidates, and the
/// candidates are not simply all pairs.
#[test]
fn nothing_that_comes_close_on_the_way_is_missed() {
    for (seed, length) in [(2, 0.1), (3, 1.0), (4, 30.0)] {
        let (features, [x0, x1]) = cloud(seed, length);
        let radius = 0.05;
        let found = between(&features, &x0, &x1, radius, &|_| false).expect("few");
        let mut missed = all_pairs(&features);
        let all = missed.len();
        missed.retain(|p| !found.contains(p));
        assert_eq!(missed.len() + found.len(), all);
        assert!(length > 1.0 || found.len() < all / 2, "{} of {all}", found.len());
        for step in 0..=50 {
            let t = f64::from(step) / 50.0;
            let x: Vec<Vec3> = x0.iter().zip(&x1).map(|(a, b)| a + t * (b - a)).collect();
            for pair in &missed {
                assert!(pair.closest(&pair.gather(&x)).d2 >= radius * radius, "{pair:?} {t}");
            }
        }
    }
}

#[test]
fn what_moves_together_is_no_candidate() {
    let (features, [x0, _]) = cloud(5, 0.0);
    let x1: Vec<Vec3> = x0.iter().map(|x| x + Vec3::new(20.0, 20.0, 20.0)).collect();
    let still = between(&features, &x0, &x0, 0.1, &|_| false);
    let moving = between(&features, &x0, &x1, 0.1, &|_| false);
    assert_eq!(still, moving);
}

#[test]
fn skipped_pairs_are_left_out_and_threads_change_nothing() {
    let (features, [x0, x1]) = cloud(6, 0.3);
    let skip = |corners: [usize; 4]| corners.iter().all(|&v| v < 60);
    let run = || between(&features, &x0, &x1, 0.1, &skip).expect("few");
    let mut expected = between(&features, &x0, &x1, 0.1, &|_| false).expect("few");
    let all = expected.len();
    expected.retain(|p| !skip(p.corners()));
    assert!(expected.len() < all);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        assert_eq!(pool.expect("a thread pool").install(run), expected);
    }
}

#[test]
fn a_step_that_is_too_long_is_refused() {
    let (features, [x0, x1]) = cloud(7, 100.0);
    let all = all_pairs(&features).len();
    let run = |budget| between_within(budget, &features, &x0, &x1, 1e3, &|_| false);
    assert_eq!(run(all).map(|pairs| pairs.len()), Ok(all));
    for budget in [0, 10, all - 1] {
        assert_eq!(run(budget), Err(TooMany { budget }));
    }
}

#[test]
fn close_pairs_are_those_of_brute_force() {
    let mut random = Random::new(5);
    let x: Vec<Vec3> = (0..90).map(|_| random.vector()).collect();
    let facets: Vec<[usize; 3]> = (0..30).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let (a, b) = (Features::new(&facets[..12]), Features::new(&facets[12..]));
    let all = Features::new(&facets);
    let radius = 0.3;
    let close = |p: &Pair| p.closest(&p.gather(&x)).d2 < radius * radius;
    let mut expected = all_pairs(&all);
    expected.retain(close);
    assert_eq!(close_within(&all, &x, radius), expected);
    let of_a = |v: &usize| *v < 36;
    let separate = |p: &Pair| {
        let corners = p.corners();
        let (first, second) = corners.split_at(p.corners_of_first());
        of_a(&first[0]) != of_a(&second[0])
    };
    expected.retain(separate);
    assert!(expected.len() > 100);
    let mut found = close_between(&a, &b, &x, radius);
    found.sort_unstable();
    assert_eq!(found, expected);
}
