//! Reading layouts.

use std::collections::HashMap;
use std::fmt::Write as _;

use quell_expression::{Span, nearest};

use crate::kind::{Branch, Kind, Kinds, continues_name, starts_name};
use crate::{Layout, LayoutError, Tree};

/// Parentheses may be nested this deeply.
const DEPTH_LIMIT: usize = 64;

/// A layout may have this many branches.
const BRANCH_LIMIT: usize = 4096;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Token {
    Name,
    Plus,
    Bar,
    Open,
    Close,
}

struct Parser<'a> {
    text: &'a str,
    kinds: &'a Kinds,
    tokens: Vec<(Token, Span)>,
    next: usize,
    seen: HashMap<&'a str, Span>,
}

/// Reads a layout.
pub(crate) fn parse(text: &str, kinds: &Kinds) -> Result<Layout, LayoutError> {
    let tokens = tokens(text)?;
    let mut parser = Parser {
        text,
        kinds,
        tokens,
        next: 0,
        seen: HashMap::new(),
    };
    if parser.tokens.is_empty() {
        return Err(error(
            Span {
                start: 0,
                end: text.len(),
            },
            "the layout is empty",
            Some(format!("write branches such as `{}`", example(kinds))),
        ));
    }
    let tree = parser.parallel(0)?;
    if let Some((token, span)) = parser.tokens.get(parser.next) {
        return Err(match token {
            Token::Close => error(
                *span,
                "this `)` closes nothing",
                Some("remove it, or open a group before it".into()),
            ),
            _ => error(
                *span,
                format!("expected `+` or `|` before `{}`", parser.slice(*span)),
                Some("`+` connects in series, `|` in parallel".into()),
            ),
        });
    }
    let whole = Span {
        start: 0,
        end: text.len(),
    };
    let tree = tree
        .flattened()
        .ok_or_else(|| error(whole, "the layout is empty", None))?;
    Ok(Layout {
        domain: kinds.domain(),
        tree,
    })
}

fn error(span: Span, message: impl Into<String>, help: Option<String>) -> LayoutError {
    LayoutError {
        span,
        message: message.into(),
        help,
    }
}

/// A small layout in the domain's letters, for help texts.
fn example(kinds: &Kinds) -> String {
    let letters: Vec<String> = kinds
        .domain()
        .letters()
        .iter()
        .take(2)
        .map(|(letter, _)| format!("{letter}1"))
        .collect();
    letters.join(" | ")
}

fn tokens(text: &str) -> Result<Vec<(Token, Span)>, LayoutError> {
    let mut tokens = Vec::new();
    let mut characters = text.char_indices().peekable();
    let mut branches = 0;
    while let Some((start, character)) = characters.next() {
        let mut end = start + character.len_utf8();
        let token = match character {
            _ if character.is_whitespace() => continue,
            '+' => Token::Plus,
            '|' => {
                if characters.next_if(|(_, next)| *next == '|').is_some() {
                    return Err(error(
                        Span {
                            start,
                            end: end + 1,
                        },
                        "`||` is no operator",
                        Some("write a single `|` for parallel".into()),
                    ));
                }
                Token::Bar
            }
            '(' => Token::Open,
            ')' => Token::Close,
            _ if starts_name(character) => {
                while let Some((at, next)) = characters.next_if(|(_, next)| continues_name(*next)) {
                    end = at + next.len_utf8();
                }
                branches += 1;
                if branches > BRANCH_LIMIT {
                    return Err(error(
                        Span { start, end },
                        format!("a layout may have at most {BRANCH_LIMIT} branches"),
                        None,
                    ));
                }
                Token::Name
            }
            _ => {
                let help = match character {
                    '-' => Some("series is written `+`".to_owned()),
                    '*' | '/' | '&' | ',' => Some("series is written `+`, parallel `|`".to_owned()),
                    _ if character.is_numeric() => {
                        Some("a branch name starts with a letter, such as `k1`".to_owned())
                    }
                    _ => {
                        Some("a layout consists of branch names, `+`, `|`, `(` and `)`".to_owned())
                    }
                };
                return Err(error(
                    Span { start, end },
                    format!("`{}` has no meaning in a layout", character.escape_debug()),
                    help,
                ));
            }
        };
        tokens.push((token, Span { start, end }));
    }
    Ok(tokens)
}

