//! The table of formats of `brdfit export`.

use brdfit_bandwidth::ShaderLanguage;

use crate::exporters::exporter::Exporter;
use crate::exporters::shader::Shader;

/// A format of the command line.
pub(crate) struct Format {
    /// Its name there.
    pub(crate) name: &'static str,
    /// One line about it.
    pub(crate) help: &'static str,
    /// Its exporter.
    pub(crate) exporter: &'static dyn Exporter,
}

/// All formats, in the order of the help.
pub(crate) static FORMATS: [Format; 2] = [
    Format { name: "wgsl", help: "For WebGPU", exporter: &Shader(ShaderLanguage::Wgsl) },
    Format { name: "glsl", help: "For OpenGL, WebGL 2 and Vulkan", exporter: &Shader(ShaderLanguage::Glsl) },
];

/// The format with this name.
pub(crate) fn find(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_format_is_found_by_its_name_and_writes_something_of_its_own() {
        for format in &FORMATS {
            let found = find(format.name).expect("it is in the list");
            let content = found.exporter.export();
            assert!(!content.is_empty());
            for other in FORMATS.iter().filter(|other| other.name != format.name) {
                assert_ne!(content, other.exporter.export(), "{} and {}", format.name, other.name);
            }
        }
        assert!(find("obj").is_none());
    }
}
