#!/usr/bin/env python3
"""Compare our image of a sphere or a floor with one by Mitsuba 3 (PyPI: mitsuba), direct light only.

    outside_check.py SCENE.json OURS.exr [--light LIGHT.exr] [--spp 1024] [--save THEIRS.exr]
    outside_check.py --self-check

SCENE.json: one sphere around the origin, or one plane that fills the image, its material `lambert`, or `ggx` with rho_d = 0.
Its lights are the rectangles that it lists and, where it has an environment or procedural light, LIGHT.exr: that light by
latitude and longitude as this program exports it. Rectangles must not be in view, nor hide LIGHT.exr: we have no shadows.
Prints relMSE over the pixels that are at least two pixels inside the silhouette; ends with 7 above 1e-3. Mitsuba averages
over the area of a pixel (box filter), we look through its centre: inside the silhouette the difference is of second order.

--self-check compares Mitsuba with a direct sum over all texels of a light, at some pixels, for both materials: that proves
the conventions written down here (camera, turn of the light, separate masking of either direction, F = 1)
without our renderer.
"""
import argparse
import json
import sys
import time

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

BAR = 1e-3


def directions(rows, columns, closed):
    """World directions of the texels of a map, (rows, columns, 3), and theta of its rows, (rows, 1).

    The upper row is at +z; a column at u of the width looks to the azimuth pi - 2 pi u from +x towards +y: +x is in the middle,
    +y a quarter to the left of it. `closed`: the first and the last row are the poles themselves, as in Mitsuba.
    """
    theta = np.pi * (np.arange(rows) / (rows - 1) if closed else (np.arange(rows) + 0.5) / rows)[:, None]
    phi = np.pi - 2 * np.pi * (np.arange(columns) + 0.5) / columns
    d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi], axis=2)
    return d, theta


def look_up(light, d):
    """Bilinear look-up of our map (see `directions`) in the directions d; over a pole it goes on at the other side."""
    rows, columns = light.shape[:2]
    v = np.arccos(np.clip(d[..., 2], -1, 1)) / np.pi * rows - 0.5
    u = (0.5 - np.arctan2(d[..., 1], d[..., 0]) / (2 * np.pi)) * columns - 0.5
    x, y = np.floor(u).astype(int), np.floor(v).astype(int)
    s, t = (u - x)[..., None], (v - y)[..., None]

    def at(y, x):
        over = (y < 0) | (y >= rows)
        return light[np.clip(y, 0, rows - 1), (x + np.where(over, columns // 2, 0)) % columns]

    return (1 - t) * ((1 - s) * at(y, x) + s * at(y, x + 1)) + t * ((1 - s) * at(y + 1, x) + s * at(y + 1, x + 1))


def their_light(light):
    """Our map as Mitsuba reads it after the turn in `render`: with rows at the poles, columns from +y towards +x."""
    d, _ = directions(light.shape[0] + 1, light.shape[1], closed=True)
    return look_up(light, d[..., [1, 0, 2]] * [1, -1, 1]).astype(np.float32)


def width(ggx):
    """The alpha of a GGX material, by either of its names."""
    return ggx["alpha"] if "alpha" in ggx else ggx["m"]


def their_material(material):
    """A BRDF by its name and its parameters in our scenes."""
    (name, value), = material.items()
    if name == "lambert":
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": value}}
    if name == "ggx" and not any(value["rho_d"]):
        # GGX, Smith's masking of either direction; a conductor without material reflects everything
        scale = {"type": "rgb", "value": value["rho_s"]}
        lobe = {"type": "roughconductor", "distribution": "ggx", "alpha": width(value), "material": "none"}
        return {**lobe, "specular_reflectance": scale}
    raise ValueError(f"{name} has no counterpart (ggx: rho_d must be 0)")


def their_rectangle(rect):
    """One of our rectangle lights."""
    (u, v), corner = np.array(rect["edges"], float), np.array(rect["corner"], float)
    n = np.cross(u, v)
    # theirs spans [-1, 1]^2 and emits towards +z
    columns = [u / 2, v / 2, n / np.linalg.norm(n), corner + (u + v) / 2]
    matrix = np.vstack([np.stack(columns, axis=1), [0, 0, 0, 1]])
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": rect["radiance"]}}
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix), "emitter": emitter}


def their_shape(thing):
    """A sphere around the origin or a plane."""
    (name, mesh), = thing["mesh"].items()
    if name == "sphere":
        return {"type": "sphere", "radius": mesh.get("radius", 1.0) * thing.get("scale", 1.0)}
    if name == "plane":
        half = mesh.get("size", 2.0) * thing.get("scale", 1.0) / 2
        place = mi.ScalarTransform4f().translate(thing.get("translate", [0, 0, 0]))
        return {"type": "rectangle", "to_world": place @ mi.ScalarTransform4f().scale([half, half, 1])}
    raise ValueError(f"{name} has no counterpart")


def render(camera, thing, material, light, rectangles, spp, seed=0):
    """Mitsuba's image, (height, width, 3), linear radiance, the background 0. `light`: our map or None."""
    transform = mi.ScalarTransform4f
    # +y, which is up in Mitsuba's maps, becomes +z
    turned = transform().rotate([1, 0, 0], 90)
    lights = {f"rectangle{n}": their_rectangle(rect) for n, rect in enumerate(rectangles)}
    if light is not None:
        lights["light"] = {"type": "envmap", "bitmap": mi.Bitmap(their_light(light)), "to_world": turned}
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "hide_emitters": True},
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": camera["vertical_fov"],
            "to_world": transform().look_at(camera["eye"], camera["target"], camera.get("up", [0, 0, 1])),
            "film": {"type": "hdrfilm", "width": camera["width"], "height": camera["height"], "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "multijitter", "sample_count": spp},
        },
        **lights,
        "surface": {**their_shape(thing), "bsdf": their_material(material)},
    })
    return np.array(mi.render(scene, seed=seed, spp=spp))[..., :3].astype(float)


