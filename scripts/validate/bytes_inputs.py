"""Inputs of bytes.sh: measured files, reconstructions and published fits where the test data is there; scenes, and small files
that are written here, good and bad. Nothing made here depends on the machine, except that NumPy's exp and tan may differ in the
last digit between processors (reconstructions): hashes of the inputs are part of the list, so that this shows.
"""
import base64
import json
import lzma
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np

from bytes_cases import EMBEDDED, MEASURED, PAIRS, RECONSTRUCTED

SCRIPTS = Path(__file__).resolve().parents[1]
SCENE_FILES = ("spot.obj", "spot_texture.png", "teapot.obj", "city.exr", "studio.exr")


def available(data):
    """Parts of the test data that are there."""
    table = data / "tables"
    parts = {
        "measured": [data / "measured" / f"{name}.binary.xz" for name in MEASURED],
        "npf": [table / "npf.bin", table / "npf_materials.json", table / "merl_valid_mask.npy.xz"],
        "published": [table / "sgd_published.json"],
        "scenes": [data / "scenes" / name for name in SCENE_FILES],
    }
    return {name: [str(file) for file in files if not file.is_file()] for name, files in parts.items()}


def make(folder, data, parts):
    """Everything in `folder`; what is large and already there stays."""
    for name in ("scenes", "pairs", "published", "made", "bad"):
        shutil.rmtree(folder / name, ignore_errors=True)
        (folder / name).mkdir(parents=True)
    if "measured" in parts:
        make_merl(data, "unpack", folder / "measured")
    if "npf" in parts:
        (folder / "npf").mkdir(exist_ok=True)
        for name in RECONSTRUCTED:
            if not (folder / "npf" / f"{name}.binary").exists():
                make_merl(data, "npf", name, folder / "npf" / f"{name}.binary")
    if "published" in parts:
        published(data / "tables" / "sgd_published.json", folder / "published")
    if "scenes" in parts:
        for name in SCENE_FILES:
            shutil.copyfile(data / "scenes" / name, folder / "scenes" / name)
    merl_files(folder)
    meshes_and_lights(folder / "scenes")
    scenes(folder / "scenes")
    spoilt_scenes(folder / "bad")
    for name in pair_names():
        scene = json.loads((SCRIPTS / "pairs" / f"{name}.json").read_text(encoding="utf-8"))
        scene["camera"].update(width=64, height=64)
        put(folder / "pairs" / f"{name}.json", scene)


def pair_names():
    """The scenes of scripts/pairs."""
    return sorted(path.stem for path in (SCRIPTS / "pairs").glob("*.json"))


def make_merl(data, *arguments):
    """Runs scripts/fixtures/make_merl.py."""
    command = [sys.executable, str(SCRIPTS / "fixtures" / "make_merl.py"), *map(str, arguments)]
    subprocess.run(command, check=True, env={**os.environ, "BRDFIT_DATA": str(data)})


def put(path, document):
    """A JSON document."""
    path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def published(table, folder):
    """Published parameters as the least document that the program reads as a fit."""
    published = json.loads(table.read_text(encoding="utf-8"))
    for name in PAIRS:
        names = {"rho_d": "rho_d", "rho_s": "rho_s", "alpha": "alpha", "p": "p", "F0": "f0", "F1": "f1"}
        channels = [{"parameters": {ours: published[name][theirs][c] for theirs, ours in names.items()}} for c in range(3)]
        put(folder / f"{name}.json", {"channels": channels})


def merl_files(folder):
    """MERL files of a lobe made by division alone, whole and spoilt in every way that has a message."""
    h, d = np.arange(90.0)[:, None, None], np.arange(90.0)[None, :, None]
    lobe = np.broadcast_to(60.0 + 90000.0 / (1.0 + h * h / 20.0) + d * d / 9.0, (90, 90, 180))
    planes = np.stack([lobe, lobe * 0.5, lobe * 0.25])
    header = struct.pack("<3i", 90, 90, 180)
    plain = header + planes.tobytes()
    nan = planes.copy()
    nan[0, 3, 4, 5], nan[2, 70, 10, 179] = np.nan, -np.inf
    few = planes.copy()
    few[:, 10:80:2] = -1.0
    few[:, :, 20:60:3] = -1.0
    made, bad = folder / "made", folder / "bad"
    (made / "deep").mkdir()
    (bad / "folder").mkdir()
    (made / "plain.binary").write_bytes(plain)
    (made / "deep" / "few.binary").write_bytes(header + few.tobytes())
    (made / "list.txt").write_text("# relative to the list\nplain.binary\n\n../../out/synth/red-satin/red-satin.binary\n")
    values = [[0.05, 0.30, 0.010, 0.40, 0.60, 0.20], [0.10, 0.25, 0.020, 0.50, 0.50, 0.30], [0.20, 0.20, 0.030, 0.30, 0.40, 0.20]]
    names = ("rho_d", "rho_s", "alpha", "p", "f0", "f1")
    put(made / "parameters.json", {"channels": [{"parameters": dict(zip(names, channel))} for channel in values]})
    for name, content in {
        "few": header + few.tobytes(),
        "nan": header + nan.tobytes(),
        "unmeasured": header + np.full_like(planes, -1.0).tobytes(),
        "cut": plain[:-1],
        "long": plain + b"\0",
        "empty": b"",
        "dimensions": struct.pack("<3i", 90, 91, 180) + plain[12:],
        "big-endian": struct.pack(">3i", 90, 90, 180) + plain[12:],
        "packed": lzma.compress(b"MERL"),
    }.items():
        (bad / f"{name}.binary").write_bytes(content)
    (bad / "cut.json").write_text('{"channels": [{"parameters": {"rho_d": 0.1, ')


