//! A headless Chromium that tests talk to over the DevTools protocol.
//!
//! The protocol comes over a pipe: Chromium reads messages that end with a zero byte from file
//! descriptor 3 and answers on 4, so that no port and no library of web sockets is needed. It
//! draws in software, so that pictures need no graphics card.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::skip::skip;

/// Names under which systems have it.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Longest life of a browser [s], should a test hang.
const LIFE: u32 = 120;

/// A browser with one page.
pub struct Chromium {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    calls: u64,
    session: Option<String>,
    events: Vec<Value>,
    _profile: TempDir,
}

/// What a page looks like.
#[derive(Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height [px].
    pub size: [usize; 2],
    /// Red, green, blue of each pixel.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Number of different colours.
    pub fn colors(&self) -> usize {
        let mut colors = self.pixels.clone();
        colors.sort_unstable();
        colors.dedup();
        colors.len()
    }

    /// Share of pixels that are not the same as in another picture.
    pub fn differing(&self, other: &Self) -> f64 {
        assert_eq!(self.size, other.size);
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs.filter(|(a, b)| a != b).count() as f64 / self.pixels.len() as f64
    }
}

impl Chromium {
    /// Starts a browser whose page has `size` pixels; none where this machine has none, and the test is counted as
    /// skipped.
    pub fn start(size: [u32; 2]) -> Option<Self> {
        let known = |name: &&&str| {
            let found = Command::new("bash").args(["-c", "command -v \"$0\"", name]).output();
            found.is_ok_and(|found| found.status.success())
        };
        let Some(program) = NAMES.iter().find(known) else {
            skip("Chromium is not on this machine");
            return None;
        };
        let profile = tempfile::tempdir().expect("a temporary folder");
        // what is given to the shell as its input and output becomes 3 and 4
        let script = "exec timeout \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null 2>/dev/null";
        let mut child = Command::new("bash")
            .args(["-c", script, &LIFE.to_string(), *program])
            .args(["--headless", "--no-sandbox", "--remote-debugging-pipe", "--hide-scrollbars"])
            .args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            // no server is reached, whatever a page asks for, except one of a test by the number of this machine
            .arg("--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1")
            .arg("--no-first-run")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("bash starts");
        let (input, output) = (child.stdin.take(), child.stdout.take());
        let mut browser = Self {
            child,
            input: input.expect("a pipe"),
            output: BufReader::new(output.expect("a pipe")),
            calls: 0,
            session: None,
            events: Vec::new(),
            _profile: profile,
        };
        let targets = browser.call("Target.getTargets", &json!({}));
        let all = targets["targetInfos"].as_array().expect("a list");
        let page = all.iter().find(|t| t["type"] == "page").expect("a page")["targetId"].clone();
        let to = json!({ "targetId": page, "flatten": true });
        let session = browser.call("Target.attachToTarget", &to);
        browser.session = session["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        let [width, height] = size;
        let screen =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        browser.call("Emulation.setDeviceMetricsOverride", &screen);
        Some(browser)
    }

    /// Calls a method of the protocol.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.calls += 1;
        let mut message = json!({ "id": self.calls, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.input.write_all(format!("{message}\0").as_bytes()).expect("it listens");
        loop {
            let mut answer = self.receive();
            if answer["id"] == self.calls {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
            self.events.push(answer);
        }
    }

    fn receive(&mut self) -> Value {
        let mut message = Vec::new();
        self.output.read_until(0, &mut message).expect("it answers");
        assert_eq!(message.pop(), Some(0), "Chromium has ended");
        serde_json::from_slice(&message).expect("JSON")
    }

    /// The value of an expression in the page; promises are waited for.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let how = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut found = self.call("Runtime.evaluate", &how);
        let thrown = &found["exceptionDetails"];
        assert!(thrown.is_null(), "{expression}: {thrown}");
        found["result"]["value"].take()
    }

    /// Opens a file.
    pub fn open(&mut self, path: &Path) {
        self.call("Page.navigate", &json!({ "url": format!("file://{}", path.display()) }));
    }

    /// Opens an address of this machine, and waits until its scripts have run.
    pub fn visit(&mut self, address: &str) {
        self.call("Page.navigate", &json!({ "url": address }));
        self.wait(&format!("location.href === {address:?} && document.readyState === 'complete'"));
    }

    /// Does something in a page that the shown one embeds, whose address has a word; places are as seen from that.
    pub fn within<T>(&mut self, word: &str, act: impl FnOnce(&mut Self) -> T) -> T {
        let outer = self.session.take();
        let start = Instant::now();
        let target = loop {
            let all = self.call("Target.getTargets", &json!({}))["targetInfos"].take();
            let is_it = |t: &&Value| {
                t["type"] == "iframe" && t["url"].as_str().is_some_and(|url| url.contains(word))
            };
            if let Some(found) = all.as_array().and_then(|all| all.iter().find(is_it)) {
                break found["targetId"].clone();
            }
            assert!(start.elapsed() < Duration::from_secs(30), "no page with {word}: {all:#}");
            std::thread::sleep(Duration::from_millis(100));
        };
        let to = json!({ "targetId": target, "flatten": true });
        let session = self.call("Target.attachToTarget", &to);
        self.session = session["sessionId"].as_str().map(str::to_owned);
        self.call("Runtime.enable", &json!({}));
        let done = act(self);
        self.session = outer;
        done
    }

    /// Drops a file at a place [px].
    pub fn drop_file(&mut self, [x, y]: [f64; 2], file: &Path) {
        let data = json!({ "items": [], "files": [file], "dragOperationsMask": 1 });
        // the page has to have taken one move before the file is let go
        for kind in ["dragEnter", "dragOver", "dragOver", "drop"] {
            let event = json!({ "type": kind, "x": x, "y": y, "data": data });
            self.call("Input.dispatchDragEvent", &event);
            std::thread::sleep(Duration::from_millis(300));
        }
    }

    /// Opens a page of ours and waits for its first picture.
    pub fn show(&mut self, page: &Path) {
        self.open(page);
        self.wait("window.puffer?.state().firstPicture");
    }

    /// What a page of ours says of itself.
    pub fn state(&mut self) -> Value {
        self.evaluate("window.puffer.state()")
    }

    /// Presses the button with a text.
    pub fn press(&mut self, text: &str) {
        let all = "[...document.querySelectorAll('button')]";
        self.evaluate(&format!("{all}.find((b) => b.textContent === '{text}').click()"));
    }

    /// Clicks the button with a text, which has to be seen.
    pub fn click_button(&mut self, text: &str) {
        let place = self.evaluate(&format!(
            "(() => {{ const all = [...document.querySelectorAll('button')]; \
             const b = all.find((b) => b.textContent === '{text}' && b.offsetParent); \
             b.scrollIntoView({{ block: 'nearest' }}); const r = b.getBoundingClientRect(); \
             return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        ));
        self.click([0, 1].map(|i| place[i].as_f64().expect("a button with this text")));
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str) {
        let start = Instant::now();
        while self.evaluate(&format!("Boolean({expression})")) != json!(true) {
            let late = start.elapsed() > Duration::from_secs(30);
            assert!(!late, "never {expression}; {:#?}", self.complaints());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Lets the page save files in a folder.
    pub fn save_in(&mut self, folder: &Path) {
        let to = json!({ "behavior": "allow", "downloadPath": folder.display().to_string() });
        self.call("Page.setDownloadBehavior", &to);
    }

    /// Makes a phone of it: a small screen that is touched.
    pub fn become_phone(&mut self) {
        let screen = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
        self.call("Emulation.setDeviceMetricsOverride", &screen);
        self.call("Emulation.setTouchEmulationEnabled", &json!({ "enabled": true }));
    }

    /// The pointer moves to a place [px], with the left button held where `pressed`.
    pub fn point(&mut self, kind: &str, [x, y]: [f64; 2], pressed: bool, shift: bool) {
        let button = if kind == "mouseMoved" && !pressed { "none" } else { "left" };
        let event = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": u8::from(pressed),
            "clickCount": 1, "modifiers": if shift { 8 } else { 0 },
        });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// A click of the left button.
    pub fn click(&mut self, place: [f64; 2]) {
        self.drag(&[place], false);
    }

    /// The left button is held from the first place to the last.
    pub fn drag(&mut self, places: &[[f64; 2]], shift: bool) {
        self.point("mouseMoved", places[0], false, shift);
        self.point("mousePressed", places[0], true, shift);
        for place in &places[1..] {
            self.point("mouseMoved", *place, true, shift);
        }
        self.point("mouseReleased", places[places.len() - 1], false, shift);
    }

    /// Fingers go through places: the first list has where each touches, the others where it moves to.
    pub fn touch(&mut self, places: &[&[[f64; 2]]]) {
        let point = |(id, [x, y]): (usize, &[f64; 2])| json!({ "x": x, "y": y, "id": id });
        for (i, fingers) in places.iter().enumerate() {
            let points: Vec<Value> = fingers.iter().enumerate().map(point).collect();
            let kind = if i == 0 { "touchStart" } else { "touchMove" };
            let event = json!({ "type": kind, "touchPoints": points });
            self.call("Input.dispatchTouchEvent", &event);
        }
        let end = json!({ "type": "touchEnd", "touchPoints": [] });
        self.call("Input.dispatchTouchEvent", &end);
    }

    /// A key goes down and up; `modifiers` are those of the protocol (2 control, 8 shift).
    pub fn key(&mut self, key: &str, modifiers: u8) {
        let code = match key {
            "Tab" => 9,
            "Enter" => 13,
            _ => 0,
        };
        let text = if key.chars().count() == 1 && modifiers == 0 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let event = json!({
                "type": kind, "key": key, "modifiers": modifiers, "windowsVirtualKeyCode": code,
                "text": if kind == "keyDown" { text } else { "" },
            });
            self.call("Input.dispatchKeyEvent", &event);
        }
    }

    /// What the page looks like now.
    pub fn picture(&mut self) -> Picture {
        // two frames later all is drawn that was asked for
        self.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))");
        let shot = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        let bytes = STANDARD.decode(shot["data"].as_str().expect("base64")).expect("base64");
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().expect("a PNG file");
        let mut raw = vec![0; reader.output_buffer_size().expect("it fits into memory")];
        let info = reader.next_frame(&mut raw).expect("a PNG file");
        let channels = info.color_type.samples();
        let pixels = raw.chunks_exact(channels).map(|p| [p[0], p[1], p[2]]).collect();
        Picture { size: [info.width as usize, info.height as usize], pixels }
    }

    /// Exceptions, messages on the console, blocked requests and dialogs so far.
    pub fn complaints(&self) -> Vec<String> {
        let methods = [
            "Runtime.exceptionThrown",
            "Runtime.consoleAPICalled",
            "Log.entryAdded",
            "Page.javascriptDialogOpening",
        ];
        let bad = self.events.iter().filter(|e| methods.iter().any(|m| e["method"] == *m));
        bad.map(Value::to_string).collect()
    }

    /// Addresses that were asked for so far, but for those that hold their data themselves.
    pub fn requests(&self) -> Vec<String> {
        let sent = self.events.iter().filter(|e| e["method"] == "Network.requestWillBeSent");
        let url = |e: &Value| e["params"]["request"]["url"].as_str().unwrap_or_default().to_owned();
        sent.map(url).filter(|url| !url.starts_with("data:")).collect()
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let close = json!({ "id": self.calls + 1, "method": "Browser.close" });
        let _ = self.input.write_all(format!("{close}\0").as_bytes());
        let _ = self.child.wait();
    }
}
