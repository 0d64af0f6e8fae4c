"""The command lines of bytes.sh: what is run, which inputs it needs, which of it belongs to the quick set.

A case has a name, which is its folder of outputs, and one or more command lines. They run in the work folder: OUT is the case's
own folder, inputs lie in in/ (bytes_inputs.py), outputs of earlier cases in out/. So no absolute path gets anywhere.
"""
from dataclasses import dataclass
from itertools import product

EMBEDDED = ("gold-metallic-paint", "blue-gloss-plastic", "polished-metal", "terracotta", "red-satin")
RECONSTRUCTED = ("alum-bronze", "chrome", "color-changing-paint3", "pink-felt")
PAIRS = ("chrome", "nickel", "red-metallic-paint", "gold-metallic-paint", "blue-rubber", "pink-felt", "alum-bronze",
         "beige-fabric", "color-changing-paint3", "specular-orange-phenolic", "white-diffuse-bball")  # fmt: skip
COMMANDS = ("fit", "atlas", "render", "export", "info", "synth", "compare", "merge", "schema", "demo", "completions", "man")


@dataclass(frozen=True)
class Case:
    """Command lines whose outputs lie in one folder."""

    name: str
    lines: tuple
    quick: bool = False
    needs: frozenset = frozenset()
    """Parts of the test data: measured, npf, published, scenes."""
    stdin: str = ""


class Cases(list):
    """The list that the functions below add to."""

    def add(self, name, *lines, quick=False, needs=(), stdin=""):
        self.append(Case(name, lines, quick, frozenset(needs), stdin))


def synth(cases):
    """The files of the embedded materials that the fits read, and every option of synth."""
    for name, options in zip(EMBEDDED, ("", "--sample-position centre", "--phi-bins 360", "--noise 0.05 --seed 7", "")):
        cases.add(f"synth/{name}", f"synth {name} {options} -o OUT/{name}.binary", quick=True)
    cases.add("synth/noise-seed-0", "synth red-satin --noise 0.3 -o OUT/x.binary")
    options = "--noise 1 --seed 3 --sample-position centre --phi-bins 360"
    cases.add("synth/noise-centre-360", f"synth terracotta {options} -o OUT/x.binary")
    cases.add("synth/from-parameters", "synth in/made/parameters.json -o OUT/x.binary")


FAMILIES = {
    "embedded": (" ".join(f"out/synth/{name}/{name}.binary" for name in EMBEDDED), "edge", ()),
    "npf": ("in/npf", "edge", ("npf",)),
    "measured": ("in/measured", "centre", ("measured",)),
}
"""Inputs, the sample position that is right for them, and the data they need."""

FIT_OPTIONS = {
    "loss-sqrt-cos": "--loss sqrt-cos",
    "loss-l2": "--loss l2",
    "anchor-distribution": "--anchor distribution",
    "step2-lm": "--step2-solver lm",
    "step2-lm-free-sqrt-cos": "--step2-solver lm --constraint free --loss sqrt-cos",
    "step2-lm-non-negative-l2": "--step2-solver lm --constraint non-negative --loss l2",
    "joint-l2-distribution": "--joint --loss l2 --anchor distribution",
    "cutoffs": "--cutoff-theta-h 60 --cutoff-theta-d 45",
    "cutoffs-wide": "--cutoff-theta-h 89 --cutoff-theta-d 89",
    "starts": "--start 0.01,0.5 --start 0.3,0.2",
    "max-iterations": "--max-iterations 3",
    "paper-with-loss": "--constraint paper --loss sqrt-cos",
    "no-panel": "--no-panel",
    "no-hash": "--no-hash",
}


