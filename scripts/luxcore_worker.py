"""Renders Bitterli's pbrt-v4 scene `dining-room` again and again with LuxCore for efficiency.py.

    luxcore_worker.py scene-v4.pbrt WIDTHxHEIGHT DEPTH RR_DEPTH THREADS SPP [LIGHT]

Speaks as mitsuba_worker.py does; every answer names the samples a pixel too, since LuxCore looks at its count now and then and
renders some more. Seconds are the engine's own clock. Only what that one file uses is understood: PLY and inline
meshes, matte, coated and metallic materials, image textures, a distant and an image light (LIGHT: `distant` or `infinite`
renders with one of them only). What differs from pbrt's models: `coateddiffuse` is LuxCore's `glossy2`, a Schlick coat over matte,
with a reflectance of 0.04. Light that a real coat sends back to the base again and again is absorbed there, which `glossy2` does not know
(and with kd = 1 it reflects 1.04 of what it gets): kd is chosen so that both have the same albedo, see `base_of`. Metals
have Schlick's Fresnel reflectance from their index at normal incidence, and albedos within 1.3 % of ours; Russian roulette
survives with at least 0.5. Depth counts as pbrt's; LuxCore's path.pathdepth.total is one more.

Runs in a Python that has pyluxcore, numpy and Pillow.
"""
import json
import os
import re
import sys
import tempfile
import time

import numpy as np
import pyluxcore
from PIL import Image

SCENE, SIZE, DEPTH, RR_DEPTH, THREADS, SPP = sys.argv[1:7]
LIGHTS = sys.argv[7:8] or ["distant", "infinite"]
HOME = os.path.dirname(os.path.abspath(SCENE))
WIDTH, HEIGHT = map(int, SIZE.split("x"))


def numbers(block, name):
    found = re.search(r'"\w+ %s"\s*\[([^\]]*)\]' % re.escape(name), block)
    return [float(v) for v in found[1].split()] if found else []


def word(block, name):
    found = re.search(r'"(?:string|texture) %s"\s*\[?\s*"([^"]*)"' % re.escape(name), block)
    return found[1] if found else None


def ply(path):
    """Positions, uv or None, and triangles of a binary little-endian PLY of floats."""
    with open(path, "rb") as f:
        names, counts = [], []
        for line in iter(lambda: f.readline().split(), [b"end_header"]):
            if line[0] == b"element":
                counts.append(int(line[2]))
            elif line[0] == b"property" and line[1] == b"float":
                names.append(line[2].decode())
        vertices = np.frombuffer(f.read(4 * len(names) * counts[0]), "<f4").reshape(counts[0], len(names))
        faces = np.frombuffer(f.read(13 * counts[1]), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    assert (faces["n"] == 3).all(), path
    column = lambda *keys: vertices[:, [names.index(k) for k in keys]] if keys[0] in names else None
    return column("x", "y", "z"), column("u", "v"), column("nx", "ny", "nz"), faces["i"]


def on_square(d):
    """Equal-area octahedral map (Clarberg 2008) of unit directions, z up: positions in [0, 1]^2."""
    x, y, z = np.abs(d).T
    r = np.sqrt(np.maximum(0, 1 - z))
    phi = np.arctan2(np.minimum(x, y), np.maximum(x, y)) * 2 / np.pi
    phi = np.where(x < y, 1 - phi, phi)
    v = phi * r
    u = r - v
    below = d[:, 2] < 0
    u, v = np.where(below, 1 - v, u), np.where(below, 1 - u, v)
    return 0.5 * (np.stack([np.copysign(u, d[:, 0]), np.copysign(v, d[:, 1])], -1) + 1)


def sky(path, to_light, out):
    """Writes the sky as the latitude-longitude image of an infinite light in LuxCore: z up in world space, u = phi / 2 pi, v = theta / pi."""
    with open(path, "rb") as f:
        f.readline()
        width, height = map(int, f.readline().split())
        assert float(f.readline()) < 0
        image = np.frombuffer(f.read(), "<f4").reshape(height, width, 3)[::-1]
    n = 1024
    theta = (np.arange(n) + 0.5) / n * np.pi
    phi = 2 * np.pi * (np.arange(2 * n) + 0.5) / (2 * n)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    world = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1).reshape(-1, 3)
    square = on_square(world @ to_light.T)
    x = np.minimum((square[:, 0] * width).astype(int), width - 1)
    y = np.minimum((square[:, 1] * height).astype(int), height - 1)
    latlong = image[y, x].reshape(n, 2 * n, 3)
    write_pfm(latlong, out)


