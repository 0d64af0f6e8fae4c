#!/usr/bin/env python3
"""Measured materials above their fits, rendered alike, as one picture.

    render_materials.py BRDFIT MEASURED_DIR FITS_DIR WORK_DIR PICTURE.png

MEASURED_DIR has the .binary files (samples at the centre of their cells), FITS_DIR the result of fitting them.
"""
import json
import subprocess
import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

NAMES = ["cc_ibiza_sunset", "chm_mint", "irid_flake_paint1", "satin_rosaline", "vch_silk_blue"]
SIZE, MARGIN, TITLE = 256, 6, 24
"""Pixels that are shown; rendered at twice as many along a side, for there is no anti-aliasing."""
SCENE = {
    "camera": {"eye": [3.9, 0, 0.9], "target": [0, 0, 0], "vertical_fov": 34, "width": 2 * SIZE, "height": 2 * SIZE},
    "light": {"procedural": {"kind": "studio"}},
    "objects": [{"mesh": {"sphere": {}}, "material": "paint"}],
}


def main():
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    program, measured, fits, work, picture = sys.argv[1], *map(Path, sys.argv[2:])
    sources = {
        "measured": lambda name: {"measured": {"file": str((measured / f"{name}.binary").resolve()), "sample_position": "centre"}},
        "fitted": lambda name: {"fit": str((fits / f"{name}.json").resolve())},
    }
    step = SIZE + MARGIN
    sheet = Image.new("RGB", (TITLE + len(NAMES) * step, TITLE + len(sources) * step), "white")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(15)
    for row, (kind, source) in enumerate(sources.items()):
        for column, name in enumerate(NAMES):
            scene = work / f"{kind}-{name}.scene.json"
            scene.write_text(json.dumps({**SCENE, "materials": {"paint": {"source": source(name)}}}))
            shown = scene.with_suffix(".png")
            # one exposure for both, from the measured one
            command = [program, "render", scene, "-o", scene.with_suffix(".exr"), "--png", shown, "--spp", "64", "--quiet"]
            reference = work / f"measured-{name}.scene.exr"
            command += ["--reference", reference] if kind == "fitted" else []
            subprocess.run([str(word) for word in command], check=True)
            small = Image.open(shown).resize((SIZE, SIZE), Image.Resampling.LANCZOS)
            sheet.paste(small, (TITLE + column * step, TITLE + row * step))
            if row == 0:
                draw.text((TITLE + column * step + SIZE / 2, 3), name, "black", font, anchor="ma")
        label = Image.new("RGB", (SIZE, TITLE), "white")
        ImageDraw.Draw(label).text((SIZE / 2, 2), kind, "black", font, anchor="ma")
        sheet.paste(label.rotate(90, expand=True), (0, TITLE + row * step))
    sheet.save(picture, optimize=True)


if __name__ == "__main__":
    main()
