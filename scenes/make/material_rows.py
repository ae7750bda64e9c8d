"""Shows each material extension in a row of balls. Its strength increases from 0 (left) to 1 (right).

From the top, the rows show clear coat on red lacquer, sheen on blue cloth, anisotropy of steel, a film of 450 nm on
dark glaze, coloured specular reflection, diffuse transmission of a leaf-green lamp shade, and dispersion of a dense
glass."""

from . import textures
from .gltf import Gltf, srgb
from .mesh import rounded_box, sphere

COLUMNS = 11
RADIUS = 0.115
SPACING = 0.305
STEP = 0.25  # how much higher and farther back each row is than the row in front of it


def _rows(strength):
    """Returns (name, keyword arguments of Gltf.material) for each row, from back to front."""
    s = strength
    return [
        ("clear coat", dict(colour=srgb("#8c1008"), roughness=0.55, layers={
            "clearcoat": {"clearcoatFactor": s, "clearcoatRoughnessFactor": 0.04}})),
        ("sheen", dict(colour=srgb("#14213d"), roughness=0.9, layers={
            "sheen": {"sheenColorFactor": (0.9 * s, 0.85 * s, s), "sheenRoughnessFactor": 0.35}})),
        ("anisotropy", dict(colour=(0.62, 0.6, 0.57), metallic=1, roughness=0.3, layers={
            "anisotropy": {"anisotropyStrength": s}})),
        ("iridescence", dict(colour=srgb("#181818"), roughness=0.12, layers={
            "iridescence": {"iridescenceFactor": s, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 450}})),
        ("specular", dict(colour=srgb("#0d1f2d"), roughness=0.2, layers={
            "specular": {"specularFactor": s, "specularColorFactor": (12, 6, 1.5)}})),
        ("diffuse transmission", dict(colour=srgb("#3d7a2c"), roughness=0.6, two_sided=True, layers={
            "diffuse_transmission": {"diffuseTransmissionFactor": s,
                                     "diffuseTransmissionColorFactor": srgb("#d6e84a")}})),
        ("dispersion", dict(colour=(1, 1, 1), roughness=0, transmission=1, ior=1.8, attenuation=((1, 1, 1), 1),
                            layers={"dispersion": {"dispersion": s}})),
    ]


def build():
    g = Gltf("Material rows")
    stone = g.material("dark marble", roughness=0.25, texture=g.texture(
        textures.marble(textures.DARK_MARBLE, seed=19), "dark marble"))
    ball = sphere(RADIUS, 72, 36)
    rows = len(_rows(0))
    for k in range(COLUMNS):
        strength = k / (COLUMNS - 1)
        x = SPACING * (k - (COLUMNS - 1) / 2)
        for row, (name, keywords) in enumerate(_rows(strength)):
            material = g.material(f"{name} {strength:.2f}", **keywords)
            up = rows - 1 - row
            g.add_object(f"{name} {strength:.2f}", ball, material, translation=(x, STEP * up + RADIUS, -0.3 * up))
    for up in range(rows):
        depth = 0.3 if up else 3
        g.add_object(f"step {up}", rounded_box(4, STEP, depth, 0.01, uv_per_unit=0.45), stone,
              translation=(0, STEP * up - STEP / 2, -0.3 * up + depth / 2 - 0.15))
    g.camera("camera", (0, 2.9, 6.0), (0, 0.78, -0.9), 21.5)
    return g.glb()
