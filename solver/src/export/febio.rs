//! Decks of FEBio 4, in XML.
//!
//! Energies are as in the sources of FEBio 4: `Mooney-Rivlin`, `Yeoh`, `Gent`, `Ogden` and `uncoupled hyperelastic` have
//! the volumetric term ½ k ln²J of ours. Its `Arruda-Boyce` has other coefficients, so that our series is written out.

use std::fmt::Write as _;

use anyhow::Result;
use mesh::Vec3;

use super::{Deck, Format, Held, Volume, ids, in_one_line, no_law};

const PROGRAM: &str = "FEBio";

pub const FORMAT: Format = Format { program: PROGRAM, ending: "feb", write };

/// Terms of Ogden's law at most.
const OGDEN_TERMS: usize = 6;
const AXES: [char; 3] = ['x', 'y', 'z'];

/// Load steps, and tolerances far below those that FEBio has by default.
const CONTROL: &str = r#"  <Module type="solid"/>
  <Control>
    <analysis>STATIC</analysis>
    <time_steps>10</time_steps>
    <step_size>0.1</step_size>
    <time_stepper type="default">
      <max_retries>8</max_retries>
      <opt_iter>15</opt_iter>
      <dtmin>0.0001</dtmin>
      <dtmax>0.1</dtmax>
    </time_stepper>
    <solver type="solid">
      <symmetric_stiffness>non-symmetric</symmetric_stiffness>
      <dtol>1e-06</dtol>
      <etol>1e-08</etol>
      <rtol>0</rtol>
      <max_refs>30</max_refs>
      <qn_method type="BFGS">
        <max_ups>0</max_ups>
      </qn_method>
    </solver>
  </Control>
"#;

/// All loads grow in proportion to the time.
const LOAD_DATA: &str = r#"  <LoadData>
    <load_controller id="1" type="loadcurve">
      <interpolate>LINEAR</interpolate>
      <extend>CONSTANT</extend>
      <points>
        <pt>0,0</pt>
        <pt>1,1</pt>
      </points>
    </load_controller>
  </LoadData>
  <Output>
    <plotfile type="febio">
      <var type="displacement"/>
      <var type="stress"/>
    </plotfile>
    <logfile>
      <node_data data="ux;uy;uz" file="displacement.txt" delim=","/>
    </logfile>
  </Output>
</febio_spec>
"#;

fn write(deck: &Deck) -> Result<String> {
    let (volumes, tags) = deck.set_names();
    let mut out =
        String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<febio_spec version=\"4.0\">\n");
    for line in deck.head(PROGRAM, "m, N, Pa") {
        writeln!(out, "  <!-- {} -->", comment(&line))?;
    }
    out += CONTROL;
    writeln!(out, "  <Material>")?;
    for (i, (volume, set)) in deck.volumes.iter().zip(&volumes).enumerate() {
        let (text, law) = (law(volume)?, volume.material.law);
        let (name, formula) = (comment(&volume.name), comment(law.formula));
        writeln!(out, "    <!-- {name}: {} of Puffer, {formula} -->", law.key)?;
        writeln!(out, "    <material id=\"{}\" name=\"M{set}\" {text}    </material>", i + 1)?;
    }
    writeln!(out, "  </Material>\n  <Mesh>")?;
    write_mesh(deck, &volumes, &mut out)?;
    write_sets(deck, &tags, &mut out)?;
    writeln!(out, "  </Mesh>\n  <MeshDomains>")?;
    for set in &volumes {
        // the change of volume counts at every point, and no pressure of an element is sought
        writeln!(out, "    <SolidDomain name=\"{set}\" mat=\"M{set}\" type=\"elastic-solid\"/>")?;
    }
    writeln!(out, "  </MeshDomains>")?;
    write_data(deck, &mut out)?;
    writeln!(out, "  <Boundary>")?;
    deck.held.iter().try_for_each(|held| write_support(held, &mut out))?;
    writeln!(out, "  </Boundary>\n  <Loads>")?;
    for &(tag, pressure) in &deck.pressures {
        let name = &tags[tag];
        writeln!(
            out,
            "    <surface_load name=\"pressure in {name}\" surface=\"{name}\" type=\"pressure\">\n      \
             <pressure lc=\"1\">{pressure:e}</pressure>\n      <symmetric_stiffness>0</symmetric_stiffness>\n      \
             <linear>0</linear>\n    </surface_load>"
        )?;
    }
    if !deck.forces.is_empty() {
        writeln!(
            out,
            "    <nodal_load name=\"gravity, body forces and tractions\" node_set=\"NFORCES\" type=\"nodal_force\">\n      \
             <value lc=\"1\" type=\"map\">forces</value>\n    </nodal_load>"
        )?;
    }
    writeln!(out, "  </Loads>")?;
    out += LOAD_DATA;
    Ok(out)
}

