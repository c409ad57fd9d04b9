//! Trees of numbers and words, from YAML, JSON or XML as OpenCV's `FileStorage` writes them.

use saphyr_parser::{Event, Parser};

/// Files of calibrations nest matrices in a map and numbers in those. With half of it they would still
/// be read; without a limit, a file of brackets alone would exhaust the stack when it is dropped.
const DEPTH: usize = 32;

/// A node of the tree.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Map(Vec<(String, Node)>),
}

/// Rows of numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Row by row.
    pub(super) data: Vec<f64>,
}

impl Node {
    /// The entry called `key` of a map.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        let Self::Map(entries) = self else { return None };
        entries.iter().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    pub(super) fn number(&self) -> Option<f64> {
        let Self::Number(number) = self else { return None };
        Some(*number)
    }

    fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::List(items) => items.iter().map(Self::number).collect(),
            _ => self.number().map(|number| vec![number]),
        }
    }

    /// A matrix: of OpenCV's kind with `rows`, `cols` and `data`, a list of rows, or one column.
    pub(super) fn matrix(&self) -> Option<Matrix> {
        if let Some(data) = self.get("data") {
            let side = |key| Some(self.get(key)?.number()? as usize);
            let (rows, columns, data) = (side("rows")?, side("cols")?, data.numbers()?);
            let is_whole = rows.checked_mul(columns) == Some(data.len());
            return is_whole.then_some(Matrix { rows, columns, data });
        }
        let Self::List(items) = self else { return None };
        if let Some(data) = self.numbers() {
            return Some(Matrix { rows: data.len(), columns: 1, data });
        }
        let rows: Vec<Vec<f64>> = items.iter().map(Self::numbers).collect::<Option<_>>()?;
        let columns = rows.first()?.len();
        let is_whole = rows.iter().all(|row| row.len() == columns);
        is_whole.then(|| Matrix { rows: rows.len(), columns, data: rows.concat() })
    }

    fn of_word(word: &str) -> Self {
        match word.trim().parse() {
            Ok(number) => Self::Number(number),
            Err(_) => Self::Text(word.to_owned()),
        }
    }
}

/// Reads a file whose name ends in `extension`; whatever is neither JSON nor XML is YAML.
pub(super) fn parse(text: &str, extension: &str) -> Result<Node, String> {
    match extension {
        "json" => of_json(text),
        "xml" => of_xml(text),
        _ => of_yaml(text),
    }
}

fn of_json(text: &str) -> Result<Node, String> {
    fn node(value: &serde_json::Value) -> Node {
        match value {
            serde_json::Value::Array(items) => Node::List(items.iter().map(node).collect()),
            serde_json::Value::Object(entries) => {
                Node::Map(entries.iter().map(|(key, value)| (key.clone(), node(value))).collect())
            }
            serde_json::Value::String(text) => Node::Text(text.clone()),
            other => Node::of_word(&other.to_string()),
        }
    }
    let value = serde_json::from_str(text).map_err(|error| format!("is not JSON: {error}"))?;
    Ok(node(&value))
}

/// The elements below the root, and below those.
fn of_xml(text: &str) -> Result<Node, String> {
    let tree = roxmltree::Document::parse(text).map_err(|error| format!("is not XML: {error}"))?;
    let leaf = |element: roxmltree::Node<'_, '_>| {
        let words: Vec<Node> =
            element.text().unwrap_or_default().split_whitespace().map(Node::of_word).collect();
        match <[Node; 1]>::try_from(words) {
            Ok([word]) => word,
            Err(words) => Node::List(words),
        }
    };
    let name = |element: &roxmltree::Node<'_, '_>| element.tag_name().name().to_owned();
    let entry = |element: roxmltree::Node<'_, '_>| {
        let inner: Vec<(String, Node)> =
            element.children().filter(|c| c.is_element()).map(|c| (name(&c), leaf(c))).collect();
        (name(&element), if inner.is_empty() { leaf(element) } else { Node::Map(inner) })
    };
    let root = tree.root_element();
    Ok(Node::Map(root.children().filter(|c| c.is_element()).map(entry).collect()))
}

/// A list or a map that is not complete yet, with the key that waits for its value.
struct Open {
    node: Node,
    key: Option<String>,
}