def fit(cases):
    """Every constraint, position and distribution on every family; every other option on two of them; the ways to name inputs."""
    for family, (files, right, needs) in FAMILIES.items():
        for constraint, position in product(("physical", "non-negative", "free", "paper"), ("edge", "centre")):
            if family == "embedded" and constraint in ("non-negative", "free") and position != right:
                continue  # files without noise give the same parameters under every constraint
            line = f"fit {files} --constraint {constraint} --sample-position {position}"
            first = constraint == "physical" and position == right
            picture = "--picture" if constraint == "physical" else ""
            cases.add(f"fit/{family}/{constraint}-{position}", f"{line} {picture} -o OUT", quick=first, needs=needs)
            if position == right:
                cases.add(f"fit/{family}/{constraint}-{position}-joint", f"{line} --joint -o OUT", needs=needs)
        if family != "embedded":
            for name, options in FIT_OPTIONS.items():
                line = f"fit {files} --sample-position {right} {options} -o OUT"
                cases.add(f"fit/{family}/{name}", line, needs=needs)
    gold, satin = ("out/synth/{0}/{0}.binary".format(name) for name in ("gold-metallic-paint", "red-satin"))
    cases.add("fit/standard-output", f"fit {gold}", quick=True)
    cases.add("fit/verbose", f"fit {gold} -o OUT -v", f"fit {satin} -o OUT -v -v", quick=True)
    cases.add("fit/embedded/max-iterations", f"fit {gold} {satin} --max-iterations 2 -o OUT", quick=True)
    cases.add("synth/from-fit", "synth out/fit/embedded/physical-centre/red-satin.json -o OUT/x.binary")
    cases.add("fit/standard-output-options", f"fit {gold} --no-hash --quiet", f"fit {gold} --no-panel --color always")
    cases.add("fit/list", "fit @in/made/list.txt -o OUT")
    cases.add("fit/list-of-standard-input", "fit @- -o OUT", stdin=f"# two files\n\n{gold}\n{satin}\n")
    cases.add("fit/recursive", "fit out/synth/gold-metallic-paint in/made --recursive -o OUT")
    cases.add("fit/atlas", f"fit {gold} --atlas --picture -o OUT")
    cases.add("fit/full-circle", "fit out/synth/polished-metal/polished-metal.binary --constraint free --joint --picture -o OUT")
    files = FAMILIES["embedded"][0]
    shards = [f"fit {gold} in/made/plain.binary {satin} --shard {n}/2 -o OUT" for n in (1, 2)]
    cases.add("fit/shards-and-merge", *shards, "merge OUT", quick=True)
    cases.add("fit/resume", f"fit {gold} -o OUT", f"fit {files} --resume -o OUT", f"fit {files} --resume --loss l2 -o OUT")
    bad = "in/bad/cut.binary in/bad/nan.binary in/bad/unmeasured.binary in/bad/few.binary"
    cases.add("fit/bad-among-good", f"fit {gold} {bad} {satin} -o OUT", quick=True)
    cases.add("fit/bad-in-shards", *(f"fit {gold} {bad} --shard {n}/2 -o OUT" for n in (1, 2)), "merge OUT")
    cases.add("fit/accept-non-finite", "fit in/bad/nan.binary in/bad/few.binary --accept-non-finite --picture -o OUT", quick=True)


ATLAS_OPTIONS = {
    "percentile": "--percentile 60",
    "epsilon": "--epsilon 0.05",
    "delta": "--delta 0.2",
    "delta-0": "--delta 0",
    "no-reflections": "--no-reflections",
    "finest-share": "--finest-share 0.05",
    "max-resolution-512": "--max-resolution 512",
    "ktx2-only": "--formats ktx2 --max-resolution 256",
    "exr-only": "--formats exr --max-resolution 256",
    "exr-float": "--formats exr --exr-samples float --max-resolution 256",
    "rgba-float": "--channels rgba --exr-samples float --max-resolution 256",
    "sample-position": "--sample-position centre --max-resolution 256",
}


