//! The pages of robots that were made, in a real browser: their size, when they show their first picture, and
//! that they load nothing and complain of nothing.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use tests::chromium::Chromium;
use tests::skip::skip;
use tests::workdir::repository;

/// Largest page of the frog [B].
const LARGEST: u64 = 15_000_000;

/// A screenshot of each goes to build/NAME/pictures/page.png.
#[test]
#[ignore = "needs robots that take minutes to hours; run by make test-all for those that are made"]
fn pages_of_robots_open() {
    let Some(program) = Chromium::installed() else { return };
    for name in ["frog", "finger", "gripper", "walker", "worm", "arm"] {
        let folder = repository().join("build").join(name);
        let page = folder.join("report.html");
        if !page.is_file() {
            skip(&format!("there is no build/{name}/report.html: make {name}"));
            continue;
        }
        let size = std::fs::metadata(&page).unwrap().len();
        assert!(name != "frog" || size < LARGEST, "{name}: {size} bytes");
        let mut browser = Chromium::start(program, [1200, 800]);
        browser.open(&page);
        browser.wait("window.puffer?.state().firstPicture");
        let first = browser.evaluate("window.puffer.state().firstPicture");
        eprintln!("{name}: {:.1} MB, first picture after {first} ms", size as f64 * 1e-6);
        assert!(browser.picture().colors() > 1000, "{name}");
        assert_eq!(browser.complaints(), [""; 0], "{name}");
        let shot = browser.call("Page.captureScreenshot", &json!({}));
        let bytes = STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        std::fs::create_dir_all(folder.join("pictures")).unwrap();
        std::fs::write(folder.join("pictures/page.png"), bytes).unwrap();
    }
}
