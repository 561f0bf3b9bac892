//! From a study file to a [`Study`]: keys checked, names resolved, layouts parsed; every fault at its place.

mod band;
mod candidates;
mod continuation;
mod criteria;
mod design;
mod devices;
mod immittance;
mod objectives;
mod simulate;
mod slots;
mod sweep;
mod tasks;
mod transient;

pub(crate) use slots::kinds_of;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Document, Fault, Source, Table, Value};
use quell_expression::{Function, Span, nearest};
use quell_model::{HostFile, LinearHost, Waveform};

use crate::amount::Amount;
use crate::keys;
use crate::study::{FrequencyRun, ReportWishes, Run, Study};

/// The version of study files that this Quell writes and reads.
pub const FILE_VERSION: i64 = 1;

impl Study {
    /// Reads a study file and the files that it names.
    ///
    /// # Errors
    /// Whatever is wrong with the file, at its place and with a remedy.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
        let text = String::from_utf8(bytes).map_err(|error| not_text(path, &error))?;
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        Self::parse(Source::new(path.display().to_string(), text), &folder)
    }

    /// Reads the text of a study; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(source: Source, folder: &Path) -> Result<Self, Fault> {
        let source = Arc::new(source);
        let document = Arc::new(Document::parse(Arc::clone(&source))?);
        let root = document.root();
        check_version(&root)?;
        root.check(&keys::STUDY)?;

        let host = read_host(&root.require("host")?, folder)?;
        let overrides = amounts_of(root.get("parameters"), &source)?;
        // The host as it stands tells the names of ports, inputs and outputs.
        let standing = crate::situation::build(&host, &overrides, &[])?;

        let components = devices::components(root.get("components"), &source)?;
        let laws = devices::laws(root.get("elements"), &source)?;
        let kinds = devices::declared(
            root.get("elements"),
            &laws,
            &components,
            root.get("components"),
        )?;
        let components = devices::component_layouts(components, &kinds)?;
        // Whoever only follows branches may do without these; stable bands need neither runs nor, of a host that has none, devices.
        let bands = band::alone(&root);
        let free = continuation::alone(&root);
        let section = |key: &str| match root.get(key) {
            None if free || (bands && key != "criteria") => Ok(None),
            None => {
                let known = keys::STUDY.keys.iter().find(|known| known.name == key);
                let words = known.map_or("", |known| known.documentation);
                let missing = root.require(key).map(Some);
                missing.map_err(|fault| fault.help(format!("`{key}`: {words}")))
            }
            Some(value) => Ok(Some(value)),
        };
        let devices = match section("devices")? {
            Some(value) => devices::devices(&value, &kinds, &standing.host, &source)?,
            None => IndexMap::new(),
        };
        let runs = match section("runs")? {
            Some(value) => runs(&value, &standing.host, &source)?,
            None => IndexMap::new(),
        };
        let criteria = match section("criteria")? {
            Some(value) => criteria::criteria(&value, &runs, &standing, &source)?,
            None => IndexMap::new(),
        };
        let mut study = Self {
            title: root.require("title")?.as_str()?.to_owned(),
            hash: hash(&source.text, &host, &samples(&document, folder))?,
            source,
            document: Arc::clone(&document),
            folder: folder.to_path_buf(),
            host,
            overrides,
            kinds,
            components,
            immittances: IndexMap::new(),
            laws,
            devices,
            runs,
            criteria,
            tasks: Vec::new(),
            report: report(root.get("report"))?,
        };
        immittance::declare(&root.require("tasks")?, &mut study)?;
        study.tasks = tasks::tasks(&root.require("tasks")?, &study)?;
        Ok(study)
    }
}

/// A study that cannot be opened.
fn unreadable(path: &Path, error: &std::io::Error) -> Fault {
    let shown = path.display();
    let message = match error.kind() {
        std::io::ErrorKind::NotFound => format!("there is no study `{shown}`"),
        _ if path.is_dir() => format!("`{shown}` is a folder, not a study"),
        _ => format!("the study `{shown}` cannot be read: {error}"),
    };
    Fault::new(message).help("give the path of a study file, such as `studies/quarter-car.toml`")
}

/// A study with bytes that are no UTF-8: shown where the first of them stands.
fn not_text(path: &Path, error: &std::string::FromUtf8Error) -> Fault {
    let good = error.utf8_error().valid_up_to();
    let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
    let source = Arc::new(Source::new(path.display().to_string(), text));
    let span = Span::new(good, good + char::REPLACEMENT_CHARACTER.len_utf8());
    Fault::at(&source, span, "this character is not UTF-8")
        .help("save the file with the encoding UTF-8")
}

