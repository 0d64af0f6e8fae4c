//! The material part of the JSON documents: its reader, and the models' names in them.

use crate::models::material_parameters::{ChannelError, MaterialParameters};
use crate::models::registry::{ModelName, UnknownModel};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use std::borrow::Cow;

/// Version of the layout of fits, summaries and materials; it rises when a program that reads the present one could be misled.
pub const SCHEMA_VERSION: u32 = 1;

/// Errors of reading the material of a document; each message is one line and names the member by its path.
#[derive(Debug, thiserror::Error)]
pub enum MaterialError {
    /// The text is not JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A later program wrote it.
    #[error("has schema version {found}; this program reads {SCHEMA_VERSION}")]
    Version {
        /// The document's version.
        found: u32,
    },
    /// A member is missing or of another type.
    #[error("{path}: {problem}")]
    Member {
        /// Its path, as `channels[1].parameters.alpha`; that of its owner if it is missing; `document` for the whole.
        path: String,
        /// The fault.
        problem: String,
    },
    /// A parameter lies where the model cannot be evaluated.
    #[error("channels[{}].parameters.{}", .0.channel, .0.error)]
    Parameter(ChannelError),
}

impl MaterialParameters {
    /// Reads the material part of a document; the result of a fit contains it, a file with nothing else is one too:
    ///
    /// `{"model": "sgd", "channels": [{"parameters": {"rho_d": .., "rho_s": .., "alpha": .., "p": .., "f0": .., "f1": ..}}, .., ..]}`
    ///
    /// Without `model` it is "sgd". Members that it does not know are skipped.
    ///
    /// # Errors
    /// [`MaterialError`] for the first invalid member.
    pub fn read(json: &[u8]) -> Result<Self, MaterialError> {
        let document: Value = serde_json::from_slice(json)?;
        let document = Member { path: String::new(), value: &document };
        let schema_version: Option<u32> = document.optional("schema_version")?;
        if let Some(found) = schema_version
            && found > SCHEMA_VERSION
        {
            return Err(MaterialError::Version { found });
        }
        let model = match document.optional::<String>("model")? {
            None => ModelName::default(),
            Some(name) => name
                .parse()
                .map_err(|error: UnknownModel| document.child("model", &Value::Null).error(error.to_string()))?,
        };
        let channels = document.required("channels")?;
        let elements = channels.value.as_array().ok_or_else(|| channels.error("expected an array of three".into()))?;
        let elements: Vec<Vec<f64>> = elements
            .iter()
            .enumerate()
            .map(|(n, value)| read_channel(model, &Member { path: format!("channels[{n}]"), value }))
            .collect::<Result<_, _>>()?;
        let count = elements.len();
        let channels =
            elements.try_into().map_err(|_| channels.error(format!("expected an array of three, has {count}")))?;
        Self::new(model, channels).map_err(MaterialError::Parameter)
    }
}

/// The values of one channel.
fn read_channel(model: ModelName, channel: &Member<'_>) -> Result<Vec<f64>, MaterialError> {
    let _: Option<String> = channel.optional("name")?;
    let parameters = channel.required("parameters")?;
    let known = model.model().parameters().iter();
    known.map(|parameter| parameters.required(parameter.name)?.decode::<f64>()).collect()
}

impl Serialize for ModelName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for ModelName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Cow::<str>::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

impl JsonSchema for ModelName {
    fn schema_name() -> Cow<'static, str> {
        "ModelName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = Self::ALL.iter().map(|model| model.as_str()).collect();
        json_schema!({ "type": "string", "description": "The name of a model.", "enum": names })
    }
}

/// A value with its path, empty for the whole document.
struct Member<'v> {
    path: String,
    value: &'v Value,
}

impl<'v> Member<'v> {
    fn error(&self, problem: String) -> MaterialError {
        let path = if self.path.is_empty() { "document" } else { &self.path };
        MaterialError::Member { path: path.to_owned(), problem }
    }

