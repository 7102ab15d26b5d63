#!/usr/bin/env python3
"""Methods of other programs at equal time, to be set beside equal_time.py's table of ours (run by hand).

    scripts/equal_time_peers.py SCENE.xml --reference FILE.exr --time 20 PEER[@LAYER]... [--seeds 5] [--resolution WxH] [--keep FOLDER]

PEER: `mitsuba-ptracer` and `mitsuba-path` (Mitsuba 3, LLVM; kernels compiled and samples chosen for the time in runs before),
`luxcore-PATHCPU`, `-LIGHTCPU`, `-BIDIRCPU`, `-BIDIRVMCPU` (LuxCore; stopped by the clock). Errors, LAYER and table as equal_time.py has them; the
work named is samples a pixel. Loading is not timed. LuxCore is given what it needs from the scene's XML: rectangles and spheres (as
meshes with normals), matte and glass, area lights. Runs in a Python that has mitsuba, pyluxcore, numpy and OpenImageIO.
"""
import argparse
import math
import os
import sys
import tempfile
import time
import xml.etree.ElementTree as ET

import numpy as np

import scene_for_both
from equal_time import errors, passes_of, read, shrunk, table


def numbers(node, *keys, default=0.0):
    return [float(node.get(k, default)) for k in keys]


def triple(text):
    values = [float(v) for v in text.replace(",", " ").split()]
    return values * 3 if len(values) == 1 else values


def matrix(node):
    """The 4 x 4 matrix of Mitsuba's <transform>; its steps apply in their order."""
    m = np.eye(4)
    for step in [] if node is None else node:
        s = np.eye(4)
        if step.tag == "translate":
            s[:3, 3] = numbers(step, "x", "y", "z")
        elif step.tag == "scale":
            s[:3, :3] = np.diag(triple(step.get("value")) if step.get("value") else numbers(step, "x", "y", "z", default=1))
        elif step.tag == "rotate":
            axis, angle = np.array(numbers(step, "x", "y", "z")), math.radians(float(step.get("angle")))
            x, y, z = axis / np.linalg.norm(axis)
            k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            s[:3, :3] += math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
        elif step.tag == "lookat":
            origin, target, up = (np.array(triple(step.get(k))) for k in ("origin", "target", "up"))
            z = (target - origin) / np.linalg.norm(target - origin)
            x = np.cross(up, z) / np.linalg.norm(np.cross(up, z))
            s[:3, 0], s[:3, 1], s[:3, 2], s[:3, 3] = x, np.cross(z, x), z, origin
        else:
            raise SystemExit("unknown step <%s> of a transform" % step.tag)
        m = s @ m
    return m


def mesh(shape):
    """Points, triangles and normals (or None) of a shape."""
    m = matrix(shape.find("transform"))
    place = lambda p: np.asarray(p, float) @ m[:3, :3].T + m[:3, 3]
    square = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    if shape.get("type") == "rectangle":
        return place(square), [(0, 1, 2), (0, 2, 3)], None
    if shape.get("type") == "sphere":
        center = shape.find("point[@name='center']")
        radius = float(shape.find("float[@name='radius']").get("value"))
        rows, around = 129, 257
        t, phi = np.meshgrid(np.linspace(0, np.pi, rows), np.linspace(0, 2 * np.pi, around), indexing="ij")
        n = np.stack([np.sin(t) * np.cos(phi), np.cos(t), -np.sin(t) * np.sin(phi)], -1).reshape(-1, 3)
        a = (np.arange(rows - 1)[:, None] * around + np.arange(around - 1)).ravel()
        triangles = np.concatenate([np.stack([a, a + around, a + 1], 1), np.stack([a + 1, a + around, a + around + 1], 1)])
        return place(n * radius + numbers(center, "x", "y", "z")), triangles, n
    raise SystemExit("a %s is not understood" % shape.get("type"))


