//! `windings.csv`: the threads of a state, a row for each segment of each, in the order of the thread.

use csv::ReaderBuilder;

/// The file beside a report.
pub const WINDINGS: &str = "windings.csv";

/// A segment of a thread, straight within a facet or a tetrahedron.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What the scene calls the thread.
    pub winding: String,
    /// Its start and its end.
    pub ends: [SegmentEnd; 2],
    /// Mean force along it [N].
    pub force: f64,
    /// Vertices of the tetrahedron that it is in, or of the facet, which has the third one twice.
    pub vertices: [usize; 4],
}

/// An end of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentEnd {
    /// Where it is at rest [m].
    pub rest: [f64; 3],
    /// Where it is now [m].
    pub now: [f64; 3],
    /// Its barycentric coordinates at rest, by the vertices; 0 where a facet has one again [1].
    pub weights: [f64; 4],
}

/// A row as it is read.
type Row = (String, [[f64; 3]; 4], f64, [usize; 4], [[f64; 4]; 2]);

impl Segment {
    /// The names of the columns.
    pub fn head() -> Vec<String> {
        let ends = ["start", "end"];
        let places = ends.iter().flat_map(|end| {
            ["at rest", "now"].into_iter().flat_map(move |when| {
                ["x", "y", "z"].map(|axis| format!("{end} {when} {axis} [m]"))
            })
        });
        let vertices = (1..=4).map(|k| format!("vertex {k}"));
        let weights = ends.iter().flat_map(|end| (1..=4).map(move |k| format!("{end} weight {k}")));
        let head = ["winding".to_owned()].into_iter().chain(places).chain(["force [N]".to_owned()]);
        head.chain(vertices).chain(weights).collect()
    }

    /// The cells of its row.
    pub fn row(&self) -> Vec<String> {
        let places = self.ends.iter().flat_map(|end| [end.rest, end.now]).flatten();
        let numbers = places.chain([self.force]).map(|number| number.to_string());
        let vertices = self.vertices.iter().map(|vertex| vertex.to_string());
        let weights = self.ends.iter().flat_map(|end| end.weights).map(|weight| weight.to_string());
        [self.winding.clone()].into_iter().chain(numbers).chain(vertices).chain(weights).collect()
    }

    /// All segments of a file.
    ///
    /// # Errors
    /// If it is not one that `solver simulate` has written.
    pub fn all(text: &str) -> Result<Vec<Self>, String> {
        let mut reader = ReaderBuilder::new().from_reader(text.as_bytes());
        if reader.headers().is_ok_and(|head| head.iter().ne(Self::head().iter())) {
            return Err("its columns are not those that `solver simulate` writes".into());
        }
        let read = |(i, row): (usize, Result<Row, csv::Error>)| {
            let found = row.ok().map(Self::of).filter(Self::is_finite);
            found.ok_or_else(|| format!("line {} is not a name and finite numbers", i + 2))
        };
        reader.deserialize().enumerate().map(read).collect()
    }

    fn of((winding, [a, b, c, d], force, vertices, [start, end]): Row) -> Self {
        let ends = [
            SegmentEnd { rest: a, now: b, weights: start },
            SegmentEnd { rest: c, now: d, weights: end },
        ];
        Self { winding: winding.trim_start().to_owned(), ends, force, vertices }
    }

    fn is_finite(&self) -> bool {
        let all = |end: &SegmentEnd| {
            let mut numbers = end.rest.iter().chain(&end.now).chain(&end.weights);
            numbers.all(|number| number.is_finite())
        };
        self.force.is_finite() && self.ends.iter().all(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let end = |x: f64| SegmentEnd {
            rest: [x, 0.1 + 0.2, 0.0],
            now: [x, -1e-300, 2.5],
            weights: [0.3, 0.7, 0.0, 0.0],
        };
        let segment = Segment {
            winding: "u, \"v\"".into(),
            ends: [end(0.0), end(1.0)],
            force: 0.5,
            vertices: [4, 7, 9, 9],
        };
        let table = |rows: &[Vec<String>]| {
            let mut table = csv::Writer::from_writer(Vec::new());
            rows.iter().for_each(|row| table.write_record(row).expect("in memory"));
            String::from_utf8(table.into_inner().expect("in memory")).expect("text")
        };
        let text = table(&[Segment::head(), segment.row()]);
        assert_eq!(Segment::all(&text), Ok(vec![segment.clone()]));
        let mut row = segment.row();
        row[3] = "nan".into();
        let said = Segment::all(&table(&[Segment::head(), segment.row(), row]));
        assert_eq!(said, Err("line 3 is not a name and finite numbers".into()));
        let said = Segment::all("winding,force [N]\na,1\n").expect_err("other columns");
        assert!(said.contains("its columns are not"), "{said}");
    }
}