impl<'a> Parser<'a> {
    fn slice(&self, span: Span) -> &'a str {
        self.text.get(span.start..span.end).unwrap_or_default()
    }

    fn peek(&self) -> Option<Token> {
        self.tokens.get(self.next).map(|(token, _)| *token)
    }

    fn parallel(&mut self, depth: usize) -> Result<Tree<Branch>, LayoutError> {
        let mut children = vec![self.series(depth)?];
        while self.peek() == Some(Token::Bar) {
            self.next += 1;
            children.push(self.series(depth)?);
        }
        Ok(Tree::Parallel(children))
    }

    fn series(&mut self, depth: usize) -> Result<Tree<Branch>, LayoutError> {
        let mut children = vec![self.operand(depth)?];
        while self.peek() == Some(Token::Plus) {
            self.next += 1;
            children.push(self.operand(depth)?);
        }
        Ok(Tree::Series(children))
    }

    fn operand(&mut self, depth: usize) -> Result<Tree<Branch>, LayoutError> {
        let Some((token, span)) = self.tokens.get(self.next).copied() else {
            let end = self.text.trim_end().len();
            let last = self
                .tokens
                .last()
                .map_or(Span { start: end, end }, |(_, span)| *span);
            return Err(error(
                last,
                format!("a branch is missing after `{}`", self.slice(last)),
                Some("write a branch name or a group in parentheses".into()),
            ));
        };
        match token {
            Token::Name => {
                self.next += 1;
                self.branch(span)
            }
            Token::Open => {
                if depth >= DEPTH_LIMIT {
                    return Err(error(
                        span,
                        format!("groups may be nested at most {DEPTH_LIMIT} deep"),
                        None,
                    ));
                }
                self.next += 1;
                let tree = self.parallel(depth + 1)?;
                match self.tokens.get(self.next) {
                    Some((Token::Close, _)) => {
                        self.next += 1;
                        Ok(tree)
                    }
                    Some((_, other)) => Err(error(
                        *other,
                        format!("expected `+`, `|` or `)` before `{}`", self.slice(*other)),
                        Some("`+` connects in series, `|` in parallel".into()),
                    )),
                    None => Err(error(
                        span,
                        "this `(` is never closed",
                        Some("add a `)`".into()),
                    )),
                }
            }
            Token::Plus | Token::Bar | Token::Close => Err(error(
                span,
                format!("expected a branch before `{}`", self.slice(span)),
                Some("write a branch name or a group in parentheses".into()),
            )),
        }
    }

    fn branch(&mut self, span: Span) -> Result<Tree<Branch>, LayoutError> {
        let name = self.slice(span);
        let Some(branch) = self.kinds.branch(name) else {
            return Err(self.unknown(name, span));
        };
        if self.seen.insert(name, span).is_some() {
            return Err(error(
                span,
                format!("`{name}` occurs twice in this layout"),
                Some(format!(
                    "number the branches, such as `{}`",
                    self.unused(name)
                )),
            ));
        }
        Ok(Tree::Leaf(branch))
    }

    /// A numbered name of the same stem that the text does not use.
    fn unused(&self, name: &str) -> String {
        let stem = name.trim_end_matches(|character: char| character.is_ascii_digit());
        (2..=BRANCH_LIMIT + 2)
            .map(|number| format!("{stem}{number}"))
            .find(|candidate| !self.text.contains(candidate.as_str()))
            .unwrap_or_else(|| stem.to_owned())
    }

    fn unknown(&self, name: &str, span: Span) -> LayoutError {
        let domain = self.kinds.domain();
        let digits = name.bytes().rev().take_while(u8::is_ascii_digit).count();
        let (stem, number) = name.split_at(name.len() - digits);
        let declared: Vec<(&str, &Kind)> = self.kinds.declared().collect();
        let suggestion =
            nearest(stem, declared.iter().map(|(declared, _)| *declared)).map(|near| {
                let placeholder = declared
                    .iter()
                    .any(|(declared, kind)| *declared == near && **kind == Kind::Placeholder);
                if placeholder {
                    near.to_owned()
                } else {
                    format!("{near}{number}")
                }
            });
        let other_case = stem.chars().next().and_then(|first| {
            domain
                .letters()
                .iter()
                .find(|(letter, _)| letter.eq_ignore_ascii_case(&first))
                .map(|(letter, _)| format!("{letter}{}", name.chars().skip(1).collect::<String>()))
        });
        let letters = domain
            .letters()
            .iter()
            .map(|(letter, element)| format!("`{letter}` {}", domain.element_name(*element)))
            .collect::<Vec<_>>()
            .join(", ");
        let mut help = String::new();
        if let Some(near) = suggestion.or(other_case) {
            help = format!("did you mean `{near}`? ");
        }
        let _ = write!(
            help,
            "In a {domain} layout the first letter tells the element: {letters}"
        );
        if !declared.is_empty() {
            let names = declared
                .iter()
                .map(|(declared, _)| format!("`{declared}`"))
                .collect::<Vec<_>>()
                .join(", ");
            let _ = write!(help, "; declared besides: {names}");
        }
        error(
            span,
            format!("`{name}` is no known kind of branch"),
            Some(help),
        )
    }
}