    fn child(&self, name: &str, value: &'v Value) -> Self {
        let path = if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) };
        Self { path, value }
    }

    fn decode<T: DeserializeOwned>(&self) -> Result<T, MaterialError> {
        T::deserialize(self.value).map_err(|error| self.error(error.to_string()))
    }

    fn find(&self, name: &str) -> Result<Option<Self>, MaterialError> {
        let members = self.value.as_object().ok_or_else(|| self.error("expected an object".to_owned()))?;
        Ok(members.get(name).map(|value| self.child(name, value)))
    }

    fn required(&self, name: &str) -> Result<Self, MaterialError> {
        self.find(name)?.ok_or_else(|| self.error(format!("missing field `{name}`")))
    }

    /// A member that may be absent or null.
    fn optional<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, MaterialError> {
        Ok(self.find(name)?.map(|member| member.decode()).transpose()?.flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn written() -> Value {
        let channels = [0.0625, 0.125, 0.25].map(|rho_d| {
            json!({"parameters": {"rho_d": rho_d, "rho_s": 0.3, "alpha": 0.01, "p": 0.6, "f0": 0.3, "f1": 0.1}})
        });
        json!({ "channels": channels })
    }

    /// The message about a document of which one value, named by its JSON pointer, is replaced.
    fn refused(pointer: &str, value: Value) -> String {
        let mut document = written();
        *document.pointer_mut(pointer).unwrap() = value;
        let message = MaterialParameters::read(document.to_string().as_bytes()).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    }

    #[test]
    fn every_model_is_read_by_the_names_of_its_parameters() {
        for &model in ModelName::ALL {
            let value = |n: usize| 0.0625 * (n + 1) as f64;
            let parameters = model.model().parameters();
            // last first: the order in the file does not matter
            let channel: serde_json::Map<String, Value> =
                parameters.iter().enumerate().rev().map(|(n, p)| (p.name.to_owned(), value(n).into())).collect();
            let channels = [0, 1, 2].map(|_| json!({ "parameters": channel }));
            let document = json!({ "model": model, "channels": channels });
            let read = MaterialParameters::read(document.to_string().as_bytes()).unwrap();
            assert_eq!(read.model(), model);
            assert_eq!(read.channel(2), (0..parameters.len()).map(value).collect::<Vec<_>>());
        }
    }

    #[test]
    fn other_members_are_skipped_and_optional_ones_read() {
        let plain = MaterialParameters::read(written().to_string().as_bytes()).unwrap();
        let mut document = written();
        document["slices"] = json!({"theta_h": [0.0]});
        document["schema_version"] = 1.into();
        document["model"] = "sgd".into();
        document["channels"][2]["name"] = "B".into();
        assert_eq!(MaterialParameters::read(document.to_string().as_bytes()).unwrap(), plain);
        assert_eq!((plain.model().as_str(), plain.get(1, "rho_d")), ("sgd", Some(0.125)));
        assert_eq!(plain.get(1, "nothing"), None);
    }

    #[test]
    fn each_mistake_is_named_by_its_path() {
        let cases = [
            ("", Value::Null, "document: expected an object"),
            ("/channels", json!({}), "channels: expected an array of three"),
            ("/channels", json!([{}]), "channels[0]: missing field `parameters`"),
            ("/channels", json!([]), "channels: expected an array of three, has 0"),
            ("/channels/1", 3.into(), "channels[1]: expected an object"),
            ("/channels/1/parameters", Value::Null, "channels[1].parameters: expected an object"),
            ("/channels/2/parameters", json!({"rho_d": 0}), "channels[2].parameters: missing field `rho_s`"),
            (
                "/channels/0/parameters/p",
                "x".into(),
                "channels[0].parameters.p: invalid type: string \"x\", expected f64",
            ),
            (
                "/channels/0/parameters/p",
                20.into(),
                "channels[0].parameters.p = 20 is outside of the model's domain: between -90 and 20",
            ),
        ];
        for (pointer, value, message) in cases {
            assert_eq!(refused(pointer, value), message);
        }
        let negative = refused("/channels/1/parameters/alpha", (-1).into());
        assert!(
            negative.starts_with("channels[1].parameters.alpha = -1 is outside of the model's domain"),
            "{negative}"
        );
    }

    #[test]
    fn other_versions_models_and_texts_are_refused() {
        let with = |name: &str, value: Value| {
            let mut document = written();
            document[name] = value;
            MaterialParameters::read(document.to_string().as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(with("schema_version", 2.into()), "has schema version 2; this program reads 1");
        assert!(with("schema_version", "1".into()).starts_with("schema_version: invalid type"));
        assert_eq!(with("model", "phong".into()), "model: expected \"sgd\" or \"ggx\", found \"phong\"");
        assert!(matches!(MaterialParameters::read(b"{"), Err(MaterialError::Json(_))));
        // a number that no double holds
        let overflow = written().to_string().replace("0.0625", "1e999");
        assert!(matches!(MaterialParameters::read(overflow.as_bytes()), Err(MaterialError::Json(_))));
    }
}