def atlas(cases):
    """Layouts and channels on fitted and measured inputs; every option; batches."""
    fits = {name: f"out/fit/embedded/physical-edge/{name}.json" for name in EMBEDDED}
    low = "--max-resolution 256"
    cases.add("atlas/embedded", f"atlas red-satin gold-metallic-paint terracotta {low} -o OUT --preview --format json", quick=True)
    cases.add("atlas/fits-max", "atlas out/fit/embedded/physical-edge -o OUT --preview --format text")
    cases.add("atlas/fits-rgba", f"atlas {fits['gold-metallic-paint']} {fits['red-satin']} --channels rgba -o OUT --preview")
    cases.add("atlas/npf-fits-max", "atlas out/fit/npf/physical-edge -o OUT --format json", needs=["npf"])
    cases.add("atlas/npf-fits-rgba-float", "atlas out/fit/npf/paper-edge --channels rgba --exr-samples float -o OUT", needs=["npf"])
    for channels in ("max", "rgba"):
        line = f"--layout hemisphere --channels {channels} --preview -o OUT"
        cases.add(f"atlas/fits-hemisphere-{channels}", f"atlas {fits['gold-metallic-paint']} {line}", quick=channels == "rgba")
        position = "--sample-position centre"
        measured = "in/measured/satin_rosaline.binary in/measured/chm_mint.binary"
        cases.add(f"atlas/measured-hemisphere-{channels}", f"atlas {measured} {position} {line}", needs=["measured"])
    cases.add("atlas/measured-max", "atlas in/measured --sample-position centre -o OUT --preview --format text", needs=["measured"])
    one = "in/measured/irid_flake_paint1.binary --sample-position centre"
    cases.add("atlas/measured-rgba", f"atlas {one} --channels rgba {low} -o OUT", quick=True, needs=["measured"])
    cases.add("atlas/npf-measured", "atlas in/npf -o OUT --format json", needs=["npf"])
    cases.add("atlas/synth-measured", f"atlas {FAMILIES['embedded'][0]} {low} -o OUT")
    satin = "out/synth/red-satin/red-satin.binary"
    for name, options in ATLAS_OPTIONS.items():
        cases.add(f"atlas/{name}", f"atlas {fits['gold-metallic-paint']} {satin} {options} -o OUT --format json")
    cases.add("atlas/verbose", f"atlas red-satin {low} -v -v -o OUT")
    cases.add("atlas/recursive", f"atlas in/made --recursive {low} -o OUT")
    cases.add("atlas/shards", *(f"atlas {' '.join(EMBEDDED)} {low} --shard {n}/2 -o OUT" for n in (1, 2)))
    cases.add("atlas/resume", f"atlas red-satin {low} -o OUT", f"atlas red-satin terracotta {low} --resume -o OUT --format json")
    bad = f"in/bad/long.binary in/bad/nan.binary red-satin in/bad/cut.json in/bad/unmeasured.binary {low}"
    cases.add("atlas/bad-among-good", f"atlas {bad} -o OUT --format json", quick=True)
    cases.add("atlas/accept-non-finite", f"atlas in/bad/nan.binary --accept-non-finite {low} -o OUT")


MODES = ("adaptive", "adaptive-pixels", "adaptive-counts", "reference")
RENDER_OPTIONS = {
    "target-error": "--target-error 0.1",
    "spp": "--spp 1.5",
    "seed": "--spp 4 --seed 5",
    "pilot-samples": "--spp 4 --pilot-samples 64",
    "sampling-rate": "--spp 4 --sampling-rate 3.1416",
    "frames": "--spp 4 --frames 3 --seed 2",
    "frames-of-reference": "--spp 4 --frames 2 --mode reference",
    "repeat": "--spp 4 --repeat 2",
    "background-black": "--spp 4 --background black",
    "exposure": "--spp 4 --exposure 2.5",
    "prefilter-with-paper": "--spp 4 --prefilter 0.7 --upsample paper --allocation eq9",
    "against-reference": "--spp 4 --reference out/render/ball/reference-reflected-edge-aware/x.exr",
}
LAYERS = ("gbuffer", "light", "pilot", "bandwidth", "decision", "list", "upsampled", "gbuffer,list")


