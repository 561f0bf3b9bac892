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
use crate::form::{SignalNames, linear_form};
use crate::linear::{LinearForm, LinearHost};

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
        let title = match root.get("title") {
            Some(title) => title.as_str()?.to_owned(),
            None => source.name.clone(),
        };
        for section in [
            "parameters",
            "coordinates",
            "inputs",
            "linear",
            "ports",
            "outputs",
        ] {
            if let Some(value) = root.get(section) {
                value.as_table()?;
            }
        }
        root.require("linear")?.as_table()?.check(&keys::LINEAR)?;
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

    /// The matrix files that the host names, as paths that can be opened; a study's hash covers them.
    #[must_use]
    pub fn matrix_files(&self) -> Vec<PathBuf> {
        let Some(matrices) = self
            .document
            .root()
            .get("linear")
            .and_then(|linear| linear.as_table().ok()?.get("matrices")?.as_table().ok())
        else {
            return Vec::new();
        };
        let mut files: Vec<PathBuf> = matrices
            .entries()
            .filter_map(|(_, _, value)| value.as_str().ok())
            .map(|reference| crate::matrix::matrix_path(reference, &self.folder))
            .collect();
        files.sort();
        files.dedup();
        files
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
            parameters,
            elements: Vec::new(),
        };
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

/// A section that may be left out.
fn section<'a>(root: &Table<'a>, name: &str) -> Result<Option<Table<'a>>, Fault> {
    root.get(name)
        .map(|value: Value<'a>| value.as_table())
        .transpose()
}
