//! `solver/python.md`: every piece of Python in it runs, and says what the reports say.

use std::fs;
use std::process::Command;

use tests::chamber;
use tests::workdir::repository;

use crate::sweep::{python, said};

#[test]
fn every_piece_of_python_runs() {
    let Some(python) = python() else { return };
    let page = fs::read_to_string(repository().join("solver/python.md")).unwrap();
    let pieces: Vec<&str> =
        page.split("```python\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(pieces.len(), 5);
    for piece in &pieces {
        assert!(piece.lines().count() <= 5, "more than five lines:\n{piece}");
    }
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml -o inflated").assert_good();
    dir.solver("optimize design.toml --set shape.level.0.iterations=1 --set shape.level.1.iterations=1 -o optimize").assert_good();
    // a sweep is too long for this test; it writes its table with pandas as well
    fs::create_dir(dir.path("sweep")).unwrap();
    let table = "import pandas; t = pandas.DataFrame({'status': ['ok', 'failed'], 'volume': [1.0, None]}); \
                 t.to_parquet('sweep/table.parquet')";
    let run = |code: &str| {
        let output = Command::new(&python).args(["-c", code]).current_dir(dir.path("")).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{code}\n{}", said(&output));
        said(&output)
    };
    run(table);
    let printed: Vec<String> = pieces.iter().map(|piece| run(piece)).collect();

    let report = dir.json("inflated/report.json");
    let number = |text: &str| text.trim().parse::<f64>().unwrap_or_else(|_| panic!("{text}"));
    let (volume, largest) = printed[0].trim().split_once(' ').unwrap();
    assert_eq!(Some(number(volume)), report["chambers"]["cavity"]["volume"].as_f64());
    let tags = report["tags"].as_object().unwrap();
    let on_tags =
        tags.values().filter_map(|tag| tag["max_displacement"].as_f64()).fold(0.0, f64::max);
    assert!(number(largest) >= on_tags && number(largest) < 1.5 * on_tags, "{largest} {on_tags}");
    let steps = report["steps"].as_array().unwrap().len();
    assert_eq!(printed[1].lines().count(), 1 + steps, "{}", printed[1]);
    let last = dir.lines("optimize/history.jsonl").pop().unwrap();
    let objective = number(printed[2].split_whitespace().last().unwrap());
    let expected = last["objective"].as_f64().unwrap();
    assert!((objective / expected - 1.0).abs() < 1e-5, "{objective} {expected}");
    assert!(printed[3].contains("displacement"), "{}", printed[3]);
    assert!(printed[4].contains("count") && printed[4].contains("1.0"), "{}", printed[4]);
}