fn write_mesh(deck: &Deck, volumes: &[String], out: &mut String) -> Result<()> {
    writeln!(out, "    <Nodes name=\"NALL\">")?;
    for (i, x) in deck.nodes.iter().enumerate() {
        writeln!(out, "      <node id=\"{}\">{}</node>", i + 1, vector(x))?;
    }
    writeln!(out, "    </Nodes>")?;
    let kind = if deck.degree == 1 { "tet4" } else { "tet10" };
    for (volume, set) in deck.volumes.iter().zip(volumes) {
        writeln!(out, "    <Elements type=\"{kind}\" name=\"{set}\">")?;
        for element in volume.elements.clone() {
            // our order of nodes, VTK's, is that of FEBio
            let nodes = ids(&deck.elements[element], ",");
            writeln!(out, "      <elem id=\"{}\">{nodes}</elem>", element + 1)?;
        }
        writeln!(out, "    </Elements>")?;
    }
    Ok(())
}

fn write_sets(deck: &Deck, tags: &[String], out: &mut String) -> Result<()> {
    for (tag, name) in deck.tags.iter().zip(tags) {
        let title = comment(&tag.name);
        writeln!(out, "    <!-- tag \"{title}\" -->\n    <Surface name=\"{name}\">")?;
        for (i, facet) in tag.facets.iter().enumerate() {
            let kind = if deck.degree == 1 { "tri3" } else { "tri6" };
            writeln!(out, "      <{kind} id=\"{}\">{}</{kind}>", i + 1, ids(&facet.nodes, ","))?;
        }
        let nodes = ids(&tag.nodes, ",");
        writeln!(out, "    </Surface>\n    <NodeSet name=\"N{name}\">{nodes}</NodeSet>")?;
    }
    for held in &deck.held {
        let nodes = ids(&held.nodes, ",");
        writeln!(out, "    <NodeSet name=\"{}\">{nodes}</NodeSet>", held.name)?;
    }
    if !deck.forces.is_empty() {
        let nodes: Vec<usize> = deck.forces.iter().map(|(node, _)| *node).collect();
        writeln!(out, "    <NodeSet name=\"NFORCES\">{}</NodeSet>", ids(&nodes, ","))?;
    }
    Ok(())
}

/// Values that differ from node to node.
fn write_data(deck: &Deck, out: &mut String) -> Result<()> {
    let mut data = String::new();
    for held in &deck.held {
        for axis in (0..3).filter(|&axis| held.axes[axis] && held.uniform(axis).is_none()) {
            let values = held.displacement.iter().map(|u| format!("{:e}", u[axis]));
            write_values(&mut data, &map_name(held, axis), &held.name, "scalar", values)?;
        }
    }
    if !deck.forces.is_empty() {
        let values = deck.forces.iter().map(|(_, force)| vector(force));
        write_values(&mut data, "forces", "NFORCES", "vec3", values)?;
    }
    if !data.is_empty() {
        writeln!(out, "  <MeshData>\n{data}  </MeshData>")?;
    }
    Ok(())
}

fn write_values(
    out: &mut String,
    name: &str,
    set: &str,
    kind: &str,
    values: impl Iterator<Item = String>,
) -> Result<()> {
    writeln!(out, "    <NodeData name=\"{name}\" node_set=\"{set}\" data_type=\"{kind}\">")?;
    for (i, value) in (1..).zip(values) {
        writeln!(out, "      <node lid=\"{i}\">{value}</node>")?;
    }
    writeln!(out, "    </NodeData>")?;
    Ok(())
}

