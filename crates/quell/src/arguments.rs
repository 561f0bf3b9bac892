//! What may be typed: one definition for parsing, help, completions and the manual page.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Designs passive vibration suppressors: which springs, dampers and inerters, connected how, with what values.
#[derive(Debug, Parser)]
#[command(
    name = "quell",
    version,
    propagate_version = true,
    after_help = "\
Begin here:
  quell check studies/tuned-mass-damper.toml     is the study sound? what will it do?
  quell run studies/tuned-mass-damper.toml       do it: a shortlist here, report.html in runs/
  quell layouts --springs 1 --dampers 1 --inerters 1

Exit codes: 0 done (an infeasible design is done, and says so), 1 the study is wrong, 2 the run failed, 130 it was interrupted."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Read a study and say what it would do, without doing it
    Check(CheckOptions),
    /// Run a study: the shortlist on the terminal, results.json and report.html in a folder
    Run(RunOptions),
    /// List or count the layouts of a budget of elements
    Layouts(LayoutOptions),
    /// Networks that have a given admittance: is it passive, and what can be built?
    #[command(visible_alias = "synthesize")]
    Synthesise(SynthesisOptions),
    /// Print the JSON Schema of study files, for editors
    Schema,
    /// Print the reference of every key of study and host files, as Markdown
    Reference,
    /// Print completions for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, in roff
    Man,
}

#[derive(Debug, Args)]
pub(crate) struct CheckOptions {
    /// The study file
    pub(crate) study: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  quell run studies/tuned-mass-damper.toml
  quell run studies/tuned-mass-damper.toml --task peak --seed 7 --out runs/peak-7
  quell run studies/tuned-mass-damper.toml --force      start afresh over an earlier run

A run that is interrupted loses nothing that was finished: the same command goes on with it.
The same study, seed and version give the same designs on any number of threads.")]
pub(crate) struct RunOptions {
    /// The study file
    pub(crate) study: PathBuf,
    /// Folder for results.json, report.html and the store of finished work [default: runs/STUDY-NAME]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Run this task only (may be given several times)
    #[arg(long, value_name = "NAME")]
    pub(crate) task: Vec<String>,
    /// Seed of the random streams
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Threads [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Begin anew, over an earlier or interrupted run in the folder
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  quell synthesise '(s^2 + s + 1)/(s^2 + s + 4)'
  quell synthesise '(3 s^2 + 3 s + 2)/(3 s + 1)' --impedance
  quell synthesise '(s^2 + 0.1 s + 1)/(s^2 + s + 4)' --nearest

The methods are those of docs/synthesis.md; every network is analysed back from its elements.")]
pub(crate) struct SynthesisOptions {
    /// Y(s), force over velocity (N s/m): a spring is k/s, a damper c, an inerter b*s
    #[arg(value_name = "FUNCTION", allow_hyphen_values = true)]
    pub(crate) function: String,
    /// The function is the impedance Z(s) = 1/Y(s), velocity over force
    #[arg(long)]
    pub(crate) impedance: bool,
    /// Where no passive device has the function: take the nearest that one has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Largest number of elements of the networks that are tried
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u8).range(1..=8))]
    pub(crate) most: u8,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  quell layouts --springs 1 --dampers 1 --inerters 1
  quell layouts --springs 2 --dampers 2 --inerters 2 --count
  quell layouts --springs 1 --dampers 1 --masses 1
  quell layouts --kinds pipe,orifice --branches 4 --at-least pipe=1 --compound pipe
  quell layouts --catalogue

`+` is series, `|` is parallel, `+` binds tighter. Each layout is listed once, up to the order inside a group.")]
pub(crate) struct LayoutOptions {
    /// List the devices that have a name in the field, with their sources
    #[arg(long, exclusive = true)]
    pub(crate) catalogue: bool,
    /// Number of springs
    #[arg(
        long,
        short = 'k',
        value_name = "N",
        default_value_t = 0,
        conflicts_with = "kinds"
    )]
    pub(crate) springs: usize,
    /// Number of dampers
    #[arg(
        long,
        short = 'c',
        value_name = "N",
        default_value_t = 0,
        conflicts_with = "kinds"
    )]
    pub(crate) dampers: usize,
    /// Number of inerters
    #[arg(
        long,
        short = 'b',
        value_name = "N",
        default_value_t = 0,
        conflicts_with = "kinds"
    )]
    pub(crate) inerters: usize,
    /// Number of masses (at the far end of a device)
    #[arg(
        long,
        short = 'm',
        value_name = "N",
        default_value_t = 0,
        conflicts_with = "kinds"
    )]
    pub(crate) masses: usize,
    /// Kinds of branch of your own, separated by commas, each a single element unless named in --compound
    #[arg(
        long,
        value_delimiter = ',',
        requires = "branches",
        value_name = "KIND,…"
    )]
    pub(crate) kinds: Vec<String>,
    /// Number of branches of those kinds
    #[arg(long, requires = "kinds", value_name = "N")]
    pub(crate) branches: Option<usize>,
    /// At least so many branches of a kind (may be given several times)
    #[arg(long, requires = "kinds", value_name = "KIND=N")]
    pub(crate) at_least: Vec<String>,
    /// Those of the kinds that are made of several elements, and so do not merge with their like side by side
    #[arg(long, requires = "kinds", value_delimiter = ',', value_name = "KIND,…")]
    pub(crate) compound: Vec<String>,
    /// List reducible layouts too: two like elements side by side in one group
    #[arg(long)]
    pub(crate) reducible: bool,
    /// Print the number only
    #[arg(long)]
    pub(crate) count: bool,
}
