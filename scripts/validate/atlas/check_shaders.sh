#!/usr/bin/env bash
# The look-up functions in WGSL and GLSL against those in Rust, on some 20,000 random look-ups per layout and the special
# ones: the shaders run as they are on a software Vulkan device (Mesa's lavapipe, a Debian package, installed here where it is
# missing) through wgpu. The GLSL is also compiled by Khronos' glslang, for OpenGL, OpenGL ES and Vulkan.
#
#     scripts/validate/atlas/check_shaders.sh
data_is_optional=yes
source "$(dirname "$0")/../../common.sh"
python_environment
temporary_folder
icd=(/usr/share/vulkan/icd.d/lvp_icd*.json)
if [ ! -e "${icd[0]}" ] || ! command -v glslangValidator >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        mesa-vulkan-drivers libvulkan1 glslang-tools >/dev/null
    icd=(/usr/share/vulkan/icd.d/lvp_icd*.json)
fi
shaders=$root/src/bandwidth/shaders

# fragment HEAD DECLARATIONS: the GLSL text in a shader that calls its functions
fragment() {
    printf '%s\n' "$1"
    cat "$shaders/bandwidth_atlas.glsl"
    printf '%s\n' "$2"
    echo 'void main() {
        color = bandwidth_nearest(atlas, bandwidth_isotropic(i, o), 0);
        color += bandwidth_bilinear(atlas, bandwidth_hemisphere(i, o), 2);
    }'
}
plain='in vec3 i; in vec3 o; out vec4 color; uniform sampler2D atlas;'
located='layout(location = 0) in vec3 i; layout(location = 1) in vec3 o; layout(location = 0) out vec4 color;'
fragment '#version 130' "$plain" >"$work/opengl.frag"
fragment '#version 300 es
precision highp float; precision highp sampler2D;' "$plain" >"$work/opengl_es.frag"
fragment '#version 450' "$located layout(binding = 0) uniform sampler2D atlas;" >"$work/vulkan.frag"
fragment '#version 450
#extension GL_EXT_samplerless_texture_functions : require
#define BANDWIDTH_ATLAS texture2D' "$located layout(binding = 0) uniform texture2D atlas;" >"$work/samplerless.frag"
glslangValidator "$work/opengl.frag" >&2
glslangValidator "$work/opengl_es.frag" >&2
glslangValidator -V -o "$work/vulkan.spv" "$work/vulkan.frag" >&2
glslangValidator -V -o "$work/samplerless.spv" "$work/samplerless.frag" >&2
echo "GLSL compiles in glslang: 130, 300 es, 450 with a sampler2D, 450 with a texture2D"

build_example sampling_vectors
"$example" "$work"
export VK_ICD_FILENAMES=${icd[0]} VK_DRIVER_FILES=${icd[0]} XDG_RUNTIME_DIR=$work
"$python" "$root/scripts/validate/atlas/run_shaders.py" "$work" "$shaders"/bandwidth_atlas.{wgsl,glsl}
