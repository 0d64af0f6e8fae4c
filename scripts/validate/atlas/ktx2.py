#!/usr/bin/env python3
"""A reader of KTX2 files with half-precision texels, as short as the format allows.

Source: KTX File Format Specification 2.0 (Khronos), sections 3 to 5. Run with a file, it prints what the file holds.
"""
import struct
import sys
from pathlib import Path

import numpy as np

MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"
CHANNELS = {76: 1, 97: 4}  # VK_FORMAT_R16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT


def read(path):
    """Levels of a 2-D texture, each a half array (rows, columns, channels) with row 0 first, and the key/values."""
    data = Path(path).read_bytes()
    if data[:12] != MAGIC:
        raise ValueError(f"{path}: no KTX2 file")
    header = struct.unpack_from("<13I2Q", data, 12)
    vk_format, type_size, width, height, depth, layers, faces, level_count, compression = header[:9]
    values_start, values_length = header[11:13]
    if vk_format not in CHANNELS or (type_size, depth, layers, faces, compression) != (2, 0, 0, 1, 0):
        raise ValueError(f"{path}: not a plain 2-D texture of half-precision texels")

    key_values, at = {}, values_start
    while at < values_start + values_length:
        (length,) = struct.unpack_from("<I", data, at)
        key, value = data[at + 4 : at + 4 + length].split(b"\0", 1)
        key_values[key.decode()] = value.rstrip(b"\0").decode()
        at += 4 + (length + 3) // 4 * 4

    levels = []
    for k in range(level_count):
        start, length, _ = struct.unpack_from("<3Q", data, 80 + 24 * k)
        shape = (height >> k, width >> k, CHANNELS[vk_format])
        levels.append(np.frombuffer(data[start : start + length], "<f2").reshape(shape))
    return levels, key_values


if __name__ == "__main__":
    for name in sys.argv[1:]:
        levels, key_values = read(name)
        print("\n".join([name] + [f"  {key}: {value}" for key, value in key_values.items()]))
        for k, level in enumerate(levels):
            print(f"  level {k}: {level.shape[1]} x {level.shape[0]}, {level.min():g} to {level.max():g}")