# Albedos under a uniform sky, over a sphere's picture (so that directions have the weight of their cosine), by the coat's
# roughness. Of `coateddiffuse` over a base of reflectance r, rendered by us at eight r and matched within 0.004 by
#     A0 + P r (1 + K r + (K r)^2 + (K r)^3 + (K r)^4),
# five reflections by the base being pbrt's maxdepth of 10: (A0, P, K). Of LuxCore's `glossy2` over kd: a + b kd, (a, b).
COATED = {0.01: (0.0912, 0.3587, 0.5655), 0.1: (0.0780, 0.3624, 0.5317), 0.2: (0.0646, 0.3622, 0.4724)}
GLOSSY2 = {0.01: (0.0871, 0.9549), 0.1: (0.0761, 0.9485), 0.2: (0.0617, 0.9384)}


def base_of(reflectance, roughness):
    """kd with which `glossy2` has the albedo of a `coateddiffuse` of this reflectance."""
    (a0, p, k), (a, b), r = COATED[roughness], GLOSSY2[roughness], np.asarray(reflectance)
    return np.maximum(0, a0 - a + p * r * sum((k * r) ** i for i in range(5))) / b


def texture(path, change, out):
    """Writes an 8-bit sRGB image, made linear and changed, for LuxCore's imagemap, whose own decoding is a bare power."""
    c = np.asarray(Image.open(path).convert("RGB")) / 255
    write_pfm(change(np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)), out)


def write_pfm(image, out):
    with open(out, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (image.shape[1], image.shape[0]))
        image[::-1].astype("<f4").tofile(f)


def matrix(text):
    """pbrt's column-major matrix as rows."""
    return np.array([float(v) for v in text.split()]).reshape(4, 4).T


def build(folder):
    with open(SCENE) as f:
        text = re.sub(r"#.*", "", f.read())
    scene, props = pyluxcore.Scene(), pyluxcore.Properties()
    put = lambda key, value: props.Set(pyluxcore.Property("scene." + key, value))

    head, world = text.split("WorldBegin")
    to_camera = matrix(re.search(r"Transform \[([^\]]*)\]", head)[1])
    axes, eye = to_camera[:3, :3], -to_camera[:3, :3].T @ to_camera[:3, 3]
    put("camera.type", "perspective")
    put("camera.lookat.orig", list(map(float, eye)))
    put("camera.lookat.target", list(map(float, eye + axes[2])))
    put("camera.up", list(map(float, axes[1])))
    # pbrt's field of view spans the shorter side; LuxCore's too. See peer notes: its film lies one pixel off vertically.
    put("camera.fieldofview", numbers(head, "fov")[0])
    aspect = WIDTH / HEIGHT
    put("camera.screenwindow", [-aspect, aspect, -1.0 - 2.0 / HEIGHT, 1.0 - 2.0 / HEIGHT])

    pictures = re.findall(r'Texture "(\w+)" "spectrum" "imagemap"(.*?)(?=Texture|MakeNamed)', world, re.S)
    pictures = {name: os.path.join(HOME, word(body, "filename")) for name, body in pictures}
    for name, body in re.findall(r'MakeNamedMaterial "(\w+)"(.*?)(?=MakeNamed|NamedMaterial)', world, re.S):
        kind, colour = word(body, "type"), word(body, "reflectance") or tuple(numbers(body, "reflectance"))
        material = "materials.%s." % name
        if kind == "conductor":
            eta, k = np.array(numbers(body, "eta")), np.array(numbers(body, "k"))
            put("textures.%sF.type" % name, "fresnelcolor")
            put("textures.%sF.kr" % name, list(map(float, ((eta - 1) ** 2 + k ** 2) / ((eta + 1) ** 2 + k ** 2))))
            put(material + "type", "metal2")
            put(material + "fresnel", name + "F")
        else:
            change = lambda r: r
            if kind == "coateddiffuse":
                put(material + "type", "glossy2")
                put(material + "ks", [0.04, 0.04, 0.04])
                change = lambda r: base_of(r, numbers(body, "uroughness")[0])
            else:
                put(material + "type", "matte")
            if colour in pictures:
                image = os.path.join(folder, name + ".pfm")
                texture(pictures[colour], change, image)
                put("textures.%sKd.type" % name, "imagemap")
                put("textures.%sKd.file" % name, image)
                put("textures.%sKd.gamma" % name, 1.0)
                put("textures.%sKd.mapping.uvscale" % name, [1.0, -1.0])
                put("textures.%sKd.mapping.uvdelta" % name, [0.0, 1.0])
                put(material + "kd", name + "Kd")
            else:
                put(material + "kd", list(map(float, change(colour))))
        if kind != "diffuse":
            put(material + "uroughness", numbers(body, "uroughness")[0])
            put(material + "vroughness", numbers(body, "vroughness")[0])

    shapes = world[world.rindex("MakeNamedMaterial"):]
    place, material, count = np.eye(4), None, 0
    directives = r'NamedMaterial "\w+"|TransformEnd|Transform \[[^\]]*\]|Shape "\w+".*?(?=NamedMaterial|Shape|Transform|LightSource)'
    for d in re.findall(r"(?<!Make)(?:%s)" % directives, shapes, re.S):
        if d.startswith("NamedMaterial"):
            material = re.search(r'"(\w+)"', d)[1]
        elif d.startswith("Transform"):
            place = matrix(re.search(r"\[([^\]]*)\]", d)[1]) if "[" in d else np.eye(4)
        else:
            if word(d, "filename"):
                p, uv, n, triangles = ply(os.path.join(HOME, word(d, "filename")))
            else:
                p, uv = (np.array(numbers(d, k)).reshape(-1, size) for k, size in (("P", 3), ("uv", 2)))
                n, triangles = None, np.array(numbers(d, "indices")).astype(int).reshape(-1, 3)
            p = p @ place[:3, :3].T + place[:3, 3]
            if n is not None:
                n = n @ np.linalg.inv(place[:3, :3])
            listed = lambda a, kind=float: None if a is None else [tuple(map(kind, row)) for row in a]
            mesh = "mesh%d" % count
            count += 1
            scene.DefineMesh(mesh, listed(p), listed(triangles, int), listed(n), listed(uv), None, None)
            put("objects.%s.shape" % mesh, mesh)
            put("objects.%s.material" % mesh, material)

    lights = world[world.index('LightSource "distant"'):]
    if "distant" in LIGHTS:
        put("lights.sun.type", "sharpdistant")
        put("lights.sun.color", numbers(lights, "L"))
        put("lights.sun.direction", [-v for v in numbers(lights, "from")])
    if "infinite" in LIGHTS:
        turn = np.radians(float(re.search(r"Rotate (\S+) 0 0 1", lights)[1]))
        rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        to_world = rotation @ matrix(re.search(r"ConcatTransform \[([^\]]*)\]", lights)[1])[:3, :3]
        image = os.path.join(folder, "sky.pfm")
        sky(os.path.join(HOME, word(lights, "filename")), np.linalg.inv(to_world), image)
        put("lights.sky.type", "infinite")
        put("lights.sky.file", image)
        put("lights.sky.gamma", 1.0)
    scene.Parse(props)
    return scene


