"""Mitsuba 3's render tests that have a variance image, in every variant (run by references.py).

Each test is rendered with as many samples as Mitsuba takes (2,000,000 in all), and `kaustika compare --variance` tests every
pixel as Mitsuba does, and means over tiles and over the picture. Tiles and means of all surfaces, or all media, in one variant
have a significance of 1 % together (Sidak).
"""
import json
import math
import os

DATA = "mitsuba3/mitsuba-data-tests/tests/scenes"
VARIANTS = {"rgb": ["--rgb"], "spectral": ["--spectral"], "spectral_polarized": ["--spectral", "-p", "polarized=true"]}
SAMPLES = 2000000
SPHERES = ["arealight", "bumpmap", "constant", "envmap", "normalmap", "normalmap_identity_roughconductor", "roughdielectric",
           "roughplastic_linear", "textured_diffuse", "texturedprincipled1", "texturedprincipledthin"]
IN_MEDIA = ["hetero_sigmat", "hetero_spectral_sigmat_no_scattering", "homo_area_light", "homo_dielectric_envmap",
            "homo_null_envmap", "homo_obj_inside_medium", "homo_spectral_sigmat", "surf_area_light"]
# folder, name, integrator, variants
SURFACES = [("bsdf_spheres", name, "path", list(VARIANTS)) for name in SPHERES]
SURFACES += [("orthographic_sensor", "orthographic", "path", list(VARIANTS)), ("spot_light", "spot", "direct", list(VARIANTS))]
MEDIA = [("participating_media", name, "volpathmis" if name == "homo_spectral_sigmat" else "volpath", ["rgb", "spectral"])
         for name in IN_MEDIA]

# What fails by the reference's fault, and the section of docs/references.md that says why.
EXPLAINED = {(name, "rgb"): "white" for name in ("constant", "orthographic")}
EXPLAINED.update({(test[1], variant): "sky" for test in SURFACES + MEDIA for variant in test[3][1:]
                  if test[1] not in ("arealight", "constant", "orthographic", "spot", "homo_area_light")})
EXPLAINED.update({("homo_spectral_sigmat", variant): "mean" for variant in ("rgb", "spectral")})
# The references' white in RGB: their version of Mitsuba projected D65 to this colour, later ones and we to (1, 1, 1).
WHITE = "1.00108409,0.99970782,0.99970305"

HEAD = "\n| test | variant | verdict | per pixel | tiles | mean | chi²/dof | mean ratio |\n|---|---|---|---|---|---|---|---|"


def sidak(count):
    """Significance of each of `count` tests that have 1 % together."""
    return -math.expm1(math.log1p(-0.01) / count)


def mark(ok):
    return "pass" if ok else "**fail**"


def one(run, scenes, folder, test, variant, extra=(), note=""):
    """Renders and compares one test, prints its row and says whether it passed; None where the scene is missing."""
    group, name, integrator, _ = test
    base = os.path.join(scenes, DATA, group)
    scene = os.path.join(base, "test_%s_%s.xml" % (name, integrator))
    if not os.path.exists(scene):
        return None
    reference = os.path.join(base, "refs", "test_%s_ref_%s" % (name, variant))
    spp = str(SAMPLES // (200 * 120 if group == "orthographic_sensor" else 48 * 48))
    out = os.path.join(folder, "test.exr")
    run("render", scene, "-o", out, "--spp", spp, "--sampler", "independent", "--quiet", *VARIANTS[variant], *extra)
    r = json.loads(run("compare", out, reference + ".exr", "--variance", reference + "_var.exr", "--spp", spp, "--json"))
    family = 2 * 3 * len(MEDIA if test in MEDIA else SURFACES)
    tiles = r["tiles"]["min_p"] > sidak(r["tiles"]["tiles"] * family)
    z = max(map(abs, r["mean"]["z"]))
    mean = math.erfc(z / math.sqrt(2)) > sidak(family)
    passed = r["pixels"]["accept"] and tiles and mean
    reason = EXPLAINED.get((name, variant))
    verdict = "pass" if passed else "**fail**" if extra or not reason else "[%s](#%s)" % (reason, reason)
    print("| %s%s | %s | %s | %s (%.4f) | %s (p %.2g) | %s (z %.2f) | %.3f | %.5f |"
          % (name, note, variant, verdict, mark(r["pixels"]["accept"]), r["pixels"]["passed"], mark(tiles), r["tiles"]["min_p"],
             mark(mean), z, r["chi2_per_dof"], r["mean_ratio"]), flush=True)
    return passed


def run_all(run, scenes, folder, tests, sky):
    """Runs tests in all their variants; `sky` is the museum as the spectral references show it, or None. Returns those that
    failed and are not explained."""
    print(HEAD)
    results = [(test, variant, one(run, scenes, folder, test, variant)) for test in tests for variant in test[3]]
    failed = [(test, variant) for test, variant, passed in results if passed is False]
    missed = [(test[1], variant) for test, variant in failed if (test[1], variant) not in EXPLAINED]
    again = {"white": ["--environment", WHITE], "sky": ["--environment", sky] if sky else None}
    print(HEAD)
    for test, variant in failed:
        reason = EXPLAINED.get((test[1], variant))
        if again.get(reason) and one(run, scenes, folder, test, variant, again[reason], ", the reference's " + reason) is False:
            missed.append((test[1], variant + ", with the reference's " + reason))
    return missed
