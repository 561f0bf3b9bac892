//! The keys a table may have: one definition for the reader, the schema and the reference.

/// The keys of one kind of table.
#[derive(Debug)]
pub struct KeySet {
    /// What the table is called in the reference.
    pub title: &'static str,
    /// What the table is for.
    pub documentation: &'static str,
    /// The keys with fixed names, in the order they are documented.
    pub keys: &'static [Key],
    /// Keys with names of the user's choice: what the names are (such as `NAME`), the shape of each value and what it means.
    pub others: Option<(&'static str, Shape, &'static str)>,
}

/// One key of a table.
#[derive(Debug)]
pub struct Key {
    /// The key as it is written.
    pub name: &'static str,
    /// What its value looks like.
    pub shape: Shape,
    /// Whether the table is refused without it.
    pub required: bool,
    /// What it means, with its default if it has one.
    pub documentation: &'static str,
}

/// What a value looks like.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    /// Any text.
    Text,
    /// A number without a unit.
    Number,
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Boolean,
    /// A number, or a text with a unit or an expression.
    Amount,
    /// A text that is an expression; a number stands for itself.
    Expression,
    /// One of these texts.
    Choice(&'static [&'static str]),
    /// A list of values of one shape.
    List(&'static Shape),
    /// A table with these keys.
    Table(&'static KeySet),
    /// A table with names of the user's choice, the values of one shape.
    MapOf(&'static Shape),
    /// Any of these shapes.
    AnyOf(&'static [Shape]),
    /// Whatever TOML can hold.
    Anything,
}

impl Key {
    /// A key the table must have.
    pub const fn required(name: &'static str, shape: Shape, documentation: &'static str) -> Self {
        Self {
            name,
            shape,
            required: true,
            documentation,
        }
    }

    /// A key the table may have.
    pub const fn optional(name: &'static str, shape: Shape, documentation: &'static str) -> Self {
        Self {
            name,
            shape,
            required: false,
            documentation,
        }
    }
}

impl KeySet {
    /// The key of this name, if the name is a fixed one.
    pub fn key(&self, name: &str) -> Option<&Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// Whether both define the same table: constants have no address of their own, so names decide.
    fn same(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
            || (self.title == other.title
                && self.documentation == other.documentation
                && self
                    .keys
                    .iter()
                    .map(|key| key.name)
                    .eq(other.keys.iter().map(|key| key.name)))
    }
}

/// A table definition with the name other definitions refer to it by.
pub(crate) struct Named {
    pub(crate) keys: &'static KeySet,
    pub(crate) anchor: String,
}

/// Every table definition reachable from one, each once, in the order of first mention.
pub(crate) struct Tables {
    pub(crate) nested: Vec<Named>,
}

impl Tables {
    pub(crate) fn under(root: &KeySet) -> Self {
        let mut tables = Self { nested: Vec::new() };
        tables.collect(root, root);
        // Definitions found on the way are visited in turn; a definition may contain itself.
        let mut next = 0;
        while let Some(keys) = tables.nested.get(next).map(|named| named.keys) {
            tables.collect(root, keys);
            next += 1;
        }
        tables
    }

    /// The name of a definition; `None` if it is the root.
    pub(crate) fn anchor(&self, keys: &KeySet) -> Option<&str> {
        self.nested
            .iter()
            .find(|named| named.keys.same(keys))
            .map(|named| named.anchor.as_str())
    }

    fn collect(&mut self, root: &KeySet, keys: &KeySet) {
        for key in keys.keys {
            self.shape(root, &key.shape);
        }
        if let Some((_, shape, _)) = &keys.others {
            self.shape(root, shape);
        }
    }

    fn shape(&mut self, root: &KeySet, shape: &Shape) {
        match shape {
            Shape::Table(keys) => {
                if keys.same(root) || self.anchor(keys).is_some() {
                    return;
                }
                // Markdown renderers number headings of the same title so, the first one without a number.
                let wanted = slug(keys.title);
                let taken = |anchor: &str| {
                    slug(root.title) == anchor
                        || self.nested.iter().any(|named| named.anchor == anchor)
                };
                let mut anchor = wanted.clone();
                let mut number = 0;
                while taken(&anchor) {
                    number += 1;
                    anchor = format!("{wanted}-{number}");
                }
                self.nested.push(Named { keys, anchor });
            }
            Shape::List(inner) | Shape::MapOf(inner) => self.shape(root, inner),
            Shape::AnyOf(shapes) => {
                for shape in *shapes {
                    self.shape(root, shape);
                }
            }
            Shape::Text
            | Shape::Number
            | Shape::Integer
            | Shape::Boolean
            | Shape::Amount
            | Shape::Expression
            | Shape::Choice(_)
            | Shape::Anything => {}
        }
    }
}

/// The anchor Markdown renderers give a heading: small letters, hyphens for blanks, no punctuation.
fn slug(title: &str) -> String {
    title
        .to_lowercase()
        .chars()
        .filter_map(|character| match character {
            ' ' | '-' => Some('-'),
            '_' => Some('_'),
            character if character.is_alphanumeric() => Some(character),
            _ => None,
        })
        .collect()
}
