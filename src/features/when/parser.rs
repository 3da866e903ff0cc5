//! Parses the tokens of a condition.

use super::super::model::Value;
use super::lexer::{Kind, Token};
use super::{Node, Operand, WhenError};

/// Deepest nesting.
const DEEPEST: usize = 64;

/// Parses tokens, of which the last is [`Kind::End`]; returns the condition and the attributes that occur.
pub(super) fn parse(tokens: Vec<Token>) -> Result<(Node, Vec<(String, usize)>), WhenError> {
    let end = tokens.last().map_or(1, |end| end.column);
    let mut parser = Parser { tokens: tokens.into_iter().peekable(), end, names: Vec::new() };
    if parser.kind() == &Kind::End {
        return Err(WhenError { column: 1, cause: "the condition is empty".to_owned() });
    }
    let root = parser.any(0)?;
    match parser.kind() {
        Kind::End => Ok((root, parser.names)),
        Kind::Comparison(_) => Err(parser.mistake("comparisons cannot be chained; use and")),
        _ => Err(parser.unexpected("and or or")),
    }
}

struct Parser {
    tokens: std::iter::Peekable<std::vec::IntoIter<Token>>,
    /// Column after the last token.
    end: usize,
    names: Vec<(String, usize)>,
}

impl Parser {
    /// Returns the next token without moving past it.
    fn kind(&mut self) -> &Kind {
        self.tokens.peek().map_or(&Kind::End, |token| &token.kind)
    }

    fn column(&mut self) -> usize {
        self.tokens.peek().map_or(self.end, |token| token.column)
    }

    fn advance(&mut self) -> Kind {
        self.tokens.next().map_or(Kind::End, |token| token.kind)
    }

    /// Moves past a token if it is next.
    fn is_next(&mut self, kind: &Kind) -> bool {
        self.tokens.next_if(|token| token.kind == *kind).is_some()
    }

    fn mistake(&mut self, cause: &str) -> WhenError {
        WhenError { column: self.column(), cause: cause.to_owned() }
    }

    fn unexpected(&mut self, expected: &str) -> WhenError {
        let found = match self.kind() {
            Kind::End => "but the condition ends".to_owned(),
            other => format!("not {}", other.text()),
        };
        self.mistake(&format!("expected {expected}, {found}"))
    }

    fn any(&mut self, depth: usize) -> Result<Node, WhenError> {
        let first = self.all(depth)?;
        let mut nodes = vec![first];
        while self.is_next(&Kind::Or) {
            nodes.push(self.all(depth)?);
        }
        Ok(one_or(nodes, Node::Any))
    }

    fn all(&mut self, depth: usize) -> Result<Node, WhenError> {
        let first = self.not(depth)?;
        let mut nodes = vec![first];
        while self.is_next(&Kind::And) {
            nodes.push(self.not(depth)?);
        }
        Ok(one_or(nodes, Node::All))
    }

    fn not(&mut self, depth: usize) -> Result<Node, WhenError> {
        if depth >= DEEPEST && matches!(self.kind(), Kind::Not | Kind::Open) {
            return Err(self.mistake(&format!("the condition is nested more than {DEEPEST} deep")));
        }
        if self.is_next(&Kind::Not) {
            return Ok(Node::Not(Box::new(self.not(depth + 1)?)));
        }
        if self.is_next(&Kind::Open) {
            let node = self.any(depth + 1)?;
            return match self.kind() {
                Kind::Close => {
                    self.advance();
                    Ok(node)
                }
                Kind::Comparison(_) => Err(self.mistake("comparisons cannot be chained; use and")),
                _ => Err(self.unexpected("), and or or")),
            };
        }
        self.comparison()
    }

    fn comparison(&mut self) -> Result<Node, WhenError> {
        let left = self.operand()?;
        if let Kind::Comparison(comparison) = *self.kind() {
            self.advance();
            let right = self.operand()?;
            return Ok(Node::Compare(left, comparison, right));
        }
        if self.is_next(&Kind::Is) {
            let is_negated = self.is_next(&Kind::Not);
            if !self.is_next(&Kind::NoValue) {
                return Err(self.unexpected(if is_negated { "none" } else { "none or not none" }));
            }
            return Ok(negated(is_negated, Node::IsNone(left)));
        }
        let is_negated = self.is_next(&Kind::Not);
        if self.is_next(&Kind::In) {
            return Ok(negated(is_negated, Node::In(left, self.literals()?)));
        }
        Err(self.unexpected(if is_negated { "in" } else { "a comparison, in or is" }))
    }

    fn operand(&mut self) -> Result<Operand, WhenError> {
        let column = self.column();
        match self.kind() {
            Kind::Name(_) | Kind::Literal(_) => match self.advance() {
                Kind::Name(name) => {
                    self.names.push((name.clone(), column));
                    Ok(Operand::Attribute(name))
                }
                Kind::Literal(value) => Ok(Operand::Literal(value)),
                _ => Err(self.unexpected("an attribute or a literal")),
            },
            Kind::NoValue => Err(self.mistake("none is not a value; use is none")),
            _ => Err(self.unexpected("an attribute or a literal")),
        }
    }

    fn literals(&mut self) -> Result<Vec<Value>, WhenError> {
        if !self.is_next(&Kind::Open) {
            return Err(self.unexpected("("));
        }
        let mut values = Vec::new();
        loop {
            match self.kind() {
                Kind::Literal(value) => values.push(value.clone()),
                Kind::Name(name) => {
                    let name = crate::file::message::brief(name);
                    return Err(self.mistake(&format!("expected a literal, not {name}; text is written '{name}'")));
                }
                _ => return Err(self.unexpected("a literal")),
            }
            self.advance();
            if self.is_next(&Kind::Close) {
                return Ok(values);
            }
            if !self.is_next(&Kind::Comma) {
                return Err(self.unexpected(", or )"));
            }
        }
    }
}

fn negated(is_negated: bool, node: Node) -> Node {
    if is_negated { Node::Not(Box::new(node)) } else { node }
}

/// Returns the only node, or all of them in a common node.
fn one_or(mut nodes: Vec<Node>, common: impl FnOnce(Vec<Node>) -> Node) -> Node {
    match nodes.len() {
        1 => nodes.swap_remove(0),
        _ => common(nodes),
    }
}