fn check_version(root: &Table<'_>) -> Result<(), Fault> {
    let Some(value) = root.get("quell") else {
        return Err(root
            .fault("the file does not say which version of the format it is written in")
            .help(format!("begin the file with `quell = {FILE_VERSION}`")));
    };
    let version = value.as_integer()?;
    if version == FILE_VERSION {
        return Ok(());
    }
    let help = if version > FILE_VERSION {
        "a newer Quell wrote it: update Quell".to_owned()
    } else {
        format!("write `quell = {FILE_VERSION}`")
    };
    Err(value
        .fault(format!(
            "this Quell reads version {FILE_VERSION} of study files, not {version}"
        ))
        .help(help))
}

fn read_host(value: &Value<'_>, folder: &Path) -> Result<HostFile, Fault> {
    let path = folder.join(value.as_str()?);
    if path.is_dir() {
        return Err(value
            .fault(format!("`{}` is a folder, not a host file", path.display()))
            .help("name the file in it"));
    }
    if !path.is_file() {
        return Err(value
            .fault(format!("the host file `{}` does not exist", path.display()))
            .help("the path is relative to the study file"));
    }
    HostFile::read(&path).map_err(|fault| {
        // A file that is not even text has no place of its own.
        if fault.source.is_some() {
            fault
        } else {
            Fault {
                help: fault.help,
                ..value.fault(fault.message)
            }
        }
    })
}

/// A table of named tables; whoever writes a list of them or a single value is told how it is written.
fn named_tables<'a>(value: &Value<'a>, section: &str) -> Result<Table<'a>, Fault> {
    value
        .as_table()
        .map_err(|fault| fault.help(format!("write `[{section}.NAME]` for each")))
}

/// Files of samples that signals of runs name, wherever a run or a configuration gives them.
fn samples(document: &Document, folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = document
        .tables()
        .iter()
        .filter_map(|table| Waveform::file(table, folder))
        .filter(|file| file.is_file())
        .collect();
    files.sort();
    files.dedup();
    files
}

