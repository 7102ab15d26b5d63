"""Renders a scene with Mitsuba 3 into a reference and the variance of one sample of each pixel, both in linear sRGB.

    mitsuba_references.py SCENE.xml FOLDER VARIANT... [-Dname=value ...]

VARIANT is rgb, spectral or spectral_polarized. Writes NAME_VARIANT.exr, the mean of BATCHES renders of SPP samples a pixel with
different seeds, and NAME_VARIANT_var.exr, SPP times the variance between them. Needs the package mitsuba and LLVM
(DRJIT_LIBLLVM_PATH).
"""
import os
import sys

import mitsuba as mi
import numpy as np

BATCHES, SPP = 256, 256

scene_path, folder = sys.argv[1:3]
defines = dict(word[2:].split("=") for word in sys.argv[3:] if word.startswith("-D"))
name = os.path.splitext(os.path.basename(scene_path))[0]
for variant in [word for word in sys.argv[3:] if not word.startswith("-D")]:
    mi.set_variant("llvm_ad_" + variant)
    scene = mi.load_file(scene_path, **defines)
    batches = np.array([np.array(mi.render(scene, spp=SPP, seed=seed))[..., :3] for seed in range(BATCHES)], dtype=np.float64)
    out = os.path.join(folder, "%s_%s" % (name, variant))
    for image, path in ((batches.mean(0), out + ".exr"), (SPP * batches.var(0, ddof=1), out + "_var.exr")):
        mi.Bitmap(image.astype(np.float32)).write(path)
    error = np.sqrt(batches.mean((1, 2)).var(0, ddof=1) / BATCHES)
    print("Mitsuba %s, %s, %s: mean %s, standard error %s" % (mi.__version__, name, variant, batches.mean((0, 1, 2)), error))
