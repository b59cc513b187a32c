//! The body-centred cubic lattice around the surface of a body, as tetrahedra.
//!
//! Cubes are halved in all directions as long as bounds of the functions leave a surface possible in
//! them, down to the grid. The lattice therefore misses no surface, however thin what it bounds, and
//! costs what the surface is large. Each face between two cubes has four tetrahedra: from its edges to
//! both centres.

use std::collections::HashMap;

use anyhow::{Result, ensure};
use mesh::Vec3;
use rayon::prelude::*;

use super::complex::{Complex, is_positive};
use super::model::Bounds;
use super::sides::{Side, Sides};

/// Most cells in a row, for which 32 bits still hold coordinates to a hundredth of a cell.
const MOST: i64 = 1 << 17;

/// A cube by its lower corner, in cells of the grid.
type Cube = [i64; 3];

/// The tetrahedra that the surface of a body may meet.
pub fn lattice(sides: &Sides, within: Bounds) -> Result<Complex> {
    let cells = ((within.1 - within.0).max() / sides.grid).ceil() as i64 + 1;
    ensure!(
        cells <= MOST,
        "the body is {cells} cells of the grid long; files hold coordinates of at most {MOST}: choose \
         a coarser grid"
    );
    let (middle, size) = ((within.0 + within.1) / 2.0, (cells as u64).next_power_of_two() as i64);
    let corner = [-size / 2; 3];
    let all: Vec<&Side> = sides.list.iter().collect();
    let cubes = near_surface(&Search { middle, grid: sides.grid }, corner, size, &all);
    let mut faces: Vec<(Cube, usize)> = cubes
        .iter()
        .flat_map(|&cube| (0..3).flat_map(move |k| [(cube, k), (beside(cube, k, -1), k)]))
        .collect();
    faces.par_sort_unstable();
    faces.dedup();
    let mut complex = tetrahedra(sides, &middle, &faces);
    let flat = complex.tets.iter().find(|&&tet| !is_positive(&complex.vertices, tet));
    ensure!(flat.is_none(), "a grid of {} is too fine for 32-bit coordinates", sides.grid);
    complex.mark_rim();
    Ok(complex)
}

fn beside(mut cube: Cube, axis: usize, by: i64) -> Cube {
    cube[axis] += by;
    cube
}

/// Where the lattice is [unit].
struct Search {
    middle: Vec3,
    grid: f64,
}

/// The cubes of the grid in a cube of `size` in which a surface is possible: one of the body's sides is
/// zero there, and none shuts it out. `sides` are those that are not negative all over.
fn near_surface(search: &Search, cube: Cube, size: i64, sides: &[&Side]) -> Vec<Cube> {
    let half = size as f64 / 2.0;
    let center = search.middle + Vec3::from(cube.map(|x| x as f64 + half)) * search.grid;
    // Its circumscribed ball, and room for rounding.
    let radius = half * search.grid * 3.0_f64.sqrt() * (1.0 + 1e-6);
    let mut near = Vec::new();
    for &side in sides {
        let (low, high) = side.range(&center, radius);
        if low > 0.0 {
            return Vec::new();
        }
        if high >= 0.0 {
            near.push(side);
        }
    }
    if near.is_empty() || size == 1 {
        return if near.is_empty() { Vec::new() } else { vec![cube] };
    }
    let child = |k: i64| {
        let corner = [0, 1, 2].map(|axis| cube[axis] + (k >> axis & 1) * size / 2);
        near_surface(search, corner, size / 2, &near)
    };
    if size > 8 {
        (0..8).into_par_iter().flat_map_iter(child).collect()
    } else {
        (0..8).flat_map(child).collect()
    }
}

/// The tetrahedra at faces, each by the cube on its lower side and its axis.
fn tetrahedra(sides: &Sides, middle: &Vec3, faces: &[(Cube, usize)]) -> Complex {
    let mut complex = Complex::default();
    let mut known = HashMap::new();
    // Points of the lattice in halves of a cell: corners are even, centres odd.
    let mut vertex = |at: Cube| {
        *known.entry(at).or_insert_with(|| {
            let p = middle + Vec3::from(at.map(|x| x as f64 / 2.0)) * sides.grid;
            complex.vertices.push(sides.settle(&(p * sides.metres), 0));
            (complex.vertices.len() - 1) as u32
        })
    };
    for &(cube, axis) in faces {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let center = cube.map(|x| 2 * x + 1);
        let [below, above] = [vertex(center), vertex(beside(center, axis, 2))];
        let corner = |k: i64, l: i64| beside(beside(beside(center, axis, 1), u, k), v, l);
        let ring = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)].map(&mut vertex);
        for k in 0..4 {
            complex.tets.push([ring[k], ring[(k + 1) % 4], below, above]);
        }
    }
    complex.on = vec![0; complex.vertices.len()];
    complex
}
