//! The faces of a body: the patches of a folder that `cad2fem model` or `cad2fem import` wrote.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;
use std::path::{Component, Path};

use anyhow::{Context as _, Result, bail, ensure};
use mesh::io::read_surface;
use mesh::topology::edge_facets;
use mesh::{SurfaceMesh, Vec3, triangle_key};
use serde_json::{Value, json};

use super::MM;
use crate::reported::{Model, Region};
use crate::store::Store;

/// Faces of triangles meet smoothly if these enclose less on average [deg]: half of the angle at
/// which `cad2fem import --split 40` parts them.
const SMOOTH: f64 = 20.0;

/// A face is flat if the mean of its normals is as long.
const FLAT_FACE_NORMAL: f64 = 0.9999;

/// A face, which can be chosen as a whole.
#[derive(Clone, Debug)]
pub struct Face {
    /// Name of its region.
    pub name: String,
    /// Name of the file in `patches`. Triangles without a region have no file.
    pub file: Option<String>,
    /// What it is: `plane`, `cylinder`, … as CAD says, else `plane` or `curved`.
    pub kind: String,
    /// Whether it lies inside the body, as a sheet does.
    pub inside: bool,
    /// Numbers of the triangles of the face, without gaps.
    pub triangles: Range<usize>,
    /// [m²]
    pub area: f64,
    /// Middle of its area [m].
    pub middle: Vec3,
    /// Unit normal out of the body; none of a curved face.
    pub normal: Option<Vec3>,
    /// Mean of its unit normals.
    pub facing: Vec3,
}

/// Where two faces meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Border {
    /// Numbers of the faces.
    pub faces: [usize; 2],
    /// Whether they have the same tangent planes there.
    pub smooth: bool,
}

/// A body in faces.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the file that it was made of, or of its folder.
    pub source: String,
    /// Angle at which the faces of a file of triangles end [deg].
    pub split: Option<f64>,
    /// All triangles [m], face by face; those of surfaces inside have vertices of their own.
    pub surface: SurfaceMesh,
    /// All faces, in the order of their triangles.
    pub faces: Vec<Face>,
    /// Where they meet, by ascending numbers.
    pub borders: Vec<Border>,
}

impl Body {
    /// Reads a folder.
    pub fn read(folder: &Path) -> Result<Self> {
        let report = Model::read(folder)?;
        let model = read_surface(&folder.join("model.stl"))?;
        let mut of_place = HashMap::with_capacity(model.triangles.len());
        for t in 0..model.triangles.len() {
            of_place.insert(triangle_key(&model.corners(t)), t);
        }
        let mut groups = Groups { owner: vec![None; model.triangles.len()], regions: Vec::new() };
        for region in &report.regions {
            groups.take(region, &patch(folder, region)?, &of_place).with_context(|| {
                format!(
                    "{}: {} is not of model.stl; make the model again",
                    folder.display(),
                    region.name
                )
            })?;
        }
        let sheets = report.inside.iter().map(|region| patch(folder, region));
        let sheets = sheets.collect::<Result<Vec<_>>>()?;
        let mut body = groups.body(&model);
        body.source = source(&report, folder);
        body.split = report.import.split;
        for (region, patch) in report.inside.iter().zip(&sheets) {
            body.add_sheet(region, patch);
        }
        let tangent = report.tangent.as_ref().map(|pairs| tangent(pairs, &body.faces));
        body.borders = borders(&body, model.triangles.len(), tangent.as_ref());
        Ok(body)
    }

    /// The faces that meet one.
    pub fn beside(&self, face: usize) -> impl Iterator<Item = usize> {
        self.borders.iter().filter_map(move |border| match border.faces {
            [a, b] if a == face => Some(b),
            [a, b] if b == face => Some(a),
            _ => None,
        })
    }

    /// What its faces measure, by the names of their files.
    pub fn measured(&self) -> Vec<(String, mesh::faces::Face)> {
        let with_file: Vec<usize> =
            (0..self.faces.len()).filter(|&i| self.faces[i].file.is_some()).collect();
        let one = |&i: &usize| {
            let Face { file, area, middle, facing, .. } = &self.faces[i];
            let beside = self.beside(i).filter_map(|other| with_file.binary_search(&other).ok());
            let beside: BTreeSet<usize> = beside.collect();
            let (area, middle, normal) = (*area, *middle, *facing);
            let face =
                mesh::faces::Face { area, middle, normal, beside: beside.into_iter().collect() };
            (file.clone().unwrap_or_default(), face)
        };
        with_file.iter().map(one).collect()
    }

    fn add_sheet(&mut self, region: &Region, patch: &SurfaceMesh) {
        let begin = self.surface.triangles.len();
        self.surface.append(patch);
        let face = self.face(region, begin..self.surface.triangles.len());
        self.faces.push(Face { inside: true, ..face });
    }

