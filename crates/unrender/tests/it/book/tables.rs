//! The tables of keys on the pages of `docs/reference`, made from the schemas.
//! `<!-- keys NAME#POINTER -->` marks the place of one.

use super::schema::{NAMES, schema, target};
use super::{files, hold, root};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;

const BEGIN: &str = "<!-- keys ";
const END: &str = "<!-- end of keys -->";

/// The table of the object at `pointer` in the schema `name`.
fn table(name: &str, pointer: &str) -> String {
    let schema = schema(name);
    let object = schema.pointer(pointer).unwrap_or_else(|| panic!("{name} has no {pointer}"));
    let required: BTreeSet<&str> = match object.get("required").and_then(Value::as_array) {
        Some(keys) => keys.iter().filter_map(Value::as_str).collect(),
        None => BTreeSet::new(),
    };
    let properties = object["properties"].as_object().unwrap();
    let absent = |key: &str, of_key: &Value| match of_key.get("default") {
        Some(default) => format!("`{default}`"),
        None if required.contains(key) => "must be there".to_owned(),
        None => String::new(),
    };
    // Files that the program writes have all their keys; only files that people write have
    // defaults.
    let is_input = ["project", "edit", "lighting"].contains(&name);
    let (head, rule) = if is_input { (" default |", "---|") } else { ("", "") };
    let mut text = format!("| key | value | meaning |{head}\n|---|---|---|{rule}\n");
    for (key, of_key) in properties {
        let meaning = of_key.get("description").and_then(Value::as_str).unwrap_or_default();
        let value = kind(name, of_key);
        let last = if is_input { format!(" {} |", absent(key, of_key)) } else { String::new() };
        text.push_str(&format!("| `{key}` | {value} | {meaning} |{last}\n"));
    }
    text.replace("  |", " |")
}

/// The allowed values, in words.
fn kind(name: &str, at: &Value) -> String {
    if let Some(title) = at.get("title").and_then(Value::as_str) {
        return title.to_owned();
    }
    if let Some((name, at)) = target(name, at) {
        return kind(&name, &at);
    }
    if let Some(value) = at.get("const") {
        return format!("`{value}`");
    }
    if let Some(values) = at.get("enum").and_then(Value::as_array) {
        let values = values.iter().filter(|value| !value.is_null());
        return values.map(|value| format!("`{value}`")).collect::<Vec<_>>().join(", ");
    }
    if let Some(choices) = at.get("oneOf").and_then(Value::as_array) {
        let choices = choices.iter().filter(|choice| choice["type"] != "null");
        return choices.map(|choice| kind(name, choice)).collect::<Vec<_>>().join(", or ");
    }
    let types = match &at["type"] {
        Value::Array(types) => types.iter().filter_map(Value::as_str).collect(),
        single => vec![single.as_str().unwrap_or_else(|| panic!("{name}: no type in {at}"))],
    };
    let word = types.into_iter().find(|word| *word != "null").unwrap_or("null");
    let words = [("string", "text"), ("integer", "whole number"), ("boolean", "`true`, `false`")];
    words.iter().find(|(from, _)| *from == word).map_or(word, |(_, to)| to).to_owned()
}

#[test]
fn tables_of_keys_are_those_of_the_schemas() {
    let mut seen = BTreeSet::new();
    for page in files("docs/reference", ".md") {
        let text = fs::read_to_string(root().join(&page)).unwrap();
        for mark in text.split(BEGIN).skip(1) {
            let (place, _) = mark.split_once(" -->").unwrap();
            let (name, pointer) = place.split_once('#').unwrap();
            hold(&page, (&format!("{BEGIN}{place} -->"), END), &table(name, pointer));
            assert!(seen.insert(place.to_owned()), "{place} is on the pages twice");
        }
    }
    for name in NAMES {
        let schema = schema(name);
        let has_keys = |at: &Value| at.get("properties").is_some();
        let parts = schema["$defs"].as_object().unwrap().iter();
        let parts =
            parts.filter(|(_, at)| has_keys(at)).map(|(key, _)| format!("{name}#/$defs/{key}"));
        let whole = has_keys(&schema).then(|| format!("{name}#"));
        for place in parts.chain(whole) {
            assert!(seen.contains(&place), "no page of docs/reference has <!-- keys {place} -->");
        }
    }
}