def surface(camera, radius):
    """Per pixel, through its centre: whether the sphere is hit, the normal there, and the unit vector to the eye."""
    eye, target = np.array(camera["eye"], float), np.array(camera["target"], float)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, camera.get("up", [0, 0, 1]))
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    width, height = camera["width"], camera["height"]
    step = 2 * np.tan(np.radians(camera["vertical_fov"]) / 2) / height
    x = (np.arange(width) + 0.5 - width / 2)[None, :, None] * step
    y = (np.arange(height) + 0.5 - height / 2)[:, None, None] * step
    d = forward + x * right + y * down
    d /= np.linalg.norm(d, axis=2, keepdims=True)
    b = d @ eye
    root = b * b - (eye @ eye - radius * radius)
    hit = root > 0
    t = -b - np.sqrt(np.maximum(root, 0))
    return hit, (eye + t[..., None] * d) / radius, -d


def inside(hit, pixels=2):
    """The pixels whose neighbours up to a distance are hit too."""
    padded = np.pad(hit, pixels)
    size = 2 * pixels + 1
    return np.lib.stride_tricks.sliding_window_view(padded, (size, size)).all(axis=(2, 3))


def brdf(material, i, o, n):
    """Value in 1/sr for many incident directions, from its definition."""
    (name, value), = material.items()
    if name == "lambert":
        return np.broadcast_to(np.array(value) / np.pi, (*i.shape[:-1], 3))
    h = i + o
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    m2 = width(value) ** 2

    def g1(cos):
        return 2 / (1 + np.sqrt(1 + m2 * (1 / cos**2 - 1)))

    cos_h, cos_i, cos_o = h @ n, np.maximum(i @ n, 1e-9), o @ n
    d = m2 / (np.pi * cos_h**4 * (m2 + 1 / cos_h**2 - 1) ** 2)
    return (d * g1(cos_i) * g1(cos_o) / (4 * cos_i * cos_o))[..., None] * np.array(value["rho_s"])


def by_summation(material, light, n, o):
    """Reflected radiance, summed over the texels of a map."""
    d, theta = directions(*light.shape[:2], closed=False)
    weight = np.maximum(d @ n, 0) * np.sin(theta) * (np.pi / light.shape[0]) * (2 * np.pi / light.shape[1])
    return np.einsum("yxc,yxc,yx->c", brdf(material, d, o, n), light, weight)