    /// A face of some of the triangles.
    fn face(&self, region: &Region, triangles: Range<usize>) -> Face {
        let measured = mesh::faces::Face::of(&self.surface, triangles.clone());
        let mesh::faces::Face { area, middle, normal: facing, .. } = measured;
        let flat = (facing.norm() > FLAT_FACE_NORMAL).then(|| facing.normalize());
        let Region { name, kind } = region.clone();
        let kind = kind.unwrap_or_else(|| if flat.is_some() { "plane" } else { "curved" }.into());
        let file = Some(format!("{name}.stl"));
        Face { name, file, kind, inside: false, triangles, area, middle, normal: flat, facing }
    }

    /// What the page needs of it, lengths in millimetres.
    #[must_use = "the page finds the blobs by what is returned"]
    pub fn packed(&self, store: &mut Store) -> Value {
        let nodes: Vec<f64> =
            self.surface.vertices.iter().flat_map(|p| [MM * p.x, MM * p.y, MM * p.z]).collect();
        let triangles: Vec<usize> = self.surface.triangles.iter().flatten().copied().collect();
        let face = |f: &Face| {
            json!({
                "name": f.name,
                "file": f.file,
                "kind": f.kind,
                "inside": f.inside,
                "triangles": [f.triangles.start, f.triangles.end],
                "area": MM * MM * f.area,
                "middle": (MM * f.middle).as_slice(),
                "normal": f.normal.map(|n| [n.x, n.y, n.z]),
                "facing": f.facing.as_slice(),
            })
        };
        let border = |b: &Border| json!([b.faces[0], b.faces[1], b.smooth]);
        json!({
            "nodes": store.numbers(&nodes, 3),
            "triangles": store.indices(&triangles, 3),
            "faces": self.faces.iter().map(face).collect::<Vec<_>>(),
            "borders": self.borders.iter().map(border).collect::<Vec<_>>(),
        })
    }
}

fn source(report: &Model, folder: &Path) -> String {
    let path = report.input.as_ref().map_or(folder, |input| input.path.as_path());
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The surface of a region.
fn patch(folder: &Path, Region { name, .. }: &Region) -> Result<SurfaceMesh> {
    let file = format!("{name}.stl");
    let mut parts = Path::new(&file).components();
    let plain = matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None));
    ensure!(plain, "{}: {name:?} is not the name of a patch", folder.display());
    Ok(read_surface(&folder.join("patches").join(file))?)
}

/// Which region has each triangle of the model.
struct Groups {
    owner: Vec<Option<usize>>,
    regions: Vec<Region>,
}

impl Groups {
    fn take(
        &mut self,
        region: &Region,
        patch: &SurfaceMesh,
        of_place: &HashMap<[[u64; 3]; 3], usize>,
    ) -> Result<()> {
        let index = self.regions.len();
        for t in 0..patch.triangles.len() {
            match of_place.get(&triangle_key(&patch.corners(t))) {
                Some(&own) => self.owner[own] = Some(index),
                None => bail!("its triangle {t} is not there"),
            }
        }
        self.regions.push(region.clone());
        Ok(())
    }

    /// The triangles face by face; what no region has comes last.
    fn body(self, model: &SurfaceMesh) -> Body {
        let rest = self.regions.len();
        let mut order: Vec<usize> = (0..model.triangles.len()).collect();
        order.sort_by_key(|&t| self.owner[t].unwrap_or(rest));
        let triangles = order.iter().map(|&t| model.triangles[t]).collect();
        let surface = SurfaceMesh { vertices: model.vertices.clone(), triangles };
        let mut body = Body {
            source: String::new(),
            split: None,
            surface,
            faces: Vec::new(),
            borders: Vec::new(),
        };
        let mut begin = 0;
        for (index, region) in self.regions.iter().enumerate() {
            let count = self.owner.iter().filter(|owner| **owner == Some(index)).count();
            body.faces.push(body.face(region, begin..begin + count));
            begin += count;
        }
        if begin < order.len() {
            let none = Region { name: "no region".into(), kind: None };
            body.faces.push(Face { file: None, ..body.face(&none, begin..order.len()) });
        }
        body
    }
}

/// Pairs of faces that CAD knows to be smooth.
fn tangent(pairs: &[[String; 2]], faces: &[Face]) -> BTreeSet<[usize; 2]> {
    let index = |name: &String| faces.iter().position(|face| face.name == *name);
    let pair = |[a, b]: &[String; 2]| {
        let (a, b) = (index(a)?, index(b)?);
        Some([a.min(b), a.max(b)])
    };
    pairs.iter().filter_map(pair).collect()
}

