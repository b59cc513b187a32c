use measure::quantity::Equilibrium;
use mechanics::testing::{cube, square};
use mesh::{SurfaceMesh, Tags, Vec3};

use super::*;

const SCENE: &str = "
[[body]]
name = 'lower'
mesh = 'cube.msh'
material = { kind = 'neo-hookean', young = 1e5, poisson = 0.4 }
[[body]]
name = 'upper'
mesh = 'cube.msh'
material = { kind = 'neo-hookean', young = 2e5, poisson = 0.4 }
translate = [0.0, 0.0, 1.01]
[[fixed]]
on = 'lower.bottom'
[[probe]]
name = 'lift'
kind = 'displacement'
on = 'upper.top'
axis = [0, 0, 2]
[time]
end = 1.0
steps = 4
method = 'quasistatic'
";

const CONTACT: &str = "[contact]\nactivation = 1e-3\nstiffness = 1e5\n";

/// Terms of many kinds; all are built in the tests of `measure`.
const TERMS: &str = "
[[objective]]
kind = 'target'
on = ['lower.top', 'lower.bottom']
target = 'cube.stl'
distance = 'signed'
spacing = 0.1
[[objective]]
kind = 'displacement'
on = 'upper.top'
displacement = [0.03, '0.1*t', { t = [0.5, 1.0], value = [0.0, 1.0] }]
over = { steps = [2, 4] }
[[objective]]
kind = 'position'
on = 'upper'
position = [0, 0, 1]
[[objective]]
kind = 'contact-force'
on = 'upper'
form = 'along'
direction = [0, 0, 3]
[[objective]]
kind = 'contact-proxy'
on = ['lower.top', 'upper.bottom']
activation = 0.02
over = 'trapezoid'
[[objective]]
kind = 'wall-thickness'
on = ['lower.top', 'lower.bottom', 'upper.top']
density = 'quadratic'
activation = 1.2
[[objective]]
kind = 'smoothness'
on = 'lower.top'
[[objective]]
kind = 'clearance'
activation = 1e-3
[[objective]]
kind = 'volume'
on = 'upper'
[[objective]]
kind = 'stress'
on = 'upper'
[[objective]]
kind = 'strain-limit'
largest = 1.05
[[objective]]
kind = 'probe'
probe = 'lift'
target = '0.2*t'
scale = 0.01
";

#[derive(serde::Deserialize)]
struct Design {
    objective: Vec<ObjectiveConfig>,
}

/// Names and values of all terms with their factors, at a state where the upper
/// cube is stretched by a tenth along z.
fn values(contact: &str, terms: &str) -> Result<Vec<(String, f64, Vec<f64>)>> {
    let folder = tempfile::tempdir()?;
    let at = |name: &str| folder.path().join(name);
    let mesh = cube(1, 0.0);
    let mut tags = Tags::new(["bottom", "top"].map(str::to_owned).to_vec());
    for facet in mesh::topology::boundary(&mesh).facets {
        let z = facet.map(|v| mesh.vertices[v].z);
        if z.iter().all(|other| *other == z[0]) {
            tags.set(facet, if z[0] == 0.0 { 1 } else { 2 });
        }
    }
    mesh::io::write_tets(&at("cube.msh"), &mesh, &tags)?;
    let (skin, _) = mesh::topology::boundary(&mesh).surface(&mesh);
    mesh::io::write_surface(&at("cube.stl"), &skin)?;
    mesh::io::write_surface(&at("open.stl"), &square(1, 0.0))?;
    let turned = |t: &[usize; 3]| [t[0], t[2], t[1]];
    let triangles = skin.triangles.iter().map(turned).collect();
    let inside_out = SurfaceMesh { vertices: skin.vertices, triangles };
    mesh::io::write_surface(&at("inside out.stl"), &inside_out)?;
    std::fs::write(at("sim.toml"), format!("{SCENE}{contact}"))?;

    let scene = Scene::read(&at("sim.toml"))?;
    let named = (0..).zip(terms.split("[[objective]]")).map(|(i, term)| match i {
        0 => String::new(),
        _ => format!("[[objective]]\nname = 'term {i}'\nweight = 2\n{term}"),
    });
    let design: Design = toml::from_str(&named.collect::<String>())?;
    let builder = ObjectiveBuilder::new(&at("design.toml"), &design.objective, &scene)?;
    let space = FunctionSpace::new(1, scene.body.mesh.vertices.len(), scene.body.mesh.tets.clone());
    let stretched = |x: &Vec3| if x.z > 1.005 { 0.1 * (x.z - 1.01) } else { 0.0 };
    let u: Vec<f64> =
        scene.body.mesh.vertices.iter().flat_map(|x| [0.0, 0.0, stretched(x)]).collect();
    let mut pull = vec![0.0; u.len()];
    pull.chunks_exact_mut(3).for_each(|f| f[2] = 1.0);
    let rest = &scene.body.mesh.vertices;
    let (space, u, contact) = (&space, &u, &pull);
    let energies = &mechanics::energy::Energies::default();
    let at = Equilibrium { space, rest, u, time: 1.0, contact, reaction: &[], energies };
    let terms = builder.build(&scene, &scene.body, space)?;
    let one = |t: &Weighted| {
        assert!(t.weight == 2.0);
        (t.name.clone(), t.quantity.value(&at), t.factors.clone())
    };
    Ok(terms.iter().map(one).collect())
}

