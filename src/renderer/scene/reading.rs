//! Reading and validation of scene documents.

use serde::de::IgnoredAny;

use crate::scene::check::check;
use crate::scene::document::SceneDocument;
use crate::scene::error::SceneError;

impl SceneDocument {
    /// Reads and checks a document: every number, every name of a material. Files are not touched.
    ///
    /// # Errors
    /// [`SceneError::Document`] with the path to the first member that is wrong.
    pub fn read(json: &[u8]) -> Result<Self, SceneError> {
        let mut reader = serde_json::Deserializer::from_slice(json);
        let document: Self = serde_path_to_error::deserialize(&mut reader)
            .map_err(|error| refuse(json, &error.path().to_string(), error.inner()))?;
        reader.end().map_err(|error| not_json("", &error))?;
        check(&document)?;
        Ok(document)
    }
}

/// An error of the member at `path`.
fn refuse(json: &[u8], path: &str, error: &serde_json::Error) -> SceneError {
    let place = |error: &serde_json::Error| (error.line(), error.column());
    if error.is_data() {
        // a list is read as the members of the scene in their order
        let path = if path.starts_with('[') { "." } else { path };
        return SceneError::document(path, in_words(error));
    }
    match serde_json::from_slice::<IgnoredAny>(json) {
        Err(syntax) => {
            let known = place(&syntax) == place(error);
            not_json(if known { path.trim_end_matches(['.', '?']) } else { "" }, &syntax)
        }
        Ok(IgnoredAny) => SceneError::document(path, in_words(error)),
    }
}

fn not_json(path: &str, error: &serde_json::Error) -> SceneError {
    SceneError::document(path, format!("is not valid JSON: {error}"))
}

/// The reader's message without the names of this program's types.
fn in_words(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    let what = message.strip_suffix(&place).unwrap_or(&message);
    if what == "expected value" {
        // valid JSON, but no name of a choice, or an object with none or several of them
        return format!("expected exactly one of the choices that the schema lists,{place}");
    }
    if what.starts_with("invalid type: unit variant, expected ") {
        return format!("expected an object with that name as its one member,{place}");
    }
    let Some((found, wanted)) = what.split_once(", expected ") else { return message };
    let wanted = match wanted {
        "f64" => "a number",
        "usize" | "u32" => "a whole number from 0",
        _ if wanted.starts_with("struct ") => "an object",
        _ => wanted,
    };
    format!("{found}, expected {wanted}{place}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(json: &str) -> String {
        SceneDocument::read(json.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn what_is_not_json_says_so() {
        for (json, start) in [
            (
                "{ \"camera\": { \"eye\": [0, 0,, 1] } }",
                "camera.eye[2]: is not valid JSON: expected value at line 1 column 28",
            ),
            ("{ \"camera\": { \"ey", "camera: is not valid JSON: EOF while parsing a string at line 1 column 17"),
            ("hello", "is not valid JSON: expected value at line 1 column 1"),
            ("", "is not valid JSON: EOF while parsing a value"),
            // the first mistake is that of the light, but there is a worse one behind it
            ("{ \"light\": {}, }", "is not valid JSON: key must be a string at line 1 column 16"),
        ] {
            let message = message(json);
            assert!(message.starts_with(start), "{message}");
        }
    }

    #[test]
    fn wrong_types_are_said_in_words() {
        let camera = |member: &str| format!("{{ \"camera\": {{ {member} }} }}");
        for (json, start) in [
            ("3".to_owned(), "invalid type: integer `3`, expected an object at line 1 column 1"),
            ("[1]".to_owned(), "invalid type: integer `1`, expected "),
            ("[]".to_owned(), "invalid length 1, expected an object"),
            (camera("\"eye\": [0, 0, null]"), "camera.eye[2]: invalid type: null, expected a number at line 1"),
            (camera("\"width\": -1"), "camera.width: invalid value: integer `-1`, expected a whole number from 0"),
            (camera("\"vertical_fov\": 1e999"), "camera.vertical_fov: number out of range"),
            (
                "{ \"light\": {} }".to_owned(),
                "light: expected exactly one of the choices that the schema lists, at line 1",
            ),
            ("{ \"light\": 3 }".to_owned(), "light: expected exactly one of the choices"),
            (
                "{ \"light\": { \"procedural\": { \"kind\": \"sky\" }, \"environment\": {} } }".to_owned(),
                "light: expected exactly one of the choices",
            ),
            ("{ \"light\": \"rect\" }".to_owned(), "light.rect: expected an object with that name as its one member"),
            (
                "{ \"light\": \"procedural\" }".to_owned(),
                "light.procedural: expected an object with that name as its one member",
            ),
        ] {
            let message = message(&json);
            assert!(message.starts_with(start), "{json}: {message}");
        }
    }
}
