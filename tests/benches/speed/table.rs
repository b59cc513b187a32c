//! The table that `make bench` prints.

use crate::dense;
use crate::row::{Row, find};
use crate::stored::Stored;

/// Sets the share of the dense rate beside the factorisations.
pub fn compare_dense(rows: &mut [Row]) {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let known = rows.to_vec();
    for row in rows {
        let threads = match row.what.as_str() {
            "factor, 1 thread" => 1,
            "factor" | "factor, double" => all,
            _ => continue,
        };
        let what = dense::name("dense LLᵀ", threads);
        if let Some(dense) = find(&known, &what, &format!("as {}", row.body)) {
            let share = 100.0 * dense.seconds.median / row.seconds.median;
            row.beside = format!("{share:.0} % of the dense rate in double precision");
        }
    }
}

/// All rows, beside the run before.
pub fn render(run: &Stored, before: Option<&Stored>) -> String {
    let mut text = format!("{}\n", run.title());
    match before {
        Some(before) if before.machine == run.machine => {
            text += &format!("compared with {}\n", before.title());
        }
        Some(before) => {
            text += &format!("compared with ANOTHER MACHINE: {}\n", before.title());
        }
        None => text += "no stored run to compare with\n",
    }
    text += &format!(
        "\n{:<21}{:<15}{:>8}{:>11}{:>21}{:>17}{:>10}{:>10}  {}\n",
        "what", "body", "dofs", "median s", "fastest - slowest", "rate", "speed-up", "now/then", ""
    );
    for row in &run.rows {
        let then = before.and_then(|b| b.rows.iter().find(|r| r.key() == row.key()));
        let ratio = then.map_or("-".to_owned(), |then| {
            format!("{:.2}", row.seconds.median / then.seconds.median)
        });
        let speed_up = row.speed_up().map_or("-".to_owned(), |s| format!("{s:.2}"));
        let dofs = row.dofs.map_or("-".to_owned(), |n| n.to_string());
        let s = &row.seconds;
        let spread = format!("{} - {}", short(s.min), short(s.max));
        text += format!(
            "{:<21}{:<15}{dofs:>8}{:>11}{spread:>21}{:>17}{speed_up:>10}{ratio:>10}  {}",
            row.what,
            row.body,
            short(s.median),
            row.work.rate(s.median),
            row.beside
        )
        .trim_end();
        text += "\n";
    }
    text
}

/// Rows that took more than `factor` times as long as in another run, one line each.
pub fn slower(run: &Stored, before: &Stored, factor: f64) -> Vec<String> {
    let judge = |row: &Row| {
        let then = find(&before.rows, &row.what, &row.body)?.seconds.median;
        let now = row.seconds.median;
        (now > factor * then).then(|| {
            let percent = 100.0 * (now / then - 1.0);
            format!(
                "{}: {} s, {} s before: {percent:.0} % slower",
                row.key(),
                short(now),
                short(then)
            )
        })
    };
    run.rows.iter().filter_map(judge).collect()
}

/// Seconds with three digits that count.
fn short(seconds: f64) -> String {
    let decimals = (2.0 - seconds.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{seconds:.decimals$}")
}
