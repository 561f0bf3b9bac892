//! Components: a narrow pipe and an orifice, in hydraulics.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use quell_expression::{Dimension, Expression, Quantity, Unit};
use quell_network::{
    Component, ComponentError, ComponentVariable, Domain, Expansion, ExpansionWorkspace, Kinds,
    Layout, NetworkError, expand,
};

fn constants() -> Vec<(String, Quantity)> {
    [("I0", "3.8e6", "kg/m^4"), ("R0", "1.05e8", "kg/(s*m^4)")]
        .map(|(name, value, unit)| {
            let dimension = Unit::parse(unit).unwrap().dimension;
            (
                name.to_owned(),
                Quantity::new(value.parse().unwrap(), dimension),
            )
        })
        .into()
}

fn component(name: &str, layout: &str, variables: &[&str], values: &[(&str, &str)]) -> Component {
    let variable = |name: &&str| ComponentVariable {
        name: (*name).to_owned(),
        dimension: Dimension::NONE,
        sample: 0.9,
    };
    Component {
        name: name.to_owned(),
        layout: Layout::parse(layout, &Kinds::new(Domain::Hydraulic)).unwrap(),
        variables: variables.iter().map(variable).collect(),
        values: values
            .iter()
            .map(|(name, text)| ((*name).to_owned(), Expression::parse(text).unwrap()))
            .collect(),
    }
}

fn components() -> Vec<Component> {
    vec![
        component(
            "pipe",
            "R + I",
            &["dL", "dA"],
            &[("I", "I0*dL/dA"), ("R", "R0*dL/dA^2")],
        ),
        component("orifice", "R", &["dO"], &[("R", "dO*R0")]),
    ]
}

fn layout(text: &str) -> Layout {
    let mut kinds = Kinds::new(Domain::Hydraulic);
    for name in ["pipe", "orifice", "missing"] {
        kinds.declare_component(name).unwrap();
    }
    kinds.declare_placeholder("network").unwrap();
    Layout::parse(text, &kinds).unwrap()
}

fn expansion(text: &str) -> Expansion {
    expand(&layout(text), &components(), Some(2.0), &constants()).unwrap()
}

#[test]
fn instances_become_numbered_elements_and_keep_their_terminals() {
    let expansion = expansion("C1 | C2 + (pipe1 | orifice1)");
    let names: Vec<&str> = expansion
        .network()
        .elements()
        .iter()
        .map(|element| element.name.as_str())
        .collect();
    assert_eq!(names, ["C1", "C2", "pipe1.R", "pipe1.I", "orifice1.R"]);
    let variables: Vec<&str> = expansion
        .variables()
        .iter()
        .map(|variable| variable.name.as_str())
        .collect();
    assert_eq!(
        variables,
        ["C1", "C2", "pipe1.dL", "pipe1.dA", "orifice1.dO"]
    );
    let nodal = expansion.network().nodal();
    assert_eq!(nodal.parts["pipe1"], nodal.parts["pipe1.R"]);
    assert_eq!(nodal.parts["pipe1"], nodal.parts["pipe1.I"]);
    assert_eq!(nodal.parts["pipe1"].1, nodal.parts["orifice1"].0);
    // The strokes of pipe and orifice, in series in the mechanical network, add up to that of the compliance beside them.
    let values = [5.0, 3.0, 2.0, 1.0, 0.5];
    let share = |name: &str| {
        expansion
            .network()
            .stroke_share(expansion.network().part(name).unwrap(), 1.7, &values)
    };
    assert!((share("pipe1") + share("orifice1") - share("C2")).norm() < 1e-14);
    assert!((share("pipe1") - share("pipe1.I")).norm() < 1e-15);
}

