#!/usr/bin/env python3
"""Renders other people's scenes and compares them with their references (run by hand).

    scripts/references.py SCENES [--quick] [--media]

SCENES is a folder laid out as `pbrt-v4/NAME/...`, `mitsuba3/NAME/...`, `mitsuba06/NAME/...`;
a scene that is missing is left out. Prints one table in Markdown for pictures with a reference
image, one for the tests with a variance image, one for those of media, in RGB and spectral (`--media`: these
and the volumetric caustic alone). Build first: cargo build --release.

Mean ratios and their standard errors come from four renders with different seeds. The tests
take the per-pixel test as Mitsuba has it; tile and mean tests share one significance of 1 %
over the whole family (Sidak).
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
KAUSTIKA = os.path.join(ROOT, "target", "release", "kaustika")
SCENES = sys.argv[1]
QUICK = "--quick" in sys.argv
MEDIA_ONLY = "--media" in sys.argv
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
# Paths as long as the reference's, as far as the tiles tell that no caustic lights.
MEDIA_PICTURES = [
    ("pbrt-v4/volumetric-caustic", "scene-v4.pbrt", "TungstenRender.exr", 8, 2.0, ["-p", "max_depth=4", "--rgb"]),
]
DATA = "mitsuba3/mitsuba-data-tests/tests/scenes"
SPHERES = ["arealight", "bumpmap", "constant", "envmap", "normalmap", "normalmap_identity_roughconductor",
           "roughdielectric", "roughplastic_linear", "textured_diffuse", "texturedprincipled1"]
# The references' white: their version of Mitsuba projected D65 to this colour, later ones and we to (1, 1, 1).
WHITE = ["--environment", "1.00108409,0.99970782,0.99970305"]
TESTS = [("bsdf_spheres", name, "path", []) for name in SPHERES]
TESTS += [("orthographic_sensor", "orthographic", "path", []), ("spot_light", "spot", "direct", [])]
EXPERIMENTS = [("bsdf_spheres", "constant", "path", WHITE), ("orthographic_sensor", "orthographic", "path", WHITE),
               ("bsdf_spheres", "texturedprincipledthin", "path", [])]
MEDIA = [("participating_media", name, "volpathmis" if name == "homo_spectral_sigmat" else "volpath", mode)
         for mode in ("rgb", "spectral")
         for name in ("hetero_sigmat", "hetero_spectral_sigmat_no_scattering", "homo_area_light", "homo_dielectric_envmap",
                      "homo_null_envmap", "homo_obj_inside_medium", "homo_spectral_sigmat", "surf_area_light")]


def run(*args):
    done = subprocess.run([KAUSTIKA, *args], capture_output=True, text=True)
    if done.returncode not in (0,):
        raise SystemExit("kaustika %s failed:\n%s" % (" ".join(args), done.stderr))
    return done.stdout


def picture(folder, scene, reference, spp, bound, extra, label=None):
    if not os.path.exists(scene) or not os.path.exists(reference):
        return
    ratios, errors, seconds = [], [], 0.0
    for seed in range(SEEDS):
        out = os.path.join(folder, "picture%d.exr" % seed)
        start = time.time()
        run("render", scene, "-o", out, "--spp", str(max(1, spp // 4) if QUICK else spp), "--seed", str(seed + 1),
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


def test(folder, group, name, method, extra, family, mode="rgb"):
    base = os.path.join(SCENES, DATA, group)
    scene = os.path.join(base, "test_%s_%s.xml" % (name, method))
    if not os.path.exists(scene):
        return
    reference = os.path.join(base, "refs", "test_%s_ref_%s.exr" % (name, mode))
    pixels = 200 * 120 if group == "orthographic_sensor" else 48 * 48
    spp = str(2000000 // pixels)
    out = os.path.join(folder, name + ".exr")
    run("render", scene, "-o", out, "--spp", spp, "--sampler", "independent", "--quiet", "--" + mode, *extra)
    r = json.loads(run("compare", out, reference, "--variance", reference.replace(".exr", "_var.exr"),
                       "--spp", spp, "--json"))
    sidak = lambda count: -math.expm1(math.log1p(-0.01) / (family * count))
    tiles = r["tiles"]["min_p"] > sidak(2 * 3 * r["tiles"]["tiles"])
    z = max(abs(v) for v in r["mean"]["z"])
    mean = math.erfc(z / math.sqrt(2)) > sidak(2 * 3)
    mark = lambda ok: "pass" if ok else "**fail**"
    print("| %s%s | %s (%.4f) | %s (p %.2g) | %s (z %.2f) | %.3f | %.5f |"
          % (name if mode == "rgb" else name + ", " + mode, " with the references' white" if extra else "", mark(r["pixels"]["accept"]), r["pixels"]["passed"],
             mark(tiles), r["tiles"]["min_p"], mark(mean), z, r["chi2_per_dof"], r["mean_ratio"]), flush=True)


with tempfile.TemporaryDirectory() as folder:
    print("| scene | seeds x spp | mean ratio | standard error | bound | within | relMSE | seconds |\n|---|---|---|---|---|---|---|---|")
    for name, scene, reference, spp, bound, extra in ([] if MEDIA_ONLY else PICTURES) + MEDIA_PICTURES:
        base = os.path.join(SCENES, name)
        picture(folder, os.path.join(base, scene), os.path.join(base, reference), spp, bound, extra, name)
        if name.endswith("veach-mis"):
            for model in (["beckmann", "1"], ["beckmann", "0.3"]):
                made = os.path.join(folder, "veach-mis")
                subprocess.run([sys.executable, os.path.join(ROOT, "scripts", "veach_mis_to_mitsuba.py"),
                                os.path.join(base, scene), made, *model], check=True)
                picture(folder, os.path.join(made, "scene.xml"), os.path.join(base, reference), spp, bound, [],
                        "veach-mis, Beckmann, reflectance x %s" % model[1])
    HEAD = "\n| test | per pixel | tiles | mean | chi²/dof | mean ratio |\n|---|---|---|---|---|---|"
    if not MEDIA_ONLY:
        print(HEAD)
        for group, name, method, extra in TESTS + EXPERIMENTS:
            test(folder, group, name, method, extra, len(TESTS))
    print(HEAD)
    for group, name, method, mode in MEDIA:
        test(folder, group, name, method, [], len(MEDIA), mode)
