"""Rewrites a Mitsuba scene so that Mitsuba 3 and Kaustika do the same work (used by efficiency.py).

write(SCENE.xml, FOLDER, ...) puts a copy into FOLDER, beside links to what lies in the scene's folder. In the copy, which
both programs read,
- included files stand in place, variables have their values;
- the integrator is `path` with the depth and roulette depth asked for (the scene's, and 5, if none is);
- the film has a box filter, the resolution asked for (or the scene's), and no further properties;
- the sampler is the one asked for (Kaustika's is chosen on its command line);
- `roughdiffuse`, which Mitsuba 3 does not have, is `diffuse`, textures are filtered bilinearly if at all; media, which
  Kaustika does not have, are left out, and so are properties of Mitsuba 0.6 that Mitsuba 3 refuses.
"""
import os
import re
import xml.etree.ElementTree as ET

REFUSED = {"roughconductor": ["extEta", "ext_eta"]}


def flat(node, folder):
    """The node with the children of included files in place of <include>."""
    for i, child in reversed(list(enumerate(node))):
        if child.tag == "include":
            root = flat(ET.parse(os.path.join(folder, child.get("filename"))).getroot(), folder)
            node.remove(child)
            for k, c in enumerate(root):
                node.insert(i + k, c)
        else:
            flat(child, folder)
    return node


def substitute(node, values):
    for default in node.findall("default"):
        values.setdefault(default.get("name"), default.get("value"))
        node.remove(default)
    longest_first = sorted(values, key=len, reverse=True)
    for n in node.iter():
        for key, text in n.attrib.items():
            if "$" in text:
                n.set(key, re.sub(r"\$(%s)" % "|".join(longest_first), lambda m: values[m.group(1)], text))


def value(parent, *names):
    found = [c.get("value") for c in parent if c.get("name") in names]
    return found[0] if found else None


def write(scene, folder, defines, sampler, spp, depth=None, rr_depth=None, resolution=None, name="scene.xml"):
    """The path of the copy; (depth, rr_depth or None) and (width, height) that it has."""
    home = os.path.dirname(os.path.abspath(scene))
    root = flat(ET.parse(scene).getroot(), home)
    substitute(root, dict(defines))
    old = int(root.get("version").split(".")[0]) < 2
    of_depth, of_rr, of_count = (("maxDepth", "rrDepth", "sampleCount") if old else ("max_depth", "rr_depth", "sample_count"))

    integrator = root.find("integrator")
    depth = depth or int(value(integrator, of_depth) or 65)
    rr_depth = rr_depth or value(integrator, of_rr)
    set_children(integrator, "path", [("integer", of_depth, depth)] + ([("integer", of_rr, rr_depth)] if rr_depth else []))

    sensor = root.find("sensor")
    film = sensor.find("film")
    width, height = resolution or (int(value(film, "width")), int(value(film, "height")))
    pixels = [("string", "pixelFormat" if old else "pixel_format", "rgb")]
    set_children(film, "hdrfilm", [("integer", "width", width), ("integer", "height", height)] + pixels)
    ET.SubElement(film, "rfilter", type="box")
    for s in sensor.findall("sampler"):
        sensor.remove(s)
    set_children(ET.SubElement(sensor, "sampler"), sampler, [("integer", of_count, spp)])

    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag == "medium":
                parent.remove(child)
            elif child.get("name") in ("filterType", "filter_type") and child.get("value") != "nearest":
                child.set("value", "bilinear")
            elif child.get("type") == "roughdiffuse":
                child.set("type", "diffuse")
                for c in [c for c in child if c.get("name") in ("alpha", "useFastApprox")]:
                    child.remove(c)
            for refused in REFUSED.get(child.get("type"), []):
                for c in [c for c in child if c.get("name") == refused]:
                    child.remove(c)

    os.makedirs(folder, exist_ok=True)
    for entry in os.listdir(home):
        link = os.path.join(folder, entry)
        if not entry.endswith(".xml") and not os.path.lexists(link):
            os.symlink(os.path.join(home, entry), link)
    path = os.path.join(folder, name)
    ET.ElementTree(root).write(path)
    return path, (depth, rr_depth), (width, height)


def set_children(node, kind, properties):
    node.clear()
    node.set("type", kind)
    for tag, name, v in properties:
        ET.SubElement(node, tag, name=name, value=str(v))
