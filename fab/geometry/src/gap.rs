//! Positions of planes that keep away from vertices.
//!
//! A plane that passes within rounding of a vertex cuts slivers off the edges there, which cross
//! when they are rounded again.

/// Least distance of a plane from vertices: a hundred times what 32-bit files resolve at
/// 200 mm, and much less than a printer does [m].
const CLEAR: f64 = 1e-6;

/// How far a plane is moved for it, at most, as a part of the extent of the vertices.
const NEAR: f64 = 5e-3;

/// The position nearest to `wanted` that keeps 1 μm from all heights, or the middle of the widest gap
/// between them if there is none within 0.5 % of their extent.
pub fn clear(heights: impl Iterator<Item = f64>, wanted: f64) -> f64 {
    let mut heights: Vec<f64> = heights.collect();
    heights.sort_by(f64::total_cmp);
    let [Some(low), Some(high)] = [heights.first(), heights.last()] else { return wanted };
    let reach = NEAR * (high - low);
    let [from, to] = [wanted - reach, wanted + reach];
    let within = heights.into_iter().filter(|h| (from..=to).contains(h));
    let ends: Vec<f64> = [from].into_iter().chain(within).chain([to]).collect();
    let gaps = || ends.windows(2).map(|pair| (pair[0], pair[1]));
    let nearest = |(low, high): (f64, f64)| wanted.clamp(low + CLEAR, high - CLEAR);
    let free = gaps().filter(|(low, high)| high - low > 2.0 * CLEAR).map(nearest);
    let off = |at: &f64| (at - wanted).abs();
    let widest = gaps().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let middle = widest.map_or(wanted, |(low, high)| (low + high) / 2.0);
    free.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(middle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_moves_no_further_than_needed() {
        let heights = || [0.0, 0.05, 0.05 + 5e-7, 0.1].into_iter();
        assert_eq!(clear(heights(), 0.03), 0.03);
        assert!((clear(heights(), 0.05) - (0.05 - CLEAR)).abs() < 1e-15);
        assert!((clear(heights(), 0.05 + 4e-7) - (0.05 + 5e-7 + CLEAR)).abs() < 1e-15);
        assert_eq!(clear(std::iter::empty(), 0.05), 0.05);
    }

    #[test]
    fn among_crowded_vertices_the_widest_gap_is_taken() {
        let crowded = (0..=200_000).map(|k| f64::from(k) * 5e-7);
        // One vertex is left out.
        let heights = crowded.filter(|h| (h - 0.0502).abs() > 1e-7);
        assert!((clear(heights, 0.05) - 0.0502).abs() < 1e-12);
    }
}
