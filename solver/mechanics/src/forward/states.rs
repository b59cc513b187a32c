//! States of a run, in memory up to a budget and beyond it in a file.

use std::borrow::Cow;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};

use super::State;

/// States one after the other. Those that do not fit into the budget lie in a file
/// without a name, in the folder for temporary files (`TMPDIR`); it goes when
/// they go, and when the program is killed. If it cannot be written, they stay in
/// memory, and `unwritten` says why.
#[derive(Debug)]
pub struct States {
    kept: Vec<Kept>,
    /// What states in memory may still take [B].
    left: f64,
    file: Option<File>,
    /// Why the last state that should lie in the file does not.
    unwritten: Option<std::io::Error>,
}

#[derive(Debug)]
enum Kept {
    Here(State),
    /// Where in the file, and the lengths of [`parts`].
    There(u64, [usize; 4]),
}

impl States {
    /// None yet, with so many bytes of memory for them; the first stays in memory in any
    /// case.
    pub fn new(first: State, budget: f64) -> Self {
        let left = budget - bytes(&first) as f64;
        Self { kept: vec![Kept::Here(first)], left, file: None, unwritten: None }
    }

    /// Adds one.
    pub fn push(&mut self, state: State) {
        let size = bytes(&state) as f64;
        let kept = if size <= self.left {
            self.left -= size;
            Kept::Here(state)
        } else {
            self.write(&state).unwrap_or_else(|error| {
                self.unwritten = Some(error);
                Kept::Here(state)
            })
        };
        self.kept.push(kept);
    }

    /// State n.
    ///
    /// # Panics
    /// When the disk does not give back what it took.
    pub fn get(&self, n: usize) -> Cow<'_, State> {
        match &self.kept[n] {
            Kept::Here(state) => Cow::Borrowed(state),
            &Kept::There(at, lengths) => {
                let file = self.file.as_ref().expect("written to");
                Cow::Owned(read(file, at, lengths).expect("what was written can be read"))
            }
        }
    }

    /// What is left of the budget [B].
    pub fn memory_left(&self) -> f64 {
        self.left.max(0.0)
    }

    /// Why states beyond the budget are in memory all the same, if any are.
    pub fn unwritten(&self) -> Option<&std::io::Error> {
        self.unwritten.as_ref()
    }

    fn write(&mut self, state: &State) -> std::io::Result<Kept> {
        if self.file.is_none() {
            self.file = Some(tempfile::tempfile()?);
        }
        let mut file = self.file.as_ref().expect("made above");
        let at = file.seek(SeekFrom::End(0))?;
        let numbers = parts(state).into_iter().flatten();
        let bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
        if let Err(error) = file.write_all(&bytes) {
            file.set_len(at)?;
            return Err(error);
        }
        Ok(Kept::There(at, parts(state).map(Vec::len)))
    }
}

fn parts(state: &State) -> [&Vec<f64>; 4] {
    [&state.u, &state.v, &state.a, &state.internal]
}

fn bytes(state: &State) -> usize {
    8 * parts(state).iter().map(|part| part.len()).sum::<usize>()
}

fn read(mut file: &File, at: u64, lengths: [usize; 4]) -> std::io::Result<State> {
    let mut bytes = vec![0; 8 * lengths.iter().sum::<usize>()];
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(&mut bytes)?;
    let mut numbers =
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes")));
    let [u, v, a, internal] = lengths.map(|len| numbers.by_ref().take(len).collect());
    Ok(State { u, v, a, internal })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(n: usize) -> State {
        let numbers = |by: f64| (0..5).map(|i| by / (1.0 + (i + n) as f64)).collect();
        let internal = if n == 0 { Vec::new() } else { numbers(3.0) };
        State { u: numbers(0.1), v: numbers(-1e-300), a: Vec::new(), internal }
    }

    #[test]
    fn what_exceeds_the_budget_comes_back_from_disk_bit_for_bit() {
        for (in_memory, on_disk) in [(1, 6), (3, 4), (7, 0)] {
            let mut states = States::new(state(0), 80.0 + 120.0 * (in_memory - 1) as f64);
            (1..7).for_each(|n| states.push(state(n)));
            let there = states.kept.iter().filter(|k| matches!(k, Kept::There(..)));
            assert_eq!(there.count(), on_disk);
            for n in [6, 2, 5, 0, 1, 4, 3] {
                assert_eq!(*states.get(n), state(n), "{n} of {in_memory} in memory");
            }
            states.push(state(7));
            assert_eq!(
                (states.get(7).into_owned(), states.get(6).into_owned()),
                (state(7), state(6))
            );
        }
    }
}
