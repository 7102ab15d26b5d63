#!/usr/bin/env python3
"""Rewrites Bitterli's pbrt-v4 `veach-mis` scene as Mitsuba XML with another microfacet
distribution, for the experiment that docs/references.md describes.

    veach_mis_to_mitsuba.py scene-v4.pbrt OUTDIR [beckmann|ggx [REFLECTANCE]]

Only what that one file uses is understood: inline triangle meshes, spheres placed by one
translation, conductors by eta and k, one perspective camera.
"""
import os
import re
import sys

source, out = sys.argv[1:3]
distribution = sys.argv[3] if len(sys.argv) > 3 else "beckmann"
reflectance = sys.argv[4] if len(sys.argv) > 4 else "1"
os.makedirs(out, exist_ok=True)
text = open(source).read()


def numbers(block, name):
    found = re.search(r'"[a-z0-9]+ %s" \[([^\]]*)\]' % re.escape(name), block)
    return found.group(1).split() if found else []


xml = ['<scene version="3.0.0">', '<integrator type="path"><integer name="max_depth" value="2"/></integrator>']
matrix = re.search(r"^Transform \[([^\]]*)\]", text, re.M).group(1).split()
rows = [[float(matrix[4 * c + r]) for c in range(4)] for r in range(4)]
# pbrt gives world to camera; its inverse for a rigid motion, with x mirrored as Mitsuba has it.
rot = [[rows[c][r] for c in range(3)] for r in range(3)]
pos = [-sum(rot[r][k] * rows[k][3] for k in range(3)) for r in range(3)]
flat = [v for r in range(3) for v in (-rot[r][0], rot[r][1], rot[r][2], pos[r])] + [0, 0, 0, 1]
fov = re.search(r'"float fov" \[ ([0-9.]+) \]', text).group(1)
xml.append('<sensor type="perspective"><float name="fov" value="%s"/><string name="fov_axis" value="smaller"/>' % fov)
xml.append('<transform name="to_world"><matrix value="%s"/></transform>' % " ".join("%.9g" % v for v in flat))
xml.append('<film type="hdrfilm"><integer name="width" value="1280"/><integer name="height" value="720"/>'
           '<rfilter type="tent"/></film></sensor>')
for name, body in re.findall(r'MakeNamedMaterial "(\w+)"(.*?)(?=MakeNamed|NamedMaterial)', text, re.S):
    xml.append('<bsdf type="twosided" id="%s">' % name)
    if '"conductor"' in body:
        xml.append('<bsdf type="roughconductor"><string name="distribution" value="%s"/>' % distribution)
        xml.append('<float name="alpha" value="%s"/>' % numbers(body, "uroughness")[0])
        xml.append('<rgb name="specular_reflectance" value="%s"/>' % reflectance)
        for key in ("eta", "k"):
            xml.append('<rgb name="%s" value="%s"/>' % (key, " ".join(numbers(body, key))))
    else:
        xml.append('<bsdf type="diffuse"><rgb name="reflectance" value="%s"/>' % " ".join(numbers(body, "reflectance")))
    xml.append("</bsdf></bsdf>")
material, light, count, place = "Diffuse", None, 0, "0 0 0"
pieces = re.split(r"^(?=\s*(?:NamedMaterial|AreaLightSource|AttributeEnd|Transform|Shape))", text.split("WorldBegin")[1], flags=re.M)
for piece in pieces:
    head = piece.strip()
    if head.startswith("NamedMaterial"):
        material = re.search(r'"(\w+)"', head).group(1)
    elif head.startswith("AreaLightSource"):
        light = " ".join(numbers(head, "L"))
    elif head.startswith("Transform"):
        place = " ".join(re.search(r"\[([^\]]*)\]", head).group(1).split()[12:15])
    elif head.startswith("AttributeEnd"):
        light = None if "Shape" not in head else light
    elif head.startswith("Shape"):
        emitter = '<emitter type="area"><rgb name="radiance" value="%s"/></emitter>' % light if light else ""
        if '"sphere"' in head:
            x, y, z = place.split()
            xml.append('<shape type="sphere"><point name="center" x="%s" y="%s" z="%s"/><float name="radius" value="%s"/>'
                       % (x, y, z, numbers(head, "radius")[0]))
        else:
            p, n, index = numbers(head, "P"), numbers(head, "N"), numbers(head, "indices")
            mesh = "mesh%d.ply" % count
            count += 1
            with open(os.path.join(out, mesh), "w") as f:
                f.write("ply\nformat ascii 1.0\nelement vertex %d\n" % (len(p) // 3))
                f.write("".join("property float %s\n" % c for c in ("x", "y", "z", "nx", "ny", "nz")))
                f.write("element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(index) // 3))
                for i in range(0, len(p), 3):
                    f.write(" ".join(p[i:i + 3] + n[i:i + 3]) + "\n")
                for i in range(0, len(index), 3):
                    f.write("3 " + " ".join(index[i:i + 3]) + "\n")
            xml.append('<shape type="ply"><string name="filename" value="%s"/>' % mesh)
        xml.append('<ref id="%s"/>%s</shape>' % (material, emitter))
xml.append("</scene>")
open(os.path.join(out, "scene.xml"), "w").write("\n".join(xml))
