//! A row: its measured points, the states of its runs there, and the errors.

use reports::BandEnd;

use super::*;

impl Row {
    /// Compares each of its simulations with the measured points. The two that are the ends of a band are one.
    pub(super) fn compared(&self, folder: &Path) -> Result<Vec<Comparison>> {
        self.check()?;
        let mut found: Vec<Comparison> = Vec::new();
        for (i, Run { name, .. }) in self.run.iter().enumerate() {
            if self.run[..i].iter().any(|run| run.name == *name) {
                continue;
            }
            let (mut points, mut values) = (Vec::new(), Vec::new());
            for run in self.run.iter().filter(|run| run.name == *name) {
                let measured = self.measured(folder, run)?;
                values.extend(self.simulated(run, &measured, folder)?);
                points.extend(measured.into_iter().map(|point| point.measured));
            }
            ensure!(
                values.iter().any(Option::is_some),
                "run \"{name}\": no measured point lies between its states; conditions: {}",
                self.condition.iter().map(|c| c.simulated.as_str()).collect::<Vec<_>>().join(", ")
            );
            let fitted = self.run.iter().any(|run| run.name == *name && run.fitted);
            found.push(self.comparison(name.clone(), fitted, points, values));
        }
        if let Some(ends) = &self.band {
            let band = self.between(ends, &found)?;
            // an end alone claims nothing
            found.retain(|one| !ends.contains(&one.run));
            found.push(band);
        }
        Ok(found)
    }

    /// Refuses a row that compares nothing, or whose bounds nothing can meet.
    fn check(&self) -> Result<()> {
        ensure!(!self.y.is_empty(), "y: no column; expected one or more titles of the table");
        ensure!(!self.run.is_empty(), "no [[row.run]]: expected one simulation or more");
        let turns = matches!(self.passage, Some(Passage::Peak | Passage::Valley));
        let chosen = turns || matches!(self.passage, Some(Passage::First | Passage::Last));
        ensure!(
            !self.condition.is_empty() || chosen,
            "condition: none; expected one or more, or passage = \"first\", \"last\", \"peak\" or \"valley\", which \
             takes a state of each run"
        );
        ensure!(
            self.condition.is_empty() || !turns,
            "condition: {} beside a passage that is a maximum or minimum of the ordinate; expected none",
            self.condition.len()
        );
        for (i, condition) in self.condition.iter().enumerate() {
            ensure!(
                condition.measured.is_some() != condition.value.is_some(),
                "condition {} of \"{}\": expected either measured, the title of a column, or value",
                i + 1,
                condition.simulated
            );
        }
        let ordered = |name: &str, [from, to]: [f64; 2]| {
            ensure!(from < to, "{name} = [{from}, {to}]: expected the smaller number first");
            Ok(())
        };
        self.range.map_or(Ok(()), |range| ordered("range", range))?;
        ordered("tolerance", self.tolerance)?;
        for end in self.band.iter().flatten() {
            ensure!(
                self.run.iter().any(|run| run.name == *end),
                "band: no [[row.run]] is called \"{end}\""
            );
        }
        Ok(())
    }

    /// The measured points that a run simulates.
    fn measured(&self, folder: &Path, run: &Run) -> Result<Vec<Point>> {
        let path = folder.join(&self.measured);
        let mut lines = self.lines.clone();
        lines.extend(run.lines.clone());
        let table = Table::read(&path, &lines)?;
        let column =
            |title: &String| table.numbers(title).with_context(|| path.display().to_string());
        let columns = |titles: &[String]| titles.iter().map(column).collect::<Result<Vec<_>>>();
        let (x, trials) = (column(&self.x)?, columns(&self.y)?);
        let spread = self.spread.as_ref().map(column).transpose()?;
        let wanted = |c: &Condition| match (&c.measured, c.value) {
            (Some(title), _) => column(title),
            (None, value) => Ok(vec![value.unwrap_or_default(); x.len()]),
        };
        let conditions = self.condition.iter().map(wanted).collect::<Result<Vec<_>>>()?;
        let at = |values: &[Vec<f64>], i: usize| values.iter().map(|v| v[i]).collect::<Vec<_>>();
        let point = |(i, &x): (usize, &f64)| {
            let trials = at(&trials, i);
            let low = trials.iter().copied().fold(f64::INFINITY, f64::min);
            let high = trials.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let measured = MeasuredPoint {
                x,
                y: trials.iter().sum::<f64>() / trials.len() as f64,
                spread: spread.as_ref().map_or(0.5 * (high - low), |s| s[i]),
            };
            Point { measured, conditions: at(&conditions, i) }
        };
        let [from, to] = self.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let points =
            x.iter().enumerate().map(point).filter(|p| (from..=to).contains(&p.measured.x));
        let points: Vec<Point> = points.collect();
        ensure!(!points.is_empty(), "{}: no line within the range", path.display());
        if let Some(zero) = points.iter().find(|p| p.measured.y == 0.0) {
            anyhow::bail!(
                "{}: the ordinate is 0 at {} = {}: it has no relative error; leave it out by range",
                path.display(),
                self.x,
                zero.measured.x
            );
        }
        Ok(points)
    }

    /// The simulated ordinate at each measured point; none where no state of the run meets the conditions.
    fn simulated(&self, run: &Run, measured: &[Point], folder: &Path) -> Result<Vec<Option<f64>>> {
        let path = folder.join(&run.steps);
        let context = || path.display().to_string();
        let states = self.states(&path).with_context(context)?;
        let (mut values, mut last) = (Vec::new(), f64::NEG_INFINITY);
        for point in measured {
            let met = self.met(&states, &point.conditions, last).with_context(context)?;
            last = met.map_or(last, |met| met.place);
            values.push(met.map(|met| met.value));
        }
        Ok(values)
    }

