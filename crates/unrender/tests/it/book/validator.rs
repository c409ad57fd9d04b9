//! Validation by JSON Schema 2020-12, for the keywords that the schemas of the repository use.
//!
//! A library for all of it brings 35 crates. A keyword that is not known here is a failure, so that no
//! schema says something that nobody checks. `$ref` stands alone or beside others, as 2020-12 has it.

use serde_json::{Map, Value};

/// Words that say something to people only.
const SILENT: [&str; 6] = ["$schema", "$defs", "title", "description", "default", "then"];

/// Checks values with schemas that may refer to each other.
pub(crate) struct Validator<'a> {
    /// The schema of a name.
    pub(crate) schema: &'a dyn Fn(&str) -> Value,
}

impl Validator<'_> {
    /// What of `value` is not as `at` says, a part of the schema `name`.
    pub(crate) fn faults(&self, name: &str, at: &Value, value: &Value, place: &str) -> Vec<String> {
        let Some(words) = at.as_object() else { panic!("{name}: {at} is no schema") };
        let said = words.iter().filter(|(word, _)| !SILENT.contains(&word.as_str()));
        let faults = said.flat_map(|(word, wanted)| {
            self.faults_of_word(name, words, (word, wanted), value, place)
        });
        faults.collect()
    }

    fn is_valid(&self, name: &str, at: &Value, value: &Value) -> bool {
        self.faults(name, at, value, "").is_empty()
    }

    fn faults_of_word(
        &self,
        name: &str,
        words: &Map<String, Value>,
        (word, wanted): (&String, &Value),
        value: &Value,
        place: &str,
    ) -> Vec<String> {
        let list = || wanted.as_array().unwrap().iter();
        let how_many = || list().filter(|at| self.is_valid(name, at, value)).count();
        let texts = |list: &Value| -> Vec<String> {
            list.as_array().unwrap().iter().map(|v| v.as_str().unwrap().to_owned()).collect()
        };
        let holds = match word.as_str() {
            "$ref" => {
                let (file, pointer) = wanted.as_str().unwrap().split_once('#').unwrap();
                let name = file.strip_suffix(".schema.json").unwrap_or(name);
                let schema = (self.schema)(name);
                return self.faults(name, schema.pointer(pointer).unwrap(), value, place);
            }
            "properties" => return self.of_properties(name, wanted, value, place),
            "additionalProperties" => return self.of_others(name, words, wanted, value, place),
            "items" => {
                let items = value.as_array().into_iter().flatten().enumerate();
                return items
                    .flat_map(|(i, item)| self.faults(name, wanted, item, &format!("{place}/{i}")))
                    .collect();
            }
            "allOf" => return list().flat_map(|at| self.faults(name, at, value, place)).collect(),
            "anyOf" => how_many() > 0,
            "oneOf" => how_many() == 1,
            "not" => !self.is_valid(name, wanted, value),
            "if" if self.is_valid(name, wanted, value) => {
                return self.faults(name, &words["then"], value, place);
            }
            "if" => true,
            "type" => match wanted {
                Value::Array(types) => types.iter().any(|one| is_of_type(value, one)),
                one => is_of_type(value, one),
            },
            "enum" => list().any(|one| one == value),
            "const" => wanted == value,
            "required" => value
                .as_object()
                .is_none_or(|map| texts(wanted).iter().all(|key| map.contains_key(key))),
            "dependentRequired" => value.as_object().is_none_or(|map| {
                let needed = wanted.as_object().unwrap().iter();
                needed
                    .filter(|(key, _)| map.contains_key(*key))
                    .all(|(_, others)| texts(others).iter().all(|other| map.contains_key(other)))
            }),
            "minimum" => bound(value, wanted, |v, b| v >= b),
            "exclusiveMinimum" => bound(value, wanted, |v, b| v > b),
            "maximum" => bound(value, wanted, |v, b| v <= b),
            "exclusiveMaximum" => bound(value, wanted, |v, b| v < b),
            "minItems" => {
                value.as_array().is_none_or(|v| v.len() as u64 >= wanted.as_u64().unwrap())
            }
            "maxItems" => {
                value.as_array().is_none_or(|v| v.len() as u64 <= wanted.as_u64().unwrap())
            }
            "pattern" => {
                value.as_str().is_none_or(|text| matches_pattern(wanted.as_str().unwrap(), text))
            }
            other => panic!("{name}: the keyword {other} is not known to this test"),
        };
        if holds { Vec::new() } else { vec![format!("{place}: {value} against {word} {wanted}")] }
    }

    fn of_properties(&self, name: &str, wanted: &Value, value: &Value, place: &str) -> Vec<String> {
        let Some(map) = value.as_object() else { return Vec::new() };
        let known = map.iter().filter_map(|(key, value)| Some((key, wanted.get(key)?, value)));
        known
            .flat_map(|(key, at, value)| self.faults(name, at, value, &format!("{place}/{key}")))
            .collect()
    }

    fn of_others(
        &self,
        name: &str,
        words: &Map<String, Value>,
        wanted: &Value,
        value: &Value,
        place: &str,
    ) -> Vec<String> {
        let Some(map) = value.as_object() else { return Vec::new() };
        let is_known =
            |key: &&String| words.get("properties").is_some_and(|p| p.get(key).is_some());
        let others = map.keys().filter(|key| !is_known(key));
        others
            .flat_map(|key| match wanted {
                Value::Bool(true) => Vec::new(),
                Value::Bool(false) => vec![format!("{place}: there is no key {key}")],
                at => self.faults(name, at, &map[key], &format!("{place}/{key}")),
            })
            .collect()
    }
}