def render(cases):
    """Modes, geometries, fillings, allocations, prefilters on one scene; every other option; scenes of every kind."""
    pictures = "-o OUT/x.exr --png OUT/x.png --stats OUT/x.stats.json"
    everything = f"{pictures} --map OUT/map.png --layers all"
    ball = "render in/scenes/ball.json"
    for mode, geometry, upsample in product(MODES, ("reflected", "operators", "operators-literal"), ("edge-aware", "paper")):
        if mode in MODES[2:] and (geometry, upsample) not in (("reflected", "edge-aware"), ("operators", "paper")):
            continue  # these shade every pixel, and neither word matters
        line = f"{ball} --spp 4 --mode {mode} --geometry {geometry} --upsample {upsample} {everything}"
        cases.add(f"render/ball/{mode}-{geometry}-{upsample}", line, quick=(geometry, upsample) == ("reflected", "edge-aware"))
    for allocation, prefilter in product(("variance", "eq9", "even"), ("never", "always", "1")):
        line = f"{ball} --spp 4 --allocation {allocation} --prefilter {prefilter} {everything}"
        quick = (allocation, prefilter) == ("eq9", "always")
        cases.add(f"render/ball/{allocation}-prefilter-{prefilter}", line, quick=quick)
    for name, options in RENDER_OPTIONS.items():
        cases.add(f"render/ball/{name}", f"{ball} {options} {everything}", quick=name == "against-reference")
    for layers in LAYERS:
        cases.add(f"render/layers/{layers}", f"{ball} --spp 1 --layers {layers} -o OUT/x.exr")
    cases.add("render/verbose", f"{ball} --spp 1 -v -v -o OUT/x.exr")
    cases.add("render/light-map", f"{ball} --spp 1 --light-map OUT/light.exr -o OUT/x.exr", quick=True)
    cases.add("render/large", f"render in/scenes/ball-large.json --spp 2 {everything}")
    cases.add("render/atlases-of-kinds", f"render in/scenes/kinds.json --spp 4 {everything}")
    cases.add("render/atlas-exr", f"render in/scenes/atlas-exr.json --spp 4 {everything}")
    cases.add("render/uniform", f"render in/scenes/uniform.json --spp 4 {everything}")
    cases.add("render/hdr", f"render in/scenes/hdr.json --spp 4 {everything}", quick=True)
    cases.add("render/light-of-exr", f"render in/scenes/light-of-exr.json --spp 4 --light-map OUT/light.exr {pictures}")
    for mesh in ("obj", "gltf", "glb"):
        cases.add(f"render/mesh-{mesh}", f"render in/scenes/mesh-{mesh}.json --spp 4 {everything}", quick=mesh != "glb")
    fits = "--materials out/fit/embedded/physical-edge"
    cases.add("render/materials-folder", f"render in/scenes/fit.json {fits} --spp 4 {everything}", quick=True)
    spot = "render in/scenes/spot.json --spp 4"
    cases.add("render/spot/adaptive", f"{spot} {everything}", quick=True, needs=["scenes"])
    for mode in MODES[1:]:
        cases.add(f"render/spot/{mode}", f"{spot} --mode {mode} {pictures}", needs=["scenes"])
    cases.add("render/spot/operators-prefilter", f"{spot} --geometry operators --prefilter 1 {everything}", needs=["scenes"])
    cases.add("render/spot/light-map", f"{spot} --light-map OUT/light.exr -o OUT/x.exr", needs=["scenes"])
    cases.add("render/spot/gold", f"render in/scenes/spot-gold.json --spp 4 {everything}", needs=["scenes"])
    # a light with negative values, which is refused
    cases.add("failures/render-light-negative", f"render in/scenes/spot-studio.json {pictures}", needs=["scenes"])
    cases.add("render/teapot", f"render in/scenes/teapot.json --spp 4 {everything}", needs=["scenes", "measured"])


def pairs(cases, scenes):
    """The scenes of scripts/pairs, whose materials are published fits or measured files; atlases are computed on the way."""
    for scene in scenes:
        measured = scene.startswith("measured-")
        materials, need = ("in/measured", "measured") if measured else ("in/published", "published")
        line = f"render in/pairs/{scene}.json --materials {materials} -o OUT/x.exr --png OUT/x.png --stats OUT/x.stats.json"
        cases.add(f"render/pairs/{scene}", f"{line} --layers all --map OUT/map.png", needs=[need])


