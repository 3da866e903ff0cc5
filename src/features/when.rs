//! Conditions on attributes, as styles have them: `class == 'track' and ele > 2000`.
//!
//! | | |
//! | --- | --- |
//! | comparisons | `==`, `!=`, `<`, `<=`, `>`, `>=` between attributes and literals |
//! | sets | `class in ('track', 'path')`, `class not in (1, 2)` |
//! | absence | `name is none`, `name is not none` |
//! | logic | `and`, `or`, `not`, parentheses; `and` binds tighter than `or` |
//! | text | `'it''s'`, in single quotation marks |
//! | names | `class`, `addr:street`, or in double quotation marks: `"name with spaces"` |
//! | other literals | `12`, `-0.5`, `1e3`, `true`, `false` |
//!
//! A text that is a number equals that number, and true and false equal 1 and 0, because formats disagree about which
//! is which. Two texts are compared letter by letter. An attribute without a value equals nothing, and is neither smaller
//! nor larger than anything, so `class != 'track'` is true without a class. The same holds for values of different kinds.

mod lexer;
mod parser;

use std::cmp::Ordering;

use super::model::{Attributes, Value};
use crate::file::message::{did_you_mean, quoted};

/// Longest condition in bytes.
const LONGEST: usize = 4096;

/// A mistake in a condition. One line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("column {column}: {cause}")]
pub(crate) struct WhenError {
    /// Column in characters, counted from 1.
    pub column: usize,
    /// What is wrong, and what would be right.
    pub cause: String,
}

/// A condition.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct When {
    root: Node,
    /// The attributes that occur, with their columns.
    names: Vec<(String, usize)>,
}

#[derive(Clone, Debug, PartialEq)]
enum Node {
    All(Vec<Node>),
    Any(Vec<Node>),
    Not(Box<Node>),
    Compare(Operand, Comparison, Operand),
    In(Operand, Vec<Value>),
    IsNone(Operand),
}

#[derive(Clone, Debug, PartialEq)]
enum Operand {
    /// The name of an attribute.
    Attribute(String),
    Literal(Value),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

impl When {
    /// Parses a condition.
    ///
    /// # Errors
    /// Returns the column of the first mistake, and what is wrong there.
    pub(crate) fn parse(text: &str) -> Result<Self, WhenError> {
        if text.len() > LONGEST {
            return Err(WhenError { column: 1, cause: format!("the condition is longer than {LONGEST} bytes") });
        }
        let (root, names) = parser::parse(lexer::tokens(text)?)?;
        Ok(Self { root, names })
    }

    /// Returns whether a feature with these attributes meets the condition.
    pub(crate) fn is_met(&self, attributes: &Attributes) -> bool {
        self.root.is_met(attributes)
    }

    /// Returns the names of the attributes that occur, in the order of the text.
    #[cfg(test)]
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|(name, _)| name.as_str())
    }

    /// Checks that all attributes that occur are among the `known` ones. A file in which only some features have an
    /// attribute lists it too.
    ///
    /// # Errors
    /// Returns the first name that is not known.
    pub(crate) fn check(&self, known: &[&str]) -> Result<(), WhenError> {
        match self.names.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some((name, column)) => {
                let hint = did_you_mean(name, known.iter().copied());
                let cause = format!("there is no attribute {}{hint} (text is written 'like this')", quoted(name));
                Err(WhenError { column: *column, cause })
            }
        }
    }
}

impl Node {
    /// Evaluates a node. The depth of the recursion is that of the text, which the parser limits.
    fn is_met(&self, attributes: &Attributes) -> bool {
        match self {
            Self::All(nodes) => nodes.iter().all(|node| node.is_met(attributes)),
            Self::Any(nodes) => nodes.iter().any(|node| node.is_met(attributes)),
            Self::Not(node) => !node.is_met(attributes),
            Self::IsNone(operand) => *operand.value(attributes) == Value::None,
            Self::In(operand, values) => {
                let own = operand.value(attributes);
                values.iter().any(|value| order(own, value) == Some(Ordering::Equal))
            }
            Self::Compare(left, comparison, right) => {
                comparison.holds(order(left.value(attributes), right.value(attributes)))
            }
        }
    }
}