    /// Where a run meets the conditions of a point, of which the one before is met at `last`; none where it does not.
    fn met(&self, states: &[(Vec<f64>, f64)], wanted: &[f64], last: f64) -> Result<Option<Met>> {
        if let Some(turn @ (Passage::Peak | Passage::Valley)) = self.passage {
            let [peak, valley] = turns(states.iter().map(|(_, value)| *value));
            return Ok(if turn == Passage::Peak { peak } else { valley });
        }
        let found = match wanted {
            [] => {
                let each = states.iter().enumerate();
                each.map(|(i, (_, value))| Met { place: i as f64, value: *value }).collect()
            }
            [wanted] => {
                let path: Vec<_> = states.iter().map(|(c, value)| (c[0], *value)).collect();
                passages(&path, *wanted)
            }
            several => {
                let value = interpolate(states, several);
                return Ok(value.map(|value| Met { place: 0.0, value }));
            }
        };
        match (&found[..], self.passage) {
            ([], _) => Ok(None),
            (all, Some(Passage::Next)) => Ok(all.iter().find(|met| met.place >= last).copied()),
            ([one], _) | ([one, ..], Some(Passage::First)) => Ok(Some(*one)),
            ([.., one], Some(Passage::Last)) => Ok(Some(*one)),
            (several, _) => anyhow::bail!(
                "{} states have {} = {}, as the run goes back and forth; there the ordinate is {:?}\n  \
                 add passage = \"first\", \"last\" or \"next\" to the row",
                several.len(),
                self.condition[0].simulated,
                wanted[0],
                several.iter().map(|met| met.value).collect::<Vec<_>>()
            ),
        }
    }

    /// Values of the conditions and of the ordinate in every state of a run.
    fn states(&self, path: &Path) -> Result<Vec<(Vec<f64>, f64)>> {
        let rows = rows(path)?;
        let column = |name: &str, from_first_step: bool| -> Result<Vec<f64>> {
            let values: Vec<f64> =
                rows.iter().map(|row| number(row, name)).collect::<Result<_>>()?;
            let zero = values.first().filter(|_| from_first_step).map_or(0.0, |v| *v);
            Ok(values.iter().map(|v| v - zero).collect())
        };
        let conditions = self.condition.iter().map(|c| column(&c.simulated, c.from_first_step));
        let conditions: Vec<_> = conditions.collect::<Result<_>>()?;
        let values = column(&self.simulated, self.from_first_step)?;
        let at = |i: usize| conditions.iter().map(|c| c[i]).collect();
        Ok(values.into_iter().enumerate().map(|(i, value)| (at(i), value)).collect())
    }

    /// Two simulations as one: what of the band between them is nearest to the measured ordinates.
    fn between(&self, ends: &[String; 2], found: &[Comparison]) -> Result<Comparison> {
        let of = |name: &String| found.iter().find(|one| one.run == *name);
        let [Some(a), Some(b)] = ends.each_ref().map(of) else {
            anyhow::bail!("band: {ends:?}: expected the names of two runs");
        };
        ensure!(
            a.measured.len() == b.measured.len(),
            "band: \"{}\" has {} points and \"{}\" {}; expected the same lines of the table",
            a.run,
            a.measured.len(),
            b.run,
            b.measured.len()
        );
        let nearest = |(point, (a, b)): (&MeasuredPoint, (&Option<f64>, &Option<f64>))| {
            let (a, b) = ((*a)?, (*b)?);
            Some(point.y.clamp(a.min(b), a.max(b)))
        };
        let both = a.simulated.iter().zip(&b.simulated);
        let values: Vec<Option<f64>> = a.measured.iter().zip(both).map(nearest).collect();
        ensure!(values.iter().any(Option::is_some), "band: no point is reached by both runs");
        let name = format!("{} … {}", a.run, b.run);
        let end =
            |one: &Comparison| BandEnd { run: one.run.clone(), simulated: one.simulated.clone() };
        let band = self.comparison(name, a.fitted || b.fitted, a.measured.clone(), values);
        Ok(Comparison { ends: vec![end(a), end(b)], ..band })
    }

    /// The errors of simulated values, of which one exists at least.
    fn comparison(
        &self,
        run: String,
        fitted: bool,
        measured: Vec<MeasuredPoint>,
        simulated: Vec<Option<f64>>,
    ) -> Comparison {
        let both = || measured.iter().zip(&simulated).filter_map(|(p, s)| Some((p.y, (*s)?)));
        let errors: Vec<f64> = both().map(|(y, s)| s / y - 1.0).collect();
        let differences: Vec<f64> = both().map(|(y, s)| s - y).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let rms = |values: &[f64]| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt();
        let largest =
            errors.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        let [low, high] = self.tolerance;
        Comparison {
            row: self.name.clone(),
            run,
            fitted,
            mean: mean(&errors),
            rms: rms(&errors),
            unit: table::unit(&self.y[0]).unwrap_or_default().to_owned(),
            mean_difference: mean(&differences),
            rms_difference: rms(&differences),
            largest,
            tolerance: self.tolerance,
            within: errors.len() == measured.len()
                && errors.iter().all(|e| (low..=high).contains(e)),
            measured,
            simulated,
            plot: self.plot.clone(),
            reason: self.reason.clone(),
            assumed: self.assumed.clone(),
            held_back: self.held_back.clone(),
            ends: Vec::new(),
        }
    }
}
