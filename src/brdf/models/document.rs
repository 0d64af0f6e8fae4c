//! The material part of the JSON documents, and its reader.

use crate::models::sgd::{ParameterError, Sgd, SgdParameters};
use crate::models::sgd_material::SgdMaterial;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a document has to say of a material: a result of the fit contains it, a file with nothing else is one too.
///
/// `{"channels": [{"parameters": {"rho_d": .., "rho_s": .., "alpha": .., "p": .., "f0": .., "f1": ..}}, .., ..]}`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "brdfit material")]
pub struct MaterialDocument {
    /// Version of the layout; a file without one is taken for the present one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema_version: Option<u32>,
    /// The model's name: "sgd", also where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// R, G and B.
    pub channels: [MaterialChannel; 3],
}

/// One channel of a [`MaterialDocument`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MaterialChannel {
    /// R, G or B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The six free parameters of the model.
    pub parameters: SgdParameters,
}

/// Why a document is not that of a material; each message is one line and names the member by its path.
#[derive(Debug, thiserror::Error)]
pub enum MaterialError {
    /// The text is not JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A later program wrote it.
    #[error("has schema version {found}, this program knows {}", MaterialDocument::SCHEMA_VERSION)]
    Version {
        /// The document's version.
        found: u32,
    },
    /// A member is missing or of another type.
    #[error("{path}: {problem}")]
    Member {
        /// Its path, as `channels[1].parameters.alpha`; that of its owner if it is missing; `document` for the whole.
        path: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A parameter lies where the model cannot be evaluated.
    #[error("channels[{channel}].parameters.{error}")]
    Parameter {
        /// 0, 1, 2 for R, G, B.
        channel: usize,
        /// Which parameter, with its domain.
        error: ParameterError,
    },
}

impl MaterialDocument {
    /// The latest layout that this program knows.
    pub const SCHEMA_VERSION: u32 = 1;
    /// The one name that [`Self::model`] may be.
    const MODEL: &str = "sgd";

    /// Reads a document and checks its parameters; members that it does not know are skipped.
    ///
    /// # Errors
    /// [`MaterialError`] for the first thing that is wrong.
    pub fn read(json: &[u8]) -> Result<Self, MaterialError> {
        let document: Value = serde_json::from_slice(json)?;
        let document = Member { path: String::new(), value: &document };
        let schema_version = document.optional("schema_version")?;
        if let Some(found) = schema_version
            && found > Self::SCHEMA_VERSION
        {
            return Err(MaterialError::Version { found });
        }
        let model: Option<String> = document.optional("model")?;
        if let Some(model) = &model
            && model != Self::MODEL
        {
            let problem = format!("expected {:?}, is {model:?}", Self::MODEL);
            return Err(document.required("model")?.error(problem));
        }
        let channels = document.required("channels")?;
        let elements = channels.value.as_array().ok_or_else(|| channels.error("expected an array of three".into()))?;
        let elements: Vec<MaterialChannel> = elements
            .iter()
            .enumerate()
            .map(|(n, value)| MaterialChannel::read(&Member { path: format!("channels[{n}]"), value }))
            .collect::<Result<_, _>>()?;
        let count = elements.len();
        let channels =
            elements.try_into().map_err(|_| channels.error(format!("expected an array of three, has {count}")))?;
        let read = Self { schema_version, model, channels };
        read.check()?;
        Ok(read)
    }

    /// Parameters of R, G and B.
    pub fn parameters(&self) -> [SgdParameters; 3] {
        self.channels.each_ref().map(|channel| channel.parameters)
    }

    /// The material, ready to be evaluated and sampled.
    ///
    /// # Errors
    /// [`MaterialError::Parameter`]; never after [`Self::read`].
    pub fn material(&self) -> Result<SgdMaterial, MaterialError> {
        self.check()?;
        Ok(SgdMaterial::new(self.parameters()).expect("checked above"))
    }