def meshes_and_lights(folder):
    """A pyramid on a square as OBJ, glTF and GLB, and a light in the Radiance format, 32 x 16 pixels."""
    points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1.2)]
    triangles = [(0, 2, 1), (0, 3, 2), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    coordinates = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.5)]
    text = [f"v {x} {y} {z}" for x, y, z in points] + [f"vt {u} {v}" for u, v in coordinates] + ["f 1/1 4/4 3/3 2/2"]
    text += ["f " + " ".join(f"{corner + 1}/{corner + 1}" for corner in triangle) for triangle in triangles[2:]]
    (folder / "pyramid.obj").write_text("# a square and four triangles\n" + "\n".join(text) + "\n")
    positions, uvs, indices = (np.array(points, "<f4"), np.array(coordinates, "<f4"), np.array(triangles, "<u2"))
    blob = positions.tobytes() + uvs.tobytes() + indices.tobytes()
    views = [(0, 60), (60, 40), (100, 36)]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "rotation": [0, 0, 0.38268343, 0.92387953], "scale": [1, 1, 1.1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 1.2]},
            {"bufferView": 1, "componentType": 5126, "count": 5, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 18, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": length} for start, length in views],
        "buffers": [{"byteLength": len(blob)}],
    }
    head = json.dumps(document).encode()
    head += b" " * (-len(head) % 4)
    total = 12 + 8 + len(head) + 8 + len(blob)
    chunks = struct.pack("<II", len(head), 0x4E4F534A) + head + struct.pack("<II", len(blob), 0x004E4942) + blob
    (folder / "pyramid.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, total) + chunks)
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    put(folder / "pyramid.gltf", document)
    row, column = np.mgrid[0:16, 0:32]
    bright = (column // 4 + row // 3) % 5 == 0
    pixels = np.stack([100 + 4 * column, 120 + 0 * column, 90 + 8 * row, np.where(bright, 132, 128)], axis=-1)
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n"
    (folder / "tiles.hdr").write_bytes(header + pixels.astype(np.uint8).tobytes())


def camera(width=64, height=48, eye=(3.4, 0.4, 1.7), fov=40):
    """A camera that looks at the origin, a little below."""
    return {"eye": list(eye), "target": [0, 0, -0.2], "vertical_fov": fov, "width": width, "height": height}


ATLAS = "../../out/atlas/embedded/{}.atlas.ktx2"
CHECKER = {"checker": {"colors": [[1, 0.9, 0.8], [0.2, 0.2, 0.3]], "scale": 8}}


def scenes(folder):
    """Small scenes: one for the options, one of each kind of light, mesh and source."""
    satin = {"source": {"embedded": "red-satin"}, "atlas": ATLAS.format("red-satin")}
    gold = {"source": {"embedded": "gold-metallic-paint"}, "atlas": ATLAS.format("gold-metallic-paint")}
    floor = {"source": {"lambert": [0.7, 0.7, 0.7]}, "atlas": ATLAS.format("terracotta"), "albedo": CHECKER}
    ground = {"mesh": {"plane": {"size": 5}}, "material": "floor", "translate": [0, 0, -1]}
    studio = {"procedural": {"kind": "studio", "rotation": 20}}

    def scene(name, light, materials, objects, view=None):
        document = {"camera": view or camera(), "light": light, "materials": materials, "objects": objects}
        put(folder / f"{name}.json", document)

    objects = [
        ground,
        {"mesh": {"sphere": {"radius": 0.9}}, "material": "satin", "translate": [0, -0.9, 0]},
        {"mesh": {"torus": {"radius": 0.6, "tube": 0.25}}, "material": "gold", "translate": [0, 1, 0], "rotate": [20, 60, 0]},
    ]
    materials = {"floor": floor, "satin": satin, "gold": gold}
    scene("ball", studio, materials, objects)
    scene("ball-large", {"procedural": {"kind": "sky", "scale": 0.5}}, materials, objects, camera(256, 192))
    scene("hdr", {"environment": {"file": "tiles.hdr", "rotation": 45, "scale": 2}}, materials, objects)
    light = {"environment": {"file": "../../out/render/light-map/light.exr"}}
    scene("light-of-exr", light, {"floor": floor, "satin": satin}, objects[:2])
    scene("uniform", {"procedural": {"kind": "uniform"}}, {"floor": floor, "satin": satin}, objects[:2])
    scene("atlas-exr", studio, {"satin": {**satin, "atlas": ATLAS.format("red-satin").replace("ktx2", "exr")}},
          [{"mesh": {"displaced_sphere": {"octaves": 2, "seed": 3}}, "material": "satin"}])  # fmt: skip
    scene("fit", studio, {"fit": {"source": {"fit": "red-satin.json"}, "atlas": ATLAS.format("red-satin")}},
          [{"mesh": {"torus_knot": {"p": 2, "q": 3}}, "material": "fit"}])  # fmt: skip
    for kind in ("obj", "gltf", "glb"):
        mesh = {"file": {"path": f"pyramid.{kind}", "up": "z"}} if kind == "obj" else {"file": {"path": f"pyramid.{kind}"}}
        scene(f"mesh-{kind}", {"procedural": {"kind": "strips"}}, {"floor": floor, "satin": {**gold, "albedo": CHECKER}},
              [ground, {"mesh": mesh, "material": "satin", "scale": 0.8}])  # fmt: skip
    # every kind of source, and materials without an atlas
    ggx = {"rho_d": [0.1, 0.2, 0.3], "rho_s": [0.5, 0.4, 0.3], "m": 0.2}
    kinds = {
        "embedded": {"source": {"embedded": EMBEDDED[1]}},
        "fit": {"source": {"fit": "../../out/fit/embedded/physical-edge/terracotta.json"}},
        "ggx": {"source": {"ggx": ggx}, "albedo": {"constant": [0.9, 0.8, 0.7]}},
        "lambert": {"source": {"lambert": [0.8, 0.5, 0.3]}, "albedo": CHECKER},
        "measured": {"source": {"measured": {"file": "../made/plain.binary", "sample_position": "edge"}}},
    }
    meshes = ({"sphere": {}}, {"torus": {}}, {"torus_knot": {}}, {"plane": {"size": 1.5}}, {"displaced_sphere": {"frequency": 3}})
    row = [{"mesh": mesh, "material": name, "scale": 0.4, "rotate": [0, 50, 10 * n], "translate": [0, n - 2, 0]}
           for n, (name, mesh) in enumerate(zip(kinds, meshes))]  # fmt: skip
    scene("kinds", {"procedural": {"kind": "sky", "rotation": 100}}, kinds, row, camera(96, 40))
    textured = {"source": {"ggx": {"rho_d": [0.6, 0.6, 0.6], "rho_s": [0.1, 0.1, 0.1], "m": 0.25}},
                "atlas": ATLAS.format("red-satin"), "albedo": {"texture": {"file": "spot_texture.png"}}}  # fmt: skip
    spot = {"mesh": {"file": {"path": "spot.obj"}}, "material": "skin", "rotate": [0, 0, 120]}
    for name, light, skin in (("spot", "city", textured), ("spot-gold", "city", gold), ("spot-studio", "studio", textured)):
        environment = {"environment": {"file": f"{light}.exr", "rotation": 30}}
        scene(name, environment, {"floor": floor, "skin": skin}, [ground, spot], camera(eye=(4.2, -1, 1.6), fov=36))
    mint = {"source": {"measured": {"file": "../measured/chm_mint.binary", "sample_position": "centre"}}}
    pot = {"mesh": {"file": {"path": "teapot.obj", "up": "y"}}, "material": "mint", "scale": 0.5}
    scene("teapot", {"environment": {"file": "city.exr", "rotation": 90}}, {"mint": mint}, [pot], camera(eye=(4.2, -1, 1.6)))


def spoilt_scenes(folder):
    """Scenes with one mistake each, and the files they name."""

    def scene(name, **changes):
        document = {
            "camera": camera(8, 8),
            "light": {"procedural": {"kind": "uniform"}},
            "materials": {"grey": {"source": {"lambert": [0.5, 0.5, 0.5]}}},
            "objects": [{"mesh": {"plane": {}}, "material": "grey"}],
        }
        put(folder / f"{name}.json", {**document, **changes})

    (folder / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n")
    (folder / "bad.exr").write_bytes(b"not an image")
    (folder / "bad.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    scene("unknown-member", lights=[])
    scene("unknown-material", objects=[{"mesh": {"plane": {}}, "material": "red"}])
    scene("out-of-range", camera={**camera(8, 8), "vertical_fov": 190})
    scene("missing-mesh", objects=[{"mesh": {"file": {"path": "missing.obj"}}, "material": "grey"}])
    scene("bad-mesh", objects=[{"mesh": {"file": {"path": "bad.obj"}}, "material": "grey"}])
    scene("bad-light", light={"environment": {"file": "bad.exr"}})
    texture = {"source": {"lambert": [0.5, 0.5, 0.5]}, "albedo": {"texture": {"file": "bad.png"}}}
    scene("bad-texture", materials={"grey": texture})
