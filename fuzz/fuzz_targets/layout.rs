//! No text makes the reader of layouts panic, and what it reads prints and reads back as the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quell_network::{Domain, Element, Kinds, Layout};

fuzz_target!(|text: &str| {
    for domain in Domain::ALL {
        let mut kinds = Kinds::new(domain);
        let declared = kinds
            .declare_component("pipe")
            .and_then(|()| kinds.declare_element("pad", Element::Damper))
            .and_then(|()| kinds.declare_placeholder("slot"));
        assert!(declared.is_ok());
        match Layout::parse(text, &kinds) {
            Ok(layout) => {
                let printed = layout.to_string();
                assert_eq!(
                    Layout::parse(&printed, &kinds).as_ref(),
                    Ok(&layout),
                    "{printed}"
                );
                let canonical = layout.canonical();
                assert_eq!(canonical, canonical.canonical());
                let _ = layout.dual();
            }
            Err(error) => {
                assert!(error.span.start <= error.span.end && error.span.end <= text.len());
                assert!(!error.message.is_empty());
            }
        }
    }
});