impl Open {
    fn add(&mut self, item: Node) -> Result<(), String> {
        match (&mut self.node, self.key.take(), item) {
            (Node::List(items), _, item) => items.push(item),
            (Node::Map(entries), Some(key), item) => entries.push((key, item)),
            (_, None, Node::Text(key)) => self.key = Some(key),
            (_, None, Node::Number(key)) => self.key = Some(key.to_string()),
            _ => return Err("is no YAML of OpenCV's: a key is a list or a map".into()),
        }
        Ok(())
    }
}

/// The first document. Its head `%YAML:1.0` is OpenCV's own; YAML itself has no colon there.
fn of_yaml(text: &str) -> Result<Node, String> {
    let text = match text.strip_prefix("%YAML:1.0") {
        Some(rest) => rest,
        None => text,
    };
    let mut open: Vec<Open> = Vec::new();
    for event in Parser::new_from_str(text) {
        let (event, _) = event.map_err(|error| format!("is not YAML: {error}"))?;
        let whole = match event {
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                let is_list = matches!(event, Event::SequenceStart(..));
                let node = if is_list { Node::List(vec![]) } else { Node::Map(vec![]) };
                open.push(Open { node, key: None });
                if open.len() > DEPTH {
                    return Err(format!("is no calibration: it nests deeper than {DEPTH} levels"));
                }
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => open.pop().map(|open| open.node),
            Event::Scalar(text, ..) => Some(Node::of_word(&text)),
            Event::Alias(_) => return Err("has an alias (*), which OpenCV does not write".into()),
            _ => None,
        };
        match (whole, open.last_mut()) {
            (Some(node), Some(around)) => around.add(node)?,
            (Some(node), None) => return Ok(node),
            (None, _) => (),
        }
    }
    Err("is empty".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_three_forms_are_one_tree() {
        let yaml = "%YAML:1.0\n---\n# made by a script\nsize: 640\nK: !!opencv-matrix\n   rows: 2\n   \
                    cols: 2\n   dt: d\n   data: [ 5.35e+02, 0., .5,\n       1. ]\nwords: \"a b\"\n";
        let json = "{\"size\": 640, \"K\": {\"type_id\": \"opencv-matrix\", \"rows\": 2, \
                    \"cols\": 2, \"dt\": \"d\", \"data\": [535.0, 0, 0.5, 1]}}";
        let xml = "<?xml version=\"1.0\"?><opencv_storage><size>640</size>\
                   <K type_id=\"opencv-matrix\"><rows>2</rows><cols>2</cols><dt>d</dt>\
                   <data>535. 0. .5\n 1.</data></K></opencv_storage>";
        let nested = "{\"size\": 640, \"K\": [[535, 0], [0.5, 1]]}";
        for (text, extension) in
            [(yaml, "yml"), (json, "json"), (xml, "xml"), (nested, "json"), (nested, "yaml")]
        {
            let tree = parse(text, extension).unwrap();
            assert_eq!(tree.get("size").unwrap().number(), Some(640.0), "{extension}");
            let matrix = tree.get("K").unwrap().matrix().unwrap();
            let expected = Matrix { rows: 2, columns: 2, data: vec![535.0, 0.0, 0.5, 1.0] };
            assert_eq!(matrix, expected, "{extension}");
        }
    }

    #[test]
    fn what_is_no_such_file_is_reported() {
        for (text, extension, expected) in [
            ("", "yml", "is empty"),
            ("a: [1, 2", "yml", "is not YAML"),
            ("a: &b 1\nc: *b\n", "yml", "alias"),
            ("? [1]\n: 2\n", "yml", "a key is a list"),
            ("{", "json", "is not JSON"),
            ("<a>", "xml", "is not XML"),
        ] {
            let problem = parse(text, extension).unwrap_err();
            assert!(problem.contains(expected), "{text}: {problem}");
        }
        assert!(parse(&"[".repeat(100), "yml").unwrap_err().contains("nests deeper"));
        assert!(parse(&"[".repeat(100_000), "yml").is_err());
        assert!(parse(&"- ".repeat(100_000), "yml").is_err());
        let wrong = parse("{\"K\": {\"rows\": 3, \"cols\": 3, \"data\": [1]}}", "json").unwrap();
        assert_eq!(wrong.get("K").unwrap().matrix(), None);
    }
}