    fn check(&self) -> Result<(), MaterialError> {
        self.parameters().into_iter().enumerate().try_for_each(|(channel, parameters)| {
            Sgd::new(parameters).map(drop).map_err(|error| MaterialError::Parameter { channel, error })
        })
    }
}

impl From<[SgdParameters; 3]> for MaterialDocument {
    /// A document without anything that is optional.
    fn from(parameters: [SgdParameters; 3]) -> Self {
        let channels = parameters.map(|parameters| MaterialChannel { name: None, parameters });
        Self { schema_version: None, model: None, channels }
    }
}

impl MaterialChannel {
    fn read(channel: &Member<'_>) -> Result<Self, MaterialError> {
        let name = channel.optional("name")?;
        let parameters = channel.required("parameters")?;
        let number = |name| parameters.required(name)?.decode::<f64>();
        let parameters = SgdParameters {
            rho_d: number("rho_d")?,
            rho_s: number("rho_s")?,
            alpha: number("alpha")?,
            p: number("p")?,
            f0: number("f0")?,
            f1: number("f1")?,
        };
        Ok(Self { name, parameters })
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

    const CHANNEL: SgdParameters = SgdParameters { rho_d: 0.05, rho_s: 0.3, alpha: 0.01, p: 0.6, f0: 0.3, f1: 0.1 };

    fn written() -> Value {
        let channels = [0.0625, 0.125, 0.25].map(|rho_d| SgdParameters { rho_d, ..CHANNEL });
        serde_json::to_value(MaterialDocument::from(channels)).unwrap()
    }

    /// The message about a document of which one value, named by its JSON pointer, is replaced.
    fn refused(pointer: &str, value: Value) -> String {
        let mut document = written();
        *document.pointer_mut(pointer).unwrap() = value;
        let message = MaterialDocument::read(document.to_string().as_bytes()).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    }

    #[test]
    fn what_is_written_is_read() {
        let text = written().to_string();
        let read = MaterialDocument::read(text.as_bytes()).unwrap();
        assert_eq!(read.parameters().map(|channel| channel.rho_d), [0.0625, 0.125, 0.25]);
        assert_eq!(read, serde_json::from_str(&text).unwrap());
        assert_eq!(read.material().unwrap().channel(1).parameters(), &read.parameters()[1]);
    }

    #[test]
    fn other_members_are_skipped_and_optional_ones_kept() {
        let mut document = written();
        document["slices"] = serde_json::json!({"theta_h": [0.0]});
        document["schema_version"] = 1.into();
        document["model"] = "sgd".into();
        document["channels"][2]["name"] = "B".into();
        let read = MaterialDocument::read(document.to_string().as_bytes()).unwrap();
        assert_eq!((read.schema_version, read.model.as_deref()), (Some(1), Some("sgd")));
        assert_eq!(read.channels[2].name.as_deref(), Some("B"));
    }

    #[test]
    fn each_mistake_is_named_by_its_path() {
        let cases = [
            ("", Value::Null, "document: expected an object"),
            ("/channels", serde_json::json!({}), "channels: expected an array of three"),
            ("/channels", serde_json::json!([{}]), "channels[0]: missing field `parameters`"),
            ("/channels", serde_json::json!([]), "channels: expected an array of three, has 0"),
            ("/channels/1", 3.into(), "channels[1]: expected an object"),
            ("/channels/1/parameters", Value::Null, "channels[1].parameters: expected an object"),
            (
                "/channels/2/parameters",
                serde_json::json!({"rho_d": 0}),
                "channels[2].parameters: missing field `rho_s`",
            ),
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
            MaterialDocument::read(document.to_string().as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(with("schema_version", 2.into()), "has schema version 2, this program knows 1");
        assert!(with("schema_version", "1".into()).starts_with("schema_version: invalid type"));
        assert_eq!(with("model", "ggx".into()), "model: expected \"sgd\", is \"ggx\"");
        assert!(matches!(MaterialDocument::read(b"{"), Err(MaterialError::Json(_))));
        // a number that no double holds
        let overflow = written().to_string().replace("0.0625", "1e999");
        assert!(matches!(MaterialDocument::read(overflow.as_bytes()), Err(MaterialError::Json(_))));
    }

    #[test]
    fn by_hand_a_document_can_be_wrong() {
        let mut document = MaterialDocument::from([CHANNEL; 3]);
        document.channels[2].parameters.alpha = 0.0;
        assert!(matches!(document.material(), Err(MaterialError::Parameter { channel: 2, .. })));
    }
}
