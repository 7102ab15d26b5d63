#!/usr/bin/env python3
"""Error times time of the path tracer beside Mitsuba 3's, on a Mitsuba scene, or LuxCore's (run by hand).

    scripts/efficiency.py SCENE.xml [-D KEY=VALUE]... [--spp 64] [--depth D] [--rr-depth R] [--resolution WxH] [--threads 2]
        [--rounds 5] [--samplers sobol] [--peers independent multijitter] [--variant llvm_ad_rgb] [--reference FILE.exr]
        [--kaustika PROGRAM] [--lock FILE]... [--json OUT]
    scripts/efficiency.py dining-room/scene-v4.pbrt --luxcore PYTHON --resolution WxH [as above]

Kaustika renders with each of --samplers, Mitsuba with each of --peers; both in RGB with a box filter, and equal samples and
depth (scene_for_both.py says what is changed in the scene, for both; luxcore_worker.py what differs there,
PYTHON being one that has pyluxcore). Paths end by each one's own Russian roulette, from --rr-depth or the file's depth on, if either is given. In each round every one renders once, with a seed of its own, in turn. Depths count
as Mitsuba's in an XML file, as pbrt's in a pbrt file. A round's figure is

    relMSE x seconds,   relMSE = mean (x - r)² / (r² + 0.01)

over pixels and channels; trimmed: without the 0.1 % of pixels of largest error. r is the reference, or, without one, the
mean of this renderer's other rounds: then relMSE is multiplied by (R-1)/R, because the mean of R-1 others has an error of
its own, 1/(R-1) of a round's. That makes MSE unbiased, and relMSE too but for the noise in its denominator; it sees no
bias, which the mean ratio of the two renderers' pictures is shown for.

Seconds: of Kaustika `seconds.render` of --stats, the wall time of all passes with their sums, variances and
error estimates; without loading, building, and the writing of files. Of Mitsuba the wall time of a
render and its film's development, without loading, and with all kernels compiled (mitsuba_worker.py). Of LuxCore its
engine's own clock.

--lock: files to hold (flock) during a round; between two rounds they are free for others.
Runs in a Python that has mitsuba and numpy. Build first: cargo build --release.
"""
import argparse
import contextlib
import fcntl
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import scene_for_both

HERE = os.path.dirname(os.path.abspath(__file__))
LUXCORE_RR_DEPTH = 3  # LuxCore's default
KAUSTIKA = os.path.join(os.path.dirname(HERE), "target", "release", "kaustika")


def arguments():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("scene")
    ap.add_argument("-D", dest="defines", action="append", default=[], metavar="KEY=VALUE")
    ap.add_argument("--spp", type=int, default=64)
    ap.add_argument("--depth", type=int)
    ap.add_argument("--rr-depth", type=int)
    ap.add_argument("--resolution", type=lambda s: tuple(map(int, s.split("x"))))
    ap.add_argument("--threads", type=int, default=2)
    ap.add_argument("--rounds", type=int, default=5)
    ap.add_argument("--samplers", nargs="+", default=["sobol"])
    ap.add_argument("--peers", nargs="*", default=["independent", "multijitter"])
    ap.add_argument("--variant", default="llvm_ad_rgb")
    ap.add_argument("--luxcore", metavar="PYTHON")
    ap.add_argument("--reference")
    ap.add_argument("--kaustika", default=KAUSTIKA)
    ap.add_argument("--lock", action="append", default=[])
    ap.add_argument("--json")
    return ap.parse_args()


@contextlib.contextmanager
def alone(a):
    with contextlib.ExitStack() as stack:
        for path in a.lock:
            fcntl.flock(stack.enter_context(open(path, "w")), fcntl.LOCK_EX)
        yield


