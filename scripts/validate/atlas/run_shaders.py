#!/usr/bin/env python3
"""Run the look-ups of the shader texts and compare them with what the Rust functions return.

    run_shaders.py VECTORS WGSL GLSL

VECTORS is the folder that the example `sampling_vectors` wrote. Both texts run as compute shaders in WebGPU (wgpu), on a
software device where there is no other. Prints one line per language and layout; exits with 1 where a nearest texel differs at
all or a bilinear value by more than 1e-4 of the range of the texels (the look-ups keep away from the borders between
texels, the texels are random: this is the most that rounding in the position explains).
"""
import sys
from pathlib import Path

import numpy as np
import wgpu

import ktx2

WGSL_ENTRY = """
@group(0) @binding(0) var atlas: texture_2d<f32>;
@group(0) @binding(1) var<storage, read> rows: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> values: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if (2u * id.x >= arrayLength(&rows)) { return; }
    let i = rows[2u * id.x];
    let place = bandwidth_LAYOUT(i.xyz, rows[2u * id.x + 1u].xyz);
    values[2u * id.x] = bandwidth_nearest(atlas, place, u32(i.w));
    values[2u * id.x + 1u] = bandwidth_bilinear(atlas, place, u32(i.w));
}
"""

GLSL_ENTRY = """
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform texture2D atlas;
layout(set = 0, binding = 1) readonly buffer Rows { vec4 rows[]; };
layout(set = 0, binding = 2) buffer Values { vec4 values[]; };

void main() {
    uint k = gl_GlobalInvocationID.x;
    if (2u * k >= uint(rows.length())) { return; }
    vec4 i = rows[2u * k];
    BandwidthPlace place = bandwidth_LAYOUT(i.xyz, rows[2u * k + 1u].xyz);
    values[2u * k] = bandwidth_nearest(atlas, place, int(i.w));
    values[2u * k + 1u] = bandwidth_bilinear(atlas, place, int(i.w));
}
"""


def upload(device, levels):
    """A texture with these levels."""
    size, channels = levels[0].shape[0], levels[0].shape[2]
    texture = device.create_texture(
        size=(size, size, 1),
        format={1: "r16float", 4: "rgba16float"}[channels],
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
        mip_level_count=len(levels),
    )
    for k, level in enumerate(levels):
        n = level.shape[0]
        target = {"texture": texture, "mip_level": k, "origin": (0, 0, 0)}
        device.queue.write_texture(target, level.tobytes(), {"bytes_per_row": 2 * channels * n}, (n, n, 1))
    return texture


def run(device, code, texture, rows):
    """The values that the shader returns for the rows (i, level, o, 0): nearest and bilinear, four channels each."""
    module = device.create_shader_module(label="comp", code=code)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
    source = device.create_buffer_with_data(data=rows.tobytes(), usage=wgpu.BufferUsage.STORAGE)
    target = device.create_buffer(size=rows.nbytes, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    bindings = [texture.create_view(), {"buffer": source}, {"buffer": target}]
    entries = [{"binding": k, "resource": resource} for k, resource in enumerate(bindings)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups((len(rows) + 63) // 64)
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(target), np.float32).reshape(-1, 2, 4)


def main():
    vectors, wgsl, glsl = map(Path, sys.argv[1:4])
    sources = {
        "WGSL": wgsl.read_text() + WGSL_ENTRY,
        "GLSL": "#version 450\n#define BANDWIDTH_ATLAS texture2D\n" + glsl.read_text() + GLSL_ENTRY,
    }
    adapter = wgpu.gpu.request_adapter_sync()
    device = adapter.request_device_sync()
    print(f"device: {adapter.info['device']}")
    failed = False
    for layout in ("isotropic", "hemisphere"):
        levels, _ = ktx2.read(vectors / f"{layout}.ktx2")
        table = np.fromfile(vectors / f"{layout}.rows", "<f4").reshape(-1, 16)
        texture = upload(device, levels)
        for language, source in sources.items():
            values = run(device, source.replace("LAYOUT", layout), texture, np.ascontiguousarray(table[:, :8]))
            expected = table[:, 8:].reshape(-1, 2, 4)
            different = int(np.any(values[:, 0] != expected[:, 0], axis=1).sum())
            error = float(np.abs(values[:, 1] - expected[:, 1]).max() / levels[0].max())
            wrong = different > 0 or not error <= 1e-4
            failed |= wrong
            print(
                f"{language} {layout:10s} {len(table)} look-ups: {different} nearest texels differ, "
                f"bilinear within {error:.1e} of the range  {'FAILED' if wrong else 'ok'}"
            )
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
