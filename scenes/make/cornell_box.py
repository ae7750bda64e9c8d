"""The Cornell box as measured by the Cornell University Program of Computer Graphics ("Cornell Box Data", 1998). It
first appeared in Goral et al. 1984. The geometry (in millimetres), the camera and the spectra are as published in
1998."""

import math

from .gltf import Gltf
from .mesh import Mesh
from .vec import cross, normalize, sub

# These tables contain reflectances at 400, 404, ... 700 nm.
WHITE = """.343 .445 .551 .624 .665 .687 .708 .723 .715 .710 .745 .758 .739 .767 .777 .765 .751 .745 .748 .729 .745
.757 .753 .750 .746 .747 .735 .732 .739 .734 .725 .721 .733 .725 .732 .743 .744 .748 .728 .716 .733 .726 .713 .740
.754 .764 .752 .736 .734 .741 .740 .732 .745 .755 .751 .744 .731 .733 .744 .731 .712 .708 .729 .730 .727 .707 .703
.729 .750 .760 .751 .739 .724 .730 .740 .737"""
GREEN = """.092 .096 .098 .097 .098 .095 .095 .097 .095 .094 .097 .098 .096 .101 .103 .104 .107 .109 .112 .115 .125
.140 .160 .187 .229 .285 .343 .390 .435 .464 .472 .476 .481 .462 .447 .441 .426 .406 .373 .347 .337 .314 .285 .277
.266 .250 .230 .207 .186 .171 .160 .148 .141 .136 .130 .126 .123 .121 .122 .119 .114 .115 .117 .117 .118 .120 .122
.128 .132 .139 .144 .146 .150 .152 .157 .159"""
RED = """.040 .046 .048 .053 .049 .050 .053 .055 .057 .056 .059 .057 .061 .061 .060 .062 .062 .062 .061 .062 .060
.059 .057 .058 .058 .058 .056 .055 .056 .059 .057 .055 .059 .059 .058 .059 .061 .061 .063 .063 .067 .068 .072 .080
.090 .099 .124 .154 .192 .255 .287 .349 .402 .443 .487 .513 .558 .584 .620 .606 .609 .651 .612 .610 .650 .638 .627
.620 .630 .628 .642 .639 .657 .639 .635 .642"""
LIGHT = ((400, 0.0), (500, 8.0), (600, 15.6), (700, 18.4))  # (wavelength in nm, relative emission)


def _cie_1931(nm):
    """Returns the colour matching functions at a wavelength. Uses the piecewise Gaussian fit of Wyman, Sloan & Shirley
    2013 (JCGT 2:2), eq. 4."""
    def lobe(mean, below, above):
        t = (nm - mean) * (below if nm < mean else above)
        return math.exp(-0.5 * t * t)
    return (0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
            - 0.065 * lobe(501.1, 0.0490, 0.0382),
            0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
            1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725))


def _linear_rgb(xyz):
    x, y, z = xyz
    return (3.2404542 * x - 1.5371385 * y - 0.4985314 * z, -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
            0.0556434 * x - 0.2040259 * y + 1.0572252 * z)


def _integrate(spectrum):
    sums = [0.0, 0.0, 0.0]
    for k in range(76):
        for i, m in enumerate(_cie_1931(400 + 4 * k)):
            sums[i] += m * spectrum(k)
    return sums


def reflectance(table):
    """Returns the colour of a reflectance spectrum in linear Rec. 709, under an equal-energy illuminant with full
    adaptation. A constant reflectance of 1 has the colour (1, 1, 1)."""
    values = [float(v) for v in table.split()]
    white = _linear_rgb(_integrate(lambda k: 1.0))
    rgb = _linear_rgb(_integrate(lambda k: values[k]))
    return tuple(max(0.0, c / w) for c, w in zip(rgb, white))


def emission(scale):
    """Returns the lamp's emission, whose green is `scale`. The published spectrum has the colour (1.90, 1, 0.25) in
    linear Rec. 709. Taking its square root removes half of this warm tint, as an adapting eye or camera would."""
    def power(k):
        nm = 400 + 4 * k
        for (a, pa), (b, pb) in zip(LIGHT, LIGHT[1:]):
            if nm <= b:
                return pa + (pb - pa) * (nm - a) / (b - a)
    rgb = _linear_rgb(_integrate(power))
    return tuple(math.sqrt(c / rgb[1]) * scale for c in rgb)


def _faces(*corners):
    """Returns a mesh of quads. The corners of each quad must be counter-clockwise as seen from its front."""
    mesh = Mesh()
    for a, b, c, d in corners:
        n = normalize(cross(sub(b, a), sub(d, a)))
        base = len(mesh.positions)
        mesh.positions += [tuple(float(v) for v in p) for p in (a, b, c, d)]
        mesh.normals += [n] * 4
        mesh.uvs += [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]
        mesh.indices += [base, base + 1, base + 2, base, base + 2, base + 3]
    return mesh


def _block(top):
    """Returns a block that reaches from its published top face down to the floor. The corners of the top face must be
    counter-clockwise as seen from above. Like the published block, it has no bottom."""
    foot = [(x, 0, z) for x, _, z in top]
    sides = [(foot[k], foot[(k + 1) % 4], top[(k + 1) % 4], top[k]) for k in range(4)]
    return _faces(tuple(top), *sides)


def build():
    g = Gltf("Cornell box")
    white = g.material("white", reflectance(WHITE), roughness=1)
    red = g.material("red", reflectance(RED), roughness=1)
    green = g.material("green", reflectance(GREEN), roughness=1)
    lamp = g.material("light", (0.78, 0.78, 0.78), roughness=1, emission=emission(24.0))

    g.add_object("floor", _faces(((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))), white)
    g.add_object("ceiling", _faces(((556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0))), white)
    g.add_object("back wall", _faces(((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))), white)
    g.add_object("right wall", _faces(((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))), green)
    g.add_object("left wall", _faces(((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))), red)
    # The published lamp lies in the plane of the ceiling. We move it down by 0.5 mm, so that lamp and ceiling do not
    # coincide.
    g.add_object("light", _faces(((343, 548.3, 227), (343, 548.3, 332), (213, 548.3, 332), (213, 548.3, 227))), lamp)
    g.add_object("short block", _block([(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]), white)
    g.add_object("tall block", _block([(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]), white)
    # The published camera has a focal length of 35 mm and a film of 25 mm x 25 mm.
    g.camera("camera", (278, 273, -800), (278, 273, 0), 2 * math.degrees(math.atan(0.0125 / 0.035)), 1.0, near=1)
    return g.glb()