fn is_of_type(value: &Value, name: &Value) -> bool {
    match name.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.as_f64().is_some_and(|v| v.fract() == 0.0),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("there is no type {other}"),
    }
}

fn bound(value: &Value, bound: &Value, holds: fn(f64, f64) -> bool) -> bool {
    value.as_f64().is_none_or(|value| holds(value, bound.as_f64().unwrap()))
}

/// The two patterns that the schemas have.
fn matches_pattern(pattern: &str, text: &str) -> bool {
    match pattern {
        "[./]" => text.contains(['.', '/']),
        "^same as " => text.starts_with("same as "),
        "^#[0-9a-f]{6}$" => text.strip_prefix('#').is_some_and(|digits| {
            let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
            digits.len() == 6 && digits.chars().all(is_digit)
        }),
        other => panic!("the pattern {other} is not known to this test"),
    }
}

#[test]
fn every_keyword_refuses_what_it_should() {
    let other = serde_json::json!({ "$defs": { "small": { "type": "number", "maximum": 3 } } });
    let validator = Validator { schema: &|_| other.clone() };
    let refuses = |at: &str, value: &str| {
        let [at, value] = [at, value].map(|text| serde_json::from_str(text).unwrap());
        !validator.is_valid("other", &at, &value)
    };
    for (at, bad, good) in [
        (r##"{"$ref": "#/$defs/small"}"##, "4", "3"),
        (r#"{"type": "integer"}"#, "1.5", "1"),
        (r#"{"type": ["string", "null"]}"#, "1", "null"),
        (r#"{"properties": {"a": {"const": 1}}}"#, r#"{"a": 2}"#, r#"{"a": 1}"#),
        (
            r#"{"properties": {"a": {}}, "additionalProperties": false}"#,
            r#"{"b": 1}"#,
            r#"{"a": 1}"#,
        ),
        (r#"{"additionalProperties": {"type": "number"}}"#, r#"{"b": "x"}"#, r#"{"b": 1}"#),
        (r#"{"items": {"minimum": 0}}"#, "[-1]", "[1]"),
        (r#"{"minItems": 2, "maxItems": 3}"#, "[1]", "[1, 2]"),
        (r#"{"oneOf": [{"minimum": 1}, {"maximum": 2}]}"#, "1.5", "3"),
        (r#"{"anyOf": [{"minimum": 2}, {"maximum": 1}]}"#, "1.5", "3"),
        (r#"{"allOf": [{"minimum": 2}, {"maximum": 4}]}"#, "5", "3"),
        (r#"{"not": {"required": ["a"]}}"#, r#"{"a": 1}"#, "{}"),
        (r#"{"required": ["a"]}"#, "{}", r#"{"a": 1}"#),
        (r#"{"dependentRequired": {"a": ["b"]}}"#, r#"{"a": 1}"#, r#"{"b": 1}"#),
        (r#"{"if": {"minimum": 1}, "then": {"maximum": 2}}"#, "3", "0"),
        (r#"{"enum": ["a", null]}"#, r#""b""#, "null"),
        (r#"{"exclusiveMinimum": 0, "exclusiveMaximum": 1}"#, "0", "0.5"),
        (r#"{"pattern": "^#[0-9a-f]{6}$"}"#, r##""#12345g""##, r##""#12345f""##),
    ] {
        assert!(refuses(at, bad), "{at} takes {bad}");
        assert!(!refuses(at, good), "{at} refuses {good}");
    }
}
