//! A row: its measured points, the states of its runs there, and the errors.

use super::*;

impl Row {
    /// Compares each of its simulations with the measured points. The two that are the ends of a band are one.
    pub(super) fn compared(&self, folder: &Path) -> Result<Vec<Comparison>> {
        ensure!(
            self.condition.is_some() != self.passage.is_some(),
            "expected either condition, what a state and a line have in common, or passage = \"last\", \"peak\" or \
             \"valley\", a state of each run"
        );
        let mut found: Vec<Comparison> = Vec::new();
        for (i, Run { name, .. }) in self.run.iter().enumerate() {
            if self.run[..i].iter().any(|run| run.name == *name) {
                continue;
            }
            let (mut points, mut values) = (Vec::new(), Vec::new());
            for run in self.run.iter().filter(|run| run.name == *name) {
                let (measured, conditions) = self.measured(folder, run)?;
                values.extend(self.simulated(run, &conditions, folder)?);
                points.extend(measured);
            }
            ensure!(
                values.iter().any(Option::is_some),
                "run \"{name}\": no measured point lies between its states{}",
                self.condition.as_ref().map_or(String::new(), |c| format!(" of {}", c.simulated))
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

    /// The measured points that a run simulates, and the condition of each; 0 without.
    fn measured(&self, folder: &Path, run: &Run) -> Result<(Vec<MeasuredPoint>, Vec<f64>)> {
        let path = folder.join(&self.measured);
        let mut lines = self.r#where.clone();
        lines.extend(run.r#where.clone());
        let table = Table::read(&path, &lines)?;
        let column =
            |title: &String| table.numbers(title).with_context(|| path.display().to_string());
        let x = column(&self.x)?;
        let trials = self.y.iter().map(column).collect::<Result<Vec<_>>>()?;
        let spread = self.spread.as_ref().map(column).transpose()?;
        let conditions = self.condition.as_ref().map(|c| column(&c.measured)).transpose()?;
        let conditions = conditions.unwrap_or_else(|| vec![0.0; x.len()]);
        let point = |(i, &x): (usize, &f64)| {
            let trials: Vec<f64> = trials.iter().map(|trial| trial[i]).collect();
            let low = trials.iter().copied().fold(f64::INFINITY, f64::min);
            let high = trials.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let measured = MeasuredPoint {
                x,
                y: trials.iter().sum::<f64>() / trials.len() as f64,
                spread: spread.as_ref().map_or(0.5 * (high - low), |s| s[i]),
            };
            (measured, conditions[i])
        };
        let [from, to] = self.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let points = x.iter().enumerate().map(point);
        let points: (Vec<MeasuredPoint>, Vec<f64>) =
            points.filter(|(point, _)| (from..=to).contains(&point.x)).unzip();
        ensure!(!points.0.is_empty(), "{}: no line within the range", path.display());
        if let Some(zero) = points.0.iter().find(|point| point.y == 0.0) {
            bail!(
                "{}: the ordinate is 0 at {} = {}: it has no relative error; leave it out by range",
                path.display(),
                self.x,
                zero.x
            );
        }
        Ok(points)
    }

    /// The simulated ordinate at each measured point; none where no state of the run meets the condition.
    fn simulated(&self, run: &Run, wanted: &[f64], folder: &Path) -> Result<Vec<Option<f64>>> {
        let path = folder.join(&run.steps);
        let steps = rows(&path)?;
        let column = |name: &str, from_first_step: bool| -> Result<Vec<f64>> {
            let values: Result<Vec<f64>> = steps.iter().map(|row| number(row, name)).collect();
            let values = values.with_context(|| path.display().to_string())?;
            let zero = values.first().filter(|_| from_first_step).map_or(0.0, |v| *v);
            Ok(values.iter().map(|v| v - zero).collect())
        };
        let values = column(&self.simulated, self.from_first_step)?;
        let Some(condition) = &self.condition else {
            let [peak, valley] = turns(&values);
            let value = match self.passage {
                Some(Passage::Peak) => peak,
                Some(Passage::Valley) => valley,
                Some(Passage::Last) | None => values.last().copied(),
            };
            return Ok(vec![value; wanted.len()]);
        };
        let at = column(&condition.simulated, condition.from_first_step)?;
        let states: Vec<(f64, f64)> = at.into_iter().zip(values).collect();
        let met = |&wanted: &f64| match passages(&states, wanted)[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            ref several => bail!(
                "{}: {} states have {} = {wanted}, as the run goes back and forth; there the ordinate is {several:?}; \
                 leave them out by range",
                path.display(),
                several.len(),
                condition.simulated,
            ),
        };
        wanted.iter().map(met).collect()
    }

    /// Two simulations as one: what of the band between them is nearest to the measured ordinates.
    fn between(&self, ends: &[String; 2], found: &[Comparison]) -> Result<Comparison> {
        let of = |name: &String| found.iter().find(|one| one.run == *name);
        let [Some(a), Some(b)] = ends.each_ref().map(of) else {
            bail!("band: {ends:?}: expected the names of two [[row.run]]");
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
            unit: unit(&self.y[0]).unwrap_or_default().to_owned(),
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