def info(cases):
    """The state of files, for people and for programs."""
    made = FAMILIES["embedded"][0]
    cases.add("info/text", f"info {made}", quick=True)
    cases.add("info/json", f"info {made} --format json", quick=True)
    cases.add("info/colour", f"info {made.split()[0]} --color always --sample-position centre")
    for family in ("npf", "measured"):
        files, right, needs = FAMILIES[family]
        names = " ".join(f"{files}/{name}.binary" for name in (RECONSTRUCTED if family == "npf" else MEASURED))
        for form in ("text", "json"):
            cases.add(f"info/{family}-{form}", f"info {names} --format {form} --sample-position {right}", needs=needs)
    bad = "in/bad/nan.binary in/bad/few.binary in/bad/unmeasured.binary in/bad/cut.binary"
    for form in ("text", "json"):
        cases.add(f"info/bad-{form}", f"info {bad} --format {form}")


MEASURED = ("cc_ibiza_sunset", "chm_mint", "irid_flake_paint1", "paper_white", "satin_rosaline", "vch_silk_blue")


def compare(cases):
    """Equal, different and incomparable fits: text, JSON and exit code."""
    ours = "out/fit/embedded/physical-edge"
    short = "out/fit/embedded/max-iterations/red-satin.json"
    for form in ("text", "json"):
        cases.add(f"compare/equal-{form}", f"compare {ours} {ours} --format {form}", quick=True)
        cases.add(f"compare/different-{form}", f"compare {short} {ours}/red-satin.json --format {form}", quick=True)
        cases.add(f"compare/free-{form}", f"compare {ours} out/fit/embedded/free-edge --format {form}")
        cases.add(f"compare/centre-{form}", f"compare {ours} out/fit/embedded/physical-centre --format {form}")
        starts = "out/fit/npf/physical-edge out/fit/npf/starts"
        cases.add(f"compare/starts-{form}", f"compare {starts} --format {form}", needs=["npf"])
        npf = "out/fit/npf/max-iterations out/fit/npf/physical-edge"
        cases.add(f"compare/iterations-{form}", f"compare {npf} --two-sided --format {form}", needs=["npf"])
        cases.add(f"compare/bars-{form}", f"compare {npf} --cost-warn 1 --cost-fail inf --curve-warn 0.1 --curve-fail 10 "
                  f"--errors-warn 0.1 --errors-fail 10 --format {form}", needs=["npf"])  # fmt: skip
        joint = "out/fit/measured/physical-centre out/fit/measured/physical-centre-joint"
        cases.add(f"compare/joint-{form}", f"compare {joint} --format {form}", needs=["measured"])
    one = f"{ours}/red-satin.json"
    cases.add("compare/to-a-file", f"compare {one} {one} --format json -o OUT/x.json")
    cases.add("compare/missing", f"compare {ours} in/made")


def texts(cases):
    """Schemas, shaders, help, completions, manual pages; the demo."""
    for name in ("fit", "summary", "info", "atlas", "scene", "render"):
        cases.add(f"schema/{name}", f"schema {name}", quick=True)
    for language in ("wgsl", "glsl"):
        cases.add(f"export/{language}", f"export {language}", f"export {language} -o OUT/x.{language}", quick=True)
    cases.add("help/brdfit", "--help", "-h", "help", "--version", quick=True)
    for name in COMMANDS:
        cases.add(f"help/{name}", f"{name} --help", f"{name} -h", quick=True)
        cases.add(f"help/man-{name}", f"man {name}", quick=True)
    cases.add("help/man-brdfit", "man", quick=True)
    for shell in ("bash", "elvish", "fish", "powershell", "zsh"):
        cases.add(f"help/completions-{shell}", f"completions {shell}", quick=True)
    cases.add("demo/default", "demo -o OUT", quick=True)
    for name in EMBEDDED[1:]:
        cases.add(f"demo/{name}", f"demo -o OUT --material {name} --quiet")


