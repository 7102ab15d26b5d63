"""Renders one scene again and again with Mitsuba 3 for efficiency.py, its kernels compiled before the first answer.

    mitsuba_worker.py SCENE.xml VARIANT THREADS SPP

Says `{"load": s, "first": s, "version": ..., "spp": ...}` when it is ready: seconds of loading and of a first render, which
compiles; the samples a pixel that the sampler makes of SPP. Then, for every line "SEED FILE.npy" it is given, renders with
that seed, writes the picture (linear RGB) and says `{"seconds": s}`: rendering and developing the film, synchronised.
Variants that compile need LLVM's library: DRJIT_LIBLLVM_PATH.
"""
import json
import sys
import time

import drjit as dr
import mitsuba as mi
import numpy as np

scene_path, variant, threads, spp = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
mi.set_variant(variant)
mi.set_log_level(mi.LogLevel.Error)
dr.set_thread_count(max(2, threads))  # Mitsuba 3.9.1 waits for ever when it reads an EXR with one thread
start = time.perf_counter()
scene = mi.load_file(scene_path)
load = time.perf_counter() - start
dr.set_thread_count(threads)


def render(seed):
    start = time.perf_counter()
    image = scene.integrator().render(scene, seed=seed, spp=spp)
    if not variant.startswith("scalar"):
        dr.eval(image)
        dr.sync_thread()
    return time.perf_counter() - start, image


def say(**answer):
    print(json.dumps(answer), flush=True)


first, _ = render(1 << 20)
say(load=load, first=first, version=mi.__version__, spp=scene.sensors()[0].sampler().sample_count())
for line in sys.stdin:
    seed, out = line.split(maxsplit=1)
    seconds, image = render(int(seed))
    np.save(out.strip(), np.array(image, dtype=np.float32)[..., :3])
    say(seconds=seconds)
