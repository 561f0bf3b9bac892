//! A host file and the host it describes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use faer::Mat;
use quell_document::{Document, Fault, Source, Table, Value};
use quell_expression::{Expression, ExpressionError, Quantity};

use super::elements::NamedElement;
use super::keys;
use super::names::Names;
use super::parameters::{Override, parameters};
use super::{coordinates, linear, outputs, ports};
use crate::equations::{Amounts, Waveform, signal};
use crate::form::{SignalNames, linear_form};
use crate::linear::{LinearForm, LinearHost};

/// The sections each of which makes a host one that is written as equations.
const EQUATION_SECTIONS: [&str; 3] = ["equations", "lagrangian", "states"];

/// The format this version reads.
const FORMAT: i64 = 1;

/// A host file as typed, with the place of everything.
#[derive(Debug, Clone)]
pub struct HostFile {
    document: Arc<Document>,
    folder: PathBuf,
    title: String,
}

/// A host in SI, with what study files may refer to beside its equations.
#[derive(Debug, Clone)]
pub struct Host {
    /// Coordinates, matrices, inputs, ports and outputs.
    pub linear: LinearHost,
    /// The parameters in file order.
    pub parameters: Vec<(String, Quantity)>,
    /// Elements with a name, for `force(name)` and `stroke(name)`.
    pub elements: Vec<NamedElement>,
    /// Each coordinate and its rate where a run in time begins.
    pub starts: Vec<[f64; 2]>,
    /// What each input is in a run in time, if the file says so.
    pub waveforms: Vec<Option<Waveform>>,
}

impl Host {
    /// Names for [`linear_form`] as far as the host knows them; a study adds its devices and their parts.
    #[must_use]
    pub fn names(&self) -> SignalNames<'_> {
        SignalNames {
            constants: &self.parameters,
            elements: &self.elements,
            ..SignalNames::default()
        }
    }

    /// [`linear_form`] with the host's own names.
    ///
    /// # Errors
    /// As [`linear_form`].
    pub fn form(
        &self,
        expression: &Expression,
    ) -> Result<(LinearForm, quell_expression::Dimension), ExpressionError> {
        linear_form(&self.linear, expression, &self.names())
    }
}

