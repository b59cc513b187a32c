//! A program that runs, and may not hang.

use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A program that takes longer than this hangs: each takes a second or less undisturbed.
const LONGEST: Duration = Duration::from_secs(120);

/// How a program ended.
pub struct End {
    /// Exit code; none after a signal.
    pub code: Option<i32>,
    /// The signal that ended it.
    pub signal: Option<i32>,
    /// Standard error.
    pub said: String,
}

impl End {
    /// Refuses panics, and ends that are none of these codes.
    pub fn expect(&self, codes: &[i32]) -> Result<(), String> {
        if self.said.contains("panicked") {
            return Err(format!("a panic: {}", self.said));
        }
        match self.code {
            Some(code) if codes.contains(&code) => Ok(()),
            code => Err(format!("ends with {code:?}, signal {:?}: {}", self.signal, self.said)),
        }
    }
}

/// A program that was started.
pub struct Running {
    child: Child,
    clock: Instant,
}

impl Running {
    /// Starts it.
    pub fn start(mut command: Command) -> Self {
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let child = command.spawn().unwrap_or_else(|e| panic!("{command:?}: {e}"));
        Self { child, clock: Instant::now() }
    }

    /// Waits so long since the start; false when it has ended before.
    pub fn runs_for(&mut self, time: Duration) -> bool {
        while self.clock.elapsed() < time {
            if self.child.try_wait().unwrap().is_some() {
                return false;
            }
            std::thread::sleep(Duration::from_micros(300));
        }
        true
    }

    /// Sends it a signal by its name.
    pub fn signal(&self, name: &str) {
        let pid = self.child.id().to_string();
        // it may just have ended
        let _ = Command::new("kill").args(["-s", name, &pid]).stderr(Stdio::null()).status();
    }

    /// Waits for its end.
    pub fn end(mut self) -> Result<End, String> {
        let pipe = self.child.stderr.take();
        let reader = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            let _ = pipe.map(|mut pipe| pipe.read_to_end(&mut bytes));
            String::from_utf8_lossy(&bytes).into_owned()
        });
        if self.runs_for(LONGEST) {
            let _ = self.child.kill();
            let _ = self.child.wait();
            return Err(format!("runs longer than {} s", LONGEST.as_secs()));
        }
        let status = self.child.wait().map_err(|e| e.to_string())?;
        let said = reader.join().unwrap_or_default();
        Ok(End { code: status.code(), signal: status.signal(), said })
    }
}

/// Runs a program to its end.
pub fn run(command: Command) -> Result<End, String> {
    Running::start(command).end()
}