class Kaustika:
    def __init__(self, a, scene, sampler):
        self.a, self.sampler, self.spp = a, sampler, a.spp
        self.name = "Kaustika, %s" % sampler
        self.scene = scene.of_sampler("independent")
        self.changes = scene.changes
        self.folder = scene.folder

    def render(self, seed):
        image, stats = (os.path.join(self.folder, f) for f in ("image.pfm", "stats.json"))
        subprocess.run([self.a.kaustika, "render", self.scene, "-q", "--rgb", "--spp", str(self.spp), "--seed", str(seed),
                        "--threads", str(self.a.threads), "--sampler", self.sampler, "-o", image, "--stats", stats,
                        *self.changes], check=True, stderr=subprocess.DEVNULL)
        with open(stats) as f:
            return json.load(f)["seconds"]["render"], pfm(image)


class Peer:
    """A renderer that is loaded and waits for seeds (mitsuba_worker.py says how it speaks)."""

    def __init__(self, name, folder, command):
        self.name, self.folder = name, folder
        self.process = subprocess.Popen(list(map(str, command)), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True)
        self.spp = self.answer()["spp"]

    def answer(self):
        for line in self.process.stdout:
            if line.startswith("{"):  # the renderer may print too
                return json.loads(line)
        raise SystemExit(self.name + " ended")

    def render(self, seed):
        image = os.path.join(self.folder, "image.npy")
        self.process.stdin.write("%d %s\n" % (seed, image))
        self.process.stdin.flush()
        answer = self.answer()
        self.spp = answer.get("spp", self.spp)
        return answer["seconds"], np.load(image).astype(np.float64)


class MitsubaScene:
    changes = []

    def __init__(self, a, folder):
        self.a, self.folder = a, folder
        _, (self.depth, self.rr_depth), self.size = self.write("independent")

    def write(self, sampler):
        a = self.a
        defines = [d.split("=", 1) for d in a.defines]
        return scene_for_both.write(a.scene, self.folder, defines, sampler, a.spp, a.depth, a.rr_depth, a.resolution,
                                    sampler + ".xml")

    def of_sampler(self, sampler):
        return self.write(sampler)[0]

    def peers(self):
        worker = os.path.join(HERE, "mitsuba_worker.py")
        return [Peer("Mitsuba %s, %s" % (self.a.variant, s), self.folder,
                     [sys.executable, worker, self.of_sampler(s), self.a.variant, self.a.threads, self.a.spp]) for s in self.a.peers]


class PbrtScene:
    def __init__(self, a, folder):
        self.a, self.folder, self.size = a, folder, a.resolution
        self.depth, self.rr_depth = a.depth or 65, a.rr_depth
        self.text_size = "%dx%d" % self.size
        self.changes = ["--resolution", self.text_size, "--filter", "box", "-p", "max_depth=%d" % self.depth]
        if self.rr_depth:
            self.changes += ["-p", "rr_depth=%d" % self.rr_depth]

    def of_sampler(self, _):
        return self.a.scene

    def peers(self):
        command = [self.a.luxcore, os.path.join(HERE, "luxcore_worker.py"), self.a.scene, self.text_size, self.depth,
                   self.rr_depth or LUXCORE_RR_DEPTH, self.a.threads, self.a.spp]
        return [Peer("LuxCore, sobol", self.folder, command)] if self.a.luxcore else []


def pfm(path):
    with open(path, "rb") as f:
        kind, size, scale = (f.readline().split() for _ in range(3))
        width, height = map(int, size)
        order = "<f4" if float(scale[0]) < 0 else ">f4"
        pixels = np.frombuffer(f.read(), order).reshape(height, width, 3 if kind == [b"PF"] else 1)
    return pixels[::-1].astype(np.float64)


def read_reference(path):
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    image = mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(image, dtype=np.float64)


def rel_mse(image, reference, factor=1.0, trim=0.0):
    error = factor * ((image - reference) ** 2 / (reference ** 2 + 1e-2)).mean(axis=-1).ravel()
    if trim:
        error = np.sort(error)[:len(error) - math.ceil(trim * len(error))]
    return float(error.mean())


