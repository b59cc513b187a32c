#![allow(clippy::all, missing_docs)]
use fab::{config::Config, mold::Mold, skin::Skin};
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t = Instant::now();
    let msh = mesh::io::read_tets(std::path::Path::new(&a[1])).unwrap();
    let config = Config::parse(&std::fs::read_to_string(&a[2]).unwrap()).unwrap();
    println!("read {:?}", t.elapsed());
    let skin = Skin::new(&msh, &config.cavity).map_err(|e| e.to_string()).unwrap();
    println!("skin {:?} inlet {:?}", t.elapsed(), skin.cores[0].inlets);
    let m = Mold::new(&skin, &config).map_err(|e| e.to_string()).unwrap();
    println!("mold {:?} block {:?}", t.elapsed(), m.block);
    for f in &m.findings {
        println!("{f:?}");
    }
    for f in &m.features {
        println!("{f:?}");
    }
    for p in m.shells.iter().chain(&m.cores) {
        let s = p.solid.to_surface();
        let mut q = s.clone();
        for v in &mut q.vertices {
            *v = v.map(|x| f64::from((1e3 * x) as f32));
        }
        println!(
            "{} tris {} vol {} genus {} raw {:?}",
            p.name,
            s.triangles.len(),
            p.solid.volume() * 1e9,
            p.solid.genus(),
            mesh::check::check_surface(&s).iter().map(|f| f.message.clone()).collect::<Vec<_>>()
        );
        let path = std::path::PathBuf::from(format!("{}/{}.stl", a[3], p.name));
        mesh::io::write_surface(&path, &q).unwrap();
        let r = mesh::io::read_surface(&path).unwrap();
        println!(
            "   written {} {:?}",
            r.triangles.len(),
            mesh::check::check_surface(&r).iter().map(|f| f.message.clone()).collect::<Vec<_>>()
        );
    }
    println!("all {:?}", t.elapsed());
}