fn write_support(held: &Held, out: &mut String) -> Result<()> {
    let set = &held.name;
    let at_rest = |axis: usize| held.uniform(axis) == Some(0.0);
    let still: Vec<usize> = (0..3).filter(|&axis| held.axes[axis] && at_rest(axis)).collect();
    if !still.is_empty() {
        writeln!(out, "    <bc name=\"{set}\" node_set=\"{set}\" type=\"zero displacement\">")?;
        for (axis, letter) in AXES.iter().enumerate() {
            let held = u8::from(still.contains(&axis));
            writeln!(out, "      <{letter}_dof>{held}</{letter}_dof>")?;
        }
        writeln!(out, "    </bc>")?;
    }
    for axis in (0..3).filter(|&axis| held.axes[axis] && !at_rest(axis)) {
        let value = match held.uniform(axis) {
            Some(value) => format!("<value lc=\"1\">{value:e}</value>"),
            None => format!("<value lc=\"1\" type=\"map\">{}</value>", map_name(held, axis)),
        };
        let letter = AXES[axis];
        writeln!(
            out,
            "    <bc name=\"{set} along {letter}\" node_set=\"{set}\" type=\"prescribed displacement\">\n      \
             <dof>{letter}</dof>\n      {value}\n      <relative>0</relative>\n    </bc>"
        )?;
    }
    Ok(())
}

fn map_name(held: &Held, axis: usize) -> String {
    format!("{}_{}", held.name, AXES[axis])
}

/// The law in FEBio's words: the rest of a tag, and what is in it.
fn law(volume: &Volume) -> Result<String> {
    let p = &volume.material.values;
    Ok(match volume.material.law.key {
        "mooney-rivlin" if p[2] == 0.0 => {
            values("Mooney-Rivlin", &[("c1", p[0]), ("c2", p[1]), ("k", 2.0 * p[3])])
        }
        "mooney-rivlin" => {
            let [c1, c2, c3] = [p[0], p[1], p[2]];
            hyperelastic(&format!("{c1}*(I1-3) + {c2}*(I2-3) + {c3}*(I1-3)*(I2-3)"), 2.0 * p[3])
        }
        "mooney-rivlin-quadratic" => {
            values("polynomial", &[("c10", p[0]), ("c01", p[1]), ("c11", p[2]), ("D1", p[3])])
        }
        "neo-hookean" => values("neo-Hookean", &[("E", p[0]), ("v", p[1])]),
        "yeoh" => values("Yeoh", &[("c1", p[0]), ("c2", p[1]), ("c3", p[2]), ("k", p[3])]),
        "gent" => values("Gent", &[("G", p[0]), ("Jm", p[1]), ("k", p[2])]),
        "arruda-boyce" => hyperelastic(&arruda_boyce(p), p[2]),
        "ogden" => ogden(volume)?,
        "saint-venant-kirchhoff" => values("isotropic elastic", &[("E", p[0]), ("v", p[1])]),
        _ => return no_law(volume, PROGRAM, ""),
    })
}

fn values(kind: &str, values: &[(&str, f64)]) -> String {
    let lines = values.iter().map(|(key, value)| format!("      <{key}>{value:e}</{key}>\n"));
    format!("type=\"{kind}\">\n{}", lines.collect::<String>())
}

/// A law of Ī₁ and Ī₂, with ½ k ln²J.
fn hyperelastic(energy: &str, bulk: f64) -> String {
    format!("type=\"uncoupled hyperelastic\">\n      <k>{bulk:e}</k>\n      <W>{energy}</W>\n")
}

/// The series of the law, with the coefficients of `mechanics`.
fn arruda_boyce(p: &[f64]) -> String {
    let series = [1.0 / 2.0, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673_750.0];
    let term = |(i, c): (i32, f64)| {
        let factor = p[0] * c * p[1].powi(2 - 2 * i);
        format!("{factor:.17}*(I1^{i}-{})", 3_i32.pow(i.unsigned_abs()))
    };
    (1..).zip(series).map(term).collect::<Vec<_>>().join(" + ")
}

/// Σ c/m² (λ̄₁^m + …) in place of our Σ μ/α (…): its c is μ α.
fn ogden(volume: &Volume) -> Result<String> {
    let p = &volume.material.values;
    let terms = p.len() / 2;
    if terms > OGDEN_TERMS {
        return no_law(volume, PROGRAM, &format!(" of more than {OGDEN_TERMS} terms"));
    }
    let mut text = String::from("type=\"Ogden\">\n");
    for i in 0..terms {
        let (mu, alpha) = (p[i], p[terms + i]);
        writeln!(text, "      <c{}>{:e}</c{}>", i + 1, mu * alpha, i + 1)?;
        writeln!(text, "      <m{}>{alpha:e}</m{}>", i + 1, i + 1)?;
    }
    writeln!(text, "      <k>{:e}</k>", p[2 * terms])?;
    Ok(text)
}

fn vector(v: &Vec3) -> String {
    format!("{:e},{:e},{:e}", v.x, v.y, v.z)
}

/// Text that may stand in a comment.
fn comment(text: &str) -> String {
    in_one_line(text).replace("--", "- -")
}
