//! USD in its binary form (`.usdc`, the "crate" format), version 0.8, the one in which OpenUSD writes.
//!
//! The file has a head, the values that are longer than four bytes, and six tables. A *spec* is a path with a set of
//! *fields*; a field is a name with a value; names are *tokens*. A value is a number of 64 bits: its type, whether it is
//! an array, and the value itself or the place of it in the file. [OpenUSD, Usdc file format]

use super::packed::{block, integers, sized};
use super::stage::{Metadata, Prim, Property, Stage, Value};
use indexmap::{IndexMap, IndexSet};

/// The format's version, the last of the head's eight bytes.
const VERSION: [u8; 8] = [0, 8, 0, 0, 0, 0, 0, 0];
/// Bytes of the head.
const HEAD: usize = 88;
/// Values start at multiples of so many bytes, so that readers can map arrays into memory.
const ALIGNED: usize = 8;
/// Ends a set of fields.
const END: u32 = u32::MAX;
/// A value that is an array.
const ARRAY: u64 = 1 << 63;
/// A value that stands in the number itself, not at a place in the file.
const INLINED: u64 = 1 << 62;

/// The type of a value, as the format numbers them.
#[derive(Clone, Copy)]
enum Type {
    Bool = 1,
    Int = 3,
    Float = 8,
    Double = 9,
    String = 10,
    Token = 11,
    Asset = 12,
    Matrix = 15,
    Float2 = 20,
    Float3 = 24,
    Float4 = 28,
    TokenList = 32,
    PathList = 34,
    TokenVector = 41,
    Specifier = 42,
    Variability = 44,
}

/// What a spec describes, as the format numbers it.
#[derive(Clone, Copy)]
enum Kind {
    Attribute = 1,
    Prim = 6,
    Root = 7,
    Relationship = 8,
}

/// Items of a list that is stated whole, and items that go before those of weaker layers: bits of a list's first byte.
const EXPLICIT: u8 = 1 | 2;
const PREPENDED: u8 = 1 << 5;

/// The bytes of `stage`.
///
/// # Errors
/// If it is too large for the format.
pub(super) fn bytes(stage: &Stage) -> Result<Vec<u8>, String> {
    let mut file = File { bytes: vec![0; HEAD], ..File::default() };
    // A property's token is written with a minus sign in front of its number, which zero lacks.
    file.token("");
    let mut nodes = vec![Node { token: 0, is_property: false, jump: -1 }];
    file.paths.insert("/".into());
    list_paths(&stage.root, "", true, &mut file, &mut nodes);
    let mut fields = file.metadata(&stage.metadata);
    fields.push(file.token_vector("primChildren", std::iter::once(stage.root.name.as_str())));
    file.spec("/", Kind::Root, fields);
    file.prim(&stage.root, "");
    file.finish(&nodes)
}

/// A path below its parent.
struct Node {
    /// The index of the last part of it.
    token: i32,
    is_property: bool,
    /// Where to read on: -2 at a leaf that is the last of its parent, -1 if the first child comes next and no sibling
    /// does, 0 if a sibling comes next, else how many nodes behind this one its sibling is, the first child coming next.
    jump: i32,
}

/// Lists the paths of `prim` and all below it, each before those below, and numbers them in this order.
fn list_paths(prim: &Prim, parent: &str, is_last: bool, file: &mut File, nodes: &mut Vec<Node>) {
    let path = format!("{parent}/{}", prim.name);
    let (index, below) = (nodes.len(), prim.properties.len() + prim.children.len());
    nodes.push(Node { token: file.token(&prim.name) as i32, is_property: false, jump: -2 });
    file.paths.insert(path.clone());
    for (place, property) in prim.properties.iter().enumerate() {
        let jump = if place + 1 < below { 0 } else { -2 };
        let token = file.token(property.name()) as i32;
        nodes.push(Node { token, is_property: true, jump });
        file.paths.insert(format!("{path}.{}", property.name()));
    }
    for (place, child) in prim.children.iter().enumerate() {
        list_paths(child, &path, place + 1 == prim.children.len(), file, nodes);
    }
    nodes[index].jump = match (below > 0, is_last) {
        (true, true) => -1,
        (true, false) => (nodes.len() - index) as i32,
        (false, true) => -2,
        (false, false) => 0,
    };
}

/// A name with a value: the index of the token, and the number of 64 bits.
type Field = (u32, u64);

/// A file in the making.
#[derive(Default)]
struct File {
    /// The head and the values, in the end all of it.
    bytes: Vec<u8>,
    tokens: IndexSet<String>,
    /// The tokens that are strings.
    strings: IndexMap<u32, ()>,
    paths: IndexSet<String>,
    fields: IndexSet<Field>,
    /// Sets of indices of fields, each with [`END`] behind it.
    sets: Vec<u32>,
    /// The index of the path, the start of the set of fields, and the kind.
    specs: Vec<[u32; 3]>,
}

