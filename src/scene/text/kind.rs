//! Choices in files: `{ kind = "…", … }`, or only the name of the kind if none of its keys is required.
//!
//! An enum whose variants are the kinds derives `Deserialize` without a tag; [`registry!`] declares one whose kinds have a file each. Serde's own tag buffers
//! the table, which loses the line of every mistake in it; the [reader](super::reader) reads the table in place, with `kind` before its other keys.

use crate::scene::error::hint;
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error, Expected, IgnoredAny, MapAccess, VariantAccess,
    Visitor,
};
use std::fmt;

/// Declares a registry: an enum with a line for each kind, which gives its specification and its name in files.
macro_rules! registry {
    ($part:ident; $(#[$attribute:meta])* pub enum $registry:ident { $($kind:ident($spec:ident) = $name:literal,)* }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
        #[schemars(tag = "kind", transform = crate::schema::kind_alone)]
        pub enum $registry {
            $(
                #[allow(missing_docs)]
                #[serde(rename = $name)]
                $kind($spec),
            )*
        }

        impl $registry {
            /// Names of all kinds, as in files.
            pub const KINDS: &[&str] = &[$($name),*];

            /// Name of the kind, as in files.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $name,)*
                }
            }

            /// The specification of the kind.
            pub(in crate::scene) fn part(&self) -> &dyn $part {
                match self {
                    $(Self::$kind(part) => part,)*
                }
            }
        }

        $(
            impl From<$spec> for $registry {
                fn from(part: $spec) -> Self {
                    Self::$kind(part)
                }
            }
        )*
    };
}
pub(crate) use registry;

/// Reads an enum from the keys of a table, the first of which is `kind`.
pub(in crate::scene) struct ByKind<A>(pub(in crate::scene) A);

impl<'de, A: MapAccess<'de>> Deserializer<'de> for ByKind<A> {
    type Error = A::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_map(self.0)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        kinds: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        visitor.visit_enum(Chosen::of(self.0, kinds)?)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

/// The serde expectation of a name or table of one of these kinds.
pub(in crate::scene) struct ExpectedKind(pub(super) &'static [&'static str]);

impl Expected for ExpectedKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a name, or a table with a `kind`, which is one of {}", self.0.join(", "))
    }
}

/// A name that must be one of these.
struct Kind(&'static [&'static str]);

impl<'de> DeserializeSeed<'de> for Kind {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'static str, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl Visitor<'_> for Kind {
    type Value = &'static str;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the name of a kind in quotes")
    }

    fn visit_str<E: Error>(self, kind: &str) -> Result<&'static str, E> {
        let known = self.0.iter().copied().find(|k| *k == kind);
        known.ok_or_else(|| E::custom(format!("unknown kind `{kind}`; {}", hint(kind, self.0))))
    }
}

/// A kind and the other keys of its table.
pub(super) struct Chosen<A> {
    kind: &'static str,
    keys: A,
}

impl<'de, A: MapAccess<'de>> Chosen<A> {
    /// The kind that these keys name before all other keys.
    pub(in crate::scene) fn of(mut keys: A, kinds: &'static [&'static str]) -> Result<Self, A::Error> {
        if keys.next_key::<String>()?.is_none_or(|key| key != "kind") {
            let missing = format!("it has no `kind`; add kind = \"…\" with one of {}", kinds.join(", "));
            return Err(A::Error::custom(missing));
        }
        Ok(Self { kind: keys.next_value_seed(Kind(kinds))?, keys })
    }

    /// The kind of this name, without keys.
    pub(in crate::scene) fn alone(name: &str, kinds: &'static [&'static str], none: A) -> Result<Self, A::Error> {
        match kinds.iter().find(|kind| **kind == name) {
            Some(kind) => Ok(Self { kind, keys: none }),
            None => Err(A::Error::custom(format!("unknown name `{name}`; {}", hint(name, kinds)))),
        }
    }
}

impl<'de, A: MapAccess<'de>> EnumAccess<'de> for Chosen<A> {
    type Error = A::Error;
    type Variant = Keys<A>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Keys<A>), A::Error> {
        let kind: StrDeserializer<A::Error> = StrDeserializer::new(self.kind);
        Ok((seed.deserialize(kind)?, Keys(self.keys)))
    }
}

/// The keys of a kind, without `kind`.
pub(in crate::scene) struct Keys<A>(A);

impl<'de, A: MapAccess<'de>> VariantAccess<'de> for Keys<A> {
    type Error = A::Error;

    fn unit_variant(mut self) -> Result<(), A::Error> {
        match self.0.next_key_seed(NoKey)? {
            None => Ok(()),
            Some(()) => self.0.next_value::<IgnoredAny>().map(|_| ()),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, A::Error> {
        seed.deserialize(MapAccessDeserializer::new(self.0))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_map(self.0)
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_map(self.0)
    }
}

/// Refuses every key.
struct NoKey;

impl<'de> DeserializeSeed<'de> for NoKey {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        let key = String::deserialize(deserializer)?;
        Err(D::Error::custom(format!("unknown key `{key}`; it takes no key but `kind`")))
    }
}