/// Where faces meet, of the first `count` triangles.
fn borders(body: &Body, count: usize, tangent: Option<&BTreeSet<[usize; 2]>>) -> Vec<Border> {
    let triangles = &body.surface.triangles[..count];
    let mut of_triangle = vec![0; count];
    for (i, face) in body.faces.iter().enumerate().filter(|(_, face)| !face.inside) {
        of_triangle[face.triangles.clone()].fill(i);
    }
    let normal = |t: usize| body.surface.normal(t);
    // length, and length times angle
    let mut sums: BTreeMap<[usize; 2], [f64; 2]> = BTreeMap::new();
    for ([u, v], pair) in edge_facets(triangles) {
        let [s, t] = pair[..] else { continue };
        let (a, b) = (of_triangle[s], of_triangle[t]);
        if a != b {
            let length = (body.surface.vertices[u] - body.surface.vertices[v]).norm();
            let angle = normal(s).dot(&normal(t)).clamp(-1.0, 1.0).acos().to_degrees();
            let sum = sums.entry([a.min(b), a.max(b)]).or_default();
            sum[0] += length;
            sum[1] += length * angle;
        }
    }
    let border = |(faces, [length, turned]): ([usize; 2], [f64; 2])| {
        let flat = turned < SMOOTH * length;
        Border { faces, smooth: tangent.map_or(flat, |known| known.contains(&faces)) }
    };
    sums.into_iter().map(border).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fs;

    use mesh::io::write_surface;
    use mesh::solid::Solid;
    use mesh::topology::submesh;
    use tempfile::TempDir;

    use super::*;
    use crate::reported::read;

    /// A box of 40 × 20 × 10 mm with a box of air of 20 × 10 × 4 mm inside, its faces as patches `f0`
    /// to `f11`: those of the outside first.
    pub(crate) fn hollow() -> TempDir {
        body_with_air(5.0)
    }

    /// Box of [`hollow`], whose air begins at x [mm]. A negative x opens the air to the outside.
    pub(crate) fn body_with_air(x: f64) -> TempDir {
        let cube = |low: Vec3, high: Vec3| Solid::cube(&(1e-3 * low), &(1e-3 * high));
        let outer = cube(Vec3::zeros(), Vec3::new(40.0, 20.0, 10.0));
        let air = cube(Vec3::new(x, 5.0, 3.0), Vec3::new(25.0, 15.0, 7.0));
        let surface = outer.difference(&air).to_surface();
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write_surface(&path("model.stl"), &surface).unwrap();
        fs::create_dir(path("patches")).unwrap();
        let key = |t: usize| {
            let n = surface.normal(t);
            let on_outside = n.dot(&(surface.centroid(t) - Vec3::new(0.02, 0.01, 0.005))) > 0.0;
            (!on_outside, n.map(|x| x.round() as i64).as_slice().to_vec())
        };
        let keys: BTreeSet<_> = (0..surface.triangles.len()).map(key).collect();
        let mut regions = Vec::new();
        for (i, face) in keys.iter().enumerate() {
            let own = (0..surface.triangles.len()).filter(|&t| key(t) == *face);
            let own: Vec<_> = own.map(|t| surface.triangles[t]).collect();
            let patch = submesh(&surface.vertices, &own).0;
            write_surface(&path(&format!("patches/f{i}.stl")), &patch).unwrap();
            regions.push(json!({ "name": format!("f{i}") }));
        }
        fs::write(path("model.json"), json!({ "regions": regions }).to_string()).unwrap();
        folder
    }

    #[test]
    fn faces_have_area_normal_and_neighbours() {
        let folder = hollow();
        let body = Body::read(folder.path()).unwrap();
        assert_eq!((body.faces.len(), body.surface.triangles.len()), (12, 24));
        // f0: outside, facing -x
        let face = &body.faces[0];
        assert!((face.area - 200e-6).abs() < 1e-11, "{}", face.area);
        assert_eq!((face.normal, &face.kind[..]), (Some(-Vec3::x()), "plane"));
        assert!((face.middle - Vec3::new(0.0, 0.01, 0.005)).norm() < 1e-8);
        assert_eq!(body.borders.len(), 24, "twelve edges of each box");
        assert!(body.borders.iter().all(|b| !b.smooth && (b.faces[0] < 6) == (b.faces[1] < 6)));
    }

    #[test]
    fn cad_says_what_is_smooth_and_what_faces_are() {
        let folder = hollow();
        let file = folder.path().join("model.json");
        let mut report: Value = read(&file).unwrap();
        report["regions"][3]["kind"] = json!("cylinder");
        report["tangent"] = json!([["f2", "f0"], ["f0", "nobody"]]);
        fs::write(&file, report.to_string()).unwrap();
        let body = Body::read(folder.path()).unwrap();
        let smooth: Vec<_> = body.borders.iter().filter(|b| b.smooth).map(|b| b.faces).collect();
        assert_eq!((smooth, &body.faces[3].kind[..]), (vec![[0, 2]], "cylinder"));
    }

    #[test]
    fn a_folder_that_does_not_belong_together_is_refused() {
        let folder = hollow();
        let refused = |words: &[&str]| {
            let error = format!("{:#}", Body::read(folder.path()).unwrap_err());
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        };
        let patch = folder.path().join("patches/f4.stl");
        let other = Solid::cube(&Vec3::zeros(), &Vec3::repeat(0.01)).to_surface();
        write_surface(&patch, &other).unwrap();
        refused(&["f4", "make the model again"]);
        fs::remove_file(&patch).unwrap();
        refused(&["f4.stl"]);
        let report = folder.path().join("model.json");
        fs::write(&report, json!({ "regions": [{ "name": "../model" }] }).to_string()).unwrap();
        refused(&["\"../model\" is not the name of a patch"]);
        fs::remove_file(&report).unwrap();
        refused(&["cad2fem import"]);
    }
}
