#!/usr/bin/env python3
"""Error of each sampler at equal samples a pixel (run by hand).

    scripts/samplers.py SCENE... [-- FURTHER RENDER ARGUMENTS]

The word `builtin` stands for the built-in scene. Prints relMSE (without the 0.1 % worst pixels) against a render with
many samples, mean over four seeds, as one Markdown table a scene. Build first: cargo build --release.
"""
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
KAUSTIKA = os.path.join(ROOT, "target", "release", "kaustika")
SAMPLERS = ["independent", "stratified", "halton", "sobol", "zsobol", "pmj02"]
COUNTS = [4, 16, 64]
args = sys.argv[1:]
cut = args.index("--") if "--" in args else len(args)
scenes, extra = args[:cut], args[cut + 1:]


def render(scene, out, spp, sampler, seed):
    named = [] if scene == "builtin" else [scene]
    subprocess.run([KAUSTIKA, "render", *named, "-o", out, "--spp", str(spp), "--sampler", sampler,
                    "--seed", str(seed), "--resolution", "96x96", "--filter", "box", "--quiet", *extra], check=True)


with tempfile.TemporaryDirectory() as folder:
    for scene in scenes:
        reference = os.path.join(folder, "reference.exr")
        render(scene, reference, 4096, "sobol", 1000)
        print("\n%s\n\n| sampler | %s |\n|---|%s" % (os.path.basename(os.path.dirname(scene)) or scene,
              " | ".join("%d spp" % n for n in COUNTS), "---|" * len(COUNTS)))
        for sampler in SAMPLERS:
            row = []
            for spp in COUNTS:
                errors = []
                for seed in range(1, 5):
                    out = os.path.join(folder, "out.exr")
                    render(scene, out, spp, sampler, seed)
                    found = subprocess.run([KAUSTIKA, "compare", out, reference, "--json"],
                                           check=True, capture_output=True, text=True)
                    errors.append(json.loads(found.stdout)["rel_mse_trimmed"])
                row.append(sum(errors) / len(errors))
            print("| %s | %s |" % (sampler, " | ".join("%.4g" % v for v in row)), flush=True)
