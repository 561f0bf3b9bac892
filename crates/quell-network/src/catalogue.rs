//! Named devices of the field, each with its source.

use crate::{Domain, Kinds, Layout, LayoutError};

/// A two-terminal part of a device, between two points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DevicePart {
    /// The points: `host`, `other` (another point of the host, or the ground), `mass` (the device's own mass).
    pub between: (&'static str, &'static str),
    /// The layout between them; one that ends in a mass has only its first point.
    pub layout: &'static str,
}

/// A named device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Device {
    /// The short name: `TVMD`.
    pub name: &'static str,
    /// The name in words.
    pub title: &'static str,
    /// Its parts; most devices have one.
    pub parts: &'static [DevicePart],
    /// Author and year.
    pub source: &'static str,
}

impl Device {
    /// The layout of a device of one part, as text.
    #[must_use]
    pub const fn text(&self) -> Option<&'static str> {
        match self.parts {
            [only] => Some(only.layout),
            _ => None,
        }
    }

    /// The layout of a device of one part; none of one that joins three points.
    ///
    /// # Errors
    /// None that can occur: every entry of the catalogue reads.
    pub fn layout(&self) -> Option<Result<Layout, LayoutError>> {
        self.text()
            .map(|text| Layout::parse(text, &Kinds::new(Domain::Translational)))
    }
}

const fn one(layout: &'static str) -> [DevicePart; 1] {
    [DevicePart {
        between: ("host", "other"),
        layout,
    }]
}

/// The device of a name, upper and lower case alike.
#[must_use]
pub fn device(name: &str) -> Option<&'static Device> {
    CATALOGUE
        .iter()
        .find(|device| device.name.eq_ignore_ascii_case(name))
}

const SMITH_WANG: &str = "Smith and Wang 2004, Vehicle System Dynamics 42";
const BESIDE: &str = "one spring, damper and inerter beside the static spring, after Smith and Wang 2004 (numbered here)";

/// Named devices.
///
/// Struts have the static spring `k1` beside the rest. S1 to S4 are those of Smith and Wang; S5 to S8 have one spring
/// more and are numbered here, not after the paper.
pub const CATALOGUE: &[Device] = &[
    Device {
        name: "shimmy-damper",
        title: "shimmy damper: spring beside damper",
        parts: &one("k1 | c1"),
        source: "Li, Jiang and Neild 2017, Journal of Aircraft 54",
    },
    Device {
        name: "Maxwell",
        title: "Maxwell element: spring and damper in series",
        parts: &one("k1 + c1"),
        source: "Maxwell 1867",
    },
    Device {
        name: "Zener",
        title: "standard linear solid: a spring beside a Maxwell element",
        parts: &one("k1 | k2 + c1"),
        source: "Zener 1948",
    },
    Device {
        name: "absorber",
        title: "undamped dynamic vibration absorber",
        parts: &one("k1 + m1"),
        source: "Frahm 1911, US patent 989 958",
    },
    Device {
        name: "TMD",
        title: "tuned mass damper",
        parts: &one("(k1 | c1) + m1"),
        source: "Ormondroyd and Den Hartog 1928",
    },
    Device {
        name: "three-element-TMD",
        title: "tuned mass damper with the damper on a spring of its own",
        parts: &one("(k1 | k2 + c1) + m1"),
        source: "Asami and Nishihara 1999, Journal of Vibration and Acoustics 121",
    },
    Device {
        name: "RIDTMD",
        title: "rotational inertia double tuned mass damper",
        parts: &one("(k1 | k2 + (c1 | b1)) + m1"),
        source: "Garrido, Curadelli and Ambrosini 2013, Engineering Structures 56",
    },
    Device {
        name: "VMD",
        title: "viscous mass damper: damper beside inerter",
        parts: &one("c1 | b1"),
        source: "Ikago, Saito and Inoue 2012, Earthquake Engineering and Structural Dynamics 41",
    },
    Device {
        name: "TVMD",
        title: "tuned viscous mass damper",
        parts: &one("k1 + (c1 | b1)"),
        source: "Ikago, Saito and Inoue 2012, Earthquake Engineering and Structural Dynamics 41",
    },
    Device {
        name: "TID",
        title: "tuned inerter damper",
        parts: &one("(k1 | c1) + b1"),
        source: "Lazar, Neild and Wagg 2014, Earthquake Engineering and Structural Dynamics 43",
    },
    Device {
        name: "TMDI",
        title: "tuned mass damper whose mass is tied to another point by an inerter",
        parts: &[
            DevicePart {
                between: ("host", "mass"),
                layout: "k1 | c1",
            },
            DevicePart {
                between: ("mass", "other"),
                layout: "b1",
            },
            DevicePart {
                between: ("mass", "mass"),
                layout: "m1",
            },
        ],
        source: "Marian and Giaralis 2014, Probabilistic Engineering Mechanics 38",
    },
    Device {
        name: "non-traditional-TMD",
        title: "mass on a spring, with its damper to another point",
        parts: &[
            DevicePart {
                between: ("host", "mass"),
                layout: "k1",
            },
            DevicePart {
                between: ("mass", "other"),
                layout: "c1",
            },
            DevicePart {
                between: ("mass", "mass"),
                layout: "m1",
            },
        ],
        source: "Ren 2001, Journal of Sound and Vibration 245",
    },
    Device {
        name: "S1",
        title: "strut: damper",
        parts: &one("k1 | c1"),
        source: SMITH_WANG,
    },
    Device {
        name: "S2",
        title: "strut: damper on a relaxation spring",
        parts: &one("k1 | k2 + c1"),
        source: SMITH_WANG,
    },
    Device {
        name: "S3",
        title: "strut: damper beside inerter",
        parts: &one("k1 | c1 | b1"),
        source: SMITH_WANG,
    },
    Device {
        name: "S4",
        title: "strut: damper and inerter in series",
        parts: &one("k1 | c1 + b1"),
        source: SMITH_WANG,
    },
    Device {
        name: "S5",
        title: "strut: damper beside inerter, on a spring",
        parts: &one("k1 | k2 + (c1 | b1)"),
        source: BESIDE,
    },
    Device {
        name: "S6",
        title: "strut: spring, damper and inerter in series",
        parts: &one("k1 | k2 + c1 + b1"),
        source: BESIDE,
    },
    Device {
        name: "S7",
        title: "strut: damper in series with a centred inerter",
        parts: &one("k1 | c1 + (k2 | b1)"),
        source: BESIDE,
    },
    Device {
        name: "S8",
        title: "strut: inerter in series with a centred damper",
        parts: &one("k1 | b1 + (k2 | c1)"),
        source: BESIDE,
    },
];
