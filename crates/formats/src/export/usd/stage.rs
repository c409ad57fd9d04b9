//! A USD stage as plain data: a tree of prims with typed values, which both writers take.
//!
//! It holds what exports need of USD's data model: definitions, attributes with one value, connections, relationships of
//! one target, and prepended API schemas. [OpenUSD, Sdf data model]

use glam::{DMat4, Vec2, Vec3};

/// A typed value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// `bool`
    Bool(bool),
    /// `float`
    Float(f32),
    /// `double`
    Double(f64),
    /// `token`
    Token(String),
    /// `string`
    String(String),
    /// `asset`: a path.
    Asset(String),
    /// `float2` and its roles.
    Float2(Vec2),
    /// `float3` and its roles, such as `color3f`.
    Float3(Vec3),
    /// `float4`
    Float4([f32; 4]),
    /// `matrix4d`, with the images of the axes and the translation as rows.
    Matrix(DMat4),
    /// `int[]`
    Ints(Vec<i32>),
    /// `token[]`
    Tokens(Vec<String>),
    /// `float2[]` and its roles, such as `texCoord2f[]`.
    Float2s(Vec<Vec2>),
    /// `float3[]` and its roles, such as `point3f[]`.
    Float3s(Vec<Vec3>),
}

impl Value {
    /// A token.
    pub(super) fn token(text: &str) -> Self {
        Self::Token(text.into())
    }
}

/// Fields of a prim, of an attribute or of the stage beside those that are written in a way of their own.
pub(super) type Metadata = Vec<(&'static str, Value)>;

/// An attribute or a relationship.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Property {
    /// An attribute.
    Attribute(Attribute),
    /// A relationship.
    Relationship {
        /// Its name.
        name: &'static str,
        /// The path of its target.
        target: String,
    },
}

impl Property {
    /// Its name.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Attribute(attribute) => attribute.name,
            Self::Relationship { name, .. } => name,
        }
    }
}

/// An attribute: with a value, a connection, or neither, as outputs are declared.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Attribute {
    /// The name of its type, such as `color3f[]`.
    pub(super) kind: &'static str,
    /// Its name.
    pub(super) name: &'static str,
    /// Whether it is the same at all times.
    pub(super) is_uniform: bool,
    /// Its value.
    pub(super) value: Option<Value>,
    /// The path of the attribute that it takes its value from.
    pub(super) source: Option<String>,
    /// Its other fields.
    pub(super) metadata: Metadata,
}

/// A definition in the tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Prim {
    /// Its name, an identifier.
    pub(super) name: String,
    /// The name of its schema.
    pub(super) kind: &'static str,
    /// The API schemas that are applied to it.
    pub(super) schemas: Vec<&'static str>,
    /// Its other fields.
    pub(super) metadata: Metadata,
    /// Its properties; their names differ.
    pub(super) properties: Vec<Property>,
    /// The prims below; their names differ.
    pub(super) children: Vec<Prim>,
}

impl Prim {
    /// A prim of the schema `kind`.
    pub(super) fn new(kind: &'static str, name: &str) -> Self {
        Self { name: name.into(), kind, ..Self::default() }
    }

    /// The same with the name that it has in the scene.
    pub(super) fn named(mut self, name: &str) -> Self {
        self.metadata.push(("displayName", Value::String(name.into())));
        self
    }

    /// The same with an API schema.
    pub(super) fn with_schema(mut self, schema: &'static str) -> Self {
        self.schemas.push(schema);
        self
    }

    /// Adds an attribute.
    pub(super) fn set(&mut self, kind: &'static str, name: &'static str, value: Value) {
        self.add(kind, name, Some(value), None);
    }

    /// Adds an attribute that is the same at all times.
    pub(super) fn set_uniform(&mut self, kind: &'static str, name: &'static str, value: Value) {
        self.add(kind, name, Some(value), None).is_uniform = true;
    }

    /// Adds an attribute of one value for each vertex.
    pub(super) fn set_by_vertex(&mut self, kind: &'static str, name: &'static str, value: Value) {
        let metadata = vec![("interpolation", Value::token("vertex"))];
        self.add(kind, name, Some(value), None).metadata = metadata;
    }

    /// Adds an attribute that takes its value from the attribute at the path `source`.
    pub(super) fn connect(&mut self, kind: &'static str, name: &'static str, source: String) {
        self.add(kind, name, None, Some(source));
    }

    /// Adds an attribute without a value.
    pub(super) fn declare(&mut self, kind: &'static str, name: &'static str) {
        self.add(kind, name, None, None);
    }

    /// Adds a relationship.
    pub(super) fn relate(&mut self, name: &'static str, target: String) {
        self.properties.push(Property::Relationship { name, target });
    }

    /// Moves and turns the prim by the one transform `matrix`.
    pub(super) fn place(&mut self, matrix: DMat4) {
        let operation = "xformOp:transform";
        self.set("matrix4d", operation, Value::Matrix(matrix));
        self.set_uniform("token[]", "xformOpOrder", Value::Tokens(vec![operation.into()]));
    }

    fn add(
        &mut self,
        kind: &'static str,
        name: &'static str,
        value: Option<Value>,
        source: Option<String>,
    ) -> &mut Attribute {
        let metadata = Metadata::new();
        let attribute = Attribute { kind, name, is_uniform: false, value, source, metadata };
        self.properties.push(Property::Attribute(attribute));
        match self.properties.last_mut() {
            Some(Property::Attribute(attribute)) => attribute,
            _ => unreachable!("it was added above"),
        }
    }
}

/// A stage of one layer: its fields, and its one root prim.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stage {
    /// The fields of the layer.
    pub(super) metadata: Metadata,
    /// The root prim, which is the default prim.
    pub(super) root: Prim,
}
