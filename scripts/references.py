#!/usr/bin/env python3
"""Renders other people's scenes and compares them with their references (run by hand).

    scripts/references.py SCENES [--quick] [--pictures | --tests | --media] [--sky FILE]

SCENES is a folder laid out as `pbrt-v4/NAME/...`, `mitsuba3/NAME/...`, `mitsuba06/NAME/...`;
a scene that is missing is left out. Prints one table in Markdown for pictures with a reference image and one for the tests
with a variance image, in RGB, spectral and polarized (variance_tests.py); then those that failed by the
reference's fault once more, with that fault put into the scene. `--pictures` and `--tests` make either alone, `--media` the
volumetric caustic and the tests of media. FILE is the tests' environment map as the spectral references show it: what
mitsuba_sky.py writes. The exit code is 1 if a test fails that docs/references.md does not explain.
Build first: cargo build --release.

Mean ratios and their standard errors come from four renders with different seeds.
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import time

import variance_tests

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
KAUSTIKA = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release", "kaustika")
SCENES = sys.argv[1]
QUICK, PICTURES_ONLY, TESTS_ONLY, MEDIA_ONLY = (word in sys.argv for word in ("--quick", "--pictures", "--tests", "--media"))
SKY = sys.argv[sys.argv.index("--sky") + 1] if "--sky" in sys.argv else None
SEEDS = 4

# name, scene, reference, spp a seed, bound of the mean ratio in %, further arguments
PICTURES = [
    ("mitsuba3/cornell-box", "scene_v3.xml", "scene_v3.exr", 8, 0.5, []),
    ("pbrt-v4/veach-mis", "scene-v4.pbrt", "TungstenRender.exr", 8, 1.0, ["-p", "max_depth=1"]),
    ("pbrt-v4/veach-bidir", "scene-v4.pbrt", "TungstenRender.exr", 16, 1.0, ["-p", "max_depth=6"]),
    ("mitsuba06/living-room", "scene.xml", "TungstenRender.exr", 4, 2.0, []),
    ("mitsuba3/staircase2", "scene.xml", "TungstenRender.exr", 2, None, []),
    ("pbrt-v4/dining-room", "scene-v4.pbrt", "TungstenRender.exr", 2, None, []),
]
# Paths as long as the reference's, as far as the tiles tell. The lamp, which the crop leaves out with all above
# it, is too dark in the reference: docs/references.md.
MEDIA_PICTURES = [
    ("pbrt-v4/volumetric-caustic", "scene-v4.pbrt", "TungstenRender.exr", 4, 2.0,
     ["-m", "bdpt", "-p", "max_depth=4", "--rgb", "--crop", "0,104,1024,1024"]),
]


def run(*args):
    done = subprocess.run([KAUSTIKA, *args], capture_output=True, text=True)
    if done.returncode not in (0,):
        raise SystemExit("kaustika %s failed:\n%s" % (" ".join(args), done.stderr))
    return done.stdout


def picture(folder, scene, reference, spp, bound, extra, label=None):
    if not os.path.exists(scene) or not os.path.exists(reference):
        return
    spp = max(1, spp // 4) if QUICK else spp
    ratios, errors, seconds = [], [], 0.0
    for seed in range(SEEDS):
        out = os.path.join(folder, "picture%d.exr" % seed)
        start = time.time()
        run("render", scene, "-o", out, "--spp", str(spp), "--seed", str(seed + 1),
            "--sampler", "independent", "--quiet", *extra)
        seconds += time.time() - start
        result = json.loads(run("compare", out, reference, "--json"))
        ratios.append(result["mean_ratio"])
        errors.append(result["rel_mse"])
    mean = sum(ratios) / SEEDS
    error = math.sqrt(sum((r - mean) ** 2 for r in ratios) / (SEEDS - 1) / SEEDS)
    limit = "eye" if bound is None else "%.1f %%" % bound
    verdict = "" if bound is None else ("yes" if abs(mean - 1) * 100 <= bound else "**no**")
    print("| %s | %d x %d | %.5f | %.5f | %s | %s | %.3g | %.0f |"
          % (label, SEEDS, spp, mean, error, limit, verdict, sum(errors) / SEEDS, seconds), flush=True)


with tempfile.TemporaryDirectory() as folder:
    pictures = [] if TESTS_ONLY else MEDIA_PICTURES if MEDIA_ONLY else PICTURES + MEDIA_PICTURES
    if pictures:
        print("| scene | seeds x spp | mean ratio | standard error | bound | within | relMSE | seconds |")
        print("|---|---|---|---|---|---|---|---|")
    for name, scene, reference, spp, bound, extra in pictures:
        base = os.path.join(SCENES, name)
        picture(folder, os.path.join(base, scene), os.path.join(base, reference), spp, bound, extra, name)
        if name.endswith("veach-mis"):
            for model in (["beckmann", "1"], ["beckmann", "0.3"]):
                made = os.path.join(folder, "veach-mis")
                subprocess.run([sys.executable, os.path.join(ROOT, "scripts", "veach_mis_to_mitsuba.py"),
                                os.path.join(base, scene), made, *model], check=True)
                picture(folder, os.path.join(made, "scene.xml"), os.path.join(base, reference), spp, bound, [],
                        "veach-mis, Beckmann, reflectance x %s" % model[1])
    tests = [] if PICTURES_ONLY else variance_tests.MEDIA if MEDIA_ONLY else variance_tests.SURFACES + variance_tests.MEDIA
    missed = variance_tests.run_all(run, SCENES, folder, tests, SKY) if tests else []
for name, variant in missed:
    print("not explained: %s, %s" % (name, variant), file=sys.stderr)
sys.exit(1 if missed else 0)
