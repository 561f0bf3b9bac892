//! From a function that a search has found to networks that have it.

use indexmap::IndexMap;
use quell_network::{
    Matching, RationalFunction, Realisation, SynthesisError, bott_duffin, reduced_bott_duffin,
};

use super::candidate::Found;
use crate::outcome::{RealisedNetwork, Synthesis};
use crate::study::Study;

/// A regular biquadratic needs at most five elements (Jiang and Smith 2011); more are left to general methods.
const MOST_MATCHED: usize = 5;

/// The functions of a design with their networks; none where it has no function.
pub(super) fn of(study: &Study, found: &Found) -> Vec<Synthesis> {
    let mut all = Vec::new();
    for (slot, layout, _) in &found.candidate.layouts {
        let mut branches = layout.branches();
        let (Some(branch), None) = (branches.next(), branches.next()) else {
            continue;
        };
        let form = study.immittances.iter().find(|(name, _)| {
            branch
                .name
                .strip_prefix(name.as_str())
                .is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()))
        });
        let device = found
            .evaluated
            .devices
            .iter()
            .find(|device| device.name == slot.device);
        let (Some((_, form)), Some(device)) = (form, device) else {
            continue;
        };
        let value = |name: &str| {
            let full = format!("{}.{name}", branch.name);
            device
                .variables
                .iter()
                .find(|variable| variable.name == full)
                .map_or(f64::NAN, |variable| variable.value)
        };
        let Ok(function) = form.function(value) else {
            continue;
        };
        all.push(synthesised(&slot.device, &function));
    }
    all
}

fn synthesised(device: &str, function: &RationalFunction) -> Synthesis {
    let mut networks: Vec<RealisedNetwork> = Vec::new();
    let mut trouble: Option<SynthesisError> = None;
    let matching = Matching {
        most_elements: MOST_MATCHED,
        ..Matching::default()
    };
    match matching.smallest(function) {
        Ok(smallest) => networks.extend(smallest.realisations.iter().filter_map(network)),
        Err(error) => trouble = Some(error),
    }
    for general in [bott_duffin(function), reduced_bott_duffin(function)] {
        match general {
            Ok(realisation) => networks.extend(network(&realisation)),
            Err(error) => trouble = trouble.or(Some(error)),
        }
    }
    networks.sort_by_key(|network| network.values.len());
    let mut texts: Vec<String> = Vec::new();
    networks.retain(|network| {
        let new = !texts.contains(&network.network);
        texts.push(network.network.clone());
        new
    });
    let status = match (networks.first(), trouble) {
        (Some(smallest), _) => format!("synthesised, {} elements at least", smallest.values.len()),
        (None, Some(error)) => format!("not synthesised: {error}"),
        (None, None) => "not synthesised".to_owned(),
    };
    Synthesis {
        device: device.to_owned(),
        numerator: function.numerator.clone(),
        denominator: function.denominator.clone(),
        networks,
        status,
    }
}

/// A realisation without levers, with its values.
fn network(realisation: &Realisation) -> Option<RealisedNetwork> {
    let values: IndexMap<String, f64> = match realisation.structure.layout() {
        Some((layout, values)) => layout
            .branches()
            .map(|branch| branch.name.clone())
            .zip(values)
            .collect(),
        None => realisation
            .structure
            .mesh()?
            .elements
            .into_iter()
            .map(|element| (element.name, element.value))
            .collect(),
    };
    Some(RealisedNetwork {
        method: realisation.method.to_string(),
        network: realisation.structure.to_string(),
        is_series_parallel: realisation.structure.is_series_parallel(),
        values,
        residual: realisation.residual,
    })
}
