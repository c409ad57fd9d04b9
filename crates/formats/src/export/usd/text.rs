//! USD as text (`.usda`). [OpenUSD, Usda file format]

use super::stage::{Attribute, Metadata, Prim, Property, Stage, Value};
use std::fmt::Write;

/// The text of `stage`.
pub(super) fn bytes(stage: &Stage) -> Vec<u8> {
    let mut text = String::from("#usda 1.0\n(\n");
    fields(&stage.metadata, "    ", &mut text);
    text.push_str(")\n\n");
    prim(&stage.root, "", &mut text);
    text.into_bytes()
}

fn prim(prim: &Prim, indent: &str, text: &mut String) {
    let inside = format!("{indent}    ");
    let _ = write!(text, "{indent}def {} \"{}\"", prim.kind, prim.name);
    if !prim.metadata.is_empty() || !prim.schemas.is_empty() {
        text.push_str(" (\n");
        fields(&prim.metadata, &inside, text);
        if !prim.schemas.is_empty() {
            let schemas = list(&prim.schemas, |schema| quoted(schema));
            let _ = writeln!(text, "{inside}prepend apiSchemas = {schemas}");
        }
        let _ = write!(text, "{indent})");
    }
    let _ = write!(text, "\n{indent}{{\n");
    for property in &prim.properties {
        match property {
            Property::Attribute(attribute) => self::attribute(attribute, &inside, text),
            Property::Relationship { name, target } => {
                let _ = writeln!(text, "{inside}rel {name} = <{target}>");
            }
        }
    }
    for child in &prim.children {
        text.push('\n');
        self::prim(child, &inside, text);
    }
    let _ = writeln!(text, "{indent}}}");
}

fn attribute(attribute: &Attribute, indent: &str, text: &mut String) {
    let uniform = if attribute.is_uniform { "uniform " } else { "" };
    let declared = format!("{indent}{uniform}{} {}", attribute.kind, attribute.name);
    if let Some(source) = &attribute.source {
        let _ = writeln!(text, "{declared}.connect = <{source}>");
        return;
    }
    text.push_str(&declared);
    if let Some(value) = &attribute.value {
        let _ = write!(text, " = {}", literal(value));
    }
    if !attribute.metadata.is_empty() {
        text.push_str(" (\n");
        fields(&attribute.metadata, &format!("{indent}    "), text);
        let _ = write!(text, "{indent})");
    }
    text.push('\n');
}

fn fields(metadata: &Metadata, indent: &str, text: &mut String) {
    for (name, value) in metadata {
        let _ = writeln!(text, "{indent}{name} = {}", literal(value));
    }
}

/// A value as the text format has it.
fn literal(value: &Value) -> String {
    match value {
        Value::Bool(value) => u8::from(*value).to_string(),
        Value::Float(value) => value.to_string(),
        Value::Double(value) => value.to_string(),
        Value::Token(text) | Value::String(text) => quoted(text),
        Value::Asset(path) => asset(path),
        Value::Float2(v) => tuple(&v.to_array()),
        Value::Float3(v) => tuple(&v.to_array()),
        Value::Float4(v) => tuple(v),
        Value::Matrix(matrix) => {
            let rows = matrix.to_cols_array_2d().map(|row| tuple(&row));
            format!("( {} )", rows.join(", "))
        }
        Value::Ints(values) => list(values, i32::to_string),
        Value::Tokens(values) => list(values, |token| quoted(token)),
        Value::Float2s(values) => list(values, |v| tuple(&v.to_array())),
        Value::Float3s(values) => list(values, |v| tuple(&v.to_array())),
    }
}

fn tuple<T: ToString>(numbers: &[T]) -> String {
    let numbers: Vec<String> = numbers.iter().map(T::to_string).collect();
    format!("({})", numbers.join(", "))
}

fn list<T>(items: &[T], text: impl Fn(&T) -> String) -> String {
    let items: Vec<String> = items.iter().map(text).collect();
    format!("[{}]", items.join(", "))
}

/// Text in double quotes on one line.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            '\t' => quoted.push_str("\\t"),
            c if c.is_ascii_control() => {
                let _ = write!(quoted, "\\x{:02x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// A path between at signs, three where it has one itself.
fn asset(path: &str) -> String {
    if path.contains('@') {
        return format!("@@@{}@@@", path.replace("@@@", "\\@@@"));
    }
    format!("@{path}@")
}