/// BLAKE3 of everything that determines the results: Quell's version, study, host, matrices, samples.
fn hash(text: &str, host: &HostFile, samples: &[PathBuf]) -> Result<String, Fault> {
    let mut hasher = blake3::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(env!("CARGO_PKG_VERSION").as_bytes());
    add(text.as_bytes());
    add(host.source().text.as_bytes());
    for path in host.matrix_files().iter().chain(samples) {
        let bytes = std::fs::read(path).map_err(|error| {
            Fault::new(format!(
                "the file `{}` cannot be read: {error}",
                path.display()
            ))
        })?;
        add(&bytes);
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// A table of amounts, by name.
fn amounts_of(
    value: Option<Value<'_>>,
    source: &Arc<Source>,
) -> Result<IndexMap<String, Amount>, Fault> {
    let Some(value) = value else {
        return Ok(IndexMap::new());
    };
    value
        .as_table()?
        .entries()
        .map(|(name, _, value)| Ok((name.to_owned(), Amount::read(&value, source)?)))
        .collect()
}

/// The index of a name among others, or a fault at it with the nearest.
fn resolve<'a>(
    value: &Value<'_>,
    what: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Fault> {
    let name = value.as_str()?;
    names
        .clone()
        .position(|known| known == name)
        .ok_or_else(|| {
            unknown(
                value.fault(format!("there is no {what} `{name}`")),
                name,
                what,
                names,
            )
        })
}

/// Adds the nearest valid name, or all of them.
fn unknown<'a>(
    fault: Fault,
    name: &str,
    what: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Fault {
    if let Some(near) = nearest(name, names.clone()) {
        return fault.help(format!("did you mean `{near}`?"));
    }
    let all: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    fault.help(match all.as_slice() {
        [] => format!("no {what} is defined"),
        [only] => format!("there is only {only}"),
        [first @ .., last] if all.len() <= 12 => {
            format!("there are {} and {last}", first.join(", "))
        }
        [first, second, third, ..] => {
            format!(
                "there are {}, among them {first}, {second} and {third}",
                all.len()
            )
        }
        [first, ..] => format!("there is {first}"),
    })
}

/// Names of the user's that expressions may use must not be taken by functions or constants.
fn check_name(name: &str, span: Span, table: &Table<'_>) -> Result<(), Fault> {
    let mut characters = name.chars();
    let sound = characters
        .next()
        .is_some_and(|first| first.is_alphabetic() || first == '_')
        && characters.all(|other| other.is_alphanumeric() || other == '_');
    if !sound {
        return Err(Fault::at(
            table.source(),
            span,
            format!("`{name}` cannot be used as a name"),
        )
        .help("a name begins with a letter and goes on with letters, digits and `_`"));
    }
    if Function::from_name(name).is_some() || name == "pi" {
        return Err(Fault::at(
            table.source(),
            span,
            format!("`{name}` is the name of a function or constant"),
        )
        .help("choose another name"));
    }
    Ok(())
}

fn runs(
    value: &Value<'_>,
    host: &LinearHost,
    source: &Arc<Source>,
) -> Result<IndexMap<String, Run>, Fault> {
    let table = named_tables(value, "runs")?;
    let mut runs = IndexMap::new();
    for (name, span, value) in table.entries() {
        check_name(name, span, &table)?;
        let entry = named_tables(&value, "runs")?;
        entry.check(&keys::RUN)?;
        let kind = entry
            .require("kind")?
            .one_of(&["frequency", "modes", "transient"])?;
        let own: &[&str] = match kind {
            "modes" => &["modes"],
            "transient" => &transient::KEYS,
            _ => &["input", "band", "spectrum"],
        };
        let strangers = ["input", "band", "spectrum", "modes"]
            .iter()
            .chain(&transient::KEYS)
            .filter(|key| !own.contains(key));
        for key in strangers {
            if let Some(stranger) = entry.key_span(key) {
                return Err(Fault::at(
                    source,
                    stranger,
                    format!("`{key}` is no key of a `{kind}` run"),
                ));
            }
        }
        let run = if kind == "transient" {
            transient::run(&entry, name, span, source)?
        } else if kind == "modes" {
            let which = entry
                .get("modes")
                .map(|value| value.one_of(&["all", "oscillatory"]))
                .transpose()?;
            if host.loss.is_some() {
                return Err(Fault::at(source, span, "modes cannot be taken of a host with loss factors")
                    .help("a loss factor is defined for harmonic motion only; give damping as `modal` or `rayleigh`, or use a `frequency` run"));
            }
            Run::Modes {
                oscillatory: which == Some("oscillatory"),
                span,
            }
        } else {
            let input = entry.get("input").ok_or_else(|| {
                let inputs: Vec<String> = host
                    .inputs
                    .iter()
                    .map(|input| format!("`input = \"{}\"`", input.name))
                    .collect();
                let fault = entry.fault(format!(
                    "the run `{name}` does not say which input shakes the host"
                ));
                if inputs.is_empty() {
                    fault.help("the host has no input: add one to it under `[inputs]`")
                } else {
                    fault.help(format!("add {}", inputs.join(" or ")))
                }
            })?;
            let index = resolve(
                &input,
                "input",
                host.inputs.iter().map(|input| input.name.as_str()),
            )?;
            let band = entry
                .get("band")
                .map(|band| read_band(&band, source))
                .transpose()?;
            Run::Frequency(Box::new(FrequencyRun {
                input: host
                    .inputs
                    .get(index)
                    .map_or_else(String::new, |input| input.name.clone()),
                input_span: input.span(),
                band,
                spectrum: entry
                    .get("spectrum")
                    .map(|value| Amount::read(&value, source))
                    .transpose()?,
                span,
            }))
        };
        runs.insert(name.to_owned(), run);
    }
    Ok(runs)
}

fn read_band(value: &Value<'_>, source: &Arc<Source>) -> Result<(Amount, Amount), Fault> {
    const EXAMPLE: &str = "write `band = [\"0 Hz\", \"30 Hz\"]`";
    match value
        .as_array()
        .map_err(|fault| fault.help(EXAMPLE))?
        .as_slice()
    {
        [lower, upper] => Ok((Amount::read(lower, source)?, Amount::read(upper, source)?)),
        other => Err(value
            .fault(format!(
                "a band has a lower and an upper frequency, found {}",
                counted(other.len(), "value")
            ))
            .help(EXAMPLE)),
    }
}

/// `1 value`, `3 values`.
fn counted(number: usize, what: &str) -> String {
    if number == 1 {
        format!("1 {what}")
    } else {
        format!("{number} {what}s")
    }
}

fn report(value: Option<Value<'_>>) -> Result<ReportWishes, Fault> {
    let mut wishes = ReportWishes {
        shortlist: 5,
        note: None,
    };
    if let Some(value) = value {
        let table = value.as_table()?;
        table.check(&keys::REPORT)?;
        if let Some(value) = table.get("shortlist") {
            wishes.shortlist = value.as_count()?;
            if wishes.shortlist == 0 {
                return Err(value
                    .fault("a shortlist holds at least one design")
                    .help("leave `shortlist` out for the best five"));
            }
        }
        wishes.note = table
            .get("note")
            .map(|value| value.as_str().map(str::to_owned))
            .transpose()?;
    }
    Ok(wishes)
}