impl File {
    fn token(&mut self, text: &str) -> u32 {
        let known = self.tokens.get_index_of(text);
        known.unwrap_or_else(|| self.tokens.insert_full(text.to_owned()).0) as u32
    }

    fn path(&mut self, path: &str) -> u32 {
        self.paths.insert_full(path.to_owned()).0 as u32
    }

    fn spec(&mut self, path: &str, kind: Kind, fields: Vec<Field>) {
        let path = self.path(path);
        self.specs.push([path, self.sets.len() as u32, kind as u32]);
        for field in fields {
            let index = self.fields.insert_full(field).0;
            self.sets.push(index as u32);
        }
        self.sets.push(END);
    }

    fn prim(&mut self, prim: &Prim, parent: &str) {
        let path = format!("{parent}/{}", prim.name);
        let mut fields = vec![
            self.field("specifier", inlined(Type::Specifier, 0)),
            self.field_of("typeName", &Value::token(prim.kind)),
        ];
        fields.extend(self.metadata(&prim.metadata));
        if !prim.schemas.is_empty() {
            let schemas: Vec<u32> = prim.schemas.iter().map(|schema| self.token(schema)).collect();
            let list = self.list(Type::TokenList, PREPENDED, &schemas);
            fields.push(self.field("apiSchemas", list));
        }
        if !prim.properties.is_empty() {
            let names = prim.properties.iter().map(Property::name);
            fields.push(self.token_vector("properties", names));
        }
        if !prim.children.is_empty() {
            let names = prim.children.iter().map(|child| child.name.as_str());
            fields.push(self.token_vector("primChildren", names));
        }
        self.spec(&path, Kind::Prim, fields);
        for property in &prim.properties {
            self.property(property, &path);
        }
        for child in &prim.children {
            self.prim(child, &path);
        }
    }

    fn property(&mut self, property: &Property, prim: &str) {
        let path = format!("{prim}.{}", property.name());
        let uniform = inlined(Type::Variability, 1);
        match property {
            Property::Relationship { target, .. } => {
                let fields =
                    vec![self.field("variability", uniform), self.field_to("targetPaths", target)];
                self.spec(&path, Kind::Relationship, fields);
            }
            Property::Attribute(attribute) => {
                let mut fields = vec![self.field_of("typeName", &Value::token(attribute.kind))];
                if attribute.is_uniform {
                    fields.push(self.field("variability", uniform));
                }
                fields.extend(attribute.value.iter().map(|value| self.field_of("default", value)));
                if let Some(source) = &attribute.source {
                    fields.push(self.field_to("connectionPaths", source));
                }
                fields.extend(self.metadata(&attribute.metadata));
                self.spec(&path, Kind::Attribute, fields);
            }
        }
    }

    fn metadata(&mut self, metadata: &Metadata) -> Vec<Field> {
        metadata.iter().map(|(name, value)| self.field_of(name, value)).collect()
    }

    fn field(&mut self, name: &str, value: u64) -> Field {
        (self.token(name), value)
    }

    fn field_of(&mut self, name: &str, value: &Value) -> Field {
        let value = self.value(value);
        self.field(name, value)
    }

    /// A field that is one path.
    fn field_to(&mut self, name: &str, path: &str) -> Field {
        let path = self.path(path);
        let list = self.list(Type::PathList, EXPLICIT, &[path]);
        self.field(name, list)
    }

