"""Figure 2 of Veach & Guibas 1995, "Optimally combining sampling techniques": four plates of different roughness
reflect four lamps of equal power and different sizes. The positions are from S. Marschner's model of the scene."""

import math

from .gltf import Gltf, srgb
from .mesh import rounded_box, sphere, sweep_wall
from .vec import cross, facing, normalize

# Each plate has an upper and a lower edge at (y, z), and a GGX alpha. glTF's roughness is the square root of alpha.
PLATES = [((-2.08375, -0.526323), (-2.70651, 0.25609), 0.005), ((-2.83856, 0.476536), (-3.28825, 1.36972), 0.02),
          ((-3.43378, 1.74564), (-3.73096, 2.70046), 0.05), ((-3.82069, 3.08221), (-3.99615, 4.0667), 0.1)]
# Each lamp has an x, a radius and a tint. A radiance of 1 / (0.81 radius^2) gives all lamps the same power.
LAMPS = [(-3.75, 0.033333, "#ffd9a8"), (-1.25, 0.1, "#ffb066"), (1.25, 0.3, "#9fd0ff"), (3.75, 0.9, "#7fa2ff")]


def build():
    g = Gltf("MIS plates")
    paper = g.material("paper", (0.32, 0.32, 0.33), roughness=0.95)
    g.add_object("paper", sweep_wall(40, 22, 16, 2.5), paper, translation=(0, -4.14615, 8.0))
    plate = rounded_box(8, 1.0, 0.06, 0.02)
    for k, ((y0, z0), (y1, z1), alpha) in enumerate(PLATES):
        material = g.material(f"plate, alpha {alpha}", (0.56, 0.60, 0.66), metallic=1, roughness=math.sqrt(alpha))
        up = normalize((0, y0 - y1, z0 - z1))
        normal = cross((1, 0, 0), up)
        centre = (0, (y0 + y1) / 2 - 0.03 * normal[1], (z0 + z1) / 2 - 0.03 * normal[2])
        g.add_object(f"plate {k + 1}", plate, material, translation=centre, rotation=facing(normal, up))
    ball = sphere(1.0, 48, 24)
    for k, (x, radius, colour) in enumerate(LAMPS):
        tint = srgb(colour)
        luminance = 0.2126 * tint[0] + 0.7152 * tint[1] + 0.0722 * tint[2]
        radiance = tuple(c / luminance / (0.81 * radius * radius) for c in tint)
        lamp = g.material(f"lamp {k + 1}", (0, 0, 0), roughness=1, emission=radiance)
        g.add_object(f"lamp {k + 1}", ball, lamp, translation=(x, 0, 0), scale=radius)
    sun = g.material("overhead lamp", (0, 0, 0), roughness=1, emission=(330, 315, 300))
    g.add_object("overhead lamp", ball, sun, translation=(10, 10, 4), scale=0.5)
    g.camera("camera", (0, 2, 15), (0, -1.98, 2.0), 26.5)
    return g.glb()