#[test]
fn values_follow_from_variables_with_exact_derivatives() {
    let expansion = expansion("C1 | C2 + (pipe1 | orifice1 | pipe2)");
    let variables = [3.0e-11, 2.6e-9, 0.7, 1.2, 2.5, 1.4, 0.6];
    let mut workspace = ExpansionWorkspace::default();
    let mut values = [0.0; 7];
    expansion.values(&variables, &mut workspace, &mut values);
    let (i0, r0, square) = (3.8e6, 1.05e8, 4.0);
    let expected = [
        square / 3.0e-11,
        square / 2.6e-9,
        square * r0 * 0.7 / 1.44,
        square * i0 * 0.7 / 1.2,
        square * r0 * 2.5,
        square * r0 * 1.4 / 0.36,
        square * i0 * 1.4 / 0.6,
    ];
    for (value, expected) in values.iter().zip(expected) {
        // A few roundings.
        assert!((value / expected - 1.0).abs() < 1e-14, "{value} {expected}");
    }
    let mut derivatives = vec![f64::NAN; expansion.entries().len()];
    let mut again = [0.0; 7];
    expansion.derivatives(&variables, &mut workspace, &mut again, &mut derivatives);
    assert_eq!(values, again);
    for ((element, variable), derivative) in expansion.entries().iter().zip(&derivatives) {
        let moved = |factor: f64| {
            let mut variables = variables;
            variables[*variable] *= factor;
            let mut values = [0.0; 7];
            expansion.values(&variables, &mut ExpansionWorkspace::default(), &mut values);
            values[*element]
        };
        let step = 1e-6;
        let difference =
            (moved(1.0 + step) - moved(1.0 - step)) / (2.0 * step * variables[*variable]);
        // Second-order differences at a relative step of 1e-6: 1e-12 truncated, 1e-10 rounded.
        let size = (values[*element] / variables[*variable]).abs();
        assert!(
            (difference - derivative).abs() < 1e-8 * size,
            "{element} {variable}: {difference} {derivative}"
        );
    }
    // Every other derivative is zero: two plain values, two pipes of 2 x 2, one orifice.
    assert_eq!(expansion.entries().len(), 2 + 4 + 1 + 4);
}

#[test]
fn too_few_variables_are_not_a_number() {
    let expansion = expansion("pipe1 + C1");
    let mut values = [0.0; 3];
    expansion.values(&[1.0], &mut ExpansionWorkspace::default(), &mut values);
    assert!(values.iter().all(|value| value.is_nan()));
}

#[test]
fn wrong_components_are_refused() {
    let refused = |component: Component, text: &str| {
        let mut all = components();
        all.retain(|known| known.name != component.name);
        all.push(component);
        expand(&layout(text), &all, Some(1.0), &constants())
            .map(|_| ())
            .unwrap_err()
    };
    let orifice = |values: &[(&str, &str)]| component("orifice", "R", &["dO"], values);
    assert!(matches!(
        refused(orifice(&[]), "orifice1"),
        ComponentError::MissingValue { .. }
    ));
    assert!(matches!(
        refused(orifice(&[("R", "R0"), ("I", "I0")]), "orifice1"),
        ComponentError::UnknownElement { .. }
    ));
    assert!(matches!(
        refused(orifice(&[("R", "dQ*R0")]), "orifice1"),
        ComponentError::Expression { .. }
    ));
    let error = refused(orifice(&[("R", "I0*dO")]), "orifice1");
    assert_eq!(
        error.to_string(),
        "the value of `R` in the component `orifice` should be in kg/(s*m^4), but it is in kg/m^4"
    );
    assert_eq!(
        expand(&layout("missing1"), &components(), Some(1.0), &constants()).unwrap_err(),
        ComponentError::Network(NetworkError::UnknownComponent {
            branch: "missing1".into(),
            component: "missing".into()
        })
    );
    assert!(matches!(
        expand(&layout("network"), &components(), Some(1.0), &constants()).unwrap_err(),
        ComponentError::Network(NetworkError::Placeholder(_))
    ));
    let mechanical = Component {
        layout: Layout::parse("c", &Kinds::new(Domain::Translational)).unwrap(),
        ..component("orifice", "R", &[], &[])
    };
    assert!(matches!(
        refused(mechanical, "orifice1"),
        ComponentError::Network(NetworkError::Domain { .. })
    ));
    // A plain number is SI.
    assert!(
        expand(
            &layout("orifice1"),
            &[orifice(&[("R", "3")])],
            Some(1.0),
            &constants()
        )
        .is_ok()
    );
}