class LuxCore:
    def __init__(self, scene, size, engine):
        import pyluxcore

        self.lux, self.size, self.engine = pyluxcore, size, engine
        pyluxcore.Init()
        pyluxcore.SetLogHandler(lambda message: None)
        root = ET.parse(scene).getroot()
        self.depth = int(root.find("integrator/integer[@name='max_depth']").get("value"))
        props = pyluxcore.Properties()
        put = lambda key, value: props.Set(pyluxcore.Property("scene." + key, value))
        look = root.find("sensor/transform/lookat")
        put("camera.type", "perspective")
        put("camera.lookat.orig", triple(look.get("origin")))
        put("camera.lookat.target", triple(look.get("target")))
        put("camera.up", triple(look.get("up")))
        put("camera.fieldofview", float(root.find("sensor/float[@name='fov']").get("value")))
        # A square picture; LuxCore's film lies one pixel off vertically.
        put("camera.screenwindow", [-1.0, 1.0, -1.0 - 2.0 / size[1], 1.0 - 2.0 / size[1]])
        for bsdf in root.findall("bsdf"):
            material, kind = "materials.%s." % bsdf.get("id"), bsdf.get("type")
            if kind == "diffuse":
                put(material + "type", "matte")
                put(material + "kd", triple(bsdf.find("rgb").get("value")))
            elif kind == "dielectric":
                put(material + "type", "glass")
                put(material + "kr", [1.0] * 3)
                put(material + "kt", [1.0] * 3)
                put(material + "interiorior", float(bsdf.find("float[@name='int_ior']").get("value")))
            else:
                raise SystemExit("a %s is not understood" % kind)
        built = pyluxcore.Scene()
        for k, shape in enumerate(root.findall("shape")):
            points, triangles, normals = mesh(shape)
            listed = lambda a, kind=float: None if a is None else [tuple(map(kind, row)) for row in a]
            name, material = "shape%d" % k, shape.find("ref").get("id")
            if shape.find("emitter") is not None:
                material = "lamp%d" % k
                put("materials.%s.type" % material, "matte")
                put("materials.%s.kd" % material, [0.0] * 3)
                put("materials.%s.emission" % material, triple(shape.find("emitter/rgb").get("value")))
            built.DefineMesh(name, listed(points), listed(triangles, int), listed(normals), None, None, None)
            put("objects.%s.shape" % name, name)
            put("objects.%s.material" % name, material)
        built.Parse(props)
        self.scene = built

    def render(self, seconds, seed):
        config, (w, h), depth = self.lux.Properties(), self.size, self.depth
        for key, value in {
            "renderengine.type": self.engine, "renderengine.seed": seed, "sampler.type": "RANDOM", "film.width": w, "film.height": h,
            "sampler.random.adaptive.strength": 0.0, "film.filter.type": "BOX", "film.filter.width": 0.5,
            "path.clamping.variance.maxvalue": 0.0, "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth,
            "path.pathdepth.glossy": depth, "path.pathdepth.specular": depth, "path.maxdepth": depth, "light.maxdepth": depth,
            "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr",
        }.items():
            config.Set(self.lux.Property(key, value))
        session = self.lux.RenderSession(self.lux.RenderConfig(config, self.scene))
        session.Start()
        time.sleep(seconds)
        session.UpdateStats()
        samples = session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat() / (w * h)
        session.Stop()
        pixels = np.zeros(w * h * 3, np.float32)
        session.GetFilm().GetOutputFloat(self.lux.FilmOutputType.RGB, pixels)
        return samples, pixels.reshape(h, w, 3)[::-1].astype(np.float64)


class Mitsuba:
    def __init__(self, scene, size, integrator, folder):
        import drjit
        import mitsuba

        mitsuba.set_variant("llvm_ad_rgb")
        mitsuba.set_log_level(mitsuba.LogLevel.Error)
        path, (depth, _), _ = scene_for_both.write(scene, folder, [], "independent", 16, resolution=size)
        self.mi, self.dr, self.scene = mitsuba, drjit, mitsuba.load_file(path)
        self.integrator = mitsuba.load_dict({"type": integrator, "max_depth": depth})
        self.spp = 4

    def once(self, spp, seed):
        start = time.perf_counter()
        image = self.integrator.render(self.scene, seed=seed, spp=spp)
        self.dr.eval(image)
        self.dr.sync_thread()
        return time.perf_counter() - start, image

    def render(self, seconds, seed):
        if self.spp == 4:
            for spp in (4, 64, 64):
                self.spp, took = spp, self.once(spp, 1 << 20)[0]
            self.spp = max(1, round(self.spp * seconds / took))
            self.once(self.spp, 1 << 20)  # the kernel of this many samples
        _, image = self.once(self.spp, seed)
        return self.spp, np.array(image)[..., :3].astype(np.float64)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("scene")
    ap.add_argument("peers", nargs="+")
    ap.add_argument("--reference", required=True)
    ap.add_argument("--time", type=float, default=20)
    ap.add_argument("--seeds", type=int, default=5)
    ap.add_argument("--resolution", default="128x128")
    ap.add_argument("--keep")
    a = ap.parse_args()
    size = tuple(map(int, a.resolution.split("x")))
    runs = {}
    with tempfile.TemporaryDirectory() as folder:
        for spec in a.peers:
            peer, _, layer = spec.partition("@")
            program, _, method = peer.partition("-")
            renderer = Mitsuba(a.scene, size, method, folder) if program == "mitsuba" else LuxCore(a.scene, size, method)
            r = shrunk(read(a.reference, layer), size[1])
            for seed in range(1, a.seeds + 1):
                samples, image = renderer.render(a.time, seed)
                runs.setdefault(spec, []).append((*errors(image, r, r, r, np.inf), samples, passes_of(a.reference) / samples, a.time))
            if a.keep:
                os.makedirs(a.keep, exist_ok=True)
                np.save(os.path.join(a.keep, peer + ".npy"), image)
    table(runs, "samples a pixel")
    sys.stdout.flush()
    os._exit(0)  # LuxCore 2.11.2 often crashes while Python shuts down


if __name__ == "__main__":
    main()
