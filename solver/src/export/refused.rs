//! What no deck says.

use anyhow::{Result, bail};
use program::{KeyPath, misfit};
use scene::Scene;
use scene::config::Dilatation;

/// The highest degree of elements that other programs have.
const HIGHEST_DEGREE: usize = 2;

/// Rooms of terms that other programs have, too.
const IN_DECKS: [&str; 4] = ["chamber", "gravity", "body_force", "traction"];

/// Refuses a scene with anything that would be missing in a deck.
pub fn check(scene: &Scene) -> Result<()> {
    let config = &scene.config;
    if config.degree > HIGHEST_DEGREE {
        bail!(misfit!(
            KeyPath::of("degree"),
            " = {}: other programs have tetrahedra of degree 1 and 2; add --degree 2",
            config.degree
        ));
    }
    if config.method().has_inertia() {
        bail!(misfit!(
            KeyPath::table("time").key("method"),
            ": a deck is a static equilibrium; expected \"quasistatic\", or a scene without [time]"
        ));
    }
    if config.solver.dilatation == Dilatation::Mean {
        bail!(misfit!(
            KeyPath::table("solver").key("dilatation"),
            " = \"mean\": decks have elements whose change of volume counts at every point; expected \"pointwise\""
        ));
    }
    let lists = [
        (config.contact().is_some(), KeyPath::table("contact")),
        (!config.obstacle.is_empty(), KeyPath::list("obstacle")),
    ];
    let written = toml::Table::try_from(config)?;
    let rooms = config.rooms().into_iter().map(|room| room.about().list);
    let rooms = rooms.filter(|list| !IN_DECKS.contains(list) && *list != "contact");
    let rooms = rooms.map(|list| (written.contains_key(list), KeyPath::list(list)));
    if let Some((_, path)) = lists.into_iter().chain(rooms).find(|(has, _)| *has) {
        bail!(misfit!(path, ": has no part in a deck; export a scene without it"));
    }
    chambers(scene)
}

/// A chamber must be a pressure on a wall.
fn chambers(scene: &Scene) -> Result<()> {
    for chamber in &scene.config.chamber {
        if chamber.plug {
            bail!(misfit!(
                chamber.title().key("plug"),
                ": a deck has no plug on which gas pushes; close the chamber by tetrahedra"
            ));
        }
        if chamber.gas.pressure().is_none() {
            bail!(misfit!(
                chamber.title().key(chamber.gas.key()),
                ": a deck has pressures only; expected pressure = ... [Pa], such as the one that solver simulate reports"
            ));
        }
    }
    Ok(())
}