    fn token_vector<'a>(&mut self, name: &str, tokens: impl Iterator<Item = &'a str>) -> Field {
        let tokens: Vec<u32> = tokens.map(|token| self.token(token)).collect();
        let place = self.place();
        self.put_indices(&tokens);
        self.field(name, at(Type::TokenVector, place))
    }

    /// A list of indices whose first byte is `what`.
    fn list(&mut self, kind: Type, what: u8, indices: &[u32]) -> u64 {
        let place = self.place();
        self.bytes.push(what);
        self.put_indices(indices);
        at(kind, place)
    }

    fn put_indices(&mut self, indices: &[u32]) {
        self.bytes.extend((indices.len() as u64).to_le_bytes());
        self.bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    }

    /// Where the next value starts.
    fn place(&mut self) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNED), 0);
        self.bytes.len()
    }

    fn value(&mut self, value: &Value) -> u64 {
        match value {
            Value::Bool(value) => inlined(Type::Bool, u32::from(*value)),
            Value::Float(value) => inlined(Type::Float, value.to_bits()),
            Value::Token(text) => inlined(Type::Token, self.token(text)),
            Value::Asset(path) => inlined(Type::Asset, self.token(path)),
            Value::String(text) => {
                let token = self.token(text);
                inlined(Type::String, self.strings.insert_full(token, ()).0 as u32)
            }
            Value::Double(value) => self.plain(Type::Double, &value.to_le_bytes()),
            Value::Float2(v) => self.plain(Type::Float2, &floats(&v.to_array())),
            Value::Float3(v) => self.plain(Type::Float3, &floats(&v.to_array())),
            Value::Float4(v) => self.plain(Type::Float4, &floats(v)),
            Value::Matrix(matrix) => {
                let bytes: Vec<u8> =
                    matrix.to_cols_array().iter().flat_map(|n| n.to_le_bytes()).collect();
                self.plain(Type::Matrix, &bytes)
            }
            Value::Ints(values) => self.array(Type::Int, values, |value| value.to_le_bytes()),
            Value::Tokens(values) => {
                let tokens: Vec<u32> = values.iter().map(|token| self.token(token)).collect();
                self.array(Type::Token, &tokens, |index| index.to_le_bytes())
            }
            Value::Float2s(values) => self.array(Type::Float2, values, |v| floats(&v.to_array())),
            Value::Float3s(values) => self.array(Type::Float3, values, |v| floats(&v.to_array())),
        }
    }

    fn plain(&mut self, kind: Type, bytes: &[u8]) -> u64 {
        let place = self.place();
        self.bytes.extend(bytes);
        at(kind, place)
    }

    fn array<T, B: IntoIterator<Item = u8>>(
        &mut self,
        kind: Type,
        items: &[T],
        bytes: impl Fn(&T) -> B,
    ) -> u64 {
        if items.is_empty() {
            return ARRAY | at(kind, 0);
        }
        let place = self.place();
        self.bytes.extend((items.len() as u64).to_le_bytes());
        self.bytes.extend(items.iter().flat_map(bytes));
        ARRAY | at(kind, place)
    }

    /// The whole file: the tables behind the values, the table of contents behind these, and the head.
    fn finish(mut self, nodes: &[Node]) -> Result<Vec<u8>, String> {
        let tables = self.tables(nodes)?;
        let mut contents = (tables.len() as u64).to_le_bytes().to_vec();
        for (name, table) in tables {
            let (start, size) = (self.place() as u64, table.len() as u64);
            self.bytes.extend(table);
            let mut row = [0; 16];
            row[..name.len()].copy_from_slice(name.as_bytes());
            contents.extend(row);
            contents.extend([start, size].into_iter().flat_map(u64::to_le_bytes));
        }
        let place = self.place() as u64;
        self.bytes.extend(contents);
        self.bytes[..8].copy_from_slice(b"PXR-USDC");
        self.bytes[8..16].copy_from_slice(&VERSION);
        self.bytes[16..24].copy_from_slice(&place.to_le_bytes());
        Ok(self.bytes)
    }

    fn tables(&self, nodes: &[Node]) -> Result<[(&'static str, Vec<u8>); 6], String> {
        if let Some(path) = self.paths.get_index(nodes.len()) {
            return Err(format!("refers to {path}, which it lacks"));
        }
        let text: Vec<u8> =
            self.tokens.iter().flat_map(|token| [token.as_bytes(), b"\0"].concat()).collect();
        let texts = block(&text)?;
        let count = |items: usize| (items as u64).to_le_bytes().to_vec();
        let tokens =
            [count(self.tokens.len()), count(text.len()), count(texts.len()), texts].concat();
        let strings: Vec<u8> = self.strings.keys().flat_map(|index| index.to_le_bytes()).collect();
        let values: Vec<u8> = self.fields.iter().flat_map(|field| field.1.to_le_bytes()).collect();
        let fields = [
            count(self.fields.len()),
            integers(self.fields.iter().map(|field| field.0 as i32))?,
            sized(&values)?,
        ];
        let sets = [count(self.sets.len()), integers(self.sets.iter().map(|index| *index as i32))?];
        let signed = |node: &Node| if node.is_property { -node.token } else { node.token };
        let paths = [
            count(nodes.len()),
            count(nodes.len()),
            integers(0..nodes.len() as i32)?,
            integers(nodes.iter().map(signed))?,
            integers(nodes.iter().map(|node| node.jump))?,
        ];
        let of_specs = |column: usize| integers(self.specs.iter().map(|spec| spec[column] as i32));
        let specs = [count(self.specs.len()), of_specs(0)?, of_specs(1)?, of_specs(2)?];
        Ok([
            ("TOKENS", tokens),
            ("STRINGS", [count(self.strings.len()), strings].concat()),
            ("FIELDS", fields.concat()),
            ("FIELDSETS", sets.concat()),
            ("PATHS", paths.concat()),
            ("SPECS", specs.concat()),
        ])
    }
}

/// A value of at most four bytes.
fn inlined(kind: Type, bits: u32) -> u64 {
    INLINED | at(kind, bits as usize)
}

/// A value at a place of the file.
fn at(kind: Type, place: usize) -> u64 {
    (kind as u64) << 48 | place as u64
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}