def relmse(x, y):
    """Relative mean square error of exposed radiance, over a list of pixels."""
    luminance = y @ [0.2126, 0.7152, 0.0722]
    exposure = min(0.35 / luminance.mean(), 0.9 / np.percentile(luminance, 95))
    return np.mean((exposure * (x - y)) ** 2 / ((exposure * y) ** 2 + 0.01))


def self_check():
    camera = {"eye": [3.0, 1.5, 1.0], "target": [0.1, 0.0, 0.2], "vertical_fov": 40.0, "width": 96, "height": 80}
    d, _ = directions(256, 512, closed=False)
    # different in all directions, one soft lamp
    light = np.stack([1 + 0.5 * d[..., 0], 1 + 0.5 * d[..., 1], 1 + 0.5 * d[..., 2]], axis=2)
    light += 30 * np.exp(40 * (d @ (np.array([0.5, 0.7, 0.4]) / np.linalg.norm([0.5, 0.7, 0.4])) - 1))[..., None]
    hit, normal, view = surface(camera, 1.0)
    chosen = np.argwhere(inside(hit))[::37]
    worst = 0.0
    for material in ({"lambert": [0.8, 0.5, 0.2]}, {"ggx": {"rho_d": [0.0] * 3, "rho_s": [0.9, 0.6, 0.3], "m": 0.25}}):
        start = time.perf_counter()
        image = render(camera, {"mesh": {"sphere": {}}}, material, light, [], 1024)
        seconds = time.perf_counter() - start
        expected = np.array([by_summation(material, light, normal[y, x], view[y, x]) for y, x in chosen])
        error = relmse(np.array([image[y, x] for y, x in chosen]), expected)
        ratio = np.mean(image[tuple(chosen.T)] / expected)
        name = next(iter(material))
        print(f"{name}: relMSE {error:.1e} over {len(chosen)} pixels, mean ratio {ratio:.5f}, {seconds:.1f} s")
        worst = max(worst, error)
    return worst


def compare(arguments):
    import OpenEXR

    def read(path):
        channels = OpenEXR.File(path, separate_channels=True).channels()
        return np.stack([channels[name].pixels for name in "RGB"], axis=2).astype(float)

    with open(arguments.scene, encoding="utf-8") as file:
        scene = json.load(file)
    thing, = scene["objects"]
    material = scene["materials"][thing["material"]]["source"]
    described = scene.get("lights", [scene.get("light")])
    rectangles = [light["rect"] for light in described if "rect" in light]
    if len(rectangles) < len(described) and not arguments.light:
        raise SystemExit("the scene has an environment or procedural light; --light LIGHT.exr is missing")
    light = read(arguments.light) if arguments.light else None
    ours = read(arguments.ours)
    start = time.perf_counter()
    theirs = render(scene["camera"], thing, material, light, rectangles, arguments.spp)
    seconds = time.perf_counter() - start
    if arguments.save:
        planes = {name: np.ascontiguousarray(theirs[..., c], np.float32) for c, name in enumerate("RGB")}
        OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, planes).write(arguments.save)
    hit = np.ones(ours.shape[:2], bool)
    if "sphere" in thing["mesh"]:
        hit, _, _ = surface(scene["camera"], their_shape(thing)["radius"])
        kept = inside(hit)
    else:
        kept = hit
    error = relmse(ours[kept], theirs[kept])
    ratio = ours[kept].sum() / theirs[kept].sum()
    print(
        f"{next(iter(material))}: relMSE {error:.2e} over {kept.sum()} of {hit.sum()} pixels, ratio of means {ratio:.5f}, "
        f"Mitsuba {mi.__version__} with {arguments.spp} samples per pixel in {seconds:.0f} s"
    )
    return error


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?")
    parser.add_argument("ours", nargs="?")
    parser.add_argument("--light")
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--save")
    parser.add_argument("--self-check", action="store_true")
    arguments = parser.parse_args()
    if not arguments.self_check and arguments.ours is None:
        parser.error("SCENE.json and OURS.exr, or --self-check")
    sys.exit(7 if (self_check() if arguments.self_check else compare(arguments)) > BAR else 0)


if __name__ == "__main__":
    main()
