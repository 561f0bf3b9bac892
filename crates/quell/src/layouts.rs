//! `quell layouts`: list or count the layouts of a budget.

use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};

use quell_network::{Budget, CATALOGUE, Domain, Element, Enumeration, Equivalence, Kinds};

use crate::arguments::LayoutOptions;
use crate::terminal::{self, Exit};

/// Layouts with masses are counted one by one, since not all of them can be built; beyond this nobody would wait.
const MOST_WITH_MASSES: u128 = 100_000_000;

pub(crate) fn layouts(options: &LayoutOptions) -> Result<(), Exit> {
    if options.catalogue {
        return terminal::print(&catalogue());
    }
    let enumeration = enumeration(options)?;
    // Of the layouts with masses only those exist in which every mass ends the device.
    let masses = options.masses > 0;
    if options.count {
        let count = if masses {
            count_ending_in_mass(&enumeration)?
        } else {
            enumeration.count()
        };
        return terminal::print(&format!("{count}\n"));
    }
    let mut listed: u128 = 0;
    let mut output = io::BufWriter::new(io::stdout().lock());
    for layout in &enumeration {
        let layout = if masses {
            match layout.place_mass() {
                Ok(placed) => placed,
                Err(_) => continue,
            }
        } else {
            layout
        };
        writeln!(output, "{layout}").map_err(|error| terminal::output_failed(&error))?;
        listed += 1;
    }
    output
        .flush()
        .map_err(|error| terminal::output_failed(&error))?;
    drop(output);
    // A person is told what was counted; a pipe gets layouts and nothing else.
    if io::stdout().is_terminal() {
        let plural = if listed == 1 { "" } else { "s" };
        terminal::print(&format!(
            "\n{listed} layout{plural}, each once {}\n",
            enumeration.equivalence()
        ))?;
    }
    Ok(())
}

/// Name, layout, words and source of every device that has a name.
fn catalogue() -> String {
    let layouts: Vec<String> = CATALOGUE
        .iter()
        .map(|entry| match entry.text() {
            Some(text) => text.to_owned(),
            None => entry
                .parts
                .iter()
                .map(|part| {
                    let (from, to) = part.between;
                    if from == to {
                        format!("{} at {from}", part.layout)
                    } else {
                        format!("{} {from} to {to}", part.layout)
                    }
                })
                .collect::<Vec<_>>()
                .join(", "),
        })
        .collect();
    let width = |texts: &mut dyn Iterator<Item = usize>| texts.max().unwrap_or(0);
    let names = width(&mut CATALOGUE.iter().map(|entry| entry.name.len()));
    let wide = width(
        &mut layouts
            .iter()
            .map(String::len)
            .filter(|length| *length < 40),
    );
    let mut text = String::new();
    for (entry, layout) in CATALOGUE.iter().zip(&layouts) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:names$}  {layout:wide$}  {} ({})",
            entry.name, entry.title, entry.source
        );
    }
    text
}

fn enumeration(options: &LayoutOptions) -> Result<Enumeration, Exit> {
    let equivalence = if options.reducible {
        Equivalence::Commutative
    } else {
        Equivalence::Irreducible
    };
    let mut kinds = Kinds::new(Domain::Translational);
    let budgets = if options.kinds.is_empty() {
        elements(options)?
    } else {
        own_kinds(options, &mut kinds)?
    };
    Enumeration::new(&kinds, &budgets, options.branches, equivalence)
        .map_err(|error| Exit::Asked(error.to_string()))
}

fn elements(options: &LayoutOptions) -> Result<Vec<Budget>, Exit> {
    let asked = [
        ("k", options.springs),
        ("c", options.dampers),
        ("b", options.inerters),
        ("m", options.masses),
    ];
    let budgets: Vec<Budget> = asked
        .into_iter()
        .filter(|(_, number)| *number > 0)
        .map(|(letter, number)| Budget::exactly(letter, number))
        .collect();
    if budgets.is_empty() {
        return Err(Exit::Asked(
            "nothing was asked for; say how many elements of each kind, such as `--springs 1 --dampers 1 --inerters 1`, \
             or name kinds of your own by `--kinds`"
                .to_owned(),
        ));
    }
    Ok(budgets)
}

fn own_kinds(options: &LayoutOptions, kinds: &mut Kinds) -> Result<Vec<Budget>, Exit> {
    // Kinds made of several elements stay apart side by side; a kind that is one element merges with its like.
    for name in &options.kinds {
        let declared = if options.compound.contains(name) {
            kinds.declare_component(name)
        } else {
            kinds.declare_element(name, Element::Damper)
        };
        declared.map_err(|error| Exit::Asked(error.to_string()))?;
    }
    let known = |name: &str| -> Result<(), Exit> {
        if options.kinds.iter().any(|kind| kind == name) {
            return Ok(());
        }
        let kinds = options.kinds.iter().map(String::as_str);
        Err(Exit::Asked(match quell_expression::nearest(name, kinds) {
            Some(near) => format!("`{name}` is not among the kinds; did you mean `{near}`?"),
            None => format!(
                "`{name}` is not among the kinds `{}`",
                options.kinds.join("`, `")
            ),
        }))
    };
    for name in &options.compound {
        known(name)?;
    }
    let mut least: Vec<(&str, usize)> = Vec::new();
    for text in &options.at_least {
        let (name, number) = text
            .split_once('=')
            .and_then(|(name, number)| Some((name.trim(), number.trim().parse().ok()?)))
            .ok_or_else(|| {
                Exit::Asked(format!(
                    "`--at-least {text}` is not KIND=N, such as `{}=1`",
                    options.kinds.first().map_or("spring", String::as_str)
                ))
            })?;
        known(name)?;
        least.push((name, number));
    }
    let demanded = least
        .iter()
        .fold(0_usize, |sum, (_, number)| sum.saturating_add(*number));
    if let Some(branches) = options.branches.filter(|branches| demanded > *branches) {
        return Err(Exit::Asked(format!(
            "at least {demanded} branches are demanded, but a layout is to have {branches}"
        )));
    }
    Ok(options
        .kinds
        .iter()
        .map(|name| {
            let number = least
                .iter()
                .filter(|(kind, _)| kind == name)
                .map(|(_, number)| *number)
                .max()
                .unwrap_or(0);
            Budget::any(name)
                .at_least(number)
                .single_element(!options.compound.contains(name))
        })
        .collect())
}

fn count_ending_in_mass(enumeration: &Enumeration) -> Result<u128, Exit> {
    if enumeration.count() > MOST_WITH_MASSES {
        return Err(Exit::Asked(format!(
            "there are {} layouts, of which those that end in a mass can only be counted one by one; ask for fewer elements",
            enumeration.count()
        )));
    }
    Ok(enumeration
        .iter()
        .filter(quell_network::Layout::ends_in_mass)
        .count() as u128)
}
