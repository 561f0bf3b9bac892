//! A parsed document: the tree of its values, each with its place.

use std::sync::Arc;

use quell_expression::Span;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::fault::Fault;
use crate::source::Source;
use crate::syntax;
use crate::table::Table;

/// A document read from TOML, every key and value with its place in the file.
#[derive(Debug)]
pub struct Document {
    source: Arc<Source>,
    root: Node,
}

/// A value and its place.
#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) span: Span,
    pub(crate) content: Content,
}

/// What a value is.
#[derive(Debug)]
pub(crate) enum Content {
    /// The text with its escapes resolved, and where in the file it begins if it stands there letter by letter.
    Text {
        text: String,
        offset: Option<usize>,
    },
    /// `None` if it does not fit 64 bits.
    Integer(Option<i64>),
    /// `None` if it is not finite.
    Float(Option<f64>),
    Boolean(bool),
    Array(Vec<Node>),
    Table(TableNode),
}

/// The entries of a table in file order.
#[derive(Debug, Default)]
pub(crate) struct TableNode {
    /// The dotted path from the root, empty for the root itself.
    pub(crate) path: String,
    pub(crate) entries: Vec<Entry>,
    /// Places in `entries`, by key.
    order: Vec<usize>,
}

/// A key, its place and its value.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) key_span: Span,
    pub(crate) value: Node,
}

/// Deeper tables and arrays than anybody writes are refused, so that walking a document needs little stack.
const DEEPEST: usize = 64;

impl Document {
    /// Reads a TOML document.
    ///
    /// # Errors
    ///
    /// A fault at the place if the text is not TOML, gives a key twice, holds a date, or nests more than 64 deep.
    pub fn parse(source: Arc<Source>) -> Result<Self, Fault> {
        let root = match DeTable::parse(&source.text) {
            Ok(table) => {
                let reader = Reader { source: &source };
                let span = Span { start: 0, end: 0 };
                Node {
                    span,
                    content: Content::Table(reader.table(table.into_inner(), String::new(), 0)?),
                }
            }
            Err(error) => return Err(syntax::fault(&source, &error)),
        };
        Ok(Self { source, root })
    }

    /// The table of the whole document; its span is the empty one at the beginning of the file.
    pub fn root(&self) -> Table<'_> {
        // The root is a table by construction.
        static NOTHING: TableNode = TableNode {
            path: String::new(),
            entries: Vec::new(),
            order: Vec::new(),
        };
        let node = match &self.root.content {
            Content::Table(node) => node,
            _ => &NOTHING,
        };
        Table::new(&self.source, self.root.span, node)
    }

    /// The table at a [path](Table::path).
    pub fn table(&self, path: &str) -> Option<Table<'_>> {
        let node = self.root.find(path)?;
        match &node.content {
            Content::Table(table) => Some(Table::new(&self.source, node.span, table)),
            _ => None,
        }
    }

    /// Every table below the root, at any depth.
    pub fn tables(&self) -> Vec<Table<'_>> {
        let mut found = Vec::new();
        self.root.tables(&self.source, &mut found);
        found
    }

    /// The file the document was read from.
    pub fn source(&self) -> &Arc<Source> {
        &self.source
    }
}

impl Node {
    /// Every table in what it holds.
    fn tables<'a>(&'a self, source: &'a Arc<Source>, found: &mut Vec<Table<'a>>) {
        let mut add = |node: &'a Self| {
            if let Content::Table(table) = &node.content {
                found.push(Table::new(source, node.span, table));
            }
            node.tables(source, found);
        };
        match &self.content {
            Content::Table(table) => table.entries.iter().for_each(|entry| add(&entry.value)),
            Content::Array(nodes) => nodes.iter().for_each(add),
            _ => {}
        }
    }

    /// The table at a path in what it holds.
    fn find(&self, path: &str) -> Option<&Self> {
        match &self.content {
            Content::Table(table) if table.path == path => Some(self),
            Content::Table(table) => table
                .entries
                .iter()
                .find_map(|entry| entry.value.find(path)),
            Content::Array(nodes) => nodes.iter().find_map(|node| node.find(path)),
            _ => None,
        }
    }
}

