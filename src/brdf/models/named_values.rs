//! Values under the names of a model's parameters, as documents hold them.

use crate::models::material_parameters::MaterialParameters;
use crate::models::parameter::Parameter;
use crate::models::registry::ModelName;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Values with names, in the order in which they are written.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedValues<T>(Vec<(Cow<'static, str>, T)>);

impl<T: Copy> NamedValues<T> {
    /// The value of this name.
    pub fn get(&self, name: &str) -> Option<T> {
        self.iter().find_map(|(other, value)| (other == name).then_some(value))
    }

    /// Names and values in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&str, T)> + '_ {
        self.0.iter().map(|(name, value)| (name.as_ref(), *value))
    }
}

impl<T> FromIterator<(&'static str, T)> for NamedValues<T> {
    fn from_iter<I: IntoIterator<Item = (&'static str, T)>>(values: I) -> Self {
        Self(values.into_iter().map(|(name, value)| (Cow::Borrowed(name), value)).collect())
    }
}

impl MaterialParameters {
    /// The values of channel R, G or B (0, 1, 2) with their names.
    pub fn named(&self, channel: usize) -> NamedValues<f64> {
        let names = self.model().model().parameters().iter().map(|parameter| parameter.name);
        names.zip(self.channel(channel).iter().copied()).collect()
    }
}

impl<T: Serialize> Serialize for NamedValues<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for NamedValues<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(InOrder(PhantomData))
    }
}

struct InOrder<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for InOrder<T> {
    type Value = NamedValues<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of values")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<NamedValues<T>, A::Error> {
        let mut values = Vec::with_capacity(map.size_hint().unwrap_or(0));
        while let Some((name, value)) = map.next_entry::<String, T>()? {
            values.push((Cow::Owned(name), value));
        }
        Ok(NamedValues(values))
    }
}

/// The parameters of one channel: one kind of object per model.
impl JsonSchema for NamedValues<f64> {
    fn schema_name() -> Cow<'static, str> {
        "Parameters".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let of = |model: &ModelName| {
            let member = |parameter: &Parameter| {
                let schema = json!({ "description": parameter.meaning, "type": "number", "format": "double" });
                (parameter.name.to_owned(), schema)
            };
            let parameters = model.model().parameters();
            let properties: Map<String, Value> = parameters.iter().map(member).collect();
            let required: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
            let description = format!("Free parameters of the model {:?}.", model.as_str());
            json!({ "description": description, "type": "object", "properties": properties, "required": required })
        };
        let models: Vec<Value> = ModelName::ALL.iter().map(of).collect();
        json_schema!({ "description": "The free parameters of one channel, by the model.", "anyOf": models })
    }
}

/// Standard errors: members that depend on the model, each a number or null.
impl JsonSchema for NamedValues<Option<f64>> {
    fn schema_name() -> Cow<'static, str> {
        "StandardErrors".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "additionalProperties": { "type": ["number", "null"], "format": "double" }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_values_survive() {
        let values: NamedValues<f64> = [("rho_d", 0.1), ("alpha", 1e-7), ("f0", -2.5)].into_iter().collect();
        let text = serde_json::to_string(&values).unwrap();
        assert_eq!(text, r#"{"rho_d":0.1,"alpha":1e-7,"f0":-2.5}"#);
        let back: NamedValues<f64> = serde_json::from_str(&text).unwrap();
        assert_eq!((back.get("alpha"), back.get("p")), (Some(1e-7), None));
        assert_eq!(serde_json::to_string(&back).unwrap(), text);
        assert!(serde_json::from_str::<NamedValues<f64>>("[1]").is_err());
    }
}
