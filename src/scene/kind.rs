//! Choices in files: `{ kind = "…", … }`, or the name of the kind alone where none of its keys is required.
//!
//! An enum whose variants are the kinds derives `Deserialize` with `#[serde(remote = "Self")]` and is then named in
//! [`by_kind!`]; [`registry!`] declares one whose kinds have a file each. Serde's own tag buffers the table and so loses the line
//! of every mistake in it; here the table is read in place, which needs `kind` to be its first key: [`first`] moves it there.

use super::error::hint;
use serde::de::value::{MapAccessDeserializer, MapDeserializer};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error, IgnoredAny, IntoDeserializer, MapAccess,
    VariantAccess, Visitor,
};
use std::convert::Infallible;
use std::fmt;
use std::marker::PhantomData;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Lets enums be chosen by `kind` in files.
macro_rules! by_kind {
    ($($name:ty),* $(,)?) => {$(
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                <$name>::deserialize($crate::scene::kind::ByKind(deserializer))
            }
        }
    )*};
}
pub(crate) use by_kind;

/// Declares a registry: an enum with a line for each kind, which names its specification and the name of the kind in files.
macro_rules! registry {
    ($part:ident; $(#[$attribute:meta])* pub enum $registry:ident { $($kind:ident($spec:ident) = $name:literal,)* }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
        #[serde(remote = "Self")]
        #[schemars(!remote, tag = "kind", transform = crate::schema::kind_alone)]
        pub enum $registry {
            $(
                #[allow(missing_docs)]
                #[serde(rename = $name)]
                $kind($spec),
            )*
        }

        $crate::scene::kind::by_kind!($registry);

        impl $registry {
            /// Every kind, as in files.
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

/// Moves `kind` to the front of every table below `table`.
pub(super) fn first(table: &mut DeTable) {
    if let Some((key, kind)) = table.remove_entry("kind") {
        let rest = std::mem::take(table);
        table.insert(key, kind);
        table.extend(rest);
    }
    table.iter_mut().for_each(|(_, value)| below(value));
}

fn below(value: &mut Spanned<DeValue>) {
    match value.get_mut() {
        DeValue::Array(list) => list.iter_mut().for_each(below),
        DeValue::Table(table) => first(table),
        _ => {}
    }
}

/// Reads an enum from a table with a `kind`, or from the name of a kind.
pub(crate) struct ByKind<D>(pub(crate) D);

impl<'de, D: Deserializer<'de>> Deserializer<'de> for ByKind<D> {
    type Error = D::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        kinds: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(Choice { kinds, visitor })
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

struct Choice<V> {
    kinds: &'static [&'static str],
    visitor: V,
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Choice<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a table with a `kind`, which is one of {}", self.kinds.join(", "))
    }

    fn visit_str<E: Error>(self, kind: &str) -> Result<V::Value, E> {
        let kind = Kind(self.kinds).visit_str(kind)?;
        let none: MapDeserializer<'de, std::iter::Empty<(&str, NoValue<E>)>, E> =
            MapDeserializer::new(std::iter::empty());
        self.visitor.visit_enum(Chosen { kind, keys: none })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<V::Value, A::Error> {
        if map.next_key::<String>()?.is_none_or(|key| key != "kind") {
            let missing = format!("it has no `kind`; add kind = \"…\" with one of {}", self.kinds.join(", "));
            return Err(A::Error::custom(missing));
        }
        let kind = map.next_value_seed(Kind(self.kinds))?;
        self.visitor.visit_enum(Chosen { kind, keys: map })
    }
}

/// The value of a key of a table without keys. With another type the compiler would make one more reader of every type below the kinds.
struct NoValue<E>(Infallible, PhantomData<E>);

impl<'de, E: Error> Deserializer<'de> for NoValue<E> {
    type Error = E;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, E> {
        match self.0 {}
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<E: Error> IntoDeserializer<'_, E> for NoValue<E> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
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

/// A kind and the keys in its table.
struct Chosen<A> {
    kind: &'static str,
    keys: A,
}

impl<'de, A: MapAccess<'de>> EnumAccess<'de> for Chosen<A> {
    type Error = A::Error;
    type Variant = Keys<A>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Keys<A>), A::Error> {
        let kind: serde::de::value::StrDeserializer<A::Error> = self.kind.into_deserializer();
        Ok((seed.deserialize(kind)?, Keys(self.keys)))
    }
}

/// The keys of a kind, without `kind`.
struct Keys<A>(A);

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