def errors(images, reference):
    """(relMSE, trimmed relMSE) of each image."""
    out, count = [], len(images)
    total = sum(images)
    for image in images:
        if reference is not None:
            r, factor = reference, 1.0
        else:
            r, factor = (total - image) / (count - 1), (count - 1) / count
        out.append((rel_mse(image, r, factor), rel_mse(image, r, factor, 1e-3)))
    return out


def measure(a, programs):
    runs = {p.name: dict(seconds=[], images=[]) for p in programs}
    for r in range(a.rounds):
        with alone(a):
            for p in programs if r % 2 == 0 else programs[::-1]:
                seconds, image = p.render(r + 1)
                runs[p.name]["seconds"].append(seconds)
                runs[p.name]["images"].append(np.where(np.isfinite(image), image, 0.0))
    return runs


def summary(a, programs, runs, size, reference):
    for p in programs:
        run = runs[p.name]
        run["spp"] = p.spp
        run["rel_mse"], run["rel_mse_trimmed"] = map(list, zip(*errors(run["images"], reference)))
        run["figure"] = [e * s for e, s in zip(run["rel_mse"], run["seconds"])]
        run["figure_trimmed"] = [e * s for e, s in zip(run["rel_mse_trimmed"], run["seconds"])]
        median = run["median"] = {k: statistics.median(run[k])
                                  for k in ("seconds", "rel_mse", "rel_mse_trimmed", "figure", "figure_trimmed")}
        median["samples_per_second"] = size[0] * size[1] * p.spp / median["seconds"]
        run["mean"] = float(np.mean(run.pop("images")))
    return runs


def report(a, programs, runs):
    ours = [p.name for p in programs if isinstance(p, Kaustika)]
    theirs = [p.name for p in programs if isinstance(p, Peer)]
    print("| renderer, sampler | spp | seconds | Msamples/s | relMSE | relMSE x s | trimmed x s | mean |\n|---|---|---|---|---|---|---|---|")
    for name in ours + theirs:
        run, m = runs[name], runs[name]["median"]
        print("| %s | %d | %.3f | %.2f | %.4g | %.4g | %.4g | %.5f |"
              % (name, run["spp"], m["seconds"], m["samples_per_second"] / 1e6, m["rel_mse"], m["figure"], m["figure_trimmed"],
                 run["mean"]))
    if theirs:
        print("\nRatios of relMSE x seconds (trimmed), the first over the second: below 1 the first is better.\n")
        print("| | %s |\n|---|%s" % (" | ".join(theirs), "---|" * len(theirs)))
        for o in ours:
            ratio = lambda t, k: runs[o]["median"][k] / runs[t]["median"][k]
            print("| %s | %s |" % (o, " | ".join("**%.3f** (%.3f)" % (ratio(t, "figure"), ratio(t, "figure_trimmed"))
                                               for t in theirs)))


def main():
    a = arguments()
    if a.scene.endswith(".pbrt") and not a.resolution:
        raise SystemExit("a pbrt scene needs --resolution")
    if a.rounds < 2 and not a.reference:
        raise SystemExit("without a reference at least two rounds are needed")
    with tempfile.TemporaryDirectory() as folder:
        scene = (PbrtScene if a.scene.endswith(".pbrt") else MitsubaScene)(a, folder)
        programs = [Kaustika(a, scene, s) for s in a.samplers] + scene.peers()
        size = scene.size
        reference = read_reference(a.reference) if a.reference else None
        print("%s, %d x %d, depth %d, roulette from %s, box filter, %d threads, %d rounds, error against %s\n"
              % (os.path.basename(os.path.dirname(os.path.abspath(a.scene))), *size, scene.depth, scene.rr_depth or "where each begins", a.threads, a.rounds,
                 "the reference" if a.reference else "the mean of the other rounds"), flush=True)
        runs = summary(a, programs, measure(a, programs), size, reference)
    report(a, programs, runs)
    if a.json:
        with open(a.json, "w") as out:
            json.dump(dict(scene=a.scene, size=size, depth=scene.depth, rr_depth=scene.rr_depth, threads=a.threads, spp=a.spp, runs=runs),
                      out, indent=1)


if __name__ == "__main__":
    main()
