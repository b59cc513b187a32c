//! The command line, and files for shells: man pages and completions.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser};
use clap_complete::Shell;
use clap_mangen::Man;

/// Write man pages and completions into the folders below SHARE (for make install)
#[derive(Parser)]
#[command(name = "shell-files", hide = true)]
struct ShellFiles {
    share: PathBuf,
}

/// The command line of a program. Besides its own verbs every program has `shell-files SHARE`,
/// which no help shows: it writes `SHARE/man/man1/*.1` and completions for bash, zsh and fish.
pub fn parse<C: CommandFactory + FromArgMatches>() -> Result<C, ExitCode> {
    let matches = C::command().subcommand(ShellFiles::command()).get_matches();
    if let Some(("shell-files", files)) = matches.subcommand() {
        let files = ShellFiles::from_arg_matches(files).unwrap_or_else(|error| error.exit());
        return Err(match write(C::command(), &files.share) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                crate::terminal::to_stderr(&format!("shell-files: {error:#}"));
                ExitCode::from(2)
            }
        });
    }
    Ok(C::from_arg_matches(&matches).unwrap_or_else(|error| error.exit()))
}

/// Writes man pages and completions of a command, where Debian's programs look for them.
fn write(mut command: clap::Command, share: &Path) -> Result<()> {
    let name = command.get_name().to_owned();
    let mut documented = command.clone().disable_help_subcommand(true);
    documented.build();
    write_pages(&documented, &share.join("man/man1"))?;
    for (shell, file) in [
        (Shell::Bash, format!("bash-completion/completions/{name}")),
        (Shell::Zsh, format!("zsh/site-functions/_{name}")),
        (Shell::Fish, format!("fish/vendor_completions.d/{name}.fish")),
    ] {
        let mut text = Vec::new();
        clap_complete::generate(shell, &mut command, &name, &mut text);
        mesh::io::write_atomic(&share.join(file), |out| out.write_all(&text))?;
    }
    Ok(())
}

/// The man page of a command and those of its verbs.
fn write_pages(command: &clap::Command, pages: &Path) -> Result<()> {
    let mut shown = command.get_subcommands().filter(|verb| !verb.is_hide_set());
    shown.try_for_each(|verb| write_pages(verb, pages))?;
    let page = Man::new(command.clone());
    let path = pages.join(page.get_filename());
    Ok(mesh::io::write_atomic(&path, |mut out| page.render(&mut out))?)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Casts molds
    #[derive(Parser)]
    #[command(name = "caster", version)]
    struct Caster {
        #[command(subcommand)]
        verb: Verb,
    }

    #[derive(clap::Subcommand)]
    enum Verb {
        /// Pour it
        Pour {
            /// Which silicone
            #[arg(long)]
            silicone: String,
        },
    }

    #[test]
    fn pages_and_completions_name_verbs_and_options() {
        let share = tempfile::tempdir().unwrap();
        write(Caster::command(), share.path()).unwrap();
        for (file, word) in [
            ("man/man1/caster.1", "Casts molds"),
            ("man/man1/caster-pour.1", "silicone"),
            ("bash-completion/completions/caster", "--silicone"),
            ("zsh/site-functions/_caster", "Which silicone"),
            ("fish/vendor_completions.d/caster.fish", "Pour it"),
        ] {
            let text = std::fs::read_to_string(share.path().join(file)).unwrap();
            assert!(text.contains(word), "{file}: {text}");
            assert!(!text.contains("shell-files"), "{file}");
        }
    }
}
