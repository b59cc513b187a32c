//! What was read of bodies from elsewhere, and what was changed of them.

use program::InputFile;
use serde::Serialize;

/// What was read and what was changed, for `model.json`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Record {
    /// The files.
    pub files: Vec<Source>,
    /// Angle at which faces of files of triangles end [deg], if they were parted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub split: Option<f64>,
    /// In the order in which it was done, in words.
    changes: Vec<String>,
    /// The largest distance by which fTetWild moved a surface that it repaired [m].
    #[serde(skip)]
    pub moved: f64,
}

impl Record {
    /// Logs and keeps a change.
    pub fn change(&mut self, text: String) {
        log::info!("{text}");
        self.changes.push(text);
    }
}

/// How the unit of a file is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Known {
    /// The file says it.
    Stated,
    /// The user says it.
    Given,
    /// By its size.
    Guessed,
}

/// A file that was read.
#[derive(Clone, Debug, Serialize)]
pub struct Source {
    #[serde(flatten)]
    /// The file and its hash; in a report its path is seen from the folder of the report.
    pub input: InputFile,
    /// The unit of its lengths.
    pub unit: String,
    /// How that is known.
    pub unit_is: Known,
    /// Number of its triangles.
    pub triangles: usize,
    /// From corner to corner [m].
    pub diagonal: f64,
}

impl Source {
    /// Says how large the body is and how the unit is known.
    pub fn described(&self) -> String {
        let size = format!("{:.4} mm from corner to corner", self.diagonal * 1e3);
        match self.unit_is {
            Known::Stated => format!("{size}; the file states its unit"),
            Known::Given => format!("{size}, in {} as --unit says", self.unit),
            Known::Guessed => {
                format!("no unit is stated: taken for {}, {size}; --unit says otherwise", self.unit)
            }
        }
    }
}
