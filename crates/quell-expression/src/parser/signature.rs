//! Heads of functions: `F(side)`.

use super::{Parser, starts_name};
use crate::{ExpressionError, Function, Span};

/// The head of a function: its name and the names of its arguments.
///
/// ```
/// use quell_expression::Signature;
/// let signature = Signature::parse("lamdot(side, lam)")?;
/// assert_eq!(signature.name, "lamdot");
/// assert_eq!(signature.arguments[1].name, "lam");
/// # Ok::<(), quell_expression::ExpressionError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signature {
    /// Name of the function.
    pub name: String,
    /// Where it stands.
    pub span: Span,
    /// Its arguments, one at least.
    pub arguments: Vec<Argument>,
}

/// An argument of a function.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Argument {
    /// Its name.
    pub name: String,
    /// Where it stands.
    pub span: Span,
}

impl Signature {
    /// Reads the head of a function.
    ///
    /// # Errors
    /// At the character: what is no name, names of built-in functions, arguments of the same name.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let mut parser = Parser::new(text);
        let Argument { name, span } = parser.plain_name("the name of a function")?;
        if Function::from_name(&name).is_some() || matches!(name.as_str(), "d" | "hold") {
            let message = format!("`{name}` is a function of the language");
            return Err(ExpressionError::new(span, message).with_help("choose another name"));
        }
        if !parser.take("(") {
            return Err(parser
                .expected("`(`")
                .with_help(format!("a function names its arguments: `{name}(x)`")));
        }
        let mut arguments: Vec<Argument> = Vec::new();
        loop {
            let argument = parser.plain_name("the name of an argument")?;
            if arguments.iter().any(|known| known.name == argument.name) {
                let message = format!("`{}` is an argument already", argument.name);
                return Err(ExpressionError::new(argument.span, message));
            }
            arguments.push(argument);
            if parser.take(")") {
                break;
            }
            if !parser.take(",") {
                return Err(parser.expected("`,` or `)`"));
            }
        }
        parser.end("the end")?;
        Ok(Self {
            name,
            span,
            arguments,
        })
    }
}

impl Parser<'_> {
    /// A name without dots.
    fn plain_name(&mut self, what: &str) -> Result<Argument, ExpressionError> {
        let starts = self.peek().is_some_and(starts_name);
        if !starts || self.reserved().is_some() {
            return Err(self.expected(what));
        }
        let (span, _) = self.found();
        self.position = span.end;
        let name = self.text.get(span.start..span.end).unwrap_or("").to_owned();
        Ok(Argument { name, span })
    }
}