def render(scene, seed):
    config, depth = pyluxcore.Properties(), int(DEPTH) + 1
    for key, value in {
        "renderengine.type": "PATHCPU", "renderengine.seed": seed, "native.threads.count": int(THREADS),
        "sampler.type": "SOBOL", "sampler.sobol.adaptive.strength": 0.0, "film.width": WIDTH, "film.height": HEIGHT,
        "film.filter.type": "BOX", "film.filter.width": 0.5, "path.clamping.variance.maxvalue": 0.0,
        "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth, "path.pathdepth.glossy": depth,
        "path.pathdepth.specular": depth, "path.russianroulette.depth": int(RR_DEPTH),
        "path.russianroulette.cap": 0.5, "batch.haltspp": int(SPP),
        "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr",
    }.items():
        config.Set(pyluxcore.Property(key, value))
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(config, scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.02)
        session.UpdateStats()
    session.UpdateStats()
    stats = session.GetStats()
    session.Stop()
    pixels = np.zeros(WIDTH * HEIGHT * 3, np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels)
    get = lambda key: stats.Get("stats.renderengine." + key).GetFloat()
    return get("time"), get("total.samplecount") / (WIDTH * HEIGHT), pixels.reshape(HEIGHT, WIDTH, 3)[::-1]


def main():
    say = lambda **answer: print(json.dumps(answer), flush=True)
    pyluxcore.Init()
    pyluxcore.SetLogHandler(lambda message: None)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        scene = build(folder)
        say(load=time.perf_counter() - start, version=pyluxcore.Version(), spp=int(SPP))
        for line in sys.stdin:
            seed, out = line.split(maxsplit=1)
            seconds, spp, image = render(scene, int(seed))
            np.save(out.strip(), image)
            say(seconds=seconds, spp=spp)
    sys.stdout.flush()
    os._exit(0)  # LuxCore 2.11.2 often crashes while Python shuts down


main()
