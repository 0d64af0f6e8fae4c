//! The functions that sample an atlas, as text for a shader.

use brdfit_bandwidth::{ShaderLanguage, shader};

use crate::exporters::exporter::Exporter;

/// In one of the languages.
pub(crate) struct Shader(pub(crate) ShaderLanguage);

impl Exporter for Shader {
    fn export(&self) -> Vec<u8> {
        shader(self.0).as_bytes().to_vec()
    }
}