FAILURES = {
    "no-command": "",
    "unknown-command": "frobnicate",
    "unknown-option": "fit in/bad/cut.binary --frobnicate",
    "no-input": "fit",
    "fit-missing": "fit in/bad/missing.binary -o OUT/x",
    "fit-cut": "fit in/bad/cut.binary -o OUT/x",
    "fit-long": "fit in/bad/long.binary",
    "fit-empty": "fit in/bad/empty.binary",
    "fit-dimensions": "fit in/bad/dimensions.binary",
    "fit-big-endian": "fit in/bad/big-endian.binary",
    "fit-xz": "fit in/bad/packed.binary",
    "fit-nan": "fit in/bad/nan.binary",
    "fit-unmeasured": "fit in/bad/unmeasured.binary",
    "fit-empty-folder": "fit in/bad/folder -o OUT/x",
    "fit-same-name": "fit in/bad/few.binary in/made/deep/few.binary -o OUT/x",
    "fit-several-without-folder": "fit in/bad/few.binary in/made/plain.binary",
    "fit-cutoff": "fit in/made/plain.binary --cutoff-theta-h 95",
    "fit-start": "fit in/made/plain.binary --start 0,1",
    "fit-loss": "fit in/made/plain.binary --loss l1",
    "fit-shard": "fit in/made/plain.binary --shard 3/2 -o OUT/x",
    "fit-panel-of-nothing": "fit in/made/plain.binary --no-hash --resume -o OUT/x",
    "atlas-unknown": "atlas red-satn -o OUT/x",
    "atlas-percentile": "atlas red-satin -o OUT/x --percentile 120",
    "atlas-resolution": "atlas red-satin -o OUT/x --max-resolution 300",
    "atlas-cut": "atlas in/bad/cut.json -o OUT/x",
    "render-missing": "render in/scenes/missing.json -o OUT/x.exr",
    "render-not-json": "render in/bad/cut.json -o OUT/x.exr",
    "render-unknown-member": "render in/bad/unknown-member.json -o OUT/x.exr",
    "render-unknown-material": "render in/bad/unknown-material.json -o OUT/x.exr",
    "render-out-of-range": "render in/bad/out-of-range.json -o OUT/x.exr",
    "render-missing-mesh": "render in/bad/missing-mesh.json -o OUT/x.exr",
    "render-bad-mesh": "render in/bad/bad-mesh.json -o OUT/x.exr",
    "render-bad-light": "render in/bad/bad-light.json -o OUT/x.exr",
    "render-bad-texture": "render in/bad/bad-texture.json -o OUT/x.exr",
    "render-missing-fit": "render in/scenes/fit.json -o OUT/x.exr",
    "render-reference": "render in/scenes/uniform.json -o OUT/x.exr --reference in/bad/cut.json",
    "render-output-folder": "render in/scenes/uniform.json -o in/bad/folder",
    "render-spp": "render in/scenes/uniform.json -o OUT/x.exr --spp 0",
    "render-contradiction": "render in/scenes/uniform.json -o OUT/x.exr --mode reference --target-error 0.1",
    "info-folder": "info in/bad/folder",
    "info-missing": "info in/bad/missing.binary --format json",
    "synth-unknown": "synth red-satn -o OUT/x.binary",
    "synth-phi-bins": "synth red-satin -o OUT/x.binary --phi-bins 90",
    "synth-noise": "synth red-satin -o OUT/x.binary --noise -1",
    "synth-not-a-fit": "synth in/scenes/uniform.json -o OUT/x.binary",
    "compare-missing": "compare in/bad/missing.json in/made/parameters.json",
    "compare-not-a-fit": "compare in/made/parameters.json in/made/parameters.json",
    "merge-nothing": "merge in/bad/folder",
    "schema-unknown": "schema picture",
    "export-unknown": "export hlsl",
    "output-in-missing-folder": "export wgsl -o OUT/missing/x.wgsl",
    "demo-unknown": "demo -o OUT/x --material gold",
}


def failures(cases):
    """What a wrong input or option says, and with which exit code."""
    for name, line in FAILURES.items():
        cases.add(f"failures/{name}", line, quick=True)


def all_cases(pair_names):
    """Every case, each after those whose outputs it reads."""
    cases = Cases()
    for part in (synth, fit, atlas, render):
        part(cases)
    pairs(cases, pair_names)
    for part in (info, compare, texts, failures):
        part(cases)
    names = [case.name for case in cases]
    assert len(set(names)) == len(names), "two cases of one name"
    assert not any(other.startswith(f"{name}/") for name in names for other in names), "a case inside of another"
    return cases