impl TableNode {
    pub(crate) fn entry(&self, key: &str) -> Option<&Entry> {
        let place = self
            .order
            .binary_search_by(|&place| {
                self.entries
                    .get(place)
                    .map(|entry| entry.key.as_str())
                    .cmp(&Some(key))
            })
            .ok()?;
        self.entries.get(*self.order.get(place)?)
    }
}

/// Turns the parser's tree into ours.
struct Reader<'a> {
    source: &'a Arc<Source>,
}

impl Reader<'_> {
    fn table(&self, table: DeTable<'_>, path: String, depth: usize) -> Result<TableNode, Fault> {
        let mut entries = Vec::with_capacity(table.len());
        for (key, value) in table {
            let key_span = self.span(&key.span());
            let key = key.into_inner().into_owned();
            let inner = join(&path, &key);
            let value = self.node(value, inner, depth + 1)?;
            entries.push(Entry {
                key,
                key_span,
                value,
            });
        }
        // Headers may come back to a table after others, which moves its entries about.
        entries.sort_by_key(|entry| entry.key_span.start);
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_by_key(|&place| entries.get(place).map(|entry| entry.key.as_str()));
        Ok(TableNode {
            path,
            entries,
            order,
        })
    }

    fn node(&self, value: Spanned<DeValue<'_>>, path: String, depth: usize) -> Result<Node, Fault> {
        let span = self.span(&value.span());
        if depth > DEEPEST {
            return Err(syntax::too_deep(self.source, span, DEEPEST));
        }
        let content = match value.into_inner() {
            DeValue::String(text) => Content::Text {
                offset: self.offset(span, &text),
                text: text.into_owned(),
            },
            DeValue::Integer(integer) => {
                Content::Integer(i64::from_str_radix(integer.as_str(), integer.radix()).ok())
            }
            DeValue::Float(float) => Content::Float(
                float
                    .as_str()
                    .parse()
                    .ok()
                    .filter(|value: &f64| value.is_finite()),
            ),
            DeValue::Boolean(boolean) => Content::Boolean(boolean),
            DeValue::Datetime(_) => {
                return Err(
                    Fault::at(self.source, span, "dates and times have no meaning here")
                        .label("a date or a time")
                        .help("if a text is meant, write it in quotes"),
                );
            }
            DeValue::Array(array) => {
                let mut nodes = Vec::with_capacity(array.len());
                for (index, value) in array.into_iter().enumerate() {
                    nodes.push(self.node(value, format!("{path}[{index}]"), depth + 1)?);
                }
                Content::Array(nodes)
            }
            DeValue::Table(table) => Content::Table(self.table(table, path, depth)?),
        };
        Ok(Node { span, content })
    }

    fn span(&self, range: &std::ops::Range<usize>) -> Span {
        self.source.fitted(Span {
            start: range.start,
            end: range.end,
        })
    }

    /// Where the contents of a quoted text begin, if they stand in the file as they are.
    fn offset(&self, span: Span, text: &str) -> Option<usize> {
        let raw = self.source.slice(span);
        let quotes = ["\"\"\"", "'''", "\"", "'"];
        let (quote, inner) = quotes
            .iter()
            .find_map(|quote| Some((quote, raw.strip_prefix(quote)?.strip_suffix(quote)?)))?;
        let mut start = span.start + quote.len();
        let mut inner = inner;
        if quote.len() == 3 {
            // A line break right after the quotes is no part of the text.
            for line_break in ["\n", "\r\n"] {
                if let Some(rest) = inner.strip_prefix(line_break) {
                    inner = rest;
                    start += line_break.len();
                    break;
                }
            }
        }
        (inner == text).then_some(start)
    }
}

/// The path of a key inside a table, quoted where it has to be.
fn join(path: &str, key: &str) -> String {
    let bare = !key.is_empty()
        && key
            .chars()
            .all(|character| character.is_ascii_alphanumeric() || matches!(character, '_' | '-'));
    let key = if bare {
        key.to_owned()
    } else {
        format!("{key:?}")
    };
    if path.is_empty() {
        key
    } else {
        format!("{path}.{key}")
    }
}