impl HostFile {
    /// Reads a host file; matrices it names are looked for in its folder.
    ///
    /// # Errors
    /// The file cannot be read, or is no host file; see [`HostFile::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Fault> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => Fault::new(format!("there is no host file `{name}`"))
                .help("a path is relative to the file that names it"),
            std::io::ErrorKind::InvalidData => {
                Fault::new(format!("the host file `{name}` is not text"))
                    .help("save it with the encoding UTF-8")
            }
            _ => Fault::new(format!("the host file `{name}` cannot be read: {error}")),
        })?;
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::parse(Arc::new(Source::new(name, text)), folder)
    }

    /// Reads the text of a host file; relative paths in it start at `folder`.
    ///
    /// # Errors
    /// Syntax, another format version, unknown or missing keys, each with its place.
    #[expect(
        clippy::needless_pass_by_value,
        reason = "the source goes on living in the file's document"
    )]
    pub fn parse(source: Arc<Source>, folder: impl Into<PathBuf>) -> Result<Self, Fault> {
        let document = Document::parse(Arc::clone(&source))?;
        let root = document.root();
        let version = root.get("quell").ok_or_else(|| {
            root.fault("the file does not say which version of the format it is written in")
                .help(format!("begin the file with `quell = {FORMAT}`"))
        })?;
        let number = version.as_integer()?;
        if number != FORMAT {
            return Err(version
                .fault(format!("this file is in format {number}"))
                .help(format!("this version of Quell reads format {FORMAT}")));
        }
        root.check(&keys::HOST)?;
        let written = EQUATION_SECTIONS
            .iter()
            .find_map(|section| Some((*section, root.get(section)?)));
        match (root.get("linear"), &written) {
            (Some(_), Some((section, value))) => {
                return Err(value
                    .fault(format!(
                        "`[linear]` and `[{section}]` cannot be used together"
                    ))
                    .help("write the springs, dampers and masses into the equations"));
            }
            (None, None) => {
                return Err(root
                    .fault("the file does not say what the host is made of")
                    .help("write `[linear]`, or its dynamics as `[equations]`, `[lagrangian]` or `[states]`"));
            }
            _ => {}
        }
        let title = match root.get("title") {
            Some(title) => title.as_str()?.to_owned(),
            None => source.name.clone(),
        };
        for section in [
            "parameters",
            "coordinates",
            "inputs",
            "linear",
            "states",
            "definitions",
            "functions",
            "equations",
            "lagrangian",
            "ports",
            "outputs",
            "operating",
        ] {
            if let Some(value) = root.get(section) {
                value.as_table()?;
            }
        }
        if let Some(linear) = root.get("linear") {
            linear.as_table()?.check(&keys::LINEAR)?;
            for section in ["dimensionless", "definitions", "functions", "operating"] {
                if let Some(value) = root.get(section) {
                    return Err(value
                        .fault(format!(
                            "`{section}` belongs to a host written as equations"
                        ))
                        .help("leave it out, or write `[equations]` instead of `[linear]`"));
                }
            }
        }
        Ok(Self {
            document: Arc::new(document),
            folder: folder.into(),
            title,
        })
    }

    /// The title, or the file's name.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The text, for messages and hashes.
    #[must_use]
    pub fn source(&self) -> &Arc<Source> {
        self.document.source()
    }

    /// The folder at which relative paths start.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The files of matrices and of samples that the host names, as paths that can be opened; a study's hash covers them.
    #[must_use]
    pub fn matrix_files(&self) -> Vec<PathBuf> {
        let root = self.document.root();
        let matrices = root
            .get("linear")
            .and_then(|linear| linear.as_table().ok()?.get("matrices")?.as_table().ok());
        let mut files: Vec<PathBuf> = matrices
            .iter()
            .flat_map(Table::entries)
            .filter_map(|(_, _, value)| value.as_str().ok())
            .map(|reference| crate::matrix::matrix_path(reference, &self.folder))
            .collect();
        let inputs = root.get("inputs").and_then(|inputs| inputs.as_table().ok());
        for (_, _, input) in inputs.iter().flat_map(Table::entries) {
            let signal = input.as_table().ok().and_then(|input| input.get("signal"));
            files.extend(signal.and_then(|signal| signal::file(&signal, &self.folder)));
        }
        files.sort();
        files.dedup();
        files
    }

    /// Whether the host is written as equations: its dynamics then are [`HostFile::equations`], otherwise [`HostFile::assemble`].
    #[must_use]
    pub fn is_equations(&self) -> bool {
        let root = self.document.root();
        EQUATION_SECTIONS
            .iter()
            .any(|section| root.get(section).is_some())
    }

    pub(crate) fn document(&self) -> &Document {
        &self.document
    }

    /// The parameters in file order, some of them replaced.
    ///
    /// # Errors
    /// A replaced parameter that the host does not have or of another dimension; a value that cannot be worked out; a cycle.
    pub fn parameters(&self, overrides: &[Override]) -> Result<Vec<(String, Quantity)>, Fault> {
        let table = section(&self.document.root(), "parameters")?;
        parameters(table.as_ref(), overrides, &mut Names::default())
    }

    /// The host's equations, some parameters replaced.
    ///
    /// # Errors
    /// As [`HostFile::assemble`].
    pub fn build(&self, overrides: &[Override]) -> Result<LinearHost, Fault> {
        Ok(self.assemble(overrides)?.linear)
    }

    /// The host's equations, parameters and named elements, some parameters replaced.
    ///
    /// # Errors
    /// Whatever is wrong in the file or the matrices it names, with its place in the host file.
    pub fn assemble(&self, overrides: &[Override]) -> Result<Host, Fault> {
        let root = self.document.root();
        if self.is_equations() {
            return Err(root
                .fault("this host is written as equations, and a linear one is needed here")
                .help("a host with `[linear]` has frequency responses and modes of its own"));
        }
        let mut names = Names::default();
        let parameters = parameters(
            section(&root, "parameters")?.as_ref(),
            overrides,
            &mut names,
        )?;
        let coordinates = root.require("coordinates")?.as_table()?;
        let linear = root.require("linear")?.as_table()?;
        linear.check(&keys::LINEAR)?;
        let layout = coordinates::layout(
            &coordinates,
            section(&root, "inputs")?.as_ref(),
            &linear,
            &parameters,
            &mut names,
        )?;
        let (free, inputs) = (layout.free.len(), layout.inputs.len());
        let empty = || Mat::zeros(free, inputs);
        let mut host = Host {
            linear: LinearHost {
                name: self.title.clone(),
                coordinates: layout.coordinates(),
                mass: Mat::zeros(free, free),
                damping: Mat::zeros(free, free),
                stiffness: Mat::zeros(free, free),
                loss: None,
                inputs: layout.inputs.clone(),
                forcing: [empty(), empty(), empty()],
                ports: Vec::new(),
                outputs: Vec::new(),
            },
            starts: layout.starts(),
            waveforms: Vec::new(),
            parameters,
            elements: Vec::new(),
        };
        host.waveforms = waveforms(&host, section(&root, "inputs")?.as_ref(), &self.folder)?;
        let base = linear::stamp(&mut host, &layout, &linear, &self.folder)?;
        if let Some(table) = section(&root, "inputs")? {
            linear::forces(&mut host, &table, base.as_ref())?;
        }
        if let Some(table) = section(&root, "ports")? {
            host.linear.ports = ports::ports(&host, &table, base.as_ref())?;
        }
        if let Some(table) = section(&root, "outputs")? {
            outputs::outputs(&mut host, &table, &mut names)?;
        }
        let linear = &host.linear;
        let finite = linear.mass.is_all_finite()
            && linear.damping.is_all_finite()
            && linear.stiffness.is_all_finite()
            && linear.loss.as_ref().is_none_or(Mat::is_all_finite)
            && linear.forcing.iter().all(Mat::is_all_finite);
        if finite {
            Ok(host)
        } else {
            Err(root
                .require("linear")?
                .as_table()?
                .fault("the host's matrices hold numbers that are too large"))
        }
    }
}

/// What the inputs are in a run in time.
fn waveforms(
    host: &Host,
    inputs: Option<&Table<'_>>,
    folder: &Path,
) -> Result<Vec<Option<Waveform>>, Fault> {
    let amounts = Amounts {
        parameters: &host.parameters,
        dimensionless: false,
    };
    host.linear
        .inputs
        .iter()
        .map(|input| {
            let given = inputs.and_then(|table| table.get(&input.name));
            let Some(given) = given else {
                return Ok(None);
            };
            given
                .as_table()?
                .get("signal")
                .map(|value| signal::waveform(&value, input.dimension, amounts, folder))
                .transpose()
        })
        .collect()
}

/// A section that may be left out.
pub(crate) fn section<'a>(root: &Table<'a>, name: &str) -> Result<Option<Table<'a>>, Fault> {
    root.get(name)
        .map(|value: Value<'a>| value.as_table())
        .transpose()
}
