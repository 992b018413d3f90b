//! Decodes CDR by the definitions of a schema in `ros2msg`, and by nothing else.

use std::collections::BTreeMap;

use crate::mcap_reader::Bytes;

/// A decoded value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Number(f64),
    Text(String),
    List(Vec<Value>),
    Message(BTreeMap<String, Value>),
}

impl Value {
    pub fn number(&self) -> f64 {
        let Value::Number(number) = self else { panic!("{self:?} is no number") };
        *number
    }

    pub fn text(&self) -> &str {
        let Value::Text(text) = self else { panic!("{self:?} is no text") };
        text
    }

    pub fn list(&self) -> &[Value] {
        let Value::List(list) = self else { panic!("{self:?} is no list") };
        list
    }

    pub fn numbers(&self) -> Vec<f64> {
        self.list().iter().map(Value::number).collect()
    }

    pub fn field(&self, name: &str) -> &Value {
        let Value::Message(fields) = self else { panic!("{self:?} is no message") };
        &fields[name]
    }
}

/// The fields of each message of a schema: type and name.
pub struct Schema {
    definitions: BTreeMap<String, Vec<(String, String)>>,
}

impl Schema {
    /// Reads the definitions. The first one has no name.
    pub fn new(text: &str) -> Self {
        let separator = format!("{}\n", "=".repeat(80));
        let definitions = text.split(&separator).map(|part| {
            let (name, fields) = match part.strip_prefix("MSG: ") {
                Some(rest) => rest.split_once('\n').unwrap(),
                None => ("", part),
            };
            let field = |line: &str| {
                let (type_name, name) = line.split_once(' ').unwrap();
                (type_name.to_owned(), name.to_owned())
            };
            (name.to_owned(), fields.lines().map(field).collect())
        });
        Self { definitions: definitions.collect() }
    }

    /// Decodes a message completely.
    pub fn decode(&self, message: &[u8]) -> BTreeMap<String, Value> {
        assert_eq!(message[..4], [0, 1, 0, 0]);
        let body = &message[4..];
        let mut reader = Reader { schema: self, body, rest: Bytes(body) };
        let fields = reader.message("");
        assert!(reader.rest.0.is_empty(), "{} bytes are left", reader.rest.0.len());
        fields
    }
}

struct Reader<'a> {
    schema: &'a Schema,
    body: &'a [u8],
    rest: Bytes<'a>,
}

impl Reader<'_> {
    fn message(&mut self, name: &str) -> BTreeMap<String, Value> {
        let fields = &self.schema.definitions[name];
        fields.iter().map(|(type_name, field)| (field.clone(), self.value(type_name))).collect()
    }

    fn value(&mut self, type_name: &str) -> Value {
        if let Some(element) = type_name.strip_suffix("[]") {
            let count = u32::from_le_bytes(self.aligned());
            return Value::List((0..count).map(|_| self.value(element)).collect());
        }
        match type_name {
            "bool" | "uint8" => Value::Number(f64::from(self.aligned::<1>()[0])),
            "int32" => Value::Number(f64::from(i32::from_le_bytes(self.aligned()))),
            "uint32" => Value::Number(f64::from(u32::from_le_bytes(self.aligned()))),
            "float32" => Value::Number(f64::from(f32::from_le_bytes(self.aligned()))),
            "float64" => Value::Number(f64::from_le_bytes(self.aligned())),
            "string" => {
                let length = u32::from_le_bytes(self.aligned()) as usize;
                let text = self.rest.take(length);
                assert_eq!(text.last(), Some(&0));
                Value::Text(String::from_utf8(text[..length - 1].to_vec()).unwrap())
            }
            message => Value::Message(self.message(message)),
        }
    }

    fn aligned<const SIZE: usize>(&mut self) -> [u8; SIZE] {
        let used = self.body.len() - self.rest.0.len();
        let padding = self.rest.take(used.next_multiple_of(SIZE) - used);
        assert!(padding.iter().all(|byte| *byte == 0));
        self.rest.take(SIZE).try_into().unwrap()
    }
}