impl Operand {
    fn value<'a>(&'a self, attributes: &'a Attributes) -> &'a Value {
        match self {
            Self::Attribute(name) => attributes.get(name),
            Self::Literal(value) => value,
        }
    }
}

impl Comparison {
    fn holds(self, order: Option<Ordering>) -> bool {
        match self {
            Self::Equal => order == Some(Ordering::Equal),
            Self::NotEqual => order != Some(Ordering::Equal),
            Self::Less => order == Some(Ordering::Less),
            Self::LessOrEqual => order.is_some_and(Ordering::is_le),
            Self::Greater => order == Some(Ordering::Greater),
            Self::GreaterOrEqual => order.is_some_and(Ordering::is_ge),
        }
    }
}

/// Returns the order of two values; `None` if they cannot be compared.
fn order(left: &Value, right: &Value) -> Option<Ordering> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    match (left, right) {
        (Value::Number(left), Value::Number(right)) => left.partial_cmp(right),
        (Value::Number(left), Value::Text(right)) => left.partial_cmp(&number(right)?),
        (Value::Text(left), Value::Number(right)) => number(left)?.partial_cmp(right),
        (Value::Text(left), Value::Text(right)) => Some(left.cmp(right)),
        (Value::Bool(left), Value::Bool(right)) => Some(left.cmp(right)),
        (Value::Bool(value), Value::Text(text)) | (Value::Text(text), Value::Bool(value)) => {
            text.eq_ignore_ascii_case(if *value { "true" } else { "false" }).then_some(Ordering::Equal)
        }
        // CSV has 1 and 0 for true and false.
        (Value::Bool(left), Value::Number(right)) => f64::from(u8::from(*left)).partial_cmp(right),
        (Value::Number(left), Value::Bool(right)) => left.partial_cmp(&f64::from(u8::from(*right))),
        (Value::None, _) | (_, Value::None) => None,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    fn attributes(entries: &[(&str, Value)]) -> Attributes {
        let mut attributes = Attributes::default();
        entries.iter().for_each(|(name, value)| attributes.push(Arc::from(*name), value.clone()));
        attributes
    }

    fn text(text: &str) -> Value {
        Value::Text(text.to_owned())
    }

    fn hut() -> Attributes {
        attributes(&[
            ("class", text("hut")),
            ("ele", Value::Number(2440.0)),
            ("beds", text("40")),
            ("open", Value::Bool(true)),
            ("name with spaces", text("it's high")),
            ("addr:city", text("Zermatt")),
            ("gone", Value::None),
        ])
    }

    #[test]
    fn conditions_are_met_or_not() {
        for (condition, expected) in [
            ("class == 'hut'", true),
            ("class == 'hut' and ele > 2000", true),
            ("class == 'track' or ele <= 2440", true),
            ("class == 'track' and ele > 0 or open == true", true),
            ("class == 'track' and (ele > 0 or open == true)", false),
            ("not class == 'hut'", false),
            ("NOT not class == 'hut'", true),
            ("class != 'hut'", false),
            ("nothing != 'hut'", true),
            ("nothing == 'hut' or nothing < 1 or nothing >= 1", false),
            ("class in ('track', 'hut')", true),
            ("class not in ('track', 'hut')", false),
            ("ele in (1, 2440)", true),
            ("gone is none and nothing is none and class is not none", true),
            ("beds > 9 and beds == 40 and beds == '40'", true),
            ("beds < '9'", true),
            ("2000<ele", true),
            ("ele >= 2.44e3 and ele > -1", true),
            ("\"name with spaces\" == 'it''s high'", true),
            ("addr:city == 'Zermatt'", true),
            ("open == 'true' and open != false", true),
            ("class < 1 or class > 1", false),
            ("open == 1 and open != 0 and ele != true", true),
        ] {
            assert_eq!(When::parse(condition).unwrap().is_met(&hut()), expected, "{condition}");
        }
    }

    #[test]
    fn mistakes_have_columns() {
        for (condition, expected) in [
            ("", "column 1: the condition is empty"),
            ("class = 'hut'", "column 7: = is not a comparison; use =="),
            ("class == 'hut", "column 10: the text has no closing '"),
            ("\"class == 1", "column 1: the name has no closing \""),
            ("class == 'hut' && ele > 1", "column 16: && is not known; use and"),
            ("ä == 'ö' || x == 1", "column 10: || is not known; use or"),
            ("class", "column 6: expected a comparison, in or is, but the condition ends"),
            ("class == ", "column 10: expected an attribute or a literal, but the condition ends"),
            ("(class == 1", "column 12: expected ), and or or, but the condition ends"),
            ("class == 1)", "column 11: expected and or or, not )"),
            ("1 < ele < 3", "column 9: comparisons cannot be chained; use and"),
            ("class == none", "column 10: none is not a value; use is none"),
            ("class is 1", "column 10: expected none or not none, not 1"),
            ("class in 'a'", "column 10: expected (, not 'a'"),
            ("class in ()", "column 11: expected a literal, not )"),
            ("class in (a)", "column 11: expected a literal, not a; text is written 'a'"),
            ("class not 1", "column 11: expected in, not 1"),
            ("class == ‘hut’", "column 10: ‘ is not a quotation mark for text; use '"),
            ("class == 12x", "column 10: 12x is not a number"),
            ("ele > 2 ele", "column 9: expected and or or, not ele"),
            ("class == upper('a')", "column 15: expected and or or, not ("),
            ("class <> 1", "column 7: <> is not a comparison; use !="),
            ("class == 1 and and x == 1", "column 16: expected an attribute or a literal, not and"),
            ("a ~ 1", "column 3: ~ has no meaning here"),
        ] {
            assert_eq!(When::parse(condition).unwrap_err().to_string(), expected, "{condition}");
        }
    }

    #[test]
    fn unknown_attributes_are_reported() {
        let when = When::parse("class == 'a' and clas == \"track\"").unwrap();
        assert_eq!(when.names().collect::<Vec<_>>(), ["class", "clas", "track"]);
        let error = when.check(&["class", "ele"]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "column 18: there is no attribute \"clas\"; did you mean \"class\"? (text is written 'like this')"
        );
        assert!(when.check(&["class", "clas", "track"]).is_ok());
    }

    #[test]
    fn depth_and_length_are_limited() {
        for hostile in
            ["(".repeat(4000), "not ".repeat(1000), "x".repeat(5000), format!("{}a == 1", "not(".repeat(100))]
        {
            assert!(When::parse(&hostile).is_err());
        }
        let error = When::parse(&"(".repeat(4000)).unwrap_err();
        assert_eq!(error.to_string(), "column 65: the condition is nested more than 64 deep");
        let long = vec!["a == 1"; 400].join(" or ");
        assert!(!When::parse(&long).unwrap().is_met(&hut()));
        let deep = format!("{}class == 'hut'{}", "(".repeat(60), ")".repeat(60));
        assert!(When::parse(&deep).unwrap().is_met(&hut()));
    }

    #[test]
    fn no_text_causes_a_panic() {
        let pieces = [
            "a", "==", "!=", "<", "(", ")", "'x'", "'", "\"", "in", "is", "not", "none", "and", "or", ",", "1", "é",
            " ",
        ];
        let mut random = super::super::tests::Random(7);
        for _ in 0..20_000 {
            let text: String = (0..random.below(12)).map(|_| pieces[random.below(pieces.len())]).collect();
            if let Ok(when) = When::parse(&text) {
                when.is_met(&hut());
            }
        }
    }
}