#[test]
fn terms_are_built_on_what_they_name() {
    let found = values(CONTACT, TERMS).expect("sound");
    assert_eq!(found.len(), 12);
    let value = |i: usize| found[i].1;
    let close = |i: usize, expected: f64| {
        assert!((value(i) - expected).abs() < 1e-9 * expected.abs().max(1.0), "{i}: {found:?}");
    };
    assert_eq!(found[3].0, "term 4");
    // d̃² is off within two lattice cells of the target's edges
    assert!(value(0).abs() < 1e-4);
    // the top is lifted by 0.1, where (0.03, 0.1, 1) is wanted at t = 1
    close(1, 0.03_f64.powi(2) + 0.01 + 0.81);
    assert_eq!(found[1].2, [0.0, 0.0, 0.5, 0.0, 0.5]);
    // eight nodes of the upper cube
    close(3, 8.0);
    assert!(value(4) > 0.0 && value(5) > 0.0);
    assert_eq!(found[4].2, [0.125, 0.25, 0.25, 0.25, 0.125]);
    close(7, 0.0);
    close(8, 1.0);
    // of the stretched cube only
    let law = mechanics::material::NeoHookean(mechanics::material::Lame::new(2e5, 0.4));
    let stretch = mechanics::math::tensor::Mat3::from_diagonal(&Vec3::new(0.0, 0.0, 0.1));
    let kinematics = mechanics::material::Kinematics::new(&stretch);
    let stress = mechanics::material::Material::first_piola(&law, &kinematics).norm_squared();
    close(9, stress);
    close(10, 0.05 * 0.05);
    // lifted by 0.1 where 0.2 is wanted, ten times the scale
    close(11, 100.0);
}

#[test]
fn what_is_missing_is_named() {
    let error =
        |contact: &str, terms: &str| format!("{:#}", values(contact, terms).expect_err("refused"));
    let (target, volume) =
        ("[[objective]]\nkind = 'target'\non = 'upper'", "[[objective]]\nkind = 'volume'\n");
    for (contact, terms, words) in [
        ("", TERMS.to_owned(), "contact-force: there are no forces"),
        ("", format!("{target}\ndistance = 'signed'\ntarget = 'open.stl'"), "4 edges on the rim"),
        ("", format!("{target}\ndistance = 'signed'\ntarget = 'inside out.stl'"), "face inwards"),
        ("", format!("{target}\ntarget = 'none.stl'"), "none.stl"),
        ("", format!("{volume}on = 'chamber'"), "objective \"term 1\": unknown tag \"chamber\""),
        ("", format!("{volume}over = {{ steps = [5] }}"), "step 5: the scene has steps 1 to 4"),
        ("", format!("{volume}over = 'simpson'\nodd = 1"), "unknown field `odd`"),
        ("", "[[objective]]\nkind = 'probe'\nprobe = 'drop'".to_owned(), "there are: lift"),
        ("", "[[objective]]\nkind = 'stress'\non = 'lower.top'".to_owned(), "lower, upper"),
        (
            "[solver]\ndilatation = 'mean'\n",
            "[[objective]]\nkind = 'stress'\n".to_owned(),
            "stress: it is made with the stress of the law at each point",
        ),
        (
            "",
            TERMS
                .replace("t = [0.5, 1.0]", "t = [0.6, 1.0]")
                .split("[[objective]]\nkind = 'position'")
                .next()
                .unwrap_or_default()
                .to_owned(),
            "displacement: ",
        ),
        (CONTACT, TERMS.replace("'upper.bottom'", "'lower'"), "parts 1 and 2 share"),
    ] {
        let error = error(contact, &terms);
        assert!(error.contains(words), "{words}: {error}");
    }
}
