"""The eight pairs of material and light of scripts/pairs, rendered by the program: scenes with atlases, runs, references.

Everything is kept in one folder, so that an atlas or a reference is made once. A reference is made again when the scene, or
the image of one sample per pixel that the program makes of it, changes.
"""
import hashlib
import json
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from .images import Layers, psnr

SCENES = Path(__file__).resolve().parents[2] / "pairs"
EIGHT = (
    "sphere-red-metallic-paint",
    "knot-nickel",
    "bumpy-sphere-gold-metallic-paint",
    "blob-blue-rubber",
    "torus-color-changing-paint3",
    "three-on-a-floor",
    "bumpy-sphere-pink-felt",
    "sphere-chrome",
)
REFERENCE_SEED = 1000
"""References take other seeds, one per frame from here on, than the images that are compared with them."""
REFERENCE_FRAMES = 16
THREADS = 2


def add_arguments(parser):
    """The arguments that all scripts over the pairs have."""
    parser.add_argument("brdfit", help="the program")
    parser.add_argument("materials", type=Path, help="folder with the files that the scenes name")
    parser.add_argument("work", type=Path, help="folder that keeps atlases and references")
    parser.add_argument("--pairs", nargs="+", default=EIGHT, metavar="NAME", help="scenes of scripts/pairs (default: the eight)")


@dataclass(frozen=True)
class Image:
    """What a run of the program left."""

    layers: Layers
    stats: dict

    @property
    def radiance(self):
        return self.layers.triple()

    @property
    def samples(self):
        """Per pixel of a surface, the pilot's included."""
        return self.stats["samples"]["per_pixel"]

    @property
    def milliseconds(self):
        return self.stats["milliseconds"]


@dataclass(frozen=True)
class Reference:
    """A converged image: `layers` also has `variance.Y`, the variance of one of its frames."""

    layers: Layers
    spp: int
    frames: int

    @property
    def radiance(self):
        return self.layers.triple()

    @property
    def foreground(self):
        return self.layers.foreground

    def psnr(self, image):
        """Of an image of the same scene, over the pixels of surfaces."""
        return psnr(image, self.radiance, self.foreground)


@dataclass(frozen=True)
class Pair:
    """A scene with its atlases."""

    name: str
    brdfit: str
    folder: Path
    materials: Path

    @classmethod
    def prepare(cls, name, args):
        """The pair of this name from the arguments of a script (`add_arguments`)."""
        scene = json.loads((SCENES / f"{name}.json").read_text(encoding="utf-8"))
        atlases = args.work / "atlases"
        for material in scene["materials"].values():
            (kind, source), = material["source"].items()
            file = source if kind == "fit" else source["file"]
            atlas = atlases / f"{Path(file).stem}.atlas.ktx2"
            if not atlas.exists():
                position = ["--sample-position", source["sample_position"]] if kind == "measured" else []
                subprocess.run([args.brdfit, "atlas", args.materials / file, "-o", atlases, "--formats", "ktx2", "--quiet",
                                *position], check=True)
            material["atlas"] = str(atlas.resolve())
        folder = args.work / name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scene.json").write_text(json.dumps(scene, indent=1) + "\n", encoding="utf-8")
        return cls(name, args.brdfit, folder, args.materials)

    def render(self, *options, layers="gbuffer", keep=None):
        """Renders with two threads. `layers`: those of --layers; `keep`: where the image goes, otherwise it is not kept."""
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            image, stats = Path(folder, "image.exr"), Path(folder, "stats.json")
            subprocess.run([self.brdfit, "render", self.folder / "scene.json", "--materials", self.materials, "-o", image,
                            "--stats", stats, "--background", "black", "--threads", str(THREADS), "--layers", layers, "--quiet",
                            *map(str, options)], check=True)
            rendered = Image(Layers.read(image), json.loads(stats.read_text(encoding="utf-8")))
            if keep:
                image.rename(keep)
            return rendered

    def constant(self, spp, *options, **where):
        """The same number of samples at every pixel; otherwise as `render`."""
        return self.render("--mode", "reference", "--spp", spp, *options, **where)

    def reference(self, spp):
        """The converged image of `spp` samples per pixel."""
        frames = min(REFERENCE_FRAMES, spp)
        return Reference(self._mean_of_frames(f"reference-{spp}", spp // frames, frames), spp, frames)

    def single_samples(self, frames):
        """The mean of frames with one independent sample of either technique at each pixel, and the variance of one of them."""
        return self._mean_of_frames(f"samples-{frames}", 2, frames)

    def _mean_of_frames(self, name, spp, frames):
        """Layers of the mean of constant images, kept under a name."""
        path = self.folder / f"{name}-{self.fingerprint}.exr"
        if not path.exists():
            self.constant(spp, "--frames", frames, "--seed", REFERENCE_SEED, keep=path)
        return Layers.read(path)

    @cached_property
    def fingerprint(self):
        """Tells whether the program still makes the same image of this scene."""
        one = self.constant(1)
        digest = hashlib.sha256(one.stats["scene"]["sha256"].encode())
        for channel in sorted(one.layers.channels):
            digest.update(np.ascontiguousarray(one.layers.scalar(channel), np.float32).tobytes())
        return digest.hexdigest()[:12]


def pairs(args):
    """The pairs of the arguments, one after the other, made ready."""
    for name in args.pairs:
        yield Pair.prepare(name, args)
