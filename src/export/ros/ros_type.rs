//! Types of ROS 2: name, definition and encoding.

use crate::export::ros::cdr::CdrWriter;

/// The line between two definitions of a schema.
const SEPARATOR_WIDTH: usize = 80;

/// A type of a field in a message.
pub trait RosType {
    /// Its name in a definition: `float64[]`, `geometry_msgs/Point`.
    fn name() -> String;
    /// Adds the definitions of this type and of those in it, each once.
    fn define(definitions: &mut Vec<Definition>);
    /// Encodes a value.
    fn encode(&self, out: &mut CdrWriter);
}

/// A message.
pub trait RosMessage: RosType {
    /// Its name: `geometry_msgs/msg/Point`.
    const FULL_NAME: &'static str;

    /// The encoded message.
    fn to_cdr(&self) -> Vec<u8> {
        let mut out = CdrWriter::default();
        self.encode(&mut out);
        out.finish()
    }

    /// The definitions of the message and of all messages in it, in the encoding `ros2msg`.
    fn schema() -> String {
        let mut definitions = Vec::new();
        Self::define(&mut definitions);
        let separator = "=".repeat(SEPARATOR_WIDTH);
        let mut parts = definitions.into_iter();
        let first = parts.next().map_or_else(String::new, |first| first.fields);
        parts.fold(first, |text, Definition { name, fields }| {
            format!("{text}{separator}\nMSG: {name}\n{fields}")
        })
    }
}

/// The definition of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// Its name: `geometry_msgs/Point`.
    pub name: String,
    /// One line a field.
    pub fields: String,
}

macro_rules! numbers {
    ($($number:ty = $name:literal),+) => {
        $(impl RosType for $number {
            fn name() -> String {
                $name.to_owned()
            }

            fn define(_: &mut Vec<Definition>) {}

            fn encode(&self, out: &mut CdrWriter) {
                out.number(self.to_le_bytes());
            }
        })+
    };
}

numbers!(u8 = "uint8", i32 = "int32", u32 = "uint32", f32 = "float32", f64 = "float64");

impl RosType for bool {
    fn name() -> String {
        "bool".to_owned()
    }

    fn define(_: &mut Vec<Definition>) {}

    fn encode(&self, out: &mut CdrWriter) {
        out.number([u8::from(*self)]);
    }
}

impl RosType for String {
    fn name() -> String {
        "string".to_owned()
    }

    fn define(_: &mut Vec<Definition>) {}

    fn encode(&self, out: &mut CdrWriter) {
        out.text(self);
    }
}

impl<T: RosType> RosType for Vec<T> {
    fn name() -> String {
        format!("{}[]", T::name())
    }

    fn define(definitions: &mut Vec<Definition>) {
        T::define(definitions);
    }

    fn encode(&self, out: &mut CdrWriter) {
        out.length(self.len());
        self.iter().for_each(|element| element.encode(out));
    }
}

/// Defines a message: `message!(Name = "package/Name" { field: type, ... })`. The order of the
/// fields is that of the encoding.
macro_rules! message {
    ($(#[$about:meta])* $message:ident = $package:literal / $name:literal {
        $($(#[$doc:meta])* $field:ident: $type:ty),* $(,)?
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $message {
            $($(#[$doc])* pub $field: $type),*
        }

        impl $crate::export::ros::ros_type::RosType for $message {
            fn name() -> String {
                concat!($package, "/", $name).to_owned()
            }

            fn define(definitions: &mut Vec<$crate::export::ros::ros_type::Definition>) {
                let name = Self::name();
                if definitions.iter().any(|known| known.name == name) {
                    return;
                }
                let mut fields = String::new();
                $(
                    let type_name =
                        <$type as $crate::export::ros::ros_type::RosType>::name();
                    let field = stringify!($field).trim_start_matches("r#");
                    fields.push_str(&format!("{type_name} {field}\n"));
                )*
                definitions.push($crate::export::ros::ros_type::Definition { name, fields });
                $(<$type as $crate::export::ros::ros_type::RosType>::define(definitions);)*
            }

            fn encode(&self, out: &mut $crate::export::ros::cdr::CdrWriter) {
                $($crate::export::ros::ros_type::RosType::encode(&self.$field, out);)*
            }
        }

        impl $crate::export::ros::ros_type::RosMessage for $message {
            const FULL_NAME: &'static str = concat!($package, "/msg/", $name);
        }
    };
}
pub(crate) use message;
