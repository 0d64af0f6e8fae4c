//! The sampling functions of [`crate::sampling`] as text for shaders.

/// A shading language in which the sampling functions are at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaderLanguage {
    /// WGSL, the language of WebGPU.
    Wgsl,
    /// GLSL from version 130 and GLSL ES from 300, for OpenGL, WebGL 2 and Vulkan.
    Glsl,
}

impl ShaderLanguage {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Wgsl, Self::Glsl];

    /// The name in lower case, which is also the extension of its files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Glsl => "glsl",
        }
    }
}

/// Functions that look a bandwidth up in an atlas, to be put in front of a shader that calls them. The comment at its head says
/// how directions map to texels, in which units values are, and how to bind the texture; nothing is bound by the text
/// itself. Function by function it is the same as [`crate::AtlasPlace`] and the look-ups of [`crate::Atlas`], in single precision.
#[must_use]
pub fn shader(language: ShaderLanguage) -> &'static str {
    match language {
        ShaderLanguage::Wgsl => include_str!("../shaders/bandwidth_atlas.wgsl"),
        ShaderLanguage::Glsl => include_str!("../shaders/bandwidth_atlas.glsl"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both are executed and compared with the functions in Rust by scripts/validate/atlas/check_shaders.sh.
    #[test]
    fn the_languages_have_the_same_functions_and_constants() {
        let [wgsl, glsl] = ShaderLanguage::ALL.map(shader);
        let names = |text: &'static str| -> Vec<&str> {
            let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            let mut names: Vec<&str> = words.filter(|word| word.to_lowercase().starts_with("bandwidth_")).collect();
            names.retain(|name| *name != "BANDWIDTH_ATLAS");
            names.sort_unstable();
            names
        };
        assert_eq!(names(wgsl), names(glsl));
        let numbers = |text: &'static str| -> Vec<&str> {
            let constants = text.lines().filter(|line| line.starts_with("const "));
            constants
                .filter_map(|line| line.split(['=', ';']).nth(1))
                .map(|value| value.trim().trim_end_matches('u'))
                .collect()
        };
        assert_eq!(numbers(wgsl).len(), 6);
        assert_eq!(numbers(wgsl), numbers(glsl));
    }
}
